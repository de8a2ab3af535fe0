//! Meshes that the tests share.

pub mod creases;
pub mod layers;
pub mod nozzle;
pub mod slow;

use curvlay_toolpath::Progress;
use curvlay_toolpath::geodesic::SurfaceDistance;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Point2, Point3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::ops::ControlFlow;

pub fn go_on(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

pub fn rng(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

pub fn to_boundary(mesh: &SurfaceMesh) -> SurfaceDistance<'_> {
    SurfaceDistance::to_boundary(mesh, &go_on).unwrap()
}

/// A mesh without the vertices that no triangle has.
pub fn compact(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> SurfaceMesh {
    let mut number = vec![u32::MAX; vertices.len()];
    let mut kept = Vec::new();
    let mut renumber = |v: u32| {
        if number[v as usize] == u32::MAX {
            number[v as usize] = kept.len() as u32;
            kept.push(vertices[v as usize]);
        }
        number[v as usize]
    };
    let triangles = triangles.iter().map(|t| t.map(&mut renumber)).collect();
    SurfaceMesh::new(kept, triangles).unwrap()
}

/// A plane plate of `n` by `n` mm without those square millimetres that are `holes`, row by row. Of two holes, or two squares, that meet in a
/// corner alone, one goes.
pub fn plate_with_holes(n: usize, seed: u64, mut holes: Vec<bool>) -> SurfaceMesh {
    let meets = |holes: &[bool], i: usize, j: usize| {
        let [a, b, c, d] = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| holes[i + n * j]);
        a == d && b == c && a != b
    };
    while let Some(at) = (0..n * (n - 1) - 1).filter(|at| at % n < n - 1).find(|at| meets(&holes, at % n, at / n)) {
        // The number of holes falls, so this ends.
        [at, at + 1].into_iter().for_each(|square| holes[square] = false);
    }
    grid(n, seed, 0.6, |i, j| holes[i + n * j], |p| Point3::new(p.x, p.y, 0.0))
}

/// A grid of `n` by `n` squares, each cut into two triangles at random; squares for which `hole` holds are left out.
/// Vertices inside are moved by up to `jitter / 2` of a square; those on rims stay. Then all are placed by `place`.
pub fn grid(
    n: usize,
    seed: u64,
    jitter: f64,
    hole: impl Fn(usize, usize) -> bool,
    mut place: impl FnMut(Point2<f64>) -> Point3<f64>,
) -> SurfaceMesh {
    let mut rng = rng(seed);
    let there = |i: isize, j: isize| {
        let inside = |k: isize| 0 <= k && k < n as isize;
        inside(i) && inside(j) && !hole(i as usize, j as usize)
    };
    let mut vertices = Vec::new();
    for j in 0..=n as isize {
        for i in 0..=n as isize {
            let inner = [(i, j), (i - 1, j), (i, j - 1), (i - 1, j - 1)].iter().all(|&(i, j)| there(i, j));
            let mut moved = |k: isize| {
                let by = jitter * (rng.random::<f64>() - 0.5);
                if inner { k as f64 + by } else { k as f64 }
            };
            vertices.push(place(Point2::new(moved(i), moved(j))));
        }
    }
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..n {
            if hole(i, j) {
                continue;
            }
            let at = |i: usize, j: usize| (i + (n + 1) * j) as u32;
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            match rng.random::<bool>() {
                true => triangles.extend([[p, q, r], [p, r, s]]),
                false => triangles.extend([[p, q, s], [q, r, s]]),
            }
        }
    }
    compact(&vertices, &triangles)
}

/// A small grid with random heights: saddles and peaks everywhere.
pub fn rough(n: usize, seed: u64, height: f64, hole: impl Fn(usize, usize) -> bool) -> SurfaceMesh {
    let mut heights = rng(seed ^ 0x5eed);
    grid(n, seed, 0.6, hole, |p| Point3::new(p.x, p.y, height * (heights.random::<f64>() - 0.5)))
}

/// Ends of all edges along the boundary.
pub fn boundary_edges(mesh: &SurfaceMesh) -> Vec<[u32; 2]> {
    let around =
        |chain: Vec<u32>| (0..chain.len()).map(|k| [chain[k], chain[(k + 1) % chain.len()]]).collect::<Vec<_>>();
    mesh.boundary_loops().into_iter().flat_map(around).collect()
}

/// Straight distance from a point to a segment.
pub fn to_segment(p: Point3<f64>, a: Point3<f64>, b: Point3<f64>) -> f64 {
    let t = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
    (a + (b - a) * t - p).norm()
}

/// Straight distance from a point to the nearest of the edges.
pub fn to_edges(mesh: &SurfaceMesh, edges: &[[u32; 2]], p: Point3<f64>) -> f64 {
    let ends = |e: &[u32; 2]| e.map(|v| mesh.vertices()[v as usize]);
    edges.iter().map(ends).map(|[a, b]| to_segment(p, a, b)).fold(f64::INFINITY, f64::min)
}

/// Each triangle cut into four at the middles of its edges. Old vertices keep their numbers.
pub fn refined(mesh: &SurfaceMesh) -> SurfaceMesh {
    let mut vertices = mesh.vertices().to_vec();
    let mut middles = std::collections::BTreeMap::new();
    let mut triangles = Vec::new();
    for &[a, b, c] in mesh.triangles() {
        let [d, e, f] = [[a, b], [b, c], [c, a]].map(|[from, to]| {
            *middles.entry([from.min(to), from.max(to)]).or_insert_with(|| {
                let middle = (mesh.vertices()[from as usize].coords + mesh.vertices()[to as usize].coords) / 2.0;
                vertices.push(middle.into());
                vertices.len() as u32 - 1
            })
        });
        triangles.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
    }
    SurfaceMesh::new(vertices, triangles).unwrap()
}

/// Barycentric coordinates of a random point of a triangle.
pub fn random_barycentric(rng: &mut Pcg64Mcg) -> [f64; 3] {
    let [mut a, mut b]: [f64; 2] = [rng.random(), rng.random()];
    if a + b > 1.0 {
        (a, b) = (1.0 - a, 1.0 - b);
    }
    [1.0 - a - b, a, b]
}
