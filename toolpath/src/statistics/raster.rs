//! The raster: samples all over the surface, and which beads cover each.
//!
//! Each triangle is cut into rows along its longest edge and each row into cells, all of at most one step; a sample in
//! each cell stands for the cell's exact area. So slivers cost no more than others of their area. Samples are not in the
//! middle: where meshes repeat, and outlines run along rows, all cells would err the same way. From row to row they shift
//! within their cells by a sequence without pattern.
//!
//! A bead is the union of discs around the points of its curve, half the width in radius. A sample covered by the piece
//! from `p` to `q`, of length `l`, satisfies `|x - p(s)| <= r + k s` for some `0 <= s <= l`: a quadratic inequality whose
//! solutions are the arc that covers the sample. Of all such arcs each sample keeps the first and the last place.

use super::curve::Piece;
use super::error::StatisticsError;
use super::sheet::Sheet;
use super::walk::{Image, Visit, Walker};
use nalgebra::{Vector2, Vector3};

/// No bead covers the sample.
pub(super) const BARE: u32 = u32::MAX;

/// Arcs of two curves cover it, or arcs of one that are far from each other.
const TWICE: u32 = u32::MAX - 1;

/// Arcs of a curve that are farther apart along it count as two, in widths.
const APART: f32 = 2.0;

/// By how much samples shift within their cells from row to row, as a share of the cell: the inverse of the plastic
/// number and of its square, whose multiples fill the unit square evenly.
const SHIFTS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];

/// Cells of a row, of equal width.
#[derive(Clone, Copy, Debug)]
struct Row {
    first: u32,
    count: u32,
    /// The row's height in the frame, and that of its first sample along it.
    y: f64,
    left: f64,
    /// Distance between samples.
    pitch: f64,
    /// What a sample stands for.
    area: f64,
}

/// What covers a sample: a curve, and from where to where, in widths from a first place.
#[derive(Clone, Copy, Debug)]
struct Cover {
    curve: u32,
    origin: f32,
    low: f32,
    high: f32,
}

pub(super) struct Raster<'s> {
    pub sheet: &'s Sheet,
    rows: Vec<Row>,
    /// Rows of triangle `t`: `first_row[t]..first_row[t + 1]`.
    first_row: Vec<u32>,
    covers: Vec<Cover>,
}

/// The ends of the row at height `y` of a triangle.
fn span(flat: &super::sheet::Flat, y: f64) -> [f64; 2] {
    let up = y / flat.height;
    [flat.foot * up, flat.base + (flat.foot - flat.base) * up]
}

impl<'s> Raster<'s> {
    pub(super) fn new(sheet: &'s Sheet, step: f64, most: usize) -> Result<Self, StatisticsError> {
        let cells = |f: &super::sheet::Flat| f.base * f.height / (2.0 * step * step) + (f.base + f.height) / step + 1.0;
        let estimate: f64 = sheet.flats.iter().filter(|f| f.height > 0.0).map(cells).sum();
        let fits = estimate <= most.min(TWICE as usize - 1) as f64;
        if !fits {
            return Err(StatisticsError::TooFine { step, samples: estimate, most });
        }
        let mut raster = Raster { sheet, rows: Vec::new(), first_row: vec![0], covers: Vec::new() };
        let mut samples = 0;
        for flat in &sheet.flats {
            let rows = if flat.height > 0.0 { (flat.height / step).ceil() as u32 } else { 0 };
            for row in 0..rows {
                let share = |k: u32| 1.0 - k as f64 / rows as f64; // of the base, where the row begins or ends
                let middle = flat.base * (share(row) + share(row + 1)) / 2.0;
                let count = (middle / step).ceil().max(1.0);
                let [up, aside] = SHIFTS.map(|ratio| (0.5 + raster.rows.len() as f64 * ratio).fract());
                // As much of the row's area below as `up` says, so that no part of a triangle has more than its due.
                let squares = [row, row + 1].map(|k| share(k) * share(k));
                let y = flat.height * (1.0 - (squares[0] + (squares[1] - squares[0]) * up).sqrt());
                let [left, right] = span(flat, y);
                let pitch = (right - left) / count;
                raster.rows.push(Row {
                    first: samples,
                    count: count as u32,
                    y,
                    left: left + aside * pitch,
                    pitch,
                    area: middle / count * flat.height / rows as f64,
                });
                samples += count as u32;
            }
            raster.first_row.push(raster.rows.len() as u32);
        }
        raster.covers = vec![Cover { curve: BARE, origin: 0.0, low: 0.0, high: 0.0 }; samples as usize];
        Ok(raster)
    }

    pub(super) fn samples(&self) -> usize {
        self.covers.len()
    }

    pub(super) fn is_bare(&self, sample: usize) -> bool {
        self.covers[sample].curve == BARE
    }

    /// Samples of a triangle: number and place.
    pub(super) fn of_triangle(&self, triangle: u32) -> impl Iterator<Item = (usize, Vector2<f64>)> + '_ {
        let (from, to) = self.row_range(triangle);
        self.rows[from..to].iter().flat_map(|row| {
            (0..row.count).map(|c| ((row.first + c) as usize, Vector2::new(row.left + row.pitch * c as f64, row.y)))
        })
    }

    fn row_range(&self, triangle: u32) -> (usize, usize) {
        (self.first_row[triangle as usize] as usize, self.first_row[triangle as usize + 1] as usize)
    }

    fn row_height(&self, triangle: u32) -> f64 {
        let (from, to) = self.row_range(triangle);
        self.sheet.flats[triangle as usize].height / (to - from).max(1) as f64
    }

    /// Lays down a piece. `round` is the length in widths of a closed curve, infinite for others. True if the bead may
    /// reach over the boundary.
    pub(super) fn deposit(&mut self, walker: &mut Walker, piece: &Piece, round: f32) -> bool {
        let mut stamp = Stamp { raster: self, piece, round, reach: piece.radii[0].max(piece.radii[1]), rim: false };
        walker.walk(Image { triangle: piece.triangle, ends: piece.ends }, &mut stamp);
        stamp.rim
    }

    /// Area of the samples for which something holds: given the number of each.
    pub(super) fn area(&self, holds: impl Fn(usize) -> bool) -> f64 {
        let of_row = |row: &Row| {
            let samples = row.first as usize..(row.first + row.count) as usize;
            samples.filter(|&sample| holds(sample)).count() as f64 * row.area
        };
        self.rows.iter().map(of_row).sum()
    }

    pub(super) fn is_twice(&self, sample: usize) -> bool {
        self.covers[sample].curve == TWICE
    }

    /// Where a sample is in space.
    pub(super) fn place(&self, triangle: u32, at: Vector2<f64>) -> Vector3<f64> {
        self.sheet.lift(triangle, at)
    }
}

impl Cover {
    /// Adds an arc of a curve.
    fn add(&mut self, curve: u32, from: f32, to: f32, round: f32) {
        if self.curve == TWICE {
            return;
        }
        if self.curve == BARE {
            *self = Cover { curve, origin: from, low: 0.0, high: to - from };
        } else if self.curve != curve {
            self.curve = TWICE;
            return;
        } else {
            let mut low = from - self.origin;
            if round.is_finite() {
                low -= round * (low / round).round();
            }
            self.low = self.low.min(low);
            self.high = self.high.max(low + (to - from));
        }
        let apart = self.high - self.low;
        // Around a closed curve the other way may be the shorter one, unless either is far from the first place.
        let far_both_ways = round - apart > APART || self.high.max(-self.low) > APART;
        if apart > APART && far_both_ways {
            self.curve = TWICE;
        }
    }
}

struct Stamp<'r, 's> {
    raster: &'r mut Raster<'s>,
    piece: &'r Piece,
    round: f32,
    reach: f64,
    rim: bool,
}

impl Visit for Stamp<'_, '_> {
    fn reach(&self) -> f64 {
        self.reach
    }

    fn crosses(&mut self, _: f64, to: Option<u32>) -> bool {
        self.rim |= to.is_none();
        true
    }

    fn enter(&mut self, image: &Image) {
        let [p, q] = image.ends;
        let reach = self.reach;
        let (from, to) = self.raster.row_range(image.triangle);
        let height = self.raster.row_height(image.triangle);
        if from == to {
            return;
        }
        // Rows that come within the reach.
        let row_at = |y: f64| (y / height).clamp(0.0, (to - from) as f64);
        let first = row_at(p.y.min(q.y) - reach).floor() as usize;
        let last = row_at(p.y.max(q.y) + reach).ceil() as usize;
        let arc = Arc::new(self.piece, image.ends);
        let side = Vector2::new(-arc.unit.y, arc.unit.x) * reach;
        let corners = [p + side, q + side, q - side, p - side];
        let along = |s: f64| (self.piece.along[0] + s * arc.widths) as f32;
        for row in &self.raster.rows[from + first..from + last] {
            let Some([left, right]) = chord(row.y, [p, q], reach, &corners) else { continue };
            let column = |x: f64| ((x - row.left) / row.pitch).clamp(-1.0, row.count as f64);
            // A column more on either side for rounding.
            let columns = (column(left).floor() as i64).max(0) as u32..(column(right).ceil() as u32 + 1).min(row.count);
            let covers = &mut self.raster.covers[row.first as usize..(row.first + row.count) as usize];
            for c in columns {
                if covers[c as usize].curve == TWICE {
                    continue;
                }
                if let Some([a, b]) = arc.covering(Vector2::new(row.left + row.pitch * c as f64, row.y)) {
                    covers[c as usize].add(self.piece.curve, along(a), along(b), self.round);
                }
            }
        }
    }
}

/// From where to where a row meets the bead of constant width around a segment.
fn chord(y: f64, ends: [Vector2<f64>; 2], radius: f64, corners: &[Vector2<f64>; 4]) -> Option<[f64; 2]> {
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut add = |a: f64, b: f64| (left, right) = (left.min(a), right.max(b));
    for end in ends {
        let half = radius * radius - (y - end.y) * (y - end.y);
        if half >= 0.0 {
            add(end.x - half.sqrt(), end.x + half.sqrt());
        }
    }
    for k in 0..4 {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        if (a.y > y) != (b.y > y) {
            let x = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
            add(x, x);
        }
    }
    (left <= right).then_some([left, right])
}

/// A piece in the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    start: Vector2<f64>,
    pub unit: Vector2<f64>,
    length: f64,
    radii: [f64; 2],
    /// What half the width grows by a millimetre.
    growth: f64,
    /// Widths a millimetre.
    widths: f64,
}

impl Arc {
    pub(super) fn new(piece: &Piece, [p, q]: [Vector2<f64>; 2]) -> Self {
        let length = (q - p).norm();
        let unit = (q - p).try_normalize(0.0).unwrap_or_else(Vector2::x);
        let each = |change: f64| if length > 0.0 { change / length } else { 0.0 };
        let growth = each(piece.radii[1] - piece.radii[0]);
        Arc { start: p, unit, length, radii: piece.radii, growth, widths: each(piece.along[1] - piece.along[0]) }
    }

    /// The part of the piece whose discs cover a point.
    fn covering(&self, x: Vector2<f64>) -> Option<[f64; 2]> {
        let to = x - self.start;
        let curvature = 1.0 - self.growth * self.growth;
        if curvature <= 0.0 {
            // One end's disc holds all others.
            let (s, radius) = if self.growth > 0.0 { (self.length, self.radii[1]) } else { (0.0, self.radii[0]) };
            return ((to - self.unit * s).norm() <= radius).then_some([s; 2]);
        }
        let half = if self.length > 0.0 { to.dot(&self.unit) + self.radii[0] * self.growth } else { 0.0 };
        let rest = half * half - curvature * (to.norm_squared() - self.radii[0] * self.radii[0]);
        if rest < 0.0 {
            return None;
        }
        let root = rest.sqrt();
        let (low, high) = ((half - root) / curvature, (half + root) / curvature);
        (low <= self.length && high >= 0.0).then(|| [low.max(0.0), high.min(self.length)])
    }

    /// Distance of a point from the bead; negative inside.
    pub(super) fn clearance(&self, x: Vector2<f64>) -> f64 {
        let to = x - self.start;
        let (along, off) = (to.dot(&self.unit), to.perp(&self.unit).abs());
        let curvature = 1.0 - self.growth * self.growth;
        let nearest = match curvature > 0.0 {
            true => (along + off * self.growth / curvature.sqrt()).clamp(0.0, self.length),
            false if self.growth > 0.0 => self.length,
            false => 0.0,
        };
        (to - self.unit * nearest).norm() - (self.radii[0] + self.growth * nearest)
    }
}
