//! Transfers: motions within their bounds everywhere, ways that are free, results that name what is wrong.

use crate::common::Fixed;
use curvlay_trajectory::Bounds;
use curvlay_trajectory::transfer::{
    End, FreeSpace, Planned, SCurve, Transfer, TransferError, TransferOptions, plan_transfer,
};
use proptest::prelude::*;

fn bounds<const N: usize>(velocity: f64, acceleration: f64, jerk: f64) -> Bounds<N> {
    Bounds { velocity: [velocity; N], acceleration: [acceleration; N], jerk: [jerk; N], ..Bounds::NONE }
}

/// The fastest double S by bisection of its highest speed.
fn slow_duration(length: f64, velocity: f64, acceleration: f64, jerk: f64) -> f64 {
    let ramp = |speed: f64| {
        if speed * jerk >= acceleration * acceleration {
            speed / acceleration + acceleration / jerk
        } else {
            2.0 * (speed / jerk).sqrt()
        }
    };
    let (mut low, mut high) = (0.0, velocity);
    if high * ramp(high) > length {
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle * ramp(middle) > length { high = middle } else { low = middle }
        }
    }
    length / high + ramp(high)
}

/// Bounds hold on every cubic between knots, ends and inner extremes, and pieces meet without a jump up to the
/// acceleration. Exact but for rounding: nothing is sampled.
fn assert_within<const N: usize>(transfer: &Transfer<N>, bounds: &Bounds<N>) {
    let knots = transfer.knots();
    let mut before: Option<[[f64; 3]; N]> = None;
    for piece in knots.windows(2) {
        let (middle, half) = (0.5 * (piece[0] + piece[1]), 0.5 * (piece[1] - piece[0]));
        // A piece that rounding has left behind says nothing.
        if half < 1e-9 {
            continue;
        }
        let state = transfer.at(middle);
        let mut ends = [[0.0; 3]; N];
        for j in 0..N {
            let (q, v, a, jerk) = (state.position[j], state.velocity[j], state.acceleration[j], state.jerk[j]);
            assert!(jerk.abs() <= bounds.jerk[j]);
            let at = |t: f64| {
                let place = q + v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0;
                [place, v + a * t + jerk * t * t / 2.0, a + jerk * t]
            };
            let fastest = if jerk.abs() > 0.0 { -a / jerk } else { 0.0 };
            for t in [-half, half, fastest.clamp(-half, half)] {
                let [place, speed, acceleration] = at(t);
                assert!(acceleration.abs() <= bounds.acceleration[j], "{acceleration}");
                assert!(speed.abs() <= bounds.velocity[j], "{speed}");
                assert!(place >= bounds.lower[j] - 1e-9 && place <= bounds.upper[j] + 1e-9);
            }
            // What the pieces say and what is given out agree at ends and between.
            for t in [-0.9 * half, 0.3 * half] {
                let given = transfer.at(middle + t);
                assert!((given.position[j] - at(t)[0]).abs() < 1e-9 && (given.velocity[j] - at(t)[1]).abs() < 1e-7);
                assert!((bounds.lower[j]..=bounds.upper[j]).contains(&given.position[j]));
            }
            if let Some(before) = before {
                let here = at(-half);
                assert!((before[j][0] - here[0]).abs() < 1e-9 && (before[j][1] - here[1]).abs() < 1e-7);
                assert!((before[j][2] - here[2]).abs() < 1e-5 * bounds.acceleration[j].max(1.0));
            }
            ends[j] = at(half);
        }
        before = Some(ends);
    }
    for time in [0.0, transfer.duration(), -1.0, transfer.duration() + 1.0] {
        let rest = transfer.at(time);
        assert_eq!((rest.velocity, rest.acceleration), ([0.0; N], [0.0; N]));
        let end = if time > 0.0 { transfer.corners().last() } else { transfer.corners().first() };
        assert_eq!(Some(&rest.position), end);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_curve_is_as_fast_as_the_bisected_one(
        length in 1e-6..100.0f64, v in 0.01..10.0f64, a in 0.01..50.0f64, jerk in 0.01..500.0f64,
    ) {
        let curve = SCurve::new(length, v, a, jerk).unwrap();
        let slow = slow_duration(length, v, a, jerk);
        prop_assert!((curve.duration() / slow - 1.0).abs() < 1e-9, "{} {slow}", curve.duration());
        let half = curve.at(0.5 * curve.duration());
        prop_assert!((half.place - 0.5 * length).abs() < 1e-12 * length);
    }

    #[test]
    fn motions_through_corners_keep_their_bounds(
        corners in proptest::collection::vec(proptest::array::uniform3(-3.0..3.0f64), 1..6),
        v in proptest::array::uniform3(0.1..4.0f64),
        a in proptest::array::uniform3(0.1..20.0f64),
        jerk in proptest::array::uniform3(0.1..200.0f64),
    ) {
        let bounds = Bounds { velocity: v, acceleration: a, jerk, lower: [-3.0; 3], upper: [3.0; 3] };
        let transfer = Transfer::through(corners, &bounds).unwrap();
        assert_within(&transfer, &bounds);
        // On each line some joint is at some bound: it is as fast as it goes.
        for (line, ends) in transfer.corners().windows(2).enumerate() {
            let alone = Transfer::through(ends.to_vec(), &bounds).unwrap();
            let at_bound = alone.knots().windows(2).any(|piece| {
                let state = alone.at(0.5 * (piece[0] + piece[1]));
                (0..3).any(|j| state.jerk[j].abs() > 0.999_999 * jerk[j])
            });
            prop_assert!(at_bound, "line {line}");
        }
    }
}

/// Discs in the plane.
struct Discs(Vec<([f64; 2], f64)>);

impl Discs {
    fn clearance(&self, a: &[f64; 2], b: &[f64; 2]) -> f64 {
        let ab = [b[0] - a[0], b[1] - a[1]];
        let square = ab[0] * ab[0] + ab[1] * ab[1];
        let to = |(center, radius): &([f64; 2], f64)| {
            let ac = [center[0] - a[0], center[1] - a[1]];
            let t = if square > 0.0 { ((ab[0] * ac[0] + ab[1] * ac[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
            (ac[0] - t * ab[0]).hypot(ac[1] - t * ab[1]) - radius
        };
        self.0.iter().map(to).fold(f64::INFINITY, f64::min)
    }

    /// Whether a flood over a grid of the square reaches the goal with `room` to every disc.
    fn flood(&self, from: &[f64; 2], to: &[f64; 2], room: f64) -> bool {
        const SIDE: usize = 120;
        let at = |k: usize| [-3.0 + 6.0 * (k % SIDE) as f64 / 119.0, -3.0 + 6.0 * (k / SIDE) as f64 / 119.0];
        let free = |k: usize| self.clearance(&at(k), &at(k)) > room;
        let cell = |q: &[f64; 2]| {
            let index = |x: f64| ((x + 3.0) / 6.0 * 119.0).round() as usize;
            index(q[0]) + SIDE * index(q[1])
        };
        let mut seen = vec![false; SIDE * SIDE];
        let mut stack = vec![cell(from)];
        while let Some(k) = stack.pop() {
            if seen[k] || !free(k) {
                continue;
            }
            seen[k] = true;
            let (x, y) = (k % SIDE, k / SIDE);
            stack.extend((x > 0).then(|| k - 1));
            stack.extend((x + 1 < SIDE).then(|| k + 1));
            stack.extend((y > 0).then(|| k - SIDE));
            stack.extend((y + 1 < SIDE).then(|| k + SIDE));
        }
        seen[cell(to)]
    }
}

impl FreeSpace<2> for Discs {
    fn free(&self, from: &[f64; 2], to: &[f64; 2]) -> bool {
        self.clearance(from, to) > 0.0
    }

    fn obstruction(&self, joints: &[f64; 2]) -> Option<String> {
        let inside =
            |(center, radius): &([f64; 2], f64)| (joints[0] - center[0]).hypot(joints[1] - center[1]) <= *radius;
        self.0.iter().position(inside).map(|k| format!("disc {k}"))
    }
}

#[test]
fn found_where_a_flood_with_room_gets_through_and_not_where_none_does() {
    let square = Bounds { lower: [-3.0; 2], upper: [3.0; 2], ..bounds(1.0, 5.0, 50.0) };
    let mut fixed = Fixed(7);
    let (mut through, mut shut, mut longer) = (0, 0, 0);
    for case in 0..150 {
        let mut disc = || ([6.0 * fixed.unit() - 3.0, 6.0 * fixed.unit() - 3.0], 0.3 + 0.5 * fixed.unit());
        let discs = Discs((0..22).map(|_| disc()).collect());
        let ends = ([-2.9, -2.9], [2.9, 2.9]);
        let options = TransferOptions { seed: case, ..TransferOptions::default() };
        let planned = plan_transfer("across", &ends.0, &ends.1, &square, &discs, &options).unwrap();
        match &planned {
            Planned::Found(transfer) => {
                let corners = transfer.corners();
                assert_eq!((corners[0], corners[corners.len() - 1]), ends);
                assert!(corners.windows(2).all(|line| discs.clearance(&line[0], &line[1]) > 0.0));
                assert_within(transfer, &square);
                // With a grid finer than the discs, a flood with half a cell less room gets through too.
                assert!(discs.flood(&ends.0, &ends.1, -0.05), "case {case}");
                longer += usize::from(corners.len() > 2);
                assert_eq!(plan_transfer("across", &ends.0, &ends.1, &square, &discs, &options).unwrap(), planned);
            }
            Planned::Collides { end, with, .. } => {
                let at = if *end == End::Start { ends.0 } else { ends.1 };
                assert_eq!(discs.obstruction(&at).as_ref(), Some(with));
            }
            Planned::NoPath { name, from, to, iterations, reached } => {
                assert_eq!((name.as_str(), (*from, *to), *iterations), ("across", ends, 5000));
                assert!(reached.iter().all(|&count| count >= 1));
                shut += 1;
            }
        }
        if discs.flood(&ends.0, &ends.1, 0.08) && !matches!(planned, Planned::Collides { .. }) {
            assert!(matches!(planned, Planned::Found(_)), "case {case}: {planned}");
            through += 1;
        }
    }
    println!("{through} with room, {shut} shut, {longer} around");
    assert!(through > 10 && shut > 10 && longer > 10);
}

#[test]
fn shortening_saves_time_and_never_loses_any() {
    let wall = Discs((0..12).map(|k| ([0.0, -3.0 + 0.4 * f64::from(k)], 0.35)).collect());
    let square = Bounds { lower: [-3.0; 2], upper: [3.0; 2], ..bounds(1.0, 5.0, 50.0) };
    let duration = |shortcuts: usize| {
        let options = TransferOptions { shortcuts, reach: 6.0, ..TransferOptions::default() };
        let planned = plan_transfer("", &[-1.0, -2.0], &[1.0, -2.0], &square, &wall, &options).unwrap();
        planned.found().unwrap().duration()
    };
    let times: Vec<f64> = [0, 20, 100, 400].map(duration).into();
    println!("{times:?}");
    assert!(times.windows(2).all(|pair| pair[1] <= pair[0]));
    // The wall ends at (0, 1.75), and a line past its last disc would meet the middle at 3.28, above the stop at 3: two
    // corners are needed, about (-0.37, 1.75) and its mirror image. Joint 2 takes the time of the long lines, joint 1
    // that of the short one.
    let best = 2.0 * slow_duration(3.75, 1.0, 5.0, 50.0) + slow_duration(0.74, 1.0, 5.0, 50.0);
    assert!(times[3] < 1.02 * best, "{} {best}", times[3]);
}

#[test]
fn a_joint_stays_within_its_stops() {
    // The short way round is shut, and the stops of joint 1 leave only the way over.
    let wall = |a: &[f64; 2], b: &[f64; 2]| {
        let crossing = a[1] + (b[1] - a[1]) * (a[0] / (a[0] - b[0]));
        a[0] * b[0] > 0.0 || (a[0].abs() + b[0].abs() > 0.0 && crossing > 1.0)
    };
    let stops = Bounds { lower: [-1.2, -0.3], upper: [1.2, 1.4], ..bounds(1.0, 5.0, 50.0) };
    let planned = plan_transfer("", &[-1.0, 0.0], &[1.0, 0.0], &stops, &wall, &TransferOptions::default()).unwrap();
    let transfer = planned.found().unwrap();
    assert!(transfer.corners().iter().all(|q| q[1] <= 1.4 && q[1] >= -0.3 && q[0].abs() <= 1.2));
    assert_within(&transfer, &stops);
    // Without room above it nothing is found.
    let low = Bounds { upper: [1.2, 0.9], ..stops };
    let options = TransferOptions { iterations: 300, ..TransferOptions::default() };
    let planned = plan_transfer("4 to 5", &[-1.0, 0.0], &[1.0, 0.0], &low, &wall, &options).unwrap();
    let text = planned.to_string();
    assert!(text.starts_with("transfer 4 to 5: no way in 300 attempts"), "{text}");
    assert!(planned.found().is_none());
}

/// Durations of lines add up with rounding: the end of the sum is the end of the motion all the same.
#[test]
fn a_motion_of_several_lines_rests_at_its_end() {
    let bounds = Bounds {
        velocity: [0.1, 0.1, 0.294_531_926_849_952_55],
        acceleration: [0.1, 0.1, 9.384_195_147_984_926],
        jerk: [0.1, 0.1, 12.787_958_050_907_996],
        lower: [-3.0; 3],
        upper: [3.0; 3],
    };
    let places = [-0.763_118_863_746_840_7, 1.915_945_429_274_235_5, 0.206_988_840_757_458_3];
    let corners = places.map(|place| [0.0, 0.0, place]);
    for from in 0..2 {
        assert_within(&Transfer::through(corners[from..].to_vec(), &bounds).unwrap(), &bounds);
    }
}

/// Walls that no posture is in: only proofs see them. Postures let the trees through, and what is behind is cut off.
#[test]
fn walls_without_thickness_are_kept_clear_of() {
    let crosses = |a: &[f64; 2], b: &[f64; 2], x: f64, open: [f64; 2]| {
        let crossing = a[1] + (b[1] - a[1]) * ((x - a[0]) / (b[0] - a[0]));
        (a[0] - x) * (b[0] - x) < 0.0 && !(open[0]..=open[1]).contains(&crossing)
    };
    let free = |a: &[f64; 2], b: &[f64; 2]| !(crosses(a, b, -0.5, [0.6, 1.0]) || crosses(a, b, 0.5, [-1.0, -0.6]));
    let square = Bounds { lower: [-1.0; 2], upper: [1.0; 2], ..bounds(1.0, 5.0, 50.0) };
    for seed in 0..20 {
        let options = TransferOptions { seed, step: 0.3, ..TransferOptions::default() };
        let planned = plan_transfer("", &[-1.0, 0.0], &[1.0, 0.0], &square, &free, &options).unwrap();
        let transfer = planned.found().unwrap();
        let corners = transfer.corners();
        assert!(corners.len() > 3 && corners.windows(2).all(|line| free(&line[0], &line[1])), "{corners:?}");
    }
}

#[test]
fn trivial_motions() {
    let free = |_: &[f64; 2], _: &[f64; 2]| true;
    let plan = |to| plan_transfer("", &[0.5, 0.5], &to, &bounds(1.0, 2.0, 4.0), &free, &TransferOptions::default());
    let still = plan([0.5, 0.5]).unwrap().found().unwrap();
    assert_eq!((still.duration(), still.at(0.3).position), (0.0, [0.5, 0.5]));
    let straight = plan([2.5, 0.5]).unwrap().found().unwrap();
    assert_eq!((straight.corners().len(), straight.iterations()), (2, 0));
    approx::assert_relative_eq!(straight.duration(), slow_duration(2.0, 1.0, 2.0, 4.0), max_relative = 1e-8);
    let nothing = Transfer::<2>::through(vec![], &bounds(1.0, 1.0, 1.0)).unwrap();
    assert_eq!((nothing.duration(), nothing.at(1.0).position, nothing.knots()), (0.0, [0.0; 2], vec![0.0]));
    assert_eq!(SCurve::new(1.0, f64::INFINITY, 1.0, 1.0), None);
    assert_eq!(SCurve::new(f64::NAN, 1.0, 1.0, 1.0), None);
    assert_eq!(SCurve::new(1.0, 1.0, 0.0, 1.0), None);
}

#[test]
fn planning_errors() {
    let free = |_: &[f64; 2], _: &[f64; 2]| true;
    let sound = Bounds { lower: [-1.0; 2], upper: [1.0; 2], ..bounds(1.0, 2.0, 4.0) };
    let options = TransferOptions::default();
    let plan = |from, to, bounds: &Bounds<2>, options: &TransferOptions| {
        plan_transfer("p", &from, &to, bounds, &free, options).unwrap_err()
    };
    assert_eq!(
        plan([0.0, 1.5], [0.0; 2], &sound, &options),
        TransferError::OutOfBounds { name: "p".into(), end: End::Start, joint: 1, value: 1.5, lower: -1.0, upper: 1.0 }
    );
    let wild = plan([0.0; 2], [f64::NAN, 0.0], &sound, &options);
    assert!(matches!(wild, TransferError::OutOfBounds { end: End::Goal, joint: 0, .. }));
    let endless = Bounds { jerk: [4.0, f64::INFINITY], ..sound };
    assert_eq!(
        plan([0.0; 2], [0.0; 2], &endless, &options),
        TransferError::Bound { joint: 1, what: "jerk", value: f64::INFINITY }
    );
    let still = TransferOptions { step: 0.0, ..options };
    assert_eq!(plan([0.0; 2], [0.0; 2], &sound, &still), TransferError::Option { what: "step", value: 0.0 });
    let dense = TransferOptions { spacing: f64::NAN, ..options };
    let error = plan([0.0; 2], [0.0; 2], &sound, &dense);
    assert!(matches!(error, TransferError::Option { what: "spacing", .. }));
    let far = TransferOptions { reach: f64::INFINITY, ..options };
    assert_eq!(plan([0.0; 2], [0.0; 2], &sound, &far), TransferError::Option { what: "reach", value: f64::INFINITY });
    // What would take steps without end is refused before the first one.
    let free = Bounds { lower: [f64::NEG_INFINITY; 2], upper: [f64::INFINITY; 2], ..sound };
    for goal in [1e300, -f64::MAX, 1e6] {
        let error = plan([0.0; 2], [goal, 0.0], &free, &options);
        assert!(matches!(error, TransferError::TooFar { step: 0.1, .. }), "{error}");
    }
    let wide = TransferOptions { reach: 1e300, ..options };
    assert!(matches!(plan([0.0; 2], [0.5; 2], &free, &wide), TransferError::TooFar { .. }));
    let corners = vec![[0.0; 2], [0.0, f64::INFINITY]];
    let error = Transfer::through(corners, &sound).unwrap_err();
    assert!(matches!(error, TransferError::OutOfBounds { end: End::Goal, joint: 1, .. }));
    // A closure has no names for what is in the way.
    let shut = |a: &[f64; 2], _: &[f64; 2]| a[0] < 0.5;
    let planned = plan_transfer("p", &[0.0; 2], &[0.7, 0.0], &sound, &shut, &options).unwrap();
    assert_eq!(planned, Planned::Collides { name: "p".into(), end: End::Goal, with: "something".into() });
    assert_eq!(planned.to_string(), "transfer p: something is in the way at the goal");
}
