//! A UR3 that holds the part under a nozzle, and paths for it.

use curvlay_kinematics::{Arm, Branch, JointLimits, Setup, Waypoint, nozzle_frame, robots};
use curvlay_trajectory::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use curvlay_trajectory::{Bounds, FreeRange, Posture, Robot};
use std::fs;
use std::path::PathBuf;

/// Seconds from one waypoint to the next: 2,545 of them in 460 s.
pub const STEP: f64 = 0.18074656188605107;

pub struct Ur3 {
    pub cell: Setup,
    pub waypoints: Vec<Waypoint>,
}

impl Ur3 {
    /// Centres the path in x and y by its mean and puts its lowest point at 0.
    pub fn new(path: &[(Point3<f64>, Vector3<f64>)]) -> Self {
        let nozzle = nozzle_frame(&Point3::new(300.0, 60.0, 220.0), &-Vector3::z_axis());
        let arm = Arm::new(&robots::UR3).unwrap();
        let cell = Setup::part_in_hand(arm, Isometry3::translation(0.0, 0.0, 45.0), nozzle).unwrap();
        let mean = path.iter().map(|(p, _)| p.coords).sum::<Vector3<f64>>() / path.len() as f64;
        let lowest = path.iter().map(|(p, _)| p.z).fold(f64::INFINITY, f64::min);
        let origin = Vector3::new(mean.x, mean.y, lowest);
        let placed = |(p, n): &(Point3<f64>, Vector3<f64>)| Waypoint {
            position: p - origin,
            axis: UnitVector3::new_normalize(*n),
        };
        Ur3 { cell, waypoints: path.iter().map(placed).collect() }
    }

    /// An upward spiral over a dome, `count` waypoints.
    pub fn dome(count: usize) -> Self {
        let point = |k: usize| {
            let turn = 0.05 * k as f64;
            let radius = 12.0 + 0.01 * k as f64;
            let p = Point3::new(radius * turn.cos(), radius * turn.sin(), 30.0 - radius * radius / 120.0);
            (p, Vector3::new(p.x / 60.0, p.y / 60.0, 1.0))
        };
        Ur3::new(&(0..count).map(point).collect::<Vec<_>>())
    }

    /// An arc beside the hand's axis, at 25 to 50 mm: turning the part about the nozzle moves the wrist on a circle as wide.
    pub fn arc(count: usize) -> Self {
        let point = |k: usize| {
            let turn = 1.6 * k as f64 / count as f64;
            (Point3::new(60.0 * turn.cos(), 60.0 * turn.sin(), 20.0), Vector3::z())
        };
        let mut robot = Ur3::new(&(0..count).map(point).collect::<Vec<_>>());
        robot.waypoints.iter_mut().for_each(|waypoint| waypoint.position += Vector3::new(30.0, 20.0, 0.0));
        robot
    }

    pub fn times(&self) -> Vec<f64> {
        (0..self.waypoints.len()).map(|k| STEP * k as f64).collect()
    }

    pub fn bounds(&self) -> Bounds<6> {
        let JointLimits { lower, upper, .. } = *self.cell.arm().limits();
        Bounds { lower, upper, velocity: [1.0; 6], acceleration: [5.0; 6], jerk: [1.0; 6] }
    }
}

impl Robot<6, 1> for Ur3 {
    fn waypoints(&self) -> usize {
        self.waypoints.len()
    }

    fn free(&self) -> [FreeRange; 1] {
        [FreeRange::Turn]
    }

    fn solutions(&self, waypoint: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 6])) {
        let flange = self.cell.flange(&self.waypoints[waypoint], free[0]);
        for (branch, joints) in self.cell.arm().inverse(&flange).unwrap_or_default().iter() {
            each(branch.slot() as u32, *joints);
        }
    }

    fn posture(&self, waypoint: usize, free: &[f64; 1], branch: u32) -> Option<Posture<6, 1>> {
        let flange = self.cell.flange(&self.waypoints[waypoint], free[0]);
        let joints = *self.cell.arm().inverse(&flange).ok()?.get(*Branch::ALL.get(branch as usize)?)?;
        Some(Posture { joints, rates: [self.cell.tool_rates(&joints)?.first] })
    }
}

/// A file of waypoints in the folder `shared` beside the workspace.
pub fn read(name: &str) -> Vec<(Point3<f64>, Vector3<f64>)> {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/waypoints").join(name);
    let text = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let point = |line: &str| {
        let x: Vec<f64> = line.split_whitespace().map(|x| x.parse().unwrap()).collect();
        (Point3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5]))
    };
    text.lines().map(point).collect()
}
