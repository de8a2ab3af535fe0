//! How a command ends.

use std::error::Error;
use std::fmt::Display;

/// How an example ended that could do its work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All is well.
    Done,
    /// Checks failed: which, a line each, of those that were not reported yet.
    ChecksFailed(Vec<String>),
}

impl Outcome {
    /// Done, if no check failed.
    pub fn of(failed: Vec<String>) -> Self {
        if failed.is_empty() { Outcome::Done } else { Outcome::ChecksFailed(failed) }
    }
}

/// Input or output that cannot be used, or arguments that do not go together, in one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    message: String,
    pub(crate) status: u8,
}

impl Failure {
    /// Input or output that cannot be used. Takes the message; line breaks become spaces.
    pub fn new(message: impl Display) -> Self {
        let message = message.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
        Failure { message, status: UNUSABLE }
    }

    /// The same for arguments that cannot be used together.
    pub fn of_arguments(message: impl Display) -> Self {
        Failure { status: ARGUMENTS, ..Failure::new(message) }
    }

    /// The line.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl<E: Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Failure::new(error)
    }
}

/// Exit status for input or output that cannot be used.
pub(crate) const UNUSABLE: u8 = 1;
/// Exit status for arguments that cannot be used.
pub(crate) const ARGUMENTS: u8 = 2;
/// Exit status of a run that finished, but a check of ours failed.
pub(crate) const CHECK_FAILED: u8 = 3;
