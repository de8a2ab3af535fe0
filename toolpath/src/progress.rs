//! How far long work has come.

use std::ops::ControlFlow;

/// How far a long computation has come; handed to the caller's callback, which may cancel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What is being done, as a short word or two.
    pub stage: &'static str,
    /// Units of work finished in this stage.
    pub done: u64,
    /// Units of work in this stage.
    pub total: u64,
}

/// What long work calls with its [`Progress`], from any of its threads; `Break` cancels it.
pub type ProgressFn<'a> = &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync + 'a);
