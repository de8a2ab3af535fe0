//! Distances to a mesh against the least of all triangles.

#![expect(clippy::float_cmp, reason = "distances along axes and of integer triples are exact")]

use curvlay_voxel::BoundaryDistance;
use curvlay_voxel::inspect::InspectError;
use curvlay_voxel::nalgebra::{Matrix2, Point3, Vector2};
use proptest::prelude::*;

type Point = Point3<f64>;

/// The least distance to a triangle over its corners, its edges and its face, each asked for by itself.
fn slow_distance([a, b, c]: [Point; 3], point: Point) -> f64 {
    let mut candidates = vec![a, b, c];
    for [from, to] in [[a, b], [b, c], [c, a]] {
        let share = (point - from).dot(&(to - from)) / (to - from).norm_squared();
        if (0.0..=1.0).contains(&share) {
            candidates.push(from + (to - from) * share);
        }
    }
    let (u, v, w) = (b - a, c - a, point - a);
    let gram = Matrix2::new(u.dot(&u), u.dot(&v), u.dot(&v), v.dot(&v));
    if let Some(shares) = gram.try_inverse().map(|inverse| inverse * Vector2::new(u.dot(&w), v.dot(&w)))
        && shares.min() >= 0.0
        && shares.sum() <= 1.0
    {
        candidates.push(a + u * shares.x + v * shares.y);
    }
    candidates.iter().map(|candidate| (candidate - point).norm()).fold(f64::INFINITY, f64::min)
}

fn check(corners: &[Point], points: &[Point]) -> Result<(), TestCaseError> {
    let triangles: Vec<[u32; 3]> = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let surface = BoundaryDistance::new(corners, &triangles).unwrap();
    for point in points {
        let of = |t: usize| slow_distance([corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]], *point);
        let expected = (0..triangles.len()).map(of).fold(f64::INFINITY, f64::min);
        let nearest = surface.nearest(point).unwrap();
        prop_assert!((nearest.distance_mm - expected).abs() < 1e-9, "{nearest:?} is not {expected} from {point}");
        prop_assert!(((nearest.point - point).norm() - nearest.distance_mm).abs() < 1e-12);
        // The triangle is the one that the point lies on.
        let t = nearest.triangle as usize;
        prop_assert!(slow_distance([corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]], nearest.point) < 1e-9);
        prop_assert_eq!(surface.distance(point).to_bits(), nearest.distance_mm.to_bits());
    }
    Ok(())
}

fn points(count: std::ops::RangeInclusive<usize>) -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec(prop::array::uniform3(-10.0..10.0).prop_map(Point::from), count)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn agrees_with_the_least_of_all_triangles(corners in points(3..=150), asked in points(1..=20)) {
        check(&corners, &asked)?;
    }

    #[test]
    fn agrees_where_triangles_are_degenerate(
        corners in prop::collection::vec(prop::array::uniform3(0i8..=2), 3..=60),
        asked in prop::collection::vec(prop::array::uniform3(-2i8..=8), 1..=20),
    ) {
        // Lattice points make collapsed, flat and repeated triangles; halves fall on faces and edges.
        let lattice = |at: &[i8; 3]| Point::from(at.map(f64::from));
        let asked: Vec<Point> = asked.iter().map(|at| lattice(at) / 2.0).collect();
        check(&corners.iter().map(lattice).collect::<Vec<_>>(), &asked)?;
    }
}

#[test]
fn the_middle_of_a_cube_is_half_its_edge_away() {
    let corner = |at: u32| Point3::from([0, 1, 2].map(|k| f64::from(at >> k & 1) * 4.0));
    let vertices: Vec<Point> = (0..8).map(corner).collect();
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let surface = BoundaryDistance::new(&vertices, &triangles).unwrap();
    for (point, distance) in [
        ([2.0, 2.0, 2.0], 2.0),
        ([2.0, 3.5, 2.0], 0.5),
        ([4.0, 1.0, 3.0], 0.0),
        ([7.0, 8.0, 2.0], 5.0),
        ([6.0, 5.0, -2.0], 3.0),
        ([2.0, 2.0, 1000.0], 996.0),
    ] {
        assert_eq!(surface.distance(&point.into()), distance, "{point:?}");
    }
}

#[test]
fn a_mesh_of_one_point_still_has_a_distance() {
    let surface = BoundaryDistance::new(&[Point::new(1.0, 2.0, 2.0)], &[[0, 0, 0]]).unwrap();
    assert_eq!(surface.distance(&Point::origin()), 3.0);
}

#[test]
fn unusable_meshes_and_points_are_refused() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
    let refused = |vertices: &[Point], triangles: &[[u32; 3]]| BoundaryDistance::new(vertices, triangles).err();
    assert_eq!(refused(&corners, &[]), Some(InspectError::NoTriangles));
    let missing = InspectError::NoSuchVertex { triangle: 0, vertex: 9, vertices: 3 };
    assert_eq!(refused(&corners, &[[0, 1, 9]]), Some(missing));
    let lost = [corners[0], corners[1], Point::new(0.0, f64::NAN, 0.0)];
    assert!(matches!(refused(&lost, &[[0, 1, 2]]), Some(InspectError::Coordinate { vertex: 2, .. })));
    let surface = BoundaryDistance::new(&corners, &[[0, 1, 2]]).unwrap();
    for bad in [f64::NAN, f64::INFINITY, 1e61] {
        let point = Point::new(0.0, bad, 0.0);
        assert!(surface.nearest(&point).is_none() && surface.distance(&point).is_nan());
    }
}
