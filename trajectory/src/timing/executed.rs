//! The executed spline: how far it is from the program, and by how much its times must be scaled.

use super::curve::{Grid, Warp};
use super::limits::Task;
use super::polish::Path;
use super::program::Program;
use super::result::{TimePathError, TimePathStatus, TimedMotion};
use super::rows::{Kind, Rows, unknown};
use super::scaling::{Spline, scale_all, scaled};
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

/// Gap and residual of each round's solution, as a share of the tolerance.
const GAP: f64 = 0.75;

/// Rounds end when no times of the spline need to be scaled, and limits that move promise no more, than this share of the tolerance.
const SETTLED: f64 = 0.5;

/// After so many rounds they go on only while the program's solution is shorter than all before, by that share as well: where the spline needs less
/// than differences say. Otherwise the times of the spline do better as unknowns.
const FEW: usize = 2;

/// By what share the duration of the program may be too long, times the number of knots: against the oracle of the tests on a grid four times as fine it is up to 1.3 % too
/// long on paths of 50 knots. A spline that is shorter by more has gained it by leaving the path between
/// knots: at reversals, where a joint stands, 5e-5 rad save 6 % of the time.
const COARSENESS: f64 = 0.6;

/// The slack that a new round begins with, as a share of the limits.
const SLACK: f64 = 0.02;

/// The least products of slack and multiplier then, in all a share of the duration.
const WARM: f64 = 0.02;

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

/// Where limits of the program belong, by what the spline differs from it.
struct Correction<'a, const N: usize> {
    task: &'a Task<'a, N>,
    spline: &'a Spline<N>,
    modelled: Modelled<N>,
}

impl<'a, const N: usize> Correction<'a, N> {
    fn new(task: &'a Task<'a, N>, spline: &'a Spline<N>, program: &Program<N>) -> Self {
        Correction { task, spline, modelled: Modelled::new(program) }
    }

    /// Where the two limits of a row belong; `None` for one that does not move.
    fn limits(&self, rows: &Rows<N>, knot: usize, kind: Kind) -> Option<[f64; 2]> {
        let last = rows.segments() - 1;
        let (limit, beyond) = match kind {
            Kind::Flow | Kind::Spike => return None,
            Kind::Acceleration(_) if knot > last => return None,
            Kind::Acceleration(joint) => {
                (self.task.bounds.acceleration[joint], self.modelled.acceleration_beyond(self.spline, knot, joint))
            }
            // The spline may pass a limit of jerk that only the program has.
            Kind::Jerk(_, joint) if self.task.jerk[joint] < self.task.bounds.jerk[joint] => return None,
            Kind::Jerk(side, joint) => {
                let beside = [knot.max(1) - 1, knot.min(last)];
                // One row without a jump.
                let of = if rows.place(knot).jump[joint] == 0.0 { beside } else { [beside[side]; 2] };
                (self.task.bounds.jerk[joint], self.modelled.jerk_beyond(self.spline, of, joint))
            }
        };
        let moved = |beyond: f64| (limit - beyond).clamp(MOVES.start() * limit, MOVES.end() * limit);
        (limit < f64::INFINITY).then(|| beyond.map(moved))
    }
}

/// Moves the limits of the program by what the spline differs from it.
fn correct<const N: usize>(
    task: &Task<'_, N>,
    grid: &Grid<N>,
    (spline, correction): (&Spline<N>, &Correction<'_, N>),
    program: &mut Program<N>,
    up: f64,
) {
    program.rows.move_limits(|rows, knot, kind, mut limits| {
        for (to, moved) in limits.iter_mut().zip(correction.limits(rows, knot, kind).into_iter().flatten()) {
            **to += if moved < **to { DOWN } else { up } * (moved - **to);
        }
    });
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
        rows.each_knot(x, 0..segments + 1, |knot, accelerations, differences| {
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

/// Moves the outermost inner knots so that the resting ones, which follow from their neighbours, are the ends of the path. The knots are
/// moved by about as much as the ends were missed; a knot that is a posture stays. Scaling all times changes nothing in it.
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

/// Solves, corrects and scales times.
pub(super) fn run<const N: usize>(
    task: &Task<'_, N>,
    warp: &Warp,
    grid: &Grid<N>,
    mut program: Program<N>,
    mut iterations: usize,
    stop: &mut dyn FnMut() -> bool,
) -> Result<TimedMotion<N>, TimePathError> {
    let mut inner: Vec<[f64; N]> = grid.knots[1..grid.segments.len()].iter().map(|knot| knot.joints).collect();
    let Rounds { best, ideal, residual, solved, is_settled } =
        rounds(task, grid, &inner, &mut program, &mut iterations, stop)?;
    let Some(mut best) = best else { return Err(TimePathError::Range) };
    if !is_settled
        && iterations < task.options.iterations
        && !best.polish(task, grid, (&inner, ideal), &mut iterations, stop)?
    {
        return Err(TimePathError::Cancelled);
    }
    let Best { pace, mut times, .. } = best;
    // The program's own limits of jerk end sooner than the first knots: there the ends are missed by more.
    if (0..N).any(|j| task.jerk[j] < task.bounds.jerk[j]) {
        meet_ends(grid, &times, &mut inner)?;
    }
    scale_all(task, &inner, &mut times)?;
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
    /// Whether the spline can gain no more than the tolerance.
    is_settled: bool,
}

impl Best {
    /// Shortens the spline by the times of its pieces. Returns whether it was not stopped.
    fn polish<const N: usize>(
        &mut self,
        task: &Task<'_, N>,
        grid: &Grid<N>,
        (inner, ideal): (&[[f64; N]], f64),
        iterations: &mut usize,
        stop: &mut dyn FnMut() -> bool,
    ) -> Result<bool, TimePathError> {
        let both = |times: &[f64], knot: usize| times[knot + 1] - times[knot - 1];
        let spans = (1..=inner.len()).map(|knot| self.pace[knot] * both(&self.times, knot)).collect();
        let path = Path { task, grid, inner, least: (1.0 - COARSENESS / inner.len() as f64) * ideal, spans };
        let mut best = (self.duration, std::mem::take(&mut self.times));
        let goes_on = path.shorten(&mut best, iterations, stop)?;
        (self.duration, self.times) = best;
        for (knot, span) in (1..).zip(&path.spans) {
            let fastest = path.max_pace(knot - 1).min(path.max_pace(knot));
            self.pace[knot] = (span / both(&self.times, knot)).min(fastest);
        }
        Ok(goes_on)
    }
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
    let mut found =
        Rounds { best: None, ideal: f64::INFINITY, residual: f64::INFINITY, solved: false, is_settled: false };
    let mut shortest = f64::INFINITY;
    for round in 0..=options.rounds {
        let outcome = program.solve(GAP * options.tolerance, options.iterations - *iterations, stop);
        *iterations += outcome.iterations;
        if outcome.stopped {
            return Err(TimePathError::Cancelled);
        }
        if round == 0 {
            found.ideal = program.time();
        }
        let is_shorter = program.time() < (1.0 - SETTLED * options.tolerance) * shortest;
        shortest = shortest.min(program.time());
        let spline = Spline::new(times_of(program), inner)?;
        let (duration, times) = scaled(task, inner, &spline)?;
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
        let correction = Correction::new(task, &spline, program);
        // Where no times need to be scaled, limits that move only up can gain so much at most.
        let promised = program.gain(|rows, knot, kind| correction.limits(rows, knot, kind)) / program.time();
        found.is_settled = left.max(promised) <= SETTLED * options.tolerance;
        if found.is_settled || (round >= FEW && !is_shorter) {
            break;
        }
        correct(task, grid, (&spline, &correction), program, UP / (1.0 + SLOWER * round as f64));
        program.shrink(SLACK);
        program.centre(WARM, false);
    }
    Ok(found)
}

/// The pace at each knot: that of the program, slower where times were scaled; zero at both ends.
fn paces<const N: usize>(grid: &Grid<N>, program: &Program<N>, spline: &Spline<N>, times: &[f64]) -> Vec<f64> {
    let pace = |knot: usize| {
        let slower = (times[knot + 1] - times[knot - 1]) / (spline.times[knot + 1] - spline.times[knot - 1]);
        grid.knots[knot].warp * program.x[knot - 1].sqrt() / slower
    };
    (0..times.len()).map(|knot| if 0 < knot && knot < times.len() - 1 { pace(knot) } else { 0.0 }).collect()
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
