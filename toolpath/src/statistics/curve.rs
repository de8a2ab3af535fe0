//! What is measured of each curve by itself: its pieces on the surface, its length and its turns.

use super::error::StatisticsError;
use super::figures::{BeadCurve, CurveStatistics, StatisticsOptions};
use super::sheet::Sheet;
use super::trace::{Hop, Spot, Tracer, flat_point};
use nalgebra::{Vector2, Vector3};
use std::collections::VecDeque;
use std::f64::consts::PI;

/// Points nearer than this share of the width to the one before are left out: their direction would be rounding.
const SAME_POINT: f64 = 1e-6;

/// A turn is what the direction changes over this share of the width.
const TURN_WINDOW: f64 = 0.25;

/// Widths that differ by less than this share of them are the same: their difference would be rounding.
const EVEN: f64 = 1e-12;

/// Slack of turns, in radians: a turn of just the limit must not count by rounding.
const TURN_SLACK: f64 = 1e-9;

/// A straight piece of bead in one triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub curve: u32,
    pub triangle: u32,
    pub weights: [[i64; 3]; 2],
    /// Ends in the frame of the triangle.
    pub ends: [Vector2<f64>; 2],
    /// Half the width at the ends.
    pub radii: [f64; 2],
    /// Arc length in widths at the ends.
    pub along: [f64; 2],
}

/// The outside of a turn, or the cap of an end: the bead sweeps around a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fan {
    pub triangle: u32,
    pub centre: Vector2<f64>,
    /// Direction of the first ray.
    pub first: Vector2<f64>,
    /// Angle from the first ray to the last, counterclockwise.
    pub sweep: f64,
    /// At turns the bead covers as much twice on the inside: the same angle is taken off there.
    pub is_turn: bool,
    pub radius: f64,
}

/// A curve laid on the surface.
#[derive(Debug, Default)]
pub(super) struct DepositedCurve {
    pub pieces: Vec<Piece>,
    pub fans: Vec<Fan>,
    pub closed: bool,
    /// The whole length in widths.
    pub widths: f64,
    /// Area of the bead, and what of it has a width in the range asked for, lies off the surface.
    pub bead: f64,
    pub in_range: f64,
    pub off_area: f64,
    pub statistics: CurveStatistics,
}

/// Points of a curve and half the width at each, without repetitions.
fn distinct(curve: &BeadCurve) -> Vec<(Vector3<f64>, f64)> {
    let mut kept: Vec<(Vector3<f64>, f64)> = Vec::new();
    let last = curve.points.len() - 1;
    for (k, (p, width)) in curve.points.iter().zip(curve.widths).enumerate() {
        let is_near = |q: &(Vector3<f64>, f64)| (p.coords - q.0).norm() <= SAME_POINT * width;
        if kept.last().is_some_and(is_near) {
            if k < last || kept.len() == 1 {
                continue;
            }
            kept.pop(); // the last point stays
        }
        kept.push((p.coords, width / 2.0));
    }
    kept
}

/// Lays a curve with at least one point on the surface.
pub(super) fn lay(
    tracer: &Tracer,
    number: u32,
    curve: &BeadCurve,
    options: &StatisticsOptions,
) -> Result<DepositedCurve, StatisticsError> {
    let sheet = tracer.sheet;
    let points = distinct(curve);
    let located = |(p, radius): (Vector3<f64>, f64), before: Option<(Spot, u32)>| {
        tracer.locate(p, radius, before).ok_or_else(|| {
            let point = curve.points.iter().position(|q| q.coords == p).unwrap_or(0);
            StatisticsError::OffSurface { curve: number as usize, point, reach: radius }
        })
    };
    let mut spots = vec![located(points[0], None)?];
    let ends = [points[0].0, points[points.len() - 1].0];
    let closed = points.len() > 2 && curve.points.first() == curve.points.last();
    let mut laid = DepositedCurve { closed, ..DepositedCurve::default() };
    laid.statistics.closed = closed;
    laid.statistics.entry_exit_mm = (ends[1] - ends[0]).norm();
    if points.len() == 1 {
        laid.dot(sheet, number, spots[0], points[0].1);
        return Ok(laid);
    }
    // The directions of each chord where it begins and ends, each in the frame of its triangle.
    let mut chords: Vec<[(u32, Vector2<f64>); 2]> = Vec::with_capacity(points.len());
    for k in 1..points.len() {
        let (from, to) = (points[k - 1], points[k]);
        let came = chords.last().map_or(u32::MAX, |chord| chord[1].0);
        spots.push(located(to, Some((spots[k - 1], came)))?);
        let hops = tracer.chord([spots[k - 1], spots[k]], [from.0, to.0], from.1.max(to.1));
        let first = hops.first().copied().flatten().map_or(spots[k - 1].triangle, |h| h.triangle);
        let last = hops.last().copied().flatten().map_or(spots[k].triangle, |h| h.triangle);
        chords.push([first, last].map(|t| (t, flat_direction(sheet, t, to.0 - from.0))));
        laid.add_chord(sheet, number, [from, to], &hops, options);
    }
    laid.turn(sheet, &points, &spots, &chords, options);
    Ok(laid)
}

fn flat_direction(sheet: &Sheet, triangle: u32, d: Vector3<f64>) -> Vector2<f64> {
    let [x, y] = sheet.flats[triangle as usize].axes;
    Vector2::new(d.dot(&x), d.dot(&y)).try_normalize(0.0).unwrap_or_else(Vector2::x)
}

impl DepositedCurve {
    fn dot(&mut self, sheet: &Sheet, curve: u32, spot: Spot, radius: f64) {
        let centre = flat_point(sheet, spot.triangle, spot.weights);
        self.pieces.push(Piece {
            curve,
            triangle: spot.triangle,
            weights: [spot.weights; 2],
            ends: [centre; 2],
            radii: [radius; 2],
            along: [0.0; 2],
        });
        let first = Vector2::x();
        self.fans.push(Fan { triangle: spot.triangle, centre, first, sweep: 2.0 * PI, is_turn: false, radius });
    }

    fn add_chord(
        &mut self,
        sheet: &Sheet,
        curve: u32,
        [(p, r), (q, s)]: [(Vector3<f64>, f64); 2],
        hops: &[Option<Hop>],
        options: &StatisticsOptions,
    ) {
        let chord = q - p;
        let length = chord.norm();
        let widths = length / (r + s);
        self.statistics.length_mm += length;
        self.bead += length * (r + s);
        self.in_range += length * width_in_range([2.0 * r, 2.0 * s], options.width_range_mm);
        // How far along the chord a point is, never going back from where we are.
        let share = |place: Vector3<f64>, at: f64| ((place - p).dot(&chord) / (length * length)).clamp(at, 1.0);
        let (mut at, mut off, mut is_off) = (0.0f64, 0.0, false);
        for hop in hops {
            let Some(hop) = hop else {
                is_off = true;
                continue;
            };
            let ends = hop.weights.map(|w| flat_point(sheet, hop.triangle, w));
            if std::mem::take(&mut is_off) {
                let back = share(sheet.lift(hop.triangle, ends[0]), at);
                off += back - at;
                at = back;
            }
            let to = share(sheet.lift(hop.triangle, ends[1]), at);
            self.pieces.push(Piece {
                curve,
                triangle: hop.triangle,
                weights: hop.weights,
                ends,
                radii: [at, to].map(|t| r + (s - r) * t),
                along: [at, to].map(|t| self.widths + widths * t),
            });
            at = to;
        }
        if is_off {
            off += 1.0 - at;
        }
        self.statistics.off_surface_mm += off * length;
        self.off_area += off * length * (r + s);
        self.widths += widths;
    }

    /// Turns at inner points and where a closed curve closes; caps at the ends of others.
    fn turn(
        &mut self,
        sheet: &Sheet,
        points: &[(Vector3<f64>, f64)],
        spots: &[Spot],
        chords: &[[(u32, Vector2<f64>); 2]],
        options: &StatisticsOptions,
    ) {
        let count = chords.len();
        let mut window = Window::new(options.sharp_turn);
        let mut length = 0.0;
        for k in 1..=count {
            length += (points[k].0 - points[k - 1].0).norm();
            if k == count && !self.closed {
                break;
            }
            let (before, after) = (chords[k - 1][1], chords[k % count][0]);
            let spot = spots[k % count];
            let incoming = carried(sheet, spot, before, after.0);
            let angle = incoming.perp(&after.1).atan2(incoming.dot(&after.1));
            window.add(length, angle, 2.0 * TURN_WINDOW * points[k].1);
            let right = Vector2::new(incoming.y, -incoming.x);
            let outgoing_left = Vector2::new(-after.1.y, after.1.x);
            let first = if angle > 0.0 { right } else { outgoing_left };
            if let Some(centre) = in_frame(sheet, spot, after.0) {
                let (triangle, radius) = (after.0, points[k].1);
                self.fans.push(Fan { triangle, centre, first, sweep: angle.abs(), is_turn: true, radius });
            }
        }
        self.statistics.sharp_turns = window.count;
        if !self.closed {
            let caps = [
                (spots[0], chords[0][0], -1.0, points[0].1),
                (spots[count], chords[count - 1][1], 1.0, points[count].1),
            ];
            for (spot, (triangle, direction), sign, radius) in caps {
                if let Some(centre) = in_frame(sheet, spot, triangle) {
                    let first = Vector2::new(direction.y, -direction.x) * sign;
                    self.fans.push(Fan { triangle, centre, first, sweep: PI, is_turn: false, radius });
                }
            }
        }
    }
}

fn in_frame(sheet: &Sheet, spot: Spot, triangle: u32) -> Option<Vector2<f64>> {
    spot.seen_from(sheet, triangle).map(|weights| flat_point(sheet, triangle, weights))
}

/// A direction at a spot carried into the frame of another triangle there: unfolded the shortest way around the spot.
fn carried(sheet: &Sheet, spot: Spot, (from, direction): (u32, Vector2<f64>), to: u32) -> Vector2<f64> {
    if from == to {
        return direction;
    }
    let mut around = spot.triangles(sheet);
    around.retain(|&t| t != from);
    let mut reached = vec![(from, direction)];
    let mut next = 0;
    while next < reached.len() {
        let (triangle, direction) = reached[next];
        next += 1;
        for across in sheet.across[triangle as usize].iter().flatten() {
            let Some(k) = around.iter().position(|&t| t == across.triangle) else { continue };
            let carried = across.direction(direction);
            if across.triangle == to {
                return carried;
            }
            around.swap_remove(k);
            reached.push((across.triangle, carried));
        }
    }
    // Fans that touch in the spot only: as seen in space.
    let [x, y] = sheet.flats[from as usize].axes;
    flat_direction(sheet, to, x * direction.x + y * direction.y)
}

/// Mean over a segment of its width where that lies within a range, and of zero elsewhere; the width goes evenly from
/// one value to another.
fn width_in_range([a, b]: [f64; 2], [low, high]: [f64; 2]) -> f64 {
    let (least, most) = (a.min(b), a.max(b));
    if most - least <= EVEN * most {
        return if (low..=high).contains(&a) { a } else { 0.0 };
    }
    let (from, to) = (least.max(low), most.min(high));
    if from < to { (to - from) * (to + from) / 2.0 / (most - least) } else { 0.0 }
}

/// Counts turns: places where the direction changes by more than a limit within a window of arc length. Keeps the
/// least and the largest direction in the window, so each point costs a constant on average.
struct Window {
    limit: f64,
    count: usize,
    direction: f64,
    low: VecDeque<(f64, f64)>,
    high: VecDeque<(f64, f64)>,
}

impl Window {
    fn new(limit: f64) -> Self {
        Window { limit: limit + TURN_SLACK, count: 0, direction: 0.0, low: VecDeque::new(), high: VecDeque::new() }
    }

    fn add(&mut self, at: f64, angle: f64, window: f64) {
        // Directions before the turns in the window; the turn here is one of them.
        let before = self.direction;
        self.direction += angle;
        for (queue, sign) in [(&mut self.low, 1.0), (&mut self.high, -1.0)] {
            while queue.front().is_some_and(|&(place, _)| at - place > window) {
                queue.pop_front();
            }
            while queue.back().is_some_and(|&(_, direction)| sign * direction >= sign * before) {
                queue.pop_back();
            }
            queue.push_back((at, before));
        }
        let change =
            |queue: &VecDeque<(f64, f64)>| queue.front().map_or(0.0, |&(_, from)| (self.direction - from).abs());
        if change(&self.low).max(change(&self.high)) > self.limit {
            self.count += 1;
            self.low.clear();
            self.high.clear();
        }
    }
}
