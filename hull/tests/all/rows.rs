//! Row intervals against the question "is this point deep?" asked point by point.

use curvlay_hull::{ConvexHull, Depth, MAX_COORDINATE, RowIntervals, RowLattice};
use proptest::prelude::*;
use std::ops::RangeInclusive;

type Point = [i32; 3];

fn hull_of(points: &[Point], depth: f64) -> ConvexHull {
    let mut hull = ConvexHull::new(Depth::new(depth).unwrap());
    hull.insert(points).unwrap();
    hull
}

fn rows_of(lattice: RowLattice, hull: &ConvexHull) -> RowIntervals {
    let mut rows = RowIntervals::new(lattice).unwrap();
    rows.update(hull);
    rows
}

/// Every row: its interval and its y and z.
fn each_row(rows: &RowIntervals) -> Vec<(Option<RangeInclusive<i32>>, [i32; 2])> {
    let RowLattice { origin, step, count } = rows.lattice();
    let indices = (0..count[1]).flat_map(|z| (0..count[0]).map(move |y| [y, z]));
    indices.map(|[y, z]| (rows.interval(y, z), [origin[0] + step * y as i32, origin[1] + step * z as i32])).collect()
}

/// Asks for every point with `x` in `xs`; nothing may be deep beyond. Returns the number of deep points.
fn assert_point_by_point(rows: &RowIntervals, hull: &ConvexHull, xs: RangeInclusive<i32>) -> usize {
    let mut count = 0;
    for (interval, [y, z]) in each_row(rows) {
        let deep: Vec<i32> = xs.clone().filter(|&x| hull.is_deep([x, y, z])).collect();
        let found: Vec<i32> = interval.into_iter().flatten().collect();
        assert_eq!(found, deep, "row y {y}, z {z}");
        count += deep.len();
    }
    count
}

/// Rows that begin and end outside the body; with step 2 those of cell centres in doubled coordinates, which are odd.
fn lattice() -> impl Strategy<Value = RowLattice> {
    (prop::array::uniform2(-70..=-60), prop_oneof![Just(2), 3..=9]).prop_map(|(origin, step)| {
        let odd = |c: i32| if step == 2 { c | 1 } else { c };
        let count = (132 / step + 2) as u32;
        RowLattice { origin: origin.map(odd), step, count: [count; 2] }
    })
}

fn depths() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![0.0, 1.0, 2.0, 2.5])
}

fn cloud(most: usize) -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec(prop::array::uniform3(-60..=60), 1..most)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn large_bodies_point_by_point(points in cloud(200), lattice in lattice(), depth in depths()) {
        let hull = hull_of(&points, depth);
        assert_point_by_point(&rows_of(lattice, &hull), &hull, -64..=64);
    }

    #[test]
    fn slim_bodies_point_by_point(points in cloud(8), lattice in lattice(), depth in depths()) {
        let hull = hull_of(&points, depth);
        assert_point_by_point(&rows_of(lattice, &hull), &hull, -64..=64);
    }

    #[test]
    fn columns_point_by_point(
        section in prop::collection::vec(prop::array::uniform2(-60..=60), 3..40),
        points in cloud(100), lattice in lattice(), depth in depths(), top in -40..=40,
    ) {
        let depth = Depth::new(depth).unwrap();
        let Ok(mut column) = ConvexHull::column(&section, top, depth) else { return Ok(()) };
        let mut rows = rows_of(lattice, &column);
        assert_point_by_point(&rows, &column, -64..=64);
        column.insert(&points).unwrap();
        rows.update(&column);
        assert_point_by_point(&rows, &column, -64..=64);
    }

    #[test]
    fn intervals_grow_with_the_body(batches in prop::collection::vec(cloud(12), 1..12), lattice in lattice(), depth in depths()) {
        let mut hull = ConvexHull::new(Depth::new(depth).unwrap());
        let mut rows = rows_of(lattice, &hull);
        prop_assert!(each_row(&rows).iter().all(|(interval, _)| interval.is_none()));
        for batch in &batches {
            let before = each_row(&rows);
            hull.insert(batch).unwrap();
            rows.update(&hull);
            let now = each_row(&rows);
            prop_assert_eq!(&now, &each_row(&rows_of(lattice, &hull)));
            for ((before, row), (now, _)) in before.into_iter().zip(now) {
                if let Some(before) = before {
                    let kept = now.as_ref().is_some_and(|now| now.start() <= before.start() && before.end() <= now.end());
                    prop_assert!(kept, "{:?} became {:?} at {:?}", before, now, row);
                }
            }
        }
    }

    /// A what-if leaves no trace in the rows.
    #[test]
    fn rollback_brings_the_rows_back(points in cloud(40), more in cloud(10), lattice in lattice(), depth in depths()) {
        let mut hull = hull_of(&points, depth);
        let mut rows = rows_of(lattice, &hull);
        let before = each_row(&rows);
        let checkpoint = hull.checkpoint();
        hull.insert(&more).unwrap();
        rows.update(&hull);
        hull.rollback(checkpoint);
        rows.update(&hull);
        prop_assert_eq!(each_row(&rows), before);
    }

    /// Where `f64` would round: ends of rows across the whole range, from all planes in 128 bits.
    #[test]
    fn far_bodies_stay_exact(
        points in prop::collection::vec(prop::array::uniform3(prop_oneof![
            -MAX_COORDINATE..=MAX_COORDINATE, Just(MAX_COORDINATE), Just(-MAX_COORDINATE), -1..=1,
        ]), 4..40),
        depth in prop::sample::select(vec![0.0, 0.5, 2.0, 64.0]),
        step in prop_oneof![Just(1), 2..=2047],
        origin in prop::array::uniform2(-MAX_COORDINATE..=1),
    ) {
        let hull = hull_of(&points, depth);
        prop_assume!(hull.is_solid());
        assert_all_planes(&hull, RowLattice { origin, step, count: [32; 2] });
    }
}

fn assert_all_planes(hull: &ConvexHull, lattice: RowLattice) {
    for (interval, [y, z]) in each_row(&rows_of(lattice, hull)) {
        assert_eq!(interval, from_all_planes(hull, y, z), "row y {y}, z {z}");
    }
}

/// Found at random: a slim body across the whole range, rows that pass it at a slant.
#[test]
fn a_needle_across_the_whole_range() {
    let needle = [[0, 0, 0], [0, 0, -68], [-32_767, 29_486, -32_767], [-32_767, -32_767, -6_246]];
    assert_all_planes(&hull_of(&needle, 0.0), RowLattice { origin: [-1_293, -16_012], step: 1_763, count: [32; 2] });
}

/// The interval of one row as every plane bounds it.
fn from_all_planes(hull: &ConvexHull, y: i32, z: i32) -> Option<RangeInclusive<i32>> {
    let (mut low, mut high) = (i128::from(-MAX_COORDINATE), i128::from(MAX_COORDINATE));
    for plane in hull.planes() {
        let [nx, ny, nz] = plane.normal.map(i128::from);
        let rest = i128::from(plane.inner) - ny * i128::from(y) - nz * i128::from(z);
        match nx {
            0 if rest < 0 => return None,
            0 => {}
            1.. => high = high.min(rest.div_euclid(nx)),
            _ => low = low.max(-rest.div_euclid(-nx)),
        }
    }
    (low <= high).then_some(low as i32..=high as i32)
}

#[test]
fn a_ball_of_thousands_of_points_at_every_lattice_point() {
    let ball: Vec<Point> = cube(-20..=20).filter(|p| p.iter().map(|c| c * c).sum::<i32>() <= 20 * 20).collect();
    for (depth, least) in [(0.0, 33_000), (1.0, 27_000), (2.5, 20_000)] {
        let hull = hull_of(&ball, depth);
        let lattice = RowLattice { origin: [-23, -23], step: 1, count: [47; 2] };
        let deep = assert_point_by_point(&rows_of(lattice, &hull), &hull, -25..=25);
        assert!(deep > least, "{deep} points at depth {depth}");
    }
}

fn cube(side: RangeInclusive<i32>) -> impl Iterator<Item = Point> {
    let [xs, ys, zs] = [side.clone(), side.clone(), side];
    xs.flat_map(move |x| {
        let zs = zs.clone();
        ys.clone().flat_map(move |y| zs.clone().map(move |z| [x, y, z]))
    })
}

#[test]
fn blocks_with_many_coplanar_facets() {
    for batch in [1, 50, 1000] {
        let block: Vec<Point> = cube(0..=9).collect();
        let mut hull = ConvexHull::new(Depth::new(2.0).unwrap());
        let mut rows = RowIntervals::new(RowLattice { origin: [-3, -3], step: 1, count: [16; 2] }).unwrap();
        for points in block.chunks(batch) {
            hull.insert(points).unwrap();
            rows.update(&hull);
        }
        for (interval, [y, z]) in each_row(&rows) {
            let deep = (2..=7).contains(&y) && (2..=7).contains(&z);
            assert_eq!(interval, deep.then_some(2..=7), "row y {y}, z {z}");
        }
    }
}

/// Discs extruded along each axis, and sheared so that their lids are slanted.
#[test]
fn discs_extruded() {
    let disc: Vec<[i32; 2]> =
        cube(-15..=15).filter(|p| p[2] == 0 && p[0] * p[0] + p[1] * p[1] <= 15 * 15).map(|p| [p[0], p[1]]).collect();
    let placed = |kind: usize, [u, v]: [i32; 2], w: i32| match kind {
        0 => [u, v, w],
        1 => [w, u, v],
        2 => [v, w, u],
        _ => [u, v, w + u - 2 * v],
    };
    for kind in 0..4 {
        for depth in [0.0, 1.0, 2.5] {
            let points: Vec<Point> = disc.iter().flat_map(|&p| [0, 8, 19].map(|w| placed(kind, p, w))).collect();
            let hull = hull_of(&points, depth);
            let lattice = RowLattice { origin: [-50, -50], step: 1, count: [105; 2] };
            let deep = assert_point_by_point(&rows_of(lattice, &hull), &hull, -20..=20);
            assert!(deep > 2_000, "{deep}");
        }
    }
}

#[test]
fn bodies_without_volume_have_their_points_at_the_surface_only() {
    let slanted: Vec<Point> = (0..5).flat_map(|u| (0..5).map(move |v| [u + v, 2 * u - v, u])).collect();
    let segment = vec![[0, 0, 0], [6, -4, 2]];
    let along_x = vec![[-5, 1, 1], [8, 1, 1]];
    let lattice = RowLattice { origin: [-12, -3], step: 1, count: [30, 12] };
    let bodies = [(slanted, 25), (segment, 3), (along_x, 14), (vec![[3, 3, 3]; 2], 1), (vec![], 0)];
    for (points, count) in bodies {
        let surface = hull_of(&points, 0.0);
        assert!(!surface.is_solid());
        let found = assert_point_by_point(&rows_of(lattice, &surface), &surface, -15..=15);
        assert_eq!(found, count, "{points:?}");
        let below = hull_of(&points, 0.5);
        assert_eq!(assert_point_by_point(&rows_of(lattice, &below), &below, -15..=15), 0);
    }
}

#[test]
fn rows_are_forgotten_when_another_body_comes() {
    let lattice = RowLattice { origin: [0, 0], step: 1, count: [8; 2] };
    let mut rows = rows_of(lattice, &hull_of(&cube(0..=7).collect::<Vec<_>>(), 0.0));
    assert_eq!(rows.interval(3, 3), Some(0..=7));
    rows.update(&hull_of(&[[2, 3, 3], [4, 3, 3]], 0.0));
    assert_eq!((rows.interval(3, 3), rows.interval(3, 4)), (Some(2..=4), None));
    rows.update(&ConvexHull::new(Depth::SURFACE));
    assert!(each_row(&rows).iter().all(|(interval, _)| interval.is_none()));
}

#[test]
fn rows_far_from_the_body_are_empty() {
    let body = cube(-1..=1).collect::<Vec<_>>();
    let mut slanted = ConvexHull::new(Depth::SURFACE);
    slanted.insert(&[[0, 0, 0], [9, 1, 2], [-3, 8, 1], [2, -1, 7]]).unwrap();
    for hull in [hull_of(&body, 0.0), slanted] {
        for far in [20, MAX_COORDINATE - 10, -MAX_COORDINATE, (1 << 20) - 3, -(1 << 20)] {
            for origin in [[far, 0], [0, far], [far, far], [far, -far.max(4 - (1 << 20))]] {
                let rows = rows_of(RowLattice { origin, step: 1, count: [4; 2] }, &hull);
                assert!(each_row(&rows).iter().all(|(interval, _)| interval.is_none()), "{origin:?}");
            }
        }
    }
}

#[test]
fn a_column_reaches_down_for_ever() {
    let mut column = ConvexHull::column(&[[0, 0], [8, 0], [8, 8], [0, 8]], 0, Depth::new(1.0).unwrap()).unwrap();
    column.insert(&[[4, 4, 6]]).unwrap();
    let rows = rows_of(RowLattice { origin: [0, -30_000], step: 1, count: [9, 2] }, &column);
    for z in 0..2 {
        assert_eq!((rows.interval(1, z), rows.interval(7, z)), (Some(1..=7), Some(1..=7)));
        assert_eq!((rows.interval(0, z), rows.interval(8, z)), (None, None));
    }
}

#[test]
fn a_lattice_without_rows_has_none() {
    let hull = hull_of(&cube(0..=3).collect::<Vec<_>>(), 0.0);
    for count in [[0, 5], [5, 0], [0, 0]] {
        assert!(each_row(&rows_of(RowLattice { origin: [0, 0], step: 1, count }, &hull)).is_empty());
    }
}

#[test]
#[should_panic(expected = "row 8, 0 of 8 x 8")]
fn a_row_that_is_not_there() {
    RowIntervals::new(RowLattice { origin: [0, 0], step: 1, count: [8; 2] }).unwrap().interval(8, 0);
}

#[test]
fn rows_out_of_reach_are_refused() {
    let m = 1 << 20;
    for (origin, step, count) in [
        ([0, 0], 0, [1, 1]),
        ([0, 0], -1, [1, 1]),
        ([m + 1, 0], 1, [1, 1]),
        ([0, i32::MIN], 1, [1, 1]),
        ([0, 0], i32::MAX, [2, 1]),
        ([0, 0], 1, [u32::MAX, u32::MAX]),
        ([-m, -m], 1, [1 << 15, 1 << 15]),
    ] {
        let refused = RowIntervals::new(RowLattice { origin, step, count });
        assert_eq!(refused.err(), Some(curvlay_hull::HullError::Rows { origin, step, count }));
    }
    assert!(RowIntervals::new(RowLattice { origin: [-m, m], step: 2 * m, count: [2, 1] }).is_ok());
    assert!(RowIntervals::new(RowLattice { origin: [0, 0], step: 1, count: [0, 0] }).is_ok());
}
