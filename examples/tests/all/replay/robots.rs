//! Programs of KUKA and Fanuc arms, and of runs that have recorded their workcell.

use super::*;
use curvlay_kinematics::program::{
    ExternalAxes, Goal, KrlLines, KrlOptions, Move, Speed, Step, Target, TpOptions, Zone, write_krl, write_tp,
};
use curvlay_kinematics::robots;
use curvlay_kinematics::workcell::WorkcellModel;

/// The assumed workcell around an arm.
fn around(name: &str) -> (WorkcellModel, AnyWorkcell) {
    let model = WorkcellModel::around(robots::find(name).unwrap());
    (model.clone(), AnyWorkcell::new(model).unwrap())
}

/// Steps of both paths: by joints to each of them, along it in lines, by joints away. `change` sees each target.
fn steps(cell: &AnyWorkcell, mut change: impl FnMut(usize, &mut Target)) -> Vec<Step> {
    let mut postures = Postures::of(cell, [0.0, -1.0, 1.5, 0.0, 1.0, 0.0]);
    let speed = Speed { mm_s: SPEED, rad_s: 1.0 };
    let mut steps = Vec::new();
    let mut number = 0;
    for path in paths() {
        let ends = [path[0], path[path.len() - 1]];
        let [above, away] = ends.map(|[x, y, z]| [x, y, z + 10.0]);
        let by_joints = |postures: &mut Postures, at: &[f64; 3]| {
            let goal = Goal::Joints(postures.at(at));
            Step::Move(Move { goal, table: None, speed: Speed { mm_s: 40.0, rad_s: 0.5 }, zone: Zone::Stop })
        };
        steps.push(by_joints(&mut postures, &above));
        for (k, at) in path.iter().enumerate() {
            let joints = postures.at(at);
            let turned = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
            let pose = Isometry3::from_parts(Translation3::from(*at), turned);
            let mut target = Target { pose, conf: ConfData::of(&postures.arm, &joints) };
            change(number, &mut target);
            number += 1;
            let is_end = k == 0 || k + 1 == path.len();
            let zone = if is_end { Zone::Stop } else { Zone::Blend(0.3) };
            if k == 1 {
                steps.extend([Step::FilamentSpeed(SPEED * FEED), Step::Extruder(true)]);
            }
            steps.push(Step::Move(Move { goal: Goal::Line(target), table: None, speed, zone }));
        }
        steps.push(Step::Extruder(false));
        steps.push(by_joints(&mut postures, &away));
    }
    steps
}

/// Writes a program into the folder of a run. Its modules have few moves: steps are counted in each of them.
fn krl(name: &str, cell: &AnyWorkcell, lines: KrlLines, steps: Vec<Step>) {
    let inputs = folder(name);
    let options =
        KrlOptions { name: "print".into(), moves_per_module: 5, lines, ..KrlOptions::of_workcell(cell.equipment()) };
    write_krl(steps, &options, |file| fs::File::create(inputs.join(file))).unwrap();
}

fn tp(name: &str, cell: &AnyWorkcell, steps: Vec<Step>) {
    let inputs = folder(name);
    let options = TpOptions { name: "print".into(), moves_per_program: 5, ..TpOptions::of_workcell(cell.equipment()) };
    write_tp(steps, &options, |file| fs::File::create(inputs.join(file))).unwrap();
}

/// Replays what is in the folder of a run.
fn replayed(name: &str, words: &[&str]) -> Map<String, Value> {
    let inputs = folder(name);
    let plan = plan(&inputs, &paths(), upright);
    run(name, &[&[inputs.to_str().unwrap(), "--plan", &plan, "--allow-time", "0.2"], words].concat())
        .unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn is_as_planned(summary: &Map<String, Value>, name: &str) {
    assert_eq!(failed(summary), Vec::<String>::new(), "{name}");
    assert!(figure(summary, "tip_off_mm") < 0.25 * WIDTH && figure(summary, "tilt_off_deg") < 0.5, "{name}");
    assert!((figure(summary, "planned_mm") - 105.0).abs() < 1e-6 && figure(summary, "missed_mm") < 0.1, "{name}");
    assert!((figure(summary, "filament_mm") / (105.0 * FEED) - 1.0).abs() < 0.02, "{name}");
}

#[test]
fn krl_is_what_was_planned() {
    let (_, cell) = around("KR 6 R900-2");
    for (name, lines) in [("krl", KrlLines::Lin), ("krl-spline", KrlLines::Spline)] {
        krl(name, &cell, lines, steps(&cell, |_, _| {}));
        let summary = replayed(name, &["--workcell", "KR 6 R900-2"]);
        is_as_planned(&summary, name);
        assert_eq!((summary["format"].as_str(), summary["files"].as_u64() > Some(2)), (Some("KRL"), true));
    }
}

#[test]
fn tp_is_what_was_planned() {
    let (_, cell) = around("LR Mate 200iD");
    tp("tp", &cell, steps(&cell, |_, _| {}));
    let summary = replayed("tp", &["--workcell", "LR Mate 200iD"]);
    is_as_planned(&summary, "tp");
    assert_eq!(summary["format"], "TP");
}

#[test]
fn a_target_that_is_off_is_caught_with_its_module() {
    let (_, cell) = around("KR 6 R900-2");
    let off = steps(&cell, |number, target| {
        if number == 2 {
            target.pose.translation.y += 1.0;
        }
    });
    krl("krl-off", &cell, KrlLines::Lin, off);
    let summary = replayed("krl-off", &["--workcell", "KR 6 R900-2"]);
    assert!(has(&summary, "the tip is off the planned path"), "{:?}", failed(&summary));
    assert!(summary["findings"].as_str().unwrap().contains("of print_001.src"), "{}", summary["findings"]);
    let (_, cell) = around("LR Mate 200iD");
    let leaning = steps(&cell, |number, target| {
        if number > 0 && number < 4 {
            let lean = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.2);
            target.pose.rotation = lean * target.pose.rotation;
        }
    });
    tp("tp-leaning", &cell, leaning);
    let summary = replayed("tp-leaning", &["--workcell", "LR Mate 200iD"]);
    assert!(has(&summary, "the nozzle direction differs from the plan: 11.4"), "{:?}", failed(&summary));
}

/// A workcell without a table does not move one, whatever the program says.
#[test]
fn external_axes_that_the_workcell_lacks_are_refused() {
    let (_, cell) = around("KR 6 R900-2");
    let tables = steps(&cell, |_, _| {}).into_iter().map(|step| match step {
        Step::Move(to) => Step::Move(Move { table: Some(ExternalAxes::from([0.1, 0.2])), ..to }),
        other => other,
    });
    krl("krl-table", &cell, KrlLines::Lin, tables.collect());
    let inputs = folder("krl-table");
    let failure = run("krl-table", &[inputs.to_str().unwrap(), "--workcell", "KR 6 R900-2", "--no-plan"]).unwrap_err();
    assert!(failure.contains("the move has 2 external axes, the workcell no table"), "{failure}");
}

/// Before G-code in the same folder the robot program counts, and the report says so.
#[test]
fn a_folder_prefers_the_robot_program_and_says_it() {
    let (_, cell) = around("KR 6 R900-2");
    let inputs = folder("krl-and-gcode");
    file(&inputs, "toolpath-bc.gcode", "G0 X0 Y0 Z5 F100\n");
    krl("krl-and-gcode", &cell, KrlLines::Lin, steps(&cell, |_, _| {}));
    let summary = replayed("krl-and-gcode", &["--workcell", "KR 6 R900-2"]);
    is_as_planned(&summary, "krl-and-gcode");
    let findings = summary["findings"].as_str().unwrap();
    assert!(findings.contains("of the programs in the folder one is replayed: print.src (KRL)"), "{findings}");
    let left = findings.lines().find(|line| line.contains("not replayed: "));
    assert!(left.is_some_and(|line| line.contains("toolpath-bc.gcode")), "{findings}");
    // Nothing names the robot.
    let failure = run("krl-and-gcode", &[inputs.to_str().unwrap()]).unwrap_err();
    assert!(failure.contains("nothing says for which robot the KRL program is"), "{failure}");
}

/// The workcell of the run is the one in its folder, or the arm that its summary names; what is not found is no guess.
#[test]
fn the_workcell_is_that_of_the_run() {
    let (model, cell) = around("KR 6 R900-2");
    for run in ["recorded-name", "recorded-file", "recorded-lost"] {
        krl(run, &cell, KrlLines::Lin, steps(&cell, |_, _| {}));
    }
    let named = folder("recorded-name");
    file(&named, "summary.json", r#"{"workcell": "KR 6 R900-2", "cell": "KR 6 R900-2 (assumed workcell)"}"#);
    let summary = replayed("recorded-name", &[]);
    is_as_planned(&summary, "recorded-name");
    assert!(summary["findings"].as_str().unwrap().contains("that of the run, KR 6 R900-2"));
    let written = folder("recorded-file");
    let mut text = Vec::new();
    model.write_json(&mut text).unwrap();
    fs::write(written.join("workcell.json"), text).unwrap();
    is_as_planned(&replayed("recorded-file", &[]), "recorded-file");
    let lost = folder("recorded-lost");
    file(&lost, "summary.json", r#"{"workcell": "/nowhere/cell.json", "cell": "mine"}"#);
    let failure = run("recorded-lost", &[lost.to_str().unwrap()]).unwrap_err();
    assert!(failure.contains("was planned in the workcell `/nowhere/cell.json`, which is not found"), "{failure}");
    file(&lost, "summary.json", r#"{"workcell": "none", "cell": "mine"}"#);
    let failure = run("recorded-lost", &[lost.to_str().unwrap()]).unwrap_err();
    assert!(failure.contains("workcell `mine`, whose file it does not name"), "{failure}");
}
