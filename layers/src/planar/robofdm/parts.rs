//! Parts as they are printed.

use super::audited::AuditedPart;
use crate::planar::{CutPlane, Solid};
use nalgebra::Vector3;

/// A part as it is printed.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintedPart {
    /// Its closed mesh.
    pub solid: Solid,
    /// The direction in which it is printed, of length 1.
    pub direction: Vector3<f64>,
    /// The plane on which it is printed; none for one that stands on the platform.
    pub base: Option<CutPlane>,
    /// Area of its surface that is risky, in mm2.
    pub risky_mm2: f64,
    /// Area that it shares with earlier parts, in mm2.
    pub seam_mm2: f64,
    /// The earlier parts that it touches, by rising number.
    pub on: Vec<usize>,
    /// What it shares with each of them.
    pub seams: Vec<Seam>,
}

/// Where a part is joined to an earlier one: the weak place of a print (section 2.5 of the dissertation).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// The earlier part.
    pub on: usize,
    /// Its area, in mm2.
    pub area_mm2: f64,
    /// The mean of its normals from the earlier part to the later one, of length 1; zero where they cancel.
    pub normal: Vector3<f64>,
}

impl Seam {
    /// Angle between a load and the normal of the seam, in radians, at most a right one: at 0 the load pulls the parts straight off each
    /// other, at a right angle it shears them. `None` for a load or a normal without length.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::nalgebra::Vector3;
    /// use curvlay_layers::planar::robofdm::Seam;
    /// let seam = Seam { on: 0, area_mm2: 9.0, normal: Vector3::x() };
    /// assert!((seam.load_angle(&Vector3::new(-2.0, 2.0, 0.0)).unwrap().to_degrees() - 45.0).abs() < 1e-12);
    /// assert_eq!(seam.load_angle(&Vector3::zeros()), None);
    /// ```
    pub fn load_angle(&self, load: &Vector3<f64>) -> Option<f64> {
        let is_one = |v: &Vector3<f64>| v.norm() > 0.0 && v.norm().is_finite();
        let angle = self.normal.cross(load).norm().atan2(self.normal.dot(load).abs());
        (is_one(load) && is_one(&self.normal)).then_some(angle)
    }
}

impl PrintedPart {
    /// As an audit takes it.
    pub fn audited(&self) -> AuditedPart<'_> {
        AuditedPart { solid: &self.solid, direction: self.direction, on_platform: self.base.is_none() }
    }
}
