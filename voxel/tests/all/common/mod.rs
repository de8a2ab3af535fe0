//! Shapes and a reader that several tests share.

use curvlay_voxel::nalgebra::{Point3, Vector3};
use curvlay_voxel::{Progress, Resolution, VoxelError, VoxelOptions, Voxelisation, voxelise};
use std::ops::ControlFlow;
use std::path::Path;

/// A mesh: vertices and triangles.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub vertices: Vec<Point3<f64>>,
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Both meshes, side by side.
    pub fn and(mut self, other: &Mesh) -> Mesh {
        let first = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|corner| corner + first)));
        self
    }

    /// The same mesh with every triangle turned.
    pub fn turned(mut self) -> Mesh {
        self.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        self
    }

    pub fn moved(mut self, by: [f64; 3]) -> Mesh {
        self.vertices.iter_mut().for_each(|at| *at += Vector3::from(by));
        self
    }

    pub fn with(&self, resolution: Resolution) -> Result<Voxelisation, VoxelError> {
        let options = VoxelOptions { resolution, ..VoxelOptions::default() };
        voxelise(&self.vertices, &self.triangles, &options, &go_on)
    }

    pub fn corners(&self) -> impl Iterator<Item = [Point3<f64>; 3]> + '_ {
        self.triangles.iter().map(|t| t.map(|corner| self.vertices[corner as usize]))
    }
}

pub fn go_on(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A box, its faces outwards.
pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let ends = [low, high];
    let corner = |k: usize| Point3::new(ends[k & 1][0], ends[k >> 1 & 1][1], ends[k >> 2][2]);
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { vertices: (0..8).map(corner).collect(), triangles }
}

/// A ball with bumps, its triangles outwards: `2 * n * (n - 1)` of them.
pub fn bumpy_ball(n: u32, radius: f64, bumps: f64) -> Mesh {
    use std::f64::consts::PI;
    let at = |i: u32, j: u32| {
        let (u, v) = (PI * f64::from(i) / f64::from(n), 2.0 * PI * f64::from(j) / f64::from(n));
        let r = radius * (1.0 + bumps * (5.0 * u).sin() * (4.0 * v).cos() * u.sin());
        Point3::new(r * u.sin() * v.cos(), r * u.sin() * v.sin(), r * u.cos())
    };
    let mut mesh = Mesh { vertices: vec![at(0, 0), Point3::new(0.0, 0.0, -radius)], triangles: Vec::new() };
    mesh.vertices.extend((1..n).flat_map(|i| (0..n).map(move |j| at(i, j))));
    let index = |i: u32, j: u32| match i {
        0 => 0,
        i if i == n => 1,
        i => 2 + (i - 1) * n + j % n,
    };
    for i in 0..n {
        for j in 0..n {
            let quad = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            if i + 1 < n {
                mesh.triangles.push([quad[0], quad[1], quad[2]]);
            }
            if i > 0 {
                mesh.triangles.push([quad[0], quad[2], quad[3]]);
            }
        }
    }
    mesh
}

/// A binary STL file of the folder `shared` beside the workspace.
pub fn shared(name: &str) -> Mesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(name);
    let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut mesh = Mesh::default();
    for (at, facet) in (0..).zip(bytes[84..].chunks_exact(50)) {
        let number = |k: usize| f64::from(f32::from_le_bytes([facet[k], facet[k + 1], facet[k + 2], facet[k + 3]]));
        mesh.vertices.extend([12, 24, 36].map(|k| Point3::new(number(k), number(k + 4), number(k + 8))));
        mesh.triangles.push([3 * at, 3 * at + 1, 3 * at + 2]);
    }
    mesh
}
