//! The files of a run.

use super::*;

/// Bug: another part's `toolpath.gcode`, programs and lists stayed beside a new summary.
#[test]
fn what_an_earlier_run_has_left_goes_away() {
    let scratch = Scratch::new("earlier");
    let (mesh, out) = (scratch.path("block.stl"), scratch.path("out"));
    fs::write(&mesh, boxes(&[[[0.0; 3], [8.0, 6.0, 4.0]]])).unwrap();
    let at = |name: &str| Path::new(&out).join(name);
    let names = || {
        let mut names: Vec<String> =
            fs::read_dir(&out).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    let run_with = |more: &[&str]| run(&[&["--mesh", &mesh, "--quiet", "--out", &out][..], more].concat());
    let machine = concat!(env!("CARGO_MANIFEST_DIR"), "/machines/open5x-table.json");
    assert_eq!(run_with(&["--cell", "2", "--machine", machine]).status.code(), Some(0));
    assert!(at("toolpath.gcode").exists() && at("toolpath-axes.gcode").exists());
    // Of ours, as other runs and earlier versions would leave it, and not of ours.
    for name in [
        "toolpath-bc.gcode",
        "print.mod",
        "print2_003.mod",
        "print_002.script",
        "print_001.csv",
        "programs.csv",
        "gouging.csv",
    ] {
        fs::write(at(name), "old").unwrap();
    }
    fs::write(at(".trajectory.csv.4711.part"), "begun").unwrap();
    for name in ["mine.txt", "printer.csv", "print_notes.csv"] {
        fs::write(at(name), "mine").unwrap();
    }
    // Nothing is removed before all input is read, and never an input: a field in the same folder is refused.
    let (before, own, field) = (names(), at("field.txt").display().to_string(), scratch.path("saved.txt"));
    let (status, line) = status_and_line(&run_with(&["--resume", &own]));
    assert!(status == 1 && line.contains("field.txt: is an input"), "{status} {line}");
    fs::copy(&own, &field).unwrap();
    let gone = run(&["--mesh", "no-such.stl", "--resume", &field, "--quiet", "--out", &out]);
    assert_eq!(gone.status.code(), Some(1));
    assert_eq!(names(), before);
    assert_eq!(run_with(&["--resume", &field, "--stage", "surfaces"]).status.code(), Some(0));
    let of_surfaces =
        ["field.csv", "field.txt", "field.vtk", "layers.obj", "layers.vtk", "report.html", "summary.json"];
    let mut with_mine = [&of_surfaces[..], &["mine.txt", "printer.csv", "print_notes.csv"]].concat();
    with_mine.sort_unstable();
    assert_eq!(names(), with_mine);
    assert_eq!(summary(&out)["stage_done"], "surfaces");
    let vtk = |name: &str| fs::read_to_string(at(name)).unwrap();
    assert!(vtk("field.vtk").contains("SCALARS field ") && vtk("layers.vtk").contains("SCALARS layer "));
    assert_eq!(run_with(&["--cell", "2", "--stage", "field"]).status.code(), Some(0));
    assert_eq!(names(), ["field.csv", "mine.txt", "print_notes.csv", "printer.csv", "report.html", "summary.json"]);
}

/// Bug: the version in the summary was 0.0.0, and the guide asks to cite it.
#[test]
fn the_version_is_that_of_the_crates() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let version = |of: &str| {
        let text = fs::read_to_string(root.join(of).join("Cargo.toml")).unwrap();
        text.lines().find_map(|line| line.strip_prefix("version = ")).unwrap().trim_matches('"').to_owned()
    };
    for name in ["voxel", "hull", "layers", "toolpath", "kinematics", "trajectory"] {
        assert_eq!(version(name), env!("CARGO_PKG_VERSION"), "{name}");
    }
    let scratch = Scratch::new("version");
    let figures = block([4.0, 4.0, 2.0], &scratch.path("out"), &["--cell", "2", "--stage", "field"]);
    assert_eq!(figures["version"], env!("CARGO_PKG_VERSION"));
}
