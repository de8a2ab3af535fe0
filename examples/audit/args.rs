//! The arguments, each declared once.

use clap::Parser;
use curvlay_examples::args::{Common, MeshArgs, above_zero, from_zero, share};
use curvlay_examples::mesh::{Unit, Up};
use std::path::PathBuf;

/// Scores an order of cells from any program: what the nozzle cannot reach, what lies on nothing, what is gouged, missing or laid twice.
///
/// Exit status: 0 done. 1 input or output cannot be used. 2 the arguments cannot be used, or not together. 3 done, but a check failed: each is a line on
/// stderr, a notice in report.html and a line in summary.json.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "audit")]
pub struct Args {
    /// What to audit: an order of cells (.csv, .vtk)
    #[arg(value_name = "INPUT", required = true)]
    pub input: PathBuf,
    /// Edge of a cell in millimetres [default: the least step between coordinates; 1 for indices]
    #[arg(long = "cell", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub cell_mm: Option<f64>,
    /// Number of the first layer in the file; smaller numbers are cells that are not built
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=1), allow_negative_numbers = true)]
    pub first_layer: u32,
    /// Thickness of a layer of cells in units of a growth field [default: 1]
    #[arg(long, value_name = "X", value_parser = above_zero, allow_negative_numbers = true)]
    pub field_step: Option<f64>,
    /// Cells of a grid, and cubes in which volumes are compared, at most: some ten bytes of memory each
    #[arg(long, value_name = "N", default_value_t = 100_000_000, value_parser = clap::value_parser!(u64).range(1..=4_000_000_000), allow_negative_numbers = true)]
    pub max_cells: u64,
    #[command(flatten)]
    pub(super) part: PartArgs,
    #[command(flatten)]
    pub(super) allow: AllowArgs,
    /// Diameter of the tip, half angle of the cone in degrees, height of the cone, diameter of the block, in millimetres
    #[arg(long, value_name = "TIP,DEG,CONE,BLOCK", default_value = "0.8,45,8,20", value_parser = nozzle, help_heading = "Checks")]
    pub nozzle: [f64; 4],
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
    /// Edge of the cubes in which volumes are compared, in millimetres [default: half a cell]
    #[arg(long = "step", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = "Checks")]
    pub step_mm: Option<f64>,
    #[command(flatten)]
    pub(super) common: Common,
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

fn tilt(text: &str) -> Result<f64, String> {
    within(text, [1.0, 90.0])
}

fn eps(text: &str) -> Result<f64, String> {
    within(text, [0.0, 16.0])
}
