//! Where a triangle of the sheet and one of the mesh pass through each other.
//!
//! In general position (see [`super::predicates`]) they share nothing or a segment, and each end of it lies where an
//! edge of one passes through the other. The segment is directed so that, seen from the front of the sheet, the
//! back of the mesh triangle lies to its left: outside a closed mesh that looks outwards is to the right.

use super::exact::height;
use super::predicates::{Moves, passing, side};
use nalgebra::Point3;

/// An end of a segment: the number of the side, of one triangle, that passes through the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// Side of the sheet's triangle.
    Sheet(u8),
    /// Side of the mesh's triangle.
    Mesh(u8),
}

/// Start and end of the segment that a triangle of the sheet shares with one of the mesh.
pub(super) fn meet(sheet: [&Point3<f64>; 3], mesh: [&Point3<f64>; 3]) -> Option<[End; 2]> {
    let over = sheet.map(|p| side(mesh, p, Moves::Point));
    if over[0] != 0 && over == [over[0]; 3] {
        return None;
    }
    let above = mesh.map(|p| side(sheet, p, Moves::Triangle));
    if above[0] != 0 && above == [above[0]; 3] {
        return None;
    }
    const UNKNOWN: i8 = 2;
    let mut known = [[UNKNOWN; 3]; 3];
    let mut pass = |i: usize, j: usize| {
        if known[i][j] == UNKNOWN {
            known[i][j] = passing([sheet[i], sheet[(i + 1) % 3]], [mesh[j], mesh[(j + 1) % 3]]);
        }
        known[i][j]
    };
    let (mut start, mut end) = (None, None);
    let mut take = |place: End, starts: bool| *(if starts { &mut start } else { &mut end }) = Some(place);
    for k in 0..3 {
        let next = (k + 1) % 3;
        if over[k] * over[next] < 0 && through([pass(k, 0), pass(k, 1), pass(k, 2)]) {
            take(End::Sheet(k as u8), over[k] < 0);
        }
        if above[k] * above[next] < 0 && through([pass(0, k), pass(1, k), pass(2, k)]) {
            take(End::Mesh(k as u8), above[k] > 0);
        }
    }
    Some([start?, end?])
}

/// Whether a line that passes the sides of a triangle like this goes through it.
pub(super) fn through(signs: [i8; 3]) -> bool {
    signs[0] != 0 && signs == [signs[0]; 3]
}

/// How often the mesh triangle is left through its front on the way from `from` to `to`, both of which move with the
/// sheet: 1, 0 or -1.
pub(super) fn leaves(from: &Point3<f64>, to: &Point3<f64>, mesh: [&Point3<f64>; 3]) -> i32 {
    let ends = [from, to].map(|p| side(mesh, p, Moves::Point));
    if ends[0] * ends[1] >= 0 {
        return 0;
    }
    let passes = [0, 1, 2].map(|k| passing([from, to], [mesh[k], mesh[(k + 1) % 3]]));
    if through(passes) { i32::from(ends[1]) } else { 0 }
}

/// Where the edge from `low` to `high` passes through the plane of a triangle: the share of the way, and the place.
pub(super) fn pierce(low: &Point3<f64>, high: &Point3<f64>, triangle: [&Point3<f64>; 3]) -> (f64, Point3<f64>) {
    let [before, after] = [low, high].map(|p| height(triangle, p).abs());
    let share = before / (before + after);
    // Both heights may round to nothing; then any place of the edge is in the plane.
    let share = if share.is_finite() { share } else { 0.5 };
    // From the nearer end, so that an end in the plane is met exactly.
    let place = if share <= 0.5 { low + (high - low) * share } else { high + (low - high) * (1.0 - share) };
    (share, place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn points(at: [[f64; 3]; 3]) -> [Point3<f64>; 3] {
        at.map(Point3::from)
    }

    #[test]
    fn the_back_of_the_mesh_is_to_the_left() {
        // A flat sheet seen from above; the mesh triangle stands across it and looks to +x.
        let sheet = points([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let mesh = points([[1.0, -9.0, -9.0], [1.0, 9.0, -9.0], [1.0, 0.0, 9.0]]);
        let [a, b, c] = [0, 1, 2].map(|k| &mesh[k]);
        // Through the bottom side (0) and the slanted one (1); to its left is -x, so it runs up along y.
        assert_eq!(meet(sheet.each_ref(), [a, b, c]), Some([End::Sheet(0), End::Sheet(1)]));
        assert_eq!(meet(sheet.each_ref(), [a, c, b]), Some([End::Sheet(1), End::Sheet(0)]));
        let (share, at) = pierce(&sheet[0], &sheet[1], [a, b, c]);
        assert_relative_eq!(share, 0.25);
        assert_relative_eq!(at, Point3::new(1.0, 0.0, 0.0));

        let small = points([[1.0, 0.5, -1.0], [1.0, 1.5, -1.0], [1.0, 1.0, 1.0]]);
        assert_eq!(meet(sheet.each_ref(), small.each_ref()), Some([End::Mesh(2), End::Mesh(1)]));
        assert_eq!(leaves(&Point3::origin(), &Point3::new(2.0, 2.0, 0.0), small.each_ref()), 1);
        assert_eq!(leaves(&Point3::new(2.0, 2.0, 0.0), &Point3::origin(), small.each_ref()), -1);
    }

    #[test]
    fn a_shared_plane_is_not_crossed() {
        let sheet = points([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        assert_eq!(meet(sheet.each_ref(), sheet.each_ref()), None);
    }
}
