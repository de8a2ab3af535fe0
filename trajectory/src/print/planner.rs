//! The whole print, layer after layer: postures one path after the other, while the layers before are smoothed side by side.

use super::options::{PrintError, PrintLimits, PrintOptions, PrintPath, check};
use super::plan::{Fault, FaultKind, LayerPlan, PrintPlan, Run};
use super::postures::{Before, Chosen, choose, prepare};
use super::run::{Planned, smoothed};
use super::run_plan::Task;
use super::ways::{Found, Ways};
use super::workcell::{PrintRobot, PrintWorkcell};
use crate::parallel;
use crate::{FreeRange, Progress, ProgressFn};
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Layers are smoothed side by side until there are so many paths a thread: more only take memory for what is built.
const PATHS_A_THREAD: usize = 2;

/// Plans a whole print.
///
/// # Arguments
/// * `robot`: its kinematics.
/// * `workcell`: the workcell before anything is built.
/// * `paths`: in the order in which they are printed.
/// * `progress`: is called with the number of paths that have postures, from any thread, and may stop the work.
///
/// # Returns
/// Motions and faults, in [`PrintPlan`]: a waypoint out of reach, something in the way or a transfer that
/// was not found are faults there, not errors.
///
/// # Errors
/// [`PrintError`] names the path and the field; [`PrintError::Cancelled`] when `progress` returns `Break`. With
/// [`PrintPlanner`] what is planned by then is kept.
///
/// # Cost
/// About half a second for a minute of robot time on two cores, most of it for smoothing, timing and proofs of freedom. Memory for
/// a few clones of the workcell besides the plan. The plan is the same on any number of threads, but for
/// [`PrintPlan::times`] and [`LayerPlan::times`].
///
/// # Example
/// ```
/// use curvlay_trajectory::nalgebra::{Isometry3, Point3, Vector3};
/// use curvlay_trajectory::print::{OpenWorkcell, PrintLimits, PrintOptions, PrintPath, PrintRobotFn, Waypoint, plan_print};
/// use curvlay_trajectory::{Bounds, FreeRange, Posture};
/// use std::ops::ControlFlow;
/// // Three linear axes, 10 mm a radian, and a tool that turns.
/// let joints = |waypoint: &Waypoint, turn: f64| {
///     let p = waypoint.position / 10.0;
///     [p.x, p.y, p.z, turn]
/// };
/// let robot = PrintRobotFn {
///     free: [FreeRange::Turn],
///     solutions: |w: &Waypoint, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 4])| each(0, joints(w, free[0])),
///     posture: |w: &Waypoint, free: &[f64; 1], _: u32| {
///         Some(Posture { joints: joints(w, free[0]), rates: [[0.0, 0.0, 0.0, 1.0]] })
///     },
///     nozzle: |q: &[f64; 4]| Some(Isometry3::new(10.0 * Vector3::new(q[0], q[1], q[2]), Vector3::z() * q[3])),
///     continued: |w: &Waypoint, _: &[f64; 1], turn: f64, near: &[f64; 4]| Some(joints(w, near[3] + turn)),
/// };
/// // Two lines of 20 mm at 10 mm/s, one above the other.
/// let line = |z: f64| {
///     let at = |k: u32| Waypoint { position: Point3::new(f64::from(k), 0.0, z), axis: Vector3::z_axis() };
///     (0..=20).map(at).collect::<Vec<_>>()
/// };
/// let (lines, times) = ([line(1.0), line(2.0)], (0..=20).map(|k| 0.1 * f64::from(k)).collect::<Vec<_>>());
/// let path = |layer: usize| PrintPath {
///     layer: layer as u32, waypoints: &lines[layer], times: &times, filament_mm: &times,
/// };
/// let limits = PrintLimits {
///     bounds: Bounds { velocity: [3.0; 4], acceleration: [10.0; 4], jerk: [100.0; 4], ..Bounds::NONE },
///     max_flow_mm3_s: f64::INFINITY,
///     max_flow_ramp_mm3_s2: f64::INFINITY,
///     filament_mm2: 2.4,
///     tolerance_mm: 0.1,
///     lever_mm: 0.0,
/// };
/// let go_on = |_| ControlFlow::Continue(());
/// let plan = plan_print(&robot, OpenWorkcell, &[path(0), path(1)], &limits, &PrintOptions::default(), &go_on)?;
/// assert_eq!((plan.runs.len(), plan.travels.len(), plan.faults.len()), (2, 1, 0));
/// assert!(plan.printing_s > 4.0 && plan.printing_s < 4.7);
/// # Ok::<(), curvlay_trajectory::print::PrintError>(())
/// ```
pub fn plan_print<const N: usize, const F: usize>(
    robot: &impl PrintRobot<N, F>,
    workcell: impl PrintWorkcell<N>,
    paths: &[PrintPath<'_>],
    limits: &PrintLimits<N>,
    options: &PrintOptions<N, F>,
    progress: ProgressFn<'_>,
) -> Result<PrintPlan<N, F>, PrintError> {
    let mut planner = PrintPlanner::new(robot, workcell, paths, limits, options)?;
    planner.run(progress)?;
    Ok(planner.into_plan())
}

/// Plans a whole print, and can be stopped: what is planned by then is kept, and [`PrintPlanner::run`] goes on from there.
#[derive(Clone)]
pub struct PrintPlanner<'a, const N: usize, const F: usize, R, C> {
    robot: &'a R,
    paths: &'a [PrintPath<'a>],
    limits: PrintLimits<N>,
    options: PrintOptions<N, F>,
    /// Where the choice of postures has come to: the workcell, where the arm is, and the next path.
    workcell: C,
    before: Option<Before<N>>,
    next: usize,
    /// Layers with postures, without motions yet.
    ready: VecDeque<Layer<N, F, C>>,
    plan: PrintPlan<N, F>,
}

/// A layer whose paths have their postures.
#[derive(Clone)]
struct Layer<const N: usize, const F: usize, C> {
    number: u32,
    /// As it is while the layer is printed; for transfers, as it is before.
    workcell: C,
    chosen: Vec<Chosen<N, F>>,
}

/// What choosing the postures of some layers leads to.
struct Ahead<const N: usize, const F: usize, C> {
    workcell: C,
    before: Option<Before<N>>,
    layers: Vec<Layer<N, F, C>>,
}

impl<'a, const N: usize, const F: usize, R: PrintRobot<N, F>, C: PrintWorkcell<N>> PrintPlanner<'a, N, F, R, C> {
    /// Nothing planned yet.
    ///
    /// # Errors
    /// [`PrintError`] names the path and the field that cannot be.
    pub fn new(
        robot: &'a R,
        workcell: C,
        paths: &'a [PrintPath<'a>],
        limits: &PrintLimits<N>,
        options: &PrintOptions<N, F>,
    ) -> Result<Self, PrintError> {
        check(paths, limits, options)?;
        if let Some(FreeRange::Within(value, _)) = robot.free().into_iter().find(|range| !range.is_sound()) {
            let must = "the range of a free parameter must be finite and not end before it begins";
            return Err(PrintError::Field { field: "free", value, must });
        }
        let (limits, options) = (*limits, *options);
        let plan = PrintPlan::new();
        Ok(PrintPlanner {
            robot,
            paths,
            limits,
            options,
            workcell,
            before: None,
            next: 0,
            ready: VecDeque::new(),
            plan,
        })
    }

    /// What is planned so far: whole layers. Faults are sorted by path.
    pub fn plan(&self) -> &PrintPlan<N, F> {
        &self.plan
    }

    /// The same, without the planner.
    pub fn into_plan(self) -> PrintPlan<N, F> {
        self.plan
    }

    /// Plans all that is left.
    ///
    /// # Errors
    /// As of [`plan_print`]. After [`PrintError::Cancelled`] it can be called again.
    pub fn run(&mut self, progress: ProgressFn<'_>) -> Result<(), PrintError> {
        let cancelled = AtomicBool::new(false);
        let mut result = Ok(());
        while result.is_ok() && (self.next < self.paths.len() || !self.ready.is_empty()) {
            let now = Progress { stage: "plan motions", done: self.next as u64, total: self.paths.len() as u64 };
            let stopped = || {
                let stops = cancelled.load(Ordering::Relaxed) || progress(now).is_break();
                cancelled.store(stops, Ordering::Relaxed);
                stops
            };
            result = self.advance(&stopped);
        }
        self.plan.settle();
        result
    }

    /// Chooses postures for a few more layers, and plans the motions of those that have them.
    fn advance(&mut self, stopped: &(dyn Fn() -> bool + Sync)) -> Result<(), PrintError> {
        let (limits, options) = (self.limits, self.options);
        let task = Task { robot: self.robot, limits: &limits, options: &options, stopped };
        let start = Instant::now();
        let group = self.next_group();
        let end = group.end;
        let (planned, ahead) = parallel::join(|| self.smoothed(&task), || self.with_postures(group, &task));
        let (planned, ahead) = (planned?, ahead?);
        self.plan.times.runs += start.elapsed();
        (self.workcell, self.before, self.next) = (ahead.workcell, ahead.before, end);
        self.ready.extend(ahead.layers);
        for mut planned in planned {
            let start = Instant::now();
            let travels = self.travels(&mut planned, &task)?;
            self.plan.times.travels += start.elapsed();
            if let Some(layer) = self.ready.pop_front() {
                self.add(&layer, planned, travels);
            }
        }
        Ok(())
    }

    /// Paths of as many layers as keep all threads busy.
    fn next_group(&self) -> Range<usize> {
        let enough = PATHS_A_THREAD * parallel::threads();
        let mut end = self.next;
        for layer in self.paths[self.next..].chunk_by(|a, b| a.layer == b.layer) {
            if end - self.next >= enough {
                break;
            }
            end += layer.len();
        }
        self.next..end
    }

    /// Layer by layer, since the part grows.
    fn with_postures(&self, group: Range<usize>, task: &Task<'_, N, F, R>) -> Result<Ahead<N, F, C>, PrintError> {
        let mut ahead = Ahead { workcell: self.workcell.clone(), before: self.before, layers: Vec::new() };
        let Ahead { workcell, before, layers } = &mut ahead;
        let mut next = group.start;
        for paths in self.paths[group].chunk_by(|a, b| a.layer == b.layer) {
            let number = paths[0].layer;
            let refused = |what| PrintError::Workcell { layer: number, what };
            workcell.begin(number).map_err(refused)?;
            let of_layer: Vec<usize> = (next..next + paths.len()).collect();
            next += paths.len();
            let prepared = parallel::map(&of_layer, |&path| prepare(path, &self.paths[path], task, workcell))?;
            // One after the other, since each begins near where the one before ends.
            let of_path = |prepared| choose(prepared, before, task, workcell);
            let chosen = prepared.into_iter().map(of_path).collect::<Result<_, _>>()?;
            layers.push(Layer { number, workcell: workcell.clone(), chosen });
            workcell.build(number).map_err(refused)?;
        }
        Ok(ahead)
    }

    /// The motions along all paths of the layers that are ready.
    fn smoothed(&self, task: &Task<'_, N, F, R>) -> Result<Vec<Vec<Planned<N, F>>>, PrintError> {
        let layers: Vec<&Layer<N, F, C>> = self.ready.iter().collect();
        parallel::map(&layers, |layer| {
            let of_path =
                |chosen: &Chosen<N, F>| smoothed(chosen, &self.paths[chosen.prepared.path], task, &layer.workcell);
            parallel::map(&layer.chosen, of_path)
        })
    }

    /// The ways to each of the runs of the first layer that is ready. Where none is found, one of the two paths may get other
    /// postures.
    fn travels(&self, planned: &mut Vec<Planned<N, F>>, task: &Task<'_, N, F, R>) -> Result<Vec<Found<N>>, PrintError> {
        let Some(layer) = self.ready.front() else { return Ok(Vec::new()) };
        let mut built = layer.workcell.clone();
        built.build(layer.number).map_err(|what| PrintError::Workcell { layer: layer.number, what })?;
        let ways = Ways {
            paths: self.paths,
            chosen: &layer.chosen,
            workcells: [&layer.workcell, &built],
            before: self.plan.runs.last(),
            first: self.plan.travels.len(),
            task,
        };
        ways.find(planned)
    }

    /// Adds a layer.
    fn add(&mut self, layer: &Layer<N, F, C>, planned: Vec<Planned<N, F>>, travels: Vec<Found<N>>) {
        let plan = &mut self.plan;
        let mut figures = LayerPlan { layer: layer.number, ..LayerPlan::default() };
        figures.waypoints = layer.chosen.iter().map(|path| self.paths[path.prepared.path].waypoints.len()).sum();
        for planned in planned {
            figures.times.runs += planned.took;
            figures.runs += planned.runs.len();
            figures.robot_s += planned.runs.iter().map(Run::duration).sum::<f64>();
            plan.max_missed_mm = plan.max_missed_mm.max(planned.missed_mm);
            plan.max_deviation_mm = plan.max_deviation_mm.max(planned.deviation_mm);
            plan.min_pace = plan.min_pace.min(planned.min_pace);
            plan.slow_runs += planned.slow_runs;
            plan.planned_s += planned.planned_s;
            plan.faults.extend(planned.faults);
            plan.runs.extend(planned.runs);
        }
        plan.printing_s += figures.robot_s;
        for (found, took) in travels {
            figures.times.travels += took;
            let from = &plan.runs[plan.travels.len()];
            match &found {
                Ok(travel) => figures.robot_s += travel.duration(),
                Err(what) => plan.faults.push(Fault {
                    layer: from.layer,
                    path: from.path,
                    kind: FaultKind::NoTransfer,
                    waypoint: self.paths[from.path].waypoints.len() - 1,
                    what: what.clone(),
                }),
            }
            plan.travels.push(found.ok());
        }
        plan.layers.push(figures);
    }
}
