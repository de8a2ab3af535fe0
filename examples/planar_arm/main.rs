//! How samples for a learned collision indicator gather at the boundary: a planar arm of three links on a circle.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.4.3, Figs. 4.5 and 4.6.
//! ```sh
//! cargo run --release --example planar_arm -- --samples 1700
//! ```
//! Draws `planar_arm.svg`: the contact space, unrolled, after each stage of the sampling (initial, up-scaled, refined)
//! with the truth and what the machine learned from the samples so far, the same for random samples, and a slice of joint
//! space. `--help` lists the options.

// The arm on which the crate's own tests learn.
#[path = "../../trajectory/tests/all/common/planar.rs"]
pub mod arm;
mod picture;

use clap::Parser;
use curvlay_examples::args::{Common, Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::count::counted;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_trajectory::indicator::svm::{Svm, SvmOptions};
use curvlay_trajectory::indicator::{
    CollisionIndicator, Rates, Sample, SamplingOptions, random_samples, training_set, verification_samples,
};
pub use picture::unrolled;
use picture::{ALONG, Drawing, JOINT, Map, dots};
use std::f64::consts::PI;
use std::process::ExitCode;
use std::time::Instant;

/// How samples for a learned collision indicator gather at the boundary, after Dai (2020), section 4.4.3.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "planar_arm")]
pub struct Args {
    /// Maximum number of samples; 1,698 in the dissertation
    #[arg(long, value_name = "N", default_value_t = 1698, value_parser = clap::value_parser!(u32).range(200..=20_000), allow_negative_numbers = true)]
    samples: u32,
    /// Number of random samples on the contact space at the start; no stage finds a pocket of free postures without one of them
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = clap::value_parser!(u32).range(20..=10_000), allow_negative_numbers = true)]
    initial: u32,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    common: Common,
}

/// How far from the contact space near postures are, in radians, and how many are asked about.
const NEAR: f64 = 0.05;
const VERIFIED: usize = 4000;
/// The joint that the slice holds, and its angle: the elbow bent as half way round the path.
const SLICE: f64 = 1.2;

/// A stage of the sampling, and what was learned from it.
pub struct Stage {
    name: &'static str,
    samples: usize,
    svm: Svm<3>,
    /// Near the contact space and on it.
    rates: [Rates; 2],
    /// Share of the map of the contact space on which it is wrong.
    wrong: f64,
}

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let folder = args.common.folder("planar_arm", [], |_| false)?;
        let (stages, outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        table(&stages).print()?;
        Ok(outcome)
    })
}

/// Samples, learns, draws and writes the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Vec<Stage>, Outcome), Failure> {
    let start = Instant::now();
    let space = arm::space();
    let options = SamplingOptions {
        initial: args.initial as usize,
        max_samples: args.samples.max(args.initial) as usize,
        seed: args.seed,
        ..SamplingOptions::default()
    };
    let set = training_set(&space, &options)?;
    let verified = [
        verification_samples(&space, VERIFIED, NEAR, args.seed.wrapping_add(10))?,
        verification_samples(&space, VERIFIED, 0.0, args.seed.wrapping_add(11))?,
    ];
    let random = random_samples(&space, &[-PI; 3], &[PI; 3], set.samples.len(), args.seed.wrapping_add(12))?;
    let until = |stage: usize| set.stages.get(stage).copied().unwrap_or(set.samples.len());
    // Later rounds of both, where there are any, count as refinement.
    let cut = [("initial", until(0)), ("up-scaled", until(1)), ("refined", set.samples.len())];
    let mut drawing = Drawing::default();
    let postures: Vec<[f64; 3]> =
        [[0.4, 0.3], [1.7, 0.9], [2.6, 5.4], [4.4, 0.2]].into_iter().filter_map(on_path).collect();
    drawing.scene("arm, path and discs", &postures);
    let mut stages = vec![];
    let no_dots = vec![false; random.len()];
    let sets = cut.into_iter().map(|(name, count)| (name, &set.samples[..count], &set.on_contact[..count]));
    for (name, samples, on) in sets.chain([("random", &random[..], &no_dots[..])]) {
        bars.update("learn", stages.len() as u64, 4);
        stages.push(learned(name, samples, on, &verified, &mut drawing)?);
    }
    draw_slice(&stages[2], &set.samples, &mut drawing);
    bars.finish();
    let svg = drawing.to_svg();
    folder.write("planar_arm.svg", &svg)?;
    folder.write("report.html", report(&stages, &svg).to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, &stages, start.elapsed())?.write(folder)?;
    Ok((stages, Outcome::Done))
}

/// The joints of a place on the path, with the last link in a direction.
fn on_path([along, turn]: [f64; 2]) -> Option<[f64; 3]> {
    arm::inverse(arm::on_path(along), turn, 1.0)
}

/// Learns from samples, of which some are `on` the contact space, and draws what is predicted along the path.
fn learned(
    name: &'static str,
    samples: &[Sample<3>],
    on: &[bool],
    verified: &[Vec<Sample<3>>; 2],
    drawing: &mut Drawing,
) -> Result<Stage, Failure> {
    let svm = Svm::train(samples, &SvmOptions::default())
        .map_err(|error| Failure::new(format!("{name} samples: {error}; --initial or --samples is too small")))?;
    let wrong = drawing.map(&Map {
        title: format!("{name}: {}, {}", counted(samples.len(), "sample"), counted(svm.kernels(), "kernel")),
        axes: ["place on the path", "direction of the last link"],
        range: ALONG,
        joints: &on_path,
        predicts: &|q| svm.predicts(q),
        dots: dots(samples, on),
    });
    let rates = verified.each_ref().map(|known| Rates::of(&svm, known));
    Ok(Stage { name, samples: samples.len(), svm, rates, wrong })
}

/// Draws a slice of joint space: off the contact space most of it is far from any sample.
fn draw_slice(learned: &Stage, samples: &[Sample<3>], drawing: &mut Drawing) {
    let near: Vec<([f64; 2], bool)> = samples
        .iter()
        .filter(|sample| (sample.joints[1] - SLICE).abs() < NEAR)
        .map(|sample| ([sample.joints[0], sample.joints[2]], sample.collides))
        .collect();
    drawing.map(&Map {
        title: format!("slice of joint space, joint 2 at {SLICE}: refined"),
        axes: ["joint 1", "joint 3"],
        range: JOINT,
        joints: &|[first, third]| Some([first, SLICE, third]),
        predicts: &|q| learned.svm.predicts(q),
        dots: near,
    });
}

/// The stages, and Fig. 4.6.
fn table(stages: &[Stage]) -> Table {
    let mut table = Table::new([
        "samples",
        "number",
        "kernels",
        "bias shift",
        "TNR near",
        "TNR on contact",
        "missed near",
        "missed on contact",
        "wrong on the map",
    ]);
    let rate = |rate: Option<f64>| rate.map_or_else(|| "-".to_owned(), |rate| format!("{rate:.3}"));
    for Stage { name, samples, svm, rates: [near, on], wrong } in stages {
        let figures = [near.tnr(), on.tnr(), near.missed_rate(), on.missed_rate(), Some(*wrong)].map(rate);
        let [a, b, c, d, e] = figures;
        table.row([(*name).to_owned(), samples.to_string(), svm.kernels().to_string(), "0".into(), a, b, c, d, e]);
    }
    for (name, samples, kernels) in [
        ("up-scaled", "474", "348"),
        ("refined", "1527", "714"),
        ("all rounds", "1698", "779"),
        ("random", "1698", "517"),
    ] {
        table.row([&format!("dissertation, {name}"), samples, kernels, "1", "-", "-", "-", "-", "-"]);
    }
    table
}

fn summary(args: &Args, stages: &[Stage], time: std::time::Duration) -> Result<Summary, Failure> {
    let mut summary = Summary::new();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("samples", args.samples)?
        .set("initial", args.initial)?
        .set("seed", args.seed)?
        .set("threads", args.common.threads)?;
    for Stage { name, samples, svm, rates, wrong } in stages {
        let name = name.replace(['-', ' '], "_");
        summary
            .set(&format!("{name}_samples"), *samples)?
            .set(&format!("{name}_kernels"), svm.kernels())?
            .set(&format!("{name}_wrong"), *wrong)?;
        for (place, rates) in [("near", rates[0]), ("contact", rates[1])] {
            for (what, rate) in [("tnr", rates.tnr()), ("missed", rates.missed_rate())] {
                if let Some(rate) = rate {
                    summary.set(&format!("{name}_{what}_{place}"), rate)?;
                }
            }
        }
    }
    summary.set_seconds("total_s", time)?;
    Ok(summary)
}

fn report(stages: &[Stage], svg: &str) -> Report {
    let mut report = Report::new("A planar arm: samples for a learned collision indicator");
    report
        .paragraph(
            "After Dai (2020), section 4.4.3. Maps of the contact space with the elbow bent to the left: along the path, and \
             up the direction of the last link. Free postures are blue, colliding ones grey, white is out of reach; the \
             black line is the boundary that was learned, red what it gets wrong; dots are the samples on contact.",
        )
        .drawing("The arm, stages of the sampling, random samples, and a slice of joint space", svg)
        .table("Against postures with a known answer", &table(stages))
        .paragraph(
            "The dissertation's path and obstacles are not known: its numbers of samples and kernels are those of another \
             setting, and its machines have 1 added to the bias.",
        );
    report
}
