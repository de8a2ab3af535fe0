//! From a mesh to the order in which its cells are built, without support and without collision.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), chapter 3.
//! ```sh
//! cargo run --release --example curved_layers -- --mesh part.stl --voxels 100000
//! ```
//! Without `--mesh` it takes a jug made in code. `--help` lists the options, the README the files that it writes.

mod field;
mod outputs;

use clap::{Parser, ValueEnum};
use curvlay_examples::args::{Common, Failure, GrowArgs, MeshArgs, Outcome, VoxelArgs, run_with_args, warn};
use curvlay_examples::bars::Bars;
use curvlay_examples::shapes::jug;
use std::process::ExitCode;

/// Curved layers for a part, after Dai (2020), chapter 3: needs no support, cannot collide, and is audited.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "curved_layers")]
struct Args {
    #[command(flatten)]
    mesh: MeshArgs,
    #[command(flatten)]
    voxel: VoxelArgs,
    #[command(flatten)]
    grow: GrowArgs,
    /// The last stage to run
    #[arg(long, default_value = "field")]
    stage: Stage,
    #[command(flatten)]
    common: Common,
}

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Stage {
    /// The growing field: which cell belongs to which layer.
    Field,
}

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = args.common.folder("curved_layers")?;
        let bars = Bars::new(args.common.quiet);
        let part = args.mesh.load("jug (made in code)", jug)?;
        part.warning.iter().for_each(warn);
        let run = field::run(&args, &part, &bars)?;
        bars.finish();
        run.findings.iter().for_each(warn);
        outputs::write(&args, &part, &run, &folder)?;
        Ok(if run.audit.is_ok() { Outcome::Done } else { Outcome::CheckFailed })
    })
}

/// Any error as one line.
fn failure(error: impl std::fmt::Display) -> Failure {
    Failure::new(error)
}
