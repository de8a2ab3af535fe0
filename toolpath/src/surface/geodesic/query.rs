//! Distances inside of triangles, exact as at the vertices.
//!
//! The shortest path to a point of a triangle starts in the triangle, or comes straight over one of its edges through a
//! window there, or from one of its corners. So the distance is the least over these. Each candidate is the length of a
//! path that exists: a line that misses its window is bent to the nearest end. So rounding at the ends of windows
//! cannot open a gap.

use super::SurfaceDistance;
use super::envelope::Window;
use crate::surface::mesh::{next, previous};
use nalgebra::Vector3;

/// The way from a point to the nearest source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Its length, in millimetres.
    pub distance: f64,
    /// Unit vector in the plane of the triangle in which the distance grows: straight away from the source, where
    /// the way is straight. Zero on a source, and where no source is connected. Where ways are equally long (on the
    /// medial axis) it belongs to one of them.
    pub direction: Vector3<f64>,
}

impl SurfaceDistance<'_> {
    /// The distance at a point of a triangle, exact as at the vertices, and the direction in which it grows.
    ///
    /// # Arguments
    /// * `barycentric`: weights of the corners, none negative, with the sum 1.
    ///
    /// # Panics
    /// If there is no such triangle.
    ///
    /// # Cost
    /// Proportional to the number of windows on the triangle's edges.
    pub fn at(&self, triangle: u32, barycentric: [f64; 3]) -> Nearest {
        let mut best = (f64::INFINITY, 3 * triangle, [0.0; 2]);
        for k in 0..3 {
            let h = 3 * triangle + k;
            let frame = self.unfolding.frame(h);
            let [ahead, above] = [1, 2].map(|further| barycentric[(k as usize + further) % 3]);
            let p = [ahead * frame.length + above * frame.apex[0], above * frame.apex[1]];
            let mut offer = |distance: f64, back_to: [f64; 2]| {
                if distance < best.0 {
                    best = (distance, h, [p[0] - back_to[0], p[1] - back_to[1]]);
                }
            };
            let tail = self.distances[self.mesh.tail(h) as usize];
            offer(tail + p[0].hypot(p[1]), [0.0; 2]);
            if self.is_source[h as usize] && 0.0 <= p[0] && p[0] <= frame.length {
                offer(p[1], [p[0], 0.0]);
            }
            let edge = self.mesh.edge(h);
            for window in self.envelope.on(edge).iter().filter(|window| window.enters == h) {
                let ([from, to], wave) = match edge == h {
                    true => (window.span, window.wave),
                    false => (window.span.map(|t| frame.length - t), window.wave.reversed(frame.length)),
                };
                let (from, to) = (from.min(to), from.max(to));
                let crossing = wave.crossing(p);
                if from <= crossing && crossing <= to {
                    let [x, y] = wave.direction(crossing);
                    offer(wave.beyond(p), [p[0] - x, p[1] - y]);
                } else {
                    let end = if crossing > to { to } else { from };
                    offer(wave.at(end) + (p[0] - end).hypot(p[1]), [end, 0.0]);
                }
            }
        }
        let (distance, half_edge, [x, y]) = best;
        let corner = |h: u32| self.mesh.vertices()[self.mesh.tail(h) as usize];
        let [a, b, c] = [half_edge, next(half_edge), previous(half_edge)].map(corner);
        let along = (b - a).normalize();
        let across = ((b - a).cross(&(c - a))).cross(&along).normalize();
        let direction = (along * x + across * y).try_normalize(0.0).filter(|_| distance > 0.0 && distance.is_finite());
        Nearest { distance, direction: direction.unwrap_or_default() }
    }

    /// The distance on an edge of the mesh, as a share of its length from the tail of a half-edge. As [`Self::at`], but
    /// only the windows next to the point need a look, since each is the first to arrive where it is.
    pub(crate) fn along(&self, half_edge: u32, share: f64) -> f64 {
        if self.is_source[half_edge as usize] {
            return 0.0;
        }
        let edge = self.mesh.edge(half_edge);
        let length = self.unfolding.frame(edge).length;
        let t = if edge == half_edge { share * length } else { (1.0 - share) * length };
        let windows = self.envelope.on(edge);
        let next = windows.partition_point(|window| window.span[1] < t);
        let beside = &windows[next.saturating_sub(1)..windows.len().min(next + 1)];
        let over = |window: &Window| {
            let bend = t.clamp(window.span[0], window.span[1]);
            window.wave.at(bend) + (t - bend).abs()
        };
        let [tail, head] = [self.mesh.tail(edge), self.mesh.head(edge)].map(|v| self.distances[v as usize]);
        beside.iter().map(over).fold((tail + t).min(head + (length - t)), f64::min)
    }

    /// How many windows the distance is made of: a measure of time and memory.
    pub fn windows(&self) -> usize {
        self.envelope.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Sources, SurfaceMesh};
    use nalgebra::Point3;
    use std::ops::ControlFlow;

    #[test]
    fn along_an_edge_is_as_in_the_triangle() {
        // A grid over saddles, with sources along its whole boundary, and from one vertex only.
        let at = |i: u32, j: u32| i + 9 * j;
        let place = |k: u32| (f64::from(k % 9), f64::from(k / 9));
        let lifted =
            |(x, y): (f64, f64)| Point3::new(x + 0.2 * (3.0 * y).sin(), y, 1.5 * (1.7 * x).sin() * (1.3 * y).cos());
        let cells = (0..64).map(|k| (k % 8, k / 8));
        let halves = |(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
        let vertices = (0..81).map(place).map(lifted).collect();
        let mesh = SurfaceMesh::new(vertices, cells.flat_map(halves).collect()).unwrap();
        let go_on = |_| ControlFlow::Continue(());
        let from_corner = Sources { vertices: &[0], ..Sources::default() };
        let to_boundary = SurfaceDistance::to_boundary(&mesh, &go_on).unwrap();
        for distance in [to_boundary, SurfaceDistance::to(&mesh, from_corner, &go_on).unwrap()] {
            for h in 0..mesh.half_edges() {
                for share in [0.0, 0.1, 0.37, 0.5, 0.82, 1.0] {
                    let mut barycentric = [0.0; 3];
                    (barycentric[h as usize % 3], barycentric[next(h) as usize % 3]) = (1.0 - share, share);
                    let (along, inside) = (distance.along(h, share), distance.at(h / 3, barycentric).distance);
                    assert!((along - inside).abs() < 1e-12, "half-edge {h}, {share}: {along}, {inside}");
                }
            }
        }
    }
}
