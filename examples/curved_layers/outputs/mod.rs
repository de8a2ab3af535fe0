//! What the example leaves behind: the products of each stage, `report.html`, `summary.json`, the tables on stdout.
//!
//! One module a stage, each with its products, its figures (`summary`, `rows`) and its chapter of the report.

mod axes;
mod build;
mod field;
mod files;
mod machine;
mod motion;
mod names;
mod paths;
mod people;
mod pictures;
mod preview;
mod programs;
mod shown;
mod surfaces;
mod tmf;
mod workcell;
mod write;

pub use files::Files;
pub use names::is_ours;
pub use write::{trajectory, write, write_range};
