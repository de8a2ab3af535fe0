//! The direction nearest to a wanted one that frees a nozzle whose tip stays where it is.
//!
//! Each point that must keep a clearance forbids a cap of directions (`nozzle`). The free directions are what all caps leave
//! of the sphere; of them the one at the least angle from the wanted direction is wanted. There are caps without number,
//! so they are taken in one at a time, by exchange:
//!
//! 1. Find the best direction outside the caps so far. It is the wanted one, or the point of a cap's circle that is nearest
//!    to it, or a point where two circles meet: where the angle from the wanted direction is least locally, it cannot fall
//!    inside the free part, nor along a circle. So a list of these candidates is kept, less those in a cap.
//! 2. Find where the nozzle in that direction lacks clearance. Nowhere: done. Else take in the cap of that point, and repeat.
//!
//! Each round finds the least angle for *some* of the caps, which is never above that for all of them; so a
//! direction found free is the least tilt there is. If no candidate is left, the caps so far cover the sphere, and no
//! tilt frees: that is proven, too.
//!
//! Caps keep one of [`SLACKS`] layers more clearance than must be, so that each takes its neighbours' in and the rounds end. So
//! "least" holds for a nozzle that is larger by the first, "no tilt" for one that is larger by the last.
//!
//! Nearly all the time goes into step 2. But a point that lacks clearance mostly lacks it with the other slack, from another wanted direction, where
//! the tip is raised a little and at the next waypoint: so the last points of a path are kept ([`Points`]) and those that are there are asked first.
//! That a place is closed is proven once with walks, and then by them alone.

use super::deepest::{Scene, Stand, Worst};
use crate::orientation::angle;
use nalgebra::{Unit, UnitVector3, Vector3};
use std::collections::VecDeque;
use std::f64::consts::PI;

/// Clearance beyond the needed one that caps keep, in layer heights. Less makes more rounds, more tilts farther; so the
/// second one is for places that the first says are closed: it opens one in ten of them.
const SLACKS: [f64; 2] = [0.02, 0.002];

/// Rounds after which the search gives up. On real parts it takes 3 in the median and 12 at most.
const ROUNDS: usize = 120;

/// A direction this far into a cap, by its cosine, is on its circle.
const ON_CIRCLE: f64 = 1e-10;

/// Directions that must not be.
#[derive(Clone, Copy, Debug)]
struct Cap {
    axis: UnitVector3<f64>,
    angle: f64,
    cos: f64,
}

impl Cap {
    fn new(axis: UnitVector3<f64>, angle: f64) -> Self {
        Cap { axis, angle, cos: angle.cos() }
    }

    fn forbids(&self, direction: &UnitVector3<f64>) -> bool {
        self.angle >= PI || self.axis.dot(direction) > self.cos + ON_CIRCLE
    }

    /// The point of its circle nearest to a direction.
    fn nearest(&self, direction: &UnitVector3<f64>) -> UnitVector3<f64> {
        let axis = self.axis.into_inner();
        let across = direction.into_inner() - axis * axis.dot(direction);
        // At the axis all are as near.
        let across = across.try_normalize(1e-12).unwrap_or_else(|| {
            let k = axis.iamin();
            axis.cross(&Vector3::ith(k, 1.0)).normalize()
        });
        Unit::new_normalize(axis * self.cos + across * self.angle.sin())
    }

    /// Where two circles meet.
    fn meet(&self, other: &Cap) -> [Option<UnitVector3<f64>>; 2] {
        let (a, b) = (self.axis.into_inner(), other.axis.into_inner());
        let across = a.cross(&b);
        let (c, square) = (a.dot(&b), across.norm_squared());
        let (x, y) = (self.cos - c * other.cos, other.cos - c * self.cos);
        let middle = (a * x + b * y) / square;
        let rest = (1.0 - middle.norm_squared()) / square;
        if !(rest >= 0.0 && rest.is_finite()) {
            return [None; 2];
        }
        let across = across * rest.sqrt();
        [Unit::try_new(middle + across, 0.5), Unit::try_new(middle - across, 0.5)]
    }
}

/// Caps, and the directions that may be the best outside of them.
struct Candidates {
    wanted: UnitVector3<f64>,
    limit: f64,
    caps: Vec<Cap>,
    /// Outside all caps, with their angle from the wanted one.
    left: Vec<(f64, UnitVector3<f64>)>,
}

impl Candidates {
    fn new(wanted: UnitVector3<f64>, limit: f64) -> Self {
        Candidates { wanted, limit, caps: Vec::new(), left: vec![(0.0, wanted)] }
    }

    fn take(&mut self, cap: Cap) {
        self.left.retain(|(_, direction)| !cap.forbids(direction));
        let nearest = cap.forbids(&self.wanted).then(|| cap.nearest(&self.wanted));
        let meeting = self.caps.iter().flat_map(|other| cap.meet(other)).flatten();
        // A cap only takes directions away. A new best one lies on its circle: at the nearest point, or where it meets another circle.
        for direction in nearest.into_iter().chain(meeting) {
            let tilt = angle(&self.wanted, &direction);
            if tilt <= self.limit && !cap.forbids(&direction) && !self.caps.iter().any(|cap| cap.forbids(&direction)) {
                self.left.push((tilt, direction));
            }
        }
        self.caps.push(cap);
    }

    /// The first of the best.
    fn best(&self) -> Option<UnitVector3<f64>> {
        let mut best: Option<&(f64, UnitVector3<f64>)> = None;
        for candidate in &self.left {
            if best.is_none_or(|best| candidate.0 < best.0) {
                best = Some(candidate);
            }
        }
        best.map(|&(_, direction)| direction)
    }
}

/// The last points that lacked clearance in searches for the waypoints of a path. They are there whatever the tip once their triangles are, as long
/// as the same depth is allowed.
#[derive(Debug, Default)]
pub(super) struct Points {
    allowed: f64,
    points: VecDeque<Worst>,
}

/// So many are kept: more are mostly too far behind.
const POINTS: usize = 32;

impl Points {
    /// Forgets what does not hold for a stand.
    fn begin(&mut self, stand: Stand) {
        if self.allowed.total_cmp(&stand.allowed).is_ne() {
            *self = Points { allowed: stand.allowed, points: VecDeque::new() };
        }
    }

    fn keep(&mut self, worst: Worst) {
        if self.points.len() == POINTS {
            self.points.pop_front();
        }
        self.points.push_back(worst);
    }

    /// Of those that are there the one that lacks most clearance.
    fn worst(&self, scene: &Scene, stand: Stand, direction: &UnitVector3<f64>) -> Option<Worst> {
        let lack = |worst: &Worst| {
            let to_point = worst.point - stand.tip;
            let z = to_point.dot(direction);
            let rho = (to_point - direction.into_inner() * z).norm();
            scene.nozzle.clearance(z, rho) - stand.clearance(worst.height)
        };
        let there = self.points.iter().filter(|worst| scene.keys.of_triangle[worst.triangle as usize] < stand.before);
        let all = there.map(|worst| Worst { lack: lack(worst), ..*worst });
        all.min_by(|a, b| a.lack.total_cmp(&b.lack)).filter(|worst| worst.lack < 0.0)
    }
}

impl Scene<'_> {
    /// The free direction nearest to `wanted`, if there is one within `limit`; `points` are those of earlier searches on the
    /// same path, to which it adds.
    pub(super) fn least_tilt(
        &self,
        stand: Stand,
        wanted: UnitVector3<f64>,
        limit: f64,
        points: &mut Points,
        stack: &mut Vec<(f64, u32)>,
    ) -> Option<UnitVector3<f64>> {
        points.begin(stand);
        SLACKS.iter().find_map(|&slack| self.exchange(stand, wanted, limit, slack, points, stack))
    }

    /// The search with caps that keep `slack`.
    fn exchange(
        &self,
        stand: Stand,
        wanted: UnitVector3<f64>,
        limit: f64,
        slack: f64,
        points: &mut Points,
        stack: &mut Vec<(f64, u32)>,
    ) -> Option<UnitVector3<f64>> {
        let cap = |bad: &Worst| {
            let to_point = bad.point - stand.tip;
            let clearance = stand.clearance(bad.height) + slack * bad.height;
            Some(Cap::new(Unit::try_new(to_point, 0.0)?, self.nozzle.cap(to_point.norm(), clearance)?))
        };
        let mut candidates = Candidates::new(wanted, limit);
        if self.plate.is_some() {
            let lean = self.nozzle.plate_lean(self.over_plate(stand))?;
            // The plate as one cap: directions that lean farther than the tip is high enough for.
            candidates.take(Cap::new(-Vector3::z_axis(), PI - lean));
        }
        for _ in 0..ROUNDS {
            let direction = candidates.best()?;
            let worst = match points.worst(self, stand, &direction) {
                Some(worst) => worst,
                None => {
                    let Some(worst) = self.bad(stand, &direction, stack) else { return Some(direction) };
                    points.keep(worst);
                    worst
                }
            };
            // The point is nearer to the nozzle than its cap keeps, so the cap forbids the direction that was asked about, and the next
            // one differs.
            candidates.take(cap(&worst)?);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gouging::{Nozzle, Obstacle};
    use crate::layer::{BuiltLayer, LayerStack};
    use nalgebra::Point3;

    #[test]
    fn points_count_once_their_triangles_are_there_and_only_for_the_depth_that_was_allowed() {
        let level = |z: f64| [[0.0, 0.0, z], [9.0, 0.0, z], [0.0, 9.0, z]].map(Point3::from);
        let vertices = [level(0.4), level(0.8)];
        let layer =
            |k: usize| BuiltLayer { vertices: &vertices[k], triangles: &[[0, 1, 2]], spacing: &[0.4], curves: &[] };
        let layers = [0, 1].map(layer);
        let stack = LayerStack::new(&layers).unwrap();
        let nozzle = Nozzle::default();
        let scene = Scene::new(&stack, &stack.keys, &nozzle, None);
        let key = stack.keys.of_triangle[1];
        let stand = |before: u32, allowed: f64| Stand { tip: Point3::new(1.0, 1.0, 0.5), before, allowed };
        let mut points = Points::default();
        points.begin(stand(key, 0.25));
        // Above the tip, in the way of a nozzle that stands upright.
        let worst = Worst {
            point: Point3::new(1.0, 1.0, 0.9),
            lack: -0.3,
            triangle: 1,
            height: 0.4,
            obstacle: Obstacle::Layer(1),
        };
        points.keep(worst);
        let found = |points: &Points, before: u32| {
            points.worst(&scene, stand(before, 0.25), &Vector3::z_axis()).map(|worst| worst.lack)
        };
        assert_eq!(found(&points, key), None);
        assert!(found(&points, key + 1).is_some_and(|lack| (lack + 0.4).abs() < 1e-12));
        // More points than are kept push it out.
        (0..POINTS).for_each(|_| points.keep(Worst { point: Point3::new(1.0, 1.0, 0.1), ..worst }));
        assert_eq!(found(&points, key + 1), None);
        points.keep(worst);
        points.begin(stand(key + 1, 0.25));
        assert!(found(&points, key + 1).is_some());
        points.begin(stand(key + 1, 0.5));
        assert_eq!(found(&points, key + 1), None);
    }
}
