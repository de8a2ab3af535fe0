//! Bounds of the clearance of bodies: no point of them is nearer to the nozzle.
//!
//! Each distance to a line of the nozzle (see the module above) is convex in space, so it is nowhere less than its tangent at the middle of a body.

use super::Nozzle;
use nalgebra::Vector3;

/// How far a nozzle may be from a pose, to all sides, in millimetres: in the plane of the axis and a point.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::gouging) struct Sway {
    /// Along its direction, and across it.
    pub along: f64,
    pub across: f64,
    /// How far a turn of its direction moves it at the point.
    pub turned: f64,
}

/// How far a body reaches from a point, or no farther than that.
#[derive(Clone, Copy, Debug)]
pub(in crate::gouging) struct Extent {
    /// Along the axis and against it.
    pub up: f64,
    pub down: f64,
    /// Along [`Nozzle::inward_of_cone`].
    pub into_cone: f64,
    /// Toward the axis.
    pub inward: f64,
}

impl Nozzle {
    /// The unit vector into the cone, across its side, from points that are in the direction `out` from the axis.
    pub(in crate::gouging) fn inward_of_cone(&self, axis: &Vector3<f64>, out: &Vector3<f64>) -> Vector3<f64> {
        axis * self.sin - out * self.cos
    }

    /// No less than this is the clearance in a body around a point at (`z`, `rho`).
    ///
    /// A nozzle that sways takes from each distance to a line what that line moves.
    pub(in crate::gouging) fn least_around(&self, z: f64, rho: f64, sway: &Sway, extent: &Extent) -> f64 {
        let [by_along, by_across, by_side] = self.swayed(sway);
        let (up, down) = (extent.up + by_along, extent.down + by_along);
        let side = (rho - self.tip_radius) * self.cos - z * self.sin - by_side;
        let cone = (-z - up).max(z - self.cone_height - down).max(side - extent.into_cone);
        cone.min((self.cone_height - z - up).max(rho - self.block_radius - extent.inward - by_across))
    }

    /// How far the flat ends, the side of the block and that of the cone move against a point.
    fn swayed(&self, sway: &Sway) -> [f64; 3] {
        let Sway { along, across, turned } = *sway;
        [along + turned, across + turned, across * self.cos + along * self.sin + turned]
    }

    /// No less than this is the clearance within a triangle whose middle is at (`z`, `rho`), if its corners are higher by
    /// the first and farther out, along the ray from the axis to the middle, by the second of `corners`.
    ///
    /// The tangent at the middle is least at a corner.
    pub(in crate::gouging) fn least_over(&self, z: f64, rho: f64, sway: &Sway, corners: [[f64; 2]; 3]) -> f64 {
        let [by_along, by_across, by_side] = self.swayed(sway);
        let least =
            |up: f64, out: f64| corners.map(|[z, rho]| up * z + out * rho).into_iter().fold(f64::INFINITY, f64::min);
        let side = (rho - self.tip_radius) * self.cos - z * self.sin + least(-self.sin, self.cos) - by_side;
        let (lower, upper) = (least(-1.0, 0.0) - by_along, least(1.0, 0.0) - by_along);
        let cone = (lower - z).max(side).max(z - self.cone_height + upper);
        cone.min((self.cone_height - z + lower).max(rho - self.block_radius + least(0.0, 1.0) - by_across))
    }

    /// A bound as [`Nozzle::least_over`], closer where a triangle lies across the edge of the tip or of the block: there each of the two
    /// faces alone is passed, but no point passes both.
    pub(in crate::gouging) fn least_over_edges(&self, z: f64, rho: f64, corners: [[f64; 2]; 3]) -> f64 {
        let side = (rho - self.tip_radius) * self.cos - z * self.sin;
        let cone = least_of_larger(
            corners.map(|[up, _]| -z - up),
            corners.map(|[up, out]| side - self.sin * up + self.cos * out),
        );
        let block = least_of_larger(
            corners.map(|[up, _]| self.cone_height - z - up),
            corners.map(|[_, out]| rho - self.block_radius + out),
        );
        cone.min(block)
    }
}

/// No less than this is the larger of two functions that are linear over a triangle, given at its corners: the most that the least
/// corner of a mean of both comes to. By duality that is the least there is.
fn least_of_larger(one: [f64; 3], other: [f64; 3]) -> f64 {
    let least = |share: f64| {
        let at = |k: usize| other[k] + share * (one[k] - other[k]);
        at(0).min(at(1)).min(at(2))
    };
    // Concave and piecewise linear in the share: the most is at an end, or where two corners are level.
    let level = [[0, 1], [1, 2], [2, 0]].map(|[i, j]| {
        let share = (other[j] - other[i]) / ((one[i] - other[i]) - (one[j] - other[j]));
        if share > 0.0 && share < 1.0 { least(share) } else { f64::NEG_INFINITY }
    });
    level.into_iter().fold(least(0.0).max(least(1.0)), f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Slow twin: many points of a triangle, none of which has less clearance than the bounds say.
        #[test]
        fn no_point_of_a_triangle_is_nearer_than_the_bounds(
            at in prop::array::uniform3(-1.0_f64..1.0),
            size in prop::array::uniform9(-1.0_f64..1.0),
            scale in prop::array::uniform2(0.05_f64..12.0),
        ) {
            let nozzle = Nozzle::default();
            let middle = Vector3::from(at) * scale[0];
            let [a, b] = [0, 3].map(|k| Vector3::new(size[k], size[k + 1], size[k + 2]) * scale[1]);
            let corners = [a, b, -a - b];
            let rho = middle.xy().norm();
            let out = if rho > 0.0 { Vector3::new(middle.x, middle.y, 0.0) / rho } else { Vector3::zeros() };
            let of_corners = corners.map(|corner| [corner.z, corner.dot(&out)]);
            let coarse = nozzle.least_over(middle.z, rho, &Sway::default(), of_corners);
            let close = nozzle.least_over_edges(middle.z, rho, of_corners);
            for i in 0..=40 {
                for j in 0..=40 - i {
                    let [u, v] = [f64::from(i) / 40.0, f64::from(j) / 40.0];
                    let point = middle + corners[0] * u + corners[1] * v + corners[2] * (1.0 - u - v);
                    let clearance = nozzle.clearance(point.z, point.xy().norm());
                    prop_assert!(coarse <= clearance + 1e-9 && close <= clearance + 1e-9, "{coarse} {close} {clearance}");
                }
            }
        }

        /// The bound of the larger of two linear functions is reached: it is the least over a fine raster, to its steps.
        #[test]
        fn the_larger_of_two_linear_functions_is_bounded_as_closely_as_can_be(
            one in prop::array::uniform3(-1.0_f64..1.0),
            other in prop::array::uniform3(-1.0_f64..1.0),
        ) {
            let bound = least_of_larger(one, other);
            let mut least = f64::INFINITY;
            for i in 0..=200 {
                for j in 0..=200 - i {
                    let shares = [f64::from(i) / 200.0, f64::from(j) / 200.0, f64::from(200 - i - j) / 200.0];
                    let at = |values: [f64; 3]| (0..3).map(|k| shares[k] * values[k]).sum::<f64>();
                    least = least.min(at(one).max(at(other)));
                }
            }
            prop_assert!(bound <= least + 1e-12 && bound >= least - 0.02, "{bound} {least}");
        }
    }
}
