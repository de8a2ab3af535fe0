//! A tree of boxes over things that are of a layer each. What is asked for goes down it, the most promising box first.

use nalgebra::{Point3, Vector3};
use std::ops::Range;

/// Things in a leaf.
const LEAF: usize = 4;

/// A thing by its box and its layer.
#[derive(Clone, Copy, Debug)]
pub struct Boxed {
    /// Lowest corner.
    pub low: Point3<f64>,
    /// Highest corner.
    pub high: Point3<f64>,
    /// The first and the last layer in it.
    pub ranks: [u32; 2],
}

impl Boxed {
    /// A box around points.
    pub fn around(points: &[Point3<f64>], rank: u32) -> Self {
        let start = [Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])];
        let [low, high] = points.iter().fold(start, |[low, high], at| [low.inf(at), high.sup(at)]);
        Boxed { low, high, ranks: [rank; 2] }
    }

    /// The middle.
    pub fn middle(&self) -> Point3<f64> {
        nalgebra::center(&self.low, &self.high)
    }

    /// From the middle to the highest corner.
    pub fn half(&self) -> Vector3<f64> {
        0.5 * (self.high - self.low)
    }

    /// Whether it may hold something of these layers.
    pub fn has(&self, ranks: &Range<u32>) -> bool {
        self.ranks[0] < ranks.end && self.ranks[1] >= ranks.start
    }

    fn join(&self, other: &Boxed) -> Boxed {
        let ranks = [self.ranks[0].min(other.ranks[0]), self.ranks[1].max(other.ranks[1])];
        Boxed { low: self.low.inf(&other.low), high: self.high.sup(&other.high), ranks }
    }
}

/// Something that is looked for.
pub trait Look {
    /// How good anything in a box can be at best: less is better, infinite is of no interest.
    fn bound(&self, of: &Boxed) -> f64;
    /// What is not better than this is passed over.
    fn limit(&self) -> f64;
    /// A thing by its number, whose box was better than the limit.
    fn see(&mut self, thing: usize);
}

struct Node {
    around: Boxed,
    /// Of a leaf the first thing in the order, of a branch the second child; the first child stands behind the branch.
    next: u32,
    /// Things of a leaf; 0 for a branch.
    count: u32,
}

/// The tree.
pub struct Boxes {
    nodes: Vec<Node>,
    order: Vec<u32>,
    things: Vec<Boxed>,
}

impl Boxes {
    /// A tree over things; they keep their numbers.
    pub fn new(things: Vec<Boxed>) -> Self {
        let mut order: Vec<u32> = (0..things.len() as u32).collect();
        let mut nodes = Vec::with_capacity(things.len());
        if !things.is_empty() {
            build(&things, &mut order, 0, &mut nodes);
        }
        Boxes { nodes, order, things }
    }

    /// Looks for something.
    pub fn look(&self, look: &mut impl Look) {
        let mut open: Vec<(f64, u32)> = Vec::with_capacity(64);
        open.extend(self.nodes.first().map(|root| (look.bound(&root.around), 0)));
        while let Some((bound, at)) = open.pop() {
            if bound >= look.limit() {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count > 0 {
                let first = node.next as usize;
                for &thing in &self.order[first..first + node.count as usize] {
                    if look.bound(&self.things[thing as usize]) < look.limit() {
                        look.see(thing as usize);
                    }
                }
                continue;
            }
            let mut children = [at + 1, node.next].map(|at| (look.bound(&self.nodes[at as usize].around), at));
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            open.extend(children.into_iter().filter(|(bound, _)| *bound < look.limit()));
        }
    }
}

/// Builds the nodes over a range of the order, which is halved along the longest side of the middles.
fn build(things: &[Boxed], order: &mut [u32], first: u32, nodes: &mut Vec<Node>) {
    let at = nodes.len();
    let around = order[1..].iter().fold(things[order[0] as usize], |sum, &thing| sum.join(&things[thing as usize]));
    if order.len() <= LEAF {
        nodes.push(Node { around, next: first, count: order.len() as u32 });
        return;
    }
    let middles: Vec<Point3<f64>> = Vec::from_iter(order.iter().map(|&thing| things[thing as usize].middle()));
    let of = Boxed::around(&middles, 0);
    let axis = (of.high - of.low).imax();
    let middle = |thing: u32| things[thing as usize].low[axis] + things[thing as usize].high[axis];
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
    nodes.push(Node { around, next: 0, count: 0 });
    let (left, right) = order.split_at_mut(half);
    build(things, left, first, nodes);
    nodes[at].next = nodes.len() as u32;
    build(things, right, first + half as u32, nodes);
}
