//! Good, ok or poor: Table 6.4 of the thesis, computed.
//!
//! H. Boge, *Robotic additive manufacturing* (MSc thesis, NTNU 2019), section 6.2.4: good is a field without missed cells and with
//! few layers, ok one with an acceptable number of missed cells and few layers, the rest is poor. The thesis gives no
//! numbers. The two bounds here are ours, and chosen after her table: of her 36 verdicts one is "ok" (3 of 59 cells missed),
//! and the poor one nearest to it misses 3 of 51.

use super::grown::Run;
use curvlay_voxel::TextGrid;
use std::fmt;

/// The largest share of missed cells that is acceptable: between 3 / 59 and 3 / 51.
const ACCEPTABLE: f64 = 0.055;

/// Few are this many layers for each level of cells, or fewer. Her good fields have up to 1.2, her poor ones without many
/// missed cells none.
const FEW: f64 = 1.5;

/// How good a growing field is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rating {
    /// Nothing is missed, and there are few layers.
    Good,
    /// Little is missed, and there are few layers.
    Ok,
    /// The rest.
    Poor,
}

impl Rating {
    /// The rating of a run.
    pub fn of(run: &Run, drawn: &TextGrid) -> Self {
        let levels = (drawn.grid.iter()).map(|cell| drawn.grid.position(cell)[2] + 1).max().unwrap_or(0);
        Self::from_counts(drawn.grid.count(), levels, run.growth.missed.len(), run.growth.order.len())
    }

    /// The rating of an object of so many cells on so many levels.
    fn from_counts(cells: usize, levels: u32, missed: usize, layers: usize) -> Self {
        let few = layers as f64 <= FEW * f64::from(levels);
        match missed {
            0 if few => Rating::Good,
            _ if few && missed as f64 <= ACCEPTABLE * cells as f64 => Rating::Ok,
            _ => Rating::Poor,
        }
    }
}

impl fmt::Display for Rating {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Rating::Good => "good",
            Rating::Ok => "ok",
            Rating::Poor => "poor",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Rating;

    #[test]
    fn many_layers_or_missed_cells_are_poor() {
        let cases = [
            ((100, 10, 0, 15), Rating::Good),
            ((100, 10, 0, 16), Rating::Poor),
            ((100, 10, 5, 10), Rating::Ok),
            ((100, 10, 6, 10), Rating::Poor),
            ((100, 10, 5, 20), Rating::Poor),
            ((0, 0, 0, 0), Rating::Good),
        ];
        for ((cells, levels, missed, layers), rating) in cases {
            assert_eq!(Rating::from_counts(cells, levels, missed, layers), rating, "{cells} {missed} {layers}");
        }
    }
}
