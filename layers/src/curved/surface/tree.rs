//! A tree of boxes over the triangles of many surfaces, for rays that are short.

use super::spacing::SurfaceSlices;
use nalgebra::{Point3, Vector3};

/// Triangles in a leaf. Fewer make the tree deeper, more make rays look at triangles in vain.
const LEAF: usize = 4;

/// How far beyond its edge a triangle still counts, as a share of the triangle: a ray through an edge that two
/// triangles share meets at least one of them.
const OVERLAP: f64 = 1e-9;

/// Boxes over triangles.
pub(super) struct Tree {
    nodes: Vec<Node>,
    triangles: Vec<Triangle>,
}

struct Node {
    low: [f64; 3],
    high: [f64; 3],
    /// First triangle and how many in a leaf; in a branch the number of its second child (the first follows it), and 0.
    first: u32,
    count: u32,
}

#[derive(Clone, Copy)]
struct Triangle {
    corner: Point3<f64>,
    sides: [Vector3<f64>; 2],
    surface: u32,
}

/// What a ray met.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Hit {
    /// Distance to the neighbour that was asked for.
    pub(super) neighbour: Option<f64>,
    /// Whether another surface than the ray's own is near.
    pub(super) near: bool,
}

impl Tree {
    /// All triangles must name points that are there.
    pub(super) fn new(surfaces: &[SurfaceSlices]) -> Self {
        let mut triangles = Vec::new();
        for (surface, (points, of_surface)) in (0..).zip(surfaces) {
            triangles.extend(of_surface.iter().map(|t| {
                let [a, b, c] = t.map(|v| points[v as usize]);
                Triangle { corner: a, sides: [b - a, c - a], surface }
            }));
        }
        let mut tree = Tree { nodes: Vec::new(), triangles };
        let len = tree.triangles.len();
        if len > 0 {
            tree.build(0, len);
        }
        tree
    }

    fn build(&mut self, first: usize, end: usize) -> usize {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        let [mut least, mut most] = [low, high];
        for triangle in &self.triangles[first..end] {
            for corner in triangle.corners() {
                for k in 0..3 {
                    low[k] = low[k].min(corner[k]);
                    high[k] = high[k].max(corner[k]);
                }
            }
            for (k, c) in triangle.middle().into_iter().enumerate() {
                least[k] = least[k].min(c);
                most[k] = most[k].max(c);
            }
        }
        let at = self.nodes.len();
        self.nodes.push(Node { low, high, first: first as u32, count: (end - first) as u32 });
        if end - first > LEAF {
            let axis = (0..3).fold(0, |best, k| if most[k] - least[k] > most[best] - least[best] { k } else { best });
            let middle = (end - first) / 2;
            self.triangles[first..end]
                .select_nth_unstable_by(middle, |a, b| a.middle()[axis].total_cmp(&b.middle()[axis]));
            self.build(first, first + middle);
            let second = self.build(first + middle, end);
            self.nodes[at].first = second as u32;
            self.nodes[at].count = 0;
        }
        at
    }

    /// Follows a ray from `start`, a point of `own`, and looks for the surface `neighbour` within `reach` where its
    /// normal goes along `normal`, and for any other surface within `near`.
    #[allow(clippy::too_many_arguments)] // one question, asked in one place
    pub(super) fn cast(
        &self,
        start: Point3<f64>,
        direction: Vector3<f64>,
        normal: &Vector3<f64>,
        own: usize,
        neighbour: Option<usize>,
        reach: f64,
        near: f64,
    ) -> Hit {
        let inverse = direction.map(|d| 1.0 / d);
        let mut hit = Hit::default();
        if self.nodes.is_empty() {
            return hit;
        }
        // Triangles are halved on the way down: no tree of 2^32 of them is deeper.
        let (mut stack, mut waiting) = ([0; 33], 1);
        while waiting > 0 {
            waiting -= 1;
            let at = stack[waiting];
            let node = &self.nodes[at];
            let limit = if neighbour.is_none() { near } else { hit.neighbour.unwrap_or(reach).max(near) };
            if !node.meets(&start, &inverse, limit) {
                continue;
            }
            if node.count == 0 {
                stack[waiting] = node.first as usize;
                stack[waiting + 1] = at + 1;
                waiting += 2;
                continue;
            }
            for triangle in &self.triangles[node.first as usize..][..node.count as usize] {
                if triangle.surface as usize == own {
                    continue;
                }
                let Some(distance) = triangle.distance(&start, &direction) else { continue };
                hit.near |= distance < near;
                if Some(triangle.surface as usize) == neighbour
                    && distance < hit.neighbour.unwrap_or(reach)
                    && triangle.sides[0].cross(&triangle.sides[1]).dot(normal) > 0.0
                {
                    hit.neighbour = Some(distance);
                }
            }
        }
        hit
    }
}

impl Node {
    /// Whether a ray comes through the box within `limit`. Where it runs along a side, not-a-number is left out.
    fn meets(&self, start: &Point3<f64>, inverse: &Vector3<f64>, limit: f64) -> bool {
        let (mut enter, mut leave) = (0.0f64, limit);
        for k in 0..3 {
            let [a, b] = [self.low[k], self.high[k]].map(|side| (side - start[k]) * inverse[k]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter <= leave * (1.0 + 1e-12)
    }
}

impl Triangle {
    fn corners(&self) -> [Point3<f64>; 3] {
        [self.corner, self.corner + self.sides[0], self.corner + self.sides[1]]
    }

    fn middle(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| self.corner[k] + (self.sides[0][k] + self.sides[1][k]) / 3.0)
    }

    /// How far along the ray the triangle is met (Moller and Trumbore 1997).
    fn distance(&self, start: &Point3<f64>, direction: &Vector3<f64>) -> Option<f64> {
        let [e1, e2] = &self.sides;
        let across = direction.cross(e2);
        let det = e1.dot(&across);
        if det == 0.0 {
            return None;
        }
        let from = start - self.corner;
        let u = from.dot(&across) / det;
        let turned = from.cross(e1);
        let v = direction.dot(&turned) / det;
        let distance = e2.dot(&turned) / det;
        (u >= -OVERLAP && v >= -OVERLAP && u + v <= 1.0 + OVERLAP && distance >= 0.0).then_some(distance)
    }
}
