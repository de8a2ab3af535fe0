//! What an instruction of RAPID comes to.

use crate::program::Step;

/// What an instruction comes to.
#[derive(Clone, Debug)]
pub(super) enum Op {
    Step(Step),
    /// A procedure is called, by its name or late, by a text.
    Call(String),
    Load(String),
    UnLoad,
    /// It moves nothing.
    Nothing,
    /// The end of the procedure.
    End,
}
