//! A cut of a part: what is above the plane becomes parts of their own, where that pays.
//!
//! A cut is tried on the part alone: what it does there it does in the whole as well, and no other part becomes more or less risky by it.

use super::options::TuningOptions;
use super::risk::{RiskModel, area_vector};
use crate::planar::solid::Wall;
use crate::planar::{CutPlane, Partition};
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// What a cut makes of a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Division {
    pub(super) below: u32,
    /// At least one.
    pub(super) above: Vec<u32>,
}

/// A part that a cut would make.
pub(super) struct TriedPart {
    pub(super) direction: Vector3<f64>,
    pub(super) walls: Vec<Wall>,
    pub(super) risky: f64,
    pub(super) seam: f64,
}

/// A cut that was tried: the part below the plane, then those above it.
pub(super) struct Trial {
    /// Cells are those of the part that was cut.
    pub(super) partition: Partition,
    pub(super) division: Division,
    pub(super) parts: Vec<TriedPart>,
}

impl Trial {
    /// Cuts the only cell of a partition.
    ///
    /// `None` if nothing is cut off, or something would float.
    pub(super) fn new(
        mut partition: Partition,
        cell: u32,
        plane: &CutPlane,
        judge: &RiskModel,
        min_mm3: f64,
        options: &TuningOptions,
    ) -> Option<Self> {
        let division = divide(&mut partition, cell, plane, judge, min_mm3, options)?;
        let mut judge = judge.clone();
        let mut parts = Vec::with_capacity(1 + division.above.len());
        for &cell in std::iter::once(&division.below).chain(&division.above) {
            let walls = partition.walls(cell);
            let (risky, seam) = (judge.risky(&walls), judge.seam(&walls));
            parts.push(TriedPart { direction: judge.direction, walls, risky, seam });
            judge.earlier.push(cell);
            (judge.direction, judge.floor) = (plane.normal(), f64::NEG_INFINITY);
        }
        Some(Trial { partition, division, parts })
    }

    pub(super) fn risky(&self) -> f64 {
        self.parts.iter().map(|part| part.risky).sum()
    }

    pub(super) fn seam(&self) -> f64 {
        self.parts.iter().map(|part| part.seam).sum()
    }

    /// Whether all parts bound solids. Pieces that were given to what they touch may touch it along an edge twice.
    pub(super) fn is_sound(&self) -> bool {
        let mut cells = std::iter::once(&self.division.below).chain(&self.division.above);
        cells.all(|&cell| self.partition.part(cell).is_ok())
    }
}

/// Cuts a cell by a plane. What is above and pays becomes cells of their own; all else stays with what it stands on.
///
/// `None` if nothing is cut off, or nothing would stand; then the partition is of no use any more.
pub(super) fn divide(
    partition: &mut Partition,
    cell: u32,
    plane: &CutPlane,
    judge: &RiskModel,
    min_mm3: f64,
    options: &TuningOptions,
) -> Option<Division> {
    let upward = RiskModel { direction: plane.normal(), floor: f64::NEG_INFINITY, ..judge.clone() };
    let cut = partition.cut(&[cell], plane);
    let below: Vec<(u32, Vec<Wall>)> = cut.below.iter().map(|&piece| (piece, partition.walls(piece))).collect();
    let stands = |walls: &[Wall]| walls.iter().any(|wall| judge.is_supported(wall));
    let (standing, floating): (Vec<_>, Vec<_>) = below.iter().partition(|(_, walls)| stands(walls));
    let (foot, others) = standing.split_first().map(|((foot, _), others)| (*foot, others))?;
    let mut touched: BTreeSet<u32> = below.iter().flat_map(|(_, walls)| walls).filter_map(|wall| wall.beyond).collect();
    touched.retain(|cell| !cut.above.contains(cell));
    let pays = |piece: u32| {
        let mut walls = partition.walls(piece);
        // A section that the plane cuts has something of it on both sides.
        let barring = |b: &u32| options.keep_sections_apart || judge.earlier.contains(b);
        let beyond: BTreeSet<u32> = walls.iter().filter_map(|wall| wall.beyond).collect();
        let spares = beyond.iter().filter(|b| barring(b)).all(|b| cut.below.contains(b) || !touched.contains(b));
        if !spares || partition.volume(piece) < min_mm3 {
            return false;
        }
        let on_section = |wall: &Wall| wall.beyond.is_some_and(|beyond| cut.below.contains(&beyond));
        let section = walls.iter().filter(|wall| on_section(wall)).map(|wall| area_vector(&wall.places).norm());
        let (section, all) = (section.sum::<f64>(), walls.len());
        walls.retain(|wall| !on_section(wall));
        walls.len() < all && judge.risky(&walls) > upward.risky(&walls) + options.seam_cost * section
    };
    let (above, kept): (Vec<u32>, Vec<u32>) = cut.above.iter().partition(|&&piece| pays(piece));
    if above.is_empty() {
        return None;
    }
    // What floats below hangs on something above: it is printed with that, if it is printed on its own.
    for (piece, _) in floating {
        let carrier = above.iter().find(|&&upper| partition.shared_area(upper, *piece) > 0.0);
        partition.merge(carrier.copied().unwrap_or(foot), *piece);
    }
    others.iter().map(|(piece, _)| piece).chain(&kept).for_each(|&piece| partition.merge(foot, piece));
    (partition.volume(foot) >= min_mm3).then_some(Division { below: foot, above })
}
