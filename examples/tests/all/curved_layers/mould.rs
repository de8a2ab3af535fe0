//! Parts that are printed on another one.

use super::*;

/// On a block that stands there: the part begins at its top, and hangs out beyond its edge.
#[test]
fn a_part_is_printed_on_another() {
    let scratch = Scratch::new("on");
    let [mesh, block, out, again] = ["part.stl", "block.stl", "out", "again"].map(|name| scratch.path(name));
    fs::write(&block, boxes(&[[[0.0; 3], [20.0, 20.0, 7.0]]])).unwrap();
    fs::write(&mesh, boxes(&[[[4.0, 5.0, 7.0], [22.0, 15.0, 13.0]]])).unwrap();
    let of_part = ["--mesh", &mesh, "--on", &block, "--layer-height", "1", "--bead", "1", "--quiet"];
    let output = run(&[&of_part[..], &["--cell", "1", "--out", &out]].concat());
    let (stderr, _) = said(&output, &out);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains("printed on block.stl (it stands at x 0.00 to 20.00, y 0.00 to 20.00"), "{stderr}");
    documented(&out);
    let figures = summary(&out);
    let number = |figures: &Value, key: &str| figures[key].as_f64().unwrap();
    assert_eq!((figures["on"].as_str(), number(&figures, "buried_mm3")), (Some("block.stl"), 0.0));
    assert_eq!((number(&figures, "missed_cells"), number(&figures, "surfaces")), (0.0, 6.0));
    assert!((number(&figures, "filled_share") - 1.0).abs() < 0.03, "{figures}");
    // Half of a bead beyond the edge hangs there; two millimetres of each layer do.
    assert!(number(&figures, "unsupported_share") < 0.02, "{figures}");
    let gcode = fs::read_to_string(Path::new(&out).join("toolpath.gcode")).unwrap();
    let word =
        |line: &str, letter: char| line.split(' ').find_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok());
    let printed = gcode.lines().filter(|line| line.starts_with("G1") && line.contains(" E"));
    let places: Vec<[f64; 2]> = printed.filter_map(|line| Some([word(line, 'X')?, word(line, 'Z')?])).collect();
    let lowest = |from: f64, to: f64| {
        let within = places.iter().filter(|[x, _]| (from..to).contains(x)).map(|[_, z]| *z);
        within.fold(f64::INFINITY, f64::min)
    };
    // On the block a layer up, and lower beyond its edge, where layers lean.
    assert!((lowest(0.0, 17.0) - 8.0).abs() < 0.1 && lowest(20.0, 22.0) < 8.0, "{places:?}");

    // A saved field is gone on with on the same block, and not without it.
    let field = Path::new(&out).join("field.txt").display().to_string();
    let resumed = |more: &[&str]| {
        let of_field = ["--mesh", &mesh, "--resume", &field, "--stage", "surfaces", "--quiet", "--out", &again];
        run(&[&of_field[..], more].concat())
    };
    let (status, line) = status_and_line(&resumed(&[]));
    assert_eq!(status, 1, "{line}");
    let (status, line) = status_and_line(&resumed(&["--on", &block]));
    assert_eq!((status, &summary(&again)["missed_cells"]), (0, &Value::from(0)), "{line}");
    assert_eq!(fs::read(&field).unwrap(), fs::read(Path::new(&again).join("field.txt")).unwrap());
}

/// A robot prints over a block without touching it.
#[test]
fn a_robot_prints_on_a_block() {
    let scratch = Scratch::new("robot-on");
    let [mesh, block, out] = ["part.stl", "block.stl", "out"].map(|name| scratch.path(name));
    fs::write(&block, boxes(&[[[0.0; 3], [24.0, 24.0, 8.0]]])).unwrap();
    fs::write(&mesh, boxes(&[[[8.0, 8.0, 8.0], [16.0, 16.0, 12.0]]])).unwrap();
    let motion = ["--stage", "motion", "--cell", "2", "--quiet", "--out", &out];
    let output = run(&[&["--mesh", &mesh, "--on", &block], &motion[..]].concat());
    let figures = summary(&out);
    let (stderr, count) = (String::from_utf8_lossy(&output.stderr), |key: &str| figures[key].as_u64().unwrap());
    assert_eq!((output.status.code(), count("findings_failed")), (Some(0), 0), "{stderr}");
    assert!(count("motions") > 0 && figures["layers_by_used"] == "directed", "{figures}");
}

#[test]
fn what_it_is_printed_on_must_fit() {
    let scratch = Scratch::new("bad-on");
    let [block, inside, aside, apart] =
        ["block.stl", "inside.stl", "aside.stl", "apart.stl"].map(|name| scratch.path(name));
    fs::write(&block, boxes(&[[[0.0; 3], [20.0, 20.0, 7.0]]])).unwrap();
    fs::write(&inside, boxes(&[[[4.0, 4.0, 2.0], [10.0, 10.0, 6.0]]])).unwrap();
    fs::write(&aside, boxes(&[[[4.0, 4.0, 9.0], [10.0, 10.0, 15.0]]])).unwrap();
    fs::write(&apart, boxes(&[[[4.0, 4.0, 3.0], [10.0, 10.0, 11.0]]])).unwrap();
    let on = |mesh: &str, more: &[&str]| {
        let out = scratch.path("out");
        let all =
            [&["--mesh", mesh, "--on", &block, "--cell", "1", "--stage", "field", "--quiet", "--out", &out], more];
        run(&all.concat())
    };
    for (mesh, more, status, word) in [
        (&inside, &[][..], 1, "block.stl: the part lies inside it: both files must have the same origin"),
        (&aside, &[][..], 1, "no cell stands on the platform"),
        (&aside, &["--orient", "best"][..], 2, "--orient best does not go with --on"),
    ] {
        let (found, line) = status_and_line(&on(mesh, more));
        assert!(found == status && line.contains(word), "{mesh}: {found} {line}");
    }
    // What lies in the block is not printed, and reported.
    let output = on(&apart, &[]);
    let (stderr, figures) = (String::from_utf8_lossy(&output.stderr), summary(&scratch.path("out")));
    assert!(output.status.code() == Some(0) && stderr.contains("reaches more than a cell into block.stl"), "{stderr}");
    let buried = figures["buried_mm3"].as_f64().unwrap();
    assert!((buried - 36.0 * 3.0).abs() < 1e-6 && figures["part_volume_mm3"].as_f64().unwrap() < 181.0, "{buried}");
}
