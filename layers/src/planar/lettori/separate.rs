//! Taking a part off at a wall: what hangs over goes, what stands on the base stays, whatever the wall cuts beside them.

use super::layers::Layered;
use super::regions::OverhangRegion;
use super::wall::SeparationWall;
use crate::planar::{CutPlane, Partition, Region, slice};
use nalgebra::{Point3, Vector3};

/// A cell that was cut: what stays, and what was taken off.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Separated {
    pub rest: u32,
    pub taken: Vec<u32>,
}

/// Takes off what is beyond a wall and hangs over. The pieces beyond the wall without overhang of the region stay, and so do the
/// pieces on this side that hold together with the base; others would float and go with the part that they touch.
///
/// # Returns
/// `None`, and an unchanged partition, if nothing would be taken off or nothing would stay.
pub(super) fn separate(
    partition: &mut Partition,
    cell: u32,
    wall: &SeparationWall,
    layered: &Layered,
    region: &OverhangRegion,
    base: f64,
) -> Option<Separated> {
    let mut trial = partition.clone();
    let upright = trial.cut(&[cell], &wall.upright);
    let tilted = trial.cut(&upright.above, &wall.tilted);
    let (beyond, mut near) = (tilted.above, [upright.below, tilted.below].concat());
    let mut taken = Vec::new();
    for piece in beyond {
        if hangs_over(&trial, piece, layered, region) { taken.push(piece) } else { near.push(piece) }
    }
    if taken.is_empty() {
        return None;
    }
    // What stands on the base, and what holds on to it.
    let within = 1e-6 * (1.0 + base.abs()) + 1e-6 * (layered.layers[0].high - layered.layers[0].low);
    let lowest = |piece: u32| trial.part(piece).map_or(f64::INFINITY, |part| part.extent(&layered.direction)[0]);
    let mut stays: Vec<u32> = near.iter().copied().filter(|&piece| lowest(piece) <= base + within).collect();
    near.retain(|piece| !stays.contains(piece));
    let mut at = 0;
    while at < stays.len() {
        let from = stays[at];
        at += 1;
        let (held, others) = near.into_iter().partition(|&piece| trial.shared_area(piece, from) > 0.0);
        near = others;
        let held: Vec<u32> = held;
        stays.extend(held);
    }
    let (&rest, others) = stays.split_first()?;
    for &piece in others {
        trial.merge(rest, piece);
    }
    // What floats goes with what it touches most.
    while let Some(&piece) =
        near.iter().find(|&&piece| taken.iter().any(|&other| trial.shared_area(piece, other) > 0.0))
    {
        near.retain(|&other| other != piece);
        let most = |&&a: &&u32, &&b: &&u32| trial.shared_area(piece, a).total_cmp(&trial.shared_area(piece, b));
        let holder = taken.iter().max_by(most).copied().unwrap_or(rest);
        trial.merge(holder, piece);
    }
    for piece in near {
        trial.merge(rest, piece);
    }
    *partition = trial;
    Some(Separated { rest, taken })
}

/// Whether a piece has overhang of the region in it, in one of its layers.
fn hangs_over(partition: &Partition, piece: u32, layered: &Layered, region: &OverhangRegion) -> bool {
    let Ok(part) = partition.part(piece) else { return false };
    let d: Vector3<f64> = layered.direction;
    region.pieces.iter().any(|(layer, overhang)| {
        let height = layered.layers[*layer].middle();
        let plane = CutPlane::through(&Point3::from(d * height), &d);
        plane.is_ok_and(|plane| {
            let section = Region::of(&slice(&part, &plane, &layered.frame));
            section.intersection(overhang).area() > 1e-6 * overhang.area()
        })
    })
}
