//! The triangles of all layers, asked for the nearest one along a line or around a place.

use super::boxes::{Boxed, Boxes, Look};
use super::sheet::Sheet;
use nalgebra::{Point3, Vector3};
use std::ops::Range;

/// How far behind its start a line may meet a triangle, in millimetres: two layers in the same place are at no distance of each other.
const BEHIND: f64 = 1e-6;
/// A line that passes beside an edge by no more than this share of a triangle meets it: it must not slip through between two of them.
const EDGE: f64 = 1e-9;

/// A plate under a surface that leans more than this (the cosine) is not below it.
const ON_PLATE: f64 = 1e-3;

/// All triangles.
pub struct Stack {
    triangles: Vec<[Point3<f64>; 3]>,
    boxes: Boxes,
}

impl Stack {
    /// Those of sheets, in their order.
    pub fn new(sheets: &[Sheet]) -> Self {
        let corners =
            |sheet: &Sheet| sheet.triangles.iter().map(|triangle| sheet.corners(triangle)).collect::<Vec<_>>();
        let triangles: Vec<[Point3<f64>; 3]> = sheets.iter().flat_map(corners).collect();
        let ranks = sheets.iter().flat_map(|sheet| sheet.triangles.iter().map(|_| sheet.rank));
        let things = triangles.iter().zip(ranks).map(|(corners, rank)| Boxed::around(corners, rank)).collect();
        Stack { triangles, boxes: Boxes::new(things) }
    }

    /// How far it is along a unit vector to the first triangle of some layers, if that is within `reach`.
    pub fn along(&self, from: Point3<f64>, way: Vector3<f64>, ranks: Range<u32>, reach: f64) -> Option<f64> {
        let mut line = Line { stack: self, from, way, ranks, best: reach, is_met: false };
        self.boxes.look(&mut line);
        line.is_met.then_some(line.best.max(0.0))
    }

    /// How far it is from a place against a unit normal to a layer before one, or to the plate: as far as that would be if it were `from_plate` times as far.
    pub fn below(&self, at: Point3<f64>, normal: Vector3<f64>, rank: u32, from_plate: f64) -> Option<f64> {
        let to_plate = (normal.z > ON_PLATE).then(|| (at.z / normal.z).max(0.0) * from_plate);
        let to_layer = self.along(at, -normal, 0..rank, f64::INFINITY);
        [to_plate, to_layer].into_iter().flatten().reduce(f64::min)
    }

    /// How far the nearest accepted point of some layers is, if that is within `reach`: of each triangle the nearest point is asked for.
    pub fn nearest(
        &self,
        to: Point3<f64>,
        ranks: Range<u32>,
        reach: f64,
        accepts: impl Fn(&Point3<f64>) -> bool,
    ) -> Option<f64> {
        let mut near = Near { stack: self, to, ranks, accepts, best: reach, is_met: false };
        self.boxes.look(&mut near);
        near.is_met.then_some(near.best)
    }
}

struct Line<'a> {
    stack: &'a Stack,
    from: Point3<f64>,
    way: Vector3<f64>,
    ranks: Range<u32>,
    best: f64,
    is_met: bool,
}

impl Look for Line<'_> {
    fn bound(&self, of: &Boxed) -> f64 {
        if !of.has(&self.ranks) {
            return f64::INFINITY;
        }
        let (mut enters, mut leaves) = (-BEHIND, f64::INFINITY);
        for axis in 0..3 {
            let [low, high] = [of.low[axis] - BEHIND - self.from[axis], of.high[axis] + BEHIND - self.from[axis]];
            if self.way[axis].abs() > 0.0 {
                let [a, b] = [low / self.way[axis], high / self.way[axis]];
                (enters, leaves) = (enters.max(a.min(b)), leaves.min(a.max(b)));
            } else if low > 0.0 || high < 0.0 {
                return f64::INFINITY;
            }
        }
        if enters <= leaves { enters } else { f64::INFINITY }
    }

    fn limit(&self) -> f64 {
        self.best
    }

    fn see(&mut self, thing: usize) {
        let met = crossing(&self.stack.triangles[thing], self.from, self.way);
        if let Some(at) = met.filter(|at| (-BEHIND..self.best).contains(at)) {
            (self.best, self.is_met) = (at, true);
        }
    }
}

/// Where a line crosses a triangle (T. Möller, B. Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997).
fn crossing([a, b, c]: &[Point3<f64>; 3], from: Point3<f64>, way: Vector3<f64>) -> Option<f64> {
    let (along, across, off) = (b - a, c - a, from - a);
    let p = way.cross(&across);
    let volume = along.dot(&p);
    let q = off.cross(&along);
    let [u, v, at] = [off.dot(&p), way.dot(&q), across.dot(&q)].map(|share| share / volume);
    let is_inside = u >= -EDGE && v >= -EDGE && u + v <= 1.0 + EDGE;
    (is_inside && at.is_finite()).then_some(at)
}

struct Near<'a, F> {
    stack: &'a Stack,
    to: Point3<f64>,
    ranks: Range<u32>,
    accepts: F,
    best: f64,
    is_met: bool,
}

impl<F: Fn(&Point3<f64>) -> bool> Look for Near<'_, F> {
    fn bound(&self, of: &Boxed) -> f64 {
        if !of.has(&self.ranks) {
            return f64::INFINITY;
        }
        (self.to - self.to.sup(&of.low).inf(&of.high)).norm()
    }

    fn limit(&self) -> f64 {
        self.best
    }

    fn see(&mut self, thing: usize) {
        let point = closest(&self.stack.triangles[thing], &self.to);
        let distance = (point - self.to).norm();
        if distance < self.best && (self.accepts)(&point) {
            (self.best, self.is_met) = (distance, true);
        }
    }
}

/// The point of a triangle that is nearest to a place (C. Ericson, *Real-Time Collision Detection*, 2005, 5.1.5).
pub fn closest(&[a, b, c]: &[Point3<f64>; 3], to: &Point3<f64>) -> Point3<f64> {
    let (ab, ac) = (b - a, c - a);
    let of = |from: Point3<f64>| [ab.dot(&(to - from)), ac.dot(&(to - from))];
    let ([d1, d2], [d3, d4], [d5, d6]) = (of(a), of(b), of(c));
    let (vc, vb, va) = (d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4);
    if d1 <= 0.0 && d2 <= 0.0 {
        a
    } else if d3 >= 0.0 && d4 <= d3 {
        b
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        a + ab * (d1 / (d1 - d3))
    } else if d6 >= 0.0 && d5 <= d6 {
        c
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        a + ac * (d2 / (d2 - d6))
    } else if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))
    } else {
        a + ab * (vb / (va + vb + vc)) + ac * (vc / (va + vb + vc))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sheet(rank: u32, corners: [[f64; 3]; 3]) -> Sheet {
        Sheet { rank, vertices: corners.map(Point3::from).to_vec(), triangles: vec![[0, 1, 2]], ..Sheet::default() }
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(53), ..ProptestConfig::with_cases(64) })]

        /// The twin looks at many points of each triangle.
        #[test]
        fn nearest_and_along_are_those_of_all_points(
            all in prop::collection::vec(prop::array::uniform3(prop::array::uniform3(-9f64..9.0)), 1..12), at in prop::array::uniform3(-9f64..9.0), before in 0_u32..12
        ) {
            let sheets: Vec<Sheet> = all.iter().zip(0..).map(|(corners, rank)| sheet(rank, *corners)).collect();
            let (stack, at) = (Stack::new(&sheets), Point3::from(at));
            const SIDE: i32 = 60;
            let shares = (1..SIDE).flat_map(|i| (1..SIDE - i).map(move |j| [i, j].map(|k| f64::from(k) / f64::from(SIDE))));
            let points: Vec<Point3<f64>> = sheets.iter().filter(|sheet| sheet.rank < before).flat_map(|sheet| {
                let [a, b, c] = sheet.corners(&[0, 1, 2]);
                shares.clone().map(move |[u, v]| a + (b - a) * u + (c - a) * v)
            }).collect();
            let wanted = points.iter().map(|point| (point - at).norm()).fold(f64::INFINITY, f64::min);
            match stack.nearest(at, 0..before, f64::INFINITY, |_| true) {
                Some(found) => prop_assert!(found <= wanted + 1e-9 && found >= wanted - 1.0, "{found} {wanted}"),
                None => prop_assert!(wanted.is_infinite()),
            }
            // Towards a point within a triangle a line meets something at that point, or before.
            for point in points.iter().step_by(97) {
                if let Some(way) = (point - at).try_normalize(1e-3) {
                    let found = stack.along(at, way, 0..before, f64::INFINITY);
                    prop_assert!(found.is_some_and(|found| found <= (point - at).norm() + 1e-6), "{found:?} {point}");
                }
            }
        }
    }
}
