//! Paths that fill a curved layer with beads: [`LevelField::paths`](crate::level_set::LevelField::paths) takes the level sets of the distance to
//! the boundary, and gives the curves of a layer ([`LayerPaths`](crate::path::LayerPaths)).
//!
//! Zhao et al., "Connected Fermat spirals for layered fabrication", ACM TOG 35(4), 2016, fill a plane region along its
//! offsets with one continuous curve; Dai 2020, section 3.5.1, does so on a surface with geodesic distance. So does
//! [`Pattern::Spirals`](crate::path::Pattern::Spirals). The other patterns stand beside it for comparison.
//!
//! * `contours`: from level sets to paths, step by step. `curve`: rings by arc length, points near the surface. `chains`: the tree of rings.
//! * `spacing`: where rings lie, and how wide their beads are. `spirals`: where rings are cut and bridged. `plan`: from
//!   cuts and bridges to curves. `crossing`: whether these cross. `segments`: what is near. `thin`: fewer points.
//! * `widths`: how wide bridges are. `narrow`: single beads where there is no room for two, or some is left; and for strips too narrow
//!   for any, in case something lies on them.
//! * `join`: curves whose ends nearly meet become one. `short`: those too short to be worth a start are left out. `carry`: whether later
//!   beads lie on them.
//! * `expected`: how much length of beads lies where, without curves.
//! * `zigzag`: rows to and fro, from where `cut` cuts the surface; `rows` joins them.
//!
//! Departures: the paper joins offsets that lie near each other, and smooths the curve by an optimisation afterwards.
//! Here the tree comes from how level sets nest, holes need no special care, and a bridge counts only if the
//! distance on it proves that it crosses no ring. Curves are not smoothed: away from bridges, every point is on a level.

mod carry;
mod chains;
mod contours;
mod crossing;
mod curve;
mod cut;
mod expected;
mod join;
mod narrow;
mod plan;
mod polyline;
mod rows;
mod segments;
mod short;
mod spacing;
mod spirals;
mod thin;
mod watch;
mod widths;
mod zigzag;

pub(crate) use carry::{Place, carriers};
pub(crate) use contours::check;
pub(crate) use curve::Loop;
pub(crate) use cut::Cut;
pub(crate) use expected::ExpectedBeads;
pub(crate) use rows::{Rim, Row, end, joined};
pub(crate) use segments::Segments;
pub use spacing::BEAD_WIDTHS;
pub(crate) use spacing::BeadsAt;
