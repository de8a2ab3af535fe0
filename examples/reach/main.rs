//! Where a nozzle should stand: what each arm reaches with the part in its hand, where it brings a part to the nozzle without touching
//! anything, and how far the workcells that we ship are from their best.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.3.1, puts it into the middle of the box with the most
//! frames. That is beside the place that a search with collisions finds.
//! ```sh
//! cargo run --release --example reach -- --arm ur5 --box 250
//! ```
//! Draws all arms; `--arm` says which one the plain keys of the summary are about. `--help` lists the options.

mod drawing;
mod outputs;
mod reaching;
mod standing;

use clap::Parser;
use curvlay_examples::args::{Common, Failure, Outcome, above_zero, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::table::Table;
use reaching::{ArmName, Found};
use std::process::ExitCode;
use std::time::Instant;

/// What arms reach with a part in the hand, and where a nozzle should stand, after Dai (2020), section 2.3.1.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "reach")]
pub struct Args {
    /// The arm that the plain keys of the summary are about
    #[arg(long, value_name = "NAME", default_value = "ur3")]
    arm: ArmName,
    /// Postures that are sampled
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000), allow_negative_numbers = true)]
    samples: u32,
    /// Edge of the box around the nozzle in millimetres
    #[arg(long = "box", value_name = "MM", default_value_t = 200.0, value_parser = above_zero, allow_negative_numbers = true)]
    box_mm: f64,
    /// Height of the platform, on which the part stands, over the flange in millimetres
    #[arg(long = "platform", value_name = "MM", default_value_t = 45.0, value_parser = above_zero, allow_negative_numbers = true)]
    platform_mm: f64,
    /// For the dissertation's box: frames must lie this far in front of axis 1 in millimetres, since counting frames knows no collisions
    #[arg(long = "front", value_name = "MM", default_value_t = 150.0, value_parser = above_zero, allow_negative_numbers = true)]
    front_mm: f64,
    /// Places that the search begins with are no farther apart than this in millimetres
    #[arg(long = "coarse", value_name = "MM", default_value_t = 100.0, value_parser = above_zero, allow_negative_numbers = true)]
    coarse_mm: f64,
    /// Last steps of the search in millimetres
    #[arg(long = "fine", value_name = "MM", default_value_t = 12.5, value_parser = above_zero, allow_negative_numbers = true)]
    fine_mm: f64,
    #[command(flatten)]
    common: Common,
}

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = args.common.folder("reach", [], |_| false)?;
        let (found, outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        Table::print_all(&[outputs::table(&found.arms), outputs::cells(&found.cells)])?;
        Ok(outcome)
    })
}

/// Places the nozzle for every arm and writes the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Found, Outcome), Failure> {
    let start = Instant::now();
    let mut found = reaching::run(args, bars)?;
    bars.finish();
    outputs::write(args, &found, folder, start.elapsed())?;
    found.findings.say();
    let outcome = found.findings.outcome();
    Ok((found, outcome))
}
