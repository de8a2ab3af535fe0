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
//! Nearly all the time goes into step 2. But a point that lacks clearance with one slack mostly lacks it with the other, from another wanted
//! direction and where the tip is raised a little: so the points of a waypoint are kept ([`Points`]) and asked first. That a place is closed
//! is proven once with walks, and then by them alone.

use super::deepest::{Scene, Stand, Worst};
use super::nozzle::Nozzle;
use crate::orientation::angle;
use nalgebra::{Unit, UnitVector3, Vector3};
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

/// Points that lacked clearance in searches for one waypoint or on one leg. They are there whatever the tip, as long as the same is
/// built and as much is allowed.
#[derive(Debug, Default)]
pub(super) struct Points {
    before: u32,
    allowed: f64,
    points: Vec<Worst>,
}

impl Points {
    /// Forgets all: what comes of a waypoint does not depend on the searches for others.
    pub fn clear(&mut self) {
        self.points.clear();
    }

    /// Forgets what does not hold for a stand.
    fn begin(&mut self, stand: Stand) {
        if self.before != stand.before || self.allowed.total_cmp(&stand.allowed).is_ne() {
            *self = Points { before: stand.before, allowed: stand.allowed, points: Vec::new() };
        }
    }

    /// The one that lacks most clearance.
    fn worst(&self, nozzle: &Nozzle, stand: Stand, direction: &UnitVector3<f64>) -> Option<Worst> {
        let lack = |worst: &Worst| {
            let to_point = worst.point - stand.tip;
            let z = to_point.dot(direction);
            let rho = (to_point - direction.into_inner() * z).norm();
            nozzle.clearance(z, rho) - stand.clearance(worst.height)
        };
        let all = self.points.iter().map(|worst| Worst { lack: lack(worst), ..*worst });
        all.min_by(|a, b| a.lack.total_cmp(&b.lack)).filter(|worst| worst.lack < 0.0)
    }
}

impl Scene<'_> {
    /// The free direction nearest to `wanted`, if there is one within `limit`; `points` are those of earlier searches for the
    /// same waypoint or leg, to which it adds.
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
            let worst = match points.worst(self.nozzle, stand, &direction) {
                Some(worst) => worst,
                None => {
                    let Some(worst) = self.bad(stand, &direction, stack) else { return Some(direction) };
                    points.points.push(worst);
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
