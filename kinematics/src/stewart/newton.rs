//! From lengths to a pose: Newton's method on the squared lengths.
//!
//! The squares `|d_i|^2 - l_i^2` are smooth where a length is zero, and cost no roots. With the twist `(v, w)` of the
//! platform about its origin their derivatives are `2 d_i . v + 2 (R b_i x d_i) . w`; the six equations are solved by
//! elimination with row exchange, the step is halved until it gains something, and the pose stays a pose: the turn is
//! applied as a quaternion.

use super::platform::Stewart;
use crate::pose::{parts, rotation};
use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

/// A pose that has the asked lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundPose {
    /// `base_platform`.
    pub pose: Isometry3<f64>,
    /// Largest difference of a leg from its asked length, in mm. At most 1e-12 of the longest leg (or of the farthest joint of base and
    /// platform from its origin, if that is more).
    pub residual_mm: f64,
    /// Steps of Newton's method.
    pub iterations: u32,
}

/// Why there is no pose for lengths. Legs are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StewartError {
    /// A length is not a positive number, or beyond 1e7 mm.
    #[error("the length of leg {} is {length} mm: it must be above 0 and at most 1e7", leg + 1)]
    Length {
        /// The leg.
        leg: usize,
        /// Its length.
        length: f64,
    },
    /// The pose to begin from is not finite, or its quaternion has another length than 1.
    #[error("the pose to begin from has entries that are not finite, or a quaternion of another length than 1")]
    Pose,
    /// From there no pose with these lengths was found; far lengths have none at all.
    #[error("no pose was found for these legs: leg {} stays {residual_mm} mm off", leg + 1)]
    NoPose {
        /// The leg that is farthest from its length at the best pose.
        leg: usize,
        /// By how much.
        residual_mm: f64,
    },
    /// On the way the platform came to a singular pose, where legs alone do not hold it.
    #[error("the platform comes to a singular pose on the way, where its legs do not hold it")]
    Singular,
}

/// Lengths along a path that the platform cannot follow.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("lengths {index}: {cause}")]
pub struct FollowError {
    /// Which lengths, counted from 0.
    pub index: usize,
    /// Why not.
    pub cause: StewartError,
}

/// Longest leg that is asked for in earnest.
const MAX_LEG_MM: f64 = 1e7;
/// A pose is found when every leg is this near to its length, as a share of the longest or of
/// the farthest joint: rounding is some 1e-15.
const DONE: f64 = 1e-12;
/// Steps after which a start counts as hopeless. From a near pose it takes 3 to 5.
const MAX_STEPS: u32 = 60;
/// Halvings of a step after which it counts as stuck.
const MAX_HALVINGS: u32 = 12;
/// Largest turn in a step, in radians: beyond it the derivatives say nothing.
const MAX_TURN: f64 = 1.0;
/// A pivot below this share of the largest entry counts as zero: the platform is singular.
const PIVOT: f64 = 1e-14;
/// Halvings of the way between two sets of lengths, when the platform is followed.
const MAX_SPLITS: u32 = 16;

/// A pose on its way.
#[derive(Clone, Copy)]
pub(super) struct State {
    pub q: UnitQuaternion<f64>,
    pub t: Vector3<f64>,
}

/// Residuals of the squares with the equations for the next step.
struct Linear {
    rows: [[f64; 8]; 6],
    /// Sum of the squared residuals.
    sum: f64,
}

impl Stewart {
    /// The pose with these lengths that Newton's method reaches from a near one: with lengths that change a little
    /// from pose to pose, the pose that goes on from the last. Limits are not looked at.
    ///
    /// # Errors
    /// [`StewartError`] names the invalid leg, or stays off.
    ///
    /// # Cost
    /// Under a microsecond from a near pose, no allocation.
    pub fn pose_near(&self, legs: &[f64; 6], near: &Isometry3<f64>) -> Result<FoundPose, StewartError> {
        check_lengths(legs)?;
        let (r, t) = parts(near).map_err(|_| StewartError::Pose)?;
        self.solve(legs, State { q: rotation(&r), t })
    }

    pub(super) fn solve(&self, legs: &[f64; 6], start: State) -> Result<FoundPose, StewartError> {
        let scale = legs.iter().fold(self.size, |a: f64, &b| a.max(b));
        let mut state = start;
        let mut linear = self.linear(legs, &state);
        let mut iterations = 0;
        loop {
            let (leg, residual_mm) = worst(&linear, legs);
            if residual_mm <= DONE * scale {
                let pose = Isometry3::from_parts(Translation3::from(state.t), state.q);
                return Ok(FoundPose { pose, residual_mm, iterations });
            }
            let failed = StewartError::NoPose { leg, residual_mm };
            if iterations == MAX_STEPS {
                return Err(failed);
            }
            iterations += 1;
            let Some(step) = eliminate(linear.rows) else { return Err(StewartError::Singular) };
            let (v, w) = (Vector3::new(step[0], step[1], step[2]), Vector3::new(step[3], step[4], step[5]));
            let mut share = (MAX_TURN / w.norm()).min(1.0);
            let mut halvings = 0;
            loop {
                let tried = moved(&state, &(v * share), &(w * share));
                let found = self.linear(legs, &tried);
                if found.sum < linear.sum {
                    (state, linear) = (tried, found);
                    break;
                }
                // Not with NaN either.
                halvings += 1;
                share *= 0.5;
                if halvings > MAX_HALVINGS {
                    return Err(failed);
                }
            }
        }
    }

    /// Residuals and derivatives of the squared lengths.
    #[inline]
    fn linear(&self, legs: &[f64; 6], state: &State) -> Linear {
        let r: Matrix3<f64> = state.q.to_rotation_matrix().into_inner();
        let mut linear = Linear { rows: [[0.0; 8]; 6], sum: 0.0 };
        for (k, length) in legs.iter().enumerate() {
            let arm = r * self.platform[k];
            let leg = arm + state.t - self.base[k];
            let turn = arm.cross(&leg);
            // Half of the equation on both sides.
            let off = 0.5 * (leg.norm_squared() - length * length);
            linear.rows[k] = [leg.x, leg.y, leg.z, turn.x, turn.y, turn.z, -off, 0.0];
            linear.sum += off * off;
        }
        linear
    }

    /// The poses of a platform that follows lengths from a pose on, one for each set of lengths.
    ///
    /// Between two sets all legs move at once and evenly; the way is halved until each step is what the legs force: on
    /// the same side of any singular pose, and no farther than twice what the legs' change can move a platform as well
    /// held as at the step's begin. So the poses stay in one mode.
    ///
    /// # Errors
    /// [`FollowError`] with the index of the lengths that cannot be reached.
    pub fn follow(
        &self,
        legs: impl IntoIterator<Item = [f64; 6]>,
        start: &Isometry3<f64>,
    ) -> Result<Vec<Isometry3<f64>>, FollowError> {
        let mut poses = Vec::new();
        let mut at = *start;
        if parts(start).is_err() {
            return Err(FollowError { index: 0, cause: StewartError::Pose });
        }
        let mut have = self.legs(start);
        for (index, wanted) in legs.into_iter().enumerate() {
            check_lengths(&wanted).map_err(|cause| FollowError { index, cause })?;
            at = self.step_to(&have, &wanted, &at, 0).map_err(|cause| FollowError { index, cause })?;
            have = wanted;
            poses.push(at);
        }
        Ok(poses)
    }

    fn step_to(
        &self,
        have: &[f64; 6],
        wanted: &[f64; 6],
        at: &Isometry3<f64>,
        depth: u32,
    ) -> Result<Isometry3<f64>, StewartError> {
        let found = self.pose_near(wanted, at);
        if let Ok(found) = found {
            let change = (0..6).map(|k| (wanted[k] - have[k]).powi(2)).sum::<f64>().sqrt();
            let size = wanted.iter().fold(1.0, |a: f64, &b| a.max(b));
            // Rounding moves the platform, too.
            let allowed = 2.0 * (change + 1e-9 * size) / self.singularity(at);
            let same_side = self.side(at) > 0.0 && self.side(&found.pose) > 0.0
                || self.side(at) < 0.0 && self.side(&found.pose) < 0.0;
            if same_side && self.distance(at, &found.pose) <= allowed {
                return Ok(found.pose);
            }
        }
        if depth == MAX_SPLITS {
            return Err(found.err().unwrap_or(StewartError::Singular));
        }
        let middle: [f64; 6] = std::array::from_fn(|k| 0.5 * (have[k] + wanted[k]));
        let halfway = self.step_to(have, &middle, at, depth + 1)?;
        self.step_to(&middle, wanted, &halfway, depth + 1)
    }

    /// How far apart two poses are, in mm: the way of the middle of the joints, and the turn at their radius.
    fn distance(&self, a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
        let middle = nalgebra::Point3::from(self.centre);
        (a * middle - b * middle).norm().hypot(self.radius * a.rotation.angle_to(&b.rotation))
    }
}

pub(super) fn check_lengths(legs: &[f64; 6]) -> Result<(), StewartError> {
    match legs.iter().position(|length| !(*length > 0.0 && *length <= MAX_LEG_MM)) {
        None => Ok(()),
        Some(leg) => Err(StewartError::Length { leg, length: legs[leg] }),
    }
}

/// The leg that is farthest from its length, and by how much: `(|d|^2 - l^2) / 2` is `l` times that, to first order.
fn worst(linear: &Linear, legs: &[f64; 6]) -> (usize, f64) {
    let mut worst = (0, 0.0f64);
    for (k, (row, length)) in linear.rows.iter().zip(legs).enumerate() {
        let off = row[6].abs() / length;
        // NaN is the worst of all.
        if off > worst.1 || off.is_nan() {
            worst = (k, off);
        }
    }
    worst
}

/// A pose moved by a twist. The turn is Cayley's, which differs from the exact one in the third order.
fn moved(state: &State, v: &Vector3<f64>, w: &Vector3<f64>) -> State {
    let half = nalgebra::Quaternion::new(1.0, 0.5 * w.x, 0.5 * w.y, 0.5 * w.z);
    State { q: UnitQuaternion::new_normalize(half * state.q.into_inner()), t: state.t + v }
}

/// Solves six equations whose right sides stand in the seventh column (the eighth is empty); `None` when they are singular.
fn eliminate(mut rows: [[f64; 8]; 6]) -> Option<[f64; 6]> {
    let largest = rows.iter().flat_map(|row| &row[..6]).fold(0.0, |a: f64, x| a.max(x.abs()));
    for k in 0..6 {
        let mut pivot = k;
        for row in k + 1..6 {
            if rows[row][k].abs() > rows[pivot][k].abs() {
                pivot = row;
            }
        }
        rows.swap(k, pivot);
        let top = rows[k];
        let holds = top[k].abs() > PIVOT * largest;
        if !holds {
            return None;
        }
        let inverse = 1.0 / top[k];
        for row in rows.iter_mut().skip(k + 1) {
            let factor = row[k] * inverse;
            // All eight, for the processor takes several at once; those before are not read any more.
            for (entry, above) in row.iter_mut().zip(&top) {
                *entry -= factor * above;
            }
        }
    }
    let mut solution = [0.0; 6];
    for k in (0..6).rev() {
        let rest: f64 = (k + 1..6).map(|column| rows[k][column] * solution[column]).sum();
        solution[k] = (rows[k][6] - rest) / rows[k][k];
    }
    Some(solution)
}
