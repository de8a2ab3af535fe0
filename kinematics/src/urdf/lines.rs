//! Lines in space, and how they are to each other.

use super::error::{AxisMisfit, Misfit};
use nalgebra::{Isometry3, Vector3};

/// Axes fit a family up to this angle, in radians: a hundred times what six digits of pi/2 lose, and 0.02 mm at a metre.
pub(super) const ANGLE: f64 = 2e-5;

/// The same in millimetres: more than URDFs round lengths by.
pub(super) const DISTANCE_MM: f64 = 0.01;

/// A line: a point and a direction of length 1.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line {
    pub at: Vector3<f64>,
    pub along: Vector3<f64>,
}

impl Line {
    pub fn seen_from(&self, frame: &Isometry3<f64>) -> Line {
        let inverse = frame.inverse();
        Line { at: (inverse * nalgebra::Point3::from(self.at)).coords, along: inverse * self.along }
    }

    pub fn distance_of(&self, point: &Vector3<f64>) -> f64 {
        (point - self.at).cross(&self.along).norm()
    }

    /// The point of this line that is nearest to another line, which is not parallel.
    pub fn nearest_to(&self, other: &Line) -> Vector3<f64> {
        let normal = self.along.cross(&other.along);
        let t = (other.at - self.at).cross(&other.along).dot(&normal) / normal.norm_squared();
        self.at + self.along * t
    }

    /// How far two lines that are not parallel pass each other.
    pub fn gap(&self, other: &Line) -> f64 {
        other.distance_of(&self.nearest_to(other))
    }
}

/// Conditions between axes; the first that does not hold is kept.
pub(super) struct Conditions<'a> {
    axes: &'a [Line; 6],
    pub first: Option<AxisMisfit>,
}

impl<'a> Conditions<'a> {
    pub fn new(axes: &'a [Line; 6]) -> Self {
        Conditions { axes, first: None }
    }

    fn note(&mut self, holds: bool, axis: usize, against: usize, misfit: Misfit) {
        if !holds && self.first.is_none() {
            self.first = Some(AxisMisfit { axis, against, misfit });
        }
    }

    pub fn parallel(&mut self, axis: usize, against: usize) {
        let angle = self.axes[axis].along.cross(&self.axes[against].along).norm().min(1.0).asin();
        self.note(angle <= ANGLE, axis, against, Misfit::NotParallel(angle));
    }

    pub fn square(&mut self, axis: usize, against: usize) {
        let angle = self.axes[axis].along.dot(&self.axes[against].along).abs().min(1.0).asin();
        self.note(angle <= ANGLE, axis, against, Misfit::NotSquare(angle));
    }

    /// For axes that are not parallel.
    pub fn meet(&mut self, axis: usize, against: usize) {
        if self.first.is_none() {
            let gap = self.axes[axis].gap(&self.axes[against]);
            self.note(gap <= DISTANCE_MM, axis, against, Misfit::Apart(gap));
        }
    }

    /// Whether an axis passes through a point.
    pub fn through(&mut self, point: &Vector3<f64>, axis: usize, against: usize) {
        let gap = self.axes[axis].distance_of(point);
        self.note(gap <= DISTANCE_MM, axis, against, Misfit::Apart(gap));
    }

    /// For axes that are parallel.
    pub fn beside(&mut self, axis: usize, against: usize) {
        let gap = self.axes[against].distance_of(&self.axes[axis].at);
        self.note(gap > DISTANCE_MM, axis, against, Misfit::Same);
    }
}

/// Which way to count an axis, so that a length comes out above zero; the way of the file where it is about zero.
pub(super) fn sense(length: f64) -> f64 {
    if length < -DISTANCE_MM { -1.0 } else { 1.0 }
}

/// The sign of a direction against an axis that it is parallel to.
pub(super) fn sign(along: &Vector3<f64>, axis: &Vector3<f64>) -> f64 {
    if along.dot(axis) < 0.0 { -1.0 } else { 1.0 }
}
