//! The fastest timing of a given path of postures.
//!
//! D. Verscheure et al., "Time-optimal path tracking for robots: a convex optimization approach", IEEE Trans. Automatic
//! Control 54(10), 2009: the squared pace along the path is the unknown, in which accelerations are linear and the
//! duration is convex. F. Debrouwere et al., "Time-optimal path following for robots with convex-concave constraints using
//! sequential convex programming", IEEE Trans. Robotics 29(6), 2013, section IV: limits of jerk are a linear expression
//! below a convex one, which a tangent replaces.
//! Symbols: the path parameter `s` is the planned time, the pace is `ds/dt`, `b = (ds/dt)^2`.
//!
//! Departs from them: the path is a function of `sigma` in which rest is regular (see `curve`), and the unknown is
//! `beta = (d sigma / dt)^2` at knots; accelerations are taken in the middle of segments between knots and jerks at knots, from the difference of
//! two accelerations; tangents are renewed in each step of one interior-point method (see `program`), whose steps are of different lengths along the path (see
//! `local`). What is executed
//! is the C2 cubic spline through the knots at their times, and not the solution of the program: its accelerations and
//! jerks, in closed form, are compared with those of the program, the limits of the program move by the difference, and
//! it is solved again from where it was. A row more at each knot keeps the squared pace from spikes that the spline
//! cannot follow. Then the times of the spline's pieces are the unknowns, with rows of the spline itself (see `polish`). Times are scaled up around each place where a limit is passed, and all alike by what is left (see `scaling`).

mod curve;
mod executed;
mod fields;
mod free;
mod limits;
mod local;
mod near;
mod options;
mod place;
mod polish;
mod program;
mod result;
mod row;
mod rows;
mod scaling;
mod start;
mod wide;

use crate::{Bounds, Progress, ProgressFn};
use curve::{Curve, Grid, Warp};
pub use free::{FreeMotion, TimeFreeError, TimeFreeOptions, TimeFreeStatus, time_path_free};
pub use options::{FlowLimits, TimePathOptions};
use program::Program;
pub use result::{TimePathError, TimePathStatus, TimedMotion};

/// Tolerance of the first timing, which only finds where knots are needed, and how much longer its segments are.
const ROUGH: f64 = 0.02;
const COARSE: f64 = 2.0;

/// Tolerance and steps at most of the duration without limits of jerk, which only says what is short beside it.
const ESTIMATE: f64 = 0.2;
const ESTIMATE_STEPS: usize = 30;

/// The fastest motion through postures in order, at rest at both ends, whose speed, acceleration and jerk stay within
/// `bounds` everywhere.
///
/// # Arguments
/// * `postures`: at least two, in radians.
/// * `planned`: when the plan passes each, in seconds, rising. At pace 1 the motion keeps these times.
/// * `max_pace`: for each piece between two postures, planned seconds a second; infinite for none.
/// * `flow`: limits of the extruder.
/// * `bounds`: `velocity`, `acceleration` and `jerk`, infinite for none. Angles follow from the postures: `lower` and
///   `upper` must be sound, but are not looked at ([`Trajectory::violations`](crate::spline::Trajectory::violations) does that).
///
/// # Returns
/// The trajectory. All postures but the first and the last are met exactly, those two within [`TimedMotion::end_deviation`].
/// Where nothing limits a piece (no pace, and joints that stand still or have no limits), the pace stays below a
/// thousand times what the whole path allows everywhere.
///
/// # Errors
/// [`TimePathError`] names the argument; [`TimePathError::Cancelled`] when `progress` returns `Break`.
///
/// # Cost
/// Linear time and memory in knots, for each step. One thread; the result is the same each time.
/// ```
/// use curvlay_trajectory::{Bounds, TimePathOptions, time_path, transfer::SCurve};
/// use std::ops::ControlFlow;
/// let bounds = Bounds { velocity: [3.0], acceleration: [10.0], jerk: [100.0], ..Bounds::NONE };
/// let quiet = |_| ControlFlow::Continue(());
/// let motion = time_path(&[[0.0], [2.0]], &[0.0, 1.0], &[f64::INFINITY], None, &bounds, &TimePathOptions::default(), &quiet)?;
/// let best = SCurve::new(2.0, 3.0, 10.0, 100.0).unwrap().duration();
/// assert!(motion.trajectory.violations(&bounds, 1e-9).is_empty());
/// assert!(motion.duration() > 0.999 * best && motion.duration() < 1.01 * best);
/// # Ok::<(), curvlay_trajectory::TimePathError>(())
/// ```
pub fn time_path<const N: usize>(
    postures: &[[f64; N]],
    planned: &[f64],
    max_pace: &[f64],
    flow: Option<FlowLimits<'_>>,
    bounds: &Bounds<N>,
    options: &TimePathOptions,
    progress: ProgressFn<'_>,
) -> Result<TimedMotion<N>, TimePathError> {
    check(postures, planned, max_pace, flow, bounds, options)?;
    let curve = Curve::new(postures, planned);
    let task = limits::Task::new(planned, max_pace, flow, bounds, options);
    let mut done = 0;
    let mut stop = || {
        done += 1;
        progress(Progress { stage: "time path", done: done - 1, total: options.iterations as u64 }).is_break()
    };
    let longer = TimePathOptions { step: COARSE * options.step, ..*options };
    let mut first = limits::Task { options: &longer, ..task };
    let (mut warp, mut grid, mut coarse) = on_grid(&first, &curve);
    // The start is a timing within all limits. Without those of jerk the path takes less, and less changes fewer of them.
    if first.resolved(coarse.time()).jerk.iter().zip(&first.jerk).any(|(resolved, given)| resolved < given) {
        let Some(duration) = jerk_free_duration(&task, &curve, &mut stop) else { return Err(TimePathError::Cancelled) };
        first = first.resolved(duration);
        (warp, grid, coarse) = on_grid(&first, &curve);
    }
    let rough = coarse.solve(options.tolerance.max(ROUGH), options.iterations, &mut stop);
    if rough.stopped {
        return Err(TimePathError::Cancelled);
    }
    let task = limits::Task { options, ..first };
    let parts = task.refined(&curve, &task.layout(&curve).1, &grid, &executed::times_of(&coarse));
    let grid = Grid::new(&curve, &warp, &parts, options.ramp);
    let mut program = task.program(&grid);
    program.start_like(&coarse);
    executed::run(&task, &warp, &grid, program, rough.iterations, &mut stop)
}

/// The windows of the ends, the grid that a task lays out, and its program at its start.
fn on_grid<const N: usize>(task: &limits::Task<'_, N>, curve: &Curve<'_, N>) -> (Warp, Grid<N>, Program<N>) {
    let (warp, parts) = task.layout(curve);
    let grid = Grid::new(curve, &warp, &parts, task.options.ramp);
    let program = task.program(&grid);
    (warp, grid, program)
}

/// About the least duration without limits of jerk, in seconds; `None` when it is stopped.
fn jerk_free_duration<const N: usize>(
    task: &limits::Task<'_, N>,
    curve: &Curve<'_, N>,
    stop: &mut dyn FnMut() -> bool,
) -> Option<f64> {
    let task = task.without_jerk();
    let (_, _, mut program) = on_grid(&task, curve);
    let outcome = program.solve(ESTIMATE, ESTIMATE_STEPS, stop);
    (!outcome.stopped).then(|| program.time())
}

fn check<const N: usize>(
    postures: &[[f64; N]],
    planned: &[f64],
    max_pace: &[f64],
    flow: Option<FlowLimits<'_>>,
    bounds: &Bounds<N>,
    options: &TimePathOptions,
) -> Result<(), TimePathError> {
    bounds.check()?;
    let count = |field, given, expected| {
        if given == expected { Ok(()) } else { Err(TimePathError::Count { field, given, expected }) }
    };
    if postures.len() < 2 {
        return Err(TimePathError::TooFew { postures: postures.len() });
    }
    let pieces = postures.len() - 1;
    count("planned", planned.len(), postures.len())?;
    count("max_pace", max_pace.len(), pieces)?;
    for (posture, joints) in postures.iter().enumerate() {
        if let Some(joint) = joints.iter().position(|angle| !angle.is_finite()) {
            return Err(TimePathError::Posture { posture, joint, value: joints[joint] });
        }
    }
    for (posture, &time) in planned.iter().enumerate() {
        if !time.is_finite() || (posture > 0 && time <= planned[posture - 1]) {
            return Err(TimePathError::Planned { posture, time });
        }
    }
    let bad = |value: f64| value.is_nan() || value <= 0.0;
    if let Some(piece) = max_pace.iter().position(|&pace| bad(pace)) {
        return Err(TimePathError::Piece { field: "max_pace", piece, value: max_pace[piece] });
    }
    if let Some(FlowLimits { flow_mm3_s, max_flow_mm3_s, max_ramp_mm3_s2 }) = flow {
        count("flow_mm3_s", flow_mm3_s.len(), pieces)?;
        if let Some(piece) = flow_mm3_s.iter().position(|flow| !flow.is_finite() || *flow < 0.0) {
            return Err(TimePathError::Piece { field: "flow_mm3_s", piece, value: flow_mm3_s[piece] });
        }
        for (field, value) in [("max_flow_mm3_s", max_flow_mm3_s), ("max_ramp_mm3_s2", max_ramp_mm3_s2)] {
            if bad(value) {
                return Err(TimePathError::Flow { field, value });
            }
        }
    }
    let TimePathOptions { tolerance, iterations, rounds: _, subdivision, ramp, step } = *options;
    let sound = [
        ("tolerance", tolerance, tolerance > 0.0 && tolerance < 1.0, "between 0 and 1"),
        ("iterations", iterations as f64, iterations > 0, "at least 1"),
        ("subdivision", subdivision as f64, (1..=TimePathOptions::MAX_SUBDIVISION).contains(&subdivision), "1 to 64"),
        ("ramp", ramp as f64, (4..=4096).contains(&ramp), "4 to 4096"),
        ("step", step, step > 0.0, "above 0"),
    ];
    match sound.iter().find(|(_, _, sound, _)| !sound) {
        Some(&(field, value, _, must)) => Err(TimePathError::Option { field, value, must }),
        None => Ok(()),
    }
}
