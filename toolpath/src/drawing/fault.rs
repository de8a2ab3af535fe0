//! What is wrong with a curve.

/// What is wrong with a curve.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveFault {
    /// A number is NaN or infinite.
    #[error("a number is not finite")]
    NotFinite,
    /// A coordinate is too large.
    #[error("a coordinate is {value:.2e} mm, beyond the limit of {limit:e} mm")]
    TooFar {
        /// The coordinate.
        value: f64,
        /// Greatest coordinate.
        limit: f64,
    },
    /// An arc whose radius is zero.
    #[error("the radius is 0")]
    ZeroRadius,
    /// A spline of a degree that cannot be, or with too few control points for it.
    #[error("a spline of degree {degree} cannot have {points} control points")]
    Degree {
        /// Its degree.
        degree: usize,
        /// Its control points.
        points: usize,
    },
    /// Knots are missing, or too many.
    #[error("the spline needs {expected} knots and has {found}")]
    KnotCount {
        /// Knots needed.
        expected: usize,
        /// Knots there are.
        found: usize,
    },
    /// Knots that fall, or span nothing.
    #[error("the knots of the spline must not fall, and must span an interval")]
    Knots,
    /// A weight that is not above zero, or not one for each control point.
    #[error("the weights of the spline must be above 0, one for each control point")]
    Weights,
}

/// Greatest coordinate of a drawing, in millimetres: a kilometre. Beyond it a double no longer holds a nanometre.
pub const MAX_COORDINATE_MM: f64 = 1e6;
