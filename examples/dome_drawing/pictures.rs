//! Pictures of each stage.

use super::plan::Planned;
use curvlay_examples::render::{Camera, INK, Rgb, Scene, layer_colour, ramp};
use curvlay_kinematics::nalgebra::{Point2, Point3, Vector3};
use curvlay_toolpath::drawing::{StrokeKind, distortion};
use std::f64::consts::TAU;

/// Names of the pictures, in the order of the stages.
pub const NAMES: [&str; 6] = ["input", "contours", "regions", "fill", "dome", "distortion"];

/// Pixels of each picture.
const PICTURE: [u32; 2] = [760, 760];
const OPEN: Rgb = [232, 98, 20];
const DOME: Rgb = [222, 224, 228];

/// Points nearer than this are left out of pictures, as a share of the width of the design.
const DETAIL: f64 = 0.002;

/// The pictures, as [`NAMES`] has them.
pub fn draw(planned: &Planned) -> Vec<Vec<u8>> {
    let reach =
        planned.contours.iter().flat_map(|contour| &contour.points).map(|at| at.coords.norm()).fold(1.0, f64::max);
    let scenes = [
        input(planned, reach),
        contours(planned, reach),
        regions(planned, reach),
        fill(planned, reach),
        on_surface(planned, reach),
        distorted(planned),
    ];
    scenes.iter().map(png).collect()
}

/// Half the width of a thin line: pictures show the whole design.
fn fine(reach: f64) -> f64 {
    0.0015 * reach
}

/// The lines of the file, each in a colour of its own.
fn input(planned: &Planned, reach: f64) -> Scene {
    let mut scene = flat();
    for (k, piece) in planned.pieces.iter().enumerate() {
        line(&mut scene, &piece.points, piece.closed, fine(reach) * 1.5, layer_colour(k as u32 % 12 + 1, 12), reach);
    }
    scene
}

/// The lines joined: open ones stand out, on top.
fn contours(planned: &Planned, reach: f64) -> Scene {
    let mut scene = flat();
    for closed in [true, false] {
        for contour in planned.contours.iter().filter(|contour| contour.closed == closed) {
            line(&mut scene, &contour.points, closed, fine(reach) * 1.5, if closed { INK } else { OPEN }, reach);
        }
    }
    scene
}

/// The regions without overlaps, and open contours.
fn regions(planned: &Planned, reach: f64) -> Scene {
    let mut scene = flat();
    for (k, region) in planned.overlaps.regions.iter().enumerate() {
        let colour = layer_colour(k as u32 % 12 + 1, 12);
        for ring in region.rings() {
            line(&mut scene, ring, true, fine(reach) * 2.0, colour, reach);
        }
    }
    for contour in &planned.overlaps.open {
        line(&mut scene, &contour.points, false, fine(reach) * 1.5, OPEN, reach);
    }
    scene
}

/// The beads in the plane, with a mark where each begins.
fn fill(planned: &Planned, reach: f64) -> Scene {
    let mut scene = flat();
    for (k, stroke) in planned.filled.strokes.iter().enumerate() {
        let colour = if stroke.kind == StrokeKind::Open { OPEN } else { ramp((k % 7) as f64 / 7.0) };
        // A little narrower, so that neighbours are distinguishable.
        line(&mut scene, &stroke.points, stroke.closed, 0.42 * stroke.width, colour, reach);
        if let Some(at) = stroke.points.first() {
            let at = Point3::new(at.x, at.y, stroke.width);
            let mark = fine(reach) * 3.0;
            scene.bar(at - Vector3::x() * mark, at + Vector3::x() * mark, mark, INK);
        }
    }
    scene
}

/// The beads on the surface.
fn on_surface(planned: &Planned, reach: f64) -> Scene {
    let mut scene = Scene::new(Camera::from_direction(Vector3::new(0.55, -1.0, 0.75)));
    surface(&mut scene, planned, |_| DOME);
    for (k, on_surface) in planned.strokes.iter().enumerate() {
        let stroke = planned.flat(on_surface);
        let colour = if stroke.kind == StrokeKind::Open { OPEN } else { ramp((k % 7) as f64 / 7.0) };
        let mut last: Option<Point3<f64>> = None;
        for at in &on_surface.points {
            let here = at.position + at.normal.into_inner() * 0.5;
            match last {
                Some(last) if (here - last).norm() < DETAIL * reach => continue,
                Some(last) => _ = scene.bar(last, here, 0.42 * stroke.width.min(4.0), colour),
                None => {}
            }
            last = Some(here);
        }
    }
    scene
}

/// How the projection distorts, as a share of the most.
fn distorted(planned: &Planned) -> Scene {
    let mut scene = flat();
    let most = planned.distortion.largest.max(1e-9);
    surface(&mut scene, planned, |at| {
        ramp((distortion(&planned.carrier, planned.projection, &[at]).largest / most).min(1.0))
    });
    scene
}

fn flat() -> Scene {
    Scene::new(Camera::from_direction(Vector3::z()))
}

fn png(scene: &Scene) -> Vec<u8> {
    scene.draw(PICTURE[0], PICTURE[1]).to_png()
}

fn line(scene: &mut Scene, points: &[Point2<f64>], closed: bool, half: f64, colour: Rgb, reach: f64) {
    let back = points[..usize::from(closed).min(points.len())].iter();
    let mut last: Option<Point3<f64>> = None;
    let end = points.len() - usize::from(!points.is_empty());
    for (k, at) in points.iter().chain(back).enumerate() {
        let here = Point3::new(at.x, at.y, 0.0);
        match last {
            Some(last) if (here - last).norm() < DETAIL * reach && k < end => continue,
            Some(last) => _ = scene.bar(last, here, half, colour),
            None => {}
        }
        last = Some(here);
    }
}

/// Draws the surface under the design.
fn surface(scene: &mut Scene, planned: &Planned, colour: impl Fn(Point2<f64>) -> Rgb) {
    patches(planned, |on, middle| {
        let colour = colour(middle);
        scene.triangles([([on[0], on[1], on[2]], colour), ([on[0], on[2], on[3]], colour)]);
    });
}

/// The surface under the design in patches, ring by ring: the corners of each, and the middle of it in the design.
fn patches(planned: &Planned, mut each: impl FnMut([Point3<f64>; 4], Point2<f64>)) {
    let (rings, sides) = (40u32, 120u32);
    let reach =
        planned.contours.iter().flat_map(|contour| &contour.points).map(|at| at.coords.norm()).fold(1.0, f64::max);
    let place = |ring: u32, k: u32| {
        let (r, a) = (reach * f64::from(ring) / f64::from(rings), TAU * f64::from(k) / f64::from(sides));
        Point2::new(r * a.cos(), r * a.sin())
    };
    for ring in 0..rings {
        for k in 0..sides {
            let corners = [place(ring, k), place(ring + 1, k), place(ring + 1, k + 1), place(ring, k + 1)];
            let on: Vec<Point3<f64>> = corners
                .iter()
                .filter_map(|at| planned.projection.of(&planned.carrier, at).map(|hit| hit.position))
                .collect();
            if let Ok(on) = on.try_into() {
                each(on, middle_of(&corners));
            }
        }
    }
}

/// The surface under the design as triangles.
pub fn mesh_of(planned: &Planned) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    patches(planned, |on, _| {
        let first = vertices.len() as u32;
        vertices.extend(on);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    });
    (vertices, triangles)
}

fn middle_of(corners: &[Point2<f64>; 4]) -> Point2<f64> {
    Point2::from(corners.iter().map(|at| at.coords).sum::<curvlay_kinematics::nalgebra::Vector2<f64>>() / 4.0)
}
