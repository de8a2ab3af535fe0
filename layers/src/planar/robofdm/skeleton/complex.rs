//! Triangles that are split and whose edges collapse, down to a graph.
//!
//! A vertex knows its triangles and its neighbours. A collapse may leave edges without triangles: where a tube has
//! lost its circumference only its axis remains.

use nalgebra::{Point3, Vector3};

/// Triangles and edges over points, all of which may vanish one by one.
pub(super) struct Complex {
    pub(super) points: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    alive: Vec<bool>,
    /// The living triangles of each vertex.
    around: Vec<Vec<u32>>,
    /// The neighbours of each vertex by rising number. A vertex that has collapsed has none.
    neighbours: Vec<Vec<u32>>,
}

impl Complex {
    pub(super) fn new(points: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        let mut complex = Self {
            points: points.to_vec(),
            triangles: Vec::new(),
            alive: Vec::new(),
            around: vec![Vec::new(); points.len()],
            neighbours: vec![Vec::new(); points.len()],
        };
        triangles.iter().for_each(|&corners| complex.add(corners));
        complex
    }

    fn add(&mut self, corners: [u32; 3]) {
        for k in 0..3 {
            self.around[corners[k] as usize].push(self.triangles.len() as u32);
            self.link(corners[k], corners[(k + 1) % 3]);
        }
        self.triangles.push(corners);
        self.alive.push(true);
    }

    fn link(&mut self, a: u32, b: u32) {
        for (a, b) in [(a, b), (b, a)] {
            if let Err(at) = self.neighbours[a as usize].binary_search(&b) {
                self.neighbours[a as usize].insert(at, b);
            }
        }
    }

    fn unlink(&mut self, a: u32, b: u32) {
        for (a, b) in [(a, b), (b, a)] {
            if let Ok(at) = self.neighbours[a as usize].binary_search(&b) {
                self.neighbours[a as usize].remove(at);
            }
        }
    }

    fn kill(&mut self, triangle: u32) {
        self.alive[triangle as usize] = false;
        for v in self.triangles[triangle as usize] {
            self.around[v as usize].retain(|&t| t != triangle);
        }
    }

    /// The living triangles.
    pub(super) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.triangles.iter().zip(&self.alive).filter(|&(_, &alive)| alive).map(|(&corners, _)| corners)
    }

    pub(super) fn neighbours(&self, v: u32) -> &[u32] {
        &self.neighbours[v as usize]
    }

    /// Whether the edge still is one.
    pub(super) fn is_edge(&self, a: u32, b: u32) -> bool {
        self.neighbours[a as usize].binary_search(&b).is_ok()
    }

    /// All edges, each once, by rising numbers.
    pub(super) fn edges(&self) -> impl Iterator<Item = [u32; 2]> {
        let of = |(a, list): (usize, &'_ Vec<u32>)| {
            list.iter().filter(move |&&b| a < b as usize).map(move |&b| [a as u32, b]).collect::<Vec<_>>()
        };
        self.neighbours.iter().enumerate().flat_map(of)
    }

    pub(super) fn length(&self, a: u32, b: u32) -> f64 {
        (self.points[a as usize] - self.points[b as usize]).norm()
    }

    /// The third corners of the triangles on an edge.
    pub(super) fn opposite(&self, a: u32, b: u32) -> Vec<u32> {
        let third = |&t: &u32| {
            let corners = self.triangles[t as usize];
            corners.contains(&b).then(|| corners.into_iter().find(|&v| v != a && v != b)).flatten()
        };
        self.around[a as usize].iter().filter_map(third).collect()
    }

    /// The link condition: the collapse of the edge changes no topology but that of its triangles.
    pub(super) fn is_collapsible(&self, a: u32, b: u32) -> bool {
        let opposite = self.opposite(a, b);
        let (na, nb) = (self.neighbours(a), self.neighbours(b));
        na.iter().filter(|v| nb.binary_search(v).is_ok()).all(|v| opposite.contains(v))
    }

    /// Whether the collapse of the edge leaves a closed surface: two triangles on it, the link condition, and more than a
    /// tetrahedron around.
    pub(super) fn is_collapsible_on_surface(&self, a: u32, b: u32) -> bool {
        let mut opposite = self.opposite(a, b);
        opposite.sort_unstable();
        opposite.dedup();
        opposite.len() == 2
            && self.around[a as usize].len() + self.around[b as usize].len() > 8
            && opposite.iter().all(|&v| self.around[v as usize].len() > 3)
            && self.is_collapsible(a, b)
    }

    /// Collapses `b` into `a`, which moves to `to`. Triangles that become edges, or double, vanish.
    pub(super) fn collapse(&mut self, a: u32, b: u32, to: Point3<f64>) {
        self.points[a as usize] = to;
        for triangle in std::mem::take(&mut self.around[b as usize]) {
            let corners = &mut self.triangles[triangle as usize];
            if corners.contains(&a) {
                self.kill(triangle);
                continue;
            }
            corners.iter_mut().filter(|v| **v == b).for_each(|v| *v = a);
            let (corners, twin) = (sorted(*corners), |t: &&u32| sorted(self.triangles[**t as usize]));
            if self.around[a as usize].iter().any(|t| twin(&t) == corners) {
                self.kill(triangle);
            } else {
                self.around[a as usize].push(triangle);
            }
        }
        for v in self.neighbours[b as usize].clone() {
            self.unlink(b, v);
            if v != a {
                self.link(a, v);
            }
        }
    }

    /// Puts a new vertex on an edge; each of its triangles becomes two.
    pub(super) fn split(&mut self, a: u32, b: u32, at: Point3<f64>) -> u32 {
        let new = self.points.len() as u32;
        self.points.push(at);
        self.around.push(Vec::new());
        self.neighbours.push(Vec::new());
        let on_edge = |&&t: &&u32| self.triangles[t as usize].contains(&b);
        let cut: Vec<u32> = self.around[a as usize].iter().filter(on_edge).copied().collect();
        self.unlink(a, b);
        for triangle in cut {
            let corners = self.triangles[triangle as usize];
            self.kill(triangle);
            self.add(corners.map(|v| if v == b { new } else { v }));
            self.add(corners.map(|v| if v == a { new } else { v }));
        }
        new
    }

    /// Area of all living triangles.
    pub(super) fn area(&self) -> f64 {
        self.triangles().map(|corners| self.area_vector(corners).norm()).sum()
    }

    fn area_vector(&self, corners: [u32; 3]) -> Vector3<f64> {
        let [a, b, c] = corners.map(|v| self.points[v as usize]);
        (b - a).cross(&(c - a)) / 2.0
    }
}

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_has_six_edges_and_none_that_may_collapse() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from);
        let complex = Complex::new(&points, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
        let edges: Vec<_> = complex.edges().collect();
        assert_eq!(edges, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
        assert!(edges.iter().all(|&[a, b]| !complex.is_collapsible_on_surface(a, b)));
    }

    /// Two pyramids base to base: a tip may go to a corner of the base, which leaves more than a tetrahedron there, and no corner to another one.
    #[test]
    fn tips_of_two_pyramids_may_collapse() {
        let turn = |k: u32| f64::from(k) * std::f64::consts::FRAC_PI_3;
        let base = (0..6).map(|k| Point3::new(turn(k).cos(), turn(k).sin(), 0.0));
        let points: Vec<_> = base.chain([1.0, -1.0].map(|z| Point3::new(0.0, 0.0, z))).collect();
        let side = |k: u32| [[k, (k + 1) % 6, 6], [(k + 1) % 6, k, 7]];
        let complex = Complex::new(&points, &(0..6).flat_map(side).collect::<Vec<_>>());
        assert!((0..6).all(|k| complex.is_collapsible_on_surface(k, 6) && complex.is_collapsible_on_surface(7, k)));
        assert!((0..6).all(|k| !complex.is_collapsible_on_surface(k, (k + 1) % 6)));
    }
}
