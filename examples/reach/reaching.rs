//! Sampling, placing, and what the placed nozzle is worth.

use super::Args;
use super::arms::ArmName;
use super::standing::{self, CELLS, Stood, Worth};
use super::tried::{ALONG, TOOL_ANGLES, part};
use clap::ValueEnum;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::count::counted;
use curvlay_examples::findings::{Findings, Severity};
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_kinematics::workcell::WorkcellModel;
use curvlay_kinematics::{
    Arm, POSITION_TOLERANCE, Placement, ReachOptions, fullest_box, nozzle_frame, reachable_points,
};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// What an arm reaches, and its nozzle.
pub struct Reached {
    pub name: ArmName,
    pub points: Vec<Point3<f64>>,
    /// The dissertation's: the box with the most frames, and what its middle is worth.
    pub placement: Placement,
    pub box_worth: Worth,
    /// Where the nozzle stands by the search.
    pub stood: Stood,
    /// Waypoints of an upright part, and how many of them the arm brings under that nozzle, free or not.
    pub waypoints: usize,
    pub waypoints_reached: usize,
    /// The arm at the first of them that it reaches.
    pub posture: Option<[f64; 6]>,
    /// Configurations at these, and the largest distance between nozzle and waypoint.
    pub configurations: usize,
    pub worst_mm: f64,
    /// Frames in the box, counted anew.
    pub recounted: usize,
    pub time: Duration,
}

impl Reached {
    /// Whether our checks hold: the count of the box, and Eq. 2.3 at every configuration.
    pub fn is_ok(&self) -> bool {
        self.recounted == self.placement.frames && self.worst_mm <= 2.0 * POSITION_TOLERANCE
    }
}

/// A workcell that we ship.
pub struct Cell {
    /// As keys of the summary begin.
    pub key: &'static str,
    pub name: String,
    pub stood: Stood,
}

/// All arms and all cells.
pub struct Found {
    pub arms: Vec<Reached>,
    pub cells: Vec<Cell>,
    pub findings: Findings,
}

/// What of it is wrong.
fn findings(arms: &[Reached], cells: &[Cell]) -> Findings {
    let mut findings = Findings::default();
    for arm in arms.iter().filter(|arm| !arm.is_ok()) {
        let amount = format!(
            "{} in the box of {}, {:e} mm",
            counted(arm.recounted, "frame"),
            arm.placement.frames,
            arm.worst_mm
        );
        findings.add(
            Severity::Failed,
            format!("{}: a second count differs, or a nozzle missed its waypoint", arm.name.title()),
            amount,
            "",
        );
    }
    for arm in arms.iter().filter(|arm| arm.stood.best.free < arm.waypoints) {
        let amount = format!("{} of {} at the best place", arm.waypoints - arm.stood.best.free, arm.waypoints);
        findings
            .explain(
                Severity::Warning,
                format!("{}: waypoints of the part have no free posture", arm.name.title()),
                amount,
                "",
            )
            .cause("part, plate and links are in the way of each other, or the part is too large for the arm")
            .try_to("a smaller --box")
            .try_to("another --platform");
    }
    for cell in cells {
        // On stdout and in the report a line each: what it would gain, and why it stays.
        let is_best = cell.stood.now.is_none_or(|now| now.free >= cell.stood.best.free);
        let severity = if is_best { Severity::Note } else { Severity::Warning };
        findings.add(severity, cell.name.clone(), cell.stood.verdict().unwrap_or_default(), "");
    }
    findings
}

/// Whether a point lies in the box around the nozzle; the box was moved to its middle, so its faces are blurred by
/// rounding.
pub fn is_in_box(point: &Point3<f64>, placement: &Placement, edge: f64) -> bool {
    (0..3).all(|axis| (point[axis] - placement.centre[axis]).abs() <= 0.5 * edge + 1e-9)
}

/// All arms and cells, on the threads that are asked for.
pub fn run(args: &Args, bars: &Bars) -> Result<Found, Failure> {
    let names = ArmName::value_variants();
    let total = names.len() + CELLS.len();
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        let mut own = Vec::new();
        loop {
            let job = next.fetch_add(1, Ordering::Relaxed);
            let result = match names.get(job) {
                Some(&name) => reach(name, args).map(Job::Arm),
                None => match CELLS.get(job - names.len()) {
                    Some((key, text)) => shipped(key, text, args).map(Job::Cell),
                    None => return own,
                },
            };
            own.push((job, result));
            bars.update("arms and cells", done.fetch_add(1, Ordering::Relaxed) as u64 + 1, total as u64);
        }
    };
    bars.update("arms and cells", 0, total as u64);
    let mut all: Vec<(usize, Result<Job, Failure>)> = thread::scope(|scope| {
        let threads: Vec<_> = (0..args.common.threads.min(total)).map(|_| scope.spawn(work)).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("no arm panics")).collect()
    });
    all.sort_by_key(|&(place, _)| place);
    let (mut arms, mut cells) = (vec![], vec![]);
    for (_, job) in all {
        match job? {
            Job::Arm(arm) => arms.push(arm),
            Job::Cell(cell) => cells.push(cell),
        }
    }
    let findings = findings(&arms, &cells);
    Ok(Found { arms, cells, findings })
}

enum Job {
    Arm(Reached),
    Cell(Cell),
}

fn shipped(key: &'static str, text: &str, args: &Args) -> Result<Cell, Failure> {
    let model = WorkcellModel::from_json(text.as_bytes())?;
    let stood = standing::search(&model, true, args)?;
    Ok(Cell { key, name: model.name, stood })
}

fn reach(name: ArmName, args: &Args) -> Result<Reached, Failure> {
    let start = Instant::now();
    let arm = Arm::new(name.model())?;
    let flange_part = Isometry3::translation(0.0, 0.0, args.platform_mm);
    let options = ReachOptions { samples: args.samples as usize, ..ReachOptions::default() };
    // The arm stands on the floor, and the nozzle in front of it.
    let usable = |_: &[f64; 6], frame: &Isometry3<f64>| {
        let at = frame.translation.vector;
        at.z >= 0.0 && at.x >= args.front_mm
    };
    let points = reachable_points(&arm, &flange_part, &options, usable)?;
    let placement = fullest_box(&points, [args.box_mm; 3], &|_| ControlFlow::Continue(()))?;
    let bare = standing::bare_cell(name.in_files(), args.platform_mm);
    let stood = standing::search(&bare, false, args)?;
    let box_worth = standing::worth(&bare, placement.centre, args)?;
    let time = start.elapsed();

    let nozzle = nozzle_frame(&stood.best.place, &-Vector3::z_axis());
    let cell = curvlay_kinematics::Setup::part_in_hand(arm, flange_part, nozzle)?;
    let (mut waypoints_reached, mut configurations, mut worst_mm) = (0, 0, 0.0f64);
    let mut posture = None;
    let waypoints = part(0.5 * args.box_mm, ALONG);
    for waypoint in &waypoints {
        let before = configurations;
        for found in cell.configurations(waypoint, TOOL_ANGLES as usize) {
            let frames = cell.frames(&found.joints, waypoint, found.tool_angle);
            let apart = frames.deposition.translation.vector - frames.nozzle.translation.vector;
            worst_mm = worst_mm.max(apart.norm());
            configurations += 1;
            posture.get_or_insert(found.joints);
        }
        waypoints_reached += usize::from(configurations > before);
    }
    let recounted = points.iter().filter(|point| is_in_box(point, &placement, args.box_mm)).count();
    let waypoints = waypoints.len();
    Ok(Reached {
        name,
        points,
        placement,
        box_worth,
        stood,
        waypoints,
        waypoints_reached,
        posture,
        configurations,
        worst_mm,
        recounted,
        time,
    })
}
