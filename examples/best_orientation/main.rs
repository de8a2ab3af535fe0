//! How a part should lie on the plate, so that as little of it as possible is missed.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 3.4, takes the pose as given; the cells that the hull
//! shadows depend on it more than on anything else.
//! ```sh
//! cargo run --release --example best_orientation -- part.stl
//! ```
//! Without `--mesh` it takes a jug made in code. `curved_layers --orient best` does the same search and goes on with the best
//! pose.

mod drawing;
mod outputs;

use clap::Parser;
use curvlay_examples::args::{Common, Failure, MeshArgs, Outcome, Part, above_zero, from_zero, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::{Findings, Severity, percent};
use curvlay_examples::orienting::{OrientArgs, Search, search};
use curvlay_examples::output::OutputFolder;
use curvlay_examples::shapes::jug;
use curvlay_layers::curved::Rules;
use rayon::ThreadPoolBuilder;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// How a part should lie on the plate: poses are tried with few cells, the best again with more, and ranked by missed cells, whether the
/// part stands by itself, support, layers, height and base.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "best_orientation")]
pub struct Args {
    #[command(flatten)]
    mesh: MeshArgs,
    #[command(flatten)]
    orient: OrientArgs,
    /// Depth inside the hull from which a cell counts as shadowed, in cells, at most 16
    #[arg(long, value_name = "CELLS", default_value_t = 1.0, value_parser = from_zero, allow_negative_numbers = true)]
    eps: f64,
    /// Only cells deeper than --eps count as shadowed, not those at exactly that depth
    #[arg(long)]
    beyond_eps: bool,
    /// Diameter of the platform in millimetres; a larger one is used if the part does not fit
    #[arg(long = "platform-diameter", value_name = "MM", default_value_t = 127.5, value_parser = above_zero, allow_negative_numbers = true)]
    platform_diameter_mm: f64,
    #[command(flatten)]
    common: Common,
}

/// What came of it: the part, its poses, how long the search took, and what is wrong.
pub struct Run {
    part: Part,
    search: Search,
    search_time: Duration,
    findings: Findings,
}

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = args.common.folder("best_orientation", [args.mesh.path()], outputs::is_ours)?;
        let (run, outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        outputs::table(&run.search).print()?;
        Ok(outcome)
    })
}

/// Searches the pose and writes the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Run, Outcome), Failure> {
    let start = Instant::now();
    let part = args.mesh.load("jug (made in code)", jug)?;
    folder.clear(outputs::is_ours)?;
    let rules = Rules { inside_depth_cells: args.eps, boundary_is_inside: !args.beyond_eps, ..Rules::default() };
    let options = args.orient.options(rules, args.platform_diameter_mm);
    let pool = ThreadPoolBuilder::new().num_threads(args.common.threads).build()?;
    let begin = Instant::now();
    let search = pool.install(|| search(&part.mesh, &args.orient, &options, bars))?;
    let search_time = begin.elapsed();
    let mut findings = Findings::default();
    part.find(&mut findings);
    let best = search.best();
    if best.missed_cells > 0 {
        let amount = format!("{} of the cells", percent(best.missed_share()));
        findings.add(Severity::Warning, "cells are missed in the best pose, too", amount, "poses.csv");
    }
    if !best.stands {
        let amount = format!("it falls when tipped by {:.1} degrees", best.pose.tipping.to_degrees());
        findings.add(
            Severity::Warning,
            "the part does not stand by itself in the best pose",
            amount,
            "--standing-first",
        );
    }
    let run = Run { part, search, search_time, findings };
    bars.finish();
    outputs::write(args, &run, folder, start)?;
    let Run { mut findings, part, search, search_time } = run;
    findings.say();
    let outcome = findings.outcome();
    Ok((Run { part, search, search_time, findings }, outcome))
}
