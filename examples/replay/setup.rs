//! What is replayed: the program, the machine, the controller, the plan, and what the summary of the run beside them says.

use super::args::Args;
use super::chosen::{Chosen, Reading, named, printer, robot, wanted};
use super::controller::{ControllerModel, Maker};
use super::judge::{Bead, Placement, Plan};
use super::machine::Machine;
use super::program::{AXES, Files, Kind, PART, find};
use curvlay_examples::args::Failure;
use curvlay_examples::facts::Facts;
use curvlay_examples::input;
use curvlay_examples::laid::Nozzle;
use curvlay_examples::waypoints::fault;
use curvlay_toolpath::gcode::flavour::FilamentWords;
use std::f64::consts::PI;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// The nozzle of which nothing is known: that of `curved_layers`. Diameter of the tip, half angle, height of the cone, block.
const NOZZLE: [f64; 4] = [0.8, 45.0, 8.0, 20.0];
/// Where the block of a printer ends, in millimetres above the tip.
const TOP_MM: f64 = 60.0;
/// Diameter of the filament of which nothing is known.
const FILAMENT_MM: f64 = 1.75;

/// Beads of a plan, as they are read.
pub type Beads = Box<dyn Iterator<Item = Result<Bead, String>>>;

/// All of it.
pub struct Setup {
    /// The program.
    pub files: Files,
    /// The machine.
    pub machine: Machine,
    /// Where it was taken from, if no option named it.
    pub machine_by: Option<String>,
    /// How G-code is read.
    pub reading: Option<Reading>,
    /// The controller.
    pub model: ControllerModel,
    /// The nozzle.
    pub nozzle: Nozzle,
    /// Diameter of the tip, half angle in degrees, height of the cone, diameter of the block.
    pub nozzle_sizes: [f64; 4],
    /// Diameter of the plate.
    pub plate_mm: Option<f64>,
    /// The plan.
    pub plan: Option<PathBuf>,
    /// How the part stands in the machine.
    pub placement: Placement,
    /// Diameter of the filament, in millimetres.
    pub filament_mm: f64,
    /// Seconds that the program should take, if something says so.
    pub planned_s: Option<f64>,
}

impl Setup {
    /// Reads what the arguments name, but for the program itself and the plan.
    ///
    /// # Errors
    /// A [`Failure`] that names the file.
    pub fn new(args: &Args) -> Result<Self, Failure> {
        let flavour = named(args)?;
        let files = find(&args.program, wanted(args, &flavour))?;
        let is_folder = args.program[0].is_dir();
        let beside = if is_folder { &args.program[0] } else { args.program[0].parent().unwrap_or(Path::new(".")) };
        let facts = Facts::read(beside);
        let is_robot = files.kind != Kind::Gcode;
        let Chosen { machine, by: machine_by, servo, reading } =
            if is_robot { robot(args, files.kind, &facts, beside)? } else { printer(args, &files, flavour)? };
        let maker = match files.kind {
            Kind::UrScript => Maker::Ur,
            Kind::Rapid | Kind::Csv => Maker::Abb,
            Kind::Krl => Maker::Kuka,
            Kind::Tp => Maker::Fanuc,
            Kind::Gcode => Maker::Gcode,
        };
        let of_cell = match &machine {
            Machine::Robot(robot) => {
                let model = &robot.nozzle_model;
                let sizes =
                    [model.tip_flat_mm, model.cone_half_angle_deg, model.cone_height_mm, model.block_diameter_mm];
                Some((sizes, model.block_top_mm))
            }
            Machine::FiveAxis(_) => None,
        };
        let sizes = args.nozzle.or(of_cell.map(|(sizes, _)| sizes)).or(facts.nozzle()).unwrap_or(NOZZLE);
        let top = of_cell.map_or(TOP_MM.max(2.0 * sizes[2]), |(_, top)| top);
        let nozzle = Nozzle::new([sizes[0], sizes[1].to_radians(), sizes[2], sizes[3], top])
            .map_err(|what| Failure::new(format!("--nozzle: {what}")))?;
        let of_machine = if let Machine::Robot(robot) = &machine { robot.plate_mm } else { None };
        let plate_mm = of_machine.or(facts.number("platform_diameter_mm"));
        let plan = plan_file(args, beside, &files, &facts);
        let planned = match files.kind {
            Kind::Gcode if files.paths[0].file_name().is_some_and(|name| name == AXES) => Some("five_axis_time_s"),
            Kind::Gcode => None,
            _ => Some("robot_time_s"),
        };
        let planned_s =
            planned.filter(|_| is_folder).and_then(|key| facts.number(key)).filter(|seconds| *seconds > 0.0);
        Ok(Setup {
            placement: placement(args, plan.as_deref(), is_robot),
            model: args.controller.model(maker, servo),
            filament_mm: args.filament_mm.or(facts.number("filament_diameter_mm")).unwrap_or(FILAMENT_MM),
            planned_s: args.planned_s.or(planned_s),
            files,
            machine,
            machine_by,
            reading,
            nozzle,
            nozzle_sizes: sizes,
            plate_mm,
            plan,
        })
    }

    /// The format of the program, with its flavour.
    pub fn format(&self) -> String {
        match &self.reading {
            Some(Reading::Flavour(flavour)) => format!("{}, {}", self.files.kind.name(), flavour.name),
            _ => self.files.kind.name().to_owned(),
        }
    }

    /// Whether the program says how much material comes out, and not just when.
    pub fn has_amounts(&self) -> bool {
        !matches!(&self.reading, Some(Reading::Flavour(flavour)) if matches!(flavour.filament, FilamentWords::Switch { .. } | FilamentWords::None))
    }

    /// Cross-section of the filament, in square millimetres.
    pub fn filament_mm2(&self) -> f64 {
        0.25 * PI * self.filament_mm * self.filament_mm
    }

    /// The beads of the plan.
    ///
    /// # Errors
    /// A [`Failure`] that names the file.
    pub fn beads(&self) -> Result<Option<Beads>, Failure> {
        let Some(path) = &self.plan else { return Ok(None) };
        let reader = BufReader::new(input::open(path, input::MAX_DATA_BYTES)?);
        let is_csv = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
        let plan = Plan::new(reader, is_csv, self.placement, self.filament_mm2()).map_err(|what| fault(path, &what))?;
        Ok(Some(Box::new(plan)))
    }
}

/// The plan: the one that is named, or that of the run. In a flavour its G-code is no plan, but its table is.
fn plan_file(args: &Args, beside: &Path, files: &Files, facts: &Facts) -> Option<PathBuf> {
    if args.no_plan {
        return None;
    }
    let is_program = files.paths.iter().any(|path| path.file_name().is_some_and(|name| name == PART));
    let name = if is_program || facts.text("flavour").is_some() { "toolpath.csv" } else { PART };
    let of_run = beside.join(name);
    args.plan.clone().or_else(|| of_run.is_file().then_some(of_run))
}

/// How the part stands: as said, or by the summary beside the plan. Printers have the part where the plan has it.
fn placement(args: &Args, plan: Option<&Path>, is_robot: bool) -> Placement {
    let facts = plan.and_then(Path::parent).filter(|_| is_robot).map(Facts::read);
    let figure = |key: &str| facts.as_ref().and_then(|facts| facts.number(key)).unwrap_or(0.0);
    Placement {
        turn: args.part_turn_deg.unwrap_or_else(|| figure("part_turn_deg")).to_radians(),
        shift_mm: args.part_shift_mm.unwrap_or_else(|| [figure("part_shift_x_mm"), figure("part_shift_y_mm")]),
    }
}
