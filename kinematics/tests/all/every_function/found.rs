//! What the properties of this folder found, each by itself.

use super::calibrations::sound_poses;
use super::numbers::go;
use crate::common::cells::ur3;
use crate::common::{ROBOTS, arm};
use curvlay_kinematics::nalgebra::Point3;
use curvlay_kinematics::print_program::*;
use curvlay_kinematics::program::link::{LinkMessage, LinkOptions, LinkSender};
use curvlay_kinematics::program::ur_stream::{UrSenderOptions, UrStreamJob, UrStreamOptions, UrStreamSender, UrTick};
use curvlay_kinematics::program::{Step, TurnChoice, UrScriptOptions, write_urscript};
use curvlay_kinematics::*;
use std::time::Duration;

#[test]
fn fits_end_whatever_a_radian_weighs() {
    let model = ROBOTS[0].1;
    let poses = sound_poses(&arm(model));
    for radian_mm in [1e308, f64::MAX, 5e-324, 1e15] {
        let options = FitOptions { radian_mm, ..FitOptions::default() };
        let error = fit_arm(model, &poses, &options).unwrap_err();
        assert!(matches!(error, FitError::Option { option: "radian_mm", .. }), "{error}");
        let options = FitOptions { open: radian_mm, ..FitOptions::default() };
        assert!(matches!(fit_arm(model, &poses, &options), Err(FitError::Option { option: "open", .. })));
    }
    assert!(fit_arm(model, &poses, &FitOptions { radian_mm: 1e6, ..FitOptions::default() }).is_ok());
}

#[test]
fn fits_without_iterations_are_not_converged() {
    let model = ROBOTS[0].1;
    let mut poses = sound_poses(&arm(model));
    poses.iter_mut().for_each(|pose| pose.position.x += 0.3 * pose.joints[1]);
    let fit = fit_arm(model, &poses, &FitOptions { max_iterations: 0, ..FitOptions::default() }).unwrap();
    assert!(!fit.is_converged && fit.iterations == 0);
}

#[test]
fn without_waypoints_a_fixture_stands_in_the_middle() {
    let (min, max) = (Point3::new(-50.0, -50.0, 0.0), Point3::new(50.0, 50.0, 40.0));
    let region = FixtureRegion { min, max, coarse_mm: 20.0, fine_mm: 1.0 };
    let assess = |_: &Point3<f64>| Some(|_: usize, _: &Waypoint| None);
    let found = best_fixture_place(&region, &[], 1.0, assess, &go).unwrap();
    assert!((found.place - Point3::new(0.0, 0.0, 20.0)).norm() <= 15.0, "{found:?}");
}

fn knots(time_s: f64) -> Vec<PrintKnot<6>> {
    let knot = |k: usize| PrintKnot { time_s: 0.2 * k as f64, joints: [0.1 + 0.02 * k as f64; 6], filament_mm: 0.1 };
    let mut knots: Vec<PrintKnot<6>> = (0..5).map(knot).collect();
    knots[2].time_s = time_s;
    knots
}

#[test]
fn blended_moves_that_are_no_number_are_refused_by_the_writer() {
    for joint in [f64::NAN, f64::INFINITY] {
        let mut samples = knots(0.4);
        samples[2].joints[1] = joint;
        let cell = ur3();
        let segments = [BlendedSegment { samples, prints: true }];
        let mut printed = print_blended(&cell, segments, BlendOptions::default());
        let steps: Vec<Step> = printed.by_ref().collect();
        let written = write_urscript(steps, &UrScriptOptions::default(), std::io::sink());
        assert!(written.is_err() || printed.dropped() > 0, "{joint}: {written:?}");
    }
}

#[test]
fn streams_leave_out_legs_of_any_length() {
    let leg = |duration_s: f64| StreamSegment {
        duration_s,
        joints: |t: f64| [t; 6],
        filament_mm: None::<fn(f64) -> f64>,
        signals: vec![],
    };
    let count = |legs: Vec<f64>| {
        print_stream([[0.0; 6]; 2], legs.into_iter().map(leg), StreamOptions::default()).take(1000).count()
    };
    let alone = count(vec![0.1]);
    for long in [1e308, f64::MAX, 1e15] {
        assert_eq!(count(vec![long, 0.1, long]), alone, "{long}");
    }
}

#[test]
fn choices_of_other_paths_begin_at_the_first_point() {
    let turns = [0.0, 1.0, 2.0];
    for start in [3, 70, usize::MAX] {
        let choice = TurnChoice { start, reversed: false, shift: 1.0, travel: 0.0 };
        assert_eq!((choice.turned(&turns), choice.ordered(&turns)), (vec![1.0, 2.0, 3.0], turns.to_vec()));
        assert!(choice.turned(&[]).is_empty() && choice.ordered::<f64>(&[]).is_empty());
    }
}

#[test]
fn senders_take_any_time() {
    let messages = || [LinkMessage::Home; 3].map(Ok).into_iter();
    for (retry, now) in [(Duration::MAX, Duration::from_secs(1)), (Duration::from_secs(1), Duration::MAX)] {
        let options = LinkOptions { retry, max_pause: retry, ..LinkOptions::default() };
        let mut sender = LinkSender::new(messages(), options).unwrap();
        sender.connected().unwrap();
        assert!(sender.next_frame(now).unwrap().is_some());
        assert_eq!(sender.deadline(), Some(Duration::MAX));
    }
    let tick = UrTick { joints: [0.0; 6], filament_mm_s: None, move_rad_s: None };
    let job = UrStreamJob { number: 1, ticks: 1 };
    let mut sender = UrStreamSender::new([Ok(tick)].into_iter(), job, UrSenderOptions::default()).unwrap();
    let _ = (sender.connected(Duration::MAX), sender.next_frame(Duration::MAX));
    assert_eq!(sender.deadline(), Duration::MAX);
}

#[test]
fn streams_have_a_heartbeat_whatever_silence_is() {
    for (silence_s, wanted) in [(f64::NAN, 0.01), (f64::INFINITY, 12.0), (-1.0, 0.01), (1.0, 0.2)] {
        let options = UrStreamOptions { silence_s, ..UrStreamOptions::default() };
        assert_eq!(options.sender().heartbeat, Duration::from_secs_f64(wanted), "{silence_s}");
    }
}
