//! Ways from the home posture to a run and back: every program of a print begins and ends at home.
//!
//! A print is cut into programs where no travel leads on and before runs that the caller names. Each program begins at home,
//! goes to a place above its first run and comes down to it; behind its last run the nozzle lifts off and goes home. Both ways are
//! transfers ([`crate::transfer`]) with the layer of the run there, as the independent check has it.

use super::options::{PrintError, PrintLimits, PrintOptions};
use super::plan::{Arrival, Departure, Fault, FaultKind, PrintPlan, Run, Travel};
use super::postures::samples_of;
use super::run_plan::Task;
use super::travel::{arrive, depart, has_way, lifted};
use super::workcell::{Moment, PrintRobot, PrintWorkcell, Waypoint};
use crate::vectors::square;
use crate::{Progress, ProgressFn};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Heights of a home posture above the part, in millimetres, the one wanted most first.
const ABOVE_MM: [f64; 6] = [100.0, 70.0, 50.0, 30.0, 15.0, 8.0];

/// So many postures are tried at each height, those nearest to the print first.
const NEAREST: usize = 3;

impl<const N: usize, const F: usize> PrintPlan<N, F> {
    /// A posture from which programs can begin: the nozzle stands upright, high above the middle of all runs, nothing touches there
    /// with all layers built, and a way leads there from the end of the print. Heights of 100 to 8 mm are tried; where no way leads to
    /// any, home is where the nozzle has lifted off. `None` without runs, and where the nozzle cannot lift off.
    ///
    /// The free postures of an arm fall into parts between which no way leads. Runs with travels between them are in one part: home is
    /// in that of the longest chain of such runs. A print may wind a joint by whole turns: of postures that are alike but for turns the one
    /// is taken that is nearest to the mean of the chain.
    ///
    /// # Arguments
    /// * `workcell`: the workcell before anything is built.
    ///
    /// # Errors
    /// [`PrintError::Workcell`] if the workcell refuses a layer, [`PrintError::Cancelled`].
    ///
    /// # Cost
    /// A posture check for each solution at [`PrintOptions::samples`] of the free parameters at each height that is tried, and a short
    /// search of a way for each of the nearest of them.
    pub fn home_above(
        &self,
        robot: &impl PrintRobot<N, F>,
        mut workcell: impl PrintWorkcell<N>,
        limits: &PrintLimits<N>,
        options: &PrintOptions<N, F>,
        progress: ProgressFn<'_>,
    ) -> Result<Option<[f64; N]>, PrintError> {
        for layer in self.layers.iter().map(|layer| layer.layer) {
            let refused = |what| PrintError::Workcell { layer, what };
            workcell.begin(layer).and_then(|()| workcell.build(layer)).map_err(refused)?;
        }
        let stopped = || progress(Progress { stage: "find home", done: 0, total: 1 }).is_break();
        let task = Task { robot, limits, options, stopped: &stopped };
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let postures = self.runs.iter().flat_map(|run| run.trajectory.joints());
        for tip in postures.filter_map(|joints| robot.nozzle(joints)).map(|nozzle| nozzle.translation.vector) {
            (low, high) = (low.inf(&tip), high.sup(&tip));
        }
        let middle = (low + high) / 2.0;
        let inside = task.inside();
        let is_inside = |joints: &[f64; N]| (0..N).all(|j| (inside.lower[j]..=inside.upper[j]).contains(&joints[j]));
        let free_at = |above: f64, near: &[f64; N]| {
            let position = Vector3::new(middle.x, middle.y, high.z + above).into();
            let waypoint = Waypoint { position, axis: Vector3::z_axis() };
            let mut found: Vec<[f64; N]> = Vec::new();
            for free in samples_of(&robot.free(), &options.samples) {
                robot.solutions(&waypoint, &free, &mut |_, joints| {
                    found.push(std::array::from_fn(|j| inside.image_near(j, joints[j], near[j]).unwrap_or(joints[j])));
                });
            }
            found.retain(|joints| is_inside(joints) && workcell.posture_free(joints));
            found.sort_by(|a, b| square(a, near).total_cmp(&square(b, near)));
            found.dedup();
            found.truncate(NEAREST);
            found
        };
        let lifted_off = |chain: Range<usize>| {
            let lifted = lifted(&self.runs[chain.end - 1], &task, &workcell).filter(is_inside)?;
            Some((chain, lifted))
        };
        let home = self.chains().into_iter().find_map(lifted_off).map(|(chain, lifted)| {
            let is_reached = |home: &[f64; N]| has_way(chain.end, &[lifted, *home], &task, &workcell);
            let near = mean(&self.runs[chain.clone()]);
            let above = ABOVE_MM.iter().find_map(|&above| free_at(above, &near).into_iter().find(is_reached));
            above.unwrap_or(lifted)
        });
        if stopped() { Err(PrintError::Cancelled) } else { Ok(home) }
    }

    /// Runs with travels between them; those that take longest first.
    fn chains(&self) -> Vec<Range<usize>> {
        let mut chains: Vec<Range<usize>> = Vec::new();
        for number in 0..self.runs.len() {
            match chains.last_mut() {
                Some(chain) if self.travels.get(number - 1).is_some_and(Option::is_some) => chain.end = number + 1,
                _ => chains.push(number..number + 1),
            }
        }
        let seconds = |chain: &Range<usize>| self.runs[chain.clone()].iter().map(Run::duration).sum::<f64>();
        chains.sort_by(|a, b| seconds(b).total_cmp(&seconds(a)));
        chains
    }
}

/// The mean of the postures at which runs begin and end.
fn mean<const N: usize, const F: usize>(runs: &[Run<N, F>]) -> [f64; N] {
    let ends = runs.iter().flat_map(|run| {
        let joints = run.trajectory.joints();
        [joints[0], joints[joints.len() - 1]]
    });
    let sum = ends.fold([0.0; N], |sum, joints| std::array::from_fn(|j| sum[j] + joints[j]));
    sum.map(|angle| angle / (2.0 * runs.len() as f64))
}

impl<const N: usize, const F: usize> PrintPlan<N, F> {
    /// The plan cut into programs that begin and end at home: at each travel that is missing, and before each run of `cuts` as well.
    ///
    /// A run to which no way leads from home, and where a program would begin, is left out of the plan, and the program begins with
    /// the run behind it. So is a run at the end of a program from which no way leads home; the program ends before it. Each gives a
    /// fault ([`FaultKind::NoTransfer`]). Without runs the plan is as it was.
    ///
    /// # Arguments
    /// * `workcell`: the workcell before anything is built.
    /// * `home`: the posture, which must be free with all layers there.
    ///
    /// # Errors
    /// [`PrintError::Workcell`] if the workcell refuses a layer, [`PrintError::Cancelled`].
    ///
    /// # Cost
    /// Two transfers a program.
    #[expect(clippy::too_many_arguments, reason = "those of `plan_print`, and where the programs begin")]
    pub fn with_homes(
        &self,
        robot: &impl PrintRobot<N, F>,
        mut workcell: impl PrintWorkcell<N>,
        home: &[f64; N],
        cuts: &BTreeSet<usize>,
        limits: &PrintLimits<N>,
        options: &PrintOptions<N, F>,
        progress: ProgressFn<'_>,
    ) -> Result<Self, PrintError> {
        let total = self.runs.len() as u64;
        let mut plan = PrintPlan { runs: Vec::new(), travels: Vec::new(), homes: Vec::new(), ..self.clone() };
        let mut layers = self.layers.iter().map(|layer| layer.layer).peekable();
        // Whether a program has begun that goes on with the next run.
        let mut is_open = false;
        for (number, run) in self.runs.iter().enumerate() {
            let now = Progress { stage: "plan ways home", done: number as u64, total };
            let stopped = || progress(now).is_break();
            if stopped() {
                return Err(PrintError::Cancelled);
            }
            let task = Task { robot, limits, options, stopped: &stopped };
            while let Some(layer) = layers.next_if(|layer| *layer <= run.layer) {
                let refused = |what| PrintError::Workcell { layer, what };
                workcell.begin(layer).and_then(|()| workcell.build(layer)).map_err(refused)?;
            }
            let arrival = match is_open {
                true => Ok(None),
                false => self.arrival(number, home, &task, &workcell).map(Some),
            };
            let arrival = match arrival {
                Ok(arrival) => arrival,
                Err(what) => {
                    plan.leave_out(run, what);
                    continue;
                }
            };
            let travel = self.travels.get(number).cloned().flatten().filter(|_| !cuts.contains(&(number + 1)));
            if travel.is_some() {
                plan.push(run, arrival, None, travel);
                is_open = true;
                continue;
            }
            match depart(number, run, home, &task, &workcell) {
                Ok(departure) => plan.push(run, arrival, Some(departure), None),
                Err(what) => {
                    plan.leave_out(run, what);
                    if is_open {
                        plan.close(home, &task, &workcell);
                    }
                }
            }
            is_open = false;
        }
        plan.travels.pop();
        plan.count_times();
        Ok(plan)
    }

    /// Ends the program that is open at its last run from which a way leads home; what is behind that is left out.
    fn close<R: PrintRobot<N, F>>(
        &mut self,
        home: &[f64; N],
        task: &Task<'_, N, F, R>,
        workcell: &impl PrintWorkcell<N>,
    ) {
        while let (Some(last), Some((arrival, _)), Some(_)) = (self.runs.pop(), self.homes.pop(), self.travels.pop()) {
            match depart(self.runs.len(), &last, home, task, workcell) {
                Ok(departure) => return self.push(&last, arrival, Some(departure), None),
                Err(what) => self.leave_out(&last, what),
            }
            if arrival.is_some() {
                return;
            }
        }
    }

    fn arrival<R: PrintRobot<N, F>>(
        &self,
        number: usize,
        home: &[f64; N],
        task: &Task<'_, N, F, R>,
        workcell: &impl PrintWorkcell<N>,
    ) -> Result<Arrival<N>, String> {
        let run = &self.runs[number];
        let waypoint = run.passes.iter().find_map(|&(_, waypoint)| waypoint).unwrap_or(0);
        arrive(number, home, (run, Moment::At { path: run.path, waypoint }), task, workcell)
    }

    fn push(
        &mut self,
        run: &Run<N, F>,
        arrival: Option<Arrival<N>>,
        departure: Option<Departure<N>>,
        travel: Option<Travel<N>>,
    ) {
        self.runs.push(run.clone());
        self.travels.push(travel);
        self.homes.push((arrival, departure));
    }

    fn leave_out(&mut self, run: &Run<N, F>, what: String) {
        let waypoint = run.passes.iter().find_map(|&(_, waypoint)| waypoint).unwrap_or(0);
        let kind = FaultKind::NoTransfer;
        self.faults.push(Fault { layer: run.layer, path: run.path, kind, waypoint, what });
    }

    /// Seconds that the robot moves, by layer: travels and ways from home count with the layer to which they lead.
    pub(super) fn count_times(&mut self) {
        let mut seconds: BTreeMap<u32, f64> = BTreeMap::new();
        for (number, run) in self.runs.iter().enumerate() {
            let (arrival, departure) = self.homes.get(number).map_or((None, None), |(a, d)| (a.as_ref(), d.as_ref()));
            let to = number
                .checked_sub(1)
                .and_then(|before| self.travels.get(before)?.as_ref())
                .map_or(0.0, Travel::duration);
            let home = [arrival.map(Arrival::duration), departure.map(Departure::duration)];
            *seconds.entry(run.layer).or_default() += run.duration() + to + home.into_iter().flatten().sum::<f64>();
        }
        for layer in &mut self.layers {
            layer.robot_s = seconds.get(&layer.layer).copied().unwrap_or(0.0);
            layer.runs = self.runs.iter().filter(|run| run.layer == layer.layer).count();
        }
        self.settle();
    }
}
