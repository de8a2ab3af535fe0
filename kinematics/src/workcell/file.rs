//! A workcell as a JSON file.

use super::check::WorkcellError;
#[cfg(feature = "serde")]
use super::model::{VERSION, WorkcellModel};
#[cfg(feature = "serde")]
use crate::json::JsonFault;

/// Why a file is no workcell.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorkcellFileError {
    /// The file cannot be read or written.
    #[error("{what}")]
    Io {
        /// What the system says.
        what: String,
    },
    /// The file is not JSON, a field is missing, unknown or of another kind.
    #[error("line {line}, column {column}: {what}")]
    Json {
        /// The line, counted from 1.
        line: usize,
        /// The column, counted from 1.
        column: usize,
        /// What is wrong there.
        what: String,
    },
    /// A value makes no workcell.
    #[error(transparent)]
    Workcell(#[from] WorkcellError),
}

#[cfg(feature = "serde")]
impl From<serde_json::Error> for WorkcellFileError {
    fn from(error: serde_json::Error) -> Self {
        match JsonFault::from(error) {
            JsonFault::Io(what) => WorkcellFileError::Io { what },
            JsonFault::At([line, column], what) => WorkcellFileError::Json { line, column, what },
        }
    }
}

/// A file of any version.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Versioned {
    version: u32,
}

#[cfg(feature = "serde")]
impl WorkcellModel {
    /// Reads a model from a JSON file, as the [module](crate::workcell) describes it. Its numbers are not checked yet:
    /// [`AnyWorkcell::from_json`](super::AnyWorkcell::from_json) reads and checks.
    ///
    /// # Errors
    /// [`WorkcellFileError::Io`]; [`WorkcellFileError::Json`] with line and column; [`WorkcellError::Version`] where a file of
    /// another version does not have the fields of this one.
    pub fn from_json(mut input: impl std::io::Read) -> Result<Self, WorkcellFileError> {
        let mut text = String::new();
        input.read_to_string(&mut text).map_err(|error| WorkcellFileError::Io { what: error.to_string() })?;
        serde_json::from_str(&text).map_err(|error| match serde_json::from_str(&text) {
            // Another version has other fields; these are not what is wrong then.
            Ok(Versioned { version }) if version != VERSION => WorkcellError::Version { found: version }.into(),
            _ => error.into(),
        })
    }

    /// Writes the model as JSON. Read again it is the same to the last bit.
    ///
    /// # Errors
    /// [`WorkcellFileError::Io`]; [`WorkcellFileError::Workcell`] names the number that is not finite, which JSON does not
    /// have, or another value that makes no workcell.
    pub fn write_json(&self, mut output: impl std::io::Write) -> Result<(), WorkcellFileError> {
        // Meshes of links are not looked at: any will do.
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(nalgebra::Point3::from);
        super::AnyWorkcell::with_link_meshes(self.clone(), &mut |_| Ok((corners.to_vec(), vec![[0, 1, 2]])))?;
        let io = |error: std::io::Error| WorkcellFileError::Io { what: error.to_string() };
        serde_json::to_writer_pretty(&mut output, self)?;
        writeln!(output).map_err(io)?;
        output.flush().map_err(io)
    }
}
