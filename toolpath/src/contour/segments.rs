//! Segments of curves, looked up by where they are.

use super::polyline::Curve;
use crate::cells::cell_of;
use crate::path::SurfacePath;
use nalgebra::Point3;

/// Pieces of lines by the cells of a grid.
pub(crate) struct Segments {
    side: f64,
    /// Cells with two numbers that say which segment it is, sorted.
    cells: Vec<([i64; 3], [u32; 2])>,
}

impl Segments {
    /// Nothing yet, in cells of a side.
    pub fn new(side: f64) -> Self {
        Segments { side, cells: Vec::new() }
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
        let first = self.cells.len();
        for p in samples(ends, self.side) {
            let entry = (cell_of(p, self.side), name);
            if !self.cells[first..].contains(&entry) {
                self.cells.push(entry);
            }
        }
    }

    pub fn sort(&mut self) {
        self.cells.sort_unstable();
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
            let start = self.cells.partition_point(|entry| entry.0 < [x, y, z - 1]);
            self.cells[start..].iter().take_while(move |entry| entry.0 <= [x, y, z + 1]).map(|entry| entry.1)
        })
    }

    /// Those that may meet a line; some twice.
    pub fn along(&self, ends: [Point3<f64>; 2]) -> impl Iterator<Item = [u32; 2]> + '_ {
        samples(ends, self.side).flat_map(|p| self.near(p))
    }
}

/// Points along a segment, half a side apart at most, both ends included.
fn samples([a, b]: [Point3<f64>; 2], side: f64) -> impl Iterator<Item = Point3<f64>> {
    let steps = (2.0 * (b - a).norm() / side).ceil().max(1.0);
    (0..=steps as usize).map(move |k| a + (b - a) * (k as f64 / steps))
}
