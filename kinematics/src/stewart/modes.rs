//! Modes: the poses that share their lengths.
//!
//! A platform with general legs has up to 40 of them (M. Raghavan, "The Stewart platform of general geometry has 40
//! configurations", J. Mech. Des. 115, 1993). They are sought by Newton's method from random poses, so nothing says
//! that all were found. One needs no search: where the joints of base and platform lie in planes, the mirror image of a
//! pose in the base's plane, with the platform mirrored in its own plane (which leaves its joints where they are),
//! has the same lengths.

use super::newton::{State, StewartError, check_lengths};
use super::platform::Stewart;
use crate::pose::{parts, rotation};
use crate::random::Random;
use nalgebra::{Isometry3, Translation3, Vector3};

/// Poses nearer than this are one, as a share of the longest leg, and in radians.
const SAME: f64 = 1e-6;

impl Stewart {
    /// The mirror image of a pose: another one with the same lengths. `None` unless the joints of the base lie in a
    /// plane and those of the platform do, and for a pose that is not finite, or so far out that its image is not.
    /// ```
    /// use curvlay_kinematics::nalgebra::Isometry3;
    /// use curvlay_kinematics::stewart::{Stewart, StewartModel};
    /// let table = Stewart::new(&StewartModel::hexagon(325.0, 0.26, 125.0, 0.79))?;
    /// let mirrored = table.mirror(&Isometry3::translation(10.0, -5.0, 380.0)).ok_or("not planar")?;
    /// assert!((mirrored.translation.vector.z + 380.0).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn mirror(&self, pose: &Isometry3<f64>) -> Option<Isometry3<f64>> {
        let (base, platform) = self.planes.as_ref()?;
        let (r, t) = parts(pose).ok()?;
        let origin = r * platform.mirrored(&Vector3::zeros()) + t;
        let turned = base.matrix() * r * platform.matrix();
        let image = base.mirrored(&origin);
        let is_finite = image.iter().all(|x| x.is_finite());
        is_finite.then(|| Isometry3::from_parts(Translation3::from(image), rotation(&turned)))
    }

    /// Modes of the platform for these lengths: what Newton's method finds from `starts` random poses, the mirror
    /// image of each included where there is one. In the order in which they were found; the same `seed` gives the
    /// same. A list may lack modes, and an empty one does not mean that no mode exists.
    ///
    /// Limits and cones are not looked at: [`Stewart::fault`] reports which modes are possible.
    ///
    /// # Errors
    /// [`StewartError::Length`] names the invalid leg.
    ///
    /// # Cost
    /// Some 5 microseconds a start, so less than a second.
    /// ```
    /// use curvlay_kinematics::nalgebra::Isometry3;
    /// use curvlay_kinematics::stewart::{Stewart, StewartModel};
    /// let table = Stewart::new(&StewartModel::hexagon(325.0, 0.26, 125.0, 0.79))?;
    /// let legs = table.legs(&Isometry3::translation(10.0, -5.0, 380.0));
    /// let modes = table.modes(&legs, 200, 1)?;
    /// assert!(modes.len() >= 2 && modes.len() % 2 == 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn modes(&self, legs: &[f64; 6], starts: u16, seed: u64) -> Result<Vec<Isometry3<f64>>, StewartError> {
        check_lengths(legs)?;
        let longest = legs.iter().fold(0.0, |a: f64, &b| a.max(b));
        let middle = self.base.iter().sum::<Vector3<f64>>() / 6.0;
        let mut random = Random::new(seed);
        let mut found: Vec<Isometry3<f64>> = Vec::new();
        for _ in 0..starts {
            // The joints' middle is no farther from the base's than a leg and both radii; nearer is likelier.
            let q = random.turn();
            let at = middle + Vector3::new(random.signed(), random.signed(), random.signed()) * longest;
            let Ok(solved) = self.solve(legs, State { q, t: at - q * self.centre }) else { continue };
            for pose in [Some(solved.pose), self.mirror(&solved.pose)].into_iter().flatten() {
                let is_new = found.iter().all(|known| {
                    (known.translation.vector - pose.translation.vector).norm() > SAME * longest
                        || known.rotation.angle_to(&pose.rotation) > SAME
                });
                if is_new {
                    found.push(pose);
                }
            }
        }
        Ok(found)
    }
}
