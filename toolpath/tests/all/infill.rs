//! Walls, skins and sparse infill: closed forms, densities, anchors, skins against brute force, degenerate parts, what is refused.

use crate::common::nozzle::tip_1_mm;
use crate::common::{go_on, grid, to_boundary};
use curvlay_toolpath::contour::BEAD_WIDTHS;
use curvlay_toolpath::fill::{
    Bridges, FillLayersError, FilledLayer, FilledLayers, fill_layer, fill_layers, fill_range,
};

use curvlay_toolpath::infill::{FillError, SparseFill};
use curvlay_toolpath::layer::{LayerSurface, StackError};
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Point2, Point3, Vector3};
use curvlay_toolpath::path::{BeadKind, InfillOptions, InfillPattern, PathError, PathOptions, Pattern, SurfacePath};
use curvlay_toolpath::plan::PrintOptions;
use curvlay_toolpath::support::{SupportOptions, check_support};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

const BEAD: f64 = 0.5;
const HEIGHT: f64 = 0.3;

/// A part of some layers, all equally thick.
struct Part {
    meshes: Vec<SurfaceMesh>,
    thickness: Vec<Vec<f64>>,
}

impl Part {
    fn new(meshes: impl IntoIterator<Item = SurfaceMesh>) -> Part {
        let meshes: Vec<_> = meshes.into_iter().collect();
        let thickness = meshes.iter().map(|mesh| vec![HEIGHT; mesh.triangles().len()]).collect();
        Part { meshes, thickness }
    }

    fn surfaces(&self) -> Vec<LayerSurface<'_>> {
        let of = |k: usize| LayerSurface {
            vertices: self.meshes[k].vertices(),
            triangles: self.meshes[k].triangles(),
            thickness: &self.thickness[k],
            is_half: false,
        };
        (0..self.meshes.len()).map(of).collect()
    }

    fn filled(&self, infill: InfillOptions) -> FilledLayers {
        fill_layers(&self.surfaces(), &PathOptions { bead: BEAD, infill, ..PathOptions::default() }, &go_on).unwrap()
    }

    fn area(&self, layer: usize) -> f64 {
        let corner = |v: u32| self.meshes[layer].vertices()[v as usize];
        let area = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).cross(&(corner(c) - corner(a))).norm() / 2.0;
        self.meshes[layer].triangles().iter().map(area).sum()
    }
}

/// A layer of a plate of `n` by `n` mm.
fn plate(n: usize, layer: usize) -> SurfaceMesh {
    grid(n, layer as u64, 0.6, |_, _| false, |p| Point3::new(p.x, p.y, HEIGHT * (layer as f64 + 0.5)))
}

/// A layer of rings of vertices around a pole: `place` says where a share of the way out and an angle are.
fn polar(rings: usize, place: impl Fn(f64, f64) -> Point3<f64>) -> SurfaceMesh {
    let around = 6 * rings as u32;
    let mut vertices = vec![place(0.0, 0.0)];
    for ring in 1..=rings {
        let at = |k: u32| place(ring as f64 / rings as f64, TAU * f64::from(k) / f64::from(around));
        vertices.extend((0..around).map(at));
    }
    let of = |ring: u32, k: u32| 1 + (ring - 1) * around + k % around;
    let mut triangles: Vec<[u32; 3]> = (0..around).map(|k| [0, of(1, k), of(1, k + 1)]).collect();
    for ring in 1..rings as u32 {
        for k in 0..around {
            let [p, q, r, s] = [of(ring, k), of(ring + 1, k), of(ring + 1, k + 1), of(ring, k + 1)];
            triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
    SurfaceMesh::new(vertices, triangles).unwrap()
}

/// A layer of a dome: a cap of a sphere around the origin, up to an angle from the pole.
fn dome(radius: f64, angle: f64) -> SurfaceMesh {
    polar(24, |share, around| {
        let (out, up) = (share * angle).sin_cos();
        Point3::new(radius * out * around.cos(), radius * out * around.sin(), radius * up)
    })
}

fn curves(filled: &FilledLayers, layer: usize, kind: BeadKind) -> Vec<&SurfacePath> {
    let paths = filled.layers[layer].iter().flat_map(|layer| &layer.paths.paths);
    // A bridge is a part of a skin.
    let kind_of = |path: &SurfacePath| match path.points[0].kind {
        BeadKind::Bridge => BeadKind::Skin,
        kind => kind,
    };
    paths.filter(|path| kind_of(path) == kind).collect()
}

fn length(filled: &FilledLayers, layer: usize, kind: BeadKind) -> f64 {
    curves(filled, layer, kind).into_iter().fold(0.0, |sum, path| sum + path.length())
}

/// Only contours.
fn walls_alone(walls: u32) -> InfillOptions {
    InfillOptions { density: 0.0, walls, skin: 0, ..InfillOptions::default() }
}

#[test]
fn walls_are_as_long_as_the_contours_of_a_square_a_disc_and_a_dome() {
    let [side, radius, angle] = [24.0, 12.0, 0.9_f64];
    let disc = polar(24, |share, angle| Point3::new(radius * share * angle.cos(), radius * share * angle.sin(), 0.15));
    type Contour<'a> = &'a dyn Fn(f64) -> f64;
    let on_square = |d: f64| 4.0 * (side - 2.0 * d);
    let on_disc = |d: f64| TAU * (radius - d);
    let on_dome = |d: f64| TAU * radius * (angle - d / radius).sin();
    let parts: [(SurfaceMesh, Contour); 3] =
        [(plate(24, 0), &on_square), (disc, &on_disc), (dome(radius, angle), &on_dome)];
    for (mesh, contour) in parts {
        let part = Part::new([mesh]);
        for walls in 1..=4 {
            let filled = part.filled(walls_alone(walls));
            let wanted: f64 = (0..walls).map(|k| contour((f64::from(k) + 0.5) * BEAD)).sum();
            let found = length(&filled, 0, BeadKind::Wall);
            // A spiral leaves a window open in each ring, and crosses it aslant.
            assert!((found - wanted).abs() < f64::from(walls) * 2.0 * BEAD, "{walls}: {found} instead of {wanted}");
            assert_eq!(curves(&filled, 0, BeadKind::Wall).len(), 1, "one spiral");
            let totals = filled.totals();
            assert!((totals.wall_mm - found).abs() < 1e-9 && totals.curves == 1);
            // All of the rest is sparse, and has nothing in it.
            let rest = part.area(0) - wanted * BEAD;
            let sparse = totals.sparse;
            assert!((sparse.area_mm2 - rest).abs() < 0.01 * rest, "{} instead of {rest}", sparse.area_mm2);
            assert_eq!((sparse.infill_mm, sparse.density()), (0.0, 0.0));
            assert!(totals.filled_fraction > 0.97 && totals.overlap_fraction < 0.03, "{totals:?}");
        }
    }
}

#[test]
fn walls_of_a_tube_run_along_both_of_its_rims() {
    // A layer around a cylinder of a radius of 8 mm, 20 mm high.
    let (radius, high) = (8.0, 20);
    let around = 48;
    let at = |j: u32, k: u32| {
        let angle = TAU * f64::from(k) / f64::from(around);
        Point3::new(radius * angle.cos(), radius * angle.sin(), f64::from(j))
    };
    let vertices = (0..=high).flat_map(|j| (0..around).map(move |k| at(j, k))).collect();
    let of = |j: u32, k: u32| j * around + k % around;
    let square = |(j, k): (u32, u32)| {
        let [p, q, r, s] = [of(j, k), of(j, k + 1), of(j + 1, k + 1), of(j + 1, k)];
        [[p, q, r], [p, r, s]]
    };
    let triangles = (0..high).flat_map(|j| (0..around).map(move |k| (j, k))).flat_map(square).collect();
    let part = Part::new([SurfaceMesh::new(vertices, triangles).unwrap()]);
    let infill = InfillOptions { density: 0.25, walls: 2, skin: 0, ..InfillOptions::default() };
    let filled = part.filled(infill);
    let rim = f64::from(around) * 2.0 * radius * (PI / f64::from(around)).sin();
    assert_eq!(curves(&filled, 0, BeadKind::Wall).len(), 2);
    let wall = length(&filled, 0, BeadKind::Wall);
    assert!((wall - 4.0 * rim).abs() < 4.0 * BEAD, "{wall}");
    let sparse = filled.totals().sparse;
    assert!((sparse.area_mm2 - rim * (f64::from(high) - 4.0 * BEAD)).abs() < 0.01 * sparse.area_mm2);
    assert!((sparse.density() - 0.25).abs() < 0.03 * 0.25, "{}", sparse.density());
}

#[test]
fn rows_have_the_density_asked_for_on_plates_and_domes() {
    for density in [0.1, 0.2, 0.5] {
        for mesh in [plate(40, 0), dome(25.0, 0.9)] {
            let part = Part::new([mesh]);
            let infill = InfillOptions { density, walls: 2, skin: 0, ..InfillOptions::default() };
            let filled = part.filled(infill);
            // By the curves alone.
            let area = part.area(0) - BEAD * length(&filled, 0, BeadKind::Wall);
            let achieved = BEAD * length(&filled, 0, BeadKind::Infill) / area;
            assert!((achieved - density).abs() < 0.03 * density, "{achieved} instead of {density}");
            let sparse = filled.totals().sparse;
            assert!((sparse.density() - achieved).abs() < 0.01 * density, "{}", sparse.density());
            assert!((sparse.infill_mm - length(&filled, 0, BeadKind::Infill)).abs() < 1e-6);
            // To and fro: few starts.
            assert!(curves(&filled, 0, BeadKind::Infill).len() <= 6, "{}", sparse.curves);
        }
    }
}

#[test]
fn a_gyroid_has_the_density_asked_for_over_its_period() {
    // A period is 2.44 * 0.5 / 0.25 = 4.88 mm, 16 layers.
    let part = Part::new((0..16).map(|k| plate(30, k)));
    let pattern = InfillPattern::Gyroid;
    let filled = part.filled(InfillOptions { density: 0.25, walls: 2, skin: 0, pattern, ..InfillOptions::default() });
    let sparse = filled.totals().sparse;
    assert!((sparse.density() - 0.25).abs() < 0.03 * 0.25, "{}", sparse.density());
    // Curves are on the gyroid: all points of a layer but those on its rim have the value 0 for one period.
    let value = |p: &Point3<f64>, period: f64| {
        let [x, y, z] = [p.x, p.y, p.z].map(|c| TAU * c / period);
        x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
    };
    let distance = to_boundary(&part.meshes[7]);
    let inner: Vec<Point3<f64>> = curves(&filled, 7, BeadKind::Infill)
        .iter()
        .flat_map(|path| &path.points)
        .filter(|p| distance.at(p.at.triangle, p.at.barycentric).distance > 3.0 * BEAD)
        .map(|p| p.at.position)
        .collect();
    let worst = |period: f64| inner.iter().map(|p| value(p, period).abs()).fold(0.0, f64::max);
    let best = (400..1000).map(|k| f64::from(k) / 100.0).map(worst).fold(f64::INFINITY, f64::min);
    assert!(inner.len() > 100 && best < 0.1, "{best}");
}

#[test]
fn infill_ends_in_the_bead_of_the_innermost_wall() {
    for pattern in [InfillPattern::Rows, InfillPattern::Gyroid] {
        for (mesh, walls) in [(plate(30, 0), 3), (dome(20.0, 1.0), 1)] {
            let part = Part::new([mesh]);
            let infill = InfillOptions { density: 0.2, walls, skin: 0, pattern, ..InfillOptions::default() };
            let filled = part.filled(infill);
            let distance = to_boundary(&part.meshes[0]);
            let inner = f64::from(walls) * BEAD;
            let found = curves(&filled, 0, BeadKind::Infill);
            assert!(!found.is_empty());
            for path in found {
                let depth = |k: usize| {
                    let at = path.points[k].at;
                    distance.at(at.triangle, at.barycentric).distance
                };
                let last = path.points.len() - 1;
                assert!((0..=last).all(|k| depth(k) > inner - 0.2 * BEAD));
                for end in if path.closed { vec![] } else { vec![depth(0), depth(last)] } {
                    assert!(end < inner - 0.1 * BEAD, "{end}: the wall ends at {inner}");
                }
            }
        }
    }
}

#[test]
fn rows_turn_from_layer_to_layer() {
    let part = Part::new((0..4).map(|k| plate(20, k)));
    for turn in [InfillOptions::default().turn, FRAC_PI_2] {
        let filled = part.filled(InfillOptions { density: 0.15, walls: 1, skin: 0, turn, ..InfillOptions::default() });
        for layer in 0..4 {
            // The mean of twice the angle.
            let mut sum = [0.0; 2];
            for path in curves(&filled, layer, BeadKind::Infill) {
                for pair in path.points.windows(2) {
                    let way: Vector3<f64> = pair[1].at.position - pair[0].at.position;
                    let angle = 2.0 * way.y.atan2(way.x);
                    sum = [sum[0] + way.norm() * angle.cos(), sum[1] + way.norm() * angle.sin()];
                }
            }
            let found = sum[1].atan2(sum[0]) / 2.0;
            let wanted = FRAC_PI_4 + FRAC_PI_2 + layer as f64 * turn;
            let off = (found - wanted).rem_euclid(PI);
            assert!(off.min(PI - off) < 0.15, "layer {layer}: {found} instead of {wanted}");
        }
    }
}

/// A step pyramid: `low` layers of 24 mm, then `high` ones of 12 mm in the middle.
fn pyramid(low: usize, high: usize) -> Part {
    let top = |layer: usize| {
        let z = HEIGHT * (layer as f64 + 0.5);
        grid(12, layer as u64, 0.6, |_, _| false, move |p| Point3::new(p.x + 6.0, p.y + 6.0, z))
    };
    Part::new((0..low).map(|k| plate(24, k)).chain((low..low + high).map(top)))
}

/// Half layers between all layers of a pyramid: skins and infill of the layers stay as they are without, and half layers inside have no skin.
#[test]
fn half_layers_do_not_count() {
    let (low, high) = (8, 5);
    let part = pyramid(low, high);
    let half = |k: usize| {
        let z = HEIGHT * (k as f64 + 1.0);
        grid(8, 50 + k as u64, 0.6, |_, _| false, move |p| Point3::new(p.x + 8.0, p.y + 8.0, z))
    };
    let halves = Part::new((0..low + high - 1).map(half));
    let between = halves.surfaces().into_iter().map(|surface| LayerSurface { is_half: true, ..surface });
    let mut between = between.map(Some).chain([None]);
    let halved: Vec<LayerSurface> =
        part.surfaces().into_iter().flat_map(|layer| [Some(layer), between.next().unwrap()]).flatten().collect();
    let infill = InfillOptions { density: 0.3, walls: 1, skin: 2, ..InfillOptions::default() };
    let options = PathOptions { bead: BEAD, infill, ..PathOptions::default() };
    let filled = |surfaces: &[LayerSurface]| fill_range(surfaces, 0..surfaces.len(), &options, &go_on).unwrap();
    let paths = |layer: &Option<FilledLayer>| layer.as_ref().unwrap().paths.paths.clone();
    let (plain, halved) = (filled(&part.surfaces()), filled(&halved));
    for (layer, both) in plain.iter().zip(halved.chunks(2)) {
        assert_eq!(format!("{:?}", paths(layer)), format!("{:?}", paths(&both[0])));
    }
    let kinds: Vec<BeadKind> = paths(&halved[2 * 4 + 1]).iter().map(|path| path.points[0].kind).collect();
    assert!(kinds.contains(&BeadKind::Infill) && !kinds.contains(&BeadKind::Skin), "{kinds:?}");
}

#[test]
fn skins_are_where_fewer_layers_lie_above_or_below() {
    let (low, high, skin) = (7, 5, 2);
    let filled = pyramid(low, high).filled(InfillOptions {
        density: 0.2,
        walls: 2,
        skin: skin as u32,
        ..InfillOptions::default()
    });
    for layer in 0..low + high {
        let (solid, sparse) = (length(&filled, layer, BeadKind::Skin), length(&filled, layer, BeadKind::Infill));
        match layer {
            // Bottom and top as a whole.
            _ if layer < skin || layer >= low + high - skin => assert!(sparse == 0.0 && solid > 0.0, "{layer}"),
            // Under the step: around what goes on above.
            _ if (low - skin..low).contains(&layer) => {
                assert!(sparse > 0.0 && solid > 0.0, "{layer}");
                let is_under = |p: &Point3<f64>, by: f64| p.coords.xy().iter().all(|c| (c - 12.0).abs() < 6.0 + by);
                for path in curves(&filled, layer, BeadKind::Infill) {
                    assert!(path.points.iter().all(|p| is_under(&p.at.position, 0.0)));
                }
                // Grown inward by a bead, from the last vertex that is covered.
                let grown = curves(&filled, layer, BeadKind::Skin);
                assert!(grown.iter().flat_map(|path| &path.points).all(|p| !is_under(&p.at.position, -3.0)));
                assert!(grown.iter().flat_map(|path| &path.points).any(|p| is_under(&p.at.position, 0.0)));
            }
            _ => assert!(sparse > 0.0 && solid == 0.0, "{layer}"),
        }
    }
    let totals = filled.totals();
    assert!(totals.filled_fraction > 0.96 && totals.overlap_fraction < 0.04, "{totals:?}");
    assert!((totals.sparse.density() - 0.2).abs() < 0.03 * 0.2, "{}", totals.sparse.density());
}

/// Whether a straight way meets a triangle, by volumes of tetrahedra.
fn meets(from: Point3<f64>, to: Point3<f64>, corners: [Point3<f64>; 3]) -> bool {
    let volume = |a: Point3<f64>, b: Point3<f64>, c: Point3<f64>, d: Point3<f64>| (b - a).cross(&(c - a)).dot(&(d - a));
    let [a, b, c] = corners;
    let sides = [volume(from, to, a, b), volume(from, to, b, c), volume(from, to, c, a)];
    let slack = 1e-9;
    volume(from, a, b, c) * volume(to, a, b, c) <= 0.0
        && (sides.iter().all(|&v| v >= -slack) || sides.iter().all(|&v| v <= slack))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3, ..ProptestConfig::default() })]

    #[test]
    fn skins_agree_with_columns_through_all_triangles(seed in 0_u64..1000, skin in 1_u32..4, hole in (3_usize..9, 3_usize..9, 2_usize..6)) {
        // Wavy layers; from the middle one on they have a hole.
        let (n, count) = (16, 10);
        let (x, y, side) = hole;
        let mesh = |layer: usize| {
            let is_hole = move |i: usize, j: usize| layer >= count / 2 && (x..x + side).contains(&i) && (y..y + side).contains(&j);
            let z = HEIGHT * (layer as f64 + 0.5);
            grid(n, seed, 0.4, is_hole, move |p| Point3::new(p.x, p.y, z + 0.5 * (0.4 * p.x).sin() * (0.3 * p.y).cos()))
        };
        let part = Part::new((0..count).map(mesh));
        let filled = part.filled(InfillOptions { density: 0.3, walls: 1, skin, ..InfillOptions::default() });
        for (layer, mesh) in part.meshes.iter().enumerate() {
            let mut normals = vec![Vector3::zeros(); mesh.vertices().len()];
            for corners in mesh.triangles() {
                let [a, b, c] = corners.map(|v| mesh.vertices()[v as usize]);
                corners.iter().for_each(|&v| normals[v as usize] += (b - a).cross(&(c - a)));
            }
            let is_covered = |v: usize| {
                let (from, normal) = (mesh.vertices()[v], normals[v].normalize());
                [-1, 1].into_iter().all(|sign| (1..=skin as i32).all(|step| {
                    let other = layer as i32 + sign * step;
                    let Some(other) = usize::try_from(other).ok().and_then(|other| part.meshes.get(other)) else { return false };
                    let to = from + normal * (f64::from(sign) * 1.5 * HEIGHT * f64::from(skin));
                    other.triangles().iter().any(|t| meets(from, to, t.map(|v| other.vertices()[v as usize])))
                }))
            };
            let bare: Vec<Point3<f64>> =
                (0..mesh.vertices().len()).filter(|&v| !is_covered(v)).map(|v| mesh.vertices()[v]).collect();
            let near = |p: Point3<f64>| bare.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
            // Infill keeps half an edge and nearly a bead off what is bare; skin is no farther from it than an edge, a bead, and what
            // edges go round, or fills what is narrow.
            for path in curves(&filled, layer, BeadKind::Infill) {
                prop_assert!(path.points.iter().all(|p| near(p.at.position) > 0.5 * BEAD));
            }
            for path in curves(&filled, layer, BeadKind::Skin) {
                let farthest = path.points.iter().map(|p| near(p.at.position)).fold(0.0, f64::max);
                prop_assert!(farthest < 1.9 + BEAD + 3.0 * BEAD, "{farthest}");
            }
            if bare.is_empty() {
                prop_assert!(length(&filled, layer, BeadKind::Infill) > 0.0);
            }
        }
    }

    #[test]
    fn any_plate_with_holes_is_filled_without_crossings(seed in 0_u64..1000, density in 0.05_f64..0.6, walls in 0_u32..4, gyroid in any::<bool>()) {
        let is_hole = |i: usize, j: usize| (4..7).contains(&i) && (5..12).contains(&j) || (i, j) == (12, 12);
        let layer = |k: usize| grid(18, seed, 0.6, is_hole, move |p| Point3::new(p.x, p.y, HEIGHT * (k as f64 + 0.5)));
        let part = Part::new((0..3).map(layer));
        let pattern = if gyroid { InfillPattern::Gyroid } else { InfillPattern::Rows };
        let filled = part.filled(InfillOptions { density, walls, skin: 1, pattern, ..InfillOptions::default() });
        let totals = filled.totals();
        prop_assert_eq!(totals.self_crossings, 0);
        prop_assert!(length(&filled, 1, BeadKind::Infill) > 0.0);
        prop_assert!([0, 2].into_iter().all(|layer| curves(&filled, layer, BeadKind::Infill).is_empty()));
        prop_assert!((walls > 0) == (totals.wall_mm > 0.0));
        // Infill begins inside of the walls, which are as wide as fits there, but for the overlap and the tolerance of curves.
        let distance = to_boundary(&part.meshes[1]);
        for p in curves(&filled, 1, BeadKind::Infill).iter().flat_map(|path| &path.points) {
            let depth = distance.at(p.at.triangle, p.at.barycentric).distance;
            prop_assert!(depth > (BEAD_WIDTHS[0] * f64::from(walls) - 0.2) * BEAD, "{}", depth);
        }
    }
}

#[test]
fn a_solid_part_does_not_depend_on_walls_and_skins() {
    let part = Part::new((0..2).map(|k| plate(10, k)));
    let solid = part.filled(InfillOptions::default());
    let other = InfillOptions { walls: 1, skin: 9, pattern: InfillPattern::Gyroid, ..InfillOptions::default() };
    assert_eq!(part.filled(other), solid);
    assert_eq!(solid.totals().sparse, SparseFill::default());
    assert!(solid.totals().skin_mm == 0.0 && solid.totals().solid_mm > 0.0);
}

#[test]
fn a_single_layer_is_all_skin() {
    let mesh = plate(12, 0);
    let thickness = vec![HEIGHT; mesh.triangles().len()];
    let surface =
        LayerSurface { vertices: mesh.vertices(), triangles: mesh.triangles(), thickness: &thickness, is_half: false };
    let infill = InfillOptions { density: 0.2, ..InfillOptions::default() };
    let options = PathOptions { bead: BEAD, infill, ..PathOptions::default() };
    let layer = fill_layer(&surface, &options, &go_on).unwrap();
    assert_eq!(layer.sparse, SparseFill::default());
    assert!(layer.statistics.covered_fraction > 0.96, "{}", layer.statistics.covered_fraction);
    let kinds: Vec<BeadKind> = layer.paths.paths.iter().map(|path| path.points[0].kind).collect();
    assert!(kinds.contains(&BeadKind::Wall) && kinds.contains(&BeadKind::Skin) && kinds.len() == 2, "{kinds:?}");
    // Without skins it is sparse.
    let options = PathOptions { infill: InfillOptions { skin: 0, ..infill }, ..options };
    assert!(fill_layer(&surface, &options, &go_on).unwrap().sparse.area_mm2 > 60.0);
}

#[test]
fn what_is_narrower_than_the_walls_is_filled_by_them() {
    // 2 mm: four beads across, where three walls would take six.
    let mesh = grid(20, 3, 0.0, |_, _| false, |p| Point3::new(p.x, p.y * 0.1, HEIGHT / 2.0));
    let part = Part::new([mesh]);
    let filled = part.filled(InfillOptions { density: 0.1, skin: 0, ..InfillOptions::default() });
    let totals = filled.totals();
    assert_eq!((totals.sparse.area_mm2, totals.skin_mm), (0.0, 0.0));
    assert!(totals.covered_fraction > 0.95, "{}", totals.covered_fraction);
    // A little wider than the walls: what is left is too narrow for rows, and solid.
    let mesh = grid(20, 3, 0.0, |_, _| false, |p| Point3::new(p.x, p.y * 0.1, HEIGHT / 2.0));
    let filled =
        Part::new([mesh]).filled(InfillOptions { density: 0.1, skin: 0, walls: 1, ..InfillOptions::default() });
    assert_eq!(filled.totals().sparse, SparseFill::default());
    assert!(filled.totals().skin_mm > 0.0 && filled.totals().covered_fraction > 0.95);
}

#[test]
fn without_walls_rows_reach_the_boundary() {
    let part = Part::new([plate(20, 0)]);
    for pattern in [Pattern::Spirals, Pattern::Rings, Pattern::Zigzag] {
        let infill = InfillOptions { density: 0.25, walls: 0, skin: 0, ..InfillOptions::default() };
        let options = PathOptions { bead: BEAD, infill, pattern, ..PathOptions::default() };
        let filled = fill_layers(&part.surfaces(), &options, &go_on).unwrap();
        let totals = filled.totals();
        assert_eq!((totals.wall_mm, totals.skin_mm, totals.covered_fraction), (0.0, 0.0, 0.0));
        assert!((totals.sparse.area_mm2 - 400.0).abs() < 1e-6);
        assert!((totals.sparse.density() - 0.25).abs() < 0.03 * 0.25, "{}", totals.sparse.density());
    }
}

#[test]
fn empty_layers_are_no_cover() {
    let mut surfaces = Part::new((0..5).map(|k| plate(14, k)));
    surfaces.thickness[2].clear();
    let mut layers = surfaces.surfaces();
    layers[2].triangles = &[];
    let infill = InfillOptions { density: 0.2, skin: 1, ..InfillOptions::default() };
    let options = PathOptions { bead: BEAD, infill, ..PathOptions::default() };
    let filled = fill_layers(&layers, &options, &go_on).unwrap();
    assert_eq!(filled.totals().sparse, SparseFill::default());
    assert!(filled.layers[2].is_none());
}

/// Lengths of the runs of bridge or skin with the other one on both sides, from the point before to the point after.
fn runs_between(path: &SurfacePath) -> Vec<f64> {
    let count = path.points.len();
    let kind = |k: usize| path.points[k % count].kind;
    let arc = |from: usize, to: usize| {
        let leg = |k: usize| (path.points[(k + 1) % count].at.position - path.points[k % count].at.position).norm();
        (from..to).map(leg).sum::<f64>()
    };
    let ends = if path.closed { 1..count + 1 } else { 1..count };
    let flips: Vec<usize> = ends.filter(|&k| kind(k - 1) != kind(k)).collect();
    let mut pairs: Vec<[usize; 2]> = flips.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    if let (true, Some(first), Some(last)) = (path.closed && flips.len() > 1, flips.first(), flips.last()) {
        pairs.push([*last, first + count]);
    }
    let is_skin = |k: usize| matches!(kind(k), BeadKind::Skin | BeadKind::Bridge);
    let pairs = pairs.into_iter().filter(|&[from, to]| kind(from - 1) == kind(to) && is_skin(from) && is_skin(to));
    pairs.map(|[from, to]| arc(from - 1, to)).collect()
}

/// A slit through all layers below the top has walls on both sides, which carry skins for a few beads: too few for a change of kind, at any size.
#[test]
fn kinds_do_not_flicker_at_any_size() {
    for size in [0.5, 6.0] {
        let layer = |k: usize| {
            let place = |p: Point2<f64>| {
                let x = p.x.min(15.0) + 0.05 * (p.x - 15.0).clamp(0.0, 1.0) + (p.x - 16.0).max(0.0);
                Point3::new(size * x, size * p.y, size * 0.6 * (k as f64 + 0.5))
            };
            grid(31, k as u64, 0.6, |i, _| k < 8 && i == 15, place)
        };
        let meshes: Vec<_> = (0..10).map(layer).collect();
        let thickness: Vec<_> = meshes.iter().map(|mesh| vec![0.6 * size; mesh.triangles().len()]).collect();
        let part = Part { meshes, thickness };
        let infill = InfillOptions { density: 0.1, walls: 1, skin: 2, ..InfillOptions::default() };
        let options = PathOptions { bead: size, infill, ..PathOptions::default() };
        let filled = fill_layers(&part.surfaces(), &options, &go_on).unwrap();
        let paths: Vec<&SurfacePath> = filled.layers[8].iter().flat_map(|layer| &layer.paths.paths).collect();
        let bridges = paths.iter().flat_map(|path| &path.points).filter(|point| point.kind == BeadKind::Bridge);
        assert!(bridges.count() > 100);
        for length in paths.into_iter().flat_map(runs_between) {
            assert!(length > 5.0 * size, "{length} mm of beads of {size}");
        }
    }
}

/// Only figures of areas are left out, and whether fitted beads cross is still known.
#[test]
fn without_coverage_the_paths_are_the_same() {
    let part = Part::new((0..4).map(|k| plate(12, k)));
    for infill in [InfillOptions::default(), InfillOptions { density: 0.2, skin: 1, ..InfillOptions::default() }] {
        let all = part.filled(infill);
        let options = PathOptions { bead: BEAD, infill, coverage: false, ..PathOptions::default() };
        let bare = fill_layers(&part.surfaces(), &options, &go_on).unwrap();
        for (all, bare) in all.layers.iter().flatten().zip(bare.layers.iter().flatten()) {
            assert_eq!((&all.paths, all.uniform), (&bare.paths, bare.uniform));
            let lengths = |of: &curvlay_toolpath::statistics::PathStatistics| {
                (of.path_mm, of.area_mm2, of.self_crossings, of.sharp_turns)
            };
            assert_eq!(lengths(&all.statistics), lengths(&bare.statistics));
        }
        let (totals, bare) = (all.totals(), bare.totals());
        assert!(totals.covered_fraction > 0.9 && totals.filled_fraction > 0.9);
        let areas = [bare.covered_fraction, bare.overlap_fraction, bare.unfillable_fraction, bare.max_gap_mm];
        assert!(areas.into_iter().all(|area| area <= 0.0), "{areas:?}");
        assert_eq!((totals.curves, totals.path_mm, totals.area_mm2), (bare.curves, bare.path_mm, bare.area_mm2));
    }
}

#[test]
fn first_skins_over_rows_are_bridges() {
    let part = Part::new((0..10).map(|k| plate(24, k)));
    let infill = InfillOptions { density: 0.2, walls: 2, skin: 2, ..InfillOptions::default() };
    let filled = part.filled(infill);
    let bridges = filled.bridges(&part.surfaces());
    // Of the first layer of the top all but what lies on rows, which are 2.5 mm apart and carry a good half millimetre, and on walls.
    let skin = filled.totals().skin_mm / 4.0;
    let share = bridges.length_mm / skin;
    assert!((0.6..0.9).contains(&share), "{share}");
    assert!(bridges.longest_mm > 1.5, "{bridges:?}");
    // Solid parts have none.
    let solid = part.filled(InfillOptions::default());
    assert_eq!(solid.bridges(&part.surfaces()), Bridges::default());
    // What goes over rows is named so, in the first layer of the top alone, and what carries it is not asked for.
    for layer in 0..10 {
        let points = filled.layers[layer].iter().flat_map(|layer| &layer.paths.paths).flat_map(|path| &path.points);
        assert_eq!(points.filter(|point| point.kind == BeadKind::Bridge).count() > 0, layer == 8);
    }
    // Kinds do not flicker: what lies between two others of one kind is longer than five beads, around the end of closed curves as well.
    let paths = filled.layers.iter().flatten().flat_map(|layer| &layer.paths.paths);
    assert!(paths.flat_map(runs_between).all(|length| length > 5.0 * BEAD));
    let plan = filled.plan(&part.surfaces(), &tip_1_mm(), &PrintOptions::default(), &go_on).unwrap();
    let support = check_support(&plan.resolved.paths, HEIGHT, &SupportOptions::default(), &go_on).unwrap();
    assert!(support.unsupported.is_empty(), "{:?}", support.unsupported);
}

#[test]
fn options_that_are_no_use_are_refused() {
    let part = Part::new([plate(6, 0)]);
    let refused = |infill: InfillOptions| {
        let options = PathOptions { bead: BEAD, infill, ..PathOptions::default() };
        fill_layers(&part.surfaces(), &options, &go_on).unwrap_err()
    };
    let infill = InfillOptions::default();
    let wrong: [(InfillOptions, &str, f64); 6] = [
        (InfillOptions { density: 1.01, ..infill }, "density", 1.01),
        (InfillOptions { density: -0.1, ..infill }, "density", -0.1),
        (InfillOptions { density: 0.5, walls: 20_000, ..infill }, "walls", 20_000.0),
        (InfillOptions { density: 0.5, skin: 20_000, ..infill }, "skin", 20_000.0),
        (InfillOptions { turn: f64::INFINITY, ..infill }, "turn", f64::INFINITY),
        (InfillOptions { overlap: 0.6, ..infill }, "overlap", 0.6),
    ];
    for (infill, name, given) in wrong {
        let FillLayersError::Layer { layer: 0, error: FillError::Paths(error) } = refused(infill) else {
            panic!("{name}: not refused as a path option");
        };
        assert!(
            matches!(error, PathError::Infill { option, value, .. } if option == name && value.total_cmp(&given).is_eq()),
            "{error}"
        );
    }
    let nan = refused(InfillOptions { density: f64::NAN, ..infill });
    assert!(nan.to_string().contains("density is NaN: it must be from 0 to 1"), "{nan}");
    // The columns of skins need a thickness.
    let mut thin = Part::new([plate(6, 0)]);
    thin.thickness[0][5] = 0.0;
    let options =
        PathOptions { bead: BEAD, infill: InfillOptions { density: 0.5, ..infill }, ..PathOptions::default() };
    let error = fill_layers(&thin.surfaces(), &options, &go_on).unwrap_err();
    assert_eq!(error, FillLayersError::Stack(StackError::BadSpacing { layer: 0, triangle: 5, spacing: 0.0 }));
}
