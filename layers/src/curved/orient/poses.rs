//! Poses to choose from.
//!
//! Directions on the sphere: R. Swinbank, R. J. Purser, "Fibonacci grids: a novel approach to global modelling", Q. J. R. Meteorol.
//! Soc. 132, 2006, section 3: heights in equal steps, turned by the golden angle from one to the next.

use super::body::Body;
use super::pose::{Pose, PoseKind};
use super::{OrientOptions, PoseError};
use nalgebra::{Point3, Unit, Vector3};
use std::convert::Infallible;
use std::f64::consts::PI;

/// The poses of a part to choose from: the given one, the [resting](PoseKind::Resting) ones, the firmest first, and
/// [`OrientOptions::directions`] spread over the sphere.
///
/// # Arguments
/// * `vertices`, `triangles`: the mesh in millimetres, with z up as given. Its facets look outwards, or all inwards.
///
/// # Errors
/// [`PoseError`] for a mesh without triangles, with an invalid coordinate or index, or without volume, and for options out of
/// range.
///
/// # Cost
/// That of the convex hull, and one look at its corners for each pose: some milliseconds for 100,000 triangles. One thread.
///
/// # Example
/// ```
/// use curvlay_layers::curved::orient::{OrientOptions, PoseKind, poses};
/// use curvlay_layers::nalgebra::Point3;
/// // A tetrahedron with legs of 3 mm rests on each of its four faces.
/// let vertices = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]].map(Point3::from);
/// let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// let found = poses(&vertices, &triangles, &OrientOptions::default())?;
/// assert_eq!(found.iter().filter(|pose| pose.kind == PoseKind::Resting).count(), 4);
/// assert_eq!(found.len(), 1 + 4 + 300);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn poses(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    options: &OrientOptions,
) -> Result<Vec<Pose>, PoseError<Infallible>> {
    options.check()?;
    let body = Body::new(vertices, triangles)?;
    let OrientOptions { directions, min_tipping, contact, min_apart, .. } = *options;
    let by_itself = |up: Unit<Vector3<f64>>, kind| Pose { up, kind, tipping: body.tipping(&up, contact) };
    let resting = body.resting(contact, min_tipping, min_apart).into_iter();
    let resting = resting.map(|(up, tipping)| Pose { up, kind: PoseKind::Resting, tipping });
    let sampled = (0..directions).map(|k| by_itself(fibonacci(k, directions), PoseKind::Sampled));
    let given = by_itself(Vector3::z_axis(), PoseKind::Given);
    Ok(std::iter::once(given).chain(resting).chain(sampled).collect())
}

/// Direction `k` of `count` on the sphere.
fn fibonacci(k: u32, count: u32) -> Unit<Vector3<f64>> {
    let golden_angle = PI * (3.0 - 5f64.sqrt());
    let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
    let (sin, cos) = (golden_angle * f64::from(k)).sin_cos();
    let radius = (1.0 - z * z).sqrt();
    Unit::new_normalize(Vector3::new(radius * cos, radius * sin, z))
}
