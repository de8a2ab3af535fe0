//! Solids made in code, for examples that are run without a file.

use crate::mesh::Mesh;
use curvlay_voxel::{ImplicitMesh, polygonise};
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Edge of the lattice on which the jug is cut out, in mm: about 30,000 triangles.
const JUG_CELL: f64 = 2.2;
/// Rounds in which the triangles of the jug are evened out.
const JUG_ROUNDS: usize = 3;

/// How far rounding may lift a vertex off the plate, in mm; real features are larger by far.
const ROUNDING: f64 = 1e-9;

/// A jug with a foot, a belly, a spout, a knob and a ring for a handle: solid, 93 mm tall, standing on a flat foot.
///
/// # Returns
/// One watertight mesh of genus 1 in mm, about 30,000 triangles, its foot in the plane z = 0 around the z axis.
pub fn jug() -> Mesh {
    // Half a cell between the lattice and the plate keeps the foot smooth.
    let low = Point3::new(-58.0, -36.0, -2.5 * JUG_CELL);
    let surface = polygonise(jug_distance, low, Point3::new(65.0, 36.0, 98.0), JUG_CELL);
    let mut surface = surface.unwrap_or_else(|error| unreachable!("the jug has a box: {error}"));
    surface.relax(jug_distance, JUG_ROUNDS);
    let ImplicitMesh { vertices, triangles } = surface;
    let mut mesh = Mesh { vertices, triangles };
    for vertex in &mut mesh.vertices {
        if vertex.z.abs() < ROUNDING {
            vertex.z = 0.0;
        }
    }
    mesh
}

/// How much smaller the small jug is.
const SMALL: f64 = 0.44;

/// The [jug], 41 mm tall: one that is planned in a minute with layers and beads of a printer.
pub fn small_jug() -> Mesh {
    let mut mesh = jug();
    mesh.vertices.iter_mut().for_each(|vertex| *vertex *= SMALL);
    mesh
}

/// Edge of the lattice on which the branches are cut out, in mm: about 6,000 triangles.
const BRANCHES_CELL: f64 = 1.6;

/// A trunk on a flat foot with a ball on top and two branches, one nearly level, one upwards: no single direction prints it without
/// support.
///
/// # Returns
/// One watertight mesh of genus 0 in mm, 45 mm tall, its foot in the plane z = 0 around the z axis.
pub fn branches() -> Mesh {
    let low = Point3::new(-28.0, -14.0, -2.5 * BRANCHES_CELL);
    let surface = polygonise(branches_distance, low, Point3::new(32.0, 14.0, 49.0), BRANCHES_CELL);
    let mut surface = surface.unwrap_or_else(|error| unreachable!("the branches have a box: {error}"));
    surface.relax(branches_distance, JUG_ROUNDS);
    let ImplicitMesh { vertices, triangles } = surface;
    let mut mesh = Mesh { vertices, triangles };
    for vertex in mesh.vertices.iter_mut().filter(|vertex| vertex.z.abs() < ROUNDING) {
        vertex.z = 0.0;
    }
    mesh
}

/// Below zero inside the branches; about the distance from their surface, in mm.
fn branches_distance(p: Point3<f64>) -> f64 {
    let trunk = cone(p, Point3::new(0.0, 0.0, -6.0), Point3::new(0.0, 0.0, 33.0), 10.0, 6.0);
    let ball = (p - Point3::new(0.0, 0.0, 37.0)).norm() - 8.5;
    let level = cone(p, Point3::new(0.0, 0.0, 17.0), Point3::new(25.0, 0.0, 22.0), 5.0, 4.5);
    let upward = cone(p, Point3::new(0.0, 0.0, 16.0), Point3::new(-20.0, 4.0, 30.0), 4.5, 4.5);
    let whole = blend(blend(blend(trunk, ball, 2.0), level, 2.0), upward, 2.0);
    -blend(-whole, p.z, 2.0)
}

/// Below zero inside the jug; about the distance from its surface, in mm.
fn jug_distance(p: Point3<f64>) -> f64 {
    let belly = ellipsoid(p, Point3::new(0.0, 0.0, 36.0), Vector3::new(31.0, 31.0, 27.0));
    let foot = cone(p, Point3::new(0.0, 0.0, -8.0), Point3::new(0.0, 0.0, 14.0), 23.0, 15.0);
    let neck = cone(p, Point3::new(0.0, 0.0, 55.0), Point3::new(0.0, 0.0, 74.0), 15.0, 12.5);
    let rim = ring(p, Point3::new(0.0, 0.0, 75.0), Vector3::z(), 12.0, 3.6);
    let lid = ellipsoid(p, Point3::new(0.0, 0.0, 76.0), Vector3::new(12.0, 12.0, 7.0));
    let knob = (p - Point3::new(0.0, 0.0, 87.5)).norm() - 5.5;
    let handle = ring(p, Point3::new(-33.0, 0.0, 46.0), Vector3::y(), 16.5, 4.4);

    let body = blend(blend(belly, foot, 6.0), neck, 8.0);
    let top = blend(blend(rim, lid, 3.0), knob, 4.0);
    let whole = blend(blend(blend(body, top, 3.0), spout(p), 7.0), handle, 4.0);
    // The plate cuts the foot flat; its edge is a little round.
    -blend(-whole, p.z, 3.0)
}

/// A round rod along a parabola in the plane y = 0, from the belly up to the lip, that tapers.
fn spout(p: Point3<f64>) -> f64 {
    // Bézier points (18, 27), (47, 29), (56, 71) as a polynomial.
    let [a, b, c] = [Vector3::new(18.0, 0.0, 27.0), Vector3::new(58.0, 0.0, 4.0), Vector3::new(-20.0, 0.0, 40.0)];
    let from_curve = |t: f64| p.coords - (a + b * t + c * (t * t));
    let samples = [0.0, 0.25, 0.5, 0.75, 1.0].map(|t| (from_curve(t).norm_squared(), t));
    let (_, mut t) =
        samples.into_iter().fold((f64::INFINITY, 0.0), |best, next| if next.0 < best.0 { next } else { best });
    // Newton steps to the foot of the perpendicular; from a quarter away three are enough.
    for _ in 0..3 {
        let tangent = b + c * (2.0 * t);
        let slope = tangent.norm_squared() - from_curve(t).dot(&(c * 2.0));
        if slope > 0.0 {
            t = (t + from_curve(t).dot(&tangent) / slope).clamp(0.0, 1.0);
        }
    }
    from_curve(t).norm() - (9.5 - 5.0 * t)
}

/// The union of two solids with a fillet between them that starts where both are `width` away.
pub(crate) fn blend(a: f64, b: f64, width: f64) -> f64 {
    let near = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - near * near * width / 4.0
}

/// A ball with three different radii.
pub(crate) fn ellipsoid(p: Point3<f64>, centre: Point3<f64>, radii: Vector3<f64>) -> f64 {
    let d = p - centre;
    let (once, twice) = (d.component_div(&radii).norm(), d.component_div(&radii.component_mul(&radii)).norm());
    if twice > 0.0 { once * (once - 1.0) / twice } else { -radii.min() }
}

/// A round rod from `a` to `b` whose radius goes from `ra` to `rb`.
pub(crate) fn cone(p: Point3<f64>, a: Point3<f64>, b: Point3<f64>, ra: f64, rb: f64) -> f64 {
    let axis = b - a;
    let t = ((p - a).dot(&axis) / axis.norm_squared()).clamp(0.0, 1.0);
    (p - (a + axis * t)).norm() - (ra + (rb - ra) * t)
}

/// A round rod bent into a ring about `axis` (of length 1).
pub(crate) fn ring(p: Point3<f64>, centre: Point3<f64>, axis: Vector3<f64>, radius: f64, thickness: f64) -> f64 {
    let d = p - centre;
    let along = d.dot(&axis);
    ((d - axis * along).norm() - radius).hypot(along) - thickness
}

/// A round bar of 15 mm radius that goes up by 40 mm, around a bend of a quarter circle of 60 mm radius, and on to the side by 30 mm:
/// after Fig. 2 of Lettori et al. (2022).
pub fn bend() -> Mesh {
    const SIDES: usize = 48;
    const STEPS: usize = 24;
    let (radius, up, curve, out) = (15.0, 40.0, 60.0, 30.0);
    let mut path = vec![(Point3::origin(), 0.0)];
    path.extend((0..=STEPS).map(|k| {
        let angle = FRAC_PI_2 * k as f64 / STEPS as f64;
        (Point3::new(curve * (1.0 - angle.cos()), 0.0, up + curve * angle.sin()), angle)
    }));
    path.push((Point3::new(curve + out, 0.0, up + curve), FRAC_PI_2));
    let ring = |(at, angle): (Point3<f64>, f64)| {
        let side = Vector3::new(angle.cos(), 0.0, -angle.sin());
        (0..SIDES).map(move |k| {
            let turn = TAU * k as f64 / SIDES as f64;
            at + (side * turn.cos() + Vector3::y() * turn.sin()) * radius
        })
    };
    let ends = [path[0].0, path[path.len() - 1].0];
    rings(path.into_iter().map(|section| ring(section).collect()).collect(), ends)
}

/// A mushroom: a stem of 20 mm radius and 60 mm height, and a cap of 60 mm radius.
pub fn mushroom() -> Mesh {
    const SIDES: usize = 72;
    let profile = [[20.0, 0.0], [20.0, 60.0], [60.0, 60.0], [57.0, 72.0], [48.0, 84.0], [33.0, 93.0], [14.0, 98.5]];
    let ring = |[r, z]: [f64; 2]| {
        (0..SIDES).map(move |k| {
            let turn = TAU * k as f64 / SIDES as f64;
            Point3::new(r * turn.cos(), r * turn.sin(), z)
        })
    };
    let ends = [Point3::origin(), Point3::new(0.0, 0.0, 100.0)];
    rings(profile.into_iter().map(|section| ring(section).collect()).collect(), ends)
}

/// A flipped L, 30 mm thick: a post 60 mm high below a bar of 90 by 30 mm that reaches to one side.
pub fn ell() -> Mesh {
    let outline =
        [[0.0, 0.0], [30.0, 0.0], [30.0, 60.0], [90.0, 60.0], [90.0, 90.0], [30.0, 90.0], [0.0, 90.0], [0.0, 60.0]];
    prism(&outline, &[[0, 1, 2, 7], [7, 2, 5, 6], [2, 3, 4, 5]], 30.0)
}

/// A T, 30 mm thick: a stem of 30 by 60 mm below a bar of 90 by 30 mm.
pub fn tee() -> Mesh {
    let outline = [
        [-15.0, 0.0],
        [15.0, 0.0],
        [15.0, 60.0],
        [45.0, 60.0],
        [45.0, 90.0],
        [15.0, 90.0],
        [-15.0, 90.0],
        [-45.0, 90.0],
        [-45.0, 60.0],
        [-15.0, 60.0],
    ];
    prism(&outline, &[[0, 1, 2, 9], [9, 2, 5, 6], [2, 3, 4, 5], [8, 9, 6, 7]], 30.0)
}

/// Rings of as many points each, counter-clockwise seen from the far end, joined and closed by a fan at both ends.
fn rings(rings: Vec<Vec<Point3<f64>>>, ends: [Point3<f64>; 2]) -> Mesh {
    let (rows, sides) = (rings.len(), rings[0].len());
    let at = |row: usize, k: usize| (row * sides + k % sides) as u32;
    let [first, last] = [at(rows, 0), at(rows, 0) + 1];
    let mut triangles = Vec::new();
    for k in 0..sides {
        triangles.extend([[first, at(0, k + 1), at(0, k)], [last, at(rows - 1, k), at(rows - 1, k + 1)]]);
        for row in 1..rows {
            let [a, b, c, d] = [at(row - 1, k), at(row - 1, k + 1), at(row, k + 1), at(row, k)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let mut vertices = rings.concat();
    vertices.extend(ends);
    Mesh { vertices, triangles }
}

/// An outline in x and z, counter-clockwise, in quads, made thick along y, its middle at y = 0.
fn prism(outline: &[[f64; 2]], quads: &[[u32; 4]], thick: f64) -> Mesh {
    let n = outline.len() as u32;
    let side = |y: f64| outline.iter().map(move |&[x, z]| Point3::new(x, y, z));
    let vertices = side(-thick / 2.0).chain(side(thick / 2.0)).collect();
    let mut triangles = Vec::new();
    for &[a, b, c, d] in quads {
        triangles.extend([[a, b, c], [a, c, d], [a + n, c + n, b + n], [a + n, d + n, c + n]]);
    }
    for k in 0..n {
        let next = (k + 1) % n;
        triangles.extend([[k, k + n, next + n], [k, next + n, next]]);
    }
    Mesh { vertices, triangles }
}
