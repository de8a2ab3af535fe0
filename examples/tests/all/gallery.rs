//! The parts of the gallery: sound meshes in one piece on the plate or on their base, and a page that has the commands that the code gives.

use curvlay_examples::gallery::PARTS;
use curvlay_examples::mesh::{Mesh, read_mesh};
use curvlay_voxel::inspect::{Orientation, inspect};
use std::fs::File;
use std::io::BufWriter;

/// How far from the plate a foot may be, and how small a part may be, mm.
const ON_PLATE_MM: f64 = 1e-6;
const MIN_SIZE_MM: f64 = 9.0;

fn check(name: &str, mesh: &Mesh, on_plate: bool) {
    let report = inspect(&mesh.vertices, &mesh.triangles).unwrap();
    assert!(report.is_sound(), "{name}: {report:?}");
    assert_eq!((report.orientation, report.components), (Orientation::Outward, 1), "{name}");
    assert!((report.signed_volume_mm3 - mesh.volume()).abs() < 1e-6 * mesh.volume(), "{name}");
    let [low, high] = report.bounds;
    assert!(low.z > -ON_PLATE_MM, "{name} reaches down to {}", low.z);
    assert_eq!(low.z < ON_PLATE_MM, on_plate, "{name} stands at {}", low.z);
    assert!((high - low).min() > MIN_SIZE_MM && (high - low).max() < 60.0, "{name}: {:?}", high - low);
}

#[test]
fn parts_are_sound_and_stand_on_the_plate() {
    for part in PARTS {
        check(part.name, &part.mesh(), part.base.is_none());
        if let Some(base) = part.base {
            check(&format!("{}-base", part.name), &base.mesh(), true);
        }
    }
}

#[test]
fn files_hold_what_was_made() {
    let folder = super::common::folder("gallery", "stl");
    for part in PARTS {
        let mesh = part.mesh();
        let path = folder.path().join(format!("{}.stl", part.name));
        mesh.write_stl(&mut BufWriter::new(File::create(&path).unwrap())).unwrap();
        let read = read_mesh(&path).unwrap();
        check(part.name, &read, part.base.is_none());
        assert!((read.volume() - mesh.volume()).abs() < 1e-4 * mesh.volume(), "{}", part.name);
    }
}

#[test]
fn the_page_has_the_commands_and_pictures() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let page = std::fs::read_to_string(root.join("gallery.md")).unwrap();
    for part in PARTS {
        assert!(page.contains(&part.command()), "docs/gallery.md lacks: {}", part.command());
        let picture = format!("gallery/{}.png", part.name);
        assert!(page.contains(&picture), "docs/gallery.md shows no {picture}");
        let bytes = std::fs::metadata(root.join(&picture)).unwrap().len();
        assert!(bytes < 60_000, "{picture}: {bytes} bytes");
    }
}
