//! The machine file: gouging, support, volume, directions.

use super::*;
use curvlay_examples::axis_program::axes_of;
use curvlay_examples::five_axis::FiveAxisPrinter;
use curvlay_toolpath::gcode::flavour::{
    AxisMove, AxisReader, Direction, Flavour, FlavourReadOptions, FlavourReader, MachineAxis,
};

/// The machine file says directions as it is asked to; by default no firmware can mistake them.
#[test]
fn directions_are_written_as_asked_for() {
    let scratch = Scratch::new("dialect");
    let mesh = scratch.path("block.stl");
    fs::write(&mesh, boxes(&[[[0.0; 3], [8.0, 6.0, 4.0]]])).unwrap();
    let mut files = Vec::new();
    for (more, words, name) in [
        (&[][..], gcode::DirectionWords::Comment, "comment"),
        (&["--dialect", "ijk"], gcode::DirectionWords::Ijk, "ijk"),
        (&["--dialect", "dissertation"], gcode::DirectionWords::Dissertation, "dissertation"),
    ] {
        let out = scratch.path(name);
        let output = run(&[&["--mesh", &mesh, "--cell", "1", "--quiet", "--out", &out][..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(summary(&out)["dialect"], name);
        let file = fs::File::open(Path::new(&out).join("toolpath.gcode")).unwrap();
        let options = ReadOptions { dialect: gcode::Dialect::Part(words), ..ReadOptions::default() };
        let moves = GcodeReader::new(BufReader::new(file), options).unwrap().collect::<Result<Vec<_>, _>>().unwrap();
        files.push(moves);
    }
    assert!(files[0].len() > 20 && files[0] == files[1] && files[0] == files[2]);
}

/// The machine file in the flavour of a controller, by name, from its own `flavour.json`, and from a profile beside it; what does not go is one line.
#[test]
fn machine_files_have_the_flavour_of_a_controller() {
    let scratch = Scratch::new("flavour");
    let mesh = scratch.path("block 1.stl");
    fs::write(&mesh, boxes(&[[[0.0; 3], [8.0, 6.0, 4.0]]])).unwrap();
    let printed = |out: &str, more: &[&str]| {
        let output = run(&[&["--mesh", &mesh, "--cell", "1", "--quiet", "--out", out][..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        fs::read_to_string(Path::new(out).join("toolpath.gcode")).unwrap()
    };
    let plain = printed(&scratch.path("plain"), &[]);
    let plain = GcodeReader::new(plain.as_bytes(), ReadOptions::default()).unwrap();
    let plain: Vec<gcode::Move> = plain.collect::<Result<_, _>>().unwrap();
    let mut ends = Vec::new();
    for name in ["siemens", "heidenhain", "klipper", "marlin"] {
        let out = scratch.path(name);
        let file = printed(&out, &["--flavour", name]);
        assert_eq!(summary(&out)["flavour"], name);
        let flavour = fs::read_to_string(Path::new(&out).join("flavour.json")).unwrap();
        let flavour: Flavour = serde_json::from_str(&flavour).unwrap();
        assert_eq!(Some(&flavour), Flavour::built_in(name).as_ref());
        let moves = FlavourReader::new(file.as_bytes(), &flavour, FlavourReadOptions::default()).unwrap();
        let moves: Vec<gcode::Move> = moves.collect::<Result<_, _>>().unwrap();
        let tips = |moves: &[gcode::Move]| -> Vec<Point3<f64>> {
            let tip = |item: &gcode::Move| match *item {
                gcode::Move::Travel { tip, .. } | gcode::Move::Print { tip, .. } => Some(tip),
                _ => None,
            };
            moves.iter().filter_map(tip).collect()
        };
        let (ours, theirs) = (tips(&plain), tips(&moves));
        assert!(ours.len() > 20 && ours.len() == theirs.len());
        assert!(ours.iter().zip(&theirs).all(|(a, b)| (a - b).norm() < 2e-4), "{name}");
        ends.push(file);
    }
    assert!(ends[1].starts_with("0 BEGIN PGM block_1 MM\r\n"), "{}", &ends[1][..80]);
    // The flavour that a run leaves is a file of one; so is it in a profile, from its own folder.
    let mine = Path::new(&scratch.path("siemens")).join("flavour.json").display().to_string();
    assert_eq!(printed(&scratch.path("mine"), &["--flavour", &mine]), ends[0]);
    let profile = scratch.path("profile.json");
    fs::write(&profile, r#"{"flavour": "siemens/flavour.json", "start_gcode": ["M77"]}"#).unwrap();
    assert!(printed(&scratch.path("profile"), &["--profile", &profile]).contains("\nN10 M77\n"));
    let changed = fs::read_to_string(&mine).unwrap().replace("\"max_length\": 512", "\"max_length\": 5");
    let bad = scratch.path("bad.json");
    fs::write(&bad, changed).unwrap();
    let unknown = scratch.path("unknown.json");
    fs::write(&unknown, "{\"nam\": 1}").unwrap();
    for (more, status, words) in [
        (&["--flavour", "linuxcnc"][..], 2, "the flavour `linuxcnc` takes moves of a machine's axes"),
        (&["--flavour", "fanuc"], 2, "`fanuc` is no G-code flavour: there are linuxcnc, "),
        (&["--flavour", "no-such.json"], 1, "no-such.json"),
        (&["--flavour", &bad], 1, "`lines.max_length`: 5 is not from 32 to 16384"),
        (&["--flavour", &unknown], 1, "unknown field `nam`"),
        (&["--flavour", "siemens", "--dialect", "ijk"], 2, "--dialect does nothing in the flavour `siemens`"),
        (&["--flavour", "siemens", "--line-numbers"], 2, "--line-numbers does nothing in the flavour `siemens`"),
    ] {
        let out = scratch.path("none");
        let output = run(&[&["--mesh", &mesh, "--cell", "1", "--quiet", "--out", &out][..], more].concat());
        let (found, line) = status_and_line(&output);
        assert!(found == status && line.contains(words), "{more:?}: {found} {line}");
        assert_eq!(String::from_utf8_lossy(&output.stderr).lines().count(), 1, "{more:?}");
        assert!(!Path::new(&out).exists());
    }
}

/// The beads that the page on machine files shows are those of the golden programs; it shows all flavours that the command takes.
#[test]
fn the_page_on_machine_files_shows_each_flavour() {
    let page = common::formats(Some("machine-files.md"));
    let of_part: Vec<&str> = Flavour::names()
        .iter()
        .copied()
        .filter(|name| Flavour::built_in(name).is_some_and(|flavour| flavour.direction != Direction::Axes))
        .collect();
    for name in &of_part {
        let row = page.lines().find(|line| line.starts_with(&format!("| `{name}` |"))).unwrap();
        let bead = row.split('`').nth(3).unwrap();
        let golden = format!("../toolpath/tests/golden/flavours/{name}.ngc");
        let golden = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(golden)).unwrap();
        assert!(golden.lines().any(|line| line == bead), "{name}: {bead}");
    }
    assert_eq!(of_part, ["klipper", "marlin", "siemens", "heidenhain"]);
}

/// Bug: 19 waypoints that gouge, pieces that are left out and a turn of 119 degrees ended with status 0 and no word. Of a post with an
/// arm that is printed sideways a block of 400 mm reaches into the plate.
#[test]
fn gouging_is_reported_and_options_decide_the_status() {
    let scratch = Scratch::new("gouging");
    let mesh = scratch.path("ell.stl");
    fs::write(&mesh, boxes(&[[[0.0; 3], [12.0, 12.0, 36.0]], [[12.0, 0.0, 24.0], [36.0, 12.0, 36.0]]])).unwrap();
    let printed = |name: &str, more: &[&str]| {
        let out = scratch.path(name);
        let args = ["--mesh", &mesh, "--cell", "4", "--nozzle", "1,45,2,400", "--quiet", "--out", &out];
        let output = run(&[&args[..], more].concat());
        let (stderr, notices) = said(&output, &out);
        (output.status.code(), stderr, notices, summary(&out))
    };
    let (status, stderr, notices, figures) = printed("strict", &[]);
    let [gouging, left_out] = ["gouging_waypoints", "left_out_pieces"].map(|key| figures[key].as_u64().unwrap());
    assert!(gouging + left_out > 0 && status == Some(3), "{stderr}");
    let words = [(gouging, "the nozzle collides with the part or the plate"), (left_out, "out of the nozzle")];
    for (_, words) in words.iter().filter(|(count, _)| *count > 0) {
        let said = |text: &str| text.contains(words);
        assert!(stderr.lines().any(|line| line.starts_with("check failed: ") && said(line)), "{stderr}");
        assert!(notices.iter().any(|notice| notice.starts_with("Check failed: ") && said(notice)));
    }
    let all = ["--allow-gouging", "1", "--allow-left-out", "1", "--allow-volume", "1", "--allow-unsupported", "1"];
    let (status, stderr, notices, figures) = printed("lenient", &all);
    let blocked = figures["blocked_travels"].as_u64().unwrap() > 0;
    assert_eq!(status, Some(if blocked { 3 } else { 0 }), "{stderr}");
    for (_, words) in words.iter().filter(|(count, _)| *count > 0) {
        assert!(stderr.lines().any(|line| line.starts_with("warning: ") && line.contains(words)), "{stderr}");
        assert!(notices.iter().any(|notice| notice.contains(words)));
    }
}

/// Of a table with four legs the top hangs between them. One layer height is asked for, so a bead aside of those below is on nothing.
#[test]
fn unsupported_beads_are_reported_and_options_decide_the_status() {
    let scratch = Scratch::new("support");
    let mesh = scratch.path("stool.stl");
    let leg = |x: f32, y: f32| [[x, y, 0.0], [x + 8.0, y + 8.0, 12.0]];
    let top = [[0.0, 0.0, 12.0], [32.0, 32.0, 20.0]];
    fs::write(&mesh, boxes(&[leg(0.0, 0.0), leg(24.0, 0.0), leg(0.0, 24.0), leg(24.0, 24.0), top])).unwrap();
    let printed = |name: &str, more: &[&str]| {
        let out = scratch.path(name);
        let all = ["--allow-missed", "1", "--allow-volume", "1", "--allow-gouging", "1", "--allow-left-out", "1"];
        let args = ["--mesh", &mesh, "--cell", "2", "--support-distance", "1", "--quiet", "--out", &out];
        let output = run(&[&args[..], &all, more].concat());
        let (stderr, notices) = said(&output, &out);
        let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
        (output.status.code(), stderr + &stdout, notices, out)
    };
    let words = "unsupported beads";
    let lenient = ["--allow-unsupported", "1", "--allow-unsupported-beads", "1000"];
    let (status, stderr, _, out) = printed("reported", &lenient);
    assert!(status == Some(0) && stderr.contains(&format!("warning: {words}")), "{stderr}");
    // Its share stands beside what is said of the checks. What is tried already is no advice.
    let share = summary(&out)["unsupported_share"].as_f64().unwrap();
    assert!(stderr.contains(&format!("; {:.2} % of the bead length is unsupported", 100.0 * share)), "{stderr}");
    assert!(
        stderr.contains("none failed (order of the cells; surfaces; paths; nozzle, travels and beads)"),
        "{stderr}"
    );
    let advice = |text: &str| {
        let of = text.lines().skip_while(|line| !line.contains(words)).take_while(|line| !line.contains("accept:"));
        of.collect::<Vec<_>>().join("\n")
    };
    assert!(advice(&stderr).ends_with("try: --layers-by best; --orient best"), "{stderr}");
    let (_, without, ..) = printed("none", &["--support", "none"]);
    assert!(advice(&without).contains("try: --layers-by best; --support auto; --orient best"), "{without}");
    let (_, by_distance, ..) = printed("distance", &["--layers-by", "distance"]);
    assert!(advice(&by_distance).ends_with("try: --orient best"), "{by_distance}");
    documented(&out);
    let figures = summary(&out);
    let figure = |key: &str| figures[key].as_f64().unwrap();
    let list = fs::read_to_string(Path::new(&out).join("unsupported.csv")).unwrap();
    let lengths = list.lines().skip(1).map(|line| line.split(',').nth(4).unwrap().parse::<f64>().unwrap());
    assert_eq!(lengths.clone().count() as u64, figures["unsupported_pieces"].as_u64().unwrap());
    assert!((lengths.clone().sum::<f64>() - figure("unsupported_mm")).abs() < 1e-3 * figure("unsupported_pieces"));
    assert!((lengths.fold(0.0, f64::max) - figure("unsupported_longest_mm")).abs() < 1e-3);
    // Those that are held at both ends are listed apart.
    let spans = fs::read_to_string(Path::new(&out).join("spans.csv")).unwrap();
    assert_eq!(spans.lines().skip(1).count() as u64, figures["spans"].as_u64().unwrap());
    assert!(stderr.contains("warning: beads span gaps, straight and held at both ends: "), "{stderr}");
    for [share, beads] in [["0", "1000"], ["1", "0"]] {
        let limits = ["--allow-unsupported", share, "--allow-unsupported-beads", beads];
        let (status, stderr, notices, _) = printed("strict", &limits);
        assert!(status == Some(3) && stderr.contains(&format!("check failed: {words}")), "{stderr}");
        assert!(notices.iter().any(|notice| notice.starts_with("Check failed: ") && notice.contains(words)));
    }
}

/// Bug: a comb of thin walls was laid to a third with status 0. What is laid is compared with the mesh, of which overlaps count once.
#[test]
fn what_is_laid_is_compared_with_the_part() {
    let scratch = Scratch::new("filled");
    let printed = |name: &str, parts: &[[[f32; 3]; 2]], status: i32| {
        let (mesh, out) = (scratch.path(&format!("{name}.stl")), scratch.path(name));
        fs::write(&mesh, boxes(parts)).unwrap();
        let output = run(&["--mesh", &mesh, "--cell", "1", "--quiet", "--out", &out]);
        let (stderr, _) = said(&output, &out);
        assert_eq!(output.status.code(), Some(status), "{name}: {stderr}");
        let figures = summary(&out);
        let figure = |key: &str| figures[key].as_f64().unwrap();
        ([figure("volume_mm3"), figure("part_volume_mm3"), figure("filled_share")], stderr)
    };
    let overlapping = [[[0.0; 3], [16.0, 12.0, 4.0]], [[8.0, 0.0, 0.0], [24.0, 12.0, 4.0]]];
    let ([mesh, part, filled], stderr) = printed("overlapping", &overlapping, 0);
    assert!((mesh - 1536.0).abs() < 1e-6 && (part - 1152.0).abs() < 1e-6, "{mesh} {part}");
    assert!((0.97..1.02).contains(&filled), "{filled} {stderr}");
    // A wall of half a cell on a plate: no bead fits into it.
    let wall = [[[0.0; 3], [20.0, 10.0, 2.0]], [[9.75, 0.0, 2.0], [10.25, 10.0, 20.0]]];
    let ([_, part, filled], stderr) = printed("wall", &wall, 3);
    assert!((part - 490.0).abs() < 1e-6 && filled < 0.9, "{part} {filled}");
    for words in ["thinner than a cell of 1.000 mm", "no bead of 1.000 mm fits", "deposited volume is "] {
        assert!(stderr.contains(words), "{words}: {stderr}");
    }
}

/// Bug: the scene had a nozzle of its own, whatever `--nozzle` said. Of a post with an arm that is printed sideways, a block of
/// 400 mm reaches into the plate; one of 20 mm does not. What it cannot print is left out and reported, and gouges nowhere.
#[test]
fn a_block_of_400_mm_is_in_the_way() {
    let scratch = Scratch::new("wide");
    let mesh = scratch.path("ell.stl");
    fs::write(&mesh, boxes(&[[[0.0; 3], [12.0, 12.0, 36.0]], [[12.0, 0.0, 24.0], [36.0, 12.0, 36.0]]])).unwrap();
    let printed = |nozzle: &str, status: i32| {
        let out = scratch.path(nozzle);
        let args = ["--cell", "4", "--stage", "motion", "--program", "none", "--nozzle", nozzle, "--quiet"];
        let output = run(&[&args[..], &["--mesh", &mesh, "--out", &out]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(status), "{said}");
        (summary(&out), said)
    };
    let (figures, _) = printed("1,45,8,20", 0);
    assert_eq!((&figures["gouging_before"], &figures["check_findings"]), (&0.into(), &0.into()));
    let (figures, said) = printed("1,45,2,400", 3);
    assert!(said.contains("out of the nozzle's reach") && said.contains("paths are not printed"), "{said}");
    assert!(figures["gouging_before"].as_u64().unwrap() > 100 && figures["left_out_mm"].as_f64().unwrap() > 10.0);
    assert_eq!(figures["check_contacts"], 0);
}

/// The machines to copy from print the block: the tip is at each waypoint of the plan, by the machine's own forward kinematics. What a machine does not reach,
/// and a file that is no machine, is one line, and no program is left.
#[test]
fn a_machine_file_makes_a_program_of_its_axes() {
    let scratch = Scratch::new("five_axis");
    let mesh = scratch.path("block.stl");
    fs::write(&mesh, boxes(&[[[0.0; 3], [8.0, 6.0, 4.0]]])).unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines");
    let ran = |out: &str, machine: &Path| {
        let machine = machine.display().to_string();
        run(&["--mesh", &mesh, "--cell", "1", "--quiet", "--out", out, "--machine", &machine])
    };
    for name in ["bc-table-tcp", "head-head-gantry", "klipper-tilting-head", "open5x-table", "polar-tilting-head"] {
        let out = scratch.path(name);
        let file = folder.join(format!("{name}.json"));
        let output = ran(&out, &file);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        let summary = summary(&out);
        assert!(summary["five_axis_tip_error_mm"].as_f64().unwrap() <= 0.02, "{name}");
        let printer = FiveAxisPrinter::load(&file).unwrap();
        assert_eq!(summary["five_axis_flavour"], printer.flavour.name.as_str());
        let text = fs::read_to_string(Path::new(&out).join("toolpath-axes.gcode")).unwrap();
        assert_eq!(summary["five_axis_bytes"], text.len());
        let tips = match printer.machine.letters().len() {
            4 => tips_of::<4>(&text, &printer),
            _ => tips_of::<5>(&text, &printer),
        };
        let plan = fs::File::open(Path::new(&out).join("toolpath.gcode")).unwrap();
        let plan = GcodeReader::new(BufReader::new(plan), ReadOptions::default()).unwrap();
        let allowed = if name == "polar-tilting-head" { 0.02 } else { 5e-4 };
        for item in plan.map(Result::unwrap) {
            let gcode::Move::Print { tip, .. } = item else { continue };
            let off = tips.iter().map(|other| (other - tip).norm()).fold(f64::INFINITY, f64::min);
            assert!(off < allowed, "{name}: {off} at {tip}");
        }
    }
    let model = fs::read_to_string(folder.join("open5x-table.json")).unwrap();
    for (from, to, words) in [
        ("\"range_mm\": [-126, 125]", "\"range_mm\": [-1, 1]", "places are out of its reach, the farthest at "),
        ("\"letter\": \"U\"", "\"letter\": \"V\"", "letter"),
        ("\"point_mm\": [0, 0, -40], ", "", "point_mm is missing"),
        ("reprapfirmware", "siemens", "dialect: the flavour `siemens` takes no axes"),
        ("reprapfirmware", "fanuc", "dialect: `fanuc` is no G-code flavour"),
        ("\"version\": 1", "\"version\": 2", "version"),
    ] {
        let file = scratch.path("machine.json");
        fs::write(&file, model.replacen(from, to, 1)).unwrap();
        let out = scratch.path("none");
        let output = ran(&out, Path::new(&file));
        let (found, line) = status_and_line(&output);
        assert!(found == 1 && line.contains(words) && line.contains("machine.json"), "{from}: {found} {line}");
        assert!(
            !Path::new(&out).join("toolpath-axes.gcode").exists() && !Path::new(&out).join("toolpath.gcode").exists()
        );
    }
}

/// The tips of a program's beads.
fn tips_of<const N: usize>(text: &str, printer: &FiveAxisPrinter) -> Vec<Point3<f64>> {
    let axes: [MachineAxis; N] = axes_of(&printer.machine).try_into().unwrap();
    let moves = AxisReader::new(text.as_bytes(), &axes, &printer.flavour, FlavourReadOptions::default()).unwrap();
    let tip = |item: AxisMove<N>| {
        let AxisMove::Print { axes, .. } = item else { return None };
        let mut all = [0.0; 5];
        all[..N].copy_from_slice(&axes);
        Some(printer.machine.forward(&all).0)
    };
    moves.map(Result::unwrap).filter_map(tip).collect()
}
