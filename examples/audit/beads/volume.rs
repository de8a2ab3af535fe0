//! Beads in the cubes in which volumes are compared.

use super::super::part::Volume;
use super::runs::{Runs, steps};
use super::shape::middle;
use curvlay_toolpath::orientation::ToolPath;
use nalgebra::{Point3, Vector3};

/// Pieces of beads that are filled at once are no longer, in millimetres: the box of a slanted one is mostly empty.
const PIECE_MM: f64 = 3.0;

/// Whether a path is of the part, and not of support or a skirt.
pub fn is_of_part(path: &ToolPath) -> bool {
    path.waypoints.last().is_some_and(|last| !last.kind.is_support())
}

/// Covers what beads fill: rectangles as wide and high as they are, larger by a share of their height to all sides.
pub fn cover(volume: &mut Volume, paths: &[ToolPath], slack: f64) {
    for pair in paths.iter().filter(|path| is_of_part(path)).flat_map(|path| path.waypoints.windows(2)) {
        let [from, to] = [middle(&pair[0]), middle(&pair[1])];
        let count = steps((to - from).norm(), PIECE_MM);
        let larger = slack * pair[1].height;
        let half = [0.5 * pair[1].width + larger, 0.5 * pair[1].height + larger];
        for k in 0..count {
            let [a, b] = [k, k + 1].map(|k| from + (to - from) * (f64::from(k) / f64::from(count)));
            let reach = Vector3::repeat(half[0].hypot(half[1]));
            let mixed = pair[0].axis.into_inner() + pair[1].axis.into_inner();
            let direction = mixed.try_normalize(1e-9).unwrap_or(pair[1].axis.into_inner());
            volume.cover_where([a.inf(&b) - reach, a.sup(&b) + reach], |at| has(&[a, b], &direction, half, at));
        }
    }
}

/// Whether a place is in a bead; round at its ends, as the next piece goes on in another direction.
fn has(
    [a, b]: &[Point3<f64>; 2],
    direction: &Vector3<f64>,
    [half_width, half_height]: [f64; 2],
    at: &Point3<f64>,
) -> bool {
    let way = b - a;
    let squared = way.norm_squared();
    let share = if squared > 0.0 { ((at - a).dot(&way) / squared).clamp(0.0, 1.0) } else { 0.0 };
    let off = at - (a + way * share);
    let across = if squared > 0.0 { direction - way * (direction.dot(&way) / squared) } else { *direction };
    let up = across.try_normalize(1e-6).map_or(0.0, |across| off.dot(&across));
    up.abs() <= half_height && off.norm_squared() - up * up <= half_width * half_width
}

/// What of the beads is outside of the part.
pub fn outside(volume: &Volume, paths: &[ToolPath], step: f64) -> Runs {
    let mut runs = Runs::default();
    for path in paths.iter().filter(|path| is_of_part(path)) {
        for pair in path.waypoints.windows(2) {
            let [from, to] = [middle(&pair[0]), middle(&pair[1])];
            let length = pair[1].arc - pair[0].arc;
            let count = steps(length, step);
            let half = Vector3::repeat(0.5 * pair[1].width.max(pair[1].height) + step);
            for k in 0..count {
                let at = from + (to - from) * ((f64::from(k) + 0.5) / f64::from(count));
                let part = length / f64::from(count);
                let is_outside = !volume.has_part([at - half, at + half]);
                runs.step(part, is_outside.then_some(part), at, path.layer, true);
            }
        }
        runs.end();
    }
    runs
}
