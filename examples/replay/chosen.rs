//! The machine that a program is for, and how its text is read: as the arguments say, or as the run beside it has recorded.

use super::args::Args;
use super::controller::{GAIN, LOOKAHEAD_S};
use super::machine::{FiveAxis, Machine, Robot};
use super::program::{AXES, Dialect, Files, Kind, Wanted, fitted};
use curvlay_examples::args::Failure;
use curvlay_examples::facts::Facts;
use curvlay_examples::five_axis::FiveAxisPrinter;
use curvlay_examples::input;
use curvlay_examples::motion::{WORKCELL_FILE, workcell_model};
use curvlay_examples::settings::named_flavour;
use curvlay_examples::waypoints::fault;
use curvlay_kinematics::workcell::WorkcellModel;
use curvlay_toolpath::gcode::flavour::{Direction, Flavour};
use std::path::Path;

/// The workcells that we ship and that can be replayed: no track.
const CELLS: [&str; 3] = [
    include_str!("../cells/ur10.json"),
    include_str!("../cells/irb1200-table.json"),
    include_str!("../cells/ur3.json"),
];
/// What stands for no flavour.
const PLAIN: &str = "plain";

/// How G-code is read.
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// As plain G-code.
    Plain(Dialect),
    /// In a flavour.
    Flavour(Box<Flavour>),
}

/// A machine.
pub struct Chosen {
    /// The machine.
    pub machine: Machine,
    /// Where it was taken from, if no option named it.
    pub by: Option<String>,
    /// Look-ahead time and gain of its streams.
    pub servo: [Option<f64>; 2],
    /// How its G-code is read.
    pub reading: Option<Reading>,
}

/// What `--flavour` names.
pub enum Named {
    /// It is not given.
    Nothing,
    /// Plain G-code.
    Plain,
    /// A flavour.
    Flavour(Box<Flavour>),
}

/// What `--flavour` names.
///
/// # Errors
/// A flavour that is not known, or a file that is none.
pub fn named(args: &Args) -> Result<Named, Failure> {
    let Some(name) = args.flavour.as_deref() else { return Ok(Named::Nothing) };
    if name == PLAIN {
        return Ok(Named::Plain);
    }
    let unknown = || {
        let known = Flavour::names().join(", ");
        Failure::of_arguments(format!(
            "--flavour: `{name}` is no G-code flavour: known are {PLAIN}, {known}; or give a JSON file (name.json)"
        ))
    };
    let flavour = named_flavour(name, Path::new(""))?.ok_or_else(unknown)?;
    Ok(Named::Flavour(Box::new(flavour)))
}

/// Which program of a folder is meant.
pub fn wanted(args: &Args, named: &Named) -> Wanted {
    match named {
        Named::Flavour(flavour) if matches!(flavour.direction, Direction::Vector { .. }) => Wanted::Vectors,
        Named::Nothing if args.machine.is_none() => Wanted::Any,
        _ => Wanted::Axes,
    }
}

/// The printer of a program in G-code.
///
/// # Errors
/// A [`Failure`] that names the file, or the arguments that do not go together.
pub fn printer(args: &Args, files: &Files, named: Named) -> Result<Chosen, Failure> {
    let program = &files.paths[0];
    if args.workcell.is_some() {
        return Err(Failure::of_arguments("--workcell is for robot programs: G-code runs on a --machine"));
    }
    let (printer, of_machine) = match &args.machine {
        Some(path) => {
            let text = input::read(path, input::MAX_SETTINGS_BYTES)?;
            let printer = FiveAxis::from_json(&text).map_err(|what| fault(path, &what))?;
            let is_open = matches!(named, Named::Nothing);
            (printer, if is_open { Some(FiveAxisPrinter::load(path)?.flavour) } else { None })
        }
        None if program.file_name().is_some_and(|name| name == AXES) => {
            return Err(fault(program, &"is for a five-axis machine: name its file with --machine"));
        }
        None => (FiveAxis::table()?, None),
    };
    let flavour = match named {
        Named::Nothing => of_machine,
        Named::Plain => None,
        Named::Flavour(flavour) => Some(*flavour),
    };
    let is_ngc = program.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ngc"));
    let reading = match flavour {
        Some(flavour) => Reading::Flavour(Box::new(fitted(&flavour, &printer))),
        None => Reading::Plain(Dialect {
            letters: printer.letters.clone(),
            linear: printer.linear,
            dwell_s: if is_ngc { 1.0 } else { 1e-3 },
        }),
    };
    let machine = Machine::FiveAxis(Box::new(printer));
    Ok(Chosen { machine, by: None, servo: [None; 2], reading: Some(reading) })
}

/// The robot of a program.
///
/// # Errors
/// As [`printer`].
pub fn robot(args: &Args, kind: Kind, facts: &Facts, beside: &Path) -> Result<Chosen, Failure> {
    if args.machine.is_some() || args.flavour.is_some() {
        return Err(Failure::of_arguments(
            "--machine and --flavour are for G-code: robot programs run in a --workcell",
        ));
    }
    let (model, by) = match &args.workcell {
        Some(path) => (workcell_model(path)?, None),
        None => {
            let (model, why) = of_run(kind, facts, beside)?;
            (model, Some(why))
        }
    };
    let robot = Robot::new(&model).map_err(|error| match &args.workcell {
        Some(path) => fault(path, &error),
        None => Failure::new(error),
    })?;
    let servo = [model.controller.servoj_lookahead_s, model.controller.servoj_gain];
    let names = ["controller.servoj_lookahead_s", "controller.servoj_gain"];
    for ((value, name), [min, max]) in servo.iter().zip(names).zip([LOOKAHEAD_S, GAIN]) {
        if let Some(value) = value.filter(|value| !(min..=max).contains(value)) {
            return Err(Failure::new(format!("{}: {name} is {value}: URScript takes {min} to {max}", model.name)));
        }
    }
    Ok(Chosen { machine: Machine::Robot(Box::new(robot)), by, servo, reading: None })
}

/// The workcell of the run, or the one that we ship for such programs; and why.
fn of_run(kind: Kind, facts: &Facts, beside: &Path) -> Result<(WorkcellModel, String), Failure> {
    let written = beside.join(WORKCELL_FILE);
    if written.is_file() {
        return Ok((workcell_model(&written)?, format!("that of the run, {}", written.display())));
    }
    if let Some(named) = facts.text("workcell") {
        let model = workcell_model(Path::new(named)).map_err(|failure| {
            let why = failure.message().to_owned();
            Failure::new(format!(
                "the run was planned in the workcell `{named}`, which is not found: {why}; name it with --workcell"
            ))
        })?;
        return Ok((model, format!("that of the run, {named}")));
    }
    let all: Result<Vec<WorkcellModel>, _> =
        CELLS.iter().map(|text| WorkcellModel::from_json(text.as_bytes())).collect();
    let all = all?;
    match facts.text("cell").map(|name| (name, all.iter().find(|model| model.name == name))) {
        Some((_, Some(model))) => return Ok((model.clone(), "that of the run, as shipped".to_owned())),
        Some((name, None)) => {
            return Err(Failure::new(format!(
                "the run was planned in the workcell `{name}`, whose file it does not name: name it with --workcell"
            )));
        }
        None => {}
    }
    if matches!(kind, Kind::Krl | Kind::Tp) {
        return Err(Failure::of_arguments(format!(
            "nothing says for which robot the {} program is: name its --workcell (a file, or an arm such as {})",
            kind.name(),
            if kind == Kind::Krl { "`KR 6 R900-2`" } else { "`LR Mate 200iD`" }
        )));
    }
    let default = usize::from(kind == Kind::Rapid);
    Ok((all[default].clone(), format!("a guess, `{}`: name the right one with --workcell", all[default].name)))
}
