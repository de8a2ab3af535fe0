//! The surface of a layer.

use nalgebra::{Point3, Vector3};

/// The surface of a layer and how thick the layer is.
#[derive(Clone, Copy, Debug)]
pub struct LayerSurface<'a> {
    /// Points in millimetres: the surface runs through the middle of the layer.
    pub vertices: &'a [Point3<f64>],
    /// Triangles, counter-clockwise seen from where the growth goes. None where nothing is left of a layer.
    pub triangles: &'a [[u32; 3]],
    /// Thickness of the layer at each triangle, in millimetres.
    pub thickness: &'a [f64],
    /// Whether it lies half way between two layers, in places where those are too far apart. It is no layer of its own for skins, and for the way in which infill
    /// turns from layer to layer.
    pub is_half: bool,
}

impl<'a> From<(&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64])> for LayerSurface<'a> {
    /// Vertices, triangles, thickness.
    fn from((vertices, triangles, thickness): (&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64])) -> Self {
        LayerSurface { vertices, triangles, thickness, is_half: false }
    }
}

impl<'a> From<(&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64], bool)> for LayerSurface<'a> {
    /// Vertices, triangles, thickness, and whether it is a half layer.
    fn from((vertices, triangles, thickness, is_half): (&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64], bool)) -> Self {
        LayerSurface { vertices, triangles, thickness, is_half }
    }
}

impl LayerSurface<'_> {
    /// The points of the top of the layer: each vertex half of the thickness around it up, along the mean normal of its triangles by area.
    /// A vertex of no triangle stays; a triangle with a vertex that is not there, or without a thickness, counts for nothing.
    ///
    /// # Cost
    /// `O(n)` for `n` triangles.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::layer::LayerSurface;
    /// let vertices = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]].map(Point3::from);
    /// let surface = LayerSurface { vertices: &vertices, triangles: &[[0, 1, 2]], thickness: &[0.6], is_half: false };
    /// assert!(surface.top().iter().all(|top| (top.z - 1.3).abs() < 1e-12));
    /// ```
    pub fn top(&self) -> Vec<Point3<f64>> {
        // Normal, area, and thickness by area, around each vertex.
        let mut around = vec![(Vector3::zeros(), 0.0, 0.0); self.vertices.len()];
        for (corners, [a, b, c], thickness) in self.whole() {
            let normal = (b - a).cross(&(c - a));
            for &corner in corners {
                let (sum, area, heights) = &mut around[corner as usize];
                *sum += normal;
                *area += normal.norm();
                *heights += normal.norm() * thickness;
            }
        }
        let lifted = |(vertex, (normal, area, heights)): (&Point3<f64>, &(Vector3<f64>, f64, f64))| {
            let up = normal.try_normalize(f64::MIN_POSITIVE).unwrap_or(Vector3::zeros());
            vertex + up * if *area > 0.0 { 0.5 * heights / area } else { 0.0 }
        };
        self.vertices.iter().zip(&around).map(lifted).collect()
    }

    /// Area by thickness, in cubic millimetres.
    pub(crate) fn volume(&self) -> f64 {
        self.whole().map(|(_, [a, b, c], thickness)| (b - a).cross(&(c - a)).norm() / 2.0 * thickness).sum()
    }

    /// The triangles that have all their vertices, with these and their thickness.
    fn whole(&self) -> impl Iterator<Item = (&[u32; 3], [Point3<f64>; 3], f64)> {
        let at = |corner: u32| self.vertices.get(corner as usize).copied();
        self.triangles.iter().zip(self.thickness).filter_map(move |(corners, &thickness)| {
            let [a, b, c] = *corners;
            Some((corners, [at(a)?, at(b)?, at(c)?], thickness))
        })
    }
}
