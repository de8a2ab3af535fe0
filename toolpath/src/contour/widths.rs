//! How wide beads are on bridges: as wide as the clearance between what lies on their sides.
//!
//! Along rings levels say how wide beads are. Bridges lead from one to the other, next to each other, and there the clearance
//! is measured: straight aside, on each side half the way to the next bridge, what the bead of a ring leaves of the way to
//! it, or the way to the boundary. A bead is as wide as both together. (Fitting those along rings likewise was tried: it
//! widens what a neighbour narrows, and in turn, far into what was even.)

use super::crossing::normal;
use super::polyline::Curve;
use super::segments::Segments;
use super::spacing::{BEAD_WIDTHS, Spacing};
use super::watch::Watch;
use crate::mesh::SurfaceMesh;
use crate::path::PathError;
use nalgebra::{Point3, Vector3};

/// How far aside neighbours are looked for, in beads: as far as two of the widest beads side by side reach from middle to middle.
const LOOKUP_DISTANCE: f64 = 1.25;
/// What lies above or below by more than this share of its distance is on another sheet of the surface: 37 degrees.
const MAX_HEIGHT_SHARE: f64 = 0.6;
/// What is no farther away along the curve than this many times its distance is the curve itself.
const SAME_CURVE_RATIO: f64 = 2.0;
/// The number in place of a curve's that stands for the boundary.
const BOUNDARY: u32 = u32::MAX;

/// Widths at the points of curves.
pub(super) fn fitted(
    mesh: &SurfaceMesh,
    spacing: &Spacing,
    curves: &[Curve],
    bead: f64,
    watch: Watch,
) -> Result<Vec<Vec<f64>>, PathError> {
    let levels: Vec<Vec<(f64, bool)>> =
        curves.iter().map(|curve| curve.points.iter().map(|at| spacing.width(at)).collect()).collect();
    let mut segments = Segments::of(curves, 4.0 / 3.0 * LOOKUP_DISTANCE * bead);
    // The boundary lies beside beads as other curves do.
    for h in (0..mesh.half_edges()).filter(|&h| mesh.twin(h).is_none()) {
        segments.add(ends_of(mesh, h), [BOUNDARY, h]);
    }
    segments.sort();
    let arcs = curves.iter().map(arcs).collect();
    let clearance = Clearance { mesh, curves, levels: &levels, segments, arcs, bead };
    let width = |number: usize, k: usize| match levels[number][k] {
        (_, true) => clearance.width(number, k),
        (width, false) => width,
    };
    let of_curve = |number: usize| {
        watch()?;
        Ok((0..curves[number].points.len()).map(|k| width(number, k)).collect())
    };
    (0..curves.len()).map(of_curve).collect()
}

fn ends_of(mesh: &SurfaceMesh, h: u32) -> [Point3<f64>; 2] {
    [mesh.tail(h), mesh.head(h)].map(|v| mesh.vertices()[v as usize])
}

/// Length of a curve up to each point, and of the whole.
fn arcs(curve: &Curve) -> Vec<f64> {
    let count = curve.points.len();
    let mut arcs = vec![0.0];
    for k in 0..curve.segments() {
        let step = (curve.points[(k + 1) % count].position - curve.points[k].position).norm();
        arcs.push(arcs[k] + step);
    }
    arcs
}

struct Clearance<'a> {
    mesh: &'a SurfaceMesh,
    curves: &'a [Curve],
    /// What levels say at each point, and whether it is on a bridge.
    levels: &'a [Vec<(f64, bool)>],
    segments: Segments,
    arcs: Vec<Vec<f64>>,
    bead: f64,
}

impl Clearance<'_> {
    /// The width at a point: the mean of the segments before and after it, each in its middle.
    fn width(&self, number: usize, point: usize) -> f64 {
        let (points, arcs) = (&self.curves[number].points, &self.arcs[number]);
        let (mut sum, mut count) = (0.0, 0.0);
        for k in [point.checked_sub(1), Some(point)].into_iter().flatten() {
            let ends = [points.get(k), points.get(k + 1)];
            let [Some(a), Some(b)] = ends.map(|at| at.map(|at| at.position)) else { continue };
            let Some(way) = (b - a).try_normalize(0.0) else { continue };
            let up = normal(self.mesh, points[k].triangle);
            let [left, right] = self.aside(number as u32, 0.5 * (arcs[k] + arcs[k + 1]), a + 0.5 * (b - a), [way, up]);
            sum += left + right;
            count += 1.0;
        }
        let width = if count > 0.0 { sum / count } else { self.bead };
        width.clamp(BEAD_WIDTHS[0] * self.bead, BEAD_WIDTHS[1] * self.bead)
    }

    /// The clearance on the left and on the right of a place of a curve.
    fn aside(&self, number: u32, arc: f64, p: Point3<f64>, [way, up]: [Vector3<f64>; 2]) -> [f64; 2] {
        let left = up.cross(&way);
        let mut clearance = [(LOOKUP_DISTANCE * self.bead, 0.5 * BEAD_WIDTHS[1] * self.bead); 2];
        for name in self.segments.near(p) {
            let ends = match name {
                [BOUNDARY, h] => ends_of(self.mesh, h),
                [other, k] => {
                    let (points, k) = (&self.curves[other as usize].points, k as usize);
                    [k, (k + 1) % points.len()].map(|k| points[k].position)
                }
            };
            // Where it passes straight aside.
            let [from, to] = ends.map(|end| (end - p).dot(&way));
            if (from < 0.0) == (to < 0.0) {
                continue;
            }
            let share = from / (from - to);
            let q = ends[0] + (ends[1] - ends[0]) * share;
            let to = q - p;
            let distance = to.norm();
            let side = usize::from(to.dot(&left) < 0.0);
            if distance >= clearance[side].0
                || to.dot(&up).abs() > MAX_HEIGHT_SHARE * distance
                || (name[0] == number && self.is_same(number, arc, name[1] as usize, (q - ends[0]).norm(), distance))
            {
                continue;
            }
            let left_over = match name {
                [BOUNDARY, _] => distance,
                [other, k] => {
                    let (levels, k) = (&self.levels[other as usize], k as usize);
                    let [(one, bridge), (two, also)] = [levels[k], levels[(k + 1) % levels.len()]];
                    if bridge || also { 0.5 * distance } else { distance - 0.5 * (one + (two - one) * share) }
                }
            };
            clearance[side] = (distance, left_over.max(0.0));
        }
        clearance.map(|(_, left_over)| left_over)
    }

    /// Whether a place of a curve is the continuation of another: no farther along the curve than straight, but for a
    /// factor.
    fn is_same(&self, number: u32, arc: f64, segment: usize, along: f64, distance: f64) -> bool {
        let arcs = &self.arcs[number as usize];
        (arcs[segment] + along - arc).abs() <= SAME_CURVE_RATIO * distance
    }
}
