//! Pictures: the parts in colours, and each step of the sequence.

use super::decompose::Divided;
use curvlay_examples::nalgebra::{Point3, Vector3};
use curvlay_examples::render::{Camera, Rgb, Scene, ramp};
use curvlay_layers::planar::Solid;

/// Pixels of each picture.
const PICTURE: [u32; 2] = [520, 460];
const ARROW: Rgb = [200, 30, 30];
const GREY: Rgb = [190, 194, 200];

fn size(solid: &Solid) -> f64 {
    let [low, high] = solid.bounds();
    (high - low).norm()
}

fn scene() -> Scene {
    Scene::new(Camera::from_direction(Vector3::new(0.6, -1.0, 0.45)))
}

fn colour(part: usize, parts: usize) -> Rgb {
    ramp(0.1 + 0.85 * part as f64 / (parts.max(2) - 1) as f64)
}

/// All parts with their directions.
pub fn parts(divided: &Divided) -> Vec<u8> {
    let mut scene = scene();
    let all = &divided.parts.parts;
    for (k, part) in all.iter().enumerate() {
        scene.mesh(part.solid.vertices(), part.solid.triangles(), colour(k, all.len()));
        arrow(&mut scene, &part.solid, part.direction, 0.18 * size(&divided.solid));
    }
    let [width, height] = PICTURE;
    scene.draw(width, height).to_png()
}

/// What stands after a part is printed: earlier parts grey, this one in its colour with its direction.
pub fn step(divided: &Divided, step: usize) -> Vec<u8> {
    let mut scene = scene();
    let all = &divided.parts.parts;
    for (k, part) in all.iter().enumerate().take(step + 1) {
        let colour = if k == step { colour(k, all.len()) } else { GREY };
        scene.mesh(part.solid.vertices(), part.solid.triangles(), colour);
    }
    if let Some(part) = all.get(step) {
        arrow(&mut scene, &part.solid, part.direction, 0.22 * size(&divided.solid));
    }
    let [width, height] = PICTURE;
    scene.draw(width, height).to_png()
}

/// From the top of a part along its direction.
fn arrow(scene: &mut Scene, solid: &Solid, direction: Vector3<f64>, length: f64) {
    let [low, high] = solid.bounds();
    let middle = low + (high - low) / 2.0;
    let [_, top] = solid.extent(&direction);
    let from: Point3<f64> = middle + direction * (top - middle.coords.dot(&direction));
    let (along, half) = (direction * length, 0.03 * length);
    let tip = from + along;
    scene.bar(from, tip, half, ARROW);
    let side = if direction.z.abs() < 0.9 { along.cross(&Vector3::z()) } else { along.cross(&Vector3::x()) };
    let (u, v) = (side.normalize() * 3.0 * half, along.cross(&side).normalize() * 3.0 * half);
    let base = tip - along * 0.25;
    let ring = [u, v, -u, -v];
    scene.triangles((0..4).map(|k| ([base + ring[k], base + ring[(k + 1) % 4], tip], ARROW)));
}
