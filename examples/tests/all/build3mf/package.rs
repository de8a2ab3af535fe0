//! The container, by the reader of meshes, which shares no code with the writer of builds.

use super::{mesh, parts, travel, wall, written};
use curvlay_examples::findings::Severity;
use curvlay_examples::mesh::read_mesh_file;
use std::fs;

/// The mesh is the one that was given, to the last bit, and nothing is said of it.
#[test]
fn the_mesh_reader_finds_the_mesh() {
    for travels in [true, false] {
        let path = std::env::temp_dir().join(format!("curvlay-build-{}-{travels}.3mf", std::process::id()));
        fs::write(&path, written(&[wall(), travel()], travels)).unwrap();
        let file = read_mesh_file(&path);
        fs::remove_file(&path).unwrap();
        let file = file.unwrap();
        assert_eq!(file.mesh, mesh());
        let doubts: Vec<_> = file.findings.iter().filter(|finding| finding.severity != Severity::Note).collect();
        assert!(doubts.is_empty(), "{doubts:?}");
    }
}

/// A package that needs yet another extension is read with a warning, as before.
#[test]
fn other_extensions_are_still_warned_of() {
    let mut all = parts(&written(&[wall()], false));
    let model = &mut all[3].1;
    *model =
        model.replace("requiredextensions=\"p tp\"", "xmlns:x=\"http://example.org/x\" requiredextensions=\"p tp x\"");
    let path = std::env::temp_dir().join(format!("curvlay-build-{}-x.3mf", std::process::id()));
    fs::write(&path, super::package_of(&all)).unwrap();
    let file = read_mesh_file(&path);
    fs::remove_file(&path).unwrap();
    let text = format!("{:?}", file.unwrap().findings);
    assert!(text.contains("http://example.org/x"), "{text}");
}
