//! A tree of boxes over triangles, asked for what is built by a given time.
//!
//! Boxes are halved (`split`); the small ones know a slab around their triangles, too (`slab`). The *keys* of triangles (their layer, or a finer time at
//! which they are built) are kept beside the tree, with their range in each box: other keys need no other tree.

use super::slab::Slab;
use super::split::{Place, split};
use super::triangle::Triangle;
use crate::mesh::on_triangle;
use nalgebra::{Point3, Vector3};
use std::ops::Range;

/// Triangles in a leaf.
const LEAF: usize = 4;

/// Triangles in a box that has a slab, at most.
const IN_SLAB: usize = 1024;

/// What is this near to a box, as a share of it, touches it.
const EDGE: f64 = 1e-9;

/// Boxes on the way down, mostly: triangles are halved, or nearly.
const DEEPEST: usize = 40;

#[derive(Debug)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    triangles: Vec<Triangle>,
}

/// A box and what is in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub middle: Point3<f64>,
    pub half: Vector3<f64>,
    /// The thickest layer in it.
    pub height: f64,
    /// What the triangles are between, too.
    slab: Slab,
    /// First triangle and how many in a leaf; in a branch the number of its second child (the first follows it), and 0.
    first: u32,
    count: u32,
}

/// A number for each triangle, and its range in each box.
#[derive(Debug)]
pub(crate) struct Keys {
    pub of_triangle: Vec<u32>,
    /// Least and most in each box.
    of_node: Vec<[u32; 2]>,
}

/// The closest point of some triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    pub point: Point3<f64>,
    pub distance: f64,
    /// In the tree's order.
    pub triangle: usize,
}

impl Tree {
    pub fn new(triangles: Vec<Triangle>) -> Self {
        let mut tree = Tree { nodes: Vec::with_capacity(triangles.len()), triangles };
        let mut places: Vec<Place> = tree.triangles.iter().zip(0..).map(Place::new).collect();
        if !places.is_empty() {
            tree.build(&mut places, 0);
            let order = places.iter().map(|place| place.index).collect();
            drop(places);
            arrange(&mut tree.triangles, order);
            tree.bound();
        }
        tree
    }

    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// The nodes over `places`, whose triangles become those from `first` on; boxes come later.
    fn build(&mut self, places: &mut [Place], first: usize) {
        let at = self.nodes.len();
        let (zero, none) = (Point3::origin(), Vector3::zeros());
        let count = places.len();
        let slab = Slab::default();
        let node = Node { middle: zero, half: none, height: 0.0, slab, first: first as u32, count: count as u32 };
        self.nodes.push(node);
        if count <= LEAF {
            return;
        }
        let split = split(places);
        let (left, right) = places.split_at_mut(split);
        self.build(left, first);
        self.nodes[at].first = self.nodes.len() as u32;
        self.nodes[at].count = 0;
        self.build(right, first + split);
    }

    /// The boxes, from the leaves up: children stand behind their parents.
    fn bound(&mut self) {
        let mut corners = vec![[[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]; self.nodes.len()];
        for at in (0..self.nodes.len()).rev() {
            let mut height: f64 = 0.0;
            let [mut low, mut high] = corners[at];
            let mut take = |point: &[f64; 3]| {
                for k in 0..3 {
                    low[k] = low[k].min(point[k]);
                    high[k] = high[k].max(point[k]);
                }
            };
            let node = self.nodes[at];
            if node.count > 0 {
                for triangle in &self.triangles[node.range()] {
                    triangle.corners.iter().for_each(|c| take(&[c.x, c.y, c.z]));
                    height = height.max(triangle.height);
                }
            } else {
                for child in [at + 1, node.first as usize] {
                    corners[child].iter().for_each(&mut take);
                    height = height.max(self.nodes[child].height);
                }
            }
            corners[at] = [low, high];
            let [low, high] = [Vector3::from(low), Vector3::from(high)];
            let half = (high - low) / 2.0;
            let node = &mut self.nodes[at];
            (node.middle, node.half, node.height) = (Point3::from((low + high) / 2.0), half, height);
        }
        self.slabs();
    }

    /// The slabs of boxes with few triangles: others hold surfaces in all directions.
    fn slabs(&mut self) {
        let mut ranges = vec![0..0; self.nodes.len()];
        for at in (0..self.nodes.len()).rev() {
            let node = &mut self.nodes[at];
            let range =
                if node.count > 0 { node.range() } else { ranges[at + 1].start..ranges[node.first as usize].end };
            if range.len() <= IN_SLAB {
                node.slab = Slab::new(&self.triangles[range.clone()], node.middle);
            }
            ranges[at] = range;
        }
    }

    /// The point closest to `p` within `reach` among the closest points of all triangles with a key in `keys` that are
    /// accepted. Of equally close ones the first in the tree counts.
    pub fn nearest(
        &self,
        by: &Keys,
        p: Point3<f64>,
        keys: Range<u32>,
        reach: f64,
        accept: impl Fn(Point3<f64>, &Triangle) -> bool,
    ) -> Option<Found> {
        let mut best: Option<Found> = None;
        let mut bound = reach * reach;
        let mut stack: Vec<(f64, u32)> = Vec::with_capacity(DEEPEST);
        let enter = |at: usize| {
            let [least, most] = by.of_node[at];
            (least < keys.end && most >= keys.start).then(|| self.nodes[at].distance_squared(p))
        };
        if !self.nodes.is_empty() {
            stack.extend(enter(0).map(|distance| (distance, 0)));
        }
        while let Some((distance, at)) = stack.pop() {
            if distance > bound {
                continue;
            }
            let node = &self.nodes[at as usize];
            for triangle in node.range() {
                if !keys.contains(&by.of_triangle[triangle]) {
                    continue;
                }
                let point = on_triangle(&self.triangles[triangle].corners, p);
                let distance = (point - p).norm_squared();
                let better = distance < bound || (distance <= bound && best.is_none_or(|b| triangle < b.triangle));
                if better && accept(point, &self.triangles[triangle]) {
                    bound = distance;
                    best = Some(Found { point, distance: distance.sqrt(), triangle });
                }
            }
            if node.count == 0 {
                let of_child = |child: u32| enter(child as usize).map(|d| (d, child));
                match (of_child(at + 1), of_child(node.first)) {
                    (Some(one), Some(other)) if one.0 < other.0 => stack.extend([other, one]),
                    (one, other) => stack.extend(one.into_iter().chain(other)),
                }
            }
        }
        best
    }

    /// Hands over all triangles with a key in `keys` that have a point within `reach` of `p`, in the tree's order.
    pub fn within(&self, by: &Keys, p: Point3<f64>, keys: Range<u32>, reach: f64, mut each: impl FnMut(usize)) {
        let bound = reach * reach;
        let mut stack: Vec<u32> = Vec::with_capacity(DEEPEST);
        stack.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(at) = stack.pop() {
            let (node, [least, most]) = (&self.nodes[at as usize], by.of_node[at as usize]);
            if least >= keys.end || most < keys.start || node.distance_squared(p) > bound {
                continue;
            }
            for triangle in node.range().filter(|&triangle| keys.contains(&by.of_triangle[triangle])) {
                if (on_triangle(&self.triangles[triangle].corners, p) - p).norm_squared() <= bound {
                    each(triangle);
                }
            }
            if node.count == 0 {
                stack.extend([node.first, at + 1]);
            }
        }
    }

    /// Walks down the tree to triangles with a key below `before`, boxes with a lower bound first. The order is always
    /// the same.
    pub fn walk(&self, by: &Keys, before: u32, state: &mut impl Walk, stack: &mut Vec<(f64, u32)>) {
        stack.clear();
        let there = |at: u32| by.of_node[at as usize][0] < before;
        if !self.nodes.is_empty() && there(0) {
            stack.push((state.bound(&self.nodes[0]), 0));
        }
        while let Some((bound, at)) = stack.pop() {
            if !state.matters(bound) {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count == 0 {
                let bound = |child: u32| {
                    if there(child) { state.bound(&self.nodes[child as usize]) } else { f64::INFINITY }
                };
                let (one, other) = ((bound(at + 1), at + 1), (bound(node.first), node.first));
                let (first, second) = if one.0 <= other.0 { (one, other) } else { (other, one) };
                stack.extend([second, first].into_iter().filter(|child| state.matters(child.0)));
                continue;
            }
            for triangle in node.range() {
                if by.of_triangle[triangle] < before && state.see(&self.triangles[triangle]) {
                    return;
                }
            }
        }
    }
}

impl Tree {
    /// Hands over all triangles with a key below `before` in boxes that are not passed over, with their numbers.
    pub fn each(&self, by: &Keys, before: u32, passes: impl Fn(&Node) -> bool, mut see: impl FnMut(u32, &Triangle)) {
        let mut open: Vec<u32> = Vec::with_capacity(DEEPEST);
        open.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(at) = open.pop() {
            let node = &self.nodes[at as usize];
            if by.of_node[at as usize][0] >= before || passes(node) {
                continue;
            }
            if node.count == 0 {
                open.extend([node.first, at + 1]);
            }
            for triangle in node.range().filter(|&triangle| by.of_triangle[triangle] < before) {
                see(triangle as u32, &self.triangles[triangle]);
            }
        }
    }
}

/// Puts at `k` what is at `order[k]`, along the cycles of the order: there is no second copy.
fn arrange(triangles: &mut [Triangle], mut order: Vec<u32>) {
    for start in 0..triangles.len() {
        let mut at = start;
        while order[at] as usize != start {
            let from = order[at] as usize;
            triangles.swap(at, from);
            order[at] = at as u32;
            at = from;
        }
        order[at] = at as u32;
    }
}

/// What a walk looks for.
pub(crate) trait Walk {
    /// No point of a box can be worth less than this.
    fn bound(&self, node: &Node) -> f64;
    /// Whether something worth that little still matters.
    fn matters(&self, bound: f64) -> bool;
    /// Looks at a triangle; whether to stop.
    fn see(&mut self, triangle: &Triangle) -> bool;
}

impl Node {
    /// Whether a straight way may meet the box.
    pub fn is_met_by(&self, from: Point3<f64>, way: Vector3<f64>) -> bool {
        let half = way * 0.5;
        let middle = from + half - self.middle;
        let extent = half.abs();
        // Boxes may be as flat as their triangles, so what touches them is in them.
        let apart = (0..3).any(|k| middle[k].abs() > (self.half[k] + extent[k]) * (1.0 + EDGE) + EDGE);
        let across = middle.cross(&half).abs();
        let aside = (0..3).any(|k| {
            let [i, j] = [(k + 1) % 3, (k + 2) % 3];
            let slack = EDGE * (1.0 + across[k]);
            across[k] > self.half[i] * extent[j] + self.half[j] * extent[i] + slack
        });
        !apart && !aside
    }

    /// How far the triangles reach from the middle along a vector, times its length.
    pub fn reach(&self, along: Vector3<f64>) -> f64 {
        self.half.dot(&along.abs()).min(self.slab.reach(along, self.half))
    }

    fn range(&self) -> Range<usize> {
        if self.count > 0 { self.first as usize..(self.first + self.count) as usize } else { 0..0 }
    }

    fn distance_squared(&self, p: Point3<f64>) -> f64 {
        let from = p - self.middle;
        (0..3).map(|k| (from[k].abs() - self.half[k]).max(0.0).powi(2)).sum()
    }
}

impl Keys {
    /// `of_triangle`: in the tree's order.
    pub fn new(tree: &Tree, of_triangle: Vec<u32>) -> Self {
        let mut of_node = vec![[u32::MAX, 0]; tree.nodes.len()];
        for at in (0..tree.nodes.len()).rev() {
            let node = &tree.nodes[at];
            let mut range = [u32::MAX, 0];
            let mut take = |[least, most]: [u32; 2]| range = [range[0].min(least), range[1].max(most)];
            if node.count > 0 {
                of_triangle[node.range()].iter().for_each(|&key| take([key; 2]));
            } else {
                [at + 1, node.first as usize].into_iter().for_each(|child| take(of_node[child]));
            }
            of_node[at] = range;
        }
        Keys { of_triangle, of_node }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn triangles_are_put_in_order_without_a_copy(order in Just((0..40_u32).collect::<Vec<_>>()).prop_shuffle()) {
            let corners = [Point3::origin(); 3];
            let triangle = |index| Triangle { corners, rims: [0; 2], height: 1.0, layer: 0, index };
            let mut triangles: Vec<Triangle> = (0..40).map(triangle).collect();
            arrange(&mut triangles, order.clone());
            prop_assert_eq!(triangles.iter().map(|triangle| triangle.index).collect::<Vec<_>>(), order);
        }
    }
}
