//! Pockets: the summits of a distance, and the saddles where they join.
//!
//! Vertices are visited from the highest down. Each starts a region of its own, or joins those of its higher
//! neighbours: then it is a saddle, and all but the highest of their pockets end there. This is the split tree of the
//! field, which is linear over triangles, so its summits and saddles are vertices; equal values are ordered by the
//! numbers of the vertices.

use super::around::Around;
use super::field::LevelField;
use crate::mesh::{NONE, SurfacePoint};
use crate::union_find::root;

/// A summit of the distance and the region around it, down to the saddle where a pocket with a higher summit begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pocket {
    /// The farthest point from the sources.
    pub summit: SurfacePoint,
    /// The distance there.
    pub height: f64,
    /// Where it joins, the distance there and the number of the pocket that it joins; `None` for the highest
    /// pocket of a connected region.
    pub joins: Option<(SurfacePoint, f64, usize)>,
}

impl LevelField<'_> {
    /// The pockets that rise by at least `rise` above the saddle where they join, highest first.
    ///
    /// # Arguments
    /// * `rise`: in millimetres; should exceed the tolerance of the field, or its errors make pockets along the medial
    ///   axis.
    ///
    /// # Cost
    /// `O(n log n)` for `n` vertices of the refined mesh.
    ///
    /// # Example
    /// ```
    /// # use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::geodesic::SurfaceDistance;
    /// use curvlay_toolpath::level_set::LevelField;
    /// use curvlay_toolpath::mesh::SurfaceMesh;
    /// # use std::ops::ControlFlow;
    /// // A bow tie: two triangles with a neck of 1 mm between them.
    /// let corners = [[-6.0, -5.0], [0.0, -0.5], [6.0, -5.0], [6.0, 5.0], [0.0, 0.5], [-6.0, 5.0]];
    /// let triangles = vec![[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]];
    /// let mesh = SurfaceMesh::new(corners.map(|[x, y]| Point3::new(x, y, 0.0)).to_vec(), triangles)?;
    /// let distance = SurfaceDistance::to_boundary(&mesh, &|_| ControlFlow::Continue(()))?;
    /// let pockets = LevelField::new(&distance, 0.01, &|_| ControlFlow::Continue(()))?.pockets(0.1);
    /// assert_eq!(pockets.len(), 2);
    /// let (_, saddle, joined) = pockets[1].joins.ok_or("the second pocket joins the first")?;
    /// assert!((saddle - 0.5).abs() < 0.01 && joined == 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn pockets(&self, rise: f64) -> Vec<Pocket> {
        let mut order: Vec<u32> =
            (0..self.values.len() as u32).filter(|&v| self.values[v as usize].is_finite()).collect();
        order.sort_by(|&a, &b| self.values[b as usize].total_cmp(&self.values[a as usize]).then(a.cmp(&b)));
        let around = Around::new(self);
        // The region of each visited vertex, as a forest, and the summit of each root.
        let mut region = vec![NONE; self.values.len()];
        let mut summit = vec![NONE; self.values.len()];
        // For each summit the saddle where it ends and the summit that goes on.
        let mut ends: Vec<Option<(u32, u32)>> = vec![None; self.values.len()];
        for &v in &order {
            (region[v as usize], summit[v as usize]) = (v, v);
            for other in around.neighbours(self, v) {
                if region[other as usize] == NONE {
                    continue;
                }
                let [here, there] = [v, other].map(|v| root(&mut region, v));
                if here == there {
                    continue;
                }
                // The vertex itself is a summit only until it meets a neighbour.
                let [one, two] = [here, there].map(|r| summit[r as usize]);
                let before = |a: u32, b: u32| {
                    let [va, vb] = [a, b].map(|v| self.values[v as usize]);
                    va > vb || (va >= vb && a < b)
                };
                let [high, low] = if before(one, two) { [one, two] } else { [two, one] };
                ends[low as usize] = Some((v, high));
                region[there as usize] = here;
                summit[here as usize] = high;
            }
        }
        let rises = |v: u32| match ends[v as usize] {
            Some((saddle, _)) => self.values[v as usize] - self.values[saddle as usize] >= rise && saddle != v,
            None => true,
        };
        let kept: Vec<u32> = order.iter().copied().filter(|&v| rises(v)).collect();
        let mut number = vec![usize::MAX; self.values.len()];
        kept.iter().enumerate().for_each(|(k, &v)| number[v as usize] = k);
        let point = |v: u32| self.surface_point(around.of(v)[0] / 3, self.points[v as usize]);
        let pocket = |&v: &u32| {
            let joins = ends[v as usize].map(|(saddle, mut into)| {
                // A lesser pocket on the way passes on to what it joins itself.
                while let (usize::MAX, Some((_, next))) = (number[into as usize], ends[into as usize]) {
                    into = next;
                }
                (point(saddle), self.values[saddle as usize], number[into as usize])
            });
            Pocket { summit: point(v), height: self.values[v as usize], joins }
        };
        kept.iter().map(pocket).collect()
    }
}
