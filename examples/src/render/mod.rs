//! Pictures without a graphics card: a z-buffer renderer to PNG.
//!
//! [`Scene`] takes cells, meshes, bars and a platform and draws them from one side, in parallel projection; [`draw_cut`]
//! shows the layers on a plane through the part; [`Image::with_legend`] says which colour is which layer.
//! The same input gives the same bytes: one thread, no time, no chance.

mod cells;
mod colours;
mod cut;
mod glyphs;
mod image;
mod plane;
mod raster;
mod scene;

pub use cells::{LayeredCells, LayeredCellsError};
pub use colours::{INK, MISSED, PLATFORM, Rgb, layer_colour, ramp};
pub use cut::draw_cut;
pub use image::Image;
pub use plane::Plane;
pub use scene::{Camera, Scene};
