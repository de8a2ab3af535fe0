//! Reads the program and lets the controller execute it, tick by tick.

use super::chosen::Reading;
use super::controller::{Controller, Tick};
use super::court::Court;
use super::machine::{Machine, ToolFrames};
use super::program::command::Place;
use super::program::{FlavourProgram, GcodeProgram, Kind, RobotProgram, Source};
use super::setup::Setup;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::input::{self, InputError};
use curvlay_examples::waypoints::fault;
use std::fs::File;
use std::io::{BufReader, Take};
use std::path::Path;

/// What came of a program, beside what the judges say.
#[derive(Clone, Debug, PartialEq)]
pub struct Executed {
    /// Seconds that it takes.
    pub seconds: f64,
    /// Seconds at its own speeds and times, without accelerations.
    pub programmed_s: f64,
    /// What the controller could not do.
    pub obstacles: super::controller::Obstacles,
    /// Whether the extruder runs when it ends.
    pub ends_extruding: bool,
    /// The names of its files.
    pub files: Vec<String>,
}

fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// Executes the program before the judges.
///
/// # Errors
/// A [`Failure`] that names the file, and the line where there is one.
pub fn execute(setup: &Setup, court: &mut Court, bars: &Bars) -> Result<Executed, Failure> {
    let mut controller = Controller::new(&setup.model, &setup.machine);
    let mut files = Vec::new();
    let count = setup.files.paths.len() as u64;
    for (done, path) in (0u64..).zip(&setup.files.paths) {
        bars.update("replay", done, count);
        let number = files.len() as u32;
        files.push(name_of(path));
        let reader = BufReader::new(input::open(path, input::MAX_DATA_BYTES)?);
        let word = if setup.files.kind == Kind::Gcode { "line" } else { "step" };
        let mut take = |source: Source| take(&mut controller, court, source, word);
        let refused = |what: String| fault(path, &what);
        // A controller's path, such as `HOME:/parts/print_001.mod`: the file beside the main one.
        let open = |name: &str| {
            let name = name.rsplit(['/', '\\', ':']).next().unwrap_or(name);
            files.push(name.to_owned());
            beside(path, name).map_err(std::io::Error::other)
        };
        let has_table = matches!(&setup.machine, Machine::Robot(robot) if robot.axes() > 6);
        let mut program = RobotProgram::new(&mut take, has_table);
        match setup.files.kind {
            Kind::Gcode => gcode(setup, reader, number, &mut take).map_err(refused)?,
            Kind::UrScript => program.urscript(reader, number).map_err(refused)?,
            Kind::Csv => program.csv(reader, number, frames(setup)).map_err(refused)?,
            Kind::Rapid => program.rapid(reader, open, number).map_err(refused)?,
            Kind::Tp => program.tp(reader, open, number, frames(setup)).map_err(refused)?,
            Kind::Krl => {
                let data = path.with_extension("dat");
                let data = BufReader::new(input::open(&data, input::MAX_DATA_BYTES)?);
                program.krl([data, reader], open, number).map_err(refused)?;
            }
        }
    }
    controller.halt(Place::default(), &mut |tick: &Tick| court.take(tick));
    court.finish();
    if let (Some(what), Some(path)) = (&court.fault, &setup.plan) {
        return Err(fault(path, what));
    }
    if controller.obstacles.moves == 0 {
        return Err(fault(&setup.files.paths[0], &"there are no moves in it"));
    }
    Ok(Executed {
        seconds: controller.seconds(),
        programmed_s: controller.programmed_s,
        obstacles: controller.obstacles,
        ends_extruding: controller.extrudes(),
        files,
    })
}

fn take(controller: &mut Controller, court: &mut Court, source: Source, word: &str) -> Result<(), String> {
    match source {
        Source::Frames(frames) => controller.set_frames(frames, &mut |tick: &Tick| court.take(tick)),
        Source::Acceleration(mm_s2) => controller.set_acceleration(mm_s2),
        Source::Command(place, command) => {
            let done = controller.command(place, &command, &mut |tick: &Tick| court.take(tick));
            done.map_err(|fault| format!("{word} {}: {fault}", place.step))?;
        }
    }
    // What follows would be compared with nothing.
    court.fault.as_ref().map_or(Ok(()), |_| Err("the plan could not be read".to_owned()))
}

/// The frames of the workcell, for programs without frames of their own.
fn frames(setup: &Setup) -> ToolFrames {
    match &setup.machine {
        Machine::Robot(robot) => robot.frames(),
        Machine::FiveAxis(_) => unreachable!("a robot program on a printer"),
    }
}

fn beside(path: &Path, name: &str) -> Result<BufReader<Take<File>>, InputError> {
    input::open(&path.parent().unwrap_or(Path::new(".")).join(name), input::MAX_DATA_BYTES).map(BufReader::new)
}

fn gcode(
    setup: &Setup,
    reader: impl std::io::BufRead,
    number: u32,
    take: &mut impl FnMut(Source) -> Result<(), String>,
) -> Result<(), String> {
    let (Machine::FiveAxis(printer), Some(reading)) = (&setup.machine, &setup.reading) else { return Ok(()) };
    match reading {
        Reading::Plain(dialect) => {
            let mut program = GcodeProgram::new(reader, number, dialect.clone());
            while let Some((place, command)) = program.next_command().map_err(|error| error.to_string())? {
                take(Source::Command(place, command))?;
            }
        }
        Reading::Flavour(flavour) => {
            let mut program = FlavourProgram::new(reader, number, flavour, printer)?;
            let refused = |error| {
                format!("{error} (read as `{}`: --flavour names another one, `plain` is G-code of none)", flavour.name)
            };
            while let Some((place, command)) = program.next_command().map_err(refused)? {
                take(Source::Command(place, command))?;
            }
        }
    }
    Ok(())
}
