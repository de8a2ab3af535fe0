//! Repair of motions that collide: the tool turned at waypoints, in steps of `pi / 500` (Eq. 4.13).

use super::audited::{Audit, Start, audited, go_on, is_free, is_swept_free, through};
use curvlay_examples::args::Failure;
use curvlay_examples::motion::Studied;
use curvlay_kinematics::scene::Scene;
use curvlay_trajectory::verify::{Checks, RepairOptions, repair_by_turning, verify};
use curvlay_trajectory::{MIN_WAYPOINTS, Trajectory};
use std::ops::Range;

/// What repair made of a motion.
pub struct Repaired {
    /// Waypoints with another turn of the tool, waypoints after which the motion is split, and those without a free posture.
    pub changed: usize,
    pub splits: usize,
    pub stuck: usize,
    /// Of the motions that came of it.
    pub audit: Audit,
}

/// Other turns of the tool where waypoints collide, or motions between two (Eq. 4.13).
pub fn repaired(scene: &Scene, starts: &[Start], trajectories: &[Trajectory<6>]) -> Result<Option<Repaired>, Failure> {
    let checks = Checks {
        posture_free: |_: usize, joints: &[f64; 6]| is_free(scene, joints),
        motion_free: |_: usize, from: &[f64; 6], to: &[f64; 6]| is_swept_free(scene, from, to),
    };
    let mut repaired = Repaired { changed: 0, splits: 0, stuck: 0, audit: Audit::default() };
    let (mut motions, mut any) = (Vec::new(), false);
    for (start, trajectory) in starts.iter().zip(trajectories) {
        let (robot, times) = (start.robot(), start.times());
        let joints = trajectory.at_waypoints();
        let found = verify(joints, &checks.posture_free, &checks.motion_free, &go_on)?;
        if found.is_free() {
            motions.push(trajectory.clone());
            continue;
        }
        any = true;
        let options = RepairOptions::default();
        let repair = repair_by_turning(robot, times, joints, &robot.bounds(false), &found, &checks, &options)?;
        repaired.changed += repair.changed.len();
        repaired.splits += repair.splits.len();
        repaired.stuck += repair.stuck.len();
        for run in unbroken(joints.len(), &repair.splits, &repair.stuck) {
            motions.push(through(&times[run.clone()], &repair.waypoints[run])?);
        }
    }
    repaired.audit = audited(scene, starts, &motions);
    Ok(any.then_some(repaired))
}

/// The runs between splits and stuck waypoints that are long enough for a motion.
fn unbroken(count: usize, splits: &[usize], stuck: &[usize]) -> Vec<Range<usize>> {
    let mut runs = vec![];
    let mut from = 0;
    for i in 0..count {
        let is_stuck = stuck.contains(&i);
        if is_stuck || splits.contains(&i) || i + 1 == count {
            runs.push(from..if is_stuck { i } else { i + 1 });
            from = i + 1;
        }
    }
    runs.retain(|run| run.len() >= MIN_WAYPOINTS);
    runs
}

#[cfg(test)]
mod tests {
    use super::unbroken;

    #[test]
    fn runs_lie_between_splits_and_stuck_waypoints() {
        let ends = |splits: &[usize], stuck: &[usize], count| -> Vec<[usize; 2]> {
            unbroken(count, splits, stuck).into_iter().map(|run| [run.start, run.end]).collect()
        };
        assert_eq!(ends(&[], &[], 20), [[0, 20]]);
        assert_eq!(ends(&[9], &[], 20), [[0, 10], [10, 20]]);
        // A stuck waypoint is in no run, and four waypoints are too few for one.
        assert_eq!(ends(&[15], &[6], 20), [[0, 6], [7, 16]]);
        assert_eq!(ends(&[], &[5], 6), [[0, 5]]);
        assert_eq!(ends(&[], &[], 0), [[0; 2]; 0]);
    }
}
