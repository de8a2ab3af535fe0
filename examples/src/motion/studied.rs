//! The motions of the dissertation: their cells, bounds and figures.

use super::cells::{TABLE_CELL, UR3_CELL};
use super::on_cell::{OverTable, PartInHand};
use curvlay_kinematics::JointLimits;
use curvlay_kinematics::workcell::{
    self, AnyWorkcell, EightAxisWorkcell, Held, LimitsModel, SixAxisWorkcell, Workcell, WorkcellFileError,
    WorkcellModel,
};
use curvlay_trajectory::print::{PrintRobot, Waypoint};
use curvlay_trajectory::{Bounds, LadderError, MinSpeed, Robot, min_speed};
use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use std::f64::consts::TAU;
use std::ops::{ControlFlow, Range};

/// Seconds from one waypoint to the next where no feed is given: 2,545 of them take 460 s, as in the dissertation.
pub const STEP_S: f64 = 460.0 / 2545.0;

/// The bounds at which all figures are made; the arms' own stops stay.
const SPEED_RAD_S: f64 = 1.0;

const ACCELERATION_RAD_S2: f64 = 5.0;

const JERK_RAD_S3: f64 = 1.0;

/// How far from a stop a ladder's waypoints stay, in radians: splines sway between them.
const STOP_ROOM: f64 = 0.05;

/// Cells of the tool angle for lower bounds on the joint speed: three digits.
const CELLS: u32 = 8192;

/// What the figures of the dissertation are made with, and what is reported of them.
pub trait Studied<const N: usize, const F: usize>: Robot<N, F> + PrintRobot<N, F> {
    /// Its waypoints.
    fn path(&self) -> &[Waypoint];

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
    /// As of [`min_speed`].
    fn min_speed(
        &self,
        times: &[f64],
        bounds: &Bounds<N>,
        waypoints: Range<usize>,
    ) -> Result<Option<MinSpeed>, LadderError>;
}

impl Studied<6, 1> for PartInHand {
    fn path(&self) -> &[Waypoint] {
        self.all()
    }

    fn bounds(&self, makers_speeds: bool) -> Bounds<6> {
        of_figures(self.workcell().limits(), makers_speeds)
    }

    fn min_speed(
        &self,
        times: &[f64],
        bounds: &Bounds<6>,
        waypoints: Range<usize>,
    ) -> Result<Option<MinSpeed>, LadderError> {
        min_speed(self, times, bounds, waypoints, CELLS, &|_| ControlFlow::Continue(())).map(Some)
    }
}

impl Studied<8, 2> for OverTable {
    fn path(&self) -> &[Waypoint] {
        self.all()
    }

    fn bounds(&self, makers_speeds: bool) -> Bounds<8> {
        of_figures(self.workcell().limits(), makers_speeds)
    }

    fn min_speed(&self, _: &[f64], _: &Bounds<8>, _: Range<usize>) -> Result<Option<MinSpeed>, LadderError> {
        Ok(None)
    }
}

fn of_figures<const N: usize>(limits: &JointLimits<N>, makers_speeds: bool) -> Bounds<N> {
    let velocity = if makers_speeds { limits.velocity } else { [SPEED_RAD_S; N] };
    let (acceleration, jerk) = ([ACCELERATION_RAD_S2; N], [JERK_RAD_S3; N]);
    Bounds { lower: limits.lower, upper: limits.upper, velocity, acceleration, jerk }
}

/// Where the part is at the flange and where the tip stands in the cell of the UR3 for which all figures are made, in millimetres. Prints
/// keep the part farther from the wrist ([`UR3_CELL`]), since the bodies of the links need room.
const STUDIED_PART_MM: [f64; 3] = [0.0, 0.0, 45.0];

const STUDIED_TIP_MM: [f64; 3] = [300.0, 60.0, 220.0];

/// The two cells of the dissertation, with the makers' stops, as all figures of its motions are made.
///
/// # Errors
/// None with the files that are there.
pub fn dissertation_cells() -> Result<(SixAxisWorkcell, EightAxisWorkcell), WorkcellFileError> {
    let cell = |file: &str| -> Result<AnyWorkcell, WorkcellFileError> {
        let mut model = WorkcellModel::from_json(file.as_bytes())?;
        model.arm.limits = LimitsModel::default();
        if model.held == Held::Part {
            (model.part.position_mm, model.nozzle.tip_mm) = (STUDIED_PART_MM, STUDIED_TIP_MM);
        }
        Ok(AnyWorkcell::new(model)?)
    };
    match (cell(UR3_CELL)?, cell(TABLE_CELL)?) {
        (AnyWorkcell::Six(six), AnyWorkcell::Eight(eight)) => Ok((six, eight)),
        _ => unreachable!("the first has six axes, the second eight"),
    }
}

/// As few samples of tilt and turn as let the table go from one to the next in so many seconds, at the speed of the
/// figures; at most 64 each, with which it may have to stand still.
pub fn near_samples(cell: &EightAxisWorkcell, seconds: f64) -> [u32; 2] {
    let steps = |range: f64| (range / (SPEED_RAD_S * seconds)).ceil().clamp(3.0, 63.0) as u32;
    cell.free().map(|range| match range {
        workcell::FreeRange::Turn => steps(TAU),
        workcell::FreeRange::Within(min, max) => steps(max - min) + 1,
    })
}

/// Waypoints centred in x and y by their mean, the lowest at z = 0.
pub fn centred(path: &[(Point3<f64>, UnitVector3<f64>)]) -> Vec<Waypoint> {
    let mean = path.iter().map(|(p, _)| p.coords).sum::<Vector3<f64>>() / path.len().max(1) as f64;
    let lowest = path.iter().map(|(p, _)| p.z).fold(f64::INFINITY, f64::min);
    let origin = Vector3::new(mean.x, mean.y, lowest);
    path.iter().map(|&(position, axis)| Waypoint { position: position - origin, axis }).collect()
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
