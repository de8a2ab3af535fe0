//! Cells as the planners of trajectories see them: an arm with the part in its hand, and an arm over a table.

use curvlay_kinematics::{
    Arm, ArmError, Branch, Cell, CellError, JointLimits, Positioner, PositionerError, TableCell, nozzle_frame, robots,
};
use curvlay_trajectory::print::{PrintRobot, Waypoint};
use curvlay_trajectory::{Bounds, FreeRange, LadderError, LeastSpeed, Posture, Robot, least_speed};
use nalgebra::{Isometry3, Point3, UnitQuaternion, UnitVector3, Vector3};
use std::f64::consts::{PI, TAU};
use std::ops::{ControlFlow, Range};

/// Seconds from one waypoint to the next where no feed is given: 2,545 of them take 460 s, as in the dissertation.
pub const STEP_S: f64 = 460.0 / 2545.0;

/// The bounds at which all figures are made; the arms' own stops stay.
const SPEED_RAD_S: f64 = 1.0;
const ACCELERATION_RAD_S2: f64 = 5.0;
const JERK_RAD_S3: f64 = 1.0;

/// How far the table may tilt to either side at a waypoint; its own stops are farther.
const MOST_TILT: f64 = PI / 3.0;

/// How far from a stop a ladder's waypoints stay, in radians: splines sway between them.
const STOP_ROOM: f64 = 0.05;

/// Cells of the tool angle by which least speeds are told: three digits.
const CELLS: u32 = 8192;

/// Numbers of ours that make no cell; never seen.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// The arm.
    #[error(transparent)]
    Arm(#[from] ArmError),
    /// The table.
    #[error(transparent)]
    Positioner(#[from] PositionerError),
    /// A frame.
    #[error(transparent)]
    Cell(#[from] CellError),
}

/// A robot whose waypoints can be taken apart, and checked.
pub trait Placed<const N: usize, const F: usize>: Robot<N, F> + PrintRobot<N, F> + Sized {
    /// The same cell with other waypoints.
    fn with(&self, waypoints: Vec<Waypoint>) -> Self;

    /// Its waypoints.
    fn path(&self) -> &[Waypoint];

    /// The same cell with some of the waypoints.
    fn part(&self, waypoints: Range<usize>) -> Self {
        self.with(self.path()[waypoints].to_vec())
    }

    /// How far joints are from a waypoint: millimetres, and the angle of the axes in radians.
    fn missed(&self, waypoint: usize, joints: &[f64; N]) -> (f64, f64) {
        let nozzle = self.nozzle(joints);
        nozzle.map_or((f64::INFINITY, f64::INFINITY), |nozzle| apart(&nozzle, &self.path()[waypoint]))
    }

    /// The bounds of the figures, or with the makers' speeds.
    fn bounds(&self, makers_speeds: bool) -> Bounds<N>;

    /// What speeds every motion through these waypoints needs; `None` with more than one free parameter.
    ///
    /// # Errors
    /// As of [`least_speed`].
    fn least_speed(
        &self,
        _times: &[f64],
        _bounds: &Bounds<N>,
        _waypoints: Range<usize>,
    ) -> Result<Option<LeastSpeed>, LadderError> {
        Ok(None)
    }
}

/// A waypoint as kinematics have it.
fn of(waypoint: &Waypoint) -> curvlay_kinematics::Waypoint {
    curvlay_kinematics::Waypoint { position: waypoint.position, axis: waypoint.axis }
}

/// Waypoints centred in x and y by their mean, the lowest at z = 0.
pub fn centred(path: &[(Point3<f64>, UnitVector3<f64>)]) -> Vec<Waypoint> {
    let mean = path.iter().map(|(p, _)| p.coords).sum::<Vector3<f64>>() / path.len().max(1) as f64;
    let lowest = path.iter().map(|(p, _)| p.z).fold(f64::INFINITY, f64::min);
    let origin = Vector3::new(mean.x, mean.y, lowest);
    path.iter().map(|&(position, axis)| Waypoint { position: position - origin, axis }).collect()
}

/// A UR3 that holds the part under a nozzle.
#[derive(Clone, Debug)]
pub struct PartInHand {
    cell: Cell,
    waypoints: Vec<Waypoint>,
}

impl PartInHand {
    /// The cell of the figures: the nozzle hangs 300 mm before and 220 mm above the base, the part stands 45 mm over the
    /// flange.
    ///
    /// # Errors
    /// None with these numbers.
    pub fn new(waypoints: Vec<Waypoint>) -> Result<Self, MotionError> {
        let nozzle = nozzle_frame(&Point3::new(300.0, 60.0, 220.0), &-Vector3::z_axis());
        let part = Isometry3::translation(0.0, 0.0, 45.0);
        Ok(PartInHand { cell: Cell::part_in_hand(Arm::new(&robots::UR3)?, part, nozzle)?, waypoints })
    }

    /// The cell.
    pub fn cell(&self) -> &Cell {
        &self.cell
    }
}

impl PrintRobot<6, 1> for PartInHand {
    fn free(&self) -> [FreeRange; 1] {
        [FreeRange::Turn]
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 6])) {
        let flange = self.cell.flange(&of(waypoint), free[0]);
        for (branch, joints) in self.cell.arm().inverse(&flange).iter() {
            each(branch.slot() as u32, *joints);
        }
    }

    fn posture(&self, waypoint: &Waypoint, free: &[f64; 1], branch: u32) -> Option<Posture<6, 1>> {
        let flange = self.cell.flange(&of(waypoint), free[0]);
        let joints = *self.cell.arm().inverse(&flange).get(*Branch::ALL.get(branch as usize)?)?;
        Some(Posture { joints, rates: [self.cell.tool_rates(&joints)?.first] })
    }

    fn nozzle(&self, joints: &[f64; 6]) -> Option<Isometry3<f64>> {
        Some(self.cell.nozzle_on_part(joints))
    }

    fn continued(&self, waypoint: &Waypoint, free: &[f64; 1], turn: f64, near: &[f64; 6]) -> Option<[f64; 6]> {
        self.cell.arm().continuing(&self.cell.flange(&of(waypoint), free[0] + turn), near)
    }
}

impl Robot<6, 1> for PartInHand {
    fn waypoints(&self) -> usize {
        self.waypoints.len()
    }

    fn free(&self) -> [FreeRange; 1] {
        PrintRobot::free(self)
    }

    fn solutions(&self, waypoint: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 6])) {
        PrintRobot::solutions(self, &self.waypoints[waypoint], free, each);
    }

    fn posture(&self, waypoint: usize, free: &[f64; 1], branch: u32) -> Option<Posture<6, 1>> {
        PrintRobot::posture(self, &self.waypoints[waypoint], free, branch)
    }
}

impl Placed<6, 1> for PartInHand {
    fn with(&self, waypoints: Vec<Waypoint>) -> Self {
        PartInHand { cell: self.cell, waypoints }
    }

    fn path(&self) -> &[Waypoint] {
        &self.waypoints
    }

    fn bounds(&self, makers_speeds: bool) -> Bounds<6> {
        bounded(self.cell.arm().limits(), makers_speeds)
    }

    fn least_speed(
        &self,
        times: &[f64],
        bounds: &Bounds<6>,
        waypoints: Range<usize>,
    ) -> Result<Option<LeastSpeed>, LadderError> {
        least_speed(self, times, bounds, waypoints, CELLS, &|_| ControlFlow::Continue(())).map(Some)
    }
}

/// An IRB 1200 with the nozzle in its hand over an A-250, which carries the part: eight axes, of which the table's are
/// the last two. Free are the tilt and the turn of the table.
///
/// The nozzle is round and lies on axis 6, so that a tool angle, the third that is free, turns joint 6 and nothing else.
/// Whatever the others do, that joint is best left at rest, in the middle between its stops.
#[derive(Clone, Debug)]
pub struct OverTable {
    cell: TableCell,
    waypoints: Vec<Waypoint>,
}

impl OverTable {
    /// The cell of the figures: the tilt axis passes 520 mm before the base at a height of 120 mm, the part stands in
    /// the middle of the table, the nozzle is 150 mm long.
    ///
    /// # Errors
    /// None with these numbers.
    pub fn new(waypoints: Vec<Waypoint>) -> Result<Self, MotionError> {
        let positioner = Positioner::new(&robots::IRBP_A250, &Isometry3::translation(520.0, 0.0, -900.0))?;
        let nozzle = nozzle_frame(&Point3::new(0.0, 0.0, 150.0), &Vector3::z_axis());
        let arm = Arm::new(&robots::IRB1200)?;
        Ok(OverTable { cell: TableCell::nozzle_in_hand(arm, nozzle, positioner, Isometry3::identity())?, waypoints })
    }

    /// The cell.
    pub fn cell(&self) -> &TableCell {
        &self.cell
    }

    /// As few samples of tilt and turn as let the table go from one to the next in so many seconds, at the speed of the
    /// figures; at most 64 each, with which it may have to stand still.
    pub fn near_samples(seconds: f64) -> [u32; 2] {
        let steps = |range: f64| (range / (SPEED_RAD_S * seconds)).ceil().clamp(3.0, 63.0) as u32;
        [steps(2.0 * MOST_TILT) + 1, steps(TAU)]
    }

    /// The table and the cell with it, tilted and turned as said. Its turn may have come round.
    pub fn turned(&self, tilt: f64, turn: f64) -> Option<([f64; 2], Cell)> {
        let table = [tilt, turn - TAU * (turn / TAU).round()];
        Some((table, self.cell.at(&table)?))
    }
}

/// Joints of the arm, then those of the table.
pub fn eight(arm: &[f64; 6], table: [f64; 2]) -> [f64; 8] {
    let [a, b, c, d, e, f] = *arm;
    [a, b, c, d, e, f, table[0], table[1]]
}

/// The reverse of [`eight`].
pub fn six_and_two(joints: &[f64; 8]) -> ([f64; 6], [f64; 2]) {
    let [a, b, c, d, e, f, tilt, turn] = *joints;
    ([a, b, c, d, e, f], [tilt, turn])
}

impl PrintRobot<8, 2> for OverTable {
    fn free(&self) -> [FreeRange; 2] {
        [FreeRange::Within(-MOST_TILT, MOST_TILT), FreeRange::Turn]
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; 2], each: &mut dyn FnMut(u32, [f64; 8])) {
        let Some((table, cell)) = self.turned(free[0], free[1]) else { return };
        let flange = cell.flange(&of(waypoint), 0.0);
        for (branch, joints) in cell.arm().inverse(&flange).iter() {
            each(branch.slot() as u32, eight(&at_rest(joints), table));
        }
    }

    fn posture(&self, waypoint: &Waypoint, free: &[f64; 2], branch: u32) -> Option<Posture<8, 2>> {
        let (table, cell) = self.turned(free[0], free[1])?;
        let flange = cell.flange(&of(waypoint), 0.0);
        let joints = at_rest(cell.arm().inverse(&flange).get(*Branch::ALL.get(branch as usize)?)?);
        let [_, tilt, turn] = self.cell.rates(&table, &joints)?.map(|rates| at_rest(&rates.first));
        Some(Posture { joints: eight(&joints, table), rates: [eight(&tilt, [1.0, 0.0]), eight(&turn, [0.0, 1.0])] })
    }

    fn nozzle(&self, joints: &[f64; 8]) -> Option<Isometry3<f64>> {
        // Also where a turn passes its stops, which is another fault.
        let (arm, [tilt, turn]) = six_and_two(joints);
        let (_, cell) = self.turned(tilt, turn)?;
        Some(cell.nozzle_on_part(&arm))
    }

    /// The table stays as it is, whole turns included, and so does joint 6 but for the turn.
    fn continued(&self, waypoint: &Waypoint, _: &[f64; 2], turn: f64, near: &[f64; 8]) -> Option<[f64; 8]> {
        let (joints, table) = six_and_two(near);
        let cell = self.cell.at(&table)?;
        let (arm, flange) = (cell.arm(), cell.flange(&of(waypoint), 0.0));
        let back = joints[5] - arm.inverse(&flange).get(arm.branch(&joints))?[5];
        let flange = flange * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), back + turn);
        Some(eight(&arm.continuing(&flange, &joints)?, table))
    }
}

impl Robot<8, 2> for OverTable {
    fn waypoints(&self) -> usize {
        self.waypoints.len()
    }

    fn free(&self) -> [FreeRange; 2] {
        PrintRobot::free(self)
    }

    fn solutions(&self, waypoint: usize, free: &[f64; 2], each: &mut dyn FnMut(u32, [f64; 8])) {
        PrintRobot::solutions(self, &self.waypoints[waypoint], free, each);
    }

    fn posture(&self, waypoint: usize, free: &[f64; 2], branch: u32) -> Option<Posture<8, 2>> {
        PrintRobot::posture(self, &self.waypoints[waypoint], free, branch)
    }
}

/// With joint 6 in the middle between its stops; of rates, with none.
fn at_rest(joints: &[f64; 6]) -> [f64; 6] {
    let [a, b, c, d, e, _] = *joints;
    [a, b, c, d, e, 0.0]
}

impl Placed<8, 2> for OverTable {
    fn with(&self, waypoints: Vec<Waypoint>) -> Self {
        OverTable { cell: self.cell, waypoints }
    }

    fn path(&self) -> &[Waypoint] {
        &self.waypoints
    }

    fn bounds(&self, makers_speeds: bool) -> Bounds<8> {
        let (arm, table) = (self.cell.arm().limits(), self.cell.positioner().limits());
        let joined = |arm: [f64; 6], table: [f64; 2]| eight(&arm, table);
        let limits = JointLimits {
            lower: joined(arm.lower, table.lower),
            upper: joined(arm.upper, table.upper),
            velocity: joined(arm.velocity, table.velocity),
            ..JointLimits::NONE
        };
        bounded(&limits, makers_speeds)
    }
}

fn bounded<const N: usize>(limits: &JointLimits<N>, makers_speeds: bool) -> Bounds<N> {
    let velocity = if makers_speeds { limits.velocity } else { [SPEED_RAD_S; N] };
    let (acceleration, jerk) = ([ACCELERATION_RAD_S2; N], [JERK_RAD_S3; N]);
    Bounds { lower: limits.lower, upper: limits.upper, velocity, acceleration, jerk }
}

/// The bounds with the stops a little nearer.
pub fn inside<const N: usize>(bounds: &Bounds<N>) -> Bounds<N> {
    let [lower, upper] = [bounds.lower.map(|stop| stop + STOP_ROOM), bounds.upper.map(|stop| stop - STOP_ROOM)];
    Bounds { lower, upper, ..*bounds }
}

/// How far a nozzle on the part is from a waypoint.
fn apart(part_nozzle: &Isometry3<f64>, waypoint: &Waypoint) -> (f64, f64) {
    let axis = part_nozzle.rotation * Vector3::z();
    let angle = axis.cross(&waypoint.axis).norm().atan2(axis.dot(&waypoint.axis));
    ((part_nozzle.translation.vector - waypoint.position.coords).norm(), angle)
}
