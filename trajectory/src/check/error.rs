//! Why a print cannot be checked.

use crate::BoundsError;
use crate::check::MotionKind;

/// Why a print cannot be checked. What is wrong with a motion itself is a [`Finding`](super::Finding).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CheckError {
    /// A motion has fewer than two knots.
    #[error("motion {motion} has {knots} knots, 2 are needed")]
    TooFewKnots {
        /// The motion, counted from 0.
        motion: usize,
        /// Its knots.
        knots: usize,
    },
    /// Not as many times as joints.
    #[error("motion {motion} has {times} times for {joints} knots")]
    Count {
        /// The motion, counted from 0.
        motion: usize,
        /// Its times.
        times: usize,
        /// Its joint positions.
        joints: usize,
    },
    /// A time is infinite or not a number.
    #[error("motion {motion}: the time of knot {knot} is {time}, not a finite number")]
    Time {
        /// The motion, counted from 0.
        motion: usize,
        /// The knot, counted from 0.
        knot: usize,
        /// Its time.
        time: f64,
    },
    /// A time is not after the one before.
    #[error("motion {motion}: the time of knot {knot} is {time} s, not after {before} s of the one before")]
    NotRising {
        /// The motion, counted from 0.
        motion: usize,
        /// The knot, counted from 0.
        knot: usize,
        /// Its time.
        time: f64,
        /// The time of the knot before.
        before: f64,
    },
    /// An angle is infinite or not a number.
    #[error("motion {motion}: joint {} at knot {knot} is {value}, not a finite number", joint + 1)]
    Angle {
        /// The motion, counted from 0.
        motion: usize,
        /// The knot, counted from 0.
        knot: usize,
        /// The joint, counted from 0.
        joint: usize,
        /// Its angle.
        value: f64,
    },
    /// Two knots are so close in time that the spline between them has no finite derivatives.
    #[error("motion {motion}: knots {knot} and {} are too close in time", knot + 1)]
    TooClose {
        /// The motion, counted from 0.
        motion: usize,
        /// The first of the two, counted from 0.
        knot: usize,
    },
    /// A print without a path, or a travel with one.
    #[error("motion {motion} is a {kind:?} with {points} path points")]
    PathLength {
        /// The motion, counted from 0.
        motion: usize,
        /// What it is for.
        kind: MotionKind,
        /// Its path points.
        points: usize,
    },
    /// A path point has a coordinate that is infinite or not a number.
    #[error("motion {motion}: path point {point} has an invalid coordinate")]
    PathPoint {
        /// The motion, counted from 0.
        motion: usize,
        /// The point, counted from 0.
        point: usize,
    },
    /// A path is followed from later to earlier, or at times beyond the motion.
    #[error("motion {motion}: prints from {from} s to {to} s, but goes from {begin} s to {end} s")]
    Printing {
        /// The motion, counted from 0.
        motion: usize,
        /// When the path begins.
        from: f64,
        /// When the path ends.
        to: f64,
        /// When the motion begins.
        begin: f64,
        /// When the motion ends.
        end: f64,
    },
    /// A motion along a path, or to a waypoint of it, that there is not, or from a later waypoint to an earlier one.
    #[error("motion {motion}: path {path} has no waypoint {waypoint}, or it is passed in the wrong order")]
    NoWaypoint {
        /// The motion, counted from 0.
        motion: usize,
        /// Its path.
        path: usize,
        /// The waypoint.
        waypoint: usize,
    },
    /// The scene cannot add a layer.
    #[error("layer {layer} cannot be added: {why}")]
    Layer {
        /// The layer, counted from 0.
        layer: u32,
        /// Why, in words.
        why: String,
    },
    /// Limits that nothing can keep.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// An option is out of range.
    #[error("option {what} is {value}: it must be finite and {min} at least")]
    Option {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its least value.
        min: f64,
    },
    /// The progress callback cancelled the check.
    #[error("cancelled")]
    Cancelled,
}
