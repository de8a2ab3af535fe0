//! How segments share parts of the package.

use super::Segment;

/// Lines of a part, and of a segment, from which on another one begins: readers hold a part at a time. With 0.3 mm between waypoints that is
/// 15 m of bead.
pub const MAX_LINES: usize = 50_000;

/// Goes through segments in their order and says where a part begins.
#[derive(Default)]
pub(super) struct Parts {
    layer: Option<u32>,
    lines: usize,
}

impl Parts {
    /// Whether a part begins with this segment: the layer is another, or the part is full.
    pub(super) fn begins(&mut self, segment: &Segment) -> bool {
        let count = segment.lines.len();
        let begins = self.layer != Some(segment.layer) || self.lines + count > MAX_LINES;
        self.lines = if begins { count } else { self.lines + count };
        self.layer = Some(segment.layer);
        begins
    }
}
