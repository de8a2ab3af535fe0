//! Which pairs may touch: those that move against each other, less those proven apart at all joints.

use super::body::Mount;
use super::chain::Chain;
use super::piece::Piece;
use super::rounding::CHAIN_MM;
use super::search::Meeting;
use super::{Placed, Scene};
use crate::track::Track;
use nalgebra::{Isometry3, Point3};

/// What links with one link between them keep apart beyond the margin at most, in millimetres: the base and the upper arm of a UR3
/// pass each other at 8 mm, and less than this does not keep the way between two waypoints free.
const CLOSE_LINKS_MM: f64 = 2.0;

/// Which chain moves a mount, and behind how many joints it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Arm(usize),
    Table(usize),
}

impl Mount {
    pub(super) fn place(self) -> Place {
        match self {
            Mount::Base => Place::Arm(0),
            Mount::Link(link) => Place::Arm(link),
            Mount::Tilt | Mount::Ground | Mount::Rail => Place::Table(1),
            Mount::Table => Place::Table(2),
        }
    }
}

/// What separates two mounts: joints of the arm and of the table, as ranges of frames `from..to`, and whose lever arms
/// count there.
pub(super) enum Apart {
    /// Both on one chain: the second is behind the first, by these joints.
    Behind { table: bool, from: usize, to: usize },
    /// One on the arm, the other on the table.
    Both,
}

impl Scene {
    /// How far points of a body can be from each of the axes that move it.
    pub(super) fn lever_arms(&self, placed: &Placed) -> Vec<f64> {
        let farthest = |measure: &dyn Fn(&Point3<f64>) -> f64| farthest(placed, measure);
        match (placed.body.mount.place(), &self.table_chain) {
            (Place::Arm(0), _) => vec![],
            // All points of the ground move alike.
            (Place::Table(_), None) => self.track.iter().map(Track::mm_per_unit).collect(),
            (Place::Arm(link), _) => self.arm_chain.lever_arms(link, farthest),
            (Place::Table(frame), Some(chain)) => chain.lever_arms(frame, farthest),
        }
    }

    /// What moves two bodies against each other, the one nearer to the base first; `None` when nothing does.
    pub(super) fn relation(&self, a: usize, b: usize) -> Option<([usize; 2], Apart)> {
        let behind = |table, i: usize, j: usize| {
            let order = if i < j { [a, b] } else { [b, a] };
            (i != j).then_some((order, Apart::Behind { table, from: i.min(j), to: i.max(j) }))
        };
        match (self.bodies[a].body.mount.place(), self.bodies[b].body.mount.place()) {
            (Place::Arm(i), Place::Arm(j)) => behind(false, i, j),
            (Place::Table(i), Place::Table(j)) => behind(true, i, j),
            (Place::Arm(0), Place::Table(j)) => behind(true, 0, j),
            (Place::Table(i), Place::Arm(0)) => behind(true, i, 0),
            _ => Some(([a, b], Apart::Both)),
        }
    }

    pub(super) fn on_table(&self, body: usize) -> bool {
        matches!(self.bodies[body].body.mount.place(), Place::Table(_))
    }

    /// How far the bodies of a pair must be apart, thicker by their [`growth`](Self::growth).
    pub(super) fn threshold(&self, [a, b]: &[usize; 2]) -> f64 {
        let both_links = self.bodies[*a].is_link && self.bodies[*b].is_link;
        match self.relation(*a, *b) {
            Some((_, Apart::Behind { table: false, from, to })) if both_links && to - from <= 2 => {
                self.margin + self.clearance.min(CLOSE_LINKS_MM)
            }
            _ => self.margin + self.clearance,
        }
    }

    pub(super) fn find_pairs(&mut self) {
        let count = self.bodies.len();
        let mut pairs = Vec::new();
        for a in 0..count {
            for b in a + 1..count {
                if !self.allowed.contains(&[a, b]) && self.may_touch(a, b) {
                    pairs.push([a, b]);
                }
            }
        }
        self.pairs = pairs;
    }

    fn may_touch(&self, a: usize, b: usize) -> bool {
        let Some(([inner, outer], apart)) = self.relation(a, b) else { return false };
        let Apart::Behind { table, from, to } = apart else { return true };
        let (inner, outer) = (&self.bodies[inner], &self.bodies[outer]);
        if !inner.is_link && inner.body.mount == Mount::Base && outer.body.mount == Mount::Rail {
            return false;
        }
        if inner.is_link && outer.is_link && to == from + 1 {
            return false;
        }
        let chain: Option<&Chain> = if table { self.table_chain.as_ref() } else { Some(&self.arm_chain) };
        let Some(chain) = chain else { return true };
        let ([low, high], radius) = chain.reachable_volume(from, to, |measure| farthest(outer, measure));
        let identity = Isometry3::identity();
        let [grown, grown_too] = self.growth(&[a, b]);
        let threshold = self.threshold(&[a, b]) + grown + grown_too;
        let volume = Piece::capsule(&low, &high, radius + CHAIN_MM, &identity);
        let frees = |piece: &Piece| {
            Meeting::new(piece, &volume, piece.mount_piece.inv_mul(&volume.mount_piece)).apart(threshold)
        };
        !inner.pieces.iter().all(frees)
    }
}

/// The greatest value on a body of a distance (or height) in the frame of its mount.
fn farthest(placed: &Placed, measure: &dyn Fn(&Point3<f64>) -> f64) -> f64 {
    let of_piece = |piece: &Piece| piece.farthest(|point| measure(&(piece.mount_piece * point))) + piece.radius;
    placed.pieces.iter().map(of_piece).fold(f64::NEG_INFINITY, f64::max)
}
