//! Uniform layers: an accepted order becomes a smooth field whose layers are a cell thick whichever way they face.
//!
//! The hop count of an order steps a cell where the front is level or upright, and up to 1.41 cells where it leans,
//! so its layers differ in thickness (Dai 2020, section 3.6.3). Here the order is *re-timed*: it is grown once more by
//! a clock that moves the front one cell a layer in every direction (`growth/clock.rs`), under the
//! same rules of support and accessibility, and no cell comes more than [`LAGS`] layers before its layer in the accepted
//! order, which keeps what the order had learnt about who must wait for whom.
//!
//! Where a part gets wider a level front can stay level or turn round the corner; what is better depends on the part. Both
//! are tried, the values of both evened out within their layers (`slope.rs`), which changes nothing of what the audit sees, and
//! the field with the more uniform slope and fewer waits is taken.
//!
//! The result is audited. If it fails, it is the turn of the less uniform one. If that fails too, or a cell is left over,
//! the clock is held closer to the order, and at last the order itself is the field. So what comes out always passes
//! the audit.

use super::field::{FieldError, LayerField};
use super::lattice::Lattice;
use super::plain::plain_field;
use super::slope::evened;
use crate::cells::{Cells, LayerOrder};
use crate::curved::growth::grow_by_clock;
use crate::curved::{AuditError, AuditReport, GrowthError, Platform, Rules, audit};
use crate::{Progress, ProgressFn};

/// How many layers before its own layer in the order a cell may be built: tried one after the other. With a longer
/// lead parts with arms that dip below their root are left with cells that cannot be built any more; with a shorter one
/// the field keeps more of the waits of the order.
pub const LAGS: [f64; 2] = [10.0, 1.0];

/// A field of uniform layers.
#[derive(Clone, Debug, PartialEq)]
pub struct UniformField {
    /// The field.
    pub field: LayerField,
    /// How it came about.
    pub method: UniformMethod,
    /// The audit of its layers, which passed.
    pub audit: AuditReport,
    /// Pairs of cells with a common face that is cut, since the front waited on one side: no surface will run across.
    pub jumps: usize,
}

/// How a field came about.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum UniformMethod {
    /// By the clock, no cell more than this number of layers before its layer in the accepted order.
    Clock {
        /// The number of layers.
        lag: f64,
        /// Whether level fronts stayed level where the part gets wider.
        stays_level: bool,
    },
    /// Smoothed within what the part allows ([`coherent_field`](super::coherent_field)).
    Coherent,
    /// By the distance from the plate or a mould ([`distance_layers`](crate::curved::distance_layers)).
    Distance,
    /// A field that follows the distance and leans no more than the nozzle's cone allows ([`grow_directed`](crate::curved::grow_directed)).
    Directed,
    /// The clock left cells over: it is the plain field of the order.
    Plain,
}

/// Why an order could not be re-timed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UniformError {
    /// The order names cells outside the solid, or none.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The growth did not start, or was cancelled.
    #[error(transparent)]
    Growth(#[from] GrowthError),
    /// The audit did not start, or was cancelled.
    #[error(transparent)]
    Audit(#[from] AuditError),
    /// The order that was given fails the audit itself.
    #[error("the order fails the audit: {0}")]
    Order(Box<AuditReport>),
}

/// Re-times an accepted order into a field of uniform layers, a cell thick, that passes the audit.
///
/// # Arguments
/// * `order`: passes the audit with `missed`.
/// * `missed`: the cells of the solid that are in no layer. They get no value.
/// * `progress`: called with the stages `uniform` and `audit uniform`; may cancel.
///
/// # Errors
/// [`UniformError`].
///
/// # Cost
/// About that of growing the order twice with incremental prevention, on two threads with the feature `rayon`, and of an
/// audit; more if it has to try again. The same input gives the same field on any number of threads.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{GrowthOptions, Platform, Rules, grow};
/// use curvlay_layers::curved::surface::uniform_field;
/// use std::ops::ControlFlow;
/// // An upright T, one cell thick: a stem of four cells below a bar of five.
/// let rows = [0b00100, 0b00100, 0b00100, 0b00100, 0b11111];
/// let cells = Cells::new([5, 1, 5], &rows)?;
/// let (platform, rules) = (Platform::under(&cells, 10.0)?, Rules::default());
/// let silent = |_| ControlFlow::Continue(());
/// let growth = grow(&cells, &platform, &rules, &GrowthOptions::default(), None, &silent)?;
/// let uniform = uniform_field(&cells, &platform, &rules, &growth.order, &[], &silent)?;
/// assert_eq!(uniform.field.value(2), Some(0.5)); // the foot
/// assert_eq!([20, 21, 22].map(|cell| uniform.field.value(cell)), [6.5, 5.5, 4.5].map(Some));
/// assert!(uniform.audit.is_ok());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn uniform_field(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    order: &LayerOrder,
    missed: &[u32],
    progress: ProgressFn,
) -> Result<UniformField, UniformError> {
    let auditing = |p: Progress| progress(Progress { stage: "audit uniform", ..p });
    let plain = plain_field(cells, order)?;
    let rows = rows_of(cells, order);
    let built = Cells::new(cells.dims(), &rows).unwrap_or(*cells);
    let layers = order.field(plain.values().len());
    for lag in LAGS {
        let attempt = |stays_level: bool| -> Result<Option<Attempt>, UniformError> {
            let release = layers.iter().map(|&layer| (f64::from(layer) - lag).max(0.0)).collect();
            let clocked = grow_by_clock(&built, platform, rules, release, stays_level, progress)?;
            if !clocked.complete {
                return Ok(None);
            }
            let field = evened(LayerField::new(cells, clocked.times, 1.0)?);
            let lattice = Lattice::of(&field);
            let jumps = lattice.jumps();
            let unevenness = lattice.unevenness() + jumps as f64 / field.count() as f64;
            Ok(Some(Attempt { field, method: UniformMethod::Clock { lag, stays_level }, jumps, unevenness }))
        };
        #[cfg(feature = "rayon")]
        let (level, turning) = rayon::join(|| attempt(true), || attempt(false));
        #[cfg(not(feature = "rayon"))]
        let (level, turning) = (attempt(true), attempt(false));
        let mut attempts: Vec<Attempt> = [level?, turning?].into_iter().flatten().collect();
        attempts.sort_by(|a, b| a.unevenness.total_cmp(&b.unevenness));
        for Attempt { field, method, jumps, .. } in attempts {
            let audit = audit(cells, platform, rules, &field.rounded(), missed, &auditing)?;
            if audit.is_ok() {
                return Ok(UniformField { field, method, audit, jumps });
            }
        }
    }
    let audit = audit(cells, platform, rules, &plain.rounded(), missed, &auditing)?;
    let jumps = Lattice::of(&plain).jumps();
    if audit.is_ok() {
        Ok(UniformField { field: plain, method: UniformMethod::Plain, audit, jumps })
    } else {
        Err(UniformError::Order(Box::new(audit)))
    }
}

/// What came of one run of the clock; not audited yet.
struct Attempt {
    field: LayerField,
    method: UniformMethod,
    jumps: usize,
    /// What the best has least of.
    unevenness: f64,
}

/// The bits of the cells of an order, which are in the grid.
pub(super) fn rows_of(cells: &Cells, order: &LayerOrder) -> Vec<u64> {
    let mut rows = vec![0; cells.rows().len()];
    for &cell in order.cells() {
        let [x, y, z] = cells.position(cell);
        let row = y as usize + cells.dims()[1] as usize * z as usize;
        rows[row * cells.words_per_row() + x as usize / 64] |= 1 << (x % 64);
    }
    rows
}
