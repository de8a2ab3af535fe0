//! A part to be checked.

use crate::planar::Solid;
use nalgebra::Vector3;

/// A part to be checked: its mesh, the direction in which it is printed, and whether it stands on the platform.
#[derive(Clone, Copy, Debug)]
pub struct AuditedPart<'a> {
    /// Its closed mesh.
    pub solid: &'a Solid,
    /// The direction in which it is printed.
    pub direction: Vector3<f64>,
    /// Whether its lowest layer lies on the platform.
    pub on_platform: bool,
}
