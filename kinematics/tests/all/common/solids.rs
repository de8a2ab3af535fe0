//! A slow and plain oracle: convex bodies by their faces, every face against every face.

use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_kinematics::scene::Shape;

type P = Point3<f64>;

/// A convex body: its faces (two corners the same for a line), outward planes, and the ball it is grown by.
#[derive(Clone, Debug)]
pub struct Solid {
    pub faces: Vec<[P; 3]>,
    pub planes: Vec<(Vector3<f64>, f64)>,
    pub radius: f64,
}

impl Solid {
    fn line(a: P, b: P, radius: f64) -> Self {
        Solid { faces: vec![[a, b, b]], planes: vec![], radius }
    }

    fn triangle(corners: [P; 3]) -> Self {
        Solid { faces: vec![corners], planes: vec![], radius: 0.0 }
    }

    /// The hull of points in general or any position that has a volume: every plane through three of them with all
    /// others on one side.
    fn hull(points: &[P], radius: f64) -> Self {
        let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
        let mut solid = Solid { faces: vec![], planes: vec![], radius };
        for i in 0..points.len() {
            for j in i + 1..points.len() {
                for k in j + 1..points.len() {
                    let normal = (points[j] - points[i]).cross(&(points[k] - points[i]));
                    if normal.norm() < 1e-9 * size * size {
                        continue;
                    }
                    let mut normal = normal.normalize();
                    let heights: Vec<f64> = points.iter().map(|p| normal.dot(&(p - points[i]))).collect();
                    let above = heights.iter().any(|&h| h > 1e-9 * size);
                    if above && heights.iter().any(|&h| h < -1e-9 * size) {
                        continue;
                    }
                    if above {
                        normal = -normal;
                    }
                    // Of a plane with more points, all triangles at the first one cover the face.
                    let first = heights.iter().position(|h| h.abs() <= 1e-9 * size).unwrap();
                    if first == i {
                        solid.faces.push([points[i], points[j], points[k]]);
                        solid.planes.push((normal, normal.dot(&points[i].coords)));
                    }
                }
            }
        }
        solid
    }

    pub fn all_of(shape: &Shape) -> Vec<Self> {
        match shape {
            Shape::Union(shapes) => shapes.iter().flat_map(Solid::all_of).collect(),
            Shape::Capsule { from, to, radius } => vec![Solid::line(*from, *to, *radius)],
            Shape::Hull { points, radius } => vec![Solid::hull(points, *radius)],
            Shape::Mesh { points, triangles } => {
                triangles.iter().map(|t| Solid::triangle(t.map(|k| points[k as usize]))).collect()
            }
            Shape::Cells { dims: [nx, ny, nz], rows, cell } => {
                let words = nx.div_ceil(64);
                let mut all = vec![];
                for (z, y, x) in (0..*nz).flat_map(|z| (0..*ny).flat_map(move |y| (0..*nx).map(move |x| (z, y, x)))) {
                    if rows[((y + ny * z) * words + x / 64) as usize] >> (x % 64) & 1 == 1 {
                        let at = |k: u32| {
                            let n = [x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)].map(f64::from);
                            Point3::from(n) * *cell
                        };
                        all.push(Solid::hull(&[0, 1, 2, 3, 4, 5, 6, 7].map(at), 0.0));
                    }
                }
                all
            }
        }
    }

    pub fn moved(&self, pose: &Isometry3<f64>) -> Self {
        let planes = self.planes.iter().map(|(n, h)| {
            let normal = pose * n;
            (normal, h + normal.dot(&pose.translation.vector))
        });
        Solid {
            faces: self.faces.iter().map(|face| face.map(|p| pose * p)).collect(),
            planes: planes.collect(),
            radius: self.radius,
        }
    }

    fn contains(&self, p: &P) -> bool {
        !self.planes.is_empty() && self.planes.iter().all(|(n, h)| n.dot(&p.coords) <= *h)
    }

    /// A ball around it.
    pub fn ball(&self) -> (P, f64) {
        let corners = self.faces.as_flattened();
        let center = Point3::from(corners.iter().map(|p| p.coords).sum::<Vector3<f64>>() / corners.len() as f64);
        (center, corners.iter().map(|p| (p - center).norm()).fold(0.0, f64::max) + self.radius)
    }

    /// The distance, 0 when they touch or overlap.
    pub fn distance(&self, other: &Solid) -> f64 {
        if self.contains(&other.faces[0][0]) || other.contains(&self.faces[0][0]) {
            return 0.0;
        }
        let mut least = f64::INFINITY;
        for a in &self.faces {
            for b in &other.faces {
                least = least.min(triangles(a, b));
            }
        }
        (least - self.radius - other.radius).max(0.0)
    }
}

fn triangles(a: &[P; 3], b: &[P; 3]) -> f64 {
    let mut least = f64::INFINITY;
    for i in 0..3 {
        let edge = [a[i], a[(i + 1) % 3]];
        let other = [b[i], b[(i + 1) % 3]];
        if pierces(&edge, b) || pierces(&other, a) {
            return 0.0;
        }
        for j in 0..3 {
            least = least.min(segments(&edge, &[b[j], b[(j + 1) % 3]]));
        }
        least = least.min(above(&a[i], b)).min(above(&b[i], a));
    }
    least
}

/// Whether a line crosses a triangle.
fn pierces([from, to]: &[P; 2], t: &[P; 3]) -> bool {
    let volume = |a: &P, b: &P, c: &P, d: &P| (b - a).cross(&(c - a)).dot(&(d - a));
    let (below, over) = (volume(&t[0], &t[1], &t[2], from), volume(&t[0], &t[1], &t[2], to));
    let sides = [0, 1, 2].map(|k| volume(from, to, &t[k], &t[(k + 1) % 3]));
    below * over < 0.0 && (sides.iter().all(|&v| v > 0.0) || sides.iter().all(|&v| v < 0.0))
}

/// The height of a point whose foot lies within a triangle.
fn above(p: &P, t: &[P; 3]) -> f64 {
    let normal = (t[1] - t[0]).cross(&(t[2] - t[0]));
    let within = |k: usize| normal.dot(&(t[(k + 1) % 3] - t[k]).cross(&(p - t[k]))) >= 0.0;
    if normal.norm() < 1e-12 || !(0..3).all(within) {
        return f64::INFINITY;
    }
    (normal.dot(&(p - t[0])) / normal.norm()).abs()
}

/// The distance of two lines with ends: of the crossing where there is one, else of an end.
fn segments(a: &[P; 2], b: &[P; 2]) -> f64 {
    let end = |p: &P, s: &[P; 2]| {
        let along = s[1] - s[0];
        let t = (p - s[0]).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        (p - (s[0] + along * t.clamp(0.0, 1.0))).norm()
    };
    let mut least = end(&a[0], b).min(end(&a[1], b)).min(end(&b[0], a)).min(end(&b[1], a));
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (uu, uv, vv, uw, vw) = (u.dot(&u), u.dot(&v), v.dot(&v), u.dot(&w), v.dot(&w));
    let det = uu * vv - uv * uv;
    if det > 1e-12 * uu * vv {
        let (s, t) = ((uv * vw - vv * uw) / det, (uu * vw - uv * uw) / det);
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            least = least.min((w + u * s - v * t).norm());
        }
    }
    least
}
