//! Trimming to a mesh with holes: inside is where the winding number is above one half, in absolute value where the rule does not mind its sign.
//!
//! Over a hole the winding number falls off smoothly, so it is computed at the corners of all pieces and pieces are cut
//! where it is one half on their sides, as marching triangles do. It is smooth on each side of a cut along the
//! mesh, and changes by a whole number across. So it is computed once a vertex; for a vertex on the mesh a little way off
//! it, and on its other side it differs by the rise of the cut. What is smaller than a triangle of the sheet may be missed.

use super::edges::Edges;
use super::error::{TrimError, Watch};
use super::patch::NONE;
use super::pieces::Pieces;
use super::solid::Solid;
use super::surface::{next, previous};
use super::triangle::altitude;
use super::winding::Dipoles;
use nalgebra::{Point3, Vector3};

/// What stands for the infinitely small step of the sheet where numbers are computed and not counted, mm: its parts in
/// the same order, far from each other, and above the rounding of solid angles near a face.
const STEP: Vector3<f64> = Vector3::new(1e-8, 1e-10, 1e-6);

/// How far into a piece the number of a corner on the mesh is taken, as a share of the way to its middle.
const INTO: f64 = 0.01;

/// Steps towards one half on a side. Each halves the interval at least every other time; the number itself is good to a
/// hundredth or so.
const STEPS: usize = 6;

/// How near to its ends a side may be cut, as a share of it: nearer ends would make slivers.
const END: f64 = 0.01;

struct Halves<'a> {
    pieces: &'a Pieces,
    solid: &'a Solid,
    dipoles: &'a Dipoles,
    /// The number at each corner, less one half, without sign: above zero is inside.
    excess: Vec<f64>,
}

/// Cuts pieces where the winding number is one half, and says which are inside.
pub(super) fn split_at_half(
    pieces: &mut Pieces,
    solid: &Solid,
    dipoles: &Dipoles,
    watch: Watch,
) -> Result<Vec<bool>, TrimError> {
    let count = 3 * pieces.corners.len();
    let mut halves = Halves { pieces, solid, dipoles, excess: vec![f64::NAN; count] };
    halves.measure(watch)?;
    let mut points = Vec::new();
    let mut split = vec![NONE; count];
    for half in 0..count as u32 {
        let back = halves.across(half);
        // One point for both sides of an edge, so that the parts of neighbours fit.
        if halves.changes(half) && split[half as usize] == NONE {
            let point = (halves.pieces.points.len() + points.len()) as u32;
            points.push(halves.half_on(half));
            split[half as usize] = point;
            if back != NONE {
                split[back as usize] = point;
            }
        }
    }
    let (parts, keep) = halves.divide(&split);
    points.splice(0..0, std::mem::take(&mut pieces.points));
    *pieces = parts;
    pieces.points = points;
    Ok(keep)
}

impl Halves<'_> {
    fn across(&self, half: u32) -> u32 {
        self.pieces.across[half as usize / 3][half as usize % 3]
    }

    fn rise(&self, half: u32) -> i32 {
        self.pieces.rise[half as usize / 3][half as usize % 3]
    }

    fn places(&self, piece: u32) -> [Point3<f64>; 3] {
        [3 * piece, 3 * piece + 1, 3 * piece + 2].map(|half| self.corner(half))
    }

    fn corner(&self, half: u32) -> Point3<f64> {
        self.pieces.points[self.pieces.corners[half as usize / 3][half as usize % 3] as usize]
    }

    fn middle(&self, piece: u32) -> Point3<f64> {
        let [a, b, c] = self.places(piece).map(|p| p.coords);
        Point3::from((a + b + c) / 3.0)
    }

    fn number(&self, p: &Point3<f64>) -> f64 {
        self.solid.winding_near(self.dipoles, &(p + STEP))
    }

    /// Finds the number of each corner.
    fn measure(&mut self, watch: Watch) -> Result<(), TrimError> {
        let mut fan = Vec::new();
        let mut numbers = Vec::new();
        for half in 0..self.excess.len() as u32 {
            watch(half as usize / 3, self.excess.len() / 3)?;
            if self.excess[half as usize].is_nan() {
                self.fan(half, &mut fan);
                self.measure_fan(&fan, &mut numbers);
                for (&half, number) in fan.iter().zip(&numbers) {
                    self.excess[half as usize] = self.solid.rule.excess(*number);
                }
            }
        }
        Ok(())
    }

    /// The numbers around one vertex.
    fn measure_fan(&self, fan: &[u32], numbers: &mut Vec<f64>) {
        numbers.clear();
        let at = self.corner(fan[0]);
        if fan.iter().all(|&half| self.rise(half) == 0 && self.rise(previous(half)) == 0) {
            numbers.resize(fan.len(), self.number(&at));
            return;
        }
        // Once, where the pieces are thickest; across a cut it changes by the rise.
        let thickness = |half: u32| altitude(&self.places(half / 3));
        let thicker = |a: &usize, b: &usize| thickness(fan[*a]).total_cmp(&thickness(fan[*b]));
        let place = (0..fan.len()).max_by(thicker).unwrap_or(0);
        numbers.resize(fan.len(), f64::NAN);
        numbers[place] = self.number(&(at + (self.middle(fan[place] / 3) - at) * INTO));
        for n in 1..fan.len() {
            if numbers[n].is_nan() {
                numbers[n] = numbers[n - 1] - f64::from(self.rise(previous(fan[n - 1])));
            }
        }
        for n in (1..fan.len()).rev() {
            if numbers[n - 1].is_nan() {
                numbers[n - 1] = numbers[n] + f64::from(self.rise(previous(fan[n - 1])));
            }
        }
    }

    /// The half-edges from one vertex, counter-clockwise, from the border or a cut along the mesh on, if there is one.
    fn fan(&self, half: u32, fan: &mut Vec<u32>) {
        fan.clear();
        let mut first = half;
        while self.across(first) != NONE && self.rise(first) == 0 {
            first = next(self.across(first));
            if first == half {
                break;
            }
        }
        // Then back to the border, which may lie behind the cut.
        let cut = first;
        while self.across(first) != NONE {
            first = next(self.across(first));
            if first == cut {
                break;
            }
        }
        let mut at = first;
        loop {
            fan.push(at);
            at = self.across(previous(at));
            if at == NONE || at == first {
                break;
            }
        }
    }

    fn changes(&self, half: u32) -> bool {
        (self.excess[half as usize] > 0.0) != (self.excess[next(half) as usize] > 0.0)
    }

    /// Where the number is one half on a side.
    fn half_on(&self, half: u32) -> Point3<f64> {
        let (a, b) = (self.corner(half), self.corner(next(half)));
        let into = if self.rise(half) != 0 { INTO } else { 0.0 };
        let middle = self.middle(half / 3);
        // The false position, after R. Dowell and P. Jarratt's Illinois rule: the value of an end that stays is halved.
        let [mut low, mut high] = [(0.0, self.excess[half as usize]), (1.0, self.excess[next(half) as usize])];
        let mut share = 0.5;
        let mut stayed = 0;
        for _ in 0..STEPS {
            share = low.0 + (high.0 - low.0) * (low.1 / (low.1 - high.1));
            let on = a + (b - a) * share;
            let value = self.number(&(on + (middle - on) * into));
            let value = self.solid.rule.excess(value);
            if (value > 0.0) == (low.1 > 0.0) {
                low = (share, value);
                high.1 = if stayed == 1 { high.1 / 2.0 } else { high.1 };
                stayed = 1;
            } else {
                high = (share, value);
                low.1 = if stayed == 2 { low.1 / 2.0 } else { low.1 };
                stayed = 2;
            }
        }
        // Both values are 0 only where the number is one half all along the side.
        let share = if share.is_finite() { share.clamp(END, 1.0 - END) } else { 0.5 };
        a + (b - a) * share
    }

    /// The pieces, those with split sides in parts, and which are inside. Their points are left out.
    fn divide(&self, split: &[u32]) -> (Pieces, Vec<bool>) {
        // Signs at the corners decide what is cut, as in marching triangles. Across a cut along the mesh they may differ between both
        // sides of an edge; the point on it is one all the same, and a piece may be split on any of its sides.
        let (mut parts, mut keep) = (Pieces::default(), Vec::new());
        let mut rises = Vec::new();
        for piece in 0..self.pieces.corners.len() {
            let source = self.pieces.sources[piece];
            let corner = |k: usize| self.pieces.corners[piece][k % 3];
            let middle = |k: usize| split[3 * piece + k % 3];
            let rise = |k: usize| self.pieces.rise[piece][k % 3];
            let inside = |k: usize| self.excess[3 * piece + k % 3] > 0.0;
            let mut push = |corners: [u32; 3], rise: [i32; 3], inside: bool| {
                parts.corners.push(corners);
                parts.sources.push(source);
                rises.push(rise);
                keep.push(inside);
            };
            let is_split = [0, 1, 2].map(|k| middle(k) != NONE);
            match is_split.iter().filter(|&&split| split).count() {
                0 => push([corner(0), corner(1), corner(2)], [rise(0), rise(1), rise(2)], inside(0)),
                1 => {
                    let k = is_split.iter().position(|&split| split).unwrap_or(0);
                    push([corner(k), middle(k), corner(k + 2)], [rise(k), 0, rise(k + 2)], inside(k));
                    push([middle(k), corner(k + 1), corner(k + 2)], [rise(k), rise(k + 1), 0], inside(k + 1));
                }
                2 => {
                    // The corner between the two split sides.
                    let k = is_split.iter().position(|&split| !split).unwrap_or(0) + 2;
                    push([corner(k), middle(k), middle(k + 2)], [rise(k), 0, rise(k + 2)], inside(k));
                    push([middle(k), corner(k + 1), corner(k + 2)], [rise(k), rise(k + 1), 0], inside(k + 1));
                    push([middle(k), corner(k + 2), middle(k + 2)], [0, rise(k + 2), 0], inside(k + 2));
                }
                _ => {
                    for k in 0..3 {
                        push([corner(k), middle(k), middle(k + 2)], [rise(k), 0, rise(k + 2)], inside(k));
                    }
                    let most = (0..3).filter(|&k| inside(k)).count() > 1;
                    push([middle(0), middle(1), middle(2)], [0; 3], most);
                }
            }
        }
        let edges = Edges::new(&parts.corners);
        parts.across = vec![[NONE; 3]; parts.corners.len()];
        let mut first = vec![NONE; edges.ends.len()];
        for half in 0..3 * parts.corners.len() as u32 {
            let (piece, k) = (half as usize / 3, half as usize % 3);
            let edge = edges.sides[piece][k] as usize;
            match first[edge] {
                NONE => first[edge] = half,
                other => {
                    parts.across[piece][k] = other;
                    parts.across[other as usize / 3][other as usize % 3] = half;
                }
            }
        }
        parts.rise = rises;
        (parts, keep)
    }
}
