//! A tree of boxes over the triangles of many surfaces, for short lines across them.

use super::spacing::SurfaceSlices;
use nalgebra::{Point3, Vector3};

/// Triangles in a leaf. Fewer make the tree deeper, more make lines look at triangles in vain.
const LEAF: usize = 4;

/// How far beyond its edge a triangle still counts, as a share of the triangle: a line through an edge that two
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

/// What a line met. Distances are not negative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Hits {
    /// Distance along the line to the next surface.
    pub(super) above: Option<f64>,
    /// Distance against it to the surface before.
    pub(super) below: Option<f64>,
    /// Whether another surface than the line's own is near.
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

    /// Follows a line both ways from `start`, a point of the surface `own`, and looks for the surfaces before and after
    /// it within `reach`, below and above, where their normals go along the line; and for any other surface within
    /// `near`. `normal` is the way of the line, one long.
    pub(super) fn cast(&self, start: Point3<f64>, normal: &Vector3<f64>, own: u32, reach: [f64; 2], near: f64) -> Hits {
        let inverse = normal.map(|d| 1.0 / d);
        let mut hits = Hits::default();
        if self.nodes.is_empty() {
            return hits;
        }
        let [mut below, mut above] = reach.map(|reach| reach.max(near));
        // Triangles are halved on the way down: no tree of 2^32 of them is deeper.
        let (mut stack, mut waiting) = ([0; 33], 1);
        while waiting > 0 {
            waiting -= 1;
            let at = stack[waiting];
            let node = &self.nodes[at];
            if !node.meets(&start, &inverse, -below, above) {
                continue;
            }
            if node.count == 0 {
                stack[waiting] = node.first as usize;
                stack[waiting + 1] = at + 1;
                waiting += 2;
                continue;
            }
            for triangle in &self.triangles[node.first as usize..][..node.count as usize] {
                if triangle.surface == own {
                    continue;
                }
                let Some(along) = triangle.place_along(&start, normal) else { continue };
                let distance = along.abs();
                hits.near |= distance < near;
                let faces = || triangle.sides[0].cross(&triangle.sides[1]).dot(normal) > 0.0;
                if triangle.surface == own + 1 && along >= 0.0 {
                    if distance < hits.above.unwrap_or(reach[1]) && faces() {
                        hits.above = Some(distance);
                        above = distance.max(near);
                    }
                } else if triangle.surface + 1 == own
                    && along <= 0.0
                    && distance < hits.below.unwrap_or(reach[0])
                    && faces()
                {
                    hits.below = Some(distance);
                    below = distance.max(near);
                }
            }
        }
        hits
    }
}

impl Node {
    /// Whether a line comes through the box between two places on it, as far as rounding allows. Where it runs along a
    /// side, not-a-number is left out.
    fn meets(&self, start: &Point3<f64>, inverse: &Vector3<f64>, from: f64, to: f64) -> bool {
        let (mut enter, mut leave) = (from, to);
        for k in 0..3 {
            let [a, b] = [self.low[k], self.high[k]].map(|side| (side - start[k]) * inverse[k]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter <= leave + 1e-12 * (to - from)
    }
}

impl Triangle {
    fn corners(&self) -> [Point3<f64>; 3] {
        [self.corner, self.corner + self.sides[0], self.corner + self.sides[1]]
    }

    fn middle(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| self.corner[k] + (self.sides[0][k] + self.sides[1][k]) / 3.0)
    }

    /// Where on the line the triangle is met (Moller and Trumbore 1997); less than 0 before its start.
    fn place_along(&self, start: &Point3<f64>, direction: &Vector3<f64>) -> Option<f64> {
        let [e1, e2] = &self.sides;
        let across = direction.cross(e2);
        let det = e1.dot(&across);
        let from = start - self.corner;
        let u = from.dot(&across) / det;
        // Where the line runs along the triangle, this is not a number or without end.
        if !(-OVERLAP..=1.0 + 2.0 * OVERLAP).contains(&u) {
            return None;
        }
        let turned = from.cross(e1);
        let v = direction.dot(&turned) / det;
        (v >= -OVERLAP && u + v <= 1.0 + OVERLAP).then(|| e2.dot(&turned) / det)
    }
}
