//! Polygons of mesh files as triangles: convex or not, plane or slightly bent.
//!
//! A polygon is looked at along the axis that its normal is nearest to (M. E. Newell's normal: the sum of the cross
//! products of its edges). Dropping a coordinate rounds nothing, so that all decisions are exact. The triangles are
//! those of the constrained Delaunay triangulation inside the polygon (crate `spade`). Corners are taken from the least one on,
//! so that a polygon that begins at another corner gives the same triangles.

use nalgebra::{Point3, Vector3};
use robust::{Coord, orient2d};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation, mitigate_underflow};
use std::collections::BTreeMap;

/// Why a polygon has no triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PolygonError {
    /// Fewer than three corners at different places, or all of them on a line.
    #[error("the polygon has no area")]
    NoArea,
    /// Two of its edges cross, seen along its normal.
    #[error("the polygon crosses itself")]
    CrossesItself,
    /// A coordinate is not finite, or beyond 3e60.
    #[error("corner {corner} of the polygon has an invalid coordinate")]
    Coordinate {
        /// The corner, counted from 0.
        corner: usize,
    },
}

/// Largest coordinate: signs are exact up to there.
const MAX_COORDINATE: f64 = 3e60;

/// Cuts a polygon into triangles that run the same way round.
///
/// # Arguments
/// * `corners`: its corners in order. It need not be convex or exactly plane; an edge that is run through once each way
///   (a bridge to a hole) bounds nothing.
///
/// # Returns
/// Triangles, by the numbers of their corners. Corners at one place are one: the first of them.
///
/// # Errors
/// [`PolygonError`] for a polygon without area, one that crosses itself, and coordinates without an exact sign.
///
/// # Cost
/// `O(n log n)` for `n` corners as a rule; a convex quadrilateral takes four signs.
///
/// # Example
/// ```
/// use curvlay_voxel::{nalgebra::Point3, triangulate_polygon};
/// // An L: a fan around the first corner would leave it.
/// let l = [[1.0, 3.0], [0.0, 3.0], [0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0]].map(|[x, y]| Point3::new(x, y, 0.0));
/// let triangles = triangulate_polygon(&l)?;
/// let area = |[a, b, c]: [usize; 3]| (l[b] - l[a]).cross(&(l[c] - l[a])).z / 2.0;
/// assert!(triangles.iter().all(|&triangle| area(triangle) > 0.0));
/// assert_eq!(triangles.into_iter().map(area).sum::<f64>(), 5.0);
/// # Ok::<(), curvlay_voxel::PolygonError>(())
/// ```
pub fn triangulate_polygon(corners: &[Point3<f64>]) -> Result<Vec<[usize; 3]>, PolygonError> {
    let usable = |at: &Point3<f64>| at.iter().all(|c| c.abs() <= MAX_COORDINATE);
    if let Some(corner) = corners.iter().position(|at| !usable(at)) {
        return Err(PolygonError::Coordinate { corner });
    }
    let order = from_the_least(corners);
    if order.len() < 3 {
        return Err(PolygonError::NoArea);
    }
    let flat = in_the_plane(corners, &order)?;
    match order[..] {
        [a, b, c] => Ok(vec![[a, b, c]]),
        [a, b, c, d] if is_convex(&flat) => Ok(vec![[a, b, c], [a, c, d]]),
        _ => Ok(inside(&flat)?.into_iter().map(|triangle| triangle.map(|at| order[at])).collect()),
    }
}

/// The numbers of the corners from the least place on, without those at the place of the one before.
fn from_the_least(corners: &[Point3<f64>]) -> Vec<usize> {
    let key = |at: &Point3<f64>| [at.x + 0.0, at.y + 0.0, at.z + 0.0];
    let less = |a: &Point3<f64>, b: &Point3<f64>| {
        let (a, b) = (key(a), key(b));
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
    };
    let count = corners.len();
    // Of several corners at the least place the one with the least corner behind it.
    let rotated = |first: usize| (0..count).map(move |step| (first + step) % count);
    let compare = |a: usize, b: usize| {
        rotated(a).zip(rotated(b)).map(|(a, b)| less(&corners[a], &corners[b])).find(|order| order.is_ne())
    };
    let first = (0..count).reduce(|best, at| match less(&corners[at], &corners[best]) {
        std::cmp::Ordering::Less => at,
        std::cmp::Ordering::Equal if compare(at, best) == Some(std::cmp::Ordering::Less) => at,
        _ => best,
    });
    let mut order: Vec<usize> = first.into_iter().flat_map(rotated).collect();
    order.dedup_by(|next, before| less(&corners[*next], &corners[*before]).is_eq());
    while order.len() > 1 && less(&corners[order[0]], &corners[order[order.len() - 1]]).is_eq() {
        order.pop();
    }
    order
}

/// The corners seen along the axis that the normal is nearest to, so that they run counter-clockwise.
fn in_the_plane(corners: &[Point3<f64>], order: &[usize]) -> Result<Vec<Point2<f64>>, PolygonError> {
    let first = corners[order[0]];
    let size = order.iter().map(|&at| (corners[at] - first).amax()).fold(0.0, f64::max);
    let spoke = |at: usize| (corners[order[at % order.len()]] - first) / size;
    let normal: Vector3<f64> = (0..order.len()).map(|at| spoke(at).cross(&spoke(at + 1))).sum();
    if normal.amax().is_nan() || normal.amax() <= 0.0 {
        return Err(PolygonError::NoArea);
    }
    let axis = normal.iamax();
    let (u, v) = if normal[axis] > 0.0 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
    Ok(order.iter().map(|&at| mitigate_underflow(Point2::new(corners[at][u], corners[at][v]))).collect())
}

/// Whether four corners all turn left.
fn is_convex(flat: &[Point2<f64>]) -> bool {
    let coord = |at: usize| Coord { x: flat[at % flat.len()].x, y: flat[at % flat.len()].y };
    (0..flat.len()).all(|at| orient2d(coord(at), coord(at + 1), coord(at + 2)) > 0.0)
}

/// A corner in the triangulation.
struct Corner {
    place: Point2<f64>,
    number: usize,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.place
    }
}

/// The triangles of the constrained Delaunay triangulation that lie inside: an odd number of edges outwards.
fn inside(flat: &[Point2<f64>]) -> Result<Vec<[usize; 3]>, PolygonError> {
    let mut cdt = ConstrainedDelaunayTriangulation::<Corner>::new();
    let mut handles = Vec::with_capacity(flat.len());
    let mut first_at = BTreeMap::new();
    for (number, &place) in flat.iter().enumerate() {
        let bits = [(place.x + 0.0).to_bits(), (place.y + 0.0).to_bits()];
        let handle = match first_at.get(&bits) {
            Some(&handle) => handle,
            None => cdt.insert(Corner { place, number }).map_err(|_| PolygonError::Coordinate { corner: number })?,
        };
        first_at.insert(bits, handle);
        handles.push(handle);
    }
    // How often the polygon runs along each edge.
    let mut runs: BTreeMap<[usize; 2], u32> = BTreeMap::new();
    for (at, &from) in handles.iter().enumerate() {
        let to = handles[(at + 1) % handles.len()];
        if from == to {
            continue;
        }
        let edges = cdt.try_add_constraint(from, to);
        if edges.is_empty() {
            return Err(PolygonError::CrossesItself);
        }
        for edge in edges {
            *runs.entry(key(cdt.directed_edge(edge).vertices().map(|v| v.index()))).or_insert(0) += 1;
        }
    }
    // From the outside inwards, face by face.
    let mut is_inside = vec![None; cdt.num_all_faces()];
    is_inside[cdt.outer_face().index()] = Some(false);
    let mut border: Vec<_> = cdt.convex_hull().collect();
    while let Some(edge) = border.pop() {
        let (here, beyond) = (edge.face(), edge.rev().face());
        let known = is_inside[here.index()].unwrap_or(false);
        if is_inside[beyond.index()].is_none() {
            let crossed = runs.get(&key(edge.vertices().map(|v| v.index()))).is_some_and(|runs| runs % 2 == 1);
            is_inside[beyond.index()] = Some(known != crossed);
            border.extend(beyond.as_inner().into_iter().flat_map(|face| face.adjacent_edges()));
        }
    }
    let faces = cdt.inner_faces().filter(|face| is_inside[face.index()] == Some(true));
    let triangles: Vec<_> = faces.map(|face| face.vertices().map(|vertex| vertex.data().number)).collect();
    if triangles.is_empty() { Err(PolygonError::NoArea) } else { Ok(triangles) }
}

fn key([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}
