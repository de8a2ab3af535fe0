//! What a machine does with a program before it runs: robot programs (URScript, RAPID, KRL, TP) and five-axis G-code, executed by a model of the controller.
//!
//! Time; axes against their limits; the tip against the planned paths; deposited beads against the plan; contact of the nozzle with what is built so far and
//! with the plate. It shares no code with the planner: its kinematics, its controller and its judges are its own, the text of programs is read by the
//! readers of the library.
//! ```sh
//! cargo run --release --example curved_layers -- --stage motion --out target/out/jug
//! cargo run --release --example replay -- target/out/jug
//! ```
//! `docs/formats/replay.md` describes its files, `--help` lists the options.

mod args;
mod axes;
mod chosen;
mod controller;
mod court;
mod judge;
mod judged;
mod machine;
mod outputs;
mod program;
mod run;
mod setup;
mod trace;

pub use args::Args;
use court::Court;
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::table::Table;
use judge::Tip;
use program::Kind;
use setup::Setup;
use std::io::BufWriter;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let flavour = args.flavour.as_deref().map(Path::new).filter(|path| path.is_file());
        let named = [args.workcell.as_deref(), args.machine.as_deref(), args.plan.as_deref(), flavour];
        let inputs = args.program.iter().map(|path| Some(path.as_path())).chain(named);
        let folder = args.common.folder("replay", inputs, outputs::is_ours)?;
        let (tables, outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        Table::print_all(&tables)?;
        Ok(outcome)
    })
}

/// Replays a program and writes the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Vec<Table>, Outcome), Failure> {
    let start = Instant::now();
    let setup = Setup::new(args)?;
    let args = &with_time(args, &setup);
    keep_apart(args, folder)?;
    let plan = setup.beads()?.map(|beads| Tip::new(beads, [args.allow.allow_tip, args.allow.allow_tilt_deg]));
    folder.clear(outputs::is_ours)?;
    let nozzle = (setup.nozzle, setup.plate_mm);
    let mut court = Court::new(&setup.machine, setup.model.tick_s(), nozzle, &args.allow, plan);
    court.has_amounts = setup.has_amounts();
    let table = if args.joints { Some(folder.begin(outputs::JOINTS)?) } else { None };
    let unfinished = match table {
        Some((unfinished, file)) => {
            court.write_to(Box::new(BufWriter::new(file)))?;
            Some(unfinished)
        }
        None => None,
    };
    let executed = run::execute(&setup, &mut court, bars)?;
    bars.finish();
    if let Some(error) = court.unwritten.take() {
        return Err(Failure::new(format!("{}: {error}", folder.path().join(outputs::JOINTS).display())));
    }
    if let Some(unfinished) = unfinished {
        unfinished.finish()?;
    }
    let mut findings = judged::findings(args, &setup, &executed, &court);
    findings.say();
    let outcome = findings.outcome();
    let run = outputs::Run { args, setup: &setup, executed, court, findings };
    Ok((outputs::write(run, folder, start.elapsed())?, outcome))
}

/// Moves that go by their own speeds take longer by their accelerations; streams and lines under `G93` have their time.
fn with_time(args: &Args, setup: &Setup) -> Args {
    let by_speeds = !matches!(setup.files.kind, Kind::UrScript | Kind::Gcode);
    let mut args = args.clone();
    args.allow.allow_time.get_or_insert(if by_speeds { 0.03 } else { 0.01 });
    args
}

/// The run in the folder of the program would lose its summary and its report to this one.
fn keep_apart(args: &Args, folder: &OutputFolder) -> Result<(), Failure> {
    let same = |path: &Path| {
        let folders = [path, folder.path()].map(std::fs::canonicalize);
        matches!(folders, [Ok(a), Ok(b)] if a == b)
    };
    match args.program.iter().find(|path| path.is_dir() && same(path)) {
        Some(path) => Err(Failure::of_arguments(format!(
            "{}: is the folder of the program, whose summary would be written over: choose another --out",
            path.display()
        ))),
        None => Ok(()),
    }
}
