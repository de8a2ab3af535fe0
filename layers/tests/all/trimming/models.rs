//! The models and the bad models, with flat and curved sheets.

use super::helpers::*;
use curvlay_layers::trim::BoundaryKind;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A binary STL file of the folder `shared` beside the workspace, vertices at the same place made one.
fn model(name: &str) -> Mesh {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(name);
    let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut mesh = Mesh::default();
    let mut known = BTreeMap::new();
    for facet in bytes[84..].chunks_exact(50) {
        let number = |at: usize| f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]]);
        let corner = |k: usize| [0, 1, 2].map(|axis| f64::from(number(12 + 12 * k + 4 * axis)) + 0.0);
        let triangle = [0, 1, 2].map(|k| {
            let at = corner(k);
            *known.entry(at.map(f64::to_bits)).or_insert_with(|| {
                mesh.vertices.push(P::from(at));
                mesh.vertices.len() as u32 - 1
            })
        });
        mesh.triangles.push(triangle);
    }
    mesh
}

const CLOSED: [&str; 19] = [
    "armadillo-hollow",
    "armadillo",
    "branches-16",
    "bunny-hollow",
    "bunny",
    "candelabra",
    "fertility",
    "flipped-ell",
    "hanging-ball",
    "kitten",
    "mech-part",
    "mushroom",
    "rocker-arm",
    "spot",
    "tee",
    "thin-fins",
    "three-rings",
    "woman-pully-hollow",
    "woman-pully",
];

#[test]
#[ignore = "needs ../shared/models; .ci/run runs it where that folder exists"]
fn every_closed_model() {
    for name in CLOSED {
        let mesh = model(&format!("models/{name}.stl"));
        let trimmer = mesh.trimmer();
        assert!(!trimmer.is_holed());
        let (mut triangles, mut error, mut slivers) = (0, 0.0_f64, 0);
        for layer in 0..12 {
            let z = 2.0 + 8.0 * f64::from(layer);
            let flat = field(70.0, 90, |_, _| z);
            let bowl = field(70.0, 90, |x, y| z - 5.0 + (x * x + y * y) / 200.0);
            for sheet in [&flat, &bowl] {
                let trimmed = trimmer.trim(&sheet.vertices, &sheet.triangles, &go).unwrap();
                check(sheet, &trimmed);
                assert!(trimmed.border_mm + trimmed.hole_mm <= 0.0, "{name}");
                triangles += trimmed.triangles.len();
                error = error.max(trimmed.error_mm);
                slivers += trimmed.slivers;
            }
            let area = trimmer.trim(&flat.vertices, &flat.triangles, &go).unwrap().area();
            let expected = section_area(&mesh, z + 1e-9);
            assert!((area - expected).abs() < 1e-6 * (1.0 + expected), "{name} at {z}: {area} for {expected}");
        }
        println!("{name}: {triangles} triangles, error {error:e} mm, {slivers} slivers");
    }
}

#[test]
#[ignore = "needs ../shared/bad-models; .ci/run runs it where that folder exists"]
fn bad_models_that_load() {
    for name in ["self-intersecting", "inside-out", "zero-area", "metres", "solid-header"] {
        let mesh = model(&format!("bad-models/{name}.stl"));
        let trimmer = mesh.trimmer();
        let scale = mesh.vertices.iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
        println!("{name}: {} triangles, holed: {}", mesh.triangles.len(), trimmer.is_holed());
        for layer in 0..8 {
            let z = 0.1 * scale * (f64::from(layer) + 0.37);
            let sheet = field(1.5 * scale, 61, |x, y| z + 0.1 * (x * x + y * y) / scale);
            let trimmed = trimmer.trim(&sheet.vertices, &sheet.triangles, &go).unwrap();
            check_inside(&mesh, &sheet, &trimmed);
            println!("  {} triangles, {} slivers, {:e}", trimmed.triangles.len(), trimmed.slivers, trimmed.error_mm);
        }
    }
}

#[test]
#[ignore = "needs ../shared/bad-models; .ci/run runs it where that folder exists"]
fn a_model_with_a_hole() {
    let mesh = model("bad-models/hole.stl");
    let trimmer = mesh.trimmer();
    assert!(trimmer.is_holed());
    let (mut hole_mm, mut off_mm) = (0.0, 0.0);
    for layer in 0..20 {
        let sheet = field(40.0, 80, |x, y| 1.3 + 2.0 * f64::from(layer) + 0.001 * (x * x + y * y));
        let trimmed = trimmer.trim(&sheet.vertices, &sheet.triangles, &go).unwrap();
        check(&sheet, &trimmed);
        hole_mm += trimmed.hole_mm;
        // Wrong by more than rounding only where one half passes through a triangle of the sheet.
        let (mut wrong, mut all) = (0.0, 0.0);
        for corners in &trimmed.triangles {
            let [a, b, c] = corners.map(|c| trimmed.vertices[c as usize]);
            let area = (b - a).cross(&(c - a)).norm() / 2.0;
            let number = winding(&mesh, &(P::from((a.coords + b.coords + c.coords) / 3.0) + STEP));
            all += area;
            wrong += if number.abs() > 0.49 { 0.0 } else { area };
        }
        assert!(wrong <= 0.002 * all, "{wrong} of {all} mm2");
        for edge in trimmed.boundary.iter().filter(|edge| edge.kind == BoundaryKind::Hole) {
            let [a, b] = edge.ends.map(|end| trimmed.vertices[end as usize]);
            let number = winding(&mesh, &(a + (b - a) / 2.0)).abs();
            off_mm += if (0.4..0.6).contains(&number) { 0.0 } else { (b - a).norm() };
        }
    }
    println!("boundary over the hole: {hole_mm} mm");
    // Next to the rim the number cannot be decided by an edge of a millimetre.
    assert!(off_mm <= 0.15 * hole_mm && hole_mm > 30.0, "{off_mm} of {hole_mm} mm");
}
