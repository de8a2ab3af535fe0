//! Strategies by name, and the best of them for a part.
//!
//! Dai 2020, section 3.4, has four strategies; un-building is ours. [`Strategy::Incremental`] makes the most uniform layers
//! and nearly always misses nothing. [`Strategy::Unbuild`] misses the fewest cells, but its fronts wait more for each other.
//! So the best one is incremental unless that misses cells and un-building misses fewer ([`best_growth`]; with the
//! surfaces at hand [`Workpiece::layers`](super::Workpiece::layers) compares volumes).

use super::cells::Cells;
use super::growth::{Growth, GrowthError, GrowthOptions, Prevention, grow};
use super::peel::{PeelError, peel};
use super::platform::Platform;
use super::rules::Rules;
use super::unbuild::{UnbuildOptions, unbuild};
use crate::Progress;
use std::fmt;
use std::ops::ControlFlow;

/// How the next layer of cells is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// All cells that can be built now (Algorithm 1).
    Greedy,
    /// Cell by cell, unless one shadows others (Algorithm 2).
    Incremental,
    /// All, halving the set while it shadows others (Algorithm 3).
    Adaptive,
    /// In the order of a peeling field (Algorithms 4 and 5), with this prevention of shadows.
    Governed(Prevention),
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
            Strategy::Unbuild => "unbuild",
        }
    }

    /// Grows an order of the cells by this strategy, with the default options of each.
    ///
    /// # Arguments
    /// * `progress`: called with the stages `peel` ([`Strategy::Governed`]), `unbuild` ([`Strategy::Unbuild`]) and `grow`; may cancel.
    ///
    /// # Errors
    /// [`GrowthError`]; cells that cannot be built are listed with the reason.
    ///
    /// # Cost
    /// That of [`grow`], [`peel`](super::peel()) or [`unbuild`].
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::curved::{Cells, Platform, Rules, Strategy};
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
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<Growth, GrowthError> {
        let with = |prevention, governor: Option<&_>| {
            let options = GrowthOptions { prevention, ..GrowthOptions::default() };
            grow(cells, platform, rules, &options, governor, progress)
        };
        match self {
            Strategy::Greedy => with(Prevention::None, None),
            Strategy::Incremental => with(Prevention::Incremental, None),
            Strategy::Adaptive => with(Prevention::Adaptive, None),
            Strategy::Governed(prevention) => with(prevention, Some(&peel(cells, platform, rules, progress)?)),
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

/// Grows by [`Strategy::Incremental`], and where that misses cells by [`Strategy::Unbuild`] as well; the result is the
/// growth that misses fewer cells, the incremental one if both miss as many.
///
/// # Errors
/// [`GrowthError`].
///
/// # Cost
/// That of one growth, or of both.
///
/// # Example
/// ```
/// use curvlay_layers::curved::{Cells, Platform, Rules, Strategy, best_growth};
/// use std::ops::ControlFlow;
/// let cells = Cells::new([2, 1, 2], &[0b11, 0b11])?;
/// let platform = Platform::under(&cells, 10.0)?;
/// let (strategy, growth) = best_growth(&cells, &platform, &Rules::default(), &|_| ControlFlow::Continue(()))?;
/// assert_eq!((strategy, growth.missed.len()), (Strategy::Incremental, 0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn best_growth(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<(Strategy, Growth), GrowthError> {
    let incremental = Strategy::Incremental.grow(cells, platform, rules, progress)?;
    if incremental.missed.is_empty() {
        return Ok((Strategy::Incremental, incremental));
    }
    let unbuilt = Strategy::Unbuild.grow(cells, platform, rules, progress)?;
    Ok(match unbuilt.missed.len() < incremental.missed.len() {
        true => (Strategy::Unbuild, unbuilt),
        false => (Strategy::Incremental, incremental),
    })
}
