//! What the examples share: reading meshes, arguments, output folder, progress bars, pictures, the report, and shapes
//! made in code. Unpublished; but for [`motion`] it knows nothing of the published crates and takes plain data from
//! them.

pub mod args;
pub mod axis_program;
pub mod bars;
pub mod build3mf;
pub mod clock;
pub mod count;
pub mod facts;
mod finding;
pub mod findings;
pub mod five_axis;
pub mod gallery;
mod html;
pub mod input;
pub mod json;
pub mod laid;
pub mod mesh;
pub mod motion;
pub mod orienting;
mod outcome;
pub mod output;
pub mod plot;
pub mod render;
pub mod replies;
pub mod report;
mod run;
pub mod settings;
pub mod shapes;
pub mod signals;
pub mod spiral;
pub mod summary;
pub mod table;
mod terminal;
pub mod viewer;
pub mod waypoints;

pub use nalgebra;
