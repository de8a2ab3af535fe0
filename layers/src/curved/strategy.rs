//! Strategies by name, and the best of them for a part.
//!
//! Dai 2020, section 3.4, has four strategies; un-building is ours. [`Strategy::Incremental`] makes the most uniform layers
//! and nearly always misses nothing. [`Strategy::Unbuild`] misses the fewest cells, but its fronts wait more for each other.
//! So the best one is incremental unless that misses cells and un-building fills more of the part
//! ([`Workpiece::order`](super::Workpiece::order)).

use super::growth::{Growth, GrowthError, GrowthOptions, Prevention, grow, grow_as_printed};
use super::unbuild::{UnbuildOptions, unbuild};
use crate::ProgressFn;
use crate::cells::Cells;
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::growth::{PeelError, peel};
use std::fmt;

/// How the next layer of cells is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Strategy {
    /// All cells that can be built now (Algorithm 1).
    Greedy,
    /// Cell by cell, unless one shadows others (Algorithm 2).
    Incremental,
    /// All, halving the set while it shadows others (Algorithm 3).
    Adaptive,
    /// In the order of a peeling field (Algorithms 4 and 5), with this prevention of shadows. Sheets of the field hold the cells at
    /// exactly the depth `eps`, too: with a whole `eps` they would be a cell thinner under flat facets than under slanted ones,
    /// and since each takes the growth as many layers as its thickest part, the flat parts would skip layers.
    Governed(Prevention),
    /// Algorithms 4 and 5 as printed, with Algorithm 2 or 3 inside ([`grow_as_printed`]): to compare with.
    Printed(Prevention),
    /// In the reverse of the order in which the part can be taken apart.
    Unbuild,
}

impl Strategy {
    /// Its name in one word.
    pub fn name(self) -> &'static str {
        match self {
            Strategy::Greedy => "greedy",
            Strategy::Incremental => "incremental",
            Strategy::Adaptive => "adaptive",
            Strategy::Governed(_) => "governed",
            Strategy::Printed(_) => "printed",
            Strategy::Unbuild => "unbuild",
        }
    }

    /// Grows an order of the cells by this strategy, with the default options of each.
    ///
    /// # Arguments
    /// * `progress`: called with the stages `peel` ([`Strategy::Governed`], [`Strategy::Printed`]), `unbuild` ([`Strategy::Unbuild`]) and `grow`; may cancel.
    ///
    /// # Errors
    /// [`GrowthError`]; cells that cannot be built are listed with the reason.
    ///
    /// # Cost
    /// That of [`grow`], [`peel`](crate::curved::peel()) or [`unbuild`].
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// use curvlay_layers::curved::{Platform, Rules, Strategy};
    /// use std::ops::ControlFlow;
    /// let cells = Cells::new([1, 1, 3], &[1; 3])?;
    /// let platform = Platform::under(&cells, 10.0)?;
    /// let growth = Strategy::Greedy.grow(&cells, &platform, &Rules::default(), &|_| ControlFlow::Continue(()))?;
    /// assert_eq!(growth.order.len(), 3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn grow(
        self,
        cells: &Cells,
        platform: &Platform,
        rules: &Rules,
        progress: ProgressFn,
    ) -> Result<Growth, GrowthError> {
        let with = |prevention, governor: Option<&_>| {
            let options = GrowthOptions { prevention, ..GrowthOptions::default() };
            grow(cells, platform, rules, &options, governor, progress)
        };
        match self {
            Strategy::Greedy => with(Prevention::None, None),
            Strategy::Incremental => with(Prevention::Incremental, None),
            Strategy::Adaptive => with(Prevention::Adaptive, None),
            Strategy::Governed(prevention) => {
                let thick_sheets = Rules { boundary_is_inside: false, ..*rules };
                with(prevention, Some(&peel(cells, platform, &thick_sheets, progress)?))
            }
            Strategy::Printed(prevention) => {
                let field = peel(cells, platform, rules, progress)?;
                grow_as_printed(cells, platform, rules, prevention, &field, progress)
            }
            Strategy::Unbuild => unbuild(cells, platform, rules, &UnbuildOptions::default(), progress),
        }
    }
}

impl fmt::Display for Strategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl From<PeelError> for GrowthError {
    fn from(error: PeelError) -> Self {
        match error {
            PeelError::Rules(rules) => GrowthError::Rules(rules),
            PeelError::Hull(hull) => GrowthError::Hull(hull),
            PeelError::Cancelled => GrowthError::Cancelled,
        }
    }
}
