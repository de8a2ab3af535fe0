//! Which base sections cross: the check of constraint I of the dissertation (section 2.4.3), from the parts and their planes alone.
//!
//! Two planes meet in a line. It cuts the sections of the parts on both into intervals; where intervals of both overlap the sections
//! cross. One that only ends on the other, as the section of an earlier cut does below a later part, has the line on its edge, not inside.

use super::parts::PrintedPart;
use crate::planar::{CutPlane, PlaneFrame, Region, slice};
use nalgebra::{Point2, Point3, Vector2, Vector3};

/// Sections are taken so far above base planes, and shrunk by so much on all sides, in mm: rounding of places is far less, beads are far more.
const INSIDE: f64 = 0.02;

/// Planes that are closer to parallel than this sine do not cross.
const PARALLEL: f64 = 1e-6;

/// The section of a part on its base.
struct Base {
    part: usize,
    plane: CutPlane,
    frame: PlaneFrame,
    region: Region,
}

/// The pairs of parts whose base sections cross inside of both, by rising numbers.
///
/// # Cost
/// A section of each part, and for each pair `O(e)`, `e` the edges of both.
///
/// # Example
/// ```
/// use curvlay_layers::nalgebra::{Point3, Vector3};
/// use curvlay_layers::planar::robofdm::{PrintedPart, crossing_sections};
/// use curvlay_layers::planar::{CutPlane, Solid};
/// let points: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i & 1) * 4.0, f64::from(i >> 1 & 1) * 4.0, f64::from(i >> 2) * 4.0)).collect();
/// let faces = [
///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// ];
/// let solid = Solid::new(&points, &faces)?;
/// let part = |normal: Vector3<f64>| -> Result<PrintedPart, Box<dyn std::error::Error>> {
///     let base = Some(CutPlane::through(&Point3::new(2.0, 2.0, 2.0), &normal)?);
///     Ok(PrintedPart { solid: solid.clone(), direction: normal, base, risky_mm2: 0.0, seam_mm2: 0.0, on: vec![], seams: vec![] })
/// };
/// let (level, upright) = (part(Vector3::z())?, part(Vector3::x())?);
/// assert_eq!(crossing_sections(&[level.clone(), upright]), [[0, 1]]);
/// assert!(crossing_sections(&[level.clone(), level]).is_empty()); // parallel
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn crossing_sections(parts: &[PrintedPart]) -> Vec<[usize; 2]> {
    let base = |(part, of): (usize, &PrintedPart)| {
        let plane = of.base?;
        let frame = PlaneFrame::of(&plane);
        let region = Region::of(&slice(&of.solid, &plane.moved(INSIDE), &frame)).grown(-INSIDE);
        Some(Base { part, plane, frame, region })
    };
    let bases: Vec<Base> = parts.iter().enumerate().filter_map(base).collect();
    let mut crossing = Vec::new();
    for (k, a) in bases.iter().enumerate() {
        let crosses = |b: &&Base| {
            let Some((from, along)) = line(&a.plane, &b.plane) else { return false };
            let [a, b] = [a, *b].map(|base| base.intervals(&from, &along));
            a.iter().any(|a| b.iter().any(|b| a[1].min(b[1]) - a[0].max(b[0]) > INSIDE))
        };
        crossing.extend(bases[k + 1..].iter().filter(crosses).map(|b| [a.part, b.part]));
    }
    crossing
}

/// The line in two planes: a point, and its direction of length 1.
fn line(a: &CutPlane, b: &CutPlane) -> Option<(Point3<f64>, Vector3<f64>)> {
    let (m, n) = (a.normal(), b.normal());
    let along = m.cross(&n);
    let sine = along.norm();
    let at = (n.cross(&along) * a.offset() + along.cross(&m) * b.offset()) / (sine * sine);
    (sine > PARALLEL).then(|| (Point3::from(at), along / sine))
}

impl Base {
    /// Where a line in the plane is inside the section, as lengths along it.
    fn intervals(&self, from: &Point3<f64>, along: &Vector3<f64>) -> Vec<[f64; 2]> {
        let origin: Point2<f64> = self.frame.flat(from);
        let u = Vector2::new(along.dot(&self.frame.u), along.dot(&self.frame.v));
        let mut at: Vec<f64> = Vec::new();
        for [p, q] in self.region.edges() {
            let [p, q] = [p - origin, q - origin];
            let [hp, hq] = [u.perp(&p), u.perp(&q)];
            if (hp > 0.0) != (hq > 0.0) {
                at.push((p + (q - p) * (hp / (hp - hq))).dot(&u));
            }
        }
        at.sort_by(f64::total_cmp);
        at.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
    }
}
