//! The motions along one path.

use super::workcell::Workcell;
use super::{Run, bounds, placed, robot};
use crate::failure;
use curvlay_examples::args::Failure;
use curvlay_examples::motion::{PartInHand, Placed};
use curvlay_kinematics::Waypoint;
use curvlay_toolpath::surface::ToolPath;
use curvlay_trajectory::{
    Bounds, FEWEST_WAYPOINTS, FreeRange, GlobalMotion, GlobalOptions, LadderOptions, Posture, Robot, RunIn, Rung,
    Timeline, Trajectory, plan_ladder, smooth_globally,
};
use nalgebra::{UnitVector3, Vector3};
use std::f64::consts::TAU;
use std::ops::{ControlFlow, Range};

/// Tool angles tried before a waypoint counts as out of reach, and samples of the ladder to begin with.
const ANGLES: u32 = 24;

/// Rounds of the filter, and seconds of each piece of run-in and run-out. Longer runs are gentler, but their tip leaves
/// the path: by a millimetre at 10 mm/s. Where the motion touches something, less of both is tried.
const ATTEMPTS: [(usize, f64); 3] = [(40, 0.05), (6, 0.02), (2, 0.01)];

/// Waypoints nearer in time than this, in seconds, are one: a controller's cycle is longer.
const LEAST_STEP_S: f64 = 1e-3;

/// A robot without the postures at which something touches (section 3.5.3).
struct Guarded<'a> {
    robot: &'a PartInHand,
    cell: &'a Workcell<'a>,
}

impl Robot<6, 1> for Guarded<'_> {
    fn waypoints(&self) -> usize {
        self.robot.waypoints()
    }

    fn free(&self) -> [FreeRange; 1] {
        self.robot.free()
    }

    fn solutions(&self, waypoint: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 6])) {
        self.robot.solutions(waypoint, free, &mut |branch, joints| {
            if self.cell.may_print(&joints) {
                each(branch, joints);
            }
        });
    }

    fn posture(&self, waypoint: usize, free: &[f64; 1], branch: u32) -> Option<Posture<6, 1>> {
        self.robot.posture(waypoint, free, branch)
    }
}

/// What came of a path.
#[derive(Default)]
pub struct Planned {
    pub runs: Vec<Run>,
    pub unreachable: usize,
    pub blocked: usize,
    pub breaks: usize,
    pub bounds_missed: usize,
    pub missed_mm: f64,
}

/// Plans one path, given the seconds from waypoint to waypoint.
pub fn plan(
    number: usize,
    path: &ToolPath,
    seconds: &[f64],
    shift: &Vector3<f64>,
    cell: &Workcell,
) -> Result<Planned, Failure> {
    let mut waypoints = vec![placed(&path.waypoints[0], shift)];
    let mut times = vec![0.0];
    let mut now = 0.0;
    for (waypoint, step) in path.waypoints[1..].iter().zip(seconds) {
        now += step;
        if now - times[times.len() - 1] >= LEAST_STEP_S {
            waypoints.push(placed(waypoint, shift));
            times.push(now);
        }
    }
    let all = robot(waypoints)?;
    let bounds = bounds(&all);
    let mut planned = Planned::default();
    let guarded = Guarded { robot: &all, cell };
    let free = |waypoint: usize| is_reachable(&guarded, &bounds, waypoint);
    let reach: Vec<bool> = (0..all.waypoints()).map(free).collect();
    let far = |waypoint: &usize| !is_reachable(&all, &bounds, *waypoint);
    let without: Vec<usize> = (0..reach.len()).filter(|&waypoint| !reach[waypoint]).collect();
    planned.unreachable = without.iter().filter(|waypoint| far(waypoint)).count();
    planned.blocked = without.len() - planned.unreachable;
    for stretch in stretches(&reach) {
        let (part, times) = long_enough(&all.part(stretch.clone()), &times[stretch]);
        let options = LadderOptions { samples: [ANGLES], doublings: 4, breaks: true, ..LadderOptions::default() };
        let go_on = |_| ControlFlow::Continue(());
        let guarded = Guarded { robot: &part, cell };
        let ladder = plan_ladder(&guarded, &times, &bounds, &options, &go_on).map_err(failure)?;
        planned.breaks += ladder.breaks.len();
        for run in ladder.runs() {
            let (trajectory, rungs, holds) =
                smooth(&part.part(run.clone()), &times[run.clone()], &ladder.rungs[run.clone()], &bounds, cell)?;
            planned.bounds_missed += usize::from(!holds);
            let missed = |(k, rung): (usize, &Rung<6, 1>)| part.missed(run.start + k, &rung.joints).0;
            planned.missed_mm = rungs.iter().enumerate().map(missed).fold(planned.missed_mm, f64::max);
            let end = |k: usize| (rungs[k].free[0], part.at(run.start + k));
            planned.runs.push(Run {
                path: number,
                layer: path.layer,
                ends: [end(0), end(rungs.len() - 1)],
                trajectory,
            });
        }
    }
    Ok(planned)
}

fn is_reachable(robot: &impl Robot<6, 1>, bounds: &Bounds<6>, waypoint: usize) -> bool {
    (0..ANGLES).any(|sample| {
        let mut found = false;
        robot.solutions(waypoint, &[TAU * f64::from(sample) / f64::from(ANGLES)], &mut |_, joints| {
            found |= (0..6).all(|j| bounds.lower[j] <= joints[j] && joints[j] <= bounds.upper[j]);
        });
        found
    })
}

/// The longest ranges of waypoints in reach.
fn stretches(reach: &[bool]) -> Vec<Range<usize>> {
    let mut start = 0;
    reach
        .chunk_by(|a, b| a == b)
        .filter_map(|same| {
            let range = start..start + same.len();
            start = range.end;
            same[0].then_some(range)
        })
        .collect()
}

/// Splits the longest steps until there are as many waypoints as a motion needs. A single waypoint is held for a moment.
fn long_enough(robot: &PartInHand, times: &[f64]) -> (PartInHand, Vec<f64>) {
    let mut waypoints: Vec<Waypoint> = (0..robot.waypoints()).map(|k| robot.at(k)).collect();
    let mut times = times.to_vec();
    if waypoints.len() == 1 {
        waypoints.push(waypoints[0]);
        times.push(times[0] + 1.0);
    }
    while waypoints.len() < FEWEST_WAYPOINTS {
        let step = |k: &usize| times[k + 1] - times[*k];
        let longest = (0..times.len() - 1).max_by(|a, b| step(a).total_cmp(&step(b))).unwrap_or(0);
        let [a, b] = [waypoints[longest], waypoints[longest + 1]];
        let axis = UnitVector3::try_new(a.axis.into_inner() + b.axis.into_inner(), 1e-9).unwrap_or(a.axis);
        waypoints.insert(longest + 1, Waypoint { position: nalgebra::center(&a.position, &b.position), axis });
        times.insert(longest + 1, (times[longest] + times[longest + 1]) / 2.0);
    }
    (robot.with(waypoints), times)
}

/// The motion of least jerk along a run, its rungs, and whether the bounds hold everywhere. Where that motion would
/// touch something a less smooth one is taken, in the end what the ladder found, as for runs too short for a filter.
fn smooth(
    part: &PartInHand,
    times: &[f64],
    rungs: &[Rung<6, 1>],
    bounds: &Bounds<6>,
    cell: &Workcell,
) -> Result<(Trajectory<6>, Vec<Rung<6, 1>>, bool), Failure> {
    let attempts = ATTEMPTS.iter().filter(|_| rungs.len() >= FEWEST_WAYPOINTS);
    for &(rounds, spacing) in attempts {
        let line = Timeline::new(times, RunIn { spacing, ..RunIn::default() }).map_err(failure)?;
        let options = GlobalOptions { lower_peak: false, rounds, ..GlobalOptions::default() };
        let found = smooth_globally(part, &line, rungs, bounds, &options, &|_| ControlFlow::Continue(()));
        let Ok(GlobalMotion { rungs, trajectory, violations, .. }) = found else { break };
        if cell.may_move(&trajectory) {
            return Ok((trajectory, rungs, violations.is_empty()));
        }
    }
    let [.., (_, spacing)] = ATTEMPTS;
    let line = Timeline::new(times, RunIn { spacing, ..RunIn::default() }).map_err(failure)?;
    let joints: Vec<[f64; 6]> = rungs.iter().map(|rung| rung.joints).collect();
    let trajectory = Trajectory::through(&line, &joints).map_err(failure)?;
    let holds = trajectory.violations(bounds, 1e-6).is_empty();
    Ok((trajectory, rungs.to_vec(), holds))
}
