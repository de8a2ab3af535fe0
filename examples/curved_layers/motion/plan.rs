//! The whole print, layer after layer: postures one path after the other, while the layers before are smoothed side by side.

use super::robots::Printer;
use super::workcell::Workcell;
use super::{Fault, FaultKind, Figures, LayerFigures, MotionRun, Run, Times, climb, run};
use crate::field::FieldRun;
use crate::machine::MachineRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_toolpath::surface::{MoveKind, ToolPath};
use curvlay_trajectory::transfer::Transfer;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// Layers are smoothed side by side until there are so many paths a thread: more only take memory for what is built.
const PATHS_A_THREAD: usize = 2;

/// What came of a transfer: the motion, or why there is none.
type Found<const N: usize> = Result<Transfer<N>, String>;

/// Plans it.
pub fn plan<const N: usize, const F: usize, R: Printer<N, F>>(
    field: &FieldRun,
    surfaces: &SurfacesRun,
    machine: &MachineRun,
    bars: &Bars,
) -> Result<MotionRun<N, F, R>, Failure> {
    let paths = &machine.freed.paths;
    let tips = || paths.iter().flat_map(|path| &path.waypoints).map(|waypoint| waypoint.tip);
    let mean = tips().map(|tip| tip.coords).sum::<Vector3<f64>>() / tips().count().max(1) as f64;
    // The plate stays where it is: z = 0 stands on what carries it.
    let shift = Vector3::new(mean.x, mean.y, 0.0);

    let steps = seconds_of(machine);
    let start = Instant::now();
    let mut cell: Workcell<N, F, R> = Workcell::new(field, surfaces, &shift)?;
    let mut print = Print::new(start.elapsed());
    let (mut before, mut next) = (None, 0);
    let mut with_postures = |group: &[&[ToolPath]]| -> Result<Vec<Layer<N, F, R>>, Failure> {
        // Layer by layer, since the part grows.
        let mut layers = Vec::new();
        for paths_of_layer in group {
            let number = paths_of_layer[0].layer;
            bars.update("plan motions", next as u64, paths.len() as u64);
            cell.begin(number)?;
            let of_path = |path: usize| climb::prepare(path, &paths[path], &steps[path], &shift, &cell);
            let of_layer = (next..next + paths_of_layer.len()).into_par_iter();
            let prepared: Vec<climb::Prepared<R>> = of_layer.map(of_path).collect::<Result<_, _>>()?;
            next += paths_of_layer.len();
            // One after the other, since each begins near where the one before ends.
            let of_path = |prepared| climb::climb(prepared, &mut before, &cell);
            let climbed = prepared.into_iter().map(of_path).collect::<Result<_, _>>()?;
            layers.push(Layer { number, cell: cell.clone(), climbed });
            cell.build(number)?;
        }
        Ok(layers)
    };
    // While layers are smoothed, the next ones get their postures; behind the last group there is nothing.
    let mut ready = Vec::new();
    for group in grouped(paths).iter().map(Vec::as_slice).chain([&[][..]]) {
        let planning = Instant::now();
        let (planned, next) = rayon::join(|| smoothed(&ready), || with_postures(group));
        print.times.plan += planning.elapsed();
        for (layer, planned) in std::mem::replace(&mut ready, next?).into_iter().zip(planned?) {
            print.add(layer, planned, paths)?;
        }
    }
    print.finish(shift)
}

/// A layer whose paths have their postures.
struct Layer<'a, const N: usize, const F: usize, R> {
    number: u32,
    /// As it is while the layer is printed; for transfers, as it is before.
    cell: Workcell<'a, N, F, R>,
    climbed: Vec<climb::Climbed<N, F, R>>,
}

/// The motions along all paths of some layers.
fn smoothed<const N: usize, const F: usize, R: Printer<N, F>>(
    layers: &[Layer<N, F, R>],
) -> Result<Vec<Vec<run::Planned<N, F>>>, Failure> {
    let of_layer = |Layer { cell, climbed, .. }: &Layer<N, F, R>| {
        climbed.par_iter().map(|climbed| run::smoothed(climbed, cell)).collect()
    };
    layers.par_iter().map(of_layer).collect()
}

/// The print as far as it is planned.
struct Print<const N: usize, const F: usize> {
    runs: Vec<Run<N, F>>,
    transfers: Vec<Option<Transfer<N>>>,
    faults: Vec<Fault>,
    layers: Vec<LayerFigures>,
    times: Times,
    missed_mm: f64,
    strayed_mm: f64,
    least_feed: f64,
}

impl<const N: usize, const F: usize> Print<N, F> {
    /// Nothing yet, but that it has taken so long.
    fn new(plan: Duration) -> Self {
        Print {
            runs: Vec::new(),
            transfers: Vec::new(),
            faults: Vec::new(),
            layers: Vec::new(),
            times: Times { plan, ..Times::default() },
            missed_mm: 0.0,
            strayed_mm: 0.0,
            least_feed: 1.0,
        }
    }

    /// Adds the motions of a layer: checks them, and looks for the ways from one to the next.
    fn add<R: Printer<N, F>>(
        &mut self,
        Layer { number, mut cell, climbed }: Layer<N, F, R>,
        planned: Vec<run::Planned<N, F>>,
        paths: &[ToolPath],
    ) -> Result<(), Failure> {
        let mut layer = LayerFigures { layer: number, ..LayerFigures::default() };
        let first = self.runs.len();
        for planned in planned {
            layer.times.plan += planned.took;
            self.missed_mm = self.missed_mm.max(planned.missed_mm);
            self.strayed_mm = self.strayed_mm.max(planned.strayed_mm);
            self.least_feed = self.least_feed.min(planned.least_feed);
            self.faults.extend(planned.faults);
            self.runs.extend(planned.runs);
        }
        layer.waypoints = climbed.iter().map(|climbed| paths[climbed.prepared.path].waypoints.len()).sum();
        layer.motions = self.runs.len() - first;
        layer.robot_s = self.runs[first..].iter().map(Run::duration).sum();
        self.check(&mut layer, &cell, first);
        self.connect(&mut layer, &mut cell, first, paths)?;
        self.layers.push(layer);
        Ok(())
    }

    /// Sees whether anything touches along the runs from `first` on.
    fn check<R: Printer<N, F>>(&mut self, layer: &mut LayerFigures, cell: &Workcell<N, F, R>, first: usize) {
        let checking = Instant::now();
        let check = |run: &Run<N, F>| timed(|| cell.collisions(&run.trajectory));
        let found: Vec<(Vec<(usize, String)>, Duration)> = self.runs[first..].par_iter().map(check).collect();
        self.times.check += checking.elapsed();
        for (run, (found, took)) in self.runs[first..].iter().zip(found) {
            layer.times.check += took;
            let (layer, path, kind) = (run.layer, run.path, FaultKind::Collision);
            self.faults.extend(found.into_iter().map(|(waypoint, what)| Fault { layer, path, kind, waypoint, what }));
        }
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
        let transfer = |to: usize| timed(|| cell.transfer(to - 1, &runs[to - 1], &runs[to]));
        // The way to the layer is gone before any of it is there.
        let there: Vec<(Found<N>, Duration)> = (first..runs.len()).take(usize::from(first > 0)).map(transfer).collect();
        cell.build(layer.layer)?;
        let transfer = |to: usize| timed(|| cell.transfer(to - 1, &runs[to - 1], &runs[to]));
        let within: Vec<(Found<N>, Duration)> = (first + 1..runs.len()).into_par_iter().map(transfer).collect();
        self.times.transfers += moving.elapsed();
        for (found, took) in there.into_iter().chain(within) {
            layer.times.transfers += took;
            let from = &runs[self.transfers.len()];
            match &found {
                Ok(transfer) => layer.robot_s += transfer.duration(),
                Err(what) => self.faults.push(Fault {
                    layer: from.layer,
                    path: from.path,
                    kind: FaultKind::NoTransfer,
                    waypoint: paths[from.path].waypoints.len() - 1,
                    what: what.clone(),
                }),
            }
            self.transfers.push(found.ok());
        }
        Ok(())
    }

    /// The whole print, in the order in which it is travelled.
    fn finish<R: Printer<N, F>>(self, shift: Vector3<f64>) -> Result<MotionRun<N, F, R>, Failure> {
        let Print { runs, transfers, mut faults, mut layers, times, missed_mm, strayed_mm, least_feed } = self;
        faults.sort_by_key(|fault| fault.path);
        for layer in &mut layers {
            layer.faults = faults.iter().filter(|fault| fault.layer == layer.layer).count();
        }
        let (name, motions, count) = (R::NAME, runs.len(), transfers.len());
        let figures =
            Figures { name, motions, transfers: count, missed_mm, strayed_mm, least_feed, times, faults, layers };
        Ok(MotionRun { robot: R::empty()?, runs, transfers, shift, figures })
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

/// For each path the seconds from waypoint to waypoint, as the plan of the deposition has them.
fn seconds_of(machine: &MachineRun) -> Vec<Vec<f64>> {
    let mut seconds = vec![Vec::new(); machine.freed.paths.len()];
    for step in machine.deposition.moves.iter().filter(|step| step.kind == MoveKind::Print) {
        seconds[step.path].push(step.seconds);
    }
    seconds
}
