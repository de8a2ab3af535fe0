//! A path planned by every method on one robot.

use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::{Studied, inside};
use curvlay_trajectory::print::{OnPath, path_deviations};
use curvlay_trajectory::{
    Bounds, FilterOptions, FilterStep, GlobalOptions, GlobalStep, LadderError, LadderNode, LadderOptions, LadderSearch,
    MIN_WAYPOINTS, Progress, Quantity, RunIn, Timeline, Trajectory, Violation, filter_locally, jerk_measure,
    plan_ladder, smooth_globally, waypoint_jerks,
};
use std::ops::{ControlFlow, Range};
use std::time::{Duration, Instant};

/// The methods, by the words of the summary.
pub const METHODS: [&str; 5] = ["ladder", "local", "global", FREED, "grid"];

/// The global filter within whatever the local filter reached where it passed its bounds: which of the two is better with
/// the same freedom. Only where the local filter breaks a bound on speed or acceleration.
pub const FREED: &str = "global_freed";

/// How far beyond a bound is broken, in shares of it.
const BEYOND: f64 = 1e-6;

/// How often a path through a few samples is refined: from 10 degrees to 2.5.
const REFINEMENTS: u32 = 2;

/// Waypoints on either side of a break for which lower bounds on the speed are reported. It lies where the rest is shortest, not at what
/// cannot be passed.
const ABOUT_BREAK: usize = 24;

/// A motion by one method.
#[derive(Clone, Debug)]
pub struct Planned<const N: usize> {
    pub method: &'static str,
    /// One a run; more than one where the path breaks off.
    pub trajectories: Vec<Trajectory<N>>,
    pub figures: Figures,
    /// How a filter went, on the run on which it took the most steps; empty for a method that is no filter.
    pub history: Vec<HistoryStep>,
}

/// A motion on its way.
#[derive(Clone, Debug, PartialEq)]
pub struct HistoryStep {
    /// What the filter lowers: J of the local one, the integral of the squared jerk of the global one.
    pub objective: f64,
    /// Greatest jerk: of each joint at the waypoints for the local filter, of all joints over its limit for the global one.
    pub jerk: Vec<f64>,
}

/// What is said of a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// Eq. 4.10, at the waypoints.
    pub j: f64,
    /// Integral of the squared jerk of the splines, from rest to rest.
    pub spline_jerk: f64,
    /// Greatest of each joint at the waypoints, by the central differences of Eq. 4.10: what the dissertation reports.
    pub waypoint_jerk: Vec<f64>,
    /// Greatest of each joint, everywhere on the spline.
    pub joint_jerk: Vec<f64>,
    pub velocity: f64,
    pub acceleration: f64,
    /// Initial path included.
    pub time: Duration,
    /// Unbroken motions.
    pub runs: usize,
    /// Where a motion breaks off within a piece of the path: the waypoints, counted over all pieces, at which it begins
    /// anew.
    pub breaks: Vec<usize>,
    /// How far joints are from their waypoints.
    pub missed_mm: f64,
    pub missed_rad: f64,
    /// How far the nozzle leaves the straight way between two waypoints.
    pub strayed_mm: f64,
    /// Bounds that do not hold everywhere.
    pub violations: Vec<Violation>,
    /// What the global filter proves of its last linearised problem: no lower greatest jerk over its bound.
    pub jerk_lower_bound: Option<f64>,
    /// Of the segments about breaks, by [`Studied::min_speed`]: every motion needs so many times a speed limit.
    pub speed_lower_bound: Option<f64>,
}

/// By how much a value is beyond its bound, as a share of the bound.
pub fn beyond(violation: &Violation) -> f64 {
    violation.value.abs() / violation.bound.abs() - 1.0
}

impl Figures {
    /// Greatest of all joints, everywhere on the spline.
    pub fn jerk(&self) -> f64 {
        self.joint_jerk.iter().copied().fold(0.0, f64::max)
    }

    /// Greatest of all joints at the waypoints, by Eq. 4.10.
    pub fn jerk_at_waypoints(&self) -> f64 {
        self.waypoint_jerk.iter().copied().fold(0.0, f64::max)
    }

    /// How many bounds on jerk, or on all else, do not hold, and the worst of them.
    pub fn broken(&self, on_jerk: bool) -> Option<(usize, &Violation)> {
        let broken = || self.violations.iter().filter(|broken| (broken.quantity == Quantity::Jerk) == on_jerk);
        Some((broken().count(), broken().max_by(|a, b| beyond(a).total_cmp(&beyond(b)))?))
    }
}

/// A motion in runs: the waypoints of each, one after the other, and the nodes.
#[derive(Clone)]
struct Motion<const N: usize, const F: usize> {
    nodes: Vec<LadderNode<N, F>>,
    runs: Vec<Range<usize>>,
    /// Whether speeds have called for more samples than the first.
    doubled: bool,
}

impl<const N: usize, const F: usize> Motion<N, F> {
    /// The splines through the nodes, one for each run, with the run-in and run-out of least jerk.
    fn splines(&self, times: &[f64]) -> Result<Vec<Trajectory<N>>, Failure> {
        let spline = |run: &Range<usize>| {
            let joints: Vec<[f64; N]> = self.nodes[run.clone()].iter().map(|node| node.joints).collect();
            let line = Timeline::new(&times[run.clone()], RunIn::default())?;
            Ok(Trajectory::through(&line, &joints)?)
        };
        self.runs.iter().map(spline).collect()
    }
}

/// How to plan.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a, const F: usize> {
    pub methods: &'a [&'static str],
    /// Samples of the grid, and how it is searched.
    pub grid: ([u32; F], LadderSearch),
    /// What the ladder does when it finds no path with four samples.
    pub finer: Finer<F>,
    pub makers_speeds: bool,
}

/// How a ladder goes on when its first samples are too few. Where there is no path at all, it breaks off.
#[derive(Clone, Copy, Debug)]
pub enum Finer<const F: usize> {
    /// All parameters doubled, so often at most.
    Doubled(u32),
    /// So many, with which speeds let the robot go from one to the next: several parameters doubled together are soon too
    /// many. The path found is refined.
    NearEnough([u32; F]),
}

/// Plans the pieces of a path: for each method one motion a piece; and what there is no motion for, in words. A method
/// without one on some piece is left out.
pub fn plan<const N: usize, const F: usize, R: Studied<N, F>>(
    robots: &[R],
    times: &[Vec<f64>],
    plan: &Plan<'_, F>,
    bars: &Bars,
) -> Result<(Vec<Planned<N>>, Vec<String>), Failure> {
    let (mut all, mut notes): (Vec<Planned<N>>, _) = (Vec::new(), Vec::new());
    let mut freed_any = false;
    let (samples, search) = plan.grid;
    let grid = LadderOptions { samples, search, doublings: 0, breaks: true, ..LadderOptions::default() };
    let mut waypoints = 0;
    for (number, (robot, times)) in robots.iter().zip(times).enumerate() {
        let mut piece = Piece::new(robot, times, plan, bars)?;
        for &method in plan.methods {
            let found = match method {
                "local" => piece.local()?,
                "global" => piece.global()?,
                FREED => {
                    let Some((found, is_freed)) = piece.freed()? else { continue };
                    freed_any |= is_freed;
                    found
                }
                "grid" => match piece.on_grid(&grid) {
                    Ok(found) => found,
                    // At whole degrees not every waypoint is in reach, and from coarse to fine not every path is found.
                    Err(error) => {
                        if notes.is_empty() {
                            notes.push(format!("no path on the grid: piece {number}: {error}"));
                        }
                        continue;
                    }
                },
                _ => Found::new(piece.ladder.clone(), piece.ladder_time),
            };
            let planned = piece.measured(method, found, waypoints)?;
            match all.iter_mut().find(|known| known.method == method) {
                Some(known) => known.append(planned),
                None => all.push(planned),
            }
        }
        waypoints += times.len();
    }
    all.retain(|planned| (planned.method != FREED || freed_any) && (planned.method != "grid" || notes.is_empty()));
    Ok((all, notes))
}

/// What a method finds on a piece.
struct Found<const N: usize, const F: usize> {
    motion: Motion<N, F>,
    /// That of what it starts from included.
    time: Duration,
    /// The splines, where they are not those through the waypoints alone.
    trajectories: Option<Vec<Trajectory<N>>>,
    lower_bound: Option<f64>,
    history: Vec<HistoryStep>,
}

impl<const N: usize, const F: usize> Found<N, F> {
    /// A motion that goes through its waypoints.
    fn new(motion: Motion<N, F>, time: Duration) -> Self {
        Found { motion, time, trajectories: None, lower_bound: None, history: Vec::new() }
    }
}

/// A piece of the path with what is planned for it: methods start from what others have found.
struct Piece<'a, const N: usize, const F: usize, R> {
    robot: &'a R,
    times: &'a [f64],
    bounds: Bounds<N>,
    bars: &'a Bars,
    ladder: Motion<N, F>,
    ladder_time: Duration,
    local: Option<(Motion<N, F>, Duration)>,
    global: Option<(Global<N, F>, Duration)>,
}

impl<'a, const N: usize, const F: usize, R: Studied<N, F>> Piece<'a, N, F, R> {
    /// A piece with its ladder, which every other method needs.
    fn new(robot: &'a R, times: &'a [f64], plan: &Plan<'_, F>, bars: &'a Bars) -> Result<Self, Failure> {
        let bounds = robot.bounds(plan.makers_speeds);
        let (ladder, ladder_time) = first_ladder(robot, times, &bounds, plan.finer, bars)?;
        Ok(Piece { robot, times, bounds, bars, ladder, ladder_time, local: None, global: None })
    }

    /// The ladder, filtered by Algorithm 6.
    fn local(&mut self) -> Result<Found<N, F>, Failure> {
        let started = Instant::now();
        let (motion, history) = smoothed(self.robot, self.times, &self.bounds, &self.ladder, self.bars)?;
        self.local = Some((motion.clone(), started.elapsed()));
        Ok(Found { history, ..Found::new(motion, self.ladder_time + started.elapsed()) })
    }

    /// The global filter, from the better of ladder and local filter.
    fn global(&mut self) -> Result<Found<N, F>, Failure> {
        let started = Instant::now();
        let (start, before) = better(&self.ladder, self.local.as_ref(), self.times)?;
        let other = unhurried(self.robot, self.times, &self.bounds, start, self.bars)?;
        let found = globally(self.robot, self.times, &self.bounds, other.as_ref().unwrap_or(start), self.bars)?;
        let time = self.ladder_time + before + started.elapsed();
        self.global = Some((found.clone(), time));
        let (motion, trajectories, lower_bound, history) = found;
        Ok(Found { motion, time, trajectories: Some(trajectories), lower_bound, history })
    }

    /// The global filter within the speeds and accelerations that the local one reaches, and whether these are beyond the bounds; if not, what the
    /// global filter has found already. `None` without both.
    fn freed(&mut self) -> Result<Option<(Found<N, F>, bool)>, Failure> {
        let started = Instant::now();
        let (Some((start, before)), Some(kept)) = (&self.local, self.global.take()) else { return Ok(None) };
        let reached = freed(&self.bounds, &start.splines(self.times)?);
        let is_freed = reached.is_some();
        let ((motion, trajectories, ..), time) = match reached {
            Some(bounds) => {
                let found = globally(self.robot, self.times, &bounds, start, self.bars)?;
                (found, self.ladder_time + *before + started.elapsed())
            }
            None => kept,
        };
        Ok(Some((Found { trajectories: Some(trajectories), ..Found::new(motion, time) }, is_freed)))
    }

    /// The ladder on a grid.
    fn on_grid(&self, grid: &LadderOptions<N, F>) -> Result<Found<N, F>, LadderError> {
        let started = Instant::now();
        let motion = plan_with(self.robot, self.times, &self.bounds, grid, self.bars)?;
        Ok(Found::new(motion, started.elapsed()))
    }

    /// The figures of what was found; waypoints are counted on from those of the pieces before.
    fn measured(&self, method: &'static str, found: Found<N, F>, waypoints: usize) -> Result<Planned<N>, Failure> {
        let Piece { robot, times, bounds, .. } = *self;
        let Found { motion, time, trajectories, lower_bound, history } = found;
        let trajectories = trajectories.map_or_else(|| motion.splines(times), Ok)?;
        let mut planned = measured(method, robot, times, &bounds, &motion, trajectories, time);
        planned.figures.jerk_lower_bound = lower_bound;
        planned.history = history;
        planned.figures.breaks.iter_mut().for_each(|waypoint| *waypoint += waypoints);
        if method == "ladder" {
            planned.figures.speed_lower_bound = needed_speed(robot, times, &bounds, &motion)?;
        }
        Ok(planned)
    }
}

/// The bounds, raised joint by joint to what these splines reach; none where they keep those on speed and acceleration.
fn freed<const N: usize>(bounds: &Bounds<N>, splines: &[Trajectory<N>]) -> Option<Bounds<N>> {
    let beyond = splines.iter().flat_map(|spline| spline.violations(bounds, BEYOND));
    let which = [Quantity::Velocity, Quantity::Acceleration];
    if !beyond.into_iter().any(|violation| which.contains(&violation.quantity)) {
        return None;
    }
    let mut freed = *bounds;
    for extremes in splines.iter().map(Trajectory::extremes) {
        for (joint, extreme) in extremes.iter().enumerate() {
            let raise = |bound: &mut f64, reached: f64| *bound = bound.max(reached.abs());
            raise(&mut freed.velocity[joint], extreme.velocity.value);
            raise(&mut freed.acceleration[joint], extreme.acceleration.value);
            raise(&mut freed.jerk[joint], extreme.jerk.value);
        }
    }
    Some(freed)
}

/// Progress as a bar.
fn shown(bars: &Bars) -> impl Fn(Progress) -> ControlFlow<()> + Sync {
    |step| {
        bars.update(step.stage, step.done, step.total);
        ControlFlow::Continue(())
    }
}

/// The ladder of four samples and, where it finds no path, of more.
fn first_ladder<const N: usize, const F: usize, R: Studied<N, F>>(
    robot: &R,
    times: &[f64],
    bounds: &Bounds<N>,
    finer: Finer<F>,
    bars: &Bars,
) -> Result<(Motion<N, F>, Duration), Failure> {
    let started = Instant::now();
    let options = LadderOptions { doublings: 0, ..LadderOptions::default() };
    let attempt = |options: &LadderOptions<N, F>, bounds: &Bounds<N>| plan_with(robot, times, bounds, options, bars);
    let ladder = match finer {
        Finer::Doubled(doublings) => attempt(&LadderOptions { doublings, breaks: true, ..options }, bounds)?,
        Finer::NearEnough(samples) => match attempt(&options, bounds) {
            Err(LadderError::NoPath { .. } | LadderError::Unreachable { .. }) => {
                let options = LadderOptions { samples, breaks: true, refinements: REFINEMENTS, ..options };
                attempt(&options, &inside(bounds))?
            }
            found => found?,
        },
    };
    Ok((ladder, started.elapsed()))
}

fn plan_with<const N: usize, const F: usize, R: Studied<N, F>>(
    robot: &R,
    times: &[f64],
    bounds: &Bounds<N>,
    options: &LadderOptions<N, F>,
    bars: &Bars,
) -> Result<Motion<N, F>, LadderError> {
    let ladder = plan_ladder(robot, times, bounds, options, &shown(bars))?;
    let (runs, doubled) = (ladder.runs().collect(), ladder.samples != [4; F]);
    Ok(Motion { nodes: ladder.nodes, runs, doubled })
}

/// The ladder of the first samples without speed limits, where these have called for more samples and it has less jerk
/// as a spline than `start`: the short way over many samples winds the tool this way and that. Speeds are the filter's
/// job.
fn unhurried<const N: usize, const F: usize, R: Studied<N, F>>(
    robot: &R,
    times: &[f64],
    bounds: &Bounds<N>,
    start: &Motion<N, F>,
    bars: &Bars,
) -> Result<Option<Motion<N, F>>, Failure> {
    if !start.doubled || start.runs.len() > 1 {
        return Ok(None);
    }
    let unbound = Bounds { velocity: [f64::INFINITY; N], ..*bounds };
    let ladder = plan_with(
        robot,
        times,
        &unbound,
        &LadderOptions { doublings: 0, breaks: true, ..LadderOptions::default() },
        bars,
    )?;
    let smoother = ladder.runs.len() == 1 && jerk(&ladder, times)? < jerk(start, times)?;
    Ok(smoother.then_some(ladder))
}

/// The greatest speed, in shares of the limits, that the stretches about the breaks of a motion need, whatever is done.
fn needed_speed<const N: usize, const F: usize, R: Studied<N, F>>(
    robot: &R,
    times: &[f64],
    bounds: &Bounds<N>,
    motion: &Motion<N, F>,
) -> Result<Option<f64>, Failure> {
    let mut most = None;
    for run in &motion.runs[1..] {
        let around = run.start.saturating_sub(ABOUT_BREAK)..(run.start + ABOUT_BREAK).min(times.len());
        most = greater(most, robot.min_speed(times, bounds, around)?.map(|found| found.lower_bound));
    }
    Ok(most)
}

/// Algorithm 6 on every run that is long enough.
fn smoothed<const N: usize, const F: usize, R: Studied<N, F>>(
    robot: &R,
    times: &[f64],
    bounds: &Bounds<N>,
    ladder: &Motion<N, F>,
    bars: &Bars,
) -> Result<(Motion<N, F>, Vec<HistoryStep>), Failure> {
    let (mut motion, mut history) = (ladder.clone(), Vec::new());
    for run in ladder.runs.iter().filter(|run| run.len() >= MIN_WAYPOINTS) {
        let part = OnPath { robot, waypoints: &robot.path()[run.clone()] };
        let (times, start) = (&times[run.clone()], &ladder.nodes[run.clone()]);
        let filtered = filter_locally(&part, times, start, bounds, &FilterOptions::default(), &shown(bars))?;
        motion.nodes[run.clone()].copy_from_slice(&filtered.nodes);
        let step = |step: FilterStep<N>| HistoryStep { objective: step.jerk, jerk: step.max_jerk.to_vec() };
        longer(&mut history, filtered.history.into_iter().map(step).collect());
    }
    Ok((motion, history))
}

/// Keeps the longer history.
fn longer(known: &mut Vec<HistoryStep>, new: Vec<HistoryStep>) {
    if new.len() > known.len() {
        *known = new;
    }
}

/// The ladder's path or the local filter's, whichever has less jerk as a spline, and the time that it took beyond the
/// ladder.
fn better<'a, const N: usize, const F: usize>(
    ladder: &'a Motion<N, F>,
    local: Option<&'a (Motion<N, F>, Duration)>,
    times: &[f64],
) -> Result<(&'a Motion<N, F>, Duration), Failure> {
    let Some((filtered, time)) = local else { return Ok((ladder, Duration::ZERO)) };
    Ok((if jerk(filtered, times)? < jerk(ladder, times)? { filtered } else { ladder }, *time))
}

/// The integral of the squared jerk of a motion's splines.
fn jerk<const N: usize, const F: usize>(motion: &Motion<N, F>, times: &[f64]) -> Result<f64, Failure> {
    Ok(motion.splines(times)?.iter().map(Trajectory::squared_jerk).sum())
}

/// A motion by the global filter, its trajectories, the lower bound of its greatest jerk, and how the filter went.
type Global<const N: usize, const F: usize> = (Motion<N, F>, Vec<Trajectory<N>>, Option<f64>, Vec<HistoryStep>);

/// The global filter on every run that is long enough.
fn globally<const N: usize, const F: usize, R: Studied<N, F>>(
    robot: &R,
    times: &[f64],
    bounds: &Bounds<N>,
    start: &Motion<N, F>,
    bars: &Bars,
) -> Result<Global<N, F>, Failure> {
    let (mut motion, mut trajectories, mut lower_bound) = (start.clone(), start.splines(times)?, None);
    let mut history = Vec::new();
    for (run, trajectory) in start.runs.iter().zip(&mut trajectories).filter(|(run, _)| run.len() >= MIN_WAYPOINTS) {
        let line = Timeline::new(&times[run.clone()], RunIn::default())?;
        let part = OnPath { robot, waypoints: &robot.path()[run.clone()] };
        let nodes = &start.nodes[run.clone()];
        let found = smooth_globally(&part, &line, nodes, bounds, &GlobalOptions::default(), &shown(bars))?;
        motion.nodes[run.clone()].copy_from_slice(&found.nodes);
        lower_bound = greater(lower_bound, found.peak.map(|peak| peak.lower_bound));
        *trajectory = found.trajectory;
        let step = |step: GlobalStep| HistoryStep { objective: step.squared_jerk, jerk: vec![step.peak] };
        longer(&mut history, found.history.into_iter().map(step).collect());
    }
    Ok((motion, trajectories, lower_bound, history))
}

/// The greater of what there is.
fn greater(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::max)
}

/// Raises what is known of each joint to a new value.
fn raise(known: &mut [f64], new: impl IntoIterator<Item = f64>) {
    known.iter_mut().zip(new).for_each(|(known, new)| *known = known.max(new));
}

fn measured<const N: usize, const F: usize, R: Studied<N, F>>(
    method: &'static str,
    robot: &R,
    times: &[f64],
    bounds: &Bounds<N>,
    motion: &Motion<N, F>,
    trajectories: Vec<Trajectory<N>>,
    time: Duration,
) -> Planned<N> {
    let mut figures = Figures {
        j: 0.0,
        spline_jerk: 0.0,
        waypoint_jerk: vec![0.0; N],
        joint_jerk: vec![0.0; N],
        velocity: 0.0,
        acceleration: 0.0,
        time,
        runs: motion.runs.len(),
        breaks: motion.runs[1..].iter().map(|run| run.start).collect(),
        missed_mm: 0.0,
        missed_rad: 0.0,
        strayed_mm: 0.0,
        violations: Vec::new(),
        jerk_lower_bound: None,
        speed_lower_bound: None,
    };
    for (waypoint, node) in motion.nodes.iter().enumerate() {
        let (mm, rad) = robot.missed(waypoint, &node.joints);
        figures.missed_mm = figures.missed_mm.max(mm);
        figures.missed_rad = figures.missed_rad.max(rad);
    }
    for (run, trajectory) in motion.runs.iter().zip(&trajectories) {
        let joints: Vec<[f64; N]> = motion.nodes[run.clone()].iter().map(|node| node.joints).collect();
        figures.j += jerk_measure(&times[run.clone()], &joints);
        for jerks in waypoint_jerks(&times[run.clone()], &joints) {
            raise(&mut figures.waypoint_jerk, jerks.map(f64::abs));
        }
        figures.spline_jerk += trajectory.squared_jerk();
        for (most, joint) in figures.joint_jerk.iter_mut().zip(trajectory.extremes()) {
            *most = most.max(joint.jerk.value.abs());
            figures.velocity = figures.velocity.max(joint.velocity.value.abs());
            figures.acceleration = figures.acceleration.max(joint.acceleration.value.abs());
        }
        figures.violations.extend(trajectory.violations(bounds, BEYOND));
        let times = &trajectory.times()[trajectory.waypoints()];
        let off = path_deviations(robot, &robot.path()[run.clone()], trajectory, times, 0.0).into_iter();
        figures.strayed_mm = off.fold(figures.strayed_mm, f64::max);
    }
    Planned { method, trajectories, figures, history: Vec::new() }
}

impl<const N: usize> Planned<N> {
    /// Adds the motion over the next piece of the path.
    fn append(&mut self, next: Planned<N>) {
        let (ours, theirs) = (&mut self.figures, next.figures);
        ours.j += theirs.j;
        ours.spline_jerk += theirs.spline_jerk;
        raise(&mut ours.waypoint_jerk, theirs.waypoint_jerk);
        raise(&mut ours.joint_jerk, theirs.joint_jerk);
        ours.velocity = ours.velocity.max(theirs.velocity);
        ours.acceleration = ours.acceleration.max(theirs.acceleration);
        ours.time += theirs.time;
        ours.runs += theirs.runs;
        ours.breaks.extend(theirs.breaks);
        ours.missed_mm = ours.missed_mm.max(theirs.missed_mm);
        ours.missed_rad = ours.missed_rad.max(theirs.missed_rad);
        ours.strayed_mm = ours.strayed_mm.max(theirs.strayed_mm);
        ours.violations.extend(theirs.violations);
        ours.jerk_lower_bound = greater(ours.jerk_lower_bound, theirs.jerk_lower_bound);
        ours.speed_lower_bound = greater(ours.speed_lower_bound, theirs.speed_lower_bound);
        self.trajectories.extend(next.trajectories);
        longer(&mut self.history, next.history);
    }
}
