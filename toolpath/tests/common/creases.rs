//! Layers in which nozzles get stuck, and the slow twin of the search for where they are deepest: a dense raster of points
//! on every sheet of every triangle.
#![allow(dead_code)] // each test takes what it needs

use crate::common::{self, rng, rough};
use crate::layers::Layer;
use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
use curvlay_toolpath::surface::Nozzle;
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
    let nozzle = Nozzle::default();
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
