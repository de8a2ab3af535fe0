//! Robots by their published numbers.
//!
//! Lengths, limits and speeds are the makers' or come from the named source of each; nobody publishes accelerations and jerks, so those
//! are infinite. An arm of which a length was not certain is not here. Frames are those in which the maker's controller counts: a file for each
//! maker says which. `examples/cells/arms.json` of the repository is this catalogue in the format of workcell files.

mod abb;
mod catalogue;
mod entry;
mod fanuc;
mod kuka;
mod names;
mod numbers;
mod orientation;
mod positioners;
mod staubli;
mod universal_robots;
mod yaskawa;

pub use abb::{IRB120, IRB1200};
pub use catalogue::CATALOGUE;
pub use entry::{CatalogueArm, Maker};
pub use names::{find, near};
pub use orientation::ShownRotation;
pub use positioners::{IRBP_A250, POSITIONERS};
pub use universal_robots::{UR3, UR3E, UR5, UR5E, UR10};
