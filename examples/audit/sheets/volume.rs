//! Layers in the cubes in which volumes are compared.

use super::super::part::Volume;
use super::patches::Patch;
use super::stack::closest;
use nalgebra::{Point3, Vector3};

/// Covers what layers fill: patches as thick as they are, larger by `slack` to all sides.
pub fn cover(volume: &mut Volume, patches: &[Patch], slack: f64) {
    let slack = slack + ROUNDING_MM;
    for patch in patches.iter().filter(|patch| !patch.is_support) {
        let [a, b, c] = patch.corners;
        let reach = Vector3::repeat(patch.slab[0].max(patch.slab[1]) + slack);
        let bounds = [a.inf(&b).inf(&c) - reach, a.sup(&b).sup(&c) + reach];
        volume.cover_where(bounds, |at| has(patch, slack, at));
    }
}

/// Places on the edge between two patches are in one of them.
const ROUNDING_MM: f64 = 1e-9;

fn has(patch: &Patch, slack: f64, at: &Point3<f64>) -> bool {
    // Along the normal of the nozzle to the plane of the patch.
    let [a, b, c] = patch.corners;
    let across = (b - a).cross(&(c - a));
    let up = (at - a).dot(&across) / patch.normal.dot(&across);
    if !(-patch.slab[0] - slack..=patch.slab[1] + slack).contains(&up) {
        return false;
    }
    let foot = at - patch.normal * up;
    (foot - closest(&patch.corners, &foot)).norm() <= slack
}

/// Whether a patch is outside of the part.
pub fn is_outside(volume: &Volume, patch: &Patch, step: f64) -> bool {
    let (core, half) = (patch.core(), Vector3::repeat(0.5 * patch.thickness() + step));
    !patch.is_support && !volume.has_part([core - half, core + half])
}
