//! Balls of one body in balls in balls, and the one that is nearest to the surface of a distance grid.

use super::Ball;
use super::grid::DistanceGrid;
use nalgebra::{IsometryMatrix3, Point3};

/// A ball about all that is below it, and either two nodes below or one ball of the body.
#[derive(Clone, Copy, Debug)]
struct Node {
    center: Point3<f64>,
    radius: f64,
    /// The first of two nodes below; 0 for a ball of the body.
    below: usize,
}

/// Balls of one body.
#[derive(Clone, Debug)]
pub(super) struct BallTree {
    body: usize,
    nodes: Vec<Node>,
}

/// Deeper trees than this would need more balls than there is memory.
const DEEPEST: usize = 64;

impl BallTree {
    /// At least one ball.
    pub fn new(body: usize, balls: &[Ball]) -> Self {
        let mut balls = balls.to_vec();
        let empty = Node { center: Point3::origin(), radius: 0.0, below: 0 };
        let mut tree = BallTree { body, nodes: vec![empty] };
        let mut open = vec![(0, 0..balls.len())];
        while let Some((node, range)) = open.pop() {
            let some = &mut balls[range.clone()];
            if let [ball] = some {
                tree.nodes[node] = Node { center: ball.center, radius: ball.radius, below: 0 };
                continue;
            }
            let low = some.iter().fold(Point3::from([f64::INFINITY; 3]), |a, b| a.inf(&b.center));
            let high = some.iter().fold(Point3::from([f64::NEG_INFINITY; 3]), |a, b| a.sup(&b.center));
            let center = nalgebra::center(&low, &high);
            let radius = some.iter().map(|ball| (ball.center - center).norm() + ball.radius).fold(0.0, f64::max);
            let axis = (high - low).imax();
            let middle = some.len() / 2;
            some.select_nth_unstable_by(middle, |a, b| a.center[axis].total_cmp(&b.center[axis]));
            let below = tree.nodes.len();
            tree.nodes[node] = Node { center, radius, below };
            tree.nodes.extend([empty; 2]);
            open.push((below, range.start..range.start + middle));
            open.push((below + 1, range.start + middle..range.end));
        }
        tree
    }

    pub fn body(&self) -> usize {
        self.body
    }

    /// The least distance between a ball and the solid of `field`, if it is below `best`, and the ball's centre in the
    /// frame of the field.
    pub fn nearest(
        &self,
        field: &DistanceGrid,
        field_body: &IsometryMatrix3<f64>,
        mut best: f64,
    ) -> Option<(f64, Point3<f64>)> {
        // All balls below a node are within its radius. The field may be wrong at both places.
        let slack = 2.0 * field.error_bound();
        let ask = |node: usize| {
            let Node { center, radius, .. } = &self.nodes[node];
            let at = field_body * center;
            (field.distance(&at) - radius, node, at)
        };
        let mut found = None;
        let mut open = [(f64::INFINITY, 0, Point3::origin()); DEEPEST];
        let mut count = 1;
        open[0] = ask(0);
        while count > 0 {
            count -= 1;
            let (distance, node, at) = open[count];
            let below = self.nodes[node].below;
            if below == 0 {
                if distance < best {
                    (best, found) = (distance, Some((distance, at)));
                }
            } else if distance - slack < best {
                let (a, b) = (ask(below), ask(below + 1));
                // The nearer one is looked at first.
                let [first, second] = if a.0 <= b.0 { [b, a] } else { [a, b] };
                (open[count], open[count + 1]) = (first, second);
                count += 2;
            }
        }
        found
    }
}
