//! From a mesh to a print in curved layers: an audited order of its cells, surfaces, tool paths, a machine file, and the motion of
//! a robot.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), chapter 3.
//! ```sh
//! cargo run --release --example curved_layers -- part.stl --layer-height 0.3 --bead 0.5
//! cargo run --release --example curved_layers -- part.stl --voxels 100000   # for research: layers and beads as the cells
//! ```
//! Without a mesh it takes a jug made in code. `--help` lists the options, `docs/formats` the files that it writes.

mod arguments;
mod choice;
mod complete;
mod estimate;
mod field;
mod findings;
mod guide;
mod machine;
mod motion;
mod mould;
mod order;
mod outputs;
mod paths;
mod ranges;
mod surfaces;

use arguments::check_arguments;
use choice::{Choice, SUPPORT_ROUNDS, Tried};
use clap::{Parser, ValueEnum};
use complete::{CompleteArgs, LayersBy, Support};
use curvlay_examples::args::{
    AllowArgs, Common, Failure, GrowArgs, MeshArgs, Outcome, Part, VoxelArgs, above_zero, from_zero, note,
    run_with_checked_args, typed_name,
};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::{Findings, Severity};
use curvlay_examples::mesh::Mesh;
use curvlay_examples::motion::nozzle_of;
use curvlay_examples::orienting::{OrientArgs, Search, laid, search};
use curvlay_examples::output::OutputFolder;
use curvlay_examples::settings::{self, BEAD_MM, LAYER_HEIGHT_MM, NOZZLE, PLATFORM_DIAMETER_MM, Settings};
use curvlay_examples::shapes::{jug, small_jug};
use curvlay_kinematics::workcell::AnyWorkcell;
use curvlay_layers::curved::orient::PoseKind;
use curvlay_layers::curved::surface::{SavedField, mesh_stamp};
use curvlay_layers::curved::{LayerOptions, Rules};
use curvlay_toolpath::deposit::DepositionOptions;
use curvlay_toolpath::gouging::Nozzle;
use curvlay_toolpath::path::{PathOptions, Pattern};
use curvlay_toolpath::plan::PrintOptions;
use curvlay_toolpath::support::SupportOptions;
use curvlay_voxel::inspect::thinner_than;
use estimate::Memory;
use field::{FieldOptions, FieldRun, Given};
use guide::Guide;
use machine::MachineRun;
use motion::{Motion, MotionArgs, Print, ProgramFormat};
use nalgebra::Point3;
use outputs::Files;
use paths::PathsRun;
use ranges::{LayerFill, Pick};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use surfaces::{SurfaceOptions, SurfacesRun};

/// A print in curved layers, after Dai (2020), chapter 3: an audited order of cells, surfaces, paths, machine file, robot motion.
///
/// Exit status: 0 done. 1 input or output cannot be used. 2 the arguments cannot be used, or not together. 3 done, but a check of ours
/// failed: more is missed, gouges, is left out, or over- or under-extruded by more than the --allow options permit; the audit of the
/// layers failed; travels are blocked; of a motion, waypoints are not reached or not printed, transfers are missing, or
/// the check of the written motions found something. Each finding is a line on stderr, a notice in report.html and a line in
/// summary.json.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "curved_layers")]
struct Args {
    #[command(flatten)]
    mesh: MeshArgs,
    /// What the part is built on: a mould, or a part that exists already. A mesh file with the same origin, unit, scale and axis as the part; the lower of
    /// both stands on the plate
    #[arg(long = "on", value_name = "FILE", help_heading = "Part")]
    mould: Option<PathBuf>,
    /// Layers parallel to this surface in place of an order that is searched: an open mesh across the part and beyond, with the same origin, unit, scale and axis
    #[arg(long = "base", value_name = "FILE", conflicts_with_all = SEARCHED_ORDER, help_heading = "Part")]
    base: Option<PathBuf>,
    /// Layers that follow these directions in place of an order that is searched, as far as layers may lean: a file with six numbers a line, `x y z i j k`, a place with the unit, scale and axis of the part and the
    /// way in which the part is to grow there. Each place of the part has the direction nearest to it inside the part, evened out where two meet
    #[arg(long, value_name = "FILE", conflicts_with = "base", conflicts_with_all = SEARCHED_ORDER, help_heading = "Part")]
    directions: Option<PathBuf>,
    /// Layers as level as the skin allows in place of an order that is searched: it hangs out over them by no more than this angle, in degrees above 0 and below 90, as far as layers may lean; 45 is
    /// what beads hold
    #[arg(long = "max-overhang", value_name = "DEGREES", value_parser = overhang, allow_negative_numbers = true, conflicts_with_all = ["base", "directions"], conflicts_with_all = SEARCHED_ORDER, help_heading = CELLS)]
    max_overhang_deg: Option<f64>,
    /// Settings of a printer, a JSON file (docs/formats/profiles.md; three in examples/profiles); options that are typed win
    #[arg(long, value_name = "FILE", help_heading = "Run")]
    profile: Option<PathBuf>,
    /// The last stage to run
    #[arg(long, default_value = "gcode", help_heading = "Run")]
    stage: Stage,
    #[command(flatten)]
    settings: Settings,
    /// How each layer is filled
    #[arg(long, default_value = "spirals", help_heading = settings::LAYERS)]
    pattern: Fill,
    /// Single beads between others cover at least so many squares of a bead, or the gap stays; 0 fills them all
    #[arg(long, value_name = "SQUARES", default_value_t = 1.0, value_parser = from_zero, allow_negative_numbers = true, help_heading = settings::LAYERS)]
    least_gap: f64,
    /// Curves of a layer whose ends are so many beads apart at most become one where a bead fits between them; 0 joins none
    #[arg(long, value_name = "BEADS", default_value_t = 2.0, value_parser = from_zero, allow_negative_numbers = true, help_heading = settings::LAYERS)]
    join_distance: f64,
    /// Shorter curves than so many beads are left out beside longer ones of the same piece of a layer; 0 keeps them all
    #[arg(long, value_name = "BEADS", default_value_t = 5.0, value_parser = from_zero, allow_negative_numbers = true, help_heading = settings::LAYERS)]
    least_length: f64,
    /// Strips narrower than three quarters of a bead, but not than so many beads, get one where later beads would lie on nothing else; 0.75:
    /// none do
    #[arg(long, value_name = "BEADS", default_value_t = 0.5, value_parser = least_width, allow_negative_numbers = true, help_heading = settings::LAYERS)]
    least_width: f64,
    /// How the part lies on the plate
    #[arg(long, default_value = "given", conflicts_with = "resume", help_heading = "How the part lies")]
    orient: Lying,
    #[command(flatten)]
    posing: OrientArgs,
    #[command(flatten)]
    voxel: VoxelArgs,
    #[command(flatten)]
    grow: GrowArgs,
    #[command(flatten)]
    complete: CompleteArgs,
    /// Tries layers that are torn as little as the part allows as well, and takes them if they end less inside the part; they may be
    /// less even
    #[arg(long, conflicts_with = "resume", help_heading = CELLS)]
    coherent: bool,
    /// Go on from the field.txt of an earlier run on the same mesh; takes the place of growing
    #[arg(long, value_name = "FILE", conflicts_with_all = ["voxels", "cell", "strategy", "prevention"], help_heading = CELLS)]
    resume: Option<PathBuf>,
    /// Files that are written beside the others, with commas between them
    #[arg(long, value_name = "FILE,...", value_delimiter = ',', help_heading = settings::FILES)]
    also: Vec<Extra>,
    /// Fills only these layers and ends: A..B (both included, from 1), A.. or K/N (piece K of N); writes paths.jsonl for --merge
    #[arg(long, value_name = "LAYERS", value_parser = ranges::pick, conflicts_with = "merge", help_heading = CELLS)]
    layers: Option<Pick>,
    /// Takes the paths of runs with --layers, which together have all layers, in place of filling them
    #[arg(long, value_name = "FILE", num_args = 1.., help_heading = CELLS)]
    merge: Vec<PathBuf>,
    /// Writes a machine file for a table that tilts (B) and turns (C) as well
    #[arg(long, help_heading = settings::FILES)]
    rotary: bool,
    /// Makes what the report compares with: surfaces of plain hop counts, directions of the nozzle without any filter
    #[arg(long, help_heading = "Run")]
    compare: bool,
    /// Measures what beads cover, cover twice and spill, by a raster, which takes nearly as long as the paths; so does --compare
    #[arg(long, help_heading = "Run")]
    statistics: bool,
    /// Memory in gigabytes that a stage may take; one that is estimated to take more is refused before it begins
    #[arg(long, value_name = "GB", default_value_t = 8.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = "Run")]
    max_memory: f64,
    /// Beads farther than this from the plate and from all earlier beads below them count as unsupported, in layer heights
    #[arg(long, value_name = "HEIGHTS", default_value_t = 1.5, value_parser = support_distance, allow_negative_numbers = true, help_heading = "What may be wrong")]
    support_distance: f64,
    #[command(flatten)]
    allow: AllowArgs,
    #[command(flatten)]
    motion: MotionArgs,
    #[command(flatten)]
    common: Common,
}

/// Options of an order that is searched, or saved: a guide takes its place.
const SEARCHED_ORDER: [&str; 5] = ["resume", "layers_by", "strategy", "nozzle_growth", "coherent"];

/// Heading of `--help` for what concerns cells, as in the shared arguments.
const CELLS: &str = "Cells and their order";

/// The arguments as the stages take them.
impl Args {
    /// Puts what is typed over the profile, and says what does not go together.
    fn with_profile(mut self) -> Result<Self, Failure> {
        if let Some(path) = &self.profile {
            self.settings = self.settings.over(&Settings::load(path)?);
        }
        if self.layers.is_some() {
            self.stage = Stage::Paths;
        }
        self.settings = self.settings.filled_in();
        let DepositionOptions { min_feed, max_feed, .. } = self.settings.deposition();
        if min_feed > max_feed {
            return Err(Failure::of_arguments(format!("--min-feed {min_feed} is above --max-feed {max_feed}")));
        }
        self.complete.check().map_err(Failure::of_arguments)?;
        if self.complete.max_layer_tilt_deg.is_some() && matches!(self.layers_by(), LayersBy::Hull | LayersBy::Distance)
        {
            let name = typed_name(self.layers_by());
            let why = format!("--max-layer-tilt does nothing with --layers-by {name}: it needs directed or best");
            return Err(Failure::of_arguments(why));
        }
        if self.settings.price_per_kg.is_some() && self.settings.material_density_g_cm3.is_none() {
            return Err(Failure::of_arguments("--price-per-kg needs --material-density: filament is sold by mass"));
        }
        if let Some(height_mm) = self.height().or(self.voxel.cell).filter(|_| self.stage >= Stage::Paths) {
            self.bead(height_mm).map_err(Failure::of_arguments)?;
        }
        if !self.motion.cell8 && self.motion.workcell.is_none() {
            self.motion.workcell = self.settings.workcell.take();
        }
        self.settings.check_templates().map_err(|error| match &self.profile {
            Some(path) => failure(format!("{}: {error}", path.display())),
            None => failure(error),
        })?;
        Ok(self)
    }

    /// The files that it reads.
    fn files(&self) -> impl Iterator<Item = Option<&Path>> {
        let one = [&self.resume, &self.profile, &self.motion.workcell, &self.mould, &self.base, &self.directions]
            .map(Option::as_deref);
        one.into_iter().chain([self.mesh.path()]).chain(self.merge.iter().map(|path| Some(path.as_path())))
    }

    /// Whether it is said what cells there are, in one way or another: then layers and beads follow from them.
    fn has_cells(&self) -> bool {
        self.resume.is_some() || self.voxel.resolution().is_some()
    }

    /// The part. Without a mesh it is a jug: a small one where layers are as those of printers, otherwise it would take too long. A field goes
    /// on with the jug that it is of.
    fn part(&self, saved: Option<&SavedField>) -> Result<Part, Failure> {
        let load = |shape: fn() -> Mesh| self.mesh.load("jug (made in code)", shape);
        if self.mesh.path().is_some() || self.voxel.resolution().is_some() {
            return Ok(load(jug)?);
        }
        let small = load(small_jug)?;
        let is_of =
            |saved: &SavedField| saved.check_mesh(mesh_stamp(&small.mesh.vertices, &small.mesh.triangles)).is_ok();
        if saved.is_none_or(is_of) { Ok(small) } else { Ok(load(jug)?) }
    }

    /// What it is built on.
    fn mould(&self) -> Result<Option<Part>, Failure> {
        Ok(self.mould.as_deref().map(|path| self.mesh.load_file(path)).transpose()?)
    }

    /// Layer height; `None` for the edge of a cell.
    fn height(&self) -> Option<f64> {
        self.settings.layer_height_mm.or(if self.has_cells() { None } else { Some(LAYER_HEIGHT_MM) })
    }

    /// Width of a bead where layers are so high.
    fn bead(&self, height_mm: f64) -> Result<f64, String> {
        let (settings, has_cells) = (&self.settings, self.has_cells());
        if settings.bead_mm.is_none() && has_cells && settings.layer_height_mm.is_none() {
            return Ok(height_mm);
        }
        // Layers are stretched a little, up or down, so that they fill the part: what counts is what was asked for.
        let asked_mm = self.height().or(self.voxel.cell).unwrap_or(height_mm);
        let bead_mm = settings.bead_mm.unwrap_or(if has_cells { height_mm.max(asked_mm) } else { BEAD_MM });
        let height_mm = asked_mm;
        if height_mm <= bead_mm {
            return Ok(bead_mm);
        }
        let origin = |is_given, otherwise| if is_given { "" } else { otherwise };
        let height_is = if has_cells { ", the edge of a cell," } else { ", the default," };
        let height_is = origin(settings.layer_height_mm.is_some(), height_is);
        let bead_is = origin(settings.bead_mm.is_some(), ", the default");
        let height_mm = (height_mm * 1e3).round() / 1e3;
        Err(format!(
            "layers of {height_mm} mm{height_is} are higher than a bead is wide, {bead_mm} mm{bead_is}: see --layer-height and --bead"
        ))
    }

    /// Whether a file is to be written: asked for, or one of the field and its layers in a run for research. With layers as those of
    /// printers they take hundreds of megabytes.
    fn writes(&self, extra: Extra) -> bool {
        self.also.contains(&extra) || (self.has_cells() && extra.stage() <= Stage::Surfaces)
    }

    /// By what the order of the cells is found: by what prints best, unless the run is for research, or the user asks for something that only orders by hulls
    /// have.
    fn layers_by(&self) -> LayersBy {
        if let Some(layers_by) = Guide::layers_by(self) {
            return layers_by;
        }
        let is_by_hulls = self.grow.strategy().is_some() || self.complete.nozzle_growth.is_some() || self.coherent;
        // A hull that holds a mould holds much of the part.
        let is_for_research = self.height().is_none() && self.mould.is_none();
        let default = if is_by_hulls || is_for_research { LayersBy::Hull } else { LayersBy::Best };
        self.complete.layers_by.unwrap_or(default)
    }

    /// Whether orders are printed to choose among them, or to find out where beads lie on nothing. Ranges of layers, and the run that puts them together, have to agree on
    /// the order before.
    fn chooses_by_print(&self) -> bool {
        let is_in_ranges = self.layers.is_some() || !self.merge.is_empty();
        let is_to_choose = self.layers_by() == LayersBy::Best || self.supports_beads(self.layers_by());
        is_to_choose && self.stage >= Stage::Gcode && self.resume.is_none() && !is_in_ranges
    }

    /// The orders that are tried, one after the other, until one passes all checks.
    fn orders(&self) -> Vec<LayersBy> {
        match self.layers_by() {
            LayersBy::Best => choice::orders().to_vec(),
            layers_by => vec![layers_by],
        }
    }

    /// Whether beads of an order that lie on nothing get support: orders by hulls are as the works have them.
    fn supports_beads(&self, layers_by: LayersBy) -> bool {
        let (_, support) = self.complete.with_strategy(self.grow.strategy().is_none());
        layers_by != LayersBy::Hull && support == Support::Auto
    }

    fn field_options(&self, layers_by: LayersBy, nozzle: &Nozzle) -> FieldOptions {
        let GrowArgs { eps, beyond_eps, .. } = self.grow;
        let (resolution, strategy, height_mm) = (self.voxel.resolution(), self.grow.strategy(), self.height());
        let platform_diameter_mm = self.platform_diameter_mm();
        let complete = self.complete.options(layers_by, strategy.is_none(), nozzle);
        let layers = LayerOptions { strategy, height_mm, ..complete };
        FieldOptions { resolution, eps, beyond_eps, platform_diameter_mm, layers }
    }

    /// Turns the part into its best pose.
    fn lay(&self, part: &mut Part, bars: &Bars) -> Result<Posed, Failure> {
        let start = Instant::now();
        let GrowArgs { eps, beyond_eps, .. } = self.grow;
        let rules = Rules { eps, eps_is_inside: !beyond_eps, ..Rules::default() };
        let options = self.posing.options(rules, self.platform_diameter_mm());
        let search = search(&part.mesh, &self.posing, &options, bars)?;
        let best = search.best().pose;
        if best.kind != PoseKind::Given {
            part.mesh = laid(&part.mesh, &best);
            let [x, y, z] = best.up.into_inner().into();
            part.warnings
                .push(format!("the part was turned: its direction {x:.3} {y:.3} {z:.3} points up (oriented.obj)"));
        }
        Ok(Posed { search, time: start.elapsed() })
    }

    fn platform_diameter_mm(&self) -> f64 {
        self.settings.platform_diameter_mm.unwrap_or(PLATFORM_DIAMETER_MM)
    }

    fn memory(&self) -> Memory {
        Memory(self.max_memory)
    }

    fn surface_options(&self) -> SurfaceOptions {
        SurfaceOptions { height_mm: self.height(), coherent: self.coherent, compare: self.compare }
    }

    fn path_options(&self, height_mm: f64) -> Result<PathOptions, Failure> {
        let (bead, pattern) = (self.bead(height_mm).map_err(failure)?, self.pattern.of_surface());
        let &Args { least_gap: min_gap, join_distance, least_length: min_length, least_width: min_width, .. } = self;
        let (infill, coverage) = (self.settings.infill(), self.has_statistics());
        Ok(PathOptions {
            bead,
            pattern,
            min_gap,
            join_distance,
            min_length,
            min_width,
            infill,
            coverage,
            ..PathOptions::default()
        })
    }

    /// How the layers are filled, and their support if there is any.
    fn fill(&self, part: PathOptions, surfaces: &SurfacesRun) -> LayerFill {
        let density = self.complete.support_density / 100.0;
        LayerFill { part, support: surfaces.support.as_ref().map(|_| part.for_support(density)) }
    }

    /// Whether what beads cover is measured.
    fn has_statistics(&self) -> bool {
        self.statistics || self.compare
    }

    fn support_options(&self) -> SupportOptions {
        SupportOptions { max_distance: self.support_distance, ..SupportOptions::default() }
    }

    fn print_options(&self) -> PrintOptions {
        let is_for_robot = self.stage >= Stage::Motion;
        let options = if is_for_robot { PrintOptions::for_robot() } else { PrintOptions::default() };
        let gouging = self.settings.gouging(options.gouging);
        PrintOptions { gouging, travel: self.settings.travel(), deposition: self.settings.deposition(), ..options }
    }
}

/// How the part lies on the plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Lying {
    /// As the mesh is given.
    Given,
    /// In the pose that misses the fewest cells, as best_orientation finds it.
    Best,
}

/// The pose that was found for the part.
struct Posed {
    search: Search,
    time: Duration,
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

/// Files that a run writes on demand. With --voxels, --cell or --resume all of the field and the layers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Extra {
    /// field.csv: the layer of each cell.
    FieldCsv,
    /// field.vtk: the same for ParaView.
    FieldVtk,
    /// layers.obj: the surfaces of the layers.
    LayersObj,
    /// layers.vtk: the same for ParaView, with their spacing.
    LayersVtk,
    /// paths.obj: the curves that fill the layers.
    PathsObj,
    /// toolpath.apt: for CAM and post-processors, APT with GOTO/x,y,z,i,j,k.
    Apt,
    /// toolpath.csv: every move with every digit.
    Csv,
    /// build.glb: part, layers and beads for viewers of glTF.
    Gltf,
}

impl Extra {
    /// The stage that makes it.
    fn stage(self) -> Stage {
        match self {
            Extra::FieldCsv => Stage::Field,
            Extra::FieldVtk | Extra::LayersObj | Extra::LayersVtk | Extra::Gltf => Stage::Surfaces,
            Extra::PathsObj => Stage::Paths,
            Extra::Apt | Extra::Csv => Stage::Gcode,
        }
    }
}

fn main() -> ExitCode {
    run_with_checked_args(check_arguments, |args: Args| {
        let args = args.with_profile()?;
        let setup = Setup::of(&args)?;
        let folder = args.common.folder("curved_layers", args.files(), outputs::is_ours)?;
        let saved = args.resume.as_deref().map(surfaces::load).transpose()?;
        ranges::check(&args.merge).map_err(failure)?;
        let (mut part, mould, guide) = (args.part(saved.as_ref())?, args.mould()?, Guide::of(&args)?);
        // All that is read has been read, or can be: what an earlier run has left goes now.
        folder.clear(outputs::is_ours)?;
        let bars = &Bars::new(args.common.quiet);
        pool(&args)?.install(|| {
            let posed = (args.orient == Lying::Best).then(|| args.lay(&mut part, bars)).transpose()?;
            let (part, mould, guide) = (&part, mould.as_ref(), guide.as_ref());
            let job = Job { args: &args, setup, part, mould, guide, posed, folder: &folder, bars };
            job.work(saved)
        })
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
        let nozzle = args.settings.nozzle.or(if args.motion.workcell.is_none() { Some(NOZZLE) } else { None });
        let cell = args.motion.cell(nozzle)?;
        if args.stage == Stage::Motion {
            args.motion.check_links(&cell)?;
        }
        Ok(Setup { format: args.motion.format(&cell)?, nozzle: nozzle_of(cell.equipment())?, cell })
    }
}

/// What is to be done.
struct Job<'a> {
    args: &'a Args,
    setup: Setup,
    part: &'a Part,
    mould: Option<&'a Part>,
    guide: Option<&'a Guide>,
    /// The pose of the part, where it was searched.
    posed: Option<Posed>,
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
    /// Why this order, where several were tried.
    choice: Option<Choice>,
}

impl Results {
    /// Whether a stage has been run.
    fn has(&self, stage: Stage) -> bool {
        match stage {
            Stage::Field => true,
            Stage::Surfaces => self.surfaces.is_some(),
            Stage::Paths => self.paths.is_some(),
            Stage::Gcode => self.machine.is_some(),
            Stage::Motion => self.motion.is_some(),
        }
    }
}

impl Job<'_> {
    /// Runs the stages.
    fn work(&self, saved: Option<SavedField>) -> Result<Outcome, Failure> {
        let Job { args, part, .. } = *self;
        let mut findings = Findings::default();
        part.find(&mut findings);
        self.mould.into_iter().for_each(|mould| mould.find_named(&mut findings));
        findings.say();
        let longest = part.mesh.bounds().map_or(0.0, |[low, high]| (high - low).max());
        if let Some(bead) = args.settings.bead_mm.filter(|bead| *bead > longest) {
            return Err(failure(format!("--bead {bead}: wider than the part is long, {longest:.3} mm")));
        }
        let mut results = match args.chooses_by_print() {
            true => self.best(&findings)?,
            false => self.begin(args.layers_by(), saved, &[], findings)?,
        };
        if args.stage >= Stage::Surfaces && results.surfaces.is_none() {
            return Err(failure(format!("the audit of the layers failed: {}", results.field.audit)));
        }
        if let Some(pick) = args.layers {
            return self.range(pick, results);
        }
        self.end(Stage::Surfaces.min(args.stage), &mut results)?;
        for stage in [Stage::Paths, Stage::Gcode, Stage::Motion].into_iter().filter(|stage| *stage <= args.stage) {
            self.run(stage, &mut results)?;
            self.end(stage, &mut results)?;
        }
        Ok(results.findings.outcome())
    }

    /// Field and surfaces of an order, with support where beads lay on nothing.
    fn begin(
        &self,
        layers_by: LayersBy,
        saved: Option<SavedField>,
        bare: &[Point3<f64>],
        mut findings: Findings,
    ) -> Result<Results, Failure> {
        let Job { args, part, mould, guide, bars, .. } = *self;
        let surfaces = (args.stage >= Stage::Surfaces).then(|| args.surface_options());
        let options = args.field_options(layers_by, &self.setup.nozzle);
        let (field, surfaces) =
            field::run(&options, surfaces.as_ref(), args.memory(), Given { part, mould, guide, saved, bare }, bars)?;
        // Where the edge of a cell is the layer height, it is known only now; nothing has been written yet.
        if let Some(surfaces) = surfaces.as_ref().filter(|_| args.stage >= Stage::Paths) {
            args.path_options(surfaces.height_mm)?;
        }
        part.coarse_for(field.solid.grid.cell_mm()).iter().for_each(|why| findings.add(Severity::Told, why, "", ""));
        let files = Files::default();
        let mut results =
            Results { field, surfaces, paths: None, machine: None, motion: None, files, findings, choice: None };
        findings::of_stage(Stage::Surfaces.min(args.stage), args, &mut results);
        Ok(results)
    }

    /// The order that prints best: one after the other is printed, until one passes all checks.
    fn best(&self, findings: &Findings) -> Result<Results, Failure> {
        let orders = self.args.orders();
        let (mut best, taken) = self.tried(orders[0], findings)?;
        let mut choice = Choice { taken, others: Vec::new() };
        for &layers_by in &orders[1..] {
            if choice.taken.passed {
                break;
            }
            if !self.args.common.quiet {
                self.bars.finish();
                let names = choice.names().join(" and ");
                note(format!(
                    "layers of --layers-by {names} do not pass all checks, {} is tried",
                    typed_name(layers_by)
                ));
            }
            let (results, mut tried) = self.tried(layers_by, findings)?;
            if tried.is_better_than(&choice.taken) {
                best = results;
                std::mem::swap(&mut choice.taken, &mut tried);
            }
            choice.others.push(tried);
        }
        if !best.has(Stage::Gcode) {
            let start = Instant::now();
            self.print(&mut best)?;
            let time = choice.taken.time + start.elapsed();
            choice.taken = Tried::of(choice.taken.layers_by, &best, self.args, time);
        }
        best.choice = Some(choice).filter(|choice| orders.len() > 1 || choice.taken.below_beads > 0);
        Ok(best)
    }

    /// Tries an order; where too many of its beads lie on nothing, again with support below them.
    fn tried(&self, layers_by: LayersBy, findings: &Findings) -> Result<(Results, Tried), Failure> {
        let start = Instant::now();
        let (mut best, mut tried) = self.tried_once(layers_by, &[], findings)?;
        let mut bare = choice::bare_places(&best, self.args);
        for _ in 0..SUPPORT_ROUNDS {
            if tried.passed || bare.is_empty() || !self.args.supports_beads(layers_by) {
                break;
            }
            if !self.args.common.quiet {
                self.bars.finish();
                note("too many beads lie on nothing: support is added below them");
            }
            let (results, again) = self.tried_once(layers_by, &bare, findings)?;
            bare.extend(choice::bare_places(&results, self.args));
            if again.is_better_than(&tried) {
                (best, tried) = (results, again);
            }
        }
        tried.time = start.elapsed();
        Ok((best, tried))
    }

    /// Tries an order with support below these places. One that fails before it is printed is not printed: it misses too much, or its audit failed.
    fn tried_once(
        &self,
        layers_by: LayersBy,
        bare: &[Point3<f64>],
        findings: &Findings,
    ) -> Result<(Results, Tried), Failure> {
        let start = Instant::now();
        let mut results = self.begin(layers_by, None, bare, findings.clone())?;
        if !results.findings.has_failed() {
            self.print(&mut results)?;
        }
        let tried = Tried::of(layers_by, &results, self.args, start.elapsed());
        Ok((results, tried))
    }

    /// Runs the stages from the surfaces to the machine file.
    fn print(&self, results: &mut Results) -> Result<(), Failure> {
        self.run(Stage::Paths, results)?;
        self.run(Stage::Gcode, results)
    }

    /// Fills a range of the layers and ends.
    fn range(&self, pick: Pick, mut results: Results) -> Result<Outcome, Failure> {
        let Job { args, bars, .. } = self;
        results.findings.say();
        let Results { field, surfaces: Some(surfaces), .. } = &results else { return Ok(Outcome::Done) };
        let range = pick.layers(surfaces.sheets.len()).map_err(failure)?;
        let options = args.path_options(surfaces.height_mm)?;
        args.memory().holds_paths(options.bead, field, surfaces)?;
        let fill = args.fill(options, surfaces);
        let layers = paths::range(&fill, surfaces, range.clone(), bars)?;
        bars.finish();
        ranges::write(&surfaces.surfaces(), &fill, range.clone(), &layers, self.folder)?;
        outputs::write_range(self, &results, range, &layers)?;
        Ok(results.findings.outcome())
    }

    /// Runs a stage that comes after the surfaces, unless it has been run, and finds what is wrong with it.
    fn run(&self, stage: Stage, results: &mut Results) -> Result<(), Failure> {
        if !results.has(stage) {
            self.make(stage, results)?;
            findings::of_stage(stage, self.args, results);
        }
        Ok(())
    }

    /// Makes what a stage makes.
    fn make(&self, stage: Stage, results: &mut Results) -> Result<(), Failure> {
        let Job { args, setup, bars, .. } = self;
        let (memory, nozzle) = (args.memory(), &setup.nozzle);
        let Results { field, surfaces: Some(surfaces), .. } = &*results else { return Ok(()) };
        match (stage, &results.paths, &results.machine) {
            (Stage::Paths, ..) => {
                let options = args.path_options(surfaces.height_mm)?;
                memory.holds_paths(options.bead, field, surfaces)?;
                let fill = args.fill(options, surfaces);
                let filled = match &args.merge[..] {
                    [] => Vec::new(),
                    files => ranges::read(files, &surfaces.surfaces(), &fill).map_err(failure)?,
                };
                let thinnest_mm = || {
                    let Mesh { vertices, triangles } = &self.part.mesh;
                    let thin = thinner_than(vertices, triangles, 2.0 * options.bead).ok()?;
                    thin.thinnest.map(|(mm, _)| mm)
                };
                results.paths = Some(paths::run(&fill, surfaces, filled, bars, thinnest_mm)?);
            }
            (Stage::Gcode, Some(paths), _) => {
                memory.holds_waypoints(&args.print_options(), args.stage >= Stage::Motion, paths)?;
                let mut machine = machine::run(nozzle, args, field, surfaces, paths, bars)?;
                if args.has_statistics() {
                    machine.measure_skin(&self.part.mesh, field.solid.shift, bars)?;
                }
                results.machine = Some(machine);
            }
            (Stage::Motion, Some(paths), Some(machine)) => {
                let (filament_mm, travel_mm_s) =
                    (args.settings.deposition().filament_diameter, args.settings.travel_feed_mm_s);
                let args = &args.motion;
                let print = Print { args, nozzle, filament_mm, travel_mm_s, field, surfaces, paths, machine };
                let mut motion = motion::run(&print, &setup.cell, bars)?;
                // What was written is checked, and the machine file then goes as fast as the robot.
                for _ in 0..CHECK_ROUNDS {
                    outputs::trajectory(&motion, self.folder)?;
                    let file = File::open(self.folder.path().join(outputs::TRAJECTORY)).map_err(failure)?;
                    if !motion.check(&print, BufReader::new(file), bars)? {
                        break;
                    }
                }
                results.machine.iter_mut().for_each(|machine| machine.deposition.retime(motion.steps()));
                results.motion = Some(motion);
            }
            _ => {}
        }
        Ok(())
    }

    /// Ends a stage: what is wrong is told, and what it has made is written.
    fn end(&self, stage: Stage, results: &mut Results) -> Result<(), Failure> {
        self.bars.finish();
        results.findings.say();
        outputs::write(stage, self, results)
    }
}

/// How often motions are written, checked, and unsafe ones taken out, at most; if some are unsafe at last, there are no programs.
const CHECK_ROUNDS: usize = 8;

fn pool(args: &Args) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(args.common.threads).build().map_err(failure)
}

/// A distance in layer heights, for clap: one layer lies one height above the next.
fn support_distance(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value| (1.0..=100.0).contains(value)).ok_or_else(|| "must be from 1 to 100".to_owned())
}

/// The least width of a bead in beads, for clap.
fn overhang(text: &str) -> Result<f64, String> {
    let degrees = above_zero(text).ok().filter(|degrees| *degrees < 90.0);
    degrees.ok_or_else(|| "must be above 0 and below 90".to_owned())
}

fn least_width(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value| (0.25..=0.75).contains(value))
        .ok_or_else(|| "must be from 0.25 to 0.75".to_owned())
}

/// Any error as one line.
fn failure(error: impl std::fmt::Display) -> Failure {
    Failure::new(error)
}
