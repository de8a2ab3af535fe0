//! RoboFDM: a mesh becomes parts that a robot prints one after another, each in flat layers along a direction of its own, without
//! support; with tool paths, joint motion, transfers between the parts, and programs.
//!
//! C. Wu, C. Dai, G. Fang, Y.-J. Liu and C. C. L. Wang, "RoboFDM: a robotic system for support-free fabrication using FDM", ICRA 2017; C. Dai,
//! *Material Deposition in 3D Space* (dissertation, TU Delft 2020), chapter 2.
//! ```sh
//! cargo run --release --example robofdm
//! cargo run --release --example robofdm -- part.stl --stage parts
//! ```
//! Without `--mesh` it prints a shape made in code that no single direction prints without support. `--help` lists the options.

mod args;
mod decompose;
mod drawing;
mod made;
mod outputs;
mod print;
mod ways;
mod workcell;

pub use args::{Args, Avoid, Base, Method, PatternName, Stage};
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
pub use made::Made;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = args.common.folder("robofdm", [args.mesh.path(), args.workcell.as_deref()], outputs::is_ours)?;
        let (made, outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        outputs::parts_table(&made).print()?;
        outputs::comparison(&args, &made).print()?;
        Ok(outcome)
    })
}

/// From the mesh to the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Made, Outcome), Failure> {
    let start = Instant::now();
    if args.avoid == Avoid::Planes && args.pedestal_mm.is_some() {
        return Err(Failure::of_arguments("--pedestal gives the head room: it does nothing with --avoid planes"));
    }
    // Read once before the work: a workcell that is not there is no news for the end of it.
    workcell::model(args)?;
    let divided = decompose::divide(args, bars)?;
    let printed = if args.stage > Stage::Parts { Some(print::print(args, &divided, bars)?) } else { None };
    bars.finish();
    let made = Made { filaments: args.filaments, load: args.load, divided, printed };
    let mut findings = made.divided.of_mesh.clone();
    made.divided.find(args, &mut findings);
    if let Some(printed) = &made.printed {
        printed.find(&mut findings);
    }
    outputs::write(args, &made, &findings, folder, start)?;
    findings.say();
    Ok((made, findings.outcome()))
}
