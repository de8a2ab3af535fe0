//! What kind of input a path is.

use clap::ValueEnum;
use curvlay_examples::args::Failure;
use curvlay_examples::input;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Kinds of input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// An order of cells: CSV, legacy VTK
    Cells,
}

/// What is read, once the kind is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The kind.
    pub kind: Kind,
    /// The files, in the order in which they are built.
    pub files: Vec<PathBuf>,
}

/// Bytes at the start of a file by which its kind is known.
const HEAD_BYTES: u64 = 4096;

/// Finds the kind of a path by its name and its first bytes.
///
/// # Errors
/// A line with the path, and what would be known.
pub fn source(path: &Path, asked: Option<Kind>) -> Result<Source, Failure> {
    let kind = match asked {
        Some(kind) => kind,
        None => known(path)?,
    };
    Ok(Source { kind, files: vec![path.to_owned()] })
}

fn known(path: &Path) -> Result<Kind, Failure> {
    let mut head = String::new();
    let mut bytes = Vec::new();
    let file = input::open(path, input::MAX_DATA_BYTES)?;
    file.take(HEAD_BYTES).read_to_end(&mut bytes).map_err(|error| fault(path, &format!("cannot be read: {error}")))?;
    head.push_str(&String::from_utf8_lossy(&bytes));
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let is_vtk = head.starts_with("# vtk DataFile");
    match ending.as_deref() {
        _ if head.trim().is_empty() => Err(fault(path, "is empty")),
        _ if is_vtk => Ok(Kind::Cells),
        Some("csv") => Ok(Kind::Cells),
        _ if head.starts_with("curvlay field ") => {
            Err(fault(path, "is an even field, which has no order: take field.csv of the same run"))
        }
        _ => Err(fault(path, "is of no kind that is known: cells as .csv or .vtk; name the kind with --as")),
    }
}

fn fault(path: &Path, what: &str) -> Failure {
    Failure::new(format!("{}: {what}", path.display()))
}
