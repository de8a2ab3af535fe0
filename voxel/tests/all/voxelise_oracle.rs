//! Cells of triangles and tetrahedra against separating axes for every cell, in whole numbers. The cells are powers
//! of two, so that nothing is rounded on the way to the lattice.

use crate::common::Mesh;
use curvlay_voxel::nalgebra::{Point3, Vector3};
use curvlay_voxel::{Resolution, VoxelError, VoxelGrid, orient};
use proptest::prelude::*;
use std::collections::BTreeSet;

type P = [i128; 3];

fn minus(a: P, b: P) -> P {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: P, b: P) -> P {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: P, b: P) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Whether the open cube with that low corner and side misses the closed convex hull of the points: there is an axis
/// among all that can matter (even for flat hulls) along which they do not overlap.
fn misses(low: P, side: i128, hull: &[P]) -> bool {
    let units = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let mut edges = Vec::new();
    for (at, &a) in hull.iter().enumerate() {
        edges.extend(hull[at + 1..].iter().map(|&b| minus(b, a)));
    }
    let mut axes = units.to_vec();
    axes.extend(edges.iter().flat_map(|&edge| units.map(|unit| cross(unit, edge))));
    for &a in &edges {
        for &b in &edges {
            let normal = cross(a, b);
            axes.push(normal);
            axes.push(cross(normal, a));
        }
    }
    axes.into_iter().filter(|&axis| axis != [0; 3]).any(|axis| {
        let corner = |k: usize| [0, 1, 2].map(|i| low[i] + if k >> i & 1 == 1 { side } else { 0 });
        let cube: Vec<_> = (0..8).map(|k| dot(axis, corner(k))).collect();
        let body: Vec<_> = hull.iter().map(|&at| dot(axis, at)).collect();
        cube.iter().max() <= body.iter().min() || body.iter().max() <= cube.iter().min()
    })
}

/// The cells of edge `unit` that meet any of the hulls. The grid begins at their least coordinates.
fn slow_cells(hulls: &[Vec<P>], unit: i128) -> BTreeSet<[u32; 3]> {
    let all = || hulls.iter().flatten();
    let low = [0, 1, 2].map(|axis| all().map(|at| at[axis]).min().expect("points"));
    let high = [0, 1, 2].map(|axis| all().map(|at| at[axis]).max().expect("points"));
    let end = [0, 1, 2].map(|axis| ((high[axis] - low[axis]) / unit + 1) as u32);
    let mut cells = BTreeSet::new();
    for x in 0..end[0] {
        for y in 0..end[1] {
            for z in 0..end[2] {
                let corner = minus([x, y, z].map(|c| i128::from(c) * unit), low.map(|c| -c));
                if hulls.iter().any(|hull| !misses(corner, unit, hull)) {
                    cells.insert([x, y, z]);
                }
            }
        }
    }
    cells
}

fn fast_cells(mesh: &Mesh, unit: i128) -> Result<VoxelGrid, VoxelError> {
    mesh.with(Resolution::Cell(unit as f64)).map(|solid| solid.grid)
}

fn as_set(grid: &VoxelGrid) -> BTreeSet<[u32; 3]> {
    grid.iter().map(|id| grid.position(id)).collect()
}

fn mesh_of(points: &[P], faces: &[[u32; 3]]) -> Mesh {
    let vertices = points.iter().map(|at| Point3::from(at.map(|c| c as f64))).collect();
    Mesh { vertices, triangles: faces.to_vec() }
}

/// The winding number by spherical excess: the angles of the spherical triangle less a half turn.
fn slow_winding(mesh: &Mesh, at: Point3<f64>) -> f64 {
    use std::f64::consts::PI;
    let excess = |corners: [Point3<f64>; 3]| {
        let [a, b, c] = corners.map(|corner| corner - at);
        let angle = |a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>| a.cross(&b).angle(&a.cross(&c));
        let volume = a.dot(&b.cross(&c));
        let sum = angle(a, b, c) + angle(b, c, a) + angle(c, a, b) - PI;
        if volume.abs() < 1e-9 { 0.0 } else { sum * volume.signum() }
    };
    mesh.corners().map(excess).sum::<f64>() / (4.0 * PI)
}

/// A tetrahedron with its faces outwards.
fn tetrahedron(points: &[P]) -> Mesh {
    let [a, b, c, d] = [0, 1, 2, 3].map(|k| points[k]);
    let mesh = mesh_of(points, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    if dot(cross(minus(b, a), minus(c, a)), minus(d, a)) < 0 { mesh.turned() } else { mesh }
}

fn points(count: usize, end: i128) -> impl Strategy<Value = Vec<P>> {
    prop::collection::vec([0..end, 0..end, 0..end], count)
}

fn collinear(at: &[P]) -> bool {
    at.iter().all(|&c| cross(minus(at[1], at[0]), minus(c, at[0])) == [0; 3])
        && at.iter().all(|&c| cross(minus(at[2], at[0]), minus(c, at[0])) == [0; 3])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Coarse steps, so that corners, edges and faces on planes of the grid are the rule.
    #[test]
    fn a_triangle_touches_the_cells_that_it_meets(at in points(3, 19), power in 0u32..4) {
        prop_assume!(!collinear(&at));
        let unit = 1 << power;
        let expected = slow_cells(std::slice::from_ref(&at), unit);
        match fast_cells(&mesh_of(&at, &[[0, 1, 2]]), unit) {
            Ok(grid) => prop_assert_eq!(as_set(&grid), expected),
            Err(VoxelError::Nothing { .. }) => prop_assert!(expected.is_empty()),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }

    /// Fine steps: corners anywhere.
    #[test]
    fn a_triangle_at_any_place_touches_the_cells_that_it_meets(at in points(3, 9 << 20)) {
        prop_assume!(!collinear(&at));
        let grid = fast_cells(&mesh_of(&at, &[[0, 1, 2]]), 1 << 20).unwrap();
        prop_assert_eq!(as_set(&grid), slow_cells(&[at], 1 << 20));
    }

    /// Closed bodies that pass through each other, flat ones among them; some faces within planes of the grid.
    #[test]
    fn tetrahedra_take_the_cells_that_their_union_meets(
        bodies in prop::collection::vec(points(4, 15), 1..4), power in 0u32..3, turn in any::<bool>()
    ) {
        let unit = 1 << power;
        let bodies: Vec<_> = bodies.into_iter().filter(|body| !collinear(body)).collect();
        prop_assume!(!bodies.is_empty());
        let mesh = bodies.iter().fold(Mesh::default(), |all, body| all.and(&tetrahedron(body)));
        let mesh = if turn { mesh.turned() } else { mesh };
        let expected = slow_cells(&bodies, unit);
        match fast_cells(&mesh, unit) {
            Ok(grid) => prop_assert_eq!(as_set(&grid), expected),
            Err(VoxelError::Nothing { .. }) => prop_assert!(expected.is_empty()),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }

    /// Faces missing, twice there or turned: each cell is decided by the winding number of its middle, the faces
    /// oriented first.
    #[test]
    fn broken_tetrahedra_are_filled_by_winding_number(
        bodies in prop::collection::vec(points(4, 15), 1..4), faults in prop::collection::vec((0usize..12, 0..3), 1..4)
    ) {
        let mut mesh = bodies.iter().fold(Mesh::default(), |all, body| all.and(&tetrahedron(body)));
        for (at, fault) in faults {
            let at = at % mesh.triangles.len();
            match fault {
                0 if mesh.triangles.len() > 1 => drop(mesh.triangles.remove(at)),
                1 => mesh.triangles.push(mesh.triangles[at]),
                _ => mesh.triangles[at].swap(0, 1),
            }
        }
        let as_points = |corners: [Point3<f64>; 3]| corners.map(|at| [at.x, at.y, at.z].map(|c| c as i128)).to_vec();
        let faces: Vec<_> = mesh.corners().map(as_points).filter(|face| !collinear(face)).collect();
        prop_assume!(!faces.is_empty());
        // Three faces at an edge can hang together one-sidedly.
        let oriented = match orient(&mesh.vertices, &mesh.triangles) {
            Ok(oriented) => Mesh { triangles: oriented.triangles, ..mesh.clone() },
            Err(_) => return Err(TestCaseError::reject("one-sided")),
        };
        let touched = slow_cells(&faces, 1);
        let low = [0, 1, 2].map(|axis| faces.iter().flatten().map(|at| at[axis]).min().expect("points"));
        let Ok(grid) = fast_cells(&mesh, 1) else { return Err(TestCaseError::reject("nothing is touched")) };
        for id in 0..grid.dims().iter().product() {
            let cell = grid.position(id);
            let middle = [0, 1, 2].map(|axis| f64::from(cell[axis]) + low[axis] as f64 + 0.5);
            let winding = slow_winding(&oriented, Point3::from(middle)).abs();
            if touched.contains(&cell) || winding > 0.53 {
                prop_assert!(grid.contains(cell), "{cell:?}, {winding}");
            } else if winding < 0.47 {
                prop_assert!(!grid.contains(cell), "{cell:?}, {winding}");
            }
        }
    }

    /// The order of triangles and of their corners does not matter.
    #[test]
    fn the_order_of_the_triangles_does_not_matter(bodies in prop::collection::vec(points(4, 40), 1..5), by in 1usize..9) {
        let mesh = bodies.iter().fold(Mesh::default(), |all, body| all.and(&tetrahedron(body)));
        let mut other = mesh.clone();
        other.triangles.rotate_left(by % mesh.triangles.len());
        other.triangles.iter_mut().for_each(|t| t.rotate_left(by % 3));
        prop_assert_eq!(fast_cells(&mesh, 3), fast_cells(&other, 3));
    }
}

/// Rows, layers and words enough to cross every border of windows and words.
#[test]
fn large_triangles_are_exact_over_windows_and_words() {
    for at in [[[0, 0, 0], [4001, 1502, 733], [90, 777, 1399]], [[0, 1300, 7], [2803, 1300, 7], [1401, 0, 911]]] {
        let unit = 8;
        let grid = fast_cells(&mesh_of(&at, &[[0, 1, 2]]), unit).unwrap();
        let low = [0, 1, 2].map(|axis| at.iter().map(|p| p[axis]).min().expect("points"));
        let mut checked = 0;
        for id in grid.iter().step_by(7) {
            for step in [[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]] {
                let cell = [0, 1, 2].map(|axis| i64::from(grid.position(id)[axis]) + step[axis]);
                let cell = cell.map(|c| c.max(0) as u32);
                let corner = [0, 1, 2].map(|axis| i128::from(cell[axis]) * unit + low[axis]);
                if cell.iter().zip(grid.dims()).all(|(&c, side)| c < side) {
                    assert_eq!(grid.contains(cell), !misses(corner, unit, &at), "{cell:?}");
                    checked += 1;
                }
            }
        }
        assert!(checked > 10_000);
    }
}
