//! The solution that goes on from where the arm is.
//!
//! Where joints are free (wrist: axes 4 and 6 in line; shoulder: wrist centre on axis 1) the closed form takes them from
//! the previous joints: joint 1 at the shoulder; at the wrist joint 4 of an ortho-parallel arm and joint 6 of a UR arm.
//! Hardly off a singularity the pose says little about them: joints that still meet the pose are kept as they are.

use super::{Arm, Branch, Solutions};
use crate::angle::nearest_image;
use crate::pose::parts;
use nalgebra::Isometry3;

/// Previous joints that meet the pose a tenth as closely as a solution must are the solution.
const KEPT: f64 = 0.1;

impl Arm {
    /// The solution within the limits that is nearest to `previous` (least sum of squared differences, whole turns
    /// counted), or `None` if there is none, or an argument is not finite.
    ///
    /// At a singularity the free joint stays where it was, the others follow. Ties go to the lower slot.
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
        if self.limits.contains(previous) && self.meets(&was, &r, &p, KEPT) {
            return Some(*previous);
        }
        let mut found = self.closed_form(&r, &p, &was.map(|angle| nearest_image(angle, 0.0)));
        while let Some((branch, joints)) = self.nearest_of(&found, previous) {
            if self.meets(&self.inner(&joints), &r, &p, 1.0) {
                return Some(joints);
            }
            found.remove(branch);
        }
        None
    }

    /// Of solutions in the geometry's joints, the one with the image nearest to `previous`, and that image.
    fn nearest_of(&self, found: &Solutions, previous: &[f64; 6]) -> Option<(Branch, [f64; 6])> {
        let mut nearest = None;
        let mut least = f64::INFINITY;
        for (branch, inner) in found.iter() {
            let Some(image) = self.limits.nearest_image(&self.outer(inner), previous) else { continue };
            let far: f64 = (0..6).map(|k| (image[k] - previous[k]).powi(2)).sum();
            if far < least {
                (nearest, least) = (Some((branch, image)), far);
            }
        }
        nearest
    }
}
