//! Why a build could not be written.

use std::io;

/// Why a build could not be written. Segments and lines are counted from 0.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteBuildError {
    /// The mesh has no triangle.
    #[error("the mesh has no triangles: a 3MF object needs them")]
    NoMesh,
    /// There is nothing to print.
    #[error("there is no segment to write")]
    NoSegments,
    /// A move names a path, a waypoint or a place that is not there.
    #[error("move {index} does not go with the paths: {what}")]
    Moves {
        /// The move, from 0.
        index: usize,
        /// What does not go with them.
        what: &'static str,
    },
    /// A segment that cannot be one.
    #[error("segment {segment}: {what}")]
    Segment {
        /// The segment.
        segment: usize,
        /// What is wrong.
        what: &'static str,
    },
    /// A number of a segment that is not finite or out of its range.
    #[error("segment {segment}, line {line}: `{what}` is {value}; it must be from {least} to {most}")]
    Number {
        /// The segment.
        segment: usize,
        /// The line of it.
        line: usize,
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least value allowed.
        least: f64,
        /// Greatest value allowed.
        most: f64,
    },
    /// The second time the segments were others than the first time.
    #[error("segment {segment} is not the one that was there when the segments were measured")]
    Changed {
        /// The segment.
        segment: usize,
    },
    /// The archive cannot be written.
    #[error("the package cannot be written: {0}")]
    Archive(String),
    /// The output cannot be written.
    #[error("the file cannot be written: {0}")]
    Io(#[from] io::Error),
}

impl From<zip::result::ZipError> for WriteBuildError {
    fn from(error: zip::result::ZipError) -> Self {
        match error {
            zip::result::ZipError::Io(error) => WriteBuildError::Io(error),
            other => WriteBuildError::Archive(other.to_string()),
        }
    }
}
