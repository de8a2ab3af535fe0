//! Programs of five-axis machines in flavours of G-code: as they are planned, and with a pivot that is off.

use super::*;
use curvlay_examples::axis_program::{axes_of, write_axis_program};
use curvlay_examples::nalgebra::UnitVector3;
use curvlay_kinematics::machine::{AxisPlanOptions, FiveAxis, MachineModel};
use curvlay_toolpath::gcode::flavour::{Flavour, ProgramOptions, write_flavour};
use curvlay_toolpath::gcode::{Move, RotaryTable};
use std::f64::consts::TAU;

/// Height where a helix begins, lift of the nozzle between two, turns of each, sides of a turn, radius at the plate, speed.
const FLOOR: f64 = 0.5;
const LIFT: f64 = 4.0;
const TURNS: u32 = 3;
const SIDES: u32 = 72;
const RADIUS: f64 = 30.0;
const PRINTING: f64 = 8.0;

/// A helix up a cone: places, and directions that lean outwards.
fn helix(number: u32) -> Vec<(Point3<f64>, UnitVector3<f64>)> {
    let at = |k: u32| {
        let turns = f64::from(k) / f64::from(SIDES);
        let (turn, layer) = (TAU * turns, f64::from(number * TURNS) + turns);
        let (z, radius) = (FLOOR + HEIGHT * layer, RADIUS + 0.1 * layer);
        let direction = Vector3::new(0.15 * turn.cos(), 0.15 * turn.sin(), 1.0);
        (Point3::new(radius * turn.cos(), radius * turn.sin(), z), UnitVector3::new_normalize(direction))
    };
    (0..=TURNS * SIDES).map(at).collect()
}

/// Two helices above each other, with a way up and down between them.
fn cone() -> Vec<Move> {
    let mut moves = Vec::new();
    for number in 0..2 {
        let helix = helix(number);
        let lifted = |(tip, direction): (Point3<f64>, UnitVector3<f64>)| tip + direction.into_inner() * LIFT;
        let travel =
            |tip: Point3<f64>, direction: UnitVector3<f64>, feed_mm_s: f64| Move::Travel { tip, direction, feed_mm_s };
        let (first, last) = (helix[0], helix[helix.len() - 1]);
        moves.extend([travel(lifted(first), first.1, 40.0), travel(first.0, first.1, 20.0)]);
        for two in helix.windows(2) {
            let (tip, direction) = two[1];
            let filament_mm = FEED * (tip - two[0].0).norm();
            moves.push(Move::Print { tip, direction, filament_mm, feed_mm_s: PRINTING });
        }
        moves.push(travel(lifted(last), last.1, 40.0));
    }
    moves
}

/// The plan of it.
fn plan_of_cone(folder: &Path) -> String {
    let mut text = format!("G28\nG21\nG90\nM83\n;WIDTH:{WIDTH}\n;HEIGHT:{HEIGHT}\n");
    for item in cone() {
        let (Move::Travel { tip, direction, .. } | Move::Print { tip, direction, .. }) = item else { continue };
        let filament =
            if let Move::Print { filament_mm, .. } = item { format!(" E{filament_mm:.6}") } else { String::new() };
        let word = if filament.is_empty() { "G0" } else { "G1" };
        let (x, y, z, d) = (tip.x, tip.y, tip.z, direction);
        let _ = writeln!(text, "{word} X{x:.5} Y{y:.5} Z{z:.5}{filament} F600 ;DIR:{:.6} {:.6} {:.6}", d.x, d.y, d.z);
    }
    file(folder, "plan.gcode", &text)
}

/// The program of a machine, changed before it is planned for.
fn program(name: &str, flavour: &str, change: impl FnOnce(&mut MachineModel)) -> String {
    let mut model = MachineModel::from_json(fs::read(machine_file(name)).unwrap().as_slice()).unwrap();
    change(&mut model);
    let machine = FiveAxis::new(model).unwrap();
    let flavour = Flavour::built_in(flavour).unwrap().for_machine(&axes_of(&machine));
    let mut file = Vec::new();
    write_axis_program(&machine, cone(), &flavour, AxisPlanOptions::default(), &ProgramOptions::default(), &mut file)
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    String::from_utf8(file).unwrap()
}

fn replayed(run_name: &str, text: &str, words: &[&str]) -> Map<String, Value> {
    let inputs = folder(run_name);
    let (program, plan) = (file(&inputs, "toolpath-axes.gcode", text), plan_of_cone(&inputs));
    run(run_name, &[&[program.as_str(), "--plan", &plan], words].concat())
        .unwrap_or_else(|error| panic!("{run_name}: {error}"))
}

/// Machines of four families, each in a flavour that its controller reads: under control of the tip and without, with times, feeds, axes by other letters. The head
/// whose first axis turns twice to and fro lifts off to turn back: from rest to rest, which is a larger share of a part of two minutes.
#[test]
fn programs_of_machines_are_what_was_planned() {
    for (name, flavour, share) in [
        ("open5x-table", "reprapfirmware", "0.01"),
        ("open5x-table", "klipper-axes", "0.01"),
        ("bc-table-tcp", "linuxcnc-tcp", "0.01"),
        ("bc-table-tcp", "siemens-axes", "0.01"),
        ("klipper-tilting-head", "klipper-axes", "0.01"),
        ("polar-tilting-head", "reprapfirmware", "0.01"),
        ("head-head-gantry", "linuxcnc", "0.04"),
        ("head-head-gantry", "linuxcnc-g94", "0.04"),
        ("head-head-gantry", "linuxcnc-flow", "0.04"),
    ] {
        let run_name = format!("{name}-{flavour}");
        let text = program(name, flavour, |_| {});
        let words = ["--machine", &machine_file(name), "--flavour", flavour, "--allow-time", share];
        let summary = replayed(&run_name, &text, &words);
        assert_eq!(failed(&summary), Vec::<String>::new(), "{run_name}");
        assert!(figure(&summary, "tip_off_mm") < 0.1 && figure(&summary, "contacts") < 0.5, "{run_name}");
        assert!(figure(&summary, "tilt_off_deg") < 1.0, "{run_name} {}", figure(&summary, "tilt_off_deg"));
        assert!(figure(&summary, "missed_mm") < 0.1 && figure(&summary, "extruded_mm") > 1100.0, "{run_name}");
        assert_eq!(summary["format"], format!("G-code, {flavour}"));
    }
}

/// A switch says when material comes out, not how much.
#[test]
fn a_flavour_without_amounts_is_compared_by_its_way() {
    let text = program("head-head-gantry", "linuxcnc-switch", |_| {});
    let words =
        ["--machine", &machine_file("head-head-gantry"), "--flavour", "linuxcnc-switch", "--allow-time", "0.04"];
    let summary = replayed("switch", &text, &words);
    assert_eq!(failed(&summary), Vec::<String>::new());
    assert!(figure(&summary, "tip_off_mm") < 0.1 && figure(&summary, "capsules") > 400.0);
    assert!(summary["findings"].as_str().unwrap().contains("says when material comes out, not how much"));
}

/// The controller turns vectors into axes.
#[test]
fn directions_are_followed() {
    for flavour in ["siemens", "heidenhain"] {
        let mut text = Vec::new();
        write_flavour(cone(), &Flavour::built_in(flavour).unwrap(), &ProgramOptions::default(), &mut text).unwrap();
        let words = ["--machine", &machine_file("bc-table-tcp"), "--flavour", flavour];
        let summary = replayed(flavour, &String::from_utf8(text).unwrap(), &words);
        assert_eq!(failed(&summary), Vec::<String>::new(), "{flavour}");
        assert!(figure(&summary, "tip_off_mm") < 0.1 && figure(&summary, "tilt_off_deg") < 1.0, "{flavour}");
        assert!((figure(&summary, "targets_missed")).abs() < 0.5, "{flavour}");
    }
}

/// The machine is not as the program was planned for: its first, its second pivot or its tip is off by 2 mm.
#[test]
fn a_pivot_that_is_off_by_two_millimetres_is_caught() {
    for (name, flavour) in
        [("open5x-table", "reprapfirmware"), ("head-head-gantry", "linuxcnc"), ("polar-tilting-head", "reprapfirmware")]
    {
        for axis in 0..2 {
            let run_name = format!("{name}-off-{axis}");
            let text = program(name, flavour, |model| {
                // Across its axis: along it a pivot says nothing.
                let across = if model.rotary[axis].axis[0].abs() < 0.5 { 0 } else { 2 };
                model.rotary[axis].point_mm.as_mut().unwrap()[across] += 2.0;
            });
            let summary = replayed(&run_name, &text, &["--machine", &machine_file(name), "--flavour", flavour]);
            assert!(
                has(&summary, "the tip is off the planned path") || has(&summary, "planned ways are left out"),
                "{run_name} {:?}",
                failed(&summary)
            );
        }
    }
}

/// In a folder the file of the machine is taken, with the time that the run has planned and its flavour.
#[test]
fn the_folder_of_a_run_is_taken() {
    let inputs = folder("machine-folder");
    let text = program("open5x-table", "reprapfirmware", |_| {});
    file(&inputs, "toolpath-axes.gcode", &text);
    fs::rename(plan_of_cone(&inputs), inputs.join("toolpath.gcode")).unwrap();
    file(&inputs, "summary.json", r#"{"five_axis_time_s": 1.0, "flavour": "none", "platform_diameter_mm": 60.0}"#);
    let words = [inputs.to_str().unwrap(), "--machine", &machine_file("open5x-table")];
    let summary = run("machine-folder", &words).unwrap();
    assert!(has(&summary, "the program takes another time than planned"), "{:?}", failed(&summary));
    assert_eq!(failed(&summary).len(), 1, "{:?}", failed(&summary));
    assert!((figure(&summary, "planned_s") - 1.0).abs() < 1e-12 && figure(&summary, "missed_mm") < 0.1);
}

/// Loops of a wall of half a kilometre, 150 by 100 mm, 0.3 mm a layer, in steps of half a millimetre at 40 mm/s; the table tilts by 5 degrees and turns to and fro.
/// The plan, and the program for the table.
fn wall(moves: u32) -> [String; 2] {
    const STEP: f64 = 0.5;
    let table = RotaryTable::default();
    let sides = [
        (0.0, 0.0, 1.0, 0.0, 150.0),
        (150.0, 0.0, 0.0, 1.0, 100.0),
        (150.0, 100.0, -1.0, 0.0, 150.0),
        (0.0, 100.0, 0.0, -1.0, 100.0),
    ];
    let place = |k: u32| {
        let (layer, mut way) = (k / 1000, STEP * f64::from(k % 1000));
        let z = 0.3 * f64::from(layer + 1);
        for (x, y, dx, dy, length) in sides {
            if way < length {
                return Point3::new(x + dx * way - 75.0, y + dy * way - 50.0, z);
            }
            way -= length;
        }
        unreachable!("a loop is 500 mm long")
    };
    let filament = FEED * STEP * 0.3 / HEIGHT;
    let [mut plan, mut program] = ["G21\nG90\nM83\n;WIDTH:1\n;HEIGHT:0.3\n".to_owned(), "G21\nG90\nM83\n".to_owned()];
    for k in 0..=moves {
        let angles = [5f64.to_radians(), 20f64.to_radians() * (TAU * f64::from(k) / 1000.0).sin()];
        let (at, p) = (place(k), table.machine_point(&place(k), angles));
        let d = table.part_point(&Point3::origin(), angles).1;
        let (word, more) = if k == 0 { ("G0", String::new()) } else { ("G1", format!(" E{filament:.5}")) };
        let [b, c] = angles.map(f64::to_degrees);
        let _ = writeln!(
            plan,
            "{word} X{:.4} Y{:.4} Z{:.4}{more} F2400 ;DIR:{:.6} {:.6} {:.6}",
            at.x, at.y, at.z, d.x, d.y, d.z
        );
        let feed = if k == 0 { "F2400\nG93" } else { "F4800" };
        let _ = writeln!(program, "{word} X{:.4} Y{:.4} Z{:.4} B{b:.5} C{c:.5}{more} {feed}", p.x, p.y, p.z);
    }
    [plan, program]
}

fn wall_replayed(name: &str, moves: u32) -> Map<String, Value> {
    let inputs = folder(name);
    let [plan, program] = wall(moves);
    file(&inputs, "toolpath.gcode", &plan);
    let program = file(&inputs, "toolpath-bc.gcode", &program);
    let summary = run(name, &[&program]).unwrap();
    assert_eq!(failed(&summary), Vec::<String>::new());
    assert_eq!(summary["moves"].as_u64(), Some(u64::from(moves) + 1));
    assert!(figure(&summary, "tip_off_mm") < 0.1 && figure(&summary, "missed_mm") < 1.0);
    summary
}

#[test]
fn a_wall_of_many_moves_is_what_was_planned() {
    wall_replayed("wall", 5000);
}

/// The program of docs/benchmarks.md, which this leaves in the folder of tests.
#[test]
#[ignore = "takes half a minute: a million moves, the row of docs/benchmarks.md"]
fn a_million_moves_are_what_was_planned() {
    wall_replayed("million", 1_000_000);
}
