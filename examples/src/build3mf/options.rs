//! What a build is written with, and what came of it.

/// What a build says beside mesh and segments.
#[derive(Clone, Copy, Debug)]
pub struct BuildOptions<'a> {
    /// Name of the part.
    pub name: &'a str,
    /// Writes travels as segments, and marks our namespace as required: a consumer that does not know it would lay beads on them. Without them
    /// consumers find ways of their own from bead to bead, through the part if they do not know better.
    pub travels: bool,
}

/// What has been written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildWritten {
    /// Parts with layers; a layer of more than [`MAX_LINES`](super::MAX_LINES) lines has several.
    pub parts: usize,
    /// Segments.
    pub segments: usize,
    /// Lines of all segments.
    pub lines: usize,
}
