//! The ladder: from each waypoint's sampled solutions one, so that joints move least.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.3.1. The nodes of a waypoint are
//! the solutions of the inverse at sampled free parameters; an edge joins nodes of neighbouring waypoints that the joints'
//! speeds allow (Eq. 4.4), weighted by the square of their distance (Eq. 4.5; section 3.5.3 uses the L1 norm, Eq. 3.4).
//! The shortest path from any node of the first waypoint minimises `J_trans` (Eq. 4.6). The search begins with four samples
//! and doubles them while there is no path.
//!
//! Distances are circular where a joint turns without end. A joint with stops a turn or more apart has several images
//! of an angle. They would multiply the nodes; instead such a joint begins as circular, and the path is turned into
//! its stops afterwards. If it fits, it is the best of all (nothing is cheaper without stops). If not, the search is
//! done again with every image of that joint a node of its own. So the result is exact either way. The same holds of the
//! way to the first waypoint from where the joints are before ([`LadderOptions::from`]).
//!
//! No edge is stored: see `search`. Departs from the dissertation: instead of doubling without end it stops after
//! [`LadderOptions::doublings`]; a path breaks off where that makes it shortest, not where it can go no further; there is a
//! search that is not exact but fast, [`LadderSearch::CoarseToFine`]; and a path can be refined by more samples about it,
//! [`LadderOptions::refinements`].

mod buckets;
mod coarse;
mod error;
mod node;
mod nodes;
mod options;
mod paths;
mod plan;
mod search;
mod slowest;

pub use error::LadderError;
pub use node::{Ladder, LadderNode};
pub use options::{LadderOptions, LadderSearch, MAX_SAMPLES, Norm};
pub use plan::plan_ladder;
pub use slowest::{MinSpeed, min_speed};
