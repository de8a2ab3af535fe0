//! A whole print: from curves on layers to the moves of a machine, in one call.
//!
//! Dai 2020, sections 3.5.2 and 3.6.3. Waypoints along the curves ([`LayerStack::orient`]), a nozzle that gouges nothing
//! ([`LayerStack::resolve_gouging`]), ways from path to path ([`LayerStack::travels`]), what is laid and how fast ([`deposit_along`]).

use crate::deposit::{Deposition, DepositionError, DepositionOptions, deposit_along};
use crate::fill::FilledLayers;
use crate::gouging::{GougingError, GougingOptions, Nozzle, ResolvedPaths};
use crate::layer::{LayerStack, LayerSurface, StackError};
use crate::orientation::{OrientError, OrientOptions, Turns};
use crate::travel::{TravelOptions, Travels};
use crate::{Progress, ProgressFn};
use std::ops::ControlFlow;

/// How deep the nozzle may be in a layer at waypoints, as a share of its height. A little less than the quarter that it may
/// be anywhere, since a machine leaves the straight way between two waypoints.
const ALLOWED_DEPTH: f64 = 0.2;

/// How far it keeps over the plate there, in millimetres, for the same reason.
const PLATE_CLEARANCE: f64 = 0.1;

/// How a print is planned.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct PrintOptions {
    /// How the nozzle is oriented.
    pub orient: OrientOptions,
    /// How it is kept from gouging: a fifth of a layer deep at waypoints and 0.1 mm over the plate, which leaves room for the
    /// motion between two; else its defaults.
    pub gouging: GougingOptions,
    /// How it travels.
    pub travel: TravelOptions,
    /// How material is laid.
    pub deposition: DepositionOptions,
}

impl Default for PrintOptions {
    fn default() -> Self {
        let gouging = GougingOptions {
            allowed_depth: ALLOWED_DEPTH,
            plate_clearance: PLATE_CLEARANCE,
            ..GougingOptions::default()
        };
        PrintOptions {
            orient: OrientOptions::default(),
            gouging,
            travel: TravelOptions::default(),
            deposition: DepositionOptions::default(),
        }
    }
}

impl PrintOptions {
    /// For a robot, whose motion gouges nowhere: what it cannot print without being deeper than a quarter of a layer in what is built
    /// is left out and listed, not printed.
    pub fn for_robot() -> Self {
        let mut options = PrintOptions::default();
        options.gouging.max_depth = GougingOptions::default().allowed_depth;
        options
    }
}

/// A whole print.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintPlan {
    /// Turns from waypoint to waypoint where the nozzle points away from the closest point below, unfiltered.
    pub before: Turns,
    /// The paths with the directions that they are printed with.
    pub resolved: ResolvedPaths,
    /// How the nozzle gets from path to path.
    pub travels: Travels,
    /// What is laid, how fast, and all moves.
    pub deposition: Deposition,
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrintError {
    /// There is not one surface for each filled layer.
    #[error("{surfaces} surfaces for {layers} filled layers: pass those that were filled")]
    SurfaceCount {
        /// Surfaces given.
        surfaces: usize,
        /// Layers filled.
        layers: usize,
    },
    /// The layers cannot be used.
    #[error(transparent)]
    Stack(#[from] StackError),
    /// The paths cannot be oriented.
    #[error(transparent)]
    Orient(OrientError),
    /// Gouging or travels cannot be looked at.
    #[error(transparent)]
    Gouging(GougingError),
    /// The moves cannot be planned.
    #[error(transparent)]
    Deposition(#[from] DepositionError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl From<OrientError> for PrintError {
    fn from(error: OrientError) -> Self {
        if error == OrientError::Cancelled { PrintError::Cancelled } else { PrintError::Orient(error) }
    }
}

impl From<GougingError> for PrintError {
    fn from(error: GougingError) -> Self {
        if error == GougingError::Cancelled { PrintError::Cancelled } else { PrintError::Gouging(error) }
    }
}

impl FilledLayers {
    /// Plans the print of these layers: [`FilledLayers::stack`] and [`LayerStack::plan`].
    ///
    /// # Arguments
    /// * `surfaces`: those that were filled.
    /// * `progress`: as for [`LayerStack::plan`].
    ///
    /// # Errors
    /// [`PrintError`].
    ///
    /// # Cost
    /// That of [`LayerStack::plan`]. An example stands at [`fill_layers`](crate::fill::fill_layers).
    pub fn plan(
        &self,
        surfaces: &[LayerSurface],
        nozzle: &Nozzle,
        options: &PrintOptions,
        progress: ProgressFn,
    ) -> Result<PrintPlan, PrintError> {
        let (surfaces_given, layers) = (surfaces.len(), self.layers.len());
        if surfaces_given != layers {
            return Err(PrintError::SurfaceCount { surfaces: surfaces_given, layers });
        }
        self.stack(surfaces)?.plan(nozzle, options, progress)
    }
}

impl LayerStack<'_> {
    /// Plans the print of these layers along their curves, in the order given.
    ///
    /// # Arguments
    /// * `progress`: called with the stages `orient` (`share`), `gouging` (`built`), `travel` and `deposit`, each of which begins with
    ///   nothing done; may cancel.
    ///
    /// # Errors
    /// [`PrintError`]. What gouges, is left out or has no free way is no error: it is listed.
    ///
    /// # Cost
    /// Some 50 microseconds a waypoint, and one to three milliseconds a travel. The result does not depend on the number of threads.
    pub fn plan(&self, nozzle: &Nozzle, options: &PrintOptions, progress: ProgressFn) -> Result<PrintPlan, PrintError> {
        let begin = |stage: &'static str| match progress(Progress { stage, done: 0, total: 0 }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(PrintError::Cancelled),
        };
        begin("orient")?;
        let oriented = self.orient(&options.orient, progress)?;
        begin("gouging")?;
        let resolved = self.resolve_gouging(oriented.paths, nozzle, &options.gouging, progress)?;
        begin("travel")?;
        let travels = self.travels(&resolved.paths, nozzle, &options.travel, progress)?;
        begin("deposit")?;
        let deposition = deposit_along(&resolved.paths, &travels.ways, &options.deposition)?;
        Ok(PrintPlan { before: oriented.before, resolved, travels, deposition })
    }
}
