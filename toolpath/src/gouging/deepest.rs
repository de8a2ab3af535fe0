//! Where a nozzle is deepest in what has been built.
//!
//! A layer is as thick as its spacing `s`: it reaches half of that to both sides of its surface along the normal, and ends
//! where the surface ends. A nozzle may enter it by a share `a` of `s`, from above, below and from the side. So it must not
//! touch what is left of the layer if a skin of `a s` is taken off: that is, points of the surface at least `a s` from its
//! boundary, moved along the normal by up to `(1/2 - a) s`. Looked at are three *sheets* of them: moved up, moved down, and
//! in place. Normals are those at vertices, so a sheet has no gaps over bent edges.
//!
//! The search for the worst point goes down the tree, box by box, and on into triangles, which it halves across their longest
//! side. A box or piece is passed over if none of its points can be worse than the worst so far: clearance
//! changes by no more than a point moves. Pieces smaller than [`PIECE`] layers, or a micrometre, are taken for their middle. So if nothing is
//! found, the nozzle is nowhere deeper than allowed plus that share of a layer; but between sheets, a quarter of a
//! layer apart, the edge of the tip may enter the side of a layer a twentieth of a layer more.
//!
//! Poses on one short way share one walk down the tree (`sweep`): each looks at what some of them may come near.

use super::nozzle::{Extent, Nozzle, NozzlePart, Sway};
use super::obstacle::Obstacle;
use crate::layer::{Keys, LayerStack, Node, Triangle, Walk};
use nalgebra::{Point3, UnitVector3, Vector3};

/// Radius in layer heights below which a piece of a triangle is taken for its middle: a hundredth of a millimetre or two.
/// A quarter layer is allowed, so a fiftieth is little. Less takes longer near contact, more proves less.
pub(super) const PIECE: f64 = 0.02;

/// The same in millimetres at least, so that layers of hardly any thickness are not cut up without end: what a layer of 0.05 mm has. No machine
/// places its tip more exactly.
const MIN_PIECE_MM: f64 = 1e-3;

/// A worse point counts if it is worse by this share: the search for a cut need not be exact. With 0.1 it takes a twentieth longer.
const ROUGH: f64 = 0.4;

/// Where a nozzle is deepest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// What it is in.
    pub obstacle: Obstacle,
    /// How deep it is in the layer, as thick as that is, or how far below the plate, in millimetres. Infinite where the
    /// block reaches down without end.
    pub depth: f64,
    /// Thickness of the layer there, in millimetres, or of the [mould](crate::layer::Mould::thickness); 0 for the plate.
    pub height: f64,
    /// Which part of the nozzle is deepest.
    pub part: NozzlePart,
    /// Where: a point of the layer less the skin that may be entered, or the lowest point of the nozzle. Where the block reaches
    /// down without end, a point of its lower edge.
    pub point: Point3<f64>,
}

/// What a nozzle must keep clear of.
pub(crate) struct Scene<'a> {
    pub stack: &'a LayerStack<'a>,
    /// When each triangle is built.
    pub keys: &'a Keys,
    pub nozzle: &'a Nozzle,
    /// Nothing may reach nearer to a plate at z = 0 than this; none without a plate.
    pub plate: Option<f64>,
}

/// A place of the nozzle's tip, and what is built by then.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stand {
    pub tip: Point3<f64>,
    /// Triangles with a key below this are there.
    pub before: u32,
    /// How deep the nozzle may be in a layer, as a share of its height.
    pub allowed: f64,
}

/// A point that is too near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Worst {
    pub point: Point3<f64>,
    /// Clearance less what it must be: below 0.
    pub lack: f64,
    /// Thickness of its layer, and which it is.
    pub height: f64,
    pub obstacle: Obstacle,
}

impl Worst {
    /// How deep the nozzle is in the thickened layer.
    pub fn depth(&self, allowed: f64) -> f64 {
        allowed * self.height - self.lack
    }
}

impl Stand {
    /// How far the sheets are from a surface of a layer of this height.
    pub fn offset(&self, height: f64) -> f64 {
        (0.5 - self.allowed).max(0.0) * height
    }

    /// The clearance that they must keep: none, or less than none where the nozzle may be more than half a layer deep.
    pub fn clearance(&self, height: f64) -> f64 {
        (0.5 - self.allowed).min(0.0) * height
    }
}

pub(super) struct Seeker<'a> {
    pub nozzle: &'a Nozzle,
    stack: &'a LayerStack<'a>,
    pub stand: Stand,
    direction: Vector3<f64>,
    rough: f64,
    worst: Option<Worst>,
    /// No clearance in excess of what is needed from here on is of interest.
    bound: f64,
    any: bool,
}

/// A triangle as the nozzle sees it.
struct Seen {
    middle: Point3<f64>,
    /// Height of the middle above the tip, and its distance from the axis.
    z: f64,
    rho: f64,
    to_corners: [Vector3<f64>; 3],
    /// How much higher the corners are than the middle, and how much farther out along the ray to it.
    in_plane: [[f64; 2]; 3],
}

impl Seeker<'_> {
    /// Height of a point above the tip, its distance from the axis, and the direction to it from there. On the axis that
    /// is nowhere: the distance grows whichever way one goes.
    pub fn place(&self, p: Point3<f64>) -> (f64, f64, Vector3<f64>) {
        let v = p - self.stand.tip;
        let z = v.dot(&self.direction);
        let across = v - self.direction * z;
        let rho = across.norm();
        (z, rho, if rho > 0.0 { across / rho } else { Vector3::zeros() })
    }

    /// No point of a triangle has less clearance than this.
    pub fn least(&self, corners: &[Point3<f64>; 3], sway: &Sway) -> f64 {
        let Seen { z, rho, in_plane, .. } = self.seen(corners);
        self.nozzle.least_over(z, rho, sway, in_plane)
    }

    fn seen(&self, corners: &[Point3<f64>; 3]) -> Seen {
        let middle = centroid(corners);
        let (z, rho, out) = self.place(middle);
        let to_corners = corners.map(|corner| corner - middle);
        let in_plane = to_corners.map(|v| [v.dot(&self.direction), v.dot(&out)]);
        Seen { middle, z, rho, to_corners, in_plane }
    }

    /// Nor any point of the sheets in a box, which are no higher than `top`. What nearly always decides is how high they are and how far out from the side of
    /// the cone, so these are bounded closely.
    pub fn least_in(&self, node: &Node, top: f64, sway: &Sway) -> f64 {
        let (z, rho, out) = self.place(node.middle);
        let offset = self.stand.offset(node.height);
        let extent = Extent {
            up: top - offset - z,
            down: node.half.dot(&self.direction.abs()),
            into_cone: node.reach(self.nozzle.inward_of_cone(&self.direction, &out)),
            inward: node.half.dot(&out.abs()),
        };
        self.nozzle.least_around(z, rho, sway, &extent) - offset
    }

    /// How far the sheets in a box are above the tip, at most: their clearance is no less than the opposite.
    pub fn top(&self, node: &Node) -> f64 {
        let middle = (node.middle - self.stand.tip).dot(&self.direction);
        middle + node.reach(self.direction) + self.stand.offset(node.height)
    }

    /// The square of the distance of a point of a triangle to the boundary of its layer, if it is near.
    fn to_rim(&self, p: Point3<f64>, triangle: &Triangle) -> f64 {
        let rims = &self.stack.rims[triangle.rims[0] as usize..triangle.rims[1] as usize];
        let squares = rims.iter().map(|[a, b]| {
            let along = b - a;
            let share = ((p - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (a + along * share - p).norm_squared()
        });
        squares.fold(f64::INFINITY, f64::min)
    }

    /// Looks for a worse point in a piece of a sheet of a triangle, `offset` from it along the normals; whether to stop.
    fn piece(&mut self, base: [Corner; 3], triangle: &Triangle, offset: f64) -> bool {
        let corners = base.map(|(corner, normal)| corner + normal * offset);
        let needed = self.stand.clearance(triangle.height);
        let Seen { middle, z, rho, to_corners, in_plane } = self.seen(&corners);
        let least = self.nozzle.least_over(z, rho, &Sway::default(), in_plane) - needed;
        // No point of the piece is worse than the worst so far.
        if least >= self.bound {
            return false;
        }
        let lack = self.nozzle.clearance(z, rho) - needed;
        // Most pieces that are looked at lie across the edge of the tip.
        if lack >= self.bound && self.nozzle.least_over_edges(z, rho, in_plane) - needed >= self.bound {
            return false;
        }
        let has_skin = match self.skin(&base, triangle) {
            Skin::All => return false,
            Skin::Middle => true,
            Skin::None => false,
        };
        if lack < self.bound && !has_skin {
            let (height, obstacle) = (triangle.height, Obstacle::of(triangle));
            self.worst = Some(Worst { point: middle, lack, height, obstacle });
            // A point that is worse by less than this is not looked for: the walk ends sooner.
            self.bound = lack * (1.0 + self.rough);
            if self.any {
                return true;
            }
        }
        let radius = to_corners.iter().map(Vector3::norm_squared).fold(0.0, f64::max).sqrt();
        if least >= self.bound || radius <= (PIECE * triangle.height).max(MIN_PIECE_MM) {
            return false;
        }
        let sides = [0, 1, 2].map(|k| (corners[(k + 1) % 3] - corners[k]).norm_squared());
        // Across its longest side, so that pieces do not become slim.
        let k = (1..3).fold(0, |longest, k| if sides[k] > sides[longest] { k } else { longest });
        let [from, to, tip] = [base[k], base[(k + 1) % 3], base[(k + 2) % 3]];
        let half = (nalgebra::center(&from.0, &to.0), (from.1 + to.1) / 2.0);
        self.piece([from, half, tip], triangle, offset) || self.piece([half, to, tip], triangle, offset)
    }

    /// How much of a piece is nearer to the boundary of the layer than the skin that may be entered from the side.
    fn skin(&self, base: &[Corner; 3], triangle: &Triangle) -> Skin {
        if triangle.rims[0] == triangle.rims[1] {
            return Skin::None;
        }
        let skin = self.stand.allowed.min(0.5) * triangle.height;
        let flat = base.map(|(corner, _)| corner);
        let foot = centroid(&flat);
        let to_rim = self.to_rim(foot, triangle).sqrt();
        let reach = flat.iter().map(|corner| (corner - foot).norm_squared()).fold(0.0, f64::max).sqrt();
        match to_rim {
            _ if to_rim + reach < skin => Skin::All,
            _ if to_rim < skin => Skin::Middle,
            _ => Skin::None,
        }
    }
}

/// What of a piece is skin: all, its middle at least, or not its middle.
enum Skin {
    All,
    Middle,
    None,
}

/// A corner of a piece, and the normal there.
type Corner = (Point3<f64>, Vector3<f64>);

fn centroid([a, b, c]: &[Point3<f64>; 3]) -> Point3<f64> {
    Point3::from((a.coords + b.coords + c.coords) / 3.0)
}

impl Walk for Seeker<'_> {
    fn bound(&self, node: &Node) -> f64 {
        // Most of what is built lies below the tip.
        let top = self.top(node);
        if -top >= self.bound {
            return f64::INFINITY;
        }
        self.least_in(node, top, &Sway::default())
    }

    fn matters(&self, bound: f64) -> bool {
        bound < self.bound
    }

    fn see(&mut self, triangle: &Triangle) -> bool {
        let offset = self.stand.offset(triangle.height);
        // Sheets are no farther than that from the triangle.
        if self.least(&triangle.corners, &Sway::default()) - offset >= self.bound {
            return false;
        }
        let normals = self.stack.corner_normals(triangle);
        let base = [0, 1, 2].map(|k| (triangle.corners[k], normals[k]));
        // The outer sheets first: where they are gouged the middle one is not asked.
        let sheets = if offset > 0.0 { &[1.0, -1.0, 0.0][..] } else { &[0.0] };
        sheets.iter().any(|side| self.piece(base, triangle, side * offset))
    }
}

impl<'a> Scene<'a> {
    /// The triangles of a stack, with these keys.
    pub fn new(stack: &'a LayerStack<'a>, keys: &'a Keys, nozzle: &'a Nozzle, plate: Option<f64>) -> Self {
        Scene { stack, keys, nozzle, plate }
    }

    fn seek(
        &self,
        stand: Stand,
        direction: &UnitVector3<f64>,
        rough: f64,
        any: bool,
        stack: &mut Vec<(f64, u32)>,
    ) -> Option<Worst> {
        let mut seeker = self.seeker(stand, direction, rough, any);
        self.stack.tree.walk(self.keys, stand.before, &mut seeker, stack);
        seeker.worst
    }

    pub(super) fn seeker(&self, stand: Stand, direction: &UnitVector3<f64>, rough: f64, any: bool) -> Seeker<'a> {
        let direction = direction.into_inner();
        Seeker { nozzle: self.nozzle, stack: self.stack, stand, direction, rough, worst: None, bound: 0.0, any }
    }

    /// As [`Scene::is_free`], at a pose on a way with no more built and the same allowed, given the triangles near it.
    pub fn is_free_of(&self, near: &[u32], stand: Stand, direction: &UnitVector3<f64>) -> bool {
        let mut seeker = self.seeker(stand, direction, 0.0, true);
        let triangles = self.stack.tree.triangles();
        let is_there = |t: &&u32| self.keys.of_triangle[**t as usize] < stand.before;
        self.above_plate(stand, direction) && !near.iter().filter(is_there).any(|&t| seeker.see(&triangles[t as usize]))
    }

    /// Whether the nozzle keeps off the plate all along a straight way on which its direction turns evenly: nothing in between is lower, or
    /// leans more than one of the ends, since directions up to a right angle from the upright make a convex cap.
    pub fn above_plate_along(&self, [from, to]: [(Stand, UnitVector3<f64>); 2]) -> bool {
        let lower = if from.0.tip.z < to.0.tip.z { from.0 } else { to.0 };
        let leaning = if from.1.z < to.1.z { from.1 } else { to.1 };
        self.above_plate(lower, &leaning)
    }

    /// A point that lacks clearance nearly as much as the worst one.
    pub fn bad(&self, stand: Stand, direction: &UnitVector3<f64>, stack: &mut Vec<(f64, u32)>) -> Option<Worst> {
        self.seek(stand, direction, ROUGH, false, stack)
    }

    /// The point that lacks most clearance.
    pub fn worst(&self, stand: Stand, direction: &UnitVector3<f64>, stack: &mut Vec<(f64, u32)>) -> Option<Worst> {
        self.seek(stand, direction, 0.0, false, stack)
    }

    /// Where the nozzle is deepest, if it is too deep: in a layer or below the plate, whichever is more.
    pub fn deepest(&self, stand: Stand, direction: &UnitVector3<f64>, stack: &mut Vec<(f64, u32)>) -> Option<Contact> {
        let in_layer = self.worst(stand, direction, stack).map(|worst| {
            let v = worst.point - stand.tip;
            let z = v.dot(direction);
            let part = self.nozzle.part(z, (v - direction.into_inner() * z).norm());
            let (obstacle, depth) = (worst.obstacle, worst.depth(stand.allowed));
            Contact { obstacle, depth, height: worst.height, part, point: worst.point }
        });
        if self.above_plate(stand, direction) {
            return in_layer;
        }
        let (depth, part) = self.nozzle.below_plate(self.over_plate(stand), direction.angle(&Vector3::z_axis()));
        let point = stand.tip + self.nozzle.lowest(direction, part);
        let below = Contact { obstacle: Obstacle::Plate, depth, height: 0.0, part, point };
        Some(in_layer.filter(|contact| contact.depth >= depth).unwrap_or(below))
    }

    /// Whether the nozzle is nowhere too deep.
    pub fn is_free(&self, stand: Stand, direction: &UnitVector3<f64>, stack: &mut Vec<(f64, u32)>) -> bool {
        self.above_plate(stand, direction) && self.seek(stand, direction, 0.0, true, stack).is_none()
    }

    /// How high the tip is over what nothing may reach below: the plate and the clearance over it, which is at most half the
    /// height of the tip, since layers may be thin.
    pub fn over_plate(&self, stand: Stand) -> f64 {
        let height = stand.tip.z;
        if height > 0.0 { (height - self.plate.unwrap_or(0.0)).max(height / 2.0) } else { height }
    }

    /// Whether nothing of the nozzle reaches below the plate, or into the clearance over it.
    pub fn above_plate(&self, stand: Stand, direction: &UnitVector3<f64>) -> bool {
        let leans = direction.angle(&Vector3::z_axis());
        self.plate.is_none() || self.nozzle.plate_lean(self.over_plate(stand)).is_some_and(|lean| leans <= lean + 1e-9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layer::BuiltLayer;

    /// The plate is asked at the lower end of a way and with the greater lean, whichever end has it.
    #[test]
    fn the_lower_end_of_a_way_and_the_greater_lean_keep_off_the_plate() {
        let vertices = [[0.0, 0.0, 5.0], [9.0, 0.0, 5.0], [0.0, 9.0, 5.0]].map(Point3::from);
        let layer = BuiltLayer { vertices: &vertices, triangles: &[[0, 1, 2]], spacing: &[0.4], curves: &[] };
        let (stack, nozzle) = (LayerStack::new(&[layer]).unwrap(), Nozzle::default());
        let scene = Scene::new(&stack, &stack.keys, &nozzle, Some(0.0));
        let end = |z: f64, lean: f64| {
            let stand = Stand { tip: Point3::new(0.0, 0.0, z), before: 1, allowed: 0.25 };
            (stand, UnitVector3::new_normalize(Vector3::new(lean, 0.0, 1.0)))
        };
        let is_above = |ends: [(f64, f64); 2]| {
            let both =
                [ends, [ends[1], ends[0]]].map(|ends| scene.above_plate_along(ends.map(|(z, lean)| end(z, lean))));
            assert_eq!(both[0], both[1]);
            both[0]
        };
        assert!(is_above([(0.1, 0.0), (9.0, 0.0)]) && !is_above([(-0.1, 0.0), (9.0, 0.0)]));
        // Leaning by one in two the rim of the tip is 0.18 mm lower.
        assert!(is_above([(0.3, 0.5), (0.3, 0.0)]) && !is_above([(0.1, 0.5), (0.1, 0.0)]));
        // The lean is that of another end than the lower one.
        assert!(!is_above([(0.1, 0.0), (9.0, 0.5)]));
    }
}
