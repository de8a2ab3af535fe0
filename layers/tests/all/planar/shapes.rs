//! Solids for the tests.

use curvlay_layers::nalgebra::{Point3, Vector3};
use curvlay_layers::planar::{CutPlane, Solid};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// The boundary of unit cells, scaled: coplanar faces, and planes through all its vertices at whole numbers.
pub fn blocks(cells: &[[i32; 3]], size: f64) -> Solid {
    let solid = |c: [i32; 3]| cells.contains(&c);
    let mut numbers: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for &cell in cells {
        for axis in 0..3 {
            for up in [0, 1] {
                let mut beside = cell;
                beside[axis] += 2 * up - 1;
                if solid(beside) {
                    continue;
                }
                let corner = |du: i32, dv: i32| {
                    let mut p = cell;
                    p[axis] += up;
                    p[(axis + 1) % 3] += du;
                    p[(axis + 2) % 3] += dv;
                    p
                };
                let mut quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if up == 0 {
                    quad.reverse();
                }
                let q = quad.map(|p| {
                    *numbers.entry(p).or_insert_with(|| {
                        vertices.push(Point3::from(p.map(|c| f64::from(c) * size)));
                        vertices.len() as u32 - 1
                    })
                });
                triangles.extend([[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
            }
        }
    }
    Solid::new(&vertices, &triangles).unwrap()
}

/// All cells of a box.
pub fn cells(low: [i32; 3], high: [i32; 3]) -> Vec<[i32; 3]> {
    let mut all = Vec::new();
    for z in low[2]..high[2] {
        for y in low[1]..high[1] {
            for x in low[0]..high[0] {
                all.push([x, y, z]);
            }
        }
    }
    all
}

pub fn cube() -> Solid {
    blocks(&[[0; 3]], 1.0)
}

/// A surface of revolution about z: points `(radius, z)` from the bottom up, both ends on the axis (radius 0).
pub fn turned(profile: &[[f64; 2]], sides: usize) -> Solid {
    let mut vertices = vec![Point3::new(0.0, 0.0, profile[0][1])];
    for &[r, z] in &profile[1..profile.len() - 1] {
        vertices.extend((0..sides).map(|k| {
            let angle = TAU * k as f64 / sides as f64;
            Point3::new(r * angle.cos(), r * angle.sin(), z)
        }));
    }
    vertices.push(Point3::new(0.0, 0.0, profile[profile.len() - 1][1]));
    let ring = |row: usize, k: usize| (1 + row * sides + k % sides) as u32;
    let rows = profile.len() - 2;
    let top = vertices.len() as u32 - 1;
    let mut triangles = Vec::new();
    for k in 0..sides {
        triangles.push([0, ring(0, k + 1), ring(0, k)]);
        for row in 1..rows {
            let [a, b, c, d] = [ring(row - 1, k), ring(row - 1, k + 1), ring(row, k + 1), ring(row, k)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([ring(rows - 1, k), ring(rows - 1, k + 1), top]);
    }
    Solid::new(&vertices, &triangles).unwrap()
}

/// A torus about z.
pub fn torus(radius: f64, tube: f64, [around, across]: [usize; 2]) -> Solid {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let at = |i: usize, k: usize| ((i % around) * across + k % across) as u32;
    for i in 0..around {
        for k in 0..across {
            let [a, b] = [TAU * i as f64 / around as f64, TAU * k as f64 / across as f64];
            let r = radius + tube * b.cos();
            vertices.push(Point3::new(r * a.cos(), r * a.sin(), tube * b.sin()));
            triangles.extend([[at(i, k), at(i + 1, k), at(i + 1, k + 1)], [at(i, k), at(i + 1, k + 1), at(i, k + 1)]]);
        }
    }
    Solid::new(&vertices, &triangles).unwrap()
}

pub fn plane(point: [f64; 3], normal: [f64; 3]) -> CutPlane {
    CutPlane::through(&Point3::from(point), &Vector3::from(normal)).unwrap()
}

/// Vertices less edges plus faces, of the vertices that faces use.
pub fn euler(solid: &Solid) -> i64 {
    let mut used: Vec<u32> = solid.triangles().concat();
    used.sort_unstable();
    used.dedup();
    used.len() as i64 - solid.edge_count() as i64 + solid.triangles().len() as i64
}

/// Closed and oriented, counted anew; and each vertex has one fan of faces.
pub fn assert_manifold(solid: &Solid) {
    let mut sides: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let mut next: BTreeMap<u32, BTreeMap<u32, u32>> = BTreeMap::new();
    for &[a, b, c] in solid.triangles() {
        for [u, v, w] in [[a, b, c], [b, c, a], [c, a, b]] {
            *sides.entry([u, v]).or_default() += 1;
            next.entry(u).or_default().insert(v, w);
        }
    }
    for (&[u, v], &count) in &sides {
        assert_eq!((count, sides.get(&[v, u]).copied()), (1, Some(1)), "edge {u} {v}");
    }
    for (vertex, fan) in next {
        let start = *fan.keys().next().unwrap();
        let (mut at, mut steps) = (fan[&start], 1);
        while at != start {
            at = fan[&at];
            steps += 1;
        }
        assert_eq!(steps, fan.len(), "vertex {vertex} has more than one fan");
    }
}

/// Cells from a list, each taken only if no two cells touch along an edge or in a corner without others between them: blocks
/// whose boundary is a manifold.
pub fn sound_blocks(list: &[[i32; 3]]) -> Vec<[i32; 3]> {
    let linked = |all: &[[i32; 3]], a: &[i32; 3], b: &[i32; 3]| {
        // A way of faces from one to the other inside the box that both span.
        let low = [0, 1, 2].map(|k| a[k].min(b[k]));
        let high = [0, 1, 2].map(|k| a[k].max(b[k]));
        let within = |c: &[i32; 3]| (0..3).all(|k| c[k] >= low[k] && c[k] <= high[k]);
        let (mut reached, mut at) = (vec![*a], 0);
        while at < reached.len() {
            let from = reached[at];
            at += 1;
            let steps = all.iter().filter(|c| within(c) && (0..3).map(|k| (c[k] - from[k]).abs()).sum::<i32>() == 1);
            let new: Vec<_> = steps.filter(|c| !reached.contains(c)).copied().collect();
            reached.extend(new);
        }
        reached.contains(b)
    };
    let mut all: Vec<[i32; 3]> = Vec::new();
    for &cell in list {
        let mut more = all.clone();
        more.push(cell);
        let near = |a: &[i32; 3], b: &[i32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() <= 1);
        let solid_side = more.iter().all(|a| more.iter().all(|b| !near(a, b) || linked(&more, a, b)));
        // The same for the empty cells around, so that voids do not touch.
        let empty: Vec<[i32; 3]> = cells([-1; 3], [4; 3]).into_iter().filter(|c| !more.contains(c)).collect();
        let empty_side = empty.iter().all(|a| empty.iter().all(|b| !near(a, b) || linked(&empty, a, b)));
        if solid_side && empty_side && !more[..all.len()].contains(&cell) {
            all = more;
        }
    }
    all
}

/// A round tube along a path of points with directions, closed at both ends.
pub fn swept(path: &[(Point3<f64>, Vector3<f64>)], across: Vector3<f64>, radius: f64, sides: usize) -> Solid {
    let mut vertices = Vec::new();
    for &(at, along) in path {
        let other = along.cross(&across).normalize();
        vertices.extend((0..sides).map(|k| {
            let angle = TAU * k as f64 / sides as f64;
            at + (across * angle.cos() + other * angle.sin()) * radius
        }));
    }
    let ring = |row: usize, k: usize| (row * sides + k % sides) as u32;
    let [first, last] = [vertices.len() as u32, vertices.len() as u32 + 1];
    vertices.extend([path[0].0, path[path.len() - 1].0]);
    let rows = path.len();
    let mut triangles = Vec::new();
    for k in 0..sides {
        triangles.push([first, ring(0, k + 1), ring(0, k)]);
        triangles.push([last, ring(rows - 1, k), ring(rows - 1, k + 1)]);
        for row in 1..rows {
            let [a, b, c, d] = [ring(row - 1, k), ring(row - 1, k + 1), ring(row, k + 1), ring(row, k)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Solid::new(&vertices, &triangles).unwrap()
}

/// The curved part of Lettori et al., Fig. 2: up, around a bend of a quarter circle, and on to the side.
pub fn bend(radius: f64, sides: usize) -> Solid {
    let (up, curve, out, steps) = (40.0, 60.0, 30.0, 16);
    let mut path = vec![(Point3::origin(), Vector3::z())];
    for k in 0..=steps {
        let angle = std::f64::consts::FRAC_PI_2 * f64::from(k) / f64::from(steps);
        let at = Point3::new(curve * (1.0 - angle.cos()), 0.0, up + curve * angle.sin());
        path.push((at, Vector3::new(angle.sin(), 0.0, angle.cos())));
    }
    path.push((Point3::new(curve + out, 0.0, up + curve), Vector3::x()));
    swept(&path, Vector3::y(), radius, sides)
}

/// A T: a stem of 30 by 30 by 60 mm below a bar of 90 by 30 by 30 mm.
pub fn tee() -> Solid {
    let mut all = cells([1, 0, 0], [2, 1, 2]);
    all.extend(cells([0, 0, 2], [3, 1, 3]));
    blocks(&all, 30.0)
}

/// A flipped L: a post of 30 by 30 by 60 mm below a bar of 90 by 30 by 30 mm that reaches to one side.
pub fn ell() -> Solid {
    let mut all = cells([0, 0, 0], [1, 1, 2]);
    all.extend(cells([0, 0, 2], [3, 1, 3]));
    blocks(&all, 30.0)
}

/// A mushroom: a stem of 20 mm radius and 60 mm, and a cap of 60 mm radius.
pub fn mushroom() -> Solid {
    turned(&[[0.0, 0.0], [20.0, 0.0], [20.0, 60.0], [60.0, 60.0], [50.0, 80.0], [25.0, 95.0], [0.0, 100.0]], 48)
}

/// A closed tube about a curve; `at` takes turns from 0 to 1.
pub fn ring(at: impl Fn(f64) -> Point3<f64>, radius: f64, [around, sides]: [usize; 2]) -> Solid {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let corner = |i: usize, k: usize| ((i % around) * sides + k % sides) as u32;
    for i in 0..around {
        let turn = i as f64 / around as f64;
        let along = (at(turn + 1e-4) - at(turn - 1e-4)).normalize();
        // Frames that look up come around to themselves.
        let across = (Vector3::z() - along * along.z).normalize();
        let other = along.cross(&across);
        for k in 0..sides {
            let angle = TAU * k as f64 / sides as f64;
            vertices.push(at(turn) + (across * angle.cos() + other * angle.sin()) * radius);
            let [a, b, c, d] = [corner(i, k), corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1)];
            triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    Solid::new(&vertices, &triangles).unwrap()
}

/// A trefoil knot that lies, 130 mm across and 50 mm high.
pub fn knot() -> Solid {
    let at = |turn: f64| {
        let t = TAU * turn;
        let [x, y] = [t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos()];
        Point3::new(20.0 * x, 20.0 * y, -17.0 * (3.0 * t).sin())
    };
    ring(at, 8.0, [96, 16])
}

/// A crank: a journal, a pin beside its axis, and a journal again, with webs between them.
pub fn crank() -> Solid {
    let mut all = cells([0, 0, 0], [2, 2, 3]);
    all.extend(cells([0, 0, 3], [6, 2, 4]));
    all.extend(cells([4, 0, 4], [6, 2, 7]));
    all.extend(cells([0, 0, 7], [6, 2, 8]));
    all.extend(cells([0, 0, 8], [2, 2, 11]));
    blocks(&all, 10.0)
}

/// A hook: up, over to the side, down, and back under itself towards the post.
pub fn hook() -> Solid {
    let (up, curve, steps) = (70.0, 30.0, 40);
    let mut path = vec![(Point3::origin(), Vector3::z())];
    for k in 0..=steps {
        let angle = 5.0 * f64::from(k) / f64::from(steps);
        let curve = curve - 1.6 * angle;
        let at = Point3::new(30.0 - curve * angle.cos(), 0.0, up + curve * angle.sin());
        path.push((at, Vector3::new(angle.sin(), 0.0, angle.cos())));
    }
    swept(&path, Vector3::y(), 8.0, 20)
}
