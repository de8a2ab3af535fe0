//! Distances inside of triangles, exact as at the vertices.
//!
//! The shortest path to a point of a triangle starts in the triangle, or comes straight over one of its edges through a
//! window there, or from one of its corners. So the distance is the least over these. Each candidate is the length of a
//! path that exists: a line that misses its window is bent to the nearest end. So rounding at the ends of windows
//! cannot open a gap.

use super::SurfaceDistance;
use super::envelope::Window;
use super::wave::Wave;
use nalgebra::{Point3, Vector3};

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

/// What reaches a triangle, in the frame of its first half-edge: straight lines from a point or parallel ones.
#[derive(Clone, Copy, Debug)]
struct Light {
    /// The source, laid flat, or the direction of parallel lines.
    from: [f64; 2],
    parallel: bool,
    /// The distance at the source, or at the origin of the frame.
    base: f64,
    /// The interval of an edge through which lines come, the triangle on its left, and the distances at its ends; none
    /// around a corner.
    gate: Option<[([f64; 2], f64); 2]>,
}

/// All that reaches a triangle: many distances in one triangle cost less with this at hand.
#[derive(Clone, Debug, Default)]
pub(crate) struct TriangleLights {
    triangle: Option<u32>,
    origin: Point3<f64>,
    axes: [Vector3<f64>; 2],
    /// The middle, laid flat.
    middle: [f64; 2],
    /// With the length of the way to the middle, shortest first.
    lights: Vec<(f64, Light)>,
}

/// A light that is later at the middle than this share more than it may be still counts: far above rounding.
const ROUNDING: f64 = 1e-9;

impl Light {
    /// The length of the way to a point, if less than `best`, and where it comes from: a vector of any length.
    // The search asks some ten lights for each distance, and mostly needs no direction.
    #[inline(always)]
    fn reach(&self, p: [f64; 2], best: f64) -> Option<(f64, [f64; 2])> {
        let [dx, dy] = [p[0] - self.from[0], p[1] - self.from[1]];
        // No bent way is shorter than the straight one. Most lights lose here: no root for them.
        let (straight, way) = match self.parallel {
            true => (self.base + self.from[0] * p[0] + self.from[1] * p[1], self.from),
            false => {
                let (square, room) = (dx * dx + dy * dy, best - self.base);
                if room <= 0.0 || square >= room * room {
                    return None;
                }
                (self.base + square.sqrt(), [dx, dy])
            }
        };
        if straight >= best {
            return None;
        }
        let Some(gate) = &self.gate else { return Some((straight, way)) };
        // Positive where the point lies to the left of the ray over an end of the gate.
        let past = |[x, y]: [f64; 2]| match self.parallel {
            true => self.from[0] * (p[1] - y) - self.from[1] * (p[0] - x),
            false => (x - self.from[0]) * dy - (y - self.from[1]) * dx,
        };
        if past(gate[0].0) <= 0.0 && past(gate[1].0) >= 0.0 {
            return Some((straight, way));
        }
        // The line misses the window: the way bends over the nearer end, which is longer, but exists.
        let bent = gate.map(|([x, y], distance)| {
            let [dx, dy] = [p[0] - x, p[1] - y];
            (distance + (dx * dx + dy * dy).sqrt(), [dx, dy])
        });
        let bent = if bent[1].0 < bent[0].0 { bent[1] } else { bent[0] };
        (bent.0 < best).then_some(bent)
    }
}

impl TriangleLights {
    /// Makes this that of a triangle.
    pub fn load(&mut self, distance: &SurfaceDistance, triangle: u32) {
        if self.triangle == Some(triangle) {
            return;
        }
        self.triangle = Some(triangle);
        (self.origin, self.axes) = distance.axes(triangle);
        // The likeliest first, so that the others lose early.
        let [u, v] = [1, 2].map(|k| {
            let mesh = distance.mesh();
            self.flat(mesh.vertices()[mesh.triangles()[triangle as usize][k] as usize])
        });
        let middle = [(u[0] + v[0]) / 3.0, (u[1] + v[1]) / 3.0];
        self.middle = middle;
        self.lights.clear();
        distance.lights(triangle, |light| {
            let there = light.reach(middle, f64::INFINITY).map_or(f64::INFINITY, |(distance, _)| distance);
            self.lights.push((there, light));
        });
        self.lights.sort_by(|one, other| one.0.total_cmp(&other.0));
    }

    /// A point of the triangle laid flat.
    pub fn flat(&self, p: Point3<f64>) -> [f64; 2] {
        self.axes.map(|axis| (p - self.origin).dot(&axis))
    }

    /// The distance at a point laid flat.
    pub fn distance(&self, p: [f64; 2]) -> f64 {
        self.least(p).0
    }

    /// The distances at some points laid flat.
    pub fn distances<const N: usize>(&self, points: [[f64; 2]; N]) -> [f64; N] {
        points.map(|p| self.distance(p))
    }

    /// The distance, and how it grows along a direction in the plane.
    pub fn slope(&self, p: [f64; 2], [u, v]: [f64; 2]) -> (f64, f64) {
        let (distance, [x, y]) = self.least(p);
        let length = (x * x + y * y).sqrt();
        (distance, if length > 0.0 { (x * u + y * v) / length } else { 0.0 })
    }

    /// The length of the shortest way to a point laid flat, and where it comes from.
    #[inline(always)]
    fn least(&self, p: [f64; 2]) -> (f64, [f64; 2]) {
        let [dx, dy] = [p[0] - self.middle[0], p[1] - self.middle[1]];
        let from_middle = (dx * dx + dy * dy).sqrt();
        let mut best = (f64::INFINITY, [0.0; 2]);
        for (at_middle, light) in &self.lights {
            // A way to the point and on to the middle is no shorter than the light's way to the middle. The lights that follow are later still.
            if *at_middle > (best.0 + from_middle) * (1.0 + ROUNDING) {
                break;
            }
            best = light.reach(p, best.0).unwrap_or(best);
        }
        best
    }
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
        let frame = self.unfolding.frame(3 * triangle);
        let p = [barycentric[1] * frame.length + barycentric[2] * frame.apex[0], barycentric[2] * frame.apex[1]];
        let mut best = (f64::INFINITY, [0.0; 2]);
        self.lights(triangle, |light| best = light.reach(p, best.0).unwrap_or(best));
        let (distance, [x, y]) = best;
        let [along, across] = self.axes(triangle).1;
        let direction = (along * x + across * y).try_normalize(0.0).filter(|_| distance > 0.0 && distance.is_finite());
        Nearest { distance, direction: direction.unwrap_or_default() }
    }

    /// The first corner of a triangle, and unit vectors along its first edge and across it.
    fn axes(&self, triangle: u32) -> (Point3<f64>, [Vector3<f64>; 2]) {
        let [a, b, c] = self.mesh.triangles()[triangle as usize].map(|v| self.mesh.vertices()[v as usize]);
        let along = (b - a).normalize();
        let across = ((b - a).cross(&(c - a))).cross(&along).normalize();
        (a, [along, across])
    }

    /// All that reaches a triangle.
    fn lights(&self, triangle: u32, mut add: impl FnMut(Light)) {
        let first = self.unfolding.frame(3 * triangle);
        let corners = [[0.0; 2], [first.length, 0.0], first.apex];
        for k in 0..3 {
            let h = 3 * triangle + k as u32;
            let (tail, head) = (corners[k], corners[(k + 1) % 3]);
            let length = self.unfolding.frame(h).length;
            let base = self.distances[self.mesh.tail(h) as usize];
            // Over a corner any way is open: its distance is that of a path that exists.
            add(Light { from: tail, parallel: false, base, gate: None });
            let u = [(head[0] - tail[0]) / length, (head[1] - tail[1]) / length];
            // From the frame of the half-edge to that of the first one.
            let placed = |x: f64, y: f64| [tail[0] + u[0] * x - u[1] * y, tail[1] + u[1] * x + u[0] * y];
            let turned = |x: f64, y: f64| [u[0] * x - u[1] * y, u[1] * x + u[0] * y];
            let strip = |along: f64, across: f64, base: f64| {
                let from = turned(along, across);
                (from, base - from[0] * tail[0] - from[1] * tail[1])
            };
            if self.is_source[h as usize] {
                let (from, base) = strip(0.0, 1.0, 0.0);
                add(Light { from, parallel: true, base, gate: Some([(tail, 0.0), (head, 0.0)]) });
            }
            let edge = self.mesh.edge(h);
            for window in self.envelope.on(edge).iter().filter(|window| window.enters == h) {
                let ([from, to], wave) = match edge == h {
                    true => (window.span, window.wave()),
                    false => ([length - window.span[1], length - window.span[0]], window.wave().reversed(length)),
                };
                let gate = Some([from, to].map(|t| (placed(t, 0.0), wave.at(t))));
                add(match wave {
                    Wave::Point { x, depth, base } => Light { from: placed(x, -depth), parallel: false, base, gate },
                    Wave::Strip { along, across, base } => {
                        let (from, base) = strip(along, across, base);
                        Light { from, parallel: true, base, gate }
                    }
                });
            }
        }
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
        // Windows follow each other along the edge: the one at the place and its neighbours, if the place is in a gap.
        let windows = self.envelope.on(edge);
        let next = windows.partition_point(|window| window.span[1] < t);
        let beside = &windows[next.saturating_sub(1)..windows.len().min(next + 1)];
        let over = |window: &Window| {
            let bend = t.clamp(window.span[0], window.span[1]);
            window.wave().at(bend) + (t - bend).abs()
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
    use super::super::Sources;
    use super::*;
    use crate::mesh::{SurfaceMesh, next};
    use nalgebra::Point3;
    use std::ops::ControlFlow;

    /// A grid over saddles.
    fn saddles() -> SurfaceMesh {
        let at = |i: u32, j: u32| i + 9 * j;
        let place = |k: u32| (f64::from(k % 9), f64::from(k / 9));
        let lifted =
            |(x, y): (f64, f64)| Point3::new(x + 0.2 * (3.0 * y).sin(), y, 1.5 * (1.7 * x).sin() * (1.3 * y).cos());
        let cells = (0..64).map(|k| (k % 8, k / 8));
        let halves = |(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
        let vertices = (0..81).map(place).map(lifted).collect();
        SurfaceMesh::new(vertices, cells.flat_map(halves).collect()).unwrap()
    }

    /// To its whole boundary, and from one vertex only.
    fn distances(mesh: &SurfaceMesh) -> [SurfaceDistance<'_>; 2] {
        let go_on = |_| ControlFlow::Continue(());
        let from_corner = Sources { vertices: &[0], ..Sources::default() };
        [SurfaceDistance::to_boundary(mesh, &go_on).unwrap(), SurfaceDistance::to(mesh, from_corner, &go_on).unwrap()]
    }

    /// Slow twin: [`SurfaceDistance::at`] asks all lights, in the order of the edges. Places up to the sides and corners of each triangle.
    #[test]
    fn the_search_that_ends_early_finds_the_least_of_all_lights() {
        let mesh = saddles();
        let mut lights = TriangleLights::default();
        for distance in distances(&mesh) {
            for (triangle, corners) in (0..).zip(mesh.triangles()) {
                lights.load(&distance, triangle);
                for (i, j) in (0..=12_u32).flat_map(|i| (0..=12 - i).map(move |j| (i, j))) {
                    let shares = [12 - i - j, i, j].map(|k| f64::from(k) / 12.0);
                    let place = corners.iter().zip(shares);
                    let place = place.map(|(v, share)| mesh.vertices()[*v as usize].coords * share);
                    let (near, (all, slope)) = (distance.at(triangle, shares), {
                        let p = lights.flat(Point3::from(place.sum::<Vector3<f64>>()));
                        (lights.distance(p), lights.slope(p, [1.0, 0.0]).0)
                    });
                    assert!((near.distance - all).abs() < 1e-12 && (all - slope).abs() <= 0.0, "{near:?} {all}");
                }
            }
        }
    }

    #[test]
    fn along_an_edge_is_as_in_the_triangle() {
        let mesh = saddles();
        for distance in distances(&mesh) {
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
