//! Beads as bodies.

use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use nalgebra::Point3;

/// Length of a path.
pub fn length(path: &ToolPath) -> f64 {
    path.waypoints.last().map_or(0.0, |last| last.arc)
}

/// The middle of a bead.
pub fn middle(at: &Waypoint) -> Point3<f64> {
    at.position - at.axis.into_inner() * (0.5 * at.height)
}

/// Of a bead with round rims.
pub fn section_mm2(width: f64, height: f64) -> f64 {
    let rim = width.min(height);
    width * height - rim * rim * (1.0 - std::f64::consts::FRAC_PI_4)
}
