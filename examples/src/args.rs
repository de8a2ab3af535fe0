//! Arguments that the examples share, and their exit status.
//!
//! Each group is flattened into the arguments of an example:
//! ```
//! use clap::Parser;
//! use curvlay_examples::args::{Common, MeshArgs};
//! #[derive(Parser)]
//! struct Args {
//!     #[command(flatten)]
//!     mesh: MeshArgs,
//!     #[command(flatten)]
//!     common: Common,
//! }
//! let args = Args::try_parse_from(["curved_layers", "--unit", "m", "--threads", "2"])?;
//! assert_eq!((args.common.threads, args.mesh.mesh), (2, None));
//! assert!(Args::try_parse_from(["curved_layers", "--scale", "0"]).is_err());
//! # Ok::<(), clap::Error>(())
//! ```

use crate::findings::{Finding, Findings, Severity};
use crate::input::Inputs;
use crate::mesh::{Mesh, MeshError, MeshFault, MeshFile, Placement, Unit, Up, mesh_findings, read_mesh_file};
use crate::output::{OutputError, OutputFolder};
use crate::signals;
use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, FromArgMatches, Parser, ValueEnum};
use curvlay_layers::curved;
use curvlay_voxel::{OrientReport, Resolution};
use serde::Serialize;
use std::env;
use std::error::Error;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;

/// What all examples take.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Run")]
pub struct Common {
    /// Folder for the results [default: target/out/ and the name of the example]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Number of threads; the results do not depend on it
    #[arg(long, value_name = "N", default_value_t = cores(), value_parser = threads, allow_negative_numbers = true)]
    pub threads: usize,
    /// No progress bars
    #[arg(long, short)]
    pub quiet: bool,
}

impl Common {
    /// Opens the output folder: the one asked for, or `target/out/NAME`. To be done before the work. `inputs` are the files that the run
    /// reads, and `is_ours` says which names it writes.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written, or when an input has the name of a file that the run writes there.
    pub fn folder<'a>(
        &self,
        name: &str,
        inputs: impl IntoIterator<Item = Option<&'a Path>>,
        is_ours: impl Fn(&str) -> bool,
    ) -> Result<OutputFolder, OutputError> {
        let default = || Path::new("target").join("out").join(name);
        let inputs = Inputs::new(inputs.into_iter().flatten());
        OutputFolder::create(&self.out.clone().unwrap_or_else(default))?.guarding(inputs, is_ours)
    }
}

/// Which part, and how it is meant.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Part")]
pub struct MeshArgs {
    /// STL, 3MF, OBJ or PLY file [default: a jug made in code, 41 mm tall; with --voxels or --cell 93 mm]
    #[arg(value_name = "MESH", help_heading = "Part")]
    pub file: Option<PathBuf>,
    /// Mesh file (same as the positional MESH)
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    pub mesh: Option<PathBuf>,
    /// Unit of the numbers in the file
    #[arg(long, default_value = "mm")]
    pub unit: Unit,
    /// Factor by which the part is enlarged
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub scale: f64,
    /// Axis of the file that points up
    #[arg(long, default_value = "z", allow_hyphen_values = true)]
    pub up: Up,
    /// Accepts a part larger than 10 m
    #[arg(long)]
    pub allow_large: bool,
    /// Accepts an ambiguous mesh (open, or with shells or sheets of unclear meaning); otherwise the exit status is 3
    #[arg(long)]
    pub allow_guesses: bool,
}

/// A part as it was read, in millimetres with z up.
#[derive(Clone, Debug)]
pub struct Part {
    /// The file without its folder, or the name of the shape.
    pub name: String,
    /// The part.
    pub mesh: Mesh,
    /// What the user should look at, a line each: doubts about its size.
    pub warnings: Vec<String>,
    /// What the reader decided, what was done to the mesh, and in what it may be another part than its author's.
    pub findings: Vec<Finding>,
    /// How its triangles were turned, with the volume that they bound.
    pub orientation: OrientReport,
    /// How fine its coordinates are if they are of single precision.
    pub spacing_mm: Option<f64>,
}

/// Share of a cell from which on the spacing of single-precision coordinates is told: half of it is how far a corner may
/// be off, and below some hundredths no cell is another.
const COARSE: f64 = 0.05;

impl Part {
    /// Adds all that there is to say about the mesh.
    pub fn find(&self, findings: &mut Findings) {
        self.warnings.iter().for_each(|warning| findings.add(Severity::Told, warning, "", ""));
        self.findings.iter().for_each(|finding| findings.push(finding.clone()));
    }

    /// The same with its name before each: for one that is not the part itself.
    pub fn find_named(&self, findings: &mut Findings) {
        let named = |what: &str| format!("{}: {what}", self.name);
        self.warnings.iter().for_each(|warning| findings.add(Severity::Told, named(warning), "", ""));
        self.findings
            .iter()
            .for_each(|finding| findings.push(Finding { what: named(&finding.what), ..finding.clone() }));
    }

    /// A warning if the coordinates are too coarse for cells of that size.
    pub fn coarse_for(&self, cell_mm: f64) -> Option<String> {
        let spacing_mm = self.spacing_mm.filter(|&spacing_mm| spacing_mm > COARSE * cell_mm)?;
        Some(format!(
            "the numbers in the file are of single precision and lie {spacing_mm:.3} mm apart so far from its origin, {:.0} % \
             of a cell: the part is distorted; export it nearer to the origin",
            100.0 * spacing_mm / cell_mm
        ))
    }
}

impl MeshArgs {
    /// Unit, scale, axis, and whether it may be large.
    pub fn placement(&self) -> Placement {
        Placement { unit: self.unit, scale: self.scale, up: self.up, allow_large: self.allow_large }
    }

    /// The file, however it was given.
    pub fn path(&self) -> Option<&Path> {
        self.file.as_deref().or(self.mesh.as_deref())
    }

    /// Reads the file, or makes `shape` when there is none; unit, scale and axis apply to both. Triangles that look the
    /// wrong way are turned; what was guessed or left out is among the findings.
    ///
    /// # Errors
    /// [`MeshError`] when the file cannot be used.
    pub fn load(&self, shape_name: &str, shape: impl FnOnce() -> Mesh) -> Result<Part, MeshError> {
        match self.path() {
            Some(path) => self.load_file(path),
            None => {
                let (path, file) = (PathBuf::from(shape_name), MeshFile::of(shape()));
                self.prepare(shape_name.to_owned(), file).map_err(|fault| MeshError { path, fault })
            }
        }
    }

    /// Reads another file with the same unit, scale and axis.
    ///
    /// # Errors
    /// [`MeshError`] when the file cannot be used.
    pub fn load_file(&self, path: &Path) -> Result<Part, MeshError> {
        let file = read_mesh_file(path)?;
        let name = path.file_name().map_or_else(String::new, |name| printable(&name.to_string_lossy()));
        self.prepare(name, file).map_err(|fault| MeshError { path: path.to_owned(), fault })
    }

    /// Reads a surface with the same unit, scale and axis: its triangles stay as they are.
    ///
    /// # Errors
    /// [`MeshError`] when the file cannot be used.
    pub fn load_surface(&self, path: &Path) -> Result<Mesh, MeshError> {
        let MeshFile { mut mesh, states_unit, .. } = read_mesh_file(path)?;
        let mut placement = self.placement();
        placement.unit = if states_unit { Unit::Mm } else { placement.unit };
        placement.apply(&mut mesh).map_err(|fault| MeshError { path: path.to_owned(), fault })?;
        Ok(mesh)
    }

    /// Places and orients a mesh.
    fn prepare(&self, name: String, file: MeshFile) -> Result<Part, MeshFault> {
        let MeshFile { mut mesh, mut findings, states_unit } = file;
        let mut placement = self.placement();
        let mut warnings = Vec::new();
        if states_unit && placement.unit != Unit::Mm {
            warnings.push(format!("the file states its unit: --unit {} was not used", typed_name(placement.unit)));
            placement.unit = Unit::Mm;
        }
        let spacing_mm = mesh.float32_spacing().map(|spacing| spacing * placement.unit.millimetres() * placement.scale);
        warnings.extend(placement.apply(&mut mesh)?);
        let orientation = mesh.orient()?;
        findings.extend(mesh_findings(&orientation, self.allow_guesses));
        if orientation.volume_mm3 <= 0.0 {
            return Err(MeshFault::NoVolume { triangles: mesh.triangles.len() });
        }
        Ok(Part { name, mesh, warnings, findings, orientation, spacing_mm })
    }
}

/// How large the cells are: one of the two, or neither.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Cells and their order")]
pub struct VoxelArgs {
    /// Number of cells to aim for [default: as many as make a cell as high as a layer, but 100,000 at most; for large parts as many as
    /// make a cell four layers high]
    #[arg(long, value_name = "N", conflicts_with = "cell", value_parser = count, allow_negative_numbers = true)]
    pub voxels: Option<u64>,
    /// Edge of a cell in millimetres
    #[arg(long, value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub cell: Option<f64>,
}

impl VoxelArgs {
    /// As voxelising takes it, if the user says.
    pub fn resolution(&self) -> Option<Resolution> {
        self.cell.map(Resolution::Cell).or(self.voxels.map(Resolution::Count))
    }
}

/// How the part grows.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Cells and their order")]
pub struct GrowArgs {
    /// Depth inside the hull from which a cell counts as shadowed, in cells
    #[arg(long = "eps", value_name = "CELLS", default_value_t = 1.0, value_parser = eps, allow_negative_numbers = true)]
    pub eps_cells: f64,
    /// Only cells deeper than --eps count as shadowed, not those at exactly that depth
    #[arg(long)]
    pub beyond_eps: bool,
    /// How the next layer is chosen
    #[arg(long, default_value = "best")]
    pub strategy: Strategy,
    /// How the strategies governed and printed keep cells from being shadowed
    #[arg(long, default_value = "adaptive")]
    pub prevention: Prevention,
}

impl GrowArgs {
    /// As growing takes it; `None` for the best one.
    pub fn strategy(&self) -> Option<curved::Strategy> {
        let prevention = match self.prevention {
            Prevention::Incremental => curved::Prevention::Incremental,
            Prevention::Adaptive => curved::Prevention::Adaptive,
        };
        match self.strategy {
            Strategy::Best => None,
            Strategy::Greedy => Some(curved::Strategy::Greedy),
            Strategy::Incremental => Some(curved::Strategy::Incremental),
            Strategy::Adaptive => Some(curved::Strategy::Adaptive),
            Strategy::Governed => Some(curved::Strategy::Governed(prevention)),
            Strategy::Unbuild => Some(curved::Strategy::Unbuild),
            Strategy::Printed => Some(curved::Strategy::Printed(prevention)),
        }
    }
}

/// How the next layer is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Strategy {
    /// Incremental; where that misses cells, un-built as well: what fills more of the part.
    Best,
    /// All cells that can be built now.
    Greedy,
    /// Cell by cell, unless it shadows others.
    Incremental,
    /// All, halving the set while it shadows others.
    Adaptive,
    /// In the order of a peeling field.
    Governed,
    /// In the reverse of the order in which the part can be taken apart.
    Unbuild,
    /// Field-governed as printed in the dissertation, to compare with.
    Printed,
}

/// How cells are kept from being shadowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Prevention {
    /// Cell by cell.
    Incremental,
    /// By halving sets.
    Adaptive,
}

/// What may be wrong before the exit status is 3.
#[derive(Args, Clone, Copy, Debug, Serialize)]
#[command(next_help_heading = "What may be wrong")]
pub struct AllowArgs {
    /// Maximum share of the volume of the part in missed cells; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 1e-3, value_parser = share, allow_negative_numbers = true)]
    pub allow_missed: f64,
    /// Maximum deviation of the deposited volume from that of the part, with and without missed cells, as a share; more sets exit status
    /// 3
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, value_parser = share, allow_negative_numbers = true)]
    pub allow_volume: f64,
    /// Maximum share of waypoints at which the nozzle gouges; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 1e-3, value_parser = share, allow_negative_numbers = true)]
    pub allow_gouging: f64,
    /// Maximum share of the path length that is left out; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 1e-3, value_parser = share, allow_negative_numbers = true)]
    pub allow_left_out: f64,
    /// Maximum share of the bead length that is unsupported, without spans held at both ends; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 5e-3, value_parser = share, allow_negative_numbers = true)]
    pub allow_unsupported: f64,
    /// Maximum length of a single unsupported piece, in bead widths; more sets exit status 3
    #[arg(long, value_name = "BEADS", default_value_t = 40.0, value_parser = from_zero, allow_negative_numbers = true)]
    pub allow_unsupported_beads: f64,
    /// Maximum share of the path length that no robot program prints (unreachable, colliding, without a transfer, or withheld); more sets
    /// exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share, allow_negative_numbers = true)]
    pub allow_unprinted: f64,
}

/// The name of a choice as it is typed.
pub fn typed_name(choice: impl ValueEnum) -> String {
    choice.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Most threads that make sense: more only cost memory, and a slip of the keyboard should not start a million.
const MAX_THREADS: usize = 1024;

fn cores() -> usize {
    thread::available_parallelism().map_or(1, |n| n.get().min(MAX_THREADS))
}

fn threads(text: &str) -> Result<usize, String> {
    let n: usize = text.parse().map_err(|_| "not a whole number".to_owned())?;
    if (1..=MAX_THREADS).contains(&n) { Ok(n) } else { Err(format!("must be from 1 to {MAX_THREADS}")) }
}

fn count(text: &str) -> Result<u64, String> {
    text.parse().ok().filter(|&n| n > 0).ok_or_else(|| "must be a whole number from 1 on".to_owned())
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "not a number".to_owned())
}

/// A finite number above zero, for clap.
///
/// # Errors
/// What is wrong with it.
pub fn above_zero(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err("must be above 0 and finite".to_owned()) }
}

/// A number from 0 on, for clap.
///
/// # Errors
/// What is wrong with it.
pub fn from_zero(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value.is_finite() && value >= 0.0 { Ok(value) } else { Err("must be 0 or more, and finite".to_owned()) }
}

/// A share from 0 to 1, for clap.
///
/// # Errors
/// What is wrong with it.
pub fn share(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err("must be from 0 to 1".to_owned()) }
}

/// A number above zero, or `inf` for no limit, for clap.
///
/// # Errors
/// What is wrong with it.
pub fn limit(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value > 0.0 { Ok(value) } else { Err("must be above 0, or inf for no limit".to_owned()) }
}

/// A temperature, for clap.
///
/// # Errors
/// What is wrong with it.
pub fn celsius(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if (0.0..=600.0).contains(&value) { Ok(value) } else { Err("must be from 0 to 600".to_owned()) }
}

fn eps(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if (0.0..=16.0).contains(&value) { Ok(value) } else { Err("must be from 0 to 16".to_owned()) }
}

/// How an example ended that could do its work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All is well.
    Done,
    /// Checks failed: which, a line each, of those that were not reported yet.
    ChecksFailed(Vec<String>),
}

impl Outcome {
    /// Done, if no check failed.
    pub fn of(failed: Vec<String>) -> Self {
        if failed.is_empty() { Outcome::Done } else { Outcome::ChecksFailed(failed) }
    }
}

/// Input or output that cannot be used, or arguments that do not go together, in one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    message: String,
    status: u8,
}

impl Failure {
    /// Input or output that cannot be used. Takes the message; line breaks become spaces.
    pub fn new(message: impl Display) -> Self {
        let message = message.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
        Failure { message, status: UNUSABLE }
    }

    /// The same for arguments that cannot be used together.
    pub fn of_arguments(message: impl Display) -> Self {
        Failure { status: ARGUMENTS, ..Failure::new(message) }
    }

    /// The line.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl<E: Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Failure::new(error)
    }
}

/// Exit status for input or output that cannot be used.
const UNUSABLE: u8 = 1;
/// Exit status for arguments that cannot be used.
const ARGUMENTS: u8 = 2;
/// Exit status of a run that finished, but a check of ours failed.
const CHECK_FAILED: u8 = 3;

/// Parses the command line and runs `main` on it.
///
/// # Returns
/// 0: done (help and version, too). 1: `main` failed, one line on stderr says at what. 2: the arguments cannot be
/// used, one line on stderr says which. 3: done, but checks failed, each with its line on stderr.
pub fn run_with_args<A: Parser>(main: impl FnOnce(A) -> Result<Outcome, Failure>) -> ExitCode {
    run_command(A::command(), env::args_os(), |args, _| main(args))
}

/// The same for a command that is more than its declaration, on a command line whose first word is the name of the program. `main` gets
/// the matches, too: they know [what was typed](is_typed).
pub fn run_command<A: FromArgMatches>(
    command: Command,
    words: impl IntoIterator<Item = impl Into<OsString> + Clone>,
    main: impl FnOnce(A, &ArgMatches) -> Result<Outcome, Failure>,
) -> ExitCode {
    let parsed = command.try_get_matches_from(words).and_then(|matches| Ok((A::from_arg_matches(&matches)?, matches)));
    match parsed {
        Ok((args, matches)) => run(|| main(args, &matches)),
        Err(error) if !error.use_stderr() => {
            // Help; if it cannot be written, nobody is there to read it.
            let _ = error.print();
            ExitCode::SUCCESS
        }
        Err(error) => {
            say(&one_line(&error));
            ExitCode::from(ARGUMENTS)
        }
    }
}

/// Whether an option was typed, rather than left at its default. What is no option was not.
pub fn is_typed(matches: &ArgMatches, id: &str) -> bool {
    matches.ids().any(|known| known == id) && matches.value_source(id) == Some(ValueSource::CommandLine)
}

/// Runs `main` and turns its end into an exit status, as [`run_with_args`].
pub fn run(main: impl FnOnce() -> Result<Outcome, Failure>) -> ExitCode {
    signals::handle();
    match main() {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::ChecksFailed(failed)) => {
            failed.iter().for_each(|check| say(&format!("check failed: {check}")));
            ExitCode::from(CHECK_FAILED)
        }
        Err(failure) => {
            say(&format!("error: {}", failure.message));
            ExitCode::from(failure.status)
        }
    }
}

/// What clap says, without usage and hints, in one line that begins with `error: `.
pub fn one_line(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let told =
        text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"));
    told.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Writes to stderr what was done, or comes next.
pub fn note(message: impl Display) {
    say(&format!("note: {message}"));
}

/// Writes a warning to stderr.
pub fn warn(message: impl Display) {
    say(&format!("warning: {message}"));
}

/// Writes a warning to stderr that a mesh is not closed, if edges of it are open.
pub fn warn_if_open(open_edges: usize) {
    if open_edges > 0 {
        warn(format!(
            "the mesh is not closed: {open_edges} of its edges have one triangle only; holes are closed by a guess"
        ));
    }
}

/// Writes a line to stderr.
pub(crate) fn say(line: &str) {
    // With stderr gone there is no place left to complain.
    let _ = writeln!(io::stderr(), "{}", printable(line));
}

/// A text on one line as a terminal may show it: a file's name may hold control characters, which would clear the screen or worse.
/// ```
/// assert_eq!(curvlay_examples::args::printable("a\u{1b}[2J.stl"), "a\\u{1b}[2J.stl");
/// ```
pub fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { c.escape_default().to_string() } else { c.to_string() }).collect()
}
