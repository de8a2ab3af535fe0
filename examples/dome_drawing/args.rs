//! The arguments, each declared once.

use super::setup::Setup;
use clap::{Parser, ValueEnum};
use curvlay_examples::args::{Common, Failure, above_zero, from_zero};
use std::path::{Path, PathBuf};

/// A drawing on a domed platform, from DXF or SVG to RAPID, after Brooks (2016).
#[derive(Parser, Clone, Debug)]
#[command(version, name = "dome_drawing")]
pub struct Args {
    /// DXF or SVG file with the design, or a saved `design.drawing`, recognised by the ending of its name
    #[arg(value_name = "DRAWING", conflicts_with_all = ["dxf", "svg", "load", "design"])]
    pub file: Option<PathBuf>,
    /// DXF file with the design, whatever its name
    #[arg(long, value_name = "FILE", conflicts_with_all = ["svg", "load"])]
    pub dxf: Option<PathBuf>,
    /// SVG file with the design, whatever its name
    #[arg(long, value_name = "FILE", conflicts_with = "load")]
    pub svg: Option<PathBuf>,
    /// File with the design that an earlier run saved (`design.drawing`)
    #[arg(long, value_name = "FILE")]
    pub load: Option<PathBuf>,
    /// Built-in design, used without a file
    #[arg(long, default_value = "rosette", conflicts_with_all = ["dxf", "svg", "load"])]
    pub design: Design,
    /// Unit of the coordinates of the file, instead of the one that it states [default: the stated one; without, mm for DXF and pixels of
    /// --dpi for SVG]
    #[arg(long, conflicts_with = "load")]
    pub unit: Option<DrawingUnit>,
    /// Pixels per inch of an SVG file: 72 of Adobe Illustrator, 90 of Inkscape before 0.92 [default: 96]
    #[arg(long, value_name = "N", value_parser = dpi, conflicts_with = "unit", allow_negative_numbers = true)]
    pub dpi: Option<f64>,
    /// Layer to print; may be given more than once [default: all]
    #[arg(long, value_name = "NAME")]
    pub layer: Vec<String>,
    /// Diameter to which the design is scaled, in millimetres [default: its own]
    #[arg(long = "diameter", value_name = "MM", value_parser = length, allow_negative_numbers = true)]
    pub diameter_mm: Option<f64>,
    /// Point of the drawing that lies at the pole of the dome [default: the middle of the design]
    #[arg(long = "centre", value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    pub centre_mm: Option<[f64; 2]>,
    /// Width of a bead in millimetres
    #[arg(long = "bead", value_name = "MM", default_value_t = 3.2, value_parser = bead, allow_negative_numbers = true)]
    pub bead_mm: f64,
    /// How contours are filled
    #[arg(long, default_value = "spiral")]
    pub fill: FillKind,
    /// Direction of scan lines in degrees
    #[arg(long = "angle", value_name = "DEG", default_value_t = 90.0, value_parser = angle, allow_negative_numbers = true)]
    pub angle_deg: f64,
    /// Ends each scan line separately, as in the thesis, instead of joining them as a zigzag
    #[arg(long)]
    pub no_zigzag: bool,
    /// Puts the outermost bead on the contour, as in the thesis, instead of half a bead within it
    #[arg(long)]
    pub on_line: bool,
    /// Surface that carries the design: dome (the platform of the thesis), sphere (of radius 200 mm), or a mesh file with its middle on
    /// the axis
    #[arg(long, value_name = "NAME|FILE", default_value = "dome")]
    pub surface: String,
    /// Projection of the design onto the surface
    #[arg(long, default_value = "vertical")]
    pub projection: ProjectionKind,
    /// Diameter of the platform in millimetres
    #[arg(long = "platform-diameter", value_name = "MM", default_value_t = 300.0, value_parser = length, allow_negative_numbers = true)]
    pub platform_diameter_mm: f64,
    /// Maximum distance between points of the program, in millimetres; 0.2 in the thesis
    #[arg(long = "step", value_name = "MM", default_value_t = 1.0, value_parser = step, allow_negative_numbers = true)]
    pub step_mm: f64,
    /// Maximum distance between ends that are joined, in millimetres
    #[arg(long = "join", value_name = "MM", default_value_t = 0.005, value_parser = join_width, allow_negative_numbers = true)]
    pub join_mm: f64,
    /// Minimum area of a closed piece in square millimetres; smaller ones are left out, as are open pieces shorter than a bead
    #[arg(long = "min-area", value_name = "MM2", default_value_t = 0.0, value_parser = from_zero, allow_negative_numbers = true)]
    pub min_area_mm2: f64,
    /// Number of layers of beads
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub layers: u32,
    /// Height of a layer of beads in millimetres
    #[arg(long = "layer-height", value_name = "MM", default_value_t = 1.0, value_parser = length, allow_negative_numbers = true)]
    pub layer_height_mm: f64,
    /// Additional height of the nozzle over the surface, in millimetres
    #[arg(long = "nozzle-height", value_name = "MM", default_value_t = 0.0, value_parser = height, allow_negative_numbers = true)]
    pub nozzle_height_mm: f64,
    /// Streams the checked program to a controller that runs `drawing_link.mod` and `drawing_move.mod`; standard input accepts `pause`,
    /// `resume`, and `height MM`
    #[arg(long = "stream", value_name = "HOST:PORT", value_parser = address)]
    pub stream: Option<String>,
    /// Length of the queue of the controller
    #[arg(long = "queue", value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub queue: u32,
    /// Maximum number of connections in a row that fail or make no progress
    #[arg(long = "stream-tries", value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub stream_tries: u32,
    /// Time to wait for a reply, and before a new connection, in seconds; doubles after each connection without progress, up to 30 s
    #[arg(long = "stream-retry", value_name = "S", default_value_t = 1.0, value_parser = retry, allow_negative_numbers = true)]
    pub stream_retry_s: f64,
    /// Time for which the extruder runs backwards at the end of each stroke, in milliseconds, while streaming
    #[arg(long = "pulse-reverse", value_name = "MS", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=60_000))]
    pub pulse_reverse_ms: u32,
    /// JSON file with the rig and the process: arm, home, heights, dome, speeds, turns of the extruder, lift and gap of the fill; each run
    /// writes its own as `setup.json` [default: as in the thesis]
    #[arg(long = "setup", value_name = "FILE")]
    pub setup_file: Option<PathBuf>,
    /// `plan.json` of an earlier run: its program is written and checked again, without design and planning
    #[arg(long = "plan", value_name = "FILE", conflicts_with_all = DESIGN)]
    pub plan_file: Option<PathBuf>,
    /// What is in it.
    #[arg(skip)]
    pub setup: Setup,
    /// Maximum number of moves in a RAPID module
    #[arg(long, value_name = "N", default_value_t = 5000, value_parser = clap::value_parser!(u32).range(1..))]
    pub moves_per_module: u32,
    #[command(flatten)]
    pub(super) common: Common,
}

/// What a plan has settled.
pub const DESIGN: [&str; 25] = [
    "file",
    "dxf",
    "svg",
    "load",
    "design",
    "unit",
    "dpi",
    "layer",
    "diameter_mm",
    "centre_mm",
    "bead_mm",
    "fill",
    "angle_deg",
    "no_zigzag",
    "on_line",
    "surface",
    "projection",
    "platform_diameter_mm",
    "step_mm",
    "join_mm",
    "min_area_mm2",
    "layers",
    "layer_height_mm",
    "nozzle_height_mm",
    "setup_file",
];

/// Designs made in code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Design {
    /// Two crowns of leaves around a hub, and stems.
    Rosette,
    /// Many narrow leaves: the size of the design of the thesis.
    Large,
}

/// Unit of a drawing's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DrawingUnit {
    /// Millimetres.
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
    /// Inches.
    In,
    /// Points: 1/72 of an inch.
    Pt,
}

/// How contours are filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FillKind {
    /// Not at all.
    None,
    /// By scan lines.
    Lines,
    /// By loops.
    Concentric,
    /// By loops joined to one curve.
    Spiral,
}

/// How a design comes onto a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProjectionKind {
    /// Along z.
    Vertical,
    /// From a point as far below the design as the dome is high.
    Point,
    /// With the lengths of the meridians.
    Meridian,
    /// Onto a mesh that is unrolled with the least distortion of its lengths.
    Rigid,
    /// Onto a mesh that is unrolled with its angles.
    Conformal,
}

/// Longest length that an option takes, in millimetres: larger ones are a slip.
pub const MAX_LENGTH_MM: f64 = 1e5;

pub fn length(text: &str) -> Result<f64, String> {
    at_most(above_zero(text)?, MAX_LENGTH_MM)
}

pub fn bead(text: &str) -> Result<f64, String> {
    let mm = above_zero(text)?;
    if mm >= 0.01 { at_most(mm, 1000.0) } else { Err("must be at least 0.01".to_owned()) }
}

pub fn join_width(text: &str) -> Result<f64, String> {
    at_most(from_zero(text)?, 1000.0)
}

pub fn at_most(value: f64, most: f64) -> Result<f64, String> {
    if value <= most { Ok(value) } else { Err(format!("must be at most {most}")) }
}

pub fn retry(text: &str) -> Result<f64, String> {
    let seconds = above_zero(text)?;
    if (0.01..=600.0).contains(&seconds) { Ok(seconds) } else { Err("must be from 0.01 to 600".to_owned()) }
}

pub fn angle(text: &str) -> Result<f64, String> {
    let degrees: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if degrees.abs() <= 3600.0 { Ok(degrees) } else { Err("must be from -3600 to 3600".to_owned()) }
}

pub fn dpi(text: &str) -> Result<f64, String> {
    let value = above_zero(text)?;
    if (1.0..=1e5).contains(&value) { Ok(value) } else { Err("must be from 1 to 100000".to_owned()) }
}

pub fn step(text: &str) -> Result<f64, String> {
    above_zero(text).and_then(|mm| if mm >= 0.01 { Ok(mm) } else { Err("must be at least 0.01".to_owned()) })
}

pub fn height(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if value.abs() <= 50.0 { Ok(value) } else { Err("must be from -50 to 50".to_owned()) }
}

pub fn address(text: &str) -> Result<String, String> {
    let is_address = text
        .rsplit_once(':')
        .is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0));
    if is_address { Ok(text.to_owned()) } else { Err("must be HOST:PORT, as in 192.168.125.1:5000".to_owned()) }
}

pub fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|word| word.trim().parse().ok().filter(|x: &f64| x.abs() <= 1e6)).collect();
    numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| "must be two numbers, as in 10,-5".to_owned())
}

impl Args {
    /// Takes the word by the ending of its name, as --dxf, --svg or --load.
    pub fn sorted(mut self) -> Result<Self, Failure> {
        let Some(file) = self.file.take() else { return Ok(self) };
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        let place = match ending.as_deref() {
            Some("dxf") => &mut self.dxf,
            Some("svg" | "svgz") => &mut self.svg,
            Some("drawing") => &mut self.load,
            _ => {
                let why = "the ending of its name says no format; export a drawing as .dxf or .svg, or name it with --dxf or --svg";
                return Err(Failure::new(format!("{}: {why}", file.display())));
            }
        };
        *place = Some(file);
        Ok(self)
    }

    /// The files that it reads.
    pub fn files(&self) -> [Option<&Path>; 6] {
        let surface = (!matches!(self.surface.as_str(), "dome" | "sphere")).then(|| Path::new(&self.surface));
        [
            self.dxf.as_deref(),
            self.svg.as_deref(),
            self.load.as_deref(),
            surface,
            self.setup_file.as_deref(),
            self.plan_file.as_deref(),
        ]
    }
}
