//! Rings by arc length, and points of the surface near a point in space.

use crate::level_set::Ring;
use crate::mesh::{SurfaceMesh, SurfacePoint, on_mesh_triangle};
use nalgebra::{Point3, Vector3};

/// Points of a ring nearer together than this share of its length count as one.
const SAME: f64 = 1e-12;

/// A closed ring by arc length. Places on it are lengths from its first point on, of any sign, and wrap around.
#[derive(Clone, Debug)]
pub(crate) struct Loop {
    points: Vec<SurfacePoint>,
    /// Arc length at each point, and that of the whole.
    starts: Vec<f64>,
    /// A ball around each `BLOCK` segments that follow each other: centre and radius.
    balls: Vec<(Point3<f64>, f64)>,
}

/// Segments in a ball: about the root of the number in a long ring.
const BLOCK: usize = 16;

impl Loop {
    /// `None` for a ring without length.
    pub fn new(ring: &Ring) -> Option<Self> {
        let whole = ring.length();
        let mut points: Vec<SurfacePoint> = Vec::with_capacity(ring.points.len());
        for point in &ring.points {
            match points.last_mut() {
                // Each segment lies in the triangle of its first point, so the later of two takes the place.
                Some(last) if (last.position - point.position).norm() <= SAME * whole => *last = *point,
                _ => points.push(*point),
            }
        }
        while points.len() > 1 && (points[points.len() - 1].position - points[0].position).norm() <= SAME * whole {
            points.pop();
        }
        if points.len() < 3 {
            return None;
        }
        let mut starts = Vec::with_capacity(points.len() + 1);
        let mut length = 0.0;
        for (k, point) in points.iter().enumerate() {
            starts.push(length);
            length += (points[(k + 1) % points.len()].position - point.position).norm();
        }
        starts.push(length);
        let ball = |from: usize| {
            let all = || (from..=(from + BLOCK).min(points.len())).map(|k| points[k % points.len()].position);
            let middle = Point3::from(all().fold(Vector3::zeros(), |sum, p| sum + p.coords) / all().count() as f64);
            (middle, all().map(|p| (p - middle).norm()).fold(0.0, f64::max))
        };
        let balls = (0..points.len()).step_by(BLOCK).map(ball).collect();
        Some(Loop { points, starts, balls })
    }

    pub fn length(&self) -> f64 {
        self.starts[self.points.len()]
    }

    /// The place within one round.
    pub fn wrapped(&self, place: f64) -> f64 {
        let rest = place.rem_euclid(self.length());
        if rest < self.length() { rest } else { 0.0 }
    }

    /// Number of the segment of a place, and the point there.
    fn segment(&self, place: f64) -> (usize, Point3<f64>) {
        let place = self.wrapped(place);
        let k = self.starts.partition_point(|&start| start <= place).clamp(1, self.points.len()) - 1;
        let [from, to] = [k, (k + 1) % self.points.len()].map(|k| self.points[k].position);
        let share = (place - self.starts[k]) / (self.starts[k + 1] - self.starts[k]);
        (k, from + (to - from) * share.clamp(0.0, 1.0))
    }

    /// The point at a place, in space.
    pub fn position(&self, place: f64) -> Point3<f64> {
        self.segment(place).1
    }

    /// The point at a place, on the surface.
    pub fn at(&self, mesh: &SurfaceMesh, place: f64) -> SurfacePoint {
        let (k, position) = self.segment(place);
        let triangle = self.points[k].triangle;
        let (_, barycentric) = on_mesh_triangle(mesh, triangle, position);
        SurfacePoint { triangle, barycentric, position }
    }

    /// A triangle at a place.
    pub fn triangle(&self, place: f64) -> u32 {
        self.points[self.segment(place).0].triangle
    }

    /// The place nearest to a point in space, and how near it is.
    pub fn nearest(&self, p: Point3<f64>) -> (f64, f64) {
        self.nearer(p, f64::INFINITY).unwrap_or((0.0, f64::INFINITY))
    }

    /// As [`Self::nearest`], if it is nearer than `most`.
    pub fn nearer(&self, p: Point3<f64>, most: f64) -> Option<(f64, f64)> {
        let mut best = (f64::NAN, most * most);
        // The nearest ball first, so that the others are ruled out early.
        let apart = |k: usize| (self.balls[k].0 - p).norm() - self.balls[k].1;
        let first = (0..self.balls.len()).min_by(|&a, &b| apart(a).total_cmp(&apart(b)))?;
        for block in [first].into_iter().chain((0..self.balls.len()).filter(|&k| k != first)) {
            let least = apart(block).max(0.0);
            // No point of the ball is nearer than the best so far.
            if least * least >= best.1 {
                continue;
            }
            for k in block * BLOCK..self.points.len().min((block + 1) * BLOCK) {
                let (from, to) = (self.points[k].position, self.points[(k + 1) % self.points.len()].position);
                let length = self.starts[k + 1] - self.starts[k];
                let share = ((p - from).dot(&(to - from)) / (length * length)).clamp(0.0, 1.0);
                let distance = (from + (to - from) * share - p).norm_squared();
                if distance < best.1 {
                    best = (self.starts[k] + share * length, distance);
                }
            }
        }
        (best.1 < most * most).then(|| (best.0, best.1.sqrt()))
    }

    /// The points from one place forward to another, both included: at most once around.
    pub fn forward(&self, mesh: &SurfaceMesh, from: f64, to: f64) -> Vec<SurfacePoint> {
        let (start, length) = (self.wrapped(from), self.wrapped(to - from));
        let mut points = vec![self.at(mesh, start)];
        // The first point behind the start; from there on at most one round.
        let first = self.starts[..self.points.len()].partition_point(|&s| s <= start);
        for step in 0..self.points.len() {
            let k = (first + step) % self.points.len();
            if self.wrapped(self.starts[k] - start) >= length {
                break;
            }
            points.push(self.points[k]);
        }
        points.push(self.at(mesh, to));
        points
    }

    /// What a cut leaves of the segments that come within a reach of a point in space, and some others.
    pub fn left(&self, mesh: &SurfaceMesh, cut: [f64; 2], p: Point3<f64>, reach: f64) -> Vec<[SurfacePoint; 2]> {
        let rest = self.length() - (cut[1] - cut[0]);
        let mut found = Vec::new();
        for block in (0..self.balls.len()).filter(|&k| (self.balls[k].0 - p).norm() <= self.balls[k].1 + reach) {
            for k in block * BLOCK..self.points.len().min((block + 1) * BLOCK) {
                // From the end of the cut on.
                let from = self.wrapped(self.starts[k] - cut[1]);
                let to = from + (self.starts[k + 1] - self.starts[k]);
                let parts = [[from, to.min(rest)], [self.length(), to]];
                for part in parts.into_iter().filter(|part| part[0] < part[1]) {
                    found.push(part.map(|place| self.at(mesh, cut[1] + place)));
                }
            }
        }
        found
    }

    /// All points, from the first one on.
    pub fn points(&self) -> &[SurfacePoint] {
        &self.points
    }
}

/// The point of the surface that is nearest to a point in space among those reached from a triangle by going ever
/// nearer. So sheets that lie close together in space are not mistaken for each other.
pub(super) fn locate(mesh: &SurfaceMesh, start: u32, p: Point3<f64>) -> SurfacePoint {
    let look = |triangle: u32| {
        let (position, barycentric) = on_mesh_triangle(mesh, triangle, p);
        ((position - p).norm_squared(), SurfacePoint { triangle, barycentric, position })
    };
    let mut best = look(start);
    loop {
        let mut better = best;
        for corner in mesh.triangles()[best.1.triangle as usize] {
            for h in mesh.fan(corner) {
                let seen = look(h / 3);
                if seen.0 < better.0 {
                    better = seen;
                }
            }
        }
        if better.0 < best.0 {
            best = better;
        } else {
            return best.1;
        }
    }
}
