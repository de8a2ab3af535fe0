//! A tree of boxes over triangles, built once for many questions.
//!
//! Halved at the median of the middles along the longest axis; nodes stand in the order of a walk that goes down first,
//! each with the number of the node after its last descendant, so that a search needs no stack.

use nalgebra::{Point3, Vector3};

/// Triangles in a leaf. Fewer cost visits, more cost tests; flat between 2 and 8.
const LEAF: usize = 4;

/// Halves of so many triangles grow at the same time.
const LARGE: usize = 1 << 14;

/// By this share of the size of all, a line may pass a box and still come through it: where it runs along a side, rounding
/// would decide.
pub(crate) const ROOM: f64 = 1e-9;

/// A box: its least and greatest corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) low: Point3<f64>,
    pub(crate) high: Point3<f64>,
}

impl Bounds {
    pub(crate) fn of<'a>(points: impl IntoIterator<Item = &'a Point3<f64>>) -> Bounds {
        let none = Point3::from([f64::INFINITY; 3]);
        let empty = Bounds { low: none, high: -none };
        points.into_iter().fold(empty, |all, p| Bounds { low: all.low.inf(p), high: all.high.sup(p) })
    }

    /// Whether two boxes share a point.
    pub(crate) fn meets(&self, other: &Bounds) -> bool {
        // All six at once: which one decides is hard to guess for a processor.
        (0..3).fold(true, |meets, k| meets & (self.low[k] <= other.high[k]) & (other.low[k] <= self.high[k]))
    }

    /// Whether a line comes through the box, made larger by `room`, between two places on it.
    fn is_passed(&self, line: &Line, between: [f64; 2], room: f64) -> bool {
        let [enter, leave] = self.passage(line, between, room);
        enter <= leave
    }

    /// Between which places a line is in the box, made larger by `room`, of those between two; the first is beyond the second if it does not come through. A box that
    /// is in another one, with no more room, has its places between those of that one: rounding does not change that.
    pub(crate) fn passage(&self, line: &Line, [from, to]: [f64; 2], room: f64) -> [f64; 2] {
        let (mut enter, mut leave) = (from, to);
        for k in 0..3 {
            let sides = [self.low[k] - room, self.high[k] + room];
            let back = usize::from(line.is_back[k]);
            let near = (sides[back] - line.start[k]) * line.inverse[k];
            let far = (sides[1 - back] - line.start[k]) * line.inverse[k];
            // Where the line runs along a side, not-a-number is left out.
            enter = if near > enter { near } else { enter };
            leave = if far < leave { far } else { leave };
        }
        [enter, leave]
    }

    /// The longest of its sides.
    pub(crate) fn size(&self) -> f64 {
        (self.high - self.low).max()
    }

    fn distance_sq(&self, p: &Point3<f64>) -> f64 {
        let beyond = |k: usize| (self.low[k] - p[k]).max(p[k] - self.high[k]).max(0.0);
        (0..3).map(|k| beyond(k) * beyond(k)).sum()
    }
}

/// A line that boxes are looked up along.
pub(crate) struct Line {
    start: Point3<f64>,
    /// One over its direction.
    inverse: Vector3<f64>,
    /// Along which axes it runs back: it enters boxes at their greatest corner there.
    is_back: [bool; 3],
}

impl Line {
    pub(crate) fn new(start: &Point3<f64>, direction: &Vector3<f64>) -> Line {
        let inverse = direction.map(|d| 1.0 / d);
        Line { start: *start, inverse, is_back: [0, 1, 2].map(|k| inverse[k] < 0.0) }
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// The node after its last descendant.
    next: u32,
    /// Its triangles in `Tree::order`, if it is a leaf; else none.
    first: u32,
    count: u32,
}

#[derive(Debug)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    /// The triangles, leaf after leaf, and their boxes.
    order: Vec<u32>,
    boxes: Vec<Bounds>,
}

impl Tree {
    /// `boxes` are those of the triangles.
    pub(crate) fn new(boxes: Vec<Bounds>) -> Tree {
        let tree = Tree::for_lines(&boxes);
        Tree { boxes: ordered(boxes, tree.order.clone()), ..tree }
    }

    /// A tree that does not keep the boxes of the triangles: for all questions but [`Tree::meeting`].
    pub(crate) fn for_lines(boxes: &[Bounds]) -> Tree {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let node = Node { bounds: Bounds::of([]), next: 0, first: 0, count: 0 };
        let mut nodes = vec![node; count_nodes(boxes.len())];
        grow(&mut nodes, 0, boxes, &mut order, 0);
        Tree { nodes, order, boxes: Vec::new() }
    }

    pub(crate) fn bounds(&self) -> &Bounds {
        &self.nodes[0].bounds
    }

    /// Hands over the triangles whose box meets a box, touching included.
    pub(crate) fn meeting(&self, bounds: &Bounds, mut take: impl FnMut(u32)) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if node.bounds.meets(bounds) {
                let leaf = node.first as usize..(node.first + node.count) as usize;
                let meeting = leaf.filter(|&place| self.boxes[place].meets(bounds));
                meeting.for_each(|place| take(self.order[place]));
                at += 1;
            } else {
                at = node.next as usize;
            }
        }
    }

    /// The triangles, leaf after leaf.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Hands over the places in [`Tree::order`] of the triangles in the leaves that a line from `start` comes through, as
    /// far against its direction and along it as `reach` says; `take` may shorten it.
    pub(crate) fn along(
        &self,
        start: &Point3<f64>,
        direction: &Vector3<f64>,
        mut reach: [f64; 2],
        mut take: impl FnMut(usize, &mut [f64; 2]),
    ) {
        let line = Line::new(start, direction);
        let size = self.nodes.first().map_or(0.0, |root| root.bounds.size());
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if node.bounds.is_passed(&line, [-reach[0], reach[1]], ROOM * size) {
                (node.first..node.first + node.count).for_each(|place| take(place as usize, &mut reach));
                at += 1;
            } else {
                at = node.next as usize;
            }
        }
    }

    /// Least of the squared distances that `distance_sq` gives for the triangles, or `bound` if that is smaller.
    pub(crate) fn nearest_sq(&self, p: &Point3<f64>, bound: f64, distance_sq: impl Fn(u32) -> f64) -> f64 {
        let (mut best, mut at) = (bound, 0);
        while let Some(node) = self.nodes.get(at) {
            if node.bounds.distance_sq(p) < best {
                best = self.leaf(node).iter().map(|&triangle| distance_sq(triangle)).fold(best, f64::min);
                at += 1;
            } else {
                at = node.next as usize;
            }
        }
        best
    }

    /// For each node, those after it first: its children or its triangles, put together into one value.
    pub(crate) fn fold<T: Clone>(&self, leaf: impl Fn(&[u32]) -> T, join: impl Fn(&T, &T) -> T) -> Vec<T> {
        let mut values: Vec<Option<T>> = vec![None; self.nodes.len()];
        for (at, node) in self.nodes.iter().enumerate().rev() {
            let children = || {
                let right = self.nodes.get(at + 1)?.next as usize;
                Some(join(values.get(at + 1)?.as_ref()?, values.get(right)?.as_ref()?))
            };
            values[at] = if node.count > 0 { Some(leaf(self.leaf(node))) } else { children() };
        }
        values.into_iter().flatten().collect()
    }

    /// A walk over the nodes by number: `far` says whether a node is done with; if not, its triangles go to `near`.
    pub(crate) fn walk(&self, mut far: impl FnMut(usize) -> bool, mut near: impl FnMut(u32)) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if far(at) {
                at = node.next as usize;
            } else {
                self.leaf(node).iter().for_each(|&triangle| near(triangle));
                at += 1;
            }
        }
    }

    fn leaf(&self, node: &Node) -> &[u32] {
        &self.order[node.first as usize..(node.first + node.count) as usize]
    }
}

/// The items that stand at the places `from`, in that order. Nothing is copied: each cycle of places passes its items on by swaps.
fn ordered<T>(mut items: Vec<T>, mut from: Vec<u32>) -> Vec<T> {
    for start in 0..from.len() {
        let mut at = start;
        loop {
            let next = std::mem::replace(&mut from[at], at as u32) as usize;
            if next == start {
                break;
            }
            items.swap(at, next);
            at = next;
        }
    }
    items
}

/// How many nodes a tree over so many triangles has, whatever these are.
fn count_nodes(triangles: usize) -> usize {
    let half = triangles / 2;
    if triangles <= LEAF { 1 } else { 1 + count_nodes(half) + count_nodes(triangles - half) }
}

/// The nodes over `order`, whose triangles stand in the tree's from `first` on; the first node gets the number `at`.
fn grow(nodes: &mut [Node], at: usize, boxes: &[Bounds], order: &mut [u32], first: usize) {
    let corners = order.iter().flat_map(|&triangle| {
        let bounds = &boxes[triangle as usize];
        [&bounds.low, &bounds.high]
    });
    let leaf = order.len() <= LEAF;
    let count = if leaf { order.len() as u32 } else { 0 };
    nodes[0] = Node { bounds: Bounds::of(corners), next: (at + nodes.len()) as u32, first: first as u32, count };
    if leaf {
        return;
    }
    let middle = |triangle: u32| {
        let bounds = &boxes[triangle as usize];
        Point3::from(bounds.low.coords + bounds.high.coords)
    };
    let middles: Vec<_> = order.iter().map(|&triangle| middle(triangle)).collect();
    let spread = Bounds::of(&middles);
    drop(middles);
    let axis = (spread.high - spread.low).imax();
    let half = order.len() / 2;
    let key = |triangle: u32| middle(triangle)[axis];
    order.select_nth_unstable_by(half, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
    let (left, right) = order.split_at_mut(half);
    let (of_left, of_right) = nodes[1..].split_at_mut(count_nodes(half));
    let next = at + 1 + of_left.len();
    join(
        left.len() >= LARGE,
        || grow(of_left, at + 1, boxes, left, first),
        || grow(of_right, next, boxes, right, first + half),
    );
}

/// Does both; with the feature `rayon` at the same time, if they are large.
#[cfg_attr(not(feature = "rayon"), allow(unused_variables))]
fn join(large: bool, one: impl FnOnce() + Send, other: impl FnOnce() + Send) {
    #[cfg(feature = "rayon")]
    if large {
        rayon::join(one, other);
        return;
    }
    one();
    other();
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxes(ends: &[([f64; 3], [f64; 3])]) -> Vec<Bounds> {
        ends.iter()
            .map(|(at, size)| Bounds::of(&[Point3::from(*at), Point3::from(*at) + Vector3::from(*size)]))
            .collect()
    }

    proptest! {
        /// Slow twin: all boxes, one by one. Coordinates on a lattice, so that sides touch.
        #[test]
        fn meeting_are_all_boxes_that_share_a_point(
            ends in prop::collection::vec((prop::array::uniform3(0_i32..9), prop::array::uniform3(0_i32..4)), 1..60),
        ) {
            let real = |v: [i32; 3]| v.map(f64::from);
            let all = boxes(&ends.iter().map(|&(at, size)| (real(at), real(size))).collect::<Vec<_>>());
            let tree = Tree::new(all.clone());
            for one in &all {
                let mut found = Vec::new();
                tree.meeting(one, |k| found.push(k));
                found.sort_unstable();
                let shares = |other: &Bounds| (0..3).all(|k| one.low[k].max(other.low[k]) <= one.high[k].min(other.high[k]));
                prop_assert_eq!(found, (0..all.len() as u32).filter(|&k| shares(&all[k as usize])).collect::<Vec<_>>());
            }
        }

        /// Slow twin: places along the line, one by one. Also along axes, and along sides of boxes.
        #[test]
        fn along_a_line_are_all_boxes_that_have_a_place_on_it(
            ends in prop::collection::vec((prop::array::uniform3(-4_i32..4), prop::array::uniform3(0_i32..4)), 1..60),
            start in prop::array::uniform3(-4_i32..5),
            direction in prop::array::uniform3(-2_i32..3),
            reach in prop::array::uniform2(0.0_f64..6.0),
        ) {
            let real = |v: [i32; 3]| v.map(f64::from);
            let all = boxes(&ends.iter().map(|&(at, size)| (real(at), real(size))).collect::<Vec<_>>());
            let tree = Tree::for_lines(&all);
            let (start, direction) = (Point3::from(real(start)), Vector3::from(real(direction)));
            let mut found = vec![false; all.len()];
            tree.along(&start, &direction, reach, |place, _| found[tree.order()[place] as usize] = true);
            for step in 0..=100 {
                let place = start + direction * (-reach[0] + (reach[0] + reach[1]) * f64::from(step) / 100.0);
                for (k, bounds) in all.iter().enumerate() {
                    prop_assert!(found[k] || bounds.distance_sq(&place) > 0.0, "box {k} has {place}");
                }
            }
        }
    }
}
