//! Random machines: what the inverse finds, the forward kinematics confirm; what it does not find, is not there.

use super::models::{linear, rotary};
use curvlay_kinematics::machine::{AxisMount, FiveAxis, MachineKind, MachineModel, ToolModel, Unreachable, VERSION};
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use proptest::prelude::*;
use std::f64::consts::TAU;

fn vector() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-1.0..1.0f64)
}

/// Any skew machine of three linear axes.
fn any_machine() -> impl Strategy<Value = FiveAxis> {
    let lines = prop::array::uniform3(vector());
    let axes = prop::array::uniform2(vector());
    let points = prop::array::uniform3(prop::array::uniform3(-50.0..50.0f64));
    let ranges = (-400.0..0.0f64, 1.0..500.0f64, -200.0..0.0f64, 1.0..250.0f64);
    (lines, axes, points, vector(), ranges, 0..3u8, prop::array::uniform2(-200.0..200.0f64), any::<bool>())
        .prop_filter_map("no machine", |(lines, axes, points, nozzle, (a, b, c, d), kind, zeros, tcp)| {
            let mounts = [
                if kind == 0 || kind == 1 { AxisMount::Table } else { AxisMount::Head },
                if kind == 0 { AxisMount::Table } else { AxisMount::Head },
            ];
            let ranges = [if b > 400.0 { None } else { Some([a, a + b]) }, Some([c, c + d])];
            let rotaries = [0, 1].map(|k: usize| {
                let mut axis = rotary(['C', 'A'][k], mounts[k], axes[k], ranges[k]);
                axis.point_mm = Some(points[k]);
                axis.zero_deg = zeros[k];
                axis
            });
            let mut linears = vec![linear('X', lines[0]), linear('Y', lines[1]), linear('Z', lines[2])];
            linears.iter_mut().for_each(|axis| axis.range_mm = [-1e5, 1e5]);
            FiveAxis::new(MachineModel {
                version: VERSION,
                name: "random".into(),
                source: None,
                dialect: None,
                tcp,
                linear: linears,
                rotary: rotaries.into(),
                nozzle: ToolModel { direction: nozzle, tip_mm: Some(points[2]) },
                part_origin_mm: points[0],
            })
            .ok()
            // Nearly dependent linear axes move by metres for a millimetre, and rounding with them.
            .filter(|machine| condition(machine.model()) > 0.05)
        })
}

fn condition(model: &MachineModel) -> f64 {
    let columns: Vec<_> = model.linear.iter().map(|axis| Vector3::from(axis.direction).normalize()).collect();
    columns[0].cross(&columns[1]).dot(&columns[2]).abs()
}

/// Readings with the rotary axes in their ranges, or nearly at the pole where the second axis allows it.
fn check(machine: &FiveAxis, tip: [f64; 3], shares: [f64; 2], near: [f64; 2]) -> Result<(), TestCaseError> {
    let ranges = machine.ranges();
    let first = machine.linear_count();
    let reading = |k: usize| {
        let [min, max] = ranges[first + k];
        if min.is_finite() { min + shares[k] * (max - min) } else { TAU * (shares[k] - 0.5) }
    };
    let mut axes = [0.0; 5];
    (axes[first], axes[first + 1]) = (reading(0), reading(1));
    let (_, direction) = machine.forward(&axes);
    let (mut found, mut has_it) = (0, false);
    let mut from = machine.start();
    (from[first], from[first + 1]) = (near[0], near[1]);
    for solution in machine.inverse(&tip.into(), &direction, &from) {
        let (there, turned) = machine.forward(&solution.axes);
        // What is off in direction is a rounding, or an end to which a reading was moved by 1e-9.
        prop_assert!((there - Point3::from(tip)).norm() < 1e-9, "{solution:?}");
        prop_assert!((turned.into_inner() - direction.into_inner()).norm() < 5e-9 + solution.missed, "{solution:?}");
        let joints = machine.joints(&solution.axes);
        for (value, [min, max]) in joints.into_iter().zip(ranges) {
            prop_assert!(value >= min - 1e-8 && value <= max + 1e-8, "{solution:?}");
        }
        for k in [first, first + 1] {
            prop_assert!(solution.axes[k] >= ranges[k][0] && solution.axes[k] <= ranges[k][1], "{solution:?}");
        }
        let same = |a: f64, b: f64| (a - b - TAU * ((a - b) / TAU).round()).abs() < 1e-5;
        has_it |= same(solution.axes[first], axes[first]) && same(solution.axes[first + 1], axes[first + 1]);
        found += 1;
    }
    prop_assert!(found > 0 && machine.unreachable(&tip.into(), &direction).is_none());
    // Next to the pole the turn is another one.
    let axis = Vector3::from(machine.model().rotary[0].axis).normalize();
    prop_assert!(has_it || axis.cross(&direction).norm() < 1e-5, "{axes:?}");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(815), ..ProptestConfig::with_cases(512) })]
    #[test]
    fn inverse_and_forward_agree(
        machine in any_machine(),
        tip in prop::array::uniform3(-200.0..200.0f64),
        shares in prop::array::uniform2(0.0..1.0f64),
        near in prop::array::uniform2(-20.0..20.0f64),
    ) {
        check(&machine, tip, shares, near)?;
        // At the ends of the ranges.
        check(&machine, tip, shares.map(f64::round), near)?;
    }

    /// Directions at distances of 1e-16 to 1 from the first axis, with the second one at right angles to it and to the nozzle.
    #[test]
    fn poles_lose_nothing(
        tip in prop::array::uniform3(-200.0..200.0f64),
        azimuth in 0.0..TAU,
        exponent in -17.0..0.0f64,
        down in any::<bool>(),
        tilts in 0..3usize,
    ) {
        let mounts = [[AxisMount::Table; 2], [AxisMount::Table, AxisMount::Head], [AxisMount::Head; 2]][tilts];
        let mut model = super::models::model(MachineKind::HeadHead);
        model.rotary[0].mount = mounts[0];
        model.rotary[1].mount = mounts[1];
        model.rotary[1].range_deg = Some([-200.0, 200.0]);
        let machine = FiveAxis::new(model).unwrap();
        let tilt = 10f64.powf(exponent);
        let up = if down { -tilt.cos() } else { tilt.cos() };
        let direction = UnitVector3::new_normalize(Vector3::new(tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), up));
        let mut found = 0;
        for solution in machine.inverse(&tip.into(), &direction, &machine.start()) {
            let (there, turned) = machine.forward(&solution.axes);
            prop_assert!((there - Point3::from(tip)).norm() < 1e-9, "{solution:?}");
            // On the axis itself, below 1e-9, the turn stays.
            prop_assert!((turned.into_inner() - direction.into_inner()).norm() < 2e-9, "{solution:?}");
            if tilt > 2e-9 {
                prop_assert!((turned.into_inner() - direction.into_inner()).norm() < 1e-14, "{solution:?}");
            }
            found += 1;
        }
        prop_assert!(found >= 1);
    }

    /// Where the inverse finds nothing, no sampled readings come near.
    #[test]
    fn what_is_not_found_is_not_there(machine in any_machine(), direction in vector()) {
        let direction = UnitVector3::new_normalize(Vector3::from(direction) + Vector3::new(0.0, 0.0, 1e-3));
        let first = machine.linear_count();
        let why = machine.unreachable(&Point3::origin(), &direction);
        prop_assert_eq!(why.is_none(), machine.inverse(&Point3::origin(), &direction, &machine.start()).next().is_some());
        let ranges = machine.ranges();
        // The nearest direction of some thousand readings within the ranges.
        let sampled = |range: [f64; 2], k: usize| {
            let [min, max] = if range[0].is_finite() { range } else { [0.0, TAU] };
            min + (max - min) * k as f64 / 100.0
        };
        let mut nearest = f64::INFINITY;
        for (a, b) in (0..=100).flat_map(|a| (0..=100).map(move |b| (a, b))) {
            let mut axes = [0.0; 5];
            (axes[first], axes[first + 1]) = (sampled(ranges[first], a), sampled(ranges[first + 1], b));
            let (_, there) = machine.forward(&axes);
            nearest = nearest.min(there.dot(&direction).clamp(-1.0, 1.0).acos());
        }
        match why {
            None => prop_assert!(nearest < 0.08, "{nearest}"),
            // The band of directions that are reached is a distance away.
            Some(Unreachable::Direction { beyond }) => prop_assert!(nearest > beyond - 1e-6, "{nearest} {beyond}"),
            Some(Unreachable::Rotary { beyond, value, range, .. }) => {
                prop_assert!(beyond > 0.0 && ((value - range[0]).abs() - beyond).abs().min(((value - range[1]).abs() - beyond).abs()) < 1e-9);
                prop_assert!(nearest > 0.0);
            }
            Some(other) => prop_assert!(false, "{other}"),
        }
    }
}

/// A polar machine whose nozzle does not pass the axis of the table.
#[test]
fn a_polar_machine_says_how_near_it_gets() {
    let mut model = super::models::model(MachineKind::PolarHead);
    model.rotary[1].point_mm = Some([0.0, 2.0, 50.0]);
    let machine = FiveAxis::new(model).unwrap();
    let up = Vector3::z_axis();
    let why = machine.unreachable(&Point3::new(0.0, 1.5, 0.0), &up);
    assert!(matches!(why, Some(Unreachable::Place { short_mm }) if (short_mm - 0.5).abs() < 1e-9), "{why:?}");
    for tip in [Point3::new(2.0, 0.0, 5.0), Point3::new(-30.0, 40.0, 1.0)] {
        assert!(machine.inverse(&tip, &up, &machine.start()).count() >= 1);
        for solution in machine.inverse(&tip, &up, &machine.start()) {
            assert!((machine.forward(&solution.axes).0 - tip).norm() < 1e-9);
        }
    }
    // A direction across the plane of the arm is not followed at all, one in it wholly.
    let machine = super::models::machine(MachineKind::PolarHead);
    let tip = Point3::new(50.0, 0.0, 10.0);
    let lean = |y: f64, x: f64| UnitVector3::new_normalize(Vector3::new(x, y, 1.0));
    for solution in machine.inverse(&tip, &lean(0.0, 0.5), &machine.start()) {
        assert!(solution.missed < 1e-12);
    }
    for solution in machine.inverse(&tip, &lean(0.5, 0.0), &machine.start()) {
        assert!((solution.missed - 0.5f64.atan()).abs() < 1e-12);
    }
}

/// The message says how far, and what would help.
#[test]
fn what_is_out_of_reach_is_said_with_degrees() {
    let machine = super::models::machine(MachineKind::HeadHead);
    let low = UnitVector3::new_normalize(Vector3::new(0.0, -(120f64.to_radians()).sin(), 120f64.to_radians().cos()));
    let said = machine.unreachable(&Point3::origin(), &low).unwrap().to_string();
    assert!(
        said.starts_with("A would be at ")
            && said.contains("120.00 degrees, 10.00 beyond its range of -110.00 to 110.00: tilt"),
        "{said}"
    );
    let far = machine.unreachable(&Point3::new(600.0, 0.0, 0.0), &Vector3::z_axis()).unwrap();
    assert!(
        matches!(far, Unreachable::Linear { letter: 'X', beyond_mm, .. } if (beyond_mm - 106.0).abs() < 1e-9),
        "{far}"
    );
    let nowhere = machine.unreachable(&Point3::new(f64::NAN, 0.0, 0.0), &Vector3::z_axis());
    assert_eq!(nowhere, Some(Unreachable::NotFinite));
}

/// Of a whole part the worst place is named, wherever it comes.
#[test]
fn the_worst_place_of_a_part_is_named() {
    let machine = super::models::machine(MachineKind::HeadHead);
    let place = |degrees: f64, x: f64| {
        let angle = degrees.to_radians();
        (Point3::new(x, 0.0, 0.0), UnitVector3::new_normalize(Vector3::new(0.0, -angle.sin(), angle.cos())))
    };
    let places = [place(0.0, 0.0), place(115.0, 0.0), place(0.0, 900.0), place(130.0, 3.0), place(120.0, 0.0)];
    let reach = machine.reach(places);
    assert_eq!((reach.places, reach.unreachable), (5, 4));
    let worst = reach.worst.unwrap();
    assert_eq!((worst.index, worst.tip), (3, Point3::new(3.0, 0.0, 0.0)));
    assert!(matches!(worst.reason, Unreachable::Rotary { beyond, .. } if (beyond - 20f64.to_radians()).abs() < 1e-9));
    let far = machine.reach([place(0.0, 700.0), place(0.0, 900.0), place(0.0, 800.0)]);
    assert_eq!(far.worst.map(|worst| worst.index), Some(1));
    let all = machine.reach(places[..1].iter().copied());
    assert_eq!((all.unreachable, all.worst), (0, None));
}

/// A nutating head reaches the horizon, and not a hair more: rounding does not put it out of reach.
#[test]
fn the_border_of_the_reach_is_reached() {
    let mut model = super::models::model(MachineKind::HeadHead);
    model.rotary[1] = rotary('B', AxisMount::Head, [0.0, 1.0, 1.0], Some([-190.0, 190.0]));
    let machine = FiveAxis::new(model).unwrap();
    for k in 0..500 {
        let azimuth = TAU * f64::from(k) / 500.0;
        let horizon = UnitVector3::new_normalize(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0));
        assert!(machine.inverse(&Point3::origin(), &horizon, &machine.start()).count() > 0, "{k}");
        let below = UnitVector3::new_normalize(Vector3::new(azimuth.cos(), azimuth.sin(), -0.01));
        let why = machine.unreachable(&Point3::origin(), &below);
        assert!(matches!(why, Some(Unreachable::Direction { beyond }) if (beyond - 0.01).abs() < 1e-6), "{why:?}");
    }
}
