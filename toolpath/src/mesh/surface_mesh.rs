//! A triangle mesh with boundary that the algorithms on surfaces can trust.
//!
//! Half-edges are corners of triangles: half-edge `3 t + k` runs from corner `k` of triangle `t` to the next one, with
//! the triangle on its left. So only the half-edges across need storing.

use nalgebra::Point3;

/// No such half-edge: what lies across a boundary edge.
pub(crate) const NONE: u32 = u32::MAX;

/// A triangle lower than this share of its longest edge is refused: a corner's direction, and with it every unfolding
/// over the triangle, would be rounding noise. A double holds 16 digits; this leaves four of them to the height.
const MIN_HEIGHT: f64 = 1e-12;

/// Coordinates beyond this are refused: their squares must stay finite.
const MAX_COORDINATE: f64 = 1e100;

/// An oriented manifold of triangles, with or without a boundary.
#[derive(Clone, Debug)]
pub struct SurfaceMesh {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    /// The half-edge across, or [`NONE`].
    twins: Vec<u32>,
    /// A half-edge out of each vertex, or [`NONE`]. At the boundary it is the first one counterclockwise: the one that
    /// runs along the boundary.
    outgoing: Vec<u32>,
}

/// Why triangles are not a surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// There is no triangle.
    #[error("the mesh has no triangle")]
    Empty,
    /// Half-edges are counted in 32 bits.
    #[error("{triangles} triangles over {vertices} vertices are too many: at most 2^29 each")]
    TooLarge {
        /// Triangles given.
        triangles: usize,
        /// Vertices given.
        vertices: usize,
    },
    /// A coordinate is NaN, infinite or absurd.
    #[error("vertex {vertex} has a coordinate that is not finite or beyond 1e100")]
    BadVertex {
        /// Number of the vertex.
        vertex: usize,
    },
    /// A corner names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex} of {vertices}")]
    NoSuchVertex {
        /// Number of the triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// Vertices given.
        vertices: usize,
    },
    /// A triangle repeats a corner or has (almost) no height; collapse it first.
    #[error("triangle {triangle} has no area: its height is below 1e-12 of its longest edge")]
    Degenerate {
        /// Number of the triangle.
        triangle: usize,
    },
    /// More than two triangles meet in an edge.
    #[error("triangle {triangle} is one of more than two at the edge from vertex {from} to {to}")]
    NonManifoldEdge {
        /// One of the triangles.
        triangle: usize,
        /// One end of the edge.
        from: u32,
        /// The other end.
        to: u32,
    },
    /// Two neighbours run along their common edge in the same direction; turn one of them round.
    #[error("triangles {triangles:?} face opposite sides: both run from vertex {from} to {to}")]
    Unoriented {
        /// The two triangles.
        triangles: [usize; 2],
        /// Start of the edge in both.
        from: u32,
        /// End of the edge in both.
        to: u32,
    },
    /// Surfaces that touch in a vertex only; give each its own copy of it.
    #[error("the triangles around vertex {vertex} are not one fan")]
    NonManifoldVertex {
        /// Number of the vertex.
        vertex: usize,
    },
}

/// The connected regions of a surface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Regions {
    /// The region of each triangle; regions are numbered by their first triangle.
    pub of_triangle: Vec<u32>,
    /// How many there are.
    pub count: usize,
}

/// The next half-edge around the same triangle.
pub(crate) fn next(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }
}

/// The half-edge before in the same triangle.
pub(crate) fn previous(half_edge: u32) -> u32 {
    if half_edge.is_multiple_of(3) { half_edge + 2 } else { half_edge - 1 }
}

impl SurfaceMesh {
    /// Checks the triangles and finds their neighbours.
    ///
    /// # Arguments
    /// * `vertices`: in millimetres. Vertices that no triangle names are allowed.
    /// * `triangles`: corners by number, counterclockwise seen from outside.
    ///
    /// # Errors
    /// [`MeshError`], for the first fault found. Nothing is repaired.
    ///
    /// # Cost
    /// `O(n log d)` time and `O(n)` memory for `n` triangles with at most `d` around a vertex.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::mesh::SurfaceMesh;
    /// use curvlay_toolpath::nalgebra::Point3;
    /// let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point3::new(x, y, 0.0));
    /// let square = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?;
    /// assert_eq!(square.boundary_loops(), [[0, 1, 2, 3]]);
    /// # Ok::<(), curvlay_toolpath::mesh::MeshError>(())
    /// ```
    pub fn new(vertices: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        check_corners(&vertices, &triangles)?;
        let twins = find_twins(vertices.len(), &triangles)?;
        let mut mesh = SurfaceMesh { outgoing: vec![NONE; vertices.len()], vertices, triangles, twins };
        mesh.check_fans()?;
        Ok(mesh)
    }

    /// The vertices, as given.
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// The triangles, as given.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The point with the given barycentric coordinates in a triangle.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn point(&self, triangle: u32, barycentric: [f64; 3]) -> Point3<f64> {
        let corners = self.triangles[triangle as usize].map(|v| self.vertices[v as usize].coords);
        Point3::from(corners[0] * barycentric[0] + corners[1] * barycentric[1] + corners[2] * barycentric[2])
    }

    /// The triangle across each edge of a triangle: first the edge from corner 0 to 1. `None` at the boundary.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn neighbours(&self, triangle: u32) -> [Option<u32>; 3] {
        [0, 1, 2].map(|k| self.twin(3 * triangle + k).map(|twin| twin / 3))
    }

    /// Whether the vertex lies on the boundary.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn is_boundary_vertex(&self, vertex: u32) -> bool {
        let first = self.outgoing[vertex as usize];
        first != NONE && self.twin(first).is_none()
    }

    /// The closed chains of vertices along the boundary, each with the surface on its left and from its first half-edge
    /// on; chains are in the order of these. So outer rims run counterclockwise and rims of holes clockwise.
    pub fn boundary_loops(&self) -> Vec<Vec<u32>> {
        let mut seen = vec![false; self.twins.len()];
        let mut loops = Vec::new();
        for first in self.boundary_half_edges() {
            let mut chain = Vec::new();
            let mut at = first;
            while !seen[at as usize] {
                seen[at as usize] = true;
                chain.push(self.tail(at));
                // The boundary leaves a vertex along the first half-edge of its fan.
                at = self.outgoing[self.head(at) as usize];
            }
            if !chain.is_empty() {
                loops.push(chain);
            }
        }
        loops
    }

    /// The connected regions: triangles are connected over common edges.
    pub fn regions(&self) -> Regions {
        let mut of_triangle = vec![NONE; self.triangles.len()];
        let mut count = 0;
        let mut waiting = Vec::new();
        for first in 0..self.triangles.len() as u32 {
            if of_triangle[first as usize] != NONE {
                continue;
            }
            of_triangle[first as usize] = count;
            waiting.push(first);
            while let Some(triangle) = waiting.pop() {
                for neighbour in self.neighbours(triangle).into_iter().flatten() {
                    if of_triangle[neighbour as usize] == NONE {
                        of_triangle[neighbour as usize] = count;
                        waiting.push(neighbour);
                    }
                }
            }
            count += 1;
        }
        Regions { of_triangle, count: count as usize }
    }

    /// Length of the diagonal of the bounding box of all triangles.
    pub(crate) fn diagonal(&self) -> f64 {
        let used = || self.triangles.iter().flatten().map(|&v| self.vertices[v as usize].coords);
        let first = self.vertices[self.triangles[0][0] as usize].coords;
        let (low, high) = used().fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)));
        (high - low).norm()
    }

    pub(crate) fn half_edges(&self) -> u32 {
        self.twins.len() as u32
    }

    pub(crate) fn boundary_half_edges(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.half_edges()).filter(|&h| self.twin(h).is_none())
    }

    pub(crate) fn twin(&self, half_edge: u32) -> Option<u32> {
        Some(self.twins[half_edge as usize]).filter(|&twin| twin != NONE)
    }

    /// The lower of the two half-edges of an edge: it stands for the edge.
    pub(crate) fn edge(&self, half_edge: u32) -> u32 {
        half_edge.min(self.twins[half_edge as usize])
    }

    pub(crate) fn tail(&self, half_edge: u32) -> u32 {
        self.triangles[half_edge as usize / 3][half_edge as usize % 3]
    }

    pub(crate) fn head(&self, half_edge: u32) -> u32 {
        self.tail(next(half_edge))
    }

    /// The next half-edge out of the same vertex, counterclockwise; `None` past the boundary.
    pub(crate) fn turn_left(&self, half_edge: u32) -> Option<u32> {
        self.twin(previous(half_edge))
    }

    /// Half-edges out of a vertex, counterclockwise, each with its triangle on its left; at the boundary from the
    /// boundary on.
    pub(crate) fn fan(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let first = Some(self.outgoing[vertex as usize]).filter(|&h| h != NONE);
        std::iter::successors(first, move |&h| self.turn_left(h).filter(|&left| Some(left) != first))
    }

    /// Finds the first half-edge of each fan, and refuses vertices with two fans.
    fn check_fans(&mut self) -> Result<(), MeshError> {
        let mut degrees = vec![0u32; self.vertices.len()];
        for h in 0..self.half_edges() {
            let vertex = self.tail(h) as usize;
            degrees[vertex] += 1;
            if self.outgoing[vertex] == NONE || self.twin(h).is_none() {
                self.outgoing[vertex] = h;
            }
        }
        for (vertex, &degree) in degrees.iter().enumerate() {
            if self.fan(vertex as u32).count() != degree as usize {
                return Err(MeshError::NonManifoldVertex { vertex });
            }
        }
        Ok(())
    }
}

fn check_corners(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<(), MeshError> {
    if triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    if triangles.len().max(vertices.len()) > 1 << 29 {
        return Err(MeshError::TooLarge { triangles: triangles.len(), vertices: vertices.len() });
    }
    let sound = |p: &Point3<f64>| p.iter().all(|c| c.abs() <= MAX_COORDINATE);
    if let Some(vertex) = vertices.iter().position(|p| !sound(p)) {
        return Err(MeshError::BadVertex { vertex });
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices.len()) {
            return Err(MeshError::NoSuchVertex { triangle, vertex, vertices: vertices.len() });
        }
        let [a, b, c] = corners.map(|v| vertices[v as usize]);
        let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
        let height = (b - a).cross(&(c - a)).norm() / longest; // as a share of the longest edge
        let has_height = height > MIN_HEIGHT; // false for 0/0 too
        if !has_height {
            return Err(MeshError::Degenerate { triangle });
        }
    }
    Ok(())
}

/// For each half-edge the one across. Half-edges are gathered by tail and sorted by head.
fn find_twins(vertices: usize, triangles: &[[u32; 3]]) -> Result<Vec<u32>, MeshError> {
    let ends = |h: u32| {
        let corners = triangles[h as usize / 3];
        (corners[h as usize % 3], corners[next(h) as usize % 3])
    };
    let half_edges = 3 * triangles.len() as u32;
    let mut starts = vec![0u32; vertices + 1];
    triangles.iter().flatten().for_each(|&v| starts[v as usize + 1] += 1);
    (0..vertices).for_each(|v| starts[v + 1] += starts[v]);
    let mut filled = starts.clone();
    let mut out = vec![(0u32, 0u32); half_edges as usize]; // head and half-edge
    for h in 0..half_edges {
        let (tail, head) = ends(h);
        out[filled[tail as usize] as usize] = (head, h);
        filled[tail as usize] += 1;
    }
    (0..vertices).for_each(|v| out[starts[v] as usize..starts[v + 1] as usize].sort_unstable());
    let between = |tail: u32, head: u32| {
        let around = &out[starts[tail as usize] as usize..starts[tail as usize + 1] as usize];
        let first = around.partition_point(|&(other, _)| other < head);
        let count = around[first..].iter().take_while(|&&(other, _)| other == head).count();
        &around[first..first + count]
    };
    let mut twins = vec![NONE; half_edges as usize];
    for h in 0..half_edges {
        let (from, to) = ends(h);
        let (along, back) = (between(from, to), between(to, from));
        if along.len() + back.len() > 2 {
            return Err(MeshError::NonManifoldEdge { triangle: h as usize / 3, from, to });
        }
        if let [(_, first), (_, second)] = along {
            return Err(MeshError::Unoriented { triangles: [first, second].map(|h| *h as usize / 3), from, to });
        }
        if let [(_, twin)] = back {
            twins[h as usize] = *twin;
        }
    }
    Ok(twins)
}
