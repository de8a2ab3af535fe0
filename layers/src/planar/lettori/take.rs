//! Taking a region of overhang off: walls are tried in the paper's order, and the first one beside which the torch is free is taken.

use super::layers::{Layered, Stand};
use super::options::VolumeOptions;
use super::regions::OverhangRegion;
use super::result::{Scenario, Separation};
use super::separate::separate;
use super::torch::{Plate, blocked_mm3};
use super::wall::{SeparationWall, Walls, interpolant, leans, leaves_enough, walls_around, walls_before};
use crate::planar::{Partition, Region, Solid};
use nalgebra::Point3;

/// How much of a part's volume must go and must stay in a separation: less is rounding.
const SHARE: f64 = 1e-9;

/// A separation whose parts are blocked by less than this share of what is taken off is as good as any: the corners of a layer, where
/// the middle of the torch does not come.
const FREE: f64 = 0.001;

/// Walls other than the first ones must save this share of the part, and as much again for each further part that they make.
const SAVED: f64 = 0.05;

/// How often a wall is moved back behind pieces that lose their hold: each time others may.
const MOVES: usize = 3;

/// How walls are chosen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strategy {
    /// Whether the torch is held against what stands; else the first walls that divide the part are taken.
    pub judges_torch: bool,
    /// Whether one wall is tried where overhang has no intersection points but lies on one side; else four walls are, as in the paper.
    pub one_sided: bool,
    /// Whether walls that lean back are tried as well.
    pub leans: bool,
    /// The most parts that one separation may take off.
    pub most: usize,
}

/// Cells with what they stand on, in the inverse order of printing.
pub(super) type Taken = Vec<(u32, Stand)>;

/// A part with overhang.
pub(super) struct Work<'a> {
    pub cell: u32,
    pub stand: Stand,
    pub own: &'a Solid,
    pub layered: &'a Layered,
    pub region: &'a OverhangRegion,
}

/// A separation that was tried.
struct Trial {
    partition: Partition,
    rest: u32,
    taken: Taken,
    taken_mm3: f64,
    walls: Walls,
    /// How far back pieces reach that lost their hold, where a single wall has them.
    floats_from: Option<f64>,
}

impl Work<'_> {
    /// Takes the region off: by one wall, or by four if no single wall will do. Where the torch would be blocked, the walls are taken beside
    /// which it is blocked least, if the strategy asks for that.
    ///
    /// # Returns
    /// The step, the cell that stays, and the cells that were taken off; `None` and an unchanged partition if no wall will do.
    pub fn take_off(
        &self,
        partition: &mut Partition,
        earlier: &[&Solid],
        plate: &Plate,
        strategy: Strategy,
        options: &VolumeOptions,
    ) -> Option<(Separation, u32, Taken)> {
        let mut best: Option<(f64, Trial)> = None;
        let mut first = true;
        for lean in leans(options).into_iter().take(if strategy.leans { usize::MAX } else { 1 }) {
            for walls in self.choices(lean, strategy, options) {
                let trials = self.trials(partition, walls, options);
                for trial in trials.into_iter().filter(|trial| trial.taken.len() <= strategy.most) {
                    if !strategy.judges_torch {
                        return Some(self.done(partition, trial));
                    }
                    let blocked = trial.blocked_mm3(earlier, plate, options);
                    let is_free = blocked <= FREE * trial.taken_mm3 && !trial.has_floats();
                    if first && is_free {
                        return Some(self.done(partition, trial));
                    }
                    let others = trial.taken.len() - 1 + usize::from(!first);
                    let cost = blocked + SAVED * partition.volume(self.cell) * others as f64;
                    if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                        best = Some((cost, trial));
                    }
                    first = false;
                }
            }
        }
        best.map(|(_, trial)| self.done(partition, trial))
    }

    /// Walls that lean back by an angle, in the order in which they are tried.
    fn choices(&self, lean: f64, strategy: Strategy, options: &VolumeOptions) -> Vec<Walls> {
        let crosses = self.region.points.iter().any(|(layer, _)| *layer == self.region.first);
        let single = if crosses || strategy.one_sided {
            walls_before(self.layered, self.region, lean, options)
        } else {
            Vec::new()
        };
        let single = single.into_iter().map(|wall| Walls { walls: vec![wall], rectangle: None });
        // Four walls that lean would meet over what they leave, and cut it to pieces.
        let around = if lean > 0.0 { None } else { walls_around(self.layered, self.region, options) };
        single.chain(around).collect()
    }

    /// What walls make of the part: as they are, and, of a single one behind which pieces lose their hold, moved back behind these.
    fn trials(&self, partition: &Partition, walls: Walls, options: &VolumeOptions) -> Vec<Trial> {
        let mut all: Vec<Trial> = Vec::new();
        let mut next = Some(walls);
        for _ in 0..=MOVES {
            let trial = next.take().and_then(|walls| self.separated(partition, walls));
            let Some(trial) = trial else { break };
            if let (Some(from), &[wall]) = (trial.floats_from, &trial.walls.walls[..]) {
                let moved = wall.moved_back(wall.upright.offset() - from + options.tolerance_mm);
                if leaves_enough(&moved, self.layered, self.region) {
                    next = Some(Walls { walls: vec![moved], rectangle: None });
                }
            }
            all.push(trial);
        }
        // The one that leaves fewest pieces without a hold first.
        all.reverse();
        all
    }

    fn separated(&self, partition: &Partition, walls: Walls) -> Option<Trial> {
        let mut trial = partition.clone();
        let (mut rest, mut taken) = (self.cell, Taken::new());
        let mut floats_from = None;
        for wall in &walls.walls {
            if let Some(separated) = separate(&mut trial, rest, wall, self.layered, self.region, self.stand.base) {
                rest = separated.rest;
                taken.extend(separated.taken);
                floats_from = separated.floats_from;
            }
        }
        let whole = partition.volume(self.cell);
        let taken_mm3: f64 = taken.iter().map(|&(cell, _)| trial.volume(cell)).sum();
        let divides = taken_mm3 >= SHARE * whole && whole - taken_mm3 >= SHARE * whole;
        divides.then_some(Trial { partition: trial, rest, taken, taken_mm3, walls, floats_from })
    }

    /// Keeps a separation.
    fn done(&self, partition: &mut Partition, trial: Trial) -> (Separation, u32, Taken) {
        let (layered, region) = (self.layered, self.region);
        let outlines = |of: &Region, height: f64| -> Vec<Vec<Point3<f64>>> {
            let contours =
                of.polygons().into_iter().flat_map(|polygon| std::iter::once(polygon.outer).chain(polygon.holes));
            contours.map(|contour| contour.iter().map(|p| layered.place(p, height)).collect()).collect()
        };
        let Walls { walls, rectangle } = trial.walls;
        let step = Separation {
            solid: self.own.clone(),
            direction: layered.direction,
            scenario: if rectangle.is_some() { Scenario::Enclosing } else { Scenario::Crossing },
            height_mm: layered.layers[region.first].low,
            carried: layered.layers.iter().flat_map(|layer| outlines(&layer.supported, layer.middle())).collect(),
            overhang: layered.layers.iter().flat_map(|layer| outlines(&layer.overhang, layer.middle())).collect(),
            points: region.points.iter().map(|&(_, p)| p).collect(),
            interpolant: interpolant(region),
            rectangle,
            walls,
            overhang_mm3: layered.overhang_mm3(),
            taken_mm3: trial.taken_mm3,
        };
        *partition = trial.partition;
        (step, trial.rest, trial.taken)
    }
}

impl Trial {
    /// Whether there are pieces that are printed from the other side of a wall.
    fn has_floats(&self) -> bool {
        let normals = || self.walls.walls.iter().map(SeparationWall::normal);
        self.taken.iter().any(|(_, stand)| normals().all(|normal| normal != stand.direction))
    }

    /// The solids of what stays and what is taken off, in the order of printing.
    fn solids(&self) -> Vec<(Solid, Option<Stand>)> {
        let taken = self.taken.iter().rev().map(|&(cell, stand)| (cell, Some(stand)));
        let cells = std::iter::once((self.rest, None)).chain(taken);
        cells.filter_map(|(cell, stand)| Some((self.partition.part(cell).ok()?, stand))).collect()
    }

    /// Calls with each part that is taken off, its stand, and all that is printed before it.
    fn sum(&self, earlier: &[&Solid], of: impl Fn(&Solid, &Stand, &[&Solid]) -> f64) -> f64 {
        let solids = self.solids();
        let mut before = earlier.to_vec();
        let mut sum = 0.0;
        for (solid, stand) in &solids {
            if let Some(stand) = stand {
                sum += of(solid, stand, &before);
            }
            before.push(solid);
        }
        sum
    }

    /// What of the parts that are taken off the torch cannot lay.
    fn blocked_mm3(&self, earlier: &[&Solid], plate: &Plate, options: &VolumeOptions) -> f64 {
        self.sum(earlier, |solid, stand, before| blocked_mm3(solid, stand, before, plate, options))
    }
}
