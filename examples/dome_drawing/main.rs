//! A drawing on a domed platform: from a DXF or SVG file to the RAPID program with which an IRB 120 that holds the platform under a
//! fixed nozzle prints the design.
//!
//! B. Brooks, *3D printing a transposed design in biopolymer materials using an articulated robot and pellet-based extrusion* (ME
//! thesis, Massey University 2016), chapter 4.
//! ```sh
//! cargo run --release --example dome_drawing -- rosette-leaves.dxf
//! cargo run --release --example dome_drawing -- flower.svg --diameter 250 --fill lines --angle 90
//! ```
//! Without a file it prints a design made in code. `--help` lists the options. With `--stream` it sends the program to the robot's
//! controller while it prints, point by point.

mod args;
mod design;
mod fault;
mod input;
mod outputs;
mod pictures;
mod plan;
mod platform;
mod robot;
mod saved;
mod setup;
pub mod stream;

pub use args::{Args, Design, DrawingUnit, FillKind, ProjectionKind};
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
use plan::Planned;
use robot::Printed;
use saved::Plan;
use setup::Setup;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let args = args.sorted()?;
        let folder = args.common.folder("dome_drawing", args.files(), outputs::is_ours)?;
        if let Some(path) = &args.plan_file {
            let (plan, printed, outcome) = work_again(&args, path, &Bars::new(args.common.quiet), &folder)?;
            outputs::table_again(&args, &plan, &printed).print()?;
            return Ok(outcome);
        }
        let (planned, plan, printed, outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        outputs::table(&args, &planned, &plan, &printed).print()?;
        Ok(outcome)
    })
}

/// Plans the print, checks it, and writes the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Planned, Plan, Printed, Outcome), Failure> {
    let start = Instant::now();
    let args = &Args { setup: Setup::read(args.setup_file.as_deref())?, ..args.clone() };
    let mut planned = plan::plan(args, bars)?;
    let plan = Plan::of(args, &planned);
    let program = robot::program(args, &plan, bars)?;
    let seconds = start.elapsed();
    plan::measure(args, &mut planned, bars)?;
    let printed = robot::check(args, &plan, program, seconds, bars)?;
    bars.update("write", 0, 1);
    folder.clear(outputs::is_ours)?;
    let outcome = outputs::write(args, &planned, &plan, &printed, folder)?;
    streamed(args, &printed, outcome.clone(), bars)?;
    bars.finish();
    Ok((planned, plan, printed, outcome))
}

/// Writes the program of a saved plan again, checks it, and writes the files.
pub fn work_again(
    args: &Args,
    path: &Path,
    bars: &Bars,
    folder: &OutputFolder,
) -> Result<(Plan, Printed, Outcome), Failure> {
    let start = Instant::now();
    bars.update("read", 0, 5);
    let plan = Plan::read(path)?;
    let args = &Args {
        setup: plan.setup.clone(),
        layer_height_mm: plan.layer_height_mm,
        nozzle_height_mm: plan.nozzle_height_mm,
        ..args.clone()
    };
    let program = robot::program(args, &plan, bars)?;
    let printed = robot::check(args, &plan, program, start.elapsed(), bars)?;
    bars.update("write", 0, 1);
    folder.clear(outputs::is_ours)?;
    let outcome = outputs::write_again(args, &plan, &printed, folder)?;
    streamed(args, &printed, outcome.clone(), bars)?;
    bars.finish();
    Ok((plan, printed, outcome))
}

/// Streams a program without faults, if that was asked for.
fn streamed(args: &Args, printed: &Printed, outcome: Outcome, bars: &Bars) -> Result<(), Failure> {
    let Some(address) = &args.stream else { return Ok(()) };
    if outcome != Outcome::Done {
        return Err(Failure::new("the program is not streamed, for it has faults".to_owned()));
    }
    robot::stream(args, address, printed, &stream::commands_of_stdin(), bars)?;
    Ok(())
}
