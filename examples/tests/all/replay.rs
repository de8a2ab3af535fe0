//! The example `replay`: small programs of each format with known answers, the same with one fault each, bad input. `gcode` has plain G-code of a table, `machines`
//! programs of five-axis machines in flavours, `robots` those of KUKA and Fanuc arms and runs that have recorded their workcell.

mod gcode;
mod machines;
mod robots;

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../replay/main.rs"]
mod example;

use crate::common::{self, summary};
use clap::Parser;
use curvlay_examples::bars::Bars;
use curvlay_examples::nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::program::ConfData;
use curvlay_kinematics::workcell::AnyWorkcell;
use curvlay_kinematics::{Arm, Positioner};
use example::Args;
use serde_json::{Map, Value};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Width, height and speed of all beads here.
const WIDTH: f64 = 1.0;
const HEIGHT: f64 = 0.5;
const SPEED: f64 = 10.0;
/// Filament for a millimetre of them, of 1.75 mm.
const FEED: f64 = WIDTH * HEIGHT / (std::f64::consts::PI * 0.875 * 0.875);
/// A tick of a stream.
const TICK: f64 = 0.008;

/// Two paths side by side.
fn paths() -> [Vec<[f64; 3]>; 2] {
    let z = HEIGHT;
    [vec![[0.0, 0.0, z], [30.0, 0.0, z], [30.0, 15.0, z], [0.0, 15.0, z]], vec![[0.0, 20.0, z], [30.0, 20.0, z]]]
}

fn folder(name: &str) -> PathBuf {
    let folder = common::place("replay", "inputs").join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// A file, as a word of a command line.
fn file(folder: &Path, name: &str, text: &str) -> String {
    fs::write(folder.join(name), text).unwrap();
    folder.join(name).to_str().unwrap().to_owned()
}

fn cell(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("cells").join(name).to_str().unwrap().to_owned()
}

fn machine_file(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("machines/{name}.json")).to_str().unwrap().to_owned()
}

/// The plan in the part, as `curvlay_layers` has it.
fn plan(folder: &Path, of: &[Vec<[f64; 3]>], direction: impl Fn(&[f64; 3]) -> Vector3<f64>) -> String {
    let mut text = format!("G28\nG21\nG90\nM82\nG92 E0\n;WIDTH:{WIDTH}\n;HEIGHT:{HEIGHT}\n");
    let mut filament = 0.0;
    for path in of {
        for (k, at) in path.iter().enumerate() {
            let d = direction(at);
            let [x, y, z] = at;
            let _ = if k == 0 {
                writeln!(text, "G0 X{x} Y{y} Z{z} F4800 ;DIR:{} {} {}", d.x, d.y, d.z)
            } else {
                filament += FEED * (Vector3::from(*at) - Vector3::from(path[k - 1])).norm();
                writeln!(text, "G1 X{x} Y{y} Z{z} E{filament:.5} F600 ;DIR:{} {} {}", d.x, d.y, d.z)
            };
        }
    }
    file(folder, "plan.gcode", &text)
}

fn upright(_: &[f64; 3]) -> Vector3<f64> {
    Vector3::z()
}

/// Replays, and gives the summary.
fn run(name: &str, words: &[&str]) -> Result<Map<String, Value>, String> {
    let folder = common::folder("replay", name);
    let args = Args::try_parse_from(["replay"].iter().chain(words)).map_err(|error| error.to_string())?;
    example::work(&args, &Bars::new(true), &folder).map_err(|failure| failure.message().to_owned())?;
    Ok(summary(&common::place("replay", name)))
}

fn figure(summary: &Map<String, Value>, key: &str) -> f64 {
    summary[key].as_f64().unwrap_or_else(|| panic!("{key}"))
}

/// The failed findings, a line each, without their advice.
fn failed(summary: &Map<String, Value>) -> Vec<String> {
    let all = summary["findings"].as_str().unwrap().lines();
    all.filter_map(|line| line.strip_prefix("failed: ")).map(str::to_owned).collect()
}

fn has(summary: &Map<String, Value>, what: &str) -> bool {
    failed(summary).iter().any(|line| line.starts_with(what))
}

/// Joints of an arm in a cell of ours with the nozzle upright at places of the part, near to those before.
struct Postures {
    arm: Arm,
    base_part: Isometry3<f64>,
    flange_nozzle: Isometry3<f64>,
    last: [f64; 6],
}

impl Postures {
    fn new(name: &str, first: [f64; 6]) -> Self {
        Postures::of(&AnyWorkcell::from_json(fs::read(cell(name)).unwrap().as_slice()).unwrap(), first)
    }

    fn of(cell: &AnyWorkcell, first: [f64; 6]) -> Self {
        let equipment = cell.equipment();
        let table =
            equipment.positioner().map_or_else(Isometry3::identity, |table: &Positioner| table.forward(&[0.0; 2]));
        let (base_part, flange_nozzle) = (table * equipment.part_frame().1, equipment.nozzle_frame().1);
        Postures { arm: *equipment.arm(), base_part, flange_nozzle, last: first }
    }

    fn at(&mut self, place: &[f64; 3]) -> [f64; 6] {
        let part_nozzle = Isometry3::from_parts(Translation3::from(*place), UnitQuaternion::identity());
        let flange = self.base_part * part_nozzle * self.flange_nozzle.inverse();
        let all = self.arm.inverse(&flange).unwrap();
        let way = |q: &[f64; 6]| (0..6).map(|k| (q[k] - self.last[k]).abs()).sum::<f64>();
        let turn = std::f64::consts::TAU;
        let unwound = |q: &[f64; 6]| [0, 1, 2, 3, 4, 5].map(|k| q[k] + turn * ((self.last[k] - q[k]) / turn).round());
        let near = all.iter().map(|(_, q)| unwound(q)).min_by(|a, b| way(a).total_cmp(&way(b)));
        self.last = near.unwrap_or_else(|| panic!("{place:?} is out of reach"));
        self.last
    }
}

/// Places at ticks along straight ways from rest to rest, with the speed there.
fn ticks(from: &[f64; 3], to: &[f64; 3], speed: f64) -> Vec<([f64; 3], f64)> {
    // Evenly faster for a quarter of a second, as the jerk of joints wants a sine.
    let ramp = 0.4;
    let length = (Vector3::from(*to) - Vector3::from(*from)).norm();
    let even = (length / speed - ramp).max(0.0);
    let top = length / (even + ramp);
    let count = ((even + 2.0 * ramp) / TICK).ceil() as u32;
    let pace = |t: f64| {
        let rise = |t: f64| 0.5 - 0.5 * (std::f64::consts::PI * (t / ramp).clamp(0.0, 1.0)).cos();
        top * rise(t).min(rise(even + 2.0 * ramp - t))
    };
    let (mut passed, mut found) = (0.0, Vec::new());
    for k in 1..=count {
        let t = f64::from(k) * TICK;
        let step = 0.5 * (pace(t) + pace(t - TICK)) * TICK;
        passed = f64::min(passed + step, length);
        let share = if k == count { 1.0 } else { passed / length };
        found.push(([0, 1, 2].map(|c| from[c] + share * (to[c] - from[c])), pace(t)));
    }
    found
}

/// A stream for the UR10. `change` sees each tick: its number, joints and text of the signals before it.
fn urscript(mut change: impl FnMut(usize, &mut [f64; 6], &mut String)) -> String {
    let mut postures = Postures::new("ur10.json", [2.75, -1.35, 1.85, -1.7, -0.86, -0.52]);
    let above = |at: &[f64; 3]| [at[0], at[1], at[2] + 10.0];
    let mut ways: Vec<([f64; 3], [f64; 3], bool, f64)> = Vec::new();
    for path in paths() {
        let from = ways.last().map_or(above(&path[0]), |way| way.1);
        ways.push((from, above(&path[0]), false, 40.0));
        ways.push((above(&path[0]), path[0], false, 10.0));
        ways.extend(path.windows(2).map(|two| (two[0], two[1], true, SPEED)));
        let end = path[path.len() - 1];
        ways.push((end, above(&end), false, 10.0));
    }
    let first = postures.at(&ways[0].0);
    let list = |q: &[f64; 6]| q.map(|x| format!("{x:.9}")).join(",");
    let mut text = format!(
        "def print_001():\n  work=p[0.75,0,0,0,0,0]\n  set_tcp(p[0.064,0,0.154,0,0,0])\n  filament_full_scale=10.0\n  movej([{}],a=1.4,v=1,r=0)\n",
        list(&first)
    );
    // The arm is behind its stream by 0.03 s: four ticks.
    let mut late = std::collections::VecDeque::from([(false, 0.0); 4]);
    let (mut was_on, mut number) = (false, 0);
    for (from, to, lays, speed) in ways {
        if (Vector3::from(from) - Vector3::from(to)).norm() < 1e-9 {
            continue;
        }
        for (place, pace) in ticks(&from, &to, speed) {
            late.push_back((lays, pace));
            let (is_on, pace) = late.pop_front().unwrap();
            let mut signals = String::new();
            if is_on != was_on {
                let _ = writeln!(signals, "  set_standard_digital_out(0,{})", if is_on { "True" } else { "False" });
                was_on = is_on;
            }
            if is_on {
                let _ = writeln!(signals, "  set_standard_analog_out(0,{:.6}/filament_full_scale)", pace * FEED);
            }
            let mut joints = postures.at(&place);
            change(number, &mut joints, &mut signals);
            let _ = writeln!(text, "{signals}  servoj([{}],t=0.008,lookahead_time=0.03,gain=2000)", list(&joints));
            number += 1;
        }
    }
    text + "  set_standard_digital_out(0,False)\n  stopj(1.4)\nend\nprint_001()\n"
}

/// Replays a stream with its plan.
fn stream(name: &str, text: &str) -> Map<String, Value> {
    let inputs = folder(name);
    let (program, plan) = (file(&inputs, "print_001.script", text), plan(&inputs, &paths(), upright));
    run(name, &[&program, "--workcell", &cell("ur10.json"), "--plan", &plan]).unwrap()
}

#[test]
fn a_stream_is_what_was_planned() {
    let text = urscript(|_, _, _| {});
    let summary = stream("stream", &text);
    assert_eq!(failed(&summary), Vec::<String>::new());
    // All ticks but for what the arm needs to arrive.
    let planned = text.lines().filter(|line| line.contains("servoj")).count() as f64 * TICK;
    assert!((figure(&summary, "time_s") / planned - 1.0).abs() < 0.01, "{} {planned}", figure(&summary, "time_s"));
    assert!(figure(&summary, "tip_off_mm") < 0.25 * WIDTH && figure(&summary, "missed_mm") < 0.1);
    assert!((figure(&summary, "filament_mm") / figure(&summary, "planned_filament_mm") - 1.0).abs() < 0.01);
    assert!((figure(&summary, "planned_mm") - 105.0).abs() < 1e-6);
    let report = fs::read_to_string(common::place("replay", "stream").join("report.html")).unwrap();
    assert!(report.contains("class=\"viewer\"") && report.contains("Axes over time"));
}

#[test]
fn a_joint_that_is_flipped_by_a_turn_is_a_jump() {
    let text = urscript(|number, joints, _| {
        if number >= 800 {
            joints[5] += std::f64::consts::TAU;
        }
    });
    let summary = stream("flipped", &text);
    assert!(has(&summary, "an axis is faster than its limit: q6"), "{:?}", failed(&summary));
    assert!(summary["findings"].as_str().unwrap().contains("the program jumps"));
}

#[test]
fn a_joint_that_is_mirrored_puts_the_whole_program_off() {
    let summary = stream("mirrored", &urscript(|_, joints, _| joints[4] = -joints[4]));
    assert!(
        has(&summary, "the tip is off the planned path") || has(&summary, "planned ways are left out"),
        "{:?}",
        failed(&summary)
    );
}

#[test]
fn ticks_that_are_lost_are_a_jerk() {
    let mut lines: Vec<String> = urscript(|_, _, _| {}).lines().map(str::to_owned).collect();
    let first = lines.iter().position(|line| line.contains("set_standard_digital_out(0,False)")).unwrap() + 60;
    lines.drain(first..first + 20);
    let summary = stream("lost-ticks", &(lines.join("\n") + "\n"));
    assert!(
        has(&summary, "an axis accelerates more") || has(&summary, "the jerk of an axis"),
        "{:?}",
        failed(&summary)
    );
}

#[test]
fn an_extruder_that_is_never_switched_off_is_heard() {
    let text = urscript(|_, _, _| {}).replace("set_standard_digital_out(0,False)", "set_standard_digital_out(0,True)");
    let summary = stream("never-off", &text);
    assert!(has(&summary, "the extruder runs when the program ends"), "{:?}", failed(&summary));
    assert!(has(&summary, "the extruder runs between planned paths"), "{:?}", failed(&summary));
}

/// A RAPID program for the arm over the table, which stands still. `change` sees the number of each line and its zone.
fn rapid(mut change: impl FnMut(usize, &str, [f64; 3]) -> Option<String>) -> String {
    let mut postures = Postures::new("irb1200-table.json", [0.0, 0.4, 0.4, 0.0, 0.7, 0.0]);
    let mut text = String::from(
        "MODULE print\n  PERS tooldata nozzle:=[TRUE,[[0,0,150],[1,0,0,0]],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]];\n  \
         PERS wobjdata part:=[FALSE,FALSE,\"STN1\",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n  PROC main()\n    PathAccLim TRUE\\AccMax:=2,TRUE\\DecelMax:=2;\n",
    );
    let mut number = 0;
    for path in paths() {
        let above = [path[0][0], path[0][1], path[0][2] + 10.0];
        let q = postures.at(&above).map(|x| format!("{:.6}", x.to_degrees())).join(",");
        let _ = writeln!(text, "    MoveAbsJ [[{q}],[0,0,9E9,9E9,9E9,9E9]],[40,60,5000,1000],fine,nozzle\\WObj:=part;");
        let places = std::iter::once((path[0], "fine"));
        let last = path.len() - 1;
        let places =
            places.chain(path[1..].iter().enumerate().map(|(k, at)| (*at, if k + 1 == last { "fine" } else { "z0" })));
        for (k, (at, zone)) in places.enumerate() {
            let joints = postures.at(&at);
            let ConfData { cf1, cf4, cf6, cfx } = ConfData::of(&postures.arm, &joints);
            let [x, y, z] = at;
            // The tool has z along the flow: half a turn about x from the part.
            let target = format!("[[{x},{y},{z}],[0,1,0,0],[{cf1},{cf4},{cf6},{cfx}],[0,0,9E9,9E9,9E9,9E9]]");
            let line = format!("    MoveL {target},[10,60,5000,1000],{zone},nozzle\\WObj:=part;\n");
            text += &change(number, &line, at).unwrap_or(line);
            number += 1;
            if k == 0 {
                let _ = writeln!(text, "    SetAO aoFilament,{:.6};\n    SetDO doExtruder,1;", SPEED * FEED);
            }
        }
        text += "    SetDO doExtruder,0;\n";
        let end = path[last];
        let q = postures.at(&[end[0], end[1], end[2] + 10.0]).map(|x| format!("{:.6}", x.to_degrees())).join(",");
        let _ = writeln!(text, "    MoveAbsJ [[{q}],[0,0,9E9,9E9,9E9,9E9]],[40,60,5000,1000],fine,nozzle\\WObj:=part;");
    }
    text + "  ENDPROC\nENDMODULE\n"
}

fn rapid_run(name: &str, text: &str, more: &[&str]) -> Map<String, Value> {
    let inputs = folder(name);
    let (program, plan) = (file(&inputs, "print.mod", text), plan(&inputs, &paths(), upright));
    let cell = cell("irb1200-table.json");
    run(name, &[&[program.as_str(), "--workcell", &cell, "--plan", &plan], more].concat()).unwrap()
}

#[test]
fn rapid_is_what_was_planned() {
    let summary = rapid_run("rapid", &rapid(|_, _, _| None), &["--allow-time", "0.15"]);
    assert_eq!(failed(&summary), Vec::<String>::new());
    // z0 is a zone of 0.3 mm: the parabola is an eighth of the diagonal away from its corner.
    let off = figure(&summary, "tip_off_mm");
    assert!(off > 0.02 && off < 0.3 / 2.0, "{off}");
    assert_eq!((figure(&summary, "targets_missed"), figure(&summary, "targets_turned")), (0.0, 0.0));
}

#[test]
fn a_zone_that_is_too_wide_cuts_its_corner() {
    let text = rapid(|_, line, at| (at == [30.0, 0.0, HEIGHT]).then(|| line.replace(",z0,", ",[FALSE,6,6,6,1,6,1],")));
    let summary = rapid_run("zone", &text, &["--allow-time", "0.15"]);
    assert!(has(&summary, "the tip is off the planned path"), "{:?}", failed(&summary));
    assert!(summary["findings"].as_str().unwrap().contains("in a blend that reaches"), "{}", summary["findings"]);
    // By the parabola: a quarter of the diagonal of a square of 6 mm from the corner, which is 6 / 4 off either line.
    assert!((figure(&summary, "tip_off_mm") - 1.5).abs() < 0.15 || figure(&summary, "tip_off_share") > 0.9);
}

#[test]
fn a_target_that_is_lost_leaves_ways_out() {
    let text = rapid(|_, _, at| (at == [30.0, 15.0, HEIGHT]).then(String::new));
    let summary = rapid_run("lost", &text, &["--allow-time", "1"]);
    assert!(has(&summary, "planned ways are left out"), "{:?}", failed(&summary));
}

#[test]
fn a_whole_turn_in_the_configuration_is_another_posture() {
    let text = rapid(|number, line, _| {
        let (head, conf) = line.split_once("[0,1,0,0],[")?;
        let mut cells = conf.splitn(4, ',');
        let (cf1, cf4, cf6, rest) = (cells.next()?, cells.next()?, cells.next()?, cells.next()?);
        let cf6: i32 = cf6.parse().ok()?;
        (number == 2).then(|| format!("{head}[0,1,0,0],[{cf1},{cf4},{},{rest}", cf6 + 4))
    });
    let summary = rapid_run("turned", &text, &["--allow-time", "0.15"]);
    assert!(has(&summary, "targets are reached in other quarter turns"), "{:?}", failed(&summary));
}

#[test]
fn bad_input_is_one_line_with_its_place() {
    let inputs = folder("bad");
    let failure = |words: &[&str]| run("bad", words).unwrap_err();
    let write = |name: &str, text: &str| file(&inputs, name, text);
    let waits = format!("G0 X0 Y0 Z5 F100\n{}", "G4 S3600\n".repeat(30));
    assert!(
        failure(&[&write("waits.gcode", &waits)])
            .contains("waits.gcode: line 26: with this wait the program has waited for 90000 s")
    );
    let none = write("none.gcode", "; nothing\n");
    assert!(failure(&[&none]).ends_with("none.gcode: there are no moves in it"));
    let arc = write("arc.gcode", "G0 X0 Y0 Z0 F100\nG2 X1 Y1 I1\n");
    assert!(failure(&[&arc]).contains("arc.gcode: line 2: G2 is not modelled"));
    let script = write("a.script", "def a(\n");
    assert!(failure(&[&script]).contains("a.script: line 1"));
    assert!(failure(&[&script, &arc]).contains("is of another format"));
    let other = write("notes.txt", "");
    assert!(failure(&[&other]).contains("is no program by its name"));
    assert!(failure(&["/nowhere/a.gcode"]).contains("/nowhere/a.gcode"));
    let empty = folder("bad/empty");
    assert!(failure(&[empty.to_str().unwrap()]).contains("has no program"));
    let part = write("print_001.mod", "");
    assert!(failure(&[&part, &part]).contains("RAPID is replayed from its main file"));
    let good = write("good.gcode", "G0 X0 Y0 Z5 F100\nG1 X1 E1 F60\n");
    let machine = write("machine.json", "{}");
    assert!(failure(&[&good, "--machine", &machine]).contains("missing field `version`"));
    assert!(failure(&[&good, "--workcell", &cell("ur3.json")]).contains("--workcell is for robot programs"));
    assert!(failure(&[&good, "--plan", &good, "--nozzle", "1,95,8,20"]).contains("half angle"));
    let plan = write("plan.gcode", "G1 X0 Y0 Z0 ;DIR:0 0\n");
    assert!(failure(&[&good, "--plan", &plan]).contains("plan.gcode: line 1: `DIR:0 0` is no direction"));
    let axes = write("toolpath-axes.gcode", "G0 X0 Y0 Z5 F100\n");
    assert!(
        failure(&[&axes]).contains("toolpath-axes.gcode: is for a five-axis machine: name its file with --machine")
    );
    let bc = machine_file("bc-table-tcp");
    assert!(failure(&[&good, "--machine", &bc, "--flavour", "klingon"]).contains("`klingon` is no G-code flavour"));
    assert!(failure(&[&good, "--machine", &bc, "--flavour", "marlin"]).contains("neither axes nor directions"));
    assert!(
        failure(&[&good, "--machine", &bc]).contains("(read as `linuxcnc-tcp`"),
        "{}",
        failure(&[&good, "--machine", &bc])
    );
    let polar = machine_file("polar-tilting-head");
    assert!(failure(&[&good, "--machine", &polar, "--flavour", "siemens"]).contains("a polar machine cannot follow"));
    for words in [
        ["--rate", "0"],
        ["--speed", "-1"],
        ["--part-shift", "1"],
        ["--allow-tip", "NaN"],
        ["--gain", "99"],
        ["--gain", "2001"],
        ["--lookahead-time", "0.02"],
        ["--lookahead-time", "0.21"],
    ] {
        assert!(run("bad", &[&[good.as_str()], words.as_slice()].concat()).is_err(), "{words:?}");
    }
}
