//! A centre line as stations: points a small step apart, smooth, on the layer.

use super::lines::CentreLine;
use super::near::Layer;
use super::walk::walk;
use crate::mesh::SurfacePoint;
use nalgebra::{UnitVector3, Vector3};

/// A point of a centre line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Station {
    pub at: SurfacePoint,
    pub normal: UnitVector3<f64>,
    /// Unit direction of the line in the tangent plane.
    pub along: Vector3<f64>,
    /// Length of the line before it.
    pub arc: f64,
    /// Steering radius in the tangent plane, infinite on a straight line.
    pub radius: f64,
}

/// Rounds of smoothing: level lines of a piecewise linear function have a kink at each edge.
const ROUNDS: usize = 3;

/// A round moves points by the first share towards the middle of their neighbours, and by the second one away again, so that bends keep their radius
/// (Taubin, "A signal processing approach to fair surface design", SIGGRAPH 1995).
const SHARES: [f64; 2] = [0.5, -0.52];

/// Where a line still bends tighter than the steering radius, it is pulled straight for at most so many rounds: next to the end of another line it gives
/// way within a step or two. What bends tighter by itself stays so.
const STRAIGHTENING: usize = 12;

/// A line along a border, but nearer to it than half a width, is moved inwards by at most this share of the width.
const MAX_SHIFT: f64 = 0.25;

/// It runs along the border if it is too near for so many widths. What crosses a border at an angle is cut there.
const BESIDE_WIDTHS: f64 = 4.0;

/// The stations of a line; none if it has no length. A closed line has its first station again at the end.
pub(super) fn stations(layer: &Layer, line: &CentreLine, step: f64, width: f64, min_radius: f64) -> Vec<Station> {
    let mut points = resampled(line, step);
    if points.len() < 2 {
        return Vec::new();
    }
    // The nearest point of the layer is there: the layer is not empty.
    let onto = |p: &mut SurfacePoint| *p = layer.nearest(p.position, f64::INFINITY).unwrap_or(*p);
    points.iter_mut().for_each(onto);
    let all = vec![true; points.len()];
    let even_out = |points: &mut Vec<SurfacePoint>| {
        SHARES.iter().for_each(|&share| smooth(points, line.closed, share, &all));
        points.iter_mut().for_each(onto);
    };
    (0..ROUNDS).for_each(|_| even_out(&mut points));
    let window = ((width / step).round() as usize).max(1);
    for _ in 0..STRAIGHTENING {
        let tight = tight(&turning(layer, &points, line.closed, window), min_radius, window);
        if !tight.contains(&true) {
            break;
        }
        smooth(&mut points, line.closed, SHARES[0], &tight);
        points.iter_mut().zip(&tight).filter(|(_, tight)| **tight).for_each(|(p, _)| onto(p));
    }
    let beside = (BESIDE_WIDTHS * width / step).ceil() as usize;
    if shift_inwards(layer, &mut points, line.closed, width, beside) {
        even_out(&mut points);
    }
    let turning = turning(layer, &points, line.closed, window);
    let mut arc = 0.0;
    (0..points.len())
        .map(|k| {
            arc += if k > 0 { (points[k].position - points[k - 1].position).norm() } else { 0.0 };
            let radius = if turning[k] > 0.0 { 1.0 / turning[k] } else { f64::INFINITY };
            Station {
                at: points[k],
                normal: layer.normal(&points[k]),
                along: along(layer, &points, line.closed, k),
                arc,
                radius,
            }
        })
        .collect()
}

/// The unit direction at a point: that of the chord between its neighbours, in the tangent plane.
fn along(layer: &Layer, points: &[SurfacePoint], closed: bool, k: usize) -> Vector3<f64> {
    let last = points.len() - 1;
    let (before, after) = match closed && (k == 0 || k == last) {
        true => (last - 1, 1),
        false => (k.saturating_sub(1), (k + 1).min(last)),
    };
    let normal = layer.normal(&points[k]);
    let chord = points[after].position - points[before].position;
    let along = (chord - normal.into_inner() * chord.dot(&normal)).try_normalize(0.0);
    along.unwrap_or_else(|| super::frame::axes(&normal)[0])
}

/// Points that bend tighter than a radius, and those within a window of them.
fn tight(turning: &[f64], min_radius: f64, window: usize) -> Vec<bool> {
    let mut tight = vec![false; turning.len()];
    for k in (0..turning.len()).filter(|&k| turning[k] * min_radius > 1.0) {
        tight[k.saturating_sub(window)..(k + window + 1).min(turning.len())].fill(true);
    }
    tight
}

/// How near a point is to a border.
#[derive(Clone, Copy, PartialEq)]
enum Room {
    /// Half a width on both sides.
    Enough,
    /// A little less on one side: the way inwards.
    Lacks(Vector3<f64>),
    /// Too little to move away from.
    TooLittle,
}

/// Moves points that are a little too near to a border on one side, along at least `beside` of them in a row; whether there are any. A line that goes
/// on over the border stays as it is: it would get a kink where it begins to move.
fn shift_inwards(layer: &Layer, points: &mut [SurfacePoint], closed: bool, width: f64, beside: usize) -> bool {
    let room = |k: usize| {
        let side = layer.normal(&points[k]).cross(&along(layer, points, closed, k));
        let lack =
            |side| 0.5 * width - walk(layer.mesh, &points[k], side, 0.5 * width, |_, _| {}).map_or(0.0, |to| to.length);
        match [lack(side), lack(-side)] {
            [left, right] if left <= 0.0 && right <= 0.0 => Room::Enough,
            [left, right] if left.max(right) > MAX_SHIFT * width || left.min(right) > 0.0 => Room::TooLittle,
            [left, right] => Room::Lacks(side * (right.max(0.0) - left.max(0.0))),
        }
    };
    let last = points.len() - 1;
    // An end lies on the border itself, where a way along it counts for nothing: it is like its neighbour.
    let rooms: Vec<Room> =
        (0..=last).map(|k| if closed || last < 2 { k } else { k.clamp(1, last - 1) }).map(room).collect();
    let mut moved = false;
    let mut first = 0;
    while first < points.len() {
        let count = rooms[first..].iter().take_while(|room| matches!(room, Room::Lacks(_))).count();
        let neighbours = [first.checked_sub(1), Some(first + count)].map(|k| k.and_then(|k| rooms.get(k)));
        if count >= beside && !neighbours.contains(&Some(&Room::TooLittle)) {
            for (point, room) in points[first..first + count].iter_mut().zip(&rooms[first..]) {
                if let Room::Lacks(inwards) = room {
                    point.position += inwards;
                    *point = layer.nearest(point.position, f64::INFINITY).unwrap_or(*point);
                }
            }
            moved = true;
        }
        first += count.max(1);
    }
    moved
}

/// Points of a line at even steps, its ends among them.
fn resampled(line: &CentreLine, step: f64) -> Vec<SurfacePoint> {
    let mut corners = line.points.clone();
    if line.closed {
        corners.extend(line.points.first().copied());
    }
    let length = line.length();
    if length <= 0.0 || !length.is_finite() {
        return Vec::new();
    }
    let count = (length / step).ceil().max(1.0) as usize;
    let (mut points, mut before, mut k) = (Vec::with_capacity(count + 1), 0.0, 0);
    for n in 0..=count {
        let wanted = length * n as f64 / count as f64;
        let size = |k: usize| (corners[k + 1].position - corners[k].position).norm();
        while k + 2 < corners.len() && before + size(k) < wanted {
            before += size(k);
            k += 1;
        }
        let share = if size(k) > 0.0 { ((wanted - before) / size(k)).clamp(0.0, 1.0) } else { 0.0 };
        let mut point = corners[k];
        point.position += (corners[k + 1].position - corners[k].position) * share;
        points.push(point);
    }
    points
}

/// Moves points of those chosen by a share towards the middle of their neighbours. Ends stay.
fn smooth(points: &mut [SurfacePoint], closed: bool, share: f64, chosen: &[bool]) {
    let last = points.len() - 1;
    let old: Vec<_> = points.iter().map(|p| p.position.coords).collect();
    let moved = |before: usize, k: usize, after: usize| {
        (old[k] * (1.0 - share) + (old[before] + old[after]) * (0.5 * share)).into()
    };
    for (k, point) in points.iter_mut().enumerate().take(last).skip(1).filter(|(k, _)| chosen[*k]) {
        point.position = moved(k - 1, k, k + 1);
    }
    if closed && last > 1 && chosen[0] {
        points[0].position = moved(last - 1, 0, 1);
        points[last].position = points[0].position;
    }
}

/// Geodesic curvature at each point: the angle in the tangent plane between the chords over a window before and after, over their mean length. Near the
/// ends of an open line that of the nearest point with both.
fn turning(layer: &Layer, points: &[SurfacePoint], closed: bool, window: usize) -> Vec<f64> {
    let last = points.len() - 1;
    let window = window.min(last / 2).max(1);
    let at = |k: isize| points[k.rem_euclid(last as isize) as usize].position;
    let turn = |k: usize| {
        let (before, after) = match closed {
            true => (at(k as isize - window as isize), at(k as isize + window as isize)),
            false => (points[k - window].position, points[k + window].position),
        };
        let normal = layer.normal(&points[k]).into_inner();
        let flat = |v: Vector3<f64>| v - normal * v.dot(&normal);
        let (u, v) = (flat(points[k].position - before), flat(after - points[k].position));
        let mean = 0.5 * (u.norm() + v.norm());
        if mean > 0.0 { u.cross(&v).norm().atan2(u.dot(&v)) / mean } else { 0.0 }
    };
    (0..=last)
        .map(|k| match closed {
            true => turn(k % last),
            false if last < 2 => 0.0,
            false => turn(k.clamp(window, last - window)),
        })
        .collect()
}
