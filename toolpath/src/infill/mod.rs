//! Layers that are not filled solid: walls along the boundary, skins at the outside of the part, sparse infill inside.
//!
//! Takes the field of a layer with its contours, and where the layer is in the part; gives its paths, and what is sparse of it
//! ([`SparseFill`]). [`InfillOptions`](crate::path::InfillOptions) say how much; [`fill_layers`](crate::fill::fill_layers) calls it.
//!
//! Three regions of each surface, by two functions that are linear over triangles: how far a place is inward of the innermost wall
//! ([`PathOptions`](crate::path::PathOptions)'s contours, which nest by exact geodesic distance), and how far it is inside of a skin (`skin`). `split` cuts the
//! refined mesh along their zeros. Walls are the outer rings of the spirals that fill solid layers (Dai 2020, section 3.5.1); a skin is a
//! surface of its own, filled solid by distance to its own boundary; the rest gets rows by geodesic distance from a cut through its
//! middle, or curves of a gyroid (`pattern`). What a skin bridges is reported by [`Bridges`](crate::fill::Bridges).
//!
//! Parts of the inside that are narrower than three beads are filled solid: a row would fit there by luck only.

mod error;
mod filled;
mod on_mesh;
mod pattern;
mod site;
mod skin;
mod sparse;
mod split;
mod within;

pub use error::FillError;
pub(crate) use filled::{Filled, MIN_BEAD_REACH, MIN_REACH, TOLERANCE, filled, thickness};
pub(crate) use site::Site;
pub(crate) use skin::{Sites, sites};
pub use sparse::SparseFill;
pub(crate) use within::Solid;
