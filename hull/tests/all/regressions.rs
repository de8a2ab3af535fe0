//! A test for each bug that was fixed.

use curvlay_hull::{ConvexHull, Depth, Location, MAX_COORDINATE, RowIntervals, RowLattice};

const M: i32 = MAX_COORDINATE;

fn hull_of(points: &[[i32; 3]]) -> ConvexHull {
    let mut hull = ConvexHull::new(Depth::SURFACE);
    hull.insert(points).unwrap();
    hull
}

/// Where planes cross a row far out, both ends were cut off at the same place, and that was taken for a point.
#[test]
fn rows_that_slanted_planes_cross_far_out_are_empty() {
    // At y = 40 the planes bound x to at least 1,200,000 and at most 1,199,961.
    let slanted = [[0, 0, 0], [1, 0, 0], [30_000, 1, 0], [0, 0, 1]];
    for mirrored in [1, -1] {
        let hull = hull_of(&slanted.map(|[x, y, z]| [mirrored * x, y, z]));
        let mut rows = RowIntervals::new(RowLattice { origin: [0, 0], step: 40, count: [2, 1] }).unwrap();
        rows.update(&hull);
        assert_eq!((rows.interval(0, 0), rows.interval(1, 0)), (Some(mirrored.min(0)..=mirrored.max(0)), None));
        let rows_inside = RowLattice { origin: [0, 0], step: 1, count: [2, 1] };
        let mut rows = RowIntervals::new(rows_inside).unwrap();
        rows.update(&hull);
        assert_eq!(rows.interval(1, 0), Some(30_000 * mirrored..=30_000 * mirrored));
    }
}

/// Heights over the plane of a flat body left 64 bits for points far outside.
#[test]
fn points_far_from_a_flat_body_are_outside() {
    let plate = hull_of(&[[-M, -M, -M], [M, -M, M], [-M, M, M]]);
    let segment = hull_of(&[[-M, -M, -M], [M, -M, M]]);
    for body in [plate, segment] {
        assert!(!body.is_solid());
        for far in [[i32::MAX, i32::MAX, i32::MIN], [i32::MIN; 3], [M + 1, 0, 0]] {
            assert_eq!((body.locate(far), body.is_deep(far)), (Location::Outside, false));
        }
    }
}

/// The point that gave a plate volume was counted together with the corners of the plate.
#[test]
fn corners_of_a_plate_do_not_extend_it_again() {
    let mut hull = hull_of(&[[0, 0, 0], [4, 0, 0], [0, 4, 0], [4, 4, 0]]);
    assert_eq!(hull.insert(&[[2, 2, 0], [2, 2, 4]]), Ok(1));
    assert_eq!(hull.insert(&[[2, 2, 4], [2, 2, 5], [2, 2, -5]]), Ok(2));
}
