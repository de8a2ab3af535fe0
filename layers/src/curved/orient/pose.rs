//! Poses to choose from.
//!
//! Directions on the sphere: R. Swinbank, R. J. Purser, "Fibonacci grids: a novel approach to global modelling", Q. J. R. Meteorol.
//! Soc. 132, 2006, section 3: heights in equal steps, turned by the golden angle from one to the next.

use super::body::Body;
use super::{OrientOptions, PoseError};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use std::convert::Infallible;
use std::f64::consts::PI;

/// Why a pose was proposed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum PoseKind {
    /// As the mesh is given.
    Given,
    /// The part rests on a face of its hull.
    Resting,
    /// One of the directions spread over the sphere.
    Sampled,
}

/// How a part may lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The direction in the frame of the mesh that points away from the plate.
    pub up: Unit<Vector3<f64>>,
    /// Why it was proposed.
    pub kind: PoseKind,
    /// By what angle the part must be tipped until it falls, in radians: 0 where it falls by itself.
    pub tipping: f64,
}

impl Pose {
    /// The rotation that turns the part so that [`Pose::up`] points along z: the shortest one.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::curved::orient::{Pose, PoseKind};
    /// use curvlay_layers::nalgebra::Vector3;
    /// let pose = Pose { up: -Vector3::z_axis(), kind: PoseKind::Sampled, tipping: 0.0 };
    /// assert!((pose.rotation() * Vector3::new(1.0, 2.0, 3.0) - Vector3::new(1.0, -2.0, -3.0)).norm() < 1e-12);
    /// ```
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        upright(&self.up)
    }

    /// The vertices of the part in this pose: turned about the middle of their box, the lowest of them at z = 0.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::curved::orient::{Pose, PoseKind};
    /// use curvlay_layers::nalgebra::{Point3, Vector3};
    /// let pose = Pose { up: Vector3::x_axis(), kind: PoseKind::Sampled, tipping: 0.0 };
    /// let laid = pose.lay(&[Point3::new(1.0, 0.0, 0.0), Point3::new(4.0, 0.0, 0.0)]);
    /// assert!((laid[0] - Point3::new(2.5, 0.0, 0.0)).norm() < 1e-12 && (laid[1].z - 3.0).abs() < 1e-12);
    /// ```
    pub fn lay(&self, vertices: &[Point3<f64>]) -> Vec<Point3<f64>> {
        let Some(&first) = vertices.first() else { return Vec::new() };
        let (low, high) = vertices.iter().fold((first, first), |(low, high), at| (low.inf(at), high.sup(at)));
        let (middle, turn) = (nalgebra::center(&low, &high), self.rotation());
        let is_turned = self.up != Vector3::z_axis();
        let turned = |at: &Point3<f64>| if is_turned { middle + turn * (at - middle) } else { *at };
        let mut laid: Vec<_> = vertices.iter().map(turned).collect();
        let lowest = laid.iter().map(|at| at.z).fold(f64::INFINITY, f64::min);
        laid.iter_mut().for_each(|at| at.z -= lowest);
        laid
    }
}

/// The shortest rotation that turns `up` to z; half a turn about x for the opposite of z.
pub(super) fn upright(up: &Unit<Vector3<f64>>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between_axis(up, &Vector3::z_axis())
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI))
}

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
