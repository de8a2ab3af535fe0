//! Continuous fibre on a layer: tapes along a field of directions.

mod tape;

pub use tape::Tape;
