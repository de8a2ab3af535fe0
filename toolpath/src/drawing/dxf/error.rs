//! Why a file, or an entity of it, cannot be read, and where.

use std::fmt;
use std::io;

/// A place in a DXF file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line, from 1.
    Line(u64),
    /// A byte of a binary file, from 0.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Line(line) => write!(f, "line {line}"),
            Place::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// Why a DXF file could not be read. Entities that are damaged are no reason: they are in [`Drawing::skipped`](super::super::Drawing::skipped).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DxfError {
    /// Something that no DXF file can have.
    #[error("{at}: not a DXF file, or a damaged one")]
    NoDxf {
        /// Where.
        at: Place,
    },
    /// The file ends within a section.
    #[error("{at}: the file ends in the middle of a section")]
    Truncated {
        /// Its end.
        at: Place,
    },
    /// There is no section of entities.
    #[error("the file has no section ENTITIES")]
    NoEntities,
    /// More than memory should hold, mostly from arrays of blocks.
    #[error("with its blocks the drawing has more than {limit} segments, arcs and control points")]
    TooMany {
        /// Greatest number.
        limit: u64,
    },
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] io::Error),
}

/// What is wrong with an entity.
#[derive(Clone, Debug)]
pub(super) struct Fault {
    pub what: String,
    /// Where, if not where the entity begins.
    pub at: Option<Place>,
}

impl Fault {
    pub fn new(what: impl Into<String>) -> Self {
        Fault { what: what.into(), at: None }
    }
}
