//! The samples nearest to a point: a grid of cells with a few samples each.

use super::sample::StressSample;
use nalgebra::Point3;

/// Samples that are interpolated between: a linear function of space has four unknowns; three times as many keep it calm.
pub(super) const NEAREST: usize = 12;

/// Samples a cell, about.
const SAMPLES_A_CELL: f64 = 4.0;

/// Samples by cells.
#[derive(Debug)]
pub(super) struct SampleGrid<'s> {
    samples: &'s [StressSample],
    low: Point3<f64>,
    cell: f64,
    dims: [i64; 3],
    starts: Vec<u32>,
    order: Vec<u32>,
}

impl<'s> SampleGrid<'s> {
    /// `samples`: at least one, all finite.
    pub(super) fn new(samples: &'s [StressSample]) -> Self {
        let first = samples[0].point.coords;
        let (low, high) =
            samples.iter().fold((first, first), |(low, high), s| (low.inf(&s.point.coords), high.sup(&s.point.coords)));
        let size = high - low;
        // Cells as wide as makes for a few samples each in a box without its flat sides.
        let mut wide: Vec<f64> = size.iter().copied().filter(|&side| side > 0.0).collect();
        wide.sort_by(|a, b| b.total_cmp(a));
        let cells = (samples.len() as f64 / SAMPLES_A_CELL).max(1.0);
        let mut cell = f64::MIN_POSITIVE;
        let mut volume = 1.0;
        for (k, side) in wide.iter().enumerate() {
            volume *= side;
            // Sides flatter than a cell do not count.
            cell = f64::max(cell, (volume / cells).powf(1.0 / (k + 1) as f64));
        }
        let dims = [0, 1, 2].map(|k| (size[k] / cell).floor().min(1e6) as i64 + 1);
        let mut grid = SampleGrid { samples, low: low.into(), cell, dims, starts: Vec::new(), order: Vec::new() };
        let keys: Vec<usize> = samples.iter().map(|s| grid.key(grid.cell_of(s.point))).collect();
        let count = dims.iter().product::<i64>() as usize;
        grid.starts = vec![0; count + 1];
        keys.iter().for_each(|&key| grid.starts[key + 1] += 1);
        (0..count).for_each(|key| grid.starts[key + 1] += grid.starts[key]);
        let mut filled = grid.starts.clone();
        grid.order = vec![0; samples.len()];
        for (sample, &key) in keys.iter().enumerate() {
            grid.order[filled[key] as usize] = sample as u32;
            filled[key] += 1;
        }
        grid
    }

    fn cell_of(&self, p: Point3<f64>) -> [i64; 3] {
        [0, 1, 2].map(|k| (((p[k] - self.low[k]) / self.cell).floor() as i64).clamp(0, self.dims[k] - 1))
    }

    fn key(&self, [x, y, z]: [i64; 3]) -> usize {
        (x + self.dims[0] * (y + self.dims[1] * z)) as usize
    }

    /// The [`NEAREST`] samples within `reach` of a point, squared distances first; of equally near ones those with lower numbers.
    pub(super) fn nearest(&self, p: Point3<f64>, reach: f64, near: &mut Vec<(f64, u32)>) {
        near.clear();
        let middle = self.cell_of(p);
        // A shell of cells at a time; what is not in the first `ring` shells is farther than this.
        let last = *self.dims.iter().max().unwrap_or(&1);
        let outside = (0..3).map(|k| {
            let high = self.low[k] + self.cell * self.dims[k] as f64;
            (self.low[k] - p[k]).max(p[k] - high).max(0.0)
        });
        if outside.fold(0.0, f64::max) > reach {
            return;
        }
        for ring in 0..=last {
            let cleared = (ring - 1).max(0) as f64 * self.cell;
            if cleared > reach || (near.len() >= NEAREST && near[NEAREST - 1].0 <= cleared * cleared) {
                break;
            }
            self.shell(middle, ring, |sample| {
                let square = (self.samples[sample as usize].point - p).norm_squared();
                if square <= reach * reach {
                    let at = near.partition_point(|other| *other < (square, sample));
                    if at < NEAREST {
                        near.insert(at, (square, sample));
                        near.truncate(NEAREST);
                    }
                }
            });
        }
    }

    /// Hands over the samples in the cells that are `ring` cells away.
    fn shell(&self, middle: [i64; 3], ring: i64, mut each: impl FnMut(u32)) {
        let range = |k: usize| (middle[k] - ring).max(0)..=(middle[k] + ring).min(self.dims[k] - 1);
        for z in range(2) {
            for y in range(1) {
                let inner = (z - middle[2]).abs() < ring && (y - middle[1]).abs() < ring;
                let step = if inner { 2 * ring } else { 1 };
                let mut x = middle[0] - ring;
                while x <= middle[0] + ring {
                    if (0..self.dims[0]).contains(&x) {
                        let key = self.key([x, y, z]);
                        let range = self.starts[key] as usize..self.starts[key + 1] as usize;
                        self.order[range].iter().for_each(|&sample| each(sample));
                    }
                    x += step;
                }
            }
        }
    }
}
