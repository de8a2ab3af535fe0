//! A mesh and its patch in the plane.

use super::energy::{conformal, in_plane, rigid, twice_area};
use super::error::UnrollError;
use super::patch::{Patch, upper_patch};
use crate::drawing::polygon::{shapes_area, union};
use crate::drawing::surface::{Distortion, MeshSurface, Surface, SurfacePoint};
use nalgebra::{Complex, Matrix2, Point2, Point3, Vector3};

/// What a map keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UnrollKind {
    /// Angles: the design looks right everywhere, and changes its size.
    Conformal,
    /// Lengths, as well as possible: isometric on cones and cylinders.
    #[default]
    Rigid,
}

/// How a patch is unrolled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnrollOptions {
    /// What the map keeps. Default: lengths.
    pub kind: UnrollKind,
    /// The patch ends this far from the axis, in millimetres. Default: to the end of what looks up.
    pub reach: f64,
    /// Most rounds for [`UnrollKind::Rigid`]. Default 500.
    pub max_rounds: u32,
    /// They end when the energy falls by a smaller share. Default 1e-6: coordinates then change by less than a thousandth of what they
    /// are distorted by.
    pub tolerance: f64,
}

impl Default for UnrollOptions {
    fn default() -> Self {
        UnrollOptions { kind: UnrollKind::Rigid, reach: f64::INFINITY, max_rounds: 500, tolerance: 1e-6 }
    }
}

/// A mesh whose upper side is unrolled into the plane of the drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct UnrolledMesh {
    whole: MeshSurface,
    /// The patch, and the same triangles in the plane.
    solid: MeshSurface,
    flat: MeshSurface,
    distortion: Distortion,
    rounds: u32,
    fell: f64,
}

/// Area that may be covered twice by rounding, as a share.
const OVERLAP: f64 = 1e-6;

impl UnrolledMesh {
    /// Unrolls the triangles that look up and hang together with the one under the z axis (of several the highest).
    ///
    /// # Errors
    /// [`UnrollError`] names the vertex or triangle.
    ///
    /// # Cost
    /// For `n` triangles `O(n log n)`, two factorisations of sparse systems, and `O(n)` a round.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::drawing::{Projection, UnrollOptions, UnrolledMesh};
    /// use curvlay_toolpath::nalgebra::{Point2, Point3};
    /// // A roof with a slope of 3/4: sides of 4 mm are 5 mm long.
    /// let at = |x: f64, y: f64| Point3::new(x, y, 9.0 - 0.75 * x.abs());
    /// let roof = [at(-4.0, -9.0), at(0.0, -9.0), at(4.0, -9.0), at(4.0, 9.0), at(0.0, 9.0), at(-4.0, 9.0)];
    /// let mesh = UnrolledMesh::new(&roof, &[[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]], UnrollOptions::default())?;
    /// let ridge = Projection::Unrolled.of(&mesh, &Point2::origin()).ok_or("beside it")?;
    /// assert!((ridge.position - at(0.0, 0.0)).norm() < 1e-9 && mesh.distortion().largest < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]], options: UnrollOptions) -> Result<Self, UnrollError> {
        let whole = MeshSurface::new(vertices, triangles)?;
        let checked = [("reach", options.reach, f64::INFINITY), ("tolerance", options.tolerance, f64::MAX)];
        if let Some((what, value, _)) = checked.into_iter().find(|(_, value, most)| !(*value > 0.0 && value <= most)) {
            return Err(UnrollError::Option { what, value });
        }
        let (pole, weights) = whole.locate(&Point2::origin()).ok_or(UnrollError::NoPole)?;
        let patch = upper_patch(vertices, triangles, pole, options.reach)?;
        let shapes: Vec<[Complex<f64>; 3]> = (0..patch.triangles.len()).map(|t| in_plane(&patch, t)).collect();
        let first = conformal(&patch, &shapes).ok_or(UnrollError::Singular)?;
        let (u, rounds, fell) = match options.kind {
            UnrollKind::Conformal => (first, 0, 0.0),
            UnrollKind::Rigid => {
                rigid(&patch, &shapes, first, options.max_rounds, options.tolerance).ok_or(UnrollError::Singular)?
            }
        };
        let mut map = Map { patch: &patch, shapes: &shapes, u };
        map.centre(triangles[pole].map(|v| vertices[v as usize]), pole, weights)?;
        map.align();
        map.check_one_to_one()?;

        let distortion = map.distortion();
        let own: Vec<[u32; 3]> = patch.triangles.iter().map(|corners| corners.map(|v| v as u32)).collect();
        let plane: Vec<Point3<f64>> = map.u.iter().map(|value| Point3::new(value.re, value.im, 0.0)).collect();
        let solid = MeshSurface::new(&patch.vertices, &own)?;
        let flat = MeshSurface::new(&plane, &own)?;
        Ok(UnrolledMesh { whole, solid, flat, distortion, rounds, fell })
    }

    /// The distortion over the triangles of the patch, from the plane to the mesh; the mean is by area.
    pub fn distortion(&self) -> Distortion {
        self.distortion
    }

    /// Rounds of the iteration, and by what share the energy fell in the last one.
    pub fn rounds(&self) -> (u32, f64) {
        (self.rounds, self.fell)
    }
}

/// A patch and its image in the plane.
struct Map<'a> {
    patch: &'a Patch,
    /// Each triangle in a plane of its own, as long and as wide as on the mesh.
    shapes: &'a [[Complex<f64>; 3]],
    /// Of each vertex.
    u: Vec<Complex<f64>>,
}

impl Map<'_> {
    /// The image of a triangle.
    fn image(&self, corners: &[usize; 3]) -> [Complex<f64>; 3] {
        corners.map(|v| self.u[v])
    }

    /// Moves the point under the axis into the origin: that with these weights in the triangle `pole` of the mesh, whose corners are `at`.
    fn centre(&mut self, at: [Point3<f64>; 3], pole: usize, weights: [f64; 3]) -> Result<(), UnrollError> {
        let place = self.patch.numbers.iter().position(|&t| t == pole).ok_or(UnrollError::NoPole)?;
        // The corners of the patch's triangle keep the order of the mesh, or come as (0, 2, 1).
        let corners = self.patch.triangles[place];
        let middle: Complex<f64> = (0..3)
            .map(|k| {
                let own = corners.iter().find(|&&v| self.patch.vertices[v] == at[k]);
                self.u[own.copied().unwrap_or(corners[k])] * weights[k]
            })
            .sum();
        self.u.iter_mut().for_each(|value| *value -= middle);
        Ok(())
    }

    /// Turns the image so that it lies on its own view from above as well as it can: both maps leave the turn free.
    fn align(&mut self) {
        let mut turn = Complex::new(0.0, 0.0);
        for (corners, shape) in self.patch.triangles.iter().zip(self.shapes) {
            for &v in corners {
                let from_above = Complex::new(self.patch.vertices[v].x, self.patch.vertices[v].y);
                turn += from_above * self.u[v].conj() * twice_area(*shape);
            }
        }
        if turn.norm() > 0.0 {
            let turn = turn / turn.norm();
            self.u.iter_mut().for_each(|value| *value *= turn);
        }
    }

    /// Refuses an image that lies on itself: a place of the drawing would have two places on the mesh. Triangles upside down are a fold; without
    /// a fold the image may still come round onto itself, which shows in its area.
    fn check_one_to_one(&self) -> Result<(), UnrollError> {
        let upside_down = |corners: &&[usize; 3]| {
            let area = twice_area(self.image(corners));
            area.is_nan() || area <= 0.0
        };
        let triangles = &self.patch.triangles;
        let count = triangles.iter().filter(upside_down).count();
        if let Some(t) = triangles.iter().position(|corners| upside_down(&corners)) {
            return Err(UnrollError::Flipped { triangle: self.patch.numbers[t], count });
        }
        let ring = |corners: &[usize; 3]| self.image(corners).map(|u| [u.re, u.im]).to_vec();
        let rings: Vec<Vec<[f64; 2]>> = triangles.iter().map(ring).collect();
        let sum: f64 = triangles.iter().map(|corners| 0.5 * twice_area(self.image(corners))).sum();
        let mm2 = sum - shapes_area(&union(&rings));
        if mm2 > OVERLAP * sum { Err(UnrollError::Overlap { mm2 }) } else { Ok(()) }
    }

    /// How much triangles are stretched; the mean is by their area on the mesh.
    fn distortion(&self) -> Distortion {
        let mut distortion = Distortion { points: self.patch.triangles.len(), ..Distortion::default() };
        let mut area = 0.0;
        for (corners, shape) in self.patch.triangles.iter().zip(self.shapes) {
            let here = stretch(self.image(corners), *shape);
            distortion.largest = distortion.largest.max(here);
            distortion.mean += here * twice_area(*shape);
            area += twice_area(*shape);
        }
        distortion.mean /= area;
        distortion
    }
}

/// `max(s1, 1 / s2) - 1` of the map from a triangle of the plane to its shape.
fn stretch(plane: [Complex<f64>; 3], shape: [Complex<f64>; 3]) -> f64 {
    let columns = |c: [Complex<f64>; 3]| {
        let (a, b) = (c[1] - c[0], c[2] - c[0]);
        Matrix2::new(a.re, b.re, a.im, b.im)
    };
    let inverse = columns(plane).try_inverse().unwrap_or_else(Matrix2::zeros);
    let values = (columns(shape) * inverse).singular_values();
    values.max().max(1.0 / values.min()) - 1.0
}

impl Surface for UnrolledMesh {
    fn hit(&self, from: &Point3<f64>, direction: &Vector3<f64>) -> Option<SurfacePoint> {
        self.whole.hit(from, direction)
    }

    fn over(&self, at: &Point2<f64>) -> Option<SurfacePoint> {
        self.whole.over(at)
    }

    fn unrolled(&self, at: &Point2<f64>) -> Option<SurfacePoint> {
        let (triangle, weights) = self.flat.locate(at)?;
        self.solid.weighted(triangle, weights)
    }

    fn is_unrolled(&self) -> bool {
        true
    }
}
