//! Surfaces and beads on them: meshes, distances, level sets, contours, fill, statistics, estimates.

use super::numbers::{bad, count, each_spoilt, fit, mesh, number, point, square};
use crate::common::go_on as go;
use curvlay_toolpath::deposit::DepositionOptions;
use curvlay_toolpath::estimate::{SampledPart, Samples, estimate_print};
use curvlay_toolpath::fill::*;
use curvlay_toolpath::geodesic::{Sources, SurfaceDistance};
use curvlay_toolpath::infill::SparseFill;
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::level_set::LevelField;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::path::*;
use curvlay_toolpath::statistics::*;
use curvlay_toolpath::travel::TravelOptions;
use proptest::prelude::*;

const PATHS: [fn(&mut PathOptions, f64); 10] = [
    |options, value| options.bead = value,
    |options, value| options.min_gap = value,
    |options, value| options.join_distance = value,
    |options, value| options.min_length = value,
    |options, value| options.min_width = value,
    |options, value| options.infill.density = value,
    |options, value| options.infill.turn = value,
    |options, value| options.infill.overlap = value,
    |options, value| (options.infill.density, options.infill.turn) = (0.3, value),
    |options, value| (options.infill.density, options.infill.overlap) = (0.3, value),
];
const STATISTICS: [fn(&mut StatisticsOptions, f64); 5] = [
    |options, value| options.samples_per_width = value,
    |options, value| options.sharp_turn = value,
    |options, value| options.min_width_mm = value,
    |options, value| options.width_range_mm[0] = value,
    |options, value| options.width_range_mm[1] = value,
];

/// Options with each field spoilt, and patterns.
pub fn path_options(value: f64, count: usize) -> Vec<PathOptions> {
    let sound = PathOptions { bead: 1.0, max_points: 1 << 16, ..PathOptions::default() };
    let walls = u32::try_from(count).unwrap_or(u32::MAX);
    let infill =
        InfillOptions { density: 0.4, walls, skin: walls, pattern: InfillPattern::Gyroid, ..InfillOptions::default() };
    let more = [
        PathOptions { pattern: Pattern::Rings, fitted: false, ..sound },
        PathOptions { pattern: Pattern::Zigzag, ..sound },
        PathOptions { max_points: count, ..sound },
        PathOptions { infill, ..sound },
    ];
    each_spoilt(&sound, &PATHS, value).into_iter().chain(more).collect()
}

fn feed_statistics(
    (vertices, triangles): (&[Point3<f64>], &[[u32; 3]]),
    paths: &[SurfacePath],
    numbers: [f64; 2],
    most: usize,
) {
    let lines: Vec<_> = paths.iter().map(SurfacePath::line).collect();
    let fine = StatisticsOptions { samples_per_width: 4.0, max_samples: 1 << 16, ..StatisticsOptions::default() };
    let all = each_spoilt(&fine, &STATISTICS, numbers[0])
        .into_iter()
        .chain([StatisticsOptions { max_samples: most.min(1 << 16), ..fine }]);
    for options in all {
        for widths in [None, Some(&numbers[..])] {
            let curve = |(points, own): &'_ (Vec<Point3<f64>>, Vec<f64>)| {
                (points.clone(), widths.map_or(own.clone(), <[f64]>::to_vec))
            };
            let given: Vec<_> = lines.iter().map(curve).collect();
            let curves: Vec<BeadCurve<'_>> =
                given.iter().map(|(points, widths)| BeadCurve { points, widths }).collect();
            let _ = path_statistics(vertices, triangles, &curves, &options, &go);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn meshes_take_anything(
        (points, triangles) in mesh(), edges in prop::collection::vec([0..6u32, 0..6u32], 0..3), vertices in prop::collection::vec(prop_oneof![9 => 0..4u32, 1 => Just(u32::MAX)], 0..3), barycentric in [number(), number(), number()],
        levels in prop::collection::vec(number(), 0..4), tolerance in number(), rise in number(), value in bad(), count in count(),
    ) {
        let Ok(mesh) = SurfaceMesh::new(points, triangles) else { return Ok(()) };
        prop_assert_eq!(mesh.regions().of_triangle.len(), mesh.triangles().len());
        prop_assert!(mesh.boundary_loops().iter().flatten().all(|&vertex| mesh.is_boundary_vertex(vertex)));
        for triangle in 0..mesh.triangles().len() as u32 {
            let _ = (mesh.neighbours(triangle), mesh.point(triangle, barycentric));
        }
        let sources = Sources { edges: &edges, vertices: &vertices };
        let found = [SurfaceDistance::to_boundary(&mesh, &go), SurfaceDistance::to(&mesh, sources, &go)];
        for distance in found.iter().flatten() {
            prop_assert_eq!(distance.mesh().vertices().len(), distance.at_vertices().len());
            let _ = (distance.windows(), distance.at_vertex(0), distance.at(0, barycentric), distance.at(0, [value, 0.0, 1.0]));
            for tolerance in [0.5, tolerance] {
                let Ok(field) = LevelField::new(distance, tolerance, &go) else { continue };
                prop_assert!(field.triangles() >= distance.mesh().triangles().len() && std::ptr::eq(field.distance(), distance));
                let _ = (field.pockets(rise), field.pockets(value));
                for levels in [&levels[..], &[0.5, 1.0], &[value]] {
                    if let Ok(sets) = field.level_sets(levels) {
                        prop_assert!(sets.rings.iter().all(|ring| ring.length() >= 0.0));
                    }
                }
                for options in path_options(value, count) {
                    let Ok(paths) = field.paths(&options, &go) else { continue };
                    prop_assert!(paths.paths.iter().all(|path| path.length() >= 0.0));
                    feed_statistics((mesh.vertices(), mesh.triangles()), &paths.paths, [value, rise], count);
                }
            }
        }
    }

    #[test]
    fn statistics_take_anything((vertices, triangles) in mesh(), points in prop::collection::vec(point(), 0..6), widths in prop::collection::vec(number(), 0..6), value in bad(), count in count()) {
        let curves = [BeadCurve { points: &points, widths: &widths }, BeadCurve { points: &points, widths: &vec![1.0; points.len()] }, BeadCurve { points: &points, widths: &fit(&widths, points.len()) }];
        let fine = StatisticsOptions { samples_per_width: 4.0, max_samples: 1 << 16, ..StatisticsOptions::default() };
        for options in each_spoilt(&fine, &STATISTICS, value).into_iter().chain([StatisticsOptions { max_samples: count.min(1 << 16), ..fine }]) {
            for curves in [&curves[..1], &curves[1..2], &curves[2..], &[]] {
                let _ = path_statistics(&vertices, &triangles, curves, &options, &go);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn fill_takes_anything(
        odd in mesh(), thickness in prop::collection::vec(number(), 0..4), value in bad(), count in count(), range in [0..4usize, 0..4usize], share in number(), layers_each in number(),
    ) {
        let sheets = [square(6.0, 0.8), square(6.0, 1.6)];
        let even = [0.8; 2];
        let sound = |k: usize| LayerSurface { vertices: &sheets[k].0, triangles: &sheets[k].1, thickness: &even, is_half: false };
        let own = fit(&[0.8], odd.1.len());
        let strange = [
            LayerSurface { vertices: &odd.0, triangles: &odd.1, thickness: &own, is_half: true }, LayerSurface { thickness: &thickness, ..sound(0) }, sound(1),
        ];
        let stacks: Vec<Vec<LayerSurface<'_>>> = strange.iter().map(|&surface| vec![sound(0), surface]).collect();
        strange.iter().for_each(|surface| assert_eq!(surface.top().len(), surface.vertices.len()));
        let options = path_options(value, count).into_iter().flat_map(|options| [options, options.for_support(share)]);
        // Each of the options with another stack: all with all would take a minute.
        for (options, surfaces) in options.zip(stacks.iter().cycle()) {
            let _ = (options.infill.is_solid(), estimate_fill(&strange, options.bead));
            let part = fill_layer(&surfaces[1], &options, &go).ok();
            let support = fill_layer(&surfaces[0], &options, &go).ok();
            if let Some(filled) = &part {
                filled.sparse.density();
            }
            let both = FilledLayer::with_support(part.clone(), support, &surfaces[0]);
            let mixed = fill_rest(surfaces, vec![both, part], &options, &go);
            let short = fill_rest(surfaces, vec![None], &options, &go);
            let [from, to] = range;
            let _ = fill_range(surfaces, from..to, &options, &go);
            for layers in [fill_layers(surfaces, &options, &go), mixed, short].into_iter().flatten() {
                let _ = (layers.totals(), layers.left_out(surfaces), layers.covered_mm3(surfaces), layers.curves_shorter_than(value), layers.bridges(surfaces));
                let _ = (layers.stack(surfaces).map(|stack| stack.triangles()), layers.stack(&surfaces[..1]).map(|stack| stack.triangles()));
                let _ = (layers.left_out(&[]), layers.covered_mm3(&surfaces[..1]), layers.bridges(&surfaces[..1]));
            }
            let parts = [SampledPart { surfaces, options, solid: (&odd.0, &odd.1) }];
            for samples in [Samples { parts: &parts, layers_each }, Samples { parts: &parts, layers_each: 1.0 }, Samples { parts: &[], layers_each: value }] {
                let found = estimate_print(&samples, &DepositionOptions::default(), &TravelOptions::default(), &go);
                found.map(|estimate| estimate.total_s()).ok();
            }
        }
        let _ = SparseFill { area_mm2: value, volume_mm3: share, curves: 0, infill_mm: 0.0, infill_mm3: value }.density();
        let kinds = [BeadKind::Wall, BeadKind::Infill, BeadKind::SupportBridge];
        prop_assert!(kinds.iter().all(|kind| !(kind.is_sparse() && kind.is_bridge()) || kind.is_support()));
    }
}
