//! Trimming: the part of a sheet that lies inside a solid, ending exactly on its skin.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 3.4.5 and Fig. 3.8, trims the
//! isosurface `S*` of a layer (here the sheet) to the input model `H` (here the mesh) and leaves the how to others.
//! Here, for one mesh and many sheets:
//! 1. [`Trimmer::new`] welds the mesh, numbers its edges and plants one tree over it.
//! 2. Each triangle of the sheet that passes through triangles of the mesh shares a segment with each. Which do is
//!    decided exactly on the given coordinates. The sheet counts as lifted by an infinitely small step, so that there
//!    is no touching and no lying in a face (`predicates`, `crossing`).
//! 3. It is cut along its segments, on an integer grid of 1e-12 of its size (`patch`), each side of it once for both of
//!    its neighbours (`pieces`). Every edge on the mesh lies in one triangle of it, so its midpoint is on the mesh too.
//! 4. Along the sheet the winding number changes at segments alone, so one exact count for each connected part of the
//!    sheet gives that of all pieces. Inside is where it is not zero: the union of parts that pass through each
//!    other, for a mesh that looks outwards or inwards.
//! 5. A mesh with holes has a winding number that is not whole. Pieces are then cut where it is one half (`holes`).
//! 6. Triangles without height are taken out (`slivers`).
//! 7. Where trimmed sheets pass through each other, the later one ends at the earlier ([`Trimmer::clip`]); [`count_crossings`] counts
//!    where they do.
//!
//! Coordinates of cuts are rounded, what is cut is not a matter of rounding. So the result is a manifold for any input.

mod clip;
mod crossing;
mod crossings;
mod edges;
mod error;
pub(crate) mod exact;
mod holes;
mod inside;
mod patch;
mod pieces;
mod predicates;
mod sheet;
mod slices;
mod slivers;
mod solid;
mod surface;
mod triangle;
mod trimmed;
mod winding;

use super::Progress;
use crate::ProgressFn;
use crate::parallel::in_parallel;
pub use clip::Clipped;
pub(crate) use clip::{CLIP_REACH, Met, earlier_met};
pub(crate) use crossings::AllTriangles;
pub use crossings::{SurfaceCrossings, count_crossings};
pub(crate) use error::check;
pub use error::{Input, MAX_COORDINATE, TrimError};
pub(crate) use inside::Inside;
use nalgebra::{Point3, Vector3};
use pieces::Pieces;
use sheet::Sheet;
pub use slices::SurfaceSlices;
pub(crate) use slivers::MOVED;
use solid::{InsideRule, Solid};
use surface::Surface;
pub use triangle::MIN_ALTITUDE_MM;
pub(crate) use trimmed::slices;
pub use trimmed::{BoundaryEdge, BoundaryKind, TrimmedSheet};

/// Triangles from one report to the next: a few milliseconds, and for a mesh with holes some tenths of a second.
const TRIANGLES_PER_REPORT: usize = 512;

/// Points whose winding numbers a thread counts at a time: some hundred microseconds.
const POINTS_AT_A_TIME: usize = 64;

/// Vertices of a mesh in millimetres, and its triangles.
pub type MeshParts<'a> = (&'a [Point3<f64>], &'a [[u32; 3]]);

/// A solid, ready to trim any number of sheets.
///
/// # Example
/// ```
/// use curvlay_layers::trim::Trimmer;
/// use curvlay_layers::nalgebra::Point3;
/// # let corner = |k: u32| Point3::from([0, 1, 2].map(|bit| if k >> bit & 1 == 1 { 10.0 } else { 0.0 }));
/// # let cube: Vec<_> = (0..8).map(corner).collect();
/// # let faces = [
/// #     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
/// #     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// # ];
/// // A cube of 10 mm and a slanted sheet that reaches outside on all sides.
/// let trimmer = Trimmer::new(&cube, &faces)?;
/// let sheet = [[-5.0, -5.0, 2.0], [15.0, -5.0, 2.0], [15.0, 15.0, 6.0], [-5.0, 15.0, 6.0]].map(Point3::from);
/// let trimmed = trimmer.trim(&sheet, &[[0, 1, 2], [0, 2, 3]], &|_| std::ops::ControlFlow::Continue(()))?;
///
/// let slope = 1.04_f64.sqrt();
/// assert!((trimmed.area() - 100.0 * slope).abs() < 1e-9);
/// assert!((trimmed.mesh_mm - (20.0 + 20.0 * slope)).abs() < 1e-9);
/// assert!(trimmed.error_mm < 1e-12 && trimmed.border_mm == 0.0);
/// # Ok::<(), curvlay_layers::trim::TrimError>(())
/// ```
#[derive(Debug)]
pub struct Trimmer {
    solid: Solid,
    /// Edges of the boundary shorter than this are put together, mm.
    min_edge_mm: f64,
}

impl Trimmer {
    /// Prepares a solid: the points round which its triangles go (winding number above one half in absolute value).
    ///
    /// # Arguments
    /// * `vertices`: mm. Vertices at the same place count as one.
    /// * `triangles`: numbers of vertices. They need not be closed, united, free of double or flat ones, nor look
    ///   outwards.
    ///
    /// # Errors
    /// [`TrimError::EmptyMesh`], [`TrimError::BadCorner`], [`TrimError::BadCoordinate`].
    ///
    /// # Cost
    /// `O(n log n)` time for `n` triangles, some 300 bytes each.
    pub fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Trimmer, TrimError> {
        Ok(Trimmer { solid: Solid::new(vertices, triangles)?, min_edge_mm: 0.0 })
    }

    /// Prepares what a solid has outside of another: the points round which its triangles go, and those of the other do not.
    ///
    /// # Arguments
    /// * `solid`, `other`: vertices and triangles as [`Trimmer::new`] takes them. Both look outwards; `solid` goes round each of its points once. If `other` has holes,
    ///   it ends where its winding number is a quarter.
    ///
    /// # Errors, cost
    /// Those of [`Trimmer::new`].
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// use curvlay_layers::curved::cell_mesh;
    /// use curvlay_layers::trim::Trimmer;
    /// use curvlay_layers::nalgebra::Point3;
    /// use std::ops::ControlFlow::Continue;
    /// // A cube of 10 mm, a smaller one in its low corner, and a level sheet across both.
    /// let cells = Cells::new([1, 1, 1], &[1])?;
    /// let [cube, corner] = [10.0, 4.0].map(|mm| cell_mesh(&cells, &[0], mm, Point3::origin()));
    /// let trimmer = Trimmer::new_outside(
    ///     (&cube.vertices, &cube.triangles),
    ///     (&corner.vertices, &corner.triangles),
    /// )?;
    /// let sheet = [[-5.0, -5.0, 2.0], [40.0, -5.0, 2.0], [-5.0, 40.0, 2.0]].map(Point3::from);
    /// let trimmed = trimmer.trim(&sheet, &[[0, 1, 2]], &|_| Continue(()))?;
    /// assert!((trimmed.area() - (100.0 - 16.0)).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new_outside(solid: MeshParts, other: MeshParts) -> Result<Trimmer, TrimError> {
        let first = solid.0.len() as u32;
        // Each triangle of the other twice, turned: the winding number is above 0 where that of the solid is 1 and that of the other 0.
        let turned = other.1.iter().map(|&[a, b, c]| [c, b, a].map(|corner| first.saturating_add(corner)));
        let vertices = [solid.0, other.0].concat();
        let triangles: Vec<[u32; 3]> = solid.1.iter().copied().chain(turned.flat_map(|corners| [corners; 2])).collect();
        let mut solid = Solid::new(&vertices, &triangles)?;
        solid.rule = InsideRule::Positive;
        Ok(Trimmer { solid, min_edge_mm: 0.0 })
    }

    /// The same, but edges of the boundary on the mesh that are shorter than a length are put together where the boundary then
    /// keeps to the mesh within a fiftieth of that length ([`TrimmedSheet::error_mm`] says how closely it does). A tenth of a bead is a good
    /// length: a mesh of very many narrow facets costs no more time than a bead can show then.
    ///
    /// # Arguments
    /// * `min_edge_mm`: mm. Nothing is put together for 0, or what is no length.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::trim::Trimmer;
    /// use curvlay_layers::nalgebra::Point3;
    /// use std::{f64::consts::TAU, ops::ControlFlow};
    /// // A column with 2,000 sides, and a level sheet across it.
    /// let at = |k: u32, z: f64| Point3::new(10.0 * (TAU * f64::from(k) / 2000.0).cos(), 10.0 * (TAU * f64::from(k) / 2000.0).sin(), z);
    /// let vertices: Vec<_> = (0..2000).flat_map(|k| [at(k, 0.0), at(k, 5.0)]).chain([0.0, 5.0].map(|z| Point3::new(0.0, 0.0, z))).collect();
    /// let facets = |k: u32| {
    ///     let [a, b, c, d] = [2 * k, 2 * k + 1, (2 * k + 2) % 4000, (2 * k + 3) % 4000];
    ///     [[a, c, b], [b, c, d], [4000, c, a], [4001, b, d]]
    /// };
    /// let triangles: Vec<_> = (0..2000).flat_map(facets).collect();
    /// let sheet = [[-15.0, -15.0, 2.0], [15.0, -15.0, 2.0], [0.0, 40.0, 2.0]].map(Point3::from);
    /// let trimmer = Trimmer::new(&vertices, &triangles)?.thinned(0.1);
    /// let trimmed = trimmer.trim(&sheet, &[[0, 1, 2]], &|_| ControlFlow::Continue(()))?;
    /// assert!(trimmed.boundary.len() < 1000 && trimmed.error_mm < 0.002);
    /// # Ok::<(), curvlay_layers::trim::TrimError>(())
    /// ```
    pub fn thinned(self, min_edge_mm: f64) -> Trimmer {
        Trimmer { min_edge_mm, ..self }
    }

    /// The length below which edges of the boundary are put together; 0 if none are.
    pub(crate) fn min_edge_mm(&self) -> f64 {
        if self.min_edge_mm > 0.0 && self.min_edge_mm.is_finite() { self.min_edge_mm } else { 0.0 }
    }

    /// Whether the mesh has holes: an edge along which triangles do not run as often one way as the other.
    pub fn is_holed(&self) -> bool {
        self.solid.holes.is_some()
    }

    /// The volume of the mesh, if it closes and goes round each of some points once, all the same way, or not at all; else `None`.
    pub(crate) fn volume_if_simple(
        &self,
        points: usize,
        point: impl Fn(usize) -> Point3<f64> + Send + Sync,
    ) -> Option<f64> {
        if self.is_holed() {
            return None;
        }
        let volume = self.solid.signed_volume();
        let way = if volume < 0.0 { -1 } else { 1 };
        let numbers = in_parallel(points, POINTS_AT_A_TIME, |k| self.solid.winding(&point(k)));
        numbers.iter().all(|&number| number == 0 || number == way).then_some(volume.abs())
    }

    /// Whether a point is inside the mesh, by its winding number.
    pub(crate) fn contains(&self, p: &Point3<f64>) -> bool {
        self.solid.contains(p)
    }

    /// Where a line first meets the mesh: how far away, and the cosine between the line and the normal there, without sign.
    pub(crate) fn skin(&self, from: &Point3<f64>, way: &Vector3<f64>, reach: f64) -> Option<(f64, f64)> {
        self.solid.skin(from, way, reach)
    }

    /// The part of a sheet that lies inside.
    ///
    /// Where the sheet lies in a face it counts as just above it (and if that face is upright, as just beyond it in x,
    /// or else in y). So a sheet in the bottom of a box is kept and one in its lid is not.
    ///
    /// # Arguments
    /// * `vertices`: mm.
    /// * `triangles`: an oriented manifold with boundary. It may touch the mesh, in any way.
    /// * `progress`: called with the stage `trim` and the triangles that are done, for a mesh with holes a second time; may cancel.
    ///
    /// # Returns
    /// An oriented manifold with boundary that runs as the sheet does; empty if the sheet does not reach inside. The
    /// same on any number of threads.
    ///
    /// # Errors
    /// [`TrimError::BadCorner`], [`TrimError::BadCoordinate`], [`TrimError::RepeatedCorner`],
    /// [`TrimError::NotManifold`], [`TrimError::SameCorners`], [`TrimError::Cancelled`]; [`TrimError::Tangled`] for a solid that passes through itself
    /// beyond measure.
    ///
    /// # Cost
    /// For `s` triangles of the sheet and `m` of the mesh some `O(s log m)`, and for each that is cut the square
    /// of its number of segments. A mesh with holes takes far longer: a winding number for each vertex.
    pub fn trim(
        &self,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
        progress: ProgressFn,
    ) -> Result<TrimmedSheet, TrimError> {
        let watch = |done: usize, total: usize| match done % TRIANGLES_PER_REPORT {
            0 if progress(Progress { stage: "trim", done: done as u64, total: total as u64 }).is_break() => {
                Err(TrimError::Cancelled)
            }
            _ => Ok(()),
        };
        // The tests of the input are here; from here on nothing but cancelling and a tangled mesh can fail.
        let sheet = Sheet::new(vertices, triangles)?;
        sheet.check_corners()?;
        let mut pieces = Pieces::cut(&sheet, &self.solid, &watch)?;
        let keep: Vec<bool> = match &self.solid.holes {
            None => pieces.numbers(&self.solid).into_iter().map(|number| self.solid.rule.holds(number)).collect(),
            Some(dipoles) => holes::split_at_half(&mut pieces, &self.solid, dipoles, &watch)?,
        };
        let lost = |piece: usize, side: usize| match pieces.rise[piece][side] {
            0 => BoundaryKind::Hole,
            _ => BoundaryKind::Mesh,
        };
        let mut surface = Surface::of(&pieces, &keep, |_, _| BoundaryKind::Border, lost);
        if self.min_edge_mm() > 0.0 {
            slivers::thin_boundary(&mut surface, &self.solid, self.min_edge_mm());
        }
        slivers::remove_slivers(&mut surface, &self.solid);
        Ok(surface.finish(&self.solid))
    }
}
