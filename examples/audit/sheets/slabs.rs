//! How thick layers are: by the way to what is below, and where surfaces are the middles of layers to what is above.

use super::super::args::LayerSide;
use super::patches::Patch;
use super::stack::Stack;
use rayon::prelude::*;

/// How thick layers are.
pub struct Heights {
    /// The height in the rules.
    pub height: f64,
    /// A twentieth of the area has less than the first, half less than the second, a twentieth more than the third.
    pub percentiles: [f64; 3],
}

/// How high the first layer is if its surface is a millimetre above the plate.
pub fn from_plate(side: LayerSide) -> f64 {
    match side {
        LayerSide::Middle => 2.0,
        LayerSide::Top => 1.0,
    }
}

/// How far a layer of some height goes below and above its surface.
pub fn nominal(side: LayerSide, height: f64) -> [f64; 2] {
    match side {
        LayerSide::Middle => [0.5 * height; 2],
        LayerSide::Top => [height, 0.0],
    }
}

/// Values below which shares of the weight lie; none without weight.
pub fn percentiles<const N: usize>(mut weighted: Vec<(f64, f64)>, shares: [f64; N]) -> Option<[f64; N]> {
    weighted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = weighted.iter().map(|(_, weight)| weight).sum();
    let last = weighted.last()?.0;
    Some(shares.map(|share| {
        let mut sum = 0.0;
        let reached = |(_, weight): &&(f64, f64)| {
            sum += weight;
            sum >= share * total
        };
        weighted.iter().find(reached).map_or(last, |(value, _)| *value)
    }))
}

/// Sets the thickness of all patches, and returns for each the way to what is below, infinite where there is nothing. What is farther than
/// `reach` heights is not the neighbour.
pub fn set(patches: &mut [Patch], stack: &Stack, side: LayerSide, height: f64, reach: f64) -> Vec<f64> {
    let near = reach * height;
    let work = |patch: &mut Patch| {
        let (at, rank) = (patch.middle(), patch.rank);
        let gap = stack.below(at, patch.normal, rank, from_plate(side)).unwrap_or(f64::INFINITY);
        let is_near = |gap: &f64| *gap <= near;
        let own = Some(gap).filter(is_near).unwrap_or(height);
        patch.slab = match side {
            LayerSide::Top => [own, 0.0],
            LayerSide::Middle => {
                let next = stack.along(at, patch.normal, rank + 1..u32::MAX, near);
                [0.5 * own, 0.5 * next.unwrap_or(height)]
            }
        };
        gap
    };
    patches.par_iter_mut().map(work).collect()
}

/// Figures of the heights, where layers lie on something.
pub fn heights(patches: &[Patch], gaps: &[f64], height: f64, reach: f64) -> Heights {
    let near = patches.iter().zip(gaps).filter(|(_, gap)| **gap <= reach * height);
    let percentiles = percentiles(near.map(|(patch, gap)| (*gap, patch.area)).collect(), [0.05, 0.5, 0.95]);
    Heights { height, percentiles: percentiles.unwrap_or([height; 3]) }
}
