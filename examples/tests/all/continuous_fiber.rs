//! The example `continuous_fiber`: its figures, its files, and what it says to bad input.

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../continuous_fiber/main.rs"]
mod example;

use crate::common;
use crate::common::summary;
use clap::Parser;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use curvlay_examples::nalgebra::Point3;
use curvlay_examples::waypoints::read_waypoints;
use curvlay_kinematics::program::{Goal, HeadInput, HeadSignal, Step, UrScriptReader};
use curvlay_toolpath::gcode::{FiberCommand, GcodeReader, Move, ReadOptions, Tool};
use example::Args;
use std::fs;
use std::path::{Path, PathBuf};

fn arguments(words: &[&str]) -> Result<Args, clap::Error> {
    Args::try_parse_from(["continuous_fiber"].iter().chain(words))
}

fn place(name: &str) -> PathBuf {
    common::place("continuous_fiber", name)
}

/// Runs the example in a folder of its own.
fn run(name: &str, words: &[&str]) -> Result<(PathBuf, Outcome), String> {
    let folder = common::folder("continuous_fiber", name);
    let (_, outcome) = example::work(&arguments(words).unwrap(), &Bars::new(true), &folder)
        .map_err(|failure| failure.message().to_owned())?;
    Ok((place(name), outcome))
}

fn moves(path: &Path) -> Vec<Move> {
    let file = fs::read(path).unwrap();
    GcodeReader::new(&file[..], ReadOptions::default()).unwrap().collect::<Result<_, _>>().unwrap()
}

/// A box of 60 x 20 x 8 mm.
fn block(name: &str) -> PathBuf {
    let path = place("files").join(name);
    fs::create_dir_all(place("files")).unwrap();
    let mut text = String::new();
    for k in 0..8 {
        text += &format!("v {} {} {}\n", 60 * (k & 1), 20 * (k >> 1 & 1), 8 * (k >> 2));
    }
    for [a, b, c, d] in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        text += &format!("f {a} {b} {c} {d}\n");
    }
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn the_specimens_have_their_tapes() {
    let (path, outcome) = run("specimens", &[]).unwrap();
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    let section = common::format_section("studies.md", "continuous_fiber");
    for key in summary.keys() {
        let bare = ["dumbbell", "bar", "arc", "layer"].iter().find_map(|name| key.strip_prefix(name));
        let is_there = |key: &str| section.contains(&format!("`{key}`"));
        assert!(
            is_there(key) || bare.is_some_and(|rest| is_there(&format!("*{rest}"))),
            "{key} is not in docs/formats/studies.md"
        );
    }
    let figure = |key: &str| summary[key].as_f64().unwrap();
    // Sections 5.4.1 and 5.4.2 of the dissertation: tapes by number and length.
    for (name, tapes, length) in [("dumbbell", 5, 150.0), ("bar", 9, 240.0), ("arc", 6, 68.0)] {
        assert_eq!(summary[&format!("{name}_tapes")], tapes);
        assert!((figure(&format!("{name}_tape_mm")) / (tapes as f64 * length) - 1.0).abs() < 2e-3, "{name}");
        let file = moves(&path.join(format!("{name}.gcode")));
        let laid = file.iter().filter(|step| matches!(step, Move::Fiber(FiberCommand::Cut))).count();
        assert_eq!(laid, tapes, "{name}");
        tapes_lie_between_beads(&file, name, tapes);
    }
    assert!(figure("covered_fraction") >= 0.95 && figure("overlap_fraction") <= 0.02);
    assert!(figure("min_radius_mm") >= figure("allowed_radius_mm"));
    assert!(figure("angle_to_principal_deg") <= 15.0);
    theory_meets_the_tests(&figure);
    assert!(moves(&path.join("arc_planar.gcode")).iter().any(|step| matches!(step, Move::Print { .. })));
    assert_eq!(summary["motion_faults"], 0);
    assert!(figure("motion_turn_deg") < 2.1 && figure("motion_deviation_mm") < 0.1);
    the_head_lays_six_tapes(&path.join("arc_tapes_001.script"));
    let csv = fs::read_to_string(path.join("tapes.csv")).unwrap();
    assert!(csv.starts_with("part,layer,tape,x_mm,y_mm,z_mm,nx,ny,nz,radius_mm\ndumbbell,1,1,"));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert_eq!(report.matches("data:image/png;base64,").count(), 5);
    // By how much theory is off is computed; the arc's plan says what is laid, and what is not.
    let off = 100.0 * (figure("modulus_gpa") / 2.32 - 1.0);
    assert!(report.contains(&format!("Ours is {off:.2} % above the measured figure. Possible reasons: ")));
    assert!(report.contains(&format!("{} motions for the 6 tapes of the arc", figure("motion_runs"))));
    assert!(report.contains(" s, 0 faults."));
}

/// Thermoplastic below and above each layer of tape; the roller presses along the normal of what it rolls over: across its way.
fn tapes_lie_between_beads(file: &[Move], name: &str, tapes: usize) {
    let order: String = file
        .iter()
        .filter_map(|step| match step {
            Move::Fiber(FiberCommand::Tool(Tool::Roller)) => Some('t'),
            Move::Print { .. } => Some('p'),
            _ => None,
        })
        .collect();
    let mut runs: Vec<char> = order.chars().collect();
    runs.dedup();
    assert_eq!(runs.iter().collect::<String>(), format!("{}p", "pt".repeat(tapes)), "{name}");
    let mut at: Option<Point3<f64>> = None;
    for step in file {
        match step {
            Move::Lay { tip, direction, .. } => {
                let way = *tip - at.unwrap();
                assert!(way.normalize().dot(&direction.into_inner()).abs() < 0.05, "{name}");
                at = Some(*tip);
            }
            Move::Travel { tip, .. } | Move::Print { tip, .. } => at = Some(*tip),
            _ => {}
        }
    }
}

/// Stiffness and delamination by theory beside the measured.
fn theory_meets_the_tests(figure: &dyn Fn(&str) -> f64) {
    // Theory beside the measured: an upper bound, and never less than the thermoplastic alone.
    assert_eq!((figure("measured_modulus_gpa"), figure("measured_rigidity_nm2")), (2.32, 0.671));
    assert!(figure("modulus_gpa") > 2.32 && figure("rigidity_perfect_nm2") > 0.671);
    // With the share of the fibre that bears in tension, the other tests are met within 30 %.
    let share = figure("bearing_fraction");
    assert!((0.1..0.3).contains(&share), "{share}");
    for (ours, measured) in [("rigidity_nm2", 0.671), ("arc_cr_cu", 16.54 / 12.43), ("arc_pu_cu", 11.35 / 12.43)] {
        assert!((figure(ours) / measured - 1.0).abs() < 0.3, "{ours}: {} {measured}", figure(ours));
    }
    // Tapes that follow the arc stiffen it more than those that planar layers have room for, and curved layers bear more.
    assert!(figure("arc_cr_cu") > figure("arc_taped_planar_cu") && figure("arc_taped_planar_cu") > 1.0);
    assert!(figure("arc_cu_apart_n") > 1.5 * 80.0 && figure("arc_cr_apart_n") > 80.0);
    // The chord just above the inner cylinder: 2 sqrt(64.2^2 - 60^2), and no layer lies right there.
    let longest = figure("arc_planar_longest_tape_mm");
    assert!(longest > 40.0 && longest <= 2.0 * (64.2f64.powi(2) - 3600.0).sqrt(), "{longest}");
}

/// Six tapes by their signals; at home the roller comes and gets hot, and the arm waits for both.
fn the_head_lays_six_tapes(script: &Path) {
    let script = fs::read(script).unwrap();
    let steps: Vec<Step> = UrScriptReader::new(&script[..]).unwrap().map(Result::unwrap).collect();
    for signal in [HeadSignal::Feed, HeadSignal::Press, HeadSignal::Cut] {
        let count = |on| steps.iter().filter(|step| **step == Step::Signal { signal, on }).count();
        assert_eq!((count(true), count(false)), (6, 6), "{signal:?}");
    }
    let on = |signal: HeadSignal| Step::Signal { signal, on: true };
    assert!(matches!(steps[0], Step::Move(_)));
    let waits = [Step::Wait(HeadInput::ToolReady), Step::Wait(HeadInput::Hot)];
    assert_eq!(steps[1..5], [on(HeadSignal::Roller), waits[0], on(HeadSignal::Heat), waits[1]]);
}

/// Every key of a summary is in the section of docs/formats/studies.md.
fn check_keys(path: &Path) {
    let section = common::format_section("studies.md", "continuous_fiber");
    for key in summary(path).keys() {
        assert!(section.contains(&format!("`{key}`")), "{key} is not in docs/formats/studies.md");
    }
}

/// A cantilever: its tapes go along it, by the solver and by a file that says the same.
#[test]
fn a_part_has_tapes_along_its_stresses() {
    let file = block("block.obj");
    let words =
        ["--stage", "tapes", "--cell", "2", "--mesh", file.to_str().unwrap(), "--tape-width", "4", "--layers", "1,3"];
    let held = ["--support", "-inf,-inf,-inf,0,inf,inf", "--load", "59,-inf,-inf,inf,inf,inf:0,0,-20", "--bond", "5"];
    let (path, _) = run("part", &[&words[..], &held].concat()).unwrap();
    let by_solver = summary(&path);
    assert!(by_solver["angle_to_principal_deg"].as_f64().unwrap() < 15.0);
    assert!(by_solver["tapes"].as_u64().unwrap() >= 6 && by_solver["elastic_cells"].as_u64() == Some(1200));
    assert_eq!((&by_solver["layers"], &by_solver["taped_layers"]), (&4.into(), &"1, 3".into()));
    assert!(by_solver.get("tape_runs").is_none() && by_solver.get("tape_on_nothing_share").is_none());
    // Tapes along a cantilever stiffen it; more of the fibre does so more.
    let gain = |summary: &serde_json::Map<String, serde_json::Value>| summary["stiffness_gain"].as_f64().unwrap();
    assert!(gain(&by_solver) > 0.05, "{}", gain(&by_solver));
    let (path, _) = run("bears", &[&words[..], &held, &["--bearing", "1"]].concat()).unwrap();
    assert!(gain(&summary(&path)) > 2.0 * gain(&by_solver));
    let stress = place("files").join("pull.csv");
    let mut text = "x,y,z,xx,yy,zz,xy,yz,zx\n".to_owned();
    for (x, y, z) in (0..13).flat_map(|x| (0..5).flat_map(move |y| (0..3).map(move |z| (x, y, z)))) {
        text += &format!("{},{},{},1,0,0,0,0,0\n", 5 * x, 5 * y, 4 * z);
    }
    fs::write(&stress, text).unwrap();
    let (path, _) = run("file", &[&words[..], &["--stress", stress.to_str().unwrap()]].concat()).unwrap();
    let by_file = summary(&path);
    check_keys(&path);
    assert!(by_file["angle_to_principal_deg"].as_f64().unwrap() < 1.0);
    assert!(by_file["covered_fraction"].as_f64().unwrap() > 0.9 && by_file.get("elastic_s").is_none());
    assert!(by_file.get("stiffness_gain").is_none());
}

/// A box of 44 x 16 x 6 mm, and what holds and loads it: a cantilever.
fn beam() -> (PathBuf, [&'static str; 14]) {
    let path = place("files").join("beam.obj");
    fs::create_dir_all(place("files")).unwrap();
    let text = fs::read_to_string(block("beam_of_60.obj")).unwrap();
    let scaled = text.replace("v 60 ", "v 44 ").replace(" 20 ", " 16 ").replace(" 8\n", " 6\n");
    // Faces name corners, not places.
    let faces =
        text.lines().filter(|line| line.starts_with('f')).map(|line| line.to_owned() + "\n").collect::<String>();
    let corners =
        scaled.lines().filter(|line| line.starts_with('v')).map(|line| line.to_owned() + "\n").collect::<String>();
    fs::write(&path, corners + &faces).unwrap();
    let words = [
        "--cell",
        "2",
        "--tape-width",
        "4",
        "--layers",
        "1,2",
        "--bond",
        "5",
        "--min-length",
        "20",
        "--support",
        "-inf,-inf,-inf,0,inf,inf",
        "--load",
        "43,-inf,-inf,inf,inf,inf:0,0,-20",
    ];
    (path, words)
}

/// A wall that is pushed along its top: where it bends most it is pulled upright, and layers along growth.csv come nearer to that, wherever the file has its axes.
#[test]
fn layers_can_follow_the_load() {
    let file = place("files").join("wall.obj");
    let text = fs::read_to_string(block("wall_of_60.obj")).unwrap();
    // 40 mm long, 6 thick and 30 high, along z of the file, as an animation program has it.
    let lines = text.lines().map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
        ["v", x, y, z] => {
            let [x, y, z] = [(x, "40"), (y, "6"), (z, "30")].map(|(k, far)| if k == "0" { k } else { far });
            format!("v {x} {z} -{y}\n")
        }
        _ => line.to_owned() + "\n",
    });
    let text: String = lines.collect();
    fs::write(&file, text).unwrap();
    let words = ["--stage", "tapes", "--cell", "2", "--mesh", file.to_str().unwrap(), "--up", "y", "--bond", "5"];
    let held = ["--support", "-inf,-inf,-inf,inf,inf,0.5", "--load", "-inf,-inf,29.5,inf,inf,inf:200,0,0"];
    let (path, _) = run("follows", &[&words[..], &held, &["--follow-load"]].concat()).unwrap();
    check_keys(&path);
    let summary = summary(&path);
    let figure = |key: &str| summary[key].as_f64().unwrap();
    let [directed, followed] = [figure("load_angle_directed_deg"), figure("load_angle_followed_deg")];
    assert!(directed > 30.0 && followed < directed - 10.0, "{directed} {followed}");
    assert!(figure("missed_directed") + figure("missed_followed") < 0.5);
    // Places in the numbers of the file: y is up there.
    let lines = read_waypoints(&path.join("growth.csv")).unwrap();
    assert_eq!(lines.len(), 20 * 3 * 15);
    for line in &lines {
        let [x, y, z, i, j, k] = line.values;
        assert!((0.0..40.0).contains(&x) && (0.0..30.0).contains(&y) && (-6.0..0.0).contains(&z), "{line:?}");
        assert!((i.hypot(j).hypot(k) - 1.0).abs() < 1e-5, "{line:?}");
    }
    let (again, _) = run("follows", &[&words[..], &held].concat()).unwrap();
    assert!(!again.join("growth.csv").exists());
}

/// Beads, tapes, beads, tapes, beads: in the machine file and in the robot's program, from home to home, with tool, heat, press and cut.
#[test]
fn a_whole_part_is_one_program() {
    let (file, words) = beam();
    let (path, outcome) = run("whole", &[&words[..], &["--mesh", file.to_str().unwrap()]].concat()).unwrap();
    let summary = summary(&path);
    check_keys(&path);
    assert_eq!(outcome, Outcome::Done, "{}", summary["findings"]);
    let figure = |key: &str| summary[key].as_f64().unwrap();
    let count = |key: &str| summary[key].as_u64().unwrap();
    let tapes = count("tapes");
    assert!(tapes >= 4 && count("cuts") == tapes && count("tape_runs") == tapes);
    assert!(figure("tape_on_nothing_share") <= 0.01 && figure("tape_uncovered_share") <= 0.01);
    let (beads, laid, cuts) = (count("program_beads"), count("program_tapes"), count("program_cuts"));
    assert!(beads == count("bead_runs") && laid == tapes && cuts == tapes && count("head_changes") == 4);
    assert!(figure("program_tape_off_mm") < 0.11 && figure("motion_turn_deg") < 2.1);
    // The machine file.
    let order: String = moves(&path.join("part.gcode"))
        .iter()
        .filter_map(|step| match step {
            Move::Fiber(FiberCommand::Tool(Tool::Roller)) => Some('R'),
            Move::Fiber(FiberCommand::Heat { celsius, wait }) if *celsius > 0.0 => Some(if *wait { 'H' } else { 'h' }),
            Move::Fiber(FiberCommand::Tool(Tool::Nozzle)) => Some('N'),
            Move::Print { .. } => Some('p'),
            Move::Lay { .. } => Some('t'),
            _ => None,
        })
        .collect();
    let mut order: Vec<char> = order.chars().collect();
    order.dedup();
    assert_eq!(order.iter().collect::<String>(), "pRHtNpRHtNp");
    // The program, read by a reader of its language, judged by its signals alone.
    let script = fs::read(path.join("part_001.script")).unwrap();
    let steps: Vec<Step> = UrScriptReader::new(&script[..]).unwrap().map(Result::unwrap).collect();
    assert!(!path.join("part_002.script").exists());
    let events: String = steps
        .iter()
        .filter_map(|step| match step {
            Step::Extruder(true) => Some('p'),
            Step::Signal { signal: HeadSignal::Roller, on } => Some(if *on { 'R' } else { 'N' }),
            Step::Wait(HeadInput::ToolReady) => Some('w'),
            Step::Wait(HeadInput::Hot) => Some('H'),
            Step::Signal { signal: HeadSignal::Press, on: true } => Some('t'),
            _ => None,
        })
        .collect();
    let mut events: Vec<char> = events.chars().collect();
    events.dedup();
    assert_eq!(events.iter().collect::<String>(), "pRwHtNwpRwHtNwp");
    // The arm stands at home whenever the tool changes.
    let mut at: Option<[f64; 6]> = None;
    let mut changes: Vec<[f64; 6]> = Vec::new();
    for step in &steps {
        match step {
            Step::Move(to) => at = if let Goal::Joints(joints) = to.goal { Some(joints) } else { None },
            Step::Servo { joints, .. } => at = Some(*joints),
            Step::Signal { signal: HeadSignal::Roller, .. } => changes.push(at.unwrap()),
            _ => {}
        }
    }
    let first = changes[0];
    assert!(changes.len() == 4 && changes.iter().all(|joints| (0..6).all(|k| (joints[k] - first[k]).abs() < 1e-4)));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert!(report.contains(&format!("the program lays {beads} beads and {tapes} tapes, with {cuts} cuts")));
}

/// The same by an ABB arm: RAPID, with a stop where a tape is cut.
#[test]
fn an_abb_arm_gets_rapid() {
    let (file, words) = beam();
    let cell = place("files").join("irb1200.json");
    fs::write(&cell, ABB_CELL).unwrap();
    let more = ["--mesh", file.to_str().unwrap(), "--workcell", cell.to_str().unwrap()];
    let (path, outcome) = run("rapid", &[&words[..], &more].concat()).unwrap();
    let summary = summary(&path);
    assert_eq!(outcome, Outcome::Done, "{}", summary["findings"]);
    assert_eq!((&summary["program_tapes"], &summary["program_cuts"]), (&summary["tapes"], &summary["cuts"]));
    let part = fs::read_to_string(path.join("fiber_001.mod")).unwrap();
    assert!(
        path.join("fiber.mod").exists() && part.contains("WaitDI diTapeHot,1;") && part.contains("WaitDI diTapeFed,1;")
    );
    // What switches the head stands behind a move that stops.
    let lines: Vec<&str> = part.lines().map(str::trim).collect();
    for (k, _) in lines.iter().enumerate().filter(|(_, line)| line.starts_with("SetDO doTapeCut,1")) {
        assert!(lines[k - 1].contains(",fine,"), "{}", lines[k - 1]);
    }
}

/// Tapes on two layers at a right angle: while the roller lifts off one it comes near the other. It turned along that one, and could not lift off.
#[test]
fn tapes_of_the_layer_above_do_not_turn_the_roller() {
    let (beam, _) = beam();
    let file = place("files").join("square.obj");
    fs::write(&file, fs::read_to_string(beam).unwrap().replace(" 16 ", " 44 ")).unwrap();
    let stress = place("files").join("crossed.csv");
    let mut text = "x,y,z,xx,yy,zz,xy,yz,zx\n".to_owned();
    for (x, y, z) in (0..12).flat_map(|x| (0..12).flat_map(move |y| (0..7).map(move |z| (x, y, z)))) {
        let [xx, yy] = if z < 3 { [1, 0] } else { [0, 1] };
        text += &format!("{},{},{z},{xx},{yy},0,0,0,0\n", 4 * x, 4 * y);
    }
    fs::write(&stress, text).unwrap();
    let words = [
        "--cell",
        "2",
        "--tape-width",
        "5",
        "--tape-spacing",
        "14",
        "--layers",
        "1,2",
        "--mesh",
        file.to_str().unwrap(),
    ];
    let (path, outcome) =
        run("crossed", &[&words[..], &["--stress", stress.to_str().unwrap(), "--smoothing", "0"]].concat()).unwrap();
    let summary = summary(&path);
    assert_eq!(summary["motion_faults"], 0, "{}", summary["findings"]);
    assert_eq!((outcome, &summary["tape_runs"]), (Outcome::Done, &summary["tapes"]));
}

/// An IRB 1200 with the nozzle in its hand over a plate that stands still.
const ABB_CELL: &str = r#"{
  "version": 1, "name": "IRB 1200 over a plate", "arm": { "geometry": { "named": "IRB1200" } }, "held": "nozzle",
  "part": { "position_mm": [450, 0, 100] },
  "nozzle": { "tip_mm": [64, 0, 154], "flow": [1, 0, 1], "tip_flat_mm": 1, "cone_half_angle_deg": 45, "cone_height_mm": 8, "block_diameter_mm": 20, "block_top_mm": 61 },
  "roller": { "diameter_mm": 20, "width_mm": 8, "block_diameter_mm": 25, "block_top_mm": 61 },
  "plate": { "thickness_mm": 20, "diameter_mm": 200 }
}"#;

#[test]
fn bad_input_fails_with_one_line() {
    let file = block("bad.obj");
    let mesh = ["--stage", "tapes", "--cell", "2", "--layers", "2", "--mesh", file.to_str().unwrap()];
    let stress = |name: &str, text: &str| {
        let path = place("files").join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let head = "x,y,z,xx,yy,zz,xy,yz,zx\n";
    let cases = [
        (stress("columns.csv", "x,y,z,xx\n1,2,3,4\n"), "columns.csv"),
        (stress("nan.csv", &format!("{head}1,2,3,NaN,0,0,0,0,0\n")), "nan.csv"),
        (stress("far.csv", &format!("{head}900,2,3,1,0,0,0,0,0\n901,2,3,1,0,0,0,0,0\n")), "farther than 10 mm"),
        (stress("empty.csv", head), "empty.csv"),
        ("no/such.csv".to_owned(), "no/such.csv"),
    ];
    for (number, (path, message)) in cases.iter().enumerate() {
        let error = run(&format!("bad_{number}"), &[&mesh[..], &["--stress", path]].concat()).unwrap_err();
        assert!(error.contains(message) && !error.contains('\n'), "{error}");
        assert!(!place(&format!("bad_{number}")).exists());
    }
    let loads = ["--load", "59,-inf,-inf,inf,inf,inf:0,0,-20"];
    let error = run("unheld", &[&mesh[..], &loads].concat()).unwrap_err();
    assert!(error.contains("no support") && error.contains("hold a region"), "{error}");
    // A layer that is not there, or that nothing covers; nothing is written.
    let four = &mesh[..5];
    for (layers, message) in [("4", "tapes on layer 4 of 4: it must be from 1 to 3"), ("2,9", "tapes on layer 9 of 4")]
    {
        let path = file.to_str().unwrap();
        let error = run("no_layer", &[four, &[layers, "--mesh", path]].concat()).unwrap_err();
        assert!(error.starts_with("--layers: ") && error.contains(message) && !place("no_layer").exists(), "{error}");
    }
    let error = run("bead", &[&mesh[2..], &["--stage", "paths", "--bead", "80"]].concat()).unwrap_err();
    assert!(error.contains("a bead of 80.000 mm fits nowhere") && error.contains("--bead"), "{error}");
    // A roller that is narrower than the tapes, and an arm with a table, before anything is planned.
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("cells/irb1200-table.json");
    let error = run("table", &[&mesh[2..], &["--workcell", table.to_str().unwrap()]].concat()).unwrap_err();
    assert!(error.contains("--workcell") && error.contains("six axes"), "{error}");
    let error = run("wide", &[&mesh[2..], &["--tape-width", "9"]].concat()).unwrap_err();
    assert!(error.contains("tapes of 9 mm under a roller of 8 mm") && error.contains("roller.width_mm"), "{error}");
    // A radius that no tape meets, or tapes longer than the layer, are no error: an empty plan that says why.
    let (path, _) = run("long", &[&mesh[..], &["--min-length", "66"]].concat()).unwrap();
    let summary = summary(&path);
    assert_eq!(summary["tapes"], 0);
    assert!(
        summary["findings"]
            .as_str()
            .unwrap()
            .contains("no tape lies on 1 of the layers that should carry some: 2\n  cause: layer 2 of 4 of bad.obj: ")
    );
    assert!(summary.get("angle_to_principal_deg").is_none() && !path.join("part.gcode").exists());
    // Longer than every specimen: they get none either, which fails their check.
    let (path, outcome) = run("longest", &["--stage", "tapes", "--min-length", "5000"]).unwrap();
    assert!(matches!(outcome, Outcome::ChecksFailed(_)));
    assert!(path.join("report.html").exists() && !path.join("dumbbell.gcode").exists());
}

#[test]
fn arguments_out_of_range_are_refused() {
    for words in [
        ["--tape-width", "0"],
        ["--min-radius", "-1"],
        ["--max-overlap", "2"],
        ["--support", "0,0,0,1,1"],
        ["--support", "0,0,0,-1,1,1"],
        ["--load", "0,0,0,1,1,1"],
        ["--load", "0,0,0,1,1,1:0,0,0"],
        ["--load", "0,0,0,1,1,1:0,0,inf"],
        ["--layers", "0"],
        ["--layers", "2,x"],
        ["--every", "0"],
        ["--bond", "0"],
        ["--bearing", "1.1"],
        ["--stage", "all"],
    ] {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
    assert!(arguments(&["--layers", "2", "--every", "3"]).is_err());
}
