//! Why nothing could be grown.

use crate::curved::buildable::rules::RulesError;
use crate::curved::nozzle::NozzleRuleError;
use curvlay_hull::HullError;

/// Why nothing could be grown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GrowthError {
    /// The rules are unsound.
    #[error(transparent)]
    Rules(#[from] RulesError),
    /// There is no cell.
    #[error("there is no cell to build")]
    NoCell,
    /// No cell stands on the platform.
    #[error("no cell stands on the platform: the part must reach down to z = 0 above it, or to its mould")]
    NothingOnPlatform,
    /// The governing field is of another grid.
    #[error("the governing field has {field} values for a grid of {cells} cells")]
    Field {
        /// Values of the field.
        field: usize,
        /// Cells of the grid, empty ones included.
        cells: usize,
    },
    /// Growth as printed, with a prevention that is not in that work.
    #[error("growth as printed has no prevention `fewer than all`: take incremental, adaptive or none")]
    NotPrinted,
    /// The order to go on from is of other cells.
    #[error("the order has cell {cell}, which neither the part nor its mould has: it is of another grid")]
    OtherCells {
        /// The cell.
        cell: u32,
    },
    /// Layers cannot lean so far.
    #[error("layers may lean by 0 to less than 90 degrees, not by {}", tilt.to_degrees())]
    LayerTilt {
        /// The angle from level, in radians.
        tilt: f64,
    },
    /// Heights of other cells, or heights that are not finite.
    #[error("heights over a surface must be finite, and one for each of the {len} cells of the grid")]
    Heights {
        /// Cells of the grid.
        len: usize,
    },
    /// Directions of other cells, or directions that are invalid.
    #[error("directions of growth must be finite, and one for each of the {len} cells of the grid")]
    Directions {
        /// Cells of the grid.
        len: usize,
    },
    /// The nozzle cannot be judged by.
    #[error(transparent)]
    Nozzle(#[from] NozzleRuleError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
    /// The platform and the cells do not fit the exact range of the hull.
    #[error(transparent)]
    Hull(#[from] HullError),
}
