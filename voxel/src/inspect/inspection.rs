//! The inspection: all findings of the other files in one report.

use super::bvh::{Aabb, Bvh};
use super::edges::Edges;
use super::error::InspectError;
use super::report::MeshReport;
use super::weld::{self, Kind, Welded};
use super::{crossings, orientation};
use nalgebra::Point3;

/// The triangles without area that are of no use to their neighbours: those with two corners at one place, and those whose
/// corners lie on a line (exactly, or but for the rounding of STL files) unless they fill the slit between an edge and a corner
/// on it. Without them the mesh is as closed as it was.
///
/// # Returns
/// Numbers of the triangles, rising.
///
/// # Errors
/// As [`inspect`].
///
/// # Cost
/// `O(n)` for `n` triangles; `O(n log n)` if some have no area.
///
/// # Example
/// ```
/// use curvlay_voxel::inspect::without_area;
/// use curvlay_voxel::nalgebra::Point3;
/// let vertices = [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.0]].map(Point3::from);
/// let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [2, 2, 3]];
/// assert_eq!(without_area(&vertices, &triangles)?, [4]);
/// # Ok::<(), curvlay_voxel::inspect::InspectError>(())
/// ```
pub fn without_area(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Vec<u32>, InspectError> {
    weld::check(vertices, triangles)?;
    let mesh = Welded::new(vertices, triangles);
    if mesh.kinds.iter().all(|kind| *kind == Kind::Sound) {
        return Ok(Vec::new());
    }
    let part = Edges::new(&mesh).part;
    let is_useless = |at: &u32| part[*at as usize] == u32::MAX && mesh.kinds[*at as usize] != Kind::Sound;
    Ok((0..triangles.len() as u32).filter(is_useless).collect())
}

/// Looks at a triangle mesh.
///
/// # Arguments
/// * `vertices`, `triangles`: corners in millimetres, and three of their numbers for each triangle, counter-clockwise
///   seen from outside. Vertices may repeat (each triangle its own, as in STL); unused ones do not count.
///
/// # Errors
/// [`InspectError`] for a mesh without triangles, with corners that do not exist or are not finite, or of more than
/// 2^30 triangles. Faulty meshes are no errors: that is what the report is about.
///
/// # Cost
/// `O(n log n)` for `n` triangles that cross little (0.1 s for 50,000) and some 300 bytes for each. Where very many
/// boxes of triangles overlap, the search for crossings is cut short, and the report says so. One thread; the report is
/// the same on every run. Signs are exact where coordinates are 0 or between 1e-80 and [`MAX_COORDINATE`](super::MAX_COORDINATE).
///
/// # Example
/// ```
/// use curvlay_voxel::inspect::{Orientation, inspect};
/// use curvlay_voxel::nalgebra::Point3;
///
/// let vertices = [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.0]].map(Point3::from);
/// let tetrahedron = inspect(&vertices, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
/// assert!(tetrahedron.is_sound());
/// assert_eq!((tetrahedron.euler, tetrahedron.components, tetrahedron.signed_volume_mm3), (2, 1, 36.0));
///
/// let open = inspect(&vertices, &[[0, 2, 1], [0, 1, 3], [0, 3, 2]])?;
/// assert_eq!((open.watertight, open.open_edges.count, open.holes), (false, 3, 1));
/// assert_eq!(open.orientation, Orientation::Outward);
/// # Ok::<(), curvlay_voxel::inspect::InspectError>(())
/// ```
pub fn inspect(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<MeshReport, InspectError> {
    weld::check(vertices, triangles)?;
    let mut mesh = Welded::new(vertices, triangles);
    let zero_area = mesh.zero_area();
    let [repeated, opposed] = mesh.mark_repeats();
    let edges = Edges::new(&mesh);
    let at_edges = edges.findings(&mesh);
    let boxes = (0..triangles.len() as u32).map(|triangle| Aabb::around(mesh.corners(triangle)));
    let bvh = Bvh::new(boxes);
    let contacts = crossings::find(&mesh, &edges, &bvh);
    let volumes = orientation::measure(&mesh, &edges, &at_edges.closure, &bvh);
    let vertices = edges.corner_count(&mesh);
    let faces = edges.part.iter().filter(|&&part| part != u32::MAX).count();
    let bounds = Aabb::around(&mesh.points);
    Ok(MeshReport {
        triangles: triangles.len(),
        vertices,
        zero_area,
        repeated,
        opposed,
        open_edges: at_edges.open,
        holes: at_edges.holes,
        open_length_mm: at_edges.rim_mm,
        largest_hole: at_edges.largest_hole,
        non_manifold_edges: at_edges.non_manifold,
        inconsistent_edges: at_edges.inconsistent,
        crossings: contacts.crossings,
        touching: contacts.touching,
        contacts_complete: contacts.complete,
        watertight: at_edges.watertight,
        orientation: volumes.orientation,
        components: edges.parts,
        cavities: volumes.cavities,
        euler: vertices as i64 - at_edges.edges as i64 + faces as i64,
        signed_volume_mm3: volumes.signed_mm3,
        area_mm2: volumes.area_mm2,
        bounds: [Point3::from(bounds.low), Point3::from(bounds.high)],
    })
}
