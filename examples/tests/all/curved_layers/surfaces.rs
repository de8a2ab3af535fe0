//! The surfaces of the layers.

use super::*;

/// Layers of one millimetre of a block with a slanted roof: their surfaces end on the mesh, and fill it.
#[test]
fn surfaces_end_on_the_mesh_and_fill_it() {
    let scratch = Scratch::new("surfaces");
    let mesh = scratch.path("wedge.obj");
    let wedge = "v 0 0 0\nv 20 0 0\nv 20 12 0\nv 0 12 0\nv 0 0 9\nv 20 0 15\nv 20 12 15\nv 0 12 9\n\
                 f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    fs::write(&mesh, wedge).unwrap();
    let (first, second) = (scratch.path("first"), scratch.path("second"));
    let run_in = |out: &str, more: &[&str]| run(&[&["--mesh", &mesh, "--quiet", "--out", out], more].concat());
    let output = run_in(&first, &["--cell", "1", "--layer-height", "1.5"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let figures = summary(&first);
    let figure = |key: &str| figures[key].as_f64().unwrap();
    assert_eq!((figure("layer_height_mm"), figure("surfaces")), (1.5, 10.0));
    assert!(figure("boundary_error_mm") <= 1e-6 && figure("boundary_at_missed_mm") == 0.0);
    assert!((figure("layer_volume_mm3") / figure("volume_mm3") - 1.0).abs() < 0.03, "{}", figure("layer_volume_mm3"));
    assert!((figure("spacing_mean_mm") - 1.5).abs() < 0.05 && figure("squeezed_share") == 0.0);
    assert!(figure("thickness_share") > 0.98 && figure("thickness_share") <= 1.0, "{}", figure("thickness_share"));
    assert!(figures["plain_spacing_mean_mm"].is_null());
    let read = |folder: &str, name: &str| fs::read_to_string(Path::new(folder).join(name)).unwrap();
    let obj = read(&first, "layers.obj");
    let count = |start: &str| obj.lines().filter(|line| line.starts_with(start)).count();
    assert_eq!((count("g layer_"), count("f ") as f64), (10, figure("surface_triangles")));
    assert!(read(&first, "layers.vtk").starts_with("# vtk") && read(&first, "field.vtk").starts_with("# vtk"));

    // Going on from the saved field gives the same surfaces; with another mesh it is refused.
    let saved = Path::new(&first).join("field.txt").display().to_string();
    let output = run_in(&second, &["--resume", &saved, "--layer-height", "1.5"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(read(&second, "layers.obj"), obj);
    assert_eq!(summary(&second)["strategy_used"], "saved");
    let third = scratch.path("third");
    fs::write(&mesh, wedge.replace("v 0 0 9", "v 0 0 9.1")).unwrap();
    let (status, line) = status_and_line(&run_in(&third, &["--resume", &saved]));
    assert!(status == 1 && line.contains("has changed"), "{status} {line}");
    fs::write(&saved, "curvlay field 1\nmesh x\n").unwrap();
    let (status, line) = status_and_line(&run_in(&third, &["--resume", &saved]));
    assert!(status == 1 && line.contains("line 2"), "{status} {line}");
    for height in ["0.1", "40"] {
        let (status, line) = status_and_line(&run_in(&third, &["--cell", "1", "--layer-height", height]));
        assert!(status == 1 && line.contains("layer height"), "{status} {line}");
    }
    assert!(!Path::new(&third).exists());
}
