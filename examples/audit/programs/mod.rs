//! Programs of any maker as beads: planar G-code, five-axis G-code, waypoints. `docs/formats/audit.md` states what is read.

mod arcs;
mod builder;
mod gcode;
mod hints;
mod waypoints;

use super::args::Args;
use curvlay_examples::args::Failure;
use curvlay_examples::input;
use curvlay_toolpath::orientation::ToolPath;
use std::io::BufReader;
use std::path::Path;

/// What a program lays.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// Beads that follow each other, in the order of the program; a path has the number of its extrusion as its curve, and is cut where its layer changes.
    pub paths: Vec<ToolPath>,
    /// Separate extrusions.
    pub starts: u32,
    /// Layers, where the program says or shows them.
    pub layers: Option<u32>,
    /// Filament, in millimetres, where the program has it.
    pub filament_mm: Option<f64>,
    /// How it was understood, in words.
    pub meant: String,
}

/// What a program does not say itself.
#[derive(Clone, Copy, Debug)]
pub struct Given {
    /// Diameter of the filament, if it is given.
    pub filament_diameter_mm: Option<f64>,
    /// Width of beads, if it is given.
    pub width_mm: Option<f64>,
    /// Height of beads, if it is given.
    pub height_mm: Option<f64>,
    /// Millimetres in a unit of the program.
    pub scale: f64,
}

impl Given {
    /// As the options have it.
    pub fn new(args: &Args) -> Self {
        Given {
            filament_diameter_mm: args.bead.filament_mm,
            width_mm: args.bead.width_mm,
            height_mm: args.bead.height_mm,
            scale: args.input_scale,
        }
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
    let program = gcode::read(open()?, &hints, machine, &Given::new(args)).map_err(fault)?;
    some(program).map_err(fault)
}

/// Reads waypoints.
///
/// # Errors
/// One line with file, line and what is wrong.
pub fn read_waypoints(path: &Path, args: &Args) -> Result<Program, Failure> {
    let fault = |what: String| Failure::new(format!("{}: {what}", path.display()));
    let lines = curvlay_examples::waypoints::read_waypoints(path)?;
    let program = waypoints::beads(&lines, &Given::new(args), args.bead.max_step_mm).map_err(fault)?;
    some(program).map_err(fault)
}

fn some(program: Program) -> Result<Program, String> {
    if program.paths.is_empty() {
        return Err("nothing is laid in it: a bead is a G1, G2 or G3 with a growing E".to_owned());
    }
    Ok(program)
}
