//! Working surfaces: an order of cells becomes the curved surfaces that a nozzle follows.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), sections 3.4.5 and 3.6.3.
//!
//! 1. [`even`](even()) re-times an accepted order into a field whose layers are a cell thick whichever way they face, and
//!    which passes the audit; [`plain_field`] takes the hop count as it is.
//! 2. [`extend`](extend()) continues the field by two rings of cells beyond the part.
//! 3. [`contour`](contour()) draws the surfaces at [the levels of a layer height](ExtendedField::levels). They reach
//!    outside the part and are to be trimmed to its mesh.
//! 4. [`measure_spacing`] says how far apart they lie, trimmed or not.
//!
//! A field can be saved and taken up again ([`SavedField`]); fields and surfaces can be written for ParaView
//! ([`write_field_vtk`], [`write_surfaces_vtk`]).
//!
//! # Waits
//! Where a front had to wait for another one, the layers of the cells on both sides of a face differ by [`JUMP`] or more.
//! Where their values are [`APART`] as well, such a face is cut: a surface goes on to it from either side, and none runs across,
//! so that surfaces are not squeezed into one cell.

mod contour;
mod even;
mod extend;
mod field;
mod lattice;
mod slope;
mod spacing;
mod store;
mod tree;
mod vtk;

pub use contour::{ContourError, Surface, contour};
pub use even::{Even, EvenError, EvenMethod, LAGS, even};
pub use extend::{ExtendedField, extend};
pub use field::{FieldError, LayerField, plain_field};
pub use lattice::{APART, JUMP};
pub use spacing::{HISTOGRAM_END, SQUEEZED, Spacing, SpacingError, SurfaceSlices, measure_spacing};
pub use store::{OtherMesh, ReadFieldError, SavedField, mesh_stamp};
pub use vtk::{write_field_vtk, write_surfaces_vtk};

/// `of` for all numbers below `count`, in their order; with the feature `rayon` by several threads, each of which takes at
/// least `least_share` of them.
#[cfg_attr(not(feature = "rayon"), allow(unused_variables))]
pub(in crate::curved) fn in_parallel<R: Send>(
    count: usize,
    least_share: usize,
    of: impl Fn(usize) -> R + Send + Sync,
) -> Vec<R> {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().with_min_len(least_share).map(of).collect()
    }
    #[cfg(not(feature = "rayon"))]
    (0..count).map(of).collect()
}
