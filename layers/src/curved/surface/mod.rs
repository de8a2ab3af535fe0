//! Working surfaces: an order of cells becomes the curved surfaces that a nozzle follows.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), sections 3.4.5 and 3.6.3.
//!
//! 1. [`uniform_field`] re-times an accepted order into a field whose layers are a cell thick whichever way they face, and
//!    which passes the audit; [`plain_field`] takes the hop count as it is.
//! 2. [`extend`](extend()) continues the field by two rings of cells beyond the part.
//! 3. [`contour`](contour()) draws the surfaces at [the levels of a layer height](ExtendedField::levels), or at [levels that fit
//!    the part](ExtendedField::fitted_levels). They reach outside the part and are to be trimmed to its mesh.
//! 4. [`Surface::smooth_border`] takes the steps of cells out of their borders, before they are trimmed.
//! 5. [`measure_spacing`] says how far apart they lie, trimmed or not.
//!
//! A field can be saved and taken up again ([`SavedField`]); fields and surfaces can be written for ParaView
//! ([`write_field_vtk`], [`write_surfaces_vtk`]).
//!
//! # Waits
//! Where a front had to wait for another one, the layers of the cells on both sides of a face differ by 2 or more.
//! Where their values are 1.4 layers apart as well, such a face is cut: a surface goes on to it from either side, and none runs across,
//! so that surfaces are not squeezed into one cell.

mod coherent;
mod contour;
mod extend;
mod field;
mod fit;
mod half;
mod lattice;
mod levels;
mod marks;
mod nozzle;
mod plain;
mod slope;
mod smooth;
mod spacing;
mod stamp;
mod store;
mod torn;
mod tree;
mod uniform;
mod vtk;

pub use crate::trim::SurfaceSlices;
pub use coherent::coherent_field;
pub use contour::{ContourError, Surface, VertexPlacement, contour, contour_with};
pub use extend::{ExtendedField, extend};
pub use field::{FieldError, LayerField};
pub use fit::FittedLevels;
pub(crate) use lattice::JUMP;
pub(crate) use levels::Levels;
pub use nozzle::uniform_field_with_nozzle;
pub use plain::plain_field;
pub use smooth::BorderSmoothing;
pub(crate) use spacing::{SPACING_REACH, measure_spacing_in};
pub use spacing::{Spacing, SpacingError, measure_spacing, measure_spacing_within};
pub use stamp::mesh_stamp;
pub use store::{OtherCells, OtherMesh, PrintAids, ReadFieldError, SavedField};
pub use uniform::{LAGS, UniformError, UniformField, UniformMethod, uniform_field};
pub use vtk::{write_field_vtk, write_surfaces_vtk};

/// Pairs of cells with a common face that is cut: no surface will run across.
pub(crate) fn jumps(field: &LayerField) -> usize {
    lattice::Lattice::of(field).jumps()
}
