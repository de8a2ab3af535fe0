//! A five-axis machine as a JSON file.

use super::error::MachineError;
#[cfg(feature = "serde")]
use super::geometry::FiveAxis;
#[cfg(feature = "serde")]
use super::model::{MachineModel, VERSION};
#[cfg(feature = "serde")]
use crate::json::JsonFault;

/// Why a file is no five-axis machine.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachineFileError {
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
    /// A value makes no machine.
    #[error(transparent)]
    Machine(#[from] MachineError),
}

#[cfg(feature = "serde")]
impl From<serde_json::Error> for MachineFileError {
    fn from(error: serde_json::Error) -> Self {
        match JsonFault::from(error) {
            JsonFault::Io(what) => MachineFileError::Io { what },
            JsonFault::At([line, column], what) => MachineFileError::Json { line, column, what },
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
impl MachineModel {
    /// Reads a model from a JSON file. Its numbers are not checked yet: [`FiveAxis::from_json`] reads and checks.
    ///
    /// # Errors
    /// [`MachineFileError::Io`]; [`MachineFileError::Json`] with line and column; [`MachineError::Version`] where a file of another version
    /// does not have the fields of this one.
    pub fn from_json(mut input: impl std::io::Read) -> Result<Self, MachineFileError> {
        let mut text = String::new();
        input.read_to_string(&mut text).map_err(|error| MachineFileError::Io { what: error.to_string() })?;
        serde_json::from_str(&text).map_err(|error| match serde_json::from_str(&text) {
            // Another version has other fields; these are not what is wrong then.
            Ok(Versioned { version }) if version != VERSION => MachineError::Version { found: version }.into(),
            _ => error.into(),
        })
    }

    /// Writes the model as JSON. Read again it is the same to the last bit.
    ///
    /// # Errors
    /// [`MachineFileError::Io`]; [`MachineFileError::Machine`] names the value that makes no machine.
    pub fn write_json(&self, mut output: impl std::io::Write) -> Result<(), MachineFileError> {
        FiveAxis::new(self.clone())?;
        let io = |error: std::io::Error| MachineFileError::Io { what: error.to_string() };
        serde_json::to_writer_pretty(&mut output, self)?;
        writeln!(output).map_err(io)?;
        output.flush().map_err(io)
    }
}

#[cfg(feature = "serde")]
impl FiveAxis {
    /// Reads a machine from a JSON file and checks it.
    ///
    /// # Errors
    /// [`MachineFileError`] names line and column, or the field.
    pub fn from_json(input: impl std::io::Read) -> Result<Self, MachineFileError> {
        Ok(Self::new(MachineModel::from_json(input)?)?)
    }
}
