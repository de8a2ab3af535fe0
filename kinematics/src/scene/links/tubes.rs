//! An estimate of the links of any arm from its lengths: tubes.
//!
//! For studies of planners and indicators, which need bodies of few numbers. The links of real arms are thicker: those of a UR3 by 20
//! to 33 mm, of a UR10 by 32 to 53, of an IRB 1200 by 30 to 140. So nothing that is shown for these tubes holds for a robot.

use crate::arm::{ArmModel, DhTable, Geometry, OrthoLengths};
use crate::scene::body::{Body, Mount, Shape};
use nalgebra::Isometry3;

fn body(name: &str, link: usize, shape: Shape) -> Body {
    let mount = if link == 0 { Mount::Base } else { Mount::Link(link) };
    Body { name: name.into(), mount, mount_body: Isometry3::identity(), shape }
}

fn tube(from: [f64; 3], to: [f64; 3], radius: f64) -> Shape {
    Shape::Capsule { from: from.into(), to: to.into(), radius }
}

/// Seven bodies, base to flange, for an arm of any lengths: an estimate, thinner than any real arm. For robots use
/// [`links`](super::links()).
///
/// Capsules, and convex hulls where an end is flat; names are [`LINK_NAMES`](super::LINK_NAMES).
/// ```
/// use curvlay_kinematics::{robots, scene};
/// let links = scene::estimated_links(&robots::UR5);
/// assert_eq!((links.len(), links[6].name.as_str(), links[6].mount), (7, "flange", scene::Mount::Link(6)));
/// ```
pub fn estimated_links(model: &ArmModel) -> Vec<Body> {
    match &model.geometry {
        Geometry::Ur(table) => ur(table),
        Geometry::Ortho(lengths) => ortho(lengths),
    }
}

/// Of a UR arm all girths follow `d5`, the distance of the planes in which forearm and wrist 2 move: so the two, at
/// 0.5 and 0.38 of it, never touch.
fn ur(table: &DhTable) -> Vec<Body> {
    let (d, a) = (&table.d, &table.a);
    let unit = d[4].abs();
    let (arm, fore, wrist) = (0.55 * unit, 0.45 * unit, 0.38 * unit);
    // The upper arm runs beside the shoulder, the forearm back in the plane that wrist 1 starts from.
    let side = d[3].signum();
    let (beside, back) = (side * 1.4 * unit, d[3] - side * unit);
    let foot = 0.5 * d[0];
    vec![
        body("base", 0, Shape::cylinder(0.75 * unit, 0.0, foot)),
        body("shoulder", 1, tube([0.0; 3], [0.0, 0.0, beside], arm)),
        body("upper arm", 2, tube([-a[1], 0.0, beside], [0.0, 0.0, beside], arm)),
        body("forearm", 3, tube([-a[2], 0.0, back], [0.0, 0.0, back], fore)),
        body("wrist 1", 4, tube([0.0, back - d[3], 0.0], [0.0; 3], wrist)),
        body("wrist 2", 5, tube([0.0, d[4], 0.0], [0.0; 3], wrist)),
        body("flange", 6, flange(wrist, 0.6 * d[5])),
    ]
}

/// Of an ortho-parallel arm girths follow the upper arm's length and the hand's.
fn ortho(lengths: &OrthoLengths) -> Vec<Body> {
    let OrthoLengths { a1, a2, b, c1, c2, c3, c4 } = *lengths;
    let (arm, fore) = (0.2 * c2.abs(), 0.15 * c2.abs());
    let wrist = (0.35 * c4.abs()).min(fore);
    vec![
        body("base", 0, Shape::cylinder(0.3 * c2.abs(), 0.0, 0.45 * c1)),
        body("shoulder", 1, tube([0.0; 3], [a1, b, 0.0], 1.2 * arm)),
        body("upper arm", 2, tube([0.0; 3], [0.0, 0.0, c2], arm)),
        body("forearm", 3, tube([0.0; 3], [a2, 0.0, 0.3 * c3], arm.min(0.6 * (a2.abs() + c3.abs())))),
        body("wrist 1", 4, tube([0.0, 0.0, -0.7 * c3], [0.0; 3], wrist)),
        body("wrist 2", 5, tube([0.0; 3], [0.0, 0.0, 0.3 * c4], wrist)),
        body("flange", 6, flange(0.7 * wrist, 0.25 * c4)),
    ]
}

/// The disc that the tool is screwed to: its thickness counts from the flange back into the hand.
fn flange(radius: f64, thick: f64) -> Shape {
    Shape::cylinder(radius, (-thick).min(0.0), (-thick).max(0.0))
}
