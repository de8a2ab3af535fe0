//! Layers along a surface, directions, or an overhang.

use super::*;

/// Over a slope across the part the layers are planes like it. A surface beside the part, or a closed one, is refused before anything is written.
#[test]
fn layers_are_parallel_to_a_surface() {
    let scratch = Scratch::new("base");
    let [mesh, slope, out] = ["part.stl", "slope.obj", "out"].map(|name| scratch.path(name));
    fs::write(&mesh, boxes(&[[[0.0; 3], [24.0, 16.0, 12.0]]])).unwrap();
    // It rises by 20 degrees along x.
    let rise = 20_f64.to_radians().tan();
    let corner = |x: f64, y: f64, lift: f64| format!("v {x} {y} {}\n", 6.0 + lift + rise * (x - 12.0));
    let sheet = |lift: f64| {
        let corners = [[-20.0, -20.0], [50.0, -20.0], [50.0, 40.0], [-20.0, 40.0]].map(|[x, y]| corner(x, y, lift));
        corners.concat() + "f 1 2 3\nf 1 3 4\n"
    };
    fs::write(&slope, sheet(0.0)).unwrap();
    let args = ["--mesh", &mesh, "--cell", "1.5", "--layer-height", "0.6", "--bead", "1", "--quiet", "--out", &out];
    let output = run(&[&args[..], &["--base", &slope, "--also", "csv"]].concat());
    let (stderr, _) = said(&output, &out);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    documented(&out);
    let figures = summary(&out);
    assert_eq!((&figures["layers_by_used"], &figures["missed_cells"]), (&"distance".into(), &Value::from(0)));
    assert!((figures["filled_share"].as_f64().unwrap() - 1.0).abs() < 0.03, "{figures}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("layers parallel to "));
    // Beads of a layer lie on one plane across the slope.
    let text = fs::read_to_string(Path::new(&out).join("toolpath.csv")).unwrap();
    let mut planes = std::collections::BTreeMap::<u32, [f64; 2]>::new();
    for line in text.lines().filter(|line| line.starts_with("print")) {
        let columns: Vec<&str> = line.split(',').collect();
        let number = |k: usize| columns[k].parse::<f64>().unwrap();
        let height = (number(3) - rise * number(1)) / (1.0 + rise * rise).sqrt();
        let ends = planes.entry(columns[10].parse().unwrap()).or_insert([f64::INFINITY, f64::NEG_INFINITY]);
        *ends = [ends[0].min(height), ends[1].max(height)];
    }
    assert!(planes.len() > 20 && planes.values().all(|[low, high]| high - low < 0.3), "{planes:?}");

    fs::remove_dir_all(&out).unwrap();
    for (text, why) in [(sheet(40.0), "the surface does not touch the part"), (String::new(), "the file is empty")] {
        fs::write(&slope, text).unwrap();
        let (status, line) = status_and_line(&run(&[&args[..], &["--base", &slope]].concat()));
        assert!(status == 1 && line.contains(why) && line.contains("slope.obj"), "{status} {line}");
        assert!(!Path::new(&out).join("summary.json").exists());
    }
    let (status, line) = status_and_line(&run(&[&args[..], &["--base", &mesh]].concat()));
    assert!(status == 1 && line.contains("no upper side"), "{status} {line}");
    let (status, _) = status_and_line(&run(&[&args[..], &["--base", &slope, "--layers-by", "hull"]].concat()));
    assert_eq!(status, 2);
}

/// How far the nozzle leans towards x in the middle of all waypoints between two heights, in degrees.
fn median_lean(out: &str, heights_mm: std::ops::Range<f64>) -> f64 {
    let text = fs::read_to_string(Path::new(out).join("toolpath.csv")).unwrap();
    let mut leans = Vec::new();
    for line in text.lines().filter(|line| line.starts_with("print")) {
        let number = |k: usize| line.split(',').nth(k).unwrap().parse::<f64>().unwrap();
        if heights_mm.contains(&number(3)) {
            leans.push(number(4).atan2(number(6)).to_degrees());
        }
    }
    leans.sort_by(f64::total_cmp);
    leans[leans.len() / 2]
}

/// Layers lie across the directions of a file, in the unit and axis of the part. What cannot be used is refused before anything is written, and what is not followed is a finding.
#[test]
fn layers_follow_directions() {
    let scratch = Scratch::new("directions");
    let [mesh, file, out] = ["part.stl", "ways.csv", "out"].map(|name| scratch.path(name));
    // A mast of 12 by 12 by 40 mm along y of its file, which is in centimetres.
    fs::write(&mesh, boxes(&[[[0.0; 3], [1.2, 4.0, 1.2]]])).unwrap();
    // It leans by 20 degrees to what becomes x; one place is beside the part, one direction too steep.
    fs::write(&file, "x y z i j k\n0.6 2 0.6 0.342 0.940 0\n0.6,3,0.6,0.342,0.940,0\n9 9 9 0 1 0\n0.6 3.9 0.6 9 1 0\n")
        .unwrap();
    let place = ["--unit", "cm", "--up", "y", "--mesh", &mesh, "--cell", "1.5", "--layer-height", "0.6", "--bead", "1"];
    let args = [&place[..], &["--quiet", "--out", &out, "--directions", &file]].concat();
    let output = run(&[&args[..], &["--also", "csv"]].concat());
    let (stderr, _) = said(&output, &out);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    documented(&out);
    assert!(stderr.contains("outside of the part, and count for nothing: 1 of 4"), "{stderr}");
    assert!(stderr.contains("more than 39 degrees") && stderr.contains(": 1 of 4"), "{stderr}");
    let figures = summary(&out);
    assert_eq!((&figures["layers_by_used"], &figures["missed_cells"]), (&"directed".into(), &Value::from(0)));
    assert!(String::from_utf8_lossy(&output.stdout).contains("layers across the directions of "));
    let median = median_lean(&out, 20.0..28.0);
    assert!((median - 20.0).abs() < 4.0, "{median}");

    fs::remove_dir_all(&out).unwrap();
    for (text, why) in [
        ("0.6 2 0.6 0 0 0\n", "line 1 must have"),
        ("0.6 2 0.6 0 1 0\n0.6 NaN 0.6 0 1 0\n", "line 2 must have"),
        ("0.6 2 0.6 0 1\n", "line 1 must be six numbers"),
        ("6 20 6 0 1 0\n", "none of the 1 places lies in the part"),
    ] {
        fs::write(&file, text).unwrap();
        let (status, line) = status_and_line(&run(&args));
        assert!(status == 1 && line.contains(why) && line.contains("ways.csv"), "{status} {line}");
        assert!(!Path::new(&out).join("summary.json").exists());
    }
    for words in [&["--layers-by", "hull"][..], &["--orient", "best"], &["--max-overhang", "30"]] {
        let (status, line) = status_and_line(&run(&[&args[..], words].concat()));
        assert_eq!(status, 2, "{line}");
    }
}

/// The skin of a bar that leans by 55 degrees hangs out over its layers by 30 degrees: they lean by 25.
#[test]
fn layers_are_as_level_as_the_overhang_allows() {
    let scratch = Scratch::new("overhang");
    let [mesh, out] = ["bar.obj", "out"].map(|name| scratch.path(name));
    let shear = 55_f64.to_radians().tan();
    let corner = |k: usize| {
        let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(|k| k as f64);
        format!("v {} {} {}\n", 12.0 * x + shear * 20.0 * z, 8.0 * y, 20.0 * z)
    };
    let squares = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"];
    let faces = squares.map(|square| format!("f {square}\n")).concat();
    fs::write(&mesh, (0..8).map(corner).collect::<String>() + &faces).unwrap();
    let args = ["--mesh", &mesh, "--cell", "1", "--layer-height", "0.5", "--bead", "0.8", "--quiet", "--out", &out];
    let output = run(&[&args[..], &["--max-overhang", "30", "--also", "csv"]].concat());
    let (stderr, _) = said(&output, &out);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    documented(&out);
    let figures = summary(&out);
    assert_eq!((&figures["max_overhang_deg"], &figures["missed_cells"]), (&"30".into(), &Value::from(0)));
    assert!(figures["unsupported_share"].as_f64().unwrap() < 0.001, "{figures}");
    let median = median_lean(&out, 8.0..16.0);
    assert!((median - 25.0).abs() < 5.0, "{median}");
    for angle in ["0", "90", "-5", "x"] {
        let (status, _) = status_and_line(&run(&[&args[..], &["--max-overhang", angle]].concat()));
        assert_eq!(status, 2);
    }
}
