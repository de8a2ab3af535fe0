//! A centre line as stations: points a small step apart, smooth, on the layer.

use super::lines::CentreLine;
use super::near::Layer;
use crate::surface::level_set::SurfacePoint;
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

/// The stations of a line; none if it has no length. A closed line has its first station again at the end.
pub(super) fn stations(layer: &Layer, line: &CentreLine, step: f64, width: f64) -> Vec<Station> {
    let mut points = resampled(line, step);
    if points.len() < 2 {
        return Vec::new();
    }
    // The nearest point of the layer is there: the layer is not empty.
    let onto = |p: &mut SurfacePoint| *p = layer.nearest(p.position, f64::INFINITY).unwrap_or(*p);
    points.iter_mut().for_each(onto);
    for _ in 0..ROUNDS {
        SHARES.iter().for_each(|&share| smooth(&mut points, line.closed, share));
        points.iter_mut().for_each(onto);
    }
    let normals: Vec<_> = points.iter().map(|p| layer.normal(p)).collect();
    let window = ((width / step).round() as usize).max(1);
    let turning = turning(&points, &normals, line.closed, window);
    let mut arc = 0.0;
    let last = points.len() - 1;
    (0..=last)
        .map(|k| {
            arc += if k > 0 { (points[k].position - points[k - 1].position).norm() } else { 0.0 };
            let (before, after) = match (line.closed, k) {
                (true, _) if k == 0 || k == last => (last - 1, 1),
                _ => (k.saturating_sub(1), (k + 1).min(last)),
            };
            let chord = points[after].position - points[before].position;
            let along = (chord - normals[k].into_inner() * chord.dot(&normals[k])).try_normalize(0.0);
            let along = along.unwrap_or_else(|| super::frame::axes(&normals[k])[0]);
            let radius = if turning[k] > 0.0 { 1.0 / turning[k] } else { f64::INFINITY };
            Station { at: points[k], normal: normals[k], along, arc, radius }
        })
        .collect()
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

/// Moves points by a share towards the middle of their neighbours. Ends stay.
fn smooth(points: &mut [SurfacePoint], closed: bool, share: f64) {
    let last = points.len() - 1;
    let old: Vec<_> = points.iter().map(|p| p.position.coords).collect();
    let moved = |before: usize, k: usize, after: usize| {
        (old[k] * (1.0 - share) + (old[before] + old[after]) * (0.5 * share)).into()
    };
    for (k, point) in points.iter_mut().enumerate().take(last).skip(1) {
        point.position = moved(k - 1, k, k + 1);
    }
    if closed && last > 1 {
        points[0].position = moved(last - 1, 0, 1);
        points[last].position = points[0].position;
    }
}

/// Geodesic curvature at each point: the angle in the tangent plane between the chords over a window before and after, over their mean length. Near the
/// ends of an open line that of the nearest point with both.
fn turning(points: &[SurfacePoint], normals: &[UnitVector3<f64>], closed: bool, window: usize) -> Vec<f64> {
    let last = points.len() - 1;
    let window = window.min(last / 2).max(1);
    let at = |k: isize| points[k.rem_euclid(last as isize) as usize].position;
    let turn = |k: usize| {
        let (before, after) = match closed {
            true => (at(k as isize - window as isize), at(k as isize + window as isize)),
            false => (points[k - window].position, points[k + window].position),
        };
        let normal = normals[k].into_inner();
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
