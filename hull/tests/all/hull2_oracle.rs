//! The plane hull against brute force: the hull of points is all that lies on or between them, in a segment of two or in a
//! triangle of three (Caratheodory).

use curvlay_hull::{ConvexHull2, Depth, HullError, Location2, MAX_COORDINATE, convex_polygon};
use proptest::prelude::*;

type Point = [i32; 2];

fn hull_of(points: &[Point], depth: Depth) -> ConvexHull2 {
    let mut hull = ConvexHull2::new(depth);
    hull.insert(points).unwrap();
    hull
}

/// Twice the signed area of the triangle, positive if it turns left.
fn turn(a: Point, b: Point, c: Point) -> i128 {
    let [[ax, ay], [bx, by], [cx, cy]] = [a, b, c].map(|p| p.map(i128::from));
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// Whether `p` lies on the closed segment from `a` to `b`.
fn on_segment(a: Point, b: Point, p: Point) -> bool {
    turn(a, b, p) == 0 && (0..2).all(|k| a[k].min(b[k]) <= p[k] && p[k] <= a[k].max(b[k]))
}

/// Whether `p` lies in the hull of `points`.
fn within(points: &[Point], p: Point) -> bool {
    let in_triangle = |a, b, c| {
        let turns = [turn(a, b, p), turn(b, c, p), turn(c, a, p)];
        turn(a, b, c) != 0 && (turns.iter().all(|&t| t >= 0) || turns.iter().all(|&t| t <= 0))
    };
    points.iter().enumerate().any(|(i, &a)| {
        points[..=i]
            .iter()
            .enumerate()
            .any(|(j, &b)| on_segment(a, b, p) || points[..j].iter().any(|&c| in_triangle(a, b, c)))
    })
}

/// Points that are not in the hull of the others, in lexical order.
fn extreme_points(points: &[Point]) -> Vec<Point> {
    let mut distinct = points.to_vec();
    distinct.sort_unstable();
    distinct.dedup();
    let others = |p: Point| distinct.iter().copied().filter(|&q| q != p).collect::<Vec<_>>();
    distinct.iter().copied().filter(|&p| !within(&others(p), p)).collect()
}

/// Every half-plane on the left of two of the points that contains all of them.
fn half_planes(points: &[Point]) -> Vec<[Point; 2]> {
    let pairs = points.iter().flat_map(|&a| points.iter().map(move |&b| [a, b]));
    pairs.filter(|&[a, b]| a != b && points.iter().all(|&p| turn(a, b, p) >= 0)).collect()
}

fn has_area(points: &[Point]) -> bool {
    points.iter().any(|&b| points.iter().any(|&c| turn(points[0], b, c) != 0))
}

fn squared_length([a, b]: [Point; 2]) -> i128 {
    (0..2).map(|k| (i128::from(b[k]) - i128::from(a[k])).pow(2)).sum()
}

/// Whether `p` lies in the hull, at least `steps / per_unit` from every edge.
fn deep(points: &[Point], walls: &[[Point; 2]], p: Point, steps: i128, per_unit: i128) -> bool {
    if !has_area(points) {
        return steps == 0 && within(points, p);
    }
    walls.iter().all(|&[a, b]| {
        let height = turn(a, b, p);
        height >= 0 && (per_unit * height).pow(2) >= steps * steps * squared_length([a, b])
    })
}

/// Corners counter-clockwise, from the least in lexical order, and all of them true corners.
fn assert_in_order(corners: &[Point]) {
    assert_eq!(corners.first(), corners.iter().min());
    if corners.len() > 2 {
        for k in 0..corners.len() {
            let [a, b, c] = [0, 1, 2].map(|ahead| corners[(k + ahead) % corners.len()]);
            assert!(turn(a, b, c) > 0, "no left turn at {b:?} of {corners:?}");
        }
    }
}

/// Point sets that are hard on a hull: few different coordinates, points on a line, one point again and again.
fn points(side: i32, most: usize) -> impl Strategy<Value = Vec<Point>> {
    (prop::collection::vec(prop::array::uniform2(-side..=side), 1..most), 0..8usize).prop_map(|(mut points, kind)| {
        for p in &mut points {
            match kind {
                0 => p[1] = 1,
                1 => p[0] = -2,
                2 => p[1] = 1 - p[0],
                3 => *p = [2, -1],
                _ => {}
            }
        }
        points
    })
}

/// Coordinates within reach, often at its end.
fn far() -> impl Strategy<Value = Vec<Point>> {
    const M: i32 = MAX_COORDINATE;
    let coordinate = prop_oneof![-M..=M, -M..=-M + 2, M - 2..=M, -2..=2];
    prop::collection::vec(prop::array::uniform2(coordinate), 1..10)
}

/// Any coordinates, often the most extreme there are.
fn anywhere() -> impl Strategy<Value = Vec<Point>> {
    let coordinate = prop_oneof![any::<i32>(), i32::MIN..=i32::MIN + 2, i32::MAX - 2..=i32::MAX, -2..=2];
    prop::collection::vec(prop::array::uniform2(coordinate), 0..10)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(800))]

    #[test]
    fn corners_locations_and_rows_agree_with_brute_force(points in points(4, 12), steps in 0u32..10) {
        let depth = Depth::new(f64::from(steps) / 4.0).unwrap();
        let hull = hull_of(&points, depth);
        assert_in_order(hull.corners());
        let mut corners = hull.corners().to_vec();
        corners.sort_unstable();
        prop_assert_eq!(corners, extreme_points(&points));
        let walls = half_planes(&points);
        let (mut inside, mut on) = (0, 0);
        for y in -6..=6 {
            let mut row = Vec::new();
            for x in -6..=6 {
                let p = [x, y];
                let least = walls.iter()
                    .map(|&[a, b]| turn(a, b, p) as f64 / (squared_length([a, b]) as f64).sqrt())
                    .fold(f64::INFINITY, f64::min);
                let on_wall = walls.iter().any(|&[a, b]| turn(a, b, p) == 0) || !has_area(&points);
                match hull.locate(p) {
                    Location2::Outside => prop_assert!(!within(&points, p), "{:?}", p),
                    Location2::On => {
                        on += 1;
                        prop_assert!(within(&points, p) && on_wall, "{:?}", p);
                    }
                    Location2::Inside { depth } => {
                        inside += 1;
                        prop_assert!(within(&points, p) && !on_wall, "{:?}", p);
                        prop_assert!((depth - least).abs() < 1e-12, "{:?}: {} {}", p, depth, least);
                    }
                }
                prop_assert_eq!(hull.is_deep(p), deep(&points, &walls, p, i128::from(steps), 4), "{:?}", p);
                if hull.is_deep(p) {
                    row.push(x);
                }
            }
            let ends = row.first().zip(row.last()).map(|(&first, &last)| first..=last);
            prop_assert_eq!(hull.row_interval(y), ends.clone());
            prop_assert_eq!(row.len(), ends.map_or(0, Iterator::count));
        }
        // Pick's theorem: the area is the lattice points inside and half of those on the boundary, less one.
        let area = if has_area(&points) { 2 * inside + on - 2 } else { 0 };
        prop_assert_eq!(hull.area_times_2(), area);
    }

    #[test]
    fn support_is_the_farthest_of_all_points(points in points(9, 30), direction in prop::array::uniform2(any::<i32>())) {
        let [dx, dy] = direction.map(i64::from);
        let reach = points.iter().map(|&[x, y]| dx * i64::from(x) + dy * i64::from(y)).max();
        prop_assert_eq!(hull_of(&points, Depth::SURFACE).support(direction), reach);
    }

    #[test]
    fn the_order_and_the_batches_do_not_matter(points in points(9, 40).prop_shuffle(), split in 1usize..9) {
        let mut sorted = points.clone();
        sorted.sort_unstable();
        let whole = hull_of(&sorted, Depth::SURFACE);
        let mut pieces = ConvexHull2::new(Depth::SURFACE);
        for piece in points.chunks(split) {
            pieces.insert(piece).unwrap();
        }
        prop_assert_eq!(pieces, whole);
    }

    #[test]
    fn rollback_restores_exactly(first in points(6, 9), more in prop::collection::vec(points(9, 9), 1..5)) {
        let mut hull = hull_of(&first, Depth::SURFACE);
        let mut stack = Vec::new();
        for batch in &more {
            stack.push((hull.clone(), hull.checkpoint()));
            hull.insert(batch).unwrap();
        }
        while let Some((before, checkpoint)) = stack.pop() {
            hull.rollback(checkpoint);
            prop_assert_eq!(&hull, &before);
        }
        prop_assert_eq!(hull, hull_of(&first, Depth::SURFACE));
    }

    /// Squares of 70 bits: where `f64` would round, depth is still decided exactly.
    #[test]
    fn far_points_stay_exact(points in far(), steps in 0u32..=64 * 512, probes in prop::collection::vec(prop::array::uniform2(any::<i16>()), 8)) {
        let depth = Depth::new(f64::from(steps) / 512.0).unwrap();
        let hull = hull_of(&points, depth);
        let mut corners = hull.corners().to_vec();
        corners.sort_unstable();
        prop_assert_eq!(corners, extreme_points(&points));
        let walls = half_planes(&points);
        let is_deep = |p| deep(&points, &walls, p, i128::from(steps), 512);
        for [x, y] in probes.into_iter().map(|probe| probe.map(i32::from)).chain(points.iter().copied()) {
            prop_assert_eq!(hull.is_deep([x, y]), is_deep([x, y]));
            prop_assert_eq!(hull.locate([x, y]) != Location2::Outside, within(&points, [x, y]));
            match hull.row_interval(y) {
                Some(row) => {
                    prop_assert!(is_deep([*row.start(), y]) && !is_deep([row.start() - 1, y]));
                    prop_assert!(is_deep([*row.end(), y]) && !is_deep([row.end() + 1, y]));
                }
                None => prop_assert!(!is_deep([x, y])),
            }
        }
    }

    #[test]
    fn polygons_are_exact_for_any_coordinates(points in anywhere()) {
        let corners = convex_polygon(&points);
        assert_in_order(&corners);
        let mut sorted = corners.clone();
        sorted.sort_unstable();
        prop_assert_eq!(sorted, extreme_points(&points));
        prop_assert_eq!(convex_polygon(&corners), corners);
    }
}

#[test]
fn few_points_make_few_corners() {
    assert_eq!(convex_polygon(&[]), Vec::<Point>::new());
    assert_eq!(convex_polygon(&[[3, 3]; 4]), [[3, 3]]);
    assert_eq!(convex_polygon(&[[4, 2], [0, 0], [2, 1], [4, 2]]), [[0, 0], [4, 2]]);
    let [low, high] = [i32::MIN, i32::MAX];
    assert_eq!(
        convex_polygon(&[[high, high], [0, 0], [low, high], [-1, -1], [high, low], [low, low]]),
        [[low, low], [high, low], [high, high], [low, high]]
    );
    // A triangle of area 1/2, 2^33 long: one unit to the side decides.
    let sliver = [[low, low], [high, high], [high - 1, high]];
    assert_eq!(convex_polygon(&sliver), sliver);
    assert_eq!(convex_polygon(&[[low, low], [high, high], [high - 1, high - 1]]), [[low, low], [high, high]]);
}

#[test]
fn polygons_without_area_are_known_for_what_they_are() {
    let empty = ConvexHull2::new(Depth::SURFACE);
    assert_eq!((empty.locate([0, 0]), empty.is_deep([0, 0])), (Location2::Outside, false));
    assert_eq!((empty.support([1, 0]), empty.row_interval(0), empty.area_times_2()), (None, None, 0));
    let point = hull_of(&[[1, 2]; 3], Depth::SURFACE);
    assert_eq!((point.locate([1, 2]), point.locate([1, 3])), (Location2::On, Location2::Outside));
    assert_eq!((point.row_interval(2), point.row_interval(3)), (Some(1..=1), None));
    let segment = hull_of(&[[0, 0], [6, 3], [4, 2]], Depth::SURFACE);
    assert_eq!(segment.corners(), [[0, 0], [6, 3]]);
    assert_eq!((segment.locate([2, 1]), segment.locate([8, 4])), (Location2::On, Location2::Outside));
    assert_eq!((segment.row_interval(1), segment.row_interval(4)), (Some(2..=2), None));
    let level = hull_of(&[[-3, 5], [4, 5]], Depth::SURFACE);
    assert_eq!((level.row_interval(5), level.row_interval(6)), (Some(-3..=4), None));
    let nothing_is_deep = hull_of(&[[-3, 5], [4, 5]], Depth::new(0.5).unwrap());
    assert_eq!((nothing_is_deep.is_deep([0, 5]), nothing_is_deep.row_interval(5)), (false, None));
}

/// Found: a row of a segment looked at every point as far as the segment goes, for longer than the fuzzer waits.
#[test]
fn rows_of_the_longest_segments_are_known_at_once() {
    const M: i32 = MAX_COORDINATE;
    let [rising, steep] = [[[-M, -M], [M, M]], [[0, -M], [1, M]]].map(|ends| hull_of(&ends, Depth::SURFACE));
    for y in -M..=M {
        assert_eq!(rising.row_interval(y), Some(y..=y));
        let x = (y == -M).then_some(0).or((y == M).then_some(1));
        assert_eq!(steep.row_interval(y), x.map(|x| x..=x));
    }
    assert_eq!((rising.row_interval(i32::MIN), rising.row_interval(i32::MAX)), (None, None));
}

#[test]
fn the_largest_square_stays_exact() {
    const M: i32 = MAX_COORDINATE;
    let square = hull_of(&[[-M, -M], [M, -M], [M, M], [-M, M]], Depth::new(64.0).unwrap());
    assert_eq!(square.area_times_2(), 2 * (2 * i128::from(M)).pow(2));
    assert_eq!(square.row_interval(0), Some(64 - M..=M - 64));
    assert_eq!((square.row_interval(M - 64), square.row_interval(M - 63)), (Some(64 - M..=M - 64), None));
    assert_eq!(square.locate([M, M - 1]), Location2::On);
    assert_eq!(square.support([i32::MAX, i32::MIN]), Some((i64::from(i32::MAX) - i64::from(i32::MIN)) * i64::from(M)));
    for p in [[i32::MIN, i32::MAX], [i32::MAX, 0], [0, i32::MIN]] {
        assert_eq!((square.locate(p), square.is_deep(p)), (Location2::Outside, false));
    }
    assert_eq!((square.row_interval(i32::MIN), square.row_interval(i32::MAX)), (None, None));
}

#[test]
fn bad_input_changes_nothing() {
    let mut hull = hull_of(&[[0, 0], [4, 0], [0, 4]], Depth::SURFACE);
    for value in [MAX_COORDINATE + 1, -MAX_COORDINATE - 1, i32::MIN, i32::MAX] {
        let error = hull.insert(&[[9, 9], [5, 5], [0, value]]).unwrap_err();
        assert_eq!(error, HullError::OutOfReach { index: 2, value });
        assert_eq!(error.to_string(), format!("point 2 has the coordinate {value}, beyond 32767"));
        assert_eq!(hull.corners(), [[0, 0], [4, 0], [0, 4]]);
    }
    assert_eq!(hull.insert(&[]), Ok(()));
    for units in [-0.25, 64.25, f64::INFINITY, f64::NAN] {
        assert!(matches!(Depth::new(units), Err(HullError::Depth { .. })), "{units}");
    }
    assert_eq!(Depth::new(-1.0), Err(HullError::Depth { units: -1.0 }));
}
