//! Programs of any maker as beads: planar G-code, five-axis G-code, waypoints. `docs/formats/audit.md` states what is read.

mod arcs;
mod builder;
mod gcode;
mod hints;
mod lines;
mod program;
mod waypoints;

use super::args::Args;
use curvlay_examples::args::Failure;
use curvlay_examples::input;
use program::Given;
pub use program::Program;
use std::io::BufReader;
use std::path::Path;

/// What the options say.
fn given(args: &Args) -> Given {
    Given {
        filament_diameter_mm: args.bead.filament_mm,
        width_mm: args.bead.width_mm,
        height_mm: args.bead.height_mm,
        scale: args.input_scale,
    }
}

/// Reads G-code, with the axes of a machine if one is given.
///
/// # Errors
/// One line with file, line and what is wrong.
pub fn read_gcode(path: &Path, args: &Args) -> Result<Program, Failure> {
    let fault = |what: String| Failure::new(format!("{}: {what}", path.display()));
    let machine = match &args.machine {
        None => None,
        Some(file) => {
            let text = input::read(file, input::MAX_SETTINGS_BYTES)?;
            let machine = curvlay_kinematics::machine::FiveAxis::from_json(text.as_slice());
            Some(machine.map_err(|error| Failure::new(format!("{}: {error}", file.display())))?)
        }
    };
    let open = || input::open(path, input::MAX_DATA_BYTES).map(BufReader::new);
    // What slicers say of filament and layers may stand at the end.
    let hints = hints::read(open()?).map_err(fault)?;
    let program = gcode::read(open()?, &hints, machine, &given(args)).map_err(fault)?;
    some(program).map_err(fault)
}

/// Reads waypoints.
///
/// # Errors
/// One line with file, line and what is wrong.
pub fn read_waypoints(path: &Path, args: &Args) -> Result<Program, Failure> {
    let fault = |what: String| Failure::new(format!("{}: {what}", path.display()));
    let lines = curvlay_examples::waypoints::read_waypoints(path)?;
    let program = waypoints::beads(&lines, &given(args), args.bead.max_step_mm).map_err(fault)?;
    some(program).map_err(fault)
}

fn some(program: Program) -> Result<Program, String> {
    if program.paths.is_empty() {
        return Err("nothing is laid in it: a bead is a G1, G2 or G3 with a growing E".to_owned());
    }
    Ok(program)
}
