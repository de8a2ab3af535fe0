//! Meshes that may be read as another part than their author's: said by the loader that all examples share.

use clap::Parser;
use curvlay_examples::args::{MeshArgs, Part};
use curvlay_examples::findings::{Findings, Severity};
use curvlay_examples::mesh::{Mesh, MeshError, MeshFault};
use curvlay_examples::nalgebra::Point3;

#[derive(Parser)]
struct Args {
    #[command(flatten)]
    mesh: MeshArgs,
}

fn load(mesh: &Mesh, options: &[&str]) -> Result<Part, MeshError> {
    let args = Args::try_parse_from([&["test"][..], options].concat()).unwrap();
    args.mesh.load("made here", || mesh.clone())
}

/// A box, its faces outwards or inwards.
fn cuboid(low: f64, high: f64, outwards: bool) -> Mesh {
    let ends = [low, high];
    let corner = |k: usize| Point3::new(ends[k & 1], ends[k >> 1 & 1], ends[k >> 2]);
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let split = |[a, b, c, d]: [u32; 4]| if outwards { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
    Mesh { vertices: (0..8).map(corner).collect(), triangles: quads.into_iter().flat_map(split).collect() }
}

fn and(mut mesh: Mesh, other: &Mesh) -> Mesh {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(&other.vertices);
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|corner| corner + first)));
    mesh
}

fn failed(part: &Part) -> Vec<String> {
    let mut findings = Findings::default();
    part.find(&mut findings);
    findings.of(Severity::Failed).map(|finding| format!("{finding}; {}", finding.allow)).collect()
}

#[test]
fn a_cavity_that_faces_outward_fails_unless_guesses_are_allowed() {
    let same = and(cuboid(0.0, 20.0, true), &cuboid(6.0, 14.0, true));
    let said = failed(&load(&same, &[]).unwrap());
    assert!(said.len() == 1 && said[0].contains("8000.0 mm3, with cavities 7488.0 mm3"), "{said:?}");
    assert!(said[0].ends_with("; --allow-guesses"), "{said:?}");
    let allowed = load(&same, &["--allow-guesses"]).unwrap();
    assert!(failed(&allowed).is_empty() && !allowed.findings.is_empty());
    let proper = load(&and(cuboid(0.0, 20.0, true), &cuboid(6.0, 14.0, false)), &[]).unwrap();
    assert!(proper.findings.is_empty());
    assert!((proper.orientation.volume_mm3 - 7488.0).abs() < 1e-9);
}

/// Two boxes apart are exact, each by itself.
#[test]
fn bodies_apart_have_the_sum_of_their_volumes() {
    let apart = and(cuboid(0.0, 10.0, true), &cuboid(20.0, 32.0, true));
    let part = load(&apart, &[]).unwrap();
    assert!(part.findings.is_empty() && (part.orientation.volume_mm3 - 2728.0).abs() < 1e-9);
}

#[test]
fn open_boxes_and_sheets_are_said() {
    let mut open = cuboid(0.0, 20.0, true);
    open.triangles.truncate(10);
    let said = failed(&load(&open, &[]).unwrap());
    assert!(said[0].contains("1 hole of 400.0 mm2") && said[0].contains("encloses 0 mm3"), "{said:?}");
    let sheet = Mesh {
        vertices: [[0.0, 0.0, 0.0], [20.0, 0.0, 3.0], [20.0, 20.0, 5.0], [0.0, 20.0, 2.0]].map(Point3::from).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let error = load(&Mesh { triangles: vec![[0, 1, 2]], ..sheet.clone() }, &[]).unwrap_err();
    assert!(matches!(error.fault, MeshFault::NoVolume { triangles: 1 }), "{error}");
    let said =
        failed(&load(&and(cuboid(-30.0, -10.0, true), &Mesh { triangles: vec![[0, 1, 2]], ..sheet }), &[]).unwrap());
    assert!(said.len() == 1 && said[0].contains("1 surface without thickness"), "{said:?}");
}
