//! Which part of each lattice row lies deep in a body.
//!
//! A body is the intersection of half-spaces `n . p <= inner`, so along a row (fixed y and z) its deep part is one
//! interval. Over one level (fixed z) the upper end is the minimum of the lines
//! `(inner - n_z z - n_y y) / n_x` in `y`, one for each plane with `n_x > 0`: a lower envelope. Sorted by slope once, the planes are
//! put on a stack level after level; where a line takes over from the one before is decided exactly, at the rows.

use crate::error::HullError;
use crate::hull3::ConvexHull;
use crate::plane::{Depth, Plane};
use std::ops::RangeInclusive;

/// Rows of points along x: `y = origin[0] + k step` for `k < count[0]`, and likewise z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowLattice {
    /// y and z of the first row.
    pub origin: [i32; 2],
    /// Distance of neighbouring rows; at least 1.
    pub step: i32,
    /// Rows along y and z.
    pub count: [u32; 2],
}

/// For each row of a lattice the interval of integers `x` for which the point is deep in a body.
///
/// # Example
/// ```
/// use curvlay_hull::{ConvexHull, Depth, RowIntervals, RowLattice};
/// let mut hull = ConvexHull::new(Depth::new(1.0)?);
/// hull.insert(&[[0, 0, 0], [8, 0, 0], [0, 8, 0], [8, 8, 0], [0, 0, 8], [8, 0, 8], [0, 8, 8], [8, 8, 8]])?;
/// let mut rows = RowIntervals::new(RowLattice { origin: [0, 0], step: 1, count: [9, 9] })?;
/// rows.update(&hull);
/// assert_eq!(rows.interval(4, 4), Some(1..=7));
/// assert_eq!(rows.interval(0, 4), None);
/// # Ok::<(), curvlay_hull::HullError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RowIntervals {
    lattice: RowLattice,
    /// Row `y + count[0] * z`; empty where the first is above the second.
    ends: Vec<[i32; 2]>,
}

/// Wider than any row of points within [`crate::MAX_COORDINATE`].
const EVERYTHING: [i32; 2] = [i32::MIN, i32::MAX];
const NOTHING: [i32; 2] = [0, -1];
/// A bound beyond every point: slanted planes may cross a far row at an `x` that no `i32` holds.
const BEYOND: i64 = 1 << 20;

/// A plane as it bounds the rows of one direction of x: `x <= (constant - slope y) / run`, with `run > 0`.
#[derive(Clone, Copy, Debug)]
struct Line {
    run: i64,
    slope: i64,
    constant: i64,
}

impl Line {
    /// The value of the line at `y`, times `run`.
    fn at(&self, y: i32) -> i64 {
        self.constant - self.slope * i64::from(y)
    }

    /// Whether this line lies below the other one at `y`.
    fn below(&self, other: &Line, y: i32) -> bool {
        i128::from(self.at(y)) * i128::from(other.run) < i128::from(other.at(y)) * i128::from(self.run)
    }
}

impl RowIntervals {
    /// Rows of which nothing is known to be deep.
    ///
    /// # Errors
    /// [`HullError::Rows`] for a step below 1 or above 2^21, rows beyond 2^20 (they may lie far from any body, but not so far that
    /// heights over planes leave 64 bits), or 2^28 rows or more.
    pub fn new(lattice: RowLattice) -> Result<Self, HullError> {
        let RowLattice { origin, step, count } = lattice;
        let last = |axis: usize| i64::from(origin[axis]) + i64::from(step) * (i64::from(count[axis]) - 1).max(0);
        let within = |place: i64| place.abs() <= BEYOND;
        let rows = u64::from(count[0]) * u64::from(count[1]);
        // A step that leads nowhere, with one row, must not make products of 64 bits overflow either.
        if !(1..=2 * BEYOND).contains(&i64::from(step))
            || rows >= 1 << 28
            || (0..2).any(|axis| !within(origin[axis].into()) || !within(last(axis)))
        {
            return Err(HullError::Rows { origin, step, count });
        }
        Ok(RowIntervals { lattice, ends: vec![NOTHING; rows as usize] })
    }

    /// The rows.
    pub fn lattice(&self) -> RowLattice {
        self.lattice
    }

    /// The integers `x` for which the point in row `y`, `z` (counted from 0) is deep.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn interval(&self, y: u32, z: u32) -> Option<RangeInclusive<i32>> {
        let [ny, nz] = self.lattice.count;
        assert!(y < ny && z < nz, "row {y}, {z} of {ny} x {nz}");
        let [low, high] = self.ends[y as usize + ny as usize * z as usize];
        (low <= high).then_some(low..=high)
    }

    /// Brings the intervals up to date with `hull`.
    ///
    /// # Cost
    /// `O(f log f + f nz + ny nz)` for `f` facets. Exact.
    pub fn update(&mut self, hull: &ConvexHull) {
        let [ny, nz] = self.lattice.count;
        if !hull.is_solid() {
            // A body without volume has points at depth 0 only: ask for each of its rows.
            return self.update_from_flat(hull);
        }
        let upper = sorted_by_slope(hull, |plane| plane.normal);
        let lower = sorted_by_slope(hull, |plane| [-plane.normal[0], plane.normal[1], plane.normal[2]]);
        let across: Vec<Plane> = hull.planes().filter(|plane| plane.normal[0] == 0).collect();
        let mut envelope = Vec::new();
        for z in 0..nz {
            let height = self.lattice.origin[1] + self.lattice.step * z as i32;
            let rows = self.rows_between(&across, height);
            let level = &mut self.ends[(ny * z) as usize..(ny * (z + 1)) as usize];
            level.fill(NOTHING);
            level[rows.clone()].fill(EVERYTHING);
            for (lines, side) in [(&lower, 0), (&upper, 1)] {
                lower_envelope(lines, height, self.lattice, rows.clone(), &mut envelope);
                for (at, (line, from)) in envelope.iter().enumerate() {
                    let until = envelope.get(at + 1).map_or(rows.end, |(_, next)| *next);
                    for (row, ends) in level.iter_mut().enumerate().take(until).skip(*from) {
                        let y = self.lattice.origin[0] + self.lattice.step * row as i32;
                        let bound = line.at(y).div_euclid(line.run);
                        // Cut off so that a row whose ends both lie beyond stays empty.
                        ends[side] = match side {
                            1 => bound.clamp(-BEYOND, BEYOND) as i32,
                            _ => (-bound).clamp(1 - BEYOND, 1 + BEYOND) as i32,
                        };
                    }
                }
            }
        }
    }

    /// The rows of the level at `height` that no plane along x keeps from being deep.
    fn rows_between(&self, across: &[Plane], height: i32) -> std::ops::Range<usize> {
        let RowLattice { origin: [y0, _], step, count: [ny, _] } = self.lattice;
        let (mut first, mut end) = (0, i64::from(ny));
        for plane in across {
            // slope (y0 + step k) <= rest
            let rest = plane.inner - plane.normal[2] * i64::from(height) - plane.normal[1] * i64::from(y0);
            match plane.normal[1] * i64::from(step) {
                0 if rest < 0 => end = 0,
                0 => {}
                slope if slope > 0 => end = end.min(rest.div_euclid(slope) + 1),
                slope => first = first.max(-rest.div_euclid(-slope)),
            }
        }
        if first < end { first as usize..end as usize } else { 0..0 }
    }

    fn update_from_flat(&mut self, hull: &ConvexHull) {
        let [ny, _] = self.lattice.count;
        self.ends.fill(NOTHING);
        if hull.depth() != Depth::SURFACE {
            return; // of a body without volume no point is deep below its surface
        }
        let extent = |axis: usize| {
            let up = [0, 1, 2].map(|k| i32::from(k == axis));
            Some(-hull.support(up.map(|c| -c))?..=hull.support(up)?)
        };
        let (Some(xs), Some(ys), Some(zs)) = (extent(0), extent(1), extent(2)) else {
            return; // no point at all
        };
        let (low, high) = (*xs.start() as i32, *xs.end() as i32);
        for (row, ends) in self.ends.iter_mut().enumerate() {
            let index = [row as u32 % ny, row as u32 / ny];
            let [y, z] = [0, 1].map(|k| self.lattice.origin[k] + self.lattice.step * index[k] as i32);
            if !ys.contains(&y.into()) || !zs.contains(&z.into()) {
                continue; // rows beside the body are not searched
            }
            let mut deep = (low..=high).filter(|&x| hull.is_deep([x, y, z]));
            let first = deep.next();
            *ends = first.map_or(NOTHING, |first| [first, deep.next_back().unwrap_or(first)]);
        }
    }
}

/// The planes that bound x from above once `normal_of` has been applied, by rising slope.
fn sorted_by_slope(hull: &ConvexHull, normal_of: impl Fn(&Plane) -> [i64; 3]) -> Vec<([i64; 3], i64)> {
    let mut lines: Vec<_> =
        hull.planes().map(|plane| (normal_of(&plane), plane.inner)).filter(|(normal, _)| normal[0] > 0).collect();
    lines.sort_by(|(a, _), (b, _)| (i128::from(a[1]) * i128::from(b[0])).cmp(&(i128::from(b[1]) * i128::from(a[0]))));
    lines
}

/// The least of the lines at each of the `rows` of a level: which line, and the first row where it is the least.
fn lower_envelope(
    lines: &[([i64; 3], i64)],
    height: i32,
    lattice: RowLattice,
    rows: std::ops::Range<usize>,
    envelope: &mut Vec<(Line, usize)>,
) {
    envelope.clear();
    for &([run, slope, rise], inner) in lines {
        let line = Line { run, slope, constant: inner - rise * i64::from(height) };
        let mut from = rows.start;
        while let Some(&(last, since)) = envelope.last() {
            from = takes_over(&line, &last, lattice, since, rows.end);
            if from > since {
                break;
            }
            envelope.pop();
        }
        if envelope.is_empty() {
            from = rows.start;
        }
        if from < rows.end {
            envelope.push((line, from));
        }
    }
}

/// The first of the rows `since..end` where `line` lies below `last`; its slope is no less, so it stays below.
fn takes_over(line: &Line, last: &Line, lattice: RowLattice, since: usize, end: usize) -> usize {
    let y = |row: usize| lattice.origin[0] + lattice.step * row as i32;
    let below = |row: usize| line.below(last, y(row));
    // Where they cross, in floating point; then the exact signs around it.
    let steeper = line.slope as f64 * last.run as f64 - last.slope as f64 * line.run as f64;
    let ahead = line.constant as f64 * last.run as f64 - last.constant as f64 * line.run as f64;
    let crossing = (ahead / steeper - f64::from(lattice.origin[0])) / f64::from(lattice.step);
    if crossing.is_nan() {
        return end; // the same line again, as from the triangles of one face
    }
    let mut row = crossing.ceil().clamp(since as f64, end as f64) as usize;
    while row < end && !below(row) {
        row += 1;
    }
    while row > since && below(row - 1) {
        row -= 1;
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MAX_NORMAL: i64 = 1 << 34;

    /// A line, and how another one differs from it: by little, so that the crossing in floating point is off.
    fn lines() -> impl Strategy<Value = (Line, [i64; 3])> {
        let close = || prop_oneof![-3..=3i64, -100_000..=100_000i64];
        let line = (1..MAX_NORMAL, -MAX_NORMAL..MAX_NORMAL, -(1i64 << 51)..1 << 51);
        (line.prop_map(|(run, slope, constant)| Line { run, slope, constant }), [close(), close(), close()])
    }

    /// The line that differs from `last` by so much, through about the same place at `y`.
    fn crossing(last: &Line, [wider, steeper, higher]: [i64; 3], y: i64) -> Line {
        let (run, slope) = ((last.run + wider).max(1), last.slope + steeper);
        let level = i128::from(last.constant - last.slope * y) * i128::from(run) / i128::from(last.run);
        Line { run, slope, constant: level as i64 + slope * y + higher }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn lines_take_over_at_the_first_row_where_they_lie_below(
            (a, differs) in lines(), origin in -5000..5000, step in prop_oneof![1..4, 1..70], rows in [0..50usize, 1..150usize], at in 0..150usize,
        ) {
            let crossed = rows[0] + at % rows[1];
            let b = crossing(&a, differs, i64::from(origin) + i64::from(step) * crossed as i64);
            let rises = |line: &Line, other: &Line| i128::from(line.slope) * i128::from(other.run);
            let (last, line) = if rises(&a, &b) <= rises(&b, &a) { (a, b) } else { (b, a) };
            let [since, end] = [rows[0], rows[0] + rows[1]];
            let lattice = RowLattice { origin: [origin, 0], step, count: [end as u32, 1] };
            let value = |line: &Line, row: usize| {
                i128::from(line.constant) - i128::from(line.slope) * (i128::from(origin) + i128::from(step) * row as i128)
            };
            let below = |row: &usize| value(&line, *row) * i128::from(last.run) < value(&last, *row) * i128::from(line.run);
            let expected = (since..end).find(below).unwrap_or(end);
            prop_assert_eq!(takes_over(&line, &last, lattice, since, end), expected);
        }
    }
}
