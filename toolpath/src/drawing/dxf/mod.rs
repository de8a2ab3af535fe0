//! DXF files (AutoCAD R12 to today), ASCII and binary, read into a [`Drawing`](super::Drawing): Brooks, section 4.5 to 4.7.
//!
//! Drawn are LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE and POLYLINE with bulges, SPLINE by control or fit points, and INSERT of blocks:
//! nested, scaled, turned, mirrored, in arrays. Entities of other planes (an extrusion that is not z) are seen from above. What is not
//! drawn is counted by its kind, with the reason and the first places: other kinds, entities of the paper space, invisible ones, those on
//! layers that are off or frozen, and damaged ones. None of them is a reason to refuse the file.
//!
//! Departs from the thesis: its reader took no ELLIPSE and no blocks, and did not say what it left out.

mod binary;
mod blocks;
mod entities;
mod error;
mod fit;
mod layers;
mod pair;
mod pairs;
mod read;
mod text;
mod write;

pub use error::{DxfError, Place};
pub use read::read_dxf;
pub use write::{SpacePath, write_dxf, write_paths_dxf};
