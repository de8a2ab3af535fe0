//! Stage `motion`: joint trajectories for the whole print, in a workcell: a UR3 that holds the part under a standing nozzle,
//! an arm with the nozzle over a table that tilts and turns (`--cell8`), or what a file says (`--workcell`).
//!
//! C. Dai 2020, sections 2.5, 3.5.3 and 4.3. The planning is that of [`curvlay_trajectory::print`]; what stands in the
//! cell while the part grows is that of [`GrowingScene`], and here is the check of what has been written (`check`).

pub mod check;
pub mod read_back;

use crate::failure;
use crate::field::FieldRun;
use crate::machine::MachineRun;
use crate::outputs::motion::read_csv;
use crate::paths::PathsRun;
use crate::surfaces::SurfacesRun;
use check::Checked;
use clap::ValueEnum;
use curvlay_examples::args::{Failure, above_zero, from_zero, limit};
use curvlay_examples::bars::Bars;
use curvlay_examples::input;
use curvlay_examples::motion::{
    OnCell, PlacedPaths, PrintingCell, TABLE_CELL, UR3_CELL, bounds_of, home, link_mesh, programs, table_options,
    waypoints,
};
use curvlay_kinematics::workcell::{
    AnyWorkcell, EightAxisWorkcell, GrowingOptions, GrowingScene, PartCells, SixAxisWorkcell, Workcell, WorkcellModel,
};
use curvlay_kinematics::{JointLimits, PlateOptions, place_on_plate};
use curvlay_layers::curved::surface::SavedField;
use curvlay_toolpath::gouging::{GougingOptions, Nozzle};
use curvlay_trajectory::Bounds;
use curvlay_trajectory::check::FindingClass;
use curvlay_trajectory::print::{PrintLimits, PrintOptions, PrintPlan, TipSpeed, Waypoint, plan_print};
use nalgebra::Isometry3;
use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// How deep the nozzle may be in a layer on a planned motion, as a share of its height: motions are checked with a little more,
/// at more places.
const PLANNED_DEPTH: f64 = 0.24;

/// A nozzle with a longer cone than that of the workcell has a block of this height at least, in millimetres.
const MIN_BLOCK_MM: f64 = 1.0;

/// How far the nozzle may leave its path, as a share of layer height or bead: what gouging allows as well.
const TOLERANCE_SHARE: f64 = 0.25;

/// Which cell, and what its controller is given.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Motion of a robot")]
pub struct MotionArgs {
    /// Plans the motion of an IRB 1200 over a table that tilts and turns, instead of a UR3 that holds the part
    #[arg(long, conflicts_with = "workcell")]
    pub cell8: bool,
    /// Plans the motion in the workcell of a JSON file; kinematics/docs/workcells.md describes it, examples/cells has three
    #[arg(long, value_name = "FILE")]
    pub workcell: Option<PathBuf>,
    /// The robot programs of stage motion [default: urscript for arms of Universal Robots, else rapid; csv for such an arm with a
    /// table]
    #[arg(long, value_name = "FORMAT")]
    pub program: Option<ProgramFormat>,
    /// Acceleration of a joint at most, in rad/s2; inf for no limit [default: what the workcell says; 10 in those that come
    /// along: makers of arms publish none, and MoveIt assumes 10 then]
    #[arg(long, value_name = "RAD_S2", value_parser = limit, allow_negative_numbers = true)]
    pub acceleration: Option<f64>,
    /// Jerk of a joint at most, in rad/s3; inf for no limit [default: what the workcell says; 100 in those that come along, as
    /// MoveIt assumes]
    #[arg(long, value_name = "RAD_S3", value_parser = limit, allow_negative_numbers = true)]
    pub jerk: Option<f64>,
    /// Volume that the extruder lays a second at most, in mm3/s; where the plan asks for more, the nozzle goes slower
    #[arg(long, value_name = "MM3_S", default_value_t = f64::INFINITY, value_parser = limit, allow_negative_numbers = true)]
    pub max_flow: f64,
    /// How fast that volume may change, in mm3/s2
    #[arg(long, value_name = "MM3_S2", default_value_t = f64::INFINITY, value_parser = limit, allow_negative_numbers = true)]
    pub max_flow_ramp: f64,
    /// How far the nozzle may leave its path between waypoints, in millimetres [default: a quarter of the layer height or of the
    /// bead, whichever is less]
    #[arg(long, value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// How far arm, part and everything that stands there keep apart, in millimetres; the nozzle touches the part where it prints
    #[arg(long, value_name = "MM", default_value_t = GrowingOptions::MARGIN_MM, value_parser = from_zero, allow_negative_numbers = true)]
    pub margin: f64,
    /// How much thicker the links of the arm are than their bodies, in millimetres, for cables and hoses [default: what the
    /// workcell says; 10 if it says nothing]
    #[arg(long, value_name = "MM", value_parser = from_zero, allow_negative_numbers = true)]
    pub link_allowance: Option<f64>,
    /// Plans without the bodies of the arm, whatever it touches: then no motion is proven free of collisions. Without this, an arm
    /// whose bodies are not known is refused
    #[arg(long)]
    pub no_links: bool,
    /// Most steps of a program file; a motion that is longer has a file of its own [default: 100000, of RAPID 5000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub program_steps: Option<u32>,
}

/// What a program is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProgramFormat {
    /// For arms of Universal Robots without a table: joints 125 times a second
    Urscript,
    /// For ABB arms: targets on the part, with the axes of a table
    Rapid,
    /// The same steps with every digit, for other programs
    Csv,
    /// None
    None,
}

impl MotionArgs {
    /// The workcell; with another nozzle, if one was asked for.
    pub fn cell(&self, nozzle: Option<[f64; 4]>) -> Result<AnyWorkcell, Failure> {
        let named = |error: String| match &self.workcell {
            Some(file) => failure(format!("{}: {error}", file.display())),
            None => failure(error),
        };
        let text = match &self.workcell {
            Some(file) => input::read_text(file, input::MAX_SETTINGS_BYTES)?,
            None => if self.cell8 { TABLE_CELL } else { UR3_CELL }.to_owned(),
        };
        let mut model = WorkcellModel::from_json(text.as_bytes()).map_err(|error| named(error.to_string()))?;
        if let Some([tip, angle, height, block]) = nozzle {
            let shape = &mut model.nozzle;
            (shape.tip_flat_mm, shape.cone_half_angle_deg) = (tip, angle);
            (shape.cone_height_mm, shape.block_diameter_mm) = (height, block);
            shape.block_top_mm = shape.block_top_mm.max(height + MIN_BLOCK_MM);
        }
        if let Some(allowance_mm) = self.link_allowance {
            model.arm.allowance_mm = allowance_mm;
        }
        let folder = self.workcell.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        AnyWorkcell::with_link_meshes(model, &mut |file| link_mesh(folder, file))
            .map_err(|error| named(error.to_string()))
    }

    /// Refuses an arm without bodies, unless that is wanted.
    pub fn check_links(&self, cell: &AnyWorkcell) -> Result<(), Failure> {
        if self.no_links || cell.equipment().link_bodies().is_some() {
            return Ok(());
        }
        let file = self.workcell.as_ref().map_or_else(String::new, |file| format!("{}: ", file.display()));
        Err(failure(format!(
            "{file}arm: the bodies of its links are not known, so no motion can be proven free of collisions; give `arm.bodies` \
             (kinematics/docs/workcells.md), or --no-links to plan without"
        )))
    }

    /// The format that is wanted.
    pub fn format(&self, cell: &AnyWorkcell) -> Result<ProgramFormat, Failure> {
        let takes_stream = programs::takes_stream(cell.equipment());
        let refused = |why: &str| Err(Failure::of_arguments(format!("--program {why}")));
        match (self.program, takes_stream) {
            (None, Ok(true)) => Ok(ProgramFormat::Urscript),
            (None, Ok(false)) => Ok(ProgramFormat::Rapid),
            (None, Err(_)) => Ok(ProgramFormat::Csv),
            (Some(ProgramFormat::Urscript), Ok(false)) => refused("urscript: not for an ABB arm"),
            (Some(ProgramFormat::Urscript), Err(why)) => refused(&format!("urscript: {why}")),
            (Some(ProgramFormat::Rapid), Ok(true) | Err(_)) => refused("rapid: only for ABB arms, not for a UR"),
            (Some(format), _) => Ok(format),
        }
    }
}

/// What came of the stage, by the kind of cell.
pub enum Motion {
    Six(Box<MotionRun<6, 1, SixAxisWorkcell>>),
    Eight(Box<MotionRun<8, 2, EightAxisWorkcell>>),
}

/// The whole print.
pub struct MotionRun<const N: usize, const F: usize, W> {
    pub cell: W,
    pub limits: PrintLimits<N>,
    /// How far things stay apart.
    pub margin_mm: f64,
    /// Whether the arm is planned without its bodies.
    pub without_links: bool,
    pub plan: PrintPlan<N, F>,
    /// Maps the part to the frame of what carries it.
    pub frame_part: Isometry3<f64>,
    /// Where programs begin and end; `None` where there is no such posture.
    pub home: Option<[f64; N]>,
    /// What the first check of the written motions found.
    pub checked: Option<Checked<N>>,
    /// What the last one found, once the unsafe motions were taken out.
    pub rechecked: Option<Checked<N>>,
    /// Number of motions that were taken out, since they are not safe.
    pub withheld: usize,
    options: PrintOptions<N, F>,
    format: ProgramFormat,
}

/// Does the same with the run of whichever cell it is.
macro_rules! of_run {
    ($motion:expr, $run:ident => $does:expr) => {
        match $motion {
            $crate::motion::Motion::Six($run) => $does,
            $crate::motion::Motion::Eight($run) => $does,
        }
    };
}
pub(crate) use of_run;

impl Motion {
    /// Checks the motions that were written to `trajectory.csv`. Returns whether some are unsafe and were taken out: then the file is
    /// to be written and checked again.
    pub fn check(&mut self, print: &Print, file: impl BufRead, bars: &Bars) -> Result<bool, Failure> {
        of_run!(self, run => {
            let cell = (&run.cell, &run.frame_part);
            let checked = check::check(print, cell, &run.limits, &read_csv(file)?, bars)?;
            run.take_in(checked);
            print.withhold(run, bars)
        })
    }

    /// How long the motion takes to each waypoint from the one before: path, waypoint, seconds.
    pub fn steps(&self) -> Vec<(usize, usize, f64)> {
        of_run!(self, run => run.plan.steps())
    }
}

impl<const N: usize, const F: usize, W> MotionRun<N, F, W> {
    /// Keeps what a check found: findings of the first one, the lengths of the last one.
    fn take_in(&mut self, checked: Checked<N>) {
        match &mut self.checked {
            None => self.checked = Some(checked),
            Some(first) => {
                first.unprinted_mm = checked.unprinted_mm;
                first.took += checked.took;
                self.rechecked = Some(checked);
            }
        }
    }

    /// How fast the tip may travel, in mm/s.
    pub fn fastest_mm_s(&self) -> f64 {
        self.options.tip_speed.near_mm_s.max(self.options.tip_speed.far_mm_s)
    }

    /// Unsafe motions by the last check.
    pub fn unsafe_motions(&self) -> BTreeSet<usize> {
        let last = self.rechecked.as_ref().or(self.checked.as_ref());
        last.map(|checked| checked.report.print.motions_with(FindingClass::is_unsafe)).unwrap_or_default()
    }
}

/// What the motion is planned for.
#[derive(Clone, Copy)]
pub struct Print<'a> {
    pub args: &'a MotionArgs,
    pub nozzle: &'a Nozzle,
    /// Diameter of the filament.
    pub filament_mm: f64,
    /// Speed of travels at most, in mm/s, where the user asks for one.
    pub travel_mm_s: Option<f64>,
    pub field: &'a FieldRun,
    pub surfaces: &'a SurfacesRun,
    pub paths: &'a PathsRun,
    pub machine: &'a MachineRun,
}

impl Print<'_> {
    fn limits<const N: usize>(&self, limits: &JointLimits<N>) -> PrintLimits<N> {
        let MotionArgs { acceleration, jerk, max_flow, max_flow_ramp, tolerance, .. } = *self.args;
        let bounds = bounds_of(limits);
        let wanted = |limits: [f64; N], wanted: Option<f64>| wanted.map_or(limits, |limit| [limit; N]);
        let (acceleration, jerk) = (wanted(bounds.acceleration, acceleration), wanted(bounds.jerk, jerk));
        PrintLimits {
            bounds: Bounds { acceleration, jerk, ..bounds },
            max_flow_mm3_s: max_flow,
            max_flow_ramp_mm3_s2: max_flow_ramp,
            filament_mm2: PI * self.filament_mm * self.filament_mm / 4.0,
            tolerance_mm: tolerance.unwrap_or(TOLERANCE_SHARE * self.surfaces.height_mm.min(self.paths.bead_mm)),
            // The lower edge of the block.
            lever_mm: self.nozzle.block_radius().hypot(self.nozzle.cone_height()),
        }
    }

    /// Options with travels no faster than the user asks for.
    fn unhurried<const N: usize, const F: usize>(&self, options: &PrintOptions<N, F>) -> PrintOptions<N, F> {
        let TipSpeed { near_mm_s, far_mm_s, near_mm } = options.tip_speed;
        let [near_mm_s, far_mm_s] =
            [near_mm_s, far_mm_s].map(|limit| self.travel_mm_s.map_or(limit, |mm_s| limit.min(mm_s)));
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
        let limits = self.limits(cell.limits());
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
        let cuts = programs::cuts(&run.cell, &run.plan, run.format == ProgramFormat::Csv, self.args.program_steps);
        let progress = |p: curvlay_trajectory::Progress| bars.show(p.stage, p.done, p.total);
        let start = Instant::now();
        run.plan = self.in_workcell((&run.cell, &run.frame_part), PLANNED_DEPTH, bars, |growing| {
            Ok(run.plan.with_homes(&robot, growing, &home, &cuts, &run.limits, &run.options, &progress)?)
        })?;
        run.plan.times.travels += start.elapsed();
        Ok(())
    }

    /// Takes unsafe motions out of the plan, and plans ways home around them. Returns whether there are any.
    fn withhold<const N: usize, const F: usize, W: Workcell<N, F>>(
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
    fn in_workcell<const N: usize, const F: usize, W: Workcell<N, F>, T>(
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
        AnyWorkcell::Eight(cell) => Motion::Eight(Box::new(print.plan(cell, (&table_options(), format), bars)?)),
    })
}
