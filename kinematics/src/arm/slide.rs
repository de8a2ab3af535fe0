//! The nearest posture of an arm that can move while its flange stands still.
//!
//! At two singularities four joints form a closed linkage with one freedom. Of a UR arm whose axis 5 has brought axis 6 parallel
//! to axes 2, 3 and 4, these four move in a plane. Of an ortho-parallel arm with its wrist centre on axis 1, axes 1, 4, 5
//! and 6 meet there. Both linkages give three equations, and their derivatives have full rank where the whole arm's have not, also
//! with a stretched elbow. So the posture nearest to given joints is found by Newton's method: the shortest step to
//! where the linearised equations hold, counted from those joints.

use super::{Arm, Solver, meets};
use nalgebra::{Matrix3, Matrix3x4, Vector3, Vector4};
use std::f64::consts::PI;

/// Four joints that can move while the flange stands still.
pub(super) struct Linkage {
    pub joints: [usize; 4],
    /// Where they start, and where the other two stand.
    pub start: [f64; 6],
    /// The three equations: which turn of the flange about its origin and which shift (in longest links) must vanish.
    pub turns: [Vector3<f64>; 3],
    pub shifts: [Vector3<f64>; 3],
}

/// Newton's method doubles the digits in each step; from far away it may need a few to get going.
const STEPS: usize = 12;

/// A step below this leaves nothing to gain, in radians.
const SETTLED: f64 = 1e-13;

impl Arm {
    /// The posture of the linkage nearest to where it starts; `None` when there is none near, or the pose is not singular.
    /// All joints are the geometry's.
    pub(super) fn slide(&self, r: &Matrix3<f64>, p: &Vector3<f64>, was: &[f64; 6]) -> Option<[f64; 6]> {
        let linkage = match &self.solver {
            Solver::Ur(arm) => arm.linkage(r, p, was)?,
            Solver::Ortho(arm) => arm.linkage(r, p, was)?,
        };
        let mut q = linkage.start;
        let unit = 1.0 / self.longest_link();
        for _ in 0..STEPS {
            let (rotation, position) = self.flange(&q);
            let short = (p - position) * unit;
            let twist = (0..3).map(|k| rotation.column(k).cross(&r.column(k))).sum::<Vector3<f64>>() * 0.5;
            let equation = |k: usize, linear: &Vector3<f64>, angular: &Vector3<f64>| {
                linkage.shifts[k].dot(linear) + linkage.turns[k].dot(angular)
            };
            let axes = self.inner_axes(&q);
            let mut slopes = Matrix3x4::zeros();
            let mut missing = Vector3::zeros();
            for k in 0..3 {
                for (column, &joint) in linkage.joints.iter().enumerate() {
                    let (at, along) = &axes[joint];
                    slopes[(k, column)] = equation(k, &(along.cross(&(position - at)) * unit), along);
                }
                missing[k] = equation(k, &short, &twist);
            }
            let back = Vector4::from(linkage.joints.map(|joint| was[joint] - q[joint]));
            let weights = (slopes * slopes.transpose()).try_inverse()?;
            let step = back + slopes.transpose() * (weights * (missing - slopes * back));
            linkage.joints.iter().zip(step.iter()).for_each(|(&joint, step)| q[joint] += step);
            if step.iter().any(|angle| angle.is_nan() || angle.abs() > PI) {
                return None;
            }
            if step.amax() < SETTLED {
                break;
            }
        }
        meets(&self.flange(&q), r, p, 1.0).then_some(q)
    }
}
