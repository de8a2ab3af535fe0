//! All layers of a part filled with beads: curves, figures that judge them, and the order in which they are printed.
//!
//! One call ([`fill_layers`]) takes [surfaces of layers](crate::layer::LayerSurface) and gives [`FilledLayers`].
//!
//! Dai 2020, sections 3.5.1 (curves), 3.6.3 (coverage). For each surface: the exact distance to its boundary, its level sets,
//! curves along them, and figures of these curves that know nothing of how they were made. Where fitted beads cross each other by
//! these figures, the surface is filled once more with uniform ones, which are laid along plain level sets. At last the curves
//! of all layers are put in an order with short ways between them ([`order_curves`](crate::order::order_curves)).
//!
//! * `layers`: from surfaces to filled layers; `filled`: what comes out. `estimate`: what beads will take, before any work.
//! * `bridge`: skins over sparse infill. `short`: curves that are laid only if something lies on them. `with_support`: a layer and its support.
//! * `judge`: figures of the curves of a layer. `totals`: figures of all layers.

mod bridge;
mod errors;
mod estimate;
mod filled;
mod judge;
mod layers;
mod short;
mod support_part;
mod totals;
mod with_support;

pub use bridge::Bridges;
pub use errors::FillLayersError;
pub use estimate::{FillEstimate, estimate_fill};
pub use filled::{FilledLayer, FilledLayers};
pub use layers::{fill_layer, fill_layers, fill_range, fill_rest};
pub use short::SHORT_CURVE_BEADS;
pub use totals::{FillTotals, LeftOutParts};
