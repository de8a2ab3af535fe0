//! The quadratic error function of a vertex: how far it lies from the planes of the crossings around it.
//!
//! T. Ju, F. Losasso, S. Schaefer and J. Warren, "Dual contouring of Hermite data", ACM TOG 21(3), 2002, section 2.1:
//! `E(x) = sum (n_i . (x - p_i))^2`, with the least distance to the mean of the `p_i` where that leaves `x` open. The singular values of the
//! normals are the roots of the eigenvalues of `sum n_i n_i^T`; directions with small ones are left at the mean.

use nalgebra::{Matrix3, Vector3};

/// Singular values below this share of the largest count as zero (Ju et al., section 2.3). With less a vertex leaves its
/// cube along surfaces that are nearly flat, with more edges are cut off.
const RANK: f64 = 0.1;

/// What is summed up of the planes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Qef {
    /// `sum n n^T`.
    normals: Matrix3<f64>,
    /// `sum n (n . p)`.
    offsets: Vector3<f64>,
}

impl Qef {
    /// Adds the plane through a place, across a direction of any length; none without a direction.
    pub(super) fn add(&mut self, place: Vector3<f64>, direction: Vector3<f64>) {
        if let Some(normal) = direction.try_normalize(0.0) {
            self.normals += normal * normal.transpose();
            self.offsets += normal * normal.dot(&place);
        }
    }

    /// The minimum that is nearest to the mean, as far on the way to it as the unit cube goes, less a margin at its sides.
    pub(super) fn minimum_near(&self, mean: Vector3<f64>, margin: f64) -> Vector3<f64> {
        let open = self.offsets - self.normals * mean;
        let eigen = self.normals.symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let mut way = Vector3::zeros();
        for k in 0..3 {
            if eigen.eigenvalues[k] > RANK * RANK * largest {
                let direction = eigen.eigenvectors.column(k);
                way += direction * (direction.dot(&open) / eigen.eigenvalues[k]);
            }
        }
        let room = |axis: usize| {
            let side = if way[axis] > 0.0 { 1.0 - margin } else { margin };
            if way[axis].abs() > 0.0 { ((side - mean[axis]) / way[axis]).max(0.0) } else { 1.0 }
        };
        mean + way * (0..3).map(room).fold(1.0, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, z: f64) -> Vector3<f64> {
        Vector3::new(x, y, z)
    }

    fn minimum(planes: &[(Vector3<f64>, Vector3<f64>)]) -> Vector3<f64> {
        let mut qef = Qef::default();
        planes.iter().for_each(|&(place, direction)| qef.add(place, direction));
        let mean = planes.iter().map(|(place, _)| place).sum::<Vector3<f64>>() / planes.len() as f64;
        qef.minimum_near(mean, 0.005)
    }

    #[test]
    fn three_planes_meet_in_a_corner_two_in_an_edge_and_one_leaves_the_mean() {
        let corner = [
            (at(0.7, 0.1, 0.1), at(2.0, 0.0, 0.0)),
            (at(0.1, 0.6, 0.1), at(0.0, 1.0, 0.0)),
            (at(0.2, 0.3, 0.8), at(0.0, 0.0, -1.0)),
        ];
        assert!((minimum(&corner) - at(0.7, 0.6, 0.8)).norm() < 1e-12);
        let edge = [(at(0.7, 0.2, 0.1), at(1.0, 0.0, 0.0)), (at(0.1, 0.4, 0.9), at(0.0, 0.0, 1.0))];
        assert!((minimum(&edge) - at(0.7, 0.3, 0.9)).norm() < 1e-12);
        let plane = [(at(0.5, 0.2, 0.1), at(1.0, 0.0, 0.0)), (at(0.5, 0.8, 0.7), at(1.0, 0.0, 0.0))];
        assert!((minimum(&plane) - at(0.5, 0.5, 0.4)).norm() < 1e-12);
    }

    #[test]
    fn a_corner_outside_of_the_cube_is_gone_towards_no_farther_than_the_cube_goes() {
        let planes = [(at(0.9, 0.1, 0.5), at(1.0, -0.5, 0.0)), (at(0.9, 0.9, 0.5), at(1.0, 0.5, 0.0))];
        let found = minimum(&planes);
        assert!((0..3).all(|k| (0.005..=0.995).contains(&found[k])), "{found}");
        assert!(minimum(&[(at(0.3, 0.4, 0.5), Vector3::zeros())]) == at(0.3, 0.4, 0.5));
    }
}
