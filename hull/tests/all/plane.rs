//! Planes and depths against squares in 128 bits.

use curvlay_hull::{ConvexHull, Depth, Location, MAX_COORDINATE, Plane};
use proptest::prelude::*;

/// `normal . (q - p)`.
fn height(normal: [i32; 3], p: [i32; 3], q: [i32; 3]) -> i128 {
    (0..3).map(|k| i128::from(normal[k]) * (i128::from(q[k]) - i128::from(p[k]))).sum()
}

fn squared(normal: [i32; 3]) -> i128 {
    normal.iter().map(|&c| i128::from(c).pow(2)).sum()
}

/// Whether `drop / |normal|` is `steps / 512` or more, or more only if `beyond`.
fn reaches(drop: i128, normal: [i32; 3], steps: u32, beyond: bool) -> bool {
    let (have, want) = ((512 * drop).pow(2), i128::from(steps).pow(2) * squared(normal));
    drop >= 0 && if beyond { have > want } else { have >= want }
}

fn depth(steps: u32, beyond: bool) -> Depth {
    let units = f64::from(steps) / 512.0;
    if beyond { Depth::beyond(units).unwrap() } else { Depth::new(units).unwrap() }
}

/// Depths by their number of steps; often whole units, which Pythagorean normals reach exactly.
fn steps() -> impl Strategy<Value = u32> {
    prop_oneof![0..=64 * 512u32, (0..=64u32).prop_map(|units| 512 * units)]
}

fn normals() -> impl Strategy<Value = [i32; 3]> {
    let pythagorean = prop::sample::select(vec![[0, 0, 1], [3, -4, 0], [1, 2, 2], [-2, 3, 6]]);
    prop_oneof![
        prop::array::uniform3(-9..=9),
        (pythagorean, 1..1 << 20).prop_map(|(normal, times)| normal.map(|c| times * c)),
        prop::array::uniform3(any::<i32>()),
    ]
}

fn points() -> impl Strategy<Value = [i32; 3]> {
    prop_oneof![prop::array::uniform3(-70..=70), prop::array::uniform3(-MAX_COORDINATE..=MAX_COORDINATE)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn heights_margins_and_depths_are_exact(
        normal in normals(), p in points(), q in points(), steps in steps(), beyond: bool,
    ) {
        let plane = Plane::at(normal, p, depth(steps, beyond));
        let expected = height(normal, p, q);
        prop_assert_eq!(i128::from(plane.height(q)), expected);
        prop_assert_eq!(plane.height(p), 0);
        prop_assert_eq!(plane.shows(q), !reaches(-expected, normal, steps, beyond));
        let margin = i128::from(plane.margin());
        prop_assert!(reaches(margin, normal, steps, beyond), "{}", margin);
        prop_assert!(margin == 0 || !reaches(margin - 1, normal, steps, beyond), "{}", margin);
        let length = (squared(normal) as f64).sqrt();
        prop_assert!((plane.length() - length).abs() <= 1e-12 * length);
    }

    #[test]
    fn reduced_planes_say_the_same(normal in normals(), p in points(), q in points(), steps in steps(), beyond: bool) {
        let plane = Plane::at(normal, p, depth(steps, beyond));
        let reduced = plane.reduced();
        prop_assert_eq!(plane.shows(q), reduced.shows(q));
        let divisor = reduced.normal.iter().zip(normal).find(|(of, _)| **of != 0).map_or(1, |(&of, c)| i64::from(c) / of);
        prop_assert!(divisor > 0);
        prop_assert_eq!(reduced.normal.map(|c| c * divisor), normal.map(i64::from));
        prop_assert_eq!(reduced.height(q) * divisor, plane.height(q));
        let common = |d: i64| reduced.normal.iter().all(|c| c.rem_euclid(d) == 0);
        prop_assert!(squared(normal) == 0 || ![2, 3, 5, 7, 11, 13].into_iter().any(common), "{:?}", reduced.normal);
    }

    #[test]
    fn depths_are_the_nearest_steps(units in 0.0..=64.0f64) {
        for depth in [Depth::new(units).unwrap(), Depth::beyond(units).unwrap()] {
            prop_assert!((depth.units() - units).abs() <= 0.5 / 512.0, "{}", depth.units());
        }
        prop_assert!((Depth::new(units) == Depth::new(0.0)) == (units < 0.5 / 512.0));
        prop_assert_ne!(Depth::new(units), Depth::beyond(units));
    }

    /// The planes of a hull are all there is to know about it.
    #[test]
    fn planes_of_hulls_decide_for_them(points in prop::collection::vec(prop::array::uniform3(-9..=9), 4..20), steps in 0..1500u32, beyond: bool) {
        let mut hull = ConvexHull::new(depth(steps, beyond));
        hull.insert(&points).unwrap();
        prop_assume!(hull.is_solid());
        let planes: Vec<Plane> = hull.planes().collect();
        for q in points.iter().flat_map(|&[x, y, z]| [[x, y, z], [-x, y, z], [x / 2, y / 3, z / 2], [y, z + 2, x]]) {
            prop_assert_eq!(hull.locate(q) == Location::Outside, planes.iter().any(|plane| plane.height(q) > 0));
            prop_assert_eq!(hull.is_deep(q), planes.iter().all(|plane| !plane.shows(q)));
        }
    }
}

/// Planes are plain numbers: what leaves 64 bits becomes the nearest number that does not.
#[test]
fn heights_beyond_64_bits_are_the_nearest() {
    let plane = |normal| Plane { normal, offset: 0, inner: 0 };
    let far = plane([i64::MAX, 1, 1]);
    assert_eq!((far.height([1, 0, 0]), far.height([2, 3, 4]), far.height([-2, 3, 4])), (i64::MAX, i64::MAX, i64::MIN));
    assert!(far.shows([2, 0, 0]) && !far.shows([-2, 0, 0]));
    // Sums that leave 64 bits on the way only are exact.
    assert_eq!(plane([i64::MAX, i64::MAX, i64::MAX]).height([1, 1, -1]), i64::MAX);
    assert_eq!(plane([i64::MAX, i64::MAX, i64::MAX]).height([2, 5, -7]), 0);
    assert_eq!(plane([1 << 62, 5, -1]).height([2, -1, -1]), i64::MAX - 3);
}
