//! What is left of a sheet.

use crate::curved::surface::SurfaceSlices;
use nalgebra::Point3;

/// The part of a sheet that lies inside a solid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrimmedSheet {
    /// Places, mm.
    pub vertices: Vec<Point3<f64>>,
    /// Numbers of vertices; an oriented manifold with boundary.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the number of the triangle of the sheet that it is part of.
    pub sources: Vec<u32>,
    /// The edges that only one triangle has, as that triangle runs along them.
    pub boundary: Vec<BoundaryEdge>,
    /// Length of the boundary on the mesh, mm.
    pub mesh_mm: f64,
    /// Length of the sheet's own border inside the solid, mm.
    pub border_mm: f64,
    /// Length of the boundary across holes of the mesh, mm.
    pub hole_mm: f64,
    /// The greatest distance to the mesh of a vertex or midpoint of the boundary on the mesh, measured, mm.
    pub error_mm: f64,
    /// Whether the mesh has holes, so that inside was decided by a winding number of one half.
    pub holed: bool,
    /// Triangles with an altitude below [`MIN_ALTITUDE_MM`](super::MIN_ALTITUDE_MM) that could not be taken out.
    pub slivers: usize,
}

impl TrimmedSheet {
    /// The area, mm2.
    pub fn area(&self) -> f64 {
        let corners = self.triangles.iter().map(|corners| corners.map(|corner| self.vertices[corner as usize]));
        corners.map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0).sum()
    }
}

/// An edge of the boundary of a trimmed sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundaryEdge {
    /// Its vertices; the sheet is to its left.
    pub ends: [u32; 2],
    /// What ends the sheet there.
    pub kind: BoundaryKind,
}

/// What ends a trimmed sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BoundaryKind {
    /// The mesh.
    Mesh,
    /// The sheet's own border, inside the solid.
    Border,
    /// A winding number of one half, across a hole of the mesh.
    Hole,
}

/// Sheets as plain slices.
pub(in crate::curved) fn slices(sheets: &[TrimmedSheet]) -> Vec<SurfaceSlices<'_>> {
    sheets.iter().map(|sheet| (&sheet.vertices[..], &sheet.triangles[..])).collect()
}
