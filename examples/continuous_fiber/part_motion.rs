//! The robot's motion for a whole part: beads by the nozzle and tapes by the roller, in one program from home to home.
//!
//! Both are planned in the same workcell, one with the nozzle and one with the roller in its place. After each layer with tapes the nozzle goes home, the head
//! changes there, the roller gets hot, lays the tapes of the layer, and goes home again. The motions for both begin and end in the same posture.

use super::layer::PartLayers;
use super::motion::{Placed, TapeMotion, along_tapes, mounted, six_axes};
use super::part_programs::{Item, Written};
use super::part_read_back::ReadAgain;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::TargetLanguage;
use curvlay_examples::motion::{NO_HOME, OnCell, PlacedPaths, PrintingCell, bounds_of, home, programs, waypoints};
use curvlay_examples::nalgebra::Isometry3;
use curvlay_examples::viewer;
use curvlay_kinematics::workcell::{AnyWorkcell, GrowingOptions, GrowingScene, PartCells, SixAxisWorkcell, Workcell};
use curvlay_kinematics::{PlateOptions, place_on_plate};
use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead};
use curvlay_toolpath::fill::FilledLayers;
use curvlay_toolpath::gouging::{GougingOptions, Nozzle};
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::plan::PrintPlan;
use curvlay_trajectory::print::{self, Fault, PrintLimits, PrintOptions, plan_print};
use std::collections::{BTreeMap, BTreeSet};

/// Diameter of a plate that the workcell leaves open, in millimetres, unless the part is wider, and the rim that then stays.
const PLATE_MM: f64 = 127.5;
const RIM_MM: f64 = 10.0;
/// How deep the nozzle may be in a layer on a planned motion, as a share of its height: what the machine file allows, a quarter, less a little.
const PLANNED_DEPTH: f64 = 0.24;
/// How far the nozzle may leave its path, as a share of the layer height.
const TOLERANCE: f64 = 0.25;
/// What is planned before the robot.
pub struct Work<'a> {
    pub layers: &'a PartLayers,
    pub surfaces: &'a [LayerSurface<'a>],
    pub filled: &'a FilledLayers,
    pub print: &'a PrintPlan,
    pub tapes: &'a [LayerTapes],
    pub head: &'a TapeHead,
    pub nozzle: &'a Nozzle,
    pub bead_mm: f64,
    pub bars: &'a Bars,
}

/// What the robot does.
pub struct PartMotion {
    /// Name of the workcell.
    pub cell: String,
    /// Motions along beads, and along tapes.
    pub runs: [usize; 2],
    /// Tapes and wires that were to be laid.
    pub tapes: usize,
    /// What is not printed or laid as planned: whether it is a tape, and what.
    pub faults: Vec<(bool, Fault)>,
    /// Seconds that the robot moves, but for waits.
    pub robot_s: f64,
    /// How far the tip is from its path at most, in mm: of the nozzle, and of the roller.
    pub max_deviation_mm: [f64; 2],
    /// How far the roller is turned away from a tape at most, in radians, and how it is mounted.
    pub max_turn: f64,
    pub mount: f64,
    /// Times that the head changes.
    pub changes: usize,
    /// Programs by name.
    pub files: BTreeMap<String, Vec<u8>>,
    /// What they hold, read again.
    pub read: ReadAgain,
    /// The motion for the viewer.
    pub shown: Option<(Vec<viewer::Step>, viewer::Robot)>,
}

impl Work<'_> {
    /// Plans all motions and writes the programs.
    pub fn plan(&self, cell: &AnyWorkcell) -> Result<PartMotion, Failure> {
        let cell = six_axes(cell)?;
        let takes_stream = match TargetLanguage::of(cell.equipment())? {
            None => true,
            Some(TargetLanguage::Rapid) => false,
            Some(TargetLanguage::Krl | TargetLanguage::Tp) => {
                return Err(Failure::of_arguments(
                    "--workcell: programs with tapes are written as URScript or RAPID, not in the language of this controller",
                ));
            }
        };
        let Work { layers, print, tapes, head, .. } = *self;
        let grid = &layers.solid.grid;
        let [nx, ny, _] = grid.dims();
        let plate_mm = PLATE_MM.max(grid.cell_mm() * f64::from(nx).hypot(f64::from(ny)) + RIM_MM);
        let frame_part = self.placed_on_plate(cell, plate_mm)?;
        let cells =
            layers.layered.uniform.field.cells_by_surface(&layers.layered.surfaces.heights_mm, grid.cell_mm())?;
        let grown = PartCells {
            dims: grid.dims(),
            rows: grid.rows(),
            cell_mm: grid.cell_mm(),
            origin: grid.origin(),
            frame_part,
            layers: &cells,
        };
        let (beads, home) = self.beads(cell, &grown, plate_mm)?;
        let Some(home) = home else { return Ok(nowhere(cell, &beads, tapes)) };
        let (taped, mount) = self.taped(cell, &grown, plate_mm, &home)?;
        let written = Written { cell, beads: &beads, taped: &taped, tapes, head, home };
        let items = written.items();
        let files = if takes_stream { written.streams(&items)? } else { written.modules(&items)? };
        let read = written.read(&items, &files, takes_stream)?;
        let shown = written.shown(&items, &frame_part, print);
        let faults = beads.faults.iter().map(|fault| (false, fault.clone()));
        let of_tapes = taped.iter().zip(tapes).flat_map(|(taped, list)| {
            let named = |fault: &Fault| (true, Fault { layer: list.layer, ..fault.clone() });
            taped.plan.faults.iter().map(named).collect::<Vec<_>>()
        });
        let most = |of: fn(&TapeMotion) -> f64| taped.iter().map(of).fold(0.0, f64::max);
        Ok(PartMotion {
            cell: cell.equipment().name().to_owned(),
            runs: [beads.runs.len(), taped.iter().map(|taped| taped.plan.runs.len()).sum()],
            tapes: tapes.iter().map(|list| list.tapes.len()).sum(),
            faults: faults.chain(of_tapes).collect(),
            robot_s: beads.robot_s() + taped.iter().map(|taped| taped.plan.robot_s()).sum::<f64>(),
            max_deviation_mm: [beads.max_deviation_mm, most(|taped| taped.plan.max_deviation_mm)],
            max_turn: most(|taped| taped.max_turn),
            mount,
            changes: 2 * items.iter().filter(|item| matches!(item, Item::Tapes(..))).count(),
            files,
            read,
            shown: Some(shown),
        })
    }

    /// Where the part stands: all waypoints of the nozzle are reached.
    fn placed_on_plate(&self, cell: &SixAxisWorkcell, plate_mm: f64) -> Result<Isometry3<f64>, Failure> {
        let options = PrintOptions::<6, 1>::default();
        let place = PlateOptions {
            stop_margin: options.stop_margin,
            rim_mm: self.bead_mm,
            ..PlateOptions::new(options.samples)
        };
        let all = self.print.resolved.paths.iter().flat_map(waypoints);
        let all: Vec<_> = all.map(|at| curvlay_kinematics::Waypoint { position: at.position, axis: at.axis }).collect();
        let progress = |p: curvlay_kinematics::Progress| self.bars.show(p.stage, p.done, p.total);
        Ok(place_on_plate(cell, &all, plate_mm, &place, &progress)?)
    }

    /// The motion along beads by the nozzle, and the home posture from which its programs begin, if there is one.
    fn beads(
        &self,
        cell: &SixAxisWorkcell,
        grown: &PartCells,
        plate_mm: f64,
    ) -> Result<(print::PrintPlan<6, 1>, Option<[f64; 6]>), Failure> {
        let Work { layers, surfaces, filled, print, nozzle, bead_mm, bars, .. } = *self;
        let options = PrintOptions::default();
        let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
        let stack = filled.stack(surfaces)?;
        let gouging = GougingOptions { allowed_depth: PLANNED_DEPTH, ..GougingOptions::in_workcell() };
        let contacts = stack.contacts(&print.resolved.paths, nozzle, &gouging, &progress)?;
        let scene = PrintingCell::new(GrowingScene::new(cell, grown, plate_mm, &GrowingOptions::default())?, &contacts);
        let paths = PlacedPaths::new(&print.resolved.paths, &print.deposition, &grown.frame_part);
        let height_mm = layers.layered.surfaces.height_mm;
        let limits = PrintLimits {
            tolerance_mm: TOLERANCE * height_mm.min(bead_mm),
            ..PrintLimits::of(bounds_of(cell.limits()))
        };
        let robot = OnCell::new(cell.clone(), Vec::new());
        let progress = |p: curvlay_trajectory::Progress| bars.show(p.stage, p.done, p.total);
        let beads = plan_print(&robot, scene.clone(), &paths.paths(), &limits, &options, &progress)?;
        let home = home(&beads, &robot, &scene, (&limits, &options), &progress)?;
        let Some(home) = home else { return Ok((beads, None)) };
        let cuts = self.cuts(cell, &beads);
        let beads = beads.with_homes(&robot, scene, &home, &cuts, &limits, &options, &progress)?;
        Ok((beads, Some(home)))
    }

    /// The motions along tapes by the roller, and how it is mounted. A list is laid on all that is built by then, and planned by itself: the roller
    /// must not look along tapes of another layer.
    fn taped(
        &self,
        cell: &SixAxisWorkcell,
        grown: &PartCells,
        plate_mm: f64,
        home: &[f64; 6],
    ) -> Result<(Vec<TapeMotion>, f64), Failure> {
        let Work { tapes, head, bars, .. } = *self;
        let mut built: Vec<Vec<u32>> = vec![Vec::new(); tapes.len()];
        for (list, built) in tapes.iter().zip(&mut built) {
            built.extend(grown.layers.iter().take(list.layer as usize + 1).flatten());
        }
        let place = |list: &LayerTapes| Placed::list(list, 0, head, &grown.frame_part);
        let all: Vec<Placed> = tapes.iter().flat_map(place).collect();
        let (with_roller, mount) = match all.is_empty() {
            true => (cell.clone(), 0.0),
            false => mounted(cell, &all, grown, plate_mm)?,
        };
        let lay = |(list, built): (&LayerTapes, &Vec<u32>)| {
            let grown = PartCells { layers: std::slice::from_ref(built), ..*grown };
            along_tapes((&with_roller, mount), place(list), &grown, plate_mm, Some(home), bars)
        };
        Ok((tapes.iter().zip(&built).map(lay).collect::<Result<Vec<_>, _>>()?, mount))
    }

    /// The runs of beads before which the nozzle comes from home: behind layers with tapes, and where programs would grow too long.
    fn cuts(&self, cell: &SixAxisWorkcell, beads: &print::PrintPlan<6, 1>) -> BTreeSet<usize> {
        let mut cuts = programs::cuts(cell, beads, false, None);
        let layer = |run: usize| beads.runs[run].layer;
        let has_tapes = |run: &usize| self.tapes.iter().any(|list| (layer(run - 1)..layer(*run)).contains(&list.layer));
        cuts.extend((1..beads.runs.len()).filter(has_tapes));
        cuts
    }
}

/// Without a home posture there are no programs.
fn nowhere(cell: &SixAxisWorkcell, beads: &print::PrintPlan<6, 1>, tapes: &[LayerTapes]) -> PartMotion {
    let fault = Fault { layer: 0, path: 0, kind: print::FaultKind::NoTransfer, waypoint: 0, what: NO_HOME.to_owned() };
    PartMotion {
        cell: cell.equipment().name().to_owned(),
        runs: [beads.runs.len(), 0],
        tapes: tapes.iter().map(|list| list.tapes.len()).sum(),
        faults: vec![(false, fault)],
        robot_s: 0.0,
        max_deviation_mm: [beads.max_deviation_mm, 0.0],
        max_turn: 0.0,
        mount: 0.0,
        changes: 0,
        files: BTreeMap::new(),
        read: ReadAgain::default(),
        shown: None,
    }
}
