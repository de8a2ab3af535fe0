//! A triangle mesh as a surface.

use super::{Surface, SurfacePoint};
use nalgebra::{Point2, Point3, UnitVector3, Vector3};

/// A triangle mesh that carries a drawing, seen from above, with normals smooth across its edges.
///
/// Rays go through columns of a grid over the plane, so a point costs the triangles over its cell.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshSurface {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[usize; 3]>,
    normals: Vec<Vector3<f64>>,
    low: Point2<f64>,
    cell: f64,
    size: [usize; 2],
    cells: Vec<Vec<u32>>,
}

/// Why a mesh cannot carry a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshSurfaceError {
    /// There is no triangle.
    #[error("the mesh has no triangle")]
    Empty,
    /// A vertex is not finite, or too far away.
    #[error("vertex {vertex} is not finite, or beyond 1e6 mm")]
    Vertex {
        /// The vertex.
        vertex: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names a vertex that is not there")]
    Triangle {
        /// The triangle.
        triangle: usize,
    },
}

/// Cells along the longer side of the grid at most.
const MAX_CELLS: f64 = 1000.0;

impl MeshSurface {
    /// # Errors
    /// [`MeshSurfaceError`] names the vertex or triangle.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::drawing::{MeshSurface, Surface};
    /// use curvlay_toolpath::nalgebra::{Point2, Point3};
    /// let corners = [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 5.0]].map(Point3::from);
    /// let roof = MeshSurface::new(&corners, &[[0, 1, 2]])?;
    /// let hit = roof.over(&Point2::new(1.0, 1.0)).ok_or("beside it")?;
    /// assert!((hit.position.z - 2.0).abs() < 1e-12 && (hit.normal.y + 0.5f64.sqrt()).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self, MeshSurfaceError> {
        if let Some(vertex) = vertices.iter().position(|v| !v.coords.iter().all(|x| x.abs() <= 1e6)) {
            return Err(MeshSurfaceError::Vertex { vertex });
        }
        let triangles: Vec<[usize; 3]> = triangles.iter().map(|corners| corners.map(|v| v as usize)).collect();
        if let Some(triangle) = triangles.iter().position(|corners| corners.iter().any(|&v| v >= vertices.len())) {
            return Err(MeshSurfaceError::Triangle { triangle });
        }
        if triangles.is_empty() {
            return Err(MeshSurfaceError::Empty);
        }
        // Twice the area in the length of the normal: large triangles decide.
        let mut normals = vec![Vector3::zeros(); vertices.len()];
        for &[a, b, c] in &triangles {
            let normal = (vertices[b] - vertices[a]).cross(&(vertices[c] - vertices[a]));
            // Whichever way the triangle looks, the drawing is on its upper side.
            let normal = if normal.z < 0.0 { -normal } else { normal };
            [a, b, c].into_iter().for_each(|v| normals[v] += normal);
        }
        let used = || triangles.iter().flatten().map(|&v| vertices[v].xy());
        let start = (Point2::from([f64::INFINITY; 2]), Point2::from([f64::NEG_INFINITY; 2]));
        let (low, high) = used().fold(start, |(low, high), p| (low.inf(&p), high.sup(&p)));
        // About a triangle a cell.
        let area = ((high.x - low.x) * (high.y - low.y) / triangles.len() as f64).sqrt();
        let longest = (high.x - low.x).max(high.y - low.y).max(1e-6);
        let cell = area.max(longest / MAX_CELLS);
        let size = [high.x - low.x, high.y - low.y].map(|side| (side / cell).floor() as usize + 1);
        let mut surface = MeshSurface {
            vertices: vertices.to_vec(),
            normals,
            low,
            cell,
            size,
            cells: vec![Vec::new(); size[0] * size[1]],
            triangles,
        };
        for (number, corners) in surface.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|v| surface.vertices[v].xy());
            let (from, to) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
            let ([x0, y0], [x1, y1]) = (surface.clamped(&from), surface.clamped(&to));
            for y in y0..=y1 {
                for x in x0..=x1 {
                    surface.cells[x + size[0] * y].push(number as u32);
                }
            }
        }
        Ok(surface)
    }

    fn clamped(&self, at: &Point2<f64>) -> [usize; 2] {
        let cell = |value: f64, axis: usize| ((value.max(0.0) / self.cell) as usize).min(self.size[axis] - 1);
        [cell(at.x - self.low.x, 0), cell(at.y - self.low.y, 1)]
    }

    /// The uppermost triangle over a point of the plane, and the weights of its corners there.
    pub(super) fn locate(&self, at: &Point2<f64>) -> Option<(usize, [f64; 3])> {
        if !(at.x.is_finite() && at.y.is_finite()) {
            return None;
        }
        let [x, y] = self.clamped(at);
        let from = Point3::new(at.x, at.y, 0.0);
        let down = -Vector3::z();
        let hits = self.cells[x + self.size[0] * y].iter();
        let hits = hits.filter_map(|&t| Some((t as usize, self.through(t as usize, &from, &down)?)));
        let (triangle, (_, weights)) = hits.min_by(|a, b| a.1.0.total_cmp(&b.1.0).then(a.0.cmp(&b.0)))?;
        Some((triangle, weights))
    }

    /// The point of a triangle with these weights of its corners.
    pub(super) fn weighted(&self, triangle: usize, weights: [f64; 3]) -> Option<SurfacePoint> {
        self.at(self.triangles[triangle], weights)
    }

    /// The point with these weights of the corners.
    fn at(&self, corners: [usize; 3], weights: [f64; 3]) -> Option<SurfacePoint> {
        let sum =
            |of: &dyn Fn(usize) -> Vector3<f64>| (0..3).map(|k| of(corners[k]) * weights[k]).sum::<Vector3<f64>>();
        let position = Point3::from(sum(&|v| self.vertices[v].coords));
        // Corners share their area, not their number, so unit normals are mixed.
        let normal = sum(&|v| self.normals[v].try_normalize(0.0).unwrap_or(Vector3::z()));
        Some(SurfacePoint { position, normal: UnitVector3::try_new(normal, 1e-12)? })
    }

    /// Where a ray goes through a triangle: how far along, and the weights (Moeller and Trumbore).
    fn through(&self, triangle: usize, from: &Point3<f64>, direction: &Vector3<f64>) -> Option<(f64, [f64; 3])> {
        let [a, b, c] = self.triangles[triangle].map(|v| self.vertices[v]);
        let (ab, ac) = (b - a, c - a);
        let cross = direction.cross(&ac);
        let volume = ab.dot(&cross);
        if volume.abs() <= f64::MIN_POSITIVE {
            return None;
        }
        let to = from - a;
        let u = to.dot(&cross) / volume;
        let across = to.cross(&ab);
        let v = direction.dot(&across) / volume;
        // A little wider, so that no ray slips through between two triangles.
        const EDGE: f64 = 1e-9;
        let within = u >= -EDGE && v >= -EDGE && u + v <= 1.0 + EDGE;
        within.then(|| (ac.dot(&across) / volume, [1.0 - u - v, u, v]))
    }
}

impl Surface for MeshSurface {
    /// The uppermost point.
    fn over(&self, at: &Point2<f64>) -> Option<SurfacePoint> {
        let (triangle, weights) = self.locate(at)?;
        self.weighted(triangle, weights)
    }

    /// Asks every triangle.
    fn hit(&self, from: &Point3<f64>, direction: &Vector3<f64>) -> Option<SurfacePoint> {
        let hits = (0..self.triangles.len()).filter_map(|t| Some((t, self.through(t, from, direction)?)));
        let ahead = hits.filter(|(_, (along, _))| *along >= 0.0);
        let (triangle, (_, weights)) = ahead.min_by(|a, b| a.1.0.total_cmp(&b.1.0).then(a.0.cmp(&b.0)))?;
        self.at(self.triangles[triangle], weights)
    }
}
