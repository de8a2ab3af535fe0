//! Risky area: faces that lean over too far to be printed without support.
//!
//! Dai 2020 (C. Dai, *Material Deposition in 3D Space*, TU Delft), Eq. 2.1: a face with normal `n` is safe for the direction
//! `d` if `n . d + sin(alpha_max) >= 0`, after K. Hu, S. Jin and C. C. L. Wang, "Support slimming for single material based
//! additive manufacturing", Computer-Aided Design 65, 2015.

use super::mesh::{Solid, doubled_normal};
use nalgebra::Vector3;

/// Why there is no risky area.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OverhangError {
    /// The self-support angle is not between 0 and 90 degrees.
    #[error("the self-support angle is {} degrees; it must be above 0 and below 90", .angle.to_degrees())]
    Angle {
        /// The angle in radians.
        angle: f64,
    },
    /// The direction has no length.
    #[error("the printing direction has no length")]
    Direction,
}

/// The faces that are risky (Eq. 2.1), by rising number.
///
/// # Arguments
/// * `direction`: that of printing; any length.
/// * `max_angle`: the self-support angle in radians: how far a face may lean over from upright.
/// * `base`: faces that lie in this plane (all corners within `base.1` below or above it) and look down are the base, and safe.
///
/// # Errors
/// [`OverhangError`] for an angle of 0, of 90 degrees, or beyond, and for a direction without length.
pub fn risky_faces(
    solid: &Solid,
    direction: &Vector3<f64>,
    max_angle: f64,
    base: Option<(f64, f64)>,
) -> Result<Vec<usize>, OverhangError> {
    if !(max_angle > 0.0 && max_angle < std::f64::consts::FRAC_PI_2) {
        return Err(OverhangError::Angle { angle: max_angle });
    }
    let unit = direction
        .try_normalize(0.0)
        .filter(|unit| unit.iter().all(|c| c.is_finite()))
        .ok_or(OverhangError::Direction)?;
    let limit = -max_angle.sin();
    let is_risky = |&face: &usize| {
        let corners = solid.corners(face);
        let normal = doubled_normal(corners);
        let on_base =
            base.is_some_and(|(height, within)| corners.iter().all(|p| (p.coords.dot(&unit) - height).abs() <= within));
        normal.dot(&unit) < limit * normal.norm() && !on_base
    };
    Ok((0..solid.triangles().len()).filter(is_risky).collect())
}

/// The area of the faces that are risky: see [`risky_faces`].
///
/// # Errors
/// As [`risky_faces`].
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::Vector3;
/// use curvlay_layers::planar::{Solid, risky_area};
/// let tetrahedron = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]].map(Into::into);
/// let solid = Solid::new(&tetrahedron, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
/// let angle = 45_f64.to_radians();
/// assert_eq!(risky_area(&solid, &Vector3::z(), angle, None)?, 2.0); // the face that looks down
/// assert_eq!(risky_area(&solid, &Vector3::z(), angle, Some((0.0, 1e-6)))?, 0.0); // it is the base
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn risky_area(
    solid: &Solid,
    direction: &Vector3<f64>,
    max_angle: f64,
    base: Option<(f64, f64)>,
) -> Result<f64, OverhangError> {
    let faces = risky_faces(solid, direction, max_angle, base)?;
    Ok(faces.into_iter().map(|face| doubled_normal(solid.corners(face)).norm() / 2.0).sum())
}
