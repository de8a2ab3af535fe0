//! What the properties of this folder found, each by itself.

use super::prints::{limits, options, print_of};
use super::robots::{Gantry, Shared, go};
use curvlay_trajectory::check::{CheckOptions, CheckedMotion, Contact, Moment, MotionKind, PrintSceneFn, check_motion};
use curvlay_trajectory::indicator::geometric::{
    Ball, BodiesFn, Cylinder, DistanceGrid, GeometricIndicator, GeometricModel, Twist,
};
use curvlay_trajectory::indicator::svm::SvmError;
use curvlay_trajectory::indicator::{
    CollisionIndicator, ContactFn, HardError, HardOptions, IndicatorFn, SamplesError, SamplingOptions, hard_samples,
    random_samples, training_set, verification_samples,
};
use curvlay_trajectory::nalgebra::{Isometry3, IsometryMatrix3, Point3, UnitVector3, Vector3};
use curvlay_trajectory::print::{OpenWorkcell, PrintError, Steered, Waypoint, plan_print};
use curvlay_trajectory::qp::{BandedQp, QpError, QpOptions};
use curvlay_trajectory::verify::dense_postures;
use curvlay_trajectory::{Bounds, FilterError, FilterOptions, FilterStatus, FreeRange, filter_locally};

#[test]
fn samples_beyond_memory_are_refused() {
    let space = ContactFn {
        collides: |q: &[f64; 2]| q[0] > 1.0,
        gap: |q: &[f64; 2]| q[1],
        sample: |random: &mut dyn FnMut() -> f64| Some([3.0 * random(), 0.0]),
    };
    let is_refused = |error: &SamplesError| matches!(error, SamplesError::Option { must: "at most 16,777,216", .. });
    for count in [(1 << 24) + 1, usize::MAX] {
        assert!(is_refused(&verification_samples(&space, count, 0.1, 1).unwrap_err()));
        assert!(is_refused(&random_samples(&space, &[0.0; 2], &[1.0; 2], count, 1).unwrap_err()));
        let options = SamplingOptions { initial: count, max_samples: count, ..SamplingOptions::default() };
        assert!(is_refused(&training_set(&space, &options).unwrap_err()));
        let train = |_: &[_]| {
            Err::<IndicatorFn<fn(&[f64; 2]) -> f64, fn(&[f64; 2]) -> (f64, [f64; 2])>, _>(SvmError::BiasShift(0.0))
        };
        for options in [
            HardOptions { initial: count, ..HardOptions::default() },
            HardOptions { pool: count, ..HardOptions::default() },
        ] {
            let Err(HardError::Samples(error)) = hard_samples(&space, &options, &train) else { panic!("drawn") };
            assert!(is_refused(&error));
        }
        let many_rounds = HardOptions { initial: 3, rounds: count, ..HardOptions::default() };
        assert!(matches!(hard_samples(&space, &many_rounds, &train), Err(HardError::Training { round: 0, .. })));
    }
}

#[test]
fn a_surface_out_of_reach_shows_however_many_samples_are_wanted() {
    let nowhere = ContactFn {
        collides: |_: &[f64; 2]| false,
        gap: |q: &[f64; 2]| q[1],
        sample: |_: &mut dyn FnMut() -> f64| None,
    };
    let found = verification_samples::<2>(&nowhere, 1 << 24, 0.1, 1);
    assert_eq!(found, Err(SamplesError::OutOfReach { found: 0, wanted: 1 << 24, attempts: 200_000 }));
}

#[test]
fn dense_postures_of_endless_ranges_are_none_or_a_million() {
    for (from, to, count) in [
        (f64::NEG_INFINITY, f64::INFINITY, 0),
        (-1e308, 1e308, 0),
        (f64::NAN, 1.0, 0),
        (0.0, 1e12, 1_000_001),
        (0.0, 0.0, 2),
    ] {
        let robot = Shared { range: FreeRange::Within(from, to), ..Shared::sound(1) };
        assert_eq!(dense_postures(&robot, 0, &[0.0; 2], &Bounds::NONE).len(), count, "{from} {to}");
    }
}

#[test]
fn the_local_filter_has_no_window_beyond_the_path() {
    let robot = Shared::sound(9);
    let times: Vec<f64> = (0..9).map(|k| 0.2 * f64::from(k)).collect();
    let bounds = Bounds { jerk: [1e-9; 2], ..Bounds::NONE };
    let widest = FilterOptions { gain: 1e9, max_margin: usize::MAX, ..FilterOptions::default() };
    for options in [
        FilterOptions { growth: 1, ..widest },
        FilterOptions { growth: usize::MAX, ..widest },
        FilterOptions { margin: usize::MAX, ..widest },
    ] {
        let filtered = filter_locally(&robot, &times, &robot.nodes(0.1), &bounds, &options, &go).unwrap();
        assert_eq!((filtered.status, filtered.successes), (FilterStatus::Locked, 0));
    }
}

#[test]
fn ranges_without_values_are_refused() {
    let times: Vec<f64> = (0..9).map(|k| 0.2 * f64::from(k)).collect();
    let waypoints: Vec<Waypoint> =
        (0..9).map(|k| Waypoint { position: Point3::new(f64::from(k), 0.0, 0.0), axis: Vector3::z_axis() }).collect();
    for (from, to) in [(1.0, -1.0), (f64::NAN, 1.0), (0.0, f64::NAN), (-1e308, 1e308)] {
        let robot = Shared { range: FreeRange::Within(from, to), ..Shared::sound(9) };
        let filtered = filter_locally(&robot, &times, &robot.nodes(0.0), &Bounds::NONE, &FilterOptions::default(), &go);
        assert!(matches!(filtered, Err(FilterError::Range { parameter: 0, .. })), "{from} {to}");
        let robot = Gantry { range: FreeRange::Within(from, to), ..Gantry::SOUND };
        let planned =
            plan_print(&robot, OpenWorkcell, &print_of(&[(&waypoints, 0)], &times), &limits(), &options(), &go);
        assert!(matches!(planned, Err(PrintError::Field { field: "free", .. })), "{from} {to}");
    }
    let steered = Steered { robot: &Gantry::SOUND, heading: |_: &Waypoint| 0.0, slack: -1.0 };
    let planned = plan_print(&steered, OpenWorkcell, &print_of(&[(&waypoints, 0)], &times), &limits(), &options(), &go);
    assert!(matches!(planned, Err(PrintError::Field { field: "free", .. })));
}

/// Two lines, one above the other.
fn lines() -> [Vec<Waypoint>; 2] {
    let at = |k: u32, z: f64| Waypoint { position: Point3::new(f64::from(k), 0.0, z), axis: Vector3::z_axis() };
    [1.0, 2.0].map(|z| (0..9).map(|k| at(k, z)).collect())
}

#[test]
fn programs_end_whatever_is_asked_of_them() {
    let mut qp = BandedQp::new(&[1, 1, 1], 0);
    qp.add_square(&[(0, -1.0), (1, 1.0)], 0.1, 1.0);
    qp.add_square(&[(1, -1.0), (2, 0.3)], 0.7, 3.0);
    qp.add_row(&[(2, 0.7), (1, 0.1)], 3.3, f64::INFINITY);
    qp.add_soft_row(&[(1, -1.1), (2, 1.3)], f64::NEG_INFINITY, 1.7, 2.0);
    for tolerance in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        let options = QpOptions { tolerance, iterations: usize::MAX };
        assert_eq!(qp.solve(&options, None), Err(QpError::Tolerance), "{tolerance}");
    }
    for tolerance in [5e-324, 1e-300] {
        let found = qp.solve(&QpOptions { tolerance, iterations: usize::MAX }, None).unwrap();
        assert!(found.iterations < 10_000 && found.primal_residual < 1e-6, "{} {tolerance}", found.iterations);
    }
}

#[test]
fn the_last_layer_has_a_name() {
    let lines = lines();
    let times: Vec<f64> = (0..9).map(|k| 0.1 * f64::from(k)).collect();
    let paths = print_of(&[(&lines[0], 0), (&lines[1], u32::MAX)], &times);
    let plan = plan_print(&Gantry::SOUND, OpenWorkcell, &paths, &limits(), &options(), &go).unwrap();
    assert_eq!((plan.runs.len(), plan.travels.iter().flatten().count()), (2, 1));
    let fault = curvlay_trajectory::print::Fault {
        layer: u32::MAX,
        path: 1,
        kind: curvlay_trajectory::print::FaultKind::Break,
        waypoint: 0,
        what: String::new(),
    };
    assert_eq!(fault.to_string(), "layer 4294967296, path 1, waypoint 0: break");
}

#[test]
fn lists_of_a_plan_that_do_not_fit_count_as_far_as_they_go() {
    let lines = lines();
    let times: Vec<f64> = (0..9).map(|k| 0.1 * f64::from(k)).collect();
    let paths = print_of(&[(&lines[0], 0), (&lines[1], 1)], &times);
    let mut plan = plan_print(&Gantry::SOUND, OpenWorkcell, &paths, &limits(), &options(), &go).unwrap();
    let steps = plan.steps();
    plan.runs[0].passes.push((usize::MAX, Some(usize::MAX)));
    assert_eq!(plan.steps(), steps);
    plan.runs[0].filament_mm.truncate(1);
    let (laid, end) = (plan.runs[0].filament_mm[0], plan.runs[0].duration());
    assert!(plan.segments(0..1).next().unwrap().filament_mm(end).total_cmp(&laid).is_eq());
    plan.travels.clear();
    let (limits, options) = (limits(), options());
    assert!(plan.home_above(&Gantry::SOUND, OpenWorkcell, &limits, &options, &go).unwrap().is_some());
    assert_eq!(plan.without(&[].into()).runs.len(), 2);
}

#[test]
fn a_piece_has_a_few_million_samples_at_most() {
    let scene = PrintSceneFn {
        nozzle: |q: &[f64; 1]| Some(Isometry3::translation(q[0], 0.0, 0.0)),
        contact: |_: &Moment, _: &Point3<f64>, _: &UnitVector3<f64>| None::<Contact>,
        sweep: |_: usize, _: usize, _: &[[f64; 1]; 4]| None,
    };
    // A joint that goes so far is cut into a million parts from the start.
    let motion = CheckedMotion {
        kind: MotionKind::Travel,
        times: &[0.0, 1.0],
        joints: &[[0.0], [1e9]],
        path: &[],
        printing: None,
        apart: false,
    };
    let options = CheckOptions { sample_mm: 1e-300, ..CheckOptions::default() };
    let report = check_motion(0, &motion, &Bounds::NONE, &scene, &options).unwrap();
    assert!((1_000_000..4_000_000).contains(&report.samples), "{}", report.samples);
}

#[test]
fn cylinders_at_places_that_are_not_finite_have_no_distance() {
    let bodies = BodiesFn {
        carriers: vec![[false], [true]],
        place: |q: &[f64; 1], frames: &mut [IsometryMatrix3<f64>]| {
            frames[1] = IsometryMatrix3::rotation(Vector3::z() * q[0]);
        },
        twists: |_: &[f64; 1], _: &[IsometryMatrix3<f64>]| [Twist::turning(&Point3::origin(), &Vector3::z())],
    };
    let model = GeometricModel {
        grids: vec![(0, DistanceGrid::from_cells([2; 3], &[3; 4], 1.0, &Point3::origin(), 2).unwrap())],
        balls: vec![Ball { body: 1, center: Point3::new(5.0, 0.0, 0.0), radius: 1.0 }],
        cylinders: vec![Cylinder {
            body: 1,
            from: Point3::new(0.0, 9.0, 0.0),
            to: Point3::new(0.0, 12.0, 0.0),
            radius: 1.0,
        }],
        capsules: vec![],
        planes: vec![],
        ignored: vec![],
        margin: 1.0,
    };
    let indicator = GeometricIndicator::new(bodies, model).unwrap();
    for angle in [f64::NAN, f64::INFINITY] {
        assert!(indicator.nearest(&[angle]).distance.is_nan() && indicator.predicts(&[angle]));
        assert!(indicator.gradient(&[angle]).0.is_nan());
    }
}
