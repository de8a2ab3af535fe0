//! From a mesh to curved layers that need no support and cannot collide: the order of its cells, and working surfaces.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), chapter 3.
//! ```sh
//! cargo run --release --example curved_layers -- --mesh part.stl --voxels 100000
//! ```
//! Without `--mesh` it takes a jug made in code. `--help` lists the options, the README the files that it writes.

mod field;
mod machine;
mod motion;
mod outputs;
mod paths;
mod surfaces;

use clap::{Parser, ValueEnum};
use curvlay_examples::args::{
    Common, Failure, GrowArgs, MeshArgs, Outcome, Part, Prevention as PreventionArg, Strategy as StrategyArg,
    VoxelArgs, above_zero, from_zero, run_with_args, warn,
};
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::shapes::jug;
use curvlay_kinematics::workcell::AnyWorkcell;
use curvlay_layers::curved::surface::SavedField;
use curvlay_layers::curved::{Prevention, Strategy};
use curvlay_toolpath::surface::{PathOptions, Pattern, PrintOptions};
use curvlay_voxel::Resolution;
use field::{FieldOptions, FieldRun};
use machine::MachineRun;
use motion::{Motion, MotionArgs, Print, ProgramFormat};
use paths::PathsRun;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
use std::process::ExitCode;
use surfaces::{SurfaceOptions, SurfacesRun};

/// How many cells a part gets unless the user says.
const DEFAULT_CELLS: u64 = 100_000;

/// Curved layers for a part, after Dai (2020), chapter 3: needs no support, cannot collide, and is audited.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "curved_layers")]
struct Args {
    #[command(flatten)]
    mesh: MeshArgs,
    #[command(flatten)]
    voxel: VoxelArgs,
    #[command(flatten)]
    grow: GrowArgs,
    /// The last stage to run
    #[arg(long, default_value = "gcode")]
    stage: Stage,
    /// Distance of the layers in millimetres [default: the edge of a cell]
    #[arg(long, value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    layer_height: Option<f64>,
    /// Width of a bead in millimetres [default: the distance of the layers]
    #[arg(long, value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    bead: Option<f64>,
    /// How each layer is filled
    #[arg(long, default_value = "spirals")]
    pattern: Fill,
    /// Single beads between others cover at least so many squares of a bead, or the gap stays; 0 fills them all
    #[arg(long, value_name = "SQUARES", default_value_t = 1.0, value_parser = from_zero, allow_negative_numbers = true)]
    least_gap: f64,
    /// Diameter of the filament in millimetres
    #[arg(long, value_name = "MM", default_value_t = 1.75, value_parser = above_zero, allow_negative_numbers = true)]
    filament: f64,
    /// Shape of the nozzle: diameter of its tip flat (mm), half angle of its cone (degrees), height of the cone (mm),
    /// diameter of the block above it (mm) [default: that of the workcell, 1,45,8,20 in those that come along]
    #[arg(long, value_name = "TIP,ANGLE,HEIGHT,BLOCK", value_parser = machine::shape)]
    nozzle: Option<machine::Shape>,
    /// Temperature of the nozzle, for the machine file, in degrees Celsius
    #[arg(long, value_name = "CELSIUS", value_parser = celsius, allow_negative_numbers = true)]
    nozzle_celsius: Option<f64>,
    /// Temperature of the plate, for the machine file, in degrees Celsius
    #[arg(long, value_name = "CELSIUS", value_parser = celsius, allow_negative_numbers = true)]
    bed_celsius: Option<f64>,
    /// Writes a machine file for a table that tilts (B) and turns (C) as well
    #[arg(long)]
    rotary: bool,
    /// Makes what the report compares with: surfaces of plain hop counts, directions of the nozzle without any filter
    #[arg(long)]
    compare: bool,
    /// Go on from the field.txt of an earlier run on the same mesh; takes the place of growing
    #[arg(long, value_name = "FILE", conflicts_with_all = ["voxels", "cell"])]
    resume: Option<PathBuf>,
    #[command(flatten)]
    motion: MotionArgs,
    #[command(flatten)]
    common: Common,
}

/// The arguments as the stages take them.
impl Args {
    fn field_options(&self) -> FieldOptions {
        let wanted = Resolution::Count(self.voxel.voxels.unwrap_or(DEFAULT_CELLS));
        let prevention = match self.grow.prevention {
            PreventionArg::Incremental => Prevention::Incremental,
            PreventionArg::Adaptive => Prevention::Adaptive,
        };
        let strategy = match self.grow.strategy {
            StrategyArg::Best => None,
            StrategyArg::Greedy => Some(Strategy::Greedy),
            StrategyArg::Incremental => Some(Strategy::Incremental),
            StrategyArg::Adaptive => Some(Strategy::Adaptive),
            StrategyArg::Governed => Some(Strategy::Governed(prevention)),
            StrategyArg::Unbuild => Some(Strategy::Unbuild),
            StrategyArg::Printed => Some(Strategy::Printed(prevention)),
        };
        let GrowArgs { eps, beyond_eps, platform_diameter_mm, .. } = self.grow;
        let resolution = self.voxel.cell.map_or(wanted, Resolution::Cell);
        FieldOptions { resolution, eps, beyond_eps, platform_diameter_mm, strategy, height_mm: self.layer_height }
    }

    fn surface_options(&self) -> SurfaceOptions {
        SurfaceOptions { height_mm: self.layer_height, compare: self.compare }
    }

    fn path_options(&self, height_mm: f64) -> PathOptions {
        let (bead, pattern) = (self.bead.unwrap_or(height_mm), self.pattern.of_surface());
        PathOptions { bead, pattern, min_gap: self.least_gap, ..PathOptions::default() }
    }

    fn print_options(&self) -> PrintOptions {
        let is_for_robot = self.stage >= Stage::Motion;
        let mut options = if is_for_robot { PrintOptions::for_robot() } else { PrintOptions::default() };
        options.deposition.filament_diameter = self.filament;
        options
    }
}

/// How layers are filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Fill {
    /// Connected Fermat spirals: one curve a region.
    Spirals,
    /// Rings along the boundary, not connected.
    Rings,
    /// Rows to and fro: one curve for each part that no hole divides.
    Zigzag,
}

impl Fill {
    fn of_surface(self) -> Pattern {
        match self {
            Fill::Spirals => Pattern::Spirals,
            Fill::Rings => Pattern::Rings,
            Fill::Zigzag => Pattern::Zigzag,
        }
    }
}

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
enum Stage {
    /// The growing field: which cell belongs to which layer.
    Field,
    /// The working surfaces: uniform layers, contoured and trimmed to the mesh.
    Surfaces,
    /// Tool paths: continuous curves that fill the surfaces.
    Paths,
    /// The machine file: how the nozzle stands and what it lays down.
    Gcode,
    /// Joint trajectories and programs of a robot, transfers included; only on demand.
    Motion,
}

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let setup = Setup::of(&args)?;
        let folder = args.common.folder("curved_layers")?;
        let bars = Bars::new(args.common.quiet);
        let part = args.mesh.load("jug (made in code)", jug)?;
        part.warnings.iter().for_each(warn);
        let saved = args.resume.as_deref().map(|path| surfaces::load(path, &part)).transpose()?;
        let mut results = work(&args, setup, &part, saved, &bars)?;
        check_motion(&args, &mut results, &folder, &bars)?;
        bars.finish();
        results.field.findings.iter().filter(|finding| !part.warnings.contains(finding)).for_each(warn);
        let refused = outputs::write(&args, &part, &results, &folder)?;
        let mut failed = results.failed_checks();
        failed.extend(refused.map(|why| format!("no programs: {why}")));
        Ok(Outcome::of(failed))
    })
}

/// What prints.
struct Setup {
    cell: AnyWorkcell,
    format: ProgramFormat,
    nozzle: machine::Shape,
}

impl Setup {
    fn of(args: &Args) -> Result<Self, Failure> {
        let cell = args.motion.cell(args.nozzle.as_ref())?;
        let format = args.motion.format(&cell)?;
        let nozzle = args.nozzle.clone().map_or_else(|| machine::Shape::of(cell.equipment()), Ok)?;
        Ok(Setup { cell, format, nozzle })
    }
}

/// What came of the stages.
struct Results {
    setup: Setup,
    field: FieldRun,
    surfaces: Option<SurfacesRun>,
    paths: Option<PathsRun>,
    machine: Option<MachineRun>,
    motion: Option<Motion>,
}

impl Results {
    /// What the motion is planned for, once there is a machine file.
    fn print<'a>(&'a self, args: &'a Args) -> Option<Print<'a>> {
        let (surfaces, paths) = (self.surfaces.as_ref()?, self.paths.as_ref()?);
        let (filament_mm, args, nozzle) = (args.filament, &args.motion, &self.setup.nozzle.nozzle);
        Some(Print { args, nozzle, filament_mm, field: &self.field, surfaces, paths, machine: self.machine.as_ref()? })
    }

    fn failed_checks(&self) -> Vec<String> {
        let audit = &self.field.audit;
        let audit = (!audit.is_ok()).then(|| format!("audit of the layers: {audit}"));
        let machine = self.machine.iter().flat_map(MachineRun::failed_checks);
        let motion = self.motion.iter().flat_map(Motion::failed_checks);
        audit.into_iter().chain(machine).chain(motion).collect()
    }
}

/// Runs the stages.
fn work(args: &Args, setup: Setup, part: &Part, saved: Option<SavedField>, bars: &Bars) -> Result<Results, Failure> {
    pool(args)?.install(|| {
        let surfaces = (args.stage >= Stage::Surfaces).then(|| args.surface_options());
        let (field, surfaces) = field::run(&args.field_options(), surfaces.as_ref(), part, saved, bars)?;
        let filled = surfaces.as_ref().filter(|_| args.stage >= Stage::Paths);
        let paths =
            filled.map(|surfaces| paths::run(&args.path_options(surfaces.height_mm), surfaces, bars)).transpose()?;
        let filled = surfaces.as_ref().zip(paths.as_ref()).filter(|_| args.stage >= Stage::Gcode);
        let machine = filled.map(|(surfaces, paths)| {
            machine::run(&setup.nozzle.nozzle, &args.print_options(), args.compare, surfaces, paths, bars)
        });
        let mut results = Results { setup, field, surfaces, machine: machine.transpose()?, paths, motion: None };
        if args.stage >= Stage::Motion {
            results.motion =
                results.print(args).map(|print| motion::run(&print, &results.setup.cell, bars)).transpose()?;
        }
        Ok(results)
    })
}

/// Writes the motion, reads it again and checks it. The machine file then goes as fast as the robot.
fn check_motion(args: &Args, results: &mut Results, folder: &OutputFolder, bars: &Bars) -> Result<(), Failure> {
    let Some(mut motion) = results.motion.take() else { return Ok(()) };
    if let Some(print) = results.print(args) {
        outputs::trajectory(&motion, folder)?;
        let file = File::open(folder.path().join(outputs::TRAJECTORY)).map_err(failure)?;
        pool(args)?.install(|| motion.check(&print, BufReader::new(file), bars))?;
    }
    if let Some(machine) = &mut results.machine {
        machine.deposition.retime(motion.steps());
    }
    results.motion = Some(motion);
    Ok(())
}

fn pool(args: &Args) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(args.common.threads).build().map_err(failure)
}

/// A temperature, for clap.
fn celsius(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value| (0.0..=600.0).contains(value)).ok_or_else(|| "must be from 0 to 600".to_owned())
}

/// Any error as one line.
fn failure(error: impl std::fmt::Display) -> Failure {
    Failure::new(error)
}
