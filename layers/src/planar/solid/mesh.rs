//! A closed mesh: every edge has two faces, which run along it in opposite directions.

use nalgebra::{Point3, Vector3};

use crate::trim::MAX_COORDINATE;

/// A closed, oriented mesh around a solid. Triangles are counter-clockwise from outside.
///
/// It may have several shells (pieces, voids), and triangles without area.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    /// The edges of each triangle: number `k` runs from corner `k` to the next one.
    edges: Vec<[u32; 3]>,
    edge_count: usize,
}

/// Why a mesh does not bound a solid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolidError {
    /// There are no triangles.
    #[error("the mesh has no triangles")]
    Empty,
    /// A triangle names a vertex that is not there, or the same vertex twice.
    #[error("triangle {triangle} has the corners {corners:?}, of {vertices} vertices")]
    Triangle {
        /// Number of the triangle.
        triangle: usize,
        /// Its corners.
        corners: [u32; 3],
        /// How many vertices there are.
        vertices: usize,
    },
    /// A coordinate is not finite, or too large for exact signs.
    #[error("vertex {vertex} has an invalid coordinate ({value})")]
    Coordinate {
        /// Number of the vertex.
        vertex: usize,
        /// What stands there.
        value: f64,
    },
    /// Edges have a face on one side only.
    #[error("the mesh is open: {edges} edges have one face only, the first one between ({}, {}, {}) and ({}, {}, {})",
        .ends[0][0], .ends[0][1], .ends[0][2], .ends[1][0], .ends[1][1], .ends[1][2])]
    Open {
        /// How many such edges there are.
        edges: usize,
        /// The ends of the first one.
        ends: [[f64; 3]; 2],
    },
    /// An edge has more than two faces, or two that run along it in the same direction.
    #[error("the edge between vertices {} and {} has {faces} faces, or faces that are turned against each other", .edge[0], .edge[1])]
    NotManifold {
        /// The vertices at its ends.
        edge: [u32; 2],
        /// How many faces it has.
        faces: usize,
    },
    /// The triangles are clockwise from outside, or enclose nothing.
    #[error("the mesh encloses a volume of {volume}: it is inside out, or flat")]
    NoVolume {
        /// The signed volume.
        volume: f64,
    },
}

impl Solid {
    /// Checks a mesh.
    ///
    /// # Errors
    /// [`SolidError`] names the first fault.
    ///
    /// # Cost
    /// `O(n log n)` for `n` triangles.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::planar::{Solid, SolidError};
    /// let tetrahedron = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Into::into);
    /// let solid = Solid::new(&tetrahedron, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
    /// assert!((solid.volume() - 1.0 / 6.0).abs() < 1e-15);
    /// assert!(matches!(Solid::new(&tetrahedron, &[[0, 2, 1]]), Err(SolidError::Open { edges: 3, .. })));
    /// # Ok::<(), SolidError>(())
    /// ```
    pub fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self, SolidError> {
        if triangles.is_empty() {
            return Err(SolidError::Empty);
        }
        for (vertex, p) in vertices.iter().enumerate() {
            if let Some(&value) = p.iter().find(|c| !c.is_finite() || c.abs() > MAX_COORDINATE) {
                return Err(SolidError::Coordinate { vertex, value });
            }
        }
        for (triangle, &corners) in triangles.iter().enumerate() {
            let [a, b, c] = corners;
            if a == b || b == c || c == a || corners.iter().any(|&v| v as usize >= vertices.len()) {
                return Err(SolidError::Triangle { triangle, corners, vertices: vertices.len() });
            }
        }
        let solid = Self::with_edges(vertices.to_vec(), triangles.to_vec())?;
        let volume = solid.volume();
        if volume > 0.0 { Ok(solid) } else { Err(SolidError::NoVolume { volume }) }
    }

    /// Numbers the edges, and checks that each has two faces.
    pub(super) fn with_edges(vertices: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Result<Self, SolidError> {
        let mut sides: Vec<([u32; 2], bool, usize)> = Vec::with_capacity(3 * triangles.len());
        for (face, corners) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (from, to) = (corners[k], corners[(k + 1) % 3]);
                sides.push(([from.min(to), from.max(to)], from < to, 3 * face + k));
            }
        }
        sides.sort_unstable();
        let mut edges = vec![[0; 3]; triangles.len()];
        let (mut open, mut first_open, mut edge_count) = (0, None, 0);
        for around in sides.chunk_by(|a, b| a.0 == b.0) {
            let edge = around[0].0;
            match around {
                [one, other] if one.1 != other.1 => {}
                [_] => {
                    open += 1;
                    first_open = first_open.or(Some(edge.map(|v| vertices[v as usize].into())));
                }
                _ => return Err(SolidError::NotManifold { edge, faces: around.len() }),
            }
            for &(_, _, side) in around {
                edges[side / 3][side % 3] = edge_count;
            }
            edge_count += 1;
        }
        if let Some(ends) = first_open {
            return Err(SolidError::Open { edges: open, ends });
        }
        Ok(Solid { vertices, triangles, edges, edge_count: edge_count as usize })
    }

    /// The vertices.
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// The triangles.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The edges of each triangle, numbered from 0.
    pub(super) fn edges(&self) -> &[[u32; 3]] {
        &self.edges
    }

    /// How many edges there are.
    pub fn edge_count(&self) -> usize {
        self.edge_count
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// The volume, in the cube of the unit of the vertices.
    pub fn volume(&self) -> f64 {
        signed_volume(self.vertices[0], (0..self.triangles.len()).map(|triangle| self.corners(triangle)))
    }

    /// The area of all triangles.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|triangle| doubled_normal(self.corners(triangle)).norm() / 2.0).sum()
    }

    /// Least and greatest coordinates.
    pub fn bounds(&self) -> [Point3<f64>; 2] {
        let mut used = self.triangles.iter().flatten().map(|&v| self.vertices[v as usize]);
        let first = used.next().unwrap_or_else(Point3::origin);
        used.fold([first, first], |[low, high], p| [low.inf(&p), high.sup(&p)])
    }

    /// Least and greatest distance along a direction.
    pub fn extent(&self, direction: &Vector3<f64>) -> [f64; 2] {
        self.triangles
            .iter()
            .flatten()
            .map(|&v| self.vertices[v as usize].coords.dot(direction))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], along| [low.min(along), high.max(along)])
    }

    /// How often the mesh winds around a point: 1 inside, 0 outside; on the surface anything between.
    ///
    /// # Cost
    /// `O(n)`: the solid angle of every triangle.
    pub fn winding(&self, p: &Point3<f64>) -> f64 {
        winding_of((0..self.triangles.len()).map(|triangle| self.corners(triangle)), p)
    }
}

/// Twice the area, along the normal.
pub(super) fn doubled_normal([a, b, c]: [Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// The volume inside triangles; `from` should be near them.
pub(super) fn signed_volume(from: Point3<f64>, triangles: impl Iterator<Item = [Point3<f64>; 3]>) -> f64 {
    triangles.map(|corners| corners.map(|p| p - from)).map(|[a, b, c]| a.dot(&b.cross(&c))).sum::<f64>() / 6.0
}

/// The winding number by solid angles (A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30(2), 1983).
pub(super) fn winding_of(triangles: impl Iterator<Item = [Point3<f64>; 3]>, p: &Point3<f64>) -> f64 {
    let angle = |corners: [Point3<f64>; 3]| {
        let [a, b, c] = corners.map(|corner| corner - p);
        let [la, lb, lc] = [a.norm(), b.norm(), c.norm()];
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    triangles.map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}
