//! A fault of a file, with its name.

use curvlay_examples::args::Failure;
use std::path::Path;

pub fn fault(path: &Path, what: impl std::fmt::Display) -> Failure {
    Failure::new(format!("{}: {what}", path.display()))
}
