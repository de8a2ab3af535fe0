//! Forward kinematics and inverses of the four kinds, written out by hand for axes along x, y and z.

use super::models::{KINDS, machine, model};
use curvlay_kinematics::machine::{AxisMount, AxisSolution, FiveAxis, MachineKind};
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

type Place = ([f64; 3], [f64; 3]);

/// `[x, y]` rotated by `angle`.
fn turn([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [x * cos - y * sin, x * sin + y * cos]
}

/// About z, x and y through a point, by the right-hand rule.
fn about_z(p: [f64; 3], c: [f64; 3], angle: f64) -> [f64; 3] {
    let [x, y] = turn([p[0] - c[0], p[1] - c[1]], angle);
    [x + c[0], y + c[1], p[2]]
}

fn about_x(p: [f64; 3], c: [f64; 3], angle: f64) -> [f64; 3] {
    let [y, z] = turn([p[1] - c[1], p[2] - c[2]], angle);
    [p[0], y + c[1], z + c[2]]
}

fn about_y(p: [f64; 3], c: [f64; 3], angle: f64) -> [f64; 3] {
    let [z, x] = turn([p[2] - c[2], p[0] - c[0]], angle);
    [x + c[0], p[1], z + c[2]]
}

/// Tip and direction in the part for the numbers of `model(kind)`.
fn by_hand(kind: MachineKind, v: [f64; 5]) -> Place {
    let at = |p: [f64; 3]| [p[0] + v[0], p[1] + v[1], p[2] + v[2]];
    let (up, o) = ([0.0, 0.0, 1.0], [0.0; 3]);
    let ([px, py, pz], direction) = match kind {
        // The table is turned back: first its tilt, then its turn.
        MachineKind::TableTable => {
            let tip = about_z(about_x(at([1.0, -2.0, 3.0]), [10.0, 1.0, -40.0], -v[4]), [0.3, -0.2, 5.0], -v[3]);
            (tip, about_z(about_x(up, o, -v[4]), o, -v[3]))
        }
        MachineKind::HeadTable => {
            let tilted = about_y([0.5, 4.0, 0.0], [0.0, 4.0, 60.0], v[4]);
            (about_z(at(tilted), [2.0, 3.0, 0.0], -v[3]), about_z(about_y(up, o, v[4]), o, -v[3]))
        }
        MachineKind::HeadHead => {
            let tilted = about_x([1.0, 0.5, 0.0], [1.0, -1.5, 80.0], v[4]);
            (at(about_z(tilted, [1.0, 0.0, 100.0], v[3])), about_z(about_x(up, o, v[4]), o, v[3]))
        }
        MachineKind::PolarHead => {
            let tilted = about_y([0.0; 3], [0.0, 0.0, 50.0], v[3]);
            let moved = [tilted[0] + v[0], tilted[1], tilted[2] + v[1]];
            return (about_z(moved, o, -v[2]), about_z(about_y(up, o, v[3]), o, -v[2]));
        }
    };
    ([px - 7.0, py + 8.0, pz - 9.0], direction)
}

fn values() -> impl Strategy<Value = [f64; 5]> {
    (prop::array::uniform3(-200.0..200.0f64), -6.0..6.0f64, -1.5..1.5f64).prop_map(|([x, y, z], a, b)| [x, y, z, a, b])
}

fn of_kind(kind: MachineKind, v: [f64; 5]) -> [f64; 5] {
    if kind == MachineKind::PolarHead { [v[0].abs() + 1.0, v[2], v[3], v[4], 0.0] } else { v }
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(4711), ..ProptestConfig::with_cases(256) })]
    #[test]
    fn forward_is_what_the_hand_says(v in values()) {
        for kind in KINDS {
            let v = of_kind(kind, v);
            let (tip, direction) = machine(kind).forward(&v);
            let (hand_tip, hand_direction) = by_hand(kind, v);
            prop_assert!((tip - Point3::from(hand_tip)).norm() < 1e-9, "{kind:?}: {tip} {hand_tip:?}");
            prop_assert!((direction.into_inner() - Vector3::from(hand_direction)).norm() < 1e-12, "{kind:?}");
        }
    }

    /// Tilt and turn from the direction by arc cosine and arc tangent, as text books have them.
    #[test]
    fn inverses_are_what_the_hand_says(v in values()) {
        for kind in KINDS {
            let v = of_kind(kind, v);
            let machine = machine(kind);
            let (tip, direction) = machine.forward(&v);
            let d = direction.into_inner();
            // The two readings of the rotary axes, with whole turns left out.
            let tilt = d.z.acos();
            let azimuth = d.y.atan2(d.x);
            let radial = tip.y.atan2(tip.x);
            let hand = match kind {
                // A table with C and A: R_x(-a) leans the nozzle towards y by a, which C turns by -c.
                MachineKind::TableTable => [[FRAC_PI_2 - azimuth, tilt], [-FRAC_PI_2 - azimuth, -tilt]],
                MachineKind::HeadTable => [[-azimuth, tilt], [PI - azimuth, -tilt]],
                MachineKind::HeadHead => [[azimuth - FRAC_PI_2, -tilt], [azimuth + FRAC_PI_2, tilt]],
                // The turn brings the tip to the plane y = 0; the direction is in that plane.
                MachineKind::PolarHead => {
                    let in_plane = |c: f64| (d.x * c.cos() - d.y * c.sin()).atan2(d.z);
                    [[-radial, in_plane(-radial)], [PI - radial, in_plane(PI - radial)]]
                }
            };
            let first = machine.linear_count();
            let found: Vec<_> = machine.inverse(&tip, &direction, &v).map(|s| [s.axes[first], s.axes[first + 1]]).collect();
            let same = |a: f64, b: f64| (a - b - TAU * ((a - b) / TAU).round()).abs() < 1e-6 / tilt.max(1e-3);
            for pair in &found {
                prop_assert!(hand.iter().any(|hand| same(hand[0], pair[0]) && same(hand[1], pair[1])), "{kind:?} {pair:?} {hand:?}");
            }
            for hand in &hand {
                prop_assert!(found.iter().any(|pair| same(hand[0], pair[0]) && same(hand[1], pair[1])), "{kind:?} {found:?} {hand:?}");
            }
        }
    }
}

/// Postures that can be seen with the eye.
#[test]
fn signs_are_those_of_the_right_hand() {
    let mut flat = model(MachineKind::TableTable);
    flat.part_origin_mm = [0.0; 3];
    flat.nozzle.tip_mm = None;
    flat.rotary.iter_mut().for_each(|axis| axis.point_mm = Some([0.0; 3]));
    let table = FiveAxis::new(flat.clone()).unwrap();
    // The part turns from x to y, so the nozzle over x of the machine is over -y of the part.
    let (tip, _) = table.forward(&[10.0, 0.0, 0.0, FRAC_PI_2, 0.0]);
    assert!((tip - Point3::new(0.0, -10.0, 0.0)).norm() < 1e-12, "{tip}");
    flat.rotary.iter_mut().for_each(|axis| axis.mount = AxisMount::Head);
    flat.nozzle.tip_mm = Some([0.0, 0.0, -50.0]);
    let head = FiveAxis::new(flat).unwrap();
    // The head leans about x by a quarter turn: the nozzle's hind end goes from +z to -y, its tip to +y.
    let (tip, direction) = head.forward(&[0.0, 0.0, 0.0, 0.0, FRAC_PI_2]);
    assert!((tip - Point3::new(0.0, 50.0, 0.0)).norm() < 1e-12, "{tip}");
    assert!((direction.y + 1.0).abs() < 1e-12, "{direction:?}");
}

/// An axis that reads 90 where the table lies flat, and one with the opposite sense.
#[test]
fn zero_offsets_and_senses_shift_readings_only() {
    let plain = machine(MachineKind::TableTable);
    let mut shifted = model(MachineKind::TableTable);
    shifted.rotary[1].zero_deg = 90.0;
    shifted.rotary[1].range_deg = Some([-30.0, 210.0]);
    shifted.rotary[0].axis = [0.0, 0.0, -2.0];
    let shifted = FiveAxis::new(shifted).unwrap();
    let v = [3.0, 4.0, 5.0, 0.7, 0.4];
    let w = [3.0, 4.0, 5.0, -0.7, 0.4 + FRAC_PI_2];
    let ((a, d), (b, e)) = (plain.forward(&v), shifted.forward(&w));
    assert!((a - b).norm() < 1e-12 && (d.into_inner() - e.into_inner()).norm() < 1e-12);
    let found: Vec<_> = plain.inverse(&a, &d, &v).collect();
    let again: Vec<_> = shifted.inverse(&a, &d, &w).collect();
    assert_eq!(found.len(), again.len());
    // The opposite axis gives the branches the other names.
    let tilts = |solutions: &[AxisSolution], less: f64| {
        let mut tilts: Vec<_> = solutions.iter().map(|solution| solution.axes[4] - less).collect();
        tilts.sort_by(f64::total_cmp);
        tilts
    };
    for (one, other) in tilts(&found, 0.0).iter().zip(tilts(&again, FRAC_PI_2)) {
        assert!((one - other).abs() < 1e-12, "{found:?} {again:?}");
    }
}

/// At the pole the turn stays; each whole turn of the others is there.
#[test]
fn poles_keep_the_turn_and_turns_are_all_there() {
    let machine = machine(MachineKind::HeadHead);
    let (up, tip) = (Vector3::z_axis(), Point3::new(1.0, 2.0, 3.0));
    let near = [0.0, 0.0, 0.0, 2.5, 0.3];
    let found: Vec<_> = machine.inverse(&tip, &up, &near).collect();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].axes[3..], [2.5, 0.0]);
    // C may be -360 to 360 degrees: two turns for each of two pairs.
    let lean = UnitVector3::new_normalize(Vector3::new(0.3, 0.1, 1.0));
    let found: Vec<_> = machine.inverse(&tip, &lean, &near).collect();
    assert_eq!(found.iter().filter(|s| s.branch == 0).count(), 2);
    assert_eq!(found.iter().filter(|s| s.branch == 1).count(), 2);
    // Along -y, C is 0 on one of them: -360, 0 and 360, all at rounding's distance from an end.
    let lean = UnitVector3::new_normalize(Vector3::new(0.0, -0.3, 1.0));
    let turns: Vec<_> = machine.inverse(&tip, &lean, &near).map(|s| s.axes[3].to_degrees().round()).collect();
    assert_eq!(turns, [-360.0, 0.0, 360.0, -180.0, 180.0]);
}

#[test]
fn numbers_that_are_not_finite_have_no_solution() {
    for kind in KINDS {
        let machine = machine(kind);
        let start = machine.start();
        for bad in [f64::NAN, f64::INFINITY] {
            let direction = UnitVector3::new_unchecked(Vector3::new(bad, 0.0, 1.0));
            assert_eq!(machine.inverse(&Point3::origin(), &direction, &start).count(), 0);
            assert_eq!(machine.inverse(&Point3::new(bad, 0.0, 0.0), &Vector3::z_axis(), &start).count(), 0);
            // What is near may be anything.
            for found in machine.inverse(&Point3::new(1.0, 2.0, 3.0), &Vector3::z_axis(), &[bad; 5]) {
                assert!(found.axes.iter().all(|value| value.is_finite()), "{found:?}");
            }
        }
    }
}
