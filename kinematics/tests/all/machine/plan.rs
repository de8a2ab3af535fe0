//! Plans of the axes along paths.

use super::models::{KINDS, X, Y, Z, linear, machine, model, rotary};
use super::sampled::{check, planned, print, travel};
use curvlay_kinematics::machine::{
    AxisMount, AxisPlanError, AxisPlanOptions, AxisStep, FiveAxis, MachineKind, MachineModel, PathMove, ToolModel,
    Unreachable, VERSION, plan_axes,
};
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn lean(tilt: f64, azimuth: f64) -> [f64; 3] {
    [tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos()]
}

/// Beads whose directions wander over a cap of some 80 degrees, through the pole now and then.
fn any_moves() -> impl Strategy<Value = Vec<PathMove<usize>>> {
    let waypoint = (prop::array::uniform3(-4.0..4.0f64), -0.35..0.35f64, -0.35..0.35f64, 0..12u8);
    (prop::collection::vec(waypoint, 3..25), prop::array::uniform2(-1.0..1.0f64)).prop_map(|(waypoints, [a, b])| {
        let (mut tip, mut slope) = ([20.0, 5.0, 30.0], [a, b]);
        let mut moves = vec![travel(tip, [a, b, 1.0])];
        for (step, da, db, kind) in waypoints {
            tip = [0, 1, 2].map(|k: usize| tip[k] + step[k]);
            slope = match kind {
                // Exactly upright, or straight through.
                0 => [0.0, 0.0],
                1 => slope.map(|value| -value),
                _ => [(slope[0] + da).clamp(-4.0, 4.0), (slope[1] + db).clamp(-4.0, 4.0)],
            };
            let direction = [slope[0], slope[1], 1.0];
            moves.push(if kind == 11 { travel(tip, direction) } else { print(tip, direction) });
        }
        moves
    })
}

/// The machines of the tests, and each that can with a controller that knows the tip.
fn machines() -> Vec<FiveAxis> {
    let tcp = KINDS.map(model).into_iter().filter(|model| model.linear.len() == 3).map(|mut model| {
        model.tcp = true;
        FiveAxis::new(model).unwrap()
    });
    KINDS.map(machine).into_iter().chain(tcp).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(29), ..ProptestConfig::with_cases(24) })]
    #[test]
    fn plans_keep_what_they_promise(moves in any_moves()) {
        for machine in machines() {
            let options = AxisPlanOptions::default();
            let plan = planned(&machine, &moves, options).unwrap();
            let found = check(&machine, &moves, &options, &plan);
            let prints = moves.iter().filter(|step| matches!(step, PathMove::Print { .. })).count();
            prop_assert!((found.filament_mm - 0.25 * prints as f64).abs() < 1e-9);
            if machine.kind() != MachineKind::PolarHead {
                // Where the pole lets the turn rest, its size is what the direction is off.
                let most = options.direction_tolerance_rad.max(options.pole_rad) + 1e-6;
                prop_assert!(found.direction <= most, "{:?}: {}", machine.kind(), found.direction);
                prop_assert!(plan.summary.unfollowed_tilt == 0.0);
            }
        }
    }

    /// Printing motions outside of poles stay on their branch.
    #[test]
    fn beads_do_not_change_their_branch(moves in any_moves()) {
        for machine in machines().into_iter().filter(|machine| machine.kind() != MachineKind::PolarHead) {
            let options = AxisPlanOptions::default();
            let plan = planned(&machine, &moves, options).unwrap();
            let n = machine.linear_count();
            let branch = |axes: &[f64; 5]| {
                let (tip, direction) = machine.forward(axes);
                let is_pole = direction.x.hypot(direction.y) < 2.0 * options.pole_rad;
                let near = |found: &[f64; 5]| (found[n] - axes[n]).abs() + (found[n + 1] - axes[n + 1]).abs();
                let found = machine.inverse(&tip, &direction, axes).min_by(|a, b| near(&a.axes).total_cmp(&near(&b.axes)));
                (!is_pole).then(|| found.unwrap().branch)
            };
            let mut last = None;
            for motion in plan.of_moves.iter().flatten() {
                let now = branch(&motion.axes);
                if motion.printing && let (Some(last), Some(now)) = (last, now) {
                    prop_assert_eq!(last, now);
                }
                last = now;
            }
        }
    }
}

/// A machine of the shop: C turns without end or in a range, the tilt has one.
fn head(turns: Option<[f64; 2]>, tilts: [f64; 2]) -> FiveAxis {
    let mut model = model(MachineKind::HeadHead);
    model.rotary[0] = rotary('C', AxisMount::Head, Z, turns);
    model.rotary[1] = rotary('B', AxisMount::Head, Y, Some(tilts));
    FiveAxis::new(model).unwrap()
}

/// A bead along which the nozzle leans by `tilt` and goes around from one azimuth to another.
fn ring(from: f64, to: f64, tilt: f64) -> Vec<PathMove<usize>> {
    let count = ((to - from).abs() / 0.05).ceil() as u32;
    let at = |k: u32| from + (to - from) * f64::from(k) / f64::from(count);
    let tip = |azimuth: f64| [20.0 * azimuth.cos(), 20.0 * azimuth.sin(), 10.0];
    let mut moves = vec![travel(tip(from), lean(tilt, from))];
    moves.extend((1..=count).map(|k| print(tip(at(k)), lean(tilt, at(k)))));
    moves
}

/// How many cuts a ring needs at least: from each start the state that lasts longest, by the readings at which text books arrive.
fn cuts_by_hand(from: f64, to: f64, tilt: f64, turns: [f64; 2], tilts: [f64; 2]) -> u64 {
    let way = to - from;
    let mut at = 0.0;
    let mut cuts = 0;
    loop {
        let mut farthest: f64 = 0.0;
        for (side, tilted) in [(0.0, tilt), (PI, -tilt)] {
            if tilted < tilts[0] || tilted > tilts[1] {
                continue;
            }
            for k in -20..=20 {
                let reading = from + at + side + TAU * f64::from(k);
                if reading >= turns[0] - 1e-9 && reading <= turns[1] + 1e-9 {
                    farthest = farthest.max(if way > 0.0 { turns[1] - reading } else { reading - turns[0] });
                }
            }
        }
        at += farthest * way.signum();
        if at.abs() >= way.abs() - 1e-9 {
            return cuts;
        }
        assert!(farthest > 0.0);
        cuts += 1;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::with_cases(48) })]
    /// No other choice of branches and turns cuts a bead less often.
    #[test]
    fn beads_are_cut_no_more_than_they_must(
        from in -4.0..4.0f64,
        way in -15.0..15.0f64,
        tilt in 0.1..1.2f64,
        turns in (-400.0..-20.0f64, 195.0..800.0f64),
        one_sided in any::<bool>(),
    ) {
        let width = if one_sided { turns.1.max(365.0) } else { turns.1 };
        let turns = [turns.0, turns.0 + width];
        let tilts = if one_sided { [-5.0, 110.0] } else { [-110.0, 110.0] };
        let machine = head(Some(turns), tilts);
        let options = AxisPlanOptions::default();
        let moves = ring(from, from + way, tilt);
        let plan = planned(&machine, &moves, options).unwrap();
        let by_hand = cuts_by_hand(from, from + way, tilt, turns.map(f64::to_radians), tilts.map(f64::to_radians));
        prop_assert_eq!(plan.summary.bead_rewinds, by_hand);
        check(&machine, &moves, &options, &plan);
    }
}

/// A bead is looked at to its end: of two turns at its start the one that lasts is taken, though the other one is nearer.
#[test]
fn the_start_looks_to_the_end() {
    let machine = head(Some([-360.0, 360.0]), [-5.0, 110.0]);
    // From 170 degrees on by 300 degrees: only from -190 does it get there.
    let from = 170f64.to_radians();
    let moves = ring(from, from + 300f64.to_radians(), 0.5);
    let mut options = AxisPlanOptions::default();
    let mut start = machine.start();
    start[3] = from;
    options.start = Some(start);
    let plan = planned(&machine, &moves, options).unwrap();
    assert_eq!((plan.summary.bead_rewinds, plan.summary.travel_rewinds), (0, 0));
    assert!((plan.of_moves[0][0].axes[3] - (from - TAU)).abs() < 1e-9);
    // After a bead that ends at 170 degrees the turn goes back between the beads.
    let mut far = ring(from - TAU + 1.0, from, 0.5);
    far.extend(ring(from, from + 300f64.to_radians(), 0.5));
    let plan = planned(&machine, &far, options).unwrap();
    assert_eq!((plan.summary.bead_rewinds, plan.summary.travel_rewinds), (0, 1));
    check(&machine, &far, &options, &plan);
    // From rest to rest: up and down by 5 mm at 1000 mm/s^2, a turn at 90 degrees/s and 900 degrees/s^2.
    let lifted: f64 = plan.of_moves.iter().flatten().filter(|motion| motion.lifted).map(|motion| motion.seconds).sum();
    let by_hand = 2.0 * 2.0 * (5.0 * 0.5f64.cos() / 1000.0).sqrt() + 360.0 / 90.0 + 90.0 / 900.0;
    assert!((lifted - by_hand).abs() < 1e-6, "{lifted} {by_hand}");
    // On the way, not at an end of a bead.
    let mut lifted = ring(from - TAU + 1.0, from, 0.5);
    let (first, second) = (lifted.len(), ring(from, from + 300f64.to_radians(), 0.5));
    lifted.extend([travel([0.0, 0.0, 40.0], lean(0.5, from)), travel([0.0, 1.0, 40.0], lean(0.5, from))]);
    lifted.extend(second);
    let plan = planned(&machine, &lifted, options).unwrap();
    check(&machine, &lifted, &options, &plan);
    let at = plan.of_moves.iter().position(|motions| motions.iter().any(|motion| motion.lifted));
    assert!(at == Some(first + 1) || at == Some(first + 2), "{at:?} {first}");
}

/// Through the pole, or beside it by less than its size, the turn rests.
#[test]
fn the_pole_is_passed_without_a_turn() {
    for machine in machines().into_iter().filter(|machine| machine.kind() != MachineKind::PolarHead) {
        for beside in [0.0, 0.003] {
            let direction = |k: i32| [f64::from(k) * 0.03, beside, 1.0];
            let tip = |k: i32| [f64::from(k), 0.0, 20.0];
            let mut moves = vec![travel(tip(-10), direction(-10))];
            moves.extend((-9..=10).map(|k| print(tip(k), direction(k))));
            let options = AxisPlanOptions::default();
            let plan = planned(&machine, &moves, options).unwrap();
            check(&machine, &moves, &options, &plan);
            assert_eq!((plan.summary.pole_passes, plan.summary.bead_rewinds), (1, 0), "{:?}", machine.kind());
            let turn = machine.linear_count();
            let [min, max] = plan.summary.used[turn];
            assert!(max - min < 1.7, "{:?}: C goes from {min} to {max}", machine.kind());
            assert!(plan.summary.max_direction_error_rad <= 1.3 * options.pole_rad);
        }
    }
}

/// Where the tilt has one side only, the table must turn by half a turn at the pole: in a rewind where that would take long, slowly where not.
#[test]
fn a_pole_that_must_be_turned_at_cuts_fast_beads_only() {
    for least in [-1.0, 0.0] {
        turned_at_the_pole(&head(Some([-360.0, 360.0]), [least, 110.0]));
    }
}

fn turned_at_the_pole(machine: &FiveAxis) {
    let direction = |k: i32| [f64::from(k) * 0.03, 0.0, 1.0];
    let moves = |length: f64| {
        let tip = |k: i32| [f64::from(k) * length, 0.0, 20.0];
        let mut moves: Vec<PathMove<usize>> = vec![travel(tip(-10), direction(-10))];
        moves.extend((-9..=10).map(|k| print(tip(k), direction(k))));
        moves
    };
    let options = AxisPlanOptions::default();
    let fast = planned(machine, &moves(1.0), options).unwrap();
    check(machine, &moves(1.0), &options, &fast);
    assert_eq!((fast.summary.bead_rewinds, fast.summary.pole_passes), (1, 1));
    let drawn: Vec<_> = fast.of_moves.iter().flatten().filter(|motion| motion.filament_mm.abs() > 0.9).collect();
    assert!(drawn.len() == 2 && drawn[0].filament_mm < 0.0 && drawn[1].filament_mm > 0.0);
    // The pole is 13 mm wide here, 0.67 s of time; half a turn takes three times as long.
    let slow = planned(machine, &moves(10.0), options).unwrap();
    check(machine, &moves(10.0), &options, &slow);
    assert_eq!((slow.summary.bead_rewinds, slow.summary.pole_passes), (0, 1));
    assert!(
        slow.summary.slowed > 0
            && slow.summary.worst_slowdown > 1.5
            && slow.summary.worst_slowdown < options.max_slowdown
    );
    let patient = planned(machine, &moves(1.0), AxisPlanOptions { max_pole_wait_s: 3.0, ..options }).unwrap();
    assert_eq!(patient.summary.bead_rewinds, 0);
    let exact = planned(machine, &moves(1.0), AxisPlanOptions { max_slowdown: 1e6, ..options }).unwrap();
    assert_eq!(exact.summary.bead_rewinds, 0);
    assert!(exact.summary.worst_slowdown > options.max_slowdown);
    // A travel turns on its way: there is no bead to cut, and nothing to lift off from.
    let over: Vec<_> = moves(1.0)
        .into_iter()
        .map(|step| travel(super::sampled::target(&step).0.into(), super::sampled::target(&step).1.into_inner().into()))
        .collect();
    let over = [over, vec![print([11.0, 0.0, 20.0], direction(11))]].concat();
    let plan = planned(machine, &over, options).unwrap();
    check(machine, &over, &options, &plan);
    assert_eq!((plan.summary.bead_rewinds, plan.summary.travel_rewinds), (0, 0));
}

/// Beside the pole, by little more than its size, the turn follows in small steps, on one branch.
#[test]
fn moves_beside_the_pole_are_followed() {
    for machine in machines().into_iter().filter(|machine| machine.kind() != MachineKind::PolarHead) {
        let moves = [travel([5.0, 0.0, 10.0], lean(0.05, 0.0)), print([6.0, 1.0, 10.0], lean(0.05, 2.2))];
        let options = AxisPlanOptions::default();
        let plan = planned(&machine, &moves, options).unwrap();
        let found = check(&machine, &moves, &options, &plan);
        assert_eq!((plan.summary.bead_rewinds, plan.summary.pole_passes), (0, 0));
        let [min, max] = plan.summary.used[3];
        assert!((max - min - 2.2).abs() < 1e-6, "{:?}: {min} to {max}", machine.kind());
        assert!(found.direction <= options.direction_tolerance_rad);
    }
}

/// A controller that keeps the tip on its line still turns rotary axes evenly: the direction asks for divisions of its own.
#[test]
fn directions_divide_moves_by_themselves() {
    for machine in machines().into_iter().filter(FiveAxis::knows_tip) {
        let moves = [travel([5.0, 0.0, 10.0], lean(1.0, 0.0)), print([6.0, 1.0, 10.0], lean(1.0, 0.8))];
        for tolerance in [0.02, 0.001] {
            let options = AxisPlanOptions { direction_tolerance_rad: tolerance, ..AxisPlanOptions::default() };
            let plan = planned(&machine, &moves, options).unwrap();
            let found = check(&machine, &moves, &options, &plan);
            assert!(found.direction <= tolerance && plan.summary.max_direction_error_rad <= tolerance);
            assert!(found.direction > 0.02 * tolerance, "{found:?}");
        }
    }
}

/// A tilt that does not come to upright has no pole to rest at.
#[test]
fn a_pole_out_of_range_is_out_of_reach() {
    let machine = head(Some([-360.0, 360.0]), [5.0, 110.0]);
    let moves = [travel([5.0, 0.0, 10.0], lean(0.3, 0.0)), print([6.0, 1.0, 10.0], Z)];
    let error = failure(&machine, &moves, AxisPlanOptions::default());
    let is_tilt = |reason| matches!(reason, Unreachable::Rotary { letter: 'B', .. });
    assert!(matches!(error, AxisPlanError::Unreachable { index: 1, reason, .. } if is_tilt(reason)), "{error}");
}

/// On a polar machine a rewind sweeps over the part: it goes above all that stands.
#[test]
fn polar_rewinds_go_above_what_is_printed() {
    let mut short = model(MachineKind::PolarHead);
    short.linear[0].range_mm = [-1.0, 100.0];
    let short = FiveAxis::new(short).unwrap();
    let mut moves = vec![travel([30.0, 0.0, 60.0], Z), print([31.0, 0.0, 60.0], Z), travel([-20.0, 0.0, 5.0], Z)];
    moves.extend((-19..20).map(|k| print([f64::from(k), 0.0, 5.0], Z)));
    let options = AxisPlanOptions::default();
    let plan = planned(&short, &moves, options).unwrap();
    check(&short, &moves, &options, &plan);
    assert_eq!(plan.summary.bead_rewinds, 1);
    let mut last: Option<[f64; 5]> = None;
    for motion in plan.of_moves.iter().flatten() {
        let turn = last.map_or(0.0, |last| (motion.axes[2] - last[2]).abs());
        let (tip, _) = short.forward(&motion.axes);
        assert!(!motion.lifted || turn < 1e-9 || tip.z >= 60.0 + options.lift_mm - 1e-6, "{tip}");
        last = Some(motion.axes);
    }
}

/// Layers without a tilt move no rotary axis, wherever it stands.
#[test]
fn flat_layers_leave_the_turn_alone() {
    for machine in machines().into_iter().filter(|machine| machine.kind() != MachineKind::PolarHead) {
        let mut options = AxisPlanOptions::default();
        let mut start = machine.start();
        start[3] = 1.25;
        options.start = Some(start);
        let mut moves = vec![travel([0.0, 0.0, 1.0], Z)];
        for k in 0..40 {
            let tip = [f64::from(k) * 1.3, f64::from(k % 7), 1.0 + f64::from(k / 20)];
            moves.push(if k % 10 == 9 { travel(tip, Z) } else { print(tip, Z) });
        }
        let plan = planned(&machine, &moves, options).unwrap();
        check(&machine, &moves, &options, &plan);
        for motion in plan.of_moves.iter().flatten() {
            assert!((motion.axes[3] - 1.25).abs() < 1e-12 && motion.axes[4].abs() < 1e-12);
        }
        assert_eq!(plan.summary.axis_moves, moves.len() as u64);
        assert_eq!((plan.summary.slowed, plan.summary.pole_passes), (0, 0));
    }
}

/// A range of one whole turn has both its ends at one direction: there, and only there, a bead goes on after a rewind, however far waypoints stand apart.
#[test]
fn one_whole_turn_is_enough() {
    for turns in [[0.0, 360.0], [-180.0, 180.0]] {
        let machine = head(Some(turns), [-5.0, 110.0]);
        for (step, count) in [(0.05, 400), (0.9, 22), (TAU / 8.0, 25)] {
            let at = |k: u32| 0.4 + f64::from(k) * step;
            let mut moves = vec![travel([20.0, 0.0, 10.0], lean(0.5, at(0)))];
            moves.extend((1..=count).map(|k| print([20.0, f64::from(k), 10.0], lean(0.5, at(k)))));
            let options = AxisPlanOptions::default();
            let plan = planned(&machine, &moves, options).unwrap();
            check(&machine, &moves, &options, &plan);
            let [first, last] = [at(0), at(count)].map(|at| ((at.to_degrees() - turns[0]) / 360.0).floor());
            assert_eq!(plan.summary.bead_rewinds, (last - first) as u64, "{turns:?} {step}");
        }
    }
}

/// A hose of some thousand turns: a bead of thirty turns winds on.
#[test]
fn wide_ranges_are_used() {
    let machine = head(Some([-12000.0, 12000.0]), [-5.0, 110.0]);
    let moves = ring(0.0, 30.0 * TAU, 0.4);
    let options = AxisPlanOptions::default();
    let plan = planned(&machine, &moves, options).unwrap();
    assert_eq!((plan.summary.bead_rewinds, plan.summary.travel_rewinds), (0, 0));
    check(&machine, &moves, &options, &plan);
}

/// A bed that is long in one direction: upright layers that do not fit across it are turned before they begin.
#[test]
fn upright_layers_are_turned_to_where_they_fit() {
    let mut narrow = model(MachineKind::TableTable);
    narrow.linear[1].range_mm = [-60.0, 60.0];
    let narrow = FiveAxis::new(narrow).unwrap();
    let moves = [
        travel([-90.0, 0.0, 1.0], Z),
        print([90.0, 0.0, 1.0], Z),
        travel([0.0, 0.0, 9.0], Z),
        print([80.0, 0.0, 1.0], Z),
    ];
    for turn in [0.0, 1.0, FRAC_PI_2, -2.5] {
        let mut start = narrow.start();
        start[3] = turn;
        let options = AxisPlanOptions { start: Some(start), ..AxisPlanOptions::default() };
        let plan = planned(&narrow, &moves, options).unwrap();
        check(&narrow, &moves, &options, &plan);
        // Where it fits the turn is not touched.
        let there = plan.of_moves[0][0].axes[3];
        assert!(turn != 0.0 || there == 0.0, "{there}");
        assert!(there.sin().abs() < 0.72, "{there}");
    }
}

/// Twenty turns of an endless table: no rewind, readings go on.
#[test]
fn endless_axes_wind_up() {
    let mut model = model(MachineKind::HeadTable);
    model.rotary[0] = rotary('C', AxisMount::Table, Z, None);
    let machine = FiveAxis::new(model).unwrap();
    let moves = ring(0.0, 20.0 * TAU, 0.4);
    let options = AxisPlanOptions::default();
    let plan = planned(&machine, &moves, options).unwrap();
    assert_eq!((plan.summary.bead_rewinds, plan.summary.travel_rewinds), (0, 0));
    let [min, max] = plan.summary.used[3];
    assert!((max - min - 20.0 * TAU).abs() < 1e-6);
    check(&machine, &moves, &options, &plan);
}

/// A tip that stands still while the nozzle turns by 0.8 rad in 10 degrees a second takes as long as the axis.
#[test]
fn slow_axes_slow_moves_down() {
    let mut model = model(MachineKind::HeadHead);
    model.rotary[1].max_speed_deg_s = 10.0;
    let machine = FiveAxis::new(model).unwrap();
    let moves = [travel([0.0, 0.0, 10.0], [0.0, 0.1, 1.0]), print([0.0, 1.0, 10.0], lean(0.8, FRAC_PI_2))];
    let options = AxisPlanOptions::default();
    let plan = planned(&machine, &moves, options).unwrap();
    check(&machine, &moves, &options, &plan);
    let seconds: f64 = plan.of_moves[1].iter().map(|motion| motion.seconds).sum();
    let needed = (0.8 - 0.1f64.atan()) / 10f64.to_radians();
    assert!((seconds - needed).abs() < 1e-3 * needed, "{seconds} {needed}");
    // At 20 mm/s it would be 0.05 s.
    assert!(plan.summary.slowed > 0 && plan.summary.worst_slowdown > 70.0);
}

/// With two linear axes the nozzle follows a lean along the arm, and nothing of one across it.
#[test]
fn polar_machines_report_what_they_do_not_follow() {
    let machine = machine(MachineKind::PolarHead);
    let options = AxisPlanOptions::default();
    let spokes = |across: f64| {
        let mut moves = vec![travel([20.0, 0.0, 5.0], [0.3 * (1.0 - across), 0.3 * across, 1.0])];
        moves
            .extend((1..30).map(|k| print([20.0 + f64::from(k), 0.0, 5.0], [0.3 * (1.0 - across), 0.3 * across, 1.0])));
        moves
    };
    let along = planned(&machine, &spokes(0.0), options).unwrap();
    check(&machine, &spokes(0.0), &options, &along);
    assert!(along.summary.unfollowed_tilt < 1e-9 && along.summary.max_direction_error_rad < 1e-9);
    let across = planned(&machine, &spokes(1.0), options).unwrap();
    check(&machine, &spokes(1.0), &options, &across);
    assert!((across.summary.unfollowed_tilt - 1.0).abs() < 1e-9);
    assert!((across.summary.max_direction_error_rad - 0.3f64.atan()).abs() < 1e-9);
    // Straight over the middle of the table: X goes on to the other side, C rests.
    let mut moves = vec![travel([-20.0, 0.0, 5.0], Z)];
    moves.extend((-19..20).map(|k| print([f64::from(k), 0.0, 5.0], Z)));
    let over = planned(&machine, &moves, options).unwrap();
    check(&machine, &moves, &options, &over);
    assert_eq!(over.summary.bead_rewinds, 0);
    let [min, max] = over.summary.used[2];
    assert!(max - min < 1e-9, "C goes from {min} to {max}");
    // An arm that ends at the middle must turn the table by half a turn there.
    let mut short = model(MachineKind::PolarHead);
    short.linear[0].range_mm = [-1.0, 100.0];
    let short = FiveAxis::new(short).unwrap();
    let turned = planned(&short, &moves, options).unwrap();
    check(&short, &moves, &options, &turned);
    assert_eq!(turned.summary.bead_rewinds, 1);
}

fn failure(machine: &FiveAxis, moves: &[PathMove<usize>], options: AxisPlanOptions) -> AxisPlanError {
    match plan_axes(machine, moves.iter().copied(), options) {
        Err(error) => error,
        Ok(mut plan) => {
            let error = plan.find_map(Result::err).unwrap();
            assert!(plan.next().is_none());
            error
        }
    }
}

#[test]
fn what_cannot_be_planned_is_said() {
    let machine = head(Some([-360.0, 360.0]), [-110.0, 110.0]);
    let options = AxisPlanOptions::default();
    let start = travel([0.0, 0.0, 10.0], Z);
    let low = [start, print([1.0, 0.0, 10.0], lean(1.0, 0.0)), print([2.0, 0.0, 10.0], lean(120f64.to_radians(), 0.0))];
    let said = failure(&machine, &low, options).to_string();
    assert!(
        said.starts_with("move 2, tip at ") && said.contains("beyond its range of -110.00 to 110.00: tilt"),
        "{said}"
    );
    assert_eq!(failure(&machine, &[print([0.0; 3], Z)], options), AxisPlanError::Unplaced { index: 0 });
    assert_eq!(
        failure(&machine, &[start, PathMove::Restart(1), print([0.0; 3], Z)], options),
        AxisPlanError::Unplaced { index: 2 }
    );
    let half = [travel([0.0; 3], X), print([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0])];
    assert_eq!(failure(&machine, &half, options), AxisPlanError::Opposite { index: 1 });
    let far = failure(&machine, &[start, print([2000.0, 0.0, 0.0], Z)], options);
    assert!(
        matches!(far, AxisPlanError::Unreachable { index: 1, reason: Unreachable::Linear { letter: 'X', .. }, .. }),
        "{far}"
    );
    for (bad, field) in [
        (
            PathMove::Print {
                tip: Point3::new(f64::NAN, 0.0, 0.0),
                direction: Vector3::z_axis(),
                filament_mm: 0.0,
                feed_mm_s: 1.0,
            },
            "tip",
        ),
        (
            PathMove::Print {
                tip: Point3::origin(),
                direction: UnitVector3::new_unchecked(Vector3::zeros()),
                filament_mm: 0.0,
                feed_mm_s: 1.0,
            },
            "direction",
        ),
        (
            PathMove::Print { tip: Point3::origin(), direction: Vector3::z_axis(), filament_mm: -1.0, feed_mm_s: 1.0 },
            "filament_mm",
        ),
        (
            PathMove::Travel { tip: Point3::origin(), direction: Vector3::z_axis(), feed_mm_s: f64::INFINITY },
            "feed_mm_s",
        ),
    ] {
        let error = failure(&machine, &[start, bad], options);
        assert!(matches!(error, AxisPlanError::Number { index: 1, what, .. } if what == field), "{error}");
    }
    // Nothing above the part: a rewind has no place.
    let mut flat = model(MachineKind::HeadHead);
    flat.rotary[1] = rotary('B', AxisMount::Head, Y, Some([-5.0, 110.0]));
    flat.linear[2].range_mm = [-500.0, 110.0];
    let flat = FiveAxis::new(flat).unwrap();
    let error = failure(&flat, &ring(0.0, 20.0, 0.3), AxisPlanOptions { lift_mm: 30.0, ..options });
    assert!(matches!(error, AxisPlanError::NoSpace { reason: Unreachable::Linear { letter: 'Z', .. }, .. }), "{error}");
    assert!(error.to_string().ends_with("or make `lift_mm` smaller"), "{error}");
}

#[test]
fn invalid_options_are_named() {
    let machine = machine(MachineKind::HeadHead);
    type Field = (&'static str, fn(&mut AxisPlanOptions) -> &mut f64);
    let fields: [Field; 10] = [
        ("tip_tolerance_mm", |o| &mut o.tip_tolerance_mm),
        ("travel_tolerance_mm", |o| &mut o.travel_tolerance_mm),
        ("direction_tolerance_rad", |o| &mut o.direction_tolerance_rad),
        ("pole_rad", |o| &mut o.pole_rad),
        ("max_slowdown", |o| &mut o.max_slowdown),
        ("max_pole_wait_s", |o| &mut o.max_pole_wait_s),
        ("lift_mm", |o| &mut o.lift_mm),
        ("lift_feed_mm_s", |o| &mut o.lift_feed_mm_s),
        ("retract_mm", |o| &mut o.retract_mm),
        ("retract_feed_mm_s", |o| &mut o.retract_feed_mm_s),
    ];
    for (name, field) in fields {
        for value in [f64::NAN, -1.0, f64::INFINITY] {
            let mut options = AxisPlanOptions::default();
            *field(&mut options) = value;
            let error = failure(&machine, &[], options);
            assert!(matches!(error, AxisPlanError::Option { what, .. } if what == name), "{error}");
        }
    }
    let options = AxisPlanOptions { start: Some([f64::NAN; 5]), ..AxisPlanOptions::default() };
    assert!(matches!(failure(&machine, &[], options), AxisPlanError::Option { what: "start", .. }));
}

/// What is passed through comes out in its place, before, within and behind beads.
#[test]
fn the_rest_passes_through_in_its_place() {
    let machine = machine(MachineKind::TableTable);
    let moves = [
        PathMove::Pass('a'),
        PathMove::Restart('h'),
        PathMove::Pass('b'),
        travel([0.0, 0.0, 1.0], Z),
        print([5.0, 0.0, 1.0], Z),
        PathMove::Pass('c'),
        print([5.0, 5.0, 1.0], Z),
        PathMove::Pass('d'),
        travel([0.0, 0.0, 9.0], Z),
        PathMove::Restart('i'),
        travel([1.0, 0.0, 2.0], Z),
        PathMove::Pass('e'),
    ];
    let mut plan = plan_axes(&machine, moves, AxisPlanOptions::default()).unwrap();
    let order: String = plan
        .by_ref()
        .map(|step| match step.unwrap() {
            AxisStep::Pass(letter) => letter,
            AxisStep::Move(motion) if motion.printing => 'P',
            AxisStep::Move(_) => 'T',
        })
        .collect();
    assert_eq!(order, "ahbTPcPdTiTe");
    assert_eq!((plan.summary().moves, plan.summary().axis_moves), (12, 5));
    assert_eq!(plan_axes(&machine, Vec::<PathMove<()>>::new(), AxisPlanOptions::default()).unwrap().count(), 0);
}

/// A machine built slightly out of square: the pole is not reached exactly, and flat layers print all the same.
#[test]
fn machines_as_built_print_flat_layers() {
    let skew = [0.0004, 1.0, 0.0003];
    let machine = FiveAxis::new(MachineModel {
        version: VERSION,
        name: "as built".into(),
        source: None,
        dialect: None,
        tcp: false,
        linear: vec![linear('X', X), linear('Y', [0.0002, 1.0, 0.0]), linear('Z', Z)],
        rotary: vec![
            rotary('C', AxisMount::Table, Z, None),
            rotary('B', AxisMount::Table, skew, Some([-100.0, 100.0])),
        ],
        nozzle: ToolModel { direction: [0.0003, 0.0002, 1.0], tip_mm: None },
        part_origin_mm: [0.0; 3],
    })
    .unwrap();
    assert!(matches!(machine.unreachable(&Point3::origin(), &Vector3::z_axis()), Some(Unreachable::Direction { .. })));
    let moves = [travel([0.0, 0.0, 1.0], Z), print([50.0, 0.0, 1.0], Z), print([50.0, 50.0, 1.0], [0.2, 0.1, 1.0])];
    let options = AxisPlanOptions::default();
    let plan = planned(&machine, &moves, options).unwrap();
    let found = check(&machine, &moves, &options, &plan);
    assert!(found.direction <= options.pole_rad + 1e-3);
}
