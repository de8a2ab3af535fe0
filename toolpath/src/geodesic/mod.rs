//! Exact geodesic distance on a triangle mesh to its boundary, or to any edges and vertices.
//!
//! Takes a [`SurfaceMesh`]; gives a [`SurfaceDistance`], which answers at any point of it.
//!
//! Dai 2020, section 3.5.1, builds the boundary distance field by fast wavefront propagation (Xu, Wang, Liu, Liu, He,
//! IEEE TVCG 21(7), 2015) after Mitchell, Mount, Papadimitriou (SIAM J. Comput. 16(4), 1987), with polylines as
//! sources. So does this module. A shortest path on a mesh is straight over unfolded triangles and bends in few
//! vertices only. A *window* is an interval of an edge with all straight lines from one source that cross it. Sources are
//! points (source vertices, and vertices where paths bend) and edges, which send out a *strip* of parallel lines.
//! Windows are propagated over triangles, nearest first, and trimmed against each other on each edge.
//!
//! * `unfold`: triangles laid flat. `wave`: what a window sees. `envelope`: the windows of an edge.
//! * `queue`: nearest first. `wavefront`: the propagation. `query`: distances inside of triangles.
//!
//! Departures: edges as sources are exact, by strips. The queue is sorted roughly, and vertices drop windows that they
//! beat (Xin and Wang 2009); neither changes the result.
//!
//! Distances are exact for the mesh but for rounding: paths are compared with a slack of 1e-14 of the diagonal of the
//! mesh, and unfolding over n triangles adds some n roundings.

mod envelope;
mod query;
mod queue;
mod unfold;
mod wave;
mod wavefront;

pub use query::Nearest;
pub(crate) use query::TriangleLights;

use crate::ProgressFn;
use crate::mesh::SurfaceMesh;
use envelope::Envelope;
use unfold::Unfolding;
use wavefront::{Settled, WaveFront};

/// Differences of distances below this share of the mesh's diagonal do not count. It must exceed rounding, or equal
/// paths would take turns in beating each other; what it costs in accuracy grows with the number of triangles crossed.
const SLACK: f64 = 1e-14;

/// From where distances are measured.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sources<'a> {
    /// Edges of the mesh by their ends, in any order; chains of them are polylines. Inner edges count on both sides.
    pub edges: &'a [[u32; 2]],
    /// Single vertices.
    pub vertices: &'a [u32],
}

/// Why there is no distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DistanceError {
    /// The surface is closed.
    #[error("the surface is closed: there is no boundary to measure from")]
    NoBoundary,
    /// Neither edges nor vertices were given.
    #[error("no source was given")]
    NoSource,
    /// A source edge does not exist.
    #[error("source edge {edge}: the mesh has no edge between vertices {} and {}", ends[0], ends[1])]
    NoSuchEdge {
        /// Its position among the source edges.
        edge: usize,
        /// The ends that were given.
        ends: [u32; 2],
    },
    /// A source vertex does not exist, or no triangle has it.
    #[error("no triangle has the source vertex {vertex}")]
    NoSuchVertex {
        /// The vertex.
        vertex: u32,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// The distance from everywhere on a mesh to its sources, along the surface.
///
/// Parts of the mesh that are not connected with a source have an infinite distance.
#[derive(Clone, Debug)]
pub struct SurfaceDistance<'m> {
    mesh: &'m SurfaceMesh,
    unfolding: Unfolding,
    distances: Vec<f64>,
    envelope: Envelope,
    is_source: Vec<bool>,
}

impl<'m> SurfaceDistance<'m> {
    /// Distance to the boundary.
    ///
    /// # Errors
    /// [`DistanceError::NoBoundary`], [`DistanceError::Cancelled`].
    ///
    /// # Cost
    /// Time and memory are proportional to the number of windows: two a triangle on planes. On curved surfaces each
    /// vertex between an edge and the boundary splits the lines to that edge, so their number grows as the square root
    /// of that of triangles. One thread; the result does not depend on timing.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::geodesic::SurfaceDistance;
    /// use curvlay_toolpath::mesh::SurfaceMesh;
    /// use std::ops::ControlFlow;
    /// // A pyramid without a bottom: the way down from the apex is the height of its sides.
    /// let corners = [[-3.0, -3.0, 0.0], [3.0, -3.0, 0.0], [3.0, 3.0, 0.0], [-3.0, 3.0, 0.0], [0.0, 0.0, 4.0]];
    /// let sides = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    /// let mesh = SurfaceMesh::new(corners.map(Point3::from).to_vec(), sides)?;
    /// let distance = SurfaceDistance::to_boundary(&mesh, &|_| ControlFlow::Continue(()))?;
    /// assert_eq!(distance.at_vertex(4), 5.0);
    /// assert_eq!(distance.at(0, [0.25, 0.25, 0.5]).distance, 2.5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to_boundary(mesh: &'m SurfaceMesh, progress: ProgressFn) -> Result<Self, DistanceError> {
        let edges: Vec<u32> = mesh.boundary_half_edges().collect();
        if edges.is_empty() {
            return Err(DistanceError::NoBoundary);
        }
        Self::measure(mesh, &edges, &[], progress)
    }

    /// Distance to any edges and vertices. Cost as for [`Self::to_boundary`].
    ///
    /// # Errors
    /// [`DistanceError`], except for `NoBoundary`.
    ///
    /// # Example
    /// ```
    /// # use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::geodesic::{Sources, SurfaceDistance};
    /// use curvlay_toolpath::mesh::SurfaceMesh;
    /// # use std::ops::ControlFlow;
    /// let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]].map(|[x, y]| Point3::new(x, y, 0.0));
    /// let mesh = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 3], [1, 2, 3]])?;
    /// let to_corner = Sources { vertices: &[0], ..Sources::default() };
    /// let distance = SurfaceDistance::to(&mesh, to_corner, &|_| ControlFlow::Continue(()))?;
    /// assert_eq!(distance.at_vertex(2), 5.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to(mesh: &'m SurfaceMesh, sources: Sources, progress: ProgressFn) -> Result<Self, DistanceError> {
        if sources.edges.is_empty() && sources.vertices.is_empty() {
            return Err(DistanceError::NoSource);
        }
        let mut edges = Vec::with_capacity(sources.edges.len());
        for (edge, &ends) in sources.edges.iter().enumerate() {
            edges.push(half_edge_between(mesh, ends).ok_or(DistanceError::NoSuchEdge { edge, ends })?);
        }
        for &vertex in sources.vertices {
            if vertex as usize >= mesh.vertices().len() || mesh.fan(vertex).next().is_none() {
                return Err(DistanceError::NoSuchVertex { vertex });
            }
        }
        Self::measure(mesh, &edges, sources.vertices, progress)
    }

    fn measure(
        mesh: &'m SurfaceMesh,
        edges: &[u32],
        vertices: &[u32],
        progress: ProgressFn,
    ) -> Result<Self, DistanceError> {
        let unfolding = Unfolding::new(mesh);
        let slack = SLACK * mesh.diagonal();
        let front = WaveFront::new(mesh, &unfolding, edges, vertices, slack);
        let settled = front.settle(progress).ok_or(DistanceError::Cancelled)?;
        let Settled { distances, envelope, is_source } = settled;
        Ok(SurfaceDistance { mesh, unfolding, distances, envelope, is_source })
    }

    /// The mesh.
    pub fn mesh(&self) -> &'m SurfaceMesh {
        self.mesh
    }

    /// The distance at each vertex; infinite where no source is connected.
    pub fn at_vertices(&self) -> &[f64] {
        &self.distances
    }

    /// The distance at a vertex.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn at_vertex(&self, vertex: u32) -> f64 {
        self.distances[vertex as usize]
    }
}

fn half_edge_between(mesh: &SurfaceMesh, [from, to]: [u32; 2]) -> Option<u32> {
    let out_of = |from: u32, to: u32| {
        let fan = Some(from).filter(|&v| (v as usize) < mesh.vertices().len()).map(|v| mesh.fan(v));
        fan.into_iter().flatten().find(|&h| mesh.head(h) == to)
    };
    out_of(from, to).or_else(|| out_of(to, from))
}
