//! The point of a layer that is nearest to a point in space, and normals of the layer.

use crate::layer::{Keys, Tree, Triangle};
use crate::mesh::{SurfaceMesh, SurfacePoint};
use nalgebra::{Point3, UnitVector3, Vector3};

/// The triangles of a layer in a tree, and the normals of its vertices.
#[derive(Debug)]
pub(super) struct Layer<'m> {
    pub mesh: &'m SurfaceMesh,
    /// Unit normals of vertices, weighted by area; zero at a vertex that no triangle has.
    pub normals: Vec<Vector3<f64>>,
    tree: Tree,
    keys: Keys,
}

impl<'m> Layer<'m> {
    pub(super) fn new(mesh: &'m SurfaceMesh) -> Self {
        let normals = vertex_normals(mesh);
        let triangle = |(index, corners): (usize, &[u32; 3])| Triangle {
            corners: corners.map(|v| mesh.vertices()[v as usize]),
            rims: [0; 2],
            height: 0.0,
            layer: 0,
            index: index as u32,
        };
        let tree = Tree::new(mesh.triangles().iter().enumerate().map(triangle).collect());
        let keys = Keys::new(&tree, vec![0; mesh.triangles().len()]);
        Layer { mesh, normals, tree, keys }
    }

    /// The nearest point of the layer within `reach`.
    pub(super) fn nearest(&self, p: Point3<f64>, reach: f64) -> Option<SurfacePoint> {
        let found = self.tree.nearest(&self.keys, p, 0..1, reach, |_, _| true)?;
        Some(surface_point(self.mesh, self.tree.triangles()[found.triangle].index, found.point))
    }

    /// The normal at a point: those of the corners by their weights.
    pub(super) fn normal(&self, at: &SurfacePoint) -> UnitVector3<f64> {
        let corners = self.mesh.triangles()[at.triangle as usize];
        let sum = corners
            .iter()
            .zip(at.barycentric)
            .fold(Vector3::zeros(), |sum: Vector3<f64>, (&v, weight)| sum + self.normals[v as usize] * weight);
        UnitVector3::try_new(sum, 0.0).unwrap_or_else(|| UnitVector3::new_normalize(cross(self.mesh, at.triangle)))
    }
}

/// A point in the plane of a triangle.
pub(super) fn surface_point(mesh: &SurfaceMesh, triangle: u32, position: Point3<f64>) -> SurfacePoint {
    let [a, b, c] = mesh.triangles()[triangle as usize].map(|v| mesh.vertices()[v as usize]);
    let normal = cross(mesh, triangle);
    let share = |from: Point3<f64>, to: Point3<f64>| (to - from).cross(&(position - from)).dot(&normal).max(0.0);
    let shares = [share(b, c), share(c, a), share(a, b)];
    let sum: f64 = shares.iter().sum();
    SurfacePoint { triangle, barycentric: shares.map(|share| share / sum), position }
}

/// The normal of a triangle, twice its area long.
pub(super) fn cross(mesh: &SurfaceMesh, triangle: u32) -> Vector3<f64> {
    let [a, b, c] = mesh.triangles()[triangle as usize].map(|v| mesh.vertices()[v as usize]);
    (b - a).cross(&(c - a))
}

/// Unit normals of the vertices, weighted by area.
pub(super) fn vertex_normals(mesh: &SurfaceMesh) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); mesh.vertices().len()];
    for (triangle, corners) in mesh.triangles().iter().enumerate() {
        let normal = cross(mesh, triangle as u32);
        corners.iter().for_each(|&v| normals[v as usize] += normal);
    }
    for (v, normal) in normals.iter_mut().enumerate() {
        // Opposite triangles may cancel: any of them will do.
        let any = || mesh.fan(v as u32).next().map(|h| cross(mesh, h / 3).normalize());
        *normal = normal.try_normalize(0.0).or_else(any).unwrap_or_default();
    }
    normals
}

/// A third of the area of the triangles around each vertex.
pub(super) fn vertex_areas(mesh: &SurfaceMesh) -> Vec<f64> {
    let mut areas = vec![0.0; mesh.vertices().len()];
    for (triangle, corners) in mesh.triangles().iter().enumerate() {
        let area = cross(mesh, triangle as u32).norm() / 2.0;
        corners.iter().for_each(|&v| areas[v as usize] += area / 3.0);
    }
    areas
}
