//! Planes, on which side of them a point lies (exactly), and coordinates in them.

use crate::trim::exact::{grow, sign, two_product};
use nalgebra::{Point2, Point3, Vector3};

/// A plane: the points `p` with `normal . p = offset`. Above is where the normal points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPlane {
    normal: Vector3<f64>,
    offset: f64,
}

/// Why there is no such plane.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlaneError {
    /// The normal has no length, or a number is infinite or not a number.
    #[error("a plane with the normal ({}, {}, {}) and the offset {offset} does not exist", .normal[0], .normal[1], .normal[2])]
    Unusable {
        /// The normal.
        normal: [f64; 3],
        /// The offset.
        offset: f64,
    },
}

/// How near to an axis a normal of length 1 is taken for the axis: some hundred roundings. Planes that the caller means to be
/// level or upright then hold the vertices on them exactly; a plane that really leans by so little is moved by 1e-12 of the
/// part's size.
const ON_AXIS: f64 = 1e-12;

impl CutPlane {
    /// The plane through a point. The normal may have any length; it becomes 1.
    ///
    /// # Errors
    /// [`PlaneError`] for a normal without length, or numbers that are not finite.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::nalgebra::{Point3, Vector3};
    /// use curvlay_layers::planar::CutPlane;
    /// let plane = CutPlane::through(&Point3::new(0.0, 0.0, 3.0), &Vector3::new(0.0, 0.0, 2.0))?;
    /// assert_eq!((plane.offset(), plane.side(&Point3::new(9.0, 9.0, 3.0))), (3.0, 0));
    /// # Ok::<(), curvlay_layers::planar::PlaneError>(())
    /// ```
    pub fn through(point: &Point3<f64>, normal: &Vector3<f64>) -> Result<Self, PlaneError> {
        let unit = normal.try_normalize(0.0).filter(|unit| unit.iter().all(|c| c.is_finite()));
        let unusable = || PlaneError::Unusable { normal: (*normal).into(), offset: point.coords.dot(normal) };
        let unit = snapped(unit.ok_or_else(unusable)?);
        let offset = point.coords.dot(&unit);
        if offset.is_finite() { Ok(CutPlane { normal: unit, offset }) } else { Err(unusable()) }
    }

    /// The direction that is above, of length 1.
    pub fn normal(&self) -> Vector3<f64> {
        self.normal
    }

    /// How far the plane lies from the origin along its normal.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// The same plane, moved along its normal.
    pub fn moved(&self, by: f64) -> Self {
        CutPlane { normal: self.normal, offset: self.offset + by }
    }

    /// How far above the plane a point lies, with rounding.
    pub fn height(&self, p: &Point3<f64>) -> f64 {
        self.normal.dot(&p.coords) - self.offset
    }

    /// On which side a point lies: 1 above, -1 below, 0 in the plane. Exact for the numbers of the plane and the point.
    pub fn side(&self, p: &Point3<f64>) -> i8 {
        let terms = [self.normal.x * p.x, self.normal.y * p.y, self.normal.z * p.z];
        let height = terms[0] + terms[1] + terms[2] - self.offset;
        // A rounding in each of three products and three sums: at most six half units of the sum of the terms.
        let bound = 4.0 * f64::EPSILON * (terms.iter().map(|term| term.abs()).sum::<f64>() + self.offset.abs());
        if height.abs() > bound {
            return sign(height);
        }
        let mut sum = Vec::with_capacity(8);
        for k in 0..3 {
            two_product(self.normal[k], p[k]).into_iter().for_each(|term| grow(&mut sum, term));
        }
        grow(&mut sum, -self.offset);
        sum.last().map_or(0, |&largest| sign(largest))
    }
}

fn snapped(unit: Vector3<f64>) -> Vector3<f64> {
    for axis in 0..3 {
        if (0..3).all(|k| k == axis || unit[k].abs() < ON_AXIS) {
            let mut exact = Vector3::zeros();
            exact[axis] = unit[axis].signum();
            return exact;
        }
    }
    unit
}

/// Coordinates in a plane: `u`, `v` and the plane's normal are a right-handed frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneFrame {
    /// Where both coordinates are 0.
    pub origin: Point3<f64>,
    /// Direction of the first coordinate, of length 1.
    pub u: Vector3<f64>,
    /// Direction of the second coordinate, of length 1.
    pub v: Vector3<f64>,
}

impl PlaneFrame {
    /// The frame whose origin is the foot of the perpendicular from the world's origin. For a level plane `u` and `v` are x and
    /// y; for an upright one `u` is level and `v` is z.
    pub fn of(plane: &CutPlane) -> Self {
        let n = plane.normal;
        let u = if n.z.abs() > 0.999_999 { Vector3::x() } else { Vector3::z().cross(&n) };
        let u = (u - n * u.dot(&n)).normalize();
        let frame = PlaneFrame { origin: Point3::from(n * plane.offset), u, v: n.cross(&u) };
        PlaneFrame { u: snapped(frame.u), v: snapped(frame.v), ..frame }
    }

    /// Coordinates of a point, or of its foot in the plane.
    pub fn flat(&self, p: &Point3<f64>) -> Point2<f64> {
        let d = p - self.origin;
        Point2::new(d.dot(&self.u), d.dot(&self.v))
    }

    /// The place of coordinates.
    pub fn place(&self, p: &Point2<f64>) -> Point3<f64> {
        self.origin + self.u * p.x + self.v * p.y
    }
}
