//! The nozzle of the tests, and its profile: a polygon in the plane of the axis, `z` along the axis from the tip, `rho` beside it.

use curvlay_toolpath::gouging::{Nozzle, NozzleShape};

/// The nozzle that the figures of these tests were found with: its tip flat is 1 mm wide, whatever the default is.
pub fn tip_1_mm() -> Nozzle {
    Nozzle::new(NozzleShape { tip_flat_mm: 1.0, ..NozzleShape::default() }).unwrap()
}

/// True distance to the profile.
pub fn to_profile(z: f64, rho: f64) -> f64 {
    let profile = [[0.0, 0.0], [0.0, 0.5], [8.0, 8.5], [8.0, 10.0], [1e4, 10.0]];
    let to_side = |a: [f64; 2], b: [f64; 2]| {
        let (dz, dr) = (b[0] - a[0], b[1] - a[1]);
        let t = (((z - a[0]) * dz + (rho - a[1]) * dr) / (dz * dz + dr * dr)).clamp(0.0, 1.0);
        (z - a[0] - t * dz).hypot(rho - a[1] - t * dr)
    };
    profile.windows(2).map(|side| to_side(side[0], side[1])).fold(f64::INFINITY, f64::min)
}

pub fn inside(z: f64, rho: f64) -> bool {
    (z > 0.0 && z <= 8.0 && rho < 0.5 + z) || (z >= 8.0 && rho < 10.0)
}
