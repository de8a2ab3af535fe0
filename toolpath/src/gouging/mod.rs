//! A nozzle that does not run into what it has built.
//!
//! Takes the [`ToolPath`](crate::orientation::ToolPath)s of [`LayerStack::orient`](crate::layer::LayerStack::orient) and a [`Nozzle`]; gives [`ResolvedPaths`] ([`LayerStack::resolve_gouging`](crate::layer::LayerStack::resolve_gouging)), and answers
//! for single poses ([`LayerStack::contacts`](crate::layer::LayerStack::contacts)).
//!
//! Dai 2020, section 3.6.3, names local gouging as an open point: directions for best adhesion may drive the nozzle into
//! the model. Here each waypoint is checked against all that is built by then (`deepest`), tilted by the least angle that
//! frees it (`tilt`), and the tilt is spread along the path (`along`). The tip stays where it is. A path on which waypoints are
//! left without a way out is tried from its end to its start as well: in a crease of a layer what is laid first is free. What is still
//! not free is raised by up to half a layer. If that is not enough, pieces of paths are cut out and laid before the rest of the layer; those where the nozzle would run into
//! what is built are left out (`order`). What `resolve_gouging` asks at waypoints can be asked of any pose at any moment of the print (`contact`).
//!
//! What has been built is all earlier layers, each as thick as its spacing, and of its own layer what the beads so far cover
//! (`built`), and the mould, if there is one. The nozzle may enter it by a quarter of a layer. Below the plate it may not reach at all.
//!
//! Layers from which no earlier layer shadows a later one have the tip outside the hull of all earlier cells. So there is a
//! plane through the tip with the model on one side, and a cone up to 45 degrees has a half space full of directions to
//! choose from, less where thickness and the own layer are in the way; that is why a tilt nearly always frees.

mod along;
mod built;
mod contact;
mod deepest;
mod error;
mod gouge;
mod nozzle;
mod obstacle;
mod options;
mod order;
mod resolve;
mod resolved;
mod sweep;
mod tilt;

pub use contact::{ContactError, Contacts, Moment};
pub use deepest::Contact;
pub(crate) use deepest::{Scene, Stand};
pub use error::GougingError;
pub use gouge::{Gouge, LeftOut};
pub use nozzle::{Nozzle, NozzleError, NozzlePart, NozzleShape};
pub use obstacle::Obstacle;
pub use options::GougingOptions;
pub use resolved::ResolvedPaths;
