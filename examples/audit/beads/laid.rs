//! Beads among those that were laid before: what is in the air, and what is laid twice.

use super::super::args::BeadArgs;
use super::runs::{Runs, steps};
use super::shape::{middle, section_mm2};
use curvlay_examples::laid::{Beads, Capsule};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::support::BeadSupport;
use nalgebra::{Point3, Vector3};
use std::collections::VecDeque;

/// What was found.
#[derive(Debug, Default)]
pub struct Laid {
    pub in_air: Runs,
    pub twice: Runs,
    /// Volume that lies in earlier beads, where it counts.
    pub twice_mm3: f64,
}

/// Places that are looked at are so many bead heights apart.
const STEP: f64 = 0.5;
/// Of its own path a place sees what is this many widths back, at least: nearer beads are the one that it continues.
const BACK_WIDTHS: f64 = 2.0;
/// Rounding of lengths along a path, in millimetres.
const ROUNDING: f64 = 1e-6;

/// A piece of a bead with what it is made of.
#[derive(Clone, Copy, Debug)]
struct Piece {
    ends: [Point3<f64>; 2],
    direction: Vector3<f64>,
    width: f64,
    height: f64,
    /// Length along its path where it ends.
    arc: f64,
}

impl Piece {
    /// How far a place is from the middle line: along the nozzle, and aside.
    fn off(&self, at: &Point3<f64>) -> [f64; 2] {
        let way = self.ends[1] - self.ends[0];
        let squared = way.norm_squared();
        let share = if squared > 0.0 { ((at - self.ends[0]).dot(&way) / squared).clamp(0.0, 1.0) } else { 0.0 };
        let off = at - (self.ends[0] + way * share);
        // Across the bead, where it rises along the nozzle.
        let across =
            if squared > 0.0 { self.direction - way * (self.direction.dot(&way) / squared) } else { self.direction };
        let up = across.try_normalize(1e-6).map_or(0.0, |across| off.dot(&across));
        [up.abs(), (off.norm_squared() - up * up).max(0.0).sqrt()]
    }

    /// The share of a section that is in this one, both as rectangles with their sides along each other.
    fn share(&self, [up, aside]: [f64; 2], width: f64, height: f64) -> f64 {
        let common = |off: f64, own: f64, other: f64| ((0.5 * (own + other) - off).min(own).min(other) / own).max(0.0);
        common(aside, width, self.width) * common(up, height, self.height)
    }
}

/// All that is laid, in the order of the program.
#[derive(Default)]
struct Stack {
    grid: Beads,
    pieces: Vec<Piece>,
    found: Vec<u32>,
    max_width: f64,
    max_height: f64,
}

impl Stack {
    fn push(&mut self, piece: Piece) {
        self.grid.push(Capsule { ends: piece.ends, radius: 0.5 * piece.height });
        self.max_width = self.max_width.max(piece.width);
        self.max_height = self.max_height.max(piece.height);
        self.pieces.push(piece);
    }

    fn near(&mut self, at: &Point3<f64>, reach: f64) -> impl Iterator<Item = &Piece> {
        self.found.clear();
        let half = Vector3::repeat(reach);
        self.grid.within(&[at - half, at + half], &mut self.found);
        self.found.iter().map(|&number| &self.pieces[number as usize])
    }
}

/// Goes along all paths.
pub fn walk(paths: &[ToolPath], support: &BeadSupport, rule: &BeadArgs) -> Laid {
    let mut laid = Laid::default();
    let mut stack = Stack::default();
    let mut loose = support.unsupported.iter().peekable();
    for (number, path) in paths.iter().enumerate() {
        let mut pieces = Vec::new();
        while let Some(piece) = loose.next_if(|piece| piece.path == number) {
            pieces.push(piece.arcs);
        }
        along(path, &pieces, rule, &mut stack, &mut laid);
        laid.in_air.end();
        laid.twice.end();
    }
    laid
}

fn along(path: &ToolPath, loose: &[[f64; 2]], rule: &BeadArgs, stack: &mut Stack, laid: &mut Laid) {
    let mut own: VecDeque<Piece> = VecDeque::new();
    for pair in path.waypoints.windows(2) {
        let [a, b] = [&pair[0], &pair[1]];
        let length = b.arc - a.arc;
        let count = steps(length, STEP * b.height.min(b.width));
        let part = length / f64::from(count);
        for k in 0..count {
            let share = (f64::from(k) + 0.5) / f64::from(count);
            let (at, arc) = (between(a, b, share), a.arc + share * length);
            let back = BACK_WIDTHS.max(rule.air_reach) * b.width + ROUNDING;
            while let Some(piece) = own.pop_front_if(|piece| piece.arc < arc - back) {
                stack.push(piece);
            }
            let is_loose = loose.iter().any(|[from, to]| (*from..=*to).contains(&arc));
            let wrong = is_loose && is_in_air(&at, rule.air_reach * b.width, stack);
            laid.in_air.step(part, wrong.then_some(part), at, path.layer, true);
            let inside = inside(&at, b, stack);
            let is_twice = inside > rule.overlap;
            laid.twice_mm3 += if is_twice { inside * part * section_mm2(b.width, b.height) } else { 0.0 };
            laid.twice.step(part, is_twice.then_some(part), at, path.layer, true);
            let ends = [f64::from(k), f64::from(k + 1)].map(|k| between(a, b, k / f64::from(count)));
            let piece = Piece {
                ends,
                direction: b.axis.into_inner(),
                width: b.width,
                height: b.height,
                arc: a.arc + part * f64::from(k + 1),
            };
            join(&mut own, piece, k > 0);
        }
    }
    own.into_iter().for_each(|piece| stack.push(piece));
}

/// Longest piece, in bead widths: short steps of one straight bead are one piece.
const LONG_WIDTHS: f64 = 2.0;

fn join(own: &mut VecDeque<Piece>, piece: Piece, continues: bool) {
    match own.back_mut() {
        Some(last) if continues && (piece.ends[1] - last.ends[0]).norm() <= LONG_WIDTHS * piece.width => {
            (last.ends[1], last.arc) = (piece.ends[1], piece.arc);
        }
        _ => own.push_back(piece),
    }
}

fn between(a: &Waypoint, b: &Waypoint, share: f64) -> Point3<f64> {
    let [from, to] = [middle(a), middle(b)];
    from + (to - from) * share
}

fn is_in_air(at: &Point3<f64>, reach: f64, stack: &mut Stack) -> bool {
    at.z > reach
        && !stack.near(at, reach).any(|piece| {
            let [up, aside] = piece.off(at);
            up.hypot(aside) <= reach
        })
}

/// The greatest share of a section that is in that of one earlier bead.
fn inside(at: &Point3<f64>, size: &Waypoint, stack: &mut Stack) -> f64 {
    let (width, height) = (size.width, size.height);
    let reach = 0.5 * (width + stack.max_width).hypot(height + stack.max_height);
    stack.near(at, reach).map(|piece| piece.share(piece.off(at), width, height)).fold(0.0, f64::max)
}
