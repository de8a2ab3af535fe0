//! The order that prints best, with support where beads need it.

use super::*;

/// A block is printed by the first order that is tried. A ball that hangs below a beam passes by none of them without support, as cells are missed by all; the
/// one that is nearest to passing is printed, and the report lists what was tried.
#[test]
fn the_order_that_prints_best_is_taken() {
    let scratch = Scratch::new("best");
    let prints = |name: &str, parts: &[[[f32; 3]; 2]], more: &[&str]| {
        let (mesh, out) = (scratch.path(&format!("{name}.stl")), scratch.path(name));
        fs::write(&mesh, boxes(parts)).unwrap();
        let args = ["--mesh", &mesh, "--cell", "2", "--layer-height", "1", "--bead", "1.5", "--out", &out];
        let output = run(&[&args[..], more].concat());
        let report = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned(), report, summary(&out))
    };
    let block = [[[0.0; 3], [10.0, 10.0, 8.0]]];
    let (status, stderr, report, figures) = prints("block", &block, &["--quiet"]);
    assert_eq!(
        (status, &figures["orders_tried"], &figures["layers_by_used"]),
        (Some(0), &"directed".into(), &"directed".into()),
        "{stderr}"
    );
    assert!(figures["of_limits"].as_f64().unwrap() <= 1.0 && report.contains("no other order was tried"));
    let not_tried = |report: &str| report.matches(">not tried<").count();
    assert_eq!(not_tried(&report), 2);

    let hanging = [
        [[0.0; 3], [4.0, 8.0, 28.0]],
        [[20.0, 0.0, 0.0], [24.0, 8.0, 28.0]],
        [[0.0, 0.0, 28.0], [24.0, 8.0, 32.0]],
        [[8.0, 0.0, 10.0], [16.0, 8.0, 28.0]],
    ];
    let (status, stderr, report, figures) = prints("hanging", &hanging, &["--support", "none"]);
    assert_eq!((status, not_tried(&report)), (Some(3), 0), "{stderr}");
    let tried: Vec<&str> = figures["orders_tried"].as_str().unwrap().split(',').collect();
    assert_eq!((tried.len(), tried[0]), (3, figures["layers_by_used"].as_str().unwrap()));
    assert!(figures["of_limits"].as_f64().unwrap() > 1.0);
    assert!(
        stderr.contains("note: layers of --layers-by directed do not pass all checks: trying distance"),
        "{stderr}"
    );
    assert!(report.contains("no print passes all checks, this one is nearest to it"));
    // Each finding is of the order that was taken, once.
    let findings: Vec<&str> =
        figures["findings"].as_str().unwrap().lines().filter(|line| !line.starts_with(' ')).collect();
    let distinct: std::collections::BTreeSet<&&str> = findings.iter().collect();
    assert!(findings.iter().any(|finding| finding.starts_with("failed: ")) && distinct.len() == findings.len());
    documented(&scratch.path("hanging"));

    // What only orders by hulls have, and runs for research, take hulls.
    for more in [&["--strategy", "greedy"][..], &["--nozzle-growth", "off"], &["--coherent"]] {
        let (_, _, _, figures) = prints("block", &block, &[&["--quiet"], more].concat());
        assert_eq!((&figures["layers_by"], figures.get("orders_tried")), (&"hull".into(), None), "{more:?}");
    }
}

/// A lid over a recess: level beads over it lie on nothing. Support below them, up to the lid, lets the same order pass, and can be saved and gone on with.
#[test]
fn unsupported_beads_get_support() {
    let scratch = Scratch::new("recess");
    let mesh = scratch.path("lid.stl");
    let walls = [[[0.0; 3], [4.0, 24.0, 2.5]], [[20.0, 0.0, 0.0], [24.0, 24.0, 2.5]]];
    let others = [[[4.0, 0.0, 0.0], [20.0, 4.0, 2.5]], [[4.0, 20.0, 0.0], [20.0, 24.0, 2.5]]];
    let lid = [[[0.0, 0.0, 2.5], [24.0, 24.0, 6.0]]];
    fs::write(&mesh, boxes(&[&walls[..], &others, &lid].concat())).unwrap();
    let prints = |name: &str, more: &[&str]| {
        let out = scratch.path(name);
        let args = ["--mesh", &mesh, "--cell", "1.2", "--layer-height", "0.5", "--bead", "0.8", "--out", &out];
        let output = run(&[&args[..], &["--layers-by", "directed"], more].concat());
        let report = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned(), report, summary(&out))
    };
    let number = |figures: &Value, key: &str| figures[key].as_f64().unwrap();
    let (status, stderr, _, bare) = prints("bare", &["--support", "none", "--quiet"]);
    assert_eq!((status, number(&bare, "support_below_beads_cells")), (Some(3), 0.0), "{stderr}");
    assert!(number(&bare, "unsupported_share") > 0.005, "{bare}");

    let (status, stderr, report, held) = prints("held", &[]);
    assert_eq!(status, Some(0), "{stderr}");
    assert!(stderr.contains("note: too many beads are unsupported: adding support below them"), "{stderr}");
    assert!(report.contains("with support below its beads"));
    assert!(number(&held, "unsupported_share") < 0.2 * number(&bare, "unsupported_share"), "{held}");
    // The recess is full, to within a bead of its walls.
    let recess_mm3 = 16.0 * 16.0 * 2.5;
    let support_mm3 = number(&held, "support_volume_mm3");
    assert!(support_mm3 > 0.6 * recess_mm3 && support_mm3 < 1.15 * recess_mm3, "{support_mm3}");
    assert!((number(&held, "filled_share") - 1.0).abs() < 0.03, "{held}");
    documented(&scratch.path("held"));

    let field = Path::new(&scratch.path("held")).join("field.txt").display().to_string();
    let again = scratch.path("again");
    run(&[
        "--mesh",
        &mesh,
        "--resume",
        &field,
        "--layer-height",
        "0.5",
        "--stage",
        "surfaces",
        "--quiet",
        "--out",
        &again,
    ]);
    let resumed = summary(&again);
    for key in ["support_cells", "support_cells_volume_mm3", "support_volume_mm3", "surfaces"] {
        assert_eq!(resumed[key], held[key], "{key}");
    }
}
