//! Directions and stresses on layers.

use crate::common::{go_on, grid};
use curvlay_toolpath::fiber::direction::{DirectionError, DirectionField};
use curvlay_toolpath::fiber::lines::CentreLine;
use curvlay_toolpath::fiber::stress::{LayerStress, StressError, StressOptions, StressSample};
use curvlay_toolpath::fiber::stripes::stripes;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use proptest::prelude::*;
use std::f64::consts::PI;

fn plate(n: usize) -> SurfaceMesh {
    grid(n, 5, 0.5, |_, _| false, |p| Point3::new(p.x, p.y, 0.0))
}

fn at_angle(angle: f64) -> Vector3<f64> {
    Vector3::new(angle.cos(), angle.sin(), 0.0)
}

/// A closed surface: a cube of `n` by `n` squares a side, blown up to a ball.
fn ball(n: usize) -> SurfaceMesh {
    let mut numbers = std::collections::BTreeMap::new();
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    let mut vertex = |p: [i64; 3]| {
        *numbers.entry(p).or_insert_with(|| {
            vertices.push(Point3::from(Vector3::from(p.map(|c| c as f64)).normalize() * 10.0));
            vertices.len() as u32 - 1
        })
    };
    let n = n as i64;
    for axis in 0..3 {
        for side in [-n, n] {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (2 * i - n, 2 * j - n))) {
                let place = |u: i64, v: i64| {
                    let mut p = [0; 3];
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u, v);
                    p
                };
                let [a, b, c, d] = [(i, j), (i + 2, j), (i + 2, j + 2), (i, j + 2)].map(|(u, v)| vertex(place(u, v)));
                let faces = [[a, b, c], [a, c, d]];
                triangles.extend(if side > 0 { faces } else { faces.map(|[a, b, c]| [a, c, b]) });
            }
        }
    }
    SurfaceMesh::new(vertices, triangles).unwrap()
}

/// The angle between two lines.
fn between(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b).abs())
}

#[test]
fn a_function_gives_its_tangent_part() {
    let mesh = grid(6, 1, 0.5, |_, _| false, |p| Point3::new(p.x, p.y, 0.5 * p.x));
    let field = DirectionField::from_fn(&mesh, |_| Vector3::new(-7.0, 0.0, 3.0)).unwrap();
    let wanted = Vector3::new(2.0, 0.0, 1.0).normalize();
    assert!(field.directions().iter().all(|d| between(d, &wanted) < 1e-12));
    assert!(field.singularities().is_empty());
    assert!(between(&field.at(3, [0.2, 0.3, 0.5]).unwrap(), &wanted) < 1e-12);
    // Length and sign mean nothing.
    let mut sign = 1e80;
    let other = DirectionField::from_fn(&mesh, |_| {
        sign = -sign;
        wanted * sign
    });
    assert!(other.unwrap().directions().iter().zip(field.directions()).all(|(a, b)| between(a, b) < 1e-7));
}

#[test]
fn vertices_without_a_direction_take_their_neighbours() {
    let mesh = plate(8);
    let radial = |p: Point3<f64>| Vector3::new(p.x - 4.0, 0.0, 0.0);
    let field = DirectionField::from_fn(&mesh, radial).unwrap();
    assert!(field.directions().iter().all(|d| between(d, &Vector3::x()) < 1e-9));
    let nowhere = DirectionField::from_fn(&mesh, |_| Vector3::z()).unwrap_err();
    assert_eq!(nowhere, DirectionError::Undefined { region: 0 });
    let bad = DirectionField::from_fn(&mesh, |p| Vector3::new(1.0, if p.x > 7.9 { f64::NAN } else { 0.0 }, 0.0));
    assert!(matches!(bad, Err(DirectionError::BadDirection { .. })));
}

#[test]
fn singular_points_are_where_directions_turn() {
    let mesh = plate(12);
    let [one, other] = [[3.3, 4.1], [8.6, 7.7]];
    for [turns, other_turns] in [[1, -1], [1, 1], [-1, 2], [2, 0], [-2, 1]] {
        let angle = |p: Point3<f64>| {
            let around = |at: [f64; 2]| (p.y - at[1]).atan2(p.x - at[0]);
            0.5 * (f64::from(turns) * around(one) + f64::from(other_turns) * around(other))
        };
        let field = DirectionField::from_fn(&mesh, |p| at_angle(angle(p))).unwrap();
        let mut found: Vec<(f64, i32)> =
            field.singularities().iter().map(|s| (s.at.position.x, s.half_turns)).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Around a double one directions may turn too fast for one triangle: it comes as two next to each other.
        let near = |x: f64| found.iter().filter(|f| (f.0 - x).abs() < 2.0).map(|f| f.1).sum::<i32>();
        assert_eq!([near(one[0]), near(other[0])], [turns, other_turns], "{found:?}");
        // Signs agree along every edge but those of cuts from one singular point to another, or to the border.
        assert!(found.iter().all(|f| (f.0 - one[0]).abs() < 2.0 || (f.0 - other[0]).abs() < 2.0), "{found:?}");
    }
}

#[test]
fn signs_agree_where_they_can() {
    let mesh = plate(10);
    let mut number = 0;
    let field = DirectionField::from_fn(&mesh, |p| {
        number += 1;
        at_angle(0.3 * p.x + if number % 3 == 0 { PI } else { 0.0 })
    });
    let field = field.unwrap();
    for &[a, b, c] in mesh.triangles() {
        let [a, b, c] = [a, b, c].map(|v| field.directions()[v as usize]);
        assert!(a.dot(&b) > 0.0 && b.dot(&c) > 0.0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Hopf: on a ball the indices of any field have the sum 2, whatever the directions.
    #[test]
    fn indices_on_a_ball_are_two_together(seed in prop::array::uniform9(-1.0..1.0f64)) {
        let mesh = ball(6);
        let [a, b, c, d, e, f, g, h, i] = seed;
        let of = |p: Point3<f64>| Vector3::new(a + (b * p.y).sin() + c * p.z, d * p.x + e, (f * p.x + g * p.y).cos() + h * i * p.x);
        let field = DirectionField::from_fn(&mesh, of).unwrap();
        prop_assert_eq!(field.singularities().iter().map(|s| s.half_turns).sum::<i32>(), 4);
        let smooth = field.smoothed(3.0).unwrap();
        prop_assert_eq!(smooth.singularities().iter().map(|s| s.half_turns).sum::<i32>(), 4);
    }

    /// A field that turns evenly is a smooth one already; noise on it goes.
    #[test]
    fn noise_is_evened_out(angle in 0.0..PI, seed in any::<u64>()) {
        use rand::RngExt;
        let mesh = plate(14);
        let mut rng = crate::common::rng(seed);
        let noisy = DirectionField::from_fn(&mesh, |_| at_angle(angle + 0.5 * (rng.random::<f64>() - 0.5))).unwrap();
        let smooth = noisy.clone().smoothed(3.0).unwrap();
        let off = |field: &DirectionField| field.directions().iter().map(|d| between(d, &at_angle(angle)).powi(2)).sum::<f64>().sqrt();
        prop_assert!(off(&smooth) < 0.35 * off(&noisy), "{} {}", off(&smooth), off(&noisy));
        let same = noisy.clone().smoothed(0.0).unwrap();
        prop_assert!(same.directions().iter().zip(noisy.directions()).all(|(a, b)| between(a, b) < 1e-9));
    }

    /// On a plane at any slant normals differ by rounding alone: their product may be above one.
    #[test]
    fn planes_at_any_slant_have_smooth_fields(roll in 0.0..PI, pitch in 0.0..PI, seed in any::<u64>()) {
        let turn = Rotation3::from_euler_angles(roll, pitch, 0.3);
        let mesh = grid(16, seed, 0.6, |_, _| false, |p| turn * Point3::new(p.x / 3.0, p.y / 3.0, 0.0));
        let field = DirectionField::from_fn(&mesh, |_| turn * Vector3::new(2.0, 1.0, 0.0)).unwrap();
        let smooth = field.smoothed(2.0).unwrap();
        let wanted = turn * Vector3::new(2.0, 1.0, 0.0).normalize();
        prop_assert!(smooth.directions().iter().all(|d| between(d, &wanted) < 1e-6));
    }

    /// Moving least squares of first degree: stresses that are linear in space come out as they are, at any spread of samples.
    #[test]
    fn linear_stresses_are_exact(seed in any::<u64>(), flat in any::<bool>()) {
        use rand::RngExt;
        let mesh = grid(6, 3, 0.5, |_, _| false, |p| Point3::new(p.x, p.y, if flat { 0.0 } else { 0.3 * p.x }));
        let mut rng = crate::common::rng(seed);
        let mut random = || 2.0 * rng.random::<f64>() - 1.0;
        let slopes: [Matrix3<f64>; 4] = std::array::from_fn(|_| {
            let half = Matrix3::from_fn(|_, _| random());
            half + half.transpose()
        });
        let linear = |p: Point3<f64>| slopes[0] + slopes[1] * p.x + slopes[2] * p.y + slopes[3] * p.z;
        let samples: Vec<_> = (0..200)
            .map(|_| Point3::new(4.0 * random() + 3.0, 4.0 * random() + 3.0, if flat { 0.0 } else { 3.0 * random() }))
            .map(|point| StressSample { point, stress: linear(point) })
            .collect();
        let stress = LayerStress::new(&mesh, &samples, StressOptions::default()).unwrap();
        for (p, found) in mesh.vertices().iter().zip(stress.tensors()) {
            prop_assert!((found - linear(*p)).amax() < 1e-5, "{:?}: {}", p, found - linear(*p));
        }
    }

    /// The principal direction makes the stress along it the largest of all directions in the plane.
    #[test]
    fn principal_directions_are_the_best_of_all(values in prop::array::uniform6(-1.0..1.0f64)) {
        let mesh = grid(1, 3, 0.0, |_, _| false, |p| Point3::new(p.x, p.y, p.x - 0.4 * p.y));
        let [a, b, c, d, e, f] = values;
        let tensor = Matrix3::new(a, d, f, d, b, e, f, e, c);
        let samples = [StressSample { point: Point3::origin(), stress: tensor }];
        let stress = LayerStress::new(&mesh, &samples, StressOptions::default()).unwrap();
        let principal = stress.principal()[0];
        let along = |v: &Vector3<f64>| v.dot(&(tensor * v));
        let normal = Vector3::new(-1.0, 0.4, 1.0).normalize();
        let across = normal.cross(&principal.direction);
        prop_assert!(principal.direction.dot(&normal).abs() < 1e-12);
        prop_assert!((along(&principal.direction) - principal.largest).abs() < 1e-12);
        prop_assert!((along(&across) - principal.other).abs() < 1e-12);
        for k in 0..180 {
            let (sin, cos) = (f64::from(k) * PI / 180.0).sin_cos();
            let turned = principal.direction * cos + across * sin;
            prop_assert!(along(&turned).abs() <= principal.largest.abs() + 1e-12);
        }
    }
}

/// Trimmed layers have slivers along their border, with cotangents as large as rounding lets them be.
#[test]
fn slivers_along_a_border_do_not_spoil_stripes() {
    let plate = plate(10);
    let mut vertices = plate.vertices().to_vec();
    // Vertices of the border that are almost in the place of their neighbours.
    let at = |x: f64, y: f64| vertices.iter().position(|p| (p.x - x).hypot(p.y - y) < 1e-9).unwrap();
    let moved: Vec<usize> = (2..9).step_by(2).map(|k| at(f64::from(k), 0.0)).collect();
    moved.iter().for_each(|&v| vertices[v].x -= 1.0 - 1e-9);
    let mesh = SurfaceMesh::new(vertices, plate.triangles().to_vec()).unwrap();
    let field = DirectionField::from_fn(&mesh, |p| at_angle(0.1 * p.x)).unwrap().smoothed(1.0).unwrap();
    // At the border a smooth field stops turning: over 1 mm at 0.1 a millimetre.
    assert!(field.directions().iter().zip(mesh.vertices()).all(|(d, p)| between(d, &at_angle(0.1 * p.x)) < 0.15));
    let lines = stripes(&field, 1.5, &go_on).unwrap().lines;
    let length: f64 = lines.iter().map(CentreLine::length).sum();
    assert!((length * 1.5 / 100.0 - 1.0).abs() < 0.1, "{length}");
}

/// A plate with a row of triangles so flat that their cotangents are 1e9, as a border trimmed to a skin has them.
#[test]
fn slivers_do_not_make_fields_unsolvable() {
    let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0], [2.0, -1e-9]];
    let mut vertices: Vec<Point3<f64>> = corners.iter().map(|[x, y]| Point3::new(*x, *y, 0.0)).collect();
    let flat = SurfaceMesh::new(vertices.clone(), vec![[0, 1, 2], [0, 2, 3], [0, 4, 1]]).unwrap();
    let field = DirectionField::from_fn(&flat, |_| Vector3::new(1.0, 1.0, 0.0)).unwrap().smoothed(2.0).unwrap();
    assert!(field.directions().iter().all(|d| between(d, &Vector3::new(1.0, 1.0, 0.0)) < 1e-6));
    // A splinter beside it that hangs on nothing, a ten-thousandth as wide.
    vertices.extend([[9.0, 0.0], [9.0001, 0.0], [9.0, 1e-12]].map(|[x, y]| Point3::new(x, y, 0.0)));
    let torn = SurfaceMesh::new(vertices, vec![[0, 1, 2], [0, 2, 3], [0, 4, 1], [5, 6, 7]]).unwrap();
    let field = DirectionField::from_fn(&torn, |_| Vector3::new(1.0, 1.0, 0.0)).unwrap().smoothed(20.0).unwrap();
    assert!(field.directions().iter().all(|d| between(d, &Vector3::new(1.0, 1.0, 0.0)) < 1e-6));
    assert!(!stripes(&field, 1.0, &go_on).unwrap().lines.is_empty());
}

#[test]
fn stresses_make_a_field() {
    // Bending about a hole: tension on one side, compression on the other, both along x; in the middle nothing is known.
    let mesh = plate(12);
    let samples: Vec<_> = mesh
        .vertices()
        .iter()
        .map(|p| StressSample { point: *p, stress: Matrix3::from_diagonal(&Vector3::new(p.y - 6.0, 0.0, 9.0)) })
        .collect();
    let stress = LayerStress::new(&mesh, &samples, StressOptions::default()).unwrap();
    for smoothing in [0.0, 2.0] {
        let field = DirectionField::from_stress(&stress, smoothing).unwrap();
        assert!(field.directions().iter().all(|d| between(d, &Vector3::x()) < 1e-6));
    }
    assert!((stress.at(0, [1.0 / 3.0; 3]).largest + 6.0).abs() < 1.0);
    // The same in all directions: there is no direction at all.
    let even: Vec<_> = samples.iter().map(|s| StressSample { stress: Matrix3::identity(), ..*s }).collect();
    let even = LayerStress::new(&mesh, &even, StressOptions::default()).unwrap();
    assert!(matches!(DirectionField::from_stress(&even, 1.0), Err(DirectionError::Undefined { region: 0 })));
}

#[test]
fn guides_are_followed_and_extended() {
    let mesh = plate(12);
    let line = |from: [f64; 2], to: [f64; 2]| [from, to].map(|[x, y]| Point3::new(x, y, 0.1)).to_vec();
    let one = DirectionField::from_guides(&mesh, &[line([2.0, 3.0], [5.0, 4.0])], 0.5).unwrap();
    assert!(one.directions().iter().all(|d| between(d, &Vector3::new(3.0, 1.0, 0.0)) < 1e-6));
    // Two guides: in the middle between them the direction is in the middle.
    let slanted = line([12.0, 0.0], [12.0 - 12.0 * (PI / 6.0).tan(), 12.0]);
    let both = DirectionField::from_guides(&mesh, &[line([0.0, 0.0], [0.0, 12.0]), slanted], 0.5).unwrap();
    let angle = |p: Point3<f64>| {
        let nearest = (0..mesh.vertices().len()).min_by(|&a, &b| {
            let to = |v: usize| (mesh.vertices()[v] - p).norm();
            to(a).total_cmp(&to(b))
        });
        between(&both.directions()[nearest.unwrap()], &Vector3::y())
    };
    assert!(angle(Point3::new(0.0, 6.0, 0.0)) < 0.02);
    let middle = angle(Point3::new(4.3, 6.0, 0.0));
    assert!((middle - PI / 12.0).abs() < 0.08, "{middle}");
}

#[test]
fn bad_input_is_refused() {
    let mesh = plate(3);
    let sample = StressSample { point: Point3::new(1.0, 1.0, 0.0), stress: Matrix3::identity() };
    let refused = |samples: &[StressSample], reach| {
        LayerStress::new(&mesh, samples, StressOptions { reach }).map(|_| ()).unwrap_err()
    };
    assert_eq!(refused(&[], 1.0), StressError::NoSamples);
    let nan = StressSample { point: Point3::new(f64::NAN, 0.0, 0.0), ..sample };
    assert_eq!(refused(&[sample, nan], 9.0), StressError::BadSample { sample: 1 });
    let nan = StressSample { stress: Matrix3::identity() * f64::NAN, ..sample };
    assert_eq!(refused(&[nan], 9.0), StressError::BadSample { sample: 0 });
    let skew = StressSample { stress: Matrix3::new(1.0, 2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), ..sample };
    assert_eq!(refused(&[sample, skew], 9.0), StressError::NotSymmetric { sample: 1 });
    assert_eq!(refused(&[sample], 1.0), StressError::FarFromLayer { vertex: 0, reach: 1.0 });
    let metres = StressSample { point: Point3::new(1e6, 0.0, 0.0), ..sample };
    assert_eq!(refused(&[metres], 10.0), StressError::FarFromLayer { vertex: 0, reach: 10.0 });
    assert!(matches!(refused(&[sample], f64::NAN), StressError::Reach { .. }));

    let guides = |guides: &[Vec<Point3<f64>>]| DirectionField::from_guides(&mesh, guides, 0.5).map(|_| ()).unwrap_err();
    let p = |x: f64, z: f64| Point3::new(x, 1.0, z);
    assert_eq!(guides(&[]), DirectionError::NoGuide { guide: 0 });
    assert_eq!(guides(&[vec![p(0.0, 0.0), p(1.0, 0.0)], vec![p(1.0, 0.0); 3]]), DirectionError::NoGuide { guide: 1 });
    assert_eq!(guides(&[vec![p(0.0, 0.0), p(f64::NAN, 0.0)]]), DirectionError::BadGuide { guide: 0, point: 1 });
    let far = guides(&[vec![p(0.0, 0.0), p(1.0, 0.0), p(1.0, 3.0)]]);
    assert_eq!(far, DirectionError::GuideOffLayer { guide: 0, point: 1, reach: 0.5 });
    let field = DirectionField::from_fn(&mesh, |_| Vector3::x()).unwrap();
    assert!(matches!(field.smoothed(-1.0), Err(DirectionError::Length { option: "smoothing", .. })));
    // Two plates, and a guide on one of them.
    let split = grid(5, 1, 0.0, |i, _| i == 2, |p| Point3::new(p.x, p.y, 0.0));
    let one_sided = DirectionField::from_guides(&split, &[vec![p(0.0, 0.0), p(1.0, 0.0)]], 0.5).unwrap_err();
    assert_eq!(one_sided, DirectionError::Undefined { region: 1 });
}
