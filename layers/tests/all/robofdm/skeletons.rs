use super::shapes::{Shape, cells, dumbbell, ring, tee, to_segment, tripod};
use curvlay_layers::nalgebra::{Point3, Vector3};
use curvlay_layers::planar::robofdm::{CurveSkeleton, RoboFdmError, SkeletonOptions, curve_skeleton};

fn skeleton(shape: &Shape) -> CurveSkeleton {
    curve_skeleton(&shape.points, &shape.triangles, &SkeletonOptions::default()).unwrap()
}

/// Edges minus nodes plus pieces: handles, for a connected graph.
fn cycles(skeleton: &CurveSkeleton) -> usize {
    skeleton.edges.len() + 1 - skeleton.nodes.len()
}

#[test]
fn branches_are_those_of_the_shape() {
    for (name, shape, branches) in [("dumbbell", dumbbell(), 1), ("tee", tee(), 3), ("tripod", tripod(), 3)] {
        let skeleton = skeleton(&shape);
        assert_eq!((skeleton.branch_count(), cycles(&skeleton)), (branches, 0), "{name}");
    }
}

#[test]
fn nodes_lie_on_the_axes_and_reach_to_near_the_ends() {
    let skeleton = skeleton(&tee());
    for p in &skeleton.nodes {
        let off = to_segment(p.coords, [20.0, 4.0, 0.0], [20.0, 4.0, 26.0]).min(to_segment(
            p.coords,
            [3.0, 4.0, 26.0],
            [37.0, 4.0, 26.0],
        ));
        // Within two radii of where the arms meet, the flow rounds the corner off, inside the rods.
        let near = (p.coords - Vector3::new(20.0, 4.0, 26.0)).norm() < 6.2;
        assert!(off < if near { 3.1 } else { 1.0 }, "{p} is {off} away");
    }
    // A tip recedes by some two radii, here 6.7, before its tube has become a line: without attraction to the medial axis.
    for end in [[20.0, 4.0, 0.0], [1.9, 4.0, 26.0], [38.1, 4.0, 26.0]] {
        assert!(skeleton.distance(Point3::from(end)) < 7.5, "{}", skeleton.distance(Point3::from(end)));
    }
    // The surface of a rod is a radius away from it.
    assert!((skeleton.distance(Point3::new(20.0, 7.0, 12.0)) - 3.0).abs() < 0.5);
}

#[test]
fn a_ring_keeps_its_hole_and_is_one_branch() {
    let skeleton = skeleton(&ring());
    assert_eq!((skeleton.branch_count(), cycles(&skeleton)), (1, 1));
    let radius = |p: &Point3<f64>| (p.coords - Vector3::new(16.0, 16.0, 4.0)).norm();
    // The flow moves a ring inwards a little until it is thin.
    assert!(skeleton.nodes.iter().all(|p| (10.5..12.5).contains(&radius(p))));
}

#[test]
fn a_ball_is_near_its_middle() {
    let middle = Vector3::new(6.0, 6.0, 6.0);
    let skeleton = skeleton(&cells([12, 12, 12], |p| (p - middle).norm() - 5.0));
    assert!(skeleton.branch_count() <= 1 && skeleton.nodes.iter().all(|p| (p.coords - middle).norm() < 1.0));
}

#[test]
fn a_larger_copy_has_a_larger_skeleton() {
    let small = tripod();
    let large = Shape { points: small.points.iter().map(|p| p * 4.0).collect(), ..small.clone() };
    let (small, large) = (skeleton(&small), skeleton(&large));
    assert_eq!((small.edges, small.steps), (large.edges, large.steps));
    assert!(small.nodes.iter().zip(&large.nodes).all(|(a, b)| (a * 4.0 - b).norm() < 1e-9));
}

#[test]
fn bad_meshes_and_options_are_named() {
    let shape = tee();
    let make = |points: &[Point3<f64>], triangles: &[[u32; 3]], options: SkeletonOptions| {
        curve_skeleton(points, triangles, &options).unwrap_err()
    };
    let default = SkeletonOptions::default();
    assert_eq!(make(&shape.points, &[], default), RoboFdmError::Empty);
    let open = &shape.triangles[1..];
    assert!(matches!(make(&shape.points, open, default), RoboFdmError::Open { facets: 1, .. }));
    let mut turned = shape.triangles.clone();
    turned[7].swap(0, 1);
    assert!(matches!(make(&shape.points, &turned, default), RoboFdmError::Open { facets: 2, .. }));
    let mut repeated = shape.triangles.clone();
    repeated[5] = [1, 1, 2];
    assert_eq!(make(&shape.points, &repeated, default), RoboFdmError::Facet { facet: 5 });
    repeated[5] = [0, 1, shape.points.len() as u32];
    assert_eq!(make(&shape.points, &repeated, default), RoboFdmError::Facet { facet: 5 });
    let mut points = shape.points.clone();
    points[3].y = f64::NAN;
    assert_eq!(make(&points, &shape.triangles, default), RoboFdmError::Coordinate { vertex: 3 });
    let bad = [
        ("weight", SkeletonOptions { weight: 0.0, ..default }),
        ("min_edge", SkeletonOptions { min_edge: f64::NAN, ..default }),
        ("max_edge", SkeletonOptions { max_edge: 0.0, ..default }),
        ("min_branch", SkeletonOptions { min_branch: -1.0, ..default }),
    ];
    for (expected, options) in bad {
        let error = make(&shape.points, &shape.triangles, options);
        assert!(matches!(error, RoboFdmError::Option { name, .. } if name == expected), "{error}");
    }
}
