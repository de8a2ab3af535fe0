//! Geodesic distance the slow way: every straight line from every source, over every sequence of triangles.
//!
//! A shortest path goes straight from a source edge (at a right angle), or from a source vertex, to a vertex, and on
//! from vertex to vertex. A straight part crosses no triangle twice. So all straight parts are found by following, from
//! each edge and vertex, the lines that can still be straight through all sequences of different triangles; nothing is
//! pruned. The rest is the shortest path in a graph of vertices.

use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Point2, Vector2};

/// From where lines start, laid flat.
#[derive(Clone, Copy)]
enum From {
    Point(Point2<f64>),
    /// A point of the edge's line and the unit normal.
    Edge(Point2<f64>, Vector2<f64>),
}

struct Search<'a> {
    mesh: &'a SurfaceMesh,
    from: From,
    used: Vec<bool>,
    /// The least straight distance to each vertex.
    found: Vec<f64>,
}

fn cross(a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

/// The third corner of a triangle with the given lengths to the ends of a laid-out side, on the left of it.
fn lay(a: Point2<f64>, b: Point2<f64>, from_a: f64, from_b: f64) -> Point2<f64> {
    let along = (b - a).norm();
    let x = (along * along + from_a * from_a - from_b * from_b) / (2.0 * along);
    let y = (from_a * from_a - x * x).max(0.0).sqrt();
    let u = (b - a) / along;
    a + u * x + Vector2::new(-u.y, u.x) * y
}

impl Search<'_> {
    fn length(&self, a: u32, b: u32) -> f64 {
        (self.mesh.vertices()[a as usize] - self.mesh.vertices()[b as usize]).norm()
    }

    fn direction(&self, to: Point2<f64>) -> Vector2<f64> {
        match self.from {
            From::Point(p) => to - p,
            From::Edge(_, normal) => normal,
        }
    }

    fn distance(&self, to: Point2<f64>) -> f64 {
        match self.from {
            From::Point(p) => (to - p).norm(),
            From::Edge(p, normal) => (to - p).dot(&normal),
        }
    }

    /// Lines that pass between two points (right and left) go on through an edge into the triangle ahead. Seen along
    /// the lines the edge runs from `a` on the left (laid at `pa`) to `b` on the right.
    fn follow(&mut self, [a, b]: [u32; 2], [pa, pb]: [Point2<f64>; 2], [right, left]: [Point2<f64>; 2]) {
        let Some((triangle, c)) = across(self.mesh, a, b) else { return };
        if self.used[triangle] {
            return;
        }
        let pc = lay(pa, pb, self.length(a, c), self.length(b, c));
        // Is the corner to the left of the right line, and to the right of the left one?
        let side = |p: Point2<f64>| match self.from {
            From::Point(_) => cross(self.direction(p), self.direction(pc)),
            From::Edge(_, normal) => cross(normal, pc - p),
        };
        let (of_right, of_left) = (side(right), side(left));
        let rounding = 1e-12 * (pb - pa).norm_squared();
        if of_right >= -rounding && of_left <= rounding {
            self.found[c as usize] = self.found[c as usize].min(self.distance(pc));
        }
        self.used[triangle] = true;
        if of_right > 0.0 {
            self.follow([c, b], [pc, pb], [right, if of_left < 0.0 { pc } else { left }]);
        }
        if of_left < 0.0 {
            self.follow([a, c], [pa, pc], [if of_right > 0.0 { pc } else { right }, left]);
        }
        self.used[triangle] = false;
    }
}

/// The triangle that runs from `a` to `b`, and its third corner.
fn across(mesh: &SurfaceMesh, a: u32, b: u32) -> Option<(usize, u32)> {
    mesh.triangles().iter().enumerate().find_map(|(number, t)| {
        let k = (0..3).find(|&k| t[k] == a && t[(k + 1) % 3] == b)?;
        Some((number, t[(k + 2) % 3]))
    })
}

/// All distances at vertices.
pub fn slow_distance(mesh: &SurfaceMesh, edges: &[[u32; 2]], vertices: &[u32]) -> Vec<f64> {
    let n = mesh.vertices().len();
    let search =
        |from: From| Search { mesh, from, used: vec![false; mesh.triangles().len()], found: vec![f64::INFINITY; n] };
    let mut distance = vec![f64::INFINITY; n];
    vertices.iter().chain(edges.iter().flatten()).for_each(|&v| distance[v as usize] = 0.0);
    for &[a, b] in edges {
        for [a, b] in [[a, b], [b, a]] {
            // The edge along x, with the triangle of this side above.
            let length = (mesh.vertices()[a as usize] - mesh.vertices()[b as usize]).norm();
            let (pa, pb) = (Point2::new(0.0, 0.0), Point2::new(length, 0.0));
            let mut search = search(From::Edge(pa, Vector2::new(0.0, 1.0)));
            search.follow([a, b], [pa, pb], [pb, pa]);
            distance.iter_mut().zip(&search.found).for_each(|(d, found)| *d = d.min(*found));
        }
    }
    // Straight distances from each vertex.
    let straight: Vec<Vec<f64>> = (0..n as u32)
        .map(|v| {
            let mut search = search(From::Point(Point2::origin()));
            for (number, t) in mesh.triangles().iter().enumerate() {
                let Some(k) = t.iter().position(|&corner| corner == v) else { continue };
                let (b, c) = (t[(k + 1) % 3], t[(k + 2) % 3]);
                let pb = Point2::new(search.length(v, b), 0.0);
                let pc = lay(Point2::origin(), pb, search.length(v, c), search.length(b, c));
                search.found[b as usize] = search.found[b as usize].min(search.length(v, b));
                search.found[c as usize] = search.found[c as usize].min(search.length(v, c));
                search.used[number] = true;
                search.follow([c, b], [pc, pb], [pb, pc]);
                search.used[number] = false;
            }
            search.found
        })
        .collect();
    // Shortest paths by relaxing until nothing changes.
    let mut changed = true;
    while changed {
        changed = false;
        for v in 0..n {
            for to in 0..n {
                if distance[v] + straight[v][to] < distance[to] - 1e-14 {
                    distance[to] = distance[v] + straight[v][to];
                    changed = true;
                }
            }
        }
    }
    distance
}
