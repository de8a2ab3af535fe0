//! Solids made in code, for examples that are run without a file.

use crate::mesh::Mesh;
use curvlay_voxel::{ImplicitMesh, polygonise};
use nalgebra::{Point3, Vector3};

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
const SMALL: f64 = 0.4;

/// The [jug], 37 mm tall: one that is planned in a minute with layers and beads of a printer.
pub fn small_jug() -> Mesh {
    let mut mesh = jug();
    mesh.vertices.iter_mut().for_each(|vertex| *vertex *= SMALL);
    mesh
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
fn blend(a: f64, b: f64, width: f64) -> f64 {
    let near = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - near * near * width / 4.0
}

/// A ball with three different radii.
fn ellipsoid(p: Point3<f64>, centre: Point3<f64>, radii: Vector3<f64>) -> f64 {
    let d = p - centre;
    let (once, twice) = (d.component_div(&radii).norm(), d.component_div(&radii.component_mul(&radii)).norm());
    if twice > 0.0 { once * (once - 1.0) / twice } else { -radii.min() }
}

/// A round rod from `a` to `b` whose radius goes from `ra` to `rb`.
fn cone(p: Point3<f64>, a: Point3<f64>, b: Point3<f64>, ra: f64, rb: f64) -> f64 {
    let axis = b - a;
    let t = ((p - a).dot(&axis) / axis.norm_squared()).clamp(0.0, 1.0);
    (p - (a + axis * t)).norm() - (ra + (rb - ra) * t)
}

/// A round rod bent into a ring about `axis` (of length 1).
fn ring(p: Point3<f64>, centre: Point3<f64>, axis: Vector3<f64>, radius: f64, thickness: f64) -> f64 {
    let d = p - centre;
    let along = d.dot(&axis);
    ((d - axis * along).norm() - radius).hypot(along) - thickness
}
