//! The windows of each edge: side by side, each where its wave is the first to arrive.
//!
//! Mitchell, Mount, Papadimitriou, "The discrete geodesic problem", SIAM J. Comput. 16(4), 1987: windows of an edge are
//! trimmed against each other whichever side they come from, since a path that is beaten to a point of an edge leads
//! nowhere first. They are kept in the frame of the lower half-edge of the edge.
//!
//! Where a wave is split by a vertex with a full turn around it, its parts are one again behind it, and strips of
//! collinear edges are one from the start. Parts that touch and agree to rounding become one window; without that a
//! flat region would have a window for every edge of its boundary.

use super::wave::{Wave, contest};
use crate::surface::mesh::NONE;

/// A stretch of an edge that one wave crosses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub span: [f64; 2],
    pub wave: Wave,
    /// The half-edge whose triangle the wave enters; [`NONE`] at the boundary.
    pub enters: u32,
    /// Not yet propagated.
    pub waiting: bool,
}

/// A window narrower than this share of its edge is rounding noise: its ends are the same up to a few units in the last
/// place. Dropping it opens a gap as narrow, over which distances are bridged from its ends.
const NARROW: f64 = 1e-15;
/// Parts of one wave touch if they are as near as this share of the edge. Their common end was computed twice, over
/// different triangles.
const TOUCHING: f64 = 1e-12;

/// All windows.
#[derive(Clone, Debug)]
pub(super) struct Envelope {
    /// The windows of each edge in order, at its lower half-edge.
    edges: Vec<Vec<Window>>,
    slack: f64,
    /// What takes the place of the windows that a new one meets.
    scratch: Vec<Window>,
}

impl Envelope {
    /// A challenger must be ahead by more than `slack`.
    pub fn new(half_edges: u32, slack: f64) -> Self {
        Envelope { edges: vec![Vec::new(); half_edges as usize], slack, scratch: Vec::new() }
    }

    /// Windows of an edge, in its order.
    pub fn on(&self, edge: u32) -> &[Window] {
        &self.edges[edge as usize]
    }

    /// Moves the windows that wait to enter a half-edge to the end of a list, and marks them as done.
    pub fn take_waiting(&mut self, edge: u32, enters: u32, list: &mut Vec<Window>) {
        for window in self.edges[edge as usize].iter_mut().filter(|w| w.waiting && w.enters == enters) {
            window.waiting = false;
            list.push(*window);
        }
    }

    pub fn len(&self) -> usize {
        self.edges.iter().map(Vec::len).sum()
    }

    /// Adds a window to an edge of the given length where it is ahead, and takes that stretch from those who had it.
    /// Returns whether it was ahead anywhere.
    pub fn insert(&mut self, edge: u32, length: f64, new: Window) -> bool {
        let narrow = NARROW * length;
        let windows = &mut self.edges[edge as usize];
        let first = windows.partition_point(|old| old.span[1] <= new.span[0]);
        let met = windows[first..].iter().take_while(|old| old.span[0] < new.span[1]).count();
        let same = Same { touching: TOUCHING * length, slack: self.slack };
        if met == 0 {
            // Nothing is in the way, as for most windows.
            if new.span[1] - new.span[0] <= narrow {
                return false;
            }
            if first > 0 && same.wave(&windows[first - 1], &new) {
                windows[first - 1].span[1] = new.span[1];
            } else if first < windows.len() && same.wave(&new, &windows[first]) {
                windows[first].span[0] = new.span[0];
            } else {
                windows.insert(first, new);
            }
            return true;
        }
        self.scratch.clear();
        let mut merged = Merged { windows: &mut self.scratch, narrow, same };
        let around = [first.checked_sub(1), Some(first + met).filter(|&after| after < windows.len())];
        if let Some(before) = around[0] {
            merged.push(windows[before]);
        }
        let mut gained = false;
        let mut at = new.span[0];
        for old in &windows[first..first + met] {
            let common = [old.span[0].max(new.span[0]), old.span[1].min(new.span[1])];
            gained |= merged.push(Window { span: [at, common[0]], ..new });
            let result = contest(&new.wave, &old.wave, common, self.slack);
            let mut start = common[0];
            let mut challenger = result.challenger_first;
            let mut kept = old.span[0];
            for &cut in result.cuts[..result.count].iter().chain(&common[1..]) {
                if challenger {
                    merged.push(Window { span: [kept, start], ..*old });
                    gained |= merged.push(Window { span: [start, cut], ..new });
                    kept = cut;
                }
                challenger = !challenger;
                start = cut;
            }
            merged.push(Window { span: [kept, old.span[1]], ..*old });
            at = common[1];
        }
        gained |= merged.push(Window { span: [at, new.span[1]], ..new });
        if !gained {
            return false;
        }
        if let Some(after) = around[1] {
            merged.push(windows[after]);
        }
        let replaced = around[0].unwrap_or(first)..around[1].map_or(first + met, |after| after + 1);
        windows.splice(replaced, self.scratch.drain(..));
        true
    }
}

/// Whether windows that follow each other are parts of one.
struct Same {
    touching: f64,
    slack: f64,
}

impl Same {
    fn wave(&self, one: &Window, next: &Window) -> bool {
        one.waiting
            && next.waiting
            && one.enters == next.enters
            && next.enters != NONE
            && next.span[0] - one.span[1] <= self.touching
            && one.wave.agrees(&next.wave, next.span[1], self.slack)
    }
}

/// Windows in order, those that are one put together.
struct Merged<'a> {
    windows: &'a mut Vec<Window>,
    narrow: f64,
    same: Same,
}

impl Merged<'_> {
    /// Returns whether the window was wide enough to count.
    fn push(&mut self, window: Window) -> bool {
        if window.span[1] - window.span[0] <= self.narrow {
            return false;
        }
        match self.windows.last_mut() {
            Some(last) if self.same.wave(last, &window) => last.span[1] = window.span[1],
            _ => self.windows.push(window),
        }
        true
    }
}
