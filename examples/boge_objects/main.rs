//! Six test objects on three platforms, grown by two methods, against the tables of the thesis that tried them first.
//!
//! H. Boge, *Robotic additive manufacturing* (MSc thesis, NTNU 2019): Tables 5.1, 5.2 and 6.6.
//! ```sh
//! cargo run --release --example boge_objects
//! ```
//! Every figure of the tables is printed beside ours, and the same objects follow under our own default rules, each
//! order audited. `--help` lists the options, the README the files that it writes.

mod growing;
mod objects;
mod outputs;
mod thesis;

use clap::Parser;
use curvlay_examples::args::{Common, Failure, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
pub use growing::Results;
use std::process::ExitCode;
use std::time::Instant;

/// The six objects of Boge (2019) on her three platforms, against her tables, and under our own rules.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "boge_objects")]
struct Args {
    #[command(flatten)]
    common: Common,
}

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = args.common.folder("boge_objects")?;
        let results = work(&Bars::new(args.common.quiet), &folder, args.common.threads)?;
        outputs::print(&results)?;
        Ok(results.outcome())
    })
}

/// Grows everything and writes the files.
pub fn work(bars: &Bars, folder: &OutputFolder, threads: usize) -> Result<Results, Failure> {
    let start = Instant::now();
    let results = growing::run(objects::read()?, bars)?;
    bars.finish();
    outputs::write(&results, folder, threads, start.elapsed())?;
    Ok(results)
}
