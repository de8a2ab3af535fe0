//! What has been written.

/// What [`write_rapid`](super::write_rapid) has written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RapidWritten {
    /// Part modules.
    pub modules: u32,
    /// Moves in them.
    pub moves: u64,
    /// Moves that were to be blended, but stop because a module ends there.
    pub stops_added: u32,
    /// Seconds of the moves by their own speeds ([`program_seconds`](crate::program::program_seconds)).
    pub seconds: f64,
}
