//! The arguments, each declared once.

use crate::complete::CompleteArgs;
use crate::motion::args::MotionArgs;
use crate::ranges::{self, Pick};
use clap::{Command, CommandFactory, Parser, ValueEnum};
use curvlay_examples::args::{AllowArgs, Common, Failure, GrowArgs, MeshArgs, VoxelArgs, above_zero, from_zero};
use curvlay_examples::five_axis::FiveAxisPrinter;
use curvlay_examples::orienting::OrientArgs;
use curvlay_examples::settings::{self, Settings};
use curvlay_toolpath::gcode::flavour::Flavour;
use curvlay_toolpath::path::Pattern;
use std::path::PathBuf;

/// A print in curved layers, after Dai (2020), chapter 3: an audited order of cells, surfaces, paths, machine file, robot motion.
///
/// Exit status: 0 done. 1 input or output cannot be used. 2 the arguments cannot be used, or not together. 3 done, but a check
/// failed: more is missed, gouges, is left out, or over- or under-extruded by more than the --allow options permit; the audit of the
/// layers failed; travels are blocked; of a motion, waypoints are not reached or not printed, transfers are missing, or
/// the check of the written motions found something. Each finding is a line on stderr, a notice in report.html and a line in
/// summary.json.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "curved_layers")]
pub struct Args {
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// Mesh file of what the part is printed on, such as a mould or an existing part, with the same origin, unit, scale and axis as the
    /// part; the lower of both stands on the plate
    #[arg(long = "on", value_name = "FILE", help_heading = "Part")]
    pub mould: Option<PathBuf>,
    /// Mesh file of a surface: layers are parallel to it instead of in an order that is searched. An open mesh that reaches across the
    /// part and beyond, with the same origin, unit, scale and axis
    #[arg(long = "base", value_name = "FILE", conflicts_with_all = SEARCHED_ORDER, help_heading = "Part")]
    pub base: Option<PathBuf>,
    /// File of directions that layers follow instead of an order that is searched, within the tilt that layers may have: six numbers a
    /// line, `x y z i j k`, a place with the unit, scale and axis of the part and the direction of growth there. Each place of the part
    /// takes the direction nearest to it inside the part, smoothed where two meet
    #[arg(long, value_name = "FILE", conflicts_with = "base", conflicts_with_all = SEARCHED_ORDER, help_heading = "Part")]
    pub directions: Option<PathBuf>,
    /// Maximum overhang of the skin over the layers, in degrees above 0 and below 90: layers are as level as it allows, within the tilt
    /// that layers may have, instead of in an order that is searched. Beads hold about 45
    #[arg(long = "max-overhang", value_name = "DEGREES", value_parser = overhang, allow_negative_numbers = true, conflicts_with_all = ["base", "directions"], conflicts_with_all = SEARCHED_ORDER, help_heading = CELLS)]
    pub max_overhang_deg: Option<f64>,
    /// Settings of a printer, a JSON file (docs/formats/profiles.md; three are in examples/profiles); command-line options override it
    #[arg(long, value_name = "FILE", help_heading = "Run")]
    pub profile: Option<PathBuf>,
    /// The last stage to run
    #[arg(long, default_value = "gcode", help_heading = "Run")]
    pub stage: Stage,
    #[command(flatten)]
    pub settings: Settings,
    /// The flavour that the settings ask for.
    #[arg(skip)]
    pub loaded_flavour: Option<Flavour>,
    /// How each layer is filled
    #[arg(long, default_value = "spirals", help_heading = settings::LAYERS)]
    pub pattern: Fill,
    /// Smallest gap between beads that gets a bead of its own, by the area that this bead covers, in squares of a bead; 0 fills all gaps
    #[arg(long = "min-gap", alias = "least-gap", value_name = "SQUARES", default_value_t = 1.0, value_parser = from_zero, allow_negative_numbers = true, help_heading = settings::LAYERS)]
    pub min_gap_squares: f64,
    /// Joins curves of a layer whose ends are at most this far apart, in beads, where a bead fits between them; 0 joins none
    #[arg(long = "join-distance", value_name = "BEADS", default_value_t = 2.0, value_parser = from_zero, allow_negative_numbers = true, help_heading = settings::LAYERS)]
    pub join_distance_beads: f64,
    /// Leaves out curves shorter than this, in beads, beside longer ones of the same piece of a layer; 0 keeps them all
    #[arg(long = "min-length", alias = "least-length", value_name = "BEADS", default_value_t = 5.0, value_parser = from_zero, allow_negative_numbers = true, help_heading = settings::LAYERS)]
    pub min_length_beads: f64,
    /// Narrowest strip, in beads, that gets a bead where later beads would be unsupported without it; 0.75 adds no such beads
    #[arg(long = "min-width", alias = "least-width", value_name = "BEADS", default_value_t = 0.5, value_parser = width, allow_negative_numbers = true, help_heading = settings::LAYERS)]
    pub min_width_beads: f64,
    /// How the part lies on the plate
    #[arg(long, default_value = "given", conflicts_with = "resume", help_heading = "How the part lies")]
    pub orient: Lying,
    #[command(flatten)]
    pub posing: OrientArgs,
    #[command(flatten)]
    pub voxel: VoxelArgs,
    #[command(flatten)]
    pub grow: GrowArgs,
    #[command(flatten)]
    pub complete: CompleteArgs,
    /// Also tries layers with as few tears as the part allows, and takes them if less of their boundary lies inside the part; they may be
    /// less even
    #[arg(long, conflicts_with = "resume", help_heading = CELLS)]
    pub coherent: bool,
    /// Continues from the field.txt of an earlier run on the same mesh instead of growing
    #[arg(long, value_name = "FILE", conflicts_with_all = ["voxels", "cell", "strategy", "prevention"], help_heading = CELLS)]
    pub resume: Option<PathBuf>,
    /// Additional output files, separated by commas
    #[arg(long, value_name = "FILE,...", value_delimiter = ',', help_heading = settings::FILES)]
    pub also: Vec<Extra>,
    /// Fills only these layers and ends: A..B (both included, from 1), A.. or K/N (piece K of N); writes paths.jsonl for
    /// --merge and, without --resume, the field.txt that the other ranges continue from
    #[arg(long, value_name = "LAYERS", value_parser = ranges::pick, conflicts_with = "merge", help_heading = CELLS)]
    pub layers: Option<Pick>,
    /// Takes the paths of runs with --layers, which together have all layers, instead of filling the layers
    #[arg(long, value_name = "FILE", num_args = 1.., help_heading = CELLS)]
    pub merge: Vec<PathBuf>,
    /// Also writes a program for the axes of a five-axis machine, whose file names the flavour (docs/formats/machines.md; five are in
    /// examples/machines)
    #[arg(long, value_name = "FILE", help_heading = settings::FILES)]
    pub machine: Option<PathBuf>,
    /// The machine that this file describes.
    #[arg(skip)]
    pub printer: Option<FiveAxisPrinter>,
    /// Computes what the report compares with: surfaces of plain hop counts, nozzle directions without any filter
    #[arg(long, help_heading = "Run")]
    pub compare: bool,
    /// Measures by a raster what beads cover, cover twice and spill; takes nearly as long as the paths. --compare includes it
    #[arg(long, help_heading = "Run")]
    pub statistics: bool,
    /// Maximum memory of a stage in gigabytes; a stage with a higher estimate is refused before it begins
    #[arg(long = "max-memory", value_name = "GB", default_value_t = 8.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = "Run")]
    pub max_memory_gb: f64,
    /// Maximum distance of a supported bead from the plate and from earlier beads below it, in layer heights
    #[arg(long = "support-distance", value_name = "HEIGHTS", default_value_t = 1.5, value_parser = heights, allow_negative_numbers = true, help_heading = "What may be wrong")]
    pub support_distance_heights: f64,
    #[command(flatten)]
    pub allow: AllowArgs,
    #[command(flatten)]
    pub motion: MotionArgs,
    #[command(flatten)]
    pub common: Common,
}

/// Options of an order that is searched or saved, which a guide replaces.
const SEARCHED_ORDER: [&str; 5] = ["resume", "layers_by", "strategy", "nozzle_growth", "coherent"];

/// Heading of `--help` for what concerns cells, as in the shared arguments.
const CELLS: &str = "Cells and their order";

/// The everyday options, which `-h` lists; `--help` lists all.
const EVERYDAY: &str = "file unit scale up mould out threads quiet profile stage layer_height_mm bead_mm density_percent walls skin_layers \
    infill_pattern pattern nozzle platform_diameter_mm material filament_diameter_mm nozzle_celsius bed_celsius fan_share \
    flow_mm3_s max_feed_mm_s travel_feed_mm_s retraction_mm also dialect orient voxels cell resume support workcell";

/// The command as declared, with a short `-h`. An option also accepts its name in profiles and summaries, which carries its unit:
/// `--max-feed-mm-s` for `--max-feed`.
pub fn command() -> Command {
    Args::command().mut_args(|option| {
        let id = option.get_id().to_string();
        let with_unit = id.replace('_', "-");
        let option = match option.get_long() {
            Some(long) if long != with_unit => option.alias(with_unit),
            _ => option,
        };
        let is_hidden = EVERYDAY.split(' ').all(|everyday| everyday != id);
        option.hide_short_help(is_hidden)
    })
}

/// How the part lies on the plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Lying {
    /// As the mesh is given.
    Given,
    /// In the pose that misses the fewest cells, as best_orientation finds it.
    Best,
}

/// How layers are filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Fill {
    /// Connected Fermat spirals: one curve a region.
    Spirals,
    /// Rings along the boundary, not connected.
    Rings,
    /// Rows to and fro: one curve for each part that no hole divides.
    Zigzag,
}

impl Fill {
    pub fn of_surface(self) -> Pattern {
        match self {
            Fill::Spirals => Pattern::Spirals,
            Fill::Rings => Pattern::Rings,
            Fill::Zigzag => Pattern::Zigzag,
        }
    }
}

/// The last stage to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Stage {
    /// A first look, in seconds: some of the layers, findings, estimates of time and material; takes the options of the full run.
    Preview,
    /// The growing field: which cell belongs to which layer.
    Field,
    /// The surfaces: uniform layers, contoured and trimmed to the mesh.
    Surfaces,
    /// Tool paths: continuous curves that fill the surfaces.
    Paths,
    /// The machine file: the poses of the nozzle and the material it deposits.
    Gcode,
    /// Joint trajectories and programs of a robot, transfers included; optional.
    Motion,
}

/// Optional files. With --voxels, --cell or --resume those of the field and the layers are always written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Extra {
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
    /// build.3mf: mesh and toolpath with nozzle directions, after the Toolpath Extension of 3MF.
    #[value(name = "3mf")]
    Tmf,
    /// beads.build.3mf: the same without travels, for consumers that find their own.
    #[value(name = "3mf-beads")]
    TmfBeads,
    /// build.glb: part, layers and beads for viewers of glTF.
    Gltf,
}

impl Extra {
    /// The stage that makes it.
    pub fn stage(self) -> Stage {
        match self {
            Extra::FieldCsv => Stage::Field,
            Extra::FieldVtk | Extra::LayersObj | Extra::LayersVtk | Extra::Gltf => Stage::Surfaces,
            Extra::PathsObj => Stage::Paths,
            Extra::Apt | Extra::Csv | Extra::Tmf | Extra::TmfBeads => Stage::Gcode,
        }
    }
}

/// A distance in layer heights, for clap: one layer lies one height above the next.
fn heights(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value| (1.0..=100.0).contains(value)).ok_or_else(|| "must be from 1 to 100".to_owned())
}

/// An angle of overhang in degrees, for clap.
fn overhang(text: &str) -> Result<f64, String> {
    let degrees = above_zero(text).ok().filter(|degrees| *degrees < 90.0);
    degrees.ok_or_else(|| "must be above 0 and below 90".to_owned())
}

/// A share of the width of a bead, for clap.
fn width(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value| (0.25..=0.75).contains(value))
        .ok_or_else(|| "must be from 0.25 to 0.75".to_owned())
}

/// Any error as one line.
pub fn failure(error: impl std::fmt::Display) -> Failure {
    Failure::new(error)
}
