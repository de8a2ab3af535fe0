//! A timed path, or why there is none.

use crate::BoundsError;
use crate::spline::Trajectory;

/// How the search for the least duration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimePathStatus {
    /// Within the tolerance.
    Solved,
    /// The steps were spent before. All limits hold, but the duration may be longer than need be.
    Iterations,
}

/// A timed motion along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedMotion<const N: usize> {
    /// What is executed. It begins at time 0.
    pub trajectory: Trajectory<N>,
    /// For each posture its knot in the trajectory.
    pub knots: Vec<usize>,
    /// For each knot of the trajectory the planned time that it stands for.
    pub planned: Vec<f64>,
    /// For each knot of the trajectory the pace: planned seconds a second; 0 at both ends.
    pub pace: Vec<f64>,
    /// How far the first and the last posture are missed, in radians: knots at rest follow from their neighbours (see
    /// [`Timeline`](crate::Timeline)). The other postures are met.
    pub end_deviation: f64,
    /// Duration of the discretised problem, in seconds, without what the executed spline needs beyond it.
    pub ideal_duration: f64,
    /// Steps of the interior-point methods together.
    pub iterations: usize,
    /// Gap and residual of the last round, as a share of the duration.
    pub residual: f64,
    /// How the search ended.
    pub status: TimePathStatus,
}

impl<const N: usize> TimedMotion<N> {
    /// From rest to rest, in seconds.
    pub fn duration(&self) -> f64 {
        let (start, end) = self.trajectory.span();
        end - start
    }
}

/// Why a path cannot be timed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TimePathError {
    /// Fewer than two postures.
    #[error("a path of {postures} postures: at least two are needed")]
    TooFew {
        /// Postures that were given.
        postures: usize,
    },
    /// A list does not have one entry for each posture or piece.
    #[error("{given} entries in `{field}`: pass {expected}")]
    Count {
        /// `planned`, `max_pace` or `flow_mm3_s`.
        field: &'static str,
        /// Its length.
        given: usize,
        /// The length it must have.
        expected: usize,
    },
    /// An angle is infinite or not a number.
    #[error("joint {} of posture {posture} is {value}, not a finite number", joint + 1)]
    Posture {
        /// The posture, counted from 0.
        posture: usize,
        /// The joint, counted from 0.
        joint: usize,
        /// Its angle.
        value: f64,
    },
    /// A planned time is not finite, or not after the one before it.
    #[error(
        "the planned time of posture {posture} is {time} s: it must be finite and after that of the posture before"
    )]
    Planned {
        /// The posture, counted from 0.
        posture: usize,
        /// Its planned time.
        time: f64,
    },
    /// A number for a piece is invalid.
    #[error("`{field}` of piece {piece} is {value}: a pace must be above 0, a flow finite and not negative")]
    Piece {
        /// `max_pace`, which must be above 0, or `flow_mm3_s`, which must be finite and not negative.
        field: &'static str,
        /// The piece, counted from 0.
        piece: usize,
        /// Its value.
        value: f64,
    },
    /// A limit of the flow is not above 0.
    #[error("`{field}` is {value}: it must be above 0, or infinite")]
    Flow {
        /// `max_flow_mm3_s` or `max_ramp_mm3_s2`.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// An option is out of its range.
    #[error("option `{field}` is {value}: it must be {must}")]
    Option {
        /// The option.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// Joints cannot move.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// Numbers are so large or so small that times or angles are no longer finite or distinct.
    #[error("the timing exceeds double precision: bring times, postures and limits to similar scales")]
    Range,
    /// The progress callback cancelled the work.
    #[error("cancelled")]
    Cancelled,
}
