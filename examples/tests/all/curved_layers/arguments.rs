//! Options and profiles.

use super::*;

#[test]
fn bad_arguments_exit_with_2_and_bad_files_with_1() {
    let scratch = Scratch::new("bad");
    fs::write(scratch.path("file"), "x").unwrap();
    let (out, in_the_way) = (scratch.path("out"), scratch.path("file"));
    let cases: [(&[&str], i32, &str); 81] = [
        (&["--nozzle", "1,45,8"], 2, "four numbers"),
        (&["--nozzle", "9,30,8,30"], 2, "wider than it is high"),
        (&["--voxels", "0"], 2, "--voxels"),
        (&["--cell", "-1"], 2, "--cell"),
        (&["--eps", "nan"], 2, "--eps"),
        (&["--min-gap", "-1"], 2, "--min-gap"),
        (&["--join-distance", "-1"], 2, "--join-distance"),
        (&["--min-length", "nan"], 2, "--min-length"),
        (&["--dialect", "extended"], 2, "--dialect"),
        (&["--stage", "paths", "--dialect", "ijk"], 2, "--dialect"),
        (&["--strategy", "wild"], 2, "--strategy"),
        (&["--voxels", "9", "--cell", "1"], 2, "--cell"),
        (&["--program-steps", "0"], 2, "--program-steps"),
        (&["--ur-extruder", "serial"], 2, "--ur-extruder"),
        (&["--ur-extruder", "modbus:192.168.1.9,255,16,128"], 2, "modbus:IP,UNIT,COIL,REGISTER,STEP"),
        (&["--ur-extruder", "modbus:192.168.1.9,256,16,128,0.001"], 2, "UNIT is `256`"),
        (&["--ur-extruder", "socket:192.168.1.9:0,12"], 2, "PORT must be"),
        (&["--acceleration", "0"], 2, "--acceleration"),
        (&["--jerk", "nan"], 2, "--jerk"),
        (&["--jerk", "-1"], 2, "--jerk"),
        (&["--tolerance", "0"], 2, "--tolerance"),
        (&["--margin", "-1"], 2, "--margin"),
        (&["--max-flow", "0"], 2, "--max-flow"),
        (&["--stage", "motion", "--program", "rapid"], 2, "UR3 takes urscript"),
        (&["--stage", "motion", "--program", "urscript", "--cell8"], 2, "takes rapid, krl, tp"),
        (&["--stage", "motion", "--workcell", "ur10e", "--program", "tp"], 2, "UR10e takes urscript"),
        (&["--ur-extruder", "socket:192.168.1.9:4000,12"], 2, "--stage motion"),
        (
            &["--stage", "motion", "--cell8", "--ur-extruder", "socket:192.168.1.9:4000,12"],
            2,
            "--ur-extruder does nothing with --program rapid",
        ),
        (&["--cell8"], 2, "--stage motion"),
        (&["--program", "none"], 2, "--stage motion"),
        (&["--margin", "0.5"], 2, "--stage motion"),
        (&["--stage", "paths", "--nozzle", "1,45,8,20"], 2, "--stage gcode"),
        (&["--stage", "surfaces", "--bead", "1"], 2, "--stage paths"),
        (&["--stage", "field", "--compare"], 2, "--stage surfaces"),
        (&["--prevention", "adaptive"], 2, "--strategy governed"),
        (&["--resume", "field.txt", "--strategy", "greedy"], 2, "--strategy"),
        (&["--allow-missed", "1.5"], 2, "--allow-missed"),
        (&["--allow-volume", "-1"], 2, "--allow-volume"),
        (&["--allow-gouging", "nan"], 2, "--allow-gouging"),
        (&["--allow-left-out", "x"], 2, "--allow-left-out"),
        (&["--allow-unsupported", "2"], 2, "--allow-unsupported"),
        (&["--allow-unsupported-beads", "-1"], 2, "--allow-unsupported-beads"),
        (&["--support-distance", "0.5"], 2, "--support-distance"),
        (&["--stage", "paths", "--support-distance", "2"], 2, "--stage gcode"),
        (&["--max-memory", "0"], 2, "--max-memory"),
        (&["--resume", "no-such-field.txt"], 1, "no-such-field.txt"),
        (&["--resume", &scratch.path("")], 1, "is not a file"),
        (&["--bead", "1000"], 1, "wider than the part"),
        (&["--layer-height", "0.6"], 2, "layers of 0.6 mm are higher than a bead is wide, 0.5 mm, the default"),
        (&["--bead", "0.2"], 2, "layers of 0.3 mm, the default, are higher than a bead is wide, 0.2 mm"),
        (&["--cell", "1", "--bead", "0.5"], 2, "layers of 1 mm, the edge of a cell, are higher than a bead"),
        (&["--voxels", "2000", "--bead", "0.5"], 1, "the edge of a cell, are higher than a bead"),
        (&["--min-feed", "50"], 2, "--min-feed 50 is above --max-feed 40"),
        (&["--filament", "1e308"], 2, "--filament <MM>': must be from 0.1 to 50 mm"),
        (&["--clearance", "1e308"], 2, "--clearance <MM>': must be at most 10000 mm"),
        (&["--retraction", "1e9"], 2, "--retraction <MM>': must be at most 10000 mm"),
        (&["--travel-feed", "1e99"], 2, "--travel-feed <MM_S>': must be at most 100000"),
        (&["--price-per-kg", "20"], 2, "--material-density"),
        // Options by their names with units, and by older names.
        (&["--max-feed-mm-s", "0"], 2, "--max-feed <MM_S>': must be above 0"),
        (&["--least-gap", "-1"], 2, "--min-gap <SQUARES>': must be 0 or more"),
        (&["--material-density", "1240"], 2, "g/cm3"),
        (&["--stage", "paths", "--fan", "1"], 2, "--fan does nothing with --stage paths: it needs --stage gcode"),
        (&["--profile", "no-such-profile.json"], 1, "no-such-profile.json"),
        (&["--profile", &scratch.path("file")], 1, "line 1, column 1: not JSON"),
        (&["a.stl", "--mesh", "b.stl"], 2, "--mesh"),
        (
            &["--stage", "paths", "--also", "apt"],
            2,
            "--also apt does nothing with --stage paths: it needs --stage gcode",
        ),
        (&["--also", "apt,svg"], 2, "--also"),
        (&["--tags", "simplify"], 2, "--tags"),
        (&["--density", "101"], 2, "--density <PERCENT>': must be from 0 to 100"),
        (&["--walls", "2"], 2, "--walls does nothing in a part that is solid: see --density"),
        (&["--density", "20", "--walls", "20000"], 2, "--walls"),
        (&["--voxels", "5000", "--max-memory", "0.001"], 1, "--voxels"),
        (&["--voxels", "2000", "--stage", "field", "--scale", "1e200"], 1, "--allow-large"),
        (&["--cell8", "--workcell", "x.json"], 2, "--workcell"),
        (&["--workcell", "no-such-cell.json"], 1, "no-such-cell.json"),
        (&["--workcell", &scratch.path("file")], 1, "line 1, column 1: not JSON"),
        (&["--mesh", "no-such-file.stl"], 1, "no-such-file.stl"),
        (&["--mesh", &scratch.path("")], 1, "not a file"),
        (&["--cell", "0.0001"], 1, "grid"),
        (&["--platform-diameter", "1e9"], 1, "platform"),
        (&["--on", "no-such-mould.stl"], 1, "no-such-mould.stl"),
    ];
    for (args, status, word) in cases {
        let output = run(&[args, &["--out", &out]].concat());
        let (found, line) = status_and_line(&output);
        assert_eq!(found, status, "{args:?}: {line}");
        assert!(line.starts_with("error: ") && line.contains(word), "{args:?}: {line}");
        assert!(!Path::new(&out).exists(), "{args:?} left something behind");
    }
    let (status, line) = status_and_line(&run(&["--out", &in_the_way]));
    assert!(status == 1 && line.contains(&in_the_way), "{status} {line}");
}

/// All options of the declaration that are meant to be everyday ones are there, and no others.
#[test]
fn short_help_has_forty_options_at_most() {
    let options = |word: &str| {
        let help = String::from_utf8(run(&[word]).stdout).unwrap();
        help.lines().filter(|line| line.trim_start().starts_with('-')).count()
    };
    // With -h and -V; the mesh is no option.
    assert_eq!(options("-h"), 37);
    assert!(options("--help") > 90);
}

/// What a profile says holds where nothing is typed, and both are in the summary; cells follow from the layer height.
#[test]
fn profiles_are_taken_and_options_win() {
    let scratch = Scratch::new("profile");
    let (mesh, profile, out) = (scratch.path("block.stl"), scratch.path("mine.json"), scratch.path("out"));
    fs::write(&mesh, boxes(&[[[0.0; 3], [8.0, 6.0, 2.0]]])).unwrap();
    let text = r#"{
        "name": "mine",
        "layer_height_mm": 0.4, "bead_mm": 0.9, "nozzle": [0.6, 40, 8, 20],
        "material": "PETG", "filament_diameter_mm": 2.85, "material_density_g_cm3": 1.27, "price_per_kg": 30,
        "nozzle_celsius": 235, "retraction_mm": 0, "dialect": "ijk", "extrusion": "relative",
        "start_gcode": ["M109 S{nozzle} ; mine", "G28"], "end_gcode": ["M84"]
    }"#;
    fs::write(&profile, text).unwrap();
    let args =
        ["--profile", &profile, "--bead", "0.5", "--nozzle-celsius", "240.5", "--also", "apt,csv", "--line-numbers"];
    let output = run(&[&args[..], &[&mesh, "--quiet", "--out", &out]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    documented(&out);
    let figures = summary(&out);
    let figure = |key: &str| figures[key].as_f64().unwrap();
    assert_eq!((figure("layer_height_mm"), figure("bead_mm"), figure("cell_mm")), (0.4, 0.5, 0.4));
    assert_eq!((figure("filament_diameter_mm"), figure("nozzle_celsius"), figure("retraction_mm")), (2.85, 240.5, 0.0));
    assert_eq!((&figures["material"], &figures["profile_name"]), (&"PETG".into(), &"mine".into()));
    assert_eq!((&figures["nozzle"], &figures["bed_celsius"]), (&"0.6,40,8,20".into(), &"none".into()));
    let mass = figure("filament_g");
    assert!((mass - figure("extruded_mm3") * 1.27e-3).abs() < 1e-9 && mass > 0.1);
    assert!((figure("filament_cost") - mass * 0.03).abs() < 1e-9);
    let gcode = fs::read_to_string(Path::new(&out).join("toolpath.gcode")).unwrap();
    assert!(gcode.contains("N1 M109 S240.5*") && gcode.contains(" ; mine\nN2 G28*") && gcode.contains(" M83*"));
    assert!(gcode.lines().last().unwrap().contains(" M84*"));
    assert!(!gcode.contains(";DIR:") && !gcode.contains("G1 E-0\n"));
    // Numbers and checksums hold, and viewers see as many layers as there are.
    let options = ReadOptions {
        dialect: gcode::Dialect::Part(gcode::DirectionWords::Ijk),
        skip_other_m: true,
        ..ReadOptions::default()
    };
    let moves = GcodeReader::new(gcode.as_bytes(), options).unwrap().collect::<Result<Vec<_>, _>>().unwrap();
    assert!(gcode.lines().filter(|line| line.contains("*")).count() > moves.len());
    let count = |line: &str| gcode.lines().filter(|other| *other == line).count() as f64;
    assert!((count(";LAYER_CHANGE") - figure("surfaces")).abs() < 0.5);
    assert!(gcode.contains("\n;HEIGHT:0.") && gcode.contains("\n;WIDTH:0."));
    assert!(count(";TYPE:External perimeter") > 0.0 && count(";TYPE:Solid infill") > 0.0);
    // The same moves for CAM.
    let goes =
        moves.iter().filter(|step| matches!(step, gcode::Move::Travel { .. } | gcode::Move::Print { .. })).count();
    let read = |name: &str| fs::read_to_string(Path::new(&out).join(name)).unwrap();
    let begin = |text: &str, word: &str| text.lines().filter(|line| line.starts_with(word)).count();
    // The machine file ends with a lift of its own.
    assert_eq!(begin(&read("toolpath.apt"), "GOTO/"), goes - 1);
    assert_eq!(begin(&read("toolpath.csv"), "travel,") + begin(&read("toolpath.csv"), "print,"), goes - 1);
    let vtp = fs::read(Path::new(&out).join("paths.vtp")).unwrap();
    assert!(String::from_utf8_lossy(&vtp).contains(&format!("NumberOfPoints=\"{}\"", figures["waypoints"])));
    // Of what takes hundreds of megabytes at real resolution nothing is there.
    for name in ["field.csv", "field.vtk", "layers.obj", "layers.vtk", "paths.obj"] {
        assert!(!Path::new(&out).join(name).exists(), "{name}");
    }
    // People read on stdout what there is, and where.
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    for words in
        ["8.0 x 6.0 x 2.0 mm, 0.10 cm3", "5 of 0.400 mm, beads of 0.500 mm", "(PETG)", " g, costs ", "report.html"]
    {
        assert!(said.contains(words), "{words}: {said}");
    }

    for (text, status, words) in [
        (r#"{"layer_hight_mm": 0.2}"#, 1, "line 1: `layer_hight_mm` is not a setting; did you mean `layer_height_mm`?"),
        ("{\n\"bead_mm\": 0.5,\n\"beads_mm\": 3}", 1, "line 3: `beads_mm` is not a setting; did you mean `bead_mm`?"),
        (r#"{"colour of the machine": 0.2}"#, 1, "settings are "),
        (r#"{"bead_mm": -0.5}"#, 1, "`bead_mm` is -0.5: must be above 0"),
        (r#"{"bead_mm": "wide"}"#, 1, "line 1, column"),
        (r#"{"nozzle": [9, 30, 8, 30]}"#, 1, "`nozzle`: "),
        (r#"{"start_gcode": ["G28", "M109 S{nozle}"]}"#, 1, "the header, line 2: `{nozle}` is not one of nozzle"),
        (r#"{"start_gcode": ["G28", "M109\nS210"]}"#, 1, "`start_gcode`, line 2: a line break within a line"),
        (r#"{"end_gcode": ["M84 {"]}"#, 1, "the footer, line 1: a single `{`"),
        (r#"{"workcell": "no-such.json"}"#, 1, "no-such.json"),
        (r#"{"layer_height_mm": 0.7}"#, 2, "layers of 0.7 mm are higher than a bead is wide"),
        (r#"{"density_percent": 101}"#, 1, "`density_percent` is 101: must be from 0 to 100"),
        (r#"{"min_feed_mm_s": 50}"#, 2, "--min-feed 50"),
    ] {
        fs::write(&profile, text).unwrap();
        let bad = scratch.path("bad");
        let output = run(&[&mesh, "--profile", &profile, "--quiet", "--out", &bad]);
        let (found, line) = status_and_line(&output);
        assert!(found == status && line.contains(words), "{text}: {found} {line}");
        assert_eq!(String::from_utf8_lossy(&output.stderr).lines().count(), 1, "{text}");
        assert!(!Path::new(&bad).exists(), "{text} left something behind");
    }
}

/// The profiles that come along are what they say, and their cells are there.
#[test]
fn the_profiles_that_come_along_can_be_used() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("profiles");
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let settings = Profile::load(&path).unwrap().settings();
        settings.check_templates().unwrap();
        assert!(settings.name.is_some() && settings.material_density_g_cm3.is_some(), "{}", path.display());
        assert!(settings.layer_height_mm.unwrap() <= settings.bead_mm.unwrap(), "{}", path.display());
        if let Some(cell) = &settings.workcell {
            AnyWorkcell::from_json(&fs::read(cell).unwrap()[..]).unwrap();
        }
        count += 1;
    }
    assert_eq!(count, 3);
}
