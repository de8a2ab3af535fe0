//! How a part should lie on the plate, so that as little of it as possible is missed.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 3.4, takes the pose as given; the cells that the hull
//! shadows depend on it more than on anything else.
//! ```sh
//! cargo run --release --example best_orientation -- part.stl
//! ```
//! Without `--mesh` it takes a jug made in code. `curved_layers --orient best` does the same search and goes on with the best
//! pose.

mod args;
mod drawing;
mod outputs;

pub(crate) use args::{Args, Run};
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::{Findings, Severity, percent};
use curvlay_examples::orienting::search;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::shapes::jug;
use curvlay_layers::curved::Rules;
use rayon::ThreadPoolBuilder;
use std::process::ExitCode;
use std::time::Instant;

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
    let rules = Rules { inside_depth_cells: args.eps_cells, boundary_is_inside: !args.beyond_eps, ..Rules::default() };
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
