//! The motion of a robot and its programs.

use super::*;
use curvlay_kinematics::workcell::Workcell;

/// Where `kind` stands in `trajectory.csv` of a UR3; `layer`, `path`, `waypoint` and `filament_mm` follow.
const KIND: usize = 8;

/// A small block in the hand of a UR3: every waypoint is met, nothing touches, every layer is reached.
#[test]
fn a_robot_prints_a_block() {
    let scratch = Scratch::new("motion");
    let out = scratch.path("out");
    let (size, common) = ([16.0, 12.0, 4.0], ["--cell", "2", "--stage", "motion"]);
    let figures = block(size, &out, &common);
    documented(&out);
    let count = |key: &str| figures[key].as_u64().unwrap();
    assert_eq!((count("motions"), count("transfers"), count("without_transfer")), (2, 1, 0));
    assert_eq!((count("unreachable_waypoints"), count("blocked_waypoints"), count("breaks")), (0, 0, 0));
    assert_eq!((count("check_findings"), count("collisions"), count("astray")), (0, 0, 0));
    assert!(figures["waypoint_error_mm"].as_f64().unwrap() < 1e-6);
    // 768 mm3 at 8 mm3/s are 96 s less what no bead covers; its time rises from line to line.
    let text = fs::read_to_string(Path::new(&out).join("trajectory.csv")).unwrap();
    let lines: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let times: Vec<f64> = lines.iter().map(|line| line[1].parse().unwrap()).collect();
    assert!(times.windows(2).all(|pair| pair[0] <= pair[1]));
    let robot_s = figures["robot_time_s"].as_f64().unwrap();
    assert!((times[times.len() - 1] - robot_s).abs() < 1e-3 && robot_s > 0.95 * 96.0);
    let passed: Vec<&str> = lines.iter().map(|line| line[KIND + 3]).filter(|waypoint| !waypoint.is_empty()).collect();
    assert_eq!(passed.len() as u64, count("waypoints"));
    let kinds: Vec<&str> = lines.chunk_by(|a, b| a[0] == b[0]).map(|motion| motion[0][KIND]).collect();
    let [to, between, back] =
        [&["transfer", "approach", "print"][..], &["lift", "transfer", "approach", "print"], &["lift", "transfer"]];
    assert_eq!(kinds, [to, between, back].concat());
    assert!(["motion-faults.csv", "motion-check.csv"].iter().all(|name| !Path::new(&out).join(name).exists()));
    // All of the filament of the machine file, as fast as the tip goes.
    let laid: f64 = lines[lines.len() - 1][KIND + 4].parse().unwrap();
    assert!((laid - figures["filament_mm"].as_f64().unwrap()).abs() < 1e-3, "{laid}");
    // Bug: the viewer of a motion had a volume of its own.
    let page = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
    let shown_cm3: f64 = page.split("\"volume\":").nth(1).unwrap().split([',', '}']).next().unwrap().parse().unwrap();
    let laid_cm3 = laid * std::f64::consts::PI * 1.75 * 1.75 / 4.0 / 1000.0;
    assert!((shown_cm3 / laid_cm3 - 1.0).abs() < 1e-6, "{shown_cm3} {laid_cm3}");

    layers_add_up(&out, &figures);
    let steps = steps_of(&Path::new(&out).join("print_001.script"));
    the_program_is_the_motion(&steps, &lines, &figures);
    the_filament_is_pushed(&steps, laid, &figures);
    let bytes = fs::metadata(Path::new(&out).join("print_001.script")).unwrap().len();
    assert_eq!((count("program_files"), count("program_bytes")), (1, bytes));

    // Streamed, the stand-in of a controller runs all of it.
    let output = common::example("stream_print").args([&out, "--dry-run"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let ticks = stream_of(&steps).len();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.starts_with(&format!("{ticks} ticks, ")) && said.contains(&format!("ran {ticks} ticks")), "{said}");

    // In small files the steps are the same, but for the way to the first posture of each.
    let cut = scratch.path("cut");
    block(size, &cut, &[&common[..], &["--program-steps", "1000"]].concat());
    small_files_have_the_same_steps(&cut, &steps);
}

/// The steps of a program, read again.
fn steps_of(file: &Path) -> Vec<Step> {
    let reader = UrScriptReader::new(BufReader::new(fs::File::open(file).unwrap())).unwrap();
    reader.collect::<Result<Vec<Step>, _>>().unwrap()
}

/// The joints of a tick.
fn servo(step: &Step) -> Option<[f64; 6]> {
    if let Step::Servo { joints, seconds: 0.008 } = step { Some(*joints) } else { None }
}

/// Where a program begins, and all of its ticks.
fn stream_of(steps: &[Step]) -> Vec<[f64; 6]> {
    let Step::Move(Move { goal: Goal::Joints(first), .. }) = steps[0] else { panic!("{:?}", steps[0]) };
    [first].into_iter().chain(steps.iter().filter_map(servo)).collect()
}

fn apart(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// `layers.csv`: a line a layer, which add up to the whole.
fn layers_add_up(out: &str, figures: &Value) {
    let layers = fs::read_to_string(Path::new(out).join("layers.csv")).unwrap();
    let column = |name: &str| {
        let at = layers.lines().next().unwrap().split(',').position(|known| known == name).unwrap();
        layers.lines().skip(1).map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect::<Vec<f64>>()
    };
    assert_eq!((column("layer"), column("motions"), column("faults")), (vec![1.0, 2.0], vec![1.0; 2], vec![0.0; 2]));
    assert_eq!(column("waypoints").iter().sum::<f64>() as u64, figures["waypoints"].as_u64().unwrap());
    assert!((column("robot_s").iter().sum::<f64>() - figures["robot_time_s"].as_f64().unwrap()).abs() < 0.01);
    let shares = column("realtime_factor");
    let taken: Vec<f64> = ["plan_s", "transfers_s"].iter().map(|name| column(name)[0]).collect();
    assert!((taken.iter().sum::<f64>() / column("robot_s")[0] - shares[0]).abs() < 1e-3 && shares[0] > 0.0);
}

/// The program is the motion, 125 times a second: within the arm's speeds, through the posture of every knot.
fn the_program_is_the_motion(steps: &[Step], lines: &[Vec<&str>], figures: &Value) {
    let of_line = |line: &[&str]| -> [f64; 6] { std::array::from_fn(|joint| line[joint + 2].parse().unwrap()) };
    let stream = stream_of(steps);
    assert!(apart(&stream[0], &of_line(&lines[0])) < 2e-9);
    // It begins and ends at home.
    let Some(Step::Servo { joints: end, .. }) = steps.last() else { panic!("{:?}", steps.last()) };
    assert!(apart(&stream[0], end) < 1e-9, "{:?} {end:?}", stream[0]);
    // The extruder goes off 0.03 s late, while the arm goes home: no posture is held for it.
    assert_eq!(stream.len() as u64, figures["program_steps"].as_u64().unwrap() + 1);
    // Rounded up to a tick.
    let robot_s = figures["robot_time_s"].as_f64().unwrap();
    assert!((stream.len() as f64 - 1.0) * 0.008 - robot_s < 0.008 && stream.len() as f64 * 0.008 > robot_s);
    assert!(stream.windows(2).all(|pair| apart(&pair[0], &pair[1]) < 0.008 * std::f64::consts::TAU));
    let on = |on: bool| steps.iter().filter(|step| **step == Step::Extruder(on)).count();
    assert_eq!((on(true), on(false)), (2, 2));
    // Through the posture of every knot that a tick is near.
    for line in lines {
        let time: f64 = line[1].parse().unwrap();
        let tick = time / 0.008;
        let [a, b] = [tick.floor(), tick.ceil()].map(|tick| stream[(tick as usize).min(stream.len() - 1)]);
        let share = tick - tick.floor();
        let between = std::array::from_fn(|k| a[k] + (b[k] - a[k]) * share);
        assert!(apart(&between, &of_line(line)) < 1e-3, "{time}");
    }
}

/// The filament that the steps push: tick by tick at the speed that was set last, all of it while the extruder is on. The run has read the
/// file as well.
fn the_filament_is_pushed(steps: &[Step], laid: f64, figures: &Value) {
    let (mut speed, mut is_on, mut pushed) = (0.0, false, 0.0);
    for step in steps {
        match step {
            Step::Extruder(on) => is_on = *on,
            Step::FilamentSpeed(mm_s) => speed = *mm_s,
            Step::Servo { seconds, .. } => pushed += if is_on { speed * seconds } else { 0.0 },
            Step::Move(_) | Step::Signal { .. } | Step::Wait(_) => {}
        }
        assert!(is_on || speed == 0.0 || matches!(step, Step::FilamentSpeed(_)));
    }
    assert!((pushed / laid - 1.0).abs() < 5e-3, "{pushed} {laid}");
    let read = |key: &str| figures[key].as_f64().unwrap();
    assert!((read("program_filament_mm") - pushed).abs() < 1e-6 && figures["program_not_at_home"] == 0);
    assert!(read("program_off_mm") < 1e-5, "{}", read("program_off_mm"));
    let AnyWorkcell::Six(cell) = AnyWorkcell::from_json(UR3_CELL.as_bytes()).unwrap() else { panic!("it has a table") };
    let robot = OnCell::new(cell, Vec::new());
    let tip = |joints: &[f64; 6]| robot.nozzle(joints).unwrap().translation.vector;
    let tips: Vec<_> = stream_of(steps).iter().map(tip).collect();
    let fastest = tips.windows(2).map(|pair| (pair[1] - pair[0]).norm() / 0.008).fold(0.0, f64::max);
    assert!(read("program_travel_mm_s") <= fastest + 1e-6 && read("program_travel_mm_s") > 0.5 * fastest);
}

/// Files that each begin and end at home, with the steps of one file, but for a lift and two ways more: home, and back to the next file.
fn small_files_have_the_same_steps(cut: &str, steps: &[Step]) {
    let list = fs::read_to_string(Path::new(cut).join("programs.csv")).unwrap();
    let files: Vec<Vec<&str>> = list.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(files.len(), 2);
    assert_eq!((files[0][4], files[1][4]), ("at home", "at home"));
    let home = stream_of(steps)[0];
    let mut joined: Vec<Step> = Vec::new();
    for file in &files {
        let all = steps_of(&Path::new(cut).join(file[0]));
        let end = all.iter().rev().find_map(servo).unwrap();
        assert!(apart(&stream_of(&all)[0], &home) < 1e-9 && apart(&end, &home) < 1e-9, "not at home");
        joined.extend(&all[1..]);
    }
    let servos = |steps: &[Step]| steps.iter().filter(|step| servo(step).is_some()).count();
    assert!(servos(&joined) > servos(steps));
    let signals = |steps: &[Step]| steps.iter().filter(|step| matches!(step, Step::Extruder(_))).count();
    assert_eq!(signals(&joined), signals(steps));
}

/// The same block as lines with blends: few lines, from home to home, which lay as much in the same time.
#[test]
fn a_robot_prints_a_block_by_lines_with_blends() {
    let scratch = Scratch::new("movep");
    let out = scratch.path("out");
    let args = ["--cell", "2", "--stage", "motion", "--program", "urscript-movep"];
    let figures = block([16.0, 12.0, 4.0], &out, &args);
    documented(&out);
    let number = |key: &str| figures[key].as_f64().unwrap();
    assert_eq!((figures["program_files"].as_u64(), figures["program_not_at_home"].as_u64()), (Some(1), Some(0)));
    assert!(number("program_off_mm") < 0.01, "{}", number("program_off_mm"));
    let text = fs::read_to_string(Path::new(&out).join("print_001.script")).unwrap();
    assert!(
        text.starts_with("def print_001():\n  # Begins and ends at joints ") && text.ends_with("end\nprint_001()\n")
    );
    // Twelve thousand steps of a stream; ten lines a second are a file of 10,000 lines in ten minutes or more.
    assert!(text.lines().count() < 1500 && text.contains("  movep(pose_trans("), "{}", text.lines().count());
    let steps: Vec<Step> = UrScriptReader::new(text.as_bytes()).unwrap().collect::<Result<_, _>>().unwrap();
    let ends: Vec<[f64; 6]> = steps
        .iter()
        .filter_map(|step| match step {
            Step::Move(Move { goal: Goal::Joints(joints), .. }) => Some(*joints),
            _ => None,
        })
        .collect();
    let apart = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart(&ends[0], &ends[ends.len() - 1]) < 1e-8);
    // The time of the lines, by the speeds of the TCP that stand in the file.
    let AnyWorkcell::Six(cell) = AnyWorkcell::from_json(UR3_CELL.as_bytes()).unwrap() else { panic!("it has a table") };
    let (mut at, mut seconds, mut rest, mut joints) = (None, 0.0, true, ends[0]);
    for step in &steps {
        let Step::Move(Move { goal, speed, zone, .. }) = step else { continue };
        let stops = *zone == curvlay_kinematics::program::Zone::Stop;
        let ramps = f64::from(u8::from(rest) + u8::from(stops));
        seconds += match goal {
            Goal::Line(target) => {
                let to = target.pose.inverse().translation.vector;
                let from = at.replace(to).unwrap_or_else(|| {
                    let pose = cell.controller_pose(&joints).unwrap().target.pose;
                    pose.inverse().translation.vector
                });
                (to - from).norm() / speed.mm_s + ramps * speed.mm_s / 2400.0
            }
            Goal::Joints(to) => {
                let way = apart(&std::mem::replace(&mut joints, *to), to);
                at = None;
                way / speed.rad_s + ramps * speed.rad_s / 20.0
            }
            Goal::JointMove(_) => panic!("{step:?}"),
        };
        rest = stops;
    }
    let robot_s = number("robot_time_s");
    assert!((seconds / robot_s - 1.0).abs() < 0.03, "{seconds} {robot_s}");

    // Cut at lines: more files, each from home to home; the extruder at a socket.
    let cut = scratch.path("cut");
    let more = ["--program-steps", "300", "--ur-extruder", "socket:192.168.1.9:4000,12"];
    let figures = block([16.0, 12.0, 4.0], &cut, &[&args[..], &more].concat());
    let text = fs::read_to_string(Path::new(&cut).join("print_001.script")).unwrap();
    assert!(text.contains("socket_open(\"192.168.1.9\",4000,\"extruder\")") && text.contains("\"START\",\"extruder\""));
    assert!(!text.contains("set_standard"));
    assert_eq!((figures["program_files"].as_u64(), figures["program_not_at_home"].as_u64()), (Some(2), Some(0)));
    let output = run(&["--stage", "motion", "--cell8", "--program", "urscript-movep", "--out", &scratch.path("no")]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("takes rapid, krl, tp"));
}

/// The same block over a table, for KUKA and for Fanuc.
#[test]
fn programs_of_other_makers_are_read_again() {
    let scratch = Scratch::new("makers");
    for (format, main) in [("krl", "print.src"), ("tp", "print.ls")] {
        let out = scratch.path(format);
        let args = ["--cell", "2", "--stage", "motion", "--cell8", "--program", format];
        let figures = block([16.0, 12.0, 4.0], &out, &args);
        documented(&out);
        assert!(Path::new(&out).join(main).exists());
        assert_eq!(figures["program_not_at_home"].as_u64(), Some(0), "{format}");
        assert!(figures["program_off_mm"].as_f64().unwrap() < 0.01);
    }
}

/// Bug: each path began wherever its own motion was best, often on another branch of the arm than the path before ends on,
/// with the elbow on the other side of the pedestal. Of a post with two arms, which are printed sideways, two paths could not
/// be reached.
#[test]
fn each_path_begins_near_where_the_one_before_ends() {
    let scratch = Scratch::new("tee");
    let (mesh, out) = (scratch.path("tee.stl"), scratch.path("out"));
    let post = [[0.0; 3], [12.0, 12.0, 36.0]];
    let arms = [[[12.0, 0.0, 24.0], [48.0, 12.0, 36.0]], [[-36.0, 0.0, 24.0], [0.0, 12.0, 36.0]]];
    fs::write(&mesh, boxes(&[post, arms[0], arms[1]])).unwrap();
    let args = ["--cell", "4", "--stage", "motion", "--program", "none"];
    let output = run(&[&["--mesh", &mesh, "--quiet", "--out", &out], &args[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let figures = summary(&out);
    let count = |key: &str| figures[key].as_u64().unwrap();
    assert!(count("transfers") >= 20);
    assert_eq!((count("without_transfer"), count("check_findings"), count("blocked_waypoints")), (0, 0, 0));
    // How far joints are from the first to the last posture of each transfer.
    let text = fs::read_to_string(Path::new(&out).join("trajectory.csv")).unwrap();
    let lines: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let joints = |line: &[&str]| -> [f64; 6] { std::array::from_fn(|joint| line[joint + 2].parse().unwrap()) };
    let transfers: Vec<_> = lines.chunk_by(|a, b| a[0] == b[0]).filter(|same| same[0][KIND] == "transfer").collect();
    // The first comes from home, and the last leads there.
    let mut far: Vec<f64> = transfers[1..transfers.len() - 1]
        .iter()
        .map(|same| {
            let (from, to) = (joints(&same[0]), joints(&same[same.len() - 1]));
            let by = |(a, b): (&f64, &f64)| {
                let (way, turn) = ((b - a).abs(), std::f64::consts::TAU);
                // The short way round, but for what smoothing moves the ends of paths.
                assert!(way <= (turn * (way / turn).round() - way).abs() + 0.01, "{a} {b}");
                way
            };
            from.iter().zip(&to).map(by).fold(0.0, f64::max)
        })
        .collect();
    far.sort_by(f64::total_cmp);
    assert_eq!(far.len() as u64, count("transfers"));
    // It was 3.1 and 4.4 rad: other branches, and whole turns. From one arm of the tee to the other the part turns by half a turn.
    assert!(far[far.len() / 2] < 1.0, "{far:?}");
    // Layers are planned side by side, as many at once as there are threads for; the motion is the same.
    for threads in ["1", "5"] {
        let other = scratch.path(threads);
        let output = run(&[&["--mesh", &mesh, "--quiet", "--out", &other, "--threads", threads], &args[..]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(fs::read_to_string(Path::new(&other).join("trajectory.csv")).unwrap(), text);
    }
}

/// Bug: with half a second from waypoint to waypoint the arm had the time to turn over between two of them. It met both, and
/// its nozzle went 107 mm off the path in between; nothing said so.
#[test]
fn the_nozzle_keeps_on_its_way_between_waypoints() {
    let scratch = Scratch::new("way");
    let out = scratch.path("out");
    let args = ["--voxels", "3000", "--stage", "motion", "--program", "none", "--quiet", "--out", &out];
    let output = run(&args);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let figures = summary(&out);
    let (error, tolerance) = (&figures["max_deviation_mm"], &figures["path_tolerance_mm"]);
    assert!(error.as_f64().unwrap() <= tolerance.as_f64().unwrap() && figures["astray"] == 0);
    assert!((tolerance.as_f64().unwrap() - 0.25 * figures["layer_height_mm"].as_f64().unwrap()).abs() < 1e-9);
    assert_eq!((&figures["breaks"], &figures["check_findings"]), (&0.into(), &0.into()));
    // The spline through the knots of each print, half way from knot to knot, is on the straight way.
    let AnyWorkcell::Six(cell) = AnyWorkcell::from_json(UR3_CELL.as_bytes()).unwrap() else { panic!("it has a table") };
    let robot = OnCell::new(cell, Vec::new());
    let text = fs::read_to_string(Path::new(&out).join("trajectory.csv")).unwrap();
    let lines: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let joints = |line: &Vec<&str>| -> [f64; 6] { std::array::from_fn(|joint| line[joint + 2].parse().unwrap()) };
    let tip = |joints: &[f64; 6]| robot.nozzle(joints).unwrap().translation.vector;
    let mut steps = 0;
    for print in lines.chunk_by(|a, b| a[0] == b[0]).filter(|motion| motion[0][KIND] == "print") {
        let times: Vec<f64> = print.iter().map(|line| line[1].parse().unwrap()).collect();
        let knots: Vec<[f64; 6]> = print.iter().map(joints).collect();
        let line = Timeline::at_rest(&times).unwrap();
        let spline = Trajectory::new(&line, &knots[1..knots.len() - 1]).unwrap();
        for (times, ends) in times.windows(2).zip(knots.windows(2)) {
            let [a, b] = [tip(&ends[0]), tip(&ends[1])];
            let (way, from) = (b - a, tip(&spline.at(0.5 * (times[0] + times[1])).position) - a);
            let off = from - way * (from.dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
            assert!(off.norm() <= tolerance.as_f64().unwrap(), "{} {off}", times[0]);
            steps += 1;
        }
    }
    assert!(steps > 8_000, "{steps}");
}

/// A block on a table that tilts and turns: the program has every waypoint on the part, at the speed of the deposition.
#[test]
fn an_arm_over_a_table_prints_a_block() {
    let scratch = Scratch::new("cell8");
    let out = scratch.path("out");
    let figures = block([8.0, 6.0, 4.0], &out, &["--cell", "2", "--stage", "motion", "--cell8"]);
    let count = |key: &str| figures[key].as_u64().unwrap();
    assert_eq!((count("motions"), count("transfers"), count("without_transfer")), (2, 1, 0));
    assert_eq!((count("unreachable_waypoints"), count("blocked_waypoints"), count("breaks")), (0, 0, 0));
    assert_eq!((count("collisions"), count("check_findings"), &figures["program_refused"]), (0, 0, &"".into()));
    // The run has read the program: it begins and ends at home, and lays what the plan lays.
    let [read, planned] = ["program_filament_mm", "filament_mm"].map(|key| figures[key].as_f64().unwrap());
    assert!((read / planned - 1.0).abs() < 5e-3 && figures["program_not_at_home"] == 0, "{read} {planned}");
    assert!(figures["program_off_mm"].as_f64().unwrap() < 1e-3);
    assert!(figures["waypoint_error_mm"].as_f64().unwrap() < 1e-6);
    let text = fs::read_to_string(Path::new(&out).join("trajectory.csv")).unwrap();
    assert!(text.starts_with("motion,time_s,q1,q2,q3,q4,q5,q6,q7,q8,kind,layer,path,waypoint,filament_mm\n"));

    let open = |name: &str| Ok(BufReader::new(fs::File::open(Path::new(&out).join(name))?));
    let program = read_rapid(open("print.mod").unwrap(), open).unwrap();
    assert_eq!(program.main().work_object.as_ref().unwrap().unit.as_deref(), Some("STN1"));
    let steps = program.collect::<Result<Vec<Step>, _>>().unwrap();
    let lines = |step: &Step| matches!(step, Step::Move(Move { goal: Goal::Line(_), table: Some(_), .. }));
    // Targets are merged where straight lines stay within the tolerance.
    let written = steps.iter().filter(|step| lines(step)).count() as u64 + count("motions");
    assert!(written <= count("waypoints") && written > count("waypoints") / 2, "{written}");
    let on = |on: bool| steps.iter().filter(|step| **step == Step::Extruder(on)).count();
    // Off once more at the begin and at the end of the program.
    assert_eq!((on(true), on(false)), (2, 4));
    // What the targets say is what the machine file says: the same places, in the same order, in the same time.
    let file = fs::File::open(Path::new(&out).join("toolpath.gcode")).unwrap();
    let options = ReadOptions { home: Some(Point3::origin()), ..ReadOptions::default() };
    let moves = GcodeReader::new(BufReader::new(file), options).unwrap().collect::<Result<Vec<_>, _>>().unwrap();
    let tip = |step: &gcode::Move| match step {
        gcode::Move::Print { tip, feed_mm_s, .. } => Some((*tip, *feed_mm_s)),
        _ => None,
    };
    let tips: Vec<(Point3<f64>, f64)> = moves.iter().filter_map(tip).collect();
    let target = |step: &Step| match step {
        Step::Move(Move { goal: Goal::Line(target), speed, .. }) => Some((target.pose.translation.vector, speed.mm_s)),
        _ => None,
    };
    let targets: Vec<_> = steps.iter().filter_map(target).collect();
    // Targets are merged where straight lines stay within the tolerance: each is one of the places, in their order.
    assert!(targets.len() <= tips.len() && targets.len() > tips.len() / 2, "{} {}", targets.len(), tips.len());
    let shift = tips[0].0.coords - targets[0].0;
    assert!(shift.z.abs() < 1e-3);
    // A merged line takes as long as the lines that it stands for.
    let (mut next, mut before): (_, Option<Vector3<f64>>) = (0, None);
    for (at, speed) in &targets {
        let passed = tips[next..].iter().position(|(tip, _)| (tip.coords - at - shift).norm() < 2e-3);
        let Some(passed) = passed else { panic!("{at} is not in the machine file") };
        if let (Some(from), true) = (before, next > 0) {
            let lines = tips[next - 1..=next + passed].windows(2);
            let seconds: f64 = lines.map(|pair| (pair[1].0 - pair[0].0).norm() / pair[1].1).sum();
            let length: f64 = (at - from).norm();
            assert!((speed * seconds / length - 1.0).abs() < 0.01, "{at} {speed} {}", length / seconds);
        }
        before = Some(*at);
        next += passed + 1;
    }
    assert_eq!(next, tips.len());
}

/// A robot for which no limits of acceleration and jerk are known has none, and the summary says so.
#[test]
fn without_limits_of_jerk_none_is_kept() {
    let scratch = Scratch::new("limitless");
    let limits = ["--acceleration", "inf", "--jerk", "inf", "--program", "none"];
    let args = [&["--cell", "2", "--stage", "motion"], &limits[..]].concat();
    let figures = block([8.0, 6.0, 4.0], &scratch.path("out"), &args);
    assert_eq!(
        (&figures["limit_acceleration_rad_s2"], &figures["limit_jerk_rad_s3"]),
        (&"none".into(), &"none".into())
    );
    assert!((1..=6).any(|joint| figures[&format!("max_jerk_q{joint}_rad_s3")].as_f64().unwrap() > 100.0));
    assert_eq!((&figures["check_findings"], &figures["without_transfer"]), (&0.into(), &0.into()));
}

/// A cell that is none of the two that come along: a UR10 with a leaning nozzle in its hand over a plate that stands still, read
/// from its file. The plate is so far away that the arm does not reach all of a part in the middle: it is put elsewhere.
#[test]
fn an_arm_of_a_file_prints_over_a_plate_that_stands_still() {
    let scratch = Scratch::new("workcell");
    let cell = include_str!("../../../cells/ur10.json");
    let far = cell.replace("[750, 0, 0]", "[1430, 0, 0]").replace("\"diameter_mm\": 300", "\"diameter_mm\": 500");
    assert_ne!(cell, far);
    let printed = |name: &str, text: &str| {
        let file = scratch.path(&format!("{name}.json"));
        fs::write(&file, text).unwrap();
        let out = scratch.path(name);
        let args = ["--cell", "2", "--stage", "motion", "--workcell", &file];
        let figures = block([8.0, 6.0, 4.0], &out, &args);
        documented(&out);
        assert_eq!(figures["cell"], "UR10 with the nozzle in its hand over a fixed plate");
        assert_eq!((&figures["unreachable_waypoints"], &figures["blocked_waypoints"]), (&0.into(), &0.into()));
        assert_eq!((&figures["check_findings"], &figures["without_transfer"]), (&0.into(), &0.into()));
        let script = fs::read(Path::new(&out).join("print_001.script")).unwrap();
        assert!(UrScriptReader::new(&script[..]).unwrap().all(|step| step.is_ok()));
        ["part_shift_x_mm", "part_shift_y_mm", "part_turn_deg"].map(|key| figures[key].as_f64().unwrap())
    };
    let [x, y, turn] = printed("near", cell);
    assert!(x.abs() < 5.0 && y.abs() < 5.0 && turn.abs() < 1e-12, "in the middle: {x} {y} {turn}");
    let [x, _, turn] = printed("far", &far);
    assert!(x > 20.0 || turn.abs() > 1.0, "nearer to the arm, or turned: {x} {turn}");
    // A field that cannot be is named with the file.
    let file = scratch.path("bad.json");
    fs::write(&file, cell.replace("\"cone_height_mm\": 8", "\"cone_height_mm\": -8")).unwrap();
    let (status, line) = status_and_line(&run(&["--workcell", &file, "--out", &scratch.path("bad")]));
    assert!(status == 1 && line.contains("bad.json") && line.contains("nozzle.cone_height_mm"), "{status} {line}");
}

/// Bug: the whole tower was in the scene from the first layer on, so that the holder of the nozzle collided with it.
#[test]
fn what_is_printed_later_is_not_in_the_way() {
    let scratch = Scratch::new("tower");
    let out = scratch.path("out");
    let args = ["--cell", "8", "--layer-height", "4", "--stage", "motion", "--cell8", "--program", "csv"];
    let figures = block([16.0, 16.0, 80.0], &out, &args);
    documented(&out);
    let count = |key: &str| figures[key].as_u64().unwrap();
    assert_eq!((count("motions"), count("transfers"), count("without_transfer")), (20, 19, 0));
    assert_eq!((count("blocked_waypoints"), count("unreachable_waypoints"), count("check_findings")), (0, 0, 0));
    // As CSV, the table's axes stand beside the targets.
    let file = fs::File::open(Path::new(&out).join("print_001.csv")).unwrap();
    let steps = CsvReader::new(BufReader::new(file)).unwrap().collect::<Result<Vec<Step>, _>>().unwrap();
    let moves = steps.iter().filter(|step| matches!(step, Step::Move(Move { table: Some(_), .. }))).count();
    let extruding = |step: &&Step| matches!(step, Step::Extruder(_) | Step::FilamentSpeed(_));
    assert_eq!(moves + steps.iter().filter(extruding).count(), steps.len());
    assert_eq!(steps.iter().filter(|step| matches!(step, Step::Extruder(_))).count(), 40);
    assert!(!Path::new(&out).join("print.mod").exists());
}

/// Bug: a robot that cannot print a waypoint was missing in the report. Here bodies of the arm keep no 15 mm apart: nothing is printed,
/// and no program is written; an old one is gone.
#[test]
fn what_a_robot_does_not_print_is_reported() {
    let scratch = Scratch::new("blocked");
    let (mesh, out) = (scratch.path("block.stl"), scratch.path("out"));
    fs::write(&mesh, boxes(&[[[0.0; 3], [4.0, 4.0, 4.0]]])).unwrap();
    fs::create_dir_all(&out).unwrap();
    fs::write(Path::new(&out).join("print_001.script"), "old").unwrap();
    let args = ["--mesh", &mesh, "--cell", "2", "--stage", "motion", "--margin", "15", "--allow-volume", "0.5"];
    let output = run(&[&args[..], &["--quiet", "--out", &out]].concat());
    let (stderr, notices) = said(&output, &out);
    assert_eq!(output.status.code(), Some(3), "{stderr}");
    for words in ["waypoints skipped: the robot would collide", "paths are not printed: "] {
        assert!(stderr.contains(words) && notices.iter().any(|notice| notice.contains(words)), "{stderr}");
    }
    assert!(stderr.contains("  accept: --allow-unprinted 1.0"), "{stderr}");
    let accepted =
        run(&[&args[..], &["--allow-unprinted", "1", "--quiet", "--out", &scratch.path("accepted")]].concat());
    assert_eq!(accepted.status.code(), Some(0), "{}", String::from_utf8_lossy(&accepted.stderr));
    let figures = summary(&out);
    assert_eq!(
        (&figures["motions"], &figures["program_files"], &figures["stage_done"]),
        (&0.into(), &0.into(), &"motion".into())
    );
    assert!(!Path::new(&out).join("print_001.script").exists() && Path::new(&out).join("motion-faults.csv").exists());
    documented(&out);
}
