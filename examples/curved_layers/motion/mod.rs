//! Stage `motion`: joint trajectories for the whole print, of a UR3 that holds the part under a standing nozzle or
//! (`--cell8`) of an arm with the nozzle over a table that tilts and turns.
//!
//! C. Dai 2020, sections 2.5, 3.5.3 and 4.3. Every path is split where waypoints are out of reach (`postures`); each run gets the
//! postures of the motion of least jerk and the fastest timing within the limits of the joints (`run`), with as many waypoints as
//! keep the nozzle on its way (`course`). Between runs the nozzle lifts off, travels and comes down (`travel`), clear of the part
//! as it is built by then (`workcell`). What has been written is read again and checked (`check`).

pub mod check;
mod course;
mod flow;
pub mod legs;
mod plan;
mod postures;
pub mod robots;
mod run;
pub mod travel;
mod workcell;

use crate::failure;
use crate::field::FieldRun;
use crate::machine::{MachineRun, with_layers};
use crate::paths::PathsRun;
use crate::surfaces::SurfacesRun;
use check::Checked;
use clap::ValueEnum;
use curvlay_examples::args::{Failure, above_zero, from_zero};
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::{OverTable, PartInHand};
use curvlay_kinematics::Waypoint;
use curvlay_toolpath::surface::{GougingOptions, Nozzle};
use curvlay_trajectory::{Bounds, Trajectory};
use nalgebra::Vector3;
use plan::plan;
use robots::Printer;
use std::f64::consts::PI;
use std::io::BufRead;
use std::ops::ControlFlow;
use std::time::Duration;
use travel::Travel;
use workcell::{Job, Workcell};

/// How far the nozzle may leave its path, as a share of layer height or bead: what gouging allows as well.
const TOLERANCE_SHARE: f64 = 0.25;

/// Which cell, and what its controller is given.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct MotionArgs {
    /// Plans the motion of an IRB 1200 over a table that tilts and turns, instead of a UR3 that holds the part
    #[arg(long)]
    pub cell8: bool,
    /// The robot programs of stage motion [default: urscript, with --cell8 rapid]
    #[arg(long, value_name = "FORMAT")]
    pub program: Option<ProgramFormat>,
    /// Acceleration of a joint at most, in rad/s2; makers of arms publish none, 10 is what MoveIt assumes then; inf for no limit
    #[arg(long, value_name = "RAD_S2", default_value_t = 10.0, value_parser = limit, allow_negative_numbers = true)]
    pub acceleration: f64,
    /// Jerk of a joint at most, in rad/s3; 100 is what MoveIt assumes; inf for no limit
    #[arg(long, value_name = "RAD_S3", default_value_t = 100.0, value_parser = limit, allow_negative_numbers = true)]
    pub jerk: f64,
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
    #[arg(long, value_name = "MM", default_value_t = 0.5, value_parser = from_zero, allow_negative_numbers = true)]
    pub margin: f64,
    /// Most steps of a program file; a motion that is longer has a file of its own [default: 100000, of RAPID 5000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub program_steps: Option<u32>,
}

/// What a program is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProgramFormat {
    /// For the UR3: joints 125 times a second
    Urscript,
    /// With --cell8, for the IRB 1200: targets on the part, with the table's axes
    Rapid,
    /// The same steps with every digit, for other programs
    Csv,
    /// None
    None,
}

impl MotionArgs {
    /// The format that is wanted.
    pub fn format(&self) -> Result<ProgramFormat, Failure> {
        match (self.program, self.cell8) {
            (None, false) => Ok(ProgramFormat::Urscript),
            (None, true) => Ok(ProgramFormat::Rapid),
            (Some(ProgramFormat::Urscript), true) => Err(failure("--program urscript: not for --cell8, an ABB arm")),
            (Some(ProgramFormat::Rapid), false) => Err(failure("--program rapid: only with --cell8, not for a UR3")),
            (Some(format), _) => Ok(format),
        }
    }
}

/// What came of the stage, by the cell.
pub enum Motion {
    PartInHand(Box<MotionRun<6, 1, PartInHand>>),
    OverTable(Box<MotionRun<8, 2, OverTable>>),
}

/// What the extruder can follow.
#[derive(Clone, Copy, Debug)]
pub struct FlowBounds {
    pub max_flow_mm3_s: f64,
    pub max_ramp_mm3_s2: f64,
    /// Section of the filament.
    pub filament_mm2: f64,
}

/// What every motion keeps within.
#[derive(Clone, Copy, Debug)]
pub struct Limits<const N: usize> {
    /// Stops, the makers' speeds, and the accelerations and jerks that were asked for.
    pub bounds: Bounds<N>,
    pub flow: FlowBounds,
    /// How far the nozzle may leave its path, at its tip and at a point so far from the tip.
    pub tolerance_mm: f64,
    pub lever_mm: f64,
    /// How far things stay apart.
    pub margin_mm: f64,
}

impl<const N: usize> Limits<N> {
    /// Stops and speeds alone.
    pub fn speeds(&self) -> Bounds<N> {
        Bounds { acceleration: [f64::INFINITY; N], jerk: [f64::INFINITY; N], ..self.bounds }
    }
}

/// The whole print.
pub struct MotionRun<const N: usize, const F: usize, R> {
    /// The cell, without waypoints.
    pub robot: R,
    pub limits: Limits<N>,
    /// In the order in which they are travelled.
    pub runs: Vec<Run<N, F>>,
    /// From the end of each run to the start of the next; `None` where no way was found.
    pub travels: Vec<Option<Travel<N>>>,
    /// Positions in the part, less this, are positions over what carries it.
    pub shift: Vector3<f64>,
    pub figures: Figures,
    /// What the check of the written motions found.
    pub checked: Option<Checked<N>>,
}

/// One unbroken motion along a path, from rest to rest.
pub struct Run<const N: usize, const F: usize> {
    /// The path, by its place in the list.
    pub path: usize,
    pub layer: u32,
    pub trajectory: Trajectory<N>,
    /// Knots of the motion at waypoints, and which of the path these are; `None` of those that were put between two.
    pub passes: Vec<(usize, Option<usize>)>,
    /// Millimetres of filament since it began, at each knot.
    pub filament: Vec<f64>,
    /// Free parameters and waypoint at both ends.
    pub ends: [([f64; F], Waypoint); 2],
}

/// What is said of the whole print.
pub struct Figures {
    /// The cell, in words.
    pub name: &'static str,
    pub motions: usize,
    pub transfers: usize,
    /// How far from its waypoint a nozzle is at most, and from the straight way between two.
    pub missed_mm: f64,
    pub strayed_mm: f64,
    /// Lowest share of the planned feed at a waypoint between the ends of a motion.
    pub min_pace: f64,
    /// Seconds of printing: at the planned feed, and as it is.
    pub planned_s: f64,
    pub printing_s: f64,
    /// On the clock.
    pub times: Times,
    /// In the order of the print.
    pub faults: Vec<Fault>,
    pub layers: Vec<LayerFigures>,
}

/// How long the steps took.
#[derive(Clone, Copy, Default)]
pub struct Times {
    pub plan: Duration,
    pub transfers: Duration,
}

/// What is said of a layer. Transfers count with the layer to which they lead.
#[derive(Clone, Copy, Default)]
pub struct LayerFigures {
    pub layer: u32,
    pub motions: usize,
    pub waypoints: usize,
    pub robot_s: f64,
    /// On the threads that did it, added up: what a single one would have taken.
    pub times: Times,
    pub faults: usize,
}

/// Something that cannot be printed as it is, or not be reached.
#[derive(Clone, Debug)]
pub struct Fault {
    pub layer: u32,
    pub path: usize,
    pub kind: FaultKind,
    /// The waypoint of the path.
    pub waypoint: usize,
    pub what: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// No tool angle (and no tilt and turn of the table) reaches the waypoint.
    Unreachable,
    /// In reach, but something touches at every tool angle.
    Blocked,
    /// The path breaks off before the waypoint: no posture leads on from the one before.
    Break,
    /// The nozzle leaves the way from the waypoint to the next.
    Astray,
    /// No way to the next run was found.
    NoTransfer,
}

impl FaultKind {
    pub fn name(self) -> &'static str {
        match self {
            FaultKind::Unreachable => "unreachable",
            FaultKind::Blocked => "blocked",
            FaultKind::Break => "break",
            FaultKind::Astray => "astray",
            FaultKind::NoTransfer => "no transfer",
        }
    }
}

impl<const N: usize, const F: usize> Run<N, F> {
    /// How long it takes to each waypoint of the path from the one before: path, waypoint, seconds.
    fn steps(&self) -> Vec<(usize, usize, f64)> {
        let given = self.passes.iter().filter_map(|&(knot, waypoint)| Some((self.trajectory.times()[knot], waypoint?)));
        let given: Vec<(f64, usize)> = given.collect();
        let step = |pair: &[(f64, usize)]| (self.path, pair[1].1, pair[1].0 - pair[0].0);
        given.windows(2).filter(|pair| pair[1].1 == pair[0].1 + 1).map(step).collect()
    }

    /// Seconds from rest to rest.
    pub fn duration(&self) -> f64 {
        let (first, last) = self.trajectory.span();
        last - first
    }
}

impl Times {
    pub fn all(&self) -> Duration {
        self.plan + self.transfers
    }
}

impl LayerFigures {
    /// Planning time by robot time.
    pub fn factor(&self, times: impl Fn(&Times) -> Duration) -> f64 {
        times(&self.times).as_secs_f64() / self.robot_s.max(f64::MIN_POSITIVE)
    }
}

impl Figures {
    /// Seconds that the robot moves.
    pub fn robot_s(&self) -> f64 {
        self.layers.iter().map(|layer| layer.robot_s).sum()
    }

    pub fn plan_s(&self) -> f64 {
        self.times.all().as_secs_f64()
    }

    pub fn count(&self, kind: FaultKind) -> usize {
        self.faults.iter().filter(|fault| fault.kind == kind).count()
    }
}

impl Motion {
    pub fn figures(&self) -> &Figures {
        match self {
            Motion::PartInHand(run) => &run.figures,
            Motion::OverTable(run) => &run.figures,
        }
    }

    /// Checks the motions that were written to `trajectory.csv`.
    pub fn check(&mut self, print: &Print, file: impl BufRead, bars: &Bars) -> Result<(), Failure> {
        match self {
            Motion::PartInHand(run) => run.check(print, file, bars),
            Motion::OverTable(run) => run.check(print, file, bars),
        }
    }

    /// How long the motion takes to each waypoint from the one before: path, waypoint, seconds.
    pub fn steps(&self) -> Vec<(usize, usize, f64)> {
        match self {
            Motion::PartInHand(run) => run.runs.iter().flat_map(Run::steps).collect(),
            Motion::OverTable(run) => run.runs.iter().flat_map(Run::steps).collect(),
        }
    }

    /// What the plan leaves undone (whatever is not printed, ways that were not found), and what the check found.
    pub fn failed_checks(&self) -> Vec<String> {
        let kinds = [
            (FaultKind::Unreachable, "waypoints are out of reach and not printed"),
            (FaultKind::Blocked, "waypoints are blocked and not printed"),
            (FaultKind::Break, "paths break off, and the way from one waypoint to the next is not printed"),
            (FaultKind::NoTransfer, "transfers were not found: the robot has to be brought there by hand"),
        ];
        let counted = kinds.map(|(kind, what)| (self.figures().count(kind), what));
        let failed = counted.into_iter().filter(|(count, _)| *count > 0);
        let failed = failed.map(|(count, what)| format!("{count} {what}, see motion-faults.csv"));
        let checked = match self {
            Motion::PartInHand(run) => run.checked.as_ref().map(Checked::failed_checks),
            Motion::OverTable(run) => run.checked.as_ref().map(Checked::failed_checks),
        };
        failed.chain(checked.into_iter().flatten()).collect()
    }
}

impl<const N: usize, const F: usize, R: Printer<N, F>> MotionRun<N, F, R> {
    fn check(&mut self, print: &Print, file: impl BufRead, bars: &Bars) -> Result<(), Failure> {
        let motions = check::read(file).map_err(failure)?;
        self.checked = Some(check::check::<N, F, R>(print, &self.limits, &motions, bars)?);
        Ok(())
    }
}

/// What the motion is planned for.
#[derive(Clone, Copy)]
pub struct Print<'a> {
    pub args: &'a MotionArgs,
    pub nozzle: &'a Nozzle,
    /// Diameter of the filament.
    pub filament_mm: f64,
    pub field: &'a FieldRun,
    pub surfaces: &'a SurfacesRun,
    pub paths: &'a PathsRun,
    pub machine: &'a MachineRun,
}

impl Print<'_> {
    /// The part in the middle of what carries it; the plate stays where it is: z = 0 stands on it.
    fn shift(&self) -> Vector3<f64> {
        let tips = || self.machine.freed.paths.iter().flat_map(|path| &path.waypoints).map(|waypoint| waypoint.tip);
        let mean = tips().map(|tip| tip.coords).sum::<Vector3<f64>>() / tips().count().max(1) as f64;
        Vector3::new(mean.x, mean.y, 0.0)
    }

    fn limits<const N: usize, const F: usize>(&self, robot: &impl Printer<N, F>) -> Limits<N> {
        let MotionArgs { acceleration, jerk, max_flow, max_flow_ramp, tolerance, margin, .. } = *self.args;
        let bounds = Bounds { acceleration: [acceleration; N], jerk: [jerk; N], ..robot.limits() };
        let tolerance_mm = tolerance.unwrap_or(TOLERANCE_SHARE * self.surfaces.height_mm.min(self.paths.bead_mm));
        // The lower edge of the block.
        let lever_mm = self.nozzle.block_radius().hypot(self.nozzle.cone_height());
        let filament_mm2 = PI * self.filament_mm * self.filament_mm / 4.0;
        let flow = FlowBounds { max_flow_mm3_s: max_flow, max_ramp_mm3_s2: max_flow_ramp, filament_mm2 };
        Limits { bounds, flow, tolerance_mm, lever_mm, margin_mm: margin }
    }

    /// The workcell before anything is built, for as long as `work` takes. The nozzle may be so deep in a layer, as a share of
    /// its height.
    fn in_workcell<const N: usize, const F: usize, R: Printer<N, F>, T>(
        &self,
        allowed_depth: f64,
        bars: &Bars,
        work: impl FnOnce(Workcell<N, F, R>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let Print { field, surfaces, nozzle, .. } = *self;
        with_layers(surfaces, self.paths, |stack| {
            let progress = |p: curvlay_toolpath::Progress| {
                bars.update(p.stage, p.done, p.total);
                ControlFlow::Continue(())
            };
            // The workcell knows the plate.
            let options = GougingOptions { allowed_depth, plate: false, ..GougingOptions::default() };
            let contacts = stack.contacts(&self.machine.freed.paths, nozzle, &options, &progress).map_err(failure)?;
            let job = Job { field, surfaces, nozzle, contacts: &contacts, shift: self.shift() };
            work(Workcell::new(&job, self.limits(&R::empty()?))?)
        })
    }
}

/// Plans the whole print on the cell that is wanted.
pub fn run(print: &Print, bars: &Bars) -> Result<Motion, Failure> {
    if print.args.cell8 {
        Ok(Motion::OverTable(Box::new(plan(print, bars)?)))
    } else {
        Ok(Motion::PartInHand(Box::new(plan(print, bars)?)))
    }
}

/// A limit, for clap.
fn limit(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value: &f64| *value > 0.0)
        .ok_or_else(|| "must be above 0, or inf for no limit".to_owned())
}

/// A waypoint over what carries the part.
fn placed(waypoint: &curvlay_toolpath::surface::Waypoint, shift: &Vector3<f64>) -> Waypoint {
    Waypoint { position: waypoint.tip - shift, axis: waypoint.direction }
}
