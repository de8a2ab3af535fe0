//! What is laid by a program of any maker, for judges that share no code with the planner: words of G-code, beads in a grid, the shape of a nozzle, and how deep it
//! is in what is laid.

mod beads;
mod contact;
mod nozzle;
mod words;

pub use beads::{Beads, Capsule, Layer, to_chord};
pub use contact::NozzleInBeads;
pub use nozzle::{Nozzle, NozzlePose};
pub use words::{LONGEST_LINE, words};
