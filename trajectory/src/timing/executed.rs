//! The executed spline: how far it is from the program, and by how much time must be stretched for it.

use super::curve::{Grid, Warp};
use super::limits::Task;
use super::program::Program;
use super::result::{TimePathError, TimePathStatus, TimedMotion};
use super::rows::unknown;
use crate::Bounds;
use crate::spline::{Timeline, Trajectory};

/// Limits of the program move between these shares of the limit. The spline passes the program's jerk by a quarter
/// where the limit changes sides, and stays below it elsewhere; 0.3 to 1.05 was too narrow on rough paths (1.6 % instead of
/// 1.2 % above the oracle of the tests, before spikes were limited).
const MOVES: std::ops::RangeInclusive<f64> = 0.1..=1.5;

/// What share of the way limits move each round, down, and up in the first; then up by `UP / (1 + SLOWER round)`, or they
/// oscillate; with `SLOWER` 1 they stop short of what is possible (0.55 % instead of 0.30 % above the oracle of the tests).
const DOWN: f64 = 0.8;
const UP: f64 = 0.4;
const SLOWER: f64 = 0.2;

/// Rounds end when the spline needs no more stretching, and has gained no more, than this share of the tolerance.
const SETTLED: f64 = 0.5;

/// The slack that a new round begins with, as a share of the limits.
const SLACK: f64 = 0.02;

/// The least products of slack and multiplier then, in all a share of the duration.
const WARM: f64 = 0.02;

/// Pieces on both sides that are stretched with one. A change of pace over fewer pieces needs jerk itself: with 8, a
/// rough path of seven joints took 0.8 % more than the program (and `NEAR` at 0.6), with 12 it took 0.1 %.
const AROUND: usize = 12;

/// How often they are, and the excess that is left to the uniform stretch: a duration grows by at most this share for it.
const LOCAL_STRETCHES: usize = 6;
const MAX_EXCESS: f64 = 1e-5;

/// How often the stretched spline is checked again: rounding is all that is left after the first time.
const STRETCHES: usize = 8;

/// A spline through the knots at the times of the program.
struct Spline<const N: usize> {
    times: Vec<f64>,
    /// Of all knots, the resting ones included.
    accelerations: Vec<[f64; N]>,
    /// Of all pieces.
    jerks: Vec<[f64; N]>,
    /// The greatest speed on each piece.
    speeds: Vec<[f64; N]>,
}

impl<const N: usize> Spline<N> {
    /// `inner` are the joints at all knots but the two at rest.
    fn new(times: Vec<f64>, inner: &[[f64; N]]) -> Result<Self, TimePathError> {
        let line = Timeline::at_rest(&times).map_err(|_| TimePathError::Range)?;
        let segments = inner.len() + 1;
        let mut accelerations = vec![[0.0; N]; segments + 1];
        let (mut jerks, mut speeds) = (vec![[0.0; N]; segments], vec![[0.0; N]; segments]);
        let mut angles = vec![0.0; segments - 1];
        for j in 0..N {
            angles.iter_mut().zip(inner).for_each(|(angle, knot)| *angle = knot[j]);
            let m = line.second_derivatives(&angles);
            m.iter().zip(&mut accelerations[1..]).for_each(|(&m, to)| to[j] = m);
            let mut speed = 0.0f64;
            for k in 0..segments {
                let (h, a, after) = (times[k + 1] - times[k], accelerations[k][j], accelerations[k + 1][j]);
                let next = speed + 0.5 * h * (a + after);
                let mut top = speed.abs().max(next.abs());
                if a * after < 0.0 {
                    top = top.max((speed + 0.5 * h * a * a / (a - after)).abs());
                }
                jerks[k][j] = (after - a) / h;
                speeds[k][j] = top;
                speed = next;
            }
        }
        Ok(Spline { times, accelerations, jerks, speeds })
    }

    /// By what factor the time of each piece must be stretched, if that of all is.
    fn excess(&self, task: &Task<'_, N>) -> Vec<f64> {
        let Bounds { velocity, acceleration, jerk, .. } = task.bounds;
        let of = |k: usize| {
            let mut most = [0.0f64; 3];
            for j in 0..N {
                let a = self.accelerations[k][j].abs().max(self.accelerations[k + 1][j].abs());
                most[0] = most[0].max(self.speeds[k][j] / velocity[j]);
                most[1] = most[1].max(a / acceleration[j]);
                most[2] = most[2].max(self.jerks[k][j].abs() / jerk[j]);
            }
            let above = most[0].max(most[1]).max(most[2]) > 1.0;
            if above { most[0].max(most[1].sqrt()).max(most[2].cbrt()) } else { 1.0 }
        };
        (0..self.jerks.len()).map(of).collect()
    }

    /// The times with the pieces around each excess stretched, less with the distance from it.
    fn stretched(&self, excess: &[f64]) -> Vec<f64> {
        let mut factors = excess.to_vec();
        for (k, &excess) in excess.iter().enumerate().filter(|(_, excess)| **excess > 1.0) {
            for to in k.saturating_sub(AROUND)..(k + AROUND + 1).min(factors.len()) {
                let share = 1.0 - (to.abs_diff(k) as f64 / (AROUND + 1) as f64).powi(2);
                factors[to] = factors[to].max(1.0 + (excess - 1.0) * share * share);
            }
        }
        let mut times = vec![0.0];
        for (k, factor) in factors.iter().enumerate() {
            times.push(times[k] + factor * (self.times[k + 1] - self.times[k]));
        }
        times
    }
}

pub(super) fn times_of<const N: usize>(program: &Program<N>) -> Vec<f64> {
    let last = program.x.len() - 1;
    let mut times = vec![0.0];
    let mut time = 0.0;
    for (segment, width) in program.widths.iter().enumerate() {
        time += 2.0 * width / (program.x[segment.saturating_sub(1)].sqrt() + program.x[segment.min(last)].sqrt());
        times.push(time);
    }
    times
}

/// Moves the limits of the program by what the spline differs from it.
fn correct<const N: usize>(task: &Task<'_, N>, grid: &Grid<N>, spline: &Spline<N>, program: &mut Program<N>, up: f64) {
    let modelled = Modelled::new(program);
    let Bounds { acceleration, jerk, .. } = task.bounds;
    let move_to = |to: &mut f64, limit: f64, beyond: f64| {
        // What is not limited stays so.
        if limit < f64::INFINITY {
            let moved = (limit - beyond).clamp(MOVES.start() * limit, MOVES.end() * limit);
            *to += if moved < *to { DOWN } else { up } * (moved - *to);
        }
    };
    let segments = program.rows.segments();
    let jumps: Vec<[bool; N]> =
        (0..=segments).map(|knot| program.rows.place(knot).jump.map(|jump| jump != 0.0)).collect();
    for (knot, limits) in program.rows.moved().iter_mut().enumerate() {
        for j in 0..N {
            if knot < segments {
                let beyond = modelled.acceleration_beyond(spline, knot, j);
                (0..2).for_each(|end| move_to(&mut limits.acceleration[end][j], acceleration[j], beyond[end]));
            }
            // The spline may pass a limit of jerk that only the program has.
            if task.jerk[j] < jerk[j] {
                continue;
            }
            let beside = [knot.max(1) - 1, knot.min(segments - 1)];
            for (side, segment) in beside.into_iter().enumerate() {
                // One row without a jump.
                let of = if jumps[knot][j] { [segment; 2] } else { beside };
                let beyond = modelled.jerk_beyond(spline, of, j);
                (0..2).for_each(|end| move_to(&mut limits.jerk[side][end][j], jerk[j], beyond[end]));
            }
        }
    }
    program.limits_moved();
    let upper = &mut program.upper;
    for (k, upper) in upper.iter_mut().enumerate() {
        let mut faster = 1.0f64;
        for j in 0..N {
            let top = spline.speeds[k][j].max(spline.speeds[k + 1][j]);
            faster = faster.max(top / task.bounds.velocity[j]);
        }
        if faster > 1.0 {
            *upper = upper.min(task.upper(grid, k + 1, faster));
        }
    }
}

/// What the program takes for accelerations and jerks.
struct Modelled<const N: usize> {
    /// In the middle of each segment.
    accelerations: Vec<[f64; N]>,
    /// At the beginning and the end of each segment.
    jerks: Vec<[[f64; N]; 2]>,
}

impl<const N: usize> Modelled<N> {
    fn new(program: &Program<N>) -> Self {
        let (rows, x) = (&program.rows, &program.x);
        let segments = rows.segments();
        let mut modelled = Modelled { accelerations: vec![[0.0; N]; segments], jerks: vec![[[0.0; N]; 2]; segments] };
        rows.each_knot(x, |knot, accelerations, differences| {
            let scale = x[unknown(segments, knot)].sqrt() / rows.place(knot).distance();
            if knot > 0 {
                modelled.jerks[knot - 1][1] = differences[0].map(|difference| scale * difference);
            }
            if knot < segments {
                modelled.accelerations[knot] = *accelerations;
                modelled.jerks[knot][0] = differences[1].map(|difference| scale * difference);
            }
        });
        modelled
    }

    /// How far the spline is above and below the program's accelerations, at the two knots of a segment.
    fn acceleration_beyond(&self, spline: &Spline<N>, segment: usize, joint: usize) -> [f64; 2] {
        let last = self.accelerations.len() - 1;
        [segment, segment + 1].iter().fold([f64::NEG_INFINITY; 2], |beyond, &knot| {
            let beside = [knot.max(1) - 1, knot.min(last)].map(|segment| self.accelerations[segment][joint]);
            farther(beyond, spline.accelerations[knot][joint], beside)
        })
    }

    /// How far the spline is above and below the program's jerks on the segments beside a knot.
    fn jerk_beyond(&self, spline: &Spline<N>, segments: [usize; 2], joint: usize) -> [f64; 2] {
        segments.iter().fold([f64::NEG_INFINITY; 2], |beyond, &segment| {
            farther(beyond, spline.jerks[segment][joint], self.jerks[segment].map(|end| end[joint]))
        })
    }
}

/// The greater of how far something is above and below two values, and of what was found before.
fn farther([above, below]: [f64; 2], value: f64, [a, b]: [f64; 2]) -> [f64; 2] {
    [above.max(value - a.max(b)), below.max(a.min(b) - value)]
}

/// Times at which the spline holds all limits: stretched where it does not, then as a whole by what is left.
fn stretch<const N: usize>(
    task: &Task<'_, N>,
    inner: &[[f64; N]],
    first: &Spline<N>,
) -> Result<(f64, Vec<f64>), TimePathError> {
    let last = inner.len() + 1;
    let mut best = (f64::INFINITY, Vec::new());
    let mut spline = None;
    for _ in 0..LOCAL_STRETCHES {
        let this = spline.as_ref().unwrap_or(first);
        let excess = this.excess(task);
        let whole = excess.iter().fold(1.0f64, |most, excess| most.max(*excess));
        if whole * this.times[last] < best.0 {
            best = (whole * this.times[last], this.times.iter().map(|time| time * whole).collect());
        }
        if whole <= 1.0 + MAX_EXCESS {
            break;
        }
        spline = Some(Spline::new(this.stretched(&excess), inner)?);
    }
    Ok(best)
}

/// Moves the outermost inner knots so that the resting ones, which follow from their neighbours, are the ends of the path. The knots are
/// moved by about as much as the ends were missed; a knot that is a posture stays. Stretching all time changes nothing in it.
fn meet_ends<const N: usize>(grid: &Grid<N>, times: &[f64], inner: &mut [[f64; N]]) -> Result<(), TimePathError> {
    let line = Timeline::at_rest(times).map_err(|_| TimePathError::Range)?;
    let last = inner.len() - 1;
    for (at, end, step) in [(0, 0, line.step(0)), (last, last + 2, line.step(last + 1))] {
        if last < 2 || grid.postures.contains(&(at + 1)) {
            continue;
        }
        let resting = |angles: &[f64]| angles[at] - step * step * line.second_derivatives(angles)[at] / 6.0;
        let mut angles = vec![0.0; inner.len()];
        angles[at] = 1.0;
        // The resting knot is a linear function of it.
        let by = resting(&angles);
        for j in 0..N {
            angles.iter_mut().zip(&*inner).for_each(|(angle, knot)| *angle = knot[j]);
            inner[at][j] += (grid.knots[end].joints[j] - resting(&angles)) / by;
        }
    }
    Ok(())
}

/// Solves, corrects and stretches.
pub(super) fn run<const N: usize>(
    task: &Task<'_, N>,
    warp: &Warp,
    grid: &Grid<N>,
    mut program: Program<N>,
    mut iterations: usize,
    stop: &mut dyn FnMut() -> bool,
) -> Result<TimedMotion<N>, TimePathError> {
    let mut inner: Vec<[f64; N]> = grid.knots[1..grid.segments.len()].iter().map(|knot| knot.joints).collect();
    let Rounds { best, ideal, residual, solved } = rounds(task, grid, &inner, &mut program, &mut iterations, stop)?;
    let Some(Best { pace, mut times, .. }) = best else { return Err(TimePathError::Range) };
    // The program's own limits of jerk end sooner than the first knots: there the ends are missed by more.
    if (0..N).any(|j| task.jerk[j] < task.bounds.jerk[j]) {
        meet_ends(grid, &times, &mut inner)?;
    }
    stretch_evenly(task, &inner, &mut times)?;
    let line = Timeline::at_rest(&times).map_err(|_| TimePathError::Range)?;
    let trajectory = Trajectory::new(&line, &inner).map_err(|_| TimePathError::Range)?;
    if trajectory.joints().iter().flatten().any(|angle| !angle.is_finite()) {
        return Err(TimePathError::Range);
    }
    Ok(TimedMotion {
        end_deviation: end_deviation(grid, &trajectory),
        trajectory,
        knots: grid.postures.clone(),
        planned: planned_times(task, warp, grid),
        pace,
        ideal_duration: ideal,
        iterations,
        residual,
        status: if solved { TimePathStatus::Solved } else { TimePathStatus::Iterations },
    })
}

/// The shortest spline of all rounds.
struct Best {
    duration: f64,
    /// Planned seconds a second at each knot.
    pace: Vec<f64>,
    times: Vec<f64>,
}

/// What rounds of solving and correcting have found.
struct Rounds {
    best: Option<Best>,
    /// The duration of the program's first solution.
    ideal: f64,
    /// Of the solution that the best spline is of.
    residual: f64,
    /// Whether the last round was solved.
    solved: bool,
}

/// Solves the program and corrects its limits by what the spline differs from it, until the spline gains no more.
fn rounds<const N: usize>(
    task: &Task<'_, N>,
    grid: &Grid<N>,
    inner: &[[f64; N]],
    program: &mut Program<N>,
    iterations: &mut usize,
    stop: &mut dyn FnMut() -> bool,
) -> Result<Rounds, TimePathError> {
    let options = task.options;
    let mut found = Rounds { best: None, ideal: f64::INFINITY, residual: f64::INFINITY, solved: false };
    for round in 0..=options.rounds {
        let outcome = program.solve(options.tolerance, options.iterations - *iterations, stop);
        *iterations += outcome.iterations;
        if outcome.stopped {
            return Err(TimePathError::Cancelled);
        }
        if round == 0 {
            found.ideal = program.time();
        }
        let spline = Spline::new(times_of(program), inner)?;
        let (duration, times) = stretch(task, inner, &spline)?;
        found.solved = outcome.residual <= options.tolerance;
        let gained = found.best.as_ref().map_or(f64::INFINITY, |best| best.duration / duration - 1.0);
        let left = duration / program.time() - 1.0;
        if gained > 0.0 {
            found.residual = outcome.residual;
            let pace = paces(grid, program, &spline, &times);
            found.best = Some(Best { duration, pace, times });
        }
        if !found.solved || round == options.rounds || left.max(gained) <= SETTLED * options.tolerance {
            break;
        }
        correct(task, grid, &spline, program, UP / (1.0 + SLOWER * round as f64));
        program.shrink(SLACK);
        program.centre(WARM, false);
    }
    Ok(found)
}

/// The pace at each knot: that of the program, slower where time was stretched; zero at both ends.
fn paces<const N: usize>(grid: &Grid<N>, program: &Program<N>, spline: &Spline<N>, times: &[f64]) -> Vec<f64> {
    let pace = |knot: usize| {
        let slower = (times[knot + 1] - times[knot - 1]) / (spline.times[knot + 1] - spline.times[knot - 1]);
        grid.knots[knot].warp * program.x[knot - 1].sqrt() / slower
    };
    (0..times.len()).map(|knot| if 0 < knot && knot < times.len() - 1 { pace(knot) } else { 0.0 }).collect()
}

/// Stretches all time until every limit holds. Velocities fall with the factor, accelerations with its square, jerks with its cube, so
/// once is enough but for rounding.
fn stretch_evenly<const N: usize>(
    task: &Task<'_, N>,
    inner: &[[f64; N]],
    times: &mut [f64],
) -> Result<(), TimePathError> {
    for _ in 0..STRETCHES {
        let excess = Spline::new(times.to_vec(), inner)?.excess(task);
        let whole = excess.iter().fold(1.0f64, |most, excess| most.max(*excess));
        if whole <= 1.0 {
            break;
        }
        times.iter_mut().for_each(|time| *time *= whole * (1.0 + 1e-13));
    }
    Ok(())
}

/// How far the ends of a motion are from those of the path, the joint that is farthest.
fn end_deviation<const N: usize>(grid: &Grid<N>, trajectory: &Trajectory<N>) -> f64 {
    let mut end_deviation = 0.0f64;
    for knot in [0, grid.segments.len()] {
        for j in 0..N {
            end_deviation = end_deviation.max((trajectory.joints()[knot][j] - grid.knots[knot].joints[j]).abs());
        }
    }
    end_deviation
}

/// The planned time at each knot; at postures to the last bit.
fn planned_times<const N: usize>(task: &Task<'_, N>, warp: &Warp, grid: &Grid<N>) -> Vec<f64> {
    let (mut sigma, mut planned) = (0.0, vec![task.planned[0]]);
    for segment in &grid.segments {
        sigma += segment.width;
        planned.push(task.planned[0] + warp.at(sigma)[0]);
    }
    for (posture, &knot) in grid.postures.iter().enumerate() {
        planned[knot] = task.planned[posture];
    }
    planned
}
