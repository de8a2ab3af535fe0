//! `build.3mf` of a print, beside `toolpath.csv`, which another writer makes of the same moves.

use super::{Scratch, boxes, run};
use curvlay_examples::build3mf::{BuildReader, Segment, SegmentKind, UNIT_FACTOR_MM, direction_of};
use curvlay_examples::mesh::read_mesh;
use curvlay_toolpath::nalgebra::{Point3, Vector3, distance};
use std::fs::{self, File};
use std::path::Path;

fn read(path: &Path) -> Vec<Segment> {
    let mut reader = BuildReader::open(File::open(path).unwrap()).unwrap();
    let (profiles, layers) = (reader.profiles().to_vec(), reader.layers().to_vec());
    let mut all = Vec::new();
    for (at, part) in layers.iter().enumerate() {
        let segments = reader.read_layer(at).unwrap().unwrap();
        all.extend(segments.into_iter().map(|segment| {
            let profile = profiles[segment.profile].clone();
            segment.as_written(&profile, part).unwrap()
        }));
    }
    all
}

/// Every bead and travel of the table is a line of the package, at its place; the mesh is the part on the plate; beads alone are the same beads.
#[test]
fn packages_have_the_moves_of_the_table() {
    let scratch = Scratch::new("tmf");
    let (mesh, out) = (scratch.path("block.stl"), scratch.path("out"));
    fs::write(&mesh, boxes(&[[[0.0, 0.0, 5.0], [9.0, 7.0, 7.0]]])).unwrap();
    let args = ["--layer-height", "0.5", "--bead", "0.8", "--also", "3mf,3mf-beads,csv", "--quiet", "--out", &out];
    let output = run(&[&[&mesh[..]], &args[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let file = |name: &str| Path::new(&out).join(name);
    let segments = read(&file("build.3mf"));
    let mut lines = segments.iter().flat_map(|segment| segment.lines.iter().map(move |line| (segment, line)));
    let table = fs::read_to_string(file("toolpath.csv")).unwrap();
    let rows = table.lines().skip(1).map(|row| row.split(',').collect::<Vec<_>>());
    let motions = rows.filter(|row| ["print", "travel"].contains(&row[0]));
    let (mut beads, mut travels) = (0, 0);
    for row in motions.skip(1) {
        let (segment, line) = lines.next().unwrap();
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        let tip = Point3::from(line.end.translation.vector);
        assert!((tip - Point3::new(number(1), number(2), number(3))).amax() <= UNIT_FACTOR_MM / 2.0 + 1e-9, "{row:?}");
        assert!(direction_of(&line.end).angle(&Vector3::new(number(4), number(5), number(6))) < 1e-6, "{row:?}");
        if row[0] == "travel" {
            travels += 1;
            assert_eq!(segment.kind, SegmentKind::Travel);
            continue;
        }
        beads += 1;
        let [_, end] = line.bead.unwrap();
        // The table has the sizes where a bead ends.
        assert!(
            (end.width_mm - number(12)).abs() < 0.02 && (end.height_mm - number(13)).abs() < 0.02,
            "{row:?} {end:?}"
        );
        assert!((line.speed_mm_s.unwrap() - number(8)).abs() < 1e-3, "{row:?}");
        assert_eq!(segment.layer + 1, row[10].parse::<u32>().unwrap());
    }
    assert!(lines.next().is_none() && beads > 50 && travels > 4, "{beads} {travels}");

    let alone = read(&file("beads.build.3mf"));
    let only: Vec<&Segment> = segments.iter().filter(|segment| segment.kind != SegmentKind::Travel).collect();
    assert_eq!(alone.iter().collect::<Vec<_>>(), only);

    let part = read_mesh(&file("build.3mf")).unwrap();
    let [low, high] = part.bounds().unwrap();
    assert!(distance(&low, &Point3::origin()) < 1e-9 && distance(&high, &Point3::new(9.0, 7.0, 2.0)) < 1e-9);

    // A run without the option takes it away.
    let output = run(&[&mesh, "--layer-height", "0.5", "--bead", "0.8", "--stage", "paths", "--quiet", "--out", &out]);
    assert_eq!(output.status.code(), Some(0));
    assert!(!file("build.3mf").exists() && !file("beads.build.3mf").exists());
}
