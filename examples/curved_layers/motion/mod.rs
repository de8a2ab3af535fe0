//! Stage `motion`: joint trajectories for the whole print, of a UR3 that holds the part under a standing nozzle or
//! (`--cell8`) of an arm with the nozzle over a table that tilts and turns.
//!
//! C. Dai 2020, sections 2.5, 3.5.3 and 4.3. Every path is split where waypoints are out of reach and where the joints
//! cannot keep up with the feed (`climb`); each run gets the motion of least jerk (`run`) with as many waypoints as keep the
//! nozzle on its way (`course`). Then every motion and the transfers in
//! between are checked against the cell, with the part as it is built by then (`workcell`).

mod climb;
mod course;
mod plan;
pub mod robots;
mod run;
mod workcell;

use crate::failure;
use crate::field::FieldRun;
use crate::machine::MachineRun;
use crate::surfaces::SurfacesRun;
use clap::ValueEnum;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::{OverTable, PartInHand};
use curvlay_kinematics::Waypoint;
use curvlay_trajectory::transfer::Transfer;
use curvlay_trajectory::{Bounds, Trajectory};
use nalgebra::Vector3;
use plan::plan;
use robots::Printer;
use std::time::Duration;

/// Which cell, and what its controller is given.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct MotionArgs {
    /// Plans the motion of an IRB 1200 over a table that tilts and turns, instead of a UR3 that holds the part
    #[arg(long)]
    pub cell8: bool,
    /// The robot programs of stage motion [default: urscript, with --cell8 rapid]
    #[arg(long, value_name = "FORMAT")]
    pub program: Option<ProgramFormat>,
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

/// The whole print.
pub struct MotionRun<const N: usize, const F: usize, R> {
    /// The cell, without waypoints.
    pub robot: R,
    /// In the order in which they are travelled.
    pub runs: Vec<Run<N, F>>,
    /// From the end of each run to the start of the next; `None` where no way was found.
    pub transfers: Vec<Option<Transfer<N>>>,
    /// Places in the part frame, less this, are places over what carries the part.
    pub shift: Vector3<f64>,
    pub figures: Figures,
}

/// One unbroken motion along a path.
pub struct Run<const N: usize, const F: usize> {
    /// The path, by its place in the list.
    pub path: usize,
    pub layer: u32,
    pub trajectory: Trajectory<N>,
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
    /// Least share of the planned feed at which a motion is printed.
    pub least_feed: f64,
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
    pub check: Duration,
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
    /// The waypoint of the path; of a collision the knot of the motion.
    pub waypoint: usize,
    pub what: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// No tool angle (and no tilt and turn of the table) reaches the waypoint.
    Unreachable,
    /// In reach, but something touches at every tool angle.
    Blocked,
    /// The path breaks off before the waypoint: the joints are too slow for the feed.
    Break,
    /// A bound of the joints does not hold everywhere.
    Bounds,
    /// The motion is printed below the planned feed, since a joint is too slow for it.
    Slowed,
    /// The nozzle leaves the way from the waypoint to the next.
    Astray,
    /// A motion from knot to knot is not proven free.
    Collision,
    /// No way to the next run was found.
    NoTransfer,
}

impl FaultKind {
    pub fn name(self) -> &'static str {
        match self {
            FaultKind::Unreachable => "unreachable",
            FaultKind::Blocked => "blocked",
            FaultKind::Break => "break",
            FaultKind::Bounds => "bounds",
            FaultKind::Slowed => "slowed",
            FaultKind::Astray => "astray",
            FaultKind::Collision => "collision",
            FaultKind::NoTransfer => "no transfer",
        }
    }
}

impl<const N: usize, const F: usize> Run<N, F> {
    /// When the first and when the last waypoint is passed.
    pub fn printing(&self) -> [f64; 2] {
        let (times, waypoints) = (self.trajectory.times(), self.trajectory.waypoints());
        [times[waypoints.start], times[waypoints.end - 1]]
    }

    /// Seconds from rest to rest.
    pub fn duration(&self) -> f64 {
        let (first, last) = self.trajectory.span();
        last - first
    }
}

impl Times {
    pub fn all(&self) -> Duration {
        self.plan + self.check + self.transfers
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

    /// What collides most often.
    pub fn worst(&self) -> Option<String> {
        let mut all: Vec<&str> =
            self.faults.iter().filter(|fault| fault.kind == FaultKind::Collision).map(|fault| &*fault.what).collect();
        all.sort_unstable();
        all.chunk_by(|a, b| a == b).max_by_key(|same| same.len()).map(|same| same[0].to_owned())
    }
}

impl Motion {
    pub fn figures(&self) -> &Figures {
        match self {
            Motion::PartInHand(run) => &run.figures,
            Motion::OverTable(run) => &run.figures,
        }
    }

    /// The place in the part that stands in the middle of what carries it, on the plate.
    pub fn shift(&self) -> Vector3<f64> {
        match self {
            Motion::PartInHand(run) => run.shift,
            Motion::OverTable(run) => run.shift,
        }
    }

    /// What may not be: that something touches, bounds that do not hold, and what is laid off the path.
    pub fn failed_checks(&self) -> Vec<String> {
        let kinds = [
            (FaultKind::Collision, "steps from knot to knot are not proven free"),
            (FaultKind::Bounds, "limits of joints do not hold"),
            (FaultKind::Astray, "steps leave the way between two waypoints"),
        ];
        let counted = kinds.map(|(kind, what)| (self.figures().count(kind), what));
        let failed = counted.into_iter().filter(|(count, _)| *count > 0);
        failed.map(|(count, what)| format!("{count} {what}, see motion-faults.csv")).collect()
    }
}

/// Plans the whole print on the cell that is wanted.
pub fn run(
    args: &MotionArgs,
    field: &FieldRun,
    surfaces: &SurfacesRun,
    machine: &MachineRun,
    bars: &Bars,
) -> Result<Motion, Failure> {
    if args.cell8 {
        Ok(Motion::OverTable(Box::new(plan(field, surfaces, machine, bars)?)))
    } else {
        Ok(Motion::PartInHand(Box::new(plan(field, surfaces, machine, bars)?)))
    }
}

/// The arm's own stops and speeds; accelerations and jerks for transfers, which nothing else fixes.
fn bounds<const N: usize, const F: usize>(robot: &impl Printer<N, F>) -> Bounds<N> {
    Bounds { acceleration: [f64::INFINITY; N], jerk: [f64::INFINITY; N], ..robot.bounds(true) }
}

/// A waypoint over what carries the part.
fn placed(waypoint: &curvlay_toolpath::surface::Waypoint, shift: &Vector3<f64>) -> Waypoint {
    Waypoint { position: waypoint.tip - shift, axis: waypoint.direction }
}
