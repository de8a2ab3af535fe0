//! Pictures of the surfaces: the part while it is built, single surfaces, and how far apart they lie.

use crate::field::FieldRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::render::{Camera, Image, Scene, layer_colour};
use curvlay_layers::curved::surface::Spacing;
use nalgebra::Vector3;

/// Pictures of the part while it is built.
const FRAMES: usize = 10;

/// Pixels of each of them.
const FRAME: [u32; 2] = [520, 480];

/// Pixels of the histogram.
const HISTOGRAM: [u32; 2] = [640, 300];

const PLAIN: [u8; 3] = [190, 196, 204];
const EVEN: [u8; 3] = [11, 122, 117];
const INK: [u8; 3] = [31, 38, 48];

/// A picture and the line under it.
pub type Picture = (String, Vec<u8>);

fn from_the_front() -> Camera {
    Camera::from_direction(Vector3::new(0.6, -1.0, 0.45))
}

/// The part when a tenth, two tenths, ... of its surfaces are there.
pub fn frames(field: &FieldRun, run: &SurfacesRun) -> Vec<Picture> {
    let layers = run.sheets.len();
    (1..=FRAMES)
        .map(|frame| (layers * frame).div_ceil(FRAMES))
        .map(|until| (format!("{until} of {layers} layers"), draw(field, run, 0..until)))
        .collect()
}

/// Three single surfaces: of those that are a quarter, half and three quarters up.
pub fn singles(field: &FieldRun, run: &SurfacesRun) -> Vec<Picture> {
    let layers = run.sheets.len();
    [1, 2, 3]
        .map(|quarter| (layers * quarter / 4).min(layers.saturating_sub(1)))
        .map(|at| (format!("layer {}", at + 1), draw(field, run, at..at + 1)))
        .to_vec()
}

fn draw(field: &FieldRun, run: &SurfacesRun, which: std::ops::Range<usize>) -> Vec<u8> {
    let mut scene = Scene::new(from_the_front());
    // The platform keeps the part in its place from picture to picture.
    let grid = &field.solid.grid;
    let corner = |c: [i32; 2]| [0, 1].map(|axis| grid.origin()[axis] + f64::from(c[axis]) / 2.0 * grid.cell_mm());
    let corners: Vec<[f64; 2]> = field.platform.corners().iter().map(|&c| corner(c)).collect();
    scene.platform(&corners, 0.0);
    let layers = run.sheets.len() as u32;
    for at in which {
        let Some(sheet) = run.sheets.get(at) else { continue };
        let corners = sheet.triangles.iter().map(|corners| corners.map(|corner| sheet.vertices[corner as usize]));
        let colour = layer_colour(at as u32 + 1, layers);
        scene.triangles(corners.map(|corners| (corners, colour)));
    }
    let [width, height] = FRAME;
    scene.draw(width, height).to_png()
}

/// Area by spacing, for the field of hop counts (grey) and for the even one (green), as Dai 2020, Fig. 3.18.
pub fn histogram(run: &SurfacesRun) -> Picture {
    let [width, height] = HISTOGRAM;
    let mut image = Image::new(width, height, [255; 3]);
    let (left, foot) = (20, height - 30);
    let share = |spacing: &Spacing| -> Vec<f64> {
        let all: f64 = spacing.histogram_mm2.iter().sum();
        spacing.histogram_mm2.iter().map(|area| if all > 0.0 { area / all } else { 0.0 }).collect()
    };
    let shares = [(share(&run.plain_spacing), PLAIN), (share(&run.spacing), EVEN)];
    let highest = shares.iter().flat_map(|(shares, _)| shares).copied().fold(f64::MIN_POSITIVE, f64::max);
    let bars = run.spacing.histogram_mm2.len().max(1) as u32;
    let wide = (width - 2 * left) / bars;
    for (which, (shares, colour)) in (0..).zip(&shares) {
        for (bar, share) in (0..).zip(shares) {
            let tall = (share / highest * f64::from(foot - 20)).round() as u32;
            image.fill([left + bar * wide + which * wide / 2, foot - tall], [wide.div_ceil(2), tall], *colour);
        }
    }
    image.fill([left, foot], [bars * wide, 2], INK);
    for tick in 0..=3 {
        let text = format!("{:.2}", f64::from(tick) * run.height_mm);
        let at = left + tick * bars * wide / 3;
        image.fill([at, foot], [2, 6], INK);
        image.write([at.saturating_sub(Image::text_size(&text)[0] / 2), foot + 10], &text, INK);
    }
    ("spacing in mm by area: hop counts grey, even layers green".to_owned(), image.to_png())
}
