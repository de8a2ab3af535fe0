//! Bands: the connected parts of the surface between neighbouring levels, and the rings that bound them.
//!
//! A triangle has a piece in each slab between its lowest and its highest corner. Pieces in the same slab are connected
//! over an edge whose ends span the slab. This is the connectivity of rings too, so both agree always.

use super::field::LevelField;
use super::levels::Levels;
use super::rings::{Falling, Seen, trace};
use super::{LevelSetError, Ring};
use crate::mesh::SurfacePoint;
use crate::union_find::{join, root};
use nalgebra::Point3;

/// A connected part of the surface between two levels that follow each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// How many levels lie below it: 0 between the sources and level 0.
    pub slab: usize,
    /// Rings where it begins, by number: those of level `slab - 1`. None in slab 0.
    pub below: Vec<u32>,
    /// Rings where it ends, of level `slab`. None around a summit.
    pub above: Vec<u32>,
    /// Its farthest point from the sources.
    pub summit: SurfacePoint,
    /// The distance there.
    pub height: f64,
    /// Its area in mm^2.
    pub area: f64,
}

/// Rings at given distances and the bands between them.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelSets {
    /// All rings, level by level.
    pub rings: Vec<Ring>,
    /// All bands, in the order of the first triangle in each.
    pub bands: Vec<Band>,
}

impl LevelField<'_> {
    /// The level sets at the given distances, and how they nest.
    ///
    /// # Arguments
    /// * `levels`: in millimetres, rising. Level 0 gives the boundary itself; none around summits exactly at a level.
    ///
    /// # Errors
    /// [`LevelSetError::Level`].
    ///
    /// # Cost
    /// `O(n + p)` for `n` refined triangles, of which the levels cross `p`, each counted for each level.
    ///
    /// # Example
    /// ```
    /// # use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::geodesic::SurfaceDistance;
    /// use curvlay_toolpath::level_set::LevelField;
    /// use curvlay_toolpath::mesh::SurfaceMesh;
    /// # use std::ops::ControlFlow;
    /// // A square of 8 mm, cut along a diagonal: all vertices lie on the boundary.
    /// let corners = [[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]].map(|[x, y]| Point3::new(x, y, 0.0));
    /// let square = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?;
    /// let distance = SurfaceDistance::to_boundary(&square, &|_| ControlFlow::Continue(()))?;
    /// let sets = LevelField::new(&distance, 0.01, &|_| ControlFlow::Continue(()))?.level_sets(&[1.0, 3.0])?;
    /// assert_eq!(sets.rings.len(), 2);
    /// assert!((sets.rings[0].length() - 24.0).abs() < 0.01 && (sets.rings[1].length() - 8.0).abs() < 0.01);
    /// assert!(sets.rings[0].above == sets.rings[1].below);
    /// assert!((sets.bands[sets.rings[1].above as usize].height - 4.0).abs() < 0.01);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn level_sets(&self, levels: &[f64]) -> Result<LevelSets, LevelSetError> {
        let rises = |k: usize| levels[k].is_finite() && (k == 0 || levels[k - 1] < levels[k]);
        if let Some(level) = (0..levels.len()).find(|&k| !rises(k)) {
            return Err(LevelSetError::Level { level });
        }
        Ok(self.sets(levels))
    }

    /// The level sets at levels that rise.
    pub(crate) fn sets(&self, levels: &(impl Levels + ?Sized)) -> LevelSets {
        let mut pieces = Pieces::new(self, levels);
        pieces.connect(self);
        let (mut bands, number) = pieces.bands(self, levels);
        let mut rings = Vec::new();
        let falling = Falling::new(self, &pieces.slabs, levels.count());
        let mut seen = Seen::new(self.triangles.len());
        for level in 0..levels.count() {
            for mut traced in trace(self, levels, &pieces.slabs, level, &falling, &mut seen) {
                let mut band = |slab: usize| {
                    let piece = pieces.of(traced.triangle, slab);
                    number[root(&mut pieces.parents, piece) as usize]
                };
                (traced.ring.below, traced.ring.above) = (band(level), band(level + 1));
                bands[traced.ring.below as usize].above.push(rings.len() as u32);
                bands[traced.ring.above as usize].below.push(rings.len() as u32);
                rings.push(traced.ring);
            }
        }
        LevelSets { rings, bands }
    }
}

/// Pieces of triangles, joined into sets.
struct Pieces {
    /// The slab of each vertex: how many levels are below it.
    slabs: Vec<usize>,
    /// The first piece of each triangle and its slab, and an end.
    first: Vec<(u32, usize)>,
    parents: Vec<u32>,
}

impl Pieces {
    fn new(field: &LevelField, levels: &(impl Levels + ?Sized)) -> Self {
        let slabs: Vec<usize> = (0..).zip(&field.values).map(|(v, &value)| levels.below(value, v)).collect();
        let mut count = 0;
        let mut first = Vec::with_capacity(field.triangles.len() + 1);
        for corners in &field.triangles {
            let [a, b, c] = corners.map(|v| slabs[v as usize]);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            first.push((count, low));
            // Where no source is connected there is nothing.
            if field.values[corners[0] as usize].is_finite() {
                count += (high - low) as u32 + 1;
            }
        }
        first.push((count, 0));
        Pieces { slabs, first, parents: (0..count).collect() }
    }

    fn of(&self, triangle: u32, slab: usize) -> u32 {
        let (first, low) = self.first[triangle as usize];
        first + (slab - low) as u32
    }

    /// Joins pieces across edges. The lower number becomes the root, so that bands are numbered by first pieces.
    fn connect(&mut self, field: &LevelField) {
        for h in 0..field.half_edges() {
            let Some(twin) = field.twin(h).filter(|&twin| twin > h) else { continue };
            if field.values[field.tail(h) as usize].is_infinite() {
                continue;
            }
            let [one, other] = [field.tail(h), field.head(h)].map(|v| self.slabs[v as usize]);
            for slab in one.min(other)..=one.max(other) {
                let [a, b] = [h, twin].map(|h| self.of(h / 3, slab));
                join(&mut self.parents, a, b);
            }
        }
    }

    /// The bands without their rings, and for each root the number of its band.
    fn bands(&mut self, field: &LevelField, levels: &(impl Levels + ?Sized)) -> (Vec<Band>, Vec<u32>) {
        let mut number = vec![u32::MAX; self.parents.len()];
        let mut bands: Vec<Band> = Vec::new();
        for (triangle, corners) in field.triangles.iter().enumerate() {
            let ((from, low), (to, _)) = (self.first[triangle], self.first[triangle + 1]);
            let summit = (0..3).max_by(|&i, &j| {
                let [one, other] = [i, j].map(|k: usize| field.values[corners[k] as usize]);
                one.total_cmp(&other)
            });
            let top = corners[summit.unwrap_or(0)];
            for piece in from..to {
                let slab = low + (piece - from) as usize;
                let root = root(&mut self.parents, piece) as usize;
                // Only the highest piece reaches up to the corner; the others end at a level.
                let height = if piece + 1 == to { field.values[top as usize] } else { levels.at(slab, top) };
                if number[root] == u32::MAX {
                    number[root] = bands.len() as u32;
                    let summit = field.surface_point(triangle as u32, field.points[top as usize]);
                    let (below, above) = (Vec::new(), Vec::new());
                    bands.push(Band { slab, below, above, summit, height: f64::NEG_INFINITY, area: 0.0 });
                }
                let band = &mut bands[number[root] as usize];
                if height > band.height {
                    band.height = height;
                    band.summit = field.surface_point(triangle as u32, field.up_to(triangle as u32, top, height));
                }
                let below = |level: usize| {
                    let over = corners.map(|v| field.values[v as usize] - levels.at(level, v));
                    area_below(field.area(triangle as u32), over)
                };
                let upper = if piece + 1 == to { field.area(triangle as u32) } else { below(slab) };
                band.area += upper - if piece == from { 0.0 } else { below(slab - 1) };
            }
        }
        (bands, number)
    }
}

impl LevelField<'_> {
    /// The point with the given value on the way from the lowest corner of a triangle up to `top`.
    fn up_to(&self, triangle: u32, top: u32, value: f64) -> Point3<f64> {
        let corners = self.triangles[triangle as usize];
        let lowest = |a: u32, b: u32| if self.values[b as usize] < self.values[a as usize] { b } else { a };
        let bottom = lowest(lowest(corners[0], corners[1]), corners[2]);
        let [high, low] = [top, bottom].map(|v| self.values[v as usize]);
        let [end, start] = [top, bottom].map(|v| self.points[v as usize]);
        if value >= high { end } else { end + (start - end) * ((high - value) / (high - low)) }
    }

    /// Area of a triangle.
    pub(crate) fn area(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.triangles[triangle as usize].map(|v| self.points[v as usize]);
        0.5 * (b - a).cross(&(c - a)).norm()
    }
}

/// Area of the part of a triangle where a linear function with the given values at the corners is at most zero.
fn area_below(area: f64, mut over: [f64; 3]) -> f64 {
    over.sort_by(f64::total_cmp);
    let [low, middle, high] = over;
    // It cuts off a corner that shrinks in two directions.
    if high <= 0.0 {
        area
    } else if middle <= 0.0 {
        area * (1.0 - high * high / ((high - low) * (high - middle)))
    } else if low < 0.0 {
        area * low * low / ((high - low) * (middle - low))
    } else {
        0.0
    }
}
