//! Ten million insertions, each body with a certificate: its triangles are closed, no point lies beyond any of them, and their corners are points that were
//! inserted. That makes it the hull, whatever led there.

use curvlay_hull::{ConvexHull, Depth, MAX_COORDINATE};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::collections::{HashMap, HashSet};

type Point = [i32; 3];

const POINTS: usize = 1_000_000;
const BATCH: usize = 64;

fn within(random: &mut Pcg64Mcg, most: i32) -> i32 {
    random.random_range(-most..=most)
}

/// Anywhere in a ball.
fn in_ball(random: &mut Pcg64Mcg, radius: i32) -> Point {
    loop {
        let point = [0; 3].map(|_| within(random, radius));
        if point.iter().map(|&k| i64::from(k).pow(2)).sum::<i64>() <= i64::from(radius).pow(2) {
            return point;
        }
    }
}

fn minus(a: Point, b: Point) -> [i64; 3] {
    [0, 1, 2].map(|k| i64::from(a[k]) - i64::from(b[k]))
}

fn cross(u: [i64; 3], v: [i64; 3]) -> [i64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn dot(n: [i64; 3], p: Point) -> i64 {
    (0..3).map(|k| n[k] * i64::from(p[k])).sum()
}

/// That a body is the hull of the points.
fn certify(hull: &ConvexHull, points: &[Point]) {
    let inserted: HashSet<Point> = points.iter().copied().collect();
    assert!(hull.corners().iter().all(|corner| inserted.contains(corner)));
    let mut edges: HashMap<[Point; 2], i32> = HashMap::new();
    for [a, b, c] in hull.triangles().map(|corners| corners.map(|corner| corner.expect("all corners are finite"))) {
        let normal = cross(minus(b, a), minus(c, a));
        assert_ne!(normal, [0; 3], "{a:?} {b:?} {c:?}");
        let most = points.iter().map(|&point| dot(normal, point)).max();
        assert_eq!(most, Some(dot(normal, a)), "a point lies beyond {a:?} {b:?} {c:?}");
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *edges.entry([from, to]).or_default() += 1;
        }
    }
    assert!(
        hull.is_solid() && edges.iter().all(|([from, to], &count)| count == 1 && edges.contains_key(&[*to, *from]))
    );
}

/// Inserts a million points in small batches, and certifies the body on the way.
fn grow(name: &str, mut point: impl FnMut(&mut Pcg64Mcg, usize) -> Point) {
    let mut random = Pcg64Mcg::seed_from_u64(name.bytes().map(u64::from).sum());
    let mut hull = ConvexHull::new(Depth::default());
    let mut points = Vec::with_capacity(POINTS);
    let mut certified = 1_000;
    while points.len() < POINTS {
        let begin = points.len();
        points.extend((begin..POINTS.min(begin + BATCH)).map(|k| point(&mut random, k)));
        hull.insert(&points[begin..]).unwrap();
        if points.len() >= certified && hull.is_solid() {
            certify(&hull, &points);
            certified = 10 * points.len();
        }
    }
    certify(&hull, &points);
}

#[test]
#[ignore = "long: ten million insertions, minutes"]
fn ten_million_insertions_make_the_hull() {
    const FAR: i32 = MAX_COORDINATE;
    grow("a ball", |random, _| in_ball(random, 60));
    grow("a large ball", |random, _| in_ball(random, 4_000));
    grow("a ball that grows", |random, k| in_ball(random, 2 + (k / 40_000) as i32 * 40));
    grow("a cube", |random, _| [0; 3].map(|_| within(random, 200)));
    grow("as far as coordinates reach", |random, _| [0; 3].map(|_| within(random, FAR)));
    grow("few places", |random, _| [0; 3].map(|_| within(random, 2)));
    grow("a slanted plane, then a solid", |random, k| {
        let [x, y] = [0; 2].map(|_| within(random, 5_000));
        [x, y, x + y + i32::from(k > POINTS / 2) * within(random, 3)]
    });
    grow("a line, then a plane, then a solid", |random, k| {
        let [x, y, z] = [0; 3].map(|_| within(random, 900));
        [x, 2 * x + i32::from(k > POINTS / 4) * y, -x + i32::from(k > POINTS / 2) * z]
    });
    grow("a paraboloid", |random, _| {
        let [x, y] = [0; 2].map(|_| within(random, 120));
        [x, y, x * x + y * y]
    });
    grow("cells of a part, layer by layer", |random, k| {
        let z = (k / 10_000) as i32;
        let [x, y] = [0; 2].map(|_| within(random, 40 + z / 2));
        [2 * x + z, 2 * y, 2 * z]
    });
}
