//! What an order of a part is guided by, besides the shape of the part.

use nalgebra::Vector3;

/// What guides an order. By default nothing does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Guides<'a> {
    /// Cells with support, by rising number, though the part may miss nothing without: e.g. those [below](crate::curved::Workpiece::cells_below) beads that were found to lie on nothing.
    /// Cells of the part hold it beside their material. Without support ([`LayerOptions::support`](crate::curved::LayerOptions::support)) they count for nothing.
    pub support: &'a [u32],
    /// How high each cell of the grid lies over a surface, in cells, by its number ([`Workpiece::heights_over`](crate::curved::Workpiece::heights_over)): layers of an order by distance
    /// ([`LayersBy::Distance`](crate::curved::LayersBy::Distance)) are parallel to it. None: they follow the distance from what the part stands on.
    pub heights: Option<&'a [f64]>,
    /// A direction for each cell of the grid, by its number ([`Workpiece::directions_at`](crate::curved::Workpiece::directions_at)), of length 0 where there is none: a directed order
    /// ([`LayersBy::Directed`](crate::curved::LayersBy::Directed)) follows them up to the lean that layers may have. `None`: it follows the distance from what the part stands on.
    pub directions: Option<&'a [Vector3<f64>]>,
}
