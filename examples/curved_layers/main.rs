//! From a mesh to a print in curved layers: an audited order of its cells, surfaces, tool paths, a machine file, and the motion of
//! a robot.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), chapter 3.
//! ```sh
//! cargo run --release --example curved_layers -- part.stl --layer-height 0.3 --bead 0.5
//! cargo run --release --example curved_layers -- part.stl --voxels 100000   # for research: layers and beads as the cells
//! ```
//! Without a mesh it takes a jug made in code. `--help` lists the options, the README the files that it writes.

mod args;
mod choice;
mod complete;
mod conflicts;
mod derived;
mod estimate;
mod field;
mod findings;
mod guide;
mod job;
mod machine;
mod motion;
mod mould;
mod order;
mod outputs;
mod paths;
mod preview;
mod ranges;
mod run;
mod surfaces;
mod tried;

use args::{Args, Lying, Stage, failure};
use curvlay_examples::args::{Failure, run_command};
use curvlay_examples::bars::Bars;
use guide::Guide;
use job::{Job, Setup};
use std::env;
use std::process::ExitCode;

fn main() -> ExitCode {
    run_command(args::command(), env::args_os(), |args: Args, matches| {
        conflicts::check(matches).map_err(Failure::of_arguments)?;
        let args = args.with_profile(matches)?;
        let setup = Setup::of(&args)?;
        let folder = args.common.folder("curved_layers", args.files(), outputs::is_ours)?;
        let saved = args.resume.as_deref().map(surfaces::load).transpose()?;
        ranges::check(&args.merge).map_err(failure)?;
        let (mut part, mould, guide) = (args.part(saved.as_ref())?, args.mould()?, Guide::of(&args)?);
        // All that is read has been read, or can be: what an earlier run has left goes now.
        folder.clear(outputs::is_ours)?;
        let bars = &Bars::new(args.common.quiet);
        pool(&args)?.install(|| {
            let posed = (args.orient == Lying::Best).then(|| args.lay(&mut part, bars)).transpose()?;
            let (part, mould, guide) = (&part, mould.as_ref(), guide.as_ref());
            let job = Job { args: &args, setup, part, mould, guide, posed, folder: &folder, bars };
            job.work(saved)
        })
    })
}

fn pool(args: &Args) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(args.common.threads).build().map_err(failure)
}
