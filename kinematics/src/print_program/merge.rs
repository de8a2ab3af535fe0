//! Waypoints of a motion that lie on the line between two others.

use super::knot::{PrintKnot, TargetOptions};
use crate::workcell::{ControllerPose, Workcell};
use nalgebra::{Isometry3, UnitQuaternion};

/// Waypoints that a line passes over at most: bounds the cost, a hundred interpolations a waypoint.
const MAX_PASSED: usize = 200;

/// The waypoints that are needed: from each the farthest is next that leaves those between near the line. The first and the
/// last stay, and those whose posture has no pose.
pub(super) fn merged<const N: usize, const F: usize, W: Workcell<N, F>>(
    workcell: &W,
    knots: &[PrintKnot<N>],
    options: &TargetOptions,
) -> Vec<PrintKnot<N>> {
    let poses: Vec<Option<ControllerPose>> = knots.iter().map(|knot| workcell.controller_pose(&knot.joints)).collect();
    let mut kept: Vec<PrintKnot<N>> = knots.first().copied().into_iter().collect();
    let mut from = 0;
    while from + 1 < knots.len() {
        let most = (from + MAX_PASSED).min(knots.len() - 1);
        let mut to = from + 1;
        while to < most && is_line(&knots[from..=to + 1], &poses[from..=to + 1], options) {
            to += 1;
        }
        kept.push(knots[to]);
        from = to;
    }
    kept
}

/// Whether all waypoints between the first and the last are near the line.
fn is_line<const N: usize>(knots: &[PrintKnot<N>], poses: &[Option<ControllerPose>], options: &TargetOptions) -> bool {
    let Some(poses) = poses.iter().copied().collect::<Option<Vec<ControllerPose>>>() else { return false };
    let last = poses.len() - 1;
    let place = |k: usize| poses[k].target.pose.translation.vector;
    let length = (place(last) - place(0)).norm();
    let seconds = knots[last].time_s - knots[0].time_s;
    let filament = knots[last].filament_mm - knots[0].filament_mm;
    let near = |a: f64, b: f64| (a - b).abs() <= options.merge_share * b.abs() + 1e-9;
    let steady = (0..last).all(|k| {
        let (step, way) = (knots[k + 1].time_s - knots[k].time_s, (place(k + 1) - place(k)).norm());
        let laid = knots[k + 1].filament_mm - knots[k].filament_mm;
        near(way / step, length / seconds) && near(laid / step, filament / seconds)
    });
    let [ends, turned] = [|pose: &Isometry3<f64>| *pose, |pose: &Isometry3<f64>| pose.inverse()].map(|view| {
        let [first, end] = [view(&poses[0].target.pose), view(&poses[last].target.pose)];
        (1..last).all(|k| is_between(&[first, end], &view(&poses[k].target.pose), options))
    });
    steady
        && ends
        && turned
        && (1..last).all(|k| {
            let (ends, at) = ([&poses[0], &poses[last]], &poses[k]);
            table_is_between(ends, at, place(k), options) && track_is_between(ends, at, place(k), options)
        })
}

/// How far along the line from one place to another the foot of a third is, from 0 to 1.
fn share(ends: [nalgebra::Vector3<f64>; 2], at: nalgebra::Vector3<f64>) -> f64 {
    let line = ends[1] - ends[0];
    let share = (at - ends[0]).dot(&line) / line.norm_squared();
    if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) }
}

fn is_between(ends: &[Isometry3<f64>; 2], pose: &Isometry3<f64>, options: &TargetOptions) -> bool {
    let [a, b] = [ends[0].translation.vector, ends[1].translation.vector];
    let share = share([a, b], pose.translation.vector);
    let off_mm = (a + (b - a) * share - pose.translation.vector).norm();
    let turn = ends[0].rotation.rotation_to(&ends[1].rotation).scaled_axis();
    let rotation = UnitQuaternion::from_scaled_axis(turn * share) * ends[0].rotation;
    off_mm <= options.merge_mm && rotation.angle_to(&pose.rotation) <= options.merge_rad
}

fn table_is_between(
    ends: [&ControllerPose; 2],
    pose: &ControllerPose,
    place: nalgebra::Vector3<f64>,
    options: &TargetOptions,
) -> bool {
    match (ends[0].table, ends[1].table, pose.table) {
        (Some(a), Some(b), Some(at)) => {
            let share = share(ends.map(|end| end.target.pose.translation.vector), place);
            (0..2).all(|k| (a[k] + (b[k] - a[k]) * share - at[k]).abs() <= options.merge_rad)
        }
        _ => true,
    }
}

/// Whether a track is where the controller has it on its even way, within the tolerance of the path.
fn track_is_between(
    ends: [&ControllerPose; 2],
    pose: &ControllerPose,
    place: nalgebra::Vector3<f64>,
    options: &TargetOptions,
) -> bool {
    match (ends[0].track_mm, ends[1].track_mm, pose.track_mm) {
        (Some(a), Some(b), Some(at)) => {
            let share = share(ends.map(|end| end.target.pose.translation.vector), place);
            (a + (b - a) * share - at).abs() <= options.merge_mm
        }
        _ => true,
    }
}
