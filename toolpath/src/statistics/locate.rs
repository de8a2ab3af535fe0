//! The point of the surface next to a point in space: a tree of boxes over the triangles.
//!
//! A tree of its own, beside that of `layer`: statistics judge paths, and share no code with what makes them.

use super::sheet::Sheet;
use nalgebra::Vector3;

/// Triangles in a leaf.
const LEAF: usize = 4;

struct Node {
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// Triangles `order[from..to]`; inner nodes have their first child next to them and the second at `second`.
    from: u32,
    to: u32,
    second: u32,
}

/// Finds nearest points.
pub(super) struct Locator<'s> {
    sheet: &'s Sheet,
    nodes: Vec<Node>,
    order: Vec<u32>,
}

/// A nearest point: its triangle, barycentric coordinates and distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub triangle: u32,
    pub weights: [f64; 3],
    pub distance: f64,
}

impl<'s> Locator<'s> {
    pub(super) fn new(sheet: &'s Sheet) -> Self {
        let mut order: Vec<u32> = (0..sheet.flats.len() as u32).collect();
        let mut locator = Locator { sheet, nodes: Vec::new(), order: Vec::new() };
        let middle = |&t: &u32| locator.corners(t).iter().map(|p| p / 3.0).sum::<Vector3<f64>>();
        let middles: Vec<Vector3<f64>> = order.iter().map(middle).collect();
        locator.build(&mut order, 0, &middles);
        locator.order = order;
        locator
    }

    fn corners(&self, triangle: u32) -> [Vector3<f64>; 3] {
        self.sheet.flats[triangle as usize].corners.map(|v| self.sheet.points[v as usize])
    }

    fn build(&mut self, order: &mut [u32], from: usize, middles: &[Vector3<f64>]) {
        let far = Vector3::repeat(f64::INFINITY);
        let (mut low, mut high) = (far, -far);
        for p in order.iter().flat_map(|&t| self.corners(t)) {
            (low, high) = (low.inf(&p), high.sup(&p));
        }
        let node = self.nodes.len();
        let to = (from + order.len()) as u32;
        self.nodes.push(Node { low, high, from: from as u32, to, second: 0 });
        if order.len() <= LEAF {
            return;
        }
        let axis = (high - low).imax();
        let middle = |t: u32| middles[t as usize][axis];
        let half = order.len() / 2;
        order.select_nth_unstable_by(half, |a, b| middle(*a).total_cmp(&middle(*b)).then(a.cmp(b)));
        let (first, second) = order.split_at_mut(half);
        self.build(first, from, middles);
        self.nodes[node].second = self.nodes.len() as u32;
        self.build(second, from + half, middles);
    }

    /// The nearest point within `reach`; among equals that of the lowest triangle.
    pub(super) fn nearest(&self, p: Vector3<f64>, reach: f64) -> Option<Near> {
        let mut best: Option<Near> = None;
        let mut waiting = vec![0u32];
        while let Some(number) = waiting.pop() {
            let node = &self.nodes[number as usize];
            let limit = best.map_or(reach, |near| near.distance);
            if beyond(node, p) > limit {
                continue;
            }
            if node.second == 0 {
                for &t in &self.order[node.from as usize..node.to as usize] {
                    let near = self.on_triangle(t, p);
                    let wins = best.is_none_or(|b| (near.distance, t) < (b.distance, b.triangle));
                    if near.distance <= reach && wins {
                        best = Some(near);
                    }
                }
            } else {
                let children = [number + 1, node.second];
                let nearer =
                    beyond(&self.nodes[children[0] as usize], p) <= beyond(&self.nodes[children[1] as usize], p);
                waiting.extend(if nearer { [children[1], children[0]] } else { children });
            }
        }
        best
    }

    /// The nearest point of one triangle. Coordinates are exactly zero where it lies on an edge or corner.
    pub(super) fn on_triangle(&self, triangle: u32, p: Vector3<f64>) -> Near {
        let flat = &self.sheet.flats[triangle as usize];
        let corners = self.corners(triangle);
        if flat.height > 0.0 {
            let from = p - flat.origin;
            let q = nalgebra::Vector2::new(from.dot(&flat.axes[0]), from.dot(&flat.axes[1]));
            let double_area = flat.base * flat.height;
            let weights = [1, 2, 0].map(|k| {
                let (a, b) = (flat.at[k], flat.at[(k + 1) % 3]);
                (b - a).perp(&(q - a)) / double_area
            });
            if weights.iter().all(|&w| w >= 0.0) {
                let off = from.dot(&flat.axes[0].cross(&flat.axes[1])).abs();
                return Near { triangle, weights, distance: off };
            }
        }
        let mut best = Near { triangle, weights: [1.0, 0.0, 0.0], distance: f64::INFINITY };
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let length = (b - a).norm_squared();
            let t = if length > 0.0 { ((p - a).dot(&(b - a)) / length).clamp(0.0, 1.0) } else { 0.0 };
            let distance = (a + (b - a) * t - p).norm();
            if distance < best.distance {
                let mut weights = [0.0; 3];
                (weights[k], weights[(k + 1) % 3]) = (1.0 - t, t);
                best = Near { triangle, weights, distance };
            }
        }
        best
    }
}

fn beyond(node: &Node, p: Vector3<f64>) -> f64 {
    (node.low - p).sup(&(p - node.high)).sup(&Vector3::zeros()).norm()
}
