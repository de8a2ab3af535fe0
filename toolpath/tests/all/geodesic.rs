//! Geodesic distance against closed forms, and against a slow search over all straight lines.

use crate::common::{
    boundary_edges, compact, go_on, grid, random_barycentric, refined, rng, rough, slow, to_boundary, to_edges,
};

use curvlay_toolpath::geodesic::{DistanceError, Sources, SurfaceDistance};
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Isometry3, Point3, Translation3, Vector3};
use proptest::prelude::*;
use rand::RngExt;
use slow::slow_distance;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Bound on the error of a distance, as a share of the size of the mesh.
const EXACT: f64 = 1e-12;

fn size(mesh: &SurfaceMesh) -> f64 {
    let p = mesh.vertices();
    p.iter().map(|q| (q - p[0]).norm()).fold(0.0, f64::max)
}

fn to<'m>(mesh: &'m SurfaceMesh, edges: &[[u32; 2]], vertices: &[u32]) -> SurfaceDistance<'m> {
    SurfaceDistance::to(mesh, Sources { edges, vertices }, &go_on).unwrap()
}

/// Compares vertices and some points of each triangle with a closed form.
fn agrees(distance: &SurfaceDistance, exact: impl Fn(Point3<f64>) -> f64, bound: f64) {
    let mesh = distance.mesh();
    for (v, &p) in mesh.vertices().iter().enumerate() {
        let (ours, exact) = (distance.at_vertex(v as u32), exact(p));
        assert!((ours - exact).abs() <= bound, "vertex {v} at {p}: {ours} instead of {exact}");
    }
    let mut rng = rng(1);
    for triangle in 0..mesh.triangles().len() as u32 {
        for _ in 0..3 {
            let barycentric = random_barycentric(&mut rng);
            let p = mesh.point(triangle, barycentric);
            let (ours, exact) = (distance.at(triangle, barycentric).distance, exact(p));
            assert!((ours - exact).abs() <= bound, "triangle {triangle} at {p}: {ours} instead of {exact}");
        }
    }
}

fn plane_agrees(mesh: &SurfaceMesh) {
    let edges = boundary_edges(mesh);
    let distance = to_boundary(mesh);
    agrees(&distance, |p| to_edges(mesh, &edges, p), EXACT * size(mesh));
}

#[test]
fn plane_with_holes_and_reflex_corners() {
    for (seed, jitter) in [(1, 0.0), (2, 0.6), (3, 0.6)] {
        // An L with two holes, one of them an L too, sheared so that no corner is a right angle.
        let hole = |i: usize, j: usize| {
            (i >= 14 && j >= 12)
                || (4..8).contains(&i) && (4..7).contains(&j)
                || (12..16).contains(&i) && (3..6).contains(&j) && (i < 14 || j < 4)
        };
        let shear = 0.37 * (seed - 1) as f64;
        plane_agrees(&grid(20, seed, jitter, hole, |p| Point3::new(p.x + shear * p.y, 0.8 * p.y, 0.0)));
    }
}

#[test]
fn tilted_plane_far_from_the_origin() {
    let pose = Isometry3::new(Vector3::new(300.0, -200.0, 500.0), Vector3::new(0.4, -0.7, 0.2));
    let hole = |i: usize, j: usize| (3..6).contains(&i) && (5..8).contains(&j);
    plane_agrees(&grid(10, 5, 0.6, hole, |p| pose * Point3::new(p.x, p.y, 0.0)));
}

/// A star around the origin: `rings` rings of `sectors` with a radius that changes from ray to ray.
fn star(rings: usize, radii: &[f64]) -> SurfaceMesh {
    let sectors = radii.len();
    let mut vertices = vec![Point3::origin()];
    let mut triangles = Vec::new();
    for ring in 1..=rings {
        for (k, radius) in radii.iter().enumerate() {
            let (sin, cos) = (TAU * k as f64 / sectors as f64).sin_cos();
            vertices.push(Point3::new(cos, sin, 0.0) * (radius * ring as f64 / rings as f64));
            let at = |ring: usize, k: usize| (1 + (ring - 1) * sectors + k % sectors) as u32;
            if ring == 1 {
                triangles.push([0, at(1, k), at(1, k + 1)]);
            } else {
                let [a, b, c, d] = [at(ring - 1, k), at(ring, k), at(ring, k + 1), at(ring - 1, k + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    SurfaceMesh::new(vertices, triangles).unwrap()
}

#[test]
fn stars_with_long_thin_triangles() {
    plane_agrees(&star(1, &[10.0; 12]));
    plane_agrees(&star(7, &[10.0; 40]));
    let radii: Vec<f64> = (0..48).map(|k| if k % 2 == 0 { 10.0 } else { 4.0 }).collect();
    plane_agrees(&star(3, &radii));
    let mut rng = rng(3);
    let radii: Vec<f64> = (0..30).map(|_| 3.0 + 7.0 * rng.random::<f64>()).collect();
    plane_agrees(&star(5, &radii));
}

#[test]
fn inner_polylines_points_and_both_at_once_in_a_convex_plane() {
    let mesh = grid(12, 8, 0.6, |_, _| false, |p| Point3::new(p.x + 0.2 * p.y, p.y, 0.0));
    let at = |i: u32, j: u32| {
        // The vertex that came from place (i, j), which moved by less than half a square.
        let near = Point3::new(f64::from(i) + 0.2 * f64::from(j), f64::from(j), 0.0);
        let nearest = |a: &&Point3<f64>, b: &&Point3<f64>| (*a - near).norm().total_cmp(&(*b - near).norm());
        let found = mesh.vertices().iter().min_by(nearest).unwrap();
        mesh.vertices().iter().position(|p| p == found).unwrap() as u32
    };
    let polyline: Vec<[u32; 2]> =
        (2..7).map(|i| [at(i, 5), at(i + 1, 5)]).chain((5..8).map(|j| [at(7, j + 1), at(7, j)])).collect();
    agrees(&to(&mesh, &polyline, &[]), |p| to_edges(&mesh, &polyline, p), EXACT * size(&mesh));
    let points = [at(3, 3), at(9, 9), at(0, 12)];
    let to_points = |p: Point3<f64>| {
        points.map(|v| (mesh.vertices()[v as usize] - p).norm()).into_iter().fold(f64::INFINITY, f64::min)
    };
    agrees(&to(&mesh, &[], &points), to_points, EXACT * size(&mesh));
    agrees(&to(&mesh, &polyline, &points), |p| to_points(p).min(to_edges(&mesh, &polyline, p)), EXACT * size(&mesh));
}

/// A prism over a polygon, open at both ends, and for each vertex its place when unrolled.
fn prism(sides: usize, rows: usize, height: f64) -> (SurfaceMesh, Vec<[f64; 2]>, f64) {
    let side = 2.0 * 10.0 * (TAU / (2 * sides) as f64).sin();
    let (mut vertices, mut unrolled, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..=rows {
        for k in 0..sides {
            let (sin, cos) = (TAU * k as f64 / sides as f64).sin_cos();
            let z = height * row as f64 / rows as f64;
            vertices.push(Point3::new(10.0 * cos, 10.0 * sin, z));
            unrolled.push([side * k as f64, z]);
            if row > 0 {
                let at = |row: usize, k: usize| (row * sides + k % sides) as u32;
                let [a, b, c, d] = [at(row - 1, k), at(row - 1, k + 1), at(row, k + 1), at(row, k)];
                if (row + k) % 2 == 0 {
                    triangles.extend([[a, b, c], [a, c, d]])
                } else {
                    triangles.extend([[a, b, d], [b, c, d]])
                }
            }
        }
    }
    (SurfaceMesh::new(vertices, triangles).unwrap(), unrolled, side * sides as f64)
}

#[test]
fn cylinder_unrolled() {
    let (mesh, unrolled, girth) = prism(24, 15, 30.0);
    agrees(&to_boundary(&mesh), |p| p.z.min(30.0 - p.z), EXACT * 40.0);
    let across = |a: f64, b: f64| (a - b).abs().min(girth - (a - b).abs());
    let (point, column) = (5 + 24 * 3, 7u32);
    let from_point = to(&mesh, &[], &[point]);
    let line: Vec<[u32; 2]> = (2..9).map(|row| [24 * row + column, 24 * (row + 1) + column]).collect();
    let from_line = to(&mesh, &line, &[]);
    for (v, &[x, z]) in unrolled.iter().enumerate() {
        let [px, pz] = unrolled[point as usize];
        let exact = across(x, px).hypot(z - pz);
        assert!((from_point.at_vertex(v as u32) - exact).abs() <= EXACT * 40.0, "vertex {v}");
        let beyond = (4.0 - z).max(z - 18.0).max(0.0); // the line goes from 4 to 18
        let exact = across(x, unrolled[column as usize][0]).hypot(beyond);
        assert!((from_line.at_vertex(v as u32) - exact).abs() <= EXACT * 40.0, "vertex {v}");
    }
}

/// A cone of flat sectors with the apex at the origin: rays on the unit sphere, alternately lifted. Returns for each
/// vertex its distance from the apex and its angle in the unrolled cone, and the whole angle.
fn cone(rays: usize, rings: usize, lift: impl Fn(usize) -> f64) -> (SurfaceMesh, Vec<[f64; 2]>, f64) {
    let ray = |k: usize| {
        let (sin, cos) = (TAU * (k % rays) as f64 / rays as f64).sin_cos();
        Vector3::new(cos, sin, lift(k % rays)).normalize()
    };
    let angle = |k: usize| (0..k).map(|k| ray(k).angle(&ray(k + 1))).sum::<f64>();
    let (mut vertices, mut polar, mut triangles) = (vec![Point3::origin()], vec![[0.0, 0.0]], Vec::new());
    for ring in 1..=rings {
        for k in 0..rays {
            vertices.push(Point3::from(ray(k) * ring as f64));
            polar.push([ring as f64, angle(k)]);
            let at = |ring: usize, k: usize| (1 + (ring - 1) * rays + k % rays) as u32;
            if ring == 1 {
                triangles.push([0, at(1, k), at(1, k + 1)]);
            } else {
                let [a, b, c, d] = [at(ring - 1, k), at(ring, k), at(ring, k + 1), at(ring - 1, k + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    (SurfaceMesh::new(vertices, triangles).unwrap(), polar, angle(rays))
}

fn cone_agrees(rays: usize, rings: usize, lift: impl Fn(usize) -> f64, saddle: bool) {
    let (mesh, polar, whole) = cone(rays, rings, lift);
    assert_eq!(whole > TAU + 0.1, saddle);
    for from in [1 + 2 * rays, 3 * rays + 2] {
        let distance = to(&mesh, &[], &[from as u32]);
        for (v, &[radius, angle]) in polar.iter().enumerate() {
            let turned = (angle - polar[from][1]).abs();
            let turned = turned.min(whole - turned);
            let r = polar[from][0];
            let exact = if turned >= TAU / 2.0 {
                r + radius
            } else {
                (r * r + radius * radius - 2.0 * r * radius * turned.cos()).max(0.0).sqrt()
            };
            // The rim is not convex: lines near it may leave the cone.
            if polar[from][0] + radius < 0.7 * rings as f64 {
                let ours = distance.at_vertex(v as u32);
                assert!((ours - exact).abs() <= EXACT * rings as f64, "vertex {v}: {ours} instead of {exact}");
            }
        }
    }
}

#[test]
fn cones_unrolled() {
    cone_agrees(9, 12, |_| 0.8, false);
    cone_agrees(16, 12, |_| 2.0, false);
    cone_agrees(10, 12, |k| if k % 2 == 0 { 0.5 } else { -0.5 }, true);
    cone_agrees(14, 12, |k| if k % 2 == 0 { 0.9 } else { -0.4 }, true);
}

#[test]
fn more_triangles_on_the_same_surface_change_nothing() {
    for seed in 0..4 {
        let coarse = rough(7, seed, 1.5, |i, j| i == 3 && j == 3);
        let fine = refined(&refined(&coarse));
        let (one, other) = (to_boundary(&coarse), to_boundary(&fine));
        for v in 0..coarse.vertices().len() as u32 {
            assert!((one.at_vertex(v) - other.at_vertex(v)).abs() <= EXACT * 10.0, "seed {seed}, vertex {v}");
        }
        // And the distance inside of coarse triangles is that at the new vertices.
        for (triangle, corners) in coarse.triangles().iter().enumerate() {
            let middle = coarse.point(triangle as u32, [0.5, 0.25, 0.25]);
            let v = fine.vertices().iter().position(|p| (p - middle).norm() < 1e-12).unwrap();
            let inside = one.at(triangle as u32, [0.5, 0.25, 0.25]).distance;
            assert!((inside - other.at_vertex(v as u32)).abs() <= EXACT * 10.0, "triangle {triangle} {corners:?}");
        }
    }
}

#[test]
fn moved_scaled_and_renumbered() {
    let mesh = rough(12, 21, 1.5, |i, j| i == 7 && j < 9 && j > 2);
    let distance = to_boundary(&mesh);
    let pose = Isometry3::from_parts(
        Translation3::new(40.0, -7.0, 90.0),
        Isometry3::rotation(Vector3::new(1.0, 2.0, -0.5)).rotation,
    );
    for scale in [1.0, 1e-3, 1e3] {
        let moved: Vec<_> = mesh.vertices().iter().map(|p| pose * (p * scale)).collect();
        let moved = SurfaceMesh::new(moved, mesh.triangles().to_vec()).unwrap();
        let other = to_boundary(&moved);
        for v in 0..mesh.vertices().len() as u32 {
            let rounding = 1e-15 * 100.0 * 20.0; // of coordinates up to 100, over 20 triangles
            let bound = EXACT * 20.0 * scale + rounding;
            assert!((other.at_vertex(v) - scale * distance.at_vertex(v)).abs() <= bound, "scale {scale}, vertex {v}");
        }
    }
    // Vertices and triangles in another order, with other first corners.
    let (n, mut rng) = (mesh.vertices().len(), rng(22));
    let mut order: Vec<u32> = (0..n as u32).collect();
    (1..n).for_each(|k| order.swap(k, rng.random_range(0..=k)));
    let mut vertices = vec![Point3::origin(); n];
    order.iter().enumerate().for_each(|(old, &new)| vertices[new as usize] = mesh.vertices()[old]);
    let turned = |(k, t): (usize, &[u32; 3])| [0, 1, 2].map(|c| order[t[(c + k) % 3] as usize]);
    let mut triangles: Vec<[u32; 3]> = mesh.triangles().iter().enumerate().map(turned).collect();
    triangles.reverse();
    let renumbered = SurfaceMesh::new(vertices, triangles).unwrap();
    let other = to_boundary(&renumbered);
    for (old, &new) in order.iter().enumerate() {
        assert!((other.at_vertex(new) - distance.at_vertex(old as u32)).abs() <= EXACT * 20.0, "vertex {old}");
    }
}

#[test]
fn the_same_twice() {
    let mesh = rough(15, 9, 1.0, |i, j| i > 10 && j > 11);
    let [one, other] = [to_boundary(&mesh), to_boundary(&mesh)];
    let bits = |d: &SurfaceDistance| d.at_vertices().iter().map(|d| d.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&one), bits(&other));
}

#[test]
fn corners_of_triangles_are_vertices() {
    let mesh = rough(10, 31, 1.5, |i, j| (i == 2 || i == 6) && j == 4);
    let distance = to_boundary(&mesh);
    for (triangle, corners) in mesh.triangles().iter().enumerate() {
        for (k, &v) in corners.iter().enumerate() {
            let mut barycentric = [0.0; 3];
            barycentric[k] = 1.0;
            let there = distance.at(triangle as u32, barycentric).distance;
            assert!((there - distance.at_vertex(v)).abs() <= EXACT * 15.0, "triangle {triangle}, vertex {v}");
        }
    }
}

#[test]
fn both_sides_of_an_edge_agree() {
    let mesh = rough(10, 33, 1.5, |_, _| false);
    let distance = to_boundary(&mesh);
    for triangle in 0..mesh.triangles().len() as u32 {
        for k in 0..3 {
            let Some(other) = mesh.neighbours(triangle)[k] else { continue };
            let back = mesh.neighbours(other).iter().position(|&n| n == Some(triangle)).unwrap();
            for t in [0.1, 0.35, 0.5, 0.8] {
                let (mut here, mut there) = ([0.0; 3], [0.0; 3]);
                (here[k], here[(k + 1) % 3]) = (1.0 - t, t);
                (there[back], there[(back + 1) % 3]) = (t, 1.0 - t);
                let (here, there) = (distance.at(triangle, here).distance, distance.at(other, there).distance);
                assert!((here - there).abs() <= EXACT * 15.0, "triangle {triangle}, side {k}, {t}: {here}, {there}");
            }
        }
    }
}

#[test]
fn direction_is_the_slope() {
    let mesh = rough(9, 41, 1.2, |_, _| false);
    let distance = to_boundary(&mesh);
    let mut rng = rng(5);
    let (mut asked, mut near_ridge) = (0, 0);
    for triangle in 0..mesh.triangles().len() as u32 {
        let [a, b, c] = mesh.triangles()[triangle as usize].map(|v| mesh.vertices()[v as usize]);
        let barycentric = random_barycentric(&mut rng);
        let here = distance.at(triangle, barycentric);
        assert!((here.direction.norm() - 1.0).abs() < 1e-12);
        assert!(here.direction.dot(&(b - a).cross(&(c - a)).normalize()).abs() < 1e-12);
        for (k, side) in [c - b, a - c].into_iter().enumerate() {
            // A step along a side: weight moves from one corner to another.
            let step = 1e-6;
            let (mut before, mut after) = (barycentric, barycentric);
            let (from, into) = ([1, 2][k], [2, 0][k]);
            (before[from], before[into]) = (before[from] + step, before[into] - step);
            (after[from], after[into]) = (after[from] - step, after[into] + step);
            let slope = (distance.at(triangle, after).distance - distance.at(triangle, before).distance) / (2.0 * step);
            asked += 1;
            near_ridge += usize::from((slope - here.direction.dot(&side)).abs() > 1e-5);
        }
    }
    // Only a step over a ridge, where two sources are equally far, may show another slope.
    assert!(near_ridge * 100 <= asked, "{near_ridge} of {asked}");
}

#[test]
fn thin_triangles() {
    // Slivers down to 1e-9 of their length, as trimming leaves them.
    for thin in [1e-3, 1e-6, 1e-9] {
        let rows = [0.0, 1.0, 1.0 + thin, 2.0, 3.0 - thin, 3.0];
        let mesh = grid(5, 4, 0.0, |_, _| false, |p| Point3::new(p.x, rows[p.y.round() as usize], 0.0));
        plane_agrees(&mesh);
    }
}

#[test]
fn parts_without_a_source_are_infinitely_far() {
    let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut vertices: Vec<Point3<f64>> = corners.map(Point3::from).to_vec();
    vertices.extend(corners.map(|[x, y, _]| Point3::new(x + 5.0, y, 0.0)));
    let triangles: Vec<[u32; 3]> = tetrahedron.into_iter().chain([[4, 5, 6]]).collect();
    let mesh = SurfaceMesh::new(vertices, triangles).unwrap();
    let distance = to_boundary(&mesh);
    assert_eq!(distance.at_vertices()[..4], [f64::INFINITY; 4]);
    assert_eq!(distance.at_vertices()[4..7], [0.0; 3]);
    assert!(distance.at_vertex(7).is_infinite(), "no triangle has this vertex");
    let far = distance.at(1, [0.2, 0.3, 0.5]);
    assert_eq!((far.distance, far.direction), (f64::INFINITY, Vector3::zeros()));
    assert!((distance.at(4, [1.0 / 3.0; 3]).distance - 1.0 / 18f64.sqrt()).abs() < 1e-15, "from the longest side");
}

#[test]
fn what_cannot_be_measured() {
    let tetrahedron = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [9.0, 9.0, 9.0]];
    let closed = SurfaceMesh::new(corners.map(Point3::from).to_vec(), tetrahedron).unwrap();
    let error = |edges: &[[u32; 2]], vertices: &[u32]| {
        SurfaceDistance::to(&closed, Sources { edges, vertices }, &go_on).unwrap_err()
    };
    assert_eq!(SurfaceDistance::to_boundary(&closed, &go_on).unwrap_err(), DistanceError::NoBoundary);
    assert_eq!(error(&[], &[]), DistanceError::NoSource);
    assert_eq!(error(&[[0, 1], [0, 4]], &[]), DistanceError::NoSuchEdge { edge: 1, ends: [0, 4] });
    assert_eq!(error(&[[u32::MAX, 1]], &[]), DistanceError::NoSuchEdge { edge: 0, ends: [u32::MAX, 1] });
    assert_eq!(error(&[], &[0, 5]), DistanceError::NoSuchVertex { vertex: 5 });
    assert_eq!(error(&[], &[4]), DistanceError::NoSuchVertex { vertex: 4 });
    let stop = |_| ControlFlow::Break(());
    let stopped = SurfaceDistance::to(&closed, Sources { edges: &[], vertices: &[0] }, &stop);
    assert_eq!(stopped.unwrap_err(), DistanceError::Cancelled);
}

/// Agreement with the slow search at the vertices, and inside of a triangle by cutting it there.
fn agrees_with_the_slow_search(
    mesh: &SurfaceMesh,
    edges: &[[u32; 2]],
    vertices: &[u32],
    seed: u64,
) -> Result<(), TestCaseError> {
    let distance = to(mesh, edges, vertices);
    let slow = slow_distance(mesh, edges, vertices);
    for (v, &slow) in slow.iter().enumerate() {
        let ours = distance.at_vertex(v as u32);
        prop_assert!((ours - slow).abs() <= EXACT * 10.0, "vertex {}: {} instead of {}", v, ours, slow);
    }
    let mut rng = rng(seed);
    let triangle = rng.random_range(0..mesh.triangles().len());
    let barycentric = random_barycentric(&mut rng);
    let mut points = mesh.vertices().to_vec();
    points.push(mesh.point(triangle as u32, barycentric));
    let new = points.len() as u32 - 1;
    let mut triangles = mesh.triangles().to_vec();
    let [a, b, c] = triangles.swap_remove(triangle);
    triangles.extend([[a, b, new], [b, c, new], [c, a, new]]);
    let slow = slow_distance(&SurfaceMesh::new(points, triangles).unwrap(), edges, vertices)[new as usize];
    let ours = distance.at(triangle as u32, barycentric).distance;
    prop_assert!(
        (ours - slow).abs() <= EXACT * 10.0,
        "triangle {} at {:?}: {} instead of {}",
        triangle,
        barycentric,
        ours,
        slow
    );
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn boundary_distance_is_that_of_the_slow_search(
        seed in 0u64..1 << 40, height in 0.0..4.0f64, hole in any::<bool>(),
    ) {
        let mesh = rough(4, seed, height, |i, j| hole && i == 1 && j == 2);
        agrees_with_the_slow_search(&mesh, &boundary_edges(&mesh), &[], seed)?;
    }

    #[test]
    fn distance_to_anything_is_that_of_the_slow_search(
        seed in 0u64..1 << 40, height in 0.0..4.0f64, count in 0usize..3,
    ) {
        let mesh = rough(4, seed, height, |i, j| i == 2 && j == 1);
        let mut rng = rng(seed ^ 7);
        let mut side = || {
            let t = mesh.triangles()[rng.random_range(0..mesh.triangles().len())];
            [t[0], t[1]]
        };
        let edges: Vec<[u32; 2]> = (0..count).map(|_| side()).collect();
        let vertices: Vec<u32> = (count..2).map(|_| side()[0]).collect();
        agrees_with_the_slow_search(&mesh, &edges, &vertices, seed)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// On surfaces of any kind, stretched up to 100 to 1, where the slow search is out of reach: more triangles on the
    /// same surface change nothing, no vertex is missed, and triangles agree with vertices.
    #[test]
    fn refining_changes_nothing(
        seed in any::<u64>(), n in 3usize..16, height in 0.0..4.0f64,
        stretch in prop::sample::select(vec![1.0, 0.01, 30.0]), jitter in prop::sample::select(vec![0.0, 0.3, 0.8]),
        kind in 0..3, points in any::<bool>(),
    ) {
        let mut random = rng(seed);
        let mesh = grid(n, seed, jitter, |i, j| i == n / 2 && j > n / 2 && j + 1 < n, |p| {
            let z = match kind {
                0 => random.random::<f64>() - 0.5,
                1 => (0.6 * p.x).sin() * (0.5 * p.y).cos(),
                _ => (2.0 * random.random::<f64>()).round(), // terraces: many ways of equal length
            };
            Point3::new(stretch * p.x, p.y, height * z)
        });
        let vertices = [seed as u32 % 7, mesh.vertices().len() as u32 - 1];
        let fine = refined(&mesh);
        let measure = |mesh| if points { to(mesh, &[], &vertices) } else { to_boundary(mesh) };
        let (one, other) = (measure(&mesh), measure(&fine));
        let bound = EXACT * size(&mesh);
        for (triangle, corners) in mesh.triangles().iter().enumerate() {
            for (k, &v) in corners.iter().enumerate() {
                let mut corner = [0.0; 3];
                corner[k] = 1.0;
                let there = one.at(triangle as u32, corner).distance;
                prop_assert!((there - one.at_vertex(v)).abs() <= bound, "triangle {}, vertex {}", triangle, v);
                prop_assert!((other.at_vertex(v) - one.at_vertex(v)).abs() <= bound, "vertex {}", v);
            }
        }
    }
}

/// A fine mesh: the slow search is out of reach, a graph with points on the edges is not. Its paths exist, so it is
/// never shorter; with twice the points it comes nearer.
#[test]
fn bounded_by_graphs_with_points_on_edges() {
    let mesh = grid(
        24,
        77,
        0.6,
        |i, j| (8..12).contains(&i) && (8..15).contains(&j),
        |p| Point3::new(p.x, p.y, 2.0 * (0.5 * p.x).sin() * (0.4 * p.y).cos()),
    );
    let distance = to_boundary(&mesh);
    let mut last = f64::INFINITY;
    for points in [1, 3, 7, 15] {
        let graph = graph_distance(&mesh, points);
        let mut worst: f64 = 0.0;
        for (v, &graph) in graph.iter().enumerate() {
            let ours = distance.at_vertex(v as u32);
            assert!(ours <= graph + EXACT * 30.0, "vertex {v}: {ours} is longer than {graph}");
            worst = worst.max(graph - ours);
        }
        assert!(worst < 0.5 * last, "{points} points on each edge: {worst} after {last}");
        last = worst;
    }
    assert!(last < 0.02, "{last}");
}

/// Shortest paths along lines between points on the sides of each triangle.
fn graph_distance(mesh: &SurfaceMesh, points: usize) -> Vec<f64> {
    let n = mesh.vertices().len();
    let mut nodes = mesh.vertices().to_vec();
    let mut on_edge = std::collections::BTreeMap::new();
    let mut links: Vec<Vec<(usize, f64)>> = Vec::new();
    let mut rims = Vec::new();
    for t in mesh.triangles() {
        let mut sides = Vec::new();
        for k in 0..3 {
            let (a, b) = (t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3]));
            let first = *on_edge.entry((a, b)).or_insert_with(|| {
                let [from, to] = [a, b].map(|v| mesh.vertices()[v as usize]);
                nodes.extend((1..=points).map(|k| from + (to - from) * (k as f64 / (points + 1) as f64)));
                nodes.len() - points
            });
            sides.extend([a as usize, b as usize]);
            sides.extend(first..first + points);
        }
        links.resize(nodes.len(), Vec::new());
        for &one in &sides {
            links[one].extend(
                sides.iter().filter(|&&other| other != one).map(|&other| (other, (nodes[one] - nodes[other]).norm())),
            );
        }
    }
    for [a, b] in boundary_edges(mesh) {
        let first = on_edge[&(a.min(b), a.max(b))];
        rims.extend((first..first + points).chain([a as usize, b as usize]));
    }
    let mut distance = vec![f64::INFINITY; nodes.len()];
    let mut queue = std::collections::BTreeSet::new();
    for rim in rims {
        distance[rim] = 0.0;
        queue.insert((0u64, rim));
    }
    // Bits of positive numbers are in the order of the numbers.
    while let Some((_, node)) = queue.pop_first() {
        for &(other, length) in &links[node] {
            let through = distance[node] + length;
            if through < distance[other] {
                distance[other] = through;
                queue.insert((through.to_bits(), other));
            }
        }
    }
    distance.truncate(n);
    distance
}

#[test]
fn one_triangle_and_a_strip_of_them() {
    let mesh = compact(&[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]].map(Point3::from), &[[0, 1, 2]]);
    // The centre of the inscribed circle, with radius 1.
    assert!((to_boundary(&mesh).at(0, [5.0 / 12.0, 3.0 / 12.0, 4.0 / 12.0]).distance - 1.0).abs() < 1e-15);
    plane_agrees(&mesh);
}

#[test]
fn a_vertex_beside_the_shadow_of_the_one_before_is_reached() {
    // Three rows of vertices up a sheet that unrolls into a plane but for a little: each lies behind the one before, as
    // seen from the rim, in its shadow or just beside it. Ways that bent by a billionth turned a shadow by as much; that
    // left a gap, ever wider, and vertex 11 was in it.
    let corners = [
        [0.0, 1.6586147e-05, 7.5875218e-05],
        [0.0, 0.04787964359, 0.082691127699],
        [0.0, 0.570343198993, 0.643257026393],
        [0.0, 1.095194218813, 1.165720581796],
        [0.0, 1.617657774216, 1.438537152369],
        [0.0, 2.621775737394, 1.445259459326],
        [0.879696641, 1.6572341e-05, 7.5930955e-05],
        [1.044927111, 1.5888606e-05, 7.6429526e-05],
        [1.044927111, 0.047879615158, 0.082691173135],
        [1.044927111, 0.570343170561, 0.643257052682],
        [1.044927111, 1.095194180064, 1.165720608084],
        [1.044927111, 1.617657735467, 1.438537152237],
        [1.044927111, 2.621775737394, 1.445259459194],
        [1.924621057, 1.1855101e-05, 7.9365748e-05],
        [2.089854222, 9.286362e-06, 8.1215098e-05],
        [2.089854222, 0.047876089491, 0.082696845092],
        [2.089854222, 0.570339644894, 0.643259953663],
        [2.089854222, 1.095189922151, 1.165723509065],
        [2.089854222, 1.617653477554, 1.43853716429],
        [2.089854222, 2.621775737394, 1.44525947129],
    ];
    let triangles = vec![
        [1, 6, 8],
        [6, 1, 0],
        [8, 6, 7],
        [8, 13, 15],
        [13, 8, 7],
        [15, 13, 14],
        [8, 2, 1],
        [8, 9, 2],
        [2, 10, 3],
        [2, 9, 10],
        [15, 9, 8],
        [15, 16, 9],
        [9, 17, 10],
        [9, 16, 17],
        [11, 3, 10],
        [11, 4, 3],
        [4, 12, 5],
        [4, 11, 12],
        [18, 10, 17],
        [18, 11, 10],
        [11, 19, 12],
        [11, 18, 19],
    ];
    let mesh = SurfaceMesh::new(corners.map(Point3::from).to_vec(), triangles).unwrap();
    let distance = to(&mesh, &[[0, 6], [6, 7], [7, 13], [13, 14]], &[]);
    // Neighbours in the same row across are as far.
    for (v, other) in [(11, 4), (12, 5), (18, 11)] {
        let [found, beside] = [v, other].map(|v| distance.at_vertex(v));
        assert!((found - beside).abs() < 1e-5, "{v}: {found}, {beside}");
    }
}
