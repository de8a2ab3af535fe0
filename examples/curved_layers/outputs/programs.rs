//! Robot programs of the whole print, as the controllers of the two cells take them.
//!
//! For the UR3 the stream of joints at the controller's 125 Hz, cut into files: a file ends where the arm rests with the
//! extruder off, and begins with a `movej` to its first posture. One after the other they are the whole print; where no
//! transfer was found the next file has to be approached by hand (`programs.csv` says which). For the arm over the table
//! targets on the part, with tilt and turn, at the speed of the deposition; the controller splits them itself.
//!
//! All files appear when the last of them is written, or none.

use crate::failure;
use crate::motion::robots::{Printer, out_of};
use crate::motion::{Motion, MotionArgs, MotionRun, ProgramFormat, Run};
use curvlay_examples::args::Failure;
use curvlay_examples::motion::{OverTable, PartInHand};
use curvlay_examples::output::{OutputError, OutputFolder, Unfinished};
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_kinematics::Arm;
use curvlay_kinematics::program::{
    Goal, Move, ProgramLimits, RapidOptions, RapidTool, RapidWorkObject, ServoRate, Speed, Step, UrScriptOptions,
    WriteError, Zone, write_csv, write_rapid, write_urscript,
};
use curvlay_trajectory::transfer::Transfer;
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
    steps: u64,
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
pub fn products(motion: &Motion, args: &MotionArgs, folder: &OutputFolder) -> Result<Programs, Failure> {
    let (format, most) = (args.format()?, args.program_steps);
    if format == ProgramFormat::None || motion.figures().motions == 0 {
        return Ok(Programs::default());
    }
    let written = match motion {
        Motion::PartInHand(run) => of_streams(run, format, most, folder),
        Motion::OverTable(run) => of_targets(run, format, most, folder),
    };
    match written {
        Ok(programs) => Ok(programs),
        Err(Trouble::Refused(error)) => Ok(Programs { refused: Some(error.to_string()), ..Programs::default() }),
        Err(Trouble::Failed(failure)) => Err(failure),
    }
}

/// Programs of joints over time, for the UR3.
fn of_streams(
    run: &MotionRun<6, 1, PartInHand>,
    format: ProgramFormat,
    most: Option<u32>,
    folder: &OutputFolder,
) -> Result<Programs, Trouble> {
    let most = u64::from(most.unwrap_or(STREAM_STEPS));
    let pieces = pieces(run, most, |run, transfer| ticks(run.duration()) + transfer.map_or(0, |t| ticks(t.duration())));
    let limits = limits(run.robot.cell().arm());
    let ending = if format == ProgramFormat::Csv { "csv" } else { "script" };
    let write = |piece: &Piece, name: &str, out: &mut dyn Write| {
        let steps = stream(run, &piece.runs);
        if format == ProgramFormat::Csv {
            return write_csv(steps, &limits, out);
        }
        let options = UrScriptOptions { name: name.to_owned(), limits, ..UrScriptOptions::default() };
        write_urscript(steps, &options, out)
    };
    of_pieces(run, &pieces, ending, folder, write)
}

/// Programs of targets with the axes of the table, for the arm over it.
fn of_targets(
    run: &MotionRun<8, 2, OverTable>,
    format: ProgramFormat,
    most: Option<u32>,
    folder: &OutputFolder,
) -> Result<Programs, Trouble> {
    let moves = |motion: &Run<8, 2>, transfer: Option<&Transfer<8>>| {
        (motion.trajectory.at_waypoints().len() + 2 + transfer.map_or(0, |t| t.corners().len())) as u64
    };
    let limits = limits(run.robot.cell().arm());
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
    steps: impl Fn(&Run<N, F>, Option<&Transfer<N>>) -> u64,
) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut joined = false;
    for (number, motion) in run.runs.iter().enumerate() {
        let transfer = run.transfers.get(number).and_then(Option::as_ref);
        let more = steps(motion, transfer);
        match pieces.last_mut() {
            Some(last) if joined && last.steps + more <= most => {
                last.runs.end = number + 1;
                last.steps += more;
            }
            _ => pieces.push(Piece { runs: number..number + 1, steps: more, joined }),
        }
        joined = transfer.is_some();
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
        let [first, last] = [piece.runs.start, piece.runs.end - 1].map(|at| run.runs[at].layer + 1);
        let begins = match (number, piece.joined) {
            (0, _) => "first",
            (_, true) => "where the one before ends",
            _ => "apart: bring the robot there by hand",
        };
        list += &format!("{file_name},{},{first},{last},{begins}\n", piece.steps);
    }
    let mut programs = Programs { files: pieces.len(), ..Programs::default() };
    programs.steps = pieces.iter().map(|piece| piece.steps).sum();
    for file in unfinished {
        programs.bytes += file.finish()?;
    }
    folder.write("programs.csv", list)?;
    Ok(programs)
}

/// Steps of the stream for a motion of so many seconds, which begins and ends at rest.
fn ticks(seconds: f64) -> u64 {
    (seconds / ServoRate::Hz125.seconds()).ceil() as u64
}

/// To the first posture, then the splines and the transfers themselves at every tick.
fn stream<'a, R>(run: &'a MotionRun<6, 1, R>, runs: &Range<usize>) -> impl Iterator<Item = Step> + 'a {
    let period = ServoRate::Hz125.seconds();
    let first = run.runs[runs.start].trajectory.joints()[0];
    let approach = Move { goal: Goal::Joints(first), table: None, speed: Speed::default(), zone: Zone::Stop };
    let along = runs.clone().flat_map(move |number| {
        let motion = &run.runs[number];
        let start = motion.trajectory.span().0;
        let [on, off] = motion.printing().map(|time| ((time - start) / period).ceil() as u64);
        let printing = (1..=ticks(motion.duration())).flat_map(move |tick| {
            let joints = motion.trajectory.at(start + tick as f64 * period).position;
            let signals = [(on, true), (off, false)].into_iter().filter(move |(at, _)| *at == tick);
            signals.map(|(_, on)| Step::Extruder(on)).chain([Step::Servo { joints, seconds: period }])
        });
        let moving = run.transfers.get(number).and_then(Option::as_ref).into_iter().flat_map(move |transfer| {
            (1..=ticks(transfer.duration())).map(move |tick| {
                let joints = transfer.at(tick as f64 * period).position;
                Step::Servo { joints, seconds: period }
            })
        });
        printing.chain(moving)
    });
    [Step::Move(approach)].into_iter().chain(along)
}

/// To each motion by joints, along it by targets on the part, and on by the corners of the transfer.
fn targets<'a, R: Printer<8, 2>>(run: &'a MotionRun<8, 2, R>, runs: &Range<usize>) -> impl Iterator<Item = Step> + 'a {
    let by_joints = move |joints: &[f64; 8]| {
        let place = run.robot.placement(joints)?;
        let goal = Goal::Joints(place.joints);
        Some(Step::Move(Move { goal, table: place.table, speed: Speed::default(), zone: Zone::Stop }))
    };
    runs.clone().flat_map(move |number| {
        let motion = &run.runs[number];
        let joints = motion.trajectory.at_waypoints();
        let before = (motion.trajectory.times().len() - joints.len()) / 2;
        let times = &motion.trajectory.times()[before..before + joints.len()];
        let along = (1..joints.len()).filter_map(move |k| {
            let (from, to) = (run.robot.placement(&joints[k - 1])?, run.robot.placement(&joints[k])?);
            let step = times[k] - times[k - 1];
            let mm_s = (to.target.pose.translation.vector - from.target.pose.translation.vector).norm() / step;
            let turn = from.target.pose.rotation.angle_to(&to.target.pose.rotation) / step;
            let speed = Speed { mm_s: mm_s.max(LEAST_SPEED), rad_s: (TURN_SHARE * turn).max(LEAST_TURN) };
            let zone = if k + 1 == joints.len() { Zone::Stop } else { Zone::Blend(CORNER_MM) };
            Some(Step::Move(Move { goal: Goal::Line(to.target), table: to.table, speed, zone }))
        });
        let begin = by_joints(&joints[0]).into_iter().chain([Step::Extruder(true)]);
        let end = run.transfers.get(number).and_then(Option::as_ref).into_iter();
        let end = end.flat_map(move |transfer| transfer.corners().iter().filter_map(by_joints));
        begin.chain(along).chain([Step::Extruder(false)]).chain(end)
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

fn rapid(run: &MotionRun<8, 2, OverTable>, name: String, most: u32, limits: ProgramLimits) -> RapidOptions {
    let defaults = RapidOptions::default();
    let (_, nozzle) = run.robot.nozzle();
    let (_, table_part) = run.robot.part_frame();
    let tool = RapidTool { name: "nozzle".to_owned(), frame: out_of(&nozzle), ..defaults.tool };
    let work_object =
        RapidWorkObject { name: "part".to_owned(), in_hand: false, frame: table_part, unit: Some("STN1".to_owned()) };
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
