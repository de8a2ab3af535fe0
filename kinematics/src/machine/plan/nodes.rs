//! Where the choice of branches looks: the ends of moves and what lies between them.
//!
//! Between two nodes outside of poles each branch goes on by less than a radian, so that it is clear which whole turn follows, and no reading
//! crosses an end of its range: there is a node at each crossing. The neighbourhood of a pole has nodes on its border, and one inside.

use super::pose::Pose;
use super::task::Task;
use crate::angle::nearest_image;
use crate::machine::inverse::Pairs;

/// A place along the moves of a bead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    pub pose: Pose,
    /// The move that ends here or goes on from here, and the share of it that is done.
    pub item: usize,
    pub share: f64,
    /// Within the neighbourhood of a pole.
    pub is_inside: bool,
}

/// Directions between two nodes differ by no more, radians: readings beyond a range between two nodes that are in it are within the tolerances
/// (a bulge of `ARC^2 / 8`).
const ARC: f64 = 0.1;

/// By how much a reading goes on at most between two nodes, radians: well below half a turn.
const TURN: f64 = 0.7;

/// Shares closer than this are one.
const SHARE: f64 = 1e-9;

/// Steps of bisections: the share is found to its last digit.
const STEPS: usize = 55;

/// Part of an interval that the golden section keeps.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// One move.
struct Way<'a> {
    task: &'a Task<'a>,
    from: Pose,
    to: Pose,
}

/// Appends the shares of a move at which nodes stand, in ascending order; the last one is 1.
pub(super) fn shares(task: &Task<'_>, from: &Pose, to: &Pose, found: &mut Vec<f64>) {
    let way = Way { task, from: *from, to: *to };
    let count = (from.turn(to) / ARC).ceil().max(1.0);
    let mut at = 0.0;
    for k in 1..=count as u32 {
        let end = if f64::from(k) < count { f64::from(k) / count } else { 1.0 };
        way.part(at, end, found);
        at = end;
    }
    // Both ends of a range of whole turns are crossed at one place.
    found.dedup_by(|next, last| *next - *last < 1e-12);
    if let Some(last) = found.last_mut() {
        *last = 1.0;
    }
}

/// Where `value` changes its sign between two shares.
fn crossing([mut a, mut b]: [f64; 2], value: impl Fn(f64) -> f64) -> f64 {
    let is_below = value(a) < 0.0;
    for _ in 0..STEPS {
        let middle = 0.5 * (a + b);
        if (value(middle) < 0.0) == is_below { a = middle } else { b = middle }
    }
    0.5 * (a + b)
}

/// The share at which `value`, which falls and then rises, is smallest.
fn smallest([mut a, mut b]: [f64; 2], value: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..STEPS {
        let (c, d) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
        if value(c) < value(d) { b = d } else { a = c }
    }
    0.5 * (a + b)
}

impl Way<'_> {
    fn pose(&self, share: f64) -> Pose {
        self.from.towards(&self.to, share)
    }

    fn pairs(&self, share: f64) -> Option<Pairs> {
        let pose = self.pose(share);
        self.task.machine.pairs(&pose.tip, &pose.direction, [0.0; 2]).ok()
    }

    /// Nodes of a part on which the distance from a pole falls, then rises.
    fn part(&self, from: f64, to: f64, found: &mut Vec<f64>) {
        let size = self.task.size;
        let beyond = |share: f64| self.task.distance(&self.pose(share)) - size;
        let (first, last) = (beyond(from), beyond(to));
        let step = self.task.step(&self.pose(from), &self.pose(to));
        let mut ends = [None; 3];
        if (first < 0.0) != (last < 0.0) {
            ends[0] = Some(crossing([from, to], beyond));
        } else if first >= 0.0 && first.min(last) < step {
            let nearest = smallest([from, to], beyond);
            if beyond(nearest) < -1e-3 * size {
                ends = [crossing([from, nearest], beyond), nearest, crossing([nearest, to], beyond)].map(Some);
            }
        }
        let mut at = from;
        for end in ends.into_iter().flatten().filter(|end| end - from > SHARE && to - end > SHARE).chain([to]) {
            let is_inside = self.task.is_inside(&self.pose(0.5 * (at + end)));
            if is_inside {
                found.push(end)
            } else {
                self.outside(at, end, found)
            }
            at = end;
        }
    }

    /// Nodes of a part outside of poles.
    fn outside(&self, from: f64, to: f64, found: &mut Vec<f64>) {
        let mut ends = vec![to];
        let mut at = from;
        while let Some(&end) = ends.last() {
            if end - at < SHARE || self.is_short(at, end) {
                self.limits(at, end, found);
                found.push(end);
                at = end;
                ends.pop();
            } else {
                ends.push(0.5 * (at + end));
            }
        }
    }

    /// Whether each branch goes on by little.
    fn is_short(&self, from: f64, to: f64) -> bool {
        let (task, a, b) = (self.task, self.pose(from), self.pose(to));
        let reach = task.singular(&a).min(task.singular(&b));
        if task.step(&a, &b) > (0.5 * reach).max(0.25 * task.size) {
            return false;
        }
        let (Some(first), Some(last)) = (self.pairs(from), self.pairs(to)) else { return true };
        let (Some(first), Some(last)) = (first[0], last[0]) else { return true };
        let is_free = first.is_free || last.is_free;
        is_free || (0..2).all(|k| (nearest_image(last.rotary[k], first.rotary[k]) - first.rotary[k]).abs() <= TURN)
    }

    /// Nodes where a reading of a branch is at an end of its range.
    fn limits(&self, from: f64, to: f64, found: &mut Vec<f64>) {
        let (Some(first), Some(last)) = (self.pairs(from), self.pairs(to)) else { return };
        let start = found.len();
        for branch in 0..2 {
            let (Some(a), Some(b)) = (first[branch], last[branch]) else { continue };
            for (k, axis) in self.task.machine.rotary.iter().enumerate().filter(|(_, axis)| !axis.is_endless()) {
                let (a, b) = (a.rotary[k], nearest_image(b.rotary[k], a.rotary[k]));
                for end in axis.range.map(|end| nearest_image(end, 0.5 * (a + b))) {
                    if (a < end) == (b < end) {
                        continue;
                    }
                    let beyond = |share: f64| {
                        let pair = self.pairs(share).and_then(|pairs| pairs[branch].or(pairs[0]));
                        pair.map_or(f64::NAN, |pair| nearest_image(pair.rotary[k], a) - end)
                    };
                    let share = crossing([from, to], beyond);
                    if share - from > SHARE && to - share > SHARE {
                        found.push(share);
                    }
                }
            }
        }
        found[start..].sort_by(f64::total_cmp);
    }
}
