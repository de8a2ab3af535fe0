//! Layers of a part and of its support, filled in their own ways and put together.

use crate::common::grid;
use curvlay_toolpath::fill::{FilledLayer, FilledLayers, fill_layers, fill_range, fill_rest};
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::path::{BeadKind, InfillOptions, PathOptions};
use std::ops::{ControlFlow, Range};

/// Of all triangles.
static THICKNESS: [f64; 4096] = [0.8; 4096];

type Sheet = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// A rectangle, or nothing.
fn sheet([x, wide]: [f64; 2], z: f64) -> Sheet {
    if wide == 0.0 {
        return (Vec::new(), Vec::new());
    }
    let corners = [[x, 0.0], [x + wide, 0.0], [x + wide, 14.0], [x, 14.0]];
    (corners.map(|[x, y]| Point3::new(x, y, z)).to_vec(), vec![[0, 1, 2], [0, 2, 3]])
}

struct Layers {
    part: Vec<Sheet>,
    support: Vec<Sheet>,
    both: Vec<Sheet>,
}

/// Support that is wide below and ends, and a part of plates with a stub that begins above the plate.
fn layers() -> Layers {
    let z = |k: usize| 0.4 + 0.8 * k as f64;
    let plate = |(k, stub): (usize, Option<usize>)| {
        let Some(stub) = stub else { return (Vec::new(), Vec::new()) };
        let there = move |i: usize, j: usize| i < 12 && j < 12 || j == 6 && i < 12 + stub;
        let mesh = grid(24, 3, 0.0, move |i, j| !there(i, j), |p| Point3::new(p.x, p.y, z(k)));
        (mesh.vertices().to_vec(), mesh.triangles().to_vec())
    };
    let stubs = [None, None, Some(3), Some(3), Some(3), Some(3), Some(9)];
    let part: Vec<Sheet> = stubs.into_iter().enumerate().map(plate).collect();
    let wide = [14.0, 14.0, 14.0, 2.0, 14.0, 0.0, 0.0];
    let support: Vec<Sheet> = wide.iter().enumerate().map(|(k, &wide)| sheet([40.0, wide], z(k))).collect();
    let join = |(part, support): (&Sheet, &Sheet)| {
        let first = part.0.len() as u32;
        let moved = support.1.iter().map(|corners| corners.map(|corner| corner + first));
        ([&part.0[..], &support.0].concat(), part.1.iter().copied().chain(moved).collect())
    };
    let both = part.iter().zip(&support).map(join).collect();
    Layers { part, support, both }
}

fn surfaces(sheets: &[Sheet]) -> Vec<LayerSurface<'_>> {
    sheets
        .iter()
        .map(|(vertices, triangles)| LayerSurface {
            vertices,
            triangles,
            thickness: &THICKNESS[..triangles.len()],
            is_half: false,
        })
        .collect()
}

fn filled(layers: &Layers, range: Range<usize>, options: &PathOptions, density: f64) -> Vec<Option<FilledLayer>> {
    let go = |_| ControlFlow::Continue(());
    let (part, support) = (surfaces(&layers.part), surfaces(&layers.support));
    let of_part = fill_range(&part, range.clone(), options, &go).unwrap();
    let of_support = fill_range(&support, range.clone(), &options.for_support(density), &go).unwrap();
    let both = of_part.into_iter().zip(of_support).zip(&part[range]);
    both.map(|((part, support), surface)| FilledLayer::with_support(part, support, surface)).collect()
}

fn together(layers: &Layers, cuts: &[usize], options: &PathOptions, density: f64) -> FilledLayers {
    let pieces = cuts.windows(2).flat_map(|ends| filled(layers, ends[0]..ends[1], options, density));
    fill_rest(&surfaces(&layers.both), pieces.collect(), options, &|_| ControlFlow::Continue(())).unwrap()
}

/// Lengths and covered volumes add up, beads are what they are, and pieces make what one run makes. What lies on the stubs brings
/// short curves back, so that layers with support are judged again.
#[test]
fn a_part_and_its_support_add_up() {
    let (layers, go) = (layers(), |_| ControlFlow::Continue(()));
    for infill in
        [InfillOptions::default(), InfillOptions { density: 0.3, walls: 1, skin: 1, ..InfillOptions::default() }]
    {
        let options = PathOptions { infill, join_distance: 0.0, ..PathOptions::default() };
        let whole = together(&layers, &[0, 7], &options, 0.25);
        for cuts in [&[0, 3, 7][..], &[0, 1, 2, 3, 4, 5, 6, 7]] {
            assert_eq!(together(&layers, cuts, &options, 0.25), whole);
        }
        let short = |layers: &[Option<FilledLayer>]| {
            layers.iter().flatten().map(|layer| layer.paths.short.len()).sum::<usize>()
        };
        assert!(short(&filled(&layers, 2..5, &options, 0.25)) > short(&whole.layers[2..5]));
        let part = fill_layers(&surfaces(&layers.part), &options, &go).unwrap();
        let support = fill_layers(&surfaces(&layers.support), &options.for_support(0.25), &go).unwrap();
        let (totals, of_part, of_support) = (whole.totals(), part.totals(), support.totals());
        assert!((totals.path_mm - of_part.path_mm - of_support.path_mm).abs() < 1e-6);
        assert!((totals.support_mm - of_support.path_mm).abs() < 1e-6);
        assert_eq!(totals.curves, of_part.curves + of_support.curves);
        let counts =
            |of: &Option<FilledLayer>| of.as_ref().map_or([0; 2], |layer| [layer.paths.regions, layer.paths.joints]);
        for (both, (part, support)) in whole.layers.iter().zip(part.layers.iter().zip(&support.layers)) {
            assert_eq!(counts(both), [0, 1].map(|k| counts(part)[k] + counts(support)[k]));
        }
        let covered = [&layers.both, &layers.part, &layers.support].map(|sheets| surfaces(sheets));
        let [both, alone, beside] =
            [whole.covered_mm3(&covered[0]), part.covered_mm3(&covered[1]), support.covered_mm3(&covered[2])];
        assert!((both - alone - beside).abs() < 1e-6, "{both} {alone} {beside}");
        // A quarter of the inside of two layers.
        let sparse_mm3 = of_support.sparse.volume_mm3;
        assert!(sparse_mm3 > 100.0 && (of_support.sparse.density() - 0.25).abs() < 0.06, "{:?}", of_support.sparse);
        for (layer, sheet) in whole.layers.iter().zip(&layers.part) {
            for path in layer.iter().flat_map(|layer| &layer.paths.paths) {
                let is_beside = path.points[0].at.position.x > 30.0;
                assert!(path.points.iter().all(|point| point.kind.is_support() == is_beside));
                assert!(path.points.iter().all(|point| (point.at.triangle as usize >= sheet.1.len()) == is_beside));
            }
        }
        let kinds = whole.layers.iter().flatten().flat_map(|layer| &layer.paths.paths).map(|path| path.points[0].kind);
        assert!(kinds.clone().any(|kind| kind == BeadKind::SparseSupport));
        assert_eq!(kinds.clone().any(|kind| kind == BeadKind::Infill), !infill.is_solid());
    }
}

#[test]
fn a_layer_without_support_stays_as_it_is() {
    let (layers, options) = (layers(), PathOptions::default());
    let part = surfaces(&layers.part);
    let alone = fill_range(&part, 5..6, &options, &|_| ControlFlow::Continue(())).unwrap().remove(0);
    assert_eq!(FilledLayer::with_support(alone.clone(), None, &part[5]), alone);
    assert_eq!(FilledLayer::with_support(None, None, &part[0]), None);
    let below = filled(&layers, 0..1, &options, 0.25).remove(0).unwrap();
    assert!(below.paths.paths.iter().flat_map(|path| &path.points).all(|point| point.kind.is_support()));
}

/// A layer of support alone is judged again without the part where a later bead brings a narrow strip of it back.
#[test]
fn a_layer_of_support_alone_is_judged_again() {
    let z = |k: usize| 0.4 + 0.8 * k as f64;
    // A strip of support that is narrower than three quarters of a bead, and a wall of the part on it.
    let support = vec![sheet([0.0, 0.55], z(0)), sheet([0.0, 0.0], z(1))];
    let part = vec![sheet([0.0, 0.0], z(0)), sheet([-0.3, 1.2], z(1))];
    let both = vec![support[0].clone(), part[1].clone()];
    let layers = Layers { part, support, both };
    let options = PathOptions::default();
    let before = filled(&layers, 0..2, &options, 0.25);
    let laid = |layer: &Option<FilledLayer>| layer.as_ref().map_or(0, |layer| layer.paths.paths.len());
    let whole = together(&layers, &[0, 2], &options, 0.25);
    assert_eq!([laid(&before[0]), laid(&whole.layers[0])], [0, 1]);
    assert_eq!(whole.layers[0].as_ref().unwrap().paths.paths[0].points[0].kind, BeadKind::Support);
}

/// The closing layer of support over its sparse inside is a bridge, its rim is not, nor what lies on a closed layer. A half layer between the two, which is not there,
/// changes nothing.
#[test]
fn support_over_its_sparse_inside_is_a_bridge() {
    let z = |k: usize| 0.4 + 0.8 * k as f64;
    let whole: Vec<Sheet> = (0..5).map(|k| sheet([0.0, 24.0], z(k))).collect();
    let mut with_half = whole.clone();
    with_half.insert(4, (Vec::new(), Vec::new()));
    let (options, go) = (PathOptions::default(), |_| ControlFlow::Continue(()));
    let share_of_bridges = |layer: &FilledLayer| {
        let pairs = layer.paths.paths.iter().flat_map(|path| path.points.windows(2));
        let lengths = pairs.map(|pair| {
            let is_bridge = pair.iter().all(|point| point.kind == BeadKind::SupportBridge);
            let length = (pair[1].at.position - pair[0].at.position).norm();
            [length, if is_bridge { length } else { 0.0 }]
        });
        let [all, bridges] = lengths.fold([0.0; 2], |sum, length| [sum[0] + length[0], sum[1] + length[1]]);
        bridges / all
    };
    for sheets in [&whole, &with_half] {
        let surfaces: Vec<LayerSurface> =
            surfaces(sheets).into_iter().map(|s| LayerSurface { is_half: s.triangles.is_empty(), ..s }).collect();
        let none = LayerSurface { vertices: &[], triangles: &[], thickness: &[], is_half: false };
        let support = fill_range(&surfaces, 0..sheets.len(), &options.for_support(0.25), &go).unwrap();
        let layers = support.into_iter().map(|layer| FilledLayer::with_support(None, layer, &none)).collect();
        let filled = fill_rest(&surfaces, layers, &options, &go).unwrap();
        let shares: Vec<f64> = filled.layers.iter().flatten().map(share_of_bridges).collect();
        assert_eq!(shares[..4], [0.0; 4]);
        assert!(shares[4] > 0.5 && shares[4] < 0.95, "{shares:?}");
    }
}
