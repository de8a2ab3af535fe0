//! Robot programs of the whole print, as the controllers of the two cells take them.
//!
//! For the UR3 the stream of joints at the controller's 125 Hz, cut into files: a file ends where the arm rests with the
//! extruder off, and begins with a `movej` to its first posture. One after the other they are the whole print; where no
//! transfer was found the next file has to be approached by hand (`programs.csv` says which). For the arm over the table
//! targets on the part, with tilt and turn, at the speed of the deposition; the controller splits them itself.
//!
//! All files appear when the last of them is written, or none.

use crate::failure;
use crate::motion::{Motion, MotionRun, ProgramFormat};
use curvlay_examples::args::Failure;
use curvlay_examples::output::{OutputError, OutputFolder, Unfinished};
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_kinematics::Arm;
use curvlay_kinematics::program::{
    FILAMENT_FULL_SCALE_MM_S, Goal, Move, ProgramLimits, RapidOptions, RapidTool, RapidWorkObject, ServoRate, Speed,
    Step, UrScriptOptions, WriteError, Zone, write_csv, write_rapid, write_urscript,
};
use curvlay_kinematics::scene::Mount;
use curvlay_kinematics::workcell::{SixAxisCell, Workcell, tool_frame};
use curvlay_trajectory::Trajectory;
use curvlay_trajectory::print::{LegKind, Run, Travel};
use std::io::{BufWriter, Write};
use std::ops::Range;

/// Steps of a file: 13 minutes of motion in about 13 MB. B. Brooks (2016, section 4.14) could not load 180,000 lines.
const STREAM_STEPS: u32 = 100_000;

/// Moves of a RAPID module, half a megabyte.
const MODULE_MOVES: u32 = 5000;

/// How corners between waypoints are rounded, in millimetres.
const CORNER_MM: f64 = 0.3;

/// The tool may turn so much faster than the plan says, so that turning never holds a move up.
const TURN_SHARE: f64 = 2.0;
const LEAST_TURN: f64 = 0.5;

/// The speed of the filament is written again where it changes by more than this share.
const SAME_SPEED: f64 = 2e-3;

/// Postures of a program of targets by which the nozzle lifts off, and by which it comes down.
const LIFT_POSTURES: u32 = 4;

/// Slower than this, in mm/s, is written as this: the way is a matter of micrometres.
const LEAST_SPEED: f64 = 0.01;

/// What came of it.
#[derive(Default)]
pub struct Programs {
    pub files: usize,
    pub steps: u64,
    pub bytes: u64,
    /// Why there are none.
    pub refused: Option<String>,
}

/// Some motions, with the transfers behind them, that make a file.
struct Piece {
    runs: Range<usize>,
    /// Steps; of a stream with fractions, since motions do not end on its ticks.
    steps: f64,
    /// Whether it begins where the piece before ends.
    joined: bool,
}

/// Why files are not finished.
enum Trouble {
    Refused(WriteError),
    Failed(Failure),
}

impl From<WriteError> for Trouble {
    fn from(error: WriteError) -> Self {
        match error {
            WriteError::Io { .. } => Trouble::Failed(failure(error)),
            refused => Trouble::Refused(refused),
        }
    }
}

impl From<OutputError> for Trouble {
    fn from(error: OutputError) -> Self {
        Trouble::Failed(failure(error))
    }
}

/// Writes the programs of a print; none where it has no motion. What the controller refuses is no program, but no reason
/// to leave the rest out.
pub fn products(
    motion: &Motion,
    format: ProgramFormat,
    most: Option<u32>,
    folder: &OutputFolder,
) -> Result<Programs, Failure> {
    if format == ProgramFormat::None || motion.is_empty() {
        return Ok(Programs::default());
    }
    let written = match (motion, format) {
        (Motion::Six(run), ProgramFormat::Urscript | ProgramFormat::Csv) => of_streams(run, format, most, folder),
        (Motion::Six(run), _) => of_targets(run, format, most, folder),
        (Motion::Eight(run), _) => of_targets(run, format, most, folder),
    };
    match written {
        Ok(programs) => Ok(programs),
        Err(Trouble::Refused(error)) => Ok(Programs { refused: Some(error.to_string()), ..Programs::default() }),
        Err(Trouble::Failed(failure)) => Err(failure),
    }
}

/// Programs of joints over time, for arms of Universal Robots.
fn of_streams(
    run: &MotionRun<6, 1, SixAxisCell>,
    format: ProgramFormat,
    most: Option<u32>,
    folder: &OutputFolder,
) -> Result<Programs, Trouble> {
    let most = u64::from(most.unwrap_or(STREAM_STEPS));
    let pieces = pieces(run, most, |run, travel| {
        (run.duration() + travel.map_or(0.0, Travel::duration)) / ServoRate::Hz125.seconds()
    });
    let limits = limits(run.cell.equipment().arm());
    let filament_full_scale_mm_s = fastest_filament(run).max(FILAMENT_FULL_SCALE_MM_S);
    let ending = if format == ProgramFormat::Csv { "csv" } else { "script" };
    let write = |piece: &Piece, name: &str, out: &mut dyn Write| {
        let steps = stream(run, piece);
        if format == ProgramFormat::Csv {
            return write_csv(steps, &limits, out);
        }
        let options =
            UrScriptOptions { name: name.to_owned(), limits, filament_full_scale_mm_s, ..UrScriptOptions::default() };
        write_urscript(steps, &options, out)
    };
    of_pieces(run, &pieces, ending, folder, write)
}

/// Programs of targets on the part, with the axes of a table.
fn of_targets<const N: usize, const F: usize, W: Workcell<N, F>>(
    run: &MotionRun<N, F, W>,
    format: ProgramFormat,
    most: Option<u32>,
    folder: &OutputFolder,
) -> Result<Programs, Trouble> {
    let moves = |motion: &Run<N, F>, travel: Option<&Travel<N>>| {
        let corners = travel.map_or(0, |travel| travel.way.corners().len() + 2 * LIFT_POSTURES as usize);
        (motion.passes.len() + 2 + corners) as f64
    };
    let limits = limits(run.cell.equipment().arm());
    if format == ProgramFormat::Csv {
        let pieces = pieces(run, u64::from(most.unwrap_or(STREAM_STEPS)), moves);
        let write = |piece: &Piece, _: &str, out: &mut dyn Write| write_csv(targets(run, &piece.runs), &limits, out);
        return of_pieces(run, &pieces, "csv", folder, write);
    }
    // A program for all that hangs together; it is cut into modules by the writer.
    let pieces = pieces(run, u64::MAX, moves);
    let (mut programs, mut unfinished) = (Programs::default(), Vec::new());
    for (number, piece) in pieces.iter().enumerate() {
        let name = if pieces.len() == 1 { "print".to_owned() } else { format!("print{}", number + 1) };
        let options = rapid(run, name, most.unwrap_or(MODULE_MOVES), limits);
        let done = write_rapid(targets(run, &piece.runs), &options, |name| {
            let (begun, file) = folder.begin(name)?;
            unfinished.push(begun);
            Ok(file)
        })?;
        programs.files += done.modules as usize + 1;
        programs.steps += done.moves;
    }
    for file in unfinished {
        programs.bytes += file.finish()?;
    }
    Ok(programs)
}

/// Cuts the print: where no transfer leads on, and before a motion with which a file would have too many steps.
fn pieces<const N: usize, const F: usize, R>(
    run: &MotionRun<N, F, R>,
    most: u64,
    steps: impl Fn(&Run<N, F>, Option<&Travel<N>>) -> f64,
) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut joined = false;
    for (number, motion) in run.plan.runs.iter().enumerate() {
        let travel = run.plan.travels.get(number).and_then(Option::as_ref);
        let more = steps(motion, travel);
        match pieces.last_mut() {
            Some(last) if joined && last.steps + more <= most as f64 => {
                last.runs.end = number + 1;
                last.steps += more;
            }
            _ => pieces.push(Piece { runs: number..number + 1, steps: more, joined }),
        }
        joined = travel.is_some();
    }
    pieces
}

/// A file for each piece, and a list of them.
fn of_pieces<const N: usize, const F: usize, R>(
    run: &MotionRun<N, F, R>,
    pieces: &[Piece],
    ending: &str,
    folder: &OutputFolder,
    write: impl Fn(&Piece, &str, &mut dyn Write) -> Result<(), WriteError>,
) -> Result<Programs, Trouble> {
    let mut unfinished: Vec<Unfinished> = Vec::new();
    let mut list = String::from("file,steps,first_layer,last_layer,begins\n");
    for (number, piece) in pieces.iter().enumerate() {
        let name = format!("print_{:03}", number + 1);
        let file_name = format!("{name}.{ending}");
        let (begun, file) =
            folder.begin(&file_name).map_err(|source| WriteError::Io { file: file_name.clone(), source })?;
        let mut file = BufWriter::new(file);
        write(piece, &name, &mut file)?;
        file.flush().map_err(|source| WriteError::Io { file: file_name.clone(), source })?;
        unfinished.push(begun);
        let [first, last] = [piece.runs.start, piece.runs.end - 1].map(|at| run.plan.runs[at].layer + 1);
        let begins = match (number, piece.joined) {
            (0, _) => "first",
            (_, true) => "where the one before ends",
            _ => "apart: bring the robot there by hand",
        };
        list += &format!("{file_name},{},{first},{last},{begins}\n", piece.steps.ceil());
    }
    let mut programs = Programs { files: pieces.len(), ..Programs::default() };
    programs.steps = pieces.iter().map(|piece| piece.steps.ceil() as u64).sum();
    for file in unfinished {
        programs.bytes += file.finish()?;
    }
    folder.write("programs.csv", list)?;
    Ok(programs)
}

/// No filament is faster than this anywhere in the print, in whole millimetres a second.
fn fastest_filament<const N: usize, const F: usize, R>(run: &MotionRun<N, F, R>) -> f64 {
    let of_run = |run: &Run<N, F>| {
        let knots = run.trajectory.times().windows(2).zip(run.filament_mm.windows(2));
        knots.map(|(times, laid)| (laid[1] - laid[0]) / (times[1] - times[0])).fold(0.0, f64::max)
    };
    run.plan.runs.iter().map(of_run).fold(0.0, f64::max).ceil()
}

/// To the first posture, then the motions themselves at every tick, the extruder on while the nozzle prints.
fn stream<'a, R>(run: &'a MotionRun<6, 1, R>, piece: &Piece) -> impl Iterator<Item = Step> + 'a {
    let period = ServoRate::Hz125.seconds();
    let first = run.plan.runs[piece.runs.start].trajectory.joints()[0];
    let approach = Move { goal: Goal::Joints(first), table: None, speed: Speed::default(), zone: Zone::Stop };
    let ticks = piece.steps.ceil() as u64;
    let mut begin = 0.0;
    let along = run.plan.legs(piece.runs.clone()).flat_map(move |leg| {
        let (from, to) = (begin, begin + leg.duration());
        begin = to;
        let of_leg = move |tick: &u64| *tick as f64 * period <= to;
        let first = (from / period).floor() as u64 + 1;
        let prints = leg.kind == LegKind::Print;
        let signal = move |on| prints.then_some(Step::Extruder(on));
        let mut speed = 0.0;
        let servo = (first..=ticks).take_while(of_leg).flat_map(move |tick| {
            let now = tick as f64 * period - from;
            let needed = (leg.filament_mm(now) - leg.filament_mm(now - period)).max(0.0) / period;
            // Steady speeds are written once.
            let changes = prints && (needed - speed).abs() > SAME_SPEED * speed;
            speed = if changes { needed } else { speed };
            let servo = Step::Servo { joints: leg.at(now), seconds: period };
            changes.then_some(Step::FilamentSpeed(speed)).into_iter().chain([servo])
        });
        let end = prints.then_some(Step::FilamentSpeed(0.0));
        signal(true).into_iter().chain(servo).chain(end).chain(signal(false))
    });
    let last = &run.plan.runs[piece.runs.end - 1];
    let end = run.plan.travels.get(piece.runs.end - 1).and_then(Option::as_ref);
    let joints = end.map_or(&last.trajectory, |travel| &travel.approach).joints();
    let rest = Step::Servo { joints: joints[joints.len() - 1], seconds: period };
    // The end lies between two ticks.
    [Step::Move(approach)].into_iter().chain(along).chain([rest])
}

/// To each motion by joints, along it by targets on the part, and on by the corners of the transfer.
fn targets<'a, const N: usize, const F: usize, W: Workcell<N, F>>(
    run: &'a MotionRun<N, F, W>,
    runs: &Range<usize>,
) -> impl Iterator<Item = Step> + 'a {
    let by_joints = move |joints: &[f64; N]| {
        let place = run.cell.controller_pose(joints)?;
        let goal = Goal::Joints(place.joints);
        Some(Step::Move(Move { goal, table: place.table, speed: Speed::default(), zone: Zone::Stop }))
    };
    let sampled = move |motion: &Trajectory<N>| {
        let (first, last) = motion.span();
        let at = |k: u32| motion.at(first + (last - first) * f64::from(k) / f64::from(LIFT_POSTURES)).position;
        (1..=LIFT_POSTURES).map(at).collect::<Vec<_>>()
    };
    runs.clone().flat_map(move |number| {
        let motion = &run.plan.runs[number];
        let (all, times) = (motion.trajectory.joints(), motion.trajectory.times());
        let along = motion.passes.windows(2).enumerate().filter_map(move |(k, pair)| {
            let [a, b] = [pair[0].0, pair[1].0];
            let (from, to) = (run.cell.controller_pose(&all[a])?, run.cell.controller_pose(&all[b])?);
            let step = times[b] - times[a];
            let mm_s = (to.target.pose.translation.vector - from.target.pose.translation.vector).norm() / step;
            let turn = from.target.pose.rotation.angle_to(&to.target.pose.rotation) / step;
            let speed = Speed { mm_s: mm_s.max(LEAST_SPEED), rad_s: (TURN_SHARE * turn).max(LEAST_TURN) };
            let zone = if k + 2 == motion.passes.len() { Zone::Stop } else { Zone::Blend(CORNER_MM) };
            let filament = Step::FilamentSpeed((motion.filament_mm[b] - motion.filament_mm[a]).max(0.0) / step);
            Some([filament, Step::Move(Move { goal: Goal::Line(to.target), table: to.table, speed, zone })])
        });
        let begin = by_joints(&all[0]).into_iter().chain([Step::Extruder(true)]);
        let travel = run.plan.travels.get(number).and_then(Option::as_ref).into_iter();
        let end = travel.flat_map(move |travel| {
            let corners = sampled(&travel.lift).into_iter().chain(travel.way.corners().iter().copied());
            corners.chain(sampled(&travel.approach)).filter_map(move |joints| by_joints(&joints))
        });
        begin.chain(along.flatten()).chain([Step::FilamentSpeed(0.0), Step::Extruder(false)]).chain(end)
    })
}

/// What splines may pass the limits by, so that a motion at its limit is not refused.
const SLACK: f64 = 2e-6;

fn limits(arm: &Arm) -> ProgramLimits {
    let mut joints = *arm.limits();
    for joint in 0..6 {
        joints.lower[joint] -= SLACK;
        joints.upper[joint] += SLACK;
        joints.velocity[joint] *= 1.0 + SLACK;
    }
    ProgramLimits { joints, ..ProgramLimits::default() }
}

fn rapid<const N: usize, const F: usize, W: Workcell<N, F>>(
    run: &MotionRun<N, F, W>,
    name: String,
    most: u32,
    limits: ProgramLimits,
) -> RapidOptions {
    let defaults = RapidOptions::default();
    let equipment = run.cell.equipment();
    let ((held, nozzle), (carrier, frame)) = (equipment.nozzle_frame(), equipment.part_frame());
    let in_hand = |mount| matches!(mount, Mount::Link(_));
    let tool =
        RapidTool { name: "nozzle".to_owned(), in_hand: in_hand(held), frame: tool_frame(&nozzle), ..defaults.tool };
    let unit = equipment.positioner().map(|_| "STN1".to_owned());
    let work_object = RapidWorkObject { name: "part".to_owned(), in_hand: in_hand(carrier), frame, unit };
    RapidOptions { name, tool, work_object, moves_per_module: most, limits, ..defaults }
}

pub fn summary(run: &Programs, summary: &mut Summary) -> Result<(), Failure> {
    summary
        .set("program_files", run.files)?
        .set("program_steps", run.steps)?
        .set("program_bytes", run.bytes)?
        .set("program_refused", run.refused.as_deref().unwrap_or(""))?;
    Ok(())
}

pub fn rows(run: &Programs, table: &mut Table) {
    let written = format!("{} files, {} steps, {:.1} MB", run.files, run.steps, run.bytes as f64 / 1e6);
    table.row(["programs".to_owned(), run.refused.clone().unwrap_or(written)]);
}
