//! The hull in space against brute force, on random and degenerate sets of points.

use curvlay_hull::{ConvexHull, Depth, HullError, Location, RowIntervals, RowLattice};
use proptest::prelude::*;

type Point = [i32; 3];

fn hull_of(points: &[Point], depth: Depth) -> ConvexHull {
    let mut hull = ConvexHull::new(depth);
    hull.insert(points).unwrap();
    hull
}

fn cross(u: [i64; 3], v: [i64; 3]) -> [i64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn minus(a: Point, b: Point) -> [i64; 3] {
    [0, 1, 2].map(|k| i64::from(a[k]) - i64::from(b[k]))
}

fn dot(n: [i64; 3], p: Point) -> i64 {
    (0..3).map(|k| n[k] * i64::from(p[k])).sum()
}

/// Every half-space that is bounded by three of the points and contains all of them: (normal, offset).
fn half_spaces(points: &[Point]) -> Vec<([i64; 3], i64)> {
    let mut found = Vec::new();
    for &a in points {
        for &b in points {
            for &c in points {
                let normal = cross(minus(b, a), minus(c, a));
                if normal != [0; 3] && points.iter().all(|&p| dot(normal, p) <= dot(normal, a)) {
                    found.push((normal, dot(normal, a)));
                }
            }
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// Whether four of the points span a volume.
fn spans_volume(points: &[Point]) -> bool {
    let a = points[0];
    points.iter().any(|&b| {
        points.iter().any(|&c| {
            points.iter().any(|&d| dot(cross(minus(b, a), minus(c, a)), d) != dot(cross(minus(b, a), minus(c, a)), a))
        })
    })
}

/// Point sets that are hard on a hull: few different coordinates, so that much is repeated, collinear and coplanar.
fn points(side: i32, most: usize) -> impl Strategy<Value = Vec<Point>> {
    let flattened = (prop::collection::vec(prop::array::uniform3(-side..=side), 1..most), 0..6usize);
    flattened.prop_map(|(mut points, kind)| {
        for p in &mut points {
            match kind {
                0 => p[2] = 3,                     // a plane
                1 => p[2] = p[0] + p[1],           // a slanted plane
                2 => *p = [p[0], 2 * p[0], -p[0]], // a line
                3 => *p = [1, 1, 1],               // one point again and again
                _ => {}
            }
        }
        points
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn faces_and_locations_agree_with_all_triples(points in points(3, 12), steps in 0u32..6) {
        let depth = Depth::new(f64::from(steps) / 4.0).unwrap();
        let hull = hull_of(&points, depth);
        prop_assert_eq!(hull.is_solid(), spans_volume(&points));
        let walls = half_spaces(&points);
        if hull.is_solid() {
            for plane in hull.planes() {
                prop_assert!(points.iter().all(|&p| plane.height(p) <= 0));
                prop_assert!(walls.iter().any(|(n, o)| cross(*n, plane.normal) == [0; 3]
                    && (0..3).all(|k| n[k].signum() == plane.normal[k].signum())
                    && points.iter().any(|&p| dot(*n, p) == *o && plane.height(p) == 0)));
            }
            let mut normals: Vec<_> = walls.iter().map(|(n, _)| primitive(*n)).collect();
            normals.sort_unstable();
            normals.dedup();
            let faces: Vec<_> = hull.faces().into_iter().map(|face| face.normal).collect();
            prop_assert_eq!(faces, normals);
        }
        let mut rows = RowIntervals::new(RowLattice { origin: [-4, -4], step: 1, count: [9, 9] }).unwrap();
        rows.update(&hull);
        for x in -4..=4 {
            for y in -4..=4 {
                for z in -4..=4 {
                    let p = [x, y, z];
                    let heights: Vec<i64> = walls.iter().map(|(n, o)| dot(*n, p) - o).collect();
                    let found = hull.locate(p);
                    if hull.is_solid() {
                        match found {
                            Location::Outside => prop_assert!(heights.iter().any(|&h| h > 0)),
                            Location::On => prop_assert!(heights.iter().all(|&h| h <= 0) && heights.contains(&0)),
                            Location::Inside { depth } => {
                                prop_assert!(heights.iter().all(|&h| h < 0));
                                let least = walls.iter().zip(&heights)
                                    .map(|((n, _), &h)| -h as f64 / (n.iter().map(|c| c * c).sum::<i64>() as f64).sqrt())
                                    .fold(f64::INFINITY, f64::min);
                                prop_assert!((depth - least).abs() < 1e-12);
                            }
                        }
                        // h^2 >= depth^2 n^2, in quarters of a unit
                        let deep = walls.iter().zip(&heights).all(|((n, _), &h)| {
                            h <= 0 && 16 * h * h >= i64::from(steps * steps) * n.iter().map(|c| c * c).sum::<i64>()
                        });
                        prop_assert_eq!(hull.is_deep(p), deep);
                    } else {
                        let with_p: Vec<_> = points.iter().copied().chain([p]).collect();
                        let unchanged = !spans_volume(&with_p) && hull_of(&with_p, depth).corners() == hull.corners();
                        prop_assert_eq!(found == Location::On, unchanged);
                        prop_assert_eq!(hull.is_deep(p), unchanged && steps == 0);
                    }
                    let in_row = rows.interval((y + 4) as u32, (z + 4) as u32).is_some_and(|xs| xs.contains(&x));
                    prop_assert_eq!(in_row, hull.is_deep(p), "{:?}", p);
                }
            }
        }
    }

    #[test]
    fn the_order_and_the_batches_do_not_matter(points in points(9, 60), split in 1usize..20, seed in 0u64..1000) {
        let whole = hull_of(&points, Depth::SURFACE);
        let mut shuffled = points.clone();
        shuffled.sort_by_key(|p| p.iter().fold(seed, |h, &c| h.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(17) ^ c as u64));
        let mut pieces = ConvexHull::new(Depth::SURFACE);
        for piece in shuffled.chunks(split) {
            pieces.insert(piece).unwrap();
        }
        prop_assert_eq!(pieces.corners(), whole.corners());
        prop_assert_eq!(pieces.faces(), whole.faces());
        prop_assert_eq!(pieces.volume_times_6(), whole.volume_times_6());
        prop_assert!(points.iter().all(|&p| whole.locate(p) != Location::Outside));
    }

    #[test]
    fn rollback_restores_exactly(points in points(9, 40), more in prop::collection::vec(points(12, 20), 1..5)) {
        let mut hull = hull_of(&points, Depth::new(1.0).unwrap());
        let state = |hull: &ConvexHull| (hull.triangles().collect::<Vec<_>>(), hull.planes().collect::<Vec<_>>(), hull.corners());
        let mut stack = Vec::new();
        for batch in &more {
            stack.push((state(&hull), hull.checkpoint()));
            hull.insert(batch).unwrap();
        }
        while let Some((before, checkpoint)) = stack.pop() {
            hull.rollback(checkpoint);
            prop_assert_eq!(state(&hull), before);
        }
        for batch in &more {
            let checkpoint = hull.checkpoint();
            hull.insert(batch).unwrap();
            hull.commit(checkpoint);
        }
        let all: Vec<_> = points.iter().chain(more.iter().flatten()).copied().collect();
        prop_assert_eq!(hull.faces(), hull_of(&all, Depth::SURFACE).faces());
    }

    /// A column is what the hull becomes when points far below every corner are added, seen from above.
    #[test]
    fn a_column_agrees_with_a_far_underside(points in points(6, 12), more in points(6, 12), steps in 0u32..6) {
        let section: Vec<[i32; 2]> = points.iter().map(|p| [p[0], p[1]]).collect();
        let depth = Depth::new(f64::from(steps) / 4.0).unwrap();
        let mut extruded: Vec<Point> = section.iter().map(|s| [s[0], s[1], 0]).collect();
        extruded.push([section[0][0], section[0][1], 1]);
        let column = ConvexHull::column(&section, 0, depth);
        prop_assert_eq!(column.is_ok(), spans_volume(&extruded));
        let Ok(mut column) = column else { return Ok(()) };
        let above: Vec<Point> = more.iter().map(|p| [p[0], p[1], p[2] + 7]).collect();
        column.insert(&above).unwrap();
        prop_assert_eq!(column.volume_times_6(), None);
        prop_assert_eq!(column.support([0, 0, -1]), None);
        let corners: Vec<Point> = section.iter().map(|s| [s[0], s[1], 0]).chain(above.iter().copied()).collect();
        // Far enough down nothing is slanted: every wall through two corners is vertical to within the lattice.
        let far = corners.iter().map(|p| [p[0], p[1], -20_000]);
        let deep = hull_of(&corners.iter().copied().chain(far).collect::<Vec<_>>(), depth);
        for x in -7..=7 {
            for y in -7..=7 {
                for z in -1..=14 {
                    prop_assert_eq!(column.is_deep([x, y, z]), deep.is_deep([x, y, z]), "{} {} {}", x, y, z);
                }
            }
        }
    }
}

fn primitive(v: [i64; 3]) -> [i64; 3] {
    let divisor = (1..=v.iter().map(|c| c.abs()).max().unwrap()).rev().find(|d| v.iter().all(|c| c % d == 0)).unwrap();
    v.map(|c| c / divisor)
}

#[test]
fn bodies_without_volume_are_known_for_what_they_are() {
    let empty = ConvexHull::new(Depth::SURFACE);
    assert_eq!(empty.locate([0, 0, 0]), Location::Outside);
    assert_eq!(empty.support([1, 0, 0]), None);
    let point = hull_of(&[[1, 2, 3]; 5], Depth::SURFACE);
    assert_eq!(
        (point.corners(), point.locate([1, 2, 3]), point.locate([1, 2, 4])),
        (vec![[1, 2, 3]], Location::On, Location::Outside)
    );
    let line = hull_of(&[[0, 0, 0], [4, 2, 6], [2, 1, 3]], Depth::SURFACE);
    assert_eq!(
        (line.corners().len(), line.locate([2, 1, 3]), line.locate([6, 3, 9])),
        (2, Location::On, Location::Outside)
    );
    let plate = hull_of(&[[0, 0, 0], [4, 0, 4], [0, 4, 4], [4, 4, 8], [2, 2, 4]], Depth::SURFACE);
    assert_eq!((plate.corners().len(), plate.is_solid(), plate.volume_times_6()), (4, false, Some(0)));
    assert_eq!((plate.locate([1, 1, 2]), plate.locate([1, 1, 3])), (Location::On, Location::Outside));
}

#[test]
fn extreme_coordinates_stay_exact() {
    let m = curvlay_hull::MAX_COORDINATE;
    let corners: Vec<Point> = (0..8).map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { m } else { -m })).collect();
    let hull = hull_of(&corners, Depth::new(64.0).unwrap());
    assert_eq!(hull.volume_times_6(), Some(6 * i128::from(2 * m).pow(3)));
    assert_eq!(hull.locate([m, m, m - 1]), Location::On);
    assert_eq!(hull.locate([m - 1, 0, 0]), Location::Inside { depth: 1.0 });
    assert!(hull.is_deep([m - 64, 0, 0]) && !hull.is_deep([m - 63, 0, 0]));
    let slim = hull_of(&[[-m, -m, -m], [m, m, m - 1], [m, m - 1, m], [m - 1, m, m]], Depth::SURFACE);
    assert_eq!(slim.faces().len(), 4);
}

#[test]
fn bad_input_changes_nothing() {
    let mut hull = hull_of(&[[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]], Depth::SURFACE);
    let error = hull.insert(&[[9, 9, 9], [0, 1 << 15, 0]]);
    assert_eq!(error, Err(HullError::OutOfReach { index: 1, value: 1 << 15 }));
    assert_eq!(hull.insert(&[[0, i32::MIN, 0]]), Err(HullError::OutOfReach { index: 0, value: i32::MIN }));
    assert_eq!(hull.corners().len(), 4);
    assert_eq!(hull.insert(&[]), Ok(0));
    assert!(matches!(ConvexHull::column(&[[0, 0], [1, 1], [2, 2]], 0, Depth::SURFACE), Err(HullError::NoArea)));
    assert!(matches!(
        ConvexHull::column(&[[0, 0], [1, 1], [2, 0]], 1 << 15, Depth::SURFACE),
        Err(HullError::OutOfReach { .. })
    ));
}
