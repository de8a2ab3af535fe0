//! Volume, area and faces of a body.

use crate::hull3::ConvexHull;
use crate::plane::{cross, minus};

/// A face of a body: all of its surface in one plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Face {
    /// Outward normal without common divisor.
    pub normal: [i64; 3],
    /// The corners in lexical order; a face that reaches to infinity has others there.
    pub corners: Vec<[i32; 3]>,
}

impl ConvexHull {
    /// Six times the volume, exactly; `None` for a body that reaches down without end.
    ///
    /// # Example
    /// ```
    /// use curvlay_hull::{ConvexHull, Depth};
    /// let mut block = ConvexHull::new(Depth::SURFACE);
    /// block.insert(&[[0, 0, 0], [3, 0, 0], [0, 4, 0], [0, 0, 5], [3, 4, 5]])?;
    /// assert_eq!(block.volume_times_6(), Some(180));
    /// # Ok::<(), curvlay_hull::HullError>(())
    /// ```
    pub fn volume_times_6(&self) -> Option<i128> {
        let origin = self.triangles().flatten().flatten().next().unwrap_or([0; 3]);
        let mut volume = 0;
        for corners in self.triangles() {
            let [Some(a), Some(b), Some(c)] = corners else { return None };
            let normal = cross(minus(b, origin), minus(c, origin));
            volume += minus(a, origin).iter().zip(normal).map(|(&u, n)| i128::from(u) * i128::from(n)).sum::<i128>();
        }
        Some(volume)
    }

    /// Area of the surface in square lattice units; `None` for a body that reaches down without end. A body without
    /// volume has none.
    pub fn area(&self) -> Option<f64> {
        let finite = self.triangles().all(|corners| corners.iter().all(Option::is_some));
        finite.then(|| self.planes().map(|plane| plane.length() / 2.0).sum())
    }

    /// The faces by rising normal: triangles in one plane make one face.
    ///
    /// # Cost
    /// `O(f log f)` for `f` facets.
    pub fn faces(&self) -> Vec<Face> {
        let mut triangles: Vec<_> =
            self.facets().map(|facet| (self.plane_of(facet).reduced().normal, self.facet(facet).corners)).collect();
        triangles.sort_unstable();
        let of_one_normal = triangles.chunk_by(|a, b| a.0 == b.0);
        of_one_normal
            .map(|facets| {
                let mut corners: Vec<_> =
                    facets.iter().flat_map(|(_, corners)| corners).filter_map(|&c| self.finite(c)).collect();
                corners.sort_unstable();
                corners.dedup();
                Face { normal: facets[0].0, corners }
            })
            .collect()
    }

    /// Checks every property of the structure; for tests.
    #[cfg(test)]
    pub(crate) fn assert_sound(&self) {
        for slot in self.facets() {
            let facet = self.facet(slot);
            for k in 0..3 {
                let twin = self.facet(facet.across[k]);
                let back = (0..3).find(|&e| twin.across[e] == slot && twin.corners[e] == facet.corners[(k + 1) % 3]);
                assert!(back.is_some(), "facet {slot} and its neighbour disagree");
            }
            for corner in self.corners() {
                assert!(self.plane_of(slot).height(corner) <= 0, "facet {slot} is not convex at {corner:?}");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Depth;

    #[test]
    fn a_block_of_nine_has_6_faces_and_8_corners() {
        let nine = 0..9;
        let block: Vec<_> =
            nine.clone().flat_map(|x| (0..9).flat_map(move |y| (0..9).map(move |z| [x, y, z]))).collect();
        for batch in [1, 7, 81, 729] {
            let mut hull = ConvexHull::new(Depth::SURFACE);
            for points in block.chunks(batch) {
                hull.insert(points).unwrap();
            }
            hull.assert_sound();
            assert_eq!(hull.corners().len(), 8);
            let faces = hull.faces();
            assert_eq!(faces.len(), 6);
            assert!(faces.iter().all(|face| face.corners.len() == 4));
            assert_eq!(hull.volume_times_6(), Some(6 * 8 * 8 * 8));
            assert!((hull.area().unwrap() - 384.0).abs() < 1e-9);
        }
    }
}
