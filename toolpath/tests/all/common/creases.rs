//! Layers in which nozzles get stuck, and the slow twin of the search for where they are deepest: a dense raster of points
//! on every sheet of every triangle.

use super::layers::{Layer, path};
use super::nozzle::tip_1_mm;
use crate::common::{self, rng, rough};

use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
use curvlay_toolpath::orientation::ToolPath;
use rand::RngExt;

/// Height of all layers.
pub const H: f64 = 0.8;

/// What searches may be off by, in millimetres: pieces of a fiftieth of a layer, and the same again as slack of caps.
pub const PIECE: f64 = 0.02 * H;

/// A triangle far below everything: a layer for paths.
pub fn nowhere() -> Layer {
    Layer::sheet([0.0, 0.0, -900.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1, H)
}

/// A groove along y: two sides that lean by `angle` from the upright, `gap` wide at the height of the tip.
pub fn groove(angle: f64, gap: f64) -> Layer {
    groove_of(angle, gap, 10)
}

/// The same of `n` by `n` squares a side.
pub fn groove_of(angle: f64, gap: f64, n: u32) -> Layer {
    let (sin, cos) = angle.sin_cos();
    let side = |sign: f64| {
        let foot = [sign * (gap / 2.0 - 2.0 * angle.tan()), sign * 40.0, -2.0];
        let up = [sign * 40.0 * sin, 0.0, 40.0 * cos];
        Layer::sheet(foot, up, [0.0, -sign * 80.0, 0.0], n, H)
    };
    side(1.0).and(&side(-1.0))
}

/// How deep a nozzle is in layers, by a look at a raster of `step` on all sheets. Clearance as the crate defines it, which
/// has its own tests.
pub fn slow_depth(sheets: &[Point3<f64>], tip: Point3<f64>, direction: &UnitVector3<f64>) -> f64 {
    0.25 * H - slow_lack(sheets, tip, direction)
}

pub fn slow_lack(sheets: &[Point3<f64>], tip: Point3<f64>, direction: &UnitVector3<f64>) -> f64 {
    let nozzle = tip_1_mm();
    let clearance = |p: &Point3<f64>| {
        let v = p - tip;
        let z = v.dot(direction);
        nozzle.clearance(z, (v - direction.into_inner() * z).norm())
    };
    sheets.iter().map(clearance).fold(f64::INFINITY, f64::min)
}

/// Points of what is left of layers if a quarter is taken off as a skin.
pub fn sheets(layers: &[Layer], step: f64) -> Vec<Point3<f64>> {
    layers.iter().flat_map(|layer| sheets_by_triangle(layer, step, 0.25 * H)).flatten().collect()
}

/// The same of one layer, triangle by triangle, without what is nearer than `strip` to the boundary.
pub fn sheets_by_triangle(layer: &Layer, step: f64, strip: f64) -> Vec<Vec<Point3<f64>>> {
    let corners = |t: &[u32; 3]| t.map(|v| layer.vertices[v as usize]);
    let mut normals = vec![Vector3::zeros(); layer.vertices.len()];
    let mut edges = std::collections::BTreeMap::new();
    for t in &layer.triangles {
        let [a, b, c] = corners(t);
        t.iter().for_each(|&v| normals[v as usize] += (b - a).cross(&(c - a)));
        let sides = [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
        sides.iter().for_each(|&[a, b]| *edges.entry([a.min(b), a.max(b)]).or_insert(0) += 1);
    }
    let single = edges.iter().filter(|(_, count)| **count == 1);
    let rims: Vec<_> = single.map(|(edge, _)| edge.map(|v| layer.vertices[v as usize])).collect();
    let of_triangle = |t: &[u32; 3]| {
        let mut points = Vec::new();
        let [a, b, c] = corners(t);
        let n = t.map(|v| normals[v as usize].normalize());
        let parts = ((b - a).norm().max((c - a).norm()).max((c - b).norm()) / step).ceil() as usize;
        for (i, j) in (0..=parts).flat_map(|i| (0..=parts - i).map(move |j| (i, j))) {
            let w = [i, j, parts - i - j].map(|k| k as f64 / parts as f64);
            let p = Point3::from(a.coords * w[0] + b.coords * w[1] + c.coords * w[2]);
            if rims.iter().all(|r| common::to_segment(p, r[0], r[1]) >= strip) {
                let normal = n[0] * w[0] + n[1] * w[1] + n[2] * w[2];
                points.extend([-1.0, 0.0, 1.0].map(|side| p + normal * (side * 0.25 * H)));
            }
        }
        points
    };
    layer.triangles.iter().map(of_triangle).collect()
}

/// A rough layer with hills of up to 8 mm, and tips over it, some of them close to its slopes.
pub fn hills(seed: u64) -> (Layer, Vec<Point3<f64>>) {
    let mesh = rough(7, seed, 1.6, |i, j| (i, j) == (3, 4));
    let vertices: Vec<_> = mesh.vertices().iter().map(|p| Point3::new(2.0 * p.x, 2.0 * p.y, 5.0 * p.z)).collect();
    let layer = Layer::new(&vertices, mesh.triangles(), H);
    let mut rng = rng(seed);
    let tip = |_| {
        let t = mesh.triangles()[rng.random_range(0..mesh.triangles().len())].map(|v| vertices[v as usize]);
        let w = common::random_barycentric(&mut rng);
        let p = Point3::from(t[0].coords * w[0] + t[1].coords * w[1] + t[2].coords * w[2]);
        let normal = (t[1] - t[0]).cross(&(t[2] - t[0])).normalize();
        p + normal * rng.random_range(0.6 * H..2.5 * H)
    };
    (layer, (0..6).map(tip).collect())
}

/// When each triangle of a layer is touched last, as a number of samples from 0 on through all paths; all are on this layer.
pub fn last_touched(layer: &Layer, paths: &[ToolPath]) -> Vec<Option<usize>> {
    let corners: Vec<[Point3<f64>; 3]> =
        layer.triangles.iter().map(|t| t.map(|v| layer.vertices[v as usize])).collect();
    let mut last = vec![None; corners.len()];
    let samples = || paths.iter().flat_map(|path| path.waypoints.iter().filter(|w| !w.added));
    for (number, w) in samples().enumerate() {
        let top = w.bead_top();
        let distances: Vec<_> = corners.iter().map(|t| near(t, &top, 9.0).unwrap_or(f64::INFINITY)).collect();
        let nearest = (0..corners.len()).fold(0, |best, k| if distances[k] < distances[best] { k } else { best });
        let foot = foot(&corners[nearest], &top);
        for (t, corners) in corners.iter().enumerate() {
            if near(corners, &foot, 0.4).is_some_and(|distance| distance <= 0.4) {
                last[t] = Some(number);
            }
        }
    }
    last
}

/// How far a triangle is from a point, if its box is within reach.
fn near(corners: &[Point3<f64>; 3], p: &Point3<f64>, reach: f64) -> Option<f64> {
    let [low, high] = [corners[0].inf(&corners[1]).inf(&corners[2]), corners[0].sup(&corners[1]).sup(&corners[2])];
    if (0..3).any(|k| p[k] < low[k] - reach || p[k] > high[k] + reach) {
        return None;
    }
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
    let foot = p - normal * (p - corners[0]).dot(&normal);
    let inside = (0..3).all(|k| (corners[(k + 1) % 3] - corners[k]).cross(&(foot - corners[k])).dot(&normal) >= 0.0);
    let sides = (0..3).map(|k| common::to_segment(*p, corners[k], corners[(k + 1) % 3]));
    Some(if inside { (foot - p).norm() } else { sides.fold(f64::INFINITY, f64::min) })
}

/// The point of a triangle nearest to another.
fn foot(corners: &[Point3<f64>; 3], p: &Point3<f64>) -> Point3<f64> {
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
    let foot = p - normal * (p - corners[0]).dot(&normal);
    let side = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let share = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
        a + (b - a) * share
    };
    if (0..3).all(|k| (corners[(k + 1) % 3] - corners[k]).cross(&(foot - corners[k])).dot(&normal) >= 0.0) {
        return foot;
    }
    (1..3).map(side).fold(side(0), |best, other| if (other - p).norm() < (best - p).norm() { other } else { best })
}

/// Rows of beads over hills, to and fro: in creases some close others in.
pub fn rows(seed: u64) -> (Layer, Vec<ToolPath>) {
    let (layer, _) = hills(seed);
    let triangles: Vec<[Point3<f64>; 3]> =
        layer.triangles.iter().map(|t| t.map(|v| layer.vertices[v as usize])).collect();
    let over = |x: f64, y: f64| {
        // The triangle under the place, if there is one.
        triangles.iter().find_map(|[a, b, c]| {
            let normal = (b - a).cross(&(c - a));
            let p = Point3::new(x, y, a.z - (normal.x * (x - a.x) + normal.y * (y - a.y)) / normal.z);
            let inside = [(a, b), (b, c), (c, a)].iter().all(|(s, e)| (*e - *s).cross(&(p - *s)).dot(&normal) >= 0.0);
            let up = normal.normalize();
            inside.then_some((p + up * (H / 2.0), up))
        })
    };
    let row = |k: u32| {
        let places = (0..14).map(|i| if k.is_multiple_of(2) { i } else { 13 - i });
        places.filter_map(|i| over(0.5 + f64::from(i), 1.0 + 1.7 * f64::from(k))).collect::<Vec<_>>()
    };
    let all: Vec<Vec<_>> = (0..8).map(row).collect();
    // Two curves: every other pair of rows.
    let curve = |odd: usize| {
        path(
            0,
            &all.iter().enumerate().filter(|(k, _)| k / 2 % 2 == odd).flat_map(|(_, r)| r.clone()).collect::<Vec<_>>(),
        )
    };
    (layer, vec![curve(0), ToolPath { curve: 1, ..curve(1) }])
}
