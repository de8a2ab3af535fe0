//! The example `boge_objects`, all of it but its command line.

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../boge_objects/main.rs"]
mod example;

use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use curvlay_examples::output::OutputFolder;
use example::{Hardware, Request, Results};
use std::fs;
use std::path::{Path, PathBuf};

/// Runs the example in a folder of its own.
fn run(name: &str) -> (Results, PathBuf) {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("boge").join(name);
    let folder = OutputFolder::create(&path).unwrap();
    (example::work(None, &Bars::new(true), &folder, 1).unwrap(), path)
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
    assert_eq!((&summary["audits"], &summary["audit_ok"]), (&306.into(), &true.into()));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    // Six objects on three platforms by two methods, and on the large one by ours; six pairs of plane slicing; object 6 in three series of cuts.
    let deep = results.cases[15].drawn.grid.iter().map(|cell| results.cases[15].drawn.grid.position(cell)[1]);
    let cuts = deep.clone().max().unwrap() - deep.min().unwrap() + 1;
    assert_eq!(report.matches("data:image/png;base64,").count(), 36 + 6 + 12 + 3 * cuts as usize);
    assert!(!report.contains("class=\"notice\""));
}

/// Boge 2019, section 4.4.6. Her coordinates count the row of the platform as well.
#[test]
fn the_worked_example_of_the_thesis_comes_out() {
    let (results, path) = run("worked");
    let case = &results.cases[1];
    assert_eq!(case.key, "object1_m");
    let layer = |method: usize, number: usize| -> Vec<[u32; 2]> {
        let cells = case.ways.theirs[method].growth.order.layer(number - 1).iter();
        cells.map(|&cell| case.drawn.grid.position(cell)).map(|[x, _, z]| [x, z + 1]).collect()
    };
    assert_eq!(layer(0, 1), [[4, 1], [5, 1], [6, 1]]);
    assert!((1..=9).all(|number| layer(0, number) == layer(1, number)));
    assert_eq!(layer(0, 10), [[5, 10], [6, 10], [7, 10], [8, 10], [9, 10], [9, 9]]);
    assert_eq!(layer(1, 10), [[5, 10], [6, 10], [7, 10], [8, 10], [9, 9]]);
    // The drawing of it: two cells lie in the hull of ten greedy layers (Fig. 4.17a), one with the improved layer (Fig. 4.22b), nine and three at the end.
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    let drawings: Vec<&str> = report.split("<svg").skip(1).filter(|svg| svg.contains("in the hull</text>")).collect();
    assert_eq!(drawings.len(), 2);
    for (drawing, (tenth, last)) in drawings.iter().zip([(2, 9), (1, 3)]) {
        assert!(
            drawing.contains(&format!("layer 10: {} cells, {tenth} in the hull", if tenth == 2 { 6 } else { 5 })),
            "{tenth}"
        );
        assert!(drawing.contains(&format!(", {last} in the hull")), "{last}");
        assert_eq!(drawing.matches("<polygon").count(), 14);
    }
}

/// Section 6.2.5: a threshold can only be as good as the best one, and one beyond all cells gives the greedy layers.
#[test]
fn the_threshold_of_the_thesis_is_an_option() {
    let (results, path) = run("tuned");
    for case in &results.cases {
        let [gcfa, isp] = [0, 1].map(|method| case.ways.theirs[method].growth.missed.len());
        assert!(case.tuned.run.growth.missed.len() <= gcfa.min(isp), "{}", case.key);
    }
    let csv = fs::read_to_string(path.join("layers.csv")).unwrap();
    assert!(csv.starts_with("object,platform,x,y,z,gcfa,gcfa_isp,gcfa_isp_tuned\n"));
    // What is missed has layer 0: Table 5.1 again, from the file.
    for (object, platform, column, missed) in
        [("1", "M", 5, 9), ("1", "M", 6, 3), ("6", "L", 5, 168), ("6", "L", 6, 185)]
    {
        let rows = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let of_case = rows.filter(|row| row[0] == object && row[1] == platform);
        assert_eq!(of_case.filter(|row| row[column] == "0").count(), missed, "{object} {platform} {column}");
    }
    let folder = OutputFolder::create(&path).unwrap();
    let results = example::work(Some(100_000), &Bars::new(true), &folder, 1).unwrap();
    for case in &results.cases {
        assert_eq!(case.tuned.run.growth.order, case.ways.theirs[0].growth.order, "{}", case.key);
    }
    assert!(fs::read_to_string(path.join("report.html")).unwrap().contains("With a threshold of 100000"));
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
    results.cases[4].ways.ours[3].audit.missed += 1;
    let Outcome::ChecksFailed(failed) = results.outcome() else { panic!("a failed audit") };
    assert!(failed.len() == 1 && failed[0].starts_with("audit of object2_m_governed: "), "{failed:?}");
}

/// Tables 6.4 and 6.7 of the thesis.
#[test]
fn verdicts_and_hardware_come_out() {
    let (results, path) = run("verdicts");
    assert_eq!(results.other_ratings(), [""; 0]);
    let json = fs::read_to_string(path.join("summary.json")).unwrap();
    let summary: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&json).unwrap();
    assert_eq!((&summary["ratings"], &summary["ratings_agreeing"]), (&36.into(), &36.into()));
    // In the hand and elevated, the small platform of Table 5.1: of all objects only the fifth misses cells.
    for set in ["in_hand", "elevated"] {
        assert_eq!(summary[&format!("{set}_gcfa_missed")], 9, "{set}");
        assert_eq!(summary[&format!("{set}_gcfa_isp_missed")], 15, "{set}");
    }
    // The floor is larger than her large platform.
    let on_large: usize =
        results.cases.iter().skip(2).step_by(3).map(|case| case.ways.theirs[0].growth.missed.len()).sum();
    let on_floor = summary["fixed_gcfa_missed"].as_u64().unwrap() as usize;
    assert!(on_floor >= on_large, "{on_floor} {on_large}");
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert!(report.contains("Table 6.4") && report.contains("Table 6.7"));
}

/// Grows a grid of the user's own.
fn own(name: &str, grid: &str, hardware: Hardware, allow_missed: f64) -> (Outcome, serde_json::Value, PathBuf) {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("boge").join(name);
    let folder = OutputFolder::create(&path).unwrap();
    let file = path.join("grid.txt");
    fs::write(&file, grid).unwrap();
    let request = Request { file, hardware, allow_missed, threshold: None, threads: 1 };
    let answer = example::work_on_grid(&request, &Bars::new(true), &folder).unwrap().outcome();
    let summary = serde_json::from_str(&fs::read_to_string(path.join("summary.json")).unwrap()).unwrap();
    (answer, summary, path)
}

/// A T of nine cells on a foot of one: the arms hang over the platform.
const TEE: &str = "111\n010\n010\n---\n";

#[test]
fn a_grid_of_the_user_s_own_is_grown() {
    // A beam of 21 cells on a post of one.
    let rows = ["1".repeat(21), format!("{0}010{0}", "0".repeat(9)), format!("{0}---{0}", "0".repeat(9))];
    let tall = rows.join("\n");
    for (text, hardware, key) in [
        (TEE, Hardware::InHand, "in_hand"),
        (TEE, Hardware::Elevated, "elevated"),
        (tall.as_str(), Hardware::Elevated, "elevated"),
    ] {
        let (outcome, summary, path) = own("own", text, hardware, 0.0);
        assert_eq!((outcome, &summary["missed_cells"]), (Outcome::Done, &0.into()), "{text}");
        assert_eq!((&summary["hardware"], &summary["audit_ok"]), (&key.into(), &true.into()));
        let layers = fs::read_to_string(path.join("layers.csv")).unwrap();
        let cells = text.matches('1').count();
        assert_eq!((layers.lines().count(), &summary["cells"]), (cells + 1, &cells.into()));
        assert!(layers.starts_with("x,y,z,layer,gcfa,gcfa_isp,gcfa_isp_tuned\n"));
        assert!(layers.lines().skip(1).all(|line| line.split(',').nth(3) != Some("0")), "{layers}");
        assert!(fs::read_to_string(path.join("report.html")).unwrap().contains("verdict"));
    }
}

#[test]
fn missed_cells_of_a_grid_are_reported_and_decide() {
    // An arch whose left leg ends one cell above the platform: on the floor it comes too late.
    let hook = include_str!("../../boge_objects/object1_S.txt");
    let (outcome, summary, path) = own("floor", hook, Hardware::Fixed, 0.0);
    let missed = summary["missed_cells"].as_u64().unwrap();
    assert!(missed > 0, "{summary}");
    let Outcome::ChecksFailed(failed) = outcome else { panic!("cells are missed") };
    assert!(failed.iter().any(|line| line.contains(&format!(" misses {missed} of 59 cells"))), "{failed:?}");
    assert!(fs::read_to_string(path.join("report.html")).unwrap().contains("class=\"notice\""));
    let (outcome, ..) = own("floor allowed", hook, Hardware::Fixed, 1.0);
    assert_eq!(outcome, Outcome::Done);
    let (_, summary, _) = own("elevated", hook, Hardware::Elevated, 0.0);
    assert_eq!(summary["way_gcfa_missed"], 0);
}

#[test]
fn a_grid_that_is_none_is_named() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("boge").join("bad");
    let folder = OutputFolder::create(&path).unwrap();
    let refused = |file: &Path| {
        let request = Request {
            file: file.to_owned(),
            hardware: Hardware::InHand,
            allow_missed: 0.0,
            threshold: None,
            threads: 1,
        };
        match example::work_on_grid(&request, &Bars::new(true), &folder) {
            Err(failure) => failure.message().to_owned(),
            Ok(_) => panic!("{} was read", file.display()),
        }
    };
    let file = path.join("grid.txt");
    fs::write(&file, "11\n12\n--\n").unwrap();
    let reported = refused(&file);
    assert!(reported.contains("grid.txt: line 2, column 2"), "{reported}");
    assert!(refused(&path.join("none.txt")).contains("none.txt"));
    assert!(refused(&path).contains("is not a regular file"));
    fs::write(&file, "111\n010\n0-0\n").unwrap();
    let reported = refused(&file);
    assert!(reported.ends_with("grid.txt: the platform must be at least two cells wide"), "{reported}");
    fs::write(&file, "--\n00\n\n10\n00\n").unwrap();
    let reported = refused(&file);
    assert!(reported.ends_with("grid.txt: the platform must be at least two cells deep"), "{reported}");
}
