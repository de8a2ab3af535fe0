//! Gaps between the runs of a print: an arm with two sides that it cannot change, and paths that leave it the choice of a side.

use curvlay_trajectory::indicator::CollisionIndicator;
use curvlay_trajectory::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_trajectory::print::{
    Clearance, FaultKind, Moment, PrintLimits, PrintOptions, PrintPath, PrintPlan, PrintRobot, PrintWorkcell, Waypoint,
    plan_print,
};
use curvlay_trajectory::transfer::FreeSpace;
use curvlay_trajectory::{Bounds, FreeRange, Posture};
use std::ops::ControlFlow::Continue;

/// Millimetres a radian of the linear axes.
const PITCH: f64 = 10.0;

/// The last joint on either side, the branch.
const SIDES: [f64; 2] = [0.0, 2.0];

/// Three linear axes, a tool that turns, and a joint that is on one side or the other.
struct TwoSided;

impl TwoSided {
    fn joints(waypoint: &Waypoint, turn: f64, side: f64) -> [f64; 5] {
        let p = waypoint.position / PITCH;
        [p.x, p.y, p.z, turn, side]
    }
}

impl PrintRobot<5, 1> for TwoSided {
    fn free(&self) -> [FreeRange; 1] {
        [FreeRange::Turn]
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 5])) {
        for (branch, side) in (0..).zip(SIDES) {
            each(branch, Self::joints(waypoint, free[0], side));
        }
    }

    fn posture(&self, waypoint: &Waypoint, free: &[f64; 1], branch: u32) -> Option<Posture<5, 1>> {
        let joints = Self::joints(waypoint, free[0], SIDES[branch as usize]);
        Some(Posture { joints, rates: [[0.0, 0.0, 0.0, 1.0, 0.0]] })
    }

    fn nozzle(&self, q: &[f64; 5]) -> Option<Isometry3<f64>> {
        Some(Isometry3::new(PITCH * Vector3::new(q[0], q[1], q[2]), Vector3::z() * q[3]))
    }

    fn continued(&self, waypoint: &Waypoint, _: &[f64; 1], turn: f64, near: &[f64; 5]) -> Option<[f64; 5]> {
        Some(Self::joints(waypoint, near[3] + turn, near[4]))
    }
}

/// What is free around a path on one side.
#[derive(Clone, Copy, PartialEq)]
enum Space {
    /// Nothing.
    Blocked,
    /// All of it, with so much clearance.
    Open(Clearance),
    /// The tool between 0.1 and 0.16 rad: no one of 24 samples is.
    Slot,
    /// Wide with the tool near 0 on the first half of the path, and near half a turn on the second; with the least clearance
    /// everywhere.
    Torn,
}

impl Space {
    /// At a place along a path, by its joint, and a turn of the tool.
    fn keeps(self, along: f64, turn: f64, clearance: Clearance) -> bool {
        match self {
            Space::Blocked => false,
            Space::Open(most) => most <= clearance,
            Space::Slot => (0.1..0.16).contains(&turn),
            Space::Torn => {
                clearance == Clearance::Least || (turn.cos() > 0.9 && along < 1.0) || turn.cos() < -0.9 && along > 0.9
            }
        }
    }
}

/// The space around a path on either side.
type Room = [Space; 2];

/// Paths stand 10 mm apart in y; no motion leads from one side to the other.
#[derive(Clone)]
struct Sides<'a>(&'a [Room]);

impl CollisionIndicator<5> for Sides<'_> {
    fn value(&self, _: &[f64; 5]) -> f64 {
        -100.0
    }

    fn gradient(&self, _: &[f64; 5]) -> (f64, [f64; 5]) {
        (-100.0, [0.0; 5])
    }
}

impl FreeSpace<5> for Sides<'_> {
    fn free(&self, from: &[f64; 5], to: &[f64; 5]) -> bool {
        SIDES.iter().any(|side| [from, to].iter().all(|joints| (joints[4] - side).abs() < 0.5))
    }
}

impl PrintWorkcell<5> for Sides<'_> {
    fn begin(&mut self, _: u32) -> Result<(), String> {
        Ok(())
    }

    fn build(&mut self, _: u32) -> Result<(), String> {
        Ok(())
    }

    fn keeps(&self, joints: &[f64; 5], clearance: Clearance) -> bool {
        let path = joints[1].round() as usize;
        self.0[path][usize::from(joints[4] > 1.0)].keeps(joints[0], joints[3], clearance)
    }

    fn obstacle(&self, _: &[f64; 5]) -> Option<String> {
        None
    }

    fn touches(&self, _: &[[f64; 5]; 4]) -> Option<String> {
        None
    }

    fn is_gouging(&self, _: Moment, _: &Waypoint) -> bool {
        false
    }
}

/// Lines of 20 mm at 10 mm/s, each with its layer and its room.
fn planned(of: &[(u32, Room)]) -> PrintPlan<5, 1> {
    let times: Vec<f64> = (0..=20).map(|k| 0.1 * f64::from(k)).collect();
    let line = |path: usize| -> Vec<Waypoint> {
        let at = |k| Point3::new(f64::from(k), PITCH * path as f64, 1.0);
        (0..=20).map(|k| Waypoint { position: at(k), axis: Vector3::z_axis() }).collect()
    };
    let lines: Vec<Vec<Waypoint>> = (0..of.len()).map(line).collect();
    let path = |(waypoints, (layer, _)): (_, &(u32, Room))| PrintPath {
        layer: *layer,
        waypoints,
        times: &times,
        filament_mm: &times,
    };
    let paths: Vec<PrintPath<'_>> = lines.iter().map(Vec::as_slice).zip(of).map(path).collect();
    let rooms: Vec<Room> = of.iter().map(|(_, room)| *room).collect();
    let bounds = Bounds { velocity: [3.0; 5], acceleration: [10.0; 5], jerk: [100.0; 5], ..Bounds::NONE };
    let (limits, options) = (PrintLimits::of(bounds), PrintOptions::default());
    plan_print(&TwoSided, Sides(&rooms), &paths, &limits, &options, &|_| Continue(())).unwrap()
}

/// The side of each run, and between which no way leads.
fn sides(plan: &PrintPlan<5, 1>) -> (Vec<usize>, Vec<usize>) {
    let side = |joints: &[[f64; 5]]| usize::from(joints[0][4] > 1.0);
    let gaps = plan.travels.iter().enumerate().filter(|(_, travel)| travel.is_none()).map(|(gap, _)| gap).collect();
    assert_eq!(plan.faults.len(), plan.count(FaultKind::NoTransfer));
    (plan.runs.iter().map(|run| side(run.trajectory.joints())).collect(), gaps)
}

const WIDE: Space = Space::Open(Clearance::Wide);
const FIRST: Room = [WIDE, Space::Blocked];
const SECOND: Room = [Space::Blocked, WIDE];
/// Either; what is planned on its own takes the second, for its clearance.
const BOTH: Room = [Space::Open(Clearance::Narrow), WIDE];

#[test]
fn the_path_behind_a_gap_gets_other_postures() {
    assert_eq!(sides(&planned(&[(0, FIRST), (0, BOTH), (0, BOTH)])), (vec![0, 0, 0], vec![]));
    // So does the first path of a layer.
    assert_eq!(sides(&planned(&[(0, FIRST), (1, BOTH), (2, FIRST)])), (vec![0, 0, 0], vec![]));
}

#[test]
fn the_path_before_a_gap_gets_other_postures() {
    assert_eq!(sides(&planned(&[(0, BOTH), (0, FIRST)])), (vec![0, 0], vec![]));
    // Two in a row, and no more than stand in the layer.
    assert_eq!(sides(&planned(&[(0, BOTH), (0, BOTH), (0, FIRST)])), (vec![0, 0, 0], vec![]));
    assert_eq!(sides(&planned(&[(0, BOTH), (1, FIRST)])), (vec![1, 0], vec![0]));
}

#[test]
fn postures_stay_where_others_leave_as_many_gaps() {
    assert_eq!(sides(&planned(&[(0, FIRST), (0, BOTH), (0, SECOND)])), (vec![0, 1, 1], vec![0]));
    assert_eq!(sides(&planned(&[(0, FIRST), (0, BOTH), (0, BOTH), (0, SECOND)])), (vec![0, 1, 1, 1], vec![0]));
    assert_eq!(sides(&planned(&[(0, FIRST), (0, SECOND)])), (vec![0, 1], vec![0]));
}

/// Bug: the other postures were those of few samples of the tool angle; a path of 71 waypoints on a UR3 had none.
#[test]
fn other_postures_are_found_with_more_samples() {
    let narrow = [Space::Slot, WIDE];
    assert_eq!(sides(&planned(&[(0, FIRST), (0, narrow), (0, FIRST)])), (vec![0, 0, 0], vec![]));
    assert_eq!(sides(&planned(&[(0, narrow), (0, FIRST)])), (vec![0, 0], vec![]));
}

/// Bug: where waypoints have clearance that the path cannot keep, it broke off, although it can be followed with less.
#[test]
fn a_path_takes_the_least_clearance_before_it_breaks_off() {
    let plan = planned(&[(0, FIRST), (0, [Space::Torn, Space::Blocked]), (0, FIRST)]);
    assert_eq!(sides(&plan), (vec![0, 0, 0], vec![]));
}
