//! The platform as a body.

use super::Args;
use super::plan::Planned;
use curvlay_kinematics::nalgebra::Point2;
use curvlay_kinematics::scene::Shape;
use curvlay_toolpath::drawing::Surface;
use std::f64::consts::TAU;

/// The platform: the mesh that it is, or the hull of a surface of revolution, which is convex.
pub fn platform(args: &Args, planned: &Planned) -> Shape {
    if let Some(mesh) = &planned.mesh {
        return Shape::Mesh { points: mesh.vertices.clone(), triangles: mesh.triangles.clone() };
    }
    let radius = 0.5 * args.platform_diameter_mm;
    let ring = |share: f64| {
        (0..48)
            .map(move |k| TAU * f64::from(k) / 48.0)
            .map(move |a| Point2::new(share * radius * a.cos(), share * radius * a.sin()))
    };
    let rings = (0..=16).flat_map(|k| ring(f64::from(k) / 16.0));
    let points = rings.filter_map(|at| planned.carrier.over(&at)).map(|at| at.position).collect();
    Shape::Hull { points, radius: 0.0 }
}
