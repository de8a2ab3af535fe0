//! From a mesh to a print in curved layers: an audited order of its cells, surfaces, tool paths, a machine file, and the motion of
//! a robot.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), chapter 3.
//! ```sh
//! cargo run --release --example curved_layers -- --mesh part.stl --voxels 100000
//! ```
//! Without `--mesh` it takes a jug made in code. `--help` lists the options, the README the files that it writes.

mod estimate;
mod field;
mod findings;
mod machine;
mod motion;
mod outputs;
mod paths;
mod surfaces;

use clap::parser::ValueSource;
use clap::{ArgMatches, Parser, ValueEnum};
use curvlay_examples::args::{
    AllowArgs, Common, Failure, GrowArgs, MeshArgs, Outcome, Part, Strategy, VoxelArgs, above_zero, from_zero,
    run_with_checked_args, typed_name,
};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::{Findings, Severity};
use curvlay_examples::motion::nozzle_of;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::shapes::jug;
use curvlay_kinematics::workcell::AnyWorkcell;
use curvlay_layers::curved::surface::SavedField;
use curvlay_toolpath::surface::{Nozzle, PathOptions, Pattern, PrintOptions, SupportOptions};
use estimate::Memory;
use field::{FieldOptions, FieldRun};
use machine::MachineRun;
use motion::{Motion, MotionArgs, Print, ProgramFormat};
use outputs::Files;
use paths::PathsRun;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
use std::process::ExitCode;
use surfaces::{SurfaceOptions, SurfacesRun};

/// How many cells a part gets unless the user says.
const DEFAULT_CELLS: u64 = 100_000;

/// A print in curved layers, after Dai (2020), chapter 3: an audited order of cells, surfaces, paths, machine file, robot motion.
///
/// Exit status: 0 done. 1 input or output cannot be used. 2 the arguments cannot be used, or not together. 3 done, but a check of ours
/// failed: more is missed, gouges, is left out, or is laid too much or too little than the --allow options say; the audit of the
/// layers failed; travels are blocked; of a motion, waypoints are not reached or not printed, transfers are missing, or
/// the check of the written motions found something. Each finding is a line on stderr, a notice in report.html and a line in
/// summary.json.
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
    /// Tries layers that are torn as little as the part allows as well, and takes them if they end less inside the part; they may be
    /// less even
    #[arg(long, conflicts_with = "resume")]
    coherent: bool,
    /// Width of a bead in millimetres [default: the distance of the layers]
    #[arg(long, value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    bead: Option<f64>,
    /// How each layer is filled
    #[arg(long, default_value = "spirals")]
    pattern: Fill,
    /// Single beads between others cover at least so many squares of a bead, or the gap stays; 0 fills them all
    #[arg(long, value_name = "SQUARES", default_value_t = 1.0, value_parser = from_zero, allow_negative_numbers = true)]
    least_gap: f64,
    /// Curves of a layer whose ends are so many beads apart at most become one where a bead fits between them; 0 joins none
    #[arg(long, value_name = "BEADS", default_value_t = 2.0, value_parser = from_zero, allow_negative_numbers = true)]
    join_distance: f64,
    /// Shorter curves than so many beads are left out beside longer ones of the same piece of a layer; 0 keeps them all
    #[arg(long, value_name = "BEADS", default_value_t = 5.0, value_parser = from_zero, allow_negative_numbers = true)]
    least_length: f64,
    /// Beads farther than this from the plate and from all earlier beads below them count as unsupported, in layer heights
    #[arg(long, value_name = "HEIGHTS", default_value_t = 1.5, value_parser = support_distance, allow_negative_numbers = true)]
    support_distance: f64,
    /// Diameter of the filament in millimetres
    #[arg(long, value_name = "MM", default_value_t = 1.75, value_parser = above_zero, allow_negative_numbers = true)]
    filament: f64,
    /// Shape of the nozzle: diameter of its tip flat (mm), half angle of its cone (degrees), height of the cone (mm),
    /// diameter of the block above it (mm) [default: that of the workcell, 1,45,8,20 in those that come along]
    #[arg(long, value_name = "TIP,ANGLE,HEIGHT,BLOCK", value_parser = machine::shape)]
    nozzle: Option<[f64; 4]>,
    /// Temperature of the nozzle, for the machine file, in degrees Celsius
    #[arg(long, value_name = "CELSIUS", value_parser = celsius, allow_negative_numbers = true)]
    nozzle_celsius: Option<f64>,
    /// Temperature of the plate, for the machine file, in degrees Celsius
    #[arg(long, value_name = "CELSIUS", value_parser = celsius, allow_negative_numbers = true)]
    bed_celsius: Option<f64>,
    /// How the machine file says the direction of the nozzle
    #[arg(long, default_value = "comment")]
    dialect: outputs::Words,
    /// Writes a machine file for a table that tilts (B) and turns (C) as well
    #[arg(long)]
    rotary: bool,
    /// Makes what the report compares with: surfaces of plain hop counts, directions of the nozzle without any filter
    #[arg(long)]
    compare: bool,
    /// Go on from the field.txt of an earlier run on the same mesh; takes the place of growing
    #[arg(long, value_name = "FILE", conflicts_with_all = ["voxels", "cell", "strategy", "prevention"])]
    resume: Option<PathBuf>,
    /// Memory in gigabytes that a stage may take; one that is estimated to take more is refused before it begins
    #[arg(long, value_name = "GB", default_value_t = 8.0, value_parser = above_zero, allow_negative_numbers = true)]
    max_memory: f64,
    #[command(flatten)]
    allow: AllowArgs,
    #[command(flatten)]
    motion: MotionArgs,
    #[command(flatten)]
    common: Common,
}

/// The arguments as the stages take them.
impl Args {
    fn field_options(&self) -> FieldOptions {
        let GrowArgs { eps, beyond_eps, platform_diameter_mm, .. } = self.grow;
        let (resolution, strategy) = (self.voxel.resolution(DEFAULT_CELLS), self.grow.strategy());
        FieldOptions { resolution, eps, beyond_eps, platform_diameter_mm, strategy, height_mm: self.layer_height }
    }

    fn memory(&self) -> Memory {
        Memory(self.max_memory)
    }

    fn surface_options(&self) -> SurfaceOptions {
        SurfaceOptions { height_mm: self.layer_height, coherent: self.coherent, compare: self.compare }
    }

    fn path_options(&self, height_mm: f64) -> PathOptions {
        let (bead, pattern) = (self.bead.unwrap_or(height_mm), self.pattern.of_surface());
        let (min_gap, join_distance, min_length) = (self.least_gap, self.join_distance, self.least_length);
        PathOptions { bead, pattern, min_gap, join_distance, min_length, ..PathOptions::default() }
    }

    fn support_options(&self) -> SupportOptions {
        SupportOptions { max_distance: self.support_distance, ..SupportOptions::default() }
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

/// The options that a run uses from a stage on; it would not look at them before.
const NEEDS: [(Stage, &str); 4] = [
    (Stage::Surfaces, "coherent compare"),
    (Stage::Paths, "bead pattern least_gap join_distance least_length"),
    (
        Stage::Gcode,
        "dialect filament nozzle nozzle_celsius bed_celsius rotary workcell support_distance allow_volume allow_gouging allow_left_out \
         allow_unsupported allow_unsupported_beads",
    ),
    (Stage::Motion, "cell8 program acceleration jerk max_flow max_flow_ramp tolerance margin program_steps"),
];

/// Says which option would be ignored.
fn check_arguments(matches: &ArgMatches) -> Result<(), String> {
    let is_given = |id: &str| matches.value_source(id) == Some(ValueSource::CommandLine);
    let stage = matches.get_one::<Stage>("stage").copied().unwrap_or(Stage::Gcode);
    for (needed, ids) in NEEDS.into_iter().filter(|(needed, _)| *needed > stage) {
        if let Some(id) = ids.split(' ').find(|id| is_given(id)) {
            let (name, needed) = (id.replace('_', "-"), typed_name(needed));
            return Err(format!("--{name} does nothing with --stage {}: it needs --stage {needed}", typed_name(stage)));
        }
    }
    let strategy = matches.get_one("strategy").copied();
    if is_given("prevention") && !matches!(strategy, Some(Strategy::Governed | Strategy::Printed)) {
        return Err("--prevention needs --strategy governed or printed".to_owned());
    }
    Ok(())
}

fn main() -> ExitCode {
    run_with_checked_args(check_arguments, |args: Args| {
        let setup = Setup::of(&args)?;
        let folder = args.common.folder("curved_layers")?;
        let saved = args.resume.as_deref().map(surfaces::load).transpose()?;
        // What an earlier run has left goes, but for what this one goes on from: it may fail before it has written its own.
        let kept = args.resume.as_ref().and_then(|path| path.canonicalize().ok());
        let is_kept = |name: &str| kept.is_some() && folder.path().join(name).canonicalize().ok() == kept;
        folder.clear(|name| outputs::is_ours(name) && !is_kept(name))?;
        let part = args.mesh.load("jug (made in code)", jug)?;
        let job = Job { args: &args, setup, part: &part, folder: &folder, bars: &Bars::new(args.common.quiet) };
        pool(&args)?.install(|| job.work(saved))
    })
}

/// What prints.
struct Setup {
    cell: AnyWorkcell,
    format: ProgramFormat,
    nozzle: Nozzle,
}

impl Setup {
    fn of(args: &Args) -> Result<Self, Failure> {
        let cell = args.motion.cell(args.nozzle)?;
        Ok(Setup { format: args.motion.format(&cell)?, nozzle: nozzle_of(cell.equipment())?, cell })
    }
}

/// What is to be done.
struct Job<'a> {
    args: &'a Args,
    setup: Setup,
    part: &'a Part,
    folder: &'a OutputFolder,
    bars: &'a Bars,
}

/// What came of the stages, and what is wrong with it.
struct Results {
    field: FieldRun,
    surfaces: Option<SurfacesRun>,
    paths: Option<PathsRun>,
    machine: Option<MachineRun>,
    motion: Option<Motion>,
    files: Files,
    findings: Findings,
}

impl Job<'_> {
    /// Runs the stages.
    fn work(&self, saved: Option<SavedField>) -> Result<Outcome, Failure> {
        let Job { args, part, bars, .. } = *self;
        let mut findings = Findings::default();
        part.warnings.iter().for_each(|warning| findings.add(Severity::Told, warning, "", ""));
        findings.say();
        let longest = part.mesh.bounds().map_or(0.0, |[low, high]| (high - low).max());
        if let Some(bead) = args.bead.filter(|bead| *bead > longest) {
            return Err(failure(format!("--bead {bead}: wider than the part is long, {longest:.3} mm")));
        }
        let surfaces = (args.stage >= Stage::Surfaces).then(|| args.surface_options());
        let (field, surfaces) = field::run(&args.field_options(), surfaces.as_ref(), args.memory(), part, saved, bars)?;
        part.coarse_for(field.solid.grid.cell_mm()).iter().for_each(|why| findings.add(Severity::Told, why, "", ""));
        let files = Files::default();
        let mut results = Results { field, surfaces, paths: None, machine: None, motion: None, files, findings };
        self.end(Stage::Surfaces.min(args.stage), &mut results)?;
        for stage in [Stage::Paths, Stage::Gcode, Stage::Motion].into_iter().filter(|stage| *stage <= args.stage) {
            self.run(stage, &mut results)?;
            self.end(stage, &mut results)?;
        }
        Ok(results.findings.outcome())
    }

    /// Runs a stage that comes after the surfaces.
    fn run(&self, stage: Stage, results: &mut Results) -> Result<(), Failure> {
        let Job { args, setup, bars, .. } = self;
        let (memory, nozzle) = (args.memory(), &setup.nozzle);
        let Results { field, surfaces: Some(surfaces), .. } = &*results else { return Ok(()) };
        match (stage, &results.paths, &results.machine) {
            (Stage::Paths, ..) => {
                let options = args.path_options(surfaces.height_mm);
                memory.holds_paths(options.bead, field, surfaces)?;
                results.paths = Some(paths::run(&options, surfaces, bars)?);
            }
            (Stage::Gcode, Some(paths), _) => {
                let options = args.print_options();
                memory.holds_waypoints(&options, args.stage >= Stage::Motion, paths)?;
                let support = args.support_options();
                results.machine = Some(machine::run(nozzle, &options, &support, args.compare, surfaces, paths, bars)?);
            }
            (Stage::Motion, Some(paths), Some(machine)) => {
                let (filament_mm, args) = (args.filament, &args.motion);
                let print = Print { args, nozzle, filament_mm, field, surfaces, paths, machine };
                let mut motion = motion::run(&print, &setup.cell, bars)?;
                // What was written is checked, and the machine file then goes as fast as the robot.
                outputs::trajectory(&motion, self.folder)?;
                let file = File::open(self.folder.path().join(outputs::TRAJECTORY)).map_err(failure)?;
                motion.check(&print, BufReader::new(file), bars)?;
                results.machine.iter_mut().for_each(|machine| machine.deposition.retime(motion.steps()));
                results.motion = Some(motion);
            }
            _ => {}
        }
        Ok(())
    }

    /// Ends a stage: what is wrong is told, and what it has made is written.
    fn end(&self, stage: Stage, results: &mut Results) -> Result<(), Failure> {
        findings::of_stage(stage, self.args, results);
        self.bars.finish();
        results.findings.say();
        outputs::write(stage, self, results)
    }
}

fn pool(args: &Args) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(args.common.threads).build().map_err(failure)
}

/// A temperature, for clap.
fn celsius(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value| (0.0..=600.0).contains(value)).ok_or_else(|| "must be from 0 to 600".to_owned())
}

/// A distance in layer heights, for clap: one layer lies one height above the next.
fn support_distance(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value| (1.0..=100.0).contains(value)).ok_or_else(|| "must be from 1 to 100".to_owned())
}

/// Any error as one line.
fn failure(error: impl std::fmt::Display) -> Failure {
    Failure::new(error)
}
