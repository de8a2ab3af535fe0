//! A path made in code: a spiral over a free-form patch, like the synthetic paths of C. Dai, *Material Deposition in 3D Space*
//! (dissertation, TU Delft 2020), chapter 4.

use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;

/// Places and directions of growth, in the order of travel.
pub type Path6 = (Vec<Point3<f64>>, Vec<Vector3<f64>>);

/// Distance of waypoints along the spiral, and of its lines: those of the synthetic paths that the figures use.
const STEP_MM: f64 = 0.8843;
const LINES_MM: f64 = 1.2;

/// How the arms leave the middle: they begin like Fermat's spiral and are evenly spaced soon after.
const OPENING: f64 = 80.0;

/// The arms are measured in this many pieces a step.
const PIECES: usize = 64;

/// A patch with a rounded crest across it and a slow wave: height and slopes.
fn patch(x: f64, y: f64, rounding: f64) -> (f64, f64, f64) {
    let (sin, cos) = 0.4f64.sin_cos();
    let across = x * cos + y * sin + 3.0;
    let bent = across.hypot(rounding);
    let slope = 0.5 * across / bent;
    let (wave, wave_slope) = (2.0 * (y / 14.0).sin(), 2.0 / 14.0 * (y / 14.0).cos());
    (-0.5 * bent + wave, -slope * cos, -slope * sin + wave_slope)
}

/// In on one arm of a spiral, round an S and out on the other, in equal steps along the surface: `count` waypoints 0.88 mm apart over
/// a patch whose crest is rounded by `rounding` millimetres.
pub fn spiral(count: usize, rounding: f64) -> Path6 {
    let scale = LINES_MM / PI;
    let flat = |phi: f64, half: f64| {
        let radius = scale * (phi * phi + 2.0 * OPENING * phi).sqrt();
        let (sin, cos) = (phi + half).sin_cos();
        (radius * cos, radius * sin)
    };
    let place = |(x, y): (f64, f64)| {
        let (z, along_x, along_y) = patch(x, y, rounding);
        (Point3::new(x, y, z), Vector3::new(-along_x, -along_y, 1.0).normalize())
    };
    // Both arms outwards, each with every second half of the waypoints; an even number leaves out the middle.
    let arm = |half: f64, first: f64, wanted: usize| {
        let (mut phi, mut travelled, mut next) = (0.0, 0.0, first);
        let (mut last, mut found) = (place(flat(0.0, half)).0, Vec::with_capacity(wanted));
        while found.len() < wanted {
            // So short that chords are as long as the arc, but for what does not show.
            let by = STEP_MM / PIECES as f64 / (scale * (phi + OPENING));
            let place_there = place(flat(phi + by, half));
            let length = (place_there.0 - last).norm();
            if travelled + length >= next {
                found.push(place(flat(phi + by * (next - travelled) / length, half)));
                next += STEP_MM;
            }
            (phi, travelled, last) = (phi + by, travelled + length, place_there.0);
        }
        found
    };
    let (odd, each) = (count % 2 == 1, count / 2);
    let first = if odd { STEP_MM } else { STEP_MM / 2.0 };
    let mut path = arm(PI, first, each);
    path.reverse();
    if odd {
        path.push(place((0.0, 0.0)));
    }
    path.extend(arm(0.0, first, each));
    path.into_iter().unzip()
}
