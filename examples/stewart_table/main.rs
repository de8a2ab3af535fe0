//! A curved layer printed on a Stewart platform: the platform carries the part under a nozzle that stands still.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.2, after X. Song, Y. Pan and Y.
//! Chen, "Development of a low-cost parallel kinematic machine for multidirectional additive manufacturing", J. Manuf.
//! Sci. Eng. 137, 2015.
//! ```sh
//! cargo run --release --example stewart_table -- --radius 50 --rise 12
//! cargo run --release --example stewart_table -- layer.csv
//! ```
//! Without `--waypoints` the layer is a dome made in code. `--help` lists the options.

mod args;
mod layer;
mod outputs;
mod table;

pub(crate) use args::Args;
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
use std::process::ExitCode;
use std::time::Instant;
use table::Printed;

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = args.common.folder("stewart_table", [args.waypoints()], outputs::is_ours)?;
        let (printed, outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        outputs::table(&printed).print()?;
        Ok(outcome)
    })
}

/// Poses the platform for every waypoint and writes the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Printed, Outcome), Failure> {
    let start = Instant::now();
    let waypoints = match args.waypoints() {
        Some(path) => layer::read(path)?,
        None => layer::dome(args.radius_mm, args.rise_mm, args.spacing_mm),
    };
    let printed = table::print(args.nozzle_mm, &waypoints, bars)?;
    bars.finish();
    outputs::write(args, &printed, folder, start.elapsed())?;
    let outcome = Outcome::of(printed.failed_checks());
    Ok((printed, outcome))
}
