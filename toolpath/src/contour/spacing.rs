//! Where beads lie between the boundary and the ridge: evenly, or so that they fit.
//!
//! Even beads leave a gap or lie twice where opposite sides meet, since the way across is no whole number of beads. So
//! widths follow the way across, as in Kuipers et al., "A framework for adaptive width control of dense contour-parallel
//! toolpaths in fused deposition modeling", Computer-Aided Design 128, 2020, do on planes. With the ridge at `R` from the boundary `m =
//! round(R / bead)` rings fit; the outer ones are as wide as asked for, the inner `INNER` share what is left.
//!
//! Departures: rings are closed, so each passes the way across twice and their number there is even. An odd number would
//! end the curve in each tail, and one curve could not fill a region. With widths between 0.75 and 1.25 beads an even number
//! fits wherever the way across is at least 1.5 beads, but for 2.5 to 3.
//!
//! The ridge of a place is found by going uphill: over the surface to the medial axis, and on along it while it
//! rises steeply. There rings turn around a corner; where it is level they lie side by side.

use crate::level_set::{Around, LevelField, Levels};
use crate::mesh::{SurfacePoint, next, previous};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// The least and the largest width of a bead, as shares of what was asked for.
pub const BEAD_WIDTHS: [f64; 2] = [0.75, 1.25];
/// Rings that share what is left. Two would do for the widths above; the more, the more rings move where their number
/// changes, and the closer widths stay to what was asked for.
const INNER: usize = 3;
/// Even levels lie this much higher, as a share of a bead. Ways across are often a round number of beads: a level just at
/// the ridge would run to and fro along it by rounding.
const LIFT: f64 = 1e-4;
/// One ring fits up to a ridge 1.25 beads away, two fit from 1.5 on: the number changes half way.
const SECOND: f64 = 1.375;
/// Where the number of rings changes, levels go from one to the other over this many beads. The less, the sharper beads
/// turn; the more, the larger the part where neither number fits.
const BLEND: f64 = 0.5;
/// The ridge of neighbouring places differs by no more than this slope; else rings would come together where a region
/// branches. At least one, or it would fall below the distance; low, single low places draw all around down.
const STEEPEST: f64 = 4.0;
/// Above this slope a way uphill is no ridge at all: the distance itself rises with slope one.
const SLOPE: f64 = 0.75;
/// Above this slope the medial axis is that of a corner: the way across grows faster than rings could follow.
const CORNER: f64 = 0.35;
/// The slope of the medial axis is its rise over this many beads: far, so that bumps do not count, or near, so that its
/// end is found.
const AHEAD: [f64; 2] = [0.15, 1.0];

/// A point this near to a level, as a share of the way to the next, is on it.
const BETWEEN: f64 = 0.05;

/// Beads at a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct BeadsAt {
    /// Length of beads by area, in millimetres by square millimetre; 0 where no bead fits.
    pub per_mm: f64,
    /// Their width, in millimetres.
    pub width: f64,
}

/// Where the levels of rings are, and how wide beads are.
pub(super) struct Spacing<'f, 'd> {
    field: &'f LevelField<'d>,
    bead: f64,
    count: usize,
    /// The distance of the ridge for each vertex, where beads fit; none where they are even.
    ridge: Vec<f64>,
    /// The number of rings for each vertex, a fraction where it changes.
    rings: Vec<f64>,
    /// Vertices beside necks too narrow for two beads.
    neck: Vec<bool>,
    /// Refined triangles of each triangle of the mesh, and where each list begins.
    parts: Vec<u32>,
    starts: Vec<u32>,
}

impl Levels for Spacing<'_, '_> {
    fn count(&self) -> usize {
        self.count
    }

    fn at(&self, level: usize, vertex: u32) -> f64 {
        if self.ridge.is_empty() {
            return (level as f64 + 0.5 + LIFT) * self.bead;
        }
        if level == 0 && self.neck[vertex as usize] {
            return BEAD_WIDTHS[0] * self.bead;
        }
        self.place(level, self.rings[vertex as usize], self.ridge[vertex as usize])[0]
    }
}

impl<'f, 'd> Spacing<'f, 'd> {
    /// Beads that fit, or even ones; at most so many.
    pub fn new(field: &'f LevelField<'d>, bead: f64, reach: f64, fit: bool, most: Option<usize>) -> Self {
        let mesh = field.distance().mesh();
        let mut starts = vec![0; mesh.triangles().len() + 1];
        field.parents().iter().for_each(|&parent| starts[parent as usize + 1] += 1);
        (1..starts.len()).for_each(|t| starts[t] += starts[t - 1]);
        let (mut filled, mut parts) = (starts.clone(), vec![0; field.triangles.len()]);
        for (part, &parent) in (0..).zip(field.parents()) {
            parts[filled[parent as usize] as usize] = part;
            filled[parent as usize] += 1;
        }
        let least = if fit { BEAD_WIDTHS[0] } else { 1.0 };
        let count = ((reach / bead / least).floor() as usize + 1).min(most.unwrap_or(usize::MAX));
        let mut spacing =
            Spacing { field, bead, count, ridge: Vec::new(), rings: Vec::new(), neck: Vec::new(), parts, starts };
        if fit {
            spacing.ridge = ridge(field, bead);
            let around = Around::new(field);
            // The ridge before the numbers, which follow from it; each is lowered where it would change too fast for rings to follow.
            limit(field, &around, &mut spacing.ridge, STEEPEST);
            spacing.rings = numbers(field, &around, &spacing.ridge, bead);
            limit(field, &around, &mut spacing.rings, 1.0 / (BLEND * bead));
            spacing.neck = necks(field, bead);
        }
        spacing
    }

    /// For each vertex how far it is inward of the inner edge of the innermost of some contours; below 0 where fewer fit.
    pub fn inside(&self, contours: usize) -> Vec<f64> {
        let edge = |v: u32| match contours.checked_sub(1) {
            // Nothing is held back, and the boundary itself is inside.
            None => -self.bead,
            // Even beads and fitted ones have their middles on levels; half a bead farther in is the inner edge.
            Some(last) if self.ridge.is_empty() => self.at(last, v) + 0.5 * self.bead,
            Some(last) => {
                let [middle, width] = self.place(last, self.rings[v as usize], self.ridge[v as usize]);
                middle + 0.5 * width
            }
        };
        (0..).zip(&self.field.values).map(|(v, value)| value - edge(v)).collect()
    }

    pub fn fits(&self) -> bool {
        !self.ridge.is_empty()
    }

    /// The distance of a ring's level for a number of rings and a ridge, and the width of its bead.
    fn place(&self, level: usize, rings: f64, ridge: f64) -> [f64; 2] {
        let (fewer, ridge) = (rings.floor(), ridge / self.bead);
        let (share, one) = (rings - fewer, place(level, fewer, ridge));
        // Mostly a whole number of rings fits.
        if share <= 0.0 {
            return one.map(|value| self.bead * value);
        }
        let other = place(level, fewer + 1.0, ridge);
        [0, 1].map(|k| self.bead * (one[k] + (other[k] - one[k]) * share))
    }

    /// The refined triangle that has a point, and weights of its corners.
    fn part(&self, at: &SurfacePoint) -> (u32, [f64; 3]) {
        let [from, to] = [0, 1].map(|k| self.starts[at.triangle as usize + k] as usize);
        let mut best = (self.parts[from], [1.0 / 3.0; 3], f64::NEG_INFINITY);
        for &part in &self.parts[from..to] {
            let [a, b, c] = self.field.triangles[part as usize].map(|v| self.field.points[v as usize]);
            let normal = (b - a).cross(&(c - a));
            let whole = normal.norm_squared();
            if whole <= 0.0 {
                continue;
            }
            let one = (b - a).cross(&(at.position - a)).dot(&normal) / whole;
            let other = (at.position - a).cross(&(c - a)).dot(&normal) / whole;
            let weights = [1.0 - one - other, other, one];
            let least = weights[0].min(weights[1]).min(weights[2]);
            if least > best.2 {
                best = (part, weights, least);
            }
            if least >= 0.0 {
                break;
            }
        }
        let weights = best.1.map(|w| w.max(0.0));
        (best.0, weights.map(|w| w / weights.iter().sum::<f64>()))
    }

    /// How far a point lies above levels, in millimetres: the difference between the distance and each level.
    pub fn above<const N: usize>(&self, at: &SurfacePoint, levels: [usize; N]) -> [f64; N] {
        let (part, weights) = self.part(at);
        let corners = self.field.triangles[part as usize];
        levels.map(|level| {
            let over = corners.map(|v| self.field.values[v as usize] - self.at(level, v));
            over[0] * weights[0] + over[1] * weights[1] + over[2] * weights[2]
        })
    }

    /// The width of a bead at a point, and whether the point lies between two levels. Between them it goes evenly from one to
    /// the other.
    pub fn width(&self, at: &SurfacePoint) -> (f64, bool) {
        if !self.fits() {
            return (self.bead, false);
        }
        let (part, weights) = self.part(at);
        let corners = self.field.triangles[part as usize];
        let mean = |of: &[f64]| (0..3).map(|k| of[corners[k] as usize] * weights[k]).sum::<f64>();
        let (value, rings, ridge) = (mean(&self.field.values), mean(&self.rings), mean(&self.ridge));
        let above = (0..self.count).find(|&level| self.place(level, rings, ridge)[0] >= value).unwrap_or(self.count);
        let [high, low] = [above, above.saturating_sub(1)].map(|level| self.place(level, rings, ridge));
        let share = if high[0] > low[0] { ((value - low[0]) / (high[0] - low[0])).clamp(0.0, 1.0) } else { 0.0 };
        let width = low[1] + (high[1] - low[1]) * share;
        let between = share.min(1.0 - share) > BETWEEN;
        (width.clamp(BEAD_WIDTHS[0] * self.bead, BEAD_WIDTHS[1] * self.bead), between)
    }

    /// Length of beads by area, and their width, at a distance from the boundary within a triangle of the field.
    pub fn beads_at(&self, value: f64, corners: [u32; 3], min_width: f64) -> BeadsAt {
        let bead = self.bead;
        if !self.fits() {
            return BeadsAt { per_mm: 1.0 / bead, width: bead };
        }
        let mean = |of: &[f64]| corners.iter().map(|&v| of[v as usize]).sum::<f64>() / 3.0;
        let (rings, ridge) = (mean(&self.rings), mean(&self.ridge) / bead);
        let fewer = rings.floor();
        let [one, other] = [fewer, fewer + 1.0].map(|rings| share(value / bead, rings, ridge, min_width));
        // Shares of the area add up, widths do not.
        let [per, covered] = [0, 1].map(|k| one[k] + (other[k] - one[k]) * (rings - fewer));
        BeadsAt { per_mm: per / bead, width: if per > 0.0 { covered / per * bead } else { 0.0 } }
    }

    /// The width of a single bead along the medial axis; none where it is too narrow for one.
    pub fn single(&self, value: f64) -> f64 {
        if self.fits() {
            (2.0 * value).clamp(BEAD_WIDTHS[0] * self.bead, BEAD_WIDTHS[1] * self.bead)
        } else {
            self.bead
        }
    }

    /// The least distance from the boundary at which there may be a single bead.
    pub fn least_single(&self) -> f64 {
        // Even beads may lie half outside; those that fit do not.
        if self.fits() { 0.5 * BEAD_WIDTHS[0] * self.bead } else { 0.25 * self.bead }
    }
}

/// How many rings fit below a ridge, given in beads: the number, and whether one more would fit too.
fn rings(ridge: f64) -> (f64, bool) {
    if ridge < BEAD_WIDTHS[0] {
        return (0.0, false);
    }
    if ridge < SECOND {
        return (1.0, false);
    }
    let inner = |rings: f64| rings.min(INNER as f64);
    // From here on one more ring fits, and up to there as many as there are.
    let fewer = ridge.floor().max(2.0);
    let more_from = fewer + 1.0 - inner(fewer + 1.0) * (1.0 - BEAD_WIDTHS[0]);
    let up_to = fewer + inner(fewer) * (BEAD_WIDTHS[1] - 1.0);
    match ridge {
        _ if ridge < more_from => (fewer, false),
        _ if ridge > up_to => (fewer + 1.0, false),
        _ => (fewer, true),
    }
}

/// The number of rings for each vertex. Where two numbers fit, that of the nearest place where one only does: so along a wall
/// that is just between two numbers rings go on.
fn numbers(field: &LevelField, around: &Around, ridge: &[f64], bead: f64) -> Vec<f64> {
    let fits: Vec<(f64, bool)> = ridge.iter().map(|&ridge| rings(ridge / bead)).collect();
    let mut number = vec![f64::NAN; ridge.len()];
    let mut queue = VecDeque::new();
    for (v, &(rings, open)) in (0_u32..).zip(&fits) {
        if !open {
            number[v as usize] = rings;
            queue.push_back(v);
        }
    }
    let spread = |number: &mut [f64], queue: &mut VecDeque<u32>| {
        while let Some(v) = queue.pop_front() {
            for other in around.neighbours(field, v) {
                if number[other as usize].is_nan() {
                    let fewer = fits[other as usize].0;
                    number[other as usize] = number[v as usize].clamp(fewer, fewer + 1.0);
                    queue.push_back(other);
                }
            }
        }
    };
    spread(&mut number, &mut queue);
    for v in 0..ridge.len() as u32 {
        if number[v as usize].is_nan() {
            number[v as usize] = (ridge[v as usize] / bead).round();
            queue.push_back(v);
            spread(&mut number, &mut queue);
        }
    }
    number
}

/// Lowers values until they differ by no more than a slope along each edge.
fn limit(field: &LevelField, around: &Around, values: &mut [f64], slope: f64) {
    let room = |from: u32, to: u32| slope * (field.points[to as usize] - field.points[from as usize]).norm();
    let mut queue = BinaryHeap::new();
    let lower = |values: &mut [f64], queue: &mut BinaryHeap<(Reverse<u64>, u32)>, from: u32, to: u32| {
        let most = values[from as usize] + room(from, to);
        if most < values[to as usize] {
            values[to as usize] = most;
            queue.push((Reverse(most.to_bits()), to)); // bits of positive numbers are in the order of the numbers
        }
    };
    for h in 0..field.half_edges() {
        let [one, other] = [field.tail(h), field.head(h)];
        lower(values, &mut queue, one, other);
        lower(values, &mut queue, other, one);
    }
    // By rising value, as Dijkstra's algorithm: what comes out is never lowered again, and entries that were lowered since are stale.
    while let Some((Reverse(bits), v)) = queue.pop() {
        if values[v as usize].to_bits() != bits {
            continue;
        }
        around.neighbours(field, v).for_each(|other| lower(values, &mut queue, v, other));
    }
}

/// Where a ring lies if there are `m`, with the ridge at a distance, and its width; all in beads. Above the last ring
/// levels go on beyond the ridge.
fn place(level: usize, m: f64, ridge: f64) -> [f64; 2] {
    if m < 1.0 {
        return [BEAD_WIDTHS[0] + level as f64, BEAD_WIDTHS[0]];
    }
    let inner = m.min(INNER as f64);
    let outer = m - inner;
    let width = ((ridge - outer) / inner).clamp(BEAD_WIDTHS[0], BEAD_WIDTHS[1]);
    let level = level as f64;
    if level < outer { [level + 0.5, 1.0] } else { [outer + (level - outer + 0.5) * width, width] }
}

/// A single bead in a strip of this width, in beads: length by area, and the share of the area that it covers. None where the strip is narrower
/// than `min_width`.
fn single_in(strip: f64, min_width: f64) -> [f64; 2] {
    if strip < min_width {
        return [0.0; 2];
    }
    [1.0 / strip, strip.clamp(min_width, BEAD_WIDTHS[1]) / strip]
}

/// Beads at a distance from the boundary, if there are `m` rings below a ridge, all in beads: length by area, and the share of the area that
/// they cover.
fn share(at: f64, m: f64, ridge: f64, min_width: f64) -> [f64; 2] {
    if m < 1.0 {
        return single_in(2.0 * ridge, min_width);
    }
    let inner = m.min(INNER as f64);
    let outer = m - inner;
    if at < outer {
        return [1.0; 2];
    }
    let per = inner / (ridge - outer).max(inner * BEAD_WIDTHS[0]);
    [per, per * place(outer as usize, m, ridge)[1]]
}

/// The distance of the ridge above each vertex.
fn ridge(field: &LevelField, bead: f64) -> Vec<f64> {
    let values = &field.values;
    let vertices = values.len();
    // The steepest way up from each vertex: its slope, and the vertices at the ends of the edge that it reaches.
    let mut steepest = vec![(0.0_f64, [0_u32; 2]); vertices];
    let mut offer = |v: u32, slope: f64, to: [u32; 2]| {
        if slope > steepest[v as usize].0 {
            steepest[v as usize] = (slope, to);
        }
    };
    for h in 0..field.half_edges() {
        let corners @ [v, a, b] = [h, next(h), previous(h)].map(|h| field.tail(h));
        let [p, q, r] = corners.map(|v| field.points[v as usize]);
        let [low, one, other] = corners.map(|v| values[v as usize]);
        if !low.is_finite() {
            continue;
        }
        let (to_a, to_b) = (q - p, r - p);
        offer(v, (one - low) / to_a.norm(), [a, a]);
        offer(v, (other - low) / to_b.norm(), [b, b]);
        // The gradient, as weights of both edges; inside of the triangle if both are positive.
        let [aa, ab, bb] = [to_a.dot(&to_a), to_a.dot(&to_b), to_b.dot(&to_b)];
        let whole = aa * bb - ab * ab;
        let weights = [bb * (one - low) - ab * (other - low), aa * (other - low) - ab * (one - low)];
        if whole > 0.0 && weights.iter().all(|&w| w > 0.0) {
            let gradient = (to_a * weights[0] + to_b * weights[1]) / whole;
            offer(v, gradient.norm(), [a, b]);
        }
    }
    let higher = |[a, b]: [u32; 2]| if values[a as usize] >= values[b as usize] { a } else { b };
    let mut order: Vec<u32> = (0..vertices as u32).filter(|&v| values[v as usize].is_finite()).collect();
    order.sort_by(|&a, &b| values[b as usize].total_cmp(&values[a as usize]).then(a.cmp(&b)));
    let mut ridge = vec![0.0; vertices];
    // By falling distance: what lies uphill has its ridge already.
    for &v in &order {
        let (slope, to) = steepest[v as usize];
        let here = values[v as usize];
        let mut rises = slope > SLOPE;
        let (mut at, mut gone) = (v, 0.0);
        // Up along the medial axis.
        for ahead in AHEAD {
            while gone < ahead * bead && !rises {
                let (slope, to) = steepest[at as usize];
                let up = higher(to);
                if slope <= 0.0 || values[up as usize] <= values[at as usize] {
                    break;
                }
                gone += (field.points[up as usize] - field.points[at as usize]).norm();
                at = up;
            }
            rises |= values[at as usize] - here > CORNER * gone.max(ahead * bead);
        }
        let up = higher(to);
        ridge[v as usize] = if rises && slope > 0.0 && values[up as usize] > here { ridge[up as usize] } else { here };
    }
    ridge
}

/// Vertices beside necks that are too narrow for two beads: there rings turn round.
fn necks(field: &LevelField, bead: f64) -> Vec<bool> {
    let least = BEAD_WIDTHS[0] * bead;
    let mut beside = vec![false; field.values.len()];
    let saddles = field.pockets(0.0);
    let narrow = saddles.iter().filter(|pocket| pocket.height > least);
    let places: Vec<_> =
        narrow.filter_map(|p| p.joins).filter(|(_, value, _)| *value < least).map(|(p, ..)| p).collect();
    if places.is_empty() {
        return beside;
    }
    for (v, point) in field.points.iter().enumerate() {
        let near = |p: &SurfacePoint| (p.position - point).norm() < least;
        beside[v] = field.values[v] < least && places.iter().any(near);
    }
    beside
}
