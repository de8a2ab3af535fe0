//! Back from a part of a mesh to the mesh.

use crate::mesh::{SurfaceMesh, SurfacePoint, on_mesh_triangle};
use crate::path::{BeadKind, PathPoint, SurfacePath};

/// Back from a part of a mesh to the mesh.
#[derive(Clone, Copy)]
pub(super) struct OnMesh<'a> {
    pub mesh: &'a SurfaceMesh,
    /// The triangle of the mesh that has each of the part.
    pub parents: &'a [u32],
}

impl OnMesh<'_> {
    pub fn point(&self, at: &SurfacePoint) -> SurfacePoint {
        let triangle = self.parents[at.triangle as usize];
        let (_, barycentric) = on_mesh_triangle(self.mesh, triangle, at.position);
        SurfacePoint { triangle, barycentric, position: at.position }
    }

    /// A path of a skin.
    pub fn path(&self, path: SurfacePath, regions: u32) -> SurfacePath {
        let point = |point: &PathPoint| PathPoint { at: self.point(&point.at), kind: BeadKind::Skin, ..*point };
        SurfacePath { points: path.points.iter().map(point).collect(), region: path.region + regions, ..path }
    }
}
