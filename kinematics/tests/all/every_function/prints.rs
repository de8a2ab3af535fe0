//! Programs of planned prints: streams, targets, blended moves, pieces.

use super::numbers::{bad, each_spoilt, index, joints, number};
use crate::common::cells::{over_table, ur3};
use curvlay_kinematics::print_program::*;
use curvlay_kinematics::program::{HeadSignal, ServoRate, Step, TimedSignal};
use curvlay_kinematics::workcell::Workcell;
use proptest::prelude::*;

const TARGETS: [fn(&mut TargetOptions, f64); 10] = [
    |options, value| options.corner_mm = value,
    |options, value| options.turn_factor = value,
    |options, value| options.min_turn_rad_s = value,
    |options, value| options.min_speed_mm_s = value,
    |options, value| options.merge_mm = value,
    |options, value| options.merge_rad = value,
    |options, value| options.merge_share = value,
    |options, value| options.travel_mm_s = value,
    |options, value| options.travel_rad_s = value,
    |options, value| options.same_speed = value,
];
const BLENDS: [fn(&mut BlendOptions, f64); 12] = [
    |options, value| options.path_mm = value,
    |options, value| options.axis_rad = value,
    |options, value| options.travel_rad = value,
    |options, value| options.speed_share = value,
    |options, value| options.bead_share = value,
    |options, value| options.min_move_s = value,
    |options, value| options.acceleration_mm_s2 = value,
    |options, value| options.acceleration_rad_s2 = value,
    |options, value| options.min_speed_mm_s = value,
    |options, value| options.min_speed_rad_s = value,
    |options, value| options.lag_s = value,
    |options, value| options.same_speed = value,
];

type Knot = (f64, [f64; 6], f64);

/// Knots, times of signals, and whether it prints.
type Motion = (Vec<Knot>, Option<Vec<f64>>, bool);

/// Knots along a motion, one of them spoilt now and then.
fn knots() -> impl Strategy<Value = Vec<Knot>> {
    let sound = |k: usize| (0.2 * k as f64, [0.1 + 0.02 * k as f64; 6], 0.1 * k as f64);
    let spoilt = (0..7usize, 0..20usize, (number(), joints(), number())).prop_map(move |(count, at, odd)| {
        let mut knots: Vec<Knot> = (0..count).map(sound).collect();
        if let Some(knot) = knots.get_mut(at) {
            *knot = odd;
        }
        knots
    });
    prop_oneof![4 => spoilt, 1 => prop::collection::vec((number(), joints(), number()), 0..4)]
}

fn of<const N: usize>(knots: &[Knot]) -> Vec<PrintKnot<N>> {
    let knot = |&(time_s, joints, filament_mm): &Knot| PrintKnot {
        time_s,
        joints: std::array::from_fn(|k| joints.get(k).copied().unwrap_or(0.1)),
        filament_mm,
    };
    knots.iter().map(knot).collect()
}

fn signals(times: &[f64]) -> Vec<TimedSignal> {
    times.iter().map(|&time_s| TimedSignal { time_s, signal: HeadSignal::Heat, on: true }).collect()
}

/// What a caller gives a planner of programs.
struct Given<'a> {
    motions: &'a [Motion],
    value: f64,
}

fn feed<const N: usize, const F: usize, W: Workcell<N, F>>(cell: &W, given: &Given<'_>) {
    for options in each_spoilt(&TargetOptions::default(), &TARGETS, given.value) {
        let motion = |(knots, head, _): &Motion| {
            let knots = of::<N>(knots);
            let onward = knots.iter().take(2).map(|knot| knot.joints).collect();
            TargetMotion { knots, onward, head: head.as_deref().map(signals) }
        };
        let mut steps = print_targets(cell, given.motions.iter().map(motion), options);
        steps.by_ref().take(20_000).for_each(drop);
        steps.dropped();
    }
    for options in each_spoilt(&BlendOptions::default(), &BLENDS, given.value) {
        let segment = |(knots, _, prints): &Motion| BlendedSegment { samples: of::<N>(knots), prints: *prints };
        let segments: Vec<BlendedSegment<N>> = given.motions.iter().map(segment).collect();
        let mut steps = print_blended(cell, segments, options);
        steps.by_ref().take(20_000).for_each(drop);
        steps.dropped();
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn prints_take_anything(motions in prop::collection::vec((knots(), prop::option::of(prop::collection::vec(number(), 0..3)), any::<bool>()), 0..4), value in bad()) {
        let given = Given { motions: &motions, value };
        feed(&ur3(), &given);
        feed(&over_table(), &given);
    }

    #[test]
    fn streams_and_pieces_take_anything(legs in prop::collection::vec((prop_oneof![3 => 0.0..0.4f64, 1 => number()], prop::option::of(number()), prop::collection::vec(number(), 0..3), joints()), 0..4), ends in [joints(), joints()], value in bad(), motions in prop::collection::vec((number(), any::<bool>()), 0..6), most in index()) {
        let stream = |options: StreamOptions| {
            let leg = |(duration_s, rate, times, joints): &(f64, Option<f64>, Vec<f64>, [f64; 6])| {
                let (rate, joints) = (*rate, *joints);
                StreamSegment { duration_s: *duration_s, joints: move |t: f64| joints.map(|joint| joint + t), filament_mm: rate.map(|rate| move |t: f64| rate * t), signals: signals(times) }
            };
            // A long leg has many ticks, which come one by one.
            print_stream(ends, legs.iter().map(leg), options).take(20_000).collect::<Vec<Step>>().len()
        };
        for options in [StreamOptions::default(), StreamOptions { same_speed: value, ..StreamOptions::default() }, StreamOptions { lag_s: if value > 1.0 { 1.0 } else { value }, rate: ServoRate::Hz500, ..StreamOptions::default() }] {
            prop_assert!(stream(options) > 0);
        }
        for most in [0, u64::from(most), u64::MAX] {
            let pieces = print_pieces(motions.iter().copied(), most);
            prop_assert_eq!(pieces.last().map_or(0, |piece| piece.motions.end), motions.len());
        }
    }
}
