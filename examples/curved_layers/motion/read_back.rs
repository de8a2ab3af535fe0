//! The programs as they were written, read again: where they begin and end, how much filament they lay, whether they follow the motions
//! that were checked.
//!
//! [`check`](super::check) judges the motions of `trajectory.csv`. Between these and the robot are cuts, ticks, merged lines, signals and
//! rounded numbers: those are judged here, on the files.

use super::{MotionRun, ProgramFormat};
use crate::failure;
use curvlay_examples::args::Failure;
use curvlay_examples::motion::programs::{pieces, takes_stream};
use curvlay_kinematics::program::{CsvReader, Goal, Move, ReadError, Step, UrScriptReader, read_rapid};
use curvlay_kinematics::workcell::Workcell;
use curvlay_trajectory::print::Leg;
use nalgebra::{Point3, Vector3};
use std::fs::File;
use std::io::{self, BufReader};
use std::ops::Range;
use std::path::Path;

/// How far joints may be from those of home, in radians: what degrees with five digits leave.
const HOME_RAD: f64 = 1e-5;

/// How far the tip may be from where the checked motion has it, in millimetres: what rounded coordinates leave.
pub const MAX_OFF_MM: f64 = 0.01;

/// What the filament of all programs may be off the plan, as a share.
pub const MAX_FILAMENT_SHARE: f64 = 0.005;

/// What stands in the programs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadBack {
    /// Programs.
    pub programs: usize,
    /// Those that do not begin or do not end at home.
    pub not_at_home: usize,
    /// Filament that they lay, and that of the motions, in millimetres.
    pub filament_mm: f64,
    pub planned_mm: f64,
    /// How far the tip is from the checked motion at most, in millimetres: at each tick of a stream, at the end of each line.
    pub off_mm: f64,
    /// How fast the tip goes at most while nothing is laid, in mm/s; of streams.
    pub travel_mm_s: f64,
}

/// Reads all programs of a print.
///
/// # Errors
/// A file that cannot be read, or that the reader of its language refuses, with its line.
pub fn read_back<const N: usize, const F: usize, W: Workcell<N, F>>(
    run: &MotionRun<N, F, W>,
    format: ProgramFormat,
    folder: &Path,
) -> Result<ReadBack, Failure> {
    let is_stream = takes_stream(run.cell.equipment()).unwrap_or(false);
    let filament = run.plan.runs.iter().filter_map(|run| run.filament_mm.last());
    let mut found = ReadBack { planned_mm: filament.sum(), ..ReadBack::default() };
    let pieces = pieces(&run.plan);
    let open = |name: &str| -> io::Result<BufReader<File>> { Ok(BufReader::new(File::open(folder.join(name))?)) };
    for (number, piece) in pieces.iter().enumerate() {
        let numbered = |ending: &str| format!("print_{:03}.{ending}", number + 1);
        let name = match format {
            ProgramFormat::Urscript => numbered("script"),
            ProgramFormat::Csv => numbered("csv"),
            ProgramFormat::Rapid if pieces.len() == 1 => "print.mod".to_owned(),
            ProgramFormat::Rapid => format!("print{}.mod", number + 1),
            ProgramFormat::None => break,
        };
        let refused = |error: ReadError| failure(format!("{name}, as it was written: {error}"));
        let file = open(&name).map_err(|error| failure(format!("{name}: {error}")))?;
        let mut program = Program { run, found: &mut found, piece: piece.clone(), is_stream };
        match format {
            ProgramFormat::Urscript => program.follow(UrScriptReader::new(file).map_err(refused)?),
            ProgramFormat::Csv => program.follow(CsvReader::new(file).map_err(refused)?),
            ProgramFormat::Rapid | ProgramFormat::None => program.follow(read_rapid(file, open).map_err(refused)?),
        }
        .map_err(refused)?;
    }
    Ok(found)
}

/// A program, and the runs that are to be in it.
struct Program<'a, const N: usize, const F: usize, W> {
    run: &'a MotionRun<N, F, W>,
    found: &'a mut ReadBack,
    piece: Range<usize>,
    is_stream: bool,
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> Program<'_, N, F, W> {
    fn follow(&mut self, steps: impl Iterator<Item = Result<Step, ReadError>>) -> Result<(), ReadError> {
        let legs: Vec<Leg<'_, N, F>> = self.run.plan.legs(self.piece.clone()).collect();
        let (mut checked, mut runs) = (Checked::new(&legs), self.piece.clone());
        // Where lines are to end, and where the tip is.
        let (mut expected, mut place): (Vec<Point3<f64>>, Option<Point3<f64>>) = (Vec::new(), None);
        let (mut is_on, mut fed, mut seconds_passed) = (false, 0.0, 0.0);
        let [mut first, mut last] = [None; 2];
        for step in steps {
            match step? {
                Step::Extruder(on) => {
                    if on && !is_on && !self.is_stream {
                        expected = runs.next().map_or(Vec::new(), |run| self.targets(run));
                        place = expected.first().copied();
                    }
                    is_on = on;
                }
                Step::FilamentSpeed(mm_s) => fed = mm_s,
                Step::Signal { .. } => {}
                Step::Servo { joints, seconds } => {
                    seconds_passed += seconds;
                    let tip = self.tip(&padded(&joints));
                    let checked = checked.at(seconds_passed).map(|joints| self.tip(&joints));
                    self.found.off_mm = self.found.off_mm.max(apart(tip, checked.flatten()));
                    if let (Some(from), Some(to), false) = (place, tip, is_on) {
                        self.found.travel_mm_s = self.found.travel_mm_s.max((to - from).norm() / seconds);
                    }
                    self.found.filament_mm += if is_on { fed * seconds } else { 0.0 };
                    (place, last) = (tip, Some(joints));
                }
                Step::Move(Move { goal: Goal::Joints(joints), .. }) => {
                    first = first.or(Some(joints));
                    last = Some(joints);
                    place = if self.is_stream { self.tip(&padded(&joints)) } else { None };
                }
                Step::Move(Move { goal: Goal::Line(target) | Goal::Swing(target), speed, .. }) => {
                    let tip = Point3::from(target.pose.translation.vector);
                    let is_near = |at: &Point3<f64>| (at - tip).norm() <= MAX_OFF_MM;
                    let passed = expected.iter().position(is_near);
                    let nearest = expected.iter().map(|at| (at - tip).norm()).fold(f64::INFINITY, f64::min);
                    self.found.off_mm = self.found.off_mm.max(nearest);
                    expected.drain(..passed.map_or(0, |passed| passed));
                    let length = place.map_or(0.0, |from| (tip - from).norm());
                    self.found.filament_mm += if is_on { fed * length / speed.mm_s } else { 0.0 };
                    (place, last) = (Some(tip), None);
                }
            }
        }
        let home = self.run.home.map(|home| self.run.cell.scene_posture(&home).joints);
        let is_home = |joints: Option<[f64; 6]>| {
            let apart = |a: [f64; 6], b: [f64; 6]| (0..6).all(|j| (a[j] - b[j]).abs() <= HOME_RAD);
            home.zip(joints).is_some_and(|(home, joints)| apart(home, joints))
        };
        self.found.programs += 1;
        self.found.not_at_home += usize::from(!(is_home(first) && is_home(last)));
        Ok(())
    }

    /// Where the tip is on the part.
    fn tip(&self, joints: &[f64; N]) -> Option<Point3<f64>> {
        self.run.cell.nozzle_on_part(joints).map(|nozzle| Point3::from(nozzle.translation.vector))
    }

    /// The tip at the waypoints of a run, as a controller has it.
    fn targets(&self, run: usize) -> Vec<Point3<f64>> {
        let run = &self.run.plan.runs[run];
        let pose = |knot: usize| self.run.cell.controller_pose(&run.trajectory.joints()[knot]);
        let places = run.passes.iter().filter_map(|&(knot, _)| pose(knot));
        places.map(|place| Point3::from(place.target.pose.translation.vector)).collect()
    }
}

/// The motions that were checked, asked at rising times.
struct Checked<'a, const N: usize, const F: usize> {
    legs: &'a [Leg<'a, N, F>],
    /// When the first of them begins.
    begin: f64,
}

impl<'a, const N: usize, const F: usize> Checked<'a, N, F> {
    fn new(legs: &'a [Leg<'a, N, F>]) -> Self {
        Checked { legs, begin: 0.0 }
    }

    fn at(&mut self, time: f64) -> Option<[f64; N]> {
        while self.legs.len() > 1 && time > self.begin + self.legs[0].duration() {
            self.begin += self.legs[0].duration();
            self.legs = &self.legs[1..];
        }
        let leg = self.legs.first()?;
        Some(leg.at((time - self.begin).min(leg.duration())))
    }
}

/// Joints of a stream as those of the cell, which has no others.
fn padded<const N: usize>(joints: &[f64; 6]) -> [f64; N] {
    std::array::from_fn(|joint| joints.get(joint).copied().unwrap_or(0.0))
}

fn apart(a: Option<Point3<f64>>, b: Option<Point3<f64>>) -> f64 {
    a.zip(b).map_or(f64::INFINITY, |(a, b)| Vector3::norm(&(a - b)))
}
