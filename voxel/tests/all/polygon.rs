//! Polygons as triangles: areas, rotations, and what is refused.

use curvlay_voxel::nalgebra::{Point3, Rotation3, Vector3};
use curvlay_voxel::{PolygonError, triangulate_polygon};
use proptest::prelude::*;

type Polygon = Vec<Point3<f64>>;

fn flat(corners: &[[f64; 2]]) -> Polygon {
    corners.iter().map(|&[x, y]| Point3::new(x, y, 0.0)).collect()
}

/// An L, a C, a U and a star, counter-clockwise, and their areas.
fn shapes() -> Vec<(Polygon, f64)> {
    let l = flat(&[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]]);
    let c = flat(&[[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 3.0], [4.0, 3.0], [4.0, 4.0], [0.0, 4.0]]);
    let u = flat(&[[0.0, 0.0], [5.0, 0.0], [5.0, 3.0], [4.0, 3.0], [4.0, 0.5], [1.0, 0.5], [1.0, 3.0], [0.0, 3.0]]);
    let star: Polygon = (0..10)
        .map(|k| {
            let (angle, radius) = (f64::from(k) * std::f64::consts::PI / 5.0, if k % 2 == 0 { 5.0 } else { 1.5 });
            Point3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        })
        .collect();
    let star_area = 10.0 * 0.5 * 5.0 * 1.5 * (std::f64::consts::PI / 5.0).sin();
    vec![(l, 5.0), (c, 10.0), (u, 7.5), (star, star_area)]
}

fn area(polygon: &Polygon, [a, b, c]: [usize; 3]) -> Vector3<f64> {
    (polygon[b] - polygon[a]).cross(&(polygon[c] - polygon[a])) / 2.0
}

/// The corners of the triangles, each from its least, in order.
fn places(polygon: &Polygon, triangles: &[[usize; 3]]) -> Vec<[[u64; 3]; 3]> {
    let mut places: Vec<_> = triangles
        .iter()
        .map(|triangle| {
            let mut corners = triangle.map(|at| [0, 1, 2].map(|axis| (polygon[at][axis] + 0.0).to_bits()));
            let least = (0..3).min_by_key(|&k| corners[k]).unwrap();
            corners.rotate_left(least);
            corners
        })
        .collect();
    places.sort_unstable();
    places
}

/// Every beginning of every shape, in several planes, also slightly bent: the same triangles, all one way round.
#[test]
fn every_rotation_gives_the_same_triangles() {
    let turns = [[0.0; 3], [0.4, 0.2, 1.0], [1.5, -0.7, 0.3], [std::f64::consts::PI, 0.0, 0.0]];
    for (shape, expected) in shapes() {
        for (turn, bend) in turns.iter().flat_map(|&turn| [(turn, 0.0), (turn, 0.05)]) {
            let turn = Rotation3::from_euler_angles(turn[0], turn[1], turn[2]);
            let bent = |(k, at): (usize, &Point3<f64>)| turn * (at + Vector3::z() * bend * ((k * 7 % 5) as f64 - 2.0));
            let mut polygon: Polygon = shape.iter().enumerate().map(bent).collect();
            let first = places(&polygon, &triangulate_polygon(&polygon).unwrap());
            for _ in 0..polygon.len() {
                polygon.rotate_left(1);
                let triangles = triangulate_polygon(&polygon).unwrap();
                assert_eq!(triangles.len(), polygon.len() - 2);
                assert_eq!(places(&polygon, &triangles), first);
                let along: Vec<f64> =
                    triangles.iter().map(|&t| area(&polygon, t).dot(&(turn * Vector3::z()))).collect();
                assert!(along.iter().all(|&area| area > 0.0), "{along:?}");
                assert!((along.iter().sum::<f64>() - expected).abs() < 1e-9, "{along:?}");
            }
        }
    }
}

/// A square hole, reached over a bridge that is run through both ways.
#[test]
fn a_bridge_to_a_hole_bounds_nothing() {
    let outer = [[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [0.0, 6.0], [0.0, 0.0]];
    let hole = [[2.0, 2.0], [2.0, 4.0], [4.0, 4.0], [4.0, 2.0], [2.0, 2.0]];
    let polygon = flat(&[&outer[..], &hole[..]].concat());
    let triangles = triangulate_polygon(&polygon).unwrap();
    let sum: f64 = triangles.iter().map(|&triangle| area(&polygon, triangle).z).sum();
    assert!((sum - 32.0).abs() < 1e-12, "{sum}");
}

#[test]
fn corners_on_an_edge_are_kept_and_repeats_are_one() {
    let polygon = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]]);
    let triangles = triangulate_polygon(&polygon).unwrap();
    assert_eq!(triangles.len(), 3);
    assert!(triangles.iter().flatten().any(|&at| at == 1 || at == 2));
}

#[test]
fn what_has_no_triangles_is_named() {
    let refused = |corners: &[[f64; 2]]| triangulate_polygon(&flat(corners)).unwrap_err();
    assert_eq!(refused(&[]), PolygonError::NoArea);
    assert_eq!(refused(&[[0.0, 0.0], [1.0, 0.0]]), PolygonError::NoArea);
    assert_eq!(refused(&[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0], [1.0, 0.0]]), PolygonError::NoArea);
    assert_eq!(refused(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]), PolygonError::NoArea);
    assert_eq!(refused(&[[0.0, 0.0], [4.0, 3.0], [4.0, 0.0], [0.0, 2.0]]), PolygonError::CrossesItself);
    let nan = [Point3::origin(), Point3::new(1.0, f64::NAN, 0.0), Point3::new(0.0, 1.0, 0.0)];
    assert_eq!(triangulate_polygon(&nan), Err(PolygonError::Coordinate { corner: 1 }));
}

proptest! {
    /// Star-shaped polygons of any radii: the area of the triangles is that of the polygon.
    #[test]
    fn areas_add_up(radii in prop::collection::vec(0.1..10.0f64, 3..40)) {
        let count = radii.len() as f64;
        let place = |(k, radius): (usize, &f64)| {
            let angle = k as f64 / count * std::f64::consts::TAU;
            Point3::new(radius * angle.cos(), 1.0, radius * angle.sin())
        };
        let polygon: Polygon = radii.iter().enumerate().map(place).collect();
        let triangles = triangulate_polygon(&polygon).unwrap();
        let shoelace: Vector3<f64> =
            (0..polygon.len()).map(|k| polygon[k].coords.cross(&polygon[(k + 1) % polygon.len()].coords) / 2.0).sum();
        let sum: Vector3<f64> = triangles.iter().map(|&triangle| area(&polygon, triangle)).sum();
        prop_assert!((sum - shoelace).norm() < 1e-9 * shoelace.norm().max(1.0));
        prop_assert!(triangles.iter().all(|&triangle| area(&polygon, triangle).y * shoelace.y > 0.0));
    }
}
