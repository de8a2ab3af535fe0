//! Meshes, sheets and what every trimmed sheet must be.

use curvlay_layers::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_layers::trim::{BoundaryKind, MIN_ALTITUDE_MM, TrimmedSheet, Trimmer};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

pub type P = Point3<f64>;

/// Never cancels.
pub fn go(_: curvlay_layers::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub vertices: Vec<P>,
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    pub fn moved(&self, by: &Isometry3<f64>) -> Mesh {
        Mesh { vertices: self.vertices.iter().map(|p| by * p).collect(), triangles: self.triangles.clone() }
    }

    pub fn turned(&self) -> Mesh {
        Mesh { vertices: self.vertices.clone(), triangles: self.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect() }
    }

    pub fn and(mut self, other: &Mesh) -> Mesh {
        let base = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|c| c + base)));
        self
    }

    pub fn corners(&self, triangle: usize) -> [P; 3] {
        self.triangles[triangle].map(|corner| self.vertices[corner as usize])
    }

    pub fn trimmer(&self) -> Trimmer {
        Trimmer::new(&self.vertices, &self.triangles).unwrap()
    }
}

pub fn trim(mesh: &Mesh, sheet: &Mesh) -> TrimmedSheet {
    mesh.trimmer().trim(&sheet.vertices, &sheet.triangles, &go).unwrap()
}

/// Equal but for rounding.
pub fn assert_same(a: &TrimmedSheet, b: &TrimmedSheet) {
    assert_eq!((&a.triangles, &a.sources, &a.boundary), (&b.triangles, &b.sources, &b.boundary));
    for (a, b) in a.vertices.iter().zip(&b.vertices) {
        assert!((a - b).norm() < 1e-10);
    }
}

/// A box between two corners.
pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let corner = |k: usize| P::from([0, 1, 2].map(|bit| if k >> bit & 1 == 1 { high[bit] } else { low[bit] }));
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { vertices: (0..8).map(corner).collect(), triangles }
}

/// A grid over `[0, u] x [0, v]` cells, mapped into space, wrapped round where asked for.
pub fn grid(cells: [u32; 2], wrap: [bool; 2], at: impl Fn(f64, f64) -> P) -> Mesh {
    let points = [0, 1].map(|k| if wrap[k] { cells[k] } else { cells[k] + 1 });
    let id = |i: u32, j: u32| i % points[0] + points[0] * (j % points[1]);
    let mut mesh = Mesh::default();
    for j in 0..points[1] {
        for i in 0..points[0] {
            mesh.vertices.push(at(f64::from(i) / f64::from(cells[0]), f64::from(j) / f64::from(cells[1])));
        }
    }
    for j in 0..cells[1] {
        for i in 0..cells[0] {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            mesh.triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    mesh
}

pub fn torus(ring: f64, tube: f64, cells: [u32; 2]) -> Mesh {
    grid(cells, [true; 2], |u, v| {
        let ((su, cu), (sv, cv)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
        P::new((ring + tube * cv) * cu, (ring + tube * cv) * su, tube * sv)
    })
}

/// A ball from an octahedron.
pub fn ball(centre: [f64; 3], radius: f64, depth: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    mesh.vertices = axes.iter().chain(&axes.map(|a| -a)).map(|&a| P::from(a)).collect();
    let faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    mesh.triangles = faces.to_vec();
    for _ in 0..depth {
        let mut middles = BTreeMap::new();
        let mut middle = |vertices: &mut Vec<P>, a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let sum = vertices[a as usize].coords + vertices[b as usize].coords;
                vertices.push(P::from(sum.normalize()));
                vertices.len() as u32 - 1
            })
        };
        let mut finer = Vec::new();
        for &[a, b, c] in &mesh.triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b)| middle(&mut mesh.vertices, a, b));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        mesh.triangles = finer;
    }
    mesh.vertices.iter_mut().for_each(|p| *p = P::from(p.coords * radius + Vector3::from(centre)));
    mesh
}

/// A height field over a square around the origin.
pub fn field(half: f64, cells: u32, height: impl Fn(f64, f64) -> f64) -> Mesh {
    grid([cells; 2], [false; 2], |u, v| {
        let [x, y] = [u, v].map(|c| half * (2.0 * c - 1.0));
        P::new(x, y, height(x, y))
    })
}

/// How often closed triangles go round a point.
pub fn winding(mesh: &Mesh, at: &P) -> f64 {
    let angle = |corners: [P; 3]| {
        let [a, b, c] = corners.map(|p| p - at);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    (0..mesh.triangles.len()).map(|t| angle(mesh.corners(t))).sum::<f64>() / (2.0 * TAU)
}

fn edges(triangles: &[[u32; 3]]) -> BTreeSet<[u32; 2]> {
    let mut edges = BTreeSet::new();
    for t in triangles {
        for k in 0..3 {
            assert!(edges.insert([t[k], t[(k + 1) % 3]]), "an edge is run along twice the same way: {t:?}");
        }
    }
    edges
}

/// What holds for every trimmed sheet: an oriented manifold, its boundary listed in full, and made of the sheet's triangles.
pub fn check(sheet: &Mesh, trimmed: &TrimmedSheet) {
    let edges = edges(&trimmed.triangles);
    let open: BTreeSet<_> = edges.iter().copied().filter(|&[a, b]| !edges.contains(&[b, a])).collect();
    let reported: BTreeSet<_> = trimmed.boundary.iter().map(|edge| edge.ends).collect();
    assert_eq!(reported.len(), trimmed.boundary.len());
    assert_eq!(open, reported);
    // One fan a vertex: going round the triangles of a vertex visits them all.
    let mut around: Vec<BTreeMap<u32, u32>> = vec![BTreeMap::new(); trimmed.vertices.len()];
    for t in &trimmed.triangles {
        for k in 0..3 {
            around[t[k] as usize].insert(t[(k + 1) % 3], t[(k + 2) % 3]);
        }
    }
    for (vertex, fan) in around.iter().enumerate() {
        let ends: BTreeSet<_> = fan.values().collect();
        let first =
            *fan.keys().find(|start| !ends.contains(start)).or_else(|| fan.keys().next()).expect("no stray vertex");
        let (mut at, mut count) = (first, 0);
        while let Some(&next) = fan.get(&at) {
            (at, count) = (next, count + 1);
            if at == first {
                break;
            }
        }
        assert_eq!(count, fan.len(), "vertex {vertex} has more than one fan");
    }
    let mut slivers = 0;
    assert_eq!(trimmed.sources.len(), trimmed.triangles.len());
    for (corners, &source) in trimmed.triangles.iter().zip(&trimmed.sources) {
        let [a, b, c] = corners.map(|c| trimmed.vertices[c as usize]);
        let [p, q, r] = sheet.corners(source as usize);
        let normal = (q - p).cross(&(r - p));
        let unit = normal.normalize();
        for at in [a, b, c] {
            assert!((at - p).dot(&unit).abs() < 1e-5, "a piece is off its triangle");
        }
        let cross = (b - a).cross(&(c - a));
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        if cross.norm() < longest * MIN_ALTITUDE_MM {
            slivers += 1;
        } else {
            assert!(cross.dot(&unit) > 0.0, "a piece is turned over");
        }
    }
    assert_eq!(slivers, trimmed.slivers);
    assert!(trimmed.error_mm <= 1e-6, "boundary off the mesh by {}", trimmed.error_mm);
    let length = |kind: BoundaryKind| -> f64 {
        let edges = trimmed.boundary.iter().filter(|edge| edge.kind == kind);
        edges
            .map(|edge| (trimmed.vertices[edge.ends[1] as usize] - trimmed.vertices[edge.ends[0] as usize]).norm())
            .sum()
    };
    let reported = [trimmed.mesh_mm, trimmed.border_mm, trimmed.hole_mm];
    let found = [BoundaryKind::Mesh, BoundaryKind::Border, BoundaryKind::Hole].map(length);
    for (reported, found) in reported.into_iter().zip(found) {
        assert!((reported - found).abs() <= 1e-9 * (1.0 + reported));
    }
}

/// What stands for the infinitely small step of the sheet.
pub const STEP: Vector3<f64> = Vector3::new(1e-8, 1e-10, 1e-6);

/// [`check`], and that each piece lies inside and nothing inside is left out: by the winding number at the
/// middles of pieces, and by areas of the sheet that are far from the mesh.
pub fn check_inside(mesh: &Mesh, sheet: &Mesh, trimmed: &TrimmedSheet) {
    check(sheet, trimmed);
    // As many samples as a million solid angles allow.
    let samples = 1 + 1_000_000 / mesh.triangles.len();
    let mut kept = vec![0.0; sheet.triangles.len()];
    let sparse = 1 + trimmed.triangles.len() / samples;
    for (at, (corners, &source)) in trimmed.triangles.iter().zip(&trimmed.sources).enumerate() {
        let [a, b, c] = corners.map(|c| trimmed.vertices[c as usize]);
        let area = (b - a).cross(&(c - a)).norm() / 2.0;
        kept[source as usize] += area;
        if area > 1e-6 && at % sparse == 0 {
            let number = winding(mesh, &(P::from((a.coords + b.coords + c.coords) / 3.0) + STEP));
            assert!(number.abs() > 0.5, "a piece outside: {number}");
        }
    }
    // The share of a triangle that is inside, by samples, to within what so few can tell.
    for (triangle, &kept) in kept.iter().enumerate().step_by(1 + 21 * sheet.triangles.len() / samples) {
        let [a, b, c] = sheet.corners(triangle);
        let area = (b - a).cross(&(c - a)).norm() / 2.0;
        let (mut inside, mut all) = (0, 0);
        let steps = 6;
        for i in 0..steps {
            for j in 0..steps - i {
                let [u, v] = [i, j].map(|k| (f64::from(k) + 1.0 / 3.0) / f64::from(steps));
                let at = a + (b - a) * u + (c - a) * v + STEP;
                inside += i32::from(winding(mesh, &at).abs() > 0.5);
                all += 1;
            }
        }
        let share = f64::from(inside) / f64::from(all);
        let seen = (inside == 0 && kept <= 0.3 * area) || (inside == all && kept >= 0.7 * area);
        assert!(
            seen || (kept / area - share).abs() < 0.35,
            "triangle {triangle}: {} of it kept, {share} inside",
            kept / area
        );
    }
}

/// The area of the section of a mesh with a level plane that meets no vertex, from its outline.
pub fn section_area(mesh: &Mesh, z: f64) -> f64 {
    let mut twice = 0.0;
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        let mut ends = [None, None];
        for k in 0..3 {
            let (p, q) = (corners[k], corners[(k + 1) % 3]);
            if (p.z > z) != (q.z > z) {
                let at = p + (q - p) * ((z - p.z) / (q.z - p.z));
                ends[usize::from(q.z > z)] = Some(at);
            }
        }
        if let [Some(down), Some(up)] = ends {
            // Looking from outside, the section runs from the side that goes down to the one that goes up.
            twice += down.x * up.y - down.y * up.x;
        }
    }
    twice / 2.0
}
