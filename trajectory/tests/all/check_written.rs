//! The check of a written print, against [`check_print`] asked by hand, and what it makes of faults.
#![allow(clippy::float_cmp)] // what is copied is equal bit for bit

use crate::common::quiet;
use curvlay_trajectory::check::{
    CheckError, CheckOptions, CheckedMotion, Contact, FindingClass, FindingPlace, GrowingPrintScene, MotionKind,
    PathPoint, PrintSceneFn, WrittenMotion, WrittenReport, check_print, check_written,
};
use curvlay_trajectory::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use curvlay_trajectory::print::{Moment, SegmentKind, Waypoint};
use curvlay_trajectory::transfer::Transfer;
use curvlay_trajectory::{Bounds, Progress};
use std::ops::ControlFlow;

/// Three linear axes, 1 mm a radian, over a part that stands 3 mm to the right of the frame of what carries it.
fn nozzle(q: &[f64; 3]) -> Option<Isometry3<f64>> {
    Some(Isometry3::translation(q[0], q[1], q[2]))
}

fn frame_part() -> Isometry3<f64> {
    Isometry3::translation(3.0, 0.0, 0.0)
}

fn bounds() -> Bounds<3> {
    Bounds { velocity: [10.0; 3], acceleration: [20.0; 3], jerk: [200.0; 3], ..Bounds::NONE }
}

/// A path a layer: 10 mm along x, 1 mm higher each.
fn paths(count: usize) -> Vec<Vec<Waypoint>> {
    let at = |x: usize, z: usize| Waypoint { position: Point3::new(x as f64, 0.0, z as f64), axis: Vector3::z_axis() };
    (0..count).map(|z| (0..=10).map(|x| at(x, z)).collect()).collect()
}

/// A motion through some corners, from rest to rest, that begins at `start`.
fn motion(kind: SegmentKind, number: usize, start: f64, corners: &[[f64; 3]]) -> WrittenMotion<3> {
    let way = Transfer::through(corners.to_vec(), &bounds()).unwrap();
    let mut times = way.knots();
    times.dedup_by(|b, a| *b - *a < 1e-6);
    let joints = times.iter().map(|&time| way.at(time).position).collect();
    let last = times.len() - 1;
    let times: Vec<f64> = times.into_iter().map(|time| start + time).collect();
    let waypoints = if kind == SegmentKind::Print { vec![(0, times[0]), (10, times[last])] } else { vec![] };
    WrittenMotion { kind, layer: number as u32, path: number, times, joints, waypoints }
}

/// The whole print: along each path, up, over and down to the next.
fn print(count: usize) -> Vec<WrittenMotion<3>> {
    let mut motions: Vec<WrittenMotion<3>> = vec![];
    for k in 0..count {
        let z = k as f64;
        let [start, end] = [3.0, 13.0].map(|x| [x, 0.0, z]);
        let above = |[x, y, z]: [f64; 3]| [x, y, z + 5.0];
        let next = [3.0, 0.0, z + 1.0];
        let all = [
            (SegmentKind::Print, k, vec![start, end]),
            (SegmentKind::Lift, k, vec![end, above(end)]),
            (SegmentKind::Transfer, k, vec![above(end), above(next)]),
            (SegmentKind::Approach, k, vec![above(next), next]),
        ];
        for (kind, number, corners) in all.into_iter().take(if k + 1 < count { 4 } else { 1 }) {
            let begin = motions.last().map_or(0.0, |motion| *motion.times.last().unwrap());
            motions.push(motion(kind, number, begin, &corners));
        }
    }
    motions
}

/// Layers are one millimetre thick and are as deep as the nozzle is below their top; a wall that transfers must not pass.
#[derive(Clone)]
struct Layers {
    built: u32,
    asked: Vec<u32>,
    wall: Option<f64>,
    refused: Option<u32>,
}

const FREE: Layers = Layers { built: 0, asked: vec![], wall: None, refused: None };

impl Layers {
    fn depth(&self, moment: Moment, nozzle: &Waypoint) -> Option<Contact> {
        let top = match moment {
            Moment::At { path, waypoint } => path as f64 - f64::from(u8::from(waypoint > 10)),
            Moment::After { path } => path as f64 + 1.0,
        };
        let depth_mm = top - nozzle.position.z;
        (depth_mm > 1e-6).then(|| Contact { depth_mm, what: format!("{} layers", self.built) })
    }
}

impl GrowingPrintScene<3> for Layers {
    fn begin(&mut self, layer: u32) -> Result<(), String> {
        self.built = layer + 1;
        self.asked.push(layer);
        if self.refused == Some(layer) { Err("no room".into()) } else { Ok(()) }
    }

    fn nozzle(&self, joints: &[f64; 3]) -> Option<Isometry3<f64>> {
        nozzle(joints)
    }

    fn contact(&self, moment: Moment, nozzle: &Waypoint) -> Option<Contact> {
        self.depth(moment, nozzle)
    }

    fn sweep(&self, is_transfer: bool, control: &[[f64; 3]; 4]) -> Option<String> {
        let wall = self.wall.filter(|_| is_transfer)?;
        control.iter().any(|q| q[0] > wall).then(|| format!("wall beside {} layers", self.built))
    }
}

fn judge(motions: &[WrittenMotion<3>], paths: &[Vec<Waypoint>], scene: &mut Layers) -> WrittenReport<3> {
    let options = CheckOptions::default();
    check_written(motions, paths, &frame_part(), &bounds(), scene, &options, &quiet).unwrap()
}

#[test]
fn a_sound_print_has_no_findings_and_is_printed_whole() {
    let (motions, paths, mut scene) = (print(3), paths(3), FREE);
    let report = judge(&motions, &paths, &mut scene);
    assert!(report.print.is_ok(), "{:?}", report.print.findings);
    assert_eq!((report.path_mm, report.printed_mm, report.print.motions), (30.0, 30.0, 9));
    assert_eq!(scene.asked, [0, 1, 2]);
}

/// The same motions, each with its path and its questions written out by hand.
#[test]
fn it_is_the_check_of_each_motion_with_what_is_built_by_then() {
    let (mut motions, paths) = (print(3), paths(3));
    let scene = Layers { wall: Some(12.0), ..FREE };
    // The second path is printed 0.3 mm too low, which is off the path and in the layer.
    motions[4].joints.iter_mut().for_each(|joints| joints[2] -= 0.3);
    let point = |at: &Waypoint| PathPoint { position: at.position + Vector3::x() * 3.0, axis: at.axis, passed_s: None };
    let of: Vec<Vec<PathPoint>> = motions
        .iter()
        .map(|motion| {
            let mut points: Vec<PathPoint> =
                if motion.waypoints.is_empty() { vec![] } else { paths[motion.path].iter().map(point).collect() };
            motion.waypoints.iter().for_each(|&(waypoint, time)| points[waypoint].passed_s = Some(time));
            points
        })
        .collect();
    let lent: Vec<CheckedMotion<3>> = motions
        .iter()
        .zip(&of)
        .enumerate()
        .map(|(number, (motion, path))| CheckedMotion {
            kind: if motion.kind == SegmentKind::Print { MotionKind::Print } else { MotionKind::Travel },
            times: &motion.times,
            joints: &motion.joints,
            path,
            printing: None,
            apart: number == 0,
        })
        .collect();
    let at_layer = |motion: usize| Layers { built: motions[motion].layer + 1, ..scene.clone() };
    let by_hand = PrintSceneFn {
        nozzle,
        contact: |moment: &curvlay_trajectory::check::Moment, tip: &Point3<f64>, axis: &UnitVector3<f64>| {
            let path = motions[moment.motion].path;
            let then = match motions[moment.motion].kind {
                SegmentKind::Print => Moment::At { path, waypoint: moment.point },
                SegmentKind::Lift => Moment::At { path, waypoint: 10 },
                SegmentKind::Approach => Moment::After { path },
                SegmentKind::Transfer => return None,
            };
            at_layer(moment.motion).depth(then, &Waypoint { position: *tip, axis: *axis })
        },
        sweep: |motion: usize, _: usize, control: &[[f64; 3]; 4]| {
            at_layer(motion).sweep(motions[motion].kind == SegmentKind::Transfer, control)
        },
    };
    let expected = check_print(&lent, &bounds(), &by_hand, &CheckOptions::default(), &quiet).unwrap();
    let report = judge(&motions, &paths, &mut scene.clone());
    assert_eq!(report.print, expected);
    assert!(FindingClass::ALL[1..].iter().all(|&class| report.count(class) > 0), "{:?}", expected.findings);
    assert_eq!((report.count(FindingClass::Limits), report.count(FindingClass::Collisions)), (0, 2));
    let unsafe_motions = report.print.motions_with(FindingClass::is_unsafe);
    assert_eq!(unsafe_motions.into_iter().collect::<Vec<_>>(), [2, 4, 5, 6]);
    let low = report.places.iter().find(|place| place.kind == SegmentKind::Print).unwrap();
    assert_eq!(*low, FindingPlace { kind: SegmentKind::Print, layer: 1, path: 1 });
}

#[test]
fn what_no_motion_goes_along_is_not_printed_and_nothing_has_to_lead_to_what_stands_alone() {
    let paths = paths(2);
    let mut motions = print(2);
    // The transfer to the second path was not found, and of that path only a part is printed.
    motions.drain(1..4);
    motions[1] = motion(SegmentKind::Print, 1, motions[1].times[0], &[[5.0, 0.0, 1.0], [11.0, 0.0, 1.0]]);
    motions[1].waypoints = vec![(2, motions[1].times[0]), (8, *motions[1].times.last().unwrap())];
    let report = judge(&motions, &paths, &mut FREE.clone());
    assert!(report.print.is_ok(), "{:?}", report.print.findings);
    assert_eq!((report.path_mm, report.printed_mm, report.print.gaps), (20.0, 16.0, vec![1]));
}

#[test]
fn it_says_why_it_cannot_check() {
    let (motions, paths) = (print(2), paths(2));
    let check = |motions: &[WrittenMotion<3>], scene: &mut Layers, progress: &(dyn Fn(Progress) -> _ + Sync)| {
        check_written(motions, &paths, &frame_part(), &bounds(), scene, &CheckOptions::default(), progress).unwrap_err()
    };
    let changed = |change: fn(&mut WrittenMotion<3>)| {
        let mut motions = motions.clone();
        change(&mut motions[4]);
        check(&motions, &mut FREE.clone(), &quiet)
    };
    let none = |path, waypoint| CheckError::NoWaypoint { motion: 4, path, waypoint };
    assert_eq!(changed(|motion| motion.path = 2), none(2, 10));
    assert_eq!(changed(|motion| motion.waypoints[1].0 = 11), none(1, 11));
    assert_eq!(changed(|motion| motion.waypoints[0].0 = usize::MAX), none(1, usize::MAX));
    assert_eq!(changed(|motion| motion.waypoints[1].0 = usize::MAX), none(1, usize::MAX - 1));
    assert_eq!(changed(|motion| (motion.waypoints[0].0, motion.waypoints[1].0) = (9, 3)), none(1, 9));
    let empty = CheckError::PathLength { motion: 4, kind: MotionKind::Print, points: 0 };
    assert_eq!(changed(|motion| motion.waypoints.clear()), empty);
    let mut refusing = Layers { refused: Some(1), ..FREE };
    assert_eq!(check(&motions, &mut refusing, &quiet), CheckError::Layer { layer: 1, why: "no room".into() });
    assert_eq!(check(&motions, &mut FREE.clone(), &|_| ControlFlow::Break(())), CheckError::Cancelled);
}
