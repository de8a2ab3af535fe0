//! Reads the program and lets the controller execute it, tick by tick.

use super::controller::{Controller, Tick};
use super::court::Court;
use super::machine::Machine;
use super::program::command::Place;
use super::program::{GcodeProgram, Kind, RobotProgram, Source};
use super::setup::Setup;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::input;
use curvlay_examples::waypoints::fault;
use std::io::BufReader;
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
    for (number, path) in (0u32..).zip(&setup.files.paths) {
        bars.update("replay", u64::from(number), count);
        files.push(name_of(path));
        let reader = BufReader::new(input::open(path, input::MAX_DATA_BYTES)?);
        let mut take = |source: Source| take(&mut controller, court, source);
        match setup.files.kind {
            Kind::Gcode => gcode(setup, reader, number, &mut take).map_err(|what| fault(path, &what))?,
            Kind::UrScript => {
                RobotProgram::new(&mut take).urscript(reader, number).map_err(|what| fault(path, &what))?;
            }
            Kind::Csv => {
                let Machine::Robot(robot) = &setup.machine else { continue };
                RobotProgram::new(&mut take).csv(reader, number, robot.frames()).map_err(|what| fault(path, &what))?;
            }
            Kind::Rapid => {
                let folder = path.parent().unwrap_or(Path::new("."));
                let open = |name: &str| {
                    // A controller's path, such as `HOME:/parts/print_001.mod`: the file beside the main module.
                    let name = name.rsplit(['/', '\\', ':']).next().unwrap_or(name);
                    files.push(name.to_owned());
                    input::open(&folder.join(name), input::MAX_DATA_BYTES)
                        .map(BufReader::new)
                        .map_err(std::io::Error::other)
                };
                RobotProgram::new(&mut take).rapid(reader, open).map_err(|what| fault(path, &what))?;
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

fn take(controller: &mut Controller, court: &mut Court, source: Source) -> Result<(), String> {
    match source {
        Source::Frames(frames) => controller.set_frames(frames, &mut |tick: &Tick| court.take(tick)),
        Source::Acceleration(mm_s2) => controller.set_acceleration(mm_s2),
        Source::Command(place, command) => controller.command(place, &command, &mut |tick: &Tick| court.take(tick)),
    }
    // What follows would be compared with nothing.
    court.fault.as_ref().map_or(Ok(()), |_| Err("the plan could not be read".to_owned()))
}

fn gcode(
    setup: &Setup,
    reader: impl std::io::BufRead,
    number: u32,
    take: &mut impl FnMut(Source) -> Result<(), String>,
) -> Result<(), String> {
    let Machine::Rotary(rotary) = &setup.machine else { return Ok(()) };
    let mut program = GcodeProgram::new(reader, number, [rotary.tilt.letter, rotary.turn.letter]);
    while let Some((place, command)) = program.next_command().map_err(|error| error.to_string())? {
        take(Source::Command(place, command))?;
    }
    Ok(())
}
