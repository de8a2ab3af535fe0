//! Continuous fibre between layers: the specimens of the dissertation with their tapes, machine files, the motion of a UR3 and what stiffness theory
//! says beside the measured; and a whole part with tapes in chosen layers along its principal stresses, as a machine file and a robot program.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), chapter 5, after C.-C. Li, C. Dai, W.-H. Liao and C. C. L. Wang, "Towards
//! direct deposition of continuous-fibers on curved surfaces", 2020; section 6.2.3 for paths that follow stresses.
//! ```sh
//! cargo run --release --example continuous_fiber
//! cargo run --release --example continuous_fiber -- part.stl --layers 4,8,12 --tape-width 1.1 --min-radius 5
//! cargo run --release --example continuous_fiber -- part.stl --every 3 --stress stress.csv
//! ```
//! Without a part the layer is one of the arc, pressed as in the dissertation's test. `--help` lists the options.

mod arcs;
mod drawing;
mod follow_load;
mod layer;
mod motion;
mod outputs;
mod part;
mod part_motion;
mod part_outputs;
mod planar;
mod predict;
mod specimens;
mod tapes;
mod wires;

use clap::{Parser, ValueEnum};
use curvlay_examples::args::{Common, Failure, MeshArgs, Outcome, Part, above_zero, from_zero, run_with_args, share};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::{Findings, Severity, percent};
use curvlay_examples::input;
use curvlay_examples::motion::{UR3_CELL, nozzle_of};
use curvlay_examples::nalgebra::Point3;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::shapes::jug;
use curvlay_examples::table::Table;
use curvlay_examples::waypoints::fault;
use curvlay_kinematics::workcell::AnyWorkcell;
use curvlay_layers::elastic::Material;
use curvlay_toolpath::fiber::conductor::ConductorOptions;
use curvlay_toolpath::fiber::head::TapeHead;
use curvlay_toolpath::fiber::sandwich::SandwichOptions;
use curvlay_toolpath::fiber::stress::StressSample;
use curvlay_toolpath::fiber::tapes::{Tape, TapeOptions};
use layer::LoadedLayer;
use motion::Moved;
use part::PartRun;
use planar::Planar;
use predict::{Predictions, predict};
use rayon::ThreadPoolBuilder;
use specimens::Specimen;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use tapes::Planned;

/// Tapes of continuous fibre between layers: specimens of Dai (2020), chapter 5, and a layer of a part under load.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "continuous_fiber")]
pub struct Args {
    #[command(flatten)]
    mesh: MeshArgs,
    /// How far to go
    #[arg(long, value_name = "NAME", default_value = "motion")]
    stage: Stage,
    /// Layers of the part that carry tapes, from 1, such as 4,8,12; the last layer carries none, since nothing would cover them
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true, conflicts_with = "every", help_heading = LOAD)]
    layers: Vec<u32>,
    /// Tapes on every n-th layer instead: n, 2n, 3n, ...
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true, help_heading = LOAD)]
    every: u32,
    /// Height of the layers in millimetres [default: the edge of a cell]
    #[arg(long = "layer-height", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    layer_height_mm: Option<f64>,
    /// Width of a bead in millimetres [default: 1 for each 0.6 of layer height]
    #[arg(long = "bead", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    bead_mm: Option<f64>,
    /// Share of the tapes' area that may lie on nothing, and that may stay uncovered
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share, allow_negative_numbers = true, help_heading = LOAD)]
    allow_bare: f64,
    /// Edge of the cells of the part and of the solver in millimetres [default: some 60,000 cells]
    #[arg(long = "cell", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    cell_mm: Option<f64>,
    /// Stresses instead of the solver's: CSV (x, y, z in mm of the file of the part, six components), VTK (.vtk) or results of CalculiX (.frd)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["supports", "loads", "young_gpa", "bearing", "bond_mpa"], help_heading = LOAD)]
    stress: Option<PathBuf>,
    /// How far a sample of that file may be from the layer in millimetres
    #[arg(long = "reach", value_name = "MM", default_value_t = 10.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    reach_mm: f64,
    /// Box that is held, in mm of the file of the part: its lower and its upper corner; inf for no end. May come more than once
    #[arg(long = "support", value_name = "X,Y,Z,X,Y,Z", value_parser = boxed, allow_hyphen_values = true, help_heading = LOAD)]
    supports: Vec<Boxed>,
    /// Box whose outer faces are loaded, and the force in newtons. May come more than once. Without --support and --load the base is held, and
    /// the top pushed along x
    #[arg(long = "load", value_name = "X,Y,Z,X,Y,Z:FX,FY,FZ", value_parser = pull, allow_hyphen_values = true, help_heading = LOAD)]
    loads: Vec<Pull>,
    /// Young's modulus of the part in GPa [default: 3.5, PLA]; it scales displacements, not stresses
    #[arg(long = "young", value_name = "GPA", value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    young_gpa: Option<f64>,
    /// Share of the tapes' fibre that bears [default: as in the tensile test of the dissertation, with tow that is ironed on dry]
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true, help_heading = LOAD)]
    bearing: Option<f64>,
    /// What the bond between layers, and between tape and thermoplastic, bears in MPa, in peel and in shear [default: with which the planar arc of the
    /// dissertation comes apart where it did]
    #[arg(long = "bond", value_name = "MPA", value_parser = above_zero, allow_negative_numbers = true, help_heading = LOAD)]
    bond_mpa: Option<f64>,
    /// Writes growth.csv, directions of growth across the largest stresses for `curved_layers --directions`, and says how much nearer layers come to these
    #[arg(long, conflicts_with = "stress", help_heading = LOAD)]
    follow_load: bool,
    /// Wires on the loaded layer: a point x,y,z a line in mm of the file of the part, an empty line between two wires
    #[arg(long = "wire", value_name = "FILE", help_heading = LOAD)]
    wires: Option<PathBuf>,
    /// Width of the tapes on the loaded layer in millimetres
    #[arg(long = "tape-width", value_name = "MM", default_value_t = 5.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    tape_width_mm: f64,
    /// Distance of their centre lines in millimetres [default: their width]
    #[arg(long = "tape-spacing", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    tape_spacing_mm: Option<f64>,
    /// Thickness of all tapes in millimetres
    #[arg(long = "tape-thickness", value_name = "MM", default_value_t = 0.08, value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    tape_thickness_mm: f64,
    /// Least steering radius in millimetres
    #[arg(long = "min-radius", value_name = "MM", default_value_t = 50.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    min_radius_mm: f64,
    /// Shortest tape, and tape from the blade to the roller, in millimetres
    #[arg(long = "min-length", value_name = "MM", default_value_t = 20.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    min_length_mm: f64,
    /// Share of its width with which a tape may lie on others
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = share, allow_negative_numbers = true, help_heading = TAPES)]
    max_overlap: f64,
    /// Length over which directions are evened out, in millimetres [default: twice the width of the tapes]
    #[arg(long = "smoothing", value_name = "MM", value_parser = from_zero, allow_negative_numbers = true, help_heading = TAPES)]
    smoothing_mm: Option<f64>,
    /// Each layer of tape raises the layers above by its thickness; without it by nothing, as in the dissertation
    #[arg(long, help_heading = TAPES)]
    compensate: bool,
    /// Force of the roller in newtons
    #[arg(long = "press", value_name = "N", default_value_t = 20.0, value_parser = above_zero, allow_negative_numbers = true, help_heading = TAPES)]
    press_n: f64,
    /// Temperature of the roller in degrees Celsius
    #[arg(long = "heat", value_name = "CELSIUS", default_value_t = 210.0, value_parser = curvlay_examples::args::celsius, allow_negative_numbers = true, help_heading = TAPES)]
    celsius: f64,
    /// Workcell that prints the part, or lays the tapes of the arc, a JSON file with six axes [default: a UR3 that holds the mould under a roller]
    #[arg(long, value_name = "FILE")]
    workcell: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

const LOAD: &str = "Layer and load";
const TAPES: &str = "Tapes";

/// How far a run goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Stage {
    /// Tapes, and what stiffness they give.
    Tapes,
    /// The layers of thermoplastic as well.
    Paths,
    /// The motion of the robot as well: of the whole part, or along the tapes of the arc.
    Motion,
}

/// A box: its lower and its upper corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boxed(pub [[f64; 3]; 2]);

/// A force on a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    region: Boxed,
    newtons: [f64; 3],
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let all: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    all?.try_into().ok()
}

fn boxed(text: &str) -> Result<Boxed, String> {
    let [x0, y0, z0, x1, y1, z1] = numbers(text).ok_or("must be six numbers")?;
    let ordered = [(x0, x1), (y0, y1), (z0, z1)].iter().all(|(low, high)| low <= high);
    if ordered {
        Ok(Boxed([[x0, y0, z0], [x1, y1, z1]]))
    } else {
        Err("the second corner must be the upper one".to_owned())
    }
}

fn pull(text: &str) -> Result<Pull, String> {
    let (region, force) = text.split_once(':').ok_or("must be six numbers, a colon and three numbers")?;
    let newtons: [f64; 3] = numbers(force).ok_or("the force must be three numbers")?;
    if newtons.iter().all(|n| n.is_finite()) && newtons.iter().any(|n| *n != 0.0) {
        return Ok(Pull { region: boxed(region)?, newtons });
    }
    Err("the force must be finite and not zero".to_owned())
}

impl Args {
    /// Tapes of the loaded layer.
    fn tape_options(&self) -> TapeOptions {
        TapeOptions {
            width: self.tape_width_mm,
            thickness: self.tape_thickness_mm,
            spacing: self.tape_spacing_mm.unwrap_or(self.tape_width_mm),
            min_radius: self.min_radius_mm,
            min_length: self.min_length_mm,
            max_overlap: self.max_overlap,
            ..TapeOptions::default()
        }
    }

    fn smoothing_mm(&self) -> f64 {
        self.smoothing_mm.unwrap_or(2.0 * self.tape_width_mm)
    }

    fn head(&self) -> TapeHead {
        TapeHead { blade: self.min_length_mm, force_n: self.press_n, celsius: self.celsius, ..TapeHead::default() }
    }

    fn sandwich(&self) -> SandwichOptions {
        let offset = if self.compensate { self.tape_thickness_mm } else { 0.0 };
        SandwichOptions { offset, ..SandwichOptions::default() }
    }

    /// Whether the arm and the roller of a workcell can lay these tapes.
    fn check_roller(&self, cell: &AnyWorkcell) -> Result<(), Failure> {
        motion::six_axes(cell)?;
        let (tape, roller) = (self.tape_width_mm, cell.equipment().model().roller.unwrap_or_default().width_mm);
        if tape > roller {
            let message = format!(
                "--tape-width: tapes of {tape} mm under a roller of {roller} mm: take {roller} or less, or give a wider `roller.width_mm` in the workcell"
            );
            return Err(Failure::of_arguments(message));
        }
        Ok(())
    }

    /// The files that it reads.
    fn files(&self) -> [Option<&Path>; 4] {
        [self.mesh.path(), self.stress.as_deref(), self.wires.as_deref(), self.workcell.as_deref()]
    }

    /// Options of a layer of a part without a part.
    fn check(&self) -> Result<(), Failure> {
        let of_part = [
            ("--layers", !self.layers.is_empty()),
            ("--layer-height", self.layer_height_mm.is_some()),
            ("--bead", self.bead_mm.is_some()),
            ("--bearing", self.bearing.is_some()),
            ("--bond", self.bond_mpa.is_some()),
            ("--cell", self.cell_mm.is_some()),
            ("--stress", self.stress.is_some()),
            ("--support", !self.supports.is_empty()),
            ("--load", !self.loads.is_empty()),
            ("--young", self.young_gpa.is_some()),
            ("--follow-load", self.follow_load),
        ];
        match of_part.into_iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) if self.mesh.path().is_none() => {
                Err(Failure::of_arguments(format!("{option} is for a part: give one with --mesh")))
            }
            _ => Ok(()),
        }
    }
}

/// What came of it.
pub struct Run {
    specimens: Vec<Planned>,
    planar: Planar,
    predictions: Predictions,
    layer: LoadedLayer,
    wires: Vec<Tape>,
    moved: Option<Moved>,
    plan_time: Duration,
    findings: Findings,
}

/// What was planned.
pub enum Planning {
    /// The specimens, and the arc under load.
    Specimens(Box<Run>),
    /// The user's part.
    Part(Box<PartRun>),
}

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        args.check()?;
        let folder = args.common.folder("continuous_fiber", args.files(), outputs::is_ours)?;
        let (planning, outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        match &planning {
            Planning::Specimens(run) => Table::print_all([&outputs::tapes(run), &outputs::predictions(run)])?,
            Planning::Part(run) => Table::print_all([&part_outputs::table(run)])?,
        }
        Ok(outcome)
    })
}

/// Plans everything and writes the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Planning, Outcome), Failure> {
    let start = Instant::now();
    let given = Given::read(args)?;
    let pool = ThreadPoolBuilder::new().num_threads(args.common.threads).build()?;
    let Some(part) = &given.part else {
        folder.clear(outputs::is_ours)?;
        let mut run = pool.install(|| plan(args, &given, bars))?;
        bars.finish();
        outputs::write(args, &run, folder, start)?;
        run.findings.say();
        let outcome = run.findings.outcome();
        return Ok((Planning::Specimens(Box::new(run)), outcome));
    };
    let mut findings = Findings::default();
    part.find(&mut findings);
    // Whether its layers are there is known only now.
    let run = pool.install(|| part::plan(args, part, &given, bars))?;
    bars.finish();
    part_outputs::find(args, &run, &mut findings);
    folder.clear(outputs::is_ours)?;
    part_outputs::write(args, &run, &findings, folder, start)?;
    findings.say();
    let outcome = findings.outcome();
    Ok((Planning::Part(Box::new(run)), outcome))
}

/// The files of the user, all of them read before anything is removed.
pub struct Given {
    cell: AnyWorkcell,
    part: Option<Part>,
    stress: Option<Vec<StressSample>>,
    wires: Vec<Vec<Point3<f64>>>,
}

impl Given {
    fn read(args: &Args) -> Result<Given, Failure> {
        let text = match &args.workcell {
            Some(path) => input::read(path, input::MAX_SETTINGS_BYTES)?,
            None => UR3_CELL.as_bytes().to_vec(),
        };
        let cell = AnyWorkcell::from_json(&text[..]).map_err(|error| match &args.workcell {
            Some(path) => fault(path, &error),
            None => error.into(),
        })?;
        let part = args.mesh.path().map(|_| args.mesh.load("part", jug)).transpose()?;
        if part.is_some() && args.stage >= Stage::Motion {
            args.check_roller(&cell)?;
        }
        let stress = args.stress.as_deref().map(layer::read_stress).transpose()?;
        let wires = args.wires.as_deref().map_or(Ok(Vec::new()), wires::read)?;
        Ok(Given { cell, part, stress, wires })
    }
}

fn plan(args: &Args, given: &Given, bars: &Bars) -> Result<Run, Failure> {
    let Given { cell, wires, .. } = given;
    let mut findings = Findings::default();

    let nozzle = nozzle_of(cell.equipment())?;
    let nozzle = (args.stage >= Stage::Paths).then_some(&nozzle);
    let mut specimens = Vec::new();
    let mut plan_time = Duration::ZERO;
    let tape_options = TapeOptions { thickness: args.tape_thickness_mm, ..TapeOptions::default() };
    for specimen in Specimen::all() {
        let planned = tapes::plan(specimen, &args.sandwich(), &tape_options, &args.head(), nozzle, bars)?;
        plan_time += planned.plan_time;
        specimens.push(planned);
    }
    let curved = specimens.iter().find(|planned| planned.specimen.is_curved());
    let planar = curved.map(|planned| planar::plan(&planned.specimen, args.min_length_mm, nozzle, bars)).transpose()?;
    let planar = planar.unwrap_or_else(|| unreachable!("one of them is curved"));
    let [dumbbell, bar, arc] = &specimens[..] else { unreachable!("there are three") };
    let bearing = predict::bearing(&dumbbell.specimen, &dumbbell.schedule)?;
    let matrix_gpa = predict::matrix_gpa(&bar.specimen, &bar.schedule)?;
    let matrix = Material { young_mpa: 1e3 * matrix_gpa, ..Material::default() };
    let tape = predict::tape_law(&matrix, args.tape_thickness_mm, bearing);
    let arcs = arcs::run(arc, &planar, matrix_gpa, &tape, bars)?;
    let tested = [
        (dumbbell.specimen, &dumbbell.schedule[..]),
        (bar.specimen, &bar.schedule[..]),
        (arc.specimen, &arc.schedule[..]),
    ];
    let predictions = predict(&tested, arcs)?;
    let layer = layer::arc(&arc.specimen, &args.tape_options(), args.smoothing_mm(), bars)?;
    plan_time += layer.plan_time;
    let wire_options = ConductorOptions { thickness: args.tape_thickness_mm, ..ConductorOptions::default() };
    let on_layer = |path: &PathBuf| -> Result<Vec<Tape>, Failure> {
        let numbered = wires.iter().enumerate();
        numbered.map(|(number, wire)| wires::on_layer(path, number, wire, &layer.surface, &wire_options)).collect()
    };
    let wires = args.wires.as_ref().map_or(Ok(Vec::new()), on_layer)?;
    let moved = (args.stage == Stage::Motion).then(|| motion::plan(arc, cell, &args.head(), bars)).transpose()?;
    for planned in &specimens {
        judge(planned, &tape_options, &mut findings);
    }
    let amount = format!("{:.1} mm of {} mm", planar.longest_tape_mm, arc.specimen.tape_mm[0]);
    findings.add(Severity::Noted, "the longest tape for which a planar layer of the arc has room", amount, "");
    judge_layer(&layer, &mut findings);
    moved.iter().for_each(|moved| judge_motion(moved, &mut findings));
    judge_predictions(&predictions, &mut findings);
    Ok(Run { specimens, planar, predictions, layer, wires, moved, plan_time, findings })
}

/// What the tapes of a specimen must reach: share covered, and share covered twice.
const SPECIMEN: [f64; 2] = [0.95, 0.02];
/// The mean angle to the principal direction over the worst-stressed tenth, in degrees.
const ANGLE_DEG: f64 = 15.0;
/// Share of the worst-stressed tenth of a layer below which tapes do not reinforce it as they should.
const WORST_COVERED: f64 = 0.8;
/// A prediction that differs by more than this share is told.
const NEAR: f64 = 0.1;

fn judge(planned: &Planned, options: &TapeOptions, findings: &mut Findings) {
    let title = planned.specimen.title;
    let [covered, overlap, radius] = planned.cover();
    if covered < SPECIMEN[0] || overlap > SPECIMEN[1] {
        let amount = format!("{} covered, {} twice", percent(covered), percent(overlap));
        findings.add(Severity::Failed, format!("{title}: the strip of a tape is not covered as it should"), amount, "");
    }
    if radius < options.min_radius {
        findings.add(Severity::Failed, format!("{title}: a tape bends too tightly"), format!("{radius:.1} mm"), "");
    }
    if let Some(print) = planned.print.as_ref().filter(|print| !print.resolved.left_out.is_empty()) {
        let count = print.resolved.left_out.len();
        findings.add(Severity::Told, format!("{title}: pieces of thermoplastic are left out"), count.to_string(), "");
    }
}

fn judge_layer(layer: &LoadedLayer, findings: &mut Findings) {
    if let Some(empty) = &layer.plan.empty {
        findings.add(Severity::Told, format!("no tape lies on {}", layer.name), empty.to_string(), "");
    }
    let degrees = layer.angle.mean.map(f64::to_degrees);
    if let Some(degrees) = degrees.filter(|degrees| *degrees > ANGLE_DEG) {
        let what = "tapes leave the principal direction over the worst-stressed tenth of the layer";
        findings.add(Severity::Told, what, format!("{degrees:.1} degrees in the mean"), "--smoothing, --min-radius");
    }
    let covered = layer.angle.covered_fraction;
    if layer.plan.empty.is_none() && covered < WORST_COVERED {
        let what = format!(
            "less than {} of the worst-stressed tenth of {} lies under a tape",
            percent(WORST_COVERED),
            layer.name
        );
        findings.add(Severity::Told, what, percent(covered), "");
    }
    let left: f64 = layer.plan.left_out.iter().map(|piece| piece.length_mm).sum();
    if left > 0.0 {
        let amount = format!("{left:.0} mm of {:.0} mm", left + layer.plan.tape_mm());
        findings.add(Severity::Told, format!("lines without a tape on {}", layer.name), amount, "tapes.csv");
    }
}

fn judge_motion(moved: &Moved, findings: &mut Findings) {
    for fault in &moved.faults {
        let what = format!("the robot does not lay all tapes: {} {}", fault.kind.name(), fault.what);
        findings.add(Severity::Failed, what, "", format!("tape {}, point {}", fault.path + 1, fault.waypoint));
    }
    if moved.faults.is_empty() && moved.runs != moved.tapes {
        findings.add(Severity::Failed, "tapes are laid in pieces", format!("{} of {}", moved.runs, moved.tapes), "");
    }
}

fn judge_predictions(predictions: &Predictions, findings: &mut Findings) {
    for prediction in &predictions.list {
        let ratio = prediction.ours / prediction.measured;
        if (ratio - 1.0).abs() > NEAR {
            let amount = format!("{:.3} / {:.3} {}", prediction.ours, prediction.measured, prediction.unit);
            let what = format!("{}: ours / measured differ; possible reasons: {}", prediction.what, prediction.remark);
            findings.add(Severity::Noted, what, amount.trim_end(), "");
        }
    }
}
