//! Which way the triangles of a mesh look: made one way for each skin, and outwards.
//!
//! * Two triangles that meet at an edge of no others run along it in opposite directions; that floods one way round
//!   over all triangles that hang together by such edges (`flood`). A surface with one side alone, as a Moebius strip,
//!   has no such way and is refused.
//! * What closes a volume by itself is a body, and its signed volume says whether it looks outwards (`bodies`). Bodies
//!   that lie within others keep their side: the skin of a cavity rightly looks into the cavity. Holes are closed first.
//! * Where a mesh may be read in several ways, the report says so, with the volumes (`doubt`, `holes`).
//!
//! Corners are joined by exact position. Triangles with two corners at one place stay as they are.

mod bodies;
mod doubt;
mod flood;
mod holes;

pub use doubt::Doubt;

use crate::boundary::welded;
use crate::inspect::{InspectError, check};
use flood::Patches;
use holes::{Holes, Sheets};
use nalgebra::{Point3, Vector3};
use std::fmt;

/// A mesh whose triangles look outwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Oriented {
    /// The triangles in the order of the input; in those that were turned the last two corners have changed places.
    pub triangles: Vec<[u32; 3]>,
    /// What was done.
    pub report: OrientReport,
}

/// What [`orient`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct OrientReport {
    /// Triangles of the input.
    pub triangles: usize,
    /// Triangles that were turned.
    pub turned_triangles: usize,
    /// Edges of two triangles that disagreed: both ran along it the same way.
    pub disagreeing_edges: usize,
    /// More than half of the area was turned.
    pub inside_out: bool,
    /// Volume that the bodies bound, each by itself: cavities are taken off, bodies within others do not count again, holes are
    /// closed across their rims. Bodies that pass through each other count twice where they do.
    pub volume_mm3: f64,
    /// The same if bodies were within others by the winding number without closing holes: another number only where a hole decides
    /// whether a shell is a cavity.
    pub other_volume_mm3: f64,
    /// Bodies that lie within others and look outwards as those do, so that they count as solid, and their volume.
    pub shells: usize,
    /// Volume of those.
    pub shells_mm3: f64,
    /// Holes that were closed. Seams, where triangles meet without sharing corners, do not count.
    pub holes: usize,
    /// Area of their mouths.
    pub holes_mm2: f64,
    /// Volume that depends on how they are closed: half a ball over each mouth.
    pub holes_mm3: f64,
    /// Open surfaces that bound no volume.
    pub sheets: usize,
    /// Area of those.
    pub sheets_mm2: f64,
}

/// One line for the user; empty if nothing was turned.
impl fmt::Display for OrientReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { triangles, turned_triangles, disagreeing_edges, .. } = self;
        match (turned_triangles, disagreeing_edges) {
            (0, _) => Ok(()),
            (_, 0) if turned_triangles == triangles => write!(f, "all faces looked inwards: they were turned"),
            (_, 0) => write!(f, "{turned_triangles} of {triangles} triangles looked inwards: they were turned"),
            _ => write!(
                f,
                "the triangles disagreed about inside and outside at {disagreeing_edges} edges: {turned_triangles} of \
                 {triangles} were turned"
            ),
        }
    }
}

/// Why a mesh cannot be oriented.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OrientError {
    /// The mesh cannot be used at all.
    #[error(transparent)]
    Mesh(#[from] InspectError),
    /// A surface with one side alone.
    #[error(transparent)]
    OneSided(#[from] OneSided),
}

/// A surface that has one side alone, as a Moebius strip: no turning of its triangles makes neighbours agree.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the surface at triangles {} and {} near {at:?} has one side alone (as a Moebius strip): it bounds no solid; mend \
     the mesh there", .triangles[0], .triangles[1]
)]
pub struct OneSided {
    /// Two triangles with a common edge that cannot agree, counted from 0 in the order of the input.
    pub triangles: [u32; 2],
    /// The middle of that edge, in the units of the input.
    pub at: [f64; 3],
}

/// Turns the triangles of a mesh so that neighbours agree and the faces look outwards.
///
/// A mesh that is sound comes back as it is, cavities included. Within a skin whose triangles disagree the side of the
/// larger area counts where the skin lies within other bodies; everywhere else outwards is where the signed volume is
/// above zero (holes are closed by cones over their rims). A skin without a volume keeps the side of its larger area.
///
/// # Arguments
/// * `vertices`, `triangles`: corners in millimetres, and three of their numbers for each triangle. Vertices may
///   repeat, as in STL.
///
/// # Errors
/// [`OrientError::OneSided`]; [`OrientError::Mesh`] as [`inspect`](crate::inspect::inspect).
///
/// # Cost
/// `O(n log n)` for `n` triangles (some 3 ms for 7,000), and up to 64 rays for each body if there are several. One
/// thread; the same result on every run.
///
/// # Example
/// ```
/// use curvlay_voxel::{nalgebra::Point3, orient};
/// let vertices = [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.0]].map(Point3::from);
/// // The last face looks inwards.
/// let mended = orient(&vertices, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 3, 2]])?;
/// assert_eq!(mended.triangles, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
/// assert_eq!((mended.report.turned_triangles, mended.report.disagreeing_edges), (1, 3));
/// # Ok::<(), curvlay_voxel::OrientError>(())
/// ```
pub fn orient(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Oriented, OrientError> {
    check(vertices, triangles)?;
    Ok(orient_welded(vertices, triangles, &welded(vertices))?)
}

/// The same for a mesh that was looked through; `welded` has for each vertex the first one at its position.
pub(crate) fn orient_welded(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    welded: &[u32],
) -> Result<Oriented, OneSided> {
    let used = || triangles.iter().flatten().map(|&corner| &vertices[corner as usize]);
    let none = Vector3::repeat(f64::INFINITY);
    let (low, high) = used().fold((none, -none), |(low, high), at| (low.inf(&at.coords), high.sup(&at.coords)));
    let size = (high - low).max();
    // In a box of side 1 nothing overflows, and what lay at one place does so still.
    let in_box = |corner: u32| {
        let off = vertices[corner as usize].coords - low;
        Point3::from(if size > 0.0 { off / size } else { off })
    };
    let corners: Vec<_> = triangles.iter().map(|triangle| triangle.map(in_box)).collect();
    let joined: Vec<_> = triangles.iter().map(|triangle| triangle.map(|corner| welded[corner as usize])).collect();
    let area = |[a, b, c]: &[Point3<f64>; 3]| (b - a).cross(&(c - a)).norm();
    let areas: Vec<f64> = corners.iter().map(area).collect();

    let patches = Patches::flood(&joined, &areas).map_err(|(triangles, ends)| OneSided {
        triangles,
        at: nalgebra::center(&vertices[ends[0] as usize], &vertices[ends[1] as usize]).into(),
    })?;
    let places: Vec<_> = (0..vertices.len() as u32).map(in_box).collect();
    let bodies = bodies::outwards(&patches, &corners, &places);
    let turned = &bodies.turned;
    let turned_area: f64 = areas.iter().zip(turned).filter(|&(_, &turned)| turned).map(|(area, _)| area).sum();
    let turn = |(&[a, b, c], &turned): (&[u32; 3], &bool)| if turned { [a, c, b] } else { [a, b, c] };
    let oriented: Vec<_> = triangles.iter().zip(turned).map(turn).collect();
    let sheets = Sheets::of(&bodies.sheets, &places, welded, &oriented, &areas);
    let holes = Holes::of(&places, welded, sheets.others(&oriented));
    let (square, cube) = (size * size, size * size * size);
    let report = OrientReport {
        triangles: triangles.len(),
        turned_triangles: turned.iter().filter(|&&turned| turned).count(),
        disagreeing_edges: patches.disagreeing_edges,
        inside_out: turned_area > areas.iter().sum::<f64>() / 2.0,
        volume_mm3: bodies.volume * cube,
        other_volume_mm3: bodies.other_volume * cube,
        shells: bodies.shells,
        shells_mm3: bodies.shells_volume * cube,
        holes: holes.count,
        holes_mm2: holes.area * square,
        holes_mm3: holes.volume * cube,
        sheets: sheets.count,
        sheets_mm2: sheets.area * square,
    };
    Ok(Oriented { triangles: oriented, report })
}
