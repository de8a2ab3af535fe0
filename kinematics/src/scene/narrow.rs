//! Two convex bodies, each the hull of a few points: are they farther apart than that, and where are they nearest?
//!
//! E. G. Gilbert, D. W. Johnson, S. S. Keerthi, "A fast procedure for computing the distance between complex objects in
//! three-dimensional space", IEEE J. Robotics and Automation 4(2), 1988, as parry implements it. The iteration may
//! end early or stall (two segments need none), so its word is not taken: "apart" is said only when all points of one body lie beyond all
//! points of the other along one direction, which is checked from the points. That check is the proof; the iteration
//! merely finds the direction.

use super::rounding::GAP_MM;
use nalgebra::{Point3, Vector3};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d_f64::shape::SupportMap;

/// The hull of points that are in the common frame already, whatever pose comes with them.
struct Placed<'a>(&'a [Point3<f64>]);

impl SupportMap for Placed<'_> {
    #[inline]
    fn local_support_point(&self, dir: Vector) -> Vector {
        let mut best = &self.0[0];
        let mut height = f64::NEG_INFINITY;
        for point in self.0 {
            let here = point.x * dir.x + point.y * dir.y + point.z * dir.z;
            if here > height {
                (best, height) = (point, here);
            }
        }
        Vector::new(best.x, best.y, best.z)
    }

    #[inline]
    fn support_point(&self, _: &Pose, dir: Vector) -> Vector {
        self.local_support_point(dir)
    }
}

fn ours(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

/// The gap along a direction of length 1 between all of `a` and all of `b`: a lower bound of their distance.
fn gap(a: &[Point3<f64>], b: &[Point3<f64>], direction: &Vector3<f64>) -> f64 {
    let above = b.iter().map(|p| direction.dot(&p.coords)).fold(f64::INFINITY, f64::min);
    let below = a.iter().map(|p| direction.dot(&p.coords)).fold(f64::NEG_INFINITY, f64::max);
    above - below
}

fn run(a: &[Point3<f64>], b: &[Point3<f64>], enough: f64) -> GJKResult {
    let (a, b) = (Placed(a), Placed(b));
    let (first, second) = (a.0[0] - b.0[0], a.0[a.0.len() - 1] - b.0[b.0.len() - 1]);
    let towards = first + second;
    let start = Vector::new(-towards.x, -towards.y, -towards.z).try_normalize().unwrap_or(Vector::X);
    let mut simplex = VoronoiSimplex::new();
    simplex.reset(CsoPoint::from_shapes(&Pose::IDENTITY, &a, &b, start));
    closest_points(&Pose::IDENTITY, &a, &b, enough, true, &mut simplex)
}

/// Segments that include a sine whose square is below this are left to the iteration: what is nearest rounds away.
const PARALLEL: f64 = 1e-9;

/// From the nearest point of one segment to that of another: C. Ericson, *Real-Time Collision Detection*, 2005, section
/// 5.1.9. Capsules against each other are most of the pairs of an arm, and need no iteration.
fn between_segments([a, a_end]: [&Point3<f64>; 2], [b, b_end]: [&Point3<f64>; 2]) -> Option<Vector3<f64>> {
    let (u, v, w) = (a_end - a, b_end - b, a - b);
    let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let det = uu * vv - uv * uv;
    if det <= PARALLEL * uu * vv {
        return None;
    }
    let s = ((uv * vw - vv * uw) / det).clamp(0.0, 1.0);
    let t = ((uv * s + vw) / vv).clamp(0.0, 1.0);
    let s = ((uv * t - uw) / uu).clamp(0.0, 1.0);
    Some(v * t - w - u * s)
}

/// Whether the hulls of `a` and `b` are proven to be farther apart than `threshold`.
pub(super) fn apart(a: &[Point3<f64>], b: &[Point3<f64>], threshold: f64) -> bool {
    let closed_form = match (a, b) {
        ([a, a_end], [b, b_end]) => between_segments([a, a_end], [b, b_end]),
        _ => None,
    };
    let iterated = || match run(a, b, threshold) {
        GJKResult::NoIntersection(direction) | GJKResult::Proximity(direction) => Some(ours(direction)),
        GJKResult::ClosestPoints(p, q, _) => Some(ours(q - p)),
        GJKResult::Intersection => None,
    };
    let Some(direction) = closed_form.or_else(iterated) else { return false };
    direction.try_normalize(f64::MIN_POSITIVE).is_some_and(|direction| gap(a, b, &direction) > threshold + GAP_MM)
}

/// The nearest points of the hulls of `a` and `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Nearest {
    /// Surely not nearer than the bound that was asked for.
    Beyond,
    At(Point3<f64>, Point3<f64>),
    Overlap,
}

/// The nearest points when they are nearer than `bound`.
pub(super) fn nearest(a: &[Point3<f64>], b: &[Point3<f64>], bound: f64) -> Nearest {
    match run(a, b, bound) {
        GJKResult::ClosestPoints(p, q, _) => Nearest::At(ours(p).into(), ours(q).into()),
        GJKResult::Intersection => Nearest::Overlap,
        GJKResult::NoIntersection(direction) | GJKResult::Proximity(direction) => {
            if gap(a, b, &ours(direction)) >= bound {
                return Nearest::Beyond;
            }
            // It stalled: without a bound it either ends or gives its last points, which is what there is.
            match run(a, b, f64::INFINITY) {
                GJKResult::ClosestPoints(p, q, _) => Nearest::At(ours(p).into(), ours(q).into()),
                _ => Nearest::Overlap,
            }
        }
    }
}
