//! Least-distortion maps of mesh patches: against closed forms, a one-dimensional equation, and meshes that cannot be unrolled.

use curvlay_toolpath::drawing::*;
use curvlay_toolpath::nalgebra::{Point2, Point3};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

type Mesh = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// Rings around the axis: radius and height by the number of the ring; the first is the pole.
fn rings(count: u32, sides: u32, at: impl Fn(f64) -> [f64; 2]) -> Mesh {
    let mut vertices = vec![Point3::new(0.0, 0.0, at(0.0)[1])];
    let mut triangles = Vec::new();
    for ring in 1..=count {
        let [r, z] = at(f64::from(ring) / f64::from(count));
        // Every other ring is turned by half a side, so that triangles are of one kind.
        let half = 0.5 * f64::from(ring % 2);
        vertices.extend((0..sides).map(|k| {
            let a = TAU * (f64::from(k) + half) / f64::from(sides);
            Point3::new(r * a.cos(), r * a.sin(), z)
        }));
    }
    let at = |ring: u32, k: u32| 1 + (ring - 1) * sides + k % sides;
    for k in 0..sides {
        triangles.push([0, at(1, k), at(1, k + 1)]);
        for ring in 1..count {
            let (a, b, c, d) = (at(ring, k), at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1));
            if ring % 2 == 0 {
                triangles.extend([[a, c, b], [b, c, d]]);
            } else {
                triangles.extend([[a, d, b], [a, c, d]]);
            }
        }
    }
    (vertices, triangles)
}

fn sphere(radius: f64, angle: f64) -> Mesh {
    rings(24, 48, |t| [radius * (t * angle).sin(), radius * (t * angle).cos()])
}

fn grid(n: u32, height: impl Fn(f64, f64) -> f64) -> Mesh {
    let place = |k: u32| f64::from(k) / f64::from(n) * 20.0 - 10.0;
    let vertices = (0..=n).flat_map(|y| (0..=n).map(move |x| (place(x), place(y))));
    let vertices = vertices.map(|(x, y)| Point3::new(x, y, height(x, y))).collect();
    let at = |x: u32, y: u32| x + (n + 1) * y;
    let cells = (0..n).flat_map(|y| (0..n).map(move |x| (x, y)));
    let triangles = cells
        .flat_map(|(x, y)| [[at(x, y), at(x + 1, y), at(x + 1, y + 1)], [at(x, y), at(x + 1, y + 1), at(x, y + 1)]]);
    (vertices, triangles.collect())
}

fn unrolled(mesh: &Mesh, options: UnrollOptions) -> UnrolledMesh {
    UnrolledMesh::new(&mesh.0, &mesh.1, options).unwrap()
}

fn options(kind: UnrollKind) -> UnrollOptions {
    UnrollOptions { kind, ..UnrollOptions::default() }
}

/// A cylinder lies flat without any distortion, turned as the drawing is: x is the arc, y stays.
#[test]
fn cylinders_are_unrolled_exactly() {
    let mesh = grid(40, |x, _| (400.0f64 - x * x).sqrt());
    for kind in [UnrollKind::Rigid, UnrollKind::Conformal] {
        let map = unrolled(&mesh, options(kind));
        // The chords of the mesh are shorter than the arcs.
        assert!(map.distortion().largest < 1e-5, "{:?}", map.distortion());
        for [x, y] in [[0.0, 0.0], [5.0, 3.0], [-8.0, -9.0], [10.2, 9.5]] {
            let at = Projection::Unrolled.of(&map, &Point2::new(x, y)).unwrap().position;
            let wanted = Point3::new(20.0 * (x / 20.0f64).sin(), y, 20.0 * (x / 20.0f64).cos());
            assert!((at - wanted).norm() < 0.01, "{kind:?} {x} {y}: {at}");
        }
        let ((rounds, fell), rigid) = (map.rounds(), kind == UnrollKind::Rigid);
        assert!((rounds > 0) == rigid && fell < 1e-6);
    }
}

/// On a flat mesh the map is the identity, so the drawing comes where it would without.
#[test]
fn flat_patches_stay_as_they_are() {
    let (vertices, triangles) = grid(6, |_, _| 3.0);
    // Wound downwards, and within more than the patch.
    let triangles: Vec<[u32; 3]> = triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let options = UnrollOptions { reach: 8.0, ..UnrollOptions::default() };
    let map = UnrolledMesh::new(&vertices, &triangles, options).unwrap();
    let inside = Point2::new(2.5, -1.25);
    let hit = Projection::Unrolled.of(&map, &inside).unwrap();
    assert!((hit.position - Point3::new(2.5, -1.25, 3.0)).norm() < 1e-9 && (hit.normal.z - 1.0).abs() < 1e-12);
    assert!(Projection::Unrolled.of(&map, &Point2::new(9.5, 0.0)).is_none(), "beyond the reach");
    assert!(Projection::Vertical.of(&map, &Point2::new(9.5, 0.0)).is_some());
    assert!(Projection::Unrolled.of(&map, &Point2::new(f64::NAN, 0.0)).is_none());
}

/// Where the rigid map puts the circle at each share of the angle of a sphere's cap: `f` makes
/// `integral ((f' - 1)^2 + (f / rho - 1)^2) rho ds` least, with `rho` the radius of the circle and `s` its distance from the pole. So
/// `(rho (f' - 1))' = f / rho - 1`, with `f(0) = 0` and `f' = 1` at the rim. Solved by shooting: the equation is linear.
fn rigid_radii(radius: f64, angle: f64, steps: usize) -> Vec<f64> {
    let total = radius * angle;
    let rho = |s: f64| radius * (s / radius).sin();
    let h = total / steps as f64;
    // Near the pole f = slope s. The state is f and q = rho (f' - 1).
    let shoot = |slope: f64| {
        let derivative = |s: f64, f: f64, q: f64| [1.0 + q / rho(s), f / rho(s) - 1.0];
        let (mut f, mut q) = (slope * h, rho(h) * (slope - 1.0));
        let mut all = vec![0.0, f];
        for k in 1..steps {
            let s = k as f64 * h;
            let [a, b] = derivative(s, f, q);
            let [c, d] = derivative(s + 0.5 * h, f + 0.5 * h * a, q + 0.5 * h * b);
            let [e, g] = derivative(s + 0.5 * h, f + 0.5 * h * c, q + 0.5 * h * d);
            let [i, j] = derivative(s + h, f + h * e, q + h * g);
            f += h / 6.0 * (a + 2.0 * c + 2.0 * e + i);
            q += h / 6.0 * (b + 2.0 * d + 2.0 * g + j);
            all.push(f);
        }
        (all, q)
    };
    let (q0, q1) = (shoot(0.0).1, shoot(1.0).1);
    shoot(q0 / (q0 - q1)).0
}

#[test]
fn rigid_maps_of_a_cap_are_those_of_the_equation() {
    let (radius, angle) = (100.0, 1.0);
    let mesh = sphere(radius, angle);
    let map = unrolled(&mesh, options(UnrollKind::Rigid));
    let wanted = rigid_radii(radius, angle, 2400);
    // The drawing's circle at that radius comes to the circle of the sphere.
    for ring in [4usize, 12, 20, 23] {
        let s = angle * ring as f64 / 24.0;
        for k in 0..7 {
            let a = TAU * f64::from(k) / 7.0;
            let f = wanted[100 * ring];
            let at = Projection::Unrolled.of(&map, &Point2::new(f * a.cos(), f * a.sin())).unwrap().position;
            let on = Point3::new(radius * s.sin() * a.cos(), radius * s.sin() * a.sin(), radius * s.cos());
            assert!((at - on).norm() < 0.3, "{ring} {k}: {}", (at - on).norm());
        }
    }
    // Less is lost than along the meridian, in the mean of squares that is minimised and at the worst place.
    let cap = Revolved::new(Profile::Sphere { radius, top: radius }, radius * angle.sin()).unwrap();
    let samples: Vec<Point2<f64>> = (0..24)
        .flat_map(|r| (0..12).map(move |k| (4.0 * f64::from(r), TAU * f64::from(k) / 12.0)))
        .map(|(r, a)| Point2::new(r * a.cos(), r * a.sin()))
        .collect();
    let [meridian, rigid] =
        [distortion(&cap, Projection::Meridian, &samples), distortion(&map, Projection::Unrolled, &samples)];
    assert!(rigid.largest < meridian.largest, "{rigid:?} {meridian:?}");
    assert!(map.distortion().largest < meridian.largest);
}

/// Angles are kept: circles of the drawing are circles on the sphere, as by the stereographic projection.
#[test]
fn conformal_maps_keep_angles() {
    let (radius, angle) = (100.0, 1.0);
    let map = unrolled(&sphere(radius, angle), options(UnrollKind::Conformal));
    let h = 1.5;
    let place = |x: f64, y: f64| Projection::Unrolled.of(&map, &Point2::new(x, y)).map(|hit| hit.position);
    let mut worst = 0f64;
    for r in 0..10 {
        for k in 0..8 {
            let a = TAU * f64::from(k) / 8.0 + 0.1;
            let (x, y) = (8.0 * f64::from(r) * a.cos(), 8.0 * f64::from(r) * a.sin());
            let (u, v) = (
                place(x + h, y).unwrap() - place(x - h, y).unwrap(),
                place(x, y + h).unwrap() - place(x, y - h).unwrap(),
            );
            worst = worst.max((u.angle(&v) - PI / 2.0).abs()).max((u.norm() / v.norm() - 1.0).abs());
        }
    }
    assert!(worst < 0.06, "{worst}");
    // Of the area of the patch: the sizes around 1 are on both sides.
    let middle = distortion(&map, Projection::Unrolled, &[Point2::new(1.0, 2.0)]);
    assert!(middle.largest > 0.05 && map.distortion().largest > middle.mean);
}

/// A dome's map on its mesh is along the meridian up to what the meridian itself distorts; the surface of revolution itself is unrolled
/// along the meridian.
#[test]
fn the_dome_of_the_thesis_is_unrolled() {
    let profile = Profile::brooks();
    let mesh = rings(30, 60, |t| [140.0 * t, profile.height(140.0 * t).unwrap()]);
    let map = unrolled(&mesh, UnrollOptions::default());
    let dome = Revolved::new(profile, 140.0).unwrap();
    for k in 0..60 {
        let (r, a) = (2.0 * f64::from(k), 0.7 * f64::from(k));
        let at = Point2::new(r * a.cos(), r * a.sin());
        let meridian = Projection::Meridian.of(&dome, &at).unwrap().position;
        assert_eq!(Projection::Unrolled.of(&dome, &at).unwrap().position, meridian);
        let mapped = Projection::Unrolled.of(&map, &at).unwrap().position;
        assert!((mapped - meridian).norm() < 0.05 * r + 0.5, "{r}: {}", (mapped - meridian).norm());
    }
    assert!(project(&dome, Projection::Unrolled, 0, &[Point2::origin()], false, 1.0).is_ok());
    assert!(project(&map, Projection::Unrolled, 0, &[Point2::origin(), Point2::new(50.0, 0.0)], false, 1.0).is_ok());
    let beyond = project(&map, Projection::Unrolled, 7, &[Point2::new(500.0, 0.0)], false, 1.0);
    assert!(matches!(beyond, Err(ProjectError::Beyond { stroke: 7, .. })));
    let plain = MeshSurface::new(&mesh.0, &mesh.1).unwrap();
    assert_eq!(
        project(&plain, Projection::Unrolled, 0, &[Point2::origin()], false, 1.0),
        Err(ProjectError::NotUnrolled)
    );
    assert_eq!(project(&map, Projection::Meridian, 0, &[Point2::origin()], false, 1.0), Err(ProjectError::NoMeridians));
    // Not twice anything: the same input, the same output.
    assert!(map == unrolled(&mesh, UnrollOptions::default()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// Gentle hills are unrolled, and turning or lifting them turns or lifts the map.
    #[test]
    fn hills_are_unrolled_in_any_place(
        bumps in proptest::collection::vec((-6.0..6.0f64, -6.0..6.0f64, -2.0..2.0f64), 1..4),
        lift in -50.0..50.0f64,
    ) {
        let height = |x: f64, y: f64| -> f64 {
            bumps.iter().map(|(a, b, h)| h * (-((x - a).powi(2) + (y - b).powi(2)) / 12.0).exp()).sum()
        };
        let mesh = grid(16, height);
        let map = unrolled(&mesh, UnrollOptions::default());
        prop_assert!(map.distortion().largest < 0.5 && map.distortion().mean <= map.distortion().largest);
        let lifted: Vec<Point3<f64>> = mesh.0.iter().map(|p| Point3::new(-p.y, p.x, p.z + lift)).collect();
        let turned = UnrolledMesh::new(&lifted, &mesh.1, UnrollOptions::default()).unwrap();
        for [x, y] in [[0.5, 0.25], [-6.0, 3.0], [7.0, 7.0]] {
            let (Some(one), Some(other)) = (map.unrolled(&Point2::new(x, y)), turned.unrolled(&Point2::new(-y, x))) else { continue };
            let wanted = Point3::new(-one.position.y, one.position.x, one.position.z + lift);
            prop_assert!((other.position - wanted).norm() < 1e-6, "{} {}", other.position, wanted);
        }
    }
}

#[test]
fn meshes_that_cannot_be_unrolled_are_refused() {
    let refused = |vertices: &[[f64; 3]], triangles: &[[u32; 3]]| {
        let vertices: Vec<Point3<f64>> = vertices.iter().map(|v| Point3::from(*v)).collect();
        UnrolledMesh::new(&vertices, triangles, UnrollOptions::default()).unwrap_err()
    };
    let square =
        [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [3.0, 0.0, 0.0], [3.0, 0.0, 1.0]];
    assert_eq!(refused(&square, &[]), UnrollError::Mesh(MeshSurfaceError::Empty));
    assert_eq!(refused(&square, &[[1, 4, 2]]), UnrollError::NoPole);
    assert_eq!(refused(&square, &[[0, 1, 2], [0, 2, 3], [1, 2, 4]]), UnrollError::Winding { triangle: 2 });
    assert_eq!(refused(&square, &[[0, 1, 2], [1, 4, 2], [1, 5, 2]]), UnrollError::Edge { vertices: [1, 2] });
    let mut thin = square;
    thin[3] = [0.0, 0.0, 0.0];
    thin[4] = [1.0 + 1e-12, 0.0, 0.0];
    assert_eq!(refused(&thin, &[[0, 1, 2], [1, 4, 2]]), UnrollError::Degenerate { triangle: 1 });
    let flat = grid(2, |_, _| 0.0);
    for (options, wanted) in [
        (UnrollOptions { reach: 0.0, ..UnrollOptions::default() }, "reach"),
        (UnrollOptions { reach: f64::NAN, ..UnrollOptions::default() }, "reach"),
        (UnrollOptions { tolerance: 0.0, ..UnrollOptions::default() }, "tolerance"),
        (UnrollOptions { tolerance: f64::INFINITY, ..UnrollOptions::default() }, "tolerance"),
    ] {
        let error = UnrolledMesh::new(&flat.0, &flat.1, options).unwrap_err();
        assert!(matches!(error, UnrollError::Option { what, .. } if what == wanted), "{error}");
    }
    // A ramp that winds around the axis one and a half times, each turn with its inner edge at the axis, opens to more than a whole turn.
    let ramp = |turns: f64, pitch: f64| -> Mesh {
        let n = 60u32;
        let mut vertices = vec![];
        for k in 0..=n {
            let a = turns * TAU * f64::from(k) / f64::from(n);
            vertices.extend([0.2, 10.0].map(|r| Point3::new(r * a.cos() - 3.0, r * a.sin(), pitch * a)));
        }
        let triangles = (0..n).flat_map(|k| [[2 * k, 2 * k + 1, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 2]]).collect();
        (vertices, triangles)
    };
    let (vertices, triangles) = ramp(1.5, 0.3);
    let error = UnrolledMesh::new(&vertices, &triangles, UnrollOptions::default()).unwrap_err();
    assert!(matches!(error, UnrollError::Overlap { mm2 } if mm2 > 100.0), "{error:?}");
}

/// Spikes as high as the patch is wide, next to each other, do not lie flat without turning triangles over.
#[test]
fn triangles_upside_down_are_named() {
    let spiky = |amplitude: f64| grid(6, move |x, y| amplitude * (37.0 * x + 91.0 * y * y).sin());
    for kind in [UnrollKind::Rigid, UnrollKind::Conformal] {
        let (vertices, triangles) = spiky(40.0);
        let error = UnrolledMesh::new(&vertices, &triangles, options(kind)).unwrap_err();
        let UnrollError::Flipped { triangle, count } = error else { panic!("{error:?}") };
        assert!(triangle < triangles.len() && count > 0 && count < triangles.len());
        // The same hills, an eighth as high, lie flat.
        let (vertices, triangles) = spiky(2.0);
        assert!(UnrolledMesh::new(&vertices, &triangles, options(kind)).is_ok());
    }
}
