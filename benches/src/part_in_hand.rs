//! A UR3 that holds the part under a nozzle, for the benches of trajectories.

use curvlay_kinematics::{Arm, Branch, Setup, Waypoint, nozzle_frame, robots};
use curvlay_trajectory::{Bounds, FreeRange, Posture, Robot};
use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};

/// Seconds from one waypoint to the next.
pub const STEP: f64 = 0.18;

/// The cell and what it prints.
pub struct PartInHand {
    cell: Setup,
    waypoints: Vec<Waypoint>,
}

impl PartInHand {
    /// A spiral outwards over a dome, in steps of a millimetre.
    ///
    /// # Panics
    /// Never: the numbers of the cell are sound.
    pub fn dome(count: usize) -> Self {
        let arm = Arm::new(&robots::UR3).expect("a sound model");
        let nozzle = nozzle_frame(&Point3::new(300.0, 60.0, 220.0), &-Vector3::z_axis());
        let cell = Setup::part_in_hand(arm, Isometry3::translation(0.0, 0.0, 45.0), nozzle).expect("sound frames");
        let point = |k: usize| {
            // Arc length grows by 1 mm a step, turns are 1 mm apart.
            let radius = (16.0 + k as f64 / std::f64::consts::PI).sqrt();
            let (sin, cos) = (std::f64::consts::TAU * radius).sin_cos();
            let position = Point3::new(radius * cos, radius * sin, 30.0 - radius * radius / 100.0);
            let axis = UnitVector3::new_normalize(Vector3::new(position.x / 50.0, position.y / 50.0, 1.0));
            Waypoint { position, axis }
        };
        PartInHand { cell, waypoints: (0..count).map(point).collect() }
    }

    /// Times of the waypoints.
    pub fn times(&self) -> Vec<f64> {
        (0..self.waypoints.len()).map(|k| STEP * k as f64).collect()
    }

    /// The arm's stops, 1 rad/s, 5 rad/s^2 and 1 rad/s^3.
    pub fn bounds(&self) -> Bounds<6> {
        let limits = self.cell.arm().limits();
        let (lower, upper) = (limits.lower, limits.upper);
        Bounds { lower, upper, velocity: [1.0; 6], acceleration: [5.0; 6], jerk: [1.0; 6] }
    }
}

impl Robot<6, 1> for PartInHand {
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
