//! Distance of points from the surface of a mesh.
//!
//! Nearest triangle by a tree of boxes, nearest box first; nearest point of a triangle by its plane or its edges. The
//! mesh may have holes, crossings and triangles without area: it is a set of triangles, no more.

use crate::inspect::bvh::{Aabb, Bvh};
use crate::inspect::{InspectError, check};
use nalgebra::Point3;

/// A mesh that is ready to be asked for distances.
#[derive(Clone, Debug)]
pub struct BoundaryDistance {
    corners: Vec<[Point3<f64>; 3]>,
    bvh: Bvh,
}

/// The point of a mesh that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The point on the surface.
    pub point: Point3<f64>,
    /// The triangle that it lies on; one of them, if several are equally near.
    pub triangle: u32,
    /// Its distance, in millimetres.
    pub distance_mm: f64,
}

impl BoundaryDistance {
    /// Sorts the triangles of a mesh (corners in millimetres, three of their numbers for each triangle).
    ///
    /// # Errors
    /// As [`inspect`](crate::inspect::inspect): no triangle, a corner that does not exist or is not finite.
    ///
    /// # Cost
    /// `O(n log n)` time and some 150 bytes a triangle.
    ///
    /// # Example
    /// ```
    /// use curvlay_voxel::BoundaryDistance;
    /// use curvlay_voxel::nalgebra::Point3;
    ///
    /// let vertices = [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]].map(Point3::from);
    /// let surface = BoundaryDistance::new(&vertices, &[[0, 1, 2]])?;
    /// assert_eq!(surface.distance(&Point3::new(1.0, 1.0, -3.0)), 3.0);
    /// let nearest = surface.nearest(&Point3::new(9.0, 0.0, 4.0)).unwrap();
    /// assert_eq!((nearest.point, nearest.distance_mm), (vertices[1], 5.0));
    /// # Ok::<(), curvlay_voxel::inspect::InspectError>(())
    /// ```
    pub fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self, InspectError> {
        check(vertices, triangles)?;
        let corners: Vec<_> = triangles.iter().map(|t| t.map(|corner| vertices[corner as usize])).collect();
        let bvh = Bvh::new(corners.iter().map(Aabb::around));
        Ok(BoundaryDistance { corners, bvh })
    }

    /// Distance of `point` from the surface, in millimetres, whether it lies inside or outside. Not a number for a
    /// point that [`nearest`](Self::nearest) has no answer for.
    ///
    /// # Cost
    /// `O(log n)` near the surface.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        self.nearest(point).map_or(f64::NAN, |nearest| nearest.distance_mm)
    }

    /// The point of the surface that is nearest to `point`; `None` if `point` is not finite, or farther than
    /// [`MAX_COORDINATE`](crate::inspect::MAX_COORDINATE) from the origin.
    ///
    /// # Cost
    /// `O(log n)` near the surface.
    pub fn nearest(&self, point: &Point3<f64>) -> Option<Nearest> {
        if !point.iter().all(|x| x.abs() <= crate::inspect::MAX_COORDINATE) {
            return None;
        }
        let nearest_of = |triangle: u32| nearest_on_triangle(&self.corners[triangle as usize], point);
        let (triangle, squared) =
            self.bvh.nearest(point, |triangle| nalgebra::distance_squared(&nearest_of(triangle), point))?;
        Some(Nearest { point: nearest_of(triangle), triangle, distance_mm: squared.sqrt() })
    }
}

/// The point of the triangle that is nearest to `point`.
fn nearest_on_triangle([a, b, c]: &[Point3<f64>; 3], point: &Point3<f64>) -> Point3<f64> {
    let (u, v, to) = (b - a, c - a, point - a);
    let normal = u.cross(&v);
    let size = normal.norm_squared();
    // Twice the areas, times `size`, that the foot of the perpendicular cuts off.
    let (at_b, at_c) = (to.cross(&v).dot(&normal), u.cross(&to).dot(&normal));
    if size > 0.0 && at_b >= 0.0 && at_c >= 0.0 && at_b + at_c <= size {
        // Along the normal, which is exact on axes, rather than by the two shares.
        return point - normal * (to.dot(&normal) / size);
    }
    let mut best = nearest_on_segment(a, b, point);
    for candidate in [nearest_on_segment(b, c, point), nearest_on_segment(c, a, point)] {
        if nalgebra::distance_squared(&candidate, point) < nalgebra::distance_squared(&best, point) {
            best = candidate;
        }
    }
    best
}

fn nearest_on_segment(from: &Point3<f64>, to: &Point3<f64>, point: &Point3<f64>) -> Point3<f64> {
    let along = to - from;
    let share = (point - from).dot(&along) / along.norm_squared();
    // A segment without length has a share that is not a number, and one end is as good as the other.
    if share >= 1.0 {
        *to
    } else if share > 0.0 {
        from + along * share
    } else {
        *from
    }
}
