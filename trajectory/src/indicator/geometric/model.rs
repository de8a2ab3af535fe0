//! What an indicator compares with what, and which models are invalid.

use super::grid::DistanceGrid;
use super::near::MAX_BODIES;
use super::shapes::{Ball, Capsule, Cylinder, Plane};
use nalgebra::Point3;

/// What is compared with what.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeometricModel {
    /// Grids with the bodies that carry them: the part. Compared with balls, capsules and cylinders.
    pub grids: Vec<(usize, DistanceGrid)>,
    /// Balls, compared with the grids alone: what has no other shape, such as a cone.
    pub balls: Vec<Ball>,
    /// Capsules, compared with everything but balls: links, a nozzle, obstacles.
    pub capsules: Vec<Capsule>,
    /// Cylinders, compared with everything but balls: a foot, a flange. Where they overlap with each other or with a
    /// grid, by more than 2 mm, how much is not reported.
    pub cylinders: Vec<Cylinder>,
    /// Planes, compared with capsules and cylinders.
    pub planes: Vec<Plane>,
    /// Pairs of bodies that are not compared: neighbours in the arm, the foot and the table.
    pub ignored: Vec<[usize; 2]>,
    /// Nearer than this counts as a collision, in millimetres. May be below 0, to offset shapes that are too large.
    pub margin: f64,
}

/// Why there is no indicator.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeometricError {
    /// Too many bodies.
    #[error("{count} bodies: at most {MAX_BODIES} are supported")]
    TooManyBodies {
        /// How many.
        count: usize,
    },
    /// A shape is of a body that there is not.
    #[error("{what} {index} is of body {body}, there are {count}")]
    NoBody {
        /// `ball`, `grid`, `capsule`, `cylinder`, `plane` or `ignored pair`.
        what: &'static str,
        /// Which of them.
        index: usize,
        /// Its body.
        body: usize,
        /// Number of bodies.
        count: usize,
    },
    /// A shape has a number that is not finite, a radius below 0, or is a cylinder between a point and itself.
    #[error("{what} {index} is invalid: numbers must be finite, its radius not below 0, ends of a cylinder apart")]
    Shape {
        /// `ball`, `capsule`, `cylinder` or `plane`.
        what: &'static str,
        /// Which of them.
        index: usize,
    },
    /// The margin is not finite.
    #[error("the margin is {0}: it must be finite")]
    Margin(
        /// Its value.
        f64,
    ),
    /// No two shapes move against each other.
    #[error("nothing to compare: no two shapes of bodies that move against each other")]
    Nothing,
}

pub(super) fn check(model: &GeometricModel, count: usize) -> Result<(), GeometricError> {
    if !model.margin.is_finite() {
        return Err(GeometricError::Margin(model.margin));
    }
    let known = |what, index, body| {
        if body < count { Ok(()) } else { Err(GeometricError::NoBody { what, index, body, count }) }
    };
    let sound = |what, index, is_sound: bool| is_sound.then_some(()).ok_or(GeometricError::Shape { what, index });
    let finite = |point: &Point3<f64>| point.iter().all(|x| x.is_finite());
    let length = |radius: f64| radius.is_finite() && radius >= 0.0;
    for (index, ball) in model.balls.iter().enumerate() {
        known("ball", index, ball.body)?;
        sound("ball", index, finite(&ball.center) && length(ball.radius))?;
    }
    for (index, (body, _)) in model.grids.iter().enumerate() {
        known("grid", index, *body)?;
    }
    for (index, capsule) in model.capsules.iter().enumerate() {
        known("capsule", index, capsule.body)?;
        sound("capsule", index, finite(&capsule.from) && finite(&capsule.to) && length(capsule.radius))?;
    }
    for (index, cylinder) in model.cylinders.iter().enumerate() {
        known("cylinder", index, cylinder.body)?;
        let (from, to) = (&cylinder.from, &cylinder.to);
        let long = (to - from).norm();
        sound(
            "cylinder",
            index,
            finite(from) && finite(to) && length(cylinder.radius) && long.is_finite() && long > 0.0,
        )?;
    }
    for (index, plane) in model.planes.iter().enumerate() {
        known("plane", index, plane.body)?;
        sound("plane", index, finite(&plane.point) && plane.normal.iter().all(|x| x.is_finite()))?;
    }
    for (index, pair) in model.ignored.iter().enumerate() {
        known("ignored pair", index, pair[0])?;
        known("ignored pair", index, pair[1])?;
    }
    Ok(())
}
