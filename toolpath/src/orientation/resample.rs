//! Curves as points an even step apart, corners kept.
//!
//! Dai 2020, section 3.5.2: "each tool-path is uniformly re-sampled". Departs from it: a point stays on each corner, and
//! steps between corners are evened out, so that the path does not cut corners off.
//!
//! The bend at a point is the angle between the chords to the points a quarter of a step before and behind it: a corner
//! that is rounded by several close points counts, the noise of short segments does not.

use crate::layer::BuiltCurve;
use crate::path::BeadKind;
use nalgebra::Point3;

/// Arms of the bend, in steps.
const ARM: f64 = 0.25;

/// Corners nearer to a sharper one than this, in steps, are that corner.
const APART: f64 = 0.5;

/// A curve by arc length.
pub(super) struct Line {
    pub points: Vec<Point3<f64>>,
    pub widths: Vec<f64>,
    kinds: Vec<BeadKind>,
    /// Arc length at each point.
    pub arcs: Vec<f64>,
    closed: bool,
}

impl Line {
    /// Repeated points are left out; of a closed curve the first point is repeated at the end.
    pub fn new(curve: &BuiltCurve) -> Self {
        let (points, widths, kinds) = (Vec::new(), Vec::new(), Vec::new());
        let mut line = Line { points, widths, kinds, arcs: Vec::new(), closed: curve.is_closed() };
        for k in (0..curve.len()).chain(curve.is_closed().then_some(0)) {
            let (point, width, kind) = curve.at(k);
            match line.points.last() {
                Some(last) => {
                    let step = (point - last).norm();
                    if step > 0.0 {
                        line.push(point, width, kind, line.length() + step);
                    }
                }
                None => line.push(point, width, kind, 0.0),
            }
        }
        line
    }

    fn push(&mut self, point: Point3<f64>, width: f64, kind: BeadKind, arc: f64) {
        self.points.push(point);
        self.widths.push(width);
        self.kinds.push(kind);
        self.arcs.push(arc);
    }

    pub fn length(&self) -> f64 {
        self.arcs.last().copied().unwrap_or(0.0)
    }

    /// Point, width and kind at an arc length, which is held to the curve, or goes on around a closed one.
    pub fn at(&self, arc: f64) -> (Point3<f64>, f64, BeadKind) {
        let length = self.length();
        let around = self.closed && !(0.0..=length).contains(&arc);
        let arc = if around { arc.rem_euclid(length) } else { arc.clamp(0.0, length) };
        let last = self.points.len() - 1;
        let k = self.arcs.partition_point(|&at| at <= arc).clamp(1, last.max(1)) - 1;
        if last == 0 {
            return (self.points[0], self.widths[0], self.kinds[0]);
        }
        let share = (arc - self.arcs[k]) / (self.arcs[k + 1] - self.arcs[k]);
        let width = self.widths[k] + (self.widths[k + 1] - self.widths[k]) * share;
        // Ends come out as they are.
        let point = if share >= 1.0 {
            self.points[k + 1]
        } else {
            self.points[k] + (self.points[k + 1] - self.points[k]) * share
        };
        (point, width, self.kinds[if share < 0.5 { k } else { k + 1 }])
    }

    /// Arc lengths of the samples, rising from 0 to the length.
    pub fn samples(&self, step: f64, corner: f64) -> Vec<f64> {
        let mut fixed = self.corners(step, corner);
        fixed.push(self.length());
        let mut arcs = vec![0.0];
        let mut from = 0.0;
        for to in fixed {
            let count = ((to - from) / step).round().max(1.0);
            arcs.extend((1..count as usize).map(|k| from + (to - from) * k as f64 / count));
            arcs.push(to);
            from = to;
        }
        arcs
    }

    /// Arc lengths of the corners between the ends.
    fn corners(&self, step: f64, corner: f64) -> Vec<f64> {
        let (arm, length) = (ARM * step, self.length());
        let bend = |k: usize| {
            let [before, behind] = [self.arcs[k] - arm, self.arcs[k] + arm].map(|arc| self.at(arc).0);
            (self.points[k] - before).angle(&(behind - self.points[k]))
        };
        let inner = 1..self.points.len() - 1;
        let mut sharp: Vec<(f64, usize)> = inner.map(|k| (bend(k), k)).filter(|&(bend, _)| bend > corner).collect();
        sharp.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut kept = vec![0.0, length];
        for (_, k) in sharp {
            let arc = self.arcs[k];
            let near = kept.partition_point(|&other| other < arc);
            if arc - kept[near - 1] >= APART * step && kept[near] - arc >= APART * step {
                kept.insert(near, arc);
            }
        }
        kept[1..kept.len() - 1].to_vec()
    }
}
