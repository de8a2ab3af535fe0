//! Volume of each part, and whether its faces look the right way.
//!
//! The solid is where the winding number is above zero. Crossing a closed part from outside to inside changes the
//! number by +1 if its faces look outwards (its signed volume is positive), by -1 if they look inwards. So each part
//! needs the winding number of all others at one point of it; a skin that looks inwards is a cavity where that number
//! is 1 and a fault where it is 0. Parts that cross are judged at that one point.
//!
//! The winding number is counted along a ray upwards from the point, moved aside by an infinitely small step (e, e^2)
//! in x and y, so that it never meets an edge; all signs are exact.

use super::bvh::Bvh;
use super::edges::{Closure, Edges};
use super::predicates::{side, turn};
use super::report::Orientation;
use super::weld::Welded;
use nalgebra::{Point3, Vector3};

/// A part encloses nothing if its volume is less than this share of the sum that it is the difference of: rounding
/// reaches 1e-13 or so, a sheet of paper of a metre's width encloses 1e-4.
pub(crate) const NO_VOLUME: f64 = 1e-10;

#[derive(Debug)]
pub(super) struct Volumes {
    pub(super) signed_mm3: f64,
    pub(super) area_mm2: f64,
    pub(super) orientation: Orientation,
    pub(super) cavities: usize,
}

#[derive(Clone, Copy)]
struct Part {
    origin: Option<Point3<f64>>,
    /// Six times the volume, and the same with all terms above zero.
    volume: f64,
    magnitude: f64,
    largest: (f64, u32),
}

impl Part {
    /// +1 for a part that looks outwards, -1 for one that looks inwards, 0 for one that encloses nothing.
    fn direction(&self) -> i32 {
        if self.volume.abs() <= NO_VOLUME * self.magnitude { 0 } else { self.volume.signum() as i32 }
    }
}

pub(super) fn measure(mesh: &Welded, edges: &Edges, closure: &[Closure], bvh: &Bvh) -> Volumes {
    let mut area_mm2 = 0.0;
    let mut parts = vec![Part { origin: None, volume: 0.0, magnitude: 0.0, largest: (-1.0, 0) }; edges.parts];
    for (triangle, &at) in (0..).zip(&edges.part).filter(|&(_, &part)| part != u32::MAX) {
        let (part, [a, b, c]) = (&mut parts[at as usize], mesh.corners(triangle));
        let area = (b - a).cross(&(c - a)).norm() / 2.0;
        area_mm2 += area;
        if area > part.largest.0 {
            part.largest = (area, triangle);
        }
        // A closed part may be measured from any point; an open one is closed by a cone over its rim.
        let origin = *part.origin.get_or_insert(match closure[at as usize] {
            Closure::Open(rim) => rim,
            Closure::Closed | Closure::Disordered => *a,
        });
        let volume = (a - origin).dot(&(b - origin).cross(&(c - origin)));
        part.volume += volume;
        part.magnitude += volume.abs();
    }
    let (orientation, cavities) = orientation(mesh, edges, closure, &parts, bvh);
    Volumes { signed_mm3: parts.iter().map(|part| part.volume).sum::<f64>() / 6.0, area_mm2, orientation, cavities }
}

fn orientation(mesh: &Welded, edges: &Edges, closure: &[Closure], parts: &[Part], bvh: &Bvh) -> (Orientation, usize) {
    let (mut above_zero, mut below_zero, mut cavities) = (false, false, 0);
    for (number, part) in parts.iter().enumerate() {
        let direction = part.direction();
        if closure[number] == Closure::Disordered {
            (above_zero, below_zero) = (true, true);
        } else if direction != 0 {
            let outside =
                winding_number(mesh, edges, closure, bvh, number as u32, &mesh.place(part.largest.1, None).at);
            let inside = outside + direction;
            above_zero |= outside > 0 || inside > 0;
            below_zero |= outside < 0 || inside < 0;
            cavities += usize::from(outside == 1 && inside == 0);
        }
    }
    let orientation = match (above_zero, below_zero) {
        (true, true) => Orientation::Mixed,
        (true, false) => Orientation::Outward,
        (false, true) => Orientation::Inward,
        (false, false) => Orientation::Undecided,
    };
    (orientation, cavities)
}

/// The winding number of all closed parts but `except` at `point`.
fn winding_number(
    mesh: &Welded,
    edges: &Edges,
    closure: &[Closure],
    bvh: &Bvh,
    except: u32,
    point: &Point3<f64>,
) -> i32 {
    let mut winding = 0;
    bvh.search(
        |bounds| (0..2).all(|k| bounds.low[k] <= point[k] && point[k] <= bounds.high[k]) && point.z <= bounds.high[2],
        |triangle| {
            let part = edges.part[triangle as usize];
            if part != except && part != u32::MAX && closure[part as usize] == Closure::Closed {
                winding += exit(mesh.corners(triangle), point);
            }
        },
    );
    winding
}

/// +1 if the ray upwards leaves through the front of the triangle, -1 if through its back, 0 if it misses.
pub(crate) fn exit([a, b, c]: [&Point3<f64>; 3], point: &Point3<f64>) -> i32 {
    const UP: usize = 2;
    let moved_turn = |from: &Point3<f64>, to: &Point3<f64>| {
        let step: Vector3<f64> = to - from;
        match turn(UP, from, to, point) {
            0 if step.y != 0.0 => -(step.y.signum() as i8),
            0 if step.x != 0.0 => step.x.signum() as i8,
            turn => turn,
        }
    };
    match [moved_turn(a, b), moved_turn(b, c), moved_turn(c, a)] {
        [s, t, u] if s != 0 && s == t && t == u && side(a, b, c, point) == s => i32::from(s),
        _ => 0,
    }
}
