//! Regions of overhang: which pieces of overhang in consecutive layers belong together, and the intersection points.
//!
//! Lettori et al. 2022, Fig. 1 and 2: where the outline of a layer crosses the offset of the layer below are the intersection
//! points. Departure: the paper has one region; here pieces of overhang in neighbouring layers are one region if they overlap, or come
//! as near to that as a layer carries, and the lowest region comes first.

use super::layers::Layered;
use super::options::VolumeOptions;
use crate::planar::Region;
use nalgebra::{Point2, Point3};

/// Overhang that belongs together.
#[derive(Clone, Debug)]
pub(super) struct OverhangRegion {
    /// Its lowest layer.
    pub first: usize,
    /// Its pieces: layer and overhang.
    pub pieces: Vec<(usize, Region)>,
    /// Where outlines cross the offsets of the layers below, in space, by layer.
    pub points: Vec<(usize, Point3<f64>)>,
}

/// The region with the lowest layer; `None` where nothing hangs over.
pub(super) fn first_region(layered: &Layered, options: &VolumeOptions) -> Option<OverhangRegion> {
    let pieces: Vec<(usize, Region)> = layered
        .layers
        .iter()
        .enumerate()
        .flat_map(|(layer, of)| of.overhang.pieces().into_iter().map(move |piece| (layer, piece)))
        .collect();
    let first = pieces.first()?.0;
    // Of the pieces in the lowest layer the largest one.
    let lowest = pieces.iter().enumerate().filter(|(_, (layer, _))| *layer == first);
    let (seed, _) = lowest.max_by(|a, b| a.1.1.area().total_cmp(&b.1.1.area()).then(b.0.cmp(&a.0)))?;
    let mut taken = vec![false; pieces.len()];
    taken[seed] = true;
    // Up and down from piece to piece.
    let mut reached = vec![seed];
    while let Some(from) = reached.pop() {
        // What leans out goes on beside the piece below, by as much as that would carry.
        let layer = &layered.layers[pieces[from].0];
        let near = pieces[from].1.grown((layer.high - layer.low) / options.angle.tan() + options.tolerance_mm);
        for k in 0..pieces.len() {
            let beside = !taken[k] && pieces[from].0.abs_diff(pieces[k].0) == 1;
            if beside && !near.intersection(&pieces[k].1).is_empty() {
                taken[k] = true;
                reached.push(k);
            }
        }
    }
    let mut keep = taken.into_iter();
    let pieces: Vec<(usize, Region)> = pieces.into_iter().filter(|_| keep.next().unwrap_or(false)).collect();
    let mut points = Vec::new();
    for (layer, piece) in &pieces {
        let of = &layered.layers[*layer];
        let crossings = crossings(piece, &of.carrier, options.tolerance_mm);
        points.extend(crossings.into_iter().map(|p| (*layer, layered.place(&p, of.middle()))));
    }
    Some(OverhangRegion { first, pieces, points })
}

/// Corners of a piece of overhang between an edge on the carrier's outline and one that is not.
fn crossings(piece: &Region, carrier: &Region, tolerance: f64) -> Vec<Point2<f64>> {
    let outline: Vec<[Point2<f64>; 2]> = carrier.edges().collect();
    // Rounding of booleans is far below, the width of the overhang that counts above.
    let within = 1e-3 * tolerance;
    let on_outline = |[a, b]: [Point2<f64>; 2]| {
        let middle = a + (b - a) / 2.0;
        outline.iter().any(|[c, d]| {
            let along = d - c;
            let share = ((middle - c).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            (middle - (c + along * share)).norm() <= within
        })
    };
    let mut points = Vec::new();
    for polygon in piece.polygons() {
        for contour in std::iter::once(&polygon.outer).chain(&polygon.holes) {
            let n = contour.len();
            let on: Vec<bool> = (0..n).map(|k| on_outline([contour[k], contour[(k + 1) % n]])).collect();
            points.extend((0..n).filter(|&k| on[(k + n - 1) % n] != on[k]).map(|k| contour[k]));
        }
    }
    points
}
