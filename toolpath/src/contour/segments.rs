//! Segments of curves, looked up by where they are.

use super::polyline::Curve;
use crate::cells::{cell_of, least_side};
use crate::path::SurfacePath;
use nalgebra::Point3;
use std::ops::Range;

/// A cell, and two numbers that say which segment it is.
type Entry = ([i64; 3], [u32; 2]);

/// Pieces of lines by the cells of a grid.
pub(crate) struct Segments {
    side: f64,
    /// Sorted.
    cells: Vec<Entry>,
    columns: Columns,
}

/// Where the entries of each column of cells begin: those with the same x and y, which follow each other. Lines fill a layer, so most
/// columns of a rectangle around them have some.
#[derive(Default)]
struct Columns {
    low: [i64; 2],
    /// Columns along x and y; none where the rectangle would have many more than there are entries.
    sides: [usize; 2],
    /// By x, then y, and an end.
    starts: Vec<u32>,
}

/// Columns for each entry, and in any case, that are worth their memory.
const MAX_COLUMNS: [usize; 2] = [4, 1 << 10];

impl Segments {
    /// Nothing yet, in cells of a side.
    pub fn new(side: f64) -> Self {
        Segments { side, cells: Vec::new(), columns: Columns::default() }
    }

    /// Nothing yet, in cells for segments of paths that are looked up within a reach.
    pub fn within<'a>(reach: f64, paths: impl Iterator<Item = &'a SurfacePath>) -> Self {
        let (mut length, mut count) = (0.0, 0);
        for path in paths {
            length += path.length();
            count += path.segments();
        }
        Segments::new((4.0 / 3.0 * reach).max(least_side(length, count)))
    }

    /// Those of curves: the number of each curve, and of the point where a segment begins.
    pub(super) fn of(curves: &[Curve], side: f64) -> Self {
        let mut all = Segments::new(side);
        for (number, curve) in (0..).zip(curves) {
            let count = curve.points.len();
            for k in 0..curve.segments() {
                all.add([k, (k + 1) % count].map(|k| curve.points[k].position), [number, k as u32]);
            }
        }
        all.sort();
        all
    }

    /// Adds those of paths, by the number of the path and of the point where a segment begins, and sorts.
    pub fn add_all(&mut self, paths: &[SurfacePath]) {
        for (number, path) in (0..).zip(paths) {
            (0..path.segments())
                .for_each(|k| self.add(path.segment(k).map(|point| point.at.position), [number, k as u32]));
        }
        self.sort();
    }

    /// Adds a segment; they must be sorted before any is looked up.
    pub fn add(&mut self, ends: [Point3<f64>; 2], name: [u32; 2]) {
        for p in samples(ends, self.side) {
            let entry = (cell_of(p, self.side), name);
            // A straight line does not come back to a cell that it has left.
            if self.cells.last() != Some(&entry) {
                self.cells.push(entry);
            }
        }
    }

    pub fn sort(&mut self) {
        self.columns = Columns::around(&self.cells);
        self.columns.sort(&mut self.cells);
    }

    /// Those that come within three quarters of a side of a point, some others, and some twice.
    pub fn near(&self, p: Point3<f64>) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.in_columns(p, (-1..=1).flat_map(|i| (-1..=1).map(move |j| [i, j])))
    }

    /// The same, those in the cell of the point and above and below it first.
    pub fn near_by_distance(&self, p: Point3<f64>) -> impl Iterator<Item = [u32; 2]> + '_ {
        const COLUMNS: [[i64; 2]; 9] = [[0, 0], [-1, 0], [1, 0], [0, -1], [0, 1], [-1, -1], [-1, 1], [1, -1], [1, 1]];
        self.in_columns(p, COLUMNS.into_iter())
    }

    /// Those in some columns of three cells, by how far these are from the cell of a point.
    fn in_columns(
        &self,
        p: Point3<f64>,
        columns: impl Iterator<Item = [i64; 2]> + 'static,
    ) -> impl Iterator<Item = [u32; 2]> + '_ {
        let [x, y, z] = cell_of(p, self.side);
        // Samples are a quarter of a side from what they stand for at most, so what is near is in the next cell.
        columns.map(move |[i, j]| [x + i, y + j]).flat_map(move |[x, y]| {
            let column = &self.cells[self.columns.range([x, y], self.cells.len())];
            let start = column.partition_point(|entry| entry.0 < [x, y, z - 1]);
            column[start..].iter().take_while(move |entry| entry.0 <= [x, y, z + 1]).map(|entry| entry.1)
        })
    }

    /// Those that may meet a line; some twice.
    pub fn along(&self, ends: [Point3<f64>; 2]) -> impl Iterator<Item = [u32; 2]> + '_ {
        samples(ends, self.side).flat_map(|p| self.near(p))
    }
}

impl Columns {
    /// The columns that entries are in; none yet where each begins.
    fn around(cells: &[Entry]) -> Columns {
        let (mut low, mut high) = ([i64::MAX; 2], [i64::MIN; 2]);
        for ([x, y, _], _) in cells {
            low = [low[0].min(*x), low[1].min(*y)];
            high = [high[0].max(*x), high[1].max(*y)];
        }
        let side = |k: usize| usize::try_from(high[k].checked_sub(low[k])?).ok()?.checked_add(1);
        let sides = side(0).zip(side(1)).map(|(x, y)| [x, y]);
        let most = cells.len().saturating_mul(MAX_COLUMNS[0]).saturating_add(MAX_COLUMNS[1]);
        let few = |&[x, y]: &[usize; 2]| x.checked_mul(y).is_some_and(|columns| columns <= most);
        let sides = sides.filter(few).filter(|_| u32::try_from(cells.len()).is_ok());
        Columns { low, sides: sides.unwrap_or_default(), starts: Vec::new() }
    }

    /// Sorts entries: first by column, by counting, and then each column.
    fn sort(&mut self, cells: &mut Vec<Entry>) {
        let columns = self.sides[0] * self.sides[1];
        if columns == 0 {
            cells.sort_unstable();
            return;
        }
        let column = |&([x, y, _], _): &Entry| {
            let [x, y] = [x - self.low[0], y - self.low[1]].map(|k| k as usize);
            x * self.sides[1] + y
        };
        let mut starts = vec![0; columns + 1];
        cells.iter().for_each(|entry| starts[column(entry) + 1] += 1);
        (1..starts.len()).for_each(|k| starts[k] += starts[k - 1]);
        let (mut filled, mut sorted) = (starts.clone(), vec![([0; 3], [0; 2]); cells.len()]);
        for entry in cells.iter() {
            let at = &mut filled[column(entry)];
            sorted[*at as usize] = *entry;
            *at += 1;
        }
        starts.windows(2).for_each(|ends| sorted[ends[0] as usize..ends[1] as usize].sort_unstable());
        self.starts = starts;
        *cells = sorted;
    }

    /// Among so many entries, where those of a column are: all where that is not known.
    fn range(&self, [x, y]: [i64; 2], entries: usize) -> Range<usize> {
        if self.starts.is_empty() {
            return 0..entries;
        }
        let place = |at: i64, k: usize| {
            usize::try_from(at.checked_sub(self.low[k])?).ok().filter(|&place| place < self.sides[k])
        };
        match (place(x, 0), place(y, 1)) {
            (Some(x), Some(y)) => {
                let column = x * self.sides[1] + y;
                self.starts[column] as usize..self.starts[column + 1] as usize
            }
            _ => 0..0,
        }
    }
}

/// Points along a segment, half a side apart at most, both ends included.
fn samples([a, b]: [Point3<f64>; 2], side: f64) -> impl Iterator<Item = Point3<f64>> {
    let steps = (2.0 * (b - a).norm() / side).ceil().max(1.0);
    (0..=steps as usize).map(move |k| a + (b - a) * (k as f64 / steps))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Slow twin: all entries, sorted, one by one. Lines lie close together, so that columns are counted, or far apart.
        #[test]
        fn near_are_the_entries_of_the_cells_around(
            ends in prop::collection::vec((prop::array::uniform3(-4.0_f64..4.0), prop::array::uniform3(-2.0_f64..2.0)), 0..40),
            apart in prop::sample::select(vec![1.0, 1e3, 1e7]),
            place in prop::array::uniform3(-5.0_f64..5.0),
        ) {
            let mut segments = Segments::new(1.0);
            for (number, (from, way)) in (0..).zip(&ends) {
                let from = Point3::from(*from) * if number % 3 == 0 { apart } else { 1.0 };
                segments.add([from, from + nalgebra::Vector3::from(*way)], [number, 2 * number]);
            }
            let mut all = segments.cells.clone();
            all.sort();
            segments.sort();
            prop_assert_eq!(&segments.cells, &all);
            let [x, y, z] = cell_of(place.into(), 1.0);
            let mut wanted = Vec::new();
            for i in -1..=1 {
                for j in -1..=1 {
                    let cells = [-1, 0, 1].map(|k| [x + i, y + j, z + k]);
                    wanted.extend(all.iter().filter(|entry| cells.contains(&entry.0)).map(|entry| entry.1));
                }
            }
            prop_assert_eq!(segments.near(place.into()).collect::<Vec<_>>(), wanted);
        }
    }
}
