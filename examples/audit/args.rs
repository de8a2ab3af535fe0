//! The arguments, each declared once.

use clap::{Parser, ValueEnum};
use curvlay_examples::args::{Common, MeshArgs, above_zero, from_zero, share};
use curvlay_examples::mesh::{Unit, Up};
use std::path::PathBuf;

/// Scores what any program makes, as an order of cells, as G-code or as surfaces of layers: what the nozzle cannot reach, what lies on nothing, what is gouged,
/// missing or laid twice.
///
/// Exit status: 0 done. 1 input or output cannot be used. 2 the arguments cannot be used, or not together. 3 done, but a check failed: each is a line on
/// stderr, a notice in report.html and a line in summary.json.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "audit")]
pub struct Args {
    /// What to audit: an order of cells (.csv, .vtk), G-code (.gcode, .nc, ...), waypoints (.txt), layer meshes (.obj, .stl, .ply, or a folder of them), or
    /// a folder of curved_layers
    #[arg(value_name = "INPUT", required = true)]
    pub input: PathBuf,
    /// Further layer meshes; the last number in the name of each is its layer
    #[arg(value_name = "MESH")]
    pub more: Vec<PathBuf>,
    /// Millimetres in a unit of the input, and of --cell, --bead and --layer-height
    #[arg(long = "scale", value_name = "FACTOR", default_value_t = 1.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub input_scale: f64,
    /// Five-axis machine whose axes the G-code has: a file as docs/formats/machines.md describes it
    #[arg(long, value_name = "FILE")]
    pub machine: Option<PathBuf>,
    /// Edge of a cell in millimetres [default: the least step between coordinates; 1 for indices]
    #[arg(long = "cell", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub cell_mm: Option<f64>,
    /// Number of the first layer in the file; smaller numbers are cells that are not built
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=1), allow_negative_numbers = true)]
    pub first_layer: u32,
    /// Thickness of a layer of cells in units of a growth field [default: 1]
    #[arg(long, value_name = "X", value_parser = above_zero, allow_negative_numbers = true)]
    pub field_step: Option<f64>,
    /// Layers of the order that are printed as one: cells of the last N - 1 are not in the nozzle's way [default: that of the run in a folder of
    /// curved_layers; 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), allow_negative_numbers = true)]
    pub layers_as_one: Option<u32>,
    /// Cells of a grid, and cubes in which volumes are compared, at most: some ten bytes of memory each
    #[arg(long, value_name = "N", default_value_t = 100_000_000, value_parser = clap::value_parser!(u64).range(1..=4_000_000_000), allow_negative_numbers = true)]
    pub max_cells: u64,
    #[command(flatten)]
    pub(super) part: PartArgs,
    #[command(flatten)]
    pub(super) allow: AllowArgs,
    /// Diameter of the tip, half angle of the cone in degrees, height of the cone, diameter of the block, in millimetres [default: that of the run in a
    /// folder of curved_layers; 0.8,45,8,20]
    #[arg(long, value_name = "TIP,DEG,CONE,BLOCK", value_parser = nozzle, help_heading = "Checks")]
    pub nozzle: Option<[f64; 4]>,
    /// How far the nozzle may lean from the upright where another direction is looked for, in degrees
    #[arg(long = "max-tilt", value_name = "DEG", default_value_t = 90.0, value_parser = tilt, allow_negative_numbers = true, help_heading = "Checks")]
    pub max_tilt_deg: f64,
    /// How far the nozzle keeps from centres of cells, in cells: half a cell is the bead
    #[arg(long, value_name = "CELLS", default_value_t = 0.5, value_parser = share, allow_negative_numbers = true, help_heading = "Checks")]
    pub clearance_cells: f64,
    /// Depth in the hull of what is built before from which on a cell is inside, in cells
    #[arg(long, value_name = "CELLS", default_value_t = 1.0, value_parser = eps, allow_negative_numbers = true, help_heading = "Checks")]
    pub eps_cells: f64,
    /// A cell exactly at that depth is not inside
    #[arg(long, help_heading = "Checks")]
    pub beyond_eps: bool,
    /// Diameter of the plate in millimetres, the least that carries the part if that is more
    #[arg(long = "platform-diameter", value_name = "MM", default_value_t = 0.0, value_parser = from_zero, allow_negative_numbers = true, help_heading = "Checks")]
    pub platform_mm: f64,
    /// Edge of the cubes in which volumes are compared, in millimetres [default: half a cell, the height of a bead or layer]
    #[arg(long = "step", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = "Checks")]
    pub step_mm: Option<f64>,
    #[command(flatten)]
    pub(super) bead: BeadArgs,
    #[command(flatten)]
    pub(super) sheet: SheetArgs,
    #[command(flatten)]
    pub(super) common: Common,
}

/// The nozzle of which nothing is known: that of `curved_layers`.
const NOZZLE: [f64; 4] = [0.8, 45.0, 8.0, 20.0];

impl Args {
    /// Sizes of the nozzle.
    pub fn nozzle_sizes(&self) -> [f64; 4] {
        self.nozzle.unwrap_or(NOZZLE)
    }
}

/// What beads are, and when they count.
#[derive(clap::Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Beads")]
pub struct BeadArgs {
    /// Width of beads in millimetres, where comments do not say it [default: by their volume]
    #[arg(long = "bead", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub width_mm: Option<f64>,
    /// Height of beads in millimetres, where comments do not say it; heights in the rules of support are of this one [default: the step between layers; the median]
    #[arg(long = "layer-height", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub height_mm: Option<f64>,
    /// Diameter of the filament in millimetres [default: what the program says; 1.75]
    #[arg(long = "filament", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub filament_mm: Option<f64>,
    /// Longer steps between waypoints lay nothing, in millimetres [default: 5 median steps]
    #[arg(long = "max-step", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub max_step_mm: Option<f64>,
    /// How far the middle of a bead may be from what carries it, in layer heights
    #[arg(long, value_name = "HEIGHTS", default_value_t = 1.5, value_parser = above_zero, allow_negative_numbers = true)]
    pub support_distance: f64,
    /// How far below it that has to be along the nozzle, in layer heights
    #[arg(long, value_name = "HEIGHTS", default_value_t = 0.25, value_parser = from_zero, allow_negative_numbers = true)]
    pub support_drop: f64,
    /// An unsupported place is in the air if nothing is as near as this, in bead widths
    #[arg(long, value_name = "WIDTHS", default_value_t = 2.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub air_reach: f64,
    /// How deep the nozzle may be in a bead, as a share of the bead's height
    #[arg(long, value_name = "SHARE", default_value_t = 0.25, value_parser = share, allow_negative_numbers = true)]
    pub contact: f64,
    /// The share of a section in that of an earlier bead above which it is laid twice
    #[arg(long, value_name = "SHARE", default_value_t = 0.5, value_parser = share, allow_negative_numbers = true)]
    pub overlap: f64,
    /// How much larger beads are to all sides where volumes are compared, as a share of their height
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = share, allow_negative_numbers = true)]
    pub slack: f64,
    /// Turns above this angle are sharp, in degrees
    #[arg(long = "sharp-turn", value_name = "DEG", default_value_t = 60.0, value_parser = turn, allow_negative_numbers = true)]
    pub sharp_deg: f64,
}

/// How layer meshes are meant. The options of beads count for them as well: a layer is as high as a bead.
#[derive(clap::Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Layer meshes")]
pub struct SheetArgs {
    /// Where in its layer a surface lies
    #[arg(long = "surface", value_name = "SIDE", default_value = "middle")]
    pub side: LayerSide,
    /// Axis of the files that points up
    #[arg(long = "up", value_name = "AXIS", default_value = "z", allow_hyphen_values = true)]
    pub layers_up: Up,
    /// Height of the plate in the files, in millimetres
    #[arg(long = "plate", value_name = "MM", default_value_t = 0.0, value_parser = place, allow_negative_numbers = true)]
    pub plate_mm: f64,
    /// Longest edge of the patches that are judged, in millimetres [default: two layer heights]
    #[arg(long = "patch", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub patch_mm: Option<f64>,
}

/// Where in its layer a surface lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LayerSide {
    /// In the middle: as much of the layer is above it as below
    Middle,
    /// On top: the tip of the nozzle runs on it
    Top,
}

/// The part to compare with.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Part")]
pub struct PartArgs {
    /// The part: STL, 3MF, OBJ or PLY; its lowest point is put on z = 0
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Unit of the numbers in that file
    #[arg(long = "mesh-unit", value_name = "UNIT", default_value = "mm")]
    pub unit: Unit,
    /// Factor by which the part is enlarged
    #[arg(long = "mesh-scale", value_name = "FACTOR", default_value_t = 1.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub scale: f64,
    /// Axis of that file that points up
    #[arg(long = "mesh-up", value_name = "AXIS", default_value = "z", allow_hyphen_values = true)]
    pub up: Up,
    /// Moves the part by so much, in millimetres
    #[arg(long = "mesh-shift", value_name = "X,Y,Z", default_value = "0,0,0", value_parser = list::<3>, allow_negative_numbers = true)]
    pub shift_mm: [f64; 3],
    /// Moves the part so that the middle of its box is that of the input along x and y, as slicers centre parts on their bed
    #[arg(long)]
    pub centre: bool,
}

impl PartArgs {
    /// As the reader of meshes takes them.
    pub fn mesh_args(&self) -> MeshArgs {
        MeshArgs {
            file: None,
            mesh: self.mesh.clone(),
            unit: self.unit,
            scale: self.scale,
            up: self.up,
            allow_large: false,
            allow_guesses: true,
        }
    }
}

/// Shares from which on a check fails.
#[derive(clap::Args, Clone, Copy, Debug, serde::Serialize)]
#[command(next_help_heading = "Allowed shares")]
pub struct AllowArgs {
    /// Share that the nozzle may not reach
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share, allow_negative_numbers = true)]
    pub allow_shadowed: f64,
    /// Share without support
    #[arg(long, value_name = "SHARE", default_value_t = 0.001, value_parser = share, allow_negative_numbers = true)]
    pub allow_unsupported: f64,
    /// Share in the air
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share, allow_negative_numbers = true)]
    pub allow_in_air: f64,
    /// Share at which the nozzle cuts what was laid
    #[arg(long, value_name = "SHARE", default_value_t = 0.001, value_parser = share, allow_negative_numbers = true)]
    pub allow_gouged: f64,
    /// Share of the part that nothing covers
    #[arg(long, value_name = "SHARE", default_value_t = 0.02, value_parser = share, allow_negative_numbers = true)]
    pub allow_uncovered: f64,
    /// Share outside of the part
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = from_zero, allow_negative_numbers = true)]
    pub allow_outside: f64,
    /// Share that is laid twice
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share, allow_negative_numbers = true)]
    pub allow_laid_twice: f64,
}

/// Numbers with commas between them.
fn list<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let number = |word: &str| word.trim().parse::<f64>().ok().filter(|value| value.abs() <= 1e6);
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| format!("must be {N} numbers within 1e6 with commas between them"))
}

fn nozzle(text: &str) -> Result<[f64; 4], String> {
    let all = list::<4>(text)?;
    if all.iter().all(|size| *size > 0.0) { Ok(all) } else { Err("all four must be above 0".to_owned()) }
}

fn within(text: &str, [min, max]: [f64; 2]) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (min..=max).contains(&value) { Ok(value) } else { Err(format!("must be from {min} to {max}")) }
}

fn place(text: &str) -> Result<f64, String> {
    within(text, [-1e6, 1e6])
}

fn tilt(text: &str) -> Result<f64, String> {
    within(text, [1.0, 90.0])
}

fn turn(text: &str) -> Result<f64, String> {
    within(text, [1.0, 180.0])
}

fn eps(text: &str) -> Result<f64, String> {
    within(text, [0.0, 16.0])
}
