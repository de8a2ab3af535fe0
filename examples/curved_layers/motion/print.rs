//! What the motion is planned for, and its plan.

use super::args::{MotionArgs, ProgramFormat};
use super::planned::{Motion, MotionRun};
use crate::field::FieldRun;
use crate::machine::MachineRun;
use crate::paths::PathsRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::{
    OnCell, PlacedPaths, PrintingCell, bounds_of, home, programs, table_options, track_options, turning_joints,
    waypoints,
};
use curvlay_kinematics::workcell::{AnyWorkcell, GrowingOptions, GrowingScene, PartCells, Workcell};
use curvlay_kinematics::{PlateOptions, place_on_plate};
use curvlay_layers::curved::surface::SavedField;
use curvlay_toolpath::gouging::{GougingOptions, Nozzle};
use curvlay_trajectory::Bounds;
use curvlay_trajectory::print::{PrintLimits, PrintOptions, TipSpeed, Waypoint, plan_print};
use nalgebra::Isometry3;
use std::f64::consts::PI;
use std::time::Instant;

/// How deep the nozzle may be in a layer on a planned motion, as a share of its height: motions are checked with a little more,
/// at more places.
const PLANNED_DEPTH: f64 = 0.24;

/// How far the nozzle may leave its path, as a share of layer height or bead: what gouging allows as well.
const TOLERANCE_SHARE: f64 = 0.25;

/// What the motion is planned for.
#[derive(Clone, Copy)]
pub struct Print<'a> {
    pub args: &'a MotionArgs,
    pub nozzle: &'a Nozzle,
    /// Diameter of the filament.
    pub filament_mm: f64,
    /// Maximum speed of travels, in mm/s.
    pub travel_mm_s: f64,
    pub field: &'a FieldRun,
    pub surfaces: &'a SurfacesRun,
    pub paths: &'a PathsRun,
    pub machine: &'a MachineRun,
}

impl Print<'_> {
    fn limits<const N: usize, const F: usize>(&self, cell: &impl Workcell<N, F>) -> PrintLimits<N> {
        let MotionArgs { acceleration_rad_s2, jerk_rad_s3, max_flow_mm3_s, max_flow_ramp_mm3_s2, tolerance, .. } =
            *self.args;
        let bounds = bounds_of(cell.limits());
        // A track has limits of its own.
        let turning = turning_joints(cell.equipment(), N);
        let wanted = |limits: [f64; N], wanted: Option<f64>| {
            std::array::from_fn(|joint| wanted.filter(|_| joint < turning).unwrap_or(limits[joint]))
        };
        let (acceleration, jerk) = (wanted(bounds.acceleration, acceleration_rad_s2), wanted(bounds.jerk, jerk_rad_s3));
        PrintLimits {
            bounds: Bounds { acceleration, jerk, ..bounds },
            max_flow_mm3_s,
            max_flow_ramp_mm3_s2,
            filament_mm2: PI * self.filament_mm * self.filament_mm / 4.0,
            tolerance_mm: tolerance.unwrap_or(TOLERANCE_SHARE * self.surfaces.height_mm.min(self.paths.bead_mm)),
            // The lower edge of the block.
            lever_mm: self.nozzle.block_radius().hypot(self.nozzle.cone_height()),
        }
    }

    /// Options with travels no faster than that.
    fn unhurried<const N: usize, const F: usize>(&self, options: &PrintOptions<N, F>) -> PrintOptions<N, F> {
        let TipSpeed { near_mm_s, far_mm_s, near_mm } = options.tip_speed;
        let [near_mm_s, far_mm_s] = [near_mm_s, far_mm_s].map(|limit| limit.min(self.travel_mm_s));
        PrintOptions { tip_speed: TipSpeed { near_mm_s, far_mm_s, near_mm }, ..*options }
    }

    fn growing_options(&self) -> GrowingOptions {
        let MotionArgs { margin, no_links, .. } = *self.args;
        GrowingOptions { margin_mm: margin, without_links: no_links, ..GrowingOptions::default() }
    }

    /// Plans it.
    fn plan<const N: usize, const F: usize, W: Workcell<N, F>>(
        &self,
        cell: &W,
        (options, format): (&PrintOptions<N, F>, ProgramFormat),
        bars: &Bars,
    ) -> Result<MotionRun<N, F, W>, Failure> {
        let start = Instant::now();
        let options = &self.unhurried(options);
        let robot = OnCell::new(cell.clone(), Vec::new());
        let place = PlateOptions {
            stop_margin: options.stop_margin,
            margin_mm: self.args.margin,
            comfortable_mm: self.growing_options().clearances_mm[0],
            rim_mm: self.paths.bead_mm,
            ..PlateOptions::new(options.samples)
        };
        let waypoint = |at: Waypoint| curvlay_kinematics::Waypoint { position: at.position, axis: at.axis };
        let all: Vec<_> = self.machine.resolved.paths.iter().flat_map(waypoints).map(waypoint).collect();
        let plate_mm = self.field.platform_diameter_mm();
        let progress = |p: curvlay_kinematics::Progress| bars.show(p.stage, p.done, p.total);
        let frame_part = place_on_plate(cell, &all, plate_mm, &place, &progress)?;
        let limits = self.limits(cell);
        let paths = PlacedPaths::new(&self.machine.resolved.paths, &self.machine.deposition, &frame_part);
        let progress = |p: curvlay_trajectory::Progress| bars.show(p.stage, p.done, p.total);
        let (plan, home) = self.in_workcell((cell, &frame_part), PLANNED_DEPTH, bars, |growing| {
            let took = start.elapsed();
            let mut plan = plan_print(&robot, growing.clone(), &paths.paths(), &limits, options, &progress)?;
            plan.times.runs += took;
            let start = Instant::now();
            let home = home(&plan, &robot, &growing, (&limits, options), &progress)?;
            plan.times.travels += start.elapsed();
            Ok((plan, home))
        })?;
        let MotionArgs { margin: margin_mm, no_links: without_links, .. } = *self.args;
        let (cell, options) = (cell.clone(), *options);
        let [checked, rechecked] = [None, None];
        let mut run = MotionRun {
            cell,
            limits,
            margin_mm,
            without_links,
            plan,
            frame_part,
            home,
            checked,
            rechecked,
            withheld: 0,
            options,
            format,
        };
        self.go_home(&mut run, bars)?;
        Ok(run)
    }

    /// Cuts the plan into programs that begin and end at home.
    fn go_home<const N: usize, const F: usize, W: Workcell<N, F>>(
        &self,
        run: &mut MotionRun<N, F, W>,
        bars: &Bars,
    ) -> Result<(), Failure> {
        let Some(home) = run.home else { return Ok(()) };
        let robot = OnCell::new(run.cell.clone(), Vec::new());
        let most = self.args.program_steps;
        let cuts = match run.format {
            ProgramFormat::UrscriptMovep => programs::blended_cuts(&run.cell, &run.plan, most),
            format => programs::cuts(&run.cell, &run.plan, format == ProgramFormat::Csv, most),
        };
        let progress = |p: curvlay_trajectory::Progress| bars.show(p.stage, p.done, p.total);
        let start = Instant::now();
        run.plan = self.in_workcell((&run.cell, &run.frame_part), PLANNED_DEPTH, bars, |growing| {
            Ok(run.plan.with_homes(&robot, growing, &home, &cuts, &run.limits, &run.options, &progress)?)
        })?;
        run.plan.times.travels += start.elapsed();
        Ok(())
    }

    /// Takes unsafe motions out of the plan, and plans ways home around them. Returns whether there are any.
    pub fn withhold<const N: usize, const F: usize, W: Workcell<N, F>>(
        &self,
        run: &mut MotionRun<N, F, W>,
        bars: &Bars,
    ) -> Result<bool, Failure> {
        let found = run.unsafe_motions();
        if found.is_empty() {
            return Ok(false);
        }
        run.withheld += found.len();
        run.plan = run.plan.without(&found);
        self.go_home(run, bars)?;
        Ok(true)
    }

    /// The workcell before anything is built, for as long as `work` takes. The nozzle may be so deep in a layer, as a share of
    /// its height.
    pub fn in_workcell<const N: usize, const F: usize, W: Workcell<N, F>, T>(
        &self,
        (cell, frame_part): (&W, &Isometry3<f64>),
        allowed_depth: f64,
        bars: &Bars,
        work: impl FnOnce(PrintingCell<N, F, W>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let Print { field, surfaces, nozzle, .. } = *self;
        let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
        // The workcell knows the plate.
        let options = GougingOptions { allowed_depth, ..GougingOptions::in_workcell() };
        let layers = surfaces.surfaces();
        let stack = self.paths.stack(&layers, field.mould.as_ref(), surfaces.height_mm)?;
        let contacts = stack.contacts(&self.machine.resolved.paths, nozzle, &options, &progress)?;
        let grid = &field.solid.grid;
        // Part and support; the cells of the gap between them stay empty.
        let SavedField { field: order, rows, aids, .. } = &surfaces.saved;
        let mut layers = order.cells_by_surface(&surfaces.heights_mm, grid.cell_mm())?;
        layers.iter_mut().for_each(|layer| layer.retain(|cell| aids.gap.binary_search(cell).is_err()));
        let part = PartCells {
            dims: grid.dims(),
            rows,
            cell_mm: grid.cell_mm(),
            origin: grid.origin(),
            frame_part: *frame_part,
            layers: &layers,
        };
        let mut scene = GrowingScene::new(cell, &part, field.platform_diameter_mm(), &self.growing_options())?;
        if let Some(mould) = field.platform.mould() {
            scene = scene.on_mould(mould.rows())?;
        }
        work(PrintingCell::new(scene, &contacts))
    }
}

/// Plans the whole print in a cell.
pub fn run(print: &Print, cell: &AnyWorkcell, bars: &Bars) -> Result<Motion, Failure> {
    let format = print.args.format(cell)?;
    Ok(match cell {
        AnyWorkcell::Six(cell) => Motion::Six(Box::new(print.plan(cell, (&PrintOptions::default(), format), bars)?)),
        AnyWorkcell::Seven(cell) => Motion::Seven(Box::new(print.plan(cell, (&track_options(), format), bars)?)),
        AnyWorkcell::Eight(cell) => Motion::Eight(Box::new(print.plan(cell, (&table_options(), format), bars)?)),
    })
}
