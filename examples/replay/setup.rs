//! What is replayed: the program, the machine, the controller, the plan, and what the summary of the run beside them says.

use super::args::Args;
use super::controller::{ControllerModel, Maker};
use super::judge::{Bead, Nozzle, Placement, Plan};
use super::machine::{Machine, Robot, Rotary};
use super::program::{Files, Kind, find};
use curvlay_examples::args::Failure;
use curvlay_examples::input;
use curvlay_examples::waypoints::fault;
use curvlay_kinematics::workcell::WorkcellModel;
use serde_json::{Map, Value};
use std::f64::consts::PI;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// The workcells that we ship.
const CELLS: [&str; 3] = [
    include_str!("../cells/ur10.json"),
    include_str!("../cells/irb1200-table.json"),
    include_str!("../cells/ur3.json"),
];
/// The nozzle of which nothing is known: that of `curvlay_layers` for beads of a millimetre. Diameter of the tip, half angle, height of the cone, block.
const NOZZLE: [f64; 4] = [1.0, 45.0, 8.0, 20.0];
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
    /// Where it was taken from, if nobody named it.
    pub machine_by: Option<String>,
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

/// Figures of the run beside the program.
struct Facts(Map<String, Value>);

impl Facts {
    /// Those of `summary.json` in a folder; none where there is no such file, or none of a run.
    fn read(folder: &Path) -> Self {
        let path = folder.join("summary.json");
        let text = input::read(&path, input::MAX_SETTINGS_BYTES).unwrap_or_default();
        Facts(serde_json::from_slice(&text).unwrap_or_default())
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.0.get(key)?.as_f64().filter(|value| value.is_finite())
    }

    fn text(&self, key: &str) -> Option<&str> {
        self.0.get(key)?.as_str()
    }

    fn nozzle(&self) -> Option<[f64; 4]> {
        let numbers: Option<Vec<f64>> = self.text("nozzle")?.split(',').map(|word| word.parse().ok()).collect();
        numbers?.try_into().ok()
    }
}

impl Setup {
    /// Reads what the arguments name, but for the program itself and the plan.
    ///
    /// # Errors
    /// A [`Failure`] that names the file.
    pub fn new(args: &Args) -> Result<Self, Failure> {
        let files = find(&args.program)?;
        let is_folder = args.program[0].is_dir();
        let beside = if is_folder { &args.program[0] } else { args.program[0].parent().unwrap_or(Path::new(".")) };
        let facts = Facts::read(beside);
        let (machine, machine_by, servo) = machine(args, &files, &facts)?;
        let maker = match files.kind {
            Kind::UrScript => Maker::Ur,
            Kind::Rapid | Kind::Csv => Maker::Abb,
            Kind::Gcode => Maker::Gcode,
        };
        let of_cell = match &machine {
            Machine::Robot(robot) => {
                let model = &robot.nozzle_model;
                let sizes =
                    [model.tip_flat_mm, model.cone_half_angle_deg, model.cone_height_mm, model.block_diameter_mm];
                Some((sizes, model.block_top_mm))
            }
            Machine::Rotary(_) => None,
        };
        let sizes = args.nozzle.or(of_cell.map(|(sizes, _)| sizes)).or(facts.nozzle()).unwrap_or(NOZZLE);
        let top = of_cell.map_or(TOP_MM.max(2.0 * sizes[2]), |(_, top)| top);
        let nozzle = Nozzle::new([sizes[0], sizes[1].to_radians(), sizes[2], sizes[3], top])
            .map_err(|what| Failure::new(format!("--nozzle: {what}")))?;
        let plate_mm = match &machine {
            Machine::Robot(robot) => robot.plate_mm.or(facts.number("platform_diameter_mm")),
            Machine::Rotary(_) => None,
        };
        let plan = plan_file(args, beside);
        let is_robot = files.kind != Kind::Gcode;
        Ok(Setup {
            placement: placement(args, plan.as_deref(), is_robot),
            model: args.controller.model(maker, servo),
            filament_mm: args.filament_mm.or(facts.number("filament_diameter_mm")).unwrap_or(FILAMENT_MM),
            planned_s: args.planned_s.or_else(|| {
                let whole = is_folder && is_robot;
                facts.number("robot_time_s").filter(|seconds| whole && *seconds > 0.0)
            }),
            files,
            machine,
            machine_by,
            nozzle,
            nozzle_sizes: sizes,
            plate_mm,
            plan,
        })
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

/// The plan: the one that is named, or that of the run.
fn plan_file(args: &Args, beside: &Path) -> Option<PathBuf> {
    if args.no_plan {
        return None;
    }
    let of_run = beside.join("toolpath.gcode");
    args.plan.clone().or_else(|| (of_run.is_file() && !args.program.contains(&of_run)).then_some(of_run))
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

/// The machine, where it is from if nobody named it, and the settings of its stream.
type Chosen = (Machine, Option<String>, [Option<f64>; 2]);

fn machine(args: &Args, files: &Files, facts: &Facts) -> Result<Chosen, Failure> {
    if files.kind == Kind::Gcode {
        if args.workcell.is_some() {
            return Err(Failure::of_arguments("--workcell is for robot programs: G-code runs on a --machine"));
        }
        let Some(path) = &args.machine else { return Ok((Machine::Rotary(Box::default()), None, [None; 2])) };
        let text = input::read(path, input::MAX_SETTINGS_BYTES)?;
        let rotary = Rotary::from_json(&text).map_err(|what| fault(path, &what))?;
        return Ok((Machine::Rotary(Box::new(rotary)), None, [None; 2]));
    }
    if args.machine.is_some() {
        return Err(Failure::of_arguments("--machine is for G-code: robot programs run in a --workcell"));
    }
    let (model, name, path) = match &args.workcell {
        Some(path) => (read_cell(path)?, None, Some(path.as_path())),
        None => {
            let (model, why) = shipped(files.kind, facts)?;
            (model, Some(why), None)
        }
    };
    let robot = Robot::new(&model).map_err(|error| match path {
        Some(path) => fault(path, &error),
        None => Failure::new(error),
    })?;
    let servo = [model.controller.servoj_lookahead_s, model.controller.servoj_gain];
    Ok((Machine::Robot(Box::new(robot)), name, servo))
}

fn read_cell(path: &Path) -> Result<WorkcellModel, Failure> {
    let text = input::read(path, input::MAX_SETTINGS_BYTES)?;
    WorkcellModel::from_json(&text[..]).map_err(|error| fault(path, &error))
}

/// The workcell of the run, or the one that we ship for such programs; and why.
fn shipped(kind: Kind, facts: &Facts) -> Result<(WorkcellModel, String), Failure> {
    let of_run = facts.text("workcell").map(Path::new).filter(|path| path.is_file());
    if let Some(path) = of_run {
        return Ok((read_cell(path)?, format!("that of the run, {}", path.display())));
    }
    let all: Result<Vec<WorkcellModel>, _> =
        CELLS.iter().map(|text| WorkcellModel::from_json(text.as_bytes())).collect();
    let all = all?;
    if let Some(model) = facts.text("cell").and_then(|name| all.iter().find(|model| model.name == name)) {
        return Ok((model.clone(), "that of the run, as shipped".to_owned()));
    }
    let default = usize::from(kind == Kind::Rapid);
    Ok((all[default].clone(), format!("a guess, `{}`: name the right one with --workcell", all[default].name)))
}
