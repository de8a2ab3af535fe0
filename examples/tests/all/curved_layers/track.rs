//! An arm on a track: a wall that is longer than the arm reaches, its programs, and what is refused.

use super::*;
use curvlay_kinematics::program::{read_krl, read_tp};

const CELL: &str = include_str!("../../../cells/irb120-track.json");

/// The wall: 1.2 m along the track, one layer of it.
const WALL: [f32; 3] = [9.0, 1200.0, 3.0];

const COMMON: [&str; 6] = ["--cell", "3", "--stage", "motion", "--support", "none"];

/// The file of the cell, changed.
fn cell(scratch: &Scratch, name: &str, change: impl FnOnce(&mut Value)) -> String {
    let mut model: Value = serde_json::from_str(CELL).unwrap();
    change(&mut model);
    let path = scratch.path(name);
    fs::write(&path, model.to_string()).unwrap();
    path
}

/// Where the track is at each line of a program, in mm.
fn places(steps: impl IntoIterator<Item = Step>) -> Vec<f64> {
    let moves = steps.into_iter().filter_map(|step| if let Step::Move(to) = step { Some(to) } else { None });
    moves.map(|to| to.table.and_then(|axes| axes.track_mm()).unwrap()).collect()
}

fn ends(values: &[f64]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| [low.min(value), high.max(value)])
}

#[test]
fn a_wall_longer_than_the_arm_reaches_is_printed_from_a_track() {
    let scratch = Scratch::new("track");
    let file = cell(&scratch, "cell.json", |_| ());
    let out = scratch.path("out");
    let figures = block(WALL, &out, &[&COMMON[..], &["--workcell", &file]].concat());
    documented(&out);
    let figure = |key: &str| figures[key].as_f64().unwrap();
    for key in ["unreachable_waypoints", "blocked_waypoints", "breaks", "astray", "without_transfer", "check_findings"]
    {
        assert_eq!(figures[key].as_u64(), Some(0), "{key}");
    }
    assert!(figure("unprinted_mm") < 1e-6 && figures["program_not_at_home"] == 0);
    assert!(figure("program_off_mm") < 0.01, "{}", figure("program_off_mm"));
    // The track goes along, within its range, speed and acceleration.
    let text = fs::read_to_string(Path::new(&out).join("trajectory.csv")).unwrap();
    let column = text.lines().next().unwrap().split(',').position(|name| name == "track_mm").unwrap();
    let on_way: Vec<f64> =
        text.lines().skip(1).map(|line| line.split(',').nth(column).unwrap().parse().unwrap()).collect();
    let [low, high] = ends(&on_way);
    assert!(low >= 0.0 && high <= 1400.0 && high - low > 200.0, "{low} {high}");
    assert!(figure("max_velocity_track_mm_s") <= 1000.0 && figure("max_velocity_track_mm_s") > 10.0);
    assert!(figure("max_acceleration_track_mm_s2") <= 2000.0 && figure("max_jerk_track_mm_s3") <= 20_000.0);
    assert!(figures.get("max_velocity_q7_rad_s").is_none());
    // The program goes to the same places.
    let open = |name: &str| fs::File::open(Path::new(&out).join(name)).map(BufReader::new);
    let steps = read_rapid(open("print.mod").unwrap(), open).unwrap().map(Result::unwrap);
    let [least, most] = ends(&places(steps));
    assert!(least >= low - 1e-3 && most <= high + 1e-3 && most - least > 200.0, "{least} {most}");
}

/// The same arm with its base in the middle does not reach the ends.
#[test]
fn the_arm_alone_does_not_reach_the_ends_of_the_wall() {
    let scratch = Scratch::new("no-track");
    let file = cell(&scratch, "cell.json", |model| {
        model.as_object_mut().unwrap().remove("track");
        let solids = model["solids"].as_array_mut().unwrap();
        solids.retain(|solid| solid["mount"] != "rail" && solid["mount"] != "carriage");
    });
    let (mesh, out) = (scratch.path("wall.stl"), scratch.path("out"));
    fs::write(&mesh, boxes(&[[[0.0; 3], WALL]])).unwrap();
    let output = run(&[&["--mesh", &mesh, "--quiet", "--out", &out], &COMMON[..], &["--workcell", &file]].concat());
    assert_eq!(output.status.code(), Some(3), "{}", String::from_utf8_lossy(&output.stderr));
    let figures = summary(&out);
    assert!(figures["unreachable_waypoints"].as_u64().unwrap() > 0);
    assert!(figures["unprinted_mm"].as_f64().unwrap() > 500.0);
}

/// A short wall, in the other languages.
#[test]
fn a_track_is_in_programs_of_other_makers() {
    let scratch = Scratch::new("track-programs");
    let file = cell(&scratch, "cell.json", |_| ());
    let run_in = |language: &str| {
        let out = scratch.path(language);
        block([9.0, 60.0, 3.0], &out, &[&COMMON[..], &["--workcell", &file, "--program", language]].concat());
        out
    };
    let out = run_in("krl");
    let open = |name: &str| fs::File::open(Path::new(&out).join(name)).map(BufReader::new);
    let steps = read_krl(open("print.dat").unwrap(), open("print.src").unwrap(), open).unwrap().map(Result::unwrap);
    let krl = places(steps);
    let out = run_in("tp");
    let open = |name: &str| fs::File::open(Path::new(&out).join(name)).map(BufReader::new);
    assert!(fs::read_to_string(Path::new(&out).join("print_001.ls")).unwrap().contains("\tE1= "));
    let tp = places(read_tp(open("print.ls").unwrap(), open).unwrap().map(Result::unwrap));
    assert!(krl.len() > 4 && krl.len() == tp.len() && krl.iter().zip(&tp).all(|(a, b)| (a - b).abs() < 1e-3));
    let out = run_in("csv");
    let csv = fs::File::open(Path::new(&out).join("print_001.csv")).unwrap();
    let csv = places(CsvReader::new(BufReader::new(csv)).unwrap().map(Result::unwrap));
    assert!(csv.iter().zip(&tp).all(|(a, b)| (a - b).abs() < 1e-3));
}

#[test]
fn what_a_track_cannot_be_is_said() {
    let scratch = Scratch::new("bad-track");
    let mesh = scratch.path("block.stl");
    fs::write(&mesh, boxes(&[[[0.0; 3], [9.0, 9.0, 3.0]]])).unwrap();
    let said = |file: &str, more: &[&str]| {
        let out = scratch.path("out");
        let output =
            run(&[&["--mesh", &mesh, "--quiet", "--out", &out, "--workcell", file], &COMMON[..], more].concat());
        assert!(!Path::new(&out).exists());
        status_and_line(&output)
    };
    let ur = cell(&scratch, "ur.json", |model| model["arm"]["geometry"]["named"] = "UR5e".into());
    let (status, line) = said(&ur, &["--program", "urscript"]);
    assert!(status == 2 && line.contains("URScript has no external axis") && line.contains("krl"), "{status} {line}");
    let slow = cell(&scratch, "slow.json", |model| model["track"]["max_speed_mm_s"] = 0.into());
    let (status, line) = said(&slow, &[]);
    assert!(status == 1 && line.contains("track.max_speed_mm_s is 0: it must be above 0"), "{status} {line}");
    let far = cell(&scratch, "far.json", |model| model["part"]["position_mm"][1] = 5000.into());
    let (status, line) = said(&far, &[]);
    assert!(status == 1 && line.contains("track.range_mm: stretched out, the arm reaches"), "{status} {line}");
    let open = cell(&scratch, "open.json", |model| {
        model["track"].as_object_mut().unwrap().remove("range_mm");
    });
    let (status, line) = said(&open, &[]);
    assert!(status == 1 && line.contains("missing field `range_mm`"), "{status} {line}");
}
