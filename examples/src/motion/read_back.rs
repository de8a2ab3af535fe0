//! Programs, read again: where they begin and end, how much filament they lay, whether they follow the motions that were checked.
//!
//! Between the checked motions and the robot are cuts, ticks, merged lines, signals and rounded numbers. Those are judged here, on the steps
//! that a reader finds in the files.

use super::programs::{samples, takes_stream};
use curvlay_kinematics::print_program::BlendOptions;
use curvlay_kinematics::program::{ExternalAxes, Goal, Move, Step};
use curvlay_kinematics::scene::Mount;
use curvlay_kinematics::workcell::Workcell;
use curvlay_trajectory::print::{PrintPlan, Segment, SegmentKind};
use nalgebra::{Isometry3, Point3};
use std::ops::Range;

/// How far joints may be from those of home, in radians: what degrees with five digits leave.
const HOME_RAD: f64 = 1e-5;

/// How far the tip may be from where the checked motion has it, in millimetres: what rounded coordinates leave.
pub const MAX_OFF_MM: f64 = 0.01;

/// What the filament of all programs may be off the plan, as a share.
pub const MAX_FILAMENT_SHARE: f64 = 0.005;

/// What stands in the programs of a print.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadBack {
    /// Programs.
    pub programs: usize,
    /// Those that do not begin or do not end at home.
    pub not_at_home: usize,
    /// Filament that they lay, in millimetres.
    pub filament_mm: f64,
    /// That of the motions.
    pub planned_mm: f64,
    /// How far the tip is from the checked motion at most, in millimetres: at each tick of a stream, at the end of each line; infinite where
    /// lines do not go along all runs.
    pub off_mm: f64,
    /// How fast the tip goes at most while nothing is laid, in mm/s; of streams.
    pub travel_mm_s: f64,
}

impl ReadBack {
    /// Takes in a program.
    ///
    /// # Arguments
    /// * `home`: where it is to begin and end.
    /// * `runs`: those of the plan that are to be in it.
    ///
    /// # Errors
    /// The first of the reader.
    pub fn add<const N: usize, const F: usize, W: Workcell<N, F>, E>(
        &mut self,
        print: (&W, &PrintPlan<N, F>, &[f64; N]),
        runs: Range<usize>,
        steps: impl IntoIterator<Item = Result<Step, E>>,
    ) -> Result<(), E> {
        let is_stream = takes_stream(print.0.equipment()).unwrap_or(false);
        self.add_as(if is_stream { Kind::Stream } else { Kind::Targets }, print, runs, steps)
    }

    /// Takes in a URScript of moves with blends, whose lines end at samples of the motions. Its speeds are those of the TCP.
    ///
    /// # Errors
    /// As of [`ReadBack::add`].
    pub fn add_blended<const N: usize, const F: usize, W: Workcell<N, F>, E>(
        &mut self,
        print: (&W, &PrintPlan<N, F>, &[f64; N]),
        runs: Range<usize>,
        steps: impl IntoIterator<Item = Result<Step, E>>,
    ) -> Result<(), E> {
        let is_held = matches!(print.0.equipment().part_frame().0, Mount::Link(_));
        self.add_as(Kind::Blended { is_held }, print, runs, steps)
    }

    fn add_as<const N: usize, const F: usize, W: Workcell<N, F>, E>(
        &mut self,
        kind: Kind,
        (cell, plan, home): (&W, &PrintPlan<N, F>, &[f64; N]),
        runs: Range<usize>,
        steps: impl IntoIterator<Item = Result<Step, E>>,
    ) -> Result<(), E> {
        let legs: Vec<Segment<'_, N, F>> = plan.segments(runs.clone()).collect();
        let filament = plan.runs[runs.clone()].iter().filter_map(|run| run.filament_mm.last());
        self.planned_mm += filament.sum::<f64>();
        let mut tool = Tool {
            cell,
            kind,
            checked: Checked { legs: &legs, begin: 0.0, time: 0.0 },
            lines: Lines { cell, plan, runs, kind, targets: Vec::new(), is_cut_short: false },
            is_on: false,
            fed: 0.0,
            place: None,
            pose: None,
            ends: [None; 2],
        };
        for step in steps {
            tool.pass(&step?, self);
        }
        let Tool { lines, ends, .. } = tool;
        if kind != Kind::Stream && lines.are_cut_short() {
            self.off_mm = f64::INFINITY;
        }
        let home = cell.scene_posture(home).joints;
        let is_home = |end: &Option<[f64; 6]>| {
            end.is_some_and(|end| end.iter().zip(&home).all(|(a, b)| (a - b).abs() <= HOME_RAD))
        };
        self.programs += 1;
        self.not_at_home += usize::from(!ends.iter().all(is_home));
        Ok(())
    }
}

/// Extruder and nozzle along the steps of a program.
struct Tool<'a, const N: usize, const F: usize, W> {
    cell: &'a W,
    kind: Kind,
    checked: Checked<'a, N, F>,
    lines: Lines<'a, N, F, W>,
    is_on: bool,
    /// Speed of the filament in mm/s.
    fed: f64,
    /// Where the tip is, if joints say it.
    place: Option<Point3<f64>>,
    /// Where the tool is on the part while it goes in lines.
    pose: Option<Isometry3<f64>>,
    /// Joints where the program begins, and where it is.
    ends: [Option<[f64; 6]>; 2],
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> Tool<'_, N, F, W> {
    fn tip(&self, joints: &[f64; N]) -> Option<Point3<f64>> {
        self.cell.nozzle_on_part(joints).map(|nozzle| Point3::from(nozzle.translation.vector))
    }

    /// Goes on by a step, and adds what it lays and how far it is off.
    fn pass(&mut self, step: &Step, read: &mut ReadBack) {
        match step {
            Step::Signal { .. } | Step::Wait(_) => {}
            Step::FilamentSpeed(mm_s) => self.fed = *mm_s,
            Step::Extruder(on) => {
                if *on && !self.is_on && self.kind != Kind::Stream {
                    self.pose = self.lines.begin();
                }
                self.is_on = *on;
            }
            Step::Servo { joints, seconds } => {
                let expected = self.checked.after(*seconds).and_then(|joints| self.tip(&joints));
                let to = self.tip(&of_cell(joints));
                read.off_mm = read.off_mm.max(distance(to, expected).unwrap_or(f64::INFINITY));
                if self.is_on {
                    read.filament_mm += self.fed * seconds;
                } else {
                    read.travel_mm_s = read.travel_mm_s.max(distance(self.place, to).unwrap_or(0.0) / seconds);
                }
                (self.place, self.ends[1]) = (to, Some(*joints));
            }
            Step::Move(Move { goal: Goal::Joints(joints), speed, .. }) => {
                // Signals of moves with blends come before the end of a travel where the extruder has a lag.
                if let (true, Kind::Blended { .. }, Some(from)) = (self.is_on, self.kind, self.ends[1]) {
                    let turn = from.iter().zip(joints).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    let rad_s2 = BlendOptions::of_workcell(self.cell.equipment()).acceleration_rad_s2;
                    let seconds = if turn > 0.0 { turn / speed.rad_s + speed.rad_s / rad_s2 } else { 0.0 };
                    read.filament_mm += self.fed * seconds;
                }
                self.ends = [self.ends[0].or(Some(*joints)), Some(*joints)];
                self.place = self.tip(&of_cell(joints));
            }
            Step::Move(Move { goal: Goal::Line(target) | Goal::JointMove(target), table, speed, .. }) => {
                read.off_mm = read.off_mm.max(self.lines.to(&Passed::of(&target.pose, *table)));
                let length = self.pose.map_or(0.0, |from| self.kind.way(&from, &target.pose));
                read.filament_mm += if self.is_on { self.fed * length / speed.mm_s } else { 0.0 };
                (self.pose, self.ends[1]) = (Some(target.pose), None);
            }
        }
    }
}

/// The motions that were checked.
struct Checked<'a, const N: usize, const F: usize> {
    legs: &'a [Segment<'a, N, F>],
    /// When the first of them begins, and the time that was asked for.
    begin: f64,
    time: f64,
}

impl<const N: usize, const F: usize> Checked<'_, N, F> {
    /// Joints so many seconds later.
    fn after(&mut self, seconds: f64) -> Option<[f64; N]> {
        self.time += seconds;
        while self.legs.len() > 1 && self.time > self.begin + self.legs[0].duration() {
            self.begin += self.legs[0].duration();
            self.legs = &self.legs[1..];
        }
        let leg = self.legs.first()?;
        Some(leg.at((self.time - self.begin).min(leg.duration())))
    }
}

/// What a program is.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Joints over time.
    Stream,
    /// Lines from waypoint to waypoint, at the speed of the tip.
    Targets,
    /// Lines from sample to sample, at the speed of the TCP: of the part, if the robot holds it.
    Blended { is_held: bool },
}

impl Kind {
    /// How far it is from one pose of the tool on the part to another, by what its speeds are of.
    fn way(self, from: &Isometry3<f64>, to: &Isometry3<f64>) -> f64 {
        match self {
            Kind::Blended { is_held: true } => (tip_of(&from.inverse()) - tip_of(&to.inverse())).norm(),
            _ => (tip_of(from) - tip_of(to)).norm(),
        }
    }
}

/// Where a line ends: the tool on the part, and the track, where there is one.
#[derive(Clone, Copy)]
struct Passed {
    pose: Isometry3<f64>,
    track_mm: Option<f64>,
}

impl Passed {
    fn of(pose: &Isometry3<f64>, external: Option<ExternalAxes>) -> Self {
        Passed { pose: *pose, track_mm: external.and_then(|axes| axes.track_mm()) }
    }

    /// How far the tip, or the track, is from that of another, in millimetres; infinite where one of the two has no track.
    fn off_mm(&self, other: &Self) -> f64 {
        let tip = (tip_of(&self.pose) - tip_of(&other.pose)).norm();
        match (self.track_mm, other.track_mm) {
            (Some(a), Some(b)) => tip.max((a - b).abs()),
            (None, None) => tip,
            _ => f64::INFINITY,
        }
    }
}

fn tip_of(pose: &Isometry3<f64>) -> Point3<f64> {
    Point3::from(pose.translation.vector)
}

/// The lines that are to be gone along.
struct Lines<'a, const N: usize, const F: usize, W> {
    cell: &'a W,
    plan: &'a PrintPlan<N, F>,
    /// Runs that are not begun.
    runs: Range<usize>,
    kind: Kind,
    /// Where lines may end: from the last one that was reached on.
    targets: Vec<Passed>,
    /// Whether a run was not ended before the next one was begun.
    is_cut_short: bool,
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> Lines<'_, N, F, W> {
    /// Begins the next run: where the tip is then.
    fn begin(&mut self) -> Option<Isometry3<f64>> {
        if self.targets.len() > 1 {
            self.is_cut_short = true;
        }
        self.targets = self.runs.next().map_or(Vec::new(), |run| self.targets_of(run));
        self.targets.first().map(|at| at.pose)
    }

    /// A line to some place: how far that is from one that is to be passed.
    fn to(&mut self, place: &Passed) -> f64 {
        let off_mm = |at: &Passed| at.off_mm(place);
        let passed = self.targets.iter().position(|at| off_mm(at) <= MAX_OFF_MM);
        // Waypoints next to each other may be one place.
        let all =
            passed.map(|first| self.targets[first..].iter().take_while(|at| off_mm(at) <= MAX_OFF_MM).count() + first);
        let nearest = self.targets.iter().map(off_mm).fold(f64::INFINITY, f64::min);
        self.targets.drain(..all.map_or(0, |all| all - 1));
        nearest
    }

    /// The tool at the waypoints, or at the samples, of a run, as a controller has it.
    fn targets_of(&self, run: usize) -> Vec<Passed> {
        let pose = |joints: &[f64; N]| {
            let place = self.cell.controller_pose(joints)?;
            Some(Passed { pose: place.target.pose, track_mm: place.track_mm })
        };
        if matches!(self.kind, Kind::Blended { .. }) {
            let print = self.plan.segments(run..run + 1).find(|segment| segment.kind == SegmentKind::Print);
            return print
                .map_or(Vec::new(), |print| samples(&print).iter().filter_map(|knot| pose(&knot.joints)).collect());
        }
        let run = &self.plan.runs[run];
        run.passes.iter().filter_map(|&(knot, _)| pose(&run.trajectory.joints()[knot])).collect()
    }

    /// Whether a run is not ended, or not begun.
    fn are_cut_short(&self) -> bool {
        self.is_cut_short || self.targets.len() > 1 || !self.runs.is_empty()
    }
}

/// Joints of the arm as those of the cell. A table has no axes in them: only streams and ways ask, streams are for arms without one.
fn of_cell<const N: usize>(joints: &[f64; 6]) -> [f64; N] {
    std::array::from_fn(|joint| joints.get(joint).copied().unwrap_or(0.0))
}

fn distance(a: Option<Point3<f64>>, b: Option<Point3<f64>>) -> Option<f64> {
    Some((a? - b?).norm())
}
