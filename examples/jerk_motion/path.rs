//! The tool path: a spiral over a free-form patch made in code, or waypoints from a file; and noise.

use curvlay_examples::args::Failure;
use curvlay_examples::mesh::Up;
use curvlay_examples::waypoints::read_waypoints;
use curvlay_kinematics::nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use std::f64::consts::{PI, TAU};
use std::path::Path;

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

/// In on one arm of a spiral, round an S and out on the other, in equal steps along the surface.
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

/// Turns every direction by an angle up to `most` about a random axis across it: uniform on the cap of the sphere.
pub fn noisy(path: &Path6, most: f64, seed: u64) -> Path6 {
    let mut state = seed;
    // S. Vigna's splitmix64.
    let mut random = move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    let turned = |normal: &Vector3<f64>| {
        let angle = (1.0 - random() * (1.0 - most.cos())).acos();
        let about = TAU * random();
        let side = if normal.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
        let u = normal.cross(&side).normalize();
        let axis = u * about.cos() + normal.cross(&u).normalize() * about.sin();
        UnitQuaternion::from_axis_angle(&Unit::new_normalize(axis), angle) * normal
    };
    (path.0.clone(), path.1.iter().map(turned).collect())
}

/// Brings another axis up.
pub fn upright((positions, normals): &Path6, up: Up) -> Path6 {
    let turned = |v: &Vector3<f64>| match up {
        Up::X => Vector3::new(-v.z, v.y, v.x),
        Up::Y => Vector3::new(v.x, -v.z, v.y),
        Up::Z => *v,
    };
    let positions = positions.iter().map(|p| Point3::from(turned(&p.coords))).collect();
    (positions, normals.iter().map(turned).collect())
}

/// Waypoints of a file. What is not finite is a defect that the planner names.
pub fn read(path: &Path) -> Result<Path6, Failure> {
    let place = |[x, y, z, nx, ny, nz]: [f64; 6]| (Point3::new(x, y, z), Vector3::new(nx, ny, nz));
    Ok(read_waypoints(path)?.iter().map(|line| place(line.values)).unzip())
}
