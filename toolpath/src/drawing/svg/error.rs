//! Why a drawing cannot be read.

/// Why an SVG file could not be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SvgError {
    /// It is no SVG; line and column are named where they are known.
    #[error("not a readable SVG file: {what}")]
    Invalid {
        /// What is wrong.
        what: String,
    },
    /// It is compressed, and too large.
    #[error("uncompressed it has more than {limit} bytes")]
    TooLarge {
        /// Greatest size, in bytes.
        limit: u64,
    },
    /// It is in an encoding that is not known.
    #[error("its encoding `{name}` is not known; save it as UTF-8")]
    Encoding {
        /// As the file names it.
        name: String,
    },
    /// Numbers that are too large.
    #[error(
        "line {line}: `{attribute}` has numbers beyond {limit:e}, farther than any drawing: correct it or delete the shape"
    )]
    TooFar {
        /// The attribute that they are in.
        attribute: String,
        /// The line where it begins.
        line: u32,
        /// What they must not exceed: of a path, their sum.
        limit: f64,
    },
    /// A scale that is out of its range.
    #[error("{what} is {value}; it must be {range}")]
    Scale {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
}

pub(super) fn invalid(error: impl ToString) -> SvgError {
    SvgError::Invalid { what: error.to_string() }
}
