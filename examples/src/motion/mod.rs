//! Workcells as the planners of trajectories see them, and the two cells of the dissertation.

mod cells;
mod home;
mod on_cell;
mod parts;
mod printing;
pub mod programs;
pub mod read_back;
mod reading;
pub mod shown;
mod studied;
mod target_programs;
mod track;

pub use cells::{TABLE_CELL, UR3_CELL, link_mesh};
pub use home::{NO_HOME, from_home, home};
pub use on_cell::{OnCell, OverTable, PartInHand, bounds_of};
pub use parts::{FlatPrint, Moved, Printed, is_program, plate_mm, print_parts};
pub use printing::{PlacedPaths, PrintingCell, nozzle_of, table_options, track_options, waypoints};
pub use reading::{WORKCELL_FILE, workcell_model, workcell_of, workcell_or};
pub use studied::{STEP_S, Studied, centred, dissertation_cells, inside, near_samples};
pub use target_programs::{TargetFormat, TargetLanguage, TargetProgram, target_files, write_targets};
pub use track::turning_joints;
