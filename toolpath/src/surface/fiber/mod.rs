//! Continuous fibre on a layer: tapes along a field of directions.

mod head;
mod sandwich;
mod stiffness;
mod tape;

pub use head::{LayerTapes, TapeHead, TapeHeadError, with_tapes};
pub use sandwich::{SandwichError, SandwichLayer, SandwichOptions, raise, sandwich};
pub use stiffness::{LayUp, StiffnessError, TapeInSection, arch_stiffness_n_mm, three_point_rigidity_nm2};
pub use tape::Tape;
