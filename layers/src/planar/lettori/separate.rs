//! Taking a part off at a wall: what hangs over goes, what stands on the base stays, whatever the wall cuts beside them.
//!
//! What is left on this side of the wall but holds on to nothing that stands would be behind the base plane of what is taken off, in none
//! of its layers. It is a part of its own: it stands on the other side of the same wall, is stacked the other way, and is printed later.

use super::layers::{Layered, Stand};
use super::regions::OverhangRegion;
use super::wall::SeparationWall;
use crate::planar::{CutPlane, Partition, Region, slice};
use nalgebra::{Point3, Vector3};

/// A cell that was cut: what stays, and what was taken off.
#[derive(Clone, Debug)]
pub(super) struct Separated {
    pub rest: u32,
    /// What was taken off, and where it stands, in the inverse order of printing.
    pub taken: Vec<(u32, Stand)>,
    /// How far back along the wall's normal the pieces reach that lost their hold; none if there are none.
    pub floats_from: Option<f64>,
}

/// Takes off what is beyond a wall and hangs over. The pieces beyond the wall without overhang of the region stay, and so do the
/// pieces on this side that hold together with the base. Others stand on what is taken off.
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
    let (mut behind, mut below) = (upright.below, tilted.below);
    let mut taken = Vec::new();
    let mut beside = Vec::new();
    for piece in tilted.above {
        if hangs_over(&trial, piece, layered, region) { taken.push(piece) } else { beside.push(piece) }
    }
    if taken.is_empty() {
        return None;
    }
    // What stands on the base, and what holds on to it.
    let within = 1e-6 * (1.0 + base.abs()) + 1e-6 * (layered.layers[0].high - layered.layers[0].low);
    let lowest = |piece: u32| trial.part(piece).map_or(f64::INFINITY, |part| part.extent(&layered.direction)[0]);
    let near: Vec<u32> = [&behind[..], &below, &beside].concat();
    let standing: Vec<u32> = near.iter().copied().filter(|&piece| lowest(piece) <= base + within).collect();
    let stays = held_by(&trial, standing, &near);
    for pieces in [&mut behind, &mut below, &mut beside] {
        pieces.retain(|piece| !stays.contains(piece));
    }
    let (&rest, others) = stays.split_first()?;
    for &piece in others {
        trial.merge(rest, piece);
    }
    // What floats in front of the wall goes with what it touches most.
    let mut in_front = [below, beside].concat();
    while let Some(at) = in_front.iter().position(|&piece| taken.iter().any(|&one| trial.shared_area(piece, one) > 0.0))
    {
        let piece = in_front.remove(at);
        let most = |&&a: &&u32, &&b: &&u32| trial.shared_area(piece, a).total_cmp(&trial.shared_area(piece, b));
        let holder = taken.iter().max_by(most).copied().unwrap_or(rest);
        trial.merge(holder, piece);
    }
    let floats_from = behind
        .iter()
        .filter_map(|&piece| trial.part(piece).ok())
        .map(|part| part.extent(&wall.upright.normal())[0])
        .min_by(f64::total_cmp);
    // From one side of the wall to the other, as far as pieces hold on to each other.
    let stand = |side: f64| Stand {
        direction: wall.upright.normal() * side,
        base: wall.upright.offset() * side,
        on_plate: false,
    };
    let mut printed: Vec<(u32, Stand)> = taken.iter().map(|&piece| (piece, stand(1.0))).collect();
    let mut holders = taken;
    let mut side = -1.0;
    let (mut next, mut after) = (behind, in_front);
    while !next.is_empty() {
        let held: Vec<u32> = next
            .iter()
            .copied()
            .filter(|&piece| holders.iter().any(|&one| trial.shared_area(piece, one) > 0.0))
            .collect();
        next.retain(|piece| !held.contains(piece));
        if held.is_empty() {
            break;
        }
        printed.extend(held.iter().map(|&piece| (piece, stand(side))));
        holders = held;
        side = -side;
        std::mem::swap(&mut next, &mut after);
    }
    // What touches nothing at all was loose before the cut.
    for piece in next.into_iter().chain(after) {
        trial.merge(rest, piece);
    }
    printed.reverse();
    *partition = trial;
    Some(Separated { rest, taken: printed, floats_from })
}

/// `first`, and those of `others` that hold on to them, one by one.
fn held_by(partition: &Partition, first: Vec<u32>, others: &[u32]) -> Vec<u32> {
    let mut all = first;
    let mut open: Vec<u32> = others.iter().copied().filter(|piece| !all.contains(piece)).collect();
    let mut at = 0;
    while at < all.len() {
        let from = all[at];
        at += 1;
        let (held, left): (Vec<u32>, Vec<u32>) =
            open.into_iter().partition(|&piece| partition.shared_area(piece, from) > 0.0);
        open = left;
        all.extend(held);
    }
    all
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
