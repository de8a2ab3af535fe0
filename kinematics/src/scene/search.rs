//! Two pieces against each other: both trees are walked down together, pairs of boxes that are far enough apart end it.

use super::bounds::Between;
use super::narrow::{self, Nearest};
use super::piece::{Node, Piece};
use super::rounding::GAP_MM;
use nalgebra::{Isometry3, Point3};

/// Two pieces at their places.
pub(super) struct Meeting<'a> {
    a: &'a Piece,
    b: &'a Piece,
    a_b: Isometry3<f64>,
    between: Between,
    /// What each is grown by, and both together.
    radii: [f64; 2],
    grown: f64,
}

/// The nearest points of two pieces so far, in the frame of the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    /// Zero when they touch or overlap.
    pub distance: f64,
    /// On the surfaces; none when they overlap.
    pub points: Option<[Point3<f64>; 2]>,
}

/// Space for the corners of one body in the frame of the other.
const BUFFER: usize = 32;

impl<'a> Meeting<'a> {
    pub fn new(a: &'a Piece, b: &'a Piece, a_b: Isometry3<f64>) -> Self {
        Meeting { a, b, a_b, between: Between::new(&a_b), radii: [a.radius, b.radius], grown: a.radius + b.radius }
    }

    /// The same with each piece thicker by so much.
    pub fn thicker(self, [a, b]: [f64; 2]) -> Self {
        let radii = [self.radii[0] + a, self.radii[1] + b];
        Meeting { radii, grown: radii[0] + radii[1], ..self }
    }

    /// Whether they are proven farther apart than `threshold`, which is not negative.
    pub fn apart(&self, threshold: f64) -> bool {
        let (Some(a), Some(b)) = (self.a.root(), self.b.root()) else { return true };
        self.nodes_apart(&a, &b, threshold + self.grown)
    }

    fn nodes_apart(&self, a: &Node, b: &Node, threshold: f64) -> bool {
        let (box_a, box_b) = (self.a.bounds(a), self.b.bounds(b));
        if self.between.gap(&box_a, &box_b, threshold + GAP_MM) > threshold + GAP_MM {
            return true;
        }
        match self.open(a, b, box_a.size() >= box_b.size()) {
            Open::First => {
                let (count, children) = self.a.children(a);
                children[..count].iter().all(|child| self.nodes_apart(child, b, threshold))
            }
            Open::Second => {
                let (count, children) = self.b.children(b);
                children[..count].iter().all(|child| self.nodes_apart(a, child, threshold))
            }
            Open::Neither => self.in_one_frame(a, b, |a, b, _| narrow::apart(a, b, threshold)),
        }
    }

    /// The larger of the two is opened first.
    fn open(&self, a: &Node, b: &Node, first_larger: bool) -> Open {
        match (self.a.is_leaf(a), self.b.is_leaf(b)) {
            (true, true) => Open::Neither,
            (true, false) => Open::Second,
            (false, true) => Open::First,
            (false, false) if first_larger => Open::First,
            (false, false) => Open::Second,
        }
    }

    /// Runs `ask` with the corners of two leaves in one frame: that of the first, or (`true`) that of the second. What
    /// has fewer corners is moved.
    fn in_one_frame<T>(&self, a: &Node, b: &Node, ask: impl Fn(&[Point3<f64>], &[Point3<f64>], bool) -> T) -> T {
        let (corners_a, corners_b) = (self.a.corners(a), self.b.corners(b));
        let (a, b) = (corners_a.points(), corners_b.points());
        let mut buffer = [Point3::origin(); BUFFER];
        let mut more = Vec::new();
        let (few, pose) = if a.len() < b.len() { (a, self.a_b.inverse()) } else { (b, self.a_b) };
        let (rotation, shift) = (pose.rotation.to_rotation_matrix(), pose.translation.vector);
        let moved = |point: &Point3<f64>| rotation * point + shift;
        let moved: &[Point3<f64>] = if few.len() <= BUFFER {
            for (to, from) in buffer.iter_mut().zip(few) {
                *to = moved(from);
            }
            &buffer[..few.len()]
        } else {
            more.extend(few.iter().map(moved));
            &more
        };
        if a.len() < b.len() { ask(moved, b, true) } else { ask(a, moved, false) }
    }

    /// Finds points nearer than those known.
    pub fn nearest(&self, best: f64) -> Option<Found> {
        let (a, b) = (self.a.root()?, self.b.root()?);
        let mut found = Found { distance: best, points: None };
        let gap = self.between.gap(&self.a.bounds(&a), &self.b.bounds(&b), f64::INFINITY);
        self.nodes_nearest(&a, &b, gap, &mut found);
        (found.distance < best).then_some(found)
    }

    fn nodes_nearest(&self, a: &Node, b: &Node, gap: f64, found: &mut Found) {
        if gap - self.grown - GAP_MM >= found.distance || found.distance <= 0.0 {
            return;
        }
        let first = match self.open(a, b, self.a.bounds(a).size() >= self.b.bounds(b).size()) {
            Open::Neither => return self.leaves_nearest(a, b, found),
            Open::First => true,
            Open::Second => false,
        };
        let (count, children) = if first { self.a.children(a) } else { self.b.children(b) };
        let mut order = [(f64::INFINITY, 0); 8];
        for (k, child) in children[..count].iter().enumerate() {
            let (a, b) = if first { (child, b) } else { (a, child) };
            order[k] = (self.between.gap(&self.a.bounds(a), &self.b.bounds(b), f64::INFINITY), k);
        }
        order[..count].sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        for &(gap, k) in &order[..count] {
            let (a, b) = if first { (&children[k], b) } else { (a, &children[k]) };
            self.nodes_nearest(a, b, gap, found);
        }
    }

    fn leaves_nearest(&self, a: &Node, b: &Node, found: &mut Found) {
        let bound = found.distance + self.grown;
        let (nearest, second_frame) =
            self.in_one_frame(a, b, |a, b, second_frame| (narrow::nearest(a, b, bound), second_frame));
        let (p, q) = match nearest {
            Nearest::Beyond => return,
            Nearest::Overlap => return *found = Found { distance: 0.0, points: None },
            Nearest::At(p, q) if second_frame => (self.a_b * p, self.a_b * q),
            Nearest::At(p, q) => (p, q),
        };
        let apart = q - p;
        let distance = apart.norm() - self.grown;
        if distance <= 0.0 {
            *found = Found { distance: 0.0, points: None };
        } else if distance < found.distance {
            let outward = apart / apart.norm();
            *found = Found { distance, points: Some([p + outward * self.radii[0], q - outward * self.radii[1]]) };
        }
    }
}

enum Open {
    First,
    Second,
    Neither,
}
