//! The distance as a field that is linear over triangles, finer where it must be.
//!
//! Over the triangles of the mesh the distance is not linear: it has a ridge along the medial axis, which runs through
//! triangles (all of it may, where the region is one triangle wide). So edges are cut where the distance leaves the
//! straight line between its ends, and triangles that hide a summit get a vertex on it (see `refine`). Then the linear
//! field over the finer triangles follows the distance within the tolerance, and its level sets are exact polylines.

use crate::geodesic::SurfaceDistance;
use crate::mesh::{NONE, SurfacePoint, next};
use nalgebra::Point3;

/// A distance as a field that is linear over triangles, on a refined copy of the mesh.
#[derive(Clone, Debug)]
pub struct LevelField<'d> {
    distance: &'d SurfaceDistance<'d>,
    pub(crate) points: Vec<Point3<f64>>,
    pub(crate) values: Vec<f64>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The triangle of the mesh of which each is a part.
    pub(super) parents: Vec<u32>,
    pub(super) twins: Vec<u32>,
}

impl<'d> LevelField<'d> {
    /// The distance at the vertices of its mesh, taken as linear over the triangles as they are.
    pub(super) fn unrefined(distance: &'d SurfaceDistance<'d>) -> Self {
        let mesh = distance.mesh();
        LevelField {
            distance,
            points: mesh.vertices().to_vec(),
            values: distance.at_vertices().to_vec(),
            triangles: mesh.triangles().to_vec(),
            parents: (0..mesh.triangles().len() as u32).collect(),
            twins: (0..mesh.half_edges()).map(|h| mesh.twin(h).unwrap_or(NONE)).collect(),
        }
    }

    /// The distance.
    pub fn distance(&self) -> &'d SurfaceDistance<'d> {
        self.distance
    }

    /// The triangle of the mesh of which each refined one is a part.
    pub(crate) fn parents(&self) -> &[u32] {
        &self.parents
    }

    /// Triangles of the refined mesh.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// A point of one of the refined triangles.
    pub(crate) fn surface_point(&self, triangle: u32, position: Point3<f64>) -> SurfacePoint {
        let triangle = self.parents[triangle as usize];
        SurfacePoint { triangle, barycentric: self.barycentric(triangle, position), position }
    }

    pub(crate) fn tail(&self, half_edge: u32) -> u32 {
        self.triangles[half_edge as usize / 3][half_edge as usize % 3]
    }

    pub(crate) fn head(&self, half_edge: u32) -> u32 {
        self.tail(next(half_edge))
    }

    pub(super) fn twin(&self, half_edge: u32) -> Option<u32> {
        Some(self.twins[half_edge as usize]).filter(|&twin| twin != NONE)
    }

    pub(crate) fn half_edges(&self) -> u32 {
        self.twins.len() as u32
    }

    /// Weights of the corners of a triangle of the mesh at a point in its plane.
    fn barycentric(&self, parent: u32, p: Point3<f64>) -> [f64; 3] {
        let mesh = self.distance.mesh();
        let [a, b, c] = mesh.triangles()[parent as usize].map(|v| mesh.vertices()[v as usize]);
        let normal = (b - a).cross(&(c - a));
        let share = |from: Point3<f64>, to: Point3<f64>| ((to - from).cross(&(p - from)).dot(&normal)).max(0.0);
        let shares = [share(b, c), share(c, a), share(a, b)];
        shares.map(|share| share / shares.iter().sum::<f64>())
    }
}
