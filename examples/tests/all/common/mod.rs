//! What the tests of examples share.

use curvlay_examples::output::OutputFolder;
use serde_json::{Map, Value};
use std::fs;
use std::path::{Path, PathBuf};

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
