//! What is left of a sheet.

use super::SurfaceSlices;
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;

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
    ///
    /// # Panics
    /// If a triangle has a vertex that is not there.
    pub fn area(&self) -> f64 {
        let corners = self.triangles.iter().map(|corners| corners.map(|corner| self.vertices[corner as usize]));
        corners.map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0).sum()
    }
}

impl TrimmedSheet {
    /// How much the sheet's own border turns inside the solid, in radians: the sum, over the vertices where two edges of it meet, of the
    /// angle between them. By [`border_mm`](Self::border_mm) it says whether the sheet ends along a smooth line or on a staircase.
    ///
    /// # Panics
    /// If an edge of the boundary has a vertex that is not there.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::trim::{BoundaryEdge, BoundaryKind, TrimmedSheet};
    /// use curvlay_layers::nalgebra::Point3;
    /// let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]].map(Point3::from).to_vec();
    /// let edge = |ends| BoundaryEdge { ends, kind: BoundaryKind::Border };
    /// let boundary = vec![edge([0, 1]), edge([1, 2]), BoundaryEdge { ends: [2, 0], kind: BoundaryKind::Mesh }];
    /// let sheet = TrimmedSheet { vertices, triangles: vec![[0, 1, 2]], boundary, ..TrimmedSheet::default() };
    /// assert!((sheet.border_turning() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    /// ```
    pub fn border_turning(&self) -> f64 {
        let along = |edge: &BoundaryEdge| {
            let [from, to] = edge.ends.map(|end| self.vertices[end as usize]);
            to - from
        };
        let border = || self.boundary.iter().filter(|edge| edge.kind == BoundaryKind::Border);
        let before: BTreeMap<u32, Vector3<f64>> = border().map(|edge| (edge.ends[1], along(edge))).collect();
        border().filter_map(|edge| Some(before.get(&edge.ends[0])?.angle(&along(edge)))).sum()
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

impl TrimmedSheet {
    /// Its points and triangles as plain slices.
    pub(super) fn slices(&self) -> SurfaceSlices<'_> {
        (&self.vertices, &self.triangles)
    }
}

/// Sheets as plain slices.
pub(crate) fn slices(sheets: &[TrimmedSheet]) -> Vec<SurfaceSlices<'_>> {
    sheets.iter().map(TrimmedSheet::slices).collect()
}
