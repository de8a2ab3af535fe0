//! Where on its path a nozzle is: forward only, within a window, and not beyond a point before it is said to be passed.

use super::{CheckOptions, PathPoint};
use nalgebra::{Point3, UnitVector3};

/// Millimetres of distance that a millimetre of progress costs: of two places equally near, the earlier is taken. Large
/// values make the place lag behind on a parallel line; without it rounding picks the later segment where a path turns back.
const PROGRESS_PRICE: f64 = 1e-3;

/// Where the nozzle is farther from the path than the window, the search looks so many windows ahead, so that a long part
/// left out does not make everything after it a deviation.
const WINDOWS_AHEAD: f64 = 50.0;

/// Follows one path.
pub(super) struct Follower<'a> {
    path: &'a [PathPoint],
    /// Place: `share` of the way from point `segment` to the next.
    pub segment: usize,
    pub share: f64,
    /// First point not passed.
    next: usize,
    tip: Option<Point3<f64>>,
}

/// The nearest place ahead.
#[derive(Clone, Copy)]
struct Place {
    segment: usize,
    share: f64,
    distance: f64,
}

impl<'a> Follower<'a> {
    /// `path` has a point at least.
    pub fn new(path: &'a [PathPoint]) -> Self {
        Follower { path, segment: 0, share: 0.0, next: 0, tip: None }
    }

    /// Goes on to a sample. Returns its distance from the path and the angle to the axis there, and calls `passed` with
    /// the points passed since the last one and how far each was missed.
    pub fn go(
        &mut self,
        time: f64,
        tip: &Point3<f64>,
        axis: &UnitVector3<f64>,
        options: &CheckOptions,
        mut passed: impl FnMut(usize, f64),
    ) -> (f64, f64) {
        let mut place = self.nearest(time, tip, options.window_mm);
        if place.distance > options.window_mm {
            place = self.nearest(time, tip, WINDOWS_AHEAD * options.window_mm);
        }
        self.segment = place.segment;
        self.share = place.share;
        let reached = if self.share >= 1.0 { self.segment + 1 } else { self.segment };
        let before = self.tip.unwrap_or(*tip);
        while self.next < self.path.len() && self.next <= reached {
            passed(self.next, to_segment(&self.path[self.next].position, &before, tip).0);
            self.next += 1;
        }
        self.tip = Some(*tip);
        (place.distance, angle(axis, &self.axis()))
    }

    /// Calls `missed` with the points that were not passed, and how far each is from the last sample.
    pub fn finish(&self, mut missed: impl FnMut(usize, f64)) {
        for (point, at) in self.path.iter().enumerate().skip(self.next) {
            missed(point, self.tip.map_or(f64::INFINITY, |tip| (tip - at.position).norm()));
        }
    }

    fn nearest(&self, time: f64, tip: &Point3<f64>, window: f64) -> Place {
        let stays = Place { segment: self.segment, share: self.share, distance: (tip - self.here()).norm() };
        let (mut best, mut price, mut walked) = (stays, stays.distance, 0.0);
        let ends = self.path[self.segment..].windows(2);
        for (segment, ends) in (self.segment..).zip(ends) {
            if segment > self.segment && ends[0].passed_s.is_some_and(|passed| passed > time) {
                break;
            }
            let (a, b) = (&ends[0].position, &ends[1].position);
            let length = (b - a).norm();
            let from = if segment == self.segment { self.share } else { 0.0 };
            let (_, share) = to_segment(tip, a, b);
            let last = if length > 0.0 { (from + (window - walked) / length).min(1.0) } else { 1.0 };
            let share = share.min(last).max(from);
            let distance = (tip - (a + (b - a) * share)).norm();
            let cost = distance + PROGRESS_PRICE * (walked + (share - from) * length);
            if cost < price {
                (best, price) = (Place { segment, share, distance }, cost);
            }
            walked += (1.0 - from) * length;
            if walked > window {
                break;
            }
        }
        best
    }

    fn here(&self) -> Point3<f64> {
        let a = self.path[self.segment].position;
        self.path.get(self.segment + 1).map_or(a, |b| a + (b.position - a) * self.share)
    }

    fn axis(&self) -> UnitVector3<f64> {
        let a = self.path[self.segment].axis;
        let Some(b) = self.path.get(self.segment + 1) else { return a };
        // Where the axes are equal or opposite there is no arc between them.
        a.try_slerp(&b.axis, self.share, 1e-9).unwrap_or(if self.share < 0.5 { a } else { b.axis })
    }
}

/// The angle between two axes; accurate for small ones, too.
pub(super) fn angle(a: &UnitVector3<f64>, b: &UnitVector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Distance of `p` from the line `a` to `b`, and the share of the way where it is nearest.
fn to_segment(p: &Point3<f64>, a: &Point3<f64>, b: &Point3<f64>) -> (f64, f64) {
    let along = b - a;
    let square = along.norm_squared();
    let share = if square > 0.0 { ((p - a).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
    ((p - (a + along * share)).norm(), share)
}
