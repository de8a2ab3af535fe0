//! Time stamps and defects.

use approx::assert_abs_diff_eq;
use curvlay_trajectory::nalgebra::{Point3, Vector3};
use curvlay_trajectory::{Defect, PathError, PathOptions, TimedPath, Timing, jerk_measure, timed_path, waypoint_jerks};
use proptest::prelude::*;

fn line(count: usize) -> (Vec<Point3<f64>>, Vec<Vector3<f64>>) {
    ((0..count).map(|k| Point3::new(0.5 * k as f64, 0.0, 1.0)).collect(), vec![Vector3::z(); count])
}

fn with_feed((positions, normals): &(Vec<Point3<f64>>, Vec<Vector3<f64>>)) -> TimedPath {
    timed_path(positions, normals, Timing::Feed(5.0), &PathOptions::default()).unwrap()
}

#[test]
fn a_sound_path_is_one_piece() {
    let path = with_feed(&line(11));
    assert_eq!((path.segments.len(), path.defects.len()), (1, 0));
    assert_eq!(path.segments[0].waypoints, (0..11).collect::<Vec<_>>());
    assert_abs_diff_eq!(path.segments[0].times[10], 1.0, epsilon = 1e-12);
}

#[test]
fn every_defect_is_named_and_split_at() {
    let mut given = line(40);
    given.0[4] = given.0[3]; // repeated
    given.1[5] *= 3.0; // only long
    given.0[10].y = f64::NAN;
    given.1[20] = Vector3::zeros();
    given.1[26..].iter_mut().for_each(|n| *n = -Vector3::z());
    given.0[32..].iter_mut().for_each(|p| p.z += 50.0);
    given.0[36..].iter_mut().for_each(|p| p.z += 50.0);
    let path = with_feed(&given);
    let found: Vec<(usize, &str)> = path
        .defects
        .iter()
        .map(|defect| {
            let kind = match defect {
                Defect::NotFinite { .. } => "number",
                Defect::NoNormal { .. } => "normal",
                Defect::Repeated { .. } => "repeated",
                Defect::Jump { .. } => "jump",
                Defect::Flip { .. } => "flip",
                Defect::Short { count: 4, .. } => "short",
                _ => "other",
            };
            (defect.waypoint(), kind)
        })
        .collect();
    let expected = [
        (4, "repeated"),
        (10, "number"),
        (20, "normal"),
        (26, "flip"),
        (32, "jump"),
        (32, "short"),
        (36, "jump"),
        (36, "short"),
    ];
    assert_eq!(found, expected);
    let ends: Vec<_> = path.segments.iter().map(|p| (p.waypoints[0], *p.waypoints.last().unwrap())).collect();
    assert_eq!(ends, [(0, 9), (11, 19), (21, 25), (26, 31)]);
    assert!(path.segments.iter().all(|p| p.times[0].abs() < 1e-15 && p.times.windows(2).all(|t| t[0] < t[1])));
    assert!(path.segments.iter().flat_map(|p| &p.normals).all(|n| (n.norm() - 1.0).abs() < 1e-12));
    assert_eq!(path.defects[3].to_string(), "waypoint 26: the normal turns by 180.0 degrees; path split");
}

#[test]
fn given_times_that_do_not_rise_split() {
    let (positions, normals) = line(12);
    let mut times: Vec<f64> = (0..12).map(|k| 0.125 * f64::from(k)).collect();
    times[6..].iter_mut().for_each(|t| *t -= 0.125);
    let path = timed_path(&positions, &normals, Timing::Given(&times), &PathOptions::default()).unwrap();
    assert_eq!(path.defects, [Defect::Time { waypoint: 6, time: times[6], before: times[5] }]);
    assert_eq!(path.segments.len(), 2);
    assert_eq!(path.segments[1].times, times[6..]);
    times[8] = f64::NAN;
    let path = timed_path(&positions, &normals, Timing::Given(&times), &PathOptions::default()).unwrap();
    assert!(path.defects.contains(&Defect::NotFinite { waypoint: 8 }));
}

#[test]
fn lists_and_options_that_cannot_be() {
    let (positions, normals) = line(6);
    let options = PathOptions::default();
    assert_eq!(
        timed_path(&positions, &normals[..5], Timing::Feed(5.0), &options),
        Err(PathError::Count { positions: 6, normals: 5, times: 6 })
    );
    assert!(matches!(
        timed_path(&positions, &normals, Timing::Given(&[0.0]), &options),
        Err(PathError::Count { times: 1, .. })
    ));
    for feed in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = timed_path(&positions, &normals, Timing::Feed(feed), &options);
        assert!(matches!(found, Err(PathError::Option { what: "feed", .. })));
    }
    let bad = PathOptions { jump: f64::NAN, ..options };
    let found = timed_path(&positions, &normals, Timing::Feed(5.0), &bad);
    assert!(matches!(found, Err(PathError::Option { what: "jump", .. })));
    let nothing = timed_path(&[], &[], Timing::Feed(5.0), &options).unwrap();
    assert_eq!((nothing.segments.len(), nothing.defects.len()), (0, 0));
    assert_eq!(with_feed(&line(4)).defects, [Defect::Short { waypoint: 0, count: 4 }]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn pieces_and_left_out_waypoints_are_all(
        moves in prop::collection::vec((prop_oneof![5 => 0.1..2.0f64, 1 => Just(0.0), 1 => 20.0..30.0f64], -1.2..1.2f64), 0..60)
    ) {
        let mut at = 0.0;
        let positions: Vec<_> = moves.iter().map(|m| { at += m.0; Point3::new(at, 0.0, 0.0) }).collect();
        let normals: Vec<_> = moves.iter().map(|m| Vector3::new(m.1.sin(), 0.0, m.1.cos())).collect();
        let options = PathOptions::default();
        let path = timed_path(&positions, &normals, Timing::Feed(2.0), &options).unwrap();
        let mut seen: Vec<usize> = path.segments.iter().flat_map(|p| p.waypoints.clone()).collect();
        prop_assert!(seen.is_sorted());
        for defect in &path.defects {
            match *defect {
                Defect::Repeated { waypoint, .. } => seen.push(waypoint),
                Defect::Short { count, .. } => seen.extend(std::iter::repeat_n(usize::MAX, count)),
                _ => {}
            }
        }
        prop_assert_eq!(seen.len(), moves.len());
        let kept: usize = path.segments.iter().map(|p| p.waypoints.len()).sum();
        prop_assert_eq!(kept + path.left_out(), moves.len());
        let short = path.defects.iter().any(|defect| matches!(defect, Defect::Short { .. }));
        prop_assert_eq!(path.clone().require_complete().is_err(), short);
        for piece in &path.segments {
            for k in 1..piece.times.len() {
                let distance = (piece.positions[k] - piece.positions[k - 1]).norm();
                prop_assert!(distance <= options.jump && distance >= options.repeat);
                prop_assert!(piece.normals[k].angle(&piece.normals[k - 1]) <= options.flip);
                assert_abs_diff_eq!(piece.times[k] - piece.times[k - 1], distance / 2.0, epsilon = 1e-9);
            }
        }
    }

    /// Quartics are met exactly, whatever the times.
    #[test]
    fn jerks_of_quartics_are_exact(c in prop::array::uniform5(-2.0..2.0f64), steps in prop::collection::vec(0.1..0.5f64, 0..12)) {
        let times: Vec<f64> = steps.iter().scan(-1.0, |t, s| { *t += s; Some(*t) }).collect();
        let value = |t: f64| c.iter().rev().fold(0.0, |sum, c| sum * t + c);
        let joints: Vec<[f64; 2]> = times.iter().map(|&t| [value(t), 7.0]).collect();
        let jerks = waypoint_jerks(&times, &joints);
        prop_assert_eq!(jerks.len(), times.len().saturating_sub(4));
        for (k, jerk) in jerks.iter().enumerate() {
            assert_abs_diff_eq!(jerk[0], 6.0 * c[3] + 24.0 * c[4] * times[k + 2], epsilon = 1e-8);
            assert_abs_diff_eq!(jerk[1], 0.0, epsilon = 1e-12);
        }
        let sum: f64 = jerks.iter().map(|j| j[0] * j[0] + j[1] * j[1]).sum();
        assert_abs_diff_eq!(jerk_measure(&times, &joints), sum, epsilon = 1e-12 * (1.0 + sum));
    }
}

#[test]
fn the_measure_is_blind_to_a_sawtooth_and_the_spline_is_not() {
    use curvlay_trajectory::{RunIn, Timeline, Trajectory};
    let times: Vec<f64> = (0..20).map(|k| 0.2 * f64::from(k)).collect();
    let saw: Vec<[f64; 1]> = (0..20).map(|k| [if k % 2 == 0 { 0.01 } else { -0.01 }]).collect();
    assert!(jerk_measure(&times, &saw) < 1e-20);
    let line = Timeline::new(&times, RunIn::default()).unwrap();
    assert!(Trajectory::through(&line, &saw).unwrap().squared_jerk_printing() > 100.0);
}
