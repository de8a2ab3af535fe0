//! How the nozzle stands, as a rotation: `R` takes z to the direction of the nozzle.
//!
//! A nozzle is round, so its turn about itself is free. It is the smallest rotation from z, `k = 0`: a function of the direction alone, so that
//! the nozzle winds up on no path, however often it goes round. Between two places whose directions differ by up to 2 degrees and lean by up to 90, linear interpolation of the
//! quaternions as the specification has it (section 1.4.2) is within 0.01 degrees of the great circle; a test holds it to that.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, UnitVector3, Vector3};

/// Tip and direction of a nozzle as a pose. Straight down, where every axis would do, it turns about x.
///
/// # Example
/// ```
/// use curvlay_examples::build3mf::{direction_of, frame_at};
/// use curvlay_examples::nalgebra::{Point3, UnitVector3, Vector3};
/// let lean = UnitVector3::new_normalize(Vector3::new(1.0, 0.0, 1.0));
/// let pose = frame_at(Point3::new(1.0, 2.0, 3.0), lean);
/// assert!((direction_of(&pose).into_inner() - lean.into_inner()).norm() < 1e-12 && pose.rotation.k == 0.0);
/// ```
pub fn frame_at(tip: Point3<f64>, direction: UnitVector3<f64>) -> Isometry3<f64> {
    // (w, i, j) = (1 + z, -y, x), normalised; near straight down its length comes from i and j, which keep their digits.
    let (x, y, z) = (direction.x, direction.y, direction.z);
    let across = x.hypot(y);
    // 1 + z without cancellation below the plane.
    let upright = if z >= 0.0 { 1.0 + z } else { across * across / (1.0 - z) };
    let quaternion = Quaternion::new(upright, -y, x, 0.0);
    let turn = match UnitQuaternion::try_new(quaternion, 0.0) {
        Some(turn) => turn,
        None => UnitQuaternion::from_quaternion(Quaternion::new(0.0, 1.0, 0.0, 0.0)),
    };
    Isometry3::from_parts(Translation3::from(tip.coords), turn)
}

/// The direction of a nozzle, from its tip into it.
pub fn direction_of(pose: &Isometry3<f64>) -> UnitVector3<f64> {
    UnitVector3::new_normalize(pose.rotation * Vector3::z())
}
