//! What an arm does with a stream of `servoj`, by a simulation of the control law as its maker describes it, and signals that wait
//! for it.

use curvlay_kinematics::print_program::{StreamOptions, StreamSegment, print_stream};
use curvlay_kinematics::program::{ServoRate, Step, UrScriptOptions, UrScriptReader, write_urscript};
use std::f64::consts::TAU;

/// The arm under `servoj`: the gain works as the P-term of a PID controller towards the target, the look-ahead time as its
/// D-term, which projects the present position forward (URScript manual, `servoj`). Targets change every 8 ms, the
/// law is integrated in steps of 0.1 ms.
fn followed(target: impl Fn(f64) -> f64, duration_s: f64, gain: f64, lookahead_s: f64) -> Vec<(f64, f64)> {
    const STEP: f64 = 1e-4;
    let (mut at, mut speed) = (target(0.0), 0.0);
    let steps = (duration_s / STEP) as u32;
    (0..steps)
        .map(|k| {
            let time = f64::from(k) * STEP;
            let wanted = target((time / 0.008).floor() * 0.008);
            speed += STEP * gain * (wanted - at - lookahead_s * speed);
            at += STEP * speed;
            (time + STEP, at)
        })
        .collect()
}

/// How far from a circle of 5 mm the tip goes at 40 mm/s, once it is under way, in millimetres.
fn off_circle(gain: f64, lookahead_s: f64) -> f64 {
    let (radius, rate) = (5.0, 40.0 / 5.0);
    let along =
        |phase: f64| followed(move |time| radius * (rate * time + phase).cos(), 2.0 * TAU / rate, gain, lookahead_s);
    let half = |(time, _): &(f64, f64)| *time > TAU / rate;
    along(0.0)
        .into_iter()
        .zip(along(-TAU / 4.0))
        .filter(|(x, _)| half(x))
        .map(|((_, x), (_, y))| (x.hypot(y) - radius).abs())
        .fold(0.0, f64::max)
}

#[test]
fn the_defaults_keep_to_the_path_and_softer_ones_do_not() {
    let UrScriptOptions { gain, lookahead_s, .. } = UrScriptOptions::default();
    let (ours, before) = (off_circle(gain, lookahead_s), off_circle(300.0, 0.1));
    println!("{ours:.3} mm, {before:.3} mm with a gain of 300 and 0.1 s");
    assert!(ours < 0.05, "{ours}");
    assert!(before > 0.4, "{before}");
}

#[test]
fn the_arm_is_behind_by_the_look_ahead_time() {
    for (gain, lookahead_s) in [(2000.0, 0.03), (300.0, 0.1)] {
        let (time, at) = followed(|time| 40.0 * time, 2.0, gain, lookahead_s)[19_999];
        // A target stands for a cycle: that is half a cycle more on average.
        assert!((time - at / 40.0 - lookahead_s - 0.004).abs() < 5e-3, "{}", time - at / 40.0);
    }
}

fn leg(duration_s: f64, prints: bool) -> StreamSegment<impl Fn(f64) -> [f64; 6], impl Fn(f64) -> f64> {
    let joints = move |time: f64| [0.1 * time, 0.0, 0.0, 0.0, 0.0, 0.0];
    StreamSegment { duration_s, joints, filament_mm: prints.then_some(|time: f64| 2.0 * time), signals: Vec::new() }
}

/// For each signal, after how many steps of the stream it comes.
fn signals(steps: &[Step]) -> Vec<(usize, Step)> {
    let mut servos = 0;
    let mut found = Vec::new();
    for step in steps {
        match step {
            Step::Servo { .. } => servos += 1,
            Step::Move(_) => {}
            signal => found.push((servos, *signal)),
        }
    }
    found
}

#[test]
fn signals_come_as_much_later_as_the_arm_is_behind() {
    for (rate, lag_s, ticks) in [(ServoRate::Hz125, 0.03, 4), (ServoRate::Hz500, 0.03, 15), (ServoRate::Hz500, 0.0, 0)]
    {
        let stream = |lag_s: f64| -> Vec<Step> {
            let options = StreamOptions { rate, lag_s, ..StreamOptions::default() };
            let legs = [leg(0.1, false), leg(0.4, true), leg(0.2, false), leg(0.3, true)];
            print_stream([[0.0; 6], [0.03, 0.0, 0.0, 0.0, 0.0, 0.0]], legs, options).collect()
        };
        let (at_once, delayed) = (stream(0.0), stream(lag_s));
        let later: Vec<_> = signals(&at_once).into_iter().map(|(servos, step)| (servos + ticks, step)).collect();
        assert_eq!(signals(&delayed), later);
        // The arm is held until the last of them.
        let servos = |steps: &[Step]| -> Vec<Step> {
            steps.iter().filter(|step| matches!(step, Step::Servo { .. })).copied().collect()
        };
        let (before, after) = (servos(&at_once), servos(&delayed));
        assert_eq!(after[..before.len()], before);
        let held = &after[before.len()..];
        assert!(held.len() + 1 >= ticks && held.len() <= ticks && held.iter().all(|step| Some(step) == before.last()));
    }
}

/// By the count of steps before each signal. Where the first signal has fewer before it, the first posture is held.
#[test]
fn signals_come_as_much_earlier_as_the_equipment_takes() {
    let of = |idle_s: f64, lag_s: f64| -> Vec<Step> {
        let options = StreamOptions { lag_s, ..StreamOptions::default() };
        let legs = [leg(idle_s, false), leg(0.02, true), leg(0.3, false), leg(0.3, true)];
        print_stream([[0.0; 6], [0.03, 0.0, 0.0, 0.0, 0.0, 0.0]], legs, options).collect()
    };
    let servos = |steps: &[Step]| -> Vec<Step> {
        steps.iter().filter(|step| matches!(step, Step::Servo { .. })).copied().collect()
    };
    // 62 ticks are half a second.
    for (idle_s, lag_s, early, held) in [
        (0.2, -0.08, 10, 0),
        (0.08, -0.08, 10, 0),
        (0.04, -0.08, 10, 5),
        (0.0, -0.08, 10, 10),
        (0.4, -0.5, 63, 13),
        (0.4, f64::NEG_INFINITY, 63, 13),
        (0.2, f64::NAN, 0, 0),
    ] {
        let (at_once, earlier) = (of(idle_s, 0.0), of(idle_s, lag_s));
        let expected: Vec<_> =
            signals(&at_once).into_iter().map(|(count, step)| (count + held - early, step)).collect();
        assert_eq!(signals(&earlier), expected, "{idle_s} {lag_s}");
        let before = servos(&at_once);
        let expected: Vec<Step> = std::iter::repeat_n(before[0], held).chain(before).collect();
        assert_eq!(servos(&earlier), expected, "{idle_s} {lag_s}");
        assert!(matches!(earlier[0], Step::Move(_)));
    }
}

#[test]
fn a_file_that_starts_itself_calls_its_function() {
    let write = |starts: bool| {
        let mut file = Vec::new();
        let steps: Vec<Step> = print_stream([[0.0; 6]; 2], [leg(0.1, true)], StreamOptions::default()).collect();
        write_urscript(steps, &UrScriptOptions { starts, ..UrScriptOptions::default() }, &mut file).unwrap();
        String::from_utf8(file).unwrap()
    };
    let (called, sent) = (write(true), write(false));
    assert_eq!(called, format!("{sent}curvlay()\n"));
    for text in [called, sent] {
        assert!(UrScriptReader::new(text.as_bytes()).unwrap().all(|step| step.is_ok()));
    }
    let other = write(false) + "other()\n";
    assert!(UrScriptReader::new(other.as_bytes()).unwrap().any(|step| step.is_err()));
}
