//! The example `planar_arm`: the picture, and that samples by stages learn the boundary better.

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../planar_arm/main.rs"]
mod example;

use crate::common;
use crate::common::summary;
use clap::Parser;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use example::Args;
use std::f64::consts::PI;
use std::fs;

fn arguments(words: &[&str]) -> Result<Args, clap::Error> {
    Args::try_parse_from(["planar_arm"].iter().chain(words))
}

#[test]
fn stages_gather_at_the_boundary() {
    let folder = common::folder("planar_arm", "figures");
    let (_, outcome) = example::work(&arguments(&[]).unwrap(), &Bars::new(true), &folder).unwrap();
    assert_eq!(outcome, Outcome::Done);
    let path = common::place("planar_arm", "figures");
    let summary = summary(&path);
    let figure = |key: &str| summary[key].as_f64().unwrap_or_else(|| panic!("{key}"));
    // More samples each stage, and less of the map wrong; random ones of the same number are worse.
    let names = ["initial", "up_scaled", "refined"];
    for pair in names.windows(2) {
        let [before, after] = [pair[0], pair[1]].map(|name| figure(&format!("{name}_samples")));
        assert!(before <= after, "{pair:?}");
    }
    assert!((figure("initial_samples"), figure("random_samples")) == (300.0, figure("refined_samples")));
    assert!(figure("up_scaled_samples") > 300.0 && figure("refined_samples") > figure("up_scaled_samples"));
    assert!(figure("refined_wrong") < 0.6 * figure("initial_wrong"));
    assert!(figure("refined_wrong") < 0.3 * figure("random_wrong"));
    assert!(figure("refined_tnr_contact") > 0.85 && figure("refined_missed_contact") < 0.1);
    let svg = fs::read_to_string(path.join("planar_arm.svg")).unwrap();
    // The scene, four maps and the slice; every tag that is opened is closed.
    assert_eq!((svg.matches("<text x=").count(), svg.matches("<svg").count()), (6, 1));
    assert!(svg.ends_with("</svg>") && svg.matches("<text").count() == svg.matches("</text>").count());
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert!(fs::read_to_string(path.join("report.html")).unwrap().contains(&svg));
}

/// The unrolled map and the joints are two sides of one thing, and the truth is that of points along the links.
#[test]
fn the_arm_is_what_it_says() {
    for k in 0..500 {
        let (along, turn) = (0.0125 * f64::from(k), 0.37 * f64::from(k) % (2.0 * PI));
        for side in [-1.0, 1.0] {
            let Some(q) = example::arm::inverse(example::arm::on_path(along), turn, side) else { continue };
            let [place, direction] = example::unrolled(&q);
            assert!((place - along).sin().abs() < 1e-9 && (direction - turn).sin().abs() < 1e-9);
            assert!(q[1] * side >= 0.0 && q.iter().all(|angle| angle.abs() <= PI + 1e-9));
            let at = example::arm::corners(&q);
            let touches = (0..3).any(|link| {
                (0..=400).any(|step| {
                    let t = f64::from(step) / 400.0;
                    let p = [0, 1].map(|d| at[link][d] + (at[link + 1][d] - at[link][d]) * t);
                    let within = |(c, r): &([f64; 2], f64)| (p[0] - c[0]).hypot(p[1] - c[1]) < r + example::arm::GIRTH;
                    example::arm::DISCS.iter().any(within)
                })
            });
            // Points are 0.75 mm apart: what they find is there, what they miss is a graze.
            assert!(!touches || example::arm::collides(&q));
        }
    }
}

#[test]
fn arguments_out_of_range_are_refused() {
    for words in [["--samples", "0"], ["--samples", "-1"], ["--initial", "3"], ["--seed", "x"]] {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
}
