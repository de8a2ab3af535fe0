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
mod args;
mod drawing;
mod follow_load;
mod given;
mod judged;
mod layer;
mod motion;
mod outputs;
mod part;
mod part_motion;
mod part_outputs;
mod part_programs;
mod part_read_back;
mod planar;
mod predict;
mod specimen_run;
mod specimens;
mod tape_outputs;
mod tapes;
mod wires;

pub use args::{Args, Boxed, Pull, Stage};
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::Findings;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::table::Table;
use given::Given;
use judged::{ANGLE_DEG, WORST_COVERED};
use part::PartRun;
use predict::predict;
use rayon::ThreadPoolBuilder;
use specimen_run::{Run, plan};
use std::process::ExitCode;
use std::time::Instant;

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
