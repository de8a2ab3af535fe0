//! The first direction: as it stands, as asked for, or the one with the least overhang.

use super::layers::{Stand, analyse};
use super::options::{BaseChoice, VolumeError, VolumeOptions};
use crate::planar::Solid;
use nalgebra::Vector3;

/// How many flat sides are tried as bases, beside the axes.
const SIDES: usize = 12;
/// Sides whose normals differ by less than this (a degree) are one.
const ALIKE: f64 = 0.0175;
/// Layers in which the overhang of a direction is compared; a part that is sliced in fewer is compared as it is.
const LAYERS: f64 = 60.0;

/// The direction of the first part, of length 1.
pub(super) fn direction(solid: &Solid, options: &VolumeOptions) -> Result<Vector3<f64>, VolumeError> {
    match options.base {
        BaseChoice::Up => Ok(Vector3::z()),
        BaseChoice::Along(direction) => Ok(direction.normalize()),
        BaseChoice::LeastOverhang => Ok(least_overhang(solid, options)),
    }
}

fn least_overhang(solid: &Solid, options: &VolumeOptions) -> Vector3<f64> {
    let mut candidates: Vec<Vector3<f64>> = Vec::new();
    let mut sides: Vec<(Vector3<f64>, f64)> = Vec::new();
    for triangle in 0..solid.triangles().len() {
        let [a, b, c] = solid.corners(triangle);
        let doubled = (b - a).cross(&(c - a));
        let Some(normal) = doubled.try_normalize(0.0) else { continue };
        match sides.iter_mut().find(|(known, _)| (known - normal).norm() < ALIKE) {
            Some((_, area)) => *area += doubled.norm() / 2.0,
            None => sides.push((normal, doubled.norm() / 2.0)),
        }
    }
    // A stable sort: of equal sides the first one.
    sides.sort_by(|a, b| b.1.total_cmp(&a.1));
    candidates.extend([Vector3::z(), Vector3::y(), Vector3::x()].into_iter().flat_map(|axis| [axis, -axis]));
    candidates.extend(sides.iter().take(SIDES).map(|(normal, _)| -normal));
    let mut best: Option<(f64, f64, Vector3<f64>)> = None;
    for direction in candidates {
        let [low, high] = solid.extent(&direction);
        let layer_mm = options.layer_mm.max((high - low) / LAYERS);
        let coarse = VolumeOptions { layer_mm, min_layer_mm: layer_mm, min_feature_mm: 0.0, ..*options };
        let stand = Stand { direction, base: low, on_plate: true };
        let layered = analyse(solid, &stand, &[], &coarse);
        let base = layered.layers.first().map_or(0.0, |layer| layer.section.area());
        let found = (layered.overhang_mm3(), base, direction);
        // A thousandth of the overhang is no difference; then the larger base decides, then the earlier candidate.
        let better = best.is_none_or(|(overhang, area, _)| {
            found.0 < overhang * 0.999 || (found.0 <= overhang * 1.001 && base > area * 1.001)
        });
        if better {
            best = Some(found);
        }
    }
    best.map_or_else(Vector3::z, |(_, _, direction)| direction)
}
