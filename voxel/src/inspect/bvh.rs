//! A tree of boxes over triangles, for everything that asks "which triangles are near?".
//!
//! Each node is cut at the median of the box centres along the axis where they spread most, so the depth is the
//! logarithm of the number of boxes whatever they look like. Nodes lie in preorder: the first child of node `n` is
//! node `n + 1`. Ties between centres are decided by number, so the tree depends on nothing but its input.

use nalgebra::{Point3, Vector3};
use std::ops::{ControlFlow, Range};

/// Boxes in a leaf: fewer make the tree larger than what it sorts, more make each leaf dear to search.
const LEAF: usize = 4;

/// A box along the axes; its faces belong to it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aabb {
    pub(crate) low: [f64; 3],
    pub(crate) high: [f64; 3],
}

impl Aabb {
    /// The box around nothing.
    pub(crate) const EMPTY: Self = Aabb { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// The least box around `points`.
    pub(crate) fn around<'a>(points: impl IntoIterator<Item = &'a Point3<f64>>) -> Self {
        let mut around = Self::EMPTY;
        for point in points {
            for k in 0..3 {
                around.low[k] = around.low[k].min(point[k]);
                around.high[k] = around.high[k].max(point[k]);
            }
        }
        around
    }

    fn join(mut self, other: &Self) -> Self {
        for k in 0..3 {
            self.low[k] = self.low[k].min(other.low[k]);
            self.high[k] = self.high[k].max(other.high[k]);
        }
        self
    }

    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }

    /// Whether the ray from `point` along `direction` meets the box, but for rounding.
    pub(crate) fn meets_ray(&self, point: &Point3<f64>, direction: &Vector3<f64>) -> bool {
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for k in 0..3 {
            if direction[k] == 0.0 {
                if !(self.low[k]..=self.high[k]).contains(&point[k]) {
                    return false;
                }
            } else {
                let s = (self.low[k] - point[k]) / direction[k];
                let t = (self.high[k] - point[k]) / direction[k];
                (enter, leave) = (enter.max(s.min(t)), leave.min(s.max(t)));
            }
        }
        enter <= leave
    }

    /// Squared distance of `point` from the box, 0 inside.
    fn distance_squared(&self, point: &Point3<f64>) -> f64 {
        (0..3).map(|k| (self.low[k] - point[k]).max(point[k] - self.high[k]).max(0.0).powi(2)).sum()
    }
}

/// A tree over boxes, which keep the numbers of their places in the list that it was built from.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    /// The boxes and their numbers, leaf after leaf.
    items: Vec<(Aabb, u32)>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    /// First item of a leaf, second child of any other node.
    link: u32,
    /// Items below the node.
    count: u32,
}

impl Node {
    fn is_leaf(&self) -> bool {
        self.count as usize <= LEAF
    }
}

impl Bvh {
    /// Builds the tree in `O(n log n)`; there must be fewer than 2^31 boxes.
    pub(crate) fn new(boxes: impl Iterator<Item = Aabb>) -> Self {
        let items: Vec<_> = boxes.zip(0..).collect();
        let mut bvh = Bvh { nodes: Vec::with_capacity(items.len()), items };
        if !bvh.items.is_empty() {
            bvh.build(0..bvh.items.len());
        }
        bvh
    }

    fn build(&mut self, range: Range<usize>) {
        let at = self.nodes.len();
        let items = &mut self.items[range.clone()];
        let bounds = items.iter().fold(Aabb::EMPTY, |around, (item, _)| around.join(item));
        self.nodes.push(Node { bounds, link: range.start as u32, count: range.len() as u32 });
        if items.len() <= LEAF {
            return;
        }
        let twice_centre = |item: &Aabb, k: usize| item.low[k] + item.high[k];
        let mut centres = Aabb::EMPTY;
        for (item, _) in items.iter() {
            for k in 0..3 {
                centres.low[k] = centres.low[k].min(twice_centre(item, k));
                centres.high[k] = centres.high[k].max(twice_centre(item, k));
            }
        }
        let spread = |k: usize| centres.high[k] - centres.low[k];
        let axis = (1..3).fold(0, |best, k| if spread(k) > spread(best) { k } else { best });
        let half = items.len() / 2;
        items.select_nth_unstable_by(half, |(a, i), (b, j)| {
            twice_centre(a, axis).total_cmp(&twice_centre(b, axis)).then(i.cmp(j))
        });
        self.build(range.start..range.start + half);
        self.nodes[at].link = self.nodes.len() as u32;
        self.build(range.start + half..range.end);
    }

    fn leaf(&self, node: &Node) -> &[(Aabb, u32)] {
        &self.items[node.link as usize..][..node.count as usize]
    }

    /// Hands over the number of each box that `wanted` lets pass; `wanted` must let pass the boxes around those.
    pub(crate) fn search(&self, mut wanted: impl FnMut(&Aabb) -> bool, mut found: impl FnMut(u32)) {
        let mut stack = if self.nodes.is_empty() { Vec::new() } else { vec![0u32] };
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at as usize];
            if !wanted(&node.bounds) {
            } else if !node.is_leaf() {
                stack.extend([node.link, at + 1]);
            } else {
                for (item, number) in self.leaf(node) {
                    if wanted(item) {
                        found(*number);
                    }
                }
            }
        }
    }

    /// The number with the least distance and that distance, squared, where `distance_squared` of a number is never
    /// less than the distance of its box. Among equals the one that is found first.
    pub(crate) fn nearest(
        &self,
        point: &Point3<f64>,
        mut distance_squared: impl FnMut(u32) -> f64,
    ) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let root = self.nodes.first()?;
        let mut stack = vec![(0u32, root.bounds.distance_squared(point))];
        while let Some((at, bound)) = stack.pop() {
            if best.is_some_and(|(_, least)| bound >= least) {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.is_leaf() {
                for (item, number) in self.leaf(node) {
                    if best.is_some_and(|(_, least)| item.distance_squared(point) >= least) {
                        continue;
                    }
                    let distance = distance_squared(*number);
                    if best.is_none_or(|(_, least)| distance < least) {
                        best = Some((*number, distance));
                    }
                }
            } else {
                let child = |child: u32| (child, self.nodes[child as usize].bounds.distance_squared(point));
                let (first, second) = (child(at + 1), child(node.link));
                // The nearer child is put on top.
                stack.extend(if first.1 <= second.1 { [second, first] } else { [first, second] });
            }
        }
        best
    }

    /// Hands over each pair of boxes that overlap once, until the callback breaks.
    pub(crate) fn pairs(&self, mut found: impl FnMut(u32, u32) -> ControlFlow<()>) -> ControlFlow<()> {
        let mut stack = if self.nodes.is_empty() { Vec::new() } else { vec![(0u32, 0u32)] };
        while let Some((a, b)) = stack.pop() {
            let (first, second) = (&self.nodes[a as usize], &self.nodes[b as usize]);
            if a == b {
                if !first.is_leaf() {
                    stack.extend([(a + 1, first.link), (first.link, first.link), (a + 1, a + 1)]);
                    continue;
                }
                let leaf = self.leaf(first);
                for (k, (item, i)) in leaf.iter().enumerate() {
                    for (other, j) in &leaf[k + 1..] {
                        if item.overlaps(other) {
                            found(*i, *j)?;
                        }
                    }
                }
            } else if !first.bounds.overlaps(&second.bounds) {
            } else if first.is_leaf() && second.is_leaf() {
                for (item, i) in self.leaf(first) {
                    for (other, j) in self.leaf(second) {
                        if item.overlaps(other) {
                            found(*i, *j)?;
                        }
                    }
                }
            } else if first.count >= second.count {
                stack.extend([(a + 1, b), (first.link, b)]);
            } else {
                stack.extend([(a, b + 1), (a, second.link)]);
            }
        }
        ControlFlow::Continue(())
    }
}
