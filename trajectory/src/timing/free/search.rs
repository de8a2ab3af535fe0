//! Rounds of sequential convex programming, and the timing of what they find.

use super::model::Point;
use super::options::{TimeFreeError, TimeFreeOptions, TimeFreeStatus};
use super::program::{Program, Rows};
use crate::timing::{FlowLimits, TimePathError, TimedMotion, time_path};
use crate::{Bounds, FreeRange, LadderNode, Progress, ProgressFn, Robot};

/// The time between two waypoints falls by at most this share of itself in a round, and grows by so many times. Where a round
/// has gone too far, time has to grow by as much as it takes.
const FALL: f64 = 0.3;
const GROWTH: f64 = 4.0;

/// Weight of the squared relative step of the free parameters, over the longest step, beside the duration. It only keeps
/// parameters that nothing needs where they are.
const DAMPING: f64 = 1e-2;

/// Weight of the squared relative change of the time between two waypoints, likewise.
const TIME_DAMPING: f64 = 1e-3;

/// Gap of a round's program, as a share of the duration, and the most iterations: a round needs no more digits than the
/// linear rows have.
const GAP: f64 = 5e-3;
const ITERATIONS: usize = 25;

/// Rounds that may pass limits before one must be shorter than the best so far: the first rounds pass them by a lot, and the next
/// ones recover.
const PATIENCE: usize = 3;

/// Waypoints on both sides of one out of reach that move less with it.
const NEIGHBOURS: usize = 8;

/// By how much joints move less after rounds that brought nothing, and where waypoints were out of reach.
const SHORTER: f64 = 0.3;

/// Below this share of the longest step nothing is gained any more.
const MIN_STEP_SHARE: f64 = 1e-2;

/// What is asked.
pub(super) struct Task<'a, const N: usize, const F: usize> {
    pub robot: &'a dyn Robot<N, F>,
    pub start: &'a [LadderNode<N, F>],
    pub ranges: [FreeRange; F],
    pub planned: &'a [f64],
    pub max_pace: &'a [f64],
    pub flow: Option<FlowLimits<'a>>,
    pub bounds: &'a Bounds<N>,
    pub options: &'a TimeFreeOptions,
}

impl<const N: usize, const F: usize> Task<'_, N, F> {
    /// The shortest time on a piece that pace and flow allow.
    fn shortest(&self, piece: usize) -> f64 {
        let mut pace = self.max_pace[piece];
        if let Some(flow) = self.flow {
            pace = pace.min(flow.max_flow_mm3_s / flow.flow_mm3_s[piece]);
        }
        (self.planned[piece + 1] - self.planned[piece]) / pace
    }

    /// The timing of a point, if it is shorter than the start's and no farther beyond the stops.
    pub fn timed(
        &self,
        point: &Point<N, F>,
        start: &TimedMotion<N>,
        progress: ProgressFn<'_>,
    ) -> Result<Option<TimedMotion<N>>, TimeFreeError> {
        let beyond = |motion: &TimedMotion<N>| {
            let over = |(j, extremes): (usize, crate::Extremes)| {
                (self.bounds.lower[j] - extremes.lowest.value).max(extremes.highest.value - self.bounds.upper[j])
            };
            motion.trajectory.extremes().into_iter().enumerate().map(over).fold(0.0, f64::max)
        };
        // Limits of how fast the flow changes do not count steps of the planned flow. By other times than the planned
        // ones all of it would be such steps.
        let is_planned = self.flow.is_some_and(|flow| flow.max_ramp_mm3_s2.is_finite());
        let options = &self.options.timing;
        let found = if is_planned {
            time_path(&point.joints, self.planned, self.max_pace, self.flow, self.bounds, options, progress)
        } else {
            self.timed_by_own(point, progress)
        };
        match found {
            Ok(found) => Ok((found.duration() < start.duration() && beyond(&found) <= beyond(start)).then_some(found)),
            Err(TimePathError::Cancelled) => Err(TimePathError::Cancelled.into()),
            // The start could be timed: what cannot is no result.
            Err(_) => Ok(None),
        }
    }

    /// The timing along the spline by the times of the point, which is nearer to what was optimised. Planned times and
    /// paces are then put in terms of the plan.
    fn timed_by_own(&self, point: &Point<N, F>, progress: ProgressFn<'_>) -> Result<TimedMotion<N>, TimePathError> {
        let mut own = vec![0.0];
        own.extend(point.steps.iter().scan(0.0, |time, step| {
            *time += step;
            Some(*time)
        }));
        let pieces = point.steps.len();
        // Planned seconds a second of the point.
        let ratios: Vec<f64> =
            (0..pieces).map(|piece| (self.planned[piece + 1] - self.planned[piece]) / point.steps[piece]).collect();
        let max_pace: Vec<f64> = self.max_pace.iter().zip(&ratios).map(|(pace, ratio)| pace / ratio).collect();
        let flow_mm3_s: Option<Vec<f64>> =
            self.flow.map(|flow| flow.flow_mm3_s.iter().zip(&ratios).map(|(flow, ratio)| flow * ratio).collect());
        let flow = match (self.flow, &flow_mm3_s) {
            (Some(flow), Some(flow_mm3_s)) => Some(FlowLimits { flow_mm3_s, ..flow }),
            _ => None,
        };
        let mut motion = time_path(&point.joints, &own, &max_pace, flow, self.bounds, &self.options.timing, progress)?;
        for piece in 0..pieces {
            let knots = motion.knots[piece]..motion.knots[piece + 1];
            for knot in knots.clone().skip(1) {
                motion.planned[knot] = self.planned[piece] + (motion.planned[knot] - own[piece]) * ratios[piece];
                motion.pace[knot] *= ratios[piece];
            }
            motion.planned[knots.start] = self.planned[piece];
            motion.pace[knots.start] *= if piece > 0 { ratios[piece].min(ratios[piece - 1]) } else { ratios[piece] };
        }
        motion.planned[motion.knots[pieces]] = self.planned[pieces];
        Ok(motion)
    }
}

/// The state of the rounds.
pub(super) struct Search<const N: usize, const F: usize> {
    pub best: Point<N, F>,
    /// Of the best point, times scaled where limits are passed.
    duration: f64,
    pub rounds: usize,
    pub gain: f64,
    point: Point<N, F>,
    rows: Rows,
}

impl<const N: usize, const F: usize> Search<N, F> {
    /// From postures at the times of their timing.
    pub fn new(task: &Task<'_, N, F>, mut point: Point<N, F>, motion: &TimedMotion<N>) -> Self {
        let times = motion.trajectory.times();
        point.steps = motion.knots.windows(2).map(|knots| times[knots[1]] - times[knots[0]]).collect();
        let mut search = Search {
            best: point.clone(),
            duration: f64::INFINITY,
            rounds: 0,
            gain: f64::INFINITY,
            point,
            rows: Rows::default(),
        };
        search.duration = search.look(task);
        search
    }

    /// The rows of the present point, and its duration.
    fn look(&mut self, task: &Task<'_, N, F>) -> f64 {
        let TimeFreeOptions { max_step, jerk_weight, .. } = *task.options;
        self.point.rows(task.bounds, jerk_weight, max_step, &mut self.rows)
    }

    /// Rounds until one gains nothing.
    pub fn run(&mut self, task: &Task<'_, N, F>, progress: ProgressFn<'_>) -> Result<TimeFreeStatus, TimeFreeError> {
        let options = task.options;
        // How far the joints of each waypoint may move.
        let mut reach = vec![options.max_step; task.start.len()];
        let mut waiting = 0;
        while self.rounds < options.rounds {
            let step = Progress { stage: "time free", done: self.rounds as u64, total: options.rounds as u64 };
            if progress(step).is_break() {
                return Err(TimePathError::Cancelled.into());
            }
            self.rounds += 1;
            let x = self.step(task, &reach);
            match self.point.moved(task.robot, task.start, &task.ranges, &x) {
                Ok(next) => {
                    self.point = next;
                    let duration = self.look(task);
                    if duration < self.duration {
                        self.gain = 1.0 - duration / self.duration;
                        (self.duration, waiting) = (duration, 0);
                        self.best = self.point.clone();
                        if self.gain < options.tolerance {
                            return Ok(TimeFreeStatus::Solved);
                        }
                        continue;
                    }
                }
                Err(unreachable) => {
                    let mut is_near = vec![false; reach.len()];
                    for waypoint in unreachable {
                        let end = (waypoint + NEIGHBOURS + 1).min(reach.len());
                        is_near[waypoint.saturating_sub(NEIGHBOURS)..end].fill(true);
                    }
                    reach.iter_mut().zip(is_near).filter(|(_, near)| *near).for_each(|(reach, _)| *reach *= SHORTER);
                    continue;
                }
            }
            waiting += 1;
            if waiting > PATIENCE {
                reach.iter_mut().for_each(|reach| *reach *= SHORTER);
                if reach.iter().all(|reach| *reach < MIN_STEP_SHARE * options.max_step) {
                    return Ok(TimeFreeStatus::Solved);
                }
                self.point = self.best.clone();
                self.look(task);
                waiting = 0;
            }
        }
        Ok(TimeFreeStatus::Rounds)
    }

    /// The solution of the linearised program at the present point.
    fn step(&self, task: &Task<'_, N, F>, reach: &[f64]) -> Vec<f64> {
        let (point, stride, pieces) = (&self.point, F + 1, self.point.steps.len());
        let unknowns = (pieces + 1) * stride;
        let (mut linear, mut damping) = (vec![0.0; unknowns], vec![0.0; unknowns]);
        let mut range = vec![[0.0; 2]; unknowns];
        for (waypoint, &max_step) in reach.iter().enumerate() {
            let (step, at) = (point.steps[waypoint.min(pieces - 1)], waypoint * stride);
            for f in 0..F {
                range[at + f] = [-max_step, max_step];
                damping[at + f] = DAMPING * step / (max_step * max_step);
                if let FreeRange::Within(low, high) = task.ranges[f] {
                    let (value, unit) = (point.free[waypoint][f], point.units[waypoint][f]);
                    range[at + f] = [((low - value) / unit).max(-max_step), ((high - value) / unit).min(max_step)];
                }
            }
            // The time after the last waypoint is in no row.
            damping[at + F] = TIME_DAMPING * step;
            range[at + F] = [-FALL, GROWTH];
            if waypoint < pieces {
                linear[at + F] = step;
                range[at + F][0] = (task.shortest(waypoint) / step - 1.0).clamp(-FALL, GROWTH - 1.0);
            }
        }
        let program = Program {
            rows: &self.rows,
            linear: &linear,
            damping: &damping,
            range: &range,
            width: 4 * stride - 1,
            scale: point.time(),
        };
        program.solve(GAP, ITERATIONS)
    }
}
