//! Beads as bodies: their sections, and a grid that finds those near a place.
//!
//! The tip runs at the top of a bead, so the *middle* of a bead is half its height from the tip, against the direction of the nozzle.
//! Its section is that of a slicer: a core, as wide as the bead less its height, with a round rim. Between waypoints middles and
//! sizes go evenly from one to the next.

use crate::cells::{cell_of, least_side, with_neighbours};
use crate::orientation::Waypoint;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

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

/// Pieces of beads, by number, in the cells of a grid that they pass through.
pub(crate) struct BeadGrid {
    cells: HashMap<[i64; 3], Vec<u32>>,
    side: f64,
}

impl BeadGrid {
    /// # Arguments
    /// * `reach`: how far a place may be from the centre line of a piece that is found.
    pub fn new<'a>(pieces: impl Iterator<Item = &'a [Section; 2]> + Clone, reach: f64) -> Self {
        let lengths = pieces.clone().map(|[a, b]| (b.middle - a.middle).norm());
        let (count, length) = lengths.fold((0, 0.0), |(count, sum), length| (count + 1, sum + length));
        let reach = reach.max(least_side(length, count));
        // Samples of a piece are a quarter of the reach from what they stand for, so a cell and its neighbours have all within reach.
        let side = 1.25 * reach;
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for (number, [a, b]) in (0..).zip(pieces) {
            let steps = ((b.middle - a.middle).norm() / (0.5 * reach)).ceil().max(1.0) as usize;
            for k in 0..=steps {
                let at = a.middle + (b.middle - a.middle) * (k as f64 / steps as f64);
                let here = cells.entry(cell_of(at, side)).or_default();
                if here.last() != Some(&number) {
                    here.push(number);
                }
            }
        }
        BeadGrid { cells, side }
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
        with_neighbours(cell).filter_map(|cell| self.cells.get(&cell)).flatten().copied()
    }
}
