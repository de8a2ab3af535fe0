//! The example `boge_objects`, all of it but its command line.
#![allow(clippy::unwrap_used)]

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../boge_objects/main.rs"]
mod example;

use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
use example::Results;
use std::fs;
use std::path::{Path, PathBuf};

/// Runs the example in a folder of its own.
fn run(name: &str) -> (Results, PathBuf) {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("boge").join(name);
    let folder = OutputFolder::create(&path).unwrap();
    (example::work(&Bars::new(true), &folder, 1).unwrap(), path)
}

#[test]
fn every_figure_of_the_thesis_comes_out() {
    let (results, path) = run("figures");
    let wrong: Vec<_> = results.disagreeing().collect();
    assert!(wrong.is_empty(), "{wrong:?}");
    assert_eq!(results.failed_audits(), [""; 0]);
    assert_eq!(results.outcome(), Outcome::Done);

    let json = fs::read_to_string(path.join("summary.json")).unwrap();
    let summary: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&json).unwrap();
    assert_eq!((&summary["entries"], &summary["agreeing"]), (&77.into(), &77.into()));
    // Some of them once more by hand, from Tables 5.1, 5.2 and 6.6.
    for (key, figure) in [
        ("object1_l_gcfa_missed", 16),
        ("object1_l_gcfa_isp_layers", 15),
        ("object2_m_gcfa_layers", 12),
        ("object5_s_gcfa_isp_layers", 21),
        ("object6_l_gcfa_missed", 168),
        ("object6_l_gcfa_isp_missed", 185),
        ("object3_uniform_missed", 32),
    ] {
        assert_eq!(summary[key], figure, "{key}");
    }
    assert_eq!((&summary["audits"], &summary["audit_ok"]), (&144.into(), &true.into()));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert_eq!(report.matches("data:image/png;base64,").count(), 18);
    assert!(!report.contains("class=\"notice\""));
}

/// Boge 2019, section 4.4.6. Her coordinates count the row of the platform as well.
#[test]
fn the_worked_example_of_the_thesis_comes_out() {
    let (results, _) = run("worked");
    let case = &results.cases[1];
    assert_eq!(case.key, "object1_m");
    let layer = |method: usize, number: usize| -> Vec<[u32; 2]> {
        let cells = case.theirs[method].growth.order.layer(number - 1).iter();
        cells.map(|&cell| case.drawn.grid.position(cell)).map(|[x, _, z]| [x, z + 1]).collect()
    };
    assert_eq!(layer(0, 1), [[4, 1], [5, 1], [6, 1]]);
    assert!((1..=9).all(|number| layer(0, number) == layer(1, number)));
    assert_eq!(layer(0, 10), [[5, 10], [6, 10], [7, 10], [8, 10], [9, 10], [9, 9]]);
    assert_eq!(layer(1, 10), [[5, 10], [6, 10], [7, 10], [8, 10], [9, 9]]);
}

#[test]
fn an_object_is_the_same_on_every_platform() {
    let (results, _) = run("platforms");
    let cells = [59, 51, 82, 74, 89, 826];
    for (of_object, count) in results.cases.chunks(3).zip(cells) {
        // Cells from the corner of the object's box on.
        let shapes: Vec<Vec<[u32; 3]>> = of_object
            .iter()
            .map(|case| {
                let grid = &case.drawn.grid;
                let places: Vec<[u32; 3]> = grid.iter().map(|cell| grid.position(cell)).collect();
                let low = [0, 1, 2].map(|k| places.iter().map(|place| place[k]).min().unwrap());
                places.iter().map(|place| [0, 1, 2].map(|k| place[k] - low[k])).collect()
            })
            .collect();
        assert_eq!(shapes[0].len(), count);
        assert!(shapes.iter().all(|shape| *shape == shapes[0]), "object {}", of_object[0].object + 1);
        let sizes: Vec<usize> = of_object.iter().map(|case| case.drawn.platform.len()).collect();
        assert!(sizes.is_sorted_by(|a, b| a < b), "{sizes:?}");
    }
}

#[test]
fn a_wrong_figure_and_a_failed_audit_are_named() {
    let (mut results, _) = run("wrong");
    results.entries[3].ours += 1;
    let Outcome::ChecksFailed(failed) = results.outcome() else { panic!("a wrong figure") };
    assert!(failed.len() == 1 && failed[0].starts_with("object1_s_gcfa_isp_layers: "), "{failed:?}");
    results.entries[3].ours -= 1;
    assert_eq!(results.outcome(), Outcome::Done);
    results.cases[4].ours[3].audit.missed += 1;
    let Outcome::ChecksFailed(failed) = results.outcome() else { panic!("a failed audit") };
    assert!(failed.len() == 1 && failed[0].starts_with("audit of object2_m_governed: "), "{failed:?}");
}
