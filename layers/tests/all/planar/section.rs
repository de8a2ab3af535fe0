//! Sections: closed forms, areas by sampling, and planes through vertices, edges and faces.

use super::shapes::{blocks, cells, cube, plane, sound_blocks, torus, turned};
use curvlay_layers::nalgebra::{Point2, Point3, Vector3};
use curvlay_layers::planar::{CutPlane, PlaneError, PlaneFrame, Solid, SolidError, slice};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn area(solid: &Solid, plane: &CutPlane) -> f64 {
    slice(solid, plane, &PlaneFrame::of(plane)).iter().map(|piece| piece.area()).sum()
}

#[test]
fn sections_of_a_cube_are_squares_and_hexagons() {
    let cube = cube();
    for z in [0.25, 0.5, 0.999] {
        assert!((area(&cube, &plane([0.0, 0.0, z], [0.0, 0.0, 1.0])) - 1.0).abs() < 1e-15);
    }
    // In its faces: a vertex on the plane counts as above.
    assert_eq!(area(&cube, &plane([0.0; 3], [0.0, 0.0, 1.0])), 0.0);
    assert_eq!(area(&cube, &plane([1.0; 3], [0.0, 0.0, 1.0])), 1.0);
    assert_eq!(area(&cube, &plane([0.0; 3], [0.0, 0.0, -1.0])), 1.0);
    // The regular hexagon, the triangle through three vertices, and the rectangle through four.
    assert!((area(&cube, &plane([0.5; 3], [1.0, 1.0, 1.0])) - 0.75 * 3f64.sqrt()).abs() < 1e-14);
    assert!((area(&cube, &plane([1.0, 0.0, 0.0], [1.0, 1.0, 1.0])) - 0.5 * 3f64.sqrt()).abs() < 1e-14);
    assert!((area(&cube, &plane([1.0, 0.0, 0.0], [1.0, 1.0, 0.0])) - 2f64.sqrt()).abs() < 1e-14);
}

#[test]
fn a_torus_has_a_ring_two_discs_or_an_eight() {
    let torus = torus(10.0, 3.0, [96, 48]);
    let level = plane([0.0; 3], [0.0, 0.0, 1.0]);
    let ring = slice(&torus, &level, &PlaneFrame::of(&level));
    assert_eq!((ring.len(), ring[0].holes.len()), (1, 1));
    let polygon = |r: f64| 48.0 * r * r * (TAU / 96.0).sin();
    assert!((ring[0].area() - (polygon(13.0) - polygon(7.0))).abs() < 1e-9);
    let upright = plane([0.0; 3], [0.0, 1.0, 0.0]);
    let discs = slice(&torus, &upright, &PlaneFrame::of(&upright));
    assert_eq!(discs.len(), 2);
    let disc = 24.0 * 9.0 * (TAU / 48.0).sin();
    assert!(discs.iter().all(|piece| (piece.area() - disc).abs() < 1e-9));
    // Through a saddle of the mesh: loops that touch in a vertex.
    let saddle = plane([7.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    let by_hand = sampled(&torus, &saddle, 160);
    assert!((area(&torus, &saddle) - by_hand).abs() < 0.02 * by_hand, "{by_hand}");
}

#[test]
fn a_cone_has_circles_an_ellipse_and_a_triangle() {
    let sides = 720;
    let cone = turned(&[[0.0, 0.0], [6.0, 0.0], [0.0, 12.0]], sides);
    let circle = |r: f64| sides as f64 / 2.0 * r * r * (TAU / sides as f64).sin();
    assert!((area(&cone, &plane([0.0, 0.0, 4.0], [0.0, 0.0, 1.0])) - circle(4.0)).abs() < 1e-9);
    // Through the axis and the tip.
    assert!((area(&cone, &plane([0.0; 3], [0.0, 1.0, 0.0])) - 72.0).abs() < 1e-9);
    // An ellipse: z = 6 + x / 2 cuts x^2 + y^2 = (12 - z)^2 / 4 in (1 - 1/16) x^2 + 3 x / 2 + y^2 = 9.
    let (k, shift) = (15.0 / 16.0, 3.0 / 4.0);
    let square: f64 = 9.0 + shift * shift / k;
    let ellipse = PI * square / f64::sqrt(k) * (1.0 + 0.25_f64).sqrt();
    let tilted = plane([0.0, 0.0, 6.0], [-0.5, 0.0, 1.0]);
    assert!((area(&cone, &tilted) - ellipse).abs() < 1e-4 * ellipse);
}

#[test]
fn islands_in_holes_come_apart() {
    // A frame around a post.
    let mut all = cells([0, 0, 0], [7, 7, 1]);
    all.retain(|&[x, y, _]| x == 0 || y == 0 || x == 6 || y == 6 || (x == 3 && y == 3));
    all.extend(cells([0, 0, 1], [7, 7, 2]));
    let solid = blocks(&all, 2.0);
    let level = plane([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
    let section = slice(&solid, &level, &PlaneFrame::of(&level));
    let mut areas: Vec<(f64, usize)> = section.iter().map(|piece| (piece.area(), piece.holes.len())).collect();
    areas.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(areas, [(4.0, 0), (96.0, 1)]);
}

/// The area of a section by the winding numbers of a grid of points in the plane.
fn sampled(solid: &Solid, plane: &CutPlane, n: i32) -> f64 {
    let frame = PlaneFrame::of(plane);
    let [low, high] = solid.bounds();
    let reach = (high - low).norm();
    let middle = frame.flat(&((low.coords + high.coords) / 2.0).into());
    let step = reach / f64::from(n);
    let mut inside = 0;
    for i in 0..n {
        for k in 0..n {
            let p = Point2::new((f64::from(i) + 0.437) * step, (f64::from(k) + 0.561) * step);
            let p = frame.place(&(middle + (p.coords - Vector3::new(reach, reach, 0.0).xy() / 2.0)));
            inside += i32::from(solid.winding(&p) > 0.5);
        }
    }
    f64::from(inside) * step * step
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10))]
    #[test]
    fn areas_agree_with_samples(at in prop::array::uniform3(-6.0..6.0_f64), n in prop::array::uniform3(-1.0..1.0_f64)) {
        prop_assume!(Vector3::from(n).norm() > 0.1);
        let solid = torus(8.0, 4.0, [12, 8]);
        let plane = plane(at, n);
        let (exact, slow) = (area(&solid, &plane), sampled(&solid, &plane, 60));
        prop_assert!((exact - slow).abs() < 2.0 + 0.03 * exact, "{exact} {slow}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Whole numbers: planes through vertices, along edges and in faces. Both directions leave out or take in what is in the plane;
    /// between them lies what is on either side.
    #[test]
    fn a_section_in_faces_is_that_of_the_cells_on_one_side(
        picked in prop::collection::vec(prop::array::uniform3(0..3_i32), 1..16), axis in 0..3_usize, at in -1..4_i32, up: bool,
    ) {
        let all = sound_blocks(&picked);
        let solid = blocks(&all, 1.0);
        let mut normal = [0.0; 3];
        normal[axis] = if up { 1.0 } else { -1.0 };
        let mut point = [0.0; 3];
        point[axis] = f64::from(at);
        // On the plane is above it: the plane lies lower, in the cells below.
        let row = if up { at - 1 } else { at };
        let count = all.iter().filter(|cell| cell[axis] == row).count();
        prop_assert_eq!(area(&solid, &plane(point, normal)), count as f64);
    }
}

#[test]
fn what_is_no_solid_and_no_plane_is_refused() {
    let cube = cube();
    let (vertices, triangles) = (cube.vertices().to_vec(), cube.triangles().to_vec());
    assert_eq!(Solid::new(&vertices, &[]), Err(SolidError::Empty));
    let open = Solid::new(&vertices, &triangles[1..]).unwrap_err();
    assert!(matches!(open, SolidError::Open { edges: 3, .. }), "{open}");
    let mut bad = triangles.clone();
    bad[3] = [0, 1, 99];
    assert!(matches!(Solid::new(&vertices, &bad), Err(SolidError::Triangle { triangle: 3, vertices: 8, .. })));
    bad[3] = [2, 1, 2];
    assert!(matches!(Solid::new(&vertices, &bad), Err(SolidError::Triangle { triangle: 3, .. })));
    let mut doubled = triangles.clone();
    doubled.extend(&triangles);
    assert!(matches!(Solid::new(&vertices, &doubled), Err(SolidError::NotManifold { faces: 4, .. })));
    let mut far = vertices.clone();
    far[2].y = f64::NAN;
    assert!(matches!(Solid::new(&far, &triangles), Err(SolidError::Coordinate { vertex: 2, .. })));
    let turned: Vec<_> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert_eq!(Solid::new(&vertices, &turned), Err(SolidError::NoVolume { volume: -1.0 }));
    for (point, normal) in
        [([0.0; 3], [0.0; 3]), ([f64::NAN, 0.0, 0.0], [0.0, 0.0, 1.0]), ([0.0; 3], [f64::INFINITY, 0.0, 0.0])]
    {
        let plane = CutPlane::through(&Point3::from(point), &Vector3::from(normal));
        assert!(matches!(plane, Err(PlaneError::Unusable { .. })), "{plane:?}");
    }
}

/// A plane whose numbers are exact in binary, and points that rounding puts on it.
#[test]
fn sides_are_exact() {
    let slanted = plane([0.0, 0.0, 0.0], [3.0, 4.0, 0.0]); // (0.6, 0.8, 0), rounded
    let n = slanted.normal();
    let on = Point3::new(n.y, -n.x, 7.0);
    assert_eq!(slanted.side(&on), 0);
    let off = Point3::new(n.y.next_up(), -n.x, 7.0);
    assert_eq!((slanted.side(&off), slanted.side(&Point3::new(n.y.next_down(), -n.x, 7.0))), (1, -1));
}
