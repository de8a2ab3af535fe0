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

mod layer;
mod outputs;
mod table;

use clap::Parser;
use curvlay_examples::args::{Common, Failure, Outcome, above_zero, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;
use table::Printed;

/// A curved layer printed on a Stewart platform under a fixed nozzle, after Dai (2020), section 2.2.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "stewart_table")]
pub struct Args {
    /// Waypoints instead of the built-in layer: lines of `px py pz nx ny nz`, place in mm and direction of growth
    #[arg(value_name = "WAYPOINTS", conflicts_with = "waypoints")]
    file: Option<PathBuf>,
    /// Waypoints (same as the positional file)
    #[arg(long, value_name = "FILE")]
    waypoints: Option<PathBuf>,
    /// Radius of the dome in millimetres
    #[arg(long = "radius", value_name = "MM", default_value_t = 40.0, value_parser = millimetres, allow_negative_numbers = true)]
    radius_mm: f64,
    /// Height of the middle of the dome over its rim, in millimetres
    #[arg(long = "rise", value_name = "MM", default_value_t = 10.0, value_parser = millimetres, allow_negative_numbers = true)]
    rise_mm: f64,
    /// Distance between turns of the spiral, and between waypoints along it, in millimetres
    #[arg(long = "spacing", value_name = "MM", default_value_t = 1.0, value_parser = spacing, allow_negative_numbers = true)]
    spacing_mm: f64,
    /// Height of the nozzle over the base in millimetres
    #[arg(long = "nozzle", value_name = "MM", default_value_t = 400.0, value_parser = above_zero, allow_negative_numbers = true)]
    nozzle_mm: f64,
    #[command(flatten)]
    common: Common,
}

/// The spiral has about pi (radius / spacing)^2 waypoints.
fn millimetres(text: &str) -> Result<f64, String> {
    above_zero(text).and_then(|mm| if mm <= 300.0 { Ok(mm) } else { Err("must be at most 300".to_owned()) })
}

fn spacing(text: &str) -> Result<f64, String> {
    above_zero(text).and_then(|mm| if mm >= 0.2 { Ok(mm) } else { Err("must be at least 0.2".to_owned()) })
}

impl Args {
    /// The waypoints of the user, however they were given.
    fn waypoints(&self) -> Option<&Path> {
        self.file.as_deref().or(self.waypoints.as_deref())
    }
}

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
