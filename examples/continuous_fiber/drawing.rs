//! Pictures: tapes coloured by their steering radius, stresses with their directions.

use super::layer::LoadedLayer;
use super::tapes::Planned;
use curvlay_examples::mesh::Mesh;
use curvlay_examples::nalgebra::{Point3, Vector3};
use curvlay_examples::render::{Camera, INK, Image, Rgb, Scene, ramp};
use curvlay_toolpath::fiber::tapes::{Tape, TapePlan};

/// Pixels of a picture.
const SIZE: [u32; 2] = [900, 560];
/// The layer below the tapes.
const LAYER: Rgb = [214, 219, 226];
/// The sides and layers of a specimen.
const BODY: Rgb = [226, 229, 234];
const WIRE: Rgb = [232, 98, 20];
/// Strokes of direction over the longest side of a layer.
const STROKES: f64 = 60.0;
/// Strokes are lifted by this share of their distance, so that the layer does not hide them.
const LIFTED: f64 = 0.2;

/// From straight (light) to the least radius (dark).
fn of_radius(radius: f64, min_radius: f64) -> Rgb {
    ramp(1.0 - (min_radius / radius).min(1.0))
}

/// The tapes of a plan as bands on their surface, a little above it.
fn draw_tapes(scene: &mut Scene, plan: &TapePlan, min_radius: f64, lift: f64) {
    for (tape, radii) in plan.tapes.iter().zip(&plan.radii) {
        let edges: Vec<[Point3<f64>; 2]> = (0..tape.points.len())
            .map(|k| {
                let (before, after) = (k.saturating_sub(1), (k + 1).min(tape.points.len() - 1));
                let along = tape.points[after] - tape.points[before];
                let normal = tape.normals[k].into_inner();
                // A little narrower, so that one sees where tapes meet.
                let across =
                    normal.cross(&along).try_normalize(1e-12).unwrap_or(Vector3::zeros()) * (0.47 * tape.width);
                let middle = tape.points[k] + normal * lift;
                [middle + across, middle - across]
            })
            .collect();
        for (k, pair) in edges.windows(2).enumerate() {
            let ([a, b], [c, d]) = (pair[0], pair[1]);
            let colour = of_radius(radii[k].min(radii[k + 1]), min_radius);
            scene.triangles([([a, b, c], colour), ([c, b, d], colour)]);
        }
    }
}

/// The picture with what its colours mean below.
fn with_words(image: &Image, words: &str) -> Vec<u8> {
    let [_, height] = Image::text_size(words);
    let mut framed = Image::new(image.width(), image.height() + 2 * height, [255, 255, 255]);
    framed.paste([0, 0], image);
    framed.write([12, image.height()], words, INK);
    framed.to_png()
}

fn radius_words(min_radius: f64) -> String {
    format!("dark: steered at {min_radius:.0} mm. light: straight")
}

/// A specimen cut open: its layers up to half, and the tapes on them.
pub fn specimen(planned: &Planned, min_radius: f64) -> Vec<u8> {
    let mut scene = Scene::new(Camera::from_direction(Vector3::new(0.35, -1.0, 0.75)));
    let add = |scene: &mut Scene, mesh: &Mesh, colour| _ = scene.mesh(&mesh.vertices, &mesh.triangles, colour);
    if let Some(mould) = planned.specimen.mould() {
        add(&mut scene, &mould, BODY);
    }
    let on = planned.tapes.len() / 2;
    let Some(layer) = planned.tapes.get(on) else { return with_words(&scene.draw(SIZE[0], SIZE[1]), "no tape") };
    let height = (f64::from(layer.layer) + 1.0) * planned.specimen.layer_mm;
    add(&mut scene, &planned.specimen.surface(height), LAYER);
    draw_tapes(&mut scene, &planned.plans[on], min_radius, 0.1);
    with_words(&scene.draw(SIZE[0], SIZE[1]), &radius_words(min_radius))
}

/// Where a layer is seen best from: along its mean normal, a little from below in the picture.
fn camera(layer: &LoadedLayer) -> Camera {
    let surface = &layer.surface;
    let normal: Vector3<f64> = surface
        .triangles()
        .iter()
        .map(|corners| {
            let [a, b, c] = corners.map(|v| surface.vertices()[v as usize]);
            (b - a).cross(&(c - a))
        })
        .sum();
    let normal = normal.try_normalize(1e-9).unwrap_or(Vector3::z());
    Camera::from_direction(normal + Vector3::new(0.25, -0.6, 0.2))
}

/// Tapes on a layer.
pub fn tapes(layer: &LoadedLayer, wires: &[Tape], min_radius: f64) -> Vec<u8> {
    let mut scene = Scene::new(camera(layer));
    scene.mesh(layer.surface.vertices(), layer.surface.triangles(), LAYER);
    draw_tapes(&mut scene, &layer.plan, min_radius, 0.3);
    for wire in wires {
        for (ends, normals) in wire.points.windows(2).zip(wire.normals.windows(2)) {
            let [a, b] = [0, 1].map(|k| ends[k] + normals[k].into_inner() * wire.width);
            scene.bar(a, b, wire.width / 2.0, WIRE);
        }
    }
    with_words(&scene.draw(SIZE[0], SIZE[1]), &radius_words(min_radius))
}

/// The greatest stress of a layer by colour, its principal directions as strokes.
pub fn stress(layer: &LoadedLayer) -> Vec<u8> {
    let (vertices, triangles) = (layer.surface.vertices(), layer.surface.triangles());
    let largest = layer.principal.iter().map(|p| p.largest.abs()).fold(0.0, f64::max);
    let share = |v: u32| layer.principal[v as usize].largest.abs() / largest.max(f64::MIN_POSITIVE);
    let mut scene = Scene::new(camera(layer));
    scene.triangles(triangles.iter().map(|corners| {
        // The square root, so that low stresses are distinguishable, too.
        let mean = corners.iter().map(|&v| share(v)).sum::<f64>() / 3.0;
        (corners.map(|v| vertices[v as usize]), ramp(mean.sqrt()))
    }));
    let bounds = Mesh { vertices: vertices.to_vec(), triangles: Vec::new() }.bounds();
    let step = bounds.map_or(1.0, |[low, high]| (high - low).amax()) / STROKES;
    let mut drawn = std::collections::BTreeSet::new();
    for (corners, v) in triangles.iter().map(|corners| (corners, corners[0] as usize)) {
        let p = vertices[v];
        // One stroke a cell of a grid.
        if !drawn.insert([p.x, p.y, p.z].map(|c| (c / step).floor() as i64)) {
            continue;
        }
        let [a, b, c] = corners.map(|v| vertices[v as usize]);
        let normal = (b - a).cross(&(c - a)).try_normalize(1e-12).unwrap_or(Vector3::z());
        let (p, half) = (p + normal * (LIFTED * step), layer.principal[v].direction * (0.4 * step));
        scene.bar(p - half, p + half, 0.05 * step, INK);
    }
    let words = format!("dark: no stress. light: {largest:.3} mpa. strokes: its direction");
    with_words(&scene.draw(SIZE[0], SIZE[1]), &words)
}
