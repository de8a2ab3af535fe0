//! What is wrong with a flavour.

/// A field of a flavour that cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the flavour `{flavour}`: `{field}`: {problem}")]
pub struct FlavourError {
    /// Name of the flavour.
    pub flavour: String,
    /// The field, as a path in its JSON.
    pub field: String,
    /// What is wrong, and what to do.
    pub problem: String,
}
