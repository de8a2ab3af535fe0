//! Conservative voxelisation: a triangle mesh becomes the set of cells that it touches or encloses.
//!
//! A cell belongs to the solid when its open interior meets the closed solid. The solid is the surface together with
//! all points whose winding number is above one half in absolute value: the union where parts pass through each other,
//! the whole body where every triangle is turned inwards, the sensible side of a hole. A cube whose faces lie on planes
//! of the grid gives its cells and no more; nothing of the solid lies outside the cells.
//!
//! * The surface: exact decisions on integers for each row of cells (`surface`, `lattice`).
//! * The inside: one winding number for each connected piece of what the surface misses (`interior`, `winding`,
//!   `boundary`).
//! * A wanted number of cells: a search over the size of the cells and the place of the grid (`search`).
//!
//! A mesh that was looked through once is a `solid`: it gives the cells for any size.
//!
//! The part is put on the plate: the grid and the result are those of the mesh moved by [`Voxelisation::shift`].

use crate::search;
use crate::solid::{Solid, Voxelisation};
use crate::{GridError, ProgressFn, VoxelError};
use nalgebra::Point3;

/// How large the cells are.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum Resolution {
    /// This edge, in millimetres. The grid begins where the part does: its low corner is that of the bounding box.
    Cell(f64),
    /// The size that gives this number of cells, or the nearest number that the search reaches: it ends within 0.1 %
    /// of it, where flat faces make whole layers of cells come and go at once within 0.25 %, or else with the best of
    /// a few dozen sizes and places of the grid (free in x and y; the part stands on a plane of the grid). There may be
    /// no nearer number then.
    Count(u64),
    /// This edge, and a grid whose low corner has this x and y, as [`VoxelGrid::origin`](crate::VoxelGrid::origin) gives them: what a search for a
    /// [count](Resolution::Count) found once is made again, to the last bit. The corner lies no more than a cell before
    /// the part, and is taken to the nearest 2^-20 of a cell from it.
    At {
        /// Edge of a cell in millimetres.
        cell_mm: f64,
        /// Low corner of the grid in x and y, in millimetres.
        corner: [f64; 2],
    },
}

/// Options of [`voxelise`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct VoxelOptions {
    /// How large the cells are; 100,000 cells unless said otherwise.
    pub resolution: Resolution,
    /// Most bytes that the bits of the grid may take, 256 MiB (2,147,483,648 cells) unless said otherwise, at most
    /// [`VoxelGrid::MAX_BYTES`](crate::VoxelGrid::MAX_BYTES). A larger grid is refused before it is allocated, with the size of cells that fits. The
    /// work takes about two to three times that, up to fifteen times for a mesh with holes and faces on planes of the
    /// grid, and some 150 bytes for each triangle.
    pub max_bytes: u64,
}

impl Default for VoxelOptions {
    fn default() -> Self {
        VoxelOptions { resolution: Resolution::Count(100_000), max_bytes: 1 << 28 }
    }
}

/// The cells that a mesh touches or encloses.
///
/// # Arguments
/// * `vertices`: corners in millimetres. Those that no triangle names count for nothing but are checked.
/// * `triangles`: three indices each, counter-clockwise from outside. Closed or not, they may pass through each other,
///   repeat vertices, or be turned inwards, some or all: they are oriented first. Whoever goes on with the triangles
///   takes those of [`orient`](crate::orient).
/// * `options`: how large the cells are.
/// * `progress`: called now and then with the work done; `Break` stops it.
///
/// # Returns
/// The cells whose open interior meets the closed solid (see the [crate] for what that is), the part standing on
/// `z = 0`. Vertices are rounded to 2^-24 of a cell first; all that follows about the surface is exact.
///
/// # Errors
/// [`VoxelError`] for a mesh without (sound) triangles, an invalid coordinate, a wrong index, a surface of one side alone,
/// an invalid resolution, a grid beyond the limits of [`VoxelGrid`](crate::VoxelGrid) or of `max_bytes` (before it is allocated, with
/// the size or the number of cells that fits), a mesh that touches no cell, and if it was stopped.
///
/// # Cost
/// Linear in the triangles, the rows of cells that they touch and the pieces of the rest; a fifth of a second for a
/// million surface cells, some dozens of that for a wanted number. Deterministic, on one thread.
///
/// # Example
/// ```
/// use curvlay_voxel::{Resolution, VoxelOptions, nalgebra::Point3, voxelise};
/// use std::ops::ControlFlow;
/// // A tetrahedron with its corner at the origin, legs of 3 mm, in cells of 1 mm.
/// let vertices = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]].map(Point3::from);
/// let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// let options = VoxelOptions { resolution: Resolution::Cell(1.0), ..VoxelOptions::default() };
/// let solid = voxelise(&vertices, &triangles, &options, &|_| ControlFlow::Continue(()))?;
/// assert_eq!(solid.grid.count(), 6 + 3 + 1);
/// assert_eq!(solid.report.open_edges, 0);
/// # Ok::<(), curvlay_voxel::VoxelError>(())
/// ```
pub fn voxelise(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    options: &VoxelOptions,
    progress: ProgressFn<'_>,
) -> Result<Voxelisation, VoxelError> {
    match options.resolution {
        Resolution::Cell(cell_mm) if !(cell_mm > 0.0 && cell_mm.is_finite()) => {
            return Err(GridError::CellSize { cell_mm }.into());
        }
        Resolution::At { cell_mm, .. } if !(cell_mm > 0.0 && cell_mm.is_finite()) => {
            return Err(GridError::CellSize { cell_mm }.into());
        }
        Resolution::Count(0) => return Err(VoxelError::NoCount),
        _ => {}
    }
    let mut solid = Solid::new(vertices, triangles, options.max_bytes, progress)?;
    let (trial, trials) = match options.resolution {
        Resolution::Cell(cell) => (solid.trial(cell, [0.0; 2], &solid.go_on("voxelise"))?, 1),
        Resolution::Count(wanted) => search::nearest(&mut solid, wanted)?,
        Resolution::At { cell_mm, corner } => {
            let place = solid.place_before(corner, cell_mm)?;
            (solid.trial(cell_mm, place, &solid.go_on("voxelise"))?, 1)
        }
    };
    solid.finish(trial, trials)
}
