//! The tool path: a spiral over a free-form patch made in code, or waypoints from a file; and noise.

use curvlay_examples::args::Failure;
use curvlay_examples::mesh::Up;
pub use curvlay_examples::spiral::{Path6, spiral};
use curvlay_examples::waypoints::read_waypoints;
use curvlay_kinematics::nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::path::Path;

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
    let turned = |v: &Vector3<f64>| Vector3::from(up.turned([v.x, v.y, v.z]));
    let positions = positions.iter().map(|p| Point3::from(turned(&p.coords))).collect();
    (positions, normals.iter().map(turned).collect())
}

/// Waypoints of a file. What is not finite is a defect that the planner names.
pub fn read(path: &Path) -> Result<Path6, Failure> {
    let place = |[x, y, z, nx, ny, nz]: [f64; 6]| (Point3::new(x, y, z), Vector3::new(nx, ny, nz));
    Ok(read_waypoints(path)?.iter().map(|line| place(line.values)).unzip())
}
