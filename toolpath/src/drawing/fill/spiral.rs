//! Nested loops joined by bridges into closed curves, mostly one.
//!
//! Two loops side by side are cut open where they are near each other, over the width of a bead each, and joined by two bridges. These are
//! a bead apart and a bead long, so they fill what the cuts have opened. Bridges form a shortest spanning tree of the loops, and going
//! around that tree gives one closed curve: as the connected Fermat spirals of H. Zhao et al. (ACM TOG 35(4), 2016, section 4) it
//! fills a region of any shape without a stop; neighbouring loops are followed in opposite directions.

use crate::drawing::polygon::{Ring, Shape, ring_area};
use crate::union_find::{join, root};
use nalgebra::Point2;

/// Bridges are at most this many beads long. Loops of neighbouring levels are one bead apart, those of one level on both sides of
/// the middle up to two.
const LONGEST: f64 = 2.1;

/// Places along a loop where a bridge may begin, a bead.
const PLACES: f64 = 4.0;

/// A loop with the length from its begin to each of its points.
struct Loop {
    points: Vec<Point2<f64>>,
    lengths: Vec<f64>,
    level: usize,
    /// Where bridges begin: the middle of each cut, half its width, the loop there, and its cut.
    cuts: Vec<Cut>,
}

#[derive(Clone, Copy, Debug)]
struct Cut {
    middle: f64,
    half: f64,
    /// The loop on the other side, and the number of its cut.
    other: usize,
    other_cut: usize,
    /// Whether the other loop runs alongside in the same direction.
    along: bool,
}

impl Loop {
    fn new(ring: &Ring, level: usize) -> Self {
        let points: Vec<Point2<f64>> = ring.iter().map(|&at| Point2::from(at)).collect();
        let mut lengths = vec![0.0];
        for (a, b) in points.iter().zip(points.iter().cycle().skip(1)) {
            lengths.push(lengths[lengths.len() - 1] + (b - a).norm());
        }
        Loop { points, lengths, level, cuts: Vec::new() }
    }

    fn length(&self) -> f64 {
        self.lengths[self.points.len()]
    }

    /// The point at a length along the loop, and the segment it is on.
    fn at(&self, along: f64) -> (Point2<f64>, usize) {
        let along = along.rem_euclid(self.length());
        let segment = self.lengths.partition_point(|&s| s <= along).clamp(1, self.points.len()) - 1;
        let (a, b) = (self.points[segment], self.points[(segment + 1) % self.points.len()]);
        let step = self.lengths[segment + 1] - self.lengths[segment];
        let share = if step > 0.0 { (along - self.lengths[segment]) / step } else { 0.0 };
        (a + (b - a) * share, segment)
    }

    /// The length along the loop of its point nearest to `place`.
    fn nearest(&self, place: &Point2<f64>) -> f64 {
        let n = self.points.len();
        let mut best = (f64::INFINITY, 0.0);
        for k in 0..n {
            let (a, b) = (self.points[k], self.points[(k + 1) % n]);
            let (edge, to) = (b - a, place - a);
            let square = edge.norm_squared();
            let share = if square > 0.0 { (to.dot(&edge) / square).clamp(0.0, 1.0) } else { 0.0 };
            let distance = (to - edge * share).norm_squared();
            if distance < best.0 {
                best = (distance, self.lengths[k] + share * square.sqrt());
            }
        }
        best.1
    }

    /// Whether a cut there would meet no other.
    fn is_free(&self, middle: f64, half: f64) -> bool {
        let total = self.length();
        let apart = |a: f64, b: f64| {
            let d = (a - b).rem_euclid(total);
            d.min(total - d)
        };
        // A little apart, so that rounding does not put one within the other.
        self.cuts.iter().all(|cut| apart(cut.middle, middle) >= 1.01 * (cut.half + half))
    }

    /// How far it is from one length to another, forwards or back.
    fn way(&self, from: f64, to: f64, forward: bool) -> f64 {
        (if forward { to - from } else { from - to }).rem_euclid(self.length())
    }

    /// Appends the way from one length to another, forwards or back.
    fn walk(&self, from: f64, to: f64, forward: bool, out: &mut Vec<Point2<f64>>) {
        let n = self.points.len();
        let way = self.way(from, to, forward);
        let (begin, segment) = self.at(from);
        out.push(begin);
        let mut corner = if forward { (segment + 1) % n } else { segment };
        for _ in 0..n {
            if self.way(from, self.lengths[corner], forward) >= way {
                break;
            }
            out.push(self.points[corner]);
            corner = if forward { (corner + 1) % n } else { (corner + n - 1) % n };
        }
        out.push(self.at(to).0);
    }
}

/// Joins the loops of nested levels.
///
/// # Returns
/// Closed curves, one for each set of loops that bridges can connect.
pub(super) fn joined(levels: &[Vec<Shape>], bead: f64) -> Vec<Ring> {
    let mut loops: Vec<Loop> = Vec::new();
    for (level, shapes) in levels.iter().enumerate() {
        for ring in shapes.iter().flatten().filter(|ring| ring.len() > 2 && ring_area(ring) != 0.0) {
            loops.push(Loop::new(ring, level));
        }
    }
    // Shortest possible bridges first.
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for b in 0..loops.len() {
        for a in 0..b {
            if loops[b].level - loops[a].level <= 1 {
                let gap = least_gap(&loops[a], &loops[b], bead);
                if gap <= LONGEST * bead {
                    pairs.push((gap, a, b));
                }
            }
        }
    }
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let mut trees: Vec<u32> = (0..loops.len() as u32).collect();
    for (_, a, b) in pairs {
        let [one, other] = [a, b].map(|k| root(&mut trees, k as u32));
        if one != other && bridge(&mut loops, a, b, bead) {
            join(&mut trees, one, other);
        }
    }
    let roots = (0..loops.len()).filter(|&k| trees[k] as usize == k);
    roots
        .map(|first| {
            let mut out = Vec::new();
            around(&loops, first, None, true, &mut out);
            out.dedup();
            if out.first() == out.last() {
                out.pop();
            }
            out.iter().map(|p| [p.x, p.y]).collect()
        })
        .collect()
}

/// The least distance from a place on the shorter loop to the other one; infinite if their boxes are too far apart.
fn least_gap(a: &Loop, b: &Loop, bead: f64) -> f64 {
    let bounds =
        |of: &Loop| of.points.iter().fold((of.points[0], of.points[0]), |(low, high), p| (low.inf(p), high.sup(p)));
    let ((low_a, high_a), (low_b, high_b)) = (bounds(a), bounds(b));
    let apart = (low_a - high_b).sup(&(low_b - high_a)).max();
    if apart > LONGEST * bead {
        return f64::INFINITY;
    }
    let (short, long) = if a.length() < b.length() { (a, b) } else { (b, a) };
    places(short, bead).map(|at| (long.at(long.nearest(&at.1)).0 - at.1).norm()).fold(f64::INFINITY, f64::min)
}

/// Lengths along a loop where a bridge may begin, and the points there.
fn places(of: &Loop, bead: f64) -> impl Iterator<Item = (f64, Point2<f64>)> {
    let count = (of.length() * PLACES / bead).ceil().max(PLACES);
    let step = of.length() / count;
    (0..count as usize).map(move |k| k as f64 * step).map(|s| (s, of.at(s).0))
}

/// Joins two loops where their bridges are shortest; `false` if no place is free.
fn bridge(loops: &mut [Loop], a: usize, b: usize, bead: f64) -> bool {
    let (short, long) = if loops[a].length() < loops[b].length() { (a, b) } else { (b, a) };
    let (of, to) = (&loops[short], &loops[long]);
    let half = 0.5 * bead.min(of.length() / 3.0).min(to.length() / 3.0);
    let mut best: Option<(f64, f64, f64, bool)> = None;
    for (s, at) in places(of, bead) {
        let t = to.nearest(&at);
        if (to.at(t).0 - at).norm() > LONGEST * bead || !of.is_free(s, half) || !to.is_free(t, half) {
            continue;
        }
        let [s1, s2, t1, t2] = [of.at(s - half).0, of.at(s + half).0, to.at(t - half).0, to.at(t + half).0];
        let (straight, crossed) = ((s1 - t1).norm().max((s2 - t2).norm()), (s1 - t2).norm().max((s2 - t1).norm()));
        let (cost, along) = if straight <= crossed { (straight, true) } else { (crossed, false) };
        if best.is_none_or(|best| cost < best.0) {
            best = Some((cost, s, t, along));
        }
    }
    let Some((_, s, t, along)) = best else { return false };
    let (cut_short, cut_long) = (loops[short].cuts.len(), loops[long].cuts.len());
    loops[short].cuts.push(Cut { middle: s, half, other: long, other_cut: cut_long, along });
    loops[long].cuts.push(Cut { middle: t, half, other: short, other_cut: cut_short, along });
    true
}

/// Appends the way around a loop and all that hangs on it: from one side of the cut `entry` to the other, or, without one, once
/// around.
fn around(loops: &[Loop], k: usize, entry: Option<usize>, forward: bool, out: &mut Vec<Point2<f64>>) {
    let own = &loops[k];
    let side = |cut: &Cut, ahead: bool| if ahead { cut.middle + cut.half } else { cut.middle - cut.half };
    let Some(begin) = entry.or(if own.cuts.is_empty() { None } else { Some(0) }) else {
        out.extend(&own.points);
        return;
    };
    let from = side(&own.cuts[begin], forward);
    let mut cuts: Vec<usize> = (0..own.cuts.len()).filter(|&cut| Some(cut) != entry).collect();
    let passed = |cut: usize| own.way(from, own.cuts[cut].middle, forward);
    cuts.sort_by(|&i, &j| passed(i).total_cmp(&passed(j)));
    let mut at = from;
    for cut in cuts.into_iter().map(|cut| own.cuts[cut]) {
        let (near, far) = (side(&cut, !forward), side(&cut, forward));
        own.walk(at, near, forward, out);
        // The other loop is entered beside the near side of the cut and left beside the far one, so it is followed away from there.
        let ahead = forward == cut.along;
        around(loops, cut.other, Some(cut.other_cut), !ahead, out);
        at = far;
    }
    // Without an entry the last cut was the one where the way began.
    if entry.is_some() {
        own.walk(at, side(&own.cuts[begin], !forward), forward, out);
    }
}
