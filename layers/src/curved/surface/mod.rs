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
//! Where a front had to wait for another one, the layers of the cells on both sides of a face differ by [`JUMP`] or more.
//! Where their values are [`APART`] as well, such a face is cut: a surface goes on to it from either side, and none runs across,
//! so that surfaces are not squeezed into one cell.

use crate::Progress;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

mod coherent;
mod contour;
mod extend;
mod field;
mod fit;
mod half;
mod lattice;
mod nozzle;
mod plain;
mod slices;
mod slope;
mod smooth;
mod spacing;
mod store;
mod torn;
mod tree;
mod uniform;
mod vtk;

pub use coherent::coherent_field;
pub use contour::{ContourError, Surface, VertexPlacement, contour, contour_with};
pub use extend::{ExtendedField, extend};
pub use field::{FieldError, LayerField};
pub use fit::FittedLevels;
pub use lattice::{APART, JUMP};
pub use nozzle::uniform_field_with_nozzle;
pub use plain::plain_field;
pub use slices::SurfaceSlices;
pub use smooth::BorderSmoothing;
pub use spacing::{HISTOGRAM_END, SQUEEZED, Spacing, SpacingError, measure_spacing, measure_spacing_within};
pub use store::{OtherCells, OtherMesh, PrintAids, ReadFieldError, SavedField, mesh_stamp};
pub use uniform::{LAGS, UniformError, UniformField, UniformMethod, uniform_field};
pub use vtk::{write_field_vtk, write_surfaces_vtk};

/// `of` for all numbers below `count`, in their order; with the feature `rayon` by several threads, which take `share` of them at a time: no
/// more, as a thread would stand idle while another goes through what takes long.
#[cfg_attr(not(feature = "rayon"), allow(unused_variables))]
pub(in crate::curved) fn in_parallel<R: Send>(
    count: usize,
    share: usize,
    of: impl Fn(usize) -> R + Send + Sync,
) -> Vec<R> {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().with_min_len(share).with_max_len(share).map(of).collect()
    }
    #[cfg(not(feature = "rayon"))]
    (0..count).map(of).collect()
}

/// Pairs of cells with a common face that is cut: no surface will run across.
pub(in crate::curved) fn jumps(field: &LayerField) -> usize {
    lattice::Lattice::of(field).jumps()
}

/// What takes reports and says whether to go on.
pub(in crate::curved) type Report<'a> = &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync + 'a);

/// The same in stage `stage`, with a report after each; `None` if cancelled. `of` is handed what reports how far all of them
/// have come, to ask in between whether to go on.
pub(in crate::curved) fn in_parallel_watched<R: Send>(
    count: usize,
    stage: &'static str,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    of: impl Fn(usize, Report) -> R + Send + Sync,
) -> Option<Vec<R>> {
    let (done, cancelled) = (AtomicU64::new(0), AtomicBool::new(false));
    let report = |add: u64| {
        let done = done.fetch_add(add, Ordering::Relaxed) + add;
        let go_on =
            !cancelled.load(Ordering::Relaxed) && progress(Progress { stage, done, total: count as u64 }).is_continue();
        cancelled.fetch_or(!go_on, Ordering::Relaxed);
        if go_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let one = |k: usize| {
        if cancelled.load(Ordering::Relaxed) {
            return None;
        }
        let result = of(k, &|_| report(0));
        report(1).is_continue().then_some(result)
    };
    in_parallel(count, 1, one).into_iter().collect()
}
