//! Stage `field`: cells, growth, audit. A field that an earlier run has saved takes the place of the growth.

mod in_cells;
mod options;
mod results;
mod run;

pub use in_cells::cells_of_full_run;
pub use options::{FieldOptions, Given};
pub use results::FieldRun;
pub use run::run;
