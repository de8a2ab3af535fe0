//! Tapes and conductors: stresses, directions, lines, tapes, their heads, lay-ups.

use super::numbers::{Mesh, bad, count, each_spoilt, mesh, number, point, square, unit, vector};
use super::stacks::paths;
use crate::common::go_on as go;
use curvlay_toolpath::fiber::bedding::*;
use curvlay_toolpath::fiber::conductor::{ConductorOptions, conductor};
use curvlay_toolpath::fiber::direction::DirectionField;
use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead, with_tapes};
use curvlay_toolpath::fiber::lines::CentreLine;
use curvlay_toolpath::fiber::measure::angle_to_principal;
use curvlay_toolpath::fiber::offsets::offset_lines;
use curvlay_toolpath::fiber::sandwich::{SandwichLayer, SandwichOptions, raise, sandwich, sandwich_on};
use curvlay_toolpath::fiber::stiffness::*;
use curvlay_toolpath::fiber::stress::{LayerStress, StressOptions, StressSample};
use curvlay_toolpath::fiber::stress_files::*;
use curvlay_toolpath::fiber::stripes::stripes;
use curvlay_toolpath::fiber::tapes::{Tape, TapeOptions, lay_tapes, lay_tapes_along, plan_tapes};
use curvlay_toolpath::gcode::{Mark, Move, Tool};
use curvlay_toolpath::mesh::{SurfaceMesh, SurfacePoint};
use curvlay_toolpath::nalgebra::{Matrix3, Point3, Vector3};
use curvlay_toolpath::support::SupportOptions;
use proptest::prelude::*;

const TAPE: [fn(&mut TapeOptions, f64); 7] = [
    |options, value| options.width = value,
    |options, value| options.thickness = value,
    |options, value| options.spacing = value,
    |options, value| options.min_radius = value,
    |options, value| options.min_length = value,
    |options, value| options.max_overlap = value,
    |options, value| options.gap = value,
];
const HEAD: [fn(&mut TapeHead, f64); 6] = [
    |head, value| head.blade = value,
    |head, value| head.force_n = value,
    |head, value| head.celsius = value,
    |head, value| head.lay_feed = value,
    |head, value| head.travel_feed = value,
    |head, value| head.hop = value,
];
const CONDUCTOR: [fn(&mut ConductorOptions, f64); 4] = [
    |options, value| options.width = value,
    |options, value| options.thickness = value,
    |options, value| options.step = value,
    |options, value| options.reach = value,
];

/// A sheet of squares: `n` by `n`, a millimetre each.
fn sheet(n: u32) -> Mesh {
    let at = |i: u32, j: u32| i + (n + 1) * j;
    let points = (0..=n).flat_map(|j| (0..=n).map(move |i| Point3::new(f64::from(i), f64::from(j), 0.8))).collect();
    let cells = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    let triangles = cells
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
    (points, triangles.collect())
}

fn tape() -> impl Strategy<Value = Tape> {
    let points = (prop::collection::vec(point(), 0..5), prop::collection::vec(unit(), 0..5), any::<bool>());
    (points, 0..6usize, bad()).prop_map(|((points, normals, fits), kind, value)| {
        let normals = if fits { vec![Vector3::z_axis(); points.len()] } else { normals };
        let mut tape = Tape { points, normals, width: 1.0, thickness: 0.1 };
        match kind {
            0 => tape.width = value,
            1 => tape.thickness = value,
            2 => {
                (tape.points, tape.normals) =
                    ((0..9).map(|k| Point3::new(f64::from(k), 2.0, 1.0)).collect(), vec![Vector3::z_axis(); 9])
            }
            _ => {}
        }
        tape
    })
}

fn layers() -> impl Strategy<Value = Vec<LayerTapes>> {
    let tool = prop::sample::select(vec![Tool::Roller, Tool::Conductor, Tool::Nozzle]);
    let layer = (prop_oneof![6 => 0..4u32, 1 => Just(u32::MAX)], tool, number(), prop::collection::vec(tape(), 0..3));
    prop::collection::vec(layer.prop_map(|(layer, tool, lift, tapes)| LayerTapes { layer, tool, lift, tapes }), 0..3)
}

fn samples() -> impl Strategy<Value = Vec<StressSample>> {
    let sample = (point(), prop::array::uniform6(number()), any::<bool>()).prop_map(|(point, s, spoilt)| {
        let skew = if spoilt { s[0] } else { s[3] };
        StressSample { point, stress: Matrix3::new(s[0], s[3], s[5], skew, s[1], s[4], s[5], s[4], s[2]) }
    });
    prop::collection::vec(sample, 0..6)
}

/// Pulled along x all over the sheet.
fn pulled() -> Vec<StressSample> {
    let stress = Matrix3::from_diagonal(&Vector3::new(10.0, 1.0, 0.0));
    sheet(6).0.into_iter().map(|point| StressSample { point, stress }).collect()
}

fn feed_field(field: DirectionField<'_>, value: f64, count: usize) {
    let barycentric = [value, 0.0, 1.0];
    assert_eq!(field.directions().len(), field.mesh().vertices().len());
    let _ = (field.at(0, barycentric), field.at(0, [1.0; 3]), field.singularities());
    let sound = TapeOptions { width: 1.0, spacing: 1.5, min_radius: 1.0, min_length: 2.0, ..TapeOptions::default() };
    for spacing in [1.0, value] {
        let _ = stripes(&field, spacing, &go);
    }
    for options in each_spoilt(&sound, &TAPE, value) {
        if let Ok(plan) = lay_tapes(&field, &options, &go) {
            assert!(plan.tape_mm() >= 0.0 && plan.cuts() <= plan.tapes.len().max(count));
        }
    }
    let _ = field.smoothed(value).map(|field| field.directions().len());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn directions_and_tapes_take_anything(
        odd in mesh(), given in samples(), value in bad(), direction in vector(), guide in prop::collection::vec(point(), 0..5), reach in number(), share in number(), lines in prop::collection::vec((prop::collection::vec((prop_oneof![6 => 0..9u32, 1 => Just(u32::MAX)], [number(), number(), number()], point()), 0..4), any::<bool>()), 0..3), count in count(),
    ) {
        let middle = [Point3::new(0.5, 3.0, 0.8), Point3::new(5.5, 3.2, 0.8)].to_vec();
        let sound = TapeOptions { width: 1.0, spacing: 1.5, min_radius: 1.0, min_length: 2.0, ..TapeOptions::default() };
        let meshes: Vec<SurfaceMesh> = [sheet(6), odd].into_iter().filter_map(|(points, triangles)| SurfaceMesh::new(points, triangles).ok()).collect();
        let point = |&(triangle, barycentric, position): &(u32, [f64; 3], Point3<f64>)| SurfacePoint { triangle, barycentric, position };
        let centres: Vec<CentreLine> = lines.iter().map(|(points, closed)| CentreLine { points: points.iter().map(point).collect(), closed: *closed }).collect();
        for mesh in &meshes {
            for stress in [pulled(), given.clone()] {
                for reach in [9.0, reach, value] {
                    let Ok(stress) = LayerStress::new(mesh, &stress, StressOptions { reach }) else { continue };
                    prop_assert!(std::ptr::eq(stress.mesh(), mesh) && stress.tensors().len() == stress.principal().len());
                    let principal = stress.at(0, [value, 0.5, 0.5]);
                    principal.distinctness();
                    for smoothing in [0.0, value] {
                        let Ok(field) = DirectionField::from_stress(&stress, smoothing) else { continue };
                        if let Ok(plan) = lay_tapes(&field, &sound, &go) {
                            let _ = (angle_to_principal(&stress, &plan.tapes, share), angle_to_principal(&stress, &plan.tapes, value));
                        }
                        feed_field(field, value, count);
                    }
                }
            }
            for direction in [Vector3::x(), direction] {
                if let Ok(field) = DirectionField::from_fn(mesh, |at| direction + Vector3::y() * (0.01 * at.x)) {
                    feed_field(field, value, count);
                }
            }
            for (guides, reach) in [(vec![middle.clone()], 1.0), (vec![guide.clone()], reach), (vec![middle.clone(), guide.clone()], value), (vec![], 1.0)] {
                let _ = DirectionField::from_guides(mesh, &guides, reach).map(|field| feed_field(field, value, count));
                for spacing in [1.0, value] {
                    let _ = offset_lines(mesh, &guides, spacing, reach, &go);
                }
                for options in each_spoilt(&sound, &TAPE, value) {
                    let _ = (lay_tapes_along(mesh, &guides, &options, &go), plan_tapes(mesh, &centres, &options, &go));
                }
            }
            centres.iter().for_each(|line| assert!(line.length().is_nan() || line.length() >= 0.0));
            for polyline in [&middle, &guide] {
                for options in each_spoilt(&ConductorOptions::default(), &CONDUCTOR, value) {
                    let _ = conductor(mesh, polyline, &options).map(|tape| tape.length());
                }
            }
        }
    }

    #[test]
    fn heads_and_beds_take_anything(given in layers(), mut paths in paths(), value in bad(), height in number(), sizes in [number(), number()], schedule in prop::collection::vec((any::<bool>(), number()), 0..4), layer in 0..4u32, solid in mesh(), marks in prop::collection::vec((0..5u32, number()), 0..4)) {
        for head in each_spoilt(&TapeHead::default(), &HEAD, value) {
            for layer in &given {
                let _ = head.moves(layer);
            }
            let moves = marks.iter().map(|&(number, z_mm)| Move::Mark(Mark::Layer { number, z_mm, height_mm: value }));
            if let Ok(moves) = with_tapes(moves.chain([Move::Home, Move::Dwell { seconds: value }]), &given, &head) {
                moves.for_each(drop);
            }
        }
        let [diameter, width] = sizes;
        for roller in [Roller { diameter: 20.0, width: 6.0 }, Roller { diameter, width }, Roller { diameter: value, width: 6.0 }] {
            for (height, options) in [(0.8, SupportOptions::default()), (height, SupportOptions::default()), (0.8, SupportOptions { max_distance: value, ..SupportOptions::default() })] {
                if let Ok(bed) = tape_bedding(&paths, &given, height, &roller, &options, &go) {
                    let _ = (bed.on_nothing_share(), bed.uncovered_share(), bed.bead_on_nothing_share());
                }
            }
        }
        for (points, triangles) in [square(6.0, 0.8), solid] {
            for height in [0.8, height, value] {
                bedded_surface(&points, &triangles, layer, &paths, height);
            }
        }
        let schedule: Vec<SandwichLayer> = schedule.into_iter().map(|(carries_tape, raised)| SandwichLayer { carries_tape, raised }).collect();
        let _ = raise(&mut paths, &schedule);
    }

    #[test]
    fn lay_ups_take_anything(
        layers in prop::sample::select(vec![0, 1, 9]), counts in prop::array::uniform3(prop::sample::select(vec![0, 1, 3, u32::MAX])), value in bad(), offset in number(), carrying in prop::collection::vec(prop_oneof![6 => 0..9u32, 1 => Just(u32::MAX)], 0..4), tapes in prop::collection::vec((number(), number()), 0..4),
        pieces in prop::collection::vec((number(), number()), 0..4), numbers in [number(), number(), number()],
    ) {
        let [base, every, cover] = counts;
        for offset in [0.1, offset, value] {
            let _ = (sandwich(layers, &SandwichOptions { base, every, cover, offset }), sandwich_on(layers, &carrying, offset));
        }
        let fields: [fn(&mut LayUp, f64); 4] = [
            |lay_up, value| lay_up.width_mm = value, |lay_up, value| lay_up.height_mm = value, |lay_up, value| lay_up.matrix_gpa = value, |lay_up, value| lay_up.fiber_gpa = value,
        ];
        let given: Vec<TapeInSection> = tapes.into_iter().map(|(at_mm, fiber_mm2)| TapeInSection { at_mm, fiber_mm2 }).collect();
        let sound = LayUp { width_mm: 10.0, height_mm: 4.0, matrix_gpa: 3.0, fiber_gpa: 200.0, tapes: vec![TapeInSection { at_mm: 1.0, fiber_mm2: 0.2 }] };
        for lay_up in each_spoilt(&sound, &fields, value).into_iter().chain([LayUp { tapes: given, ..sound.clone() }]) {
            let _ = (lay_up.fiber_fraction(), lay_up.modulus_gpa(), lay_up.neutral_mm(), lay_up.rigidity_nm2());
        }
        let [a, b, c] = numbers;
        let _ = (three_point_rigidity_nm2(a, b, c), three_point_rigidity_nm2(value, 1.0, 1.0));
        for pieces in [&pieces[..], &[(0.5, 1.0), (1.0, 2.0)], &[(value, 1.0)], &[(1.0, value)]] {
            let _ = (arch_stiffness_n_mm(a, b, pieces), arch_stiffness_n_mm(50.0, 1.0, pieces), arch_stiffness_n_mm(value, 1.0, pieces));
        }
    }

    #[test]
    fn files_take_anything(text in "[0-9a-zA-Z ,.\n-]{0,120}", any in prop::collection::vec(any::<u8>(), 0..90), samples in samples(), cut in 0..300usize, name in prop::option::of("[a-z]{0,5}")) {
        let mut written = Vec::new();
        write_stress_csv(&samples, &mut written).unwrap();
        let half = written[..cut.min(written.len())].to_vec();
        for text in [text.into_bytes(), any, written, half] {
            let _ = (read_stress_csv(&text[..]), read_stress_frd(&text[..]), read_stress_vtk(&text[..], name.as_deref()));
        }
    }
}
