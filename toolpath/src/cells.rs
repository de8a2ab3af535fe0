//! Grids of cubic cells over space.

use nalgebra::Point3;

/// Places farther out are in the last cell, so that it has neighbours, too.
const LAST: i64 = i64::MAX / 2;

/// A piece of mean length passes through this many half cells at most: a tenth of a metre in cells of 0.4 mm.
const MAX_STEPS: f64 = 512.0;

/// The cell along an axis that a coordinate is in, of cells with a side in millimetres; one begins at the origin.
pub(crate) fn cell_along(x: f64, side: f64) -> i64 {
    ((x / side).floor() as i64).clamp(-LAST, LAST)
}

/// The cell that a place is in.
pub(crate) fn cell_of(at: Point3<f64>, side: f64) -> [i64; 3] {
    [at.x, at.y, at.z].map(|x| cell_along(x, side))
}

/// The least side of cells for so many pieces that are so long together: with smaller ones, pieces that are far longer than what is looked for
/// would fill the memory. Larger cells only take longer to look through.
pub(crate) fn least_side(length: f64, pieces: usize) -> f64 {
    2.0 * length / pieces.max(1) as f64 / MAX_STEPS
}

/// A cell and the 26 around it, by x, then y, then z.
pub(crate) fn with_neighbours([x, y, z]: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (-1..=1).flat_map(move |i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])))
}

#[cfg(test)]
mod tests {
    use super::cell_of;
    use nalgebra::Point3;

    #[test]
    fn cells_begin_at_the_origin() {
        assert_eq!(cell_of(Point3::new(0.0, 1.9, -0.1), 2.0), [0, 0, -1]);
        assert_eq!(cell_of(Point3::new(2.0, -2.0, -2.1), 2.0), [1, -1, -2]);
    }
}
