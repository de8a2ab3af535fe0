//! What comes of planning: runs, travels, and what cannot be printed as it is.

use super::workcell::Waypoint;
use crate::spline::Trajectory;
use crate::transfer::Transfer;
use std::fmt;
use std::time::Duration;

/// The whole print.
#[derive(Clone, Debug)]
pub struct PrintPlan<const N: usize, const F: usize> {
    /// The motions along the paths, in the order in which they are travelled.
    pub runs: Vec<Run<N, F>>,
    /// From the end of each run to the start of the next, one less than runs; `None` where no way was found.
    pub travels: Vec<Option<Travel<N>>>,
    /// The way from home before each run and the way home behind it, where a program begins or ends
    /// ([`PrintPlan::with_homes`]); empty before programs are cut.
    pub homes: Vec<(Option<Arrival<N>>, Option<Departure<N>>)>,
    /// What cannot be printed as it is, or not be reached, in the order of the paths.
    pub faults: Vec<Fault>,
    /// One a layer with paths.
    pub layers: Vec<LayerPlan>,
    /// How far from its waypoint the tip is at most, in millimetres: what inverse kinematics leave.
    pub max_missed_mm: f64,
    /// How far from the straight way between two waypoints the tip is at most, in millimetres, as [`path_deviations`](super::path_deviations)
    /// looks.
    pub max_deviation_mm: f64,
    /// Lowest share of the planned feed at a waypoint between the ends of a run; 1 for none.
    pub min_pace: f64,
    /// Runs whose fastest timing was not found within the steps of [`PrintOptions::timing`](super::PrintOptions::timing): they
    /// hold all limits, but may take longer than need be.
    pub slow_runs: usize,
    /// Seconds of all runs at the planned feed.
    pub planned_s: f64,
    /// Seconds of all runs as they are.
    pub printing_s: f64,
    /// How long planning took, on the clock. The only part of a plan that is not the same each time, with
    /// [`LayerPlan::times`].
    pub times: PlanTimes,
}

/// One unbroken motion along a path, from rest to rest.
#[derive(Clone, Debug)]
pub struct Run<const N: usize, const F: usize> {
    /// The path, by its place in the list.
    pub path: usize,
    /// Its layer.
    pub layer: u32,
    /// What is executed.
    pub trajectory: Trajectory<N>,
    /// Knots of the trajectory at waypoints, and which of the path these are; `None` of those that were put between two.
    pub passes: Vec<(usize, Option<usize>)>,
    /// Millimetres of filament since the run began, at each knot.
    pub filament_mm: Vec<f64>,
    /// Free parameters and waypoint at both ends.
    pub ends: [([f64; F], Waypoint); 2],
}

impl<const N: usize, const F: usize> Run<N, F> {
    /// How long it takes to each waypoint of the path from the one before: path, waypoint, seconds. Knots
    /// that the trajectory does not have are passed over.
    pub fn steps(&self) -> Vec<(usize, usize, f64)> {
        let times = self.trajectory.times();
        let given = self.passes.iter().filter_map(|&(knot, waypoint)| Some((*times.get(knot)?, waypoint?)));
        let given: Vec<(f64, usize)> = given.collect();
        let step = |pair: &[(f64, usize)]| (self.path, pair[1].1, pair[1].0 - pair[0].0);
        given.windows(2).filter(|pair| pair[0].1.checked_add(1) == Some(pair[1].1)).map(step).collect()
    }

    /// Seconds from rest to rest.
    pub fn duration(&self) -> f64 {
        let (first, last) = self.trajectory.span();
        last - first
    }
}

/// How long steps took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlanTimes {
    /// Postures and runs.
    pub runs: Duration,
    /// Travels.
    pub travels: Duration,
}

impl PlanTimes {
    /// Both.
    pub fn all(&self) -> Duration {
        self.runs + self.travels
    }
}

/// What is said of a layer. Travels count with the layer to which they lead.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LayerPlan {
    /// The layer.
    pub layer: u32,
    /// Its runs.
    pub runs: usize,
    /// Waypoints of its paths.
    pub waypoints: usize,
    /// Seconds that the robot moves.
    pub robot_s: f64,
    /// How long planning took, on the threads that did it, added up: what a single one would have taken.
    pub times: PlanTimes,
    /// Its faults.
    pub faults: usize,
}

impl LayerPlan {
    /// Planning time by robot time.
    pub fn factor(&self, times: impl Fn(&PlanTimes) -> Duration) -> f64 {
        times(&self.times).as_secs_f64() / self.robot_s.max(f64::MIN_POSITIVE)
    }
}

/// A place that cannot be printed as it is, or not be reached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The layer.
    pub layer: u32,
    /// The path, by its place in the list.
    pub path: usize,
    /// What it is.
    pub kind: FaultKind,
    /// The waypoint of the path.
    pub waypoint: usize,
    /// What is in the way, or how far the nozzle is off, in words; may be empty.
    pub what: String,
}

impl fmt::Display for Fault {
    /// Layers are counted from 1, as in reports.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Fault { layer, path, kind, waypoint, what } = self;
        write!(f, "layer {}, path {path}, waypoint {waypoint}: {}", u64::from(*layer) + 1, kind.name())?;
        if what.is_empty() { Ok(()) } else { write!(f, ": {what}") }
    }
}

/// Why a path is not printed as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FaultKind {
    /// No sample of the free parameters reaches the waypoint.
    Unreachable,
    /// In reach, but something touches at every sample.
    Blocked,
    /// The path breaks off before the waypoint: no posture leads on from the one before.
    Break,
    /// The nozzle leaves the straight way from the waypoint to the next by more than the tolerance.
    PathDeviation,
    /// No way to the next run was found.
    NoTransfer,
}

impl FaultKind {
    /// In a word or two.
    pub fn name(self) -> &'static str {
        match self {
            FaultKind::Unreachable => "unreachable",
            FaultKind::Blocked => "blocked",
            FaultKind::Break => "break",
            FaultKind::PathDeviation => "astray",
            FaultKind::NoTransfer => "no transfer",
        }
    }
}

impl<const N: usize, const F: usize> PrintPlan<N, F> {
    /// Nothing yet.
    pub(super) fn new() -> Self {
        PrintPlan {
            runs: Vec::new(),
            travels: Vec::new(),
            homes: Vec::new(),
            faults: Vec::new(),
            layers: Vec::new(),
            max_missed_mm: 0.0,
            max_deviation_mm: 0.0,
            min_pace: 1.0,
            slow_runs: 0,
            planned_s: 0.0,
            printing_s: 0.0,
            times: PlanTimes::default(),
        }
    }

    /// Sorts faults by path, and counts them.
    pub(super) fn settle(&mut self) {
        self.faults.sort_by_key(|fault| fault.path);
        for layer in &mut self.layers {
            layer.faults = self.faults.iter().filter(|fault| fault.layer == layer.layer).count();
        }
    }

    /// Seconds that the robot moves.
    pub fn robot_s(&self) -> f64 {
        self.layers.iter().map(|layer| layer.robot_s).sum()
    }

    /// Seconds that planning took, on the clock.
    pub fn plan_s(&self) -> f64 {
        self.times.all().as_secs_f64()
    }

    /// The fastest filament of all runs between two knots, in mm/s: what the range of a signal for it must hold. 0 without runs.
    pub fn max_filament_mm_s(&self) -> f64 {
        let of_run = |run: &Run<N, F>| {
            let knots = run.trajectory.times().windows(2).zip(run.filament_mm.windows(2));
            knots.map(|(times, laid)| (laid[1] - laid[0]) / (times[1] - times[0])).fold(0.0, f64::max)
        };
        self.runs.iter().map(of_run).fold(0.0, f64::max)
    }

    /// Faults of a kind.
    pub fn count(&self, kind: FaultKind) -> usize {
        self.faults.iter().filter(|fault| fault.kind == kind).count()
    }

    /// How long the motion takes to each waypoint of a path from the one before: path, waypoint, seconds.
    pub fn steps(&self) -> Vec<(usize, usize, f64)> {
        self.runs.iter().flat_map(Run::steps).collect()
    }
}

/// The motion between two runs, each piece from rest to rest.
#[derive(Clone, Debug)]
pub struct Travel<const N: usize> {
    /// Off the end of the run.
    pub lift: Trajectory<N>,
    /// From there to above the start of the next.
    pub way: Transfer<N>,
    /// Down to it.
    pub approach: Trajectory<N>,
}

impl<const N: usize> Travel<N> {
    /// In seconds.
    pub fn duration(&self) -> f64 {
        seconds(&self.lift) + self.way.duration() + seconds(&self.approach)
    }

    /// Postures by which the travel is followed in straight motions of the joints: `count` along the lift at even times, the last
    /// at its end, the corners of the transfer, and as many along the approach. Without those the nozzle would not leave and
    /// reach the part along its direction.
    pub fn postures(&self, count: u32) -> Vec<[f64; N]> {
        let corners = self.way.corners().iter().copied();
        sampled(&self.lift, count).into_iter().chain(corners).chain(sampled(&self.approach, count)).collect()
    }
}

/// Postures along a motion at even times, the last at its end.
pub(super) fn sampled<const N: usize>(motion: &Trajectory<N>, count: u32) -> Vec<[f64; N]> {
    let (first, last) = motion.span();
    let at = |k: u32| motion.at(first + (last - first) * f64::from(k) / f64::from(count)).position;
    (1..=count).map(at).collect()
}

pub(super) fn seconds<const N: usize>(motion: &Trajectory<N>) -> f64 {
    let (first, last) = motion.span();
    last - first
}

/// From home to a run.
#[derive(Clone, Debug)]
pub struct Arrival<const N: usize> {
    /// From home to above the start of the run.
    pub way: Transfer<N>,
    /// Down to it.
    pub approach: Trajectory<N>,
}

/// From a run home.
#[derive(Clone, Debug)]
pub struct Departure<const N: usize> {
    /// Off the end of the run.
    pub lift: Trajectory<N>,
    /// Home.
    pub way: Transfer<N>,
}

impl<const N: usize> Arrival<N> {
    /// In seconds.
    pub fn duration(&self) -> f64 {
        self.way.duration() + seconds(&self.approach)
    }

    /// Postures by which it is followed in straight motions of the joints: the corners of the way, home first, and `count` along
    /// the approach at even times, the last at its end.
    pub fn postures(&self, count: u32) -> Vec<[f64; N]> {
        self.way.corners().iter().copied().chain(sampled(&self.approach, count)).collect()
    }
}

impl<const N: usize> Departure<N> {
    /// In seconds.
    pub fn duration(&self) -> f64 {
        seconds(&self.lift) + self.way.duration()
    }

    /// Postures by which it is followed in straight motions of the joints: `count` along the lift at even times, the last at its
    /// end, and the corners of the way home.
    pub fn postures(&self, count: u32) -> Vec<[f64; N]> {
        sampled(&self.lift, count).into_iter().chain(self.way.corners().iter().copied()).collect()
    }
}
