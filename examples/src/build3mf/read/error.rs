//! Why a build cannot be read.

use std::io;

/// Why a build cannot be read. `part` is the file within the package; segments and points are counted from 1, as a reader of the file counts.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadBuildError {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Io(#[source] io::Error),
    /// No ZIP archive, or one that is cut short or damaged.
    #[error("the ZIP archive cannot be read: {0}; fetch or export it anew")]
    Archive(String),
    /// A part that another one names is not there.
    #[error("there is no {part} in the package")]
    NoPart {
        /// The part.
        part: String,
    },
    /// More than is taken from one package.
    #[error("{part}: more than {limit}")]
    TooMuch {
        /// The part.
        part: String,
        /// What is taken at most.
        limit: &'static str,
    },
    /// A part that is not well-formed XML.
    #[error("{part}: {what}")]
    Xml {
        /// The part.
        part: String,
        /// What is wrong, and where.
        what: String,
    },
    /// A relationship that the format requires is missing.
    #[error("{from} has no relationship of type {kind} to {target}")]
    NoRelationship {
        /// Who lacks it: a part, or the package as a whole.
        from: String,
        /// Its type.
        kind: &'static str,
        /// To what.
        target: String,
    },
    /// The model has no toolpath.
    #[error(
        "{part}: the model has no toolpath resource (namespace http://schemas.3mf.io/3dmanufacturing/toolpath/2026/03)"
    )]
    NoToolpath {
        /// The model.
        part: String,
    },
    /// The package requires an extension that this reader does not know.
    #[error("{part}: the package requires the extension {namespace}, which is not known here")]
    Extension {
        /// The model.
        part: String,
        /// Its namespace.
        namespace: String,
    },
    /// Something that the format allows and this reader does not read.
    #[error("{part}: {what} is not read here")]
    Unsupported {
        /// The part.
        part: String,
        /// What it is.
        what: String,
    },
    /// An attribute that is missing or that says nothing valid.
    #[error("{part}, {place}: `{attribute}` is {found}; it must be {wanted}")]
    Attribute {
        /// The part.
        part: String,
        /// The element.
        place: String,
        /// The attribute.
        attribute: String,
        /// What stands there.
        found: String,
        /// What it may be.
        wanted: &'static str,
    },
    /// A segment names a profile that its layer does not declare.
    #[error("{part}, segment {segment}: there is no profile {id} in this layer")]
    UnknownProfile {
        /// The part.
        part: String,
        /// The segment.
        segment: usize,
        /// What it names.
        id: u32,
    },
    /// A segment names a part of the build that its layer does not declare.
    #[error("{part}, segment {segment}: there is no part {id} in this layer")]
    UnknownPart {
        /// The part of the package.
        part: String,
        /// The segment.
        segment: usize,
        /// What it names.
        id: u32,
    },
    /// A layer names a profile or an item of the build by a UUID that the model does not have.
    #[error("{part}: the model has no {what} with the UUID {uuid}")]
    UnknownUuid {
        /// The part.
        part: String,
        /// A profile or a build item.
        what: &'static str,
        /// The UUID.
        uuid: String,
    },
    /// A line needs two points.
    #[error("{part}, segment {segment}: {points} of at least 2 points")]
    FewPoints {
        /// The part.
        part: String,
        /// The segment.
        segment: usize,
        /// Points that it has.
        points: usize,
    },
    /// A quaternion that is not of unit length.
    #[error("{part}, segment {segment}, point {point}: the quaternion has the length {length}; it must be 1")]
    Quaternion {
        /// The part.
        part: String,
        /// The segment.
        segment: usize,
        /// The point.
        point: usize,
        /// Its length.
        length: f64,
    },
}
