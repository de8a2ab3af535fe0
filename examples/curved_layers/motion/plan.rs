//! The whole print, layer after layer: postures one path after the other, while the layers before are smoothed side by side.

use super::flow::Flow;
use super::robots::Printer;
use super::travel::{Travel, travel};
use super::workcell::Workcell;
use super::{Fault, FaultKind, Figures, LayerFigures, Limits, MotionRun, Print, Run, Times, postures, run};
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_toolpath::surface::ToolPath;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// Layers are smoothed side by side until there are so many paths a thread: more only take memory for what is built.
const PATHS_A_THREAD: usize = 2;

/// How deep the nozzle may be in a layer on a planned motion, as a share of its height: motions are checked with a little more,
/// at more places.
const PLANNED_DEPTH: f64 = 0.24;

/// What came of a travel: the motion, or why there is none.
type Found<const N: usize> = Result<Travel<N>, String>;

/// Plans it.
pub fn plan<const N: usize, const F: usize, R: Printer<N, F>>(
    print: &Print,
    bars: &Bars,
) -> Result<MotionRun<N, F, R>, Failure> {
    let start = Instant::now();
    print.in_workcell(PLANNED_DEPTH, bars, |cell| in_workcell(print, cell, start.elapsed(), bars))
}

fn in_workcell<const N: usize, const F: usize, R: Printer<N, F>>(
    Print { machine, .. }: &Print,
    mut cell: Workcell<N, F, R>,
    took: Duration,
    bars: &Bars,
) -> Result<MotionRun<N, F, R>, Failure> {
    let paths = &machine.freed.paths;
    let (shift, limits) = (*cell.shift(), *cell.limits());
    let mut print = Plan::new(R::NAME, took);
    let flows = Flow::of_paths(machine);
    let (mut before, mut next) = (None, 0);
    let mut with_postures = |group: &[&[ToolPath]]| -> Result<Vec<Layer<N, F, R>>, Failure> {
        // Layer by layer, since the part grows.
        let mut layers = Vec::new();
        for paths_of_layer in group {
            let number = paths_of_layer[0].layer;
            bars.update("plan motions", next as u64, paths.len() as u64);
            cell.begin(number)?;
            let of_path = |path: usize| postures::prepare(path, &paths[path], &flows[path], &shift, &cell);
            let of_layer = (next..next + paths_of_layer.len()).into_par_iter();
            let prepared: Vec<postures::Prepared<R>> = of_layer.map(of_path).collect::<Result<_, _>>()?;
            next += paths_of_layer.len();
            // One after the other, since each begins near where the one before ends.
            let of_path = |prepared| postures::choose(prepared, &mut before, &cell);
            let chosen = prepared.into_iter().map(of_path).collect::<Result<_, _>>()?;
            layers.push(Layer { number, cell: cell.clone(), chosen });
            cell.build(number)?;
        }
        Ok(layers)
    };
    // While layers are smoothed, the next ones get their postures; behind the last group there is nothing.
    let mut ready = Vec::new();
    for group in grouped(paths).iter().map(Vec::as_slice).chain([&[][..]]) {
        let planning = Instant::now();
        let (planned, next) = rayon::join(|| smoothed(&ready, &flows), || with_postures(group));
        print.figures.times.plan += planning.elapsed();
        for (layer, planned) in std::mem::replace(&mut ready, next?).into_iter().zip(planned?) {
            print.add(layer, planned, paths)?;
        }
    }
    Ok(print.finish(R::empty()?, limits, shift))
}

/// A layer whose paths have their postures.
struct Layer<'a, const N: usize, const F: usize, R> {
    number: u32,
    /// As it is while the layer is printed; for transfers, as it is before.
    cell: Workcell<'a, N, F, R>,
    chosen: Vec<postures::Chosen<N, F, R>>,
}

/// The motions along all paths of some layers.
fn smoothed<const N: usize, const F: usize, R: Printer<N, F>>(
    layers: &[Layer<N, F, R>],
    flows: &[Flow],
) -> Result<Vec<Vec<run::Planned<N, F>>>, Failure> {
    let of_layer = |Layer { cell, chosen, .. }: &Layer<N, F, R>| {
        chosen.par_iter().map(|chosen| run::smoothed(chosen, &flows[chosen.prepared.path], cell)).collect()
    };
    layers.par_iter().map(of_layer).collect()
}

/// The print as far as it is planned.
struct Plan<const N: usize, const F: usize> {
    runs: Vec<Run<N, F>>,
    travels: Vec<Option<Travel<N>>>,
    figures: Figures,
}

impl<const N: usize, const F: usize> Plan<N, F> {
    /// Nothing yet, but that it has taken so long.
    fn new(name: &'static str, plan: Duration) -> Self {
        let figures = Figures {
            name,
            motions: 0,
            transfers: 0,
            missed_mm: 0.0,
            strayed_mm: 0.0,
            min_pace: 1.0,
            planned_s: 0.0,
            printing_s: 0.0,
            times: Times { plan, ..Times::default() },
            faults: Vec::new(),
            layers: Vec::new(),
        };
        Plan { runs: Vec::new(), travels: Vec::new(), figures }
    }

    /// Adds the motions of a layer, and looks for the ways from one to the next.
    fn add<R: Printer<N, F>>(
        &mut self,
        Layer { number, mut cell, chosen }: Layer<N, F, R>,
        planned: Vec<run::Planned<N, F>>,
        paths: &[ToolPath],
    ) -> Result<(), Failure> {
        let mut layer = LayerFigures { layer: number, ..LayerFigures::default() };
        let first = self.runs.len();
        let figures = &mut self.figures;
        for planned in planned {
            layer.times.plan += planned.took;
            figures.missed_mm = figures.missed_mm.max(planned.missed_mm);
            figures.strayed_mm = figures.strayed_mm.max(planned.strayed_mm);
            figures.min_pace = figures.min_pace.min(planned.min_pace);
            figures.planned_s += planned.planned_s;
            figures.faults.extend(planned.faults);
            self.runs.extend(planned.runs);
        }
        layer.waypoints = chosen.iter().map(|chosen| paths[chosen.prepared.path].waypoints.len()).sum();
        layer.motions = self.runs.len() - first;
        layer.robot_s = self.runs[first..].iter().map(Run::duration).sum();
        figures.printing_s += layer.robot_s;
        self.connect(&mut layer, &mut cell, first, paths)?;
        self.figures.layers.push(layer);
        Ok(())
    }

    /// Looks for the ways to each of the runs from `first` on.
    fn connect<R: Printer<N, F>>(
        &mut self,
        layer: &mut LayerFigures,
        cell: &mut Workcell<N, F, R>,
        first: usize,
        paths: &[ToolPath],
    ) -> Result<(), Failure> {
        let moving = Instant::now();
        let runs = &self.runs;
        let to = |to: usize, cell: &Workcell<N, F, R>| timed(|| travel(cell, to - 1, &runs[to - 1], &runs[to]));
        // The way to the layer is gone before any of it is there.
        let there: Vec<(Found<N>, Duration)> =
            (first..runs.len()).take(usize::from(first > 0)).map(|run| to(run, cell)).collect();
        cell.build(layer.layer)?;
        let within: Vec<(Found<N>, Duration)> =
            (first + 1..runs.len()).into_par_iter().map(|run| to(run, cell)).collect();
        self.figures.times.transfers += moving.elapsed();
        for (found, took) in there.into_iter().chain(within) {
            layer.times.transfers += took;
            let from = &runs[self.travels.len()];
            match &found {
                Ok(travel) => layer.robot_s += travel.duration(),
                Err(what) => self.figures.faults.push(Fault {
                    layer: from.layer,
                    path: from.path,
                    kind: FaultKind::NoTransfer,
                    waypoint: paths[from.path].waypoints.len() - 1,
                    what: what.clone(),
                }),
            }
            self.travels.push(found.ok());
        }
        Ok(())
    }

    /// The whole print, in the order in which it is travelled.
    fn finish<R>(self, robot: R, limits: Limits<N>, shift: Vector3<f64>) -> MotionRun<N, F, R> {
        let Plan { runs, travels, mut figures } = self;
        figures.faults.sort_by_key(|fault| fault.path);
        for layer in &mut figures.layers {
            layer.faults = figures.faults.iter().filter(|fault| fault.layer == layer.layer).count();
        }
        (figures.motions, figures.transfers) = (runs.len(), travels.len());
        MotionRun { robot, limits, runs, travels, shift, figures, checked: None }
    }
}

/// Paths by layers, and as many layers at once as keep all threads busy.
fn grouped(paths: &[ToolPath]) -> Vec<Vec<&[ToolPath]>> {
    let enough = PATHS_A_THREAD * rayon::current_num_threads();
    let mut groups: Vec<Vec<&[ToolPath]>> = Vec::new();
    let mut held = enough;
    for layer in paths.chunk_by(|a, b| a.layer == b.layer) {
        if held >= enough {
            groups.push(Vec::new());
            held = 0;
        }
        if let Some(group) = groups.last_mut() {
            group.push(layer);
        }
        held += layer.len();
    }
    groups
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed())
}
