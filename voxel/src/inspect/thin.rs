//! Features thinner than a width.
//!
//! The thickness at a point of the surface is the length of the straight way into the solid, against the normal,
//! until the surface is met from within. (The shape diameter of L. Shapira, A. Shamir, D. Cohen-Or, "Consistent mesh
//! partitioning and skeletonisation using the shape diameter function", The Visual Computer 24, 2008, averages over a
//! cone of such rays; for a wall that makes thicknesses that it does not have.) Where parts overlap, the way ends at
//! the first surface, also if that lies inside the union.

use super::bvh::{Aabb, Bvh};
use super::error::InspectError;
use super::weld::{check, is_needle};
use nalgebra::{Point3, Vector3};

/// Sample points for the whole surface, beside one a triangle: the share is then good to a hundredth or so.
const SAMPLES: f64 = 20_000.0;

/// What is thinner than a width.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThinFeatures {
    /// Share of the surface, from 0 to 1.
    pub share: f64,
    /// The least thickness that was met and its place, if any is below the width.
    pub thinnest: Option<(f64, Point3<f64>)>,
}

/// How much of the surface has less than `width_mm` of solid under it.
///
/// With the size of a cell as the width, that is the share of the surface that cells can no longer resolve.
///
/// # Arguments
/// * `vertices`, `triangles`: a mesh with outward faces, in millimetres; one that looks inwards as a whole (its signed
///   volume is negative) is taken the other way round.
/// * `width_mm`: a length above zero.
///
/// # Errors
/// [`InspectError::Width`], else as [`inspect`](super::inspect).
///
/// # Cost
/// Some 20,000 rays and one a triangle, each `O(log n)` for a width that is small beside the part. One thread; the
/// result is the same on every run.
///
/// # Example
/// ```
/// use curvlay_voxel::inspect::thinner_than;
/// use curvlay_voxel::nalgebra::Point3;
///
/// // A plate of 10 x 10 x 1 mm: its two faces make 200 of 240 square millimetres.
/// let corner = |k: u32| Point3::new(f64::from(k & 1) * 10.0, f64::from(k >> 1 & 1) * 10.0, f64::from(k >> 2));
/// let vertices: Vec<_> = (0..8).map(corner).collect();
/// let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
/// let triangles: Vec<_> = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
/// let thin = thinner_than(&vertices, &triangles, 1.5)?;
/// assert!((thin.share - 200.0 / 240.0).abs() < 1e-9);
/// # Ok::<(), curvlay_voxel::inspect::InspectError>(())
/// ```
pub fn thinner_than(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    width_mm: f64,
) -> Result<ThinFeatures, InspectError> {
    if !(width_mm.is_finite() && width_mm > 0.0) {
        return Err(InspectError::Width { width_mm });
    }
    check(vertices, triangles)?;
    let mut corners: Vec<[Point3<f64>; 3]> = triangles.iter().map(|t| t.map(|at| vertices[at as usize])).collect();
    let doubled_normal = |[a, b, c]: &[Point3<f64>; 3]| (b - a).cross(&(c - a));
    let total: f64 = corners.iter().map(|t| doubled_normal(t).norm() / 2.0).sum();
    let origin = corners[0][0];
    let volume: f64 = corners.iter().map(|[a, b, c]| (a - origin).dot(&(b - origin).cross(&(c - origin)))).sum();
    if volume < 0.0 {
        corners.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    let bvh = Bvh::new(corners.iter().map(Aabb::around));

    let mut thin_area = 0.0;
    let mut thinnest: Option<(f64, Point3<f64>)> = None;
    for (number, triangle) in (0..).zip(&corners) {
        let [a, b, c] = triangle;
        if is_needle([a, b, c]) {
            continue; // Its normal means nothing.
        }
        let normal = doubled_normal(triangle);
        let (area, inwards) = (normal.norm() / 2.0, -normal.normalize());
        let steps = (area / total * SAMPLES).sqrt().ceil().max(1.0) as u32;
        let mut thin = 0u32;
        for point in samples(triangle, steps) {
            if let Some(thickness) = way_out(&bvh, &corners, number, &point, &inwards, width_mm) {
                thin += 1;
                if thinnest.is_none_or(|(least, _)| thickness < least) {
                    thinnest = Some((thickness, point));
                }
            }
        }
        thin_area += area * f64::from(thin) / (f64::from(steps) * f64::from(steps));
    }
    Ok(ThinFeatures { share: if total > 0.0 { thin_area / total } else { 0.0 }, thinnest })
}

/// The centres of the `steps * steps` like triangles into which a triangle can be cut.
fn samples([a, b, c]: &[Point3<f64>; 3], steps: u32) -> impl Iterator<Item = Point3<f64>> {
    let (u, v) = ((b - a) / f64::from(steps), (c - a) / f64::from(steps));
    (0..steps).flat_map(move |row| {
        // In each row upright triangles take turns with inverted ones.
        (0..2 * (steps - row) - 1).map(move |at| {
            let third = if at % 2 == 0 { 1.0 } else { 2.0 } / 3.0;
            a + u * (f64::from(at / 2) + third) + v * (f64::from(row) + third)
        })
    })
}

/// The way from `point` of the triangle `from` along `direction` to the first triangle that is met from behind, if it
/// is shorter than `width`.
fn way_out(
    bvh: &Bvh,
    corners: &[[Point3<f64>; 3]],
    from: u32,
    point: &Point3<f64>,
    direction: &Vector3<f64>,
    width: f64,
) -> Option<f64> {
    let end = point + direction * width;
    let way = Aabb::around([point, &end]);
    let mut least = None;
    bvh.search(
        |bounds| bounds.overlaps(&way) && bounds.meets_ray(point, direction),
        |number| {
            if number != from
                && let Some(length) = leaves_through(&corners[number as usize], point, direction)
                && length < least.unwrap_or(width)
            {
                least = Some(length);
            }
        },
    );
    least
}

/// Where a ray meets a triangle from behind: T. Möller, B. Trumbore, "Fast, minimum storage ray-triangle
/// intersection", Journal of Graphics Tools 2(1), 1997.
fn leaves_through([a, b, c]: &[Point3<f64>; 3], point: &Point3<f64>, direction: &Vector3<f64>) -> Option<f64> {
    let (u, v, from) = (b - a, c - a, point - a);
    let across = direction.cross(&v);
    // Below zero for a ray that runs along the normal.
    let facing = u.dot(&across);
    if facing >= 0.0 {
        return None;
    }
    let share_u = from.dot(&across) / facing;
    let turned = from.cross(&u);
    let share_v = direction.dot(&turned) / facing;
    let way = v.dot(&turned) / facing;
    (share_u >= 0.0 && share_v >= 0.0 && share_u + share_v <= 1.0 && way >= 0.0).then_some(way.abs())
}
