//! Cells with three free parameters: a UR3 whose tool may tilt, and an arm of six axes over a table of two.

use super::ur3::Ur3;
use curvlay_kinematics::{Arm, Branch, Positioner, TableSetup, Waypoint, nozzle_frame, robots};
use curvlay_trajectory::nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use curvlay_trajectory::{Bounds, FreeRange, LadderNode, Posture, Robot};
use std::f64::consts::{FRAC_PI_2, PI};

/// The tool angle, and a tilt of the waypoint's axis by a turn about a line across it.
pub struct Tilting {
    pub robot: Ur3,
}

const NOZZLE: [f64; 3] = [300.0, 60.0, 220.0];

impl Tilting {
    fn nozzle() -> Isometry3<f64> {
        nozzle_frame(&Point3::from(NOZZLE), &-Vector3::z_axis())
    }

    /// Two directions across the axis of a waypoint.
    fn across(&self, waypoint: usize) -> [Vector3<f64>; 2] {
        let frame = self.robot.waypoints[waypoint].frame(0.0);
        [frame * Vector3::x(), frame * Vector3::y()]
    }

    /// Part in base.
    fn part(&self, waypoint: usize, free: &[f64; 3]) -> Isometry3<f64> {
        let [u, v] = self.across(waypoint);
        let at = &self.robot.waypoints[waypoint];
        let frame = at.frame(free[0]);
        let tilt = UnitQuaternion::from_scaled_axis(u * free[1] + v * free[2]);
        let tilted = Isometry3::from_parts(Translation3::from(at.position), tilt * frame.rotation);
        Tilting::nozzle() * tilted.inverse()
    }

    pub fn check_rates(&self, waypoint: usize, free: &[f64; 3], branch: u32) {
        check_rates(self, waypoint, free, branch);
    }
}

/// Rates against differences.
fn check_rates<const N: usize, const F: usize>(robot: &impl Robot<N, F>, at: usize, free: &[f64; F], branch: u32) {
    let rates = robot.posture(at, free, branch).unwrap().rates;
    for f in 0..F {
        let moved = |by: f64| {
            let mut free = *free;
            free[f] += by;
            robot.posture(at, &free, branch).unwrap().joints
        };
        let (up, down) = (moved(1e-6), moved(-1e-6));
        for j in 0..N {
            let slope = (up[j] - down[j]) / 2e-6;
            assert!((slope - rates[f][j]).abs() < 1e-6 * (1.0 + slope.abs()), "{f} {j}: {slope} {}", rates[f][j]);
        }
    }
}

impl Robot<6, 3> for Tilting {
    fn waypoints(&self) -> usize {
        self.robot.waypoints.len()
    }

    fn free(&self) -> [FreeRange; 3] {
        let tilt = FreeRange::Within(-FRAC_PI_2, FRAC_PI_2);
        [FreeRange::Turn, tilt, tilt]
    }

    fn solutions(&self, waypoint: usize, free: &[f64; 3], each: &mut dyn FnMut(u32, [f64; 6])) {
        let flange = self.part(waypoint, free) * Isometry3::translation(0.0, 0.0, -45.0);
        for (branch, joints) in self.robot.cell.arm().inverse(&flange).unwrap_or_default().iter() {
            each(branch.slot() as u32, *joints);
        }
    }

    fn posture(&self, waypoint: usize, free: &[f64; 3], branch: u32) -> Option<Posture<6, 3>> {
        let part = self.part(waypoint, free);
        let flange = part * Isometry3::translation(0.0, 0.0, -45.0);
        let arm = self.robot.cell.arm();
        let joints = *arm.inverse(&flange).ok()?.get(*Branch::ALL.get(branch as usize)?)?;
        let tip = Point3::from(NOZZLE);
        let mut rates = [self.robot.cell.tool_rates(&joints)?.first, [0.0; 6], [0.0; 6]];
        let [u, v] = self.across(waypoint);
        let tilt = u * free[1] + v * free[2];
        // How the turn changes with its vector: the left Jacobian of rotations.
        let (angle, cross) = (tilt.norm(), tilt.cross_matrix());
        let (a, b) = if angle < 1e-4 {
            (0.5, 1.0 / 6.0)
        } else {
            ((1.0 - angle.cos()) / (angle * angle), (angle - angle.sin()) / angle.powi(3))
        };
        let turn = Matrix3::identity() + cross * a + cross * cross * b;
        for (rates, along) in rates[1..].iter_mut().zip([u, v]) {
            // The part turns the other way about the nozzle's tip.
            let axis = part.rotation * -(turn * along);
            let first = arm.rates_about(&joints, &tip, &UnitVector3::new_normalize(axis))?.first;
            *rates = first.map(|rate| rate * axis.norm());
        }
        Some(Posture { joints, rates })
    }
}

/// An IRB 1200 with the nozzle, over a table that tilts and turns: the tool angle and both table joints are free.
pub struct Table {
    cell: TableSetup,
    waypoints: Vec<Waypoint>,
    fixed: bool,
}

impl Table {
    pub fn new(waypoints: &[Waypoint]) -> Self {
        let positioner = Positioner::new(&robots::IRBP_A250, &Isometry3::translation(520.0, 0.0, -900.0)).unwrap();
        let nozzle = nozzle_frame(&Point3::new(0.0, 0.0, 150.0), &Vector3::z_axis());
        let arm = Arm::new(&robots::IRB1200).unwrap();
        let cell = TableSetup::nozzle_in_hand(arm, nozzle, positioner, Isometry3::identity()).unwrap();
        Table { cell, waypoints: waypoints.to_vec(), fixed: false }
    }

    /// The same with the table where it is.
    pub fn with_fixed_table(&self) -> Self {
        Table { cell: self.cell, waypoints: self.waypoints.clone(), fixed: true }
    }

    pub fn bounds(&self) -> Bounds<8> {
        let (arm, table) = (self.cell.arm().limits(), self.cell.positioner().limits());
        let joined =
            |arm: [f64; 6], table: [f64; 2]| std::array::from_fn(|j| if j < 6 { arm[j] } else { table[j - 6] });
        let (lower, upper) = (joined(arm.lower, table.lower), joined(arm.upper, table.upper));
        Bounds { lower, upper, velocity: [1.0; 8], acceleration: [5.0; 8], jerk: [f64::INFINITY; 8] }
    }

    /// The table level, one tool angle and one branch for all waypoints: those with the least way.
    pub fn level_start(&self) -> Vec<LadderNode<8, 3>> {
        let mut best: Option<(f64, Vec<LadderNode<8, 3>>)> = None;
        for branch in 0..8 {
            for k in 0..24 {
                let free = [PI * f64::from(k) / 12.0 - PI, 0.0, 0.0];
                let node = |w: usize| Some(LadderNode { joints: self.posture(w, &free, branch)?.joints, free, branch });
                let Some(nodes) = (0..self.waypoints.len()).map(node).collect::<Option<Vec<_>>>() else { continue };
                let apart = |pair: &[LadderNode<8, 3>]| {
                    pair[0].joints.iter().zip(&pair[1].joints).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
                };
                let inside = nodes
                    .iter()
                    .all(|node| self.cell.arm().limits().contains(&std::array::from_fn(|j| node.joints[j])));
                let way: f64 = nodes.windows(2).map(apart).sum();
                if inside && best.as_ref().is_none_or(|best| way < best.0) {
                    best = Some((way, nodes));
                }
            }
        }
        best.unwrap().1
    }

    pub fn check_rates(&self, waypoint: usize, free: &[f64; 3], branch: u32) {
        check_rates(self, waypoint, &[free[0], free[1] + 0.05, free[2] - 0.1], branch);
    }
}

impl Robot<8, 3> for Table {
    fn waypoints(&self) -> usize {
        self.waypoints.len()
    }

    fn free(&self) -> [FreeRange; 3] {
        let limits = self.cell.positioner().limits();
        let table = |j: usize| {
            if self.fixed { FreeRange::Within(0.0, 0.0) } else { FreeRange::Within(limits.lower[j], limits.upper[j]) }
        };
        [FreeRange::Turn, table(0), table(1)]
    }

    fn solutions(&self, waypoint: usize, free: &[f64; 3], each: &mut dyn FnMut(u32, [f64; 8])) {
        (0..8).for_each(|branch| {
            if let Some(found) = self.posture(waypoint, free, branch) {
                each(branch, found.joints);
            }
        });
    }

    fn posture(&self, waypoint: usize, free: &[f64; 3], branch: u32) -> Option<Posture<8, 3>> {
        let table = [free[1], free[2]];
        let cell = self.cell.at(&table)?;
        let flange = cell.flange(&self.waypoints[waypoint], free[0]);
        let arm = *cell.arm().inverse(&flange).ok()?.get(*Branch::ALL.get(branch as usize)?)?;
        let follow = self.cell.rates(&table, &arm)?;
        let mut rates = [[0.0; 8]; 3];
        for (f, rates) in rates.iter_mut().enumerate() {
            rates[..6].copy_from_slice(&follow[f].first);
            if f > 0 {
                rates[5 + f] = 1.0;
            }
        }
        let joints = std::array::from_fn(|j| if j < 6 { arm[j] } else { table[j - 6] });
        Some(Posture { joints, rates })
    }
}
