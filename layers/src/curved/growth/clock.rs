//! Growth by the clock: the front moves at one cell a layer whichever way it goes, and waits where it must.
//!
//! A cell is due when the front gets to it: its *time* solves `|grad T| = 1` from the cells that are built (fast
//! marching; J. A. Sethian, "A fast marching level set method for monotonically advancing fronts", PNAS 93, 1996),
//! with the plate at 0. On demand a level front that had no wait since the plate *stays level* where the part gets wider,
//! as it does with hop counts: a cell that it carries from one level down, straight or leaning out, is due a layer
//! later. Otherwise the front turns round the corner.
//!
//! Layer `k`, from 1, takes the cells with `k - 1 <= T < k` that have a support in an earlier layer, less those that would
//! shadow others ([`super::prevention`]). What is held back gets a time in the layer in which it is let go ([`SHORT_WAIT`]), and
//! the front goes on from there at its usual pace. So the layers that the times are cut into are an order that can be built.

use super::front::{Front, Protected};
use super::{GrowthError, prevention};
use crate::cells::{CellSet, Cells};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::{Neighbours, Rules};
use crate::curved::buildable::supported::supported_by_platform;
use crate::{Progress, ProgressFn};
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::f64::consts::SQRT_2;

/// Times this close are one, where a front is level.
const ROUNDING: f64 = 1e-9;

/// A front that has to wait no longer than this, in layers, sets out again as soon as it may: the surfaces there are a
/// little closer. One that waits longer sets out in the middle of a layer, so that its first surface lies in the
/// middle of the cells that waited; with the beginning of the layer it would lie on the face to those before.
const SHORT_WAIT: f64 = 0.3;

/// Neighbours one level down, the first in the list of offsets.
const BELOW: usize = 5;

/// The neighbours along each axis.
const ALONG: [[[i32; 3]; 2]; 3] = [[[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]], [[0, 0, -1], [0, 0, 1]]];

/// Times by the clock.
pub(crate) struct Clocked {
    /// Time of each cell of the grid, in layers; not a number without one.
    pub(crate) times: Vec<f64>,
    /// Whether each cell got a time.
    pub(crate) complete: bool,
}

/// A time to sort by.
#[derive(Clone, Copy, PartialEq)]
struct Time(f64);

impl Eq for Time {}

impl PartialOrd for Time {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Time {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Grows `cells`, none of them before the time in `release`.
pub(crate) fn grow_by_clock(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    release: Vec<f64>,
    stays_level: bool,
    progress: ProgressFn,
) -> Result<Clocked, GrowthError> {
    let mut clock = Clock::new(cells, platform, rules, release, stays_level)?;
    let first = supported_by_platform(cells, platform, rules)?;
    clock.front.build_all(&first)?;
    // The plate is at time 0, and the middle of a cell on it half a cell above.
    clock.build(&first.iter().map(|&cell| (cell, 0.5)).collect::<Vec<_>>());
    let total = cells.count() as u64;
    let mut layer = 0.0;
    while let Some(due) = clock.next_due() {
        // Never the same layer twice, so this ends: what is held back has its time in a later one.
        layer = due.floor().max(layer + 1.0);
        clock.build_layer(layer)?;
        let done = clock.front.order.cells().len() as u64;
        if progress(Progress { stage: "uniform", done, total }).is_break() {
            return Err(GrowthError::Cancelled);
        }
    }
    let complete = clock.front.lost.is_empty() && clock.front.waiting.iter().next().is_none();
    Ok(Clocked { times: clock.times, complete })
}

/// The state between two layers.
struct Clock<'a> {
    offsets: &'a [[i32; 3]],
    front: Front,
    solid: CellSet,
    stays_level: bool,
    /// Cells of a level of the grid, empty ones included.
    level: u32,
    /// Times of the cells that are built or chosen for the layer in the making; not a number for the others.
    times: Vec<f64>,
    /// No cell is due before this.
    release: Vec<f64>,
    /// When the cells at the front are due, by what is known so far.
    due: Vec<f64>,
    /// The same by time. Entries that `due` has gone below are passed over.
    queue: BinaryHeap<Reverse<(Time, u32)>>,
    /// Cells that wait for another one to be built.
    held: CellSet,
}

impl<'a> Clock<'a> {
    fn new(
        cells: &Cells,
        platform: &Platform,
        rules: &'a Rules,
        release: Vec<f64>,
        stays_level: bool,
    ) -> Result<Self, GrowthError> {
        Ok(Clock {
            offsets: rules.neighbours.offsets(),
            front: Front::new(cells, platform, rules)?,
            solid: CellSet::of(cells),
            stays_level,
            level: cells.dims()[0] * cells.dims()[1],
            times: vec![f64::NAN; release.len()],
            due: vec![f64::INFINITY; release.len()],
            release,
            queue: BinaryHeap::new(),
            held: CellSet::none(cells),
        })
    }

    /// When the next cell is due.
    fn next_due(&mut self) -> Option<f64> {
        while let Some(&Reverse((Time(time), cell))) = self.queue.peek() {
            if self.is_due(time, cell) {
                return Some(time);
            }
            self.queue.pop();
        }
        None
    }

    /// Whether an entry of the queue still holds.
    fn is_due(&self, time: f64, cell: u32) -> bool {
        self.front.waiting.contains(cell) && !self.held.contains(cell) && time <= self.due[cell as usize]
    }

    fn set_due(&mut self, cell: u32, due: f64) {
        if due < self.due[cell as usize] {
            self.due[cell as usize] = due;
            self.queue.push(Reverse((Time(due), cell)));
        }
    }

    /// Forgets when the cell was due.
    fn unset_due(&mut self, cell: u32) {
        self.due[cell as usize] = f64::INFINITY;
    }

    /// When the front can get to the cell at the earliest.
    fn earliest(&self, cell: u32) -> f64 {
        waited(self.arrival(cell), self.release[cell as usize])
    }

    /// Neighbours of a cell that has got a time become due.
    fn advance_from(&mut self, cell: u32) {
        let around: Vec<u32> = self.front.waiting.around(cell, self.offsets).collect();
        for next in around {
            if self.times[next as usize].is_nan() && !self.held.contains(next) {
                self.set_due(next, self.earliest(next));
            }
        }
    }

    /// The cells are built at these times.
    fn build(&mut self, cells: &[(u32, f64)]) {
        for &(cell, time) in cells {
            self.times[cell as usize] = time;
        }
        // All times first: when a neighbour is due follows from all of its neighbours at once.
        for &(cell, _) in cells {
            self.advance_from(cell);
        }
    }

    /// Builds what is due in the layer, counted from 0, and shadows nothing.
    fn build_layer(&mut self, layer: f64) -> Result<(), GrowthError> {
        let chosen = self.choose(layer);
        let mut candidates: Vec<u32> = chosen.iter().map(|&(cell, _)| cell).collect();
        candidates.sort_unstable();
        prevention::incremental(&mut self.front, &candidates, self.offsets, Protected::Others)?;
        let end = layer + 1.0;
        let (held, built): (Vec<_>, Vec<_>) =
            chosen.into_iter().partition(|&(cell, _)| self.front.waiting.contains(cell));
        for (cell, _) in held {
            // The front went on as if it were built. What became due by that stays in the queue; `choose` looks at the arrival again.
            self.times[cell as usize] = f64::NAN;
            self.release[cell as usize] = self.release[cell as usize].max(end);
            self.held.insert(cell);
        }
        // What held these back is built or lost now, in this layer: they go on from the next one.
        for cell in std::mem::take(&mut self.front.freed) {
            self.held.remove(cell);
            self.release[cell as usize] = self.release[cell as usize].max(end);
            self.unset_due(cell);
            self.set_due(cell, self.earliest(cell));
        }
        self.build(&built);
        Ok(())
    }

    /// The candidates for a layer and their times. The front marches on through the layer as if all were built.
    fn choose(&mut self, layer: f64) -> Vec<(u32, f64)> {
        let mut chosen = Vec::new();
        while let Some(&Reverse((Time(time), cell))) = self.queue.peek().filter(|next| next.0.0.0 < layer + 1.0) {
            self.queue.pop();
            if !self.is_due(time, cell) || !self.times[cell as usize].is_nan() {
                continue;
            }
            self.unset_due(cell);
            if !self.is_supported(cell) {
                continue; // until a neighbour is built
            }
            // What it was due by may have been held back since.
            let (time, earliest) = (waited(time, layer), self.earliest(cell));
            if earliest > time {
                self.set_due(cell, earliest);
                continue;
            }
            self.times[cell as usize] = time;
            chosen.push((cell, time));
            // What waits for this one may be built in the same layer.
            self.front.free_behind(cell);
            for freed in std::mem::take(&mut self.front.freed) {
                self.held.remove(freed);
                self.unset_due(freed);
                self.release[freed as usize] = self.release[freed as usize].max(layer);
                self.set_due(freed, self.earliest(freed));
            }
            self.advance_from(cell);
        }
        chosen
    }

    /// Whether a neighbour is built already.
    fn is_supported(&self, cell: u32) -> bool {
        self.solid.around(cell, self.offsets).any(|other| !self.front.waiting.contains(other))
    }

    /// The neighbours at these offsets that have a time.
    fn known_around<'b>(&'b self, cell: u32, offsets: &'b [[i32; 3]]) -> impl Iterator<Item = (u32, f64)> + 'b {
        let around = self.solid.around(cell, offsets);
        around.map(|next| (next, self.times[next as usize])).filter(|(_, time)| !time.is_nan())
    }

    /// When the front gets to a cell from the neighbours that have a time.
    fn arrival(&self, cell: u32) -> f64 {
        let along =
            |axis: usize| self.known_around(cell, &ALONG[axis]).map(|(_, time)| time).fold(f64::INFINITY, f64::min);
        let all = Neighbours::FaceOrEdge.offsets();
        let is_level =
            |&(next, time): &(u32, f64)| self.stays_level && time <= f64::from(next / self.level) + 0.5 + ROUNDING;
        // What a level front carries comes a layer later, sooner than the slope alone would let it.
        let upwards = self.known_around(cell, &all[..BELOW]).filter(is_level).map(|(_, time)| time + 1.0);
        let time = upwards.fold(upwind([0, 1, 2].map(along)), f64::min);
        if time < f64::INFINITY {
            return time;
        }
        // Over an edge only.
        self.known_around(cell, all).map(|(_, time)| time + SQRT_2).fold(f64::INFINITY, f64::min)
    }
}

/// The time at which what came at `time` goes on if it has to wait until `release`, the beginning of a layer.
fn waited(time: f64, release: f64) -> f64 {
    if release - time > SHORT_WAIT { release + 0.5 } else { time.max(release) }
}

/// The time that gives a slope of 1 with the least times of the neighbours along each axis.
fn upwind(mut least: [f64; 3]) -> f64 {
    least.sort_by(f64::total_cmp);
    let [a, b, c] = least;
    // The front comes along an axis if the neighbours along the others are reached later than this; else they take part, and the time is
    // the larger root of `sum (time - least)^2 = 1`. The terms under the roots are below 0 by rounding only.
    let mut time = a + 1.0;
    if time > b {
        time = (a + b + (2.0 - (a - b).powi(2)).max(0.0).sqrt()) / 2.0;
        if time > c {
            let (sum, squares) = (a + b + c, a * a + b * b + c * c);
            time = (sum + (sum * sum - 3.0 * (squares - 1.0)).max(0.0).sqrt()) / 3.0;
        }
    }
    time
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_front_across_one_two_or_three_axes_moves_one_cell_a_layer() {
        let far = f64::INFINITY;
        assert!((upwind([far, 3.0, far]) - 4.0).abs() < 1e-12);
        assert!((upwind([3.0, 3.0, far]) - (3.0 + 0.5f64.sqrt())).abs() < 1e-12);
        assert!((upwind([3.0; 3]) - (3.0 + 1.0 / 3f64.sqrt())).abs() < 1e-12);
        assert!((upwind([3.0, 4.5, far]) - 4.0).abs() < 1e-12); // the second one comes later
        assert!(upwind([far; 3]).is_infinite());
    }
}
