//! Pictures: skeleton, thickness, segments and their graph; the parts in colours, and each step of the sequence.

use super::decompose::Divided;
use curvlay_examples::nalgebra::{Point3, Vector3};
use curvlay_examples::render::{Camera, Rgb, Scene, ramp};
use curvlay_layers::planar::Solid;
use curvlay_layers::planar::robofdm::PlannedPart;
use std::fmt::Write;

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

/// What stands there before the parts: the pedestal, if there is one.
fn begun(divided: &Divided) -> Scene {
    let mut scene = scene();
    if let Some(pedestal) = &divided.pedestal {
        let (vertices, triangles) = pedestal.mesh();
        scene.mesh(&vertices, &triangles, GREY);
    }
    scene
}

/// All parts with their directions, on their pedestal.
pub fn parts(divided: &Divided) -> Vec<u8> {
    let mut scene = begun(divided);
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
    let mut scene = begun(divided);
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

/// Pictures of the segmentation, by file, with their captions: Fig. 2.4 of the dissertation.
pub const SEGMENTS: [(&str, &str); 3] = [
    ("skeleton.png", "the skeleton, in the shell of the part that is behind it"),
    ("diameter.png", "the distance of the surface from the skeleton: light is thick"),
    ("segments.png", "the segments, with their numbers"),
];

/// These pictures.
pub fn segments(divided: &Divided) -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let [width, height] = PICTURE;
    let all = [skeleton(divided), diameter(divided), numbered(divided)];
    let drawn = all.map(|scene| scene.draw(width, height).to_png());
    SEGMENTS.into_iter().zip(drawn).map(|((name, caption), png)| (name, caption, png)).collect()
}

/// The corners of a facet.
fn corners(divided: &Divided, facet: usize) -> [Point3<f64>; 3] {
    divided.mesh.triangles[facet].map(|corner| divided.mesh.vertices[corner as usize])
}

fn skeleton(divided: &Divided) -> Scene {
    let mut scene = scene();
    let toward = scene.camera().toward();
    // What looks away from the viewer is behind the skeleton.
    let behind = (0..divided.mesh.triangles.len())
        .map(|facet| corners(divided, facet))
        .filter(|[a, b, c]| (b - a).cross(&(c - a)).dot(&toward) < 0.0);
    scene.triangles(behind.map(|facet| (facet, GREY)));
    let skeleton = &divided.segmentation.skeleton;
    let half = 0.004 * size(&divided.solid);
    for [a, b] in &skeleton.edges {
        let [from, to] = [a, b].map(|node| divided.placed * skeleton.nodes[*node as usize]);
        scene.bar(from, to, half, ARROW);
    }
    scene
}

fn diameter(divided: &Divided) -> Scene {
    let mut scene = scene();
    let thickness = &divided.segmentation.thickness;
    let most = thickness.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    scene.triangles(thickness.iter().enumerate().map(|(facet, thick)| (corners(divided, facet), ramp(thick / most))));
    scene
}

fn numbered(divided: &Divided) -> Scene {
    let mut scene = scene();
    let segmentation = &divided.segmentation;
    scene.triangles(
        segmentation
            .part_of
            .iter()
            .enumerate()
            .map(|(facet, &part)| (corners(divided, facet), colour(part as usize, segmentation.parts))),
    );
    for part in 0..segmentation.parts {
        if let Some(at) = seen(divided, part as u32) {
            scene.label(at, &part.to_string());
        }
    }
    scene
}

/// A place of a segment that is seen: of its facets that look at the viewer, the one nearest to the middle of all of these.
fn seen(divided: &Divided, part: u32) -> Option<Point3<f64>> {
    let toward = scene().camera().toward();
    let facets = divided.segmentation.part_of.iter().enumerate().filter(|(_, of)| **of == part);
    let facets = facets.map(|(facet, _)| corners(divided, facet));
    let middle = |[a, b, c]: &[Point3<f64>; 3]| Point3::from((a.coords + b.coords + c.coords) / 3.0);
    let weight = |[a, b, c]: &[Point3<f64>; 3]| (b - a).cross(&(c - a)).dot(&toward).max(0.0);
    let facing: Vec<(Point3<f64>, f64)> =
        facets.map(|facet| (middle(&facet), weight(&facet))).filter(|(_, weight)| *weight > 0.0).collect();
    let sum: f64 = facing.iter().map(|(_, weight)| weight).sum();
    let mean: Vector3<f64> = facing.iter().map(|(at, weight)| at.coords * (weight / sum)).sum();
    let far = |at: &Point3<f64>| (at.coords - mean).norm();
    facing.iter().map(|(at, _)| *at).min_by(|a, b| far(a).total_cmp(&far(b)))
}

/// The sequence as a graph, Fig. 2.5: a row for each segment's distance from a root.
pub fn graph(divided: &Divided) -> String {
    const ROW: f64 = 78.0;
    const COLUMN: f64 = 118.0;
    const RADIUS: f64 = 17.0;
    let parts = &divided.sequence.parts;
    let place = |part: u32| parts.iter().position(|planned| planned.part == part);
    let depth = |planned: &PlannedPart| {
        let mut depth = 0;
        let mut at = planned;
        // The sequence has parents before children, so this ends.
        while let Some(parent) = at.parent.and_then(place).filter(|_| depth < parts.len()) {
            (depth, at) = (depth + 1, &parts[parent]);
        }
        depth
    };
    let depths: Vec<usize> = parts.iter().map(depth).collect();
    let mut in_row = vec![0usize; depths.iter().max().map_or(1, |deepest| deepest + 1)];
    let columns: Vec<usize> = depths
        .iter()
        .map(|&depth| {
            in_row[depth] += 1;
            in_row[depth] - 1
        })
        .collect();
    let widest = in_row.iter().copied().max().unwrap_or(1) as f64;
    let (width, height) = ((widest * COLUMN).max(7.0 * COLUMN), in_row.len() as f64 * ROW);
    let spot = |k: usize| {
        let row = in_row[depths[k]] as f64;
        [width / 2.0 + (columns[k] as f64 - (row - 1.0) / 2.0) * COLUMN, (depths[k] as f64 + 0.38) * ROW]
    };
    let mut svg = format!("<svg viewBox=\"0 0 {width} {height}\" role=\"img\">");
    for (k, planned) in parts.iter().enumerate() {
        if let Some(parent) = planned.parent.and_then(place) {
            let ([x, y], [px, py]) = (spot(k), spot(parent));
            let _ = write!(svg, "\n<path class=\"grid\" d=\"M{px:.1} {py:.1}L{x:.1} {y:.1}\"/>");
        }
    }
    for (k, planned) in parts.iter().enumerate() {
        let ([x, y], [r, g, b]) = (spot(k), colour(planned.part as usize, divided.segmentation.parts));
        let dark = u32::from(r) * 3 + u32::from(g) * 6 + u32::from(b) < 1100;
        let ink = if dark { "#ffffff" } else { "#1f2630" };
        let _ = write!(
            svg,
            "\n<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{RADIUS}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>\
             <text class=\"x\" x=\"{x:.1}\" y=\"{:.1}\" style=\"fill:{ink}\">{}</text>\
             <text class=\"x\" x=\"{x:.1}\" y=\"{:.1}\">step {}, {:.0} mm2</text>",
            y + 4.0,
            planned.part,
            y + RADIUS + 13.0,
            k + 1,
            planned.risky_mm2
        );
    }
    svg + "</svg>"
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
