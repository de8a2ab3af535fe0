//! On which side, and whether through: signs that always decide, and always agree with each other.
//!
//! The sheet is taken as moved, as a whole, by an infinitely small step against the mesh: `(e^2, e^3, e)` in x, y and
//! z. This is the simulation of simplicity of H. Edelsbrunner and E. P. Mücke, ACM Trans. Graphics 9(1), 1990, but with
//! one step for the whole sheet instead of one for each point: so a sheet that lies in a face of the mesh is on
//! one side of it as a whole.
//!
//! The step settles every case that matters. A point in the plane of a triangle is moved off it, since `n . step` is
//! not zero unless the normal `n` is. Lines along an edge of the sheet and an edge of the mesh that meet are moved
//! apart unless they are parallel; but a line parallel to an edge of a triangle has its ends on the same side of it and
//! does not pass through. So a sign is 0 only for triangles without area and for parallel edges, neither of which
//! is ever passed through.

use super::exact::{cross_sign, sign};
use nalgebra::Point3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// What of the two belongs to the sheet, and moves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Moves {
    Point,
    Triangle,
}

fn spatial(p: &Point3<f64>) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

/// The first sign that is not 0 along z, x and y: the sign of the product with the step.
fn along_step(component: impl Fn(usize, usize) -> i8) -> i8 {
    [(0, 1), (1, 2), (2, 0)].into_iter().map(|(i, j)| component(i, j)).find(|&sign| sign != 0).unwrap_or(0)
}

/// On which side of a triangle a point lies: +1 on that of its normal.
pub(super) fn side([a, b, c]: [&Point3<f64>; 3], p: &Point3<f64>, moves: Moves) -> i8 {
    // `orient3d` is positive below.
    let plain = -sign(orient3d(spatial(a), spatial(b), spatial(c), spatial(p)));
    if plain != 0 {
        return plain;
    }
    let normal = along_step(|i, j| {
        let flat = |p: &Point3<f64>| Coord { x: p[i], y: p[j] };
        sign(orient2d(flat(a), flat(b), flat(c)))
    });
    if moves == Moves::Point { normal } else { -normal }
}

/// How the line of an edge of the sheet passes that of an edge of the mesh: +1 and -1 are the two sides.
pub(super) fn passing([s, t]: [&Point3<f64>; 2], [m, n]: [&Point3<f64>; 2]) -> i8 {
    let plain = sign(orient3d(spatial(t), spatial(m), spatial(n), spatial(s)));
    if plain != 0 {
        return plain;
    }
    along_step(|i, j| {
        let flat = |p: &Point3<f64>| [p[i], p[j]];
        cross_sign(flat(s), flat(t), flat(m), flat(n))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_in_a_face_is_above_it() {
        let [a, b, c] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(Point3::from);
        let p = Point3::new(1.0, 1.0, 0.0);
        assert_eq!(side([&a, &b, &c], &p, Moves::Point), 1);
        assert_eq!(side([&a, &c, &b], &p, Moves::Point), -1);
        assert_eq!(side([&a, &b, &c], &p, Moves::Triangle), -1);
        let line = Point3::new(8.0, 0.0, 0.0);
        assert_eq!(side([&a, &b, &line], &p, Moves::Point), 0);
    }

    #[test]
    fn lines_that_meet_are_moved_apart_unless_they_are_parallel() {
        let [o, x, y, xy] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [4.0, 4.0, 0.0]].map(Point3::from);
        assert_eq!(passing([&o, &xy], [&x, &y]), -passing([&xy, &o], [&x, &y]));
        assert_ne!(passing([&o, &xy], [&x, &y]), 0);
        assert_eq!(passing([&o, &x], [&y, &xy]), 0);
    }
}
