//! Pictures: what was found in each step, and the parts in the order in which they are printed.

use super::volumes::Divided;
use curvlay_examples::nalgebra::{Point3, Vector3};
use curvlay_examples::render::{Camera, Rgb, Scene, ramp};
use curvlay_layers::planar::{Separation, SeparationWall, Solid};

/// Pixels of each picture.
const PICTURE: [u32; 2] = [520, 460];
const CARRIED: Rgb = [40, 150, 70];
const OVERHANG: Rgb = [215, 40, 40];
const POINT: Rgb = [30, 30, 30];
const LINE: Rgb = [235, 180, 0];
const WALL: Rgb = [70, 110, 220];
const TILTED: Rgb = [165, 170, 178];
const ARROW: Rgb = [200, 30, 30];

fn size(solid: &Solid) -> f64 {
    let [low, high] = solid.bounds();
    (high - low).norm()
}

fn camera() -> Camera {
    Camera::from_direction(Vector3::new(0.6, -1.0, 0.45))
}

/// Outlines of the layers, the intersection points, and the walls: Fig. 2b and 3 of the paper.
pub fn step(step: &Separation) -> Vec<u8> {
    let mut scene = Scene::new(camera());
    let thin = 0.0016 * size(&step.solid);
    for (outlines, colour, half) in [(&step.carried, CARRIED, thin), (&step.overhang, OVERHANG, 1.6 * thin)] {
        for outline in outlines {
            for k in 0..outline.len() {
                scene.bar(outline[k], outline[(k + 1) % outline.len()], half, colour);
            }
        }
    }
    for &point in &step.points {
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            scene.bar(point - axis * (5.0 * thin), point + axis * (5.0 * thin), 2.0 * thin, POINT);
        }
    }
    if let Some(corners) = step.rectangle {
        for k in 0..4 {
            scene.bar(corners[k], corners[(k + 1) % 4], 2.5 * thin, LINE);
        }
    }
    for wall in &step.walls {
        draw_wall(&mut scene, wall, step, thin);
    }
    let [width, height] = PICTURE;
    scene.draw(width, height).to_png()
}

/// The upright wall above the first layer with overhang and the tilted one below, as frames, as wide as the part, and the line
/// between them.
fn draw_wall(scene: &mut Scene, wall: &SeparationWall, step: &Separation, thin: f64) {
    let (d, n) = (step.direction, wall.upright.normal());
    let t = d.cross(&n).normalize();
    let [low, high] = step.solid.extent(&t);
    let [_, top] = step.solid.extent(&d);
    // Along the wall, which may lean, to the height of its lower edge.
    let rise = (d - n * n.dot(&d)).normalize();
    let foot = n * wall.upright.offset();
    let lower = foot + rise * ((step.height_mm - foot.dot(&d)) / rise.dot(&d));
    let edge = |along: f64| Point3::from(lower + t * (along - lower.dot(&t)));
    let down = t.cross(&wall.tilted.normal());
    let down = down * (0.12 * size(&step.solid) * if down.dot(&d) > 0.0 { -1.0 } else { 1.0 });
    let margin = 0.04 * (high - low);
    let ends = [edge(low - margin), edge(high + margin)];
    let up = rise * ((top - step.height_mm).max(0.0) * 1.05 / rise.dot(&d));
    let mut frame = |shift: Vector3<f64>, colour: Rgb| {
        for end in ends {
            scene.bar(end, end + shift, 1.5 * thin, colour);
        }
        scene.bar(ends[0] + shift, ends[1] + shift, 1.5 * thin, colour);
    };
    frame(up, WALL);
    frame(down, TILTED);
    scene.bar(ends[0], ends[1], 2.5 * thin, LINE);
}

/// The first parts in colours, each with an arrow along its direction.
pub fn parts(divided: &Divided, count: usize) -> Vec<u8> {
    let mut scene = Scene::new(camera());
    let all = &divided.result.parts;
    let length = 0.22 * size(&divided.solid);
    for (k, part) in all.iter().take(count).enumerate() {
        let share = k as f64 / (all.len().max(2) - 1) as f64;
        scene.mesh(part.solid.vertices(), part.solid.triangles(), ramp(0.15 + 0.75 * share));
        let [low, high] = part.solid.bounds();
        let middle = low + (high - low) / 2.0;
        let [_, top] = part.solid.extent(&part.direction);
        let from = middle + part.direction * (top - middle.coords.dot(&part.direction));
        arrow(&mut scene, from, part.direction * length);
    }
    let [width, height] = PICTURE;
    scene.draw(width, height).to_png()
}

/// The outlines of all layers, in the colours of their parts.
pub fn layers(divided: &Divided) -> Vec<u8> {
    let mut scene = Scene::new(camera());
    let all = &divided.result.parts;
    let thin = 0.0012 * size(&divided.solid);
    for (k, part) in all.iter().enumerate() {
        let colour = ramp(0.15 + 0.75 * k as f64 / (all.len().max(2) - 1) as f64);
        for layer in &part.layers {
            let up = part.direction * ((layer.low_mm + layer.high_mm) / 2.0 - part.base_mm);
            for [a, b] in layer.section.edges() {
                scene.bar(part.frame.place(&a) + up, part.frame.place(&b) + up, thin, colour);
            }
        }
    }
    let [width, height] = PICTURE;
    scene.draw(width, height).to_png()
}

fn arrow(scene: &mut Scene, from: Point3<f64>, along: Vector3<f64>) {
    let half = 0.03 * along.norm();
    let tip = from + along;
    scene.bar(from, tip, half, ARROW);
    let side = if along.normalize().z.abs() < 0.9 { along.cross(&Vector3::z()) } else { along.cross(&Vector3::x()) };
    let (u, v) = (side.normalize() * 3.0 * half, along.cross(&side).normalize() * 3.0 * half);
    let base = tip - along * 0.25;
    let ring = [u, v, -u, -v];
    scene.triangles((0..4).map(|k| ([base + ring[k], base + ring[(k + 1) % 4], tip], ARROW)));
}
