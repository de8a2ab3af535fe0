//! The cells and their order, and a saved field.

use super::*;

#[test]
fn every_strategy_writes_the_same_kind_of_results() {
    let scratch = Scratch::new("strategies");
    let mesh = scratch.path("arch.stl");
    fs::write(&mesh, boxes(&[[[0.0, 0.0, 0.0], [4.0, 6.0, 20.0]], [[4.0, 0.0, 14.0], [20.0, 6.0, 20.0]]])).unwrap();
    for strategy in ["best", "greedy", "incremental", "adaptive", "governed", "unbuild"] {
        let out = scratch.path(strategy);
        let common = ["--mesh", &mesh, "--cell", "1", "--stage", "surfaces", "--allow-missed", "0.3"];
        let common = [&common[..], &["--out", &out, "--threads", "1"]].concat();
        let output = run(&[&common[..], &["--strategy", strategy]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let summary = summary(&out);
        assert_eq!(summary["cells"], 4 * 6 * 20 + 16 * 6 * 6, "{strategy}");
        assert_eq!(
            (&summary["audit_ok"], &summary["strategy"], &summary["mesh"]),
            (&true.into(), &strategy.into(), &"arch.stl".into())
        );
        assert_eq!(summary["volume_mm3"].as_f64().map(f64::round), Some(1056.0));
        let reasons = ["missed_shadowed", "missed_out_of_reach", "missed_unsupported"];
        let by_reason: u64 = reasons.iter().map(|reason| summary[reason].as_u64().unwrap()).sum();
        assert_eq!(summary["missed_cells"].as_u64().unwrap(), by_reason);
        let field = fs::read_to_string(Path::new(&out).join("field.csv")).unwrap();
        let column = |at: usize| -> Vec<u64> {
            let number = |text: &str| if text.is_empty() { 0 } else { text.parse().unwrap() };
            field.lines().skip(1).map(|line| number(line.split(',').nth(at).unwrap())).collect()
        };
        // The layer of the growth, and the layer that is printed.
        let (layers, printed) = (column(6), column(7));
        assert!(field.starts_with("x,y,z,x_mm,y_mm,z_mm,cell_layer,layer,nx,ny,nz\n"));
        assert_eq!(layers.len() as u64, summary["cells"].as_u64().unwrap());
        assert_eq!(layers.iter().max().copied(), summary["cell_layers"].as_u64());
        assert!(printed.iter().max().copied() <= summary["surfaces"].as_u64());
        assert!(layers.iter().zip(&printed).all(|(layer, printed)| (*layer == 0) == (*printed == 0)));
        assert_eq!(
            layers.iter().filter(|&&layer| layer == 0).count() as u64,
            summary["missed_cells"].as_u64().unwrap()
        );
        let report = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
        assert_eq!(report.matches("data:image/png;base64,").count(), 4 + 5 + 3 + 1);
    }
}

/// A cube of 20 mm in 1210 cells: 11 x 11 x 10 of them, in a grid that begins half a cell before it. What is saved there is taken again;
/// a grid at another height is not, nor is what is no file.
#[test]
fn a_field_in_a_grid_that_was_moved_is_taken_again() {
    let scratch = Scratch::new("moved");
    let mesh = scratch.path("cube.obj");
    let cube = "v 0 0 0\nv 20 0 0\nv 20 20 0\nv 0 20 0\nv 0 0 20\nv 20 0 20\nv 20 20 20\nv 0 20 20\n\
                f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    fs::write(&mesh, cube).unwrap();
    let (first, second) = (scratch.path("first"), scratch.path("second"));
    let run_in = |out: &str, more: &[&str]| {
        run(&[&["--mesh", &mesh, "--stage", "surfaces", "--quiet", "--out", out], more].concat())
    };
    let output = run_in(&first, &["--voxels", "1210"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let file = Path::new(&first).join("field.txt");
    let (text, saved) = (fs::read_to_string(&file).unwrap(), file.display().to_string());
    let origin = text.lines().find(|line| line.starts_with("origin_mm")).unwrap();
    assert!(origin.starts_with("origin_mm -"), "{origin}: the grid was not moved");
    let output = run_in(&second, &["--resume", &saved]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(fs::read_to_string(Path::new(&second).join("field.txt")).unwrap(), text);

    let third = scratch.path("third");
    let higher = origin.rsplit_once(' ').unwrap().0.to_owned() + " 1";
    fs::write(&file, text.replace(origin, &higher)).unwrap();
    let (status, line) = status_and_line(&run_in(&third, &["--resume", &saved]));
    assert!(status == 1 && line.contains(&higher), "{status} {line}");
    let (status, line) = status_and_line(&run_in(&third, &["--resume", &first]));
    assert!(status == 1 && line.contains("is not a file"), "{status} {line}");
}

/// `best` builds the same order at every stage, and counts all the time that it takes to choose.
#[test]
fn the_order_is_the_same_at_every_stage() {
    let scratch = Scratch::new("stages");
    let mesh = scratch.path("hooks.stl");
    // A post with a beam from which a hook hangs that no order reaches.
    let blocks = [
        [[0.0, 0.0, 0.0], [6.0, 6.0, 24.0]],
        [[6.0, 0.0, 18.0], [24.0, 6.0, 24.0]],
        [[20.0, 0.0, 3.0], [24.0, 6.0, 18.0]],
    ];
    fs::write(&mesh, boxes(&blocks)).unwrap();
    let mut orders = Vec::new();
    for stage in ["field", "surfaces"] {
        let out = scratch.path(stage);
        let args = ["--mesh", &mesh, "--cell", "1", "--eps", "0.5", "--stage", stage, "--quiet", "--out", &out];
        run(&[&args[..], &HULLS_ALONE].concat());
        let figures = summary(&out);
        assert!(figures["missed_cells"].as_u64().unwrap() > 0, "there is nothing to choose");
        let figure = |key: &str| figures[key].as_f64().unwrap();
        assert!(figure("total_s") > figure("grow_s") + figure("audit_s") + figure("voxelise_s"));
        // All columns but one: the layers that are printed are not known at stage `field`.
        let field = fs::read_to_string(Path::new(&out).join("field.csv")).unwrap();
        let field: Vec<String> = field.lines().map(without_layer).collect();
        orders.push((figures["strategy_used"].clone(), figures["missed_cells"].clone(), field));
    }
    assert!(orders[0] == orders[1], "{:?} {:?}", orders[0].0, orders[1].0);
}

/// A line of `field.csv` without the layer that is printed.
fn without_layer(line: &str) -> String {
    let columns: Vec<&str> = line.split(',').collect();
    [&columns[..7], &columns[8..]].concat().join(",")
}

/// A block hangs from the end of an arm: its lower cells cannot be built, and the file holds the proof, which can be checked with
/// nothing but the file.
#[test]
fn impossible_cells_come_with_proofs() {
    let scratch = Scratch::new("impossible");
    let (mesh, out) = (scratch.path("gallows.stl"), scratch.path("out"));
    let parts =
        [[[0.0; 3], [4.0, 4.0, 24.0]], [[4.0, 0.0, 20.0], [24.0, 4.0, 24.0]], [[20.0, 0.0, 4.0], [24.0, 4.0, 20.0]]];
    fs::write(&mesh, boxes(&parts)).unwrap();
    let args = ["--mesh", &mesh, "--cell", "2", "--stage", "field", "--quiet", "--out", &out];
    let output = run(&[&args[..], &HULLS_ALONE].concat());
    assert_eq!(output.status.code(), Some(3));
    let figures = summary(&out);
    let count = |key: &str| figures[key].as_u64().unwrap();
    assert_eq!(count("impossible_cells") + count("undecided_cells"), count("missed_cells"));
    assert!(count("impossible_cells") > 10 && figures["proofs_ok"] == true, "{figures}");
    documented(&out);
    let cells = |list: &str| -> Vec<[u32; 3]> {
        let place = |place: &str| -> [u32; 3] {
            place.split(' ').map(|k| k.parse().unwrap()).collect::<Vec<u32>>().try_into().unwrap()
        };
        list.split(';').filter(|place| !place.is_empty()).map(place).collect()
    };
    let text = fs::read_to_string(Path::new(&out).join("impossible.csv")).unwrap();
    let lines: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len() as u64, count("impossible_cells"));
    let mut walled = 0;
    for line in lines {
        let at: Vec<u32> = line[..3].iter().map(|k| k.parse().unwrap()).collect();
        let wall = cells(line[7]);
        walled += usize::from(!wall.is_empty());
        // The block hangs at x 10 and 11; all chains come along the arm, and what shuts a cell off is above it.
        assert!(at[0] >= 9 && at[2] < 10, "{line:?}");
        assert!(wall.iter().all(|cell| cell[2] >= at[2]), "{line:?}");
    }
    assert!(walled > 0, "{text}");
}

/// A saved field that claims to be thicker than it has cells asks for surfaces without end.
#[test]
fn a_saved_field_must_be_one() {
    let scratch = Scratch::new("resume");
    let (mesh, out) = (scratch.path("block.stl"), scratch.path("out"));
    fs::write(&mesh, boxes(&[[[0.0; 3], [8.0, 6.0, 4.0]]])).unwrap();
    let output = run(&["--mesh", &mesh, "--cell", "2", "--stage", "surfaces", "--quiet", "--out", &out]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(Path::new(&out).join("field.txt")).unwrap();
    let last = text.lines().rev().nth(1).unwrap();
    let far = format!("{} 1e15", last.split_once(' ').unwrap().0);
    let thick = text.lines().find(|line| line.starts_with("layer_cells")).unwrap();
    for (from, to) in [(last, &far[..]), (thick, "layer_cells 1e9")] {
        let file = scratch.path("bad.txt");
        fs::write(&file, text.replace(from, to)).unwrap();
        let (status, line) =
            status_and_line(&run(&["--mesh", &mesh, "--resume", &file, "--quiet", "--out", &scratch.path("bad")]));
        assert!(status == 1 && line.contains("no part of 24 cells is as high"), "{status} {line}");
    }
    let endless = Path::new("/dev/zero");
    if endless.exists() {
        let (status, line) = status_and_line(&run(&["--mesh", &mesh, "--resume", "/dev/zero", "--out", &out]));
        assert!(status == 1 && line.contains("is not a file"), "{status} {line}");
    }
}

/// Directions turn over the posts of a bridge: there half layers lie between the layers, and a saved field gives the same ones again.
#[test]
fn half_layers_are_made_again_from_a_field() {
    let scratch = Scratch::new("half-layers");
    let (mesh, out, again) = (scratch.path("bridge.stl"), scratch.path("out"), scratch.path("again"));
    let parts =
        [[[0.0; 3], [6.0, 8.0, 20.0]], [[40.0, 0.0, 0.0], [46.0, 8.0, 20.0]], [[0.0, 0.0, 20.0], [46.0, 8.0, 30.0]]];
    fs::write(&mesh, boxes(&parts)).unwrap();
    let args = ["--mesh", &mesh, "--quiet", "--stage", "surfaces", "--allow-missed", "0.1"];
    let run = |more: &[&str]| {
        let output = run(&[&args[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    };
    run(&["--cell", "2", "--support", "none", "--layers-by", "directed", "--out", &out]);
    let field = fs::read_to_string(Path::new(&out).join("field.txt")).unwrap();
    assert!(field.contains("\nhalf_layers 1.45\ncells "));
    let without = scratch.path("without.txt");
    fs::write(&without, field.replace("half_layers 1.45\n", "")).unwrap();
    run(&["--resume", &Path::new(&out).join("field.txt").display().to_string(), "--out", &again]);
    run(&["--resume", &without, "--out", &scratch.path("plain")]);
    let surfaces = |folder: &str| fs::read(Path::new(folder).join("layers.obj")).unwrap();
    assert!(surfaces(&out) == surfaces(&again));
    let count = |folder: &str, key: &str| summary(folder)[key].as_u64().unwrap();
    let halves = count(&out, "half_layers");
    assert!(halves > 0 && count(&out, "surfaces") == count(&scratch.path("plain"), "surfaces") + halves, "{halves}");
    let report = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
    assert!(report.contains(&format!(" and {halves} half layer")));
}

/// A block that floats beside another one stands on support, which is marked as such in every file. A saved field holds it, too.
#[test]
fn what_floats_stands_on_support() {
    let scratch = Scratch::new("stands");
    let mesh = scratch.path("floating.stl");
    fs::write(&mesh, boxes(&[[[0.0; 3], [10.0, 10.0, 10.0]], [[20.0, 0.0, 6.0], [28.0, 10.0, 10.0]]])).unwrap();
    let out = scratch.path("out");
    let output = run(&["--mesh", &mesh, "--cell", "2", "--quiet", "--out", &out]);
    let (stderr, notices) = said(&output, &out);
    documented(&out);
    let figures = summary(&out);
    let count = |figures: &Value, key: &str| figures[key].as_u64().unwrap();
    assert_eq!((count(&figures, "missed_cells"), count(&figures, "missed_by_hull_cells")), (0, 40), "{stderr}");
    // Two levels of 3 by 3 cells, and one that touches the block.
    assert_eq!((count(&figures, "support_cells"), count(&figures, "support_straight_cells")), (19, 60));
    assert!((figures["support_volume_mm3"].as_f64().unwrap() - 19.0 * 8.0).abs() < 0.1 * 19.0 * 8.0, "{figures}");
    assert!((figures["filled_share"].as_f64().unwrap() - 1.0).abs() < 0.1, "{figures}");
    assert!(notices.iter().any(|notice| notice.contains("the part stands on support")), "{notices:?}");
    let text = |folder: &str, name: &str| fs::read_to_string(Path::new(folder).join(name)).unwrap();
    let gcode = text(&out, "toolpath.gcode");
    assert!(gcode.contains(";TYPE:Support material\n"), "{gcode}");
    // Beads of the support lie under the block, and nowhere else.
    let mut is_support = false;
    for line in
        gcode.lines().filter(|line| line.starts_with(";TYPE:") || (line.starts_with("G1") && line.contains(" E")))
    {
        match line.strip_prefix(";TYPE:") {
            Some(kind) => is_support = kind == "Support material",
            None => {
                let word =
                    |letter: char| line.split(' ').find_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok());
                let (Some(x), Some(z)) = (word('X'), word('Z')) else { continue };
                assert!(!is_support || (x > 19.0 && x < 29.0 && z < 7.0), "{line}");
            }
        }
    }
    let groups =
        |folder: &str| text(folder, "layers.obj").lines().filter(|line| line.starts_with("g support_")).count();
    // Six millimetres of support, in layers that bend towards the block.
    assert_eq!(groups(&out), 4);

    let (again, field) = (scratch.path("again"), Path::new(&out).join("field.txt").display().to_string());
    run(&["--mesh", &mesh, "--resume", &field, "--quiet", "--stage", "surfaces", "--out", &again]);
    let resumed = summary(&again);
    assert_eq!((count(&resumed, "missed_cells"), count(&resumed, "support_cells")), (0, 19));
    assert_eq!((groups(&again), resumed["audit_ok"].as_bool()), (4, Some(true)));
}

/// A field by itself takes less memory than surfaces do; the best strategy makes surfaces to choose.
#[test]
fn memory_is_estimated_for_the_stage() {
    let scratch = Scratch::new("memory");
    let out = scratch.path("out");
    for (gigabytes, more, is_refused) in [
        ("0.002", &["--stage", "field", "--strategy", "unbuild"][..], false),
        ("0.002", &["--stage", "surfaces", "--strategy", "unbuild"], true),
        ("0.002", &["--stage", "field"], true),
        ("0.0001", &["--stage", "field", "--strategy", "unbuild"], true),
    ] {
        let args = ["--voxels", "2000", "--max-memory", gigabytes, "--quiet", "--out", &out];
        let output = run(&[&args[..], more].concat());
        assert_eq!(output.status.code() == Some(1), is_refused, "{gigabytes} {more:?}");
        assert!(!is_refused || status_and_line(&output).1.contains("would fit"), "{gigabytes} {more:?}");
    }
}
