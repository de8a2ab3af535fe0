//! Tapes as strips on the layer, in cells, so that it is quick to find which of them lie over a point.
//!
//! Between two points of its centre line a tape is a flat rectangle. At a bend the rectangles reach on to where their outer corners meet.

use nalgebra::{Point3, Vector3};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// A point lies under a strip only if it is at most this share of the width off its plane: layers bend, and may fold over themselves.
const OFF_PLANE: f64 = 1.0 / 3.0;

/// The normals of a strip and of a point under it differ by less than a right angle, with something to spare: the cosine.
const SAME_SIDE: f64 = 0.3;

/// A piece of a tape between two points of its centre line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip {
    pub from: Point3<f64>,
    pub along: Vector3<f64>,
    pub normal: Vector3<f64>,
    side: Vector3<f64>,
    pub length: f64,
    /// How far it reaches on at its two ends.
    pub reach: [f64; 2],
    pub half_width: f64,
    pub tape: u32,
    /// Length of the tape before it.
    pub arc: f64,
}

impl Strip {
    /// A strip between two points; `None` if they coincide, or if the normal leaves no side.
    pub(super) fn new(ends: [Point3<f64>; 2], normal: Vector3<f64>, width: f64, tape: u32, arc: f64) -> Option<Self> {
        let along = ends[1] - ends[0];
        let length = along.norm();
        let along = along.try_normalize(0.0)?;
        let normal = (normal - along * normal.dot(&along)).try_normalize(1e-6)?;
        let side = normal.cross(&along);
        Some(Strip { from: ends[0], along, normal, side, length, reach: [0.0; 2], half_width: width / 2.0, tape, arc })
    }

    /// Lets two strips of one tape, one after the other, reach to where their outer corners meet.
    pub(super) fn join(before: &mut Strip, after: &mut Strip) {
        let cosine = before.along.dot(&after.along).clamp(-1.0, 1.0);
        // tan(turn / 2); no farther than half a width at turns beyond a right angle.
        let reach = before.half_width * ((1.0 - cosine) / (1.0 + cosine).max(f64::MIN_POSITIVE)).sqrt().min(1.0);
        (before.reach[1], after.reach[0]) = (reach, reach);
    }

    /// How far along the strip a point under it is; `None` if the point is not under it.
    pub(super) fn over(&self, p: Point3<f64>, normal: &Vector3<f64>) -> Option<f64> {
        let offset = p - self.from;
        let along = offset.dot(&self.along);
        let over = along >= -self.reach[0]
            && along <= self.length + self.reach[1]
            && offset.dot(&self.side).abs() <= self.half_width
            && offset.dot(&self.normal).abs() <= 2.0 * OFF_PLANE * self.half_width
            && self.normal.dot(normal) > SAME_SIDE;
        over.then_some(along)
    }
}

/// Strips in cells.
#[derive(Debug)]
pub(super) struct StripGrid {
    cell: f64,
    strips: Vec<Strip>,
    cells: HashMap<[i32; 3], Vec<u32>, BuildHasherDefault<CellHasher>>,
}

/// Cells are looked up for every sample of a layer: three numbers mixed by one multiplication each.
#[derive(Debug, Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }

    fn write(&mut self, bytes: &[u8]) {
        for four in bytes.chunks(4) {
            let number = four.iter().rev().fold(0, |number, &byte| (number << 8) | u64::from(byte));
            self.0 = (self.0.rotate_left(21) ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        }
    }
}

impl StripGrid {
    /// `width` of tapes and `step` between their points decide how wide a cell is.
    pub(super) fn new(width: f64, step: f64) -> Self {
        StripGrid { cell: width.max(step), strips: Vec::new(), cells: HashMap::default() }
    }

    fn cell_of(&self, p: Point3<f64>) -> [i32; 3] {
        [0, 1, 2].map(|k| (p[k] / self.cell).floor() as i32)
    }

    pub(super) fn add(&mut self, strip: Strip) {
        let number = self.strips.len() as u32;
        let side = strip.side * strip.half_width;
        let up = strip.normal * (2.0 * OFF_PLANE * strip.half_width);
        let [start, end] =
            [strip.from - strip.along * strip.reach[0], strip.from + strip.along * (strip.length + strip.reach[1])];
        let reach = side.abs() + up.abs();
        let low = self.cell_of(Point3::from(start.coords.inf(&end.coords) - reach));
        let high = self.cell_of(Point3::from(start.coords.sup(&end.coords) + reach));
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    self.cells.entry([x, y, z]).or_default().push(number);
                }
            }
        }
        self.strips.push(strip);
    }

    /// The strips over a point, in the order in which they were added, and how far along each it is.
    pub(super) fn over(&self, p: Point3<f64>, normal: &Vector3<f64>) -> impl Iterator<Item = (&Strip, f64)> {
        let near = self.cells.get(&self.cell_of(p)).map_or(&[][..], Vec::as_slice);
        let normal = *normal;
        near.iter().map(|&number| &self.strips[number as usize]).filter_map(move |s| Some((s, s.over(p, &normal)?)))
    }
}

/// The strips of a tape.
pub(super) fn strips_of(
    points: &[Point3<f64>],
    normals: &[nalgebra::UnitVector3<f64>],
    width: f64,
    tape: u32,
) -> Vec<Strip> {
    let (mut strips, mut arc): (Vec<Strip>, f64) = (Vec::new(), 0.0);
    for (ends, normals) in points.windows(2).zip(normals.windows(2)) {
        let normal = normals[0].into_inner() + normals[1].into_inner();
        let Some(mut strip) = Strip::new([ends[0], ends[1]], normal, width, tape, arc) else { continue };
        arc += strip.length;
        if let Some(before) = strips.last_mut() {
            Strip::join(before, &mut strip);
        }
        strips.push(strip);
    }
    strips
}
