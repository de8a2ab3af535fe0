//! The geometric indicator: grids against brute force, gradients, and rates in a made-up cell against an exact scene.

use crate::common::{Fixed, cell};
use curvlay_trajectory::indicator::geometric::{
    Ball, Bodies, BodiesFn, Capsule, Cylinder, DistanceGrid, GeometricError, GeometricIndicator, GeometricModel,
    GridError, MAX_BODIES, Plane, Twist,
};
use curvlay_trajectory::indicator::{CollisionIndicator, Rates, verification_samples};
use curvlay_trajectory::nalgebra::{IsometryMatrix3, Point3, Unit, Vector3};
use proptest::prelude::*;

/// The signed distance of a point to a union of cubes, cube by cube; inside, the distance to the nearest empty one.
fn slow_cells(dims: [u32; 3], is_solid: impl Fn([i64; 3]) -> bool, cell: f64, p: &Point3<f64>) -> f64 {
    let to_cube = |c: [i64; 3]| {
        let off = |d: usize| {
            let low = c[d] as f64 * cell;
            (low - p[d]).max(p[d] - low - cell).max(0.0)
        };
        off(0).hypot(off(1)).hypot(off(2))
    };
    let n = dims.map(i64::from);
    let cubes = || (-1..=n[2]).flat_map(|z| (-1..=n[1]).flat_map(move |y| (-1..=n[0]).map(move |x| [x, y, z])));
    let least = |wanted: bool| cubes().filter(|&c| is_solid(c) == wanted).map(to_cube).fold(f64::INFINITY, f64::min);
    let outside = least(true);
    if outside > 0.0 { outside } else { -least(false) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn cells_have_the_distance_of_brute_force(
        dims in (1u32..70, 1u32..5, 1u32..5), seed in any::<u64>(), density in 0.05..0.95f64,
        at in proptest::array::uniform3(-3.0..1.0f64),
    ) {
        let dims = [dims.0, dims.1, dims.2];
        let words = dims[0].div_ceil(64) as usize;
        let mut fixed = Fixed(seed);
        let mut rows = vec![0u64; words * (dims[1] * dims[2]) as usize];
        for row in rows.chunks_mut(words) {
            (0..dims[0] as usize).for_each(|x| row[x / 64] |= u64::from(fixed.unit() < density) << (x % 64));
        }
        let is_solid = |c: [i64; 3]| {
            (0..3).all(|d| c[d] >= 0 && c[d] < i64::from(dims[d])) && {
                let row = words * (c[1] + i64::from(dims[1]) * c[2]) as usize;
                rows[row + c[0] as usize / 64] >> (c[0] % 64) & 1 == 1
            }
        };
        let cell = 1.5;
        let Ok(grid) = DistanceGrid::from_cells(dims, &rows, cell, &Point3::origin(), 3) else {
            prop_assert!(rows.iter().all(|&row| row == 0));
            return Ok(());
        };
        // On nodes it is exact.
        let node = [0, 1, 2].map(|d| ((at[d] + 3.0) / 4.0 * f64::from(dims[d] + 6) - 3.0).round() * cell);
        let exact = slow_cells(dims, is_solid, cell, &node.into());
        prop_assert!((grid.distance(&node.into()) - exact).abs() < 1e-5, "{} {exact}", grid.distance(&node.into()));
        // Between them, and off the lattice, within the bound; there at most too small by what the corner hides.
        let between: Point3<f64> = [0, 1, 2].map(|d| (at[d] + 3.0) / 4.0 * f64::from(dims[d] + 20) * cell - 10.0 * cell).into();
        let exact = slow_cells(dims, is_solid, cell, &between);
        let found = grid.distance(&between);
        prop_assert!(found - exact <= grid.error_bound(), "{found} {exact}");
        let is_within = (0..3).all(|d| between[d] >= -3.0 * cell && between[d] <= (f64::from(dims[d]) + 3.0) * cell);
        if is_within {
            prop_assert!((found - exact).abs() <= grid.error_bound(), "{found} {exact}");
        }
    }

    /// The far lattice: its nodes are exact, and a grid with much room is as right as one with little.
    #[test]
    fn far_distances_are_those_of_brute_force(
        dims in (1u32..9, 1u32..9, 1u32..9), seed in any::<u64>(), room in 17u32..70,
        at in proptest::array::uniform3(0.0..1.0f64),
    ) {
        let dims = [dims.0, dims.1, dims.2];
        let mut fixed = Fixed(seed);
        let mut rows = vec![0u64; (dims[1] * dims[2]) as usize];
        rows.iter_mut().for_each(|row| (0..dims[0]).for_each(|x| *row |= u64::from(fixed.unit() < 0.3) << x));
        rows[0] |= 1;
        let is_solid = |c: [i64; 3]| {
            (0..3).all(|d| c[d] >= 0 && c[d] < i64::from(dims[d]))
                && rows[(c[1] + i64::from(dims[1]) * c[2]) as usize] >> c[0] & 1 == 1
        };
        let cell = 0.5;
        let grid = DistanceGrid::from_cells(dims, &rows, cell, &Point3::origin(), room).unwrap();
        let wide = [0, 1, 2].map(|d| f64::from(dims[d] + 2 * room));
        let any: Point3<f64> = [0, 1, 2].map(|d| (at[d] * wide[d] - f64::from(room)) * cell).into();
        let (found, exact) = (grid.distance(&any), slow_cells(dims, is_solid, cell, &any));
        // Within the near lattice less its blend as before; beyond it the far lattice's bend beside a solid that is
        // eight cells thick at most, and some for its notches.
        let cells = (0..3).map(|d| (-any[d]).max(any[d] - cell * f64::from(dims[d]))).fold(0.0, f64::max) / cell;
        let bound = if cells < 12.0 { 0.75f64.sqrt() * cell } else { 0.4 * cell };
        prop_assert!((found - exact).abs() <= bound + 1e-5, "{any}: {found} {exact}");
        // A node of the far lattice, off the near one.
        let around = 16 + (room - 16).div_ceil(4) * 4;
        let node: Point3<f64> = [0, 1, 2]
            .map(|d| {
                let last = (f64::from(dims[d] + 2 * around) / 4.0).floor();
                (4.0 * (at[d] * last).round() - f64::from(around)) * cell
            })
            .into();
        if (0..3).any(|d| node[d] < -16.0 * cell || node[d] > (f64::from(dims[d]) + 16.0) * cell) {
            let exact = slow_cells(dims, is_solid, cell, &node);
            prop_assert!((grid.distance(&node) - exact).abs() < 1e-5, "{node}: {} {exact}", grid.distance(&node));
        }
    }

    /// Over the seam of the two lattices the slope is still that of the value.
    #[test]
    fn slopes_across_the_seam(at in proptest::array::uniform3(-25.0..30.0f64)) {
        let rows = [0b1011u64, 0b0110, 0b1001, 0b1111];
        let grid = DistanceGrid::from_cells([4, 2, 2], &rows, 1.0, &Point3::origin(), 40).unwrap();
        let p = Point3::from(at);
        let (value, slope) = grid.gradient(&p);
        prop_assert!((value - grid.distance(&p)).abs() < 1e-12);
        let mut kinks = 0;
        for d in 0..3 {
            let moved = |step: f64| { let mut q = p; q[d] += step; grid.distance(&q) };
            let [ahead, behind] = [(moved(1e-6) - value) / 1e-6, (value - moved(-1e-6)) / 1e-6];
            if (ahead - behind).abs() < 1e-4 {
                prop_assert!((0.5 * (ahead + behind) - slope[d]).abs() < 1e-4, "{ahead} {behind} {}", slope[d]);
            } else {
                kinks += 1;
            }
        }
        prop_assert!(kinks <= 2);
    }

    #[test]
    fn slopes_of_grids_are_those_of_their_values(at in proptest::array::uniform3(-30.0..50.0f64)) {
        let grid = lump();
        let p = Point3::from(at);
        let (value, slope) = grid.gradient(&p);
        prop_assert!((value - grid.distance(&p)).abs() < 1e-12);
        for d in 0..3 {
            // A cubic lattice of spacing 2 has its kinks where coordinates are even, and at its ends.
            let to_kink = (at[d] / 2.0 - (at[d] / 2.0).round()).abs();
            if to_kink < 1e-4 {
                continue;
            }
            let moved = |step: f64| { let mut q = p; q[d] += step; grid.distance(&q) };
            let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            prop_assert!((difference - slope[d]).abs() < 1e-5, "{difference} {}", slope[d]);
        }
        prop_assert!(slope.norm() <= 3f64.sqrt() + 1e-9);
    }
}

fn lump() -> DistanceGrid {
    let mut rows = vec![0u64; 100];
    for (k, row) in rows.iter_mut().enumerate() {
        *row = if (k % 10) * (k / 10) % 7 < 4 { 0b11_0111_1100 } else { 0b1000_0001 };
    }
    DistanceGrid::from_cells([10, 10, 10], &rows, 2.0, &Point3::origin(), 4).unwrap()
}

/// A box with a dent, closed: a cube whose upper face is pulled down in the middle.
fn dented() -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let mut points: Vec<Point3<f64>> = (0..8)
        .map(|k| Point3::new(f64::from(k & 1) * 10.0, f64::from(k >> 1 & 1) * 10.0, f64::from(k >> 2) * 10.0))
        .collect();
    points.push(Point3::new(5.0, 5.0, 4.0));
    let quads = [[0, 2, 3, 1], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    let mut triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    triangles.extend([[4, 5, 8], [5, 7, 8], [7, 6, 8], [6, 4, 8]]);
    (points, triangles)
}

/// Inside by the sum of solid angles, distance by sampling nothing: each triangle by its edges and its plane.
fn slow_mesh(points: &[Point3<f64>], triangles: &[[u32; 3]], p: &Point3<f64>) -> f64 {
    let mut angle = 0.0;
    let mut least = f64::INFINITY;
    for t in triangles {
        let [a, b, c] = t.map(|k| points[k as usize] - p);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let det = a.dot(&b.cross(&c));
        angle += 2.0 * det.atan2(la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb);
        // The foot on the plane, in barycentric coordinates; else the nearest edge.
        let (u, v) = (b - a, c - a);
        let gram = nalgebra_solve(u.dot(&u), u.dot(&v), v.dot(&v), -u.dot(&a), -v.dot(&a));
        if let Some((s, r)) = gram.filter(|(s, r)| *s >= 0.0 && *r >= 0.0 && s + r <= 1.0) {
            least = least.min((a + u * s + v * r).norm());
        }
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let along: Vector3<f64> = to - from;
            let t = (-from.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            least = least.min((from + along * t).norm());
        }
    }
    if angle.abs() > std::f64::consts::TAU { -least } else { least }
}

fn nalgebra_solve(a: f64, b: f64, c: f64, x: f64, y: f64) -> Option<(f64, f64)> {
    let det = a * c - b * b;
    (det.abs() > 1e-12).then(|| ((c * x - b * y) / det, (a * y - b * x) / det))
}

#[test]
fn triangles_have_the_distance_of_brute_force() {
    let (points, triangles) = dented();
    // Rows of nodes meet edges and corners of the mesh: spacing 1, corners at whole numbers.
    for (spacing, room) in [(1.0, 3.0), (0.7, 2.0), (2.5, 5.0)] {
        let grid = DistanceGrid::from_triangles(&points, &triangles, spacing, room).unwrap();
        let around = (room / spacing).ceil();
        let side = (10.0 / spacing).ceil() + 2.0 * around;
        let mut fixed = Fixed(3);
        for _ in 0..4000 {
            let mut place = || (fixed.unit() * (side + 1.0)).floor() * spacing - around * spacing;
            let node = Point3::new(place(), place(), place());
            let exact = slow_mesh(&points, &triangles, &node);
            let found = grid.distance(&node);
            // On the surface itself either sign is right.
            assert!((found - exact).abs() < 1e-5 || exact.abs() < 1e-9, "{node}: {found} {exact}");
            let p = node + Vector3::new(fixed.unit(), fixed.unit(), fixed.unit()) * spacing;
            let (found, exact) = (grid.distance(&p), slow_mesh(&points, &triangles, &p));
            assert!(found - exact <= grid.error_bound(), "{p}: {found} {exact}");
        }
    }
    // Turned inside out it is the same body.
    let turned: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let (a, b) = [&triangles, &turned].map(|t| DistanceGrid::from_triangles(&points, t, 1.0, 2.0).unwrap()).into();
    assert_eq!(a, b);
}

#[test]
fn overlapping_bodies_are_one() {
    let (points, triangles) = dented();
    let mut both = points.clone();
    both.extend(points.iter().map(|p| p + Vector3::new(4.0, 3.0, -2.0)));
    let mut all = triangles.clone();
    all.extend(triangles.iter().map(|t| t.map(|k| k + 9)));
    let grid = DistanceGrid::from_triangles(&both, &all, 0.5, 2.0).unwrap();
    for (p, inside) in
        [([6.0, 6.0, 2.0], true), ([12.0, 11.0, 3.0], true), ([2.0, 2.0, 5.0], true), ([12.0, 1.0, 5.0], false)]
    {
        assert_eq!(grid.distance(&p.into()) < 0.0, inside, "{p:?}");
    }
}

#[test]
fn grid_errors() {
    let origin = Point3::origin();
    let cells = |dims, rows: &[u64], cell, corner: &Point3<f64>, room| {
        DistanceGrid::from_cells(dims, rows, cell, corner, room).unwrap_err()
    };
    assert_eq!(cells([2, 2, 1], &[0, 0], 1.0, &origin, 1), GridError::Empty);
    assert_eq!(cells([2, 2, 1], &[1], 1.0, &origin, 1), GridError::Words { dims: [2, 2, 1], words: 1, wanted: 2 });
    assert!(matches!(cells([u32::MAX; 3], &[1], 1.0, &origin, 1), GridError::Words { .. }));
    assert!(matches!(cells([1, 1, 1], &[1], 1.0, &origin, u32::MAX), GridError::TooLarge { .. }));
    assert!(matches!(cells([1, 1, 1], &[1], 0.0, &origin, 1), GridError::Length { what: "cell", .. }));
    assert!(matches!(cells([1, 1, 1], &[1], 1.0, &origin, 0), GridError::Length { what: "margin", .. }));
    assert_eq!(cells([1, 1, 1], &[1], 1.0, &Point3::new(f64::NAN, 0.0, 0.0), 1), GridError::Point { point: 0 });
    let (points, triangles) = dented();
    let mesh = |points: &[Point3<f64>], triangles: &[[u32; 3]], spacing, room| {
        DistanceGrid::from_triangles(points, triangles, spacing, room).unwrap_err()
    };
    assert_eq!(mesh(&points, &triangles[1..], 1.0, 1.0), GridError::Open { from: 2, to: 0 });
    assert_eq!(mesh(&points, &[], 1.0, 1.0), GridError::Empty);
    assert_eq!(mesh(&points, &[[0, 1, 9]], 1.0, 1.0), GridError::Corner { triangle: 0, corner: 9, points: 9 });
    let mut wild = points.clone();
    wild[4].y = f64::INFINITY;
    assert_eq!(mesh(&wild, &triangles, 1.0, 1.0), GridError::Point { point: 4 });
    assert!(matches!(mesh(&points, &triangles, 1e-6, 1.0), GridError::TooLarge { .. }));
    assert!(matches!(mesh(&points, &triangles, -1.0, 1.0), GridError::Length { what: "spacing", .. }));
    assert!(matches!(mesh(&points, &triangles, 1.0, f64::NAN), GridError::Length { what: "margin", .. }));
}

/// Values against all shapes compared one by one, gradients against differences.
#[test]
fn indicator_is_the_least_of_all_and_its_gradient_that_of_the_value() {
    let indicator = cell::indicator();
    let scene = cell::scene();
    let samples = verification_samples(&cell::contact(&scene), 300, 0.2, 3).unwrap();
    let (mut compared, mut kinks, mut deep) = (0, 0, 0);
    for sample in &samples {
        let q = sample.joints;
        let (value, gradient) = indicator.gradient(&q);
        assert!((value - indicator.value(&q)).abs() < 1e-12);
        // The flange 2 mm deep in the part: how deep is not reported beyond that, so no slope of it either.
        if indicator.nearest(&q).bodies == [6, 0] && (value - 2.0).abs() < 0.1 {
            deep += 1;
            continue;
        }
        for k in 0..6 {
            let moved = |step: f64| {
                let mut q = q;
                q[k] += step;
                indicator.value(&q)
            };
            let [ahead, behind] = [(moved(1e-6) - value) / 1e-6, (value - moved(-1e-6)) / 1e-6];
            // Where the two differ, another pair takes over or a kink of the lattice lies between.
            if (ahead - behind).abs() > 1e-2 * (1.0 + ahead.abs()) {
                kinks += 1;
                continue;
            }
            compared += 1;
            assert!(
                (0.5 * (ahead + behind) - gradient[k]).abs() < 1e-2 * (1.0 + gradient[k].abs()),
                "{ahead} {behind} {} {value} {:?} joint {k}",
                gradient[k],
                indicator.nearest(&q)
            );
        }
    }
    assert!(compared > 50 * kinks && deep < 10, "{compared} {kinks} {deep}");
}

/// The goal: 0.95 both ways, near and on the contact space.
#[test]
fn rates_in_a_cell_against_the_exact_scene() {
    let scene = cell::scene();
    let indicator = cell::indicator();
    for (name, within) in [("near", 0.05), ("on", 0.0)] {
        let known = verification_samples(&cell::contact(&scene), 3000, within, 11).unwrap();
        let rates = Rates::of(&indicator, &known);
        println!("{name}: {rates:?} tnr {:?} hits {:?}", rates.tnr(), rates.hit_rate());
        assert!(rates.tnr().unwrap() >= 0.95 && rates.hit_rate().unwrap() >= 0.95);
    }
}

/// A ball on two sliding joints beside a capsule and a plane.
fn sliding() -> (impl Bodies<2>, GeometricModel) {
    let bodies = BodiesFn {
        carriers: vec![[false; 2], [true; 2]],
        place: |q: &[f64; 2], frames: &mut [IsometryMatrix3<f64>]| {
            frames[1] = IsometryMatrix3::translation(q[0], 0.0, q[1])
        },
        twists: |_: &[f64; 2], _: &[IsometryMatrix3<f64>]| {
            [Twist::sliding(&Vector3::x()), Twist::sliding(&Vector3::z())]
        },
    };
    let origin = Point3::origin();
    let model = GeometricModel {
        capsules: vec![
            Capsule { body: 1, from: origin, to: origin, radius: 2.0 },
            Capsule { body: 0, from: Point3::new(20.0, -9.0, 30.0), to: Point3::new(20.0, 9.0, 30.0), radius: 3.0 },
        ],
        planes: vec![Plane { body: 0, point: Point3::origin(), normal: Vector3::z_axis() }],
        margin: 1.0,
        ..GeometricModel::default()
    };
    (bodies, model)
}

#[test]
fn closed_forms_of_capsule_and_plane() {
    let (bodies, model) = sliding();
    let indicator = GeometricIndicator::new(bodies, model).unwrap();
    let (value, gradient) = indicator.gradient(&[20.0, 10.0]);
    assert_eq!((value, gradient), (1.0 - 8.0, [0.0, -1.0]));
    let (value, gradient) = indicator.gradient(&[8.0, 21.0]);
    // 15 from the capsule's axis, along (-4, -3) / 5.
    approx::assert_abs_diff_eq!(value, 1.0 - 10.0, epsilon = 1e-12);
    approx::assert_abs_diff_eq!(gradient[0], 0.8, epsilon = 1e-12);
    approx::assert_abs_diff_eq!(gradient[1], 0.6, epsilon = 1e-12);
    assert_eq!(indicator.nearest(&[8.0, 21.0]).bodies, [1, 0]);
    // On the capsule's axis itself there is no direction.
    assert_eq!(indicator.gradient(&[20.0, 30.0]), (1.0 + 5.0, [0.0; 2]));
    // An invalid posture is not called free.
    for joints in [[f64::NAN, 50.0], [20.0, f64::INFINITY]] {
        assert!(indicator.value(&joints).is_nan() && indicator.gradient(&joints).0.is_nan());
        assert!(indicator.predicts(&joints));
    }
}

/// The least distance of points of one shape from another, sampled: from above, and by less than the samples are apart.
fn sampled(capsule: &Capsule, cylinder: &Cylinder) -> f64 {
    let (axis, middle) = ((cylinder.to - cylinder.from).normalize(), cylinder.from);
    let high = (cylinder.to - cylinder.from).norm();
    let to_cylinder = |p: &Point3<f64>| {
        let along = axis.dot(&(p - middle));
        let aside = ((p - middle).norm_squared() - along * along).max(0.0).sqrt() - cylinder.radius;
        let above = (-along).max(along - high);
        if above.max(aside) <= 0.0 { above.max(aside) } else { above.max(0.0).hypot(aside.max(0.0)) }
    };
    (0..=2000)
        .map(|k| to_cylinder(&(capsule.from + (capsule.to - capsule.from) * (f64::from(k) / 2000.0))))
        .fold(f64::INFINITY, f64::min)
        - capsule.radius
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// A capsule that slides past a cylinder: the distance is that of samples, the gradient that of the distance.
    #[test]
    fn capsules_and_cylinders(
        ends in proptest::array::uniform4(proptest::array::uniform3(-30.0..30.0f64)),
        radii in (0.0..8.0f64, 1.0..15.0f64), q in proptest::array::uniform2(-20.0..20.0f64),
    ) {
        let [a, b, c, d] = ends.map(Point3::from);
        prop_assume!((d - c).norm() > 1.0);
        let capsule = Capsule { body: 1, from: a, to: b, radius: radii.0 };
        let cylinder = Cylinder { body: 0, from: c, to: d, radius: radii.1 };
        let (bodies, _) = sliding();
        let model = GeometricModel { capsules: vec![capsule], cylinders: vec![cylinder], ..Default::default() };
        let indicator = GeometricIndicator::new(bodies, model).unwrap();
        let by = Vector3::new(q[0], 0.0, q[1]);
        let exact = sampled(&Capsule { from: a + by, to: b + by, ..capsule }, &cylinder);
        let (value, gradient) = indicator.gradient(&q);
        // Samples are at most 0.06 apart.
        prop_assert!((-value - exact).abs() < 0.04, "{} {exact}", -value);
        for k in 0..2 {
            let moved = |step: f64| { let mut q = q; q[k] += step; indicator.value(&q) };
            // Convex: a slope lies between those on either side. Twice the search's tolerance on 0.5 mm.
            let [ahead, behind] = [(moved(0.5) - value) / 0.5, (value - moved(-0.5)) / 0.5];
            prop_assert!(gradient[k] <= behind + 0.08 && gradient[k] >= ahead - 0.08, "{ahead} {behind} {}", gradient[k]);
        }
    }

    /// A capsule and a cylinder beside a part: by samples of the same grid.
    #[test]
    fn capsules_and_cylinders_in_a_grid(
        ends in proptest::array::uniform2(proptest::array::uniform3(-40.0..40.0f64)),
        radius in 0.5..12.0f64, round in any::<bool>(),
    ) {
        let [a, b] = ends.map(Point3::from);
        prop_assume!((b - a).norm() > 1.0);
        let part = || {
            let rows = [0b1110_0111u64, 0b0110, 0b1100_1001, 0b1111];
            DistanceGrid::from_cells([8, 2, 2], &rows, 2.0, &Point3::new(-8.0, -2.0, -2.0), 30).unwrap()
        };
        let (bodies, _) = sliding();
        let mut model = GeometricModel { grids: vec![(0, part())], ..Default::default() };
        let axis = (b - a).normalize();
        let (side, up) = {
            let side = axis.cross(&if axis.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() }).normalize();
            (side, axis.cross(&side))
        };
        let mut points = vec![];
        if round {
            model.cylinders = vec![Cylinder { body: 1, from: a, to: b, radius }];
            for k in 0..=60 {
                let on_axis = a + (b - a) * (f64::from(k) / 60.0);
                for turn in 0..48 {
                    let (sin, cos) = (f64::from(turn) / 48.0 * std::f64::consts::TAU).sin_cos();
                    points.extend((0..=4).map(|r| on_axis + (side * cos + up * sin) * (radius * f64::from(r) / 4.0)));
                }
            }
        } else {
            model.capsules = vec![Capsule { body: 1, from: a, to: b, radius }];
            points.extend((0..=1000).map(|k| a + (b - a) * (f64::from(k) / 1000.0)));
        }
        let indicator = GeometricIndicator::new(bodies, model).unwrap();
        let grid = part();
        let least = points.iter().map(|p| grid.distance(p)).fold(f64::INFINITY, f64::min);
        let exact = if round { least } else { least - radius };
        let found = indicator.nearest(&[0.0; 2]).distance;
        if exact > 0.0 {
            // Clear: nearly the truth. A cylinder's search is local: beside a part of two towers it may take the other.
            prop_assert!(found - exact < if round { 2.0 } else { 0.3 }, "{found} {exact}");
            prop_assert!(found - exact > if round { -2.5 } else { -0.3 }, "{found} {exact}");
        } else if exact < -1.0 {
            prop_assert!(found < 0.0, "{found} {exact}");
        }
    }
}

/// A cylinder over a plane, lying, standing and tilted; and two cylinders.
#[test]
fn closed_forms_of_cylinders() {
    let with = |cylinders: Vec<Cylinder>, planes: Vec<Plane>| {
        let (bodies, _) = sliding();
        GeometricIndicator::new(bodies, GeometricModel { cylinders, planes, ..Default::default() }).unwrap()
    };
    let floor = Plane { body: 0, point: Point3::origin(), normal: Vector3::z_axis() };
    let drum = |body, from: [f64; 3], to: [f64; 3]| Cylinder { body, from: from.into(), to: to.into(), radius: 3.0 };
    for (to, lowest) in [([0.0, 0.0, 8.0], 0.0), ([8.0, 0.0, 0.0], -3.0), ([6.0, 0.0, 8.0], -3.0 * 0.6)] {
        let indicator = with(vec![drum(1, [0.0; 3], to)], vec![floor]);
        let (value, gradient) = indicator.gradient(&[5.0, 10.0]);
        approx::assert_abs_diff_eq!(value, -(10.0 + lowest), epsilon = 1e-12);
        approx::assert_abs_diff_eq!(gradient[0], 0.0, epsilon = 1e-12);
        approx::assert_abs_diff_eq!(gradient[1], -1.0, epsilon = 1e-12);
    }
    let standing = drum(0, [0.0; 3], [0.0, 0.0, 8.0]);
    let indicator = with(vec![drum(1, [0.0; 3], [0.0, 0.0, 8.0]), standing], vec![]);
    // Side by side, one over the other, and one a little into the other.
    approx::assert_abs_diff_eq!(indicator.value(&[11.0, 2.0]), -5.0, epsilon = 0.02);
    approx::assert_abs_diff_eq!(indicator.value(&[1.0, 12.0]), -4.0, epsilon = 0.02);
    approx::assert_abs_diff_eq!(indicator.value(&[5.0, 1.0]), 1.0, epsilon = 0.02);
    assert!(indicator.gradient(&[11.0, 2.0]).1[0] < -0.99 && indicator.gradient(&[1.0, 12.0]).1[1] < -0.99);
}

#[test]
fn a_grown_part_takes_the_place_of_the_old_one() {
    let (bodies, mut model) = sliding();
    let part =
        |rows: &[u64]| DistanceGrid::from_cells([4, 1, 1], rows, 5.0, &Point3::new(-60.0, -2.5, 10.0), 2).unwrap();
    model.balls = vec![Ball { body: 1, center: Point3::origin(), radius: 2.0 }];
    model.grids = vec![(0, part(&[0b0001]))];
    let mut indicator = GeometricIndicator::new(bodies, model).unwrap();
    let q = [-30.0, 12.5];
    approx::assert_abs_diff_eq!(indicator.value(&q), 1.0 - 10.5, epsilon = 1e-9); // the plane
    assert!(indicator.replace_grid(0, part(&[0b1111])).is_some() && indicator.replace_grid(1, part(&[1])).is_none());
    approx::assert_abs_diff_eq!(indicator.value(&q), 1.0 - 8.0, epsilon = 1e-6);
    assert!((indicator.gradient(&q).1[0] + 1.0).abs() < 1e-6);
}

#[test]
fn model_errors() {
    let error = |change: &dyn Fn(&mut GeometricModel)| {
        let (bodies, mut model) = sliding();
        change(&mut model);
        GeometricIndicator::new(bodies, model).map(|_| ()).unwrap_err()
    };
    let p = Point3::origin();
    assert_eq!(
        error(&|m| m.capsules[1].body = 2),
        GeometricError::NoBody { what: "capsule", index: 1, body: 2, count: 2 }
    );
    assert_eq!(error(&|m| m.planes[0].body = 7), GeometricError::NoBody { what: "plane", index: 0, body: 7, count: 2 });
    assert_eq!(
        error(&|m| m.ignored = vec![[0, 3]]),
        GeometricError::NoBody { what: "ignored pair", index: 0, body: 3, count: 2 }
    );
    assert_eq!(
        error(&|m| m.balls = vec![Ball { body: 5, center: p, radius: 1.0 }]),
        GeometricError::NoBody { what: "ball", index: 0, body: 5, count: 2 }
    );
    assert_eq!(
        error(&|m| m.grids = vec![(4, lump())]),
        GeometricError::NoBody { what: "grid", index: 0, body: 4, count: 2 }
    );
    assert_eq!(error(&|m| m.capsules[0].radius = -1.0), GeometricError::Shape { what: "capsule", index: 0 });
    assert_eq!(
        error(&|m| m.planes[0].normal = Unit::new_unchecked(Vector3::repeat(f64::NAN))),
        GeometricError::Shape { what: "plane", index: 0 }
    );
    assert_eq!(
        error(&|m| m.balls = vec![Ball { body: 1, center: p, radius: f64::NAN }]),
        GeometricError::Shape { what: "ball", index: 0 }
    );
    let drum = |body, to| Cylinder { body, from: p, to, radius: 1.0 };
    let point = error(&|m| m.cylinders = vec![drum(1, p)]);
    assert_eq!(point, GeometricError::Shape { what: "cylinder", index: 0 });
    let nobody = error(&|m| m.cylinders = vec![drum(3, Point3::new(1.0, 0.0, 0.0))]);
    assert_eq!(nobody, GeometricError::NoBody { what: "cylinder", index: 0, body: 3, count: 2 });
    assert_eq!(error(&|m| m.margin = f64::INFINITY), GeometricError::Margin(f64::INFINITY));
    assert_eq!(error(&|m| m.ignored = vec![[1, 0]]), GeometricError::Nothing);
    let many = BodiesFn {
        carriers: vec![[false]; MAX_BODIES + 1],
        place: |_: &[f64; 1], _: &mut [IsometryMatrix3<f64>]| {},
        twists: |_: &[f64; 1], _: &[IsometryMatrix3<f64>]| [Twist::sliding(&Vector3::x())],
    };
    let error = GeometricIndicator::new(many, GeometricModel::default()).map(|_| ()).unwrap_err();
    assert_eq!(error, GeometricError::TooManyBodies { count: MAX_BODIES + 1 });
}
