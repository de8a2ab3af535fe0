//! Pictures: the part while it is built, single surfaces, how far apart they lie; paths and the distance they follow.

use super::shown::Picture;
use crate::field::FieldRun;
use crate::machine::MachineRun;
use crate::paths::{PathsRun, curves};
use crate::surfaces::SurfacesRun;
use curvlay_examples::count::counted;
use curvlay_examples::render::{Camera, Image, Scene, layer_colour, ramp};
use curvlay_layers::curved::surface::Spacing;
use curvlay_layers::trim::TrimmedSheet;
use curvlay_toolpath::geodesic::SurfaceDistance;
use curvlay_toolpath::mesh::SurfaceMesh;
use nalgebra::{Point3, Vector3};
use std::ops::ControlFlow;

/// Pictures of the part while it is built, for where the viewer does not run.
const FRAMES: usize = 5;

/// Pixels of each of them.
const FRAME: [u32; 2] = [520, 480];

/// Pixels of a picture of paths.
const PATHS: [u32; 2] = [820, 760];

/// Half the thickness of a drawn path, in beads.
const LINE: f64 = 0.22;

/// Pixels of the histogram.
const HISTOGRAM: [u32; 2] = [640, 300];

/// What the plain method gives.
pub const PLAIN: [u8; 3] = [190, 196, 204];
/// What ours gives.
pub const EVEN: [u8; 3] = [11, 122, 117];
/// What is wrong.
const FAULT: [u8; 3] = [200, 30, 30];
const INK: [u8; 3] = [31, 38, 48];
/// Support: a colour that no layer has.
const SUPPORT: [u8; 3] = [224, 112, 32];

fn from_the_front() -> Camera {
    Camera::from_direction(Vector3::new(0.6, -1.0, 0.45))
}

/// The part when a fifth, two fifths, ... of its surfaces are there.
pub fn frames(field: &FieldRun, run: &SurfacesRun) -> Vec<Picture> {
    let layers = run.sheets.len();
    let until: Vec<usize> = (1..=FRAMES).map(|frame| (layers * frame).div_ceil(FRAMES)).collect();
    let [width, height] = FRAME;
    let drawn = stage(field).draw_growing(&until, |at, scene| add(scene, run, at), width, height);
    let captions = until.iter().map(|until| format!("{until} of {}", counted(layers, "layer")));
    captions.zip(drawn.iter().map(Image::to_png)).collect()
}

/// Three single surfaces.
pub fn singles(field: &FieldRun, run: &SurfacesRun) -> Vec<Picture> {
    let [width, height] = FRAME;
    let single = |at: usize| {
        let mut scene = stage(field);
        add(&mut scene, run, at);
        (format!("layer {}", at + 1), scene.draw(width, height).to_png())
    };
    quarters(run).map(single).to_vec()
}

/// The surfaces that are a quarter, half and three quarters up.
pub fn quarters(run: &SurfacesRun) -> [usize; 3] {
    let layers = run.sheets.len();
    [1, 2, 3].map(|quarter| (layers * quarter / 4).min(layers.saturating_sub(1)))
}

/// The platform, which keeps the part in its place from picture to picture, and the mould.
fn stage(field: &FieldRun) -> Scene {
    let mut scene = Scene::new(from_the_front());
    let grid = &field.solid.grid;
    let corner = |c: [i32; 2]| [0, 1].map(|axis| grid.origin()[axis] + f64::from(c[axis]) / 2.0 * grid.cell_mm());
    let corners: Vec<[f64; 2]> = field.platform.corners().iter().map(|&c| corner(c)).collect();
    scene.platform(&corners, 0.0);
    if let Some(mould) = &field.mould {
        scene.mesh(&mould.vertices, &mould.triangles, PLAIN);
    }
    scene
}

/// Adds a surface, and the support beside it.
fn add(scene: &mut Scene, run: &SurfacesRun, at: usize) {
    let Some(sheet) = run.sheets.get(at) else { return };
    let corners = sheet.triangles.iter().map(|corners| corners.map(|corner| sheet.vertices[corner as usize]));
    let colour = layer_colour(at as u32 + 1, run.sheets.len() as u32);
    scene.triangles(corners.map(|corners| (corners, colour)));
    if let Some(sheet) = run.support.as_ref().and_then(|support| support.surfaces.sheets.get(at)) {
        scene.mesh(&sheet.vertices, &sheet.triangles, SUPPORT);
    }
}

/// The curves of one surface, seen along its mean normal.
pub fn paths(surfaces: &SurfacesRun, run: &PathsRun, at: usize) -> Option<Picture> {
    let (sheet, layer) = (surfaces.sheets.get(at)?, run.filled.layers.get(at)?.as_ref()?);
    let mut scene = Scene::new(facing(sheet));
    scene.mesh(&sheet.vertices, &sheet.triangles, PLAIN);
    // Lifted off the surface, so that it does not hide half of them.
    let lift = scene.camera().toward() * (0.5 * run.bead_mm);
    if let Some(sheet) = surfaces.support.as_ref().and_then(|support| support.surfaces.sheets.get(at)) {
        scene.mesh(&sheet.vertices, &sheet.triangles, PLAIN);
    }
    for (path, curve) in layer.paths.paths.iter().zip(curves(layer)) {
        let is_support = path.points.iter().any(|point| point.kind.is_support());
        let steps = curve.len().max(2) - 1;
        for (step, ends) in curve.windows(2).enumerate() {
            let colour = if is_support { SUPPORT } else { ramp(step as f64 / steps as f64) };
            scene.bar(ends[0] + lift, ends[1] + lift, LINE * run.bead_mm, colour);
        }
    }
    let [width, height] = PATHS;
    let caption =
        format!("layer {}: {}, {:.0} mm", at + 1, counted(layer.paths.paths.len(), "curve"), layer.statistics.path_mm);
    Some((caption, scene.draw(width, height).to_png()))
}

/// The beads of the layer with the most unsupported ones, these in red; none where all are supported.
pub fn unsupported(surfaces: &SurfacesRun, paths: &PathsRun, run: &MachineRun) -> Option<Picture> {
    let mut lengths = vec![0.0; surfaces.sheets.len()];
    for piece in &run.support.unsupported {
        lengths[run.resolved.paths[piece.path].layer as usize] += piece.length();
    }
    let (at, &most) = lengths.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)))?;
    let sheet = surfaces.sheets.get(at).filter(|_| most > 0.0)?;
    let mut scene = Scene::new(facing(sheet));
    scene.mesh(&sheet.vertices, &sheet.triangles, PLAIN);
    let lift = scene.camera().toward() * (0.5 * paths.bead_mm);
    let mut bar = |from: Point3<f64>, to: Point3<f64>, thick: f64, colour: [u8; 3]| {
        scene.bar(from + lift, to + lift, thick * LINE * paths.bead_mm, colour);
    };
    for (number, path) in run.resolved.paths.iter().enumerate().filter(|(_, path)| path.layer as usize == at) {
        path.waypoints.windows(2).for_each(|pair| bar(pair[0].position, pair[1].position, 1.0, EVEN));
        for piece in run.support.unsupported.iter().filter(|piece| piece.path == number) {
            // A mark in its middle, too: a piece may be shorter than the way between two waypoints.
            let inside = |arc: f64| arc > piece.arcs[0] && arc < piece.arcs[1];
            let whole = path.waypoints.windows(2).filter(|pair| pair.iter().all(|waypoint| inside(waypoint.arc)));
            whole.for_each(|pair| bar(pair[0].position, pair[1].position, 2.0, FAULT));
            bar(piece.tip, piece.tip + lift * 0.1, 2.0, FAULT);
        }
    }
    let [width, height] = PATHS;
    Some((format!("layer {}: {most:.1} mm of unsupported beads, red", at + 1), scene.draw(width, height).to_png()))
}

/// The geodesic distance to the boundary of one surface, in bands of a bead.
pub fn distance(surfaces: &SurfacesRun, run: &PathsRun, at: usize) -> Option<Picture> {
    let sheet = surfaces.sheets.get(at)?;
    let mesh = SurfaceMesh::new(sheet.vertices.clone(), sheet.triangles.clone()).ok()?;
    let distance = SurfaceDistance::to_boundary(&mesh, &|_| ControlFlow::Continue(())).ok()?;
    let reach = distance.at_vertices().iter().copied().filter(|value| value.is_finite()).fold(0.0, f64::max);
    let band = |value: f64| 1 + (value / run.bead_mm) as u32;
    let mut scene = Scene::new(facing(sheet));
    for triangle in 0..mesh.triangles().len() as u32 {
        scene.triangles(PATCHES.iter().map(|corners| {
            let middle = [0, 1, 2].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0);
            let colour = layer_colour(band(distance.at(triangle, middle).distance), band(reach));
            (corners.map(|corner| mesh.point(triangle, corner)), colour)
        }));
    }
    let [width, height] = PATHS;
    Some((format!("layer {}: up to {reach:.2} mm", at + 1), scene.draw(width, height).to_png()))
}

/// A triangle in four, by barycentric coordinates.
const PATCHES: [[[f64; 3]; 3]; 4] = {
    const A: [f64; 3] = [1.0, 0.0, 0.0];
    const B: [f64; 3] = [0.0, 1.0, 0.0];
    const C: [f64; 3] = [0.0, 0.0, 1.0];
    const AB: [f64; 3] = [0.5, 0.5, 0.0];
    const BC: [f64; 3] = [0.0, 0.5, 0.5];
    const CA: [f64; 3] = [0.5, 0.0, 0.5];
    [[A, AB, CA], [AB, B, BC], [CA, BC, C], [AB, BC, CA]]
};

/// From where a surface is seen best.
fn facing(sheet: &TrimmedSheet) -> Camera {
    let normal = |corners: &[u32; 3]| {
        let [a, b, c]: [Point3<f64>; 3] = corners.map(|corner| sheet.vertices[corner as usize]);
        (b - a).cross(&(c - a))
    };
    let sum: Vector3<f64> = sheet.triangles.iter().map(normal).sum();
    // Not straight along it: shading shows the shape.
    Camera::from_direction(sum.normalize() + Vector3::new(0.1, -0.25, 0.1))
}

/// Area by spacing, for the field of hop counts (grey) if there is one and for the even one (green), as Dai 2020, Fig. 3.18.
pub fn histogram(run: &SurfacesRun) -> Picture {
    let [width, height] = HISTOGRAM;
    let mut image = Image::new(width, height, [255; 3]);
    let (left, foot) = (20, height - 30);
    let share = |spacing: &Spacing| -> Vec<f64> {
        let all: f64 = spacing.histogram_mm2.iter().sum();
        spacing.histogram_mm2.iter().map(|area| if all > 0.0 { area / all } else { 0.0 }).collect()
    };
    let shares: Vec<_> =
        run.plain_spacing.iter().map(|plain| (share(plain), PLAIN)).chain([(share(&run.spacing), EVEN)]).collect();
    let highest = shares.iter().flat_map(|(shares, _)| shares).copied().fold(f64::MIN_POSITIVE, f64::max);
    let bars = run.spacing.histogram_mm2.len().max(1) as u32;
    let wide = (width - 2 * left) / bars;
    let count = shares.len() as u32;
    for (which, (shares, colour)) in (0..).zip(&shares) {
        for (bar, share) in (0..).zip(shares) {
            let tall = (share / highest * f64::from(foot - 20)).round() as u32;
            image.fill([left + bar * wide + which * wide / count, foot - tall], [wide.div_ceil(count), tall], *colour);
        }
    }
    image.fill([left, foot], [bars * wide, 2], INK);
    for tick in 0..=3 {
        let text = format!("{:.2}", f64::from(tick) * run.height_mm);
        let at = left + tick * bars * wide / 3;
        image.fill([at, foot], [2, 6], INK);
        let written = Image::text_size(&text)[0];
        image.write([at.saturating_sub(written / 2).min(width.saturating_sub(written)), foot + 10], &text, INK);
    }
    let caption = match run.plain_spacing {
        Some(_) => "spacing in mm by area: hop counts grey, uniform layers green",
        None => "spacing in mm by area",
    };
    (caption.to_owned(), image.to_png())
}
