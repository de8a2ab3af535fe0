//! Stage `preview`: what a full run would print, in seconds. Some of the layers, on a grid that need not be as fine, stand for all of them; time
//! and material are estimated from these surfaces, without paths.

mod estimated;
mod findings;
mod run;

pub use estimated::PreviewRun;

/// Cells that a preview takes at most where they follow from the layer height: their order and its audit take two to three seconds on two cores. Typed
/// --voxels and --cell are kept.
pub const MAX_CELLS: u64 = 60_000;

/// Surfaces of whole layers, about; half layers come on top. Each takes a fiftieth of a second of processor time; with a quarter fewer estimates move
/// by up to 2 % (docs/benchmarks.md).
pub const MAX_SURFACES: u32 = 50;
