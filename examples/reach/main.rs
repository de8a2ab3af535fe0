//! Where a nozzle should stand: what each arm reaches with the part in its hand, where it brings a part to the nozzle without touching
//! anything, and how far the workcells that we ship are from their best.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.3.1, puts it into the middle of the box with the most
//! frames. That is beside the place that a search with collisions finds.
//! ```sh
//! cargo run --release --example reach -- --arm ur5 --box 250
//! ```
//! Draws all arms; `--arm` says which one the plain keys of the summary are about. `--help` lists the options.

mod args;
mod arms;
mod drawing;
mod outputs;
mod reaching;
mod standing;
mod tried;

pub use args::Args;
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::table::Table;
use reaching::Found;
use std::process::ExitCode;
use std::time::Instant;

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
