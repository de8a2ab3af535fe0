//! Files of the user: never removed or written over, whichever example they are given to, and read only if they are files.

use crate::common;
use curvlay_examples::shapes::ell;
use curvlay_toolpath::gcode::flavour::Flavour;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// A folder of a test, empty.
fn place(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("input_files").join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

fn last_line(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or_default().to_owned()
}

/// Every file of a folder with what is in it.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}

/// For each example and each of its options: the name under which a run would write the file. `@` stands for it.
const GIVEN: [(&str, &[&str], &str); 24] = [
    ("best_orientation", &["@"], "best_pose.stl"),
    ("best_orientation", &["--mesh", "@"], "best_pose.obj"),
    ("continuous_fiber", &["@"], "layer.png"),
    ("continuous_fiber", &["part.stl", "--stress", "@"], "tapes.csv"),
    ("continuous_fiber", &["--wire", "@"], "arc_tapes_001.script"),
    ("continuous_fiber", &["--workcell", "@"], "summary.json"),
    ("robofdm", &["@"], "part_01.stl"),
    ("robofdm", &["--workcell", "@"], "summary.json"),
    ("volume_decomposition", &["@"], "part_part_01.stl"),
    ("curved_layers", &["@"], "layers.obj"),
    ("curved_layers", &["@", "--orient", "best"], "oriented.obj"),
    ("curved_layers", &["--profile", "@"], "summary.json"),
    ("curved_layers", &["--resume", "@"], "field.txt"),
    ("curved_layers", &["--workcell", "@", "--stage", "motion"], "print_001.csv"),
    ("curved_layers", &["--workcell", "@", "--stage", "motion"], "workcell.json"),
    ("curved_layers", &["--flavour", "@"], "flavour.json"),
    ("curved_layers", &["part.stl", "--merge", "@"], "paths.jsonl"),
    ("dome_drawing", &["@"], "design.dxf"),
    ("dome_drawing", &["--svg", "@"], "drawing_001.mod"),
    ("dome_drawing", &["--load", "@"], "design.drawing"),
    ("jerk_motion", &["--waypoints", "@"], "path-faults.txt"),
    ("jerk_motion", &["--part", "@"], "ur3_trajectory.csv"),
    ("stewart_table", &["--waypoints", "@"], "legs.csv"),
    ("boge_objects", &["--grid", "@"], "layers.csv"),
];

/// What a reader of that name takes, so that nothing but the name is wrong with it.
fn content(args: &[&str], name: &str) -> Vec<u8> {
    let option = args.iter().position(|word| *word == "@").filter(|at| *at > 0).map_or("", |at| args[at - 1]);
    match option {
        "--profile" => b"{}".to_vec(),
        "--flavour" => serde_json::to_vec(&Flavour::built_in("klipper").unwrap()).unwrap(),
        "--workcell" => fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("cells/ur3.json")).unwrap(),
        _ => {
            let mut bytes = Vec::new();
            if name.ends_with(".stl") {
                ell().write_stl(&mut bytes).unwrap();
            } else {
                ell().write_obj("an L", &mut bytes).unwrap();
            }
            bytes
        }
    }
}

/// Bug: an input that lay in the output folder under a name of ours was deleted before it was read, or written over.
#[test]
fn an_input_is_never_removed_or_written_over() {
    let part = place("part").join("part.stl");
    ell().write_stl(&mut fs::File::create(&part).unwrap()).unwrap();
    for (number, (name, args, file)) in GIVEN.into_iter().enumerate() {
        for link in [false, true] {
            let folder = place(&format!("{number}-{link}"));
            let given = if link { place(&format!("{number}-elsewhere")).join(file) } else { folder.join(file) };
            fs::write(&given, content(args, file)).unwrap();
            if link {
                fs::hard_link(&given, folder.join(file)).unwrap();
            }
            // Results of an earlier run stay as well.
            fs::write(folder.join("report.html"), "earlier").unwrap();
            let before = contents(&folder);
            let words = args.iter().map(|word| match *word {
                "@" => given.clone(),
                "part.stl" => part.clone(),
                word => PathBuf::from(word),
            });
            let output = common::example(name).args(words).arg("--quiet").arg("--out").arg(&folder).output().unwrap();
            let line = last_line(&output);
            assert_eq!(output.status.code(), Some(1), "{name} {args:?}: {line}");
            assert!(line.contains(file) && line.contains("is an input"), "{name} {args:?}: {line}");
            assert!(contents(&folder) == before, "{name} {args:?}");
        }
    }
}

/// The two examples without options write where their documentation says.
#[test]
fn an_input_is_not_the_output() {
    let mesh = place("same").join("part.stl");
    let mut bytes = Vec::new();
    ell().write_stl(&mut bytes).unwrap();
    fs::write(&mesh, &bytes).unwrap();
    let output = common::example("mesh_to_gcode").args([&mesh, &mesh]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(last_line(&output).contains("part.stl: is an input"), "{}", last_line(&output));
    assert!(fs::read(&mesh).unwrap() == bytes);
}

/// Bug: a slip in the name of a mesh deleted the results of the run before.
#[test]
fn nothing_is_removed_for_an_input_that_is_not_there() {
    let all: [(&str, &[&str], &[&str]); 6] = [
        ("curved_layers", &["no.stl"], &["toolpath.gcode", "report.html", "print_001.script"]),
        ("curved_layers", &["--cell", "2", "--merge", "no.jsonl"], &["toolpath.gcode", "field.txt"]),
        ("best_orientation", &["no.stl"], &["poses.csv", "best_pose.stl"]),
        ("continuous_fiber", &["no.stl"], &["tapes.csv", "arc.gcode"]),
        ("continuous_fiber", &["--wire", "no.txt"], &["tapes.csv", "arc.gcode"]),
        ("robofdm", &["--workcell", "no.json"], &["part_01.stl", "parts.csv"]),
    ];
    for (number, (name, args, earlier)) in all.into_iter().enumerate() {
        let folder = place(&format!("typo-{number}"));
        earlier.iter().chain([&"summary.json"]).for_each(|file| fs::write(folder.join(file), "earlier").unwrap());
        let before = contents(&folder);
        let output = common::example(name).args(args).arg("--quiet").arg("--out").arg(&folder).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{name} {args:?}: {}", last_line(&output));
        assert!(last_line(&output).contains("no."), "{name} {args:?}: {}", last_line(&output));
        assert!(contents(&folder) == before, "{name} {args:?}");
    }
}

/// Bug: `print_my_life.script`, `print_cell_setup.mod`, `step_10.png` and `my_part_01.stl` of the user were deleted.
#[test]
fn files_with_names_like_ours_stay() {
    let mine = [
        "print_my_life.script",
        "print_cell_setup.mod",
        "my_part_01.stl",
        "part_1.stl",
        "step_010.png",
        "layers.gcode",
    ];
    let all: [(&str, &[&str]); 2] = [("robofdm", &["--stage", "parts"]), ("volume_decomposition", &["--layer", "5"])];
    for (name, args) in all {
        let folder = place(&format!("mine-{name}"));
        mine.iter().for_each(|file| fs::write(folder.join(file), "mine").unwrap());
        fs::write(folder.join("print_007.mod"), "earlier").unwrap();
        let output = common::example(name).args(args).arg("--quiet").arg("--out").arg(&folder).output().unwrap();
        assert!(matches!(output.status.code(), Some(0 | 3)), "{name}: {}", last_line(&output));
        mine.iter()
            .for_each(|file| assert_eq!(fs::read_to_string(folder.join(file)).unwrap(), "mine", "{name} {file}"));
        assert!(!folder.join("print_007.mod").exists(), "{name}");
    }
}

/// Bug: `--workcell /dev/zero` took all memory. What is no regular file, or far too large, is refused.
#[cfg(unix)]
#[test]
fn only_files_of_a_sensible_size_are_read() {
    let folder = place("devices");
    let large = folder.join("large");
    // Sparse: it takes no room.
    fs::File::create(&large).unwrap().set_len(80 << 30).unwrap();
    let out = folder.join("out");
    let all: [(&str, &[&str]); 9] = [
        ("curved_layers", &["--profile", "@"]),
        ("curved_layers", &["--workcell", "@", "--stage", "motion"]),
        ("curved_layers", &["--resume", "@"]),
        ("curved_layers", &["--merge", "@"]),
        ("robofdm", &["--workcell", "@"]),
        ("continuous_fiber", &["--wire", "@"]),
        ("continuous_fiber", &["--workcell", "@"]),
        ("jerk_motion", &["--waypoints", "@"]),
        ("boge_objects", &["--grid", "@"]),
    ];
    for (name, args) in all {
        for file in ["/dev/zero", large.to_str().unwrap()] {
            let words = args.iter().map(|word| if *word == "@" { file } else { word });
            let output = common::example(name).args(words).arg("--quiet").arg("--out").arg(&out).output().unwrap();
            let line = last_line(&output);
            assert_eq!(output.status.code(), Some(1), "{name} {args:?} {file}: {line}");
            assert!(line.contains(file), "{name} {args:?}: {line}");
            let why = if file == "/dev/zero" {
                ["is not a regular file", "is not a file", "wants the paths.jsonl"]
            } else {
                ["the limit is ", "the limit is ", "the limit is "]
            };
            assert!(why.iter().any(|why| line.contains(why)), "{name} {args:?} {file}: {line}");
        }
    }
}

/// SIGINT and SIGTERM end a run with a line and the shell's status, and no file that was begun stays.
#[cfg(unix)]
#[test]
fn signals_end_a_run_cleanly() {
    for (signal, status) in [("INT", 130), ("TERM", 143)] {
        let folder = place(&format!("signal-{signal}"));
        let mut run = common::example("curved_layers");
        run.args(["--voxels", "200000"]).arg("--out").arg(&folder).stdout(Stdio::null()).stderr(Stdio::piped());
        let child = run.spawn().unwrap();
        std::thread::sleep(Duration::from_secs(3));
        let sent = Command::new("kill").arg(format!("-{signal}")).arg(child.id().to_string()).status().unwrap();
        assert!(sent.success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(status), "{}", last_line(&output));
        assert!(last_line(&output).contains(&format!("stopped by SIG{signal}")), "{}", last_line(&output));
        assert!(contents(&folder).iter().all(|(path, _)| path.extension().is_none_or(|ending| ending != "part")));
    }
}

/// A part of the user is one part, given as a word or by an option, and is not divided under the names of shapes made in code.
#[test]
fn a_mesh_given_as_a_word_is_divided_once() {
    let folder = place("word");
    let mesh = folder.join("mine.stl");
    ell().write_stl(&mut fs::File::create(&mesh).unwrap()).unwrap();
    let files = [vec![], vec!["--mesh"]].map(|option| {
        let out = folder.join(if option.is_empty() { "word" } else { "option" });
        let output = common::example("volume_decomposition")
            .args(option)
            .arg(&mesh)
            .args(["--layer", "5", "--quiet", "--out"])
            .arg(&out)
            .output();
        assert!(matches!(output.as_ref().unwrap().status.code(), Some(0 | 3)), "{}", last_line(&output.unwrap()));
        assert!(out.join("part_part_01.stl").exists() && !out.join("curved_part_01.stl").exists());
        contents(&out).into_iter().map(|(path, _)| path.file_name().unwrap().to_owned()).collect::<Vec<_>>()
    });
    assert_eq!(files[0], files[1]);
}

/// Control characters of a file's name do not reach the terminal.
#[test]
fn names_of_files_are_escaped() {
    let folder = place("escape");
    let output = common::example("curved_layers").arg("a\u{1b}[2J.stl").arg("--out").arg(&folder).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(!output.stderr.contains(&0x1b), "{}", last_line(&output));
    assert!(last_line(&output).contains(r"a\u{1b}[2J.stl"), "{}", last_line(&output));
}
