//! Bodies for the links of named arms, that contain the makers' bodies.
//!
//! Each link is a few prisms whose figures were measured from the makers' published meshes, or an estimate from the nearest
//! sibling where there is none; [`link_source`] says which. What runs along the links (cables, hoses, clips) is not part of
//! them: see [`SceneModel::link_allowance`](super::SceneModel::link_allowance). An arm of other lengths has no bodies here:
//! neither its maker's nor a guess.

mod irb120;
mod irb1200;
mod prism;
mod tubes;
mod ur10;
mod ur3;
mod ur3e;
mod ur5;
mod ur5e;

pub use tubes::estimated_links;

use super::body::{Body, Mount, Shape};
use crate::arm::{ArmModel, Geometry, robots};
use nalgebra::Isometry3;
use prism::Prism;

/// What the bodies of an arm come from, and how far they can be trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkSource {
    /// The arm, by its name in [`robots::CATALOGUE`].
    pub arm: &'static str,
    /// Where the figures come from.
    pub source: &'static str,
    /// Whether they were not measured from a mesh of this arm, but estimated from another one.
    pub is_estimate: bool,
    /// How far the real body may stick out of ours where it is measured, in millimetres: meshes and frames are rounded, and
    /// the lengths of a calibrated arm differ from the published ones. A margin must be above it.
    pub error_mm: f64,
}

/// Names of the links, base to flange.
pub const LINK_NAMES: [&str; 7] = ["base", "shoulder", "upper arm", "forearm", "wrist 1", "wrist 2", "flange"];

/// How far a maker's body may stick out of its measured shape: lengths of calibrated arms differ from the published ones by up
/// to a millimetre, and frames of the meshes are rounded to a few tenths.
const ERROR_MM: f64 = 1.0;

const ROS_UR: &str = "Universal Robots, ROS description ur_description, collision meshes";
const MENAGERIE: &str =
    "Universal Robots, ROS description by way of MuJoCo Menagerie universal_robots_ur5e, visual meshes";
const LIKE_UR3: &str =
    "estimate: the bodies of the UR3, 1.5 to 5 mm thicker, stretched by the differences of the lengths";
const LIKE_IRB140: &str = "estimate: data sheet, and the collision meshes of the IRB 140 (ROS-Industrial abb_irb140_support) with an \
                           allowance of 10 to 25 mm";

/// The pieces of each link of an arm.
type Links = [&'static [Prism]; 7];

/// All arms whose bodies are known.
const KNOWN: [(LinkSource, &ArmModel, &Links); 7] = [
    (measured("UR3", ROS_UR), &robots::UR3, &ur3::UR3),
    (estimated("UR3e", LIKE_UR3), &robots::UR3E, &ur3e::UR3E),
    (measured("UR5", ROS_UR), &robots::UR5, &ur5::UR5),
    (measured("UR5e", MENAGERIE), &robots::UR5E, &ur5e::UR5E),
    (measured("UR10", ROS_UR), &robots::UR10, &ur10::UR10),
    (estimated("IRB120", LIKE_IRB140), &robots::IRB120, &irb120::IRB120),
    (estimated("IRB1200", LIKE_IRB140), &robots::IRB1200, &irb1200::IRB1200),
];

const fn measured(arm: &'static str, source: &'static str) -> LinkSource {
    LinkSource { arm, source, is_estimate: false, error_mm: ERROR_MM }
}

const fn estimated(arm: &'static str, source: &'static str) -> LinkSource {
    LinkSource { arm, source, is_estimate: true, error_mm: ERROR_MM }
}

/// The arm of these lengths, whatever its limits.
fn known(geometry: &Geometry) -> Option<&'static (LinkSource, &'static ArmModel, &'static Links)> {
    KNOWN.iter().find(|(_, model, _)| model.geometry == *geometry)
}

/// Where the bodies of an arm come from; `None` for one whose bodies are not known. The arm is found by its lengths.
/// ```
/// use curvlay_kinematics::{ArmModel, DhTable, robots, scene};
/// use curvlay_kinematics::Geometry;
/// let source = scene::link_source(&robots::UR10).ok_or("no bodies")?;
/// assert_eq!((source.arm, source.is_estimate), ("UR10", false));
/// let other = Geometry::Ur(DhTable::ur([150.0, 0.0, 0.0, 110.0, 90.0, 80.0], -400.0, -300.0));
/// assert_eq!(scene::link_source(&ArmModel { geometry: other, ..robots::UR10 }), None);
/// # Ok::<(), &str>(())
/// ```
pub fn link_source(model: &ArmModel) -> Option<LinkSource> {
    known(&model.geometry).map(|(source, ..)| *source)
}

/// Seven bodies, base to flange, in the frames of the arm: unions of prisms, with the names [`LINK_NAMES`]. None for an arm whose
/// bodies are not known, see [`link_source`].
/// ```
/// use curvlay_kinematics::{robots, scene};
/// let links = scene::links(&robots::UR5);
/// assert_eq!((links.len(), links[6].name.as_str(), links[6].mount), (7, "flange", scene::Mount::Link(6)));
/// ```
pub fn links(model: &ArmModel) -> Vec<Body> {
    let Some((.., pieces)) = known(&model.geometry) else { return vec![] };
    let body = |(link, pieces): (usize, &&[Prism])| link_body(link, pieces.iter().map(Prism::shape).collect());
    pieces.iter().enumerate().map(body).collect()
}

/// The body of a link, 0 for the base, from its pieces.
pub(crate) fn link_body(link: usize, pieces: Vec<Shape>) -> Body {
    let mount = if link == 0 { Mount::Base } else { Mount::Link(link) };
    Body { name: LINK_NAMES[link].into(), mount, mount_body: Isometry3::identity(), shape: Shape::Union(pieces) }
}
