//! Boxes, and how far apart two of them surely are.
//!
//! S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree: a hierarchical structure for rapid interference detection",
//! SIGGRAPH 1996, section 5: two boxes are disjoint when one of 15 axes parts them. Here the axes are of length 1, so the
//! widest gap on any of them is a lower bound of the distance. A box may have no thickness: so does that of a
//! segment.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

/// A box along the axes of its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Aabb {
    pub center: Point3<f64>,
    /// Half its edges.
    pub half: Vector3<f64>,
}

impl Aabb {
    pub fn between(low: &Point3<f64>, high: &Point3<f64>) -> Self {
        Aabb { center: nalgebra::center(low, high), half: (high - low) * 0.5 }
    }

    /// The least box of some points; at least one.
    pub fn of(points: &[Point3<f64>]) -> Self {
        let (mut low, mut high) = (points[0], points[0]);
        for point in points {
            low = low.inf(point);
            high = high.sup(point);
        }
        Aabb::between(&low, &high)
    }

    pub fn corners(&self) -> [Point3<f64>; 8] {
        std::array::from_fn(|k| {
            let sign = |bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
            self.center + self.half.component_mul(&Vector3::new(sign(0), sign(1), sign(2)))
        })
    }

    /// The square of its diagonal, which says which of two boxes is the larger.
    pub fn size(&self) -> f64 {
        self.half.norm_squared()
    }
}

/// Edges that include a sine below this are parallel; their cross product parts nothing that others do not.
const PARALLEL: f64 = 1e-6;

/// How frame B lies in frame A, made ready for many pairs of boxes.
pub(super) struct Between {
    rotation: Matrix3<f64>,
    shift: Vector3<f64>,
    absolute: Matrix3<f64>,
    /// Of each pair of edges: one over the length of their cross product; 0 where they are parallel.
    scale: Matrix3<f64>,
}

impl Between {
    pub fn new(a_b: &Isometry3<f64>) -> Self {
        let rotation = a_b.rotation.to_rotation_matrix().into_inner();
        let scale = rotation.map(|cos| {
            let sine = (1.0 - cos * cos).max(0.0).sqrt();
            if sine > PARALLEL { 1.0 / sine } else { 0.0 }
        });
        Between { rotation, shift: a_b.translation.vector, absolute: rotation.abs(), scale }
    }

    /// A lower bound of the distance of a box in A and a box in B: the widest gap on any axis, but for rounding. At
    /// most 0 when no axis parts them. Stops at the first axis with a gap above `enough`.
    #[inline]
    pub fn gap(&self, a: &Aabb, b: &Aabb, enough: f64) -> f64 {
        let (r, abs) = (&self.rotation, &self.absolute);
        let apart = r * b.center.coords + self.shift - a.center.coords;
        let (across_a, across_b) = (abs * b.half, abs.tr_mul(&a.half));
        let mut gap = f64::NEG_INFINITY;
        for i in 0..3 {
            gap = gap.max(apart[i].abs() - a.half[i] - across_a[i]);
        }
        if gap > enough {
            return gap;
        }
        let along_b = r.tr_mul(&apart);
        for j in 0..3 {
            gap = gap.max(along_b[j].abs() - b.half[j] - across_b[j]);
        }
        if gap > enough {
            return gap;
        }
        for i in 0..3 {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            for j in 0..3 {
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                let between = (apart[i2] * r[(i1, j)] - apart[i1] * r[(i2, j)]).abs();
                let reach_a = a.half[i1] * abs[(i2, j)] + a.half[i2] * abs[(i1, j)];
                let reach_b = b.half[j1] * abs[(i, j2)] + b.half[j2] * abs[(i, j1)];
                gap = gap.max((between - reach_a - reach_b) * self.scale[(i, j)]);
            }
        }
        gap
    }
}
