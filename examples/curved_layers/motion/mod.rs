//! Stage `motion`: joint trajectories of a UR3 that holds the part under a standing nozzle, for the whole print.
//!
//! C. Dai 2020, sections 2.5, 3.5.3 and 4.3. Every path is split where waypoints are out of reach and where the joints
//! cannot keep up with the feed; each run gets the motion of least jerk (`run`). Then every motion and the transfers in
//! between are checked against the cell, with the part as it is built by then (`workcell`).

mod run;
mod workcell;

use crate::failure;
use crate::field::FieldRun;
use crate::machine::MachineRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::PartInHand;
use curvlay_kinematics::Waypoint;
use curvlay_toolpath::surface::MoveKind;
use curvlay_trajectory::transfer::Transfer;
use curvlay_trajectory::{Bounds, Trajectory};
use nalgebra::Vector3;
use rayon::prelude::*;
use std::time::{Duration, Instant};
use workcell::Workcell;

/// What came of the stage.
pub struct MotionRun {
    /// In the order in which they are travelled.
    pub runs: Vec<Run>,
    /// From the end of each run to the start of the next; `None` where no way was found.
    pub transfers: Vec<Option<Transfer<6>>>,
    /// Waypoints that no tool angle reaches.
    pub unreachable: usize,
    /// Waypoints in reach at which something touches at every tool angle.
    pub blocked: usize,
    /// Where a path breaks off although the next waypoint is in reach: the joints are too slow for the feed.
    pub breaks: usize,
    /// Motions between waypoints that are not proven free.
    pub collisions: usize,
    /// What collides most often, in words.
    pub worst: Option<String>,
    /// How far from its waypoint a nozzle is at most.
    pub missed_mm: f64,
    /// Runs whose bounds do not hold everywhere.
    pub bounds_missed: usize,
    /// Places in the part frame, less this, are places over the flange.
    pub shift: Vector3<f64>,
    pub times: Times,
}

/// One unbroken motion along a path.
pub struct Run {
    /// The path, by its place in the list.
    pub path: usize,
    pub layer: u32,
    pub trajectory: Trajectory<6>,
    /// Tool angle and waypoint at both ends.
    ends: [(f64, Waypoint); 2],
}

/// How long the steps took on the clock.
#[derive(Clone, Copy, Default)]
pub struct Times {
    pub plan: Duration,
    pub check: Duration,
    pub transfers: Duration,
}

impl Run {
    /// Whether a time lies behind the last waypoint.
    pub fn is_after_print(&self, time: f64) -> bool {
        let times = self.trajectory.times();
        let behind = times.partition_point(|known| *known < 0.0) + self.trajectory.at_waypoints().len();
        times.get(behind).is_some_and(|first| time >= *first)
    }
}

impl MotionRun {
    /// Seconds that the robot moves.
    pub fn robot_s(&self) -> f64 {
        let span = |run: &Run| run.trajectory.span().1 - run.trajectory.span().0;
        let transfers = self.transfers.iter().flatten().map(Transfer::duration);
        self.runs.iter().map(span).sum::<f64>() + transfers.sum::<f64>()
    }

    pub fn plan_s(&self) -> f64 {
        (self.times.plan + self.times.check + self.times.transfers).as_secs_f64()
    }

    pub fn without_transfer(&self) -> usize {
        self.transfers.iter().filter(|transfer| transfer.is_none()).count()
    }
}

/// Plans the whole print.
pub fn run(field: &FieldRun, surfaces: &SurfacesRun, machine: &MachineRun, bars: &Bars) -> Result<MotionRun, Failure> {
    let paths = &machine.freed.paths;
    let tips = || paths.iter().flat_map(|path| &path.waypoints).map(|waypoint| waypoint.tip);
    let mean = tips().map(|tip| tip.coords).sum::<Vector3<f64>>() / tips().count().max(1) as f64;
    // The plate stays where it is: z = 0 stands on the flange.
    let shift = Vector3::new(mean.x, mean.y, 0.0);

    let start = Instant::now();
    bars.update("plan motions", 0, 1);
    let steps = seconds_of(machine);
    let mut cell = Workcell::new(field, surfaces, &shift)?;
    let of_path = |(path, seconds): (usize, &Vec<f64>)| run::plan(path, &paths[path], seconds, &shift, &cell);
    let planned: Vec<run::Planned> = steps.par_iter().enumerate().map(of_path).collect::<Result<_, _>>()?;
    let mut times = Times { plan: start.elapsed(), ..Times::default() };

    let [unreachable, blocked, breaks, bounds_missed] = [
        planned.iter().map(|path| path.unreachable).sum(),
        planned.iter().map(|path| path.blocked).sum(),
        planned.iter().map(|path| path.breaks).sum(),
        planned.iter().map(|path| path.bounds_missed).sum(),
    ];
    let missed_mm = planned.iter().map(|path| path.missed_mm).fold(0.0, f64::max);
    let runs: Vec<Run> = planned.into_iter().flat_map(|path| path.runs).collect();
    let mut motion = MotionRun {
        runs,
        transfers: Vec::new(),
        unreachable,
        blocked,
        breaks,
        collisions: 0,
        worst: None,
        missed_mm,
        bounds_missed,
        shift,
        times,
    };

    // Layer by layer, since the part grows.
    let mut first = 0;
    let mut reports: Vec<String> = Vec::new();
    for layer in motion.runs.chunk_by(|a, b| a.layer == b.layer) {
        bars.update("check motions", first as u64, motion.runs.len() as u64);
        cell.build_up_to(layer[0].layer)?;
        let checking = Instant::now();
        let found: Vec<Vec<String>> = layer.par_iter().map(|run| cell.collisions(&run.trajectory)).collect();
        reports.extend(found.into_iter().flatten());
        times.check += checking.elapsed();
        let moving = Instant::now();
        // From each run of the layer to the next one, which may be the first of the next layer.
        let next = |k: usize| motion.runs.get(first + k + 1);
        let transfer = |k: usize| next(k).map(|to| cell.transfer(first + k, &layer[k], to));
        motion.transfers.par_extend((0..layer.len()).into_par_iter().filter_map(transfer));
        times.transfers += moving.elapsed();
        first += layer.len();
    }
    motion.collisions = reports.len();
    reports.sort_unstable();
    motion.worst = reports.chunk_by(|a, b| a == b).max_by_key(|same| same.len()).map(|same| same[0].clone());
    motion.times = times;
    Ok(motion)
}

/// For each path the seconds from waypoint to waypoint, as the plan of the deposition has them.
fn seconds_of(machine: &MachineRun) -> Vec<Vec<f64>> {
    let mut seconds = vec![Vec::new(); machine.freed.paths.len()];
    for step in machine.deposition.moves.iter().filter(|step| step.kind == MoveKind::Print) {
        seconds[step.path].push(step.seconds);
    }
    seconds
}

/// The arm's own stops and speeds; accelerations and jerks for transfers, which nothing else fixes.
fn bounds(robot: &PartInHand) -> Bounds<6> {
    use curvlay_examples::motion::Placed;
    Bounds { acceleration: [f64::INFINITY; 6], jerk: [f64::INFINITY; 6], ..robot.bounds(true) }
}

/// A waypoint over the flange.
fn placed(waypoint: &curvlay_toolpath::surface::Waypoint, shift: &Vector3<f64>) -> Waypoint {
    Waypoint { position: waypoint.tip - shift, axis: waypoint.direction }
}

fn robot(waypoints: Vec<Waypoint>) -> Result<PartInHand, Failure> {
    PartInHand::new(waypoints).map_err(failure)
}
