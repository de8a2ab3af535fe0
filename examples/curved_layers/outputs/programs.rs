//! Robot programs of the whole print, as the controllers of the two cells take them.
//!
//! For the UR3 the stream of joints at the controller's 125 Hz, cut into files: a file ends where the arm rests with the
//! extruder off. One after the other they are the whole print. Each program begins at the home posture and ends there: it
//! comes down to its first path from above, and lifts off its last one. For the arm over the table targets on the part, with tilt and turn, at the speed of the deposition; the controller splits them itself.
//!
//! All files appear when the last of them is written, or none.

use crate::args::failure;
use crate::motion::MotionRun;
use crate::motion::args::{MotionArgs, ProgramFormat};
use crate::motion::read_back::read_back;
use curvlay_examples::args::Failure;
use curvlay_examples::count::counted;
use curvlay_examples::findings::{Findings, Severity};
use curvlay_examples::motion::NO_HOME;
use curvlay_examples::motion::programs::{
    blended, blended_options, pieces, program_name, stream, takes_stream, targets, urscript_options,
};
use curvlay_examples::motion::read_back::{MAX_FILAMENT_SHARE, MAX_OFF_MM, ReadBack};
use curvlay_examples::motion::{TargetFormat, TargetLanguage, TargetProgram, write_targets};
use curvlay_examples::output::{OutputError, OutputFolder, Unfinished, is_numbered};
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_kinematics::print_program::StreamOptions;
use curvlay_kinematics::program::{
    ProgramLimits, Step, UrExtruder, UrScriptOptions, WriteError, write_csv, write_csv_on_track, write_urscript,
};
use curvlay_kinematics::workcell::Workcell;
use curvlay_trajectory::print::PrintPlan;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::ops::Range;

/// What came of it.
#[derive(Default)]
pub struct Programs {
    pub files: usize,
    pub steps: u64,
    pub bytes: u64,
    /// Motions that are in none of them, since they are not safe.
    pub withheld: usize,
    /// Motions, or moves, without a step, since the controller has no pose for them.
    pub dropped: u64,
    /// Moves whose speed the controller does not take, so that it is another one.
    pub clamped: u64,
    /// Why there are none.
    pub refused: Option<String>,
    /// What they hold, read again.
    pub read: Option<ReadBack>,
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

/// Writes the programs of a print; none where it has no motion. Motions that the check has found to be unsafe are in none of them.
/// What the controller refuses is no program, but no reason to leave the rest out.
pub fn products<const N: usize, const F: usize, W: Workcell<N, F>>(
    run: &MotionRun<N, F, W>,
    args: &MotionArgs,
    format: ProgramFormat,
    folder: &OutputFolder,
) -> Result<Programs, Failure> {
    let (most, extruder) = (args.program_steps, args.extruder.ur_extruder.0);
    let (cell, plan, withheld) = (&run.cell, &run.plan, run.withheld);
    let none = Programs { withheld, ..Programs::default() };
    if format == ProgramFormat::None || plan.runs.is_empty() {
        return Ok(none);
    }
    if run.home.is_none() {
        return Ok(Programs { refused: Some(NO_HOME.to_owned()), ..none });
    }
    if !run.unsafe_motions().is_empty() {
        let why = "motions are unsafe (motion-check.csv): programs are not written";
        return Ok(Programs { refused: Some(why.to_owned()), ..none });
    }
    let is_stream = takes_stream(cell.equipment()).unwrap_or(false);
    let written = match format {
        ProgramFormat::UrscriptMovep => blends(cell, plan, extruder, folder),
        ProgramFormat::Krl => modules(cell, plan, (TargetLanguage::Krl, most), folder),
        ProgramFormat::Tp => modules(cell, plan, (TargetLanguage::Tp, most), folder),
        ProgramFormat::Rapid => modules(cell, plan, (TargetLanguage::Rapid, most), folder),
        _ if is_stream => streams(cell, plan, (format, extruder), folder),
        _ => csv_targets(cell, plan, folder),
    };
    match written {
        Ok(programs) => {
            let read = Some(read_back(run, format, folder.path())?);
            Ok(Programs { withheld, read, ..programs })
        }
        Err(Trouble::Refused(error)) => Ok(Programs { refused: Some(error.to_string()), ..none }),
        Err(Trouble::Failed(failure)) => Err(failure),
    }
}

/// Programs of joints over time, for arms of Universal Robots.
fn streams<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    plan: &PrintPlan<N, F>,
    (format, extruder): (ProgramFormat, UrExtruder),
    folder: &OutputFolder,
) -> Result<Programs, Trouble> {
    let limits = ProgramLimits::of_arm(cell.equipment().arm());
    let ending = if format == ProgramFormat::Csv { "csv" } else { "script" };
    let write = |piece: Range<usize>, name: &str, out: &mut dyn Write| {
        let (steps, runs) = (stream(cell, plan, piece.clone()), piece);
        if format == ProgramFormat::Csv {
            return write_csv(steps, &limits, out).map(|()| 0);
        }
        let options = UrScriptOptions { extruder, ..with_ends(urscript_options(cell, plan, name), plan, runs) };
        write_urscript(steps, &options, out).map(|_| 0)
    };
    let steps = |piece: Range<usize>| {
        plan.segments(piece).map(|leg| leg.duration()).sum::<f64>()
            / StreamOptions::of_workcell(cell.equipment()).rate.seconds()
    };
    of_pieces(plan, steps, ending, folder, write)
}

/// Programs of lines with blends, for arms of Universal Robots.
fn blends<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    plan: &PrintPlan<N, F>,
    extruder: UrExtruder,
    folder: &OutputFolder,
) -> Result<Programs, Trouble> {
    let write = |piece: Range<usize>, name: &str, out: &mut dyn Write| {
        let options = with_ends(blended_options(cell, plan, name), plan, piece.clone());
        let options = UrScriptOptions { extruder, ..options };
        let mut steps = blended(cell, plan, piece);
        write_urscript(&mut steps, &options, out)?;
        Ok(steps.dropped())
    };
    let steps = |piece: Range<usize>| blended(cell, plan, piece).count() as f64;
    of_pieces(plan, steps, "script", folder, write)
}

/// Options of a script whose head says at which joints it begins and ends.
fn with_ends<const N: usize, const F: usize>(
    options: UrScriptOptions,
    plan: &PrintPlan<N, F>,
    piece: Range<usize>,
) -> UrScriptOptions {
    let ends = plan.segments(piece).fold([None; 2], |[first, _]: [Option<[f64; N]>; 2], segment| {
        [first.or(Some(segment.at(0.0))), Some(segment.at(segment.duration()))]
    });
    let said = |joints: [f64; N]| joints.map(|angle| format!("{:.2}", angle.to_degrees())).join(", ");
    let remark = match ends.map(|end| end.map(said)) {
        [Some(first), Some(last)] if first == last => Some(format!("Begins and ends at joints {first} degrees.")),
        [Some(first), Some(last)] => Some(format!("Begins at joints {first}, ends at {last} degrees.")),
        _ => None,
    };
    UrScriptOptions { remark, ..options }
}

/// Programs of targets on the part, with the axes of a table, in CSV.
fn csv_targets<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    plan: &PrintPlan<N, F>,
    folder: &OutputFolder,
) -> Result<Programs, Trouble> {
    let limits = ProgramLimits::of_arm(cell.equipment().arm());
    let is_track = cell.equipment().track().is_some();
    let write = |piece: Range<usize>, _: &str, out: &mut dyn Write| {
        let mut steps = targets(cell, plan, piece);
        match is_track {
            true => write_csv_on_track(&mut steps, &limits, out)?,
            false => write_csv(&mut steps, &limits, out)?,
        }
        Ok(steps.dropped())
    };
    let moves = |piece| targets(cell, plan, piece).filter(|step| matches!(step, Step::Move(_))).count() as f64;
    of_pieces(plan, moves, "csv", folder, write)
}

/// The same in a language whose programs are a main and modules: a program for all that hangs together; it is cut into modules by the writer.
fn modules<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    plan: &PrintPlan<N, F>,
    (language, moves_per_file): (TargetLanguage, Option<u32>),
    folder: &OutputFolder,
) -> Result<Programs, Trouble> {
    let pieces = pieces(plan);
    let (mut programs, mut unfinished, mut list) = (Programs::default(), Vec::new(), String::from(LIST_HEAD));
    for (number, piece) in pieces.iter().enumerate() {
        let name = program_name(pieces.len(), number);
        let before = unfinished.len();
        let mut open = |name: &str| -> io::Result<BufWriter<File>> {
            let (begun, file) = folder.begin(name)?;
            unfinished.push(begun);
            Ok(BufWriter::new(file))
        };
        let mut steps = targets(cell, plan, piece.clone());
        let format = TargetFormat { name, language, moves_per_file, max_filament_mm_s: plan.max_filament_mm_s() };
        let TargetProgram { main, moves, speeds_clamped } =
            write_targets(&mut steps, cell.equipment(), &format, &mut open)?;
        programs.dropped += steps.dropped();
        programs.clamped += speeds_clamped;
        programs.files += unfinished.len() - before;
        programs.steps += moves;
        list += &listed(plan, piece, &main, moves);
    }
    for file in unfinished {
        programs.bytes += file.finish()?;
    }
    folder.write("programs.csv", list)?;
    Ok(programs)
}

/// Whether a file of this name is a program: `print_001.script` or `.csv`; in RAPID `print.mod` with its modules `print_001.mod`, or `print1.mod`
/// with its modules `print1_001.mod`; in KRL the same with `.src`, and `print.dat`; in TP with `.ls`.
pub fn is_ours(name: &str) -> bool {
    let of = |ending: &str| {
        let Some(stem) = name.strip_suffix(ending) else { return false };
        let module = stem.rsplit_once('_');
        stem == "print"
            || is_numbered(stem, "print", 1, "")
            || is_numbered(stem, "print_", 3, "")
            || module
                .is_some_and(|(piece, module)| is_numbered(piece, "print", 1, "") && is_numbered(module, "", 3, ""))
    };
    [".script", ".csv"].iter().any(|ending| is_numbered(name, "print_", 3, ending))
        || [".mod", ".src", ".dat", ".ls"].into_iter().any(of)
}

/// The first line of `programs.csv`.
const LIST_HEAD: &str = "file,steps,first_layer,last_layer,begins\n";

/// A line of `programs.csv`.
fn listed<const N: usize, const F: usize>(
    plan: &PrintPlan<N, F>,
    piece: &Range<usize>,
    file: &str,
    steps: u64,
) -> String {
    let [first, last] = [piece.start, piece.end - 1].map(|at| plan.runs[at].layer + 1);
    format!("{file},{steps},{first},{last},at home\n")
}

/// A file for each program, and a list of them.
fn of_pieces<const N: usize, const F: usize>(
    plan: &PrintPlan<N, F>,
    steps: impl Fn(Range<usize>) -> f64,
    ending: &str,
    folder: &OutputFolder,
    write: impl Fn(Range<usize>, &str, &mut dyn Write) -> Result<u64, WriteError>,
) -> Result<Programs, Trouble> {
    let mut unfinished: Vec<Unfinished> = Vec::new();
    let mut programs = Programs::default();
    let mut list = String::from(LIST_HEAD);
    for (number, piece) in pieces(plan).into_iter().enumerate() {
        let name = format!("print_{:03}", number + 1);
        let file_name = format!("{name}.{ending}");
        let (begun, file) =
            folder.begin(&file_name).map_err(|source| WriteError::Io { file: file_name.clone(), source })?;
        let mut file = BufWriter::new(file);
        programs.dropped += write(piece.clone(), &name, &mut file)?;
        file.flush().map_err(|source| WriteError::Io { file: file_name.clone(), source })?;
        unfinished.push(begun);
        let steps = steps(piece.clone()).ceil() as u64;
        list += &listed(plan, &piece, &file_name, steps);
        programs.files += 1;
        programs.steps += steps;
    }
    for file in unfinished {
        programs.bytes += file.finish()?;
    }
    folder.write("programs.csv", list)?;
    Ok(programs)
}

pub fn summary(run: &Programs, summary: &mut Summary) -> Result<(), Failure> {
    summary
        .set("program_files", run.files)?
        .set("program_steps", run.steps)?
        .set("program_bytes", run.bytes)?
        .set("program_withheld", run.withheld)?
        .set("program_dropped", run.dropped)?
        .set("program_speeds_clamped", run.clamped)?
        .set("program_refused", run.refused.as_deref().unwrap_or(""))?;
    if let Some(read) = &run.read {
        summary
            .set("program_not_at_home", read.not_at_home)?
            .set("program_filament_mm", read.filament_mm)?
            .set("program_off_mm", read.off_mm)?
            .set("program_travel_mm_s", read.travel_mm_s)?;
    }
    Ok(())
}

/// What the programs were found to hold, but should not, and what they lack.
pub fn find(run: &Programs, fastest_mm_s: f64, findings: &mut Findings) {
    if let Some(why) = &run.refused {
        findings.add(Severity::Failed, "no programs were written", why, "--program");
    }
    if run.dropped > 0 {
        let amount = counted(run.dropped as usize, "motion");
        findings
            .explain(Severity::Failed, "programs lack motions", amount, "programs.csv")
            .cause("the controller has no pose for a posture: a table beyond its limits");
    }
    if run.clamped > 0 {
        let amount = counted(run.clamped as usize, "move");
        findings.explain(Severity::Warning, "moves have another speed than planned", amount, "programs.csv").cause(
            "the controller takes no such speed: moves by joints go from 1 to 100 percent, and turning has limits",
        );
    }
    let Some(ReadBack { programs, not_at_home, filament_mm, planned_mm, off_mm, travel_mm_s }) = run.read else {
        return;
    };
    if not_at_home > 0 {
        let amount = format!("{not_at_home} of {programs}");
        findings.add(Severity::Failed, "programs do not begin and end at home", amount, "programs.csv");
    }
    if (filament_mm - planned_mm).abs() > MAX_FILAMENT_SHARE * planned_mm {
        let amount = format!("{filament_mm:.1} instead of {planned_mm:.1} mm");
        findings.add(Severity::Failed, "programs do not lay the filament of the motions", amount, "programs.csv");
    }
    if off_mm > MAX_OFF_MM {
        let amount = format!("by {off_mm:.3} mm at most");
        findings.add(Severity::Failed, "programs leave the motions that were checked", amount, "programs.csv");
    }
    // Between two ticks.
    if travel_mm_s > 1.01 * fastest_mm_s {
        let amount = format!("{travel_mm_s:.0} mm/s, at most {fastest_mm_s:.0}");
        findings.add(Severity::Failed, "the tip travels faster than it may", amount, "programs.csv");
    }
}

pub fn rows(run: &Programs, table: &mut Table) {
    let written =
        format!("{}, {}, {:.1} MB", counted(run.files, "file"), counted(run.steps, "step"), run.bytes as f64 / 1e6);
    table.row(["programs".to_owned(), run.refused.clone().unwrap_or(written)]);
    if let Some(read) = &run.read {
        let laid = format!("{:.1} of {:.1} mm of filament", read.filament_mm, read.planned_mm);
        let off = format!("the tip within {:.4} mm of the checked motions", read.off_mm);
        table.row(["read again".to_owned(), format!("{laid}, {off}")]);
    }
}
