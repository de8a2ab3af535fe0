//! The solution that goes on from where the arm is.
//!
//! Where a joint is free (wrist: axes 4 and 6 in line; shoulder: wrist centre on axis 1) the closed form takes it
//! from the previous joints: joint 1 at the shoulder; at the wrist joint 4 of an ortho-parallel arm and joint 6 of a
//! UR arm. So an arm that passes straight through the singularity does not turn that joint, as it does not before and
//! after. But the others have to follow, and near a second singularity they would have to run, or rounding decides
//! where they are, or one of them is at its stop: then the posture next to the previous joints is taken
//! ([`follow`](super::follow)), with joints clamped to their limits.
//!
//! Where a free joint 6 of a UR arm leaves the pose out of reach, the nearest one that does not is looked at as well.
//!
//! Hardly off a singularity the pose says little about the free joint: joints that still meet the pose are kept.

use super::branches::{Branch, Solutions};
use super::follow::{NO_STOPS, SMALL};
use super::numbers::{HELD, MAX_ANGLE, NEAR_WRIST, WRIST, meets};
use super::planar::Free;
use super::solver::Arm;
use crate::angle::nearest_image;
use crate::pose::parts;
use nalgebra::{Isometry3, Matrix3, Vector3};
use std::f64::consts::PI;

/// Previous joints that meet the pose a tenth as closely as a solution must are the solution.
const KEPT: f64 = 0.1;

/// A free joint is kept unless the arm then moves this many times as far as it must. In regular postures joints move
/// up to about this much farther than the flange (in radians, and in longest links).
const RUN: f64 = 3.0;

/// The square of the distance in joint space.
fn square(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

impl Arm {
    /// The solution within the limits that is nearest to `previous` (least sum of squared differences, whole turns
    /// counted), or `None` if there is none, if the pose is one that [`Arm::inverse`] refuses, or if a previous joint is
    /// not finite or beyond 1e6 rad.
    ///
    /// At a singularity the free joint stays where it was and the others follow, unless the arm would then move more
    /// than three times as far as it must: a posture next to `previous` that meets the pose is taken then. Ties go to
    /// the lower slot.
    ///
    /// # Cost
    /// About a microsecond, beside a singularity up to ten; no allocation.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::{Arm, robots};
    /// let arm = Arm::new(&robots::IRB120)?;
    /// // Axes 4 and 6 are in line: 1.2 rad of turn could be on either, and 0.9 of it is on axis 4.
    /// let joints = [0.3, 0.2, -0.1, 0.9, 0.0, 0.3];
    /// let next = arm.continuing(&arm.forward(&joints), &joints).ok_or("out of reach")?;
    /// assert!((0..6).all(|k| (next[k] - joints[k]).abs() < 1e-9));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn continuing(&self, base_flange: &Isometry3<f64>, previous: &[f64; 6]) -> Option<[f64; 6]> {
        let (r, p) = parts(base_flange).ok()?;
        // NaN fails the comparison.
        if !previous.iter().all(|angle| angle.abs() <= MAX_ANGLE) {
            return None;
        }
        let was = self.inner(previous);
        let flange = self.flange(&was);
        if self.limits.contains(previous) && meets(&flange, &r, &p, KEPT) {
            return Some(*previous);
        }
        let joints = was.map(|angle| nearest_image(angle, 0.0));
        let exact = self.closed_form(&r, &p, &Free { joints, wrist: WRIST, swings: false });
        let near_wrist = |(_, inner): (Branch, &[f64; 6])| inner[4].abs().min(PI - inner[4].abs()) <= NEAR_WRIST;
        let ask_loosely = exact.iter().any(near_wrist);
        let mut kept = self.nearest_of(exact, previous, &r, &p);
        if ask_loosely {
            let loose = self.closed_form(&r, &p, &Free { joints, wrist: NEAR_WRIST, swings: false });
            let loose = self.nearest_of(loose, previous, &r, &p);
            let nearer = |a: &[f64; 6], b: &[f64; 6]| square(a, previous).total_cmp(&square(b, previous));
            kept = kept.into_iter().chain(loose).min_by(nearer);
        }
        // In a regular posture joints move about as far as the flange. If that is so, nothing was lost.
        let must = self.short_of(&r, &p, &flange).norm_squared();
        if kept.is_some_and(|joints| square(&joints, previous) <= RUN * RUN * must) {
            return kept;
        }
        let followed = [self.stops(), NO_STOPS].iter().find_map(|stops| {
            let inner = self.follow(&r, &p, &was, stops, SMALL)?;
            let joints = self.limits.nearest_image(&self.outer(&inner), previous)?;
            meets(&self.flange(&self.inner(&joints)), &r, &p, HELD).then_some(joints)
        });
        let swung = self.closed_form(&r, &p, &Free { joints, wrist: WRIST, swings: true });
        let swung = self.nearest_of(swung, previous, &r, &p);
        // One that stays unless the other is nearer by far.
        let unless = |stays: [f64; 6], other: [f64; 6]| {
            let is_near = square(&stays, previous) <= RUN * RUN * square(&other, previous);
            if is_near { stays } else { other }
        };
        [kept, followed, swung].into_iter().flatten().reduce(unless)
    }

    /// Of solutions in the geometry's joints that meet the pose, the image within the limits nearest to `previous`.
    fn nearest_of(
        &self,
        mut found: Solutions,
        previous: &[f64; 6],
        r: &Matrix3<f64>,
        p: &Vector3<f64>,
    ) -> Option<[f64; 6]> {
        loop {
            let mut nearest = None;
            let mut least = f64::INFINITY;
            for (branch, inner) in found.iter() {
                let Some(image) = self.limits.nearest_image(&self.outer(inner), previous) else { continue };
                let far = square(&image, previous);
                if far < least {
                    (nearest, least) = (Some((branch, image)), far);
                }
            }
            let (branch, joints) = nearest?;
            if meets(&self.flange(&self.inner(&joints)), r, p, HELD) {
                return Some(joints);
            }
            found.remove(branch);
        }
    }
}
