//! Which cells of a grid have their centre inside a mesh, and where its skin is nearest to others.

use super::error::TrimError;
use super::solid::Solid;
use crate::cells::Cells;
use crate::parallel::in_parallel;
use nalgebra::Point3;

/// A mesh whose points are in cells from the corner of a grid. Inside is where its winding number is not 0, or with holes above one half.
#[derive(Debug)]
pub(crate) struct Inside(Solid);

impl Inside {
    pub(crate) fn new(points: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self, TrimError> {
        Ok(Inside(Solid::new(points, triangles)?))
    }

    /// The bits of the cells with their centre inside; none in a grid that is too large.
    pub(crate) fn cells(&self, dims: [u32; 3]) -> Vec<u64> {
        if !dims.iter().all(|side| (1..=Cells::MAX_SIDE).contains(side)) {
            return Vec::new();
        }
        let bounds = self.0.tree.bounds();
        // Cells whose centre may lie in the box of the mesh.
        let [xs, ys, zs] = [0, 1, 2].map(|k| {
            let end = |place: f64| place.clamp(0.0, f64::from(dims[k])) as u32;
            end((bounds.low[k] - 0.5).ceil())..end((bounds.high[k] - 0.5).floor() + 1.0)
        });
        let words = dims[0].div_ceil(64) as usize;
        let row = |row: usize| {
            let mut bits = vec![0u64; words];
            let [y, z] = [row as u32 % dims[1], row as u32 / dims[1]];
            if ys.contains(&y) && zs.contains(&z) {
                let centre = |x: u32| Point3::from([x, y, z].map(|k| f64::from(k) + 0.5));
                xs.clone()
                    .filter(|&x| self.0.contains(&centre(x)))
                    .for_each(|x| bits[x as usize / 64] |= 1 << (x % 64));
            }
            bits
        };
        in_parallel(dims[1] as usize * dims[2] as usize, 1, row).concat()
    }

    /// How much of its area looks upwards, less what looks downwards, as a share of all.
    pub(crate) fn upward_share(&self) -> f64 {
        let (mut up, mut all) = (0.0, 0.0);
        for triangle in 0..self.0.triangles.len() as u32 {
            let [a, b, c] = self.0.corners(triangle);
            let normal = (b - a).cross(&(c - a));
            (up, all) = (up + normal.z, all + normal.norm());
        }
        if all > 0.0 { up / all } else { 0.0 }
    }

    /// The distance of a point from the skin, negative behind it: on the side that the mean normal at the nearest point looks away from, weighted by angles.
    pub(crate) fn height(&self, p: &Point3<f64>) -> f64 {
        self.0.signed_distance(p)
    }

    /// The point of the skin that is nearest.
    pub(crate) fn nearest(&self, p: &Point3<f64>) -> Point3<f64> {
        self.0.nearest(p)
    }
}
