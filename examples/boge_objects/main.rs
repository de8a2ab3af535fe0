//! Six test objects on three platforms, grown by two methods, against the tables of the thesis that tried them first.
//!
//! H. Boge, *Robotic additive manufacturing* (MSc thesis, NTNU 2019): Tables 5.1, 5.2, 6.4, 6.6 and 6.7.
//! ```sh
//! cargo run --release --example boge_objects
//! cargo run --release --example boge_objects -- my.txt --hardware elevated
//! ```
//! Every figure of the tables is printed beside ours, and the same objects follow under our own default rules, each
//! order audited. With a file, a grid of your own is grown in the same ways, with the platform in the hand, on the floor or
//! elevated. `--help` lists the options.

mod drawing;
mod growing;
mod grown;
mod hardware;
mod objects;
mod outputs;
mod rating;
mod thesis;
mod user;

use clap::Parser;
use curvlay_examples::args::{Common, Failure, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
pub use growing::Results;
pub use hardware::Hardware;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;
pub use user::{Request, work as work_on_grid};

/// The six objects of Boge (2019) on her three platforms, against her tables, and under our own rules.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "boge_objects")]
struct Args {
    /// Text grid of your own to grow instead: `1` cell, `-` platform, `0` empty; the last row of a flat object is the platform; an object
    /// in space has blocks with an empty line between, of which the first is the platform
    #[arg(value_name = "GRID", group = "of_user")]
    file: Option<PathBuf>,
    /// Text grid (same as the positional file)
    #[arg(long, value_name = "FILE", group = "of_user")]
    grid: Option<PathBuf>,
    /// Position of platform and nozzle, for --grid [default: in-hand]
    #[arg(long, requires = "of_user")]
    hardware: Option<Hardware>,
    /// Maximum share of missed cells of the best strategy, for --grid; more sets exit status 3 [default: 0.001]
    #[arg(long, value_name = "SHARE", requires = "of_user", value_parser = share, allow_negative_numbers = true)]
    allow_missed: Option<f64>,
    /// Voxel accumulation threshold of GCFA-ISP (section 6.2.5 of the thesis): a cell is kept when it leaves fewer cells shadowed than this [default:
    /// the one of 1 to 192 that misses least]
    #[arg(long, value_name = "CELLS", value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    threshold: Option<u32>,
    #[command(flatten)]
    common: Common,
}

/// A share, from 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err("it must be from 0 to 1".to_owned()) }
}

impl Args {
    /// The grid of the user, however it was given.
    fn grid(&self) -> Option<&Path> {
        self.file.as_deref().or(self.grid.as_deref())
    }

    /// What is asked for of a grid of the user's own.
    fn request(&self) -> Option<Request> {
        let file = self.grid()?.to_owned();
        let hardware = self.hardware.unwrap_or(Hardware::InHand);
        let allow_missed = self.allow_missed.unwrap_or(0.001);
        Some(Request { file, hardware, allow_missed, threshold: self.threshold, threads: self.common.threads })
    }
}

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = args.common.folder("boge_objects", [args.grid()], user::is_ours)?;
        if let Some(request) = args.request() {
            let answer = work_on_grid(&request, &Bars::new(args.common.quiet), &folder)?;
            answer.table().print()?;
            return Ok(answer.outcome());
        }
        let results = work(args.threshold, &Bars::new(args.common.quiet), &folder, args.common.threads)?;
        outputs::print(&results)?;
        Ok(results.outcome())
    })
}

/// Grows everything and writes the files.
pub fn work(threshold: Option<u32>, bars: &Bars, folder: &OutputFolder, threads: usize) -> Result<Results, Failure> {
    let start = Instant::now();
    let results = growing::run(objects::read()?, threshold, bars)?;
    bars.finish();
    outputs::write(&results, folder, threads, start.elapsed())?;
    Ok(results)
}
