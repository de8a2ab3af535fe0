//! How near beads are to the shell: closed forms, and a slow twin that looks at every bead from every point.

use crate::common::{go_on, rng};
use curvlay_toolpath::nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::path::BeadKind;
use curvlay_toolpath::shell::{ShellError, ShellGap, ShellOptions, shell_gap};
use proptest::prelude::*;
use rand::RngExt;
use std::ops::ControlFlow;

const H: f64 = 0.2;
const WIDTH: f64 = 0.5;

fn waypoint(tip: Point3<f64>, arc: f64, kind: BeadKind) -> Waypoint {
    let direction = Vector3::z_axis();
    Waypoint {
        position: tip,
        axis: direction,
        width: WIDTH,
        height: H,
        arc,
        added: false,
        lift: Vector3::zeros(),
        kind,
    }
}

/// Straight beads along x, 10 mm long, of `layers` layers: `at` says where the middle of each is across.
fn wall(layers: u32, kind: BeadKind, at: impl Fn(u32) -> f64) -> Vec<ToolPath> {
    let path = |layer: u32| {
        let place = |x: f64| Point3::new(x, at(layer), H * f64::from(layer + 1));
        let waypoints = vec![waypoint(place(0.0), 0.0, kind), waypoint(place(10.0), 10.0, kind)];
        ToolPath { layer, curve: 0, closed: false, waypoints }
    };
    (0..layers).map(path).collect()
}

/// A side of 10 mm from one line along x to another, both by y and z; its outside is toward y.
fn side(low: [f64; 2], high: [f64; 2]) -> ([Point3<f64>; 4], [[u32; 3]; 2]) {
    let corner = |x: f64, [y, z]: [f64; 2]| Point3::new(x, y, z);
    ([corner(10.0, low), corner(0.0, low), corner(0.0, high), corner(10.0, high)], [[0, 1, 2], [0, 2, 3]])
}

fn gap_of(paths: &[ToolPath], (vertices, triangles): &([Point3<f64>; 4], [[u32; 3]; 2])) -> ShellGap {
    shell_gap(paths, vertices, triangles, &ShellOptions::default(), &go_on).unwrap()
}

#[test]
fn on_an_upright_wall_the_gap_is_that_between_round_rims() {
    let paths = wall(20, BeadKind::Wall, |_| 0.0);
    let shell = side([0.5 * WIDTH, 0.0], [0.5 * WIDTH, 20.0 * H]);
    let gap = gap_of(&paths, &shell);
    // At the height `z` from the middle of a bead the point is `sqrt(r^2 + z^2) - r` away, for `z` up to `r`.
    let r = 0.5 * H;
    let at = |share: f64| r * (1.0 + share * share).sqrt() - r;
    let mean = r * (0.5 * (2_f64.sqrt() + 1_f64.asinh()) - 1.0);
    assert!((gap.p50_mm - at(0.5)).abs() < 2e-3 && (gap.p95_mm - at(0.95)).abs() < 2e-3, "{gap:?}");
    assert!((gap.mean_mm - mean).abs() < 1e-3 && gap.bare_share == 0.0, "{gap:?}");
    assert!((150_000..300_000).contains(&gap.points));
}

#[test]
fn beads_outside_of_the_part_count_by_how_far_they_go() {
    // The shell is a rim's radius inside of the edges of the beads: `sqrt(r^2 - z^2)` of each bead is outside.
    let r = 0.5 * H;
    let at = 0.5 * WIDTH - r;
    let gap = gap_of(&wall(20, BeadKind::Wall, |_| 0.0), &side([at, 0.0], [at, 20.0 * H]));
    assert!((gap.p50_mm - r * 0.75_f64.sqrt()).abs() < 2e-3, "{gap:?}");
    assert!((gap.mean_mm - r * std::f64::consts::FRAC_PI_4).abs() < 2e-3, "{gap:?}");
    assert!(gap.p95_mm > 0.99 * r && gap.p95_mm < 1.01 * r && gap.bare_share == 0.0, "{gap:?}");
}

#[test]
fn what_leans_has_steps_and_what_has_no_bead_is_bare() {
    // Each layer half a millimetre farther out: steps of that at layers of 0.2 mm.
    let lean = 0.5;
    let paths = wall(20, BeadKind::Wall, |layer| lean * f64::from(layer));
    let [low, high] = [0.0, 20.0].map(|k| [lean * (k - 0.5) + 0.5 * WIDTH, H * k]);
    let steps = gap_of(&paths, &side(low, high));
    let upright = gap_of(&wall(20, BeadKind::Wall, |_| 0.0), &side([0.5 * WIDTH, 0.0], [0.5 * WIDTH, 20.0 * H]));
    assert!(steps.p95_mm > 1.5 * upright.p95_mm && steps.p95_mm < H, "{steps:?} {upright:?}");
    // Half of the side has no bead, but those a millimetre and the rim below.
    let bare = gap_of(&wall(20, BeadKind::Wall, |_| 0.0), &side([0.5 * WIDTH, 0.0], [0.5 * WIDTH, 40.0 * H]));
    assert!((bare.bare_share - (20.0 * H - 1.0) / (40.0 * H)).abs() < 0.01 && bare.p95_mm > 0.9999, "{bare:?}");
    // Support is not of the part.
    let support = wall(20, BeadKind::Support, |_| 0.0);
    assert!(gap_of(&support, &side([0.5 * WIDTH, 0.0], [0.5 * WIDTH, 20.0 * H])).bare_share > 0.9999);
}

#[test]
fn nothing_to_look_at_is_no_gap() {
    let paths = wall(1, BeadKind::Wall, |_| 0.0);
    let options = ShellOptions::default();
    assert_eq!(shell_gap(&paths, &[], &[], &options, &go_on), Ok(ShellGap::default()));
    let flat = shell_gap(&paths, &[Point3::origin(); 3], &[[0, 1, 2]], &options, &go_on);
    assert_eq!(flat, Ok(ShellGap::default()));
    let (vertices, triangles) = side([0.0, 0.0], [0.0, 1.0]);
    assert!(shell_gap(&[], &vertices, &triangles, &options, &go_on).unwrap().bare_share > 0.9999);
}

#[test]
fn what_cannot_be_looked_at_is_named() {
    let (vertices, triangles) = side([0.0, 0.0], [0.0, 1.0]);
    let paths = wall(1, BeadKind::Wall, |_| 0.0);
    let error = |options: &ShellOptions| shell_gap(&paths, &vertices, &triangles, options, &go_on).unwrap_err();
    let default = ShellOptions::default();
    for (name, options) in [
        ("points", ShellOptions { points: 0, ..default }),
        ("points", ShellOptions { points: usize::MAX, ..default }),
        ("bare_mm", ShellOptions { bare_mm: 0.0, ..default }),
        ("bare_mm", ShellOptions { bare_mm: f64::NAN, ..default }),
    ] {
        assert!(matches!(error(&options), ShellError::Option { option, .. } if option == name));
    }
    let missing = shell_gap(&paths, &vertices, &[[0, 1, 2], [0, 1, 9]], &default, &go_on);
    assert_eq!(missing, Err(ShellError::BadTriangle { triangle: 1 }));
    let nan = [vertices[0], vertices[1], Point3::new(f64::NAN, 0.0, 0.0)];
    assert_eq!(shell_gap(&paths, &nan, &[[0, 1, 2]], &default, &go_on), Err(ShellError::BadTriangle { triangle: 0 }));
    let mut bad = paths.clone();
    bad[0].waypoints[1].width = f64::INFINITY;
    let error = shell_gap(&bad, &vertices, &triangles, &default, &go_on);
    assert_eq!(error, Err(ShellError::BadWaypoint { path: 0, waypoint: 1 }));
    let stopped = shell_gap(&paths, &vertices, &triangles, &default, &|_| ControlFlow::Break(()));
    assert_eq!(stopped, Err(ShellError::Cancelled));
}

/// Beads and a triangle somewhere, by a seed.
fn anywhere(seed: u64) -> (Vec<ToolPath>, [Point3<f64>; 3]) {
    let mut rng = rng(seed);
    let mut point = |far: f64| Point3::from([0; 3].map(|_| rng.random_range(-far..far)));
    let triangle = [point(2.0), point(2.0), point(2.0)];
    let ends: Vec<[Point3<f64>; 3]> = (0..30).map(|_| [point(3.0), point(3.0), point(1.0)]).collect();
    let path = |[from, to, up]: &[Point3<f64>; 3]| {
        let direction = Unit::try_new(up.coords, 1e-9).unwrap_or(Vector3::z_axis());
        let waypoint = |tip| Waypoint { axis: direction, ..waypoint(tip, 0.0, BeadKind::Solid) };
        ToolPath { layer: 0, curve: 0, closed: false, waypoints: vec![waypoint(*from), waypoint(*to)] }
    };
    (ends.iter().map(path).collect(), triangle)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// With one point to the triangle, which is its middle.
    #[test]
    fn the_gap_is_that_to_the_nearest_of_all_beads(seed in 0_u64..10_000) {
        let (paths, triangle) = anywhere(seed);
        let options = ShellOptions { points: 1, bare_mm: 0.7 };
        let gap = shell_gap(&paths, &triangle, &[[0, 1, 2]], &options, &go_on).unwrap();
        let middles = {
            // The triangle may have more points than one, if it is long: all of them are looked at as the crate says.
            let area = 0.5 * (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0])).norm();
            prop_assume!(area > 1e-6 && gap.points == 1);
            Point3::from((triangle[0].coords + triangle[1].coords + triangle[2].coords) / 3.0)
        };
        let distance = |path: &ToolPath| {
            let [a, b] = [0, 1].map(|k| {
                let at = path.waypoints[k];
                at.position - at.axis.into_inner() * (0.5 * H)
            });
            let share = ((middles - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
            let to = middles - (a + (b - a) * share);
            let up = to.dot(&path.waypoints[0].axis);
            let aside = (to.norm_squared() - up * up).max(0.0).sqrt();
            up.hypot((aside - 0.5 * (WIDTH - H)).max(0.0)) - 0.5 * H
        };
        let slow = paths.iter().map(distance).fold(options.bare_mm, f64::min);
        // Inside of a bead another distance is taken.
        prop_assume!(slow >= 0.0);
        prop_assert!((gap.mean_mm - slow).abs() < 1e-7 && (gap.p95_mm - slow).abs() < 1e-7, "{} {slow}", gap.mean_mm);
    }

    #[test]
    fn moving_all_changes_nothing(seed in 0_u64..10_000, turn in prop::array::uniform3(-2.0_f64..2.0)) {
        let (paths, triangle) = anywhere(seed);
        let motion = Isometry3::from_parts(Vector3::from(turn).into(), UnitQuaternion::from_scaled_axis(Vector3::from(turn)));
        let moved: Vec<ToolPath> = paths.iter().map(|path| {
            let waypoints = path.waypoints.iter().map(|at| Waypoint { position: motion * at.position, axis: motion * at.axis, ..*at });
            ToolPath { waypoints: waypoints.collect(), ..path.clone() }
        }).collect();
        let options = ShellOptions { points: 500, ..ShellOptions::default() };
        let [here, there] = [(&paths, triangle), (&moved, triangle.map(|p| motion * p))]
            .map(|(paths, triangle)| shell_gap(paths, &triangle, &[[0, 1, 2]], &options, &go_on).unwrap());
        prop_assume!(here.points == there.points);
        prop_assert!((here.mean_mm - there.mean_mm).abs() < 1e-6 && (here.p95_mm - there.p95_mm).abs() < 1e-3);
    }
}

#[test]
fn threads_change_nothing() {
    let paths = wall(20, BeadKind::Wall, |_| 0.0);
    let shell = side([0.2, 0.0], [0.5, 4.0]);
    let many: Vec<[u32; 3]> = shell.1.iter().copied().cycle().take(3000).collect();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| shell_gap(&paths, &shell.0, &many, &ShellOptions::default(), &go_on).unwrap())
    };
    assert_eq!(on(1), on(4));
}
