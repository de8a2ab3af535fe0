//! What comes of a growth: an order, the cells without a layer, and why they have none.

use crate::cells::LayerOrder;
use nalgebra::UnitVector3;

/// Why a cell has no layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissedReason {
    /// It came to lie inside the hull when this layer (counted from 1) was built.
    Shadowed {
        /// The layer; 0 if it lies inside the hull of the platform and its mould.
        layer: u32,
    },
    /// It hangs together with the platform through the part, but all of its supports were missed.
    SupportMissed,
    /// No chain of neighbours joins it to the platform.
    NeverAdjacent,
    /// Neither does it lie outside the hull, nor does the nozzle reach it ([`grow_with_nozzle`](crate::curved::grow_with_nozzle)); or it hangs on
    /// such cells alone.
    OutOfReach,
}

/// A cell without a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissedCell {
    /// Its number.
    pub cell: u32,
    /// Why it has none.
    pub reason: MissedReason,
}

/// Figures about a growth; they are the same on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GrowthStatistics {
    /// Layers in which all candidates could be built at once.
    pub whole_layers: u64,
    /// Sets of candidates that were tried.
    pub trials: u64,
    /// Times when nothing but giving cells up was left.
    pub sacrifices: u64,
}

/// An order of cells, and what it leaves out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Growth {
    /// The layers.
    pub order: LayerOrder,
    /// The cells without a layer, by rising number.
    pub missed: Vec<MissedCell>,
    /// How it went.
    pub statistics: GrowthStatistics,
    /// Cells that were judged by the nozzle, which reaches them, by rising number: those of [`grow_with_nozzle`](crate::curved::grow_with_nozzle), which lie
    /// inside the hull of earlier layers, and all of [`grow_by_distance`](crate::curved::grow_by_distance). The other cells keep the hull rule.
    pub nozzle: Vec<NozzleCell>,
}

impl Growth {
    /// The numbers of the missed cells, rising: what [`audit`](crate::curved::audit()) and [`uniform_field`](crate::curved::surface::uniform_field) take.
    pub fn missed_cells(&self) -> Vec<u32> {
        self.missed.iter().map(|missed| missed.cell).collect()
    }
}

/// A cell that the hull rule does not let build, and how the nozzle stands there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NozzleCell {
    /// The cell.
    pub cell: u32,
    /// From the tip of the nozzle to its block.
    pub direction: UnitVector3<f64>,
}
