//! Beads as bodies: their sections, and a grid that finds those near a place.
//!
//! The tip runs at the top of a bead, so the *middle* of a bead is half its height from the tip, against the direction of the nozzle.
//! Its section is that of a slicer: a core, as wide as the bead less its height, with a round rim. Between waypoints middles and
//! sizes go evenly from one to the next.

use crate::cells::{cell_of, least_side, with_neighbours};
use crate::orientation::Waypoint;
use nalgebra::{Point3, Vector3};

/// A bead across.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    pub middle: Point3<f64>,
    pub direction: Vector3<f64>,
    /// Half the width of its core.
    pub core: f64,
    /// Radius of its rim.
    pub rim: f64,
    pub arc: f64,
}

impl Section {
    pub fn of(at: &Waypoint) -> Section {
        let direction = at.axis.into_inner();
        let middle = at.position - direction * (0.5 * at.height);
        let core = (0.5 * (at.width - at.height)).max(0.0);
        Section { middle, direction, core, rim: 0.5 * at.height.min(at.width), arc: at.arc }
    }

    /// Part of the way to another.
    pub fn toward(&self, other: &Section, share: f64) -> Section {
        let direction = self.direction + (other.direction - self.direction) * share;
        let mix = |a: f64, b: f64| a + (b - a) * share;
        Section {
            middle: self.middle + (other.middle - self.middle) * share,
            // Opposite directions meet in none.
            direction: direction.try_normalize(1e-9).unwrap_or(self.direction),
            core: mix(self.core, other.core),
            rim: mix(self.rim, other.rim),
            arc: mix(self.arc, other.arc),
        }
    }

    /// How far a place is from the middle of the section: along its direction, and aside from the core.
    pub fn off(&self, at: Point3<f64>) -> [f64; 2] {
        let to = at - self.middle;
        let up = to.dot(&self.direction);
        [up, ((to - self.direction * up).norm() - self.core).max(0.0)]
    }
}

/// The share of the way between two sections that is nearest to a place.
pub(crate) fn nearest_share([a, b]: &[Section; 2], at: Point3<f64>) -> f64 {
    let way = b.middle - a.middle;
    let squared = way.norm_squared();
    if squared > 0.0 { (at - a.middle).dot(&way) / squared } else { 0.0 }
}

/// Both ends of the centre line of a piece of a bead.
pub(crate) fn middles([a, b]: &[Section; 2]) -> [Point3<f64>; 2] {
    [a.middle, b.middle]
}

/// Pieces of beads, by number, in the cells of a grid that their centre lines pass through: a spatial hash. A bucket holds the pieces of all cells with the
/// same hash, the last ones first.
pub(crate) struct BeadGrid {
    /// Where the pieces of each bucket begin in the list, and at last where it ends.
    firsts: Vec<usize>,
    numbers: Vec<u32>,
    side: f64,
}

impl BeadGrid {
    /// # Arguments
    /// * `lines`: the ends of the centre lines of all pieces.
    /// * `reach`: how far a place may be from the centre line of a piece that is found.
    pub fn new(lines: impl Iterator<Item = [Point3<f64>; 2]> + Clone, reach: f64) -> Self {
        let lengths = lines.clone().map(|[a, b]| (b - a).norm());
        let (count, length) = lengths.fold((0, 0.0), |(count, sum), length| (count + 1, sum + length));
        let reach = reach.max(least_side(length, count));
        // Samples of a piece are a quarter of the reach from what they stand for, so a cell and its neighbours have all within reach.
        let side = 1.25 * reach;
        let cells = |line: &[Point3<f64>; 2]| passed(*line, 0.5 * reach, side);
        let entries: usize = lines.clone().map(|line| cells(&line).count()).sum();
        let buckets = entries.max(1).next_power_of_two();
        // How many pieces each bucket has, then where they end, and, once all are in place, where they begin.
        let mut firsts = vec![0; buckets + 1];
        lines.clone().for_each(|line| cells(&line).for_each(|cell| firsts[bucket(cell, buckets)] += 1));
        let mut sum = 0;
        for first in &mut firsts {
            sum += *first;
            *first = sum;
        }
        let mut numbers = vec![0; entries];
        for (number, line) in (0..).zip(lines) {
            for cell in cells(&line) {
                let first = &mut firsts[bucket(cell, buckets)];
                *first -= 1;
                numbers[*first] = number;
            }
        }
        BeadGrid { firsts, numbers, side }
    }

    /// The pieces within reach of a place, and some others; some more than once.
    pub fn around(&self, at: Point3<f64>) -> impl Iterator<Item = u32> {
        self.in_and_around(self.cell(at))
    }

    /// The cell that a place is in.
    pub fn cell(&self, at: Point3<f64>) -> [i64; 3] {
        cell_of(at, self.side)
    }

    /// The same for all places of a cell.
    pub fn in_and_around(&self, cell: [i64; 3]) -> impl Iterator<Item = u32> {
        let pieces = |cell| {
            let bucket = bucket(cell, self.firsts.len() - 1);
            &self.numbers[self.firsts[bucket]..self.firsts[bucket + 1]]
        };
        with_neighbours(cell).flat_map(pieces).copied()
    }
}

/// The cells that samples of a line, at most `step` apart, lie in; one that comes twice in a row is handed out once.
fn passed([a, b]: [Point3<f64>; 2], step: f64, side: f64) -> impl Iterator<Item = [i64; 3]> {
    let steps = ((b - a).norm() / step).ceil().max(1.0);
    let cell = move |k: usize| cell_of(a + (b - a) * (k as f64 / steps), side);
    (0..=steps as usize)
        .map(cell)
        .scan(None, |last, cell| Some((last.replace(cell) != Some(cell)).then_some(cell)))
        .flatten()
}

/// The bucket of a cell, of so many, a power of two.
fn bucket([x, y, z]: [i64; 3], buckets: usize) -> usize {
    // The golden ratio as a share of 2^64: products with it are spread out evenly.
    const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
    let mixed = [x, y, z].iter().fold(0_u64, |mixed, &k| (mixed.rotate_left(21) ^ k as u64).wrapping_mul(GOLDEN));
    (mixed >> 32) as usize & (buckets - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// All pieces whose centre line is within reach of a place are found there, against a look at each of them.
        #[test]
        fn all_pieces_within_reach_are_found(
            lines in prop::collection::vec(prop::array::uniform2(prop::array::uniform3(-5.0_f64..5.0)), 0..40),
            places in prop::collection::vec(prop::array::uniform3(-6.0_f64..6.0), 1..20),
            reach in 0.05_f64..3.0,
        ) {
            let lines: Vec<[Point3<f64>; 2]> = lines.into_iter().map(|line| line.map(Point3::from)).collect();
            let grid = BeadGrid::new(lines.iter().copied(), reach);
            for at in places.into_iter().map(Point3::from) {
                let found: Vec<u32> = grid.around(at).collect();
                for (number, [a, b]) in (0..).zip(&lines) {
                    let way = b - a;
                    let share = ((at - a).dot(&way) / way.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                    if (at - (a + way * share)).norm() <= reach {
                        prop_assert!(found.contains(&number), "{number} of {found:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn pieces_far_away_are_not_found() {
        let line = |k: u32| [0.0, 0.5].map(|x| Point3::new(f64::from(k) + x, 0.0, 0.0));
        let grid = BeadGrid::new((0..1000).map(line), 0.4);
        // A place sees its own cell and those beside it, and in each bucket less than one other on average.
        let found = grid.around(Point3::new(500.0, 0.0, 0.0)).filter(|number| !(498..=502).contains(number)).count();
        assert!(found < 60, "{found}");
        assert!(grid.around(Point3::new(500.0, 0.0, 0.0)).any(|number| number == 500));
    }
}
