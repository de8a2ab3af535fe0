//! The solution that goes on from where the arm is.
//!
//! Where a joint is free (wrist: axes 4 and 6 in line; shoulder: wrist centre on axis 1) the closed form takes it from
//! the previous joints: joint 1 at the shoulder; at the wrist joint 4 of an ortho-parallel arm and joint 6 of a UR arm. So
//! an arm that passes straight through the singularity does not turn that joint, as it does not before and after.
//! But the others have to follow, and near a second singularity they would have to run: then the nearest of all
//! postures is taken ([`slide`](super::slide)).
//!
//! Hardly off a singularity the pose says little about the free joint: joints that still meet the pose are kept.

use super::{Arm, Branch, Solutions, meets};
use crate::angle::nearest_image;
use crate::pose::parts;
use nalgebra::Isometry3;

/// Previous joints that meet the pose a tenth as closely as a solution must are the solution.
const KEPT: f64 = 0.1;

/// A free joint is kept unless the arm then moves this many times as far as it must.
const RUN: f64 = 4.0;

/// The square of the distance in joint space.
fn square(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

impl Arm {
    /// The solution within the limits that is nearest to `previous` (least sum of squared differences, whole turns
    /// counted), or `None` if there is none, or an argument is not finite.
    ///
    /// At a singularity the free joint stays where it was and the others follow, unless they would then have to move more than
    /// four times as far as they must: the nearest posture of all is taken then. Ties go to the lower slot.
    ///
    /// # Cost
    /// About a microsecond, no allocation.
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
        let (r, p) = parts(base_flange)?;
        if !previous.iter().all(|angle| angle.is_finite()) {
            return None;
        }
        let was = self.inner(previous);
        if self.limits.contains(previous) && meets(&self.flange(&was), &r, &p, KEPT) {
            return Some(*previous);
        }
        let mut found = self.closed_form(&r, &p, &was.map(|angle| nearest_image(angle, 0.0)));
        let mut nearest = None;
        while let Some((branch, joints)) = self.nearest_of(&found, previous) {
            if meets(&self.flange(&self.inner(&joints)), &r, &p, 1.0) {
                nearest = Some(joints);
                break;
            }
            found.remove(branch);
        }
        let slid = self.slide(&r, &p, &was).and_then(|inner| self.limits.nearest_image(&self.outer(&inner), previous));
        match (nearest, slid) {
            (Some(kept), Some(slid)) if square(&kept, previous) <= RUN * RUN * square(&slid, previous) => Some(kept),
            (kept, slid) => slid.or(kept),
        }
    }

    /// Of solutions in the geometry's joints, the one with the image nearest to `previous`, and that image.
    fn nearest_of(&self, found: &Solutions, previous: &[f64; 6]) -> Option<(Branch, [f64; 6])> {
        let mut nearest = None;
        let mut least = f64::INFINITY;
        for (branch, inner) in found.iter() {
            let Some(image) = self.limits.nearest_image(&self.outer(inner), previous) else { continue };
            let far = square(&image, previous);
            if far < least {
                (nearest, least) = (Some((branch, image)), far);
            }
        }
        nearest
    }
}
