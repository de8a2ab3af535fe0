//! Where a fixed nozzle should stand: what each arm reaches with the part in its hand, and the box with the most of
//! it.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.3.1.
//! ```sh
//! cargo run --release --example reach -- --arm ur5 --box 250
//! ```
//! Draws all arms; `--arm` says which one the plain keys of the summary are about. `--help` lists the options.

mod drawing;
mod outputs;
mod reaching;

use clap::Parser;
use curvlay_examples::args::{Common, Failure, Outcome, above_zero, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
use reaching::{ArmName, Reached};
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
    /// Frames must lie this far in front of axis 1 in millimetres, so that the nozzle does not stand on the arm
    #[arg(long = "front", value_name = "MM", default_value_t = 150.0, value_parser = above_zero, allow_negative_numbers = true)]
    front_mm: f64,
    #[command(flatten)]
    common: Common,
}

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = args.common.folder("reach", [], |_| false)?;
        let (reached, outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        outputs::table(&reached).print()?;
        Ok(outcome)
    })
}

/// Places the nozzle for every arm and writes the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Vec<Reached>, Outcome), Failure> {
    let start = Instant::now();
    let reached = reaching::run(args, bars)?;
    bars.finish();
    outputs::write(args, &reached, folder, start.elapsed())?;
    let outcome = Outcome::of(reaching::failed_checks(&reached));
    Ok((reached, outcome))
}
