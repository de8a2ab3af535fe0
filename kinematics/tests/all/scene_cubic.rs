//! Sweeps of cubic motions against dense samples of the same curve, and nozzles of which the shape decides.

use curvlay_kinematics::nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use curvlay_kinematics::scene::{
    Body, Mount, Posture, PostureError, Scene, SceneModel, Shape, Sweep, SweepError, cubic_control, links,
};
use curvlay_kinematics::{Arm, Positioner, robots};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::{FRAC_PI_2, TAU};

const SAMPLES: usize = 400;

fn body(name: &str, mount: Mount, [x, y, z]: [f64; 3], shape: Shape) -> Body {
    Body { name: name.into(), mount, mount_body: Isometry3::translation(x, y, z), shape }
}

fn block(size: [f64; 3]) -> Shape {
    let corner = Point3::from(size) * 0.5;
    Shape::block(-corner, corner)
}

/// A UR3 that prints onto a part on a desk.
fn ur3(margin: f64, more: Vec<Body>) -> Scene {
    let nozzle = Shape::Capsule { from: Point3::new(0.0, 0.0, 4.0), to: Point3::new(0.0, 0.0, 90.0), radius: 4.0 };
    let part = Shape::Cells { dims: [20, 20, 30], rows: vec![0xf_ffff; 600], cell: 4.0 };
    let mut bodies = vec![
        body("nozzle", Mount::Link(6), [0.0; 3], nozzle),
        body("desk", Mount::Base, [0.0, 0.0, -20.0], block([1200.0, 1200.0, 40.0])),
        body("part", Mount::Base, [-340.0, -40.0, 0.0], part),
    ];
    bodies.extend(more);
    let links = links(&robots::UR3);
    let allowed = vec![["base".into(), "desk".into()]];
    let arm = Arm::new(&robots::UR3).unwrap();
    Scene::new(SceneModel { links, bodies, margin, allowed, ..SceneModel::of(arm) }).unwrap()
}

/// Eight axes: the part on a table that tilts and turns.
fn eight(margin: f64) -> Scene {
    let at = Isometry3::translation(-350.0, 30.0, -1000.0);
    let nozzle = Shape::Capsule { from: Point3::new(0.0, 0.0, 4.0), to: Point3::new(0.0, 0.0, 90.0), radius: 4.0 };
    let bodies = vec![
        body("nozzle", Mount::Link(6), [0.0; 3], nozzle),
        body("wall", Mount::Base, [-350.0, -330.0, 100.0], block([600.0, 20.0, 300.0])),
        body("cradle", Mount::Tilt, [0.0, 0.0, -40.0], block([400.0, 60.0, 30.0])),
        body("plate", Mount::Table, [0.0, 0.0, -5.0], Shape::cylinder(125.0, -5.0, 5.0)),
        body("part", Mount::Table, [20.0, 0.0, 60.0], block([90.0, 60.0, 110.0])),
    ];
    Scene::new(SceneModel {
        links: links(&robots::UR5),
        bodies,
        margin,
        positioner: Some(Positioner::new(&robots::IRBP_A250, &at).unwrap()),
        ..SceneModel::of(Arm::new(&robots::UR5).unwrap())
    })
    .unwrap()
}

/// The curve by its Bernstein polynomials.
fn on_curve(control: &[Posture; 4], t: f64) -> Posture {
    let u = 1.0 - t;
    let weights = [u * u * u, 3.0 * u * u * t, 3.0 * u * t * t, t * t * t];
    let mix = |of: &dyn Fn(&Posture) -> f64| weights.iter().zip(control).map(|(w, c)| w * of(c)).sum();
    Posture { joints: [0, 1, 2, 3, 4, 5].map(|k| mix(&|c| c.joints[k])), table: [0, 1].map(|k| mix(&|c| c.table[k])) }
}

fn between(from: &Posture, to: &Posture, t: f64) -> Posture {
    let mix = |a: f64, b: f64| a + (b - a) * t;
    Posture {
        joints: [0, 1, 2, 3, 4, 5].map(|k| mix(from.joints[k], to.joints[k])),
        table: [0, 1].map(|k| mix(from.table[k], to.table[k])),
    }
}

/// A posture with every joint within so much of another's.
fn about(random: &mut Pcg64Mcg, posture: &Posture, most: f64) -> Posture {
    let mut moved = |angle: f64| angle + random.random_range(-most..most);
    Posture { joints: posture.joints.map(&mut moved), table: posture.table.map(&mut moved) }
}

/// What a sweep says of a curve is what samples of the curve say.
fn agrees(scene: &Scene, control: &[Posture; 4], resolution: f64) -> Result<bool, TestCaseError> {
    let sweep = scene.sweep_cubic(control, resolution).unwrap();
    prop_assert_eq!(sweep, scene.sweep_cubic(control, resolution).unwrap());
    let free_until = match sweep {
        Sweep::Free => 1.0,
        Sweep::Near { bodies, at, free_until } => {
            prop_assert!(0.0 <= free_until && free_until <= at && at <= 1.0);
            let nearest = scene.nearest(&on_curve(control, at)).unwrap().unwrap();
            prop_assert!(nearest.distance <= scene.margin() + resolution + 1e-5, "{at} {nearest:?}");
            prop_assert!(scene.pairs().any(|pair| pair == bodies));
            free_until
        }
    };
    prop_assert_eq!(scene.is_cubic_free(control, resolution).unwrap(), sweep == Sweep::Free);
    for k in 0..=SAMPLES {
        let t = k as f64 / SAMPLES as f64;
        let touching = scene.touching(&on_curve(control, t)).unwrap();
        prop_assert!(t >= free_until || touching.is_none(), "{t} {free_until} {touching:?}");
    }
    Ok(sweep == Sweep::Free)
}

fn random_posture(random: &mut Pcg64Mcg) -> Posture {
    about(random, &Posture { joints: [0.0, -1.3, -1.5, -1.9, FRAC_PI_2, 0.0], table: [0.0; 2] }, 0.8)
}

/// Control points anywhere near a posture, a way out and back, or a step of a spline: ends with rates, which bulges a
/// little.
fn random_control(random: &mut Pcg64Mcg) -> [Posture; 4] {
    let from = random_posture(random);
    let zero = Posture { joints: [0.0; 6], table: [0.0; 2] };
    let wide = random.random_range(0.02..0.5);
    match random.random_range(0..3) {
        0 => return [from, about(random, &from, wide), about(random, &from, wide), about(random, &from, wide)],
        1 => {
            let far = about(random, &from, 2.0 * wide);
            return [from, far, about(random, &far, 0.1 * wide), about(random, &from, 0.1 * wide)];
        }
        _ => {}
    }
    let (to, rates) = (about(random, &from, 0.1), [0; 2].map(|_| about(random, &zero, 1.0)));
    cubic_control(&from, &rates[0], &to, &rates[1], random.random_range(0.05..0.5))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn a_cubic_is_free_or_says_where_it_is_not(seed in 0u64..1_000_000, margin in 0.0..3.0, resolution in 0.05..1.0) {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        for scene in [ur3(margin, vec![]), eight(margin)] {
            for _ in 0..3 {
                agrees(&scene, &random_control(&mut random), resolution)?;
            }
        }
    }

    #[test]
    fn equally_spaced_control_points_are_a_straight_motion(seed in 0u64..1_000_000) {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        for scene in [ur3(1.0, vec![]), eight(1.0)] {
            for _ in 0..4 {
                let from = random_posture(&mut random);
                let to = about(&mut random, &from, 0.4);
                let control = [0.0, 1.0, 2.0, 3.0].map(|k| between(&from, &to, k / 3.0));
                prop_assert_eq!(scene.sweep_cubic(&control, 0.5), scene.sweep(&from, &to, 0.5));
                prop_assert_eq!(scene.is_cubic_free(&control, 0.5), scene.is_free(&from, &to, 0.5));
            }
        }
    }

    /// A curve that goes there and back is as free as in reverse.
    #[test]
    fn the_reverse_of_a_free_curve_is_free(seed in 0u64..1_000_000) {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let scene = eight(0.5);
        for _ in 0..4 {
            let control = random_control(&mut random);
            let [a, b, c, d] = control;
            prop_assert_eq!(scene.is_cubic_free(&control, 0.5), scene.is_cubic_free(&[d, c, b, a], 0.5));
        }
    }
}

/// An arm stretched out, turned by joint 1 and lifted by joint 2.
fn stretched(turn: f64, lift: f64) -> Posture {
    [turn, -lift, 0.0, 0.0, 0.3, 0.0].into()
}

fn column() -> Scene {
    ur3(0.0, vec![body("column", Mount::Base, [-380.0, -110.0, 160.0], block([40.0, 40.0, 320.0]))])
}

fn sampled_free(scene: &Scene, control: &[Posture; 4]) -> bool {
    let free = |k: usize| scene.touching(&on_curve(control, k as f64 / SAMPLES as f64)).unwrap().is_none();
    (0..=SAMPLES).all(free)
}

#[test]
fn a_bulge_that_collides_is_found_though_the_chord_is_free() {
    let scene = column();
    let control = [(-0.9, 1.0), (-0.3, -0.2), (0.3, -0.2), (0.9, 1.0)].map(|(turn, lift)| stretched(turn, lift));
    assert_eq!(scene.sweep(&control[0], &control[3], 0.1), Ok(Sweep::Free));
    let Ok(Sweep::Near { bodies, at, free_until }) = scene.sweep_cubic(&control, 0.1) else { panic!("went through") };
    assert!(0.0 < free_until && free_until < at && at < 1.0, "{bodies:?} {at} {free_until}");
    assert_eq!(scene.is_cubic_free(&control, 0.1), Ok(false));
    assert!(!sampled_free(&scene, &control));
    assert!(scene.nearest(&on_curve(&control, at)).unwrap().unwrap().distance <= 0.1 + 1e-5);
}

#[test]
fn a_curve_around_what_the_chord_meets_is_free() {
    let scene = column();
    let control = [(-0.9, 0.3), (-0.3, 1.5), (0.3, 1.5), (0.9, 0.3)].map(|(turn, lift)| stretched(turn, lift));
    let Ok(Sweep::Near { bodies, .. }) = scene.sweep(&control[0], &control[3], 0.1) else { panic!("went through") };
    assert!(bodies.contains(&"column"));
    assert_eq!(scene.sweep_cubic(&control, 0.1), Ok(Sweep::Free));
    assert_eq!(scene.is_cubic_free(&control, 0.1), Ok(true));
    assert!(sampled_free(&scene, &control));
}

/// The control points of a free curve may lie where the arm collides.
#[test]
fn control_points_off_the_curve_may_collide() {
    let scene = column();
    let control = [(-0.9, 1.2), (0.2, 0.3), (-0.9, 1.2), (-0.9, 1.2)].map(|(turn, lift)| stretched(turn, lift));
    assert!(scene.touching(&control[1]).unwrap().is_some());
    assert!(sampled_free(&scene, &control));
    assert_eq!(scene.sweep_cubic(&control, 0.1), Ok(Sweep::Free));
}

#[test]
fn control_points_that_coincide() {
    let scene = column();
    let (a, b, hit) = (stretched(-0.9, 0.3), stretched(-0.4, 1.0), stretched(0.2, 0.2));
    // No motion at all is a check.
    assert_eq!(scene.sweep_cubic(&[a; 4], 1e-3), Ok(Sweep::Free));
    assert!(scene.touching(&hit).unwrap().is_some());
    assert_eq!(scene.sweep_cubic(&[hit; 4], 1e-3), scene.sweep(&hit, &hit, 1e-3));
    assert!(matches!(scene.sweep_cubic(&[hit; 4], 1e-3), Ok(Sweep::Near { at: 0.5, free_until: 0.0, .. })));
    // From rest to rest, with a rate of 0 at one end, there and back, and with a cusp.
    for control in [[a, a, b, b], [a, a, b, a], [a, b, b, b], [a, b, b, a], [a, b, a, b]] {
        assert_eq!(scene.sweep_cubic(&control, 0.05), Ok(Sweep::Free));
        assert!(sampled_free(&scene, &control));
    }
    for control in [[a, a, hit, hit], [a, hit, hit, hit], [hit, hit, hit, a], [hit, a, a, hit]] {
        assert!(!agrees(&scene, &control, 0.05).unwrap());
    }
    // Nothing to compare.
    let alone = Scene::new(SceneModel::of(Arm::new(&robots::UR3).unwrap())).unwrap();
    assert_eq!(alone.sweep_cubic(&[a, hit, hit, a], 0.05), Ok(Sweep::Free));
}

#[test]
fn control_points_from_rates_are_those_of_the_cubic() {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let zero = Posture { joints: [0.0; 6], table: [0.0; 2] };
    for seconds in [0.01, 0.4, 3.0] {
        let [from, from_rate, to, to_rate] = [0; 4].map(|_| about(&mut random, &zero, 2.0));
        let control = cubic_control(&from, &from_rate, &to, &to_rate, seconds);
        assert_eq!((control[0], control[3]), (from, to));
        // Central differences of a cubic are off by its third derivative times the square of the step.
        let step = 1e-5;
        for k in 0..6 {
            for (t, rate) in [(0.0, &from_rate), (1.0, &to_rate)] {
                let [before, after] = [t - step, t + step].map(|t| on_curve(&control, t).joints[k]);
                assert!(((after - before) / (2.0 * step * seconds) - rate.joints[k]).abs() < 1e-6);
            }
        }
        assert!(
            (on_curve(&control, 0.5).table[1]
                - 0.5 * (from.table[1] + to.table[1])
                - 0.125 * seconds * (from_rate.table[1] - to_rate.table[1]))
                .abs()
                < 1e-12
        );
    }
}

#[test]
fn bad_cubics_are_named() {
    let good = Posture::from([0.1, -1.3, -1.5, -1.9, FRAC_PI_2, 0.0]);
    let (scene, with_table) = (ur3(0.0, vec![]), eight(0.0));
    for (k, bad) in [f64::NAN, f64::NEG_INFINITY, 1e7].into_iter().enumerate() {
        for index in 0..4 {
            let mut control = [good; 4];
            control[index].joints[k] = bad;
            let error = scene.sweep_cubic(&control, 1.0).unwrap_err();
            let source = match (index, error) {
                (0, SweepError::From(source)) | (3, SweepError::To(source)) => source,
                (1 | 2, SweepError::Control { index: at, source }) if at == index => source,
                _ => panic!("{index}: {error}"),
            };
            assert!(matches!(source, PostureError::Joint { table: false, joint, .. } if joint == k));
            assert_eq!(scene.is_cubic_free(&control, 1.0).unwrap_err().to_string(), error.to_string());
        }
    }
    let mut control = [good; 4];
    control[2].table[1] = f64::INFINITY;
    // A table that is not there may stand anyhow.
    assert!(scene.sweep_cubic(&control, 1.0).is_ok());
    let error = with_table.sweep_cubic(&control, 1.0).unwrap_err();
    assert_eq!(
        error.to_string(),
        "at control point 2: axis of the table 2 is inf: it must be an angle of less than 1e6 rad"
    );
    // There and back: the ends are the same, the way is too long.
    let mut control = [good; 4];
    control[1].joints[4] += 51.0;
    let too_long = SweepError::TooLong { table: false, joint: 4, turn: 102.0, max: 100.0 };
    let error = scene.sweep_cubic(&control, 1.0).unwrap_err();
    assert!(matches!(error, SweepError::TooLong { table: false, joint: 4, turn, .. } if (turn - 102.0).abs() < 1e-9));
    assert_eq!(error.to_string().split(':').nth(1), too_long.to_string().split(':').nth(1));
    let mut control = [good; 4];
    control[2].table[0] = -60.0;
    assert!(scene.sweep_cubic(&control, 1.0).is_ok());
    assert!(matches!(with_table.is_cubic_free(&control, 1.0), Err(SweepError::TooLong { table: true, joint: 0, .. })));
    for bad in [0.0, -1.0, f64::NAN, 1e-5, 1e7] {
        assert!(matches!(scene.sweep_cubic(&[good; 4], bad), Err(SweepError::Resolution { .. })));
        assert!(matches!(scene.is_cubic_free(&[good; 4], bad), Err(SweepError::Resolution { .. })));
    }
}

/// Limits of the table are not looked at: neither of the curve nor of its control points.
#[test]
fn control_points_may_lie_beyond_the_table_s_limits() {
    let scene = eight(0.0);
    let limits = *Positioner::new(&robots::IRBP_A250, &Isometry3::identity()).unwrap().limits();
    let at = |tilt: f64| Posture { joints: [0.0, -1.57, 0.0, 0.0, 0.0, 0.0], table: [tilt, 0.0] };
    let upper = limits.upper[0];
    let control = [upper - 0.4, upper + 0.1, upper + 0.1, upper - 0.4].map(at);
    assert!((0..=100).all(|k| on_curve(&control, f64::from(k) / 100.0).table[0] < upper));
    assert_eq!(scene.sweep_cubic(&control, 0.1).map(|sweep| sweep == Sweep::Free), Ok(sampled_free(&scene, &control)));
}

/// A hand that holds a ball under a nozzle which hangs down, at an overhang: the cone fits there, what is above it may not.
#[test]
fn the_width_of_the_head_above_the_nozzle_decides() {
    const OVERHANG: f64 = 1.2;
    let arm = Arm::new(&robots::UR3).unwrap();
    let tip = Point3::new(-260.0, 120.0, 330.0);
    let ball = Point3::new(0.0, 0.0, 40.0);
    // The cone: 0.4 mm wide at the tip, 8 mm high.
    let ring = |radius: f64, z: f64| {
        [(radius, 0.0), (0.0, radius), (-radius, 0.0), (0.0, -radius)].map(|(x, y)| Point3::new(x, y, z))
    };
    let cone = Shape::Hull { points: [ring(0.2, 0.0), ring(4.0, 8.0)].concat(), radius: 0.0 };
    let scene = |radius: f64| {
        let at_tip = [tip.x, tip.y, tip.z];
        let bodies = vec![
            body("cone", Mount::Base, at_tip, cone.clone()),
            body("head", Mount::Base, at_tip, Shape::cylinder(radius, 8.0, 60.0)),
            body("plate", Mount::Link(6), [0.0; 3], Shape::cylinder(60.0, 0.0, 10.0)),
            body("part", Mount::Link(6), [0.0; 3], Shape::Capsule { from: ball, to: ball, radius: 25.0 }),
        ];
        Scene::new(SceneModel { links: links(&robots::UR3), bodies, ..SceneModel::of(arm) }).unwrap()
    };
    let (narrow, wide) = (scene(10.0), scene(200.0));
    let mut free = 0;
    for k in 0..24 {
        // The ball is a third of a millimetre under the tip, the plate's axis leans in any direction.
        let around = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), TAU * f64::from(k) / 24.0);
        let turn: UnitQuaternion<f64> = around * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), OVERHANG);
        let origin: Vector3<f64> = tip.coords - 25.3 * Vector3::z() - turn * ball.coords;
        let flange = Isometry3::from_parts(origin.into(), turn);
        for (_, joints) in arm.inverse(&flange).unwrap().iter() {
            let at = Posture::from(*joints);
            if narrow.touching(&at).unwrap().is_none() {
                free += 1;
                let touch = wide.touching(&at).unwrap().unwrap();
                assert!(touch.contains(&"head"), "{touch:?}");
                assert!(wide.nearest(&at).unwrap().unwrap().distance <= 0.0);
                assert_eq!(wide.is_cubic_free(&[at; 4], 0.1), Ok(false));
            }
        }
    }
    assert!(free >= 10, "{free}");
}
