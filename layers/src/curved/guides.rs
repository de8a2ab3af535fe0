//! What an order of a part is guided by, besides the shape of the part.

/// What guides an order. By default nothing does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Guides<'a> {
    /// Cells with support, by rising number, though the part may miss nothing without: e.g. those [below](super::Workpiece::cells_below) beads that were found to lie on nothing.
    /// Cells of the part hold it beside their material. Without support ([`CompleteOptions::support`](super::CompleteOptions::support)) they count for nothing.
    pub support: &'a [u32],
    /// How high each cell of the grid lies over a surface, in cells, by its number ([`Workpiece::heights_over`](super::Workpiece::heights_over)): layers of an order by distance
    /// ([`LayersBy::Distance`](super::LayersBy::Distance)) are parallel to it. None: they follow the distance from what the part stands on.
    pub heights: Option<&'a [f64]>,
}
