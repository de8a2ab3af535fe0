//! The windows of each edge: side by side, each where its wave is the first to arrive.
//!
//! Mitchell, Mount, Papadimitriou, "The discrete geodesic problem", SIAM J. Comput. 16(4), 1987: windows of an edge are
//! trimmed against each other whichever side they come from, since a path that is beaten to a point of an edge leads
//! nowhere first. They are kept in the frame of the lower half-edge of the edge.
//!
//! Where a wave is split by a vertex with a full turn around it, its parts are one again behind it, and strips of
//! collinear edges are one from the start. Parts that touch and agree to rounding become one window; without that a
//! flat region would have a window for every edge of its boundary.

use super::wave::{Contest, Wave, contest};
use crate::mesh::NONE;

/// An interval of an edge that one wave crosses. There are millions of them: the wave is kept without its tag.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub span: [f64; 2],
    /// The figures of the wave, in their order.
    figures: [f64; 3],
    /// The half-edge whose triangle the wave enters; [`NONE`] at the boundary.
    pub enters: u32,
    /// Not yet propagated.
    pub waiting: bool,
    is_strip: bool,
}

impl Window {
    /// A window that waits.
    pub fn new(span: [f64; 2], wave: Wave, enters: u32) -> Self {
        let (figures, is_strip) = match wave {
            Wave::Point { x, depth, base } => ([x, depth, base], false),
            Wave::Strip { along, across, base } => ([along, across, base], true),
        };
        Window { span, figures, enters, waiting: true, is_strip }
    }

    pub fn wave(&self) -> Wave {
        match (self.is_strip, self.figures) {
            (false, [x, depth, base]) => Wave::Point { x, depth, base },
            (true, [along, across, base]) => Wave::Strip { along, across, base },
        }
    }

    /// As seen from the same edge run the other way.
    pub fn reversed(&self, length: f64) -> Window {
        let [from, to] = self.span;
        Window {
            waiting: self.waiting,
            ..Window::new([length - to, length - from], self.wave().reversed(length), self.enters)
        }
    }

    fn width(&self) -> f64 {
        self.span[1] - self.span[0]
    }
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
}

impl Envelope {
    pub fn new(half_edges: u32) -> Self {
        Envelope { edges: vec![Vec::new(); half_edges as usize] }
    }

    /// Windows of an edge, in its order.
    pub fn on(&self, edge: u32) -> &[Window] {
        &self.edges[edge as usize]
    }

    /// Takes the windows of an edge out, until [`Self::put_back`]: what propagates does not change them.
    pub fn take(&mut self, edge: u32) -> Vec<Window> {
        std::mem::take(&mut self.edges[edge as usize])
    }

    pub fn put_back(&mut self, edge: u32, windows: Vec<Window>) {
        self.edges[edge as usize] = windows;
    }

    pub fn len(&self) -> usize {
        self.edges.iter().map(Vec::len).sum()
    }

    /// Adds windows in order, which do not overlap, to an edge of the given length. Returns whether any was ahead
    /// anywhere.
    pub fn add(&mut self, edge: u32, length: f64, new: &[Window], trim: &mut Trim) -> bool {
        let windows = &mut self.edges[edge as usize];
        let (Some(first), Some(last)) = (windows.first(), windows.last()) else {
            windows.extend_from_slice(new);
            return !new.is_empty();
        };
        // What lies beyond the windows that are there needs no comparison, but the next ones, which may be parts of
        // the same wave.
        let (start, end) = (first.span[0], last.span[1]);
        let below = new.partition_point(|window| window.span[1] <= start).saturating_sub(1);
        let above = (new.partition_point(|window| window.span[0] < end) + 1).clamp(below, new.len());
        let mut gained = below > 0 || above < new.len();
        for window in &new[below..above] {
            gained |= trim.insert(windows, length, *window);
        }
        windows.extend_from_slice(&new[above..]);
        windows.splice(..0, new[..below].iter().copied());
        gained
    }
}

/// Trims windows against each other; where a challenger is not ahead by more than `slack`, the interval stays with the
/// one who had it.
pub(super) struct Trim {
    slack: f64,
    /// What takes the place of the windows that a new one meets.
    scratch: Vec<Window>,
}

impl Trim {
    pub fn new(slack: f64) -> Self {
        Trim { slack, scratch: Vec::new() }
    }

    /// As [`Self::insert`], for a window that starts near the end of those that are there and ends behind it.
    pub fn append(&mut self, windows: &mut Vec<Window>, length: f64, mut new: Window) {
        if let Some(last) = windows.last_mut().filter(|last| new.span[0] < last.span[1]) {
            let common = [new.span[0], last.span[1]];
            if common[1] - common[0] <= TOUCHING * length {
                // The common ray of two windows, computed twice: no need to ask who is ahead there.
                new.span[0] = last.span[1];
            } else if last.span[0] < common[0] && common[1] < new.span[1] {
                let Contest { challenger_first, cuts, count } = contest(&new.wave(), &last.wave(), common, self.slack);
                match (challenger_first, count) {
                    (false, 0) => new.span[0] = last.span[1],
                    (true, 0) => last.span[1] = new.span[0],
                    (false, 1) => (last.span[1], new.span[0]) = (cuts[0], cuts[0]),
                    _ => {
                        self.insert(windows, length, new);
                        return;
                    }
                }
            } else {
                self.insert(windows, length, new);
                return;
            }
        }
        Merged { windows, narrow: NARROW * length, same: self.same(length) }.push(new);
    }

    fn same(&self, length: f64) -> Same {
        Same { touching: TOUCHING * length, slack: self.slack }
    }

    /// Adds a window to those in order on an edge where it is ahead, and takes that interval from those who had it.
    /// Returns whether it was ahead anywhere.
    pub fn insert(&mut self, windows: &mut Vec<Window>, length: f64, new: Window) -> bool {
        let narrow = NARROW * length;
        let first = windows.partition_point(|old| old.span[1] <= new.span[0]);
        let met = windows[first..].iter().take_while(|old| old.span[0] < new.span[1]).count();
        let same = self.same(length);
        if met == 0 {
            // Nothing is in the way, as for most windows.
            if new.width() <= narrow {
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
            // Two waves are equally far at two places of an edge at most: so each of them may win the middle or the ends.
            let result = contest(&new.wave(), &old.wave(), common, self.slack);
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
        // The list is as it was, with waiting windows still waiting.
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
            && one.is_strip == next.is_strip
            && next.span[0] - one.span[1] <= self.touching
            && one.wave().agrees(&next.wave(), next.span[1], self.slack)
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
        if window.width() <= self.narrow {
            return false;
        }
        match self.windows.last_mut() {
            Some(last) if self.same.wave(last, &window) => last.span[1] = window.span[1],
            _ => self.windows.push(window),
        }
        true
    }
}
