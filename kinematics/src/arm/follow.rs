//! The posture next to given joints where the closed form has lost them.
//!
//! On a singularity a pose leaves a joint free, and beside one, and all the more where two meet, what it says of some
//! joints is less than rounding. Then the closed form is right about the pose, but its joints may be far from where
//! the arm is, with a posture near by that is as right. Damped least squares find it: K. Levenberg, Quarterly of
//! Applied Mathematics 2, 1944, with the damping in proportion to the squared error (N. Yamashita, M. Fukushima, "On
//! the rate of convergence of the Levenberg-Marquardt method", 2001), which converges where the Jacobian has lost
//! rank, too. Each step is the shortest one for what it gains, so the arm ends hardly farther than it must.
//!
//! Of a coupled arm the angle between upper arm and forearm has no stops of its own, joint 3 has: the steps are taken in angles of
//! which the third is free of joint 2 ([`Arm::uncoupled`]).
//!
//! Joints stay between their stops: one that a step would take beyond goes to its stop, and the others make up for
//! the rest of the step (clamped joints: P. Baerlocher, R. Boulic, "An inverse kinematics architecture enforcing an
//! arbitrary number of strict priority levels", The Visual Computer 20, 2004). The next step may free it again.

use super::jacobian::{couple, jacobian_of};
use super::solver::Arm;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Steps. Three or four are enough beside a singularity; more are for the rare case of several.
const STEPS: usize = 40;

/// An error below this will do, a twentieth of what a solution may have: in radians, and in longest links. To ask for
/// more would send the arm far along directions in which it hardly shows.
const MET: f64 = 5e-11;

/// An error above this is no small step: farther away the nearest posture is a matter of branches.
pub(super) const SMALL: f64 = 0.1;

/// The same where a branch is known: the guesses of a calibrated arm are off by its deviation, and around a singularity by a few
/// times that.
pub(super) const FAR: f64 = 1.0;

/// Least damping, for the same reason; it also keeps the normal equations solvable in double precision.
const FLOOR: f64 = 1e-12;

/// Between which angles the geometry's joints stay, joint 3 uncoupled from joint 2.
pub(super) type Stops = [(f64, f64); 6];

/// No stops at all.
pub(super) const NO_STOPS: Stops = [(f64::NEG_INFINITY, f64::INFINITY); 6];

impl Arm {
    /// The limits, for the geometry's joints, joint 3 uncoupled from joint 2.
    pub(super) fn stops(&self) -> Stops {
        let [lower, upper] = [&self.limits.lower, &self.limits.upper].map(|ends| {
            let ends: [f64; 6] = std::array::from_fn(|k| ends[k] * self.signs[k] - self.offsets[k]);
            ends
        });
        [0, 1, 2, 3, 4, 5].map(|k| (lower[k].min(upper[k]), lower[k].max(upper[k])))
    }

    /// How far joint 3 of the geometry turns with its joint 2.
    fn coupling(&self) -> f64 {
        self.j23_factor * self.signs[1] * self.signs[2]
    }

    /// Joints of the geometry without (`sign` -1) or again with (1) what joint 2 adds to joint 3.
    fn uncoupled(&self, inner: &[f64; 6], sign: f64) -> [f64; 6] {
        let mut angles = *inner;
        if self.is_coupled() {
            angles[2] += sign * self.coupling() * (inner[1] + self.offsets[1]);
        }
        angles
    }

    /// From joints of the geometry to some near by, between the stops, that meet the pose, as well as they do after
    /// some steps.
    ///
    /// # Arguments
    /// * `farthest`: an error above it is given up.
    pub(super) fn follow(
        &self,
        r: &Matrix3<f64>,
        p: &Vector3<f64>,
        was: &[f64; 6],
        stops: &Stops,
        farthest: f64,
    ) -> Option<[f64; 6]> {
        let unit = 1.0 / self.longest_link();
        let was = self.uncoupled(was, -1.0);
        let mut q: [f64; 6] = std::array::from_fn(|k| between(was[k], stops[k]));
        for _ in 0..STEPS {
            let inner = self.uncoupled(&q, 1.0);
            let flange = self.flange(&inner);
            let error = self.short_of(r, p, &flange);
            let square = error.norm_squared();
            if square.is_nan() || square > farthest * farthest {
                return None;
            }
            if square <= MET * MET {
                break;
            }
            let mut slopes = jacobian_of(&self.inner_axes(&inner), &flange.1);
            couple(&mut slopes, self.coupling());
            slopes.fixed_rows_mut::<3>(0).scale_mut(unit);
            clamped_step(&mut q, slopes, error, square.max(FLOOR), stops)?;
        }
        Some(self.uncoupled(&q, 1.0))
    }

    /// How far a flange is from the pose: shift in longest links, and turn in radians, for small turns.
    pub(super) fn short_of(
        &self,
        r: &Matrix3<f64>,
        p: &Vector3<f64>,
        (rotation, position): &(Matrix3<f64>, Vector3<f64>),
    ) -> Vector6<f64> {
        let shift = (p - position) / self.longest_link();
        let turn = (0..3).map(|k| rotation.column(k).cross(&r.column(k))).sum::<Vector3<f64>>() * 0.5;
        Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
    }
}

fn between(angle: f64, (low, high): (f64, f64)) -> f64 {
    angle.max(low).min(high)
}

/// Moves joints by a damped step. The joint that it would take farthest beyond its stop goes to the stop, and the step
/// of the others is computed again.
fn clamped_step(
    q: &mut [f64; 6],
    mut slopes: Matrix6<f64>,
    mut error: Vector6<f64>,
    damping: f64,
    stops: &Stops,
) -> Option<()> {
    let mut moves = [true; 6];
    loop {
        let damped = slopes * slopes.transpose() + Matrix6::identity() * damping;
        let step = slopes.transpose() * damped.cholesky()?.solve(&error);
        let beyond = |k: usize| (q[k] + step[k] - between(q[k] + step[k], stops[k])).abs();
        let farthest = (0..6).filter(|&k| moves[k]).max_by(|&a, &b| beyond(a).total_cmp(&beyond(b)));
        let Some(k) = farthest.filter(|&k| beyond(k) > 0.0) else {
            (0..6).filter(|&k| moves[k]).for_each(|k| q[k] += step[k]);
            return Some(());
        };
        let stop = between(q[k] + step[k], stops[k]);
        error -= slopes.column(k) * (stop - q[k]);
        slopes.column_mut(k).fill(0.0);
        (q[k], moves[k]) = (stop, false);
    }
}
