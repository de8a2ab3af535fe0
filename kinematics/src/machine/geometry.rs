//! A checked machine: its chain from the part to the nozzle, and forward kinematics.

use super::model::{MachineKind, MachineModel};
use super::rotate::turned;
use crate::angle::nearest_image;
use nalgebra::{Matrix3, Point3, UnitVector3, Vector3};
use std::f64::consts::TAU;

/// How many values a posture has.
pub(super) const AXES: usize = 5;

/// How far beyond an end a rotary value may be for rounding, radians; it is moved to the end.
pub(super) const ANGLE_SLACK: f64 = 1e-9;

/// How far beyond an end a linear value may be for rounding, mm.
pub(super) const LINEAR_SLACK: f64 = 1e-9;

/// A linear axis, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Linear {
    pub range: [f64; 2],
    pub speed: f64,
    pub acceleration: f64,
}

/// A rotary axis, checked; angles in radians, infinite ends where it turns without end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rotary {
    pub is_table: bool,
    pub axis: Vector3<f64>,
    pub point: Vector3<f64>,
    pub zero: f64,
    pub range: [f64; 2],
    pub speed: f64,
    pub acceleration: f64,
}

/// Images of an angle, whole turns apart, within a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Images {
    pub first: f64,
    pub count: u64,
}

impl Rotary {
    /// The sense in which the nozzle turns as the part sees it: a table that turns one way turns the nozzle the other way.
    fn sense(&self) -> f64 {
        if self.is_table { -1.0 } else { 1.0 }
    }

    /// By which angle the nozzle turns, as the part sees it, at a reading.
    pub fn angle(&self, reading: f64) -> f64 {
        self.sense() * (reading - self.zero)
    }

    /// The reading at such an angle.
    pub fn reading(&self, angle: f64) -> f64 {
        self.zero + self.sense() * angle
    }

    pub fn is_endless(&self) -> bool {
        self.range[0].is_infinite()
    }

    /// What the chain beyond this axis looks like after it has turned: a point and a direction.
    pub fn turn(&self, reading: f64, point: &Vector3<f64>, direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let angle = self.angle(reading);
        [self.point + turned(&self.axis, angle, &(point - self.point)), turned(&self.axis, angle, direction)]
    }

    /// All images of a reading within the range; of an endless axis the one nearest to `near`.
    pub fn images(&self, reading: f64, near: f64) -> Option<Images> {
        if self.is_endless() {
            return Some(Images { first: nearest_image(reading, near), count: 1 });
        }
        let [min, max] = self.range;
        let first = reading + TAU * ((min - ANGLE_SLACK - reading) / TAU).ceil();
        let beyond = max + ANGLE_SLACK - first;
        // The range is at most some thousand turns wide.
        (beyond >= 0.0).then(|| Images { first, count: (beyond / TAU) as u64 + 1 })
    }

    /// A number of [`Rotary::images`], at the end where rounding leaves it beyond.
    pub fn image(&self, images: &Images, number: u64) -> f64 {
        (images.first + TAU * number as f64).clamp(self.range[0], self.range[1])
    }

    /// The image next to `near` that is within the range, or beyond it by `slack` and then moved to its end.
    pub fn nearest(&self, reading: f64, near: f64, slack: f64) -> Option<f64> {
        let image = nearest_image(reading, near);
        let within = image.clamp(self.range[0], self.range[1]);
        ((within - image).abs() <= slack).then_some(within)
    }
}

/// Values of the linear axes (0 for one that is not there) and readings of the rotary ones, whatever the controller's program says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Posture {
    pub linear: Vector3<f64>,
    pub rotary: [f64; 2],
}

/// Angles between the rotary axes and the nozzle, by which the inverse goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wrist {
    /// Between the first and the second axis.
    pub axes: f64,
    /// Between the second axis and the nozzle.
    pub nozzle: f64,
    /// About the second axis, from the nozzle to the first axis.
    pub upright: f64,
}

/// A five-axis machine, checked. See the [module](crate::machine) for its geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct FiveAxis {
    pub(super) model: MachineModel,
    pub(super) kind: MachineKind,
    /// Linear axes first, `'\0'` behind the last one.
    pub(super) letters: [char; AXES],
    pub(super) linear: Vec<Linear>,
    pub(super) rotary: [Rotary; 2],
    /// Directions of the linear axes, zero for one that is not there.
    pub(super) columns: Matrix3<f64>,
    /// From a way of the nozzle to values of the linear axes, zero for one that is not there.
    pub(super) rows: Matrix3<f64>,
    /// Across the plane of two linear axes.
    pub(super) across: Vector3<f64>,
    pub(super) tip: Vector3<f64>,
    pub(super) nozzle: Vector3<f64>,
    pub(super) origin: Vector3<f64>,
    pub(super) wrist: Wrist,
}

impl FiveAxis {
    /// The numbers.
    pub fn model(&self) -> &MachineModel {
        &self.model
    }

    /// How the axes are arranged.
    pub fn kind(&self) -> MachineKind {
        self.kind
    }

    /// Whether X Y Z of its programs are the tip in the part.
    pub fn knows_tip(&self) -> bool {
        self.model.tcp
    }

    /// The letters of the axes in the order of their values: the linear ones, then the rotary ones. Five, or four on a machine with two
    /// linear axes, where the fifth value is 0.
    pub fn letters(&self) -> &[char] {
        &self.letters[..self.linear.len() + 2]
    }

    /// How many of the axes are linear: 3, or 2.
    pub fn linear_count(&self) -> usize {
        self.linear.len()
    }

    /// Lower and upper end of each axis in the order of [`FiveAxis::letters`], mm and radians; infinite for an endless axis. With `tcp` those of
    /// the linear axes bound [`FiveAxis::joints`], not the values in programs.
    pub fn ranges(&self) -> [[f64; 2]; 5] {
        let mut ranges = [[0.0; 2]; AXES];
        let all = self.linear.iter().map(|axis| axis.range).chain(self.rotary.iter().map(|axis| axis.range));
        ranges.iter_mut().zip(all).for_each(|(to, from)| *to = from);
        ranges
    }

    /// The tip in the part and the direction from the tip into the nozzle, at values as they stand in a program: mm and radians in the order of
    /// [`FiveAxis::letters`], whether in their ranges or not.
    ///
    /// With `tcp` the first three values are the tip.
    pub fn forward(&self, axes: &[f64; 5]) -> (Point3<f64>, UnitVector3<f64>) {
        let (tip, direction) = self.tip_at(&self.posture(axes));
        let tip = if self.model.tcp { Vector3::new(axes[0], axes[1], axes[2]) } else { tip };
        (tip.into(), UnitVector3::new_normalize(direction))
    }

    /// Where the axes are when a program's values are these: with `tcp` the first three become positions of the linear axes.
    pub fn joints(&self, axes: &[f64; 5]) -> [f64; 5] {
        let posture = self.posture(axes);
        if !self.model.tcp {
            return *axes;
        }
        let linear = self.place(&Vector3::new(axes[0], axes[1], axes[2]), &posture.rotary);
        [linear.x, linear.y, linear.z, axes[3], axes[4]]
    }

    /// The values of a program from which planning starts by default: those of the zero posture, or the nearest within the ranges.
    pub fn start(&self) -> [f64; 5] {
        let within = |value: f64, [min, max]: [f64; 2]| value.clamp(min, max);
        let linear = Vector3::from_fn(|k, _| self.linear.get(k).map_or(0.0, |axis| within(0.0, axis.range)));
        let rotary = self.rotary.map(|axis| within(axis.zero, axis.range));
        self.values(&Posture { linear, rotary })
    }

    /// The posture at values of a program. With `tcp` its linear axes are not those of the machine.
    fn posture(&self, axes: &[f64; AXES]) -> Posture {
        let n = self.linear.len();
        let linear = Vector3::from_fn(|k, _| if k < n { axes[k] } else { 0.0 });
        Posture { linear, rotary: [axes[n], axes[n + 1]] }
    }

    /// The readings of the rotary axes among values of a program.
    pub(super) fn rotary_of(&self, axes: &[f64; AXES]) -> [f64; 2] {
        self.posture(axes).rotary
    }

    /// A posture as values of a program.
    pub(super) fn values(&self, posture: &Posture) -> [f64; AXES] {
        let first = if self.model.tcp { self.tip_at(posture).0 } else { posture.linear };
        let [a, b] = posture.rotary;
        if self.linear.len() == 3 { [first.x, first.y, first.z, a, b] } else { [first.x, first.y, a, b, 0.0] }
    }

    /// The tip in the part and the direction, of unit length but for rounding.
    pub(super) fn tip_at(&self, posture: &Posture) -> (Vector3<f64>, Vector3<f64>) {
        let (mut tip, mut direction) = (self.tip, self.nozzle);
        let way = self.columns * posture.linear;
        let mut is_below = false;
        // From the nozzle to the part: head axes, the linear ones, table axes.
        for k in [1, 0] {
            let axis = &self.rotary[k];
            if axis.is_table && !is_below {
                tip += way;
                is_below = true;
            }
            [tip, direction] = axis.turn(posture.rotary[k], &tip, &direction);
        }
        if !is_below {
            tip += way;
        }
        (tip - self.origin, direction)
    }

    /// The values of the linear axes that bring the tip to a point of the part. With two linear axes, as near to it as they can.
    pub(super) fn place(&self, tip: &Vector3<f64>, rotary: &[f64; 2]) -> Vector3<f64> {
        let (mut at, mut nozzle) = (tip + self.origin, self.tip);
        for (axis, reading) in self.rotary.iter().zip(rotary).filter(|(axis, _)| axis.is_table) {
            at = axis.point + turned(&axis.axis, -axis.angle(*reading), &(at - axis.point));
        }
        for (axis, reading) in self.rotary.iter().zip(rotary).rev().filter(|(axis, _)| !axis.is_table) {
            nozzle = axis.point + turned(&axis.axis, axis.angle(*reading), &(nozzle - axis.point));
        }
        self.rows * (at - nozzle)
    }

    /// Whether the linear axes reach these values.
    pub(super) fn has_linear(&self, values: &Vector3<f64>) -> bool {
        // False for NaN.
        let is_within = |(axis, &value): (&Linear, &f64)| {
            value >= axis.range[0] - LINEAR_SLACK && value <= axis.range[1] + LINEAR_SLACK
        };
        self.linear.iter().zip(values.iter()).all(is_within)
    }

    /// The second reading that brings the nozzle nearest to a direction of the part at a first reading, as near to `near` as whole turns allow, within the range, or beyond it by `slack`
    /// and then moved to its end.
    pub(super) fn tilt_for(&self, direction: &Vector3<f64>, turn: f64, near: f64) -> f64 {
        let [first, second] = &self.rotary;
        let seen = turned(&first.axis, -first.angle(turn), direction);
        let angle = super::rotate::angle_about(&second.axis, &self.nozzle, &seen);
        nearest_image(second.reading(angle), near)
    }
}
