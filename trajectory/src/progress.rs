//! How far long work has come.

use std::ops::ControlFlow;

/// What a caller is called with along the way; it may stop the work.
pub type ProgressFn<'a> = &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync + 'a);

/// How far a long computation has come; handed to the caller's callback, which may stop the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What is being done, as a short word or two.
    pub stage: &'static str,
    /// Units of work finished in this stage.
    pub done: u64,
    /// Units of work in this stage; 0 when unknown.
    pub total: u64,
}
