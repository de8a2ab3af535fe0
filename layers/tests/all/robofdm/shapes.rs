//! Solids made of unit cells: closed meshes without a mesher.

use curvlay_layers::nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;

#[derive(Clone, Debug)]
pub struct Shape {
    pub points: Vec<Point3<f64>>,
    pub triangles: Vec<[u32; 3]>,
}

/// The surface of all cells of `dims` for whose centre `distance` is below zero, smoothed and moved onto the zero of `distance`.
pub fn cells(dims: [i32; 3], distance: impl Fn(Vector3<f64>) -> f64) -> Shape {
    let is_cell = |c: [i32; 3]| {
        (0..3).all(|k| (0..dims[k]).contains(&c[k])) && distance(Vector3::from(c.map(|c| f64::from(c) + 0.5))) < 0.0
    };
    let mut number = BTreeMap::new();
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for x in 0..dims[0] {
        for y in 0..dims[1] {
            for z in 0..dims[2] {
                for k in 0..3 {
                    for ahead in [0, 1] {
                        let mut beyond = [x, y, z];
                        beyond[k] += 2 * ahead - 1;
                        if !is_cell([x, y, z]) || is_cell(beyond) {
                            continue;
                        }
                        let corner = |i: i32, j: i32| {
                            let mut c = [x, y, z];
                            c[k] += ahead;
                            c[(k + 1) % 3] += i;
                            c[(k + 2) % 3] += j;
                            c
                        };
                        let mut quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                        if ahead == 0 {
                            quad.reverse();
                        }
                        let quad = quad.map(|c| {
                            *number.entry(c).or_insert_with(|| {
                                points.push(Point3::from(c.map(f64::from)));
                                points.len() as u32 - 1
                            })
                        });
                        triangles.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
                    }
                }
            }
        }
    }
    let mut shape = Shape { points, triangles };
    (0..3).for_each(|_| shape.smooth());
    for p in &mut shape.points {
        for _ in 0..3 {
            let at = |k: usize, by: f64| distance(p.coords + Vector3::ith(k, by));
            let slope = Vector3::from([0, 1, 2].map(|k| (at(k, 1e-4) - at(k, -1e-4)) / 2e-4));
            *p -= slope * (distance(p.coords) / slope.norm_squared().max(0.1));
        }
    }
    shape
}

impl Shape {
    fn smooth(&mut self) {
        let mut sums = vec![(Vector3::zeros(), 0.0); self.points.len()];
        for t in &self.triangles {
            for k in 0..3 {
                let sum = &mut sums[t[k] as usize];
                sum.0 += self.points[t[(k + 1) % 3] as usize].coords;
                sum.1 += 1.0;
            }
        }
        self.points = sums.iter().map(|(sum, count)| Point3::from(sum / *count)).collect();
    }

    /// The middle of a facet.
    pub fn middle(&self, facet: usize) -> Vector3<f64> {
        self.triangles[facet].iter().map(|&v| self.points[v as usize].coords).sum::<Vector3<f64>>() / 3.0
    }
}

/// How far a point is from the segment between two others.
pub fn to_segment(p: Vector3<f64>, a: [f64; 3], b: [f64; 3]) -> f64 {
    let (a, b) = (Vector3::from(a), Vector3::from(b));
    let t = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
    (p - a - (b - a) * t).norm()
}

/// Balls of radius 6 at (7, 7, 7) and (37, 7, 7), a bar of radius 2 between them.
pub fn dumbbell() -> Shape {
    cells([44, 14, 14], |p| {
        let (a, b) = ([7.0; 3], [37.0, 7.0, 7.0]);
        let balls = (p - Vector3::from(a)).norm().min((p - Vector3::from(b)).norm()) - 6.0;
        balls.min(to_segment(p, a, b) - 2.1)
    })
}

/// A stem from (20, 4, 0) to (20, 4, 26) and a bar over it from x = 2 to 38, all round, of radius 3.
pub fn tee() -> Shape {
    cells([40, 8, 30], |p| {
        let bar = to_segment(p, [5.0, 4.0, 26.0], [35.0, 4.0, 26.0]);
        // The platform cuts the stem flat.
        bar.min(to_segment(p, [20.0, 4.0, -5.0], [20.0, 4.0, 26.0])).max(3.1 - p.z) - 3.1
    })
}

/// Three legs of radius 3 along the axes from (5, 5, 5).
pub fn tripod() -> Shape {
    let feet = [[26.0, 5.0, 5.0], [5.0, 26.0, 5.0], [5.0, 5.0, 26.0]];
    cells([30, 30, 30], |p| feet.iter().map(|&foot| to_segment(p, [5.0; 3], foot)).fold(f64::MAX, f64::min) - 3.1)
}

/// A ring of radius 12, 3 thick.
pub fn ring() -> Shape {
    cells([32, 32, 8], |p| {
        let d = p - Vector3::new(16.0, 16.0, 4.0);
        (d.xy().norm() - 12.0).hypot(d.z) - 3.1
    })
}
