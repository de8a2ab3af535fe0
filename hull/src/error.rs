//! What callers can get wrong.

/// Why a hull cannot take its input.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// A coordinate is too large for exact arithmetic.
    #[error("point {index} has the coordinate {value}, beyond {MAX_COORDINATE}")]
    OutOfReach {
        /// Position of the point in the input.
        index: usize,
        /// The coordinate.
        value: i32,
    },
    /// A column needs a cross-section with area.
    #[error("a column needs at least three corners that are not on a line")]
    NoArea,
    /// Rows that do not lie within reach, or are too many.
    #[error(
        "{count:?} rows {step} apart from {origin:?} on: they must lie within {MAX_COORDINATE} and be fewer than 2^28"
    )]
    Rows {
        /// y and z of the first row.
        origin: [i32; 2],
        /// Distance of neighbouring rows.
        step: i32,
        /// Rows along y and z.
        count: [u32; 2],
    },
    /// A depth is negative, not a number, or too large.
    #[error("a depth of {units} lattice units, it must lie between 0 and {MAX_DEPTH}")]
    Depth {
        /// The depth that was asked for, in lattice units.
        units: f64,
    },
}

/// Largest coordinate of a point, either way: with it normals stay below 2^35 and offsets below 2^52.
pub const MAX_COORDINATE: i32 = (1 << 15) - 1;

/// Largest depth, in lattice units: with it squares of distances in steps stay within 128 bits.
pub(crate) const MAX_DEPTH: f64 = 64.0;

/// Refuses points that are out of reach.
pub(crate) fn check<const N: usize>(points: &[[i32; N]]) -> Result<(), HullError> {
    for (index, point) in points.iter().enumerate() {
        if let Some(&value) = point.iter().find(|value| value.unsigned_abs() > MAX_COORDINATE.unsigned_abs()) {
            return Err(HullError::OutOfReach { index, value });
        }
    }
    Ok(())
}
