//! Strips narrower than three quarters of a bead: which get one, how wide, and what it keeps off. Against slow twins.

use crate::common::{boundary_edges, go_on, grid, plate_with_holes, rng, to_boundary, to_edges, to_segment};
use crate::paths::crossings;
use curvlay_toolpath::deposit::{DepositionOptions, deposit};
use curvlay_toolpath::fill::{FilledLayers, fill_layer, fill_layers};
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::level_set::LevelField;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::orientation::OrientOptions;
use curvlay_toolpath::path::{BeadKind, LayerPaths, PathError, PathOptions, PathPoint, Pattern, SurfacePath};
use curvlay_toolpath::support::{SupportOptions, check_support};
use proptest::prelude::*;
use rand::RngExt;
use std::collections::BTreeSet;

/// Height of the layers.
const HEIGHT: f64 = 0.8;
/// A square millimetre is narrower than three quarters of this bead, and wider than half of it.
const BEAD: f64 = 1.6;

/// A rectangle: from and to, x and y.
type Rectangle = [[f64; 2]; 2];

/// Level rectangles, one to a layer.
fn fill(rectangles: &[Rectangle], options: &PathOptions) -> FilledLayers {
    let vertices = corners(rectangles);
    fill_layers(&surfaces(&vertices), options, &go_on).unwrap()
}

fn corners(rectangles: &[Rectangle]) -> Vec<[Point3<f64>; 4]> {
    let level = |(k, &[[left, right], [front, back]]): (usize, &Rectangle)| {
        let z = HEIGHT * (k as f64 + 0.5);
        [[left, front], [right, front], [right, back], [left, back]].map(|[x, y]| Point3::new(x, y, z))
    };
    rectangles.iter().enumerate().map(level).collect()
}

fn surfaces(corners: &[[Point3<f64>; 4]]) -> Vec<LayerSurface<'_>> {
    let surface = |vertices| LayerSurface {
        vertices,
        triangles: &[[0, 1, 2], [0, 2, 3]],
        thickness: &[HEIGHT; 2],
        is_half: false,
    };
    corners.iter().map(|corners| surface(&corners[..])).collect()
}

fn paths(filled: &FilledLayers) -> Vec<&LayerPaths> {
    filled.layers.iter().map(|layer| &layer.as_ref().unwrap().paths).collect()
}

/// Nineteen strips of 20 by 0.9 mm that carry a beam, on a foot.
fn beam() -> Vec<Rectangle> {
    let foot = [[0.0, 20.0], [-5.0, 5.0]];
    let web = [[0.0, 20.0], [-0.45, 0.45]];
    let beam = [[0.0, 20.0], [-1.3, 1.3]];
    [vec![foot; 2], vec![web; 19], vec![beam; 3]].concat()
}

#[test]
fn a_beam_on_narrow_strips_lies_on_something() {
    let rectangles = beam();
    let bare = PathOptions { bead: 1.3, min_width: 0.75, ..PathOptions::default() };
    let options = PathOptions { min_width: 0.5, ..bead_of(1.3) };
    assert_eq!(options, bead_of(1.3));
    let [before, after] = [bare, options].map(|options| fill(&rectangles, &options));
    assert!(paths(&before)[2..21].iter().all(|layer| (layer.paths.len(), layer.unfilled.len()) == (0, 1)));
    for layer in &paths(&after)[2..21] {
        let [path] = &layer.paths[..] else { panic!("{} curves", layer.paths.len()) };
        // As wide as the strip, along its middle, and up to half a width from its ends.
        assert!(path.points.iter().all(|point| (point.width - 0.9).abs() < 0.02 && point.at.position.y.abs() < 0.02));
        assert!((path.length() - 19.1).abs() < 0.5, "{}", path.length());
        assert_eq!((layer.narrow_laid, layer.narrow.len(), layer.unfilled.len(), layer.regions), (1, 0, 0, 1));
        assert!((layer.narrow_laid_mm - path.length()).abs() < 1e-9);
    }
    let [left_out, filled] = [&before, &after].map(FilledLayers::totals);
    assert_eq!((left_out.narrow_curves, filled.narrow_curves, filled.narrow_left), (0, 19, 0));
    assert!((filled.narrow_mm - 19.0 * 19.1).abs() < 10.0 && filled.covered_fraction > left_out.covered_fraction);
    let vertices = corners(&rectangles);
    assert_eq!([&before, &after].map(|filled| filled.left_out(&surfaces(&vertices)).parts), [19, 0]);
    // As beads are laid: the first layer of the beam lay on nothing, and 15 mm from anything.
    let [nothing, something] = [&before, &after].map(|filled| {
        let oriented = filled.stack(&surfaces(&vertices)).unwrap().orient(&OrientOptions::default(), &go_on).unwrap();
        let laid = deposit(&oriented.paths, &DepositionOptions::default()).unwrap();
        (check_support(&oriented.paths, HEIGHT, &SupportOptions::default(), &go_on).unwrap(), laid)
    });
    assert!(nothing.0.unsupported_mm() > 30.0 && nothing.0.longest_mm() > 30.0, "{}", nothing.0.unsupported_mm());
    assert!(something.0.unsupported_mm() <= 0.0, "{:?}", something.0.unsupported);
    // The deposit follows the width.
    let strips = 19.0 * 0.9 * 19.1 * HEIGHT;
    assert!(((something.1.extruded_mm3 - nothing.1.extruded_mm3) / strips - 1.0).abs() < 0.05);
}

fn bead_of(bead: f64) -> PathOptions {
    PathOptions { bead, ..PathOptions::default() }
}

#[test]
fn strips_that_carry_nothing_stay_bare() {
    let [strip, aside] = [[[0.0, 20.0], [0.0, 0.9]], [[0.0, 20.0], [5.0, 8.0]]];
    // Nothing above, something beside, a strip that carries nothing itself, and something that stands on a wide one between.
    for layers in
        [&[aside, strip][..], &[strip, aside], &[aside, strip, strip], &[strip, [[0.0, 20.0], [0.0, 6.0]], aside]]
    {
        let filled = fill(layers, &bead_of(1.3));
        let carries = layers.len() == 3 && layers[0] == strip;
        assert_eq!(filled.totals().narrow_curves, usize::from(carries), "{layers:?}");
        let left = layers.iter().filter(|&&layer| layer == strip).count() - usize::from(carries);
        assert_eq!(
            (filled.totals().narrow_left, paths(&filled).iter().map(|layer| layer.unfilled.len()).sum()),
            (left, left)
        );
        assert!((filled.totals().narrow_left_mm - 19.1 * left as f64).abs() < 0.5);
    }
}

#[test]
fn what_lies_on_a_strip_may_be_two_layers_up() {
    // Layers half as far apart as they are thick, of which the second is elsewhere.
    let at = |[[left, right], [front, back]]: Rectangle, z: f64| {
        [[left, front], [right, front], [right, back], [left, back]].map(|[x, y]| Point3::new(x, y, z))
    };
    let [strip, aside, over] = [[0.0, 0.9], [5.0, 8.0], [-1.5, 2.5]].map(|wide| [[0.0, 20.0], wide]);
    for (height, wanted) in [(1.2, 1), (1.7, 0)] {
        let corners = [at(strip, 0.4), at(aside, 0.8), at(over, height)];
        let filled = fill_layers(&surfaces(&corners), &bead_of(1.3), &go_on).unwrap();
        assert_eq!(filled.totals().narrow_curves, wanted, "{height}");
    }
    // Three up lies on what is between, in squeezed layers as well.
    let corners = [at(strip, 0.4), at(aside, 0.6), at(aside, 0.8), at(over, 1.0)];
    assert_eq!(fill_layers(&surfaces(&corners), &bead_of(1.3), &go_on).unwrap().totals().narrow_curves, 0);
}

#[test]
fn strips_below_the_least_width_and_dots_get_none() {
    let alone = |wide: f64, long: f64, options: &PathOptions| {
        let filled = fill(&[[[0.0, 30.0], [20.0, 30.0]], [[0.0, long], [0.0, wide]]], options);
        let layers = paths(&filled);
        (layers[1].paths.len(), layers[1].narrow.len())
    };
    let options = bead_of(1.0);
    assert_eq!(alone(0.49, 20.0, &options), (0, 0));
    assert_eq!(alone(0.51, 20.0, &options), (0, 1));
    assert_eq!(alone(0.49, 20.0, &PathOptions { min_width: 0.3, ..options }), (0, 1));
    assert_eq!(alone(0.74, 20.0, &options), (0, 1));
    assert_eq!(alone(0.74, 20.0, &PathOptions { min_width: 0.75, ..options }), (0, 0));
    assert_eq!(alone(0.76, 20.0, &options), (1, 0));
    // A bead of less than its width would be a dot.
    assert_eq!(alone(0.6, 1.5, &options), (0, 0));
    assert_eq!(alone(0.6, 1.8, &options), (0, 1));
    // Uniform beads lie in such strips anyway, and in no narrower ones.
    assert_eq!(alone(0.4, 20.0, &PathOptions { fitted: false, min_width: 0.3, ..options }), (0, 0));
    assert_eq!(alone(0.6, 20.0, &PathOptions { fitted: false, ..options }), (1, 0));
    assert_eq!(alone(0.6, 20.0, &PathOptions { pattern: Pattern::Zigzag, ..options }).1, 0);
}

#[test]
fn widths_that_are_none_are_refused() {
    let mesh = plate_with_holes(4, 1, vec![false; 16]);
    let distance = to_boundary(&mesh);
    let field = LevelField::new(&distance, 0.005, &go_on).unwrap();
    for bad in [-1.0, 0.0, 0.249, 0.751, f64::NAN, f64::INFINITY] {
        let options = PathOptions { min_width: bad, ..PathOptions::default() };
        assert!(matches!(field.paths(&options, &go_on), Err(PathError::MinWidth { .. })), "{bad}");
    }
}

#[test]
fn widths_follow_a_strip_that_tapers() {
    // From 1.1 mm wide to 0.5 over 30 mm, with a bead of 1.6: 0.8 to 1.1 are wide enough.
    let across = |k: u32| [-1.0, 1.0].map(|side| Point3::new(f64::from(k), side * (0.55 - 0.01 * f64::from(k)), 0.4));
    let triangles = |k: u32| [[2 * k, 2 * k + 2, 2 * k + 1], [2 * k + 1, 2 * k + 2, 2 * k + 3]];
    let mesh = SurfaceMesh::new((0..=30).flat_map(across).collect(), (0..30).flat_map(triangles).collect()).unwrap();
    let found = LevelField::new(&to_boundary(&mesh), 0.005, &go_on).unwrap().paths(&bead_of(BEAD), &go_on).unwrap();
    let ([], [path]) = (&found.paths[..], &found.narrow[..]) else {
        panic!("{} and {}", found.paths.len(), found.narrow.len())
    };
    for point in &path.points {
        let wide = 2.0 * to_edges(&mesh, &boundary_edges(&mesh), point.at.position);
        assert!((point.width - wide).abs() < 0.02 && point.width >= 0.5 * BEAD, "{} {wide}", point.width);
    }
    let [first, last] = [&path.points[0], &path.points[path.points.len() - 1]].map(|point| point.at.position.x);
    assert!(first.min(last) < 1.1 && (first.max(last) - 15.0).abs() < 1.1, "{first} {last}");
}

/// The candidates of a plate of square millimetres, and what they are beside.
fn of_plate(mesh: &SurfaceMesh, min_width: f64) -> LayerPaths {
    let options = PathOptions { min_width, ..bead_of(BEAD) };
    LevelField::new(&to_boundary(mesh), 0.005, &go_on).unwrap().paths(&options, &go_on).unwrap()
}

/// Parts of a plate that three squares in a row are in, by their triangles, and whether a curve is in each.
fn parts_with_rows(mesh: &SurfaceMesh, curves: &[&SurfacePath]) -> Vec<bool> {
    let parts = mesh.regions();
    let part_at = |x: f64, y: f64| {
        let inside = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| mesh.vertices()[v as usize]);
            let side = |a: Point3<f64>, b: Point3<f64>| (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x) >= 0.0;
            side(a, b) && side(b, c) && side(c, a)
        };
        mesh.triangles().iter().position(inside).map(|t| parts.of_triangle[t])
    };
    let mut rows = BTreeSet::new();
    for (i, j) in (0..12).flat_map(|i| (0..12).map(move |j| (f64::from(i) + 0.5, f64::from(j) + 0.5))) {
        for [u, v] in [[1.0, 0.0], [0.0, 1.0]] {
            if let [Some(part), Some(_), Some(_)] = [0.0, 1.0, 2.0].map(|k| part_at(i + k * u, j + k * v)) {
                rows.insert(part);
            }
        }
    }
    let has = |part: u32| curves.iter().any(|path| parts.of_triangle[path.points[0].at.triangle as usize] == part);
    rows.into_iter().map(has).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Widths are within bounds, beads within the plate and off all others, nothing crosses, and no part goes without one that has space for it.
    #[test]
    fn beads_of_strips_keep_off(seed in 0u64..1000, share in 0.3..0.7, min_width in 0.3..0.6) {
        let mut random = rng(seed);
        let mesh = plate_with_holes(12, seed, (0..144).map(|_| random.random::<f64>() < share).collect());
        prop_assume!(!mesh.triangles().is_empty());
        let [bare, found] = [0.75, min_width].map(|min_width| of_plate(&mesh, min_width));
        // What is laid in any case does not change.
        prop_assert_eq!((&bare.paths, &bare.short, &bare.unfilled), (&found.paths, &found.short, &found.unfilled));
        prop_assert!(bare.narrow.is_empty());
        let others: Vec<&SurfacePath> = found.paths.iter().chain(&found.short).collect();
        let rims = boundary_edges(&mesh);
        for path in &found.narrow {
            prop_assert!(!path.closed && path.length() >= 0.98 * BEAD);
            for point in &path.points {
                let (p, width) = (point.at.position, point.width);
                prop_assert!((min_width * BEAD..=1.25 * BEAD).contains(&width));
                prop_assert!(to_edges(&mesh, &rims, p) >= 0.5 * width - 0.011, "{} {}", to_edges(&mesh, &rims, p), width);
                prop_assert_eq!(point.kind, BeadKind::Wall);
                for other in &others {
                    let (line, widths) = other.line();
                    let off = |k: usize| to_segment(p, line[k], line[k + 1]) - 0.25 * (widths[k] + widths[k + 1]);
                    prop_assert!((0..line.len() - 1).all(|k| off(k) >= 0.5 * width - 1e-9));
                }
            }
        }
        let all: Vec<SurfacePath> = others.iter().copied().chain(&found.narrow).cloned().collect();
        let laid: Vec<SurfacePath> = others.into_iter().cloned().collect();
        prop_assert_eq!(crossings(&all), crossings(&laid));
        prop_assert!(parts_with_rows(&mesh, &all.iter().collect::<Vec<_>>()).into_iter().all(|has| has));
    }
}

/// Bits of the ends of an open curve, whichever way round.
fn ends(path: &SurfacePath) -> [[u64; 3]; 2] {
    let bits = |point: &PathPoint| point.at.position.coords.map(f64::to_bits).into();
    let [a, b] = [&path.points[0], &path.points[path.points.len() - 1]].map(bits);
    if a < b { [a, b] } else { [b, a] }
}

/// Which short and which narrow curves stay, from the last layer to the first: all places against all segments.
fn slow_carriers(layers: &[LayerPaths]) -> Vec<[Vec<SurfacePath>; 2]> {
    let mut stay: Vec<[Vec<SurfacePath>; 2]> = vec![Default::default(); layers.len()];
    for at in (0..layers.len()).rev() {
        let mut places = Vec::new();
        for above in at + 1..layers.len().min(at + 3) {
            for path in layers[above].paths.iter().chain(&stay[above][0]).chain(&stay[above][1]) {
                for pair in path.line().0.windows(2) {
                    let steps = (2.0 * (pair[1] - pair[0]).norm() / BEAD).ceil().max(1.0);
                    places.extend((0..steps as usize).map(|k| pair[0] + (pair[1] - pair[0]) * (k as f64 / steps)));
                }
            }
        }
        let on = |path: &SurfacePath, p: &Point3<f64>| {
            path.line().0.windows(2).any(|pair| to_segment(*p, pair[0], pair[1]) <= 1.5 * HEIGHT)
        };
        let mut kept = layers[at].paths.clone();
        for (k, left) in [&layers[at].short, &layers[at].narrow].into_iter().enumerate() {
            let free = places.iter().filter(|p| !kept.iter().any(|path| on(path, p))).copied().collect::<Vec<_>>();
            let carries = |path: &&SurfacePath| free.iter().any(|p| on(path, p));
            stay[at][k] = left.iter().filter(carries).cloned().collect();
            kept.extend(stay[at][k].clone());
        }
    }
    stay
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// What stays of stacks of random plates is what the slow twin says, and every place on a strip that stays is on something.
    #[test]
    fn what_carries_is_that_of_the_slow_twin(seed in 0u64..1000, share in 0.3..0.6, fewer in 0.0..0.3) {
        let mut random = rng(seed);
        let meshes: Vec<SurfaceMesh> = (0..4_u32).map(|k| {
            let share = share - fewer * f64::from(k) / 3.0;
            let holes: Vec<bool> = (0..100).map(|_| random.random::<f64>() < share).collect();
            // No two squares meet in a corner alone: cut to whole rows of a plate with holes.
            let level = plate_with_holes(10, seed + u64::from(k), holes);
            let up = |p: &Point3<f64>| Point3::new(p.x, p.y, HEIGHT * (f64::from(k) + 0.5));
            SurfaceMesh::new(level.vertices().iter().map(up).collect(), level.triangles().to_vec()).unwrap()
        }).collect();
        prop_assume!(meshes.iter().all(|mesh| !mesh.triangles().is_empty()));
        let thickness: Vec<Vec<f64>> = meshes.iter().map(|mesh| vec![HEIGHT; mesh.triangles().len()]).collect();
        let surfaces: Vec<LayerSurface> = meshes.iter().zip(&thickness)
            .map(|(mesh, thickness)| (mesh.vertices(), mesh.triangles(), &thickness[..]).into()).collect();
        let options = PathOptions { join_distance: 0.0, ..bead_of(BEAD) };
        let alone: Vec<LayerPaths> =
            surfaces.iter().map(|surface| fill_layer(surface, &options, &go_on).unwrap().paths).collect();
        let Ok(filled) = fill_layers(&surfaces, &options, &go_on) else { return Ok(()) };
        let stay = slow_carriers(&alone);
        for ((got, alone), [short, narrow]) in paths(&filled).into_iter().zip(&alone).zip(&stay) {
            let set = |paths: &[SurfacePath]| paths.iter().map(ends).collect::<BTreeSet<_>>();
            let wanted = [&alone.paths[..], short, narrow].concat();
            prop_assert_eq!(set(&got.paths), set(&wanted));
            prop_assert_eq!((got.paths.len(), got.narrow_laid), (wanted.len(), narrow.len()));
            prop_assert_eq!(got.narrow.len() + narrow.len(), alone.narrow.len());
            prop_assert_eq!(got.short.len() + short.len(), alone.short.len());
            prop_assert_eq!(got.regions, alone.regions + narrow.len());
        }
        // Of parts without a bead there are those left that are.
        for (got, mesh) in paths(&filled).into_iter().zip(&meshes) {
            let parts = mesh.regions();
            let part = |triangle: u32| parts.of_triangle[triangle as usize];
            let with: BTreeSet<u32> = got.paths.iter().map(|path| part(path.points[0].at.triangle)).collect();
            let without: BTreeSet<u32> = got.unfilled.iter().map(|unfilled| part(unfilled.at.triangle)).collect();
            prop_assert!(with.is_disjoint(&without) && with.len() + without.len() == parts.count);
        }
    }
}

#[test]
fn some_strips_carry() {
    // A plate with a strip that sticks out, and a plate over both.
    let plate = |z: f64, wide: bool| {
        let there = move |i: usize, j: usize| (i < 8 || wide) && j < 8 || j == 4 && i < 16;
        grid(20, 3, 0.0, move |i, j| !there(i, j), |p| Point3::new(p.x, p.y, z))
    };
    let meshes = [plate(0.4, false), plate(1.2, true)];
    let thickness = meshes.each_ref().map(|mesh| vec![HEIGHT; mesh.triangles().len()]);
    let surfaces: [LayerSurface; 2] =
        [0, 1].map(|k| (meshes[k].vertices(), meshes[k].triangles(), &thickness[k][..]).into());
    let [bare, filled] = [0.75, 0.5]
        .map(|min_width| fill_layers(&surfaces, &PathOptions { min_width, ..bead_of(BEAD) }, &go_on).unwrap());
    assert_eq!([&bare, &filled].map(|filled| paths(filled)[0].paths.len()), [1, 2]);
    assert_eq!((filled.totals().narrow_curves, bare.totals().narrow_curves), (1, 0));
    assert!((6.0..8.5).contains(&filled.totals().narrow_mm), "{}", filled.totals().narrow_mm);
    // Its figures are judged again: the strip is covered.
    let [before, after] = [&bare, &filled].map(|filled| &filled.layers[0].as_ref().unwrap().statistics);
    assert!(after.covered_fraction > before.covered_fraction + 5.0 / 72.0 && after.self_crossings == 0);
}
