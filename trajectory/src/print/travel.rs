//! From the end of one run to the start of the next: the nozzle lifts off along its own direction, a transfer leads over, and
//! the nozzle comes down along its direction there.
//!
//! A nozzle that moves back along its direction stays within the place that it had, since its block reaches up without end:
//! lifting off gouges nothing that the end of the path did not. Only where links of the arm are in the way another
//! direction is tried; then the nozzle is looked at on all of it.

use super::options::TipSpeed;
use super::plan::{Arrival, Departure, Run, Travel};
use super::run_plan::Task;
use super::workcell::{Moment, PrintRobot, PrintWorkcell, Waypoint};
use crate::transfer::{Transfer, TransferError, TransferOptions, plan_transfer};
use crate::{Bounds, TimePathOptions, Trajectory, time_path};
use nalgebra::Vector3;

/// How far the nozzle lifts off before a transfer, in millimetres, the least first; and where not even that is free.
const LIFTS_MM: [f64; 5] = [5.0, 10.0, 20.0, 40.0, 80.0];
const MIN_LIFT_MM: f64 = 2.5;

/// Postures on the way are so far apart, in millimetres, so that the nozzle goes straight; and how fast it goes at most.
const LIFT_STEP_MM: f64 = 1.0;
const LIFT_MM_S: f64 = 80.0;

/// No joint goes farther than this from one of them to the next, in radians: beyond it the arm turns over.
const LIFT_STEP_RAD: f64 = 0.2;

/// What stands for no limit of acceleration and of jerk on transfers, in rad/s2 and rad/s3: far above what arms do.
const NO_ACCELERATION: f64 = 1e3;
const NO_JERK: f64 = 1e6;

/// How a transfer is looked for, one way after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Search {
    /// From near by, from far off, and both again, longer, with the tool turned about the nozzle, which takes links of the arm
    /// out of the way.
    Short,
    /// With much shorter edges, for ends that are nearly shut in; then much longer.
    Long,
}

const EFFORTS: [Effort; 6] = {
    let near = Effort { far: false, turns: &[0.0], iterations: 500, step: 0.5 };
    let turned = Effort { turns: &[0.25, -0.25, 0.5, -0.5, 1.0, -1.0], iterations: 5000, step: 0.25, ..near };
    let tight = Effort { step: 0.06, iterations: 20_000, ..turned };
    let long = Effort { far: true, iterations: 60_000, step: 0.5, ..turned };
    [near, Effort { far: true, ..near }, turned, Effort { far: true, ..turned }, tight, long]
};

impl Search {
    fn efforts(self) -> &'static [Effort] {
        let (short, long) = EFFORTS.split_at(4);
        match self {
            Search::Short => short,
            Search::Long => long,
        }
    }
}

#[derive(Clone, Copy)]
struct Effort {
    /// Whether the farthest of the lifts is wanted that are free, not the nearest.
    far: bool,
    /// Radians, the first that is free.
    turns: &'static [f64],
    /// Random postures, and the longest edge in radians.
    iterations: usize,
    step: f64,
}

/// Layers are counted from 1 in words.
fn shown(layer: u32) -> u64 {
    u64::from(layer) + 1
}

/// A way from the end of one run to the start of the next, or why there is none.
pub(super) fn travel<const N: usize, const F: usize, R: PrintRobot<N, F>, C: PrintWorkcell<N>>(
    number: usize,
    [from, to]: [&Run<N, F>; 2],
    task: &Task<'_, N, F, R>,
    workcell: &C,
    search: Search,
) -> Result<Travel<N>, String> {
    let (before, after) = (from.trajectory.joints(), to.trajectory.joints());
    let (start, goal) = (before[before.len() - 1], after[0]);
    let name = format!(
        "from path {} of layer {} to path {} of layer {}",
        from.path,
        shown(from.layer),
        to.path,
        shown(to.layer)
    );
    // The next path is not begun while the nozzle comes down.
    let moment = Moment::After { path: from.path };
    let mut why = String::new();
    let mut tried = Vec::new();
    for effort in search.efforts() {
        if (task.stopped)() {
            break;
        }
        let lifted = [(&from.ends[1], &start), (&to.ends[0], &goal)]
            .map(|(end, at)| lift(task.robot, workcell, moment, end, at, effort));
        let [Some(up), Some(mut down)] = lifted else {
            let what = if lifted[0].is_none() { "lift off" } else { "come down" };
            why = format!("transfer {name}: the nozzle cannot {what}");
            continue;
        };
        let ends = [up[up.len() - 1], down[down.len() - 1]];
        if tried.contains(&(ends, effort.iterations)) {
            continue;
        }
        tried.push((ends, effort.iterations));
        down.reverse();
        match way(&task.limits.bounds, workcell, &name, number, &ends, effort) {
            Ok(way) => {
                let way = unhurried(&way, highest([from, to]), task)?;
                let [lift, approach] =
                    [up, down].map(|postures| timed(&postures, &task.limits.bounds, &task.options.timing));
                return Ok(Travel { lift: lift?, way, approach: approach? });
            }
            Err(error) => why = error,
        }
    }
    Err(why)
}

/// A way from the home posture to the start of a run, or why there is none. `moment` is what stands when the nozzle comes down.
pub(super) fn arrive<const N: usize, const F: usize, R: PrintRobot<N, F>, C: PrintWorkcell<N>>(
    number: usize,
    home: &[f64; N],
    (run, moment): (&Run<N, F>, Moment),
    task: &Task<'_, N, F, R>,
    workcell: &C,
) -> Result<Arrival<N>, String> {
    let name = format!("from home to path {} of layer {}", run.path, shown(run.layer));
    let start = run.trajectory.joints()[0];
    let (way, mut down) = homeward(&name, number, (home, true), (&run.ends[0], &start, moment), task, workcell)?;
    down.reverse();
    Ok(Arrival { way, approach: timed(&down, &task.limits.bounds, &task.options.timing)? })
}

/// A way from the end of a run to the home posture, or why there is none.
pub(super) fn depart<const N: usize, const F: usize, R: PrintRobot<N, F>, C: PrintWorkcell<N>>(
    number: usize,
    run: &Run<N, F>,
    home: &[f64; N],
    task: &Task<'_, N, F, R>,
    workcell: &C,
) -> Result<Departure<N>, String> {
    let name = format!("from path {} of layer {} home", run.path, shown(run.layer));
    let joints = run.trajectory.joints();
    let (end, moment) = (joints[joints.len() - 1], Moment::After { path: run.path });
    let (way, up) = homeward(&name, number, (home, false), (&run.ends[1], &end, moment), task, workcell)?;
    Ok(Departure { lift: timed(&up, &task.limits.bounds, &task.options.timing)?, way })
}

/// Where the nozzle is after the longest free lift off the end of a run; `None` where no lift is free.
pub(super) fn lifted<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    run: &Run<N, F>,
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> Option<[f64; N]> {
    let joints = run.trajectory.joints();
    let (end, moment) = (&joints[joints.len() - 1], Moment::After { path: run.path });
    let far = EFFORTS.iter().filter(|effort| effort.far);
    let up = far.filter_map(|effort| lift(task.robot, workcell, moment, &run.ends[1], end, effort)).next()?;
    up.last().copied()
}

/// Whether a short search finds a way from one posture to another.
pub(super) fn has_way<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    number: usize,
    ends: &[[f64; N]; 2],
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> bool {
    let found = |effort: &Effort| way(&task.limits.bounds, workcell, "home", number, ends, effort).is_ok();
    [EFFORTS[0], EFFORTS[2]].iter().any(|effort| !(task.stopped)() && found(effort))
}

/// A transfer between home and a posture above an end of a run, and the postures of the lift from that end.
fn homeward<const N: usize, const F: usize, R: PrintRobot<N, F>, C: PrintWorkcell<N>>(
    name: &str,
    number: usize,
    (home, comes): (&[f64; N], bool),
    (end, at, moment): (&([f64; F], Waypoint), &[f64; N], Moment),
    task: &Task<'_, N, F, R>,
    workcell: &C,
) -> Result<(Transfer<N>, Vec<[f64; N]>), String> {
    let mut why = format!("transfer {name}: the search was stopped");
    for effort in Search::Short.efforts().iter().chain(Search::Long.efforts()) {
        if (task.stopped)() {
            break;
        }
        let Some(up) = lift(task.robot, workcell, moment, end, at, effort) else {
            why = format!("transfer {name}: the nozzle cannot {}", if comes { "come down" } else { "lift off" });
            continue;
        };
        let above = up[up.len() - 1];
        let ends = if comes { [*home, above] } else { [above, *home] };
        match way(&task.limits.bounds, workcell, name, number, &ends, effort) {
            Ok(way) => return Ok((unhurried(&way, end.1.position.z, task)?, up)),
            Err(error) => why = error,
        }
    }
    Err(why)
}

/// Postures from the end of a run to a free one above it: along the nozzle, else half upright, else upright.
fn lift<const N: usize, const F: usize>(
    robot: &impl PrintRobot<N, F>,
    workcell: &impl PrintWorkcell<N>,
    moment: Moment,
    (free, waypoint): &([f64; F], Waypoint),
    end: &[f64; N],
    effort: &Effort,
) -> Option<Vec<[f64; N]>> {
    let (axis, up) = (waypoint.axis.into_inner(), Vector3::z());
    // Straight down there is no half way.
    let ways = [axis, axis + up, up].into_iter().filter(|way| way.norm() > 1e-3);
    let mut lifts = LIFTS_MM;
    if effort.far {
        lifts.reverse();
    }
    let along = |turn: f64, way: &Vector3<f64>, height: f64| {
        let steps = (height / LIFT_STEP_MM).ceil();
        let place = |share: f64| {
            let position = waypoint.position + way.normalize() * (height * share);
            Waypoint { position, ..*waypoint }
        };
        let mut postures = vec![*end];
        for step in 1..=steps as u32 {
            let (share, last) = (f64::from(step) / steps, postures[postures.len() - 1]);
            let joints = robot.continued(&place(share), free, turn * share, &last)?;
            let farthest = (0..N).map(|j| (joints[j] - last[j]).abs()).fold(0.0, f64::max);
            if farthest > LIFT_STEP_RAD {
                return None;
            }
            postures.push(joints);
        }
        let is_along_nozzle = way == &axis;
        let gouges_nothing = || !(1..=steps as u32).any(|k| workcell.is_gouging(moment, &place(f64::from(k) / steps)));
        let is_free = workcell.posture_free(postures.last()?)
            && (is_along_nozzle || gouges_nothing())
            && postures.windows(2).all(|pair| workcell.touches(&line(&pair[0], &pair[1])).is_none());
        is_free.then_some(postures)
    };
    let first = |turn: f64| {
        ways.clone().find_map(|way| lifts.iter().chain([&MIN_LIFT_MM]).find_map(|&height| along(turn, &way, height)))
    };
    effort.turns.iter().find_map(|&turn| first(turn))
}

/// The control polygon of a straight motion.
fn line<const N: usize>(from: &[f64; N], to: &[f64; N]) -> [[f64; N]; 4] {
    [0.0, 1.0, 2.0, 3.0].map(|k| std::array::from_fn(|j| from[j] + (to[j] - from[j]) * (k / 3.0)))
}

/// A transfer between two free postures.
fn way<const N: usize>(
    bounds: &Bounds<N>,
    workcell: &impl PrintWorkcell<N>,
    name: &str,
    number: usize,
    [above, before]: &[[f64; N]; 2],
    effort: &Effort,
) -> Result<Transfer<N>, String> {
    let Effort { iterations, step, .. } = *effort;
    let options =
        TransferOptions { seed: number as u64 + 1, iterations, step, shortcuts: 30, ..TransferOptions::default() };
    let planned = plan_transfer(name, above, before, &finite(bounds), workcell, &options)
        .map_err(|error: TransferError| error.to_string())?;
    let why = planned.to_string();
    planned.found().ok_or(why)
}

/// Looks along a line of a transfer, how fast the tip goes; and what the steps between them leave of its speed, as chords are shorter
/// than the way.
const TIP_LOOKS: u32 = 32;
const CHORD: f64 = 0.99;

/// The height of the ends of two runs that a travel joins.
fn highest<const N: usize, const F: usize>([from, to]: [&Run<N, F>; 2]) -> f64 {
    from.ends[1].1.position.z.max(to.ends[0].1.position.z)
}

/// The same way with the tip no faster over the part than [`TipSpeed`] says.
fn unhurried<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    way: &Transfer<N>,
    highest_mm: f64,
    task: &Task<'_, N, F, R>,
) -> Result<Transfer<N>, String> {
    let TipSpeed { near_mm_s, far_mm_s, near_mm } = task.options.tip_speed;
    let rate = |from: &[f64; N], to: &[f64; N]| {
        let tip = |look: u32| {
            let share = f64::from(look) / f64::from(TIP_LOOKS);
            let nozzle = task.robot.nozzle(&std::array::from_fn(|j| from[j] + (to[j] - from[j]) * share));
            nozzle.map(|nozzle| nozzle.translation.vector)
        };
        let tips: Vec<Vector3<f64>> = (0..=TIP_LOOKS).filter_map(tip).collect();
        let is_near = tips.iter().any(|tip| tip.z < highest_mm + near_mm);
        let limit = if is_near { near_mm_s.min(far_mm_s) } else { far_mm_s };
        let fastest = tips.windows(2).map(|pair| (pair[1] - pair[0]).norm()).fold(0.0, f64::max) * f64::from(TIP_LOOKS);
        if fastest > 0.0 { CHORD * limit / fastest } else { f64::INFINITY }
    };
    way.limited(&finite(&task.limits.bounds), rate).map_err(|error| error.to_string())
}

/// The bounds with some in place of none: a transfer has no fastest motion without.
fn finite<const N: usize>(bounds: &Bounds<N>) -> Bounds<N> {
    let (acceleration, jerk) =
        (bounds.acceleration.map(|a| a.min(NO_ACCELERATION)), bounds.jerk.map(|j| j.min(NO_JERK)));
    Bounds { acceleration, jerk, ..*bounds }
}

/// The fastest motion through the postures of a lift.
fn timed<const N: usize>(
    postures: &[[f64; N]],
    bounds: &Bounds<N>,
    timing: &TimePathOptions,
) -> Result<Trajectory<N>, String> {
    let times: Vec<f64> = (0..postures.len()).map(|k| k as f64 * LIFT_STEP_MM / LIFT_MM_S).collect();
    let max_pace = vec![1.0; postures.len() - 1];
    let found = time_path(postures, &times, &max_pace, None, bounds, timing, &|_| std::ops::ControlFlow::Continue(()));
    found.map(|found| found.trajectory).map_err(|error| error.to_string())
}
