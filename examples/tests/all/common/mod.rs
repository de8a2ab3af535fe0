//! What the tests of examples share.

use curvlay_examples::output::OutputFolder;
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// An example, which `cargo test` has built beside this test.
pub fn example(name: &str) -> Command {
    let beside = std::env::current_exe().unwrap();
    let program = beside.ancestors().nth(2).unwrap().join("examples").join(name);
    assert!(program.exists(), "build the examples first: cargo build --examples");
    Command::new(program)
}

/// A page on formats; all of them, one after the other, for no name.
pub fn formats(page: Option<&str>) -> String {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats");
    let pages = match page {
        Some(page) => vec![docs.join(page)],
        None => fs::read_dir(&docs).unwrap().map(|file| file.unwrap().path()).collect(),
    };
    pages.into_iter().map(|page| fs::read_to_string(page).unwrap()).collect()
}

/// Where the keys of summaries of `curved_layers` stand: settings have the page of profiles.
pub fn summary_keys() -> String {
    formats(Some("summary.md")) + &formats(Some("profiles.md"))
}

/// Whether the text of a page has each key of a summary as a word.
pub fn assert_has_keys(page: &str, summary: &Map<String, Value>) {
    let words: BTreeSet<&str> = page.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    let missing: Vec<_> = summary.keys().filter(|key| !words.contains(key.as_str())).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

/// What a page on formats says of an example: its section, up to the next one.
pub fn format_section(page: &str, example: &str) -> String {
    let text = formats(Some(page));
    let (_, section) = text.split_once(&format!("\n## `{example}`\n")).unwrap();
    section.split("\n## ").next().unwrap().to_owned()
}

/// The Rust listings of a chapter of the guide, in their order.
pub fn listings(chapter: &str) -> Vec<String> {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/guide");
    let page = fs::read_to_string(guide.join(chapter)).unwrap();
    page.split("```rust\n").skip(1).map(|rest| rest.split_once("```").unwrap().0.to_owned()).collect()
}

/// Boxes as OBJ.
pub fn boxes_as_obj(boxes: &[[[i32; 3]; 2]]) -> String {
    let mut text = String::new();
    for bounds in boxes {
        for k in 0..8usize {
            let [x, y, z] = [0, 1, 2].map(|axis| bounds[k >> axis & 1][axis]);
            text.push_str(&format!("v {x} {y} {z}\n"));
        }
    }
    for first in (0..boxes.len()).map(|at| 8 * at + 1) {
        for quad in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            let [a, b, c, d] = quad.map(|corner| corner + first);
            text.push_str(&format!("f {a} {b} {c} {d}\n"));
        }
    }
    text
}

/// A place for the files of a test.
pub fn place(example: &str, name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(example).join(name)
}

/// The output folder there.
pub fn folder(example: &str, name: &str) -> OutputFolder {
    OutputFolder::create(&place(example, name)).unwrap()
}

/// The figures that a run has left there.
pub fn summary(folder: &Path) -> Map<String, Value> {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}
