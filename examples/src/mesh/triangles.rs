//! Triangles over vertices.

use super::fault::MeshFault;
use curvlay_voxel::{OrientReport, Oriented, orient};
use nalgebra::Point3;

/// Triangles over vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners, each place once.
    pub vertices: Vec<Point3<f64>>,
    /// Numbers of the corners, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Least and greatest coordinates; `None` without vertices.
    pub fn bounds(&self) -> Option<[Point3<f64>; 2]> {
        let first = *self.vertices.first()?;
        let grow = |[low, high]: [Point3<f64>; 2], p: &Point3<f64>| [low.inf(p), high.sup(p)];
        Some(self.vertices.iter().fold([first, first], grow))
    }

    /// Area of all triangles.
    pub fn area(&self) -> f64 {
        self.corners().map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0).sum()
    }

    /// Volume that the triangles enclose, whichever way they look; overlaps count twice.
    pub fn volume(&self) -> f64 {
        self.corners().map(|[a, b, c]| a.coords.dot(&b.coords.cross(&c.coords)) / 6.0).sum::<f64>().abs()
    }

    fn corners(&self) -> impl Iterator<Item = [Point3<f64>; 3]> {
        self.triangles.iter().map(|triangle| triangle.map(|corner| self.vertices[corner as usize]))
    }

    /// Turns triangles so that neighbours agree and all look outwards: to be done before anything else.
    ///
    /// # Returns
    /// What was done; its `Display` is a line for the user.
    ///
    /// # Errors
    /// [`MeshFault::Orientation`] for a surface that has no outside.
    pub fn orient(&mut self) -> Result<OrientReport, MeshFault> {
        let Oriented { triangles, report } = orient(&self.vertices, &self.triangles)?;
        self.triangles = triangles;
        Ok(report)
    }

    /// The same mesh after [`Mesh::orient`].
    ///
    /// # Errors
    /// As [`Mesh::orient`].
    pub fn oriented(mut self) -> Result<Self, MeshFault> {
        self.orient()?;
        Ok(self)
    }

    /// How far apart single-precision numbers lie at the largest coordinate, if all coordinates are such numbers (as
    /// in binary STL): the shape is no finer than that.
    pub fn float32_spacing(&self) -> Option<f64> {
        let mut largest = 0.0_f32;
        for &c in self.vertices.iter().flat_map(Point3::iter) {
            let single = c as f32;
            if f64::from(single).to_bits() != c.to_bits() {
                return None;
            }
            largest = largest.max(single.abs());
        }
        Some(f64::from(largest.next_up()) - f64::from(largest)).filter(|spacing| spacing.is_finite())
    }
}
