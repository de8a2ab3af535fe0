//! Workcells as data: the cells of the examples against the same cells made by hand, what planners ask, numbers that cannot
//! be. Files are tested in `workcell_json.rs`.
#![cfg(feature = "serde")] // the cells are read from the files of the examples

use curvlay_kinematics::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use curvlay_kinematics::scene::{Body, Mount, Posture, Scene, SceneModel, Shape, links};
use curvlay_kinematics::workcell::{
    AnyWorkcell, ArmGeometry, EightAxisWorkcell, FreeRange, LimitsModel, MountModel, PositionerGeometry, ShapeModel,
    SixAxisWorkcell, Workcell, WorkcellError, WorkcellModel, tool_frame,
};
use curvlay_kinematics::{
    Arm, ArmError, JointLimits, Positioner, PositionerModel, Setup, TableSetup, Waypoint, nozzle_frame, robots,
};
use std::f64::consts::{PI, TAU};

const UR3: &str = include_str!("../../../examples/cells/ur3.json");
const IRB1200: &str = include_str!("../../../examples/cells/irb1200-table.json");
const UR10: &str = include_str!("../../../examples/cells/ur10.json");

fn model(text: &str) -> WorkcellModel {
    WorkcellModel::from_json(text.as_bytes()).unwrap()
}

fn six(model: WorkcellModel) -> SixAxisWorkcell {
    match AnyWorkcell::new(model).unwrap() {
        AnyWorkcell::Six(cell) => cell,
        _ => panic!("not six axes"),
    }
}

fn eight(model: WorkcellModel) -> EightAxisWorkcell {
    match AnyWorkcell::new(model).unwrap() {
        AnyWorkcell::Eight(cell) => cell,
        _ => panic!("not eight axes"),
    }
}

/// The IRB 1200 with a nozzle beside axis 6, bent.
fn bent() -> WorkcellModel {
    let mut model = model(IRB1200);
    model.nozzle.tip_mm = [64.0, 10.0, 154.0];
    model.nozzle.flow = [1.0, 0.2, 1.0];
    model
}

fn leaning(x: f64, y: f64, z: f64, lean: [f64; 2]) -> Waypoint {
    Waypoint { position: Point3::new(x, y, z), axis: UnitVector3::new_normalize(Vector3::new(lean[0], lean[1], 1.0)) }
}

fn waypoints() -> Vec<Waypoint> {
    let mut all = vec![];
    for (k, x) in [-50.0, 0.0, 50.0].into_iter().enumerate() {
        for y in [-50.0, 10.0, 50.0] {
            let (sin, cos) = (1.3 * k as f64 + 0.02 * y).sin_cos();
            for (z, lean) in [(0.0, 0.0), (30.0, 0.4), (100.0, 1.0)] {
                all.push(leaning(x, y, z, [lean * cos, lean * sin]));
            }
        }
    }
    all
}

fn assert_meets(part_nozzle: &Isometry3<f64>, waypoint: &Waypoint) {
    let apart = (part_nozzle.translation.vector - waypoint.position.coords).norm();
    let turned = (part_nozzle.rotation * Vector3::z()).cross(&waypoint.axis).norm();
    assert!(apart < 3e-6 && turned < 3e-9, "{apart:e} {turned:e}");
    assert!((part_nozzle.rotation * Vector3::z()).dot(&waypoint.axis) > 0.0);
}

fn fixed(name: &str, low: [f64; 3], high: [f64; 3]) -> Body {
    let shape = Shape::block(low.into(), high.into());
    Body { name: name.into(), mount: Mount::Base, mount_body: Isometry3::identity(), shape }
}

/// Nozzle, hot end and a plate of 150 mm, as the examples made them by hand.
fn printing(nozzle: (Mount, Isometry3<f64>), part: (Mount, Isometry3<f64>)) -> [Body; 3] {
    let ring = |radius: f64, z: f64| {
        let out = radius / (PI / 12.0).cos();
        (0..12).map(move |k| {
            let (sin, cos) = (TAU * f64::from(k) / 12.0).sin_cos();
            Point3::new(out * cos, out * sin, z)
        })
    };
    let wide = 0.5 + 8.0 * 45f64.to_radians().tan();
    let cone = Shape::Hull { points: ring(0.5, 0.0).chain(ring(wide, 8.0)).collect(), radius: 0.0 };
    let body = |name: &str, (mount, mount_body), shape| Body { name: name.into(), mount, mount_body, shape };
    [
        body("nozzle", nozzle, cone),
        body("hot end", nozzle, Shape::cylinder(10.0, 8.0, 61.0)),
        body("plate", part, Shape::cylinder(75.0, -4.0, 0.0)),
    ]
}

fn floor() -> Body {
    fixed("floor", [-1500.0, -1500.0, -650.0], [1500.0, 1500.0, -600.0])
}

/// The radius of a foot: half of the lesser width of its prisms.
fn foot(links: &[Body]) -> f64 {
    let Shape::Union(pieces) = &links[0].shape else { panic!("a foot is of pieces") };
    let wide = pieces.iter().fold([0.0f64; 2], |wide, piece| {
        let Shape::Hull { points, .. } = piece else { panic!("a piece is a prism") };
        points.iter().fold(wide, |[x, y], point| [x.max(point.x.abs()), y.max(point.y.abs())])
    });
    wide[0].min(wide[1])
}

fn solutions<const N: usize, const F: usize>(
    cell: &impl Workcell<N, F>,
    waypoint: &Waypoint,
    free: &[f64; F],
) -> Vec<(u32, [f64; N])> {
    let mut found = vec![];
    cell.solutions(waypoint, free, &mut |branch, joints| found.push((branch, joints)));
    found
}

#[test]
fn the_ur3_of_the_file_is_the_one_made_by_hand() {
    let nozzle = nozzle_frame(&Point3::new(300.0, 60.0, 260.0), &-Vector3::z_axis());
    let part = Isometry3::translation(0.0, 0.0, 120.0);
    let by_hand = Setup::part_in_hand(Arm::new(&robots::UR3).unwrap(), part, nozzle).unwrap();
    let cell = six(model(UR3));
    let mut count = 0;
    for waypoint in waypoints() {
        for k in 0..5 {
            let angle = 1.3 * f64::from(k) - 2.0;
            let expected = by_hand.arm().inverse(&by_hand.flange(&waypoint, angle)).unwrap();
            let expected: Vec<_> = expected.iter().map(|(branch, joints)| (branch.slot() as u32, *joints)).collect();
            assert_eq!(solutions(&cell, &waypoint, &[angle]), expected);
            for (branch, joints) in expected {
                let rates = by_hand.tool_rates(&joints).map(|rates| (joints, [rates.first]));
                assert_eq!(cell.following(&waypoint, &[angle], branch), rates);
                let on_part = cell.nozzle_on_part(&joints).unwrap();
                assert_eq!(on_part, by_hand.nozzle_on_part(&joints));
                assert_meets(&on_part, &waypoint);
                let stance = cell.frames(&joints).unwrap();
                let frames = by_hand.frames(&joints, &waypoint, angle);
                assert_eq!((stance.nozzle, stance.carrier), (nozzle, stance.arm[6]));
                assert!((stance.part.to_homogeneous() - frames.part.to_homogeneous()).amax() < 1e-11);
                let pose = cell.controller_pose(&joints).unwrap();
                assert_eq!((pose.target.pose, pose.table, pose.joints), (tool_frame(&on_part), None, joints));
                count += 1;
            }
        }
    }
    assert!(count > 200, "{count}");
    assert_eq!(cell.free(), [FreeRange::Turn]);
    let mut limits = robots::UR3.limits;
    (limits.lower[2], limits.upper[2]) = (-PI, PI);
    assert_eq!(*cell.limits(), JointLimits { acceleration: [10.0; 6], jerk: [100.0; 6], ..limits });

    let links = links(&robots::UR3);
    let foot = foot(&links);
    let mut bodies = vec![
        fixed("beam", [-400.0, -foot, -40.0], [foot, foot, 0.0]),
        fixed("pillar", [-500.0, -100.0, -600.0], [-400.0, 100.0, 0.0]),
        floor(),
    ];
    bodies.extend(printing((Mount::Base, nozzle), (Mount::Link(6), part)));
    let scene = cell.equipment().scene(150.0);
    assert_eq!(scene, SceneModel { links, bodies, link_allowance: 10.0, ..SceneModel::of(*cell.setup().arm()) });
}

#[test]
fn the_irb1200_of_the_file_is_the_one_made_by_hand() {
    let limits = JointLimits { acceleration: [10.0; 2], jerk: [100.0; 2], ..robots::IRBP_A250.limits };
    let table = PositionerModel { limits, ..robots::IRBP_A250 };
    let positioner = Positioner::new(&table, &Isometry3::translation(520.0, 0.0, -900.0)).unwrap();
    let nozzle = nozzle_frame(&Point3::new(0.0, 0.0, 150.0), &Vector3::z_axis());
    let arm = Arm::new(&robots::IRB1200).unwrap();
    let by_hand = TableSetup::nozzle_in_hand(arm, nozzle, positioner, Isometry3::identity()).unwrap();
    let cell = eight(model(IRB1200));
    let mut count = 0;
    for waypoint in waypoints() {
        for free in [[0.0, 0.0], [0.7, 2.0], [-0.9, -3.0], [0.2, 4.0]] {
            let table = [free[0], free[1] - TAU * (free[1] / TAU).round()];
            let at = by_hand.at(&table).unwrap();
            let found = at.arm().inverse(&at.flange(&waypoint, 0.0)).unwrap();
            let rest = |q: &[f64; 6]| [q[0], q[1], q[2], q[3], q[4], 0.0, table[0], table[1]];
            let expected: Vec<_> = found.iter().map(|(branch, q)| (branch.slot() as u32, rest(q))).collect();
            assert_eq!(solutions(&cell, &waypoint, &free), expected);
            for (branch, joints) in expected {
                let arm: [f64; 6] = std::array::from_fn(|j| joints[j]);
                let rates = by_hand.rates(&table, &arm).map(|[_, tilt, turn]| {
                    let mut rows = [rest(&tilt.first), rest(&turn.first)];
                    (rows[0][6], rows[0][7], rows[1][6], rows[1][7]) = (1.0, 0.0, 0.0, 1.0);
                    (joints, rows)
                });
                assert_eq!(cell.following(&waypoint, &free, branch), rates);
                assert_meets(&cell.nozzle_on_part(&joints).unwrap(), &waypoint);
                let pose = cell.controller_pose(&joints).unwrap();
                assert_eq!((pose.table, pose.joints), (Some(table), arm));
                assert_eq!(cell.scene_posture(&joints), Posture { joints: arm, table });
                let stance = cell.frames(&joints).unwrap();
                assert_eq!(stance.part, at.part_frame().1);
                count += 1;
            }
        }
    }
    assert!(count > 200, "{count}");
    assert_eq!(cell.free(), [FreeRange::Within(-PI / 3.0, PI / 3.0), FreeRange::Turn]);
    let limits = cell.limits();
    assert_eq!(
        (limits.lower[..6].to_vec(), limits.lower[6..].to_vec()),
        (robots::IRB1200.limits.lower.to_vec(), vec![-TAU; 2])
    );
    assert_eq!((limits.velocity[5], limits.velocity[7]), (600f64.to_radians(), 85f64.to_radians()));
    assert_eq!((limits.acceleration, limits.jerk), ([10.0; 8], [100.0; 8]));

    let links = links(&robots::IRB1200);
    let body = |name: &str, mount, mount_body, shape| Body { name: name.into(), mount, mount_body, shape };
    let mut bodies = vec![
        body("pedestal", Mount::Base, Isometry3::identity(), Shape::cylinder(foot(&links), -600.0, 0.0)),
        floor(),
        body("post", Mount::Table, Isometry3::identity(), Shape::cylinder(60.0, -105.0, -4.0)),
        body("holder", Mount::Link(6), nozzle, Shape::cylinder(25.0, 60.0, 150.0)),
    ];
    bodies.extend(printing((Mount::Link(6), nozzle), (Mount::Table, Isometry3::identity())));
    let own = SceneModel { link_allowance: 10.0, ..SceneModel::of(*cell.setup().arm()) };
    let expected = SceneModel { links, bodies, positioner: Some(positioner), ..own };
    assert_eq!(cell.equipment().scene(150.0), expected);
}

#[test]
fn a_plate_with_corners_lies_about_the_middle_of_the_part() {
    let mut model = model(UR10);
    (model.plate.size_mm, model.plate.diameter_mm) = (Some([300.0, 200.0]), None);
    let scene = six(model).equipment().scene(100.0);
    let plate = scene.bodies.iter().find(|body| body.name == "plate").unwrap();
    assert_eq!(plate.shape, Shape::block(Point3::new(-150.0, -100.0, -20.0), Point3::new(150.0, 100.0, 0.0)));
}

/// Every waypoint over the plate, up to 45 degrees aside, has a posture with nothing nearer than a centimetre but the nozzle
/// itself, far from singularities.
#[test]
fn a_ur10_reaches_over_its_plate() {
    let cell = six(model(UR10));
    assert_eq!(cell.equipment().nozzle_frame().0, Mount::Link(6));
    assert_eq!(cell.equipment().part_frame(), (Mount::Base, Isometry3::translation(750.0, 0.0, 0.0)));
    let scene = cell.equipment().scene(100.0);
    // The plate is as wide as the file says, not as the print wants it.
    let plate = scene.bodies.iter().find(|body| body.name == "plate").unwrap();
    assert_eq!(plate.shape, Shape::cylinder(150.0, -20.0, 0.0));
    // What prints may be near the plate.
    let allowed = ["nozzle", "hot end"].map(|name| [name.into(), "plate".into()]).into();
    let scene = Scene::new(SceneModel { margin: 10.0, allowed, ..scene }).unwrap();
    for waypoint in waypoints() {
        let mut best = 0.0f64;
        for k in 0..12 {
            for (_, joints) in solutions(&cell, &waypoint, &[TAU * f64::from(k) / 12.0]) {
                assert_meets(&cell.nozzle_on_part(&joints).unwrap(), &waypoint);
                let within = cell.limits().contains(&joints);
                if within && scene.touching(&cell.scene_posture(&joints)).unwrap().is_none() {
                    best = best.max(cell.manipulability(&joints));
                }
            }
        }
        assert!(best > 1e8, "{waypoint:?} {best:e}");
    }
}

/// Derivatives against differences, the waypoint met, in all cells.
fn assert_follows<const N: usize, const F: usize>(cell: &impl Workcell<N, F>, free: [f64; F]) {
    const STEP: f64 = 1e-5;
    let mut count = 0;
    for waypoint in waypoints() {
        for branch in 0..8 {
            let Some((joints, rates)) = cell.following(&waypoint, &free, branch) else { continue };
            if cell.manipulability(&joints) < 1e7 || rates.iter().flatten().any(|rate| rate.abs() > 10.0) {
                continue;
            }
            assert_meets(&cell.nozzle_on_part(&joints).unwrap(), &waypoint);
            for (f, rates) in rates.iter().enumerate() {
                let at = |step: f64| {
                    let free = std::array::from_fn(|g| if g == f { free[g] + step } else { free[g] });
                    cell.following(&waypoint, &free, branch).unwrap().0
                };
                let (before, after) = (at(-STEP), at(STEP));
                for j in 0..N {
                    let off = after[j] - before[j];
                    let slope = (off - TAU * (off / TAU).round()) / (2.0 * STEP);
                    assert!((slope - rates[j]).abs() < 1e-5, "{branch} {f} {j}: {slope} {}", rates[j]);
                }
            }
            count += 1;
        }
    }
    assert!(count > 20, "{count}");
}

#[test]
fn joints_follow_the_free_parameters() {
    assert_follows(&six(model(UR3)), [0.7]);
    assert_follows(&six(model(UR10)), [-2.0]);
    assert_follows(&eight(model(IRB1200)), [0.3, 1.9]);
    assert_follows(&eight(bent()), [0.3, 1.9]);
    let mut turned = bent();
    turned.positioner.as_mut().unwrap().tool_angle_deg = 130.0;
    assert_follows(&eight(turned), [-0.4, -2.5]);
}

#[test]
fn a_bent_nozzle_keeps_its_heading_over_a_table() {
    let mut turned = bent();
    turned.positioner.as_mut().unwrap().tool_angle_deg = 30.0;
    let cell = eight(turned);
    let (waypoint, mut count) = (leaning(10.0, 20.0, 30.0, [0.0, 0.0]), 0);
    for turn in [0.0, 1.0, 2.0, 3.0] {
        for (_, joints) in solutions(&cell, &waypoint, &[0.0, turn]) {
            let x = cell.frames(&joints).unwrap().nozzle.rotation * Vector3::x();
            let expected = Vector3::new(30f64.to_radians().cos(), 30f64.to_radians().sin(), 0.0);
            assert!((x - expected).norm() < 1e-8, "{x:?}");
            count += 1;
        }
    }
    assert!(count > 8);
    // Growth straight down in the base has no heading that could be followed, but no nonsense comes out either.
    let down = Waypoint { position: Point3::new(0.0, 0.0, 300.0), axis: -Vector3::z_axis() };
    for branch in 0..8 {
        assert_eq!(cell.following(&down, &[0.0, 0.0], branch), None);
    }
}

#[test]
fn the_arm_goes_on_with_the_table_at_rest_and_the_tool_turned() {
    for (cell, is_on_axis) in [(eight(model(IRB1200)), true), (eight(bent()), false)] {
        let waypoint = leaning(10.0, -20.0, 40.0, [0.2, 0.1]);
        let mut count = 0;
        for (_, mut joints) in solutions(&cell, &waypoint, &[0.1, 0.4]) {
            if !cell.limits().contains(&joints) || cell.manipulability(&joints) < 1e7 {
                continue;
            }
            joints[7] -= TAU; // a whole turn of the table stays
            let again = cell.continuing(&waypoint, &[0.0; 2], 0.0, &joints).unwrap();
            assert!((0..8).all(|j| (again[j] - joints[j]).abs() < 1e-9), "{again:?} {joints:?}");
            let lifted = Waypoint { position: waypoint.position + 5.0 * waypoint.axis.into_inner(), ..waypoint };
            let Some(next) = cell.continuing(&lifted, &[0.0; 2], 0.3, &joints) else { continue };
            assert_eq!((next[6], next[7]), (joints[6], joints[7]));
            // In two steps it is where one step leads: the turn counts from the free parameters.
            let half = cell.continuing(&lifted, &[0.0; 2], 0.15, &joints).unwrap();
            let twice = cell.continuing(&lifted, &[0.0; 2], 0.3, &half).unwrap();
            assert!((0..8).all(|j| (twice[j] - next[j]).abs() < 1e-9));
            let [before, after] = [&joints, &next].map(|joints| cell.nozzle_on_part(joints).unwrap());
            assert_meets(&after, &lifted);
            let turn = (before.rotation.inverse() * after.rotation).scaled_axis();
            if !is_on_axis {
                assert!((turn - Vector3::z() * 0.3).norm() < 1e-7, "{turn:?}");
            } else {
                // Along axis 6 other joints turn as well; joint 6 itself is what is asked for. It points down the nozzle.
                assert!((next[5] + 0.3).abs() < 1e-9, "{}", next[5]);
            }
            count += 1;
        }
        assert!(count > 1, "{count}");
    }
    // On a UR3 the turn is that of the tool angle.
    let (cell, waypoint) = (six(model(UR3)), leaning(5.0, 0.0, 20.0, [0.1, 0.0]));
    let (_, joints) = solutions(&cell, &waypoint, &[0.4])[0];
    let next = cell.continuing(&waypoint, &[0.4], 0.1, &joints).unwrap();
    let expected = solutions(&cell, &waypoint, &[0.5])[0].1;
    assert!((0..6).all(|j| (next[j] - expected[j]).abs() < 1e-9));
}

/// The lengths of the IRB 1200, times a factor.
fn irb1200_geometry(by: f64) -> ArmGeometry {
    ArmGeometry::OrthoParallel {
        j23_factor: 0.0,
        a1_mm: 0.0,
        a2_mm: -42.0 * by,
        b_mm: 0.0,
        c1_mm: 399.1 * by,
        c2_mm: 350.0 * by,
        c3_mm: 351.0 * by,
        c4_mm: 82.0 * by,
        offsets_deg: [0.0, 0.0, -90.0, 0.0, 0.0, 0.0],
        signs: [1.0; 6],
    }
}

/// Joint 6 that turns the other way, or rests elsewhere: the same motion of the nozzle.
#[test]
fn the_sense_of_joint_6_is_seen() {
    let mut other = model(IRB1200);
    let mut geometry = irb1200_geometry(1.0);
    if let ArmGeometry::OrthoParallel { signs, .. } = &mut geometry {
        signs[5] = -1.0;
    }
    other.arm.geometry = geometry;
    let stops = |side: f64| Some([170.0, 150.0, 200.0, 270.0, 130.0, 350.0].map(|stop| Some(side * stop)));
    other.arm.limits = LimitsModel { min_deg: stops(-1.0), max_deg: stops(1.0), ..other.arm.limits };
    other.arm.limits.max_deg.as_mut().unwrap()[5] = Some(370.0); // the middle is 10 degrees
    let cell = eight(other);
    let waypoint = leaning(10.0, -20.0, 40.0, [0.2, 0.1]);
    let mut count = 0;
    for (_, joints) in solutions(&cell, &waypoint, &[0.1, 0.4]) {
        assert!((joints[5] - 10f64.to_radians()).abs() < 1e-12);
        assert_meets(&cell.nozzle_on_part(&joints).unwrap(), &waypoint);
        if !cell.limits().contains(&joints) {
            continue;
        }
        if let Some(next) = cell.continuing(&waypoint, &[0.0; 2], 0.3, &joints) {
            assert!((next[5] - joints[5] - 0.3).abs() < 1e-9);
            assert!((0..5).all(|j| (next[j] - joints[j]).abs() < 1e-9));
            count += 1;
        }
    }
    assert!(count > 0);
}

/// Joint 6 of a UR3 turns without end: it rests at zero.
#[test]
fn an_endless_joint_6_rests_at_zero() {
    let mut ur3 = model(IRB1200);
    ur3.arm.geometry = ArmGeometry::Named("UR3".into());
    ur3.positioner.as_mut().unwrap().frame.position_mm = [-300.0, 0.0, -1100.0];
    let cell = eight(ur3);
    let waypoint = leaning(0.0, 0.0, 10.0, [0.1, 0.1]);
    let found = solutions(&cell, &waypoint, &[0.0, 0.0]);
    assert!(!found.is_empty());
    for (_, joints) in found {
        assert!(joints[5].abs() < 1e-12, "{joints:?}");
        assert_meets(&cell.nozzle_on_part(&joints).unwrap(), &waypoint);
    }
}

#[test]
fn stands_have_the_width_that_they_are_given() {
    use curvlay_kinematics::workcell::StandModel::{Beam, Pedestal};
    let bodies = |stand| {
        let mut model = model(UR3);
        model.stand = Some(stand);
        six(model).equipment().scene(100.0).bodies
    };
    let found = bodies(Pedestal { height_mm: 500.0, radius_mm: Some(90.0) });
    assert_eq!(found[0].shape, Shape::cylinder(90.0, -500.0, 0.0));
    let beam = Beam {
        height_mm: 500.0,
        thickness_mm: 30.0,
        length_mm: 300.0,
        half_width_mm: Some(50.0),
        pillar_mm: [80.0, 120.0],
    };
    let expected = [
        fixed("beam", [-300.0, -50.0, -30.0], [50.0, 50.0, 0.0]),
        fixed("pillar", [-380.0, -60.0, -500.0], [-300.0, 60.0, 0.0]),
    ];
    assert_eq!(bodies(beam)[..2], expected);
}

#[test]
fn a_table_with_narrow_stops_is_no_turn() {
    let mut narrow = model(IRB1200);
    let table = narrow.positioner.as_mut().unwrap();
    (table.limits.min_deg, table.limits.max_deg) = (Some([Some(-70.0), Some(-90.0)]), Some([Some(70.0), Some(200.0)]));
    let cell = eight(narrow);
    let degrees = f64::to_radians;
    let expected =
        [FreeRange::Within(degrees(-60.0), degrees(60.0)), FreeRange::Within(degrees(-90.0), degrees(200.0))];
    assert_eq!(cell.free(), expected);
    let waypoint = leaning(0.0, 0.0, 20.0, [0.0, 0.0]);
    let found = solutions(&cell, &waypoint, &[0.0, degrees(190.0)]);
    assert!(!found.is_empty() && found.iter().all(|(_, joints)| joints[7] > PI));
    assert!(solutions(&cell, &waypoint, &[0.0, degrees(-100.0)]).is_empty());
    assert_eq!(cell.frames(&[0.0, 0.0, 0.0, 0.0, 0.1, 0.0, 2.0, 0.0]), None);
}

/// The same arm by its lengths, not by its name.
fn with_lengths(text: &str) -> WorkcellModel {
    let mut model = model(text);
    let d_mm = [127.3, 0.0, 0.0, 163.941, 115.7, 92.2];
    model.arm.geometry = ArmGeometry::Ur {
        d_mm,
        upper_arm_mm: -612.0,
        forearm_mm: -572.3,
        offsets_deg: [0.0; 6],
        signs: [1.0; 6],
        j23_factor: 0.0,
    };
    model
}

#[test]
fn limits_that_are_not_given_are_the_robots_or_none() {
    let mut bare = model(UR3);
    bare.arm.limits = LimitsModel::default();
    assert_eq!(*six(bare.clone()).limits(), robots::UR3.limits);
    bare.arm.limits.max_speed_deg_s = Some([Some(10.0), None, None, None, None, None]);
    let limits = *six(bare).limits();
    assert_eq!((limits.velocity[0], limits.velocity[1]), (10f64.to_radians(), f64::INFINITY));
    assert_eq!((limits.jerk, limits.upper), ([f64::INFINITY; 6], robots::UR3.limits.upper));
    let mut own = with_lengths(UR10);
    own.arm.limits = LimitsModel::default();
    assert_eq!(*six(own).limits(), JointLimits::NONE);
}

#[test]
fn nothing_comes_of_numbers_that_are_none() {
    let cell = eight(model(IRB1200));
    let waypoint = leaning(0.0, 0.0, 20.0, [0.0, 0.0]);
    let nowhere = Waypoint { position: Point3::new(f64::NAN, 0.0, 0.0), ..waypoint };
    assert!(solutions(&cell, &nowhere, &[0.0; 2]).is_empty());
    assert!(solutions(&cell, &waypoint, &[f64::NAN, 0.0]).is_empty());
    assert!(solutions(&cell, &waypoint, &[0.0, f64::INFINITY]).is_empty());
    assert_eq!(cell.following(&waypoint, &[0.0; 2], 8), None);
    assert_eq!(cell.continuing(&waypoint, &[0.0; 2], f64::NAN, &[0.1; 8]), None);
    let cell = six(model(UR3));
    assert!(solutions(&cell, &waypoint, &[f64::NAN]).is_empty());
    assert_eq!(cell.following(&waypoint, &[0.0], u32::MAX), None);
}

/// What is said of a model that was changed, and of which field.
fn refused(text: &str, change: impl FnOnce(&mut WorkcellModel)) -> WorkcellError {
    let mut model = model(text);
    change(&mut model);
    AnyWorkcell::new(model).unwrap_err()
}

#[test]
fn numbers_that_cannot_be_are_named_as_in_the_file() {
    type Change = fn(&mut WorkcellModel);
    let cases: [(&str, &str, Change); 26] = [
        (UR3, "nozzle.tip_mm[1]", |m| m.nozzle.tip_mm[1] = f64::NAN),
        (UR3, "nozzle.tip_flat_mm", |m| m.nozzle.tip_flat_mm = -1.0),
        (UR3, "nozzle.tip_flat_mm", |m| m.nozzle.tip_flat_mm = 9.0),
        (UR3, "nozzle.cone_half_angle_deg", |m| m.nozzle.cone_half_angle_deg = 90.0),
        (UR3, "nozzle.cone_half_angle_deg", |m| m.nozzle.cone_half_angle_deg = f64::NAN),
        (UR3, "nozzle.cone_height_mm", |m| m.nozzle.cone_height_mm = 0.0),
        (UR3, "nozzle.block_diameter_mm", |m| m.nozzle.block_diameter_mm = 16.9),
        (UR3, "nozzle.block_top_mm", |m| m.nozzle.block_top_mm = 8.0),
        (UR3, "part.position_mm[2]", |m| m.part.position_mm[2] = f64::INFINITY),
        (UR3, "part.rpy_deg[0]", |m| m.part.rpy_deg[0] = f64::NAN),
        (UR3, "plate.thickness_mm", |m| m.plate.thickness_mm = 0.0),
        (UR3, "plate.diameter_mm", |m| m.plate.diameter_mm = Some(-150.0)),
        (UR3, "arm.limits.max_speed_deg_s[1]", |m| {
            m.arm.limits.max_speed_deg_s = Some([Some(1.0), Some(0.0), None, None, None, None]);
        }),
        (UR3, "arm.limits.max_acceleration_rad_s2[0]", |m| {
            m.arm.limits.max_acceleration_rad_s2 = Some([Some(f64::INFINITY); 6]);
        }),
        (UR3, "arm.limits.max_jerk_rad_s3[5]", |m| m.arm.limits.max_jerk_rad_s3.as_mut().unwrap()[5] = Some(-1.0)),
        (UR3, "arm.limits.min_deg[2]", |m| {
            let limits = &mut m.arm.limits;
            std::mem::swap(&mut limits.min_deg, &mut limits.max_deg);
            limits.min_deg.as_mut().unwrap()[..2].fill(None);
        }),
        (UR3, "arm.limits.max_deg[0]", |m| m.arm.limits.max_deg.as_mut().unwrap()[0] = Some(f64::NAN)),
        (UR10, "arm.geometry.ur.d_mm[3]", |m| {
            *m = with_lengths(UR10);
            if let ArmGeometry::Ur { d_mm, .. } = &mut m.arm.geometry {
                d_mm[3] = f64::NAN;
            }
        }),
        (UR3, "solids[0].shape.block.min_mm[2]", |m| {
            let ShapeModel::Block { min_mm, .. } = &mut m.solids[0].shape else { return };
            min_mm[2] = -500.0;
        }),
        (IRB1200, "solids[1].shape.cylinder.radius_mm", |m| {
            let ShapeModel::Cylinder { radius_mm, .. } = &mut m.solids[1].shape else { return };
            *radius_mm = -60.0;
        }),
        (IRB1200, "solids[1].shape.cylinder.min_z_mm", |m| {
            let ShapeModel::Cylinder { min_z_mm, .. } = &mut m.solids[1].shape else { return };
            *min_z_mm = 5.0;
        }),
        (IRB1200, "solids[0].shape.hull.points_mm[1][2]", |m| {
            m.solids[0].shape = ShapeModel::Hull { points_mm: vec![[0.0; 3], [0.0, 0.0, f64::NAN]] };
        }),
        (IRB1200, "solids[0].shape.capsule.radius_mm", |m| {
            m.solids[0].shape = ShapeModel::Capsule { from_mm: [0.0; 3], to_mm: [1.0; 3], radius_mm: 0.0 };
        }),
        (IRB1200, "positioner.print_tilt_deg[0]", |m| m.positioner.as_mut().unwrap().print_tilt_deg = [60.0, -60.0]),
        (IRB1200, "positioner.print_tilt_deg[1]", |m| m.positioner.as_mut().unwrap().print_tilt_deg[1] = 400.0),
        (IRB1200, "positioner.tool_angle_deg", |m| m.positioner.as_mut().unwrap().tool_angle_deg = f64::NAN),
    ];
    for (text, field, change) in cases {
        let error = refused(text, change);
        let WorkcellError::Number { path, .. } = &error else { panic!("{field}: {error}") };
        assert_eq!(path, field, "{error}");
        assert!(error.to_string().starts_with(&format!("{field} is ")), "{error}");
    }
    use curvlay_kinematics::workcell::StandModel::{Beam, Pedestal};
    let beam = |thickness_mm, pillar_mm| Beam {
        height_mm: 600.0,
        thickness_mm,
        length_mm: 400.0,
        half_width_mm: None,
        pillar_mm,
    };
    for (field, stand) in [
        ("stand.pedestal.height_mm", Pedestal { height_mm: -1.0, radius_mm: None }),
        ("stand.pedestal.radius_mm", Pedestal { height_mm: 1.0, radius_mm: Some(0.0) }),
        ("stand.beam.thickness_mm", beam(700.0, [1.0; 2])),
        ("stand.beam.pillar_mm[1]", beam(40.0, [1.0, f64::NAN])),
    ] {
        let error = refused(UR3, |m| m.stand = Some(stand));
        assert!(matches!(&error, WorkcellError::Number { path, .. } if path == field), "{error}");
    }
}

#[test]
fn cells_that_cannot_be_are_refused() {
    let unknown = refused(UR3, |m| m.arm.geometry = ArmGeometry::Named("UR17".into()));
    let expected = "arm.geometry.named: no robot is called `UR17`; near are UR10, UR16e, UR3, UR3e; examples/cells/arms.json has all \
                    names; any other arm is given by its lengths instead of a name, like {\"ortho_parallel\": {\"a1_mm\": 150, ";
    assert!(unknown.to_string().starts_with(expected), "{unknown}");
    let far = refused(UR3, |m| m.arm.geometry = ArmGeometry::Named("kitchen mixer".into()));
    assert!(far.to_string().contains("`kitchen mixer`; examples/cells/arms.json has all names"), "{far}");
    let unknown = refused(IRB1200, |m| {
        m.positioner.as_mut().unwrap().geometry = PositionerGeometry::Named("A-250".into());
    });
    assert!(matches!(unknown, WorkcellError::UnknownRobot { path, .. } if path == "positioner.geometry.named"));
    assert_eq!(refused(UR3, |m| m.version = 2), WorkcellError::Version { found: 2 });
    assert_eq!(refused(IRB1200, |m| m.held = model(UR3).held), WorkcellError::HeldPartOnTable);
    let still = refused(UR3, |m| m.nozzle.flow = [0.0; 3]);
    assert_eq!(still, WorkcellError::NoDirection { path: "nozzle.flow".into() });
    let name = |index: usize, name: &'static str| {
        let error = refused(IRB1200, |m| m.solids[index].name = name.into());
        matches!(error, WorkcellError::Name { path, name: found, .. }
            if path == format!("solids[{index}].name") && found == name)
    };
    assert!(name(1, "floor") && name(0, "part") && name(2, "forearm") && name(0, "pedestal") && name(0, ""));
    let mount = |text: &str, mount: MountModel| {
        let error = refused(text, |m| m.solids[0].mount = mount);
        matches!(error, WorkcellError::Mount { path, .. } if path == "solids[0].mount")
    };
    assert!(mount(UR3, MountModel::Table) && mount(UR3, MountModel::Tilt));
    assert!(mount(IRB1200, MountModel::Link(0)) && mount(IRB1200, MountModel::Link(7)));
    let no_elbow = refused(UR10, |m| {
        *m = with_lengths(UR10);
        if let ArmGeometry::Ur { upper_arm_mm, .. } = &mut m.arm.geometry {
            *upper_arm_mm = 0.0;
        }
    });
    let source = ArmError::NoLength { link: "upper arm" };
    assert_eq!(no_elbow, WorkcellError::Arm { path: "arm.geometry", source });
    let axes = |turn_axis| PositionerGeometry::Axes {
        tilt_origin_mm: [0.0; 3],
        tilt_axis: [1.0, 0.0, 0.0],
        turn_origin_mm: [0.0; 3],
        turn_axis,
        table_origin_mm: [0.0, 0.0, 100.0],
    };
    let parallel = refused(IRB1200, |m| m.positioner.as_mut().unwrap().geometry = axes([-1.0, 0.0, 0.0]));
    assert!(matches!(parallel, WorkcellError::Positioner { path: "positioner.geometry", .. }));
    let zero = refused(IRB1200, |m| m.positioner.as_mut().unwrap().geometry = axes([0.0; 3]));
    assert_eq!(zero, WorkcellError::NoDirection { path: "positioner.geometry.axes.turn_axis".into() });
    let nothing = refused(UR3, |m| m.solids[0].shape = ShapeModel::Hull { points_mm: vec![] });
    assert!(matches!(nothing, WorkcellError::Scene(_)), "{nothing}");
}

/// Solids are where their mounts are.
#[test]
fn solids_go_with_what_carries_them() {
    let mut model = model(IRB1200);
    model.part.position_mm = [0.0, 5.0, 10.0];
    model.part.rpy_deg = [0.0, 0.0, 90.0];
    let ball = ShapeModel::Capsule { from_mm: [1.0, 2.0, 3.0], to_mm: [1.0, 2.0, 3.0], radius_mm: 1.0 };
    let mounts = [
        (MountModel::Link(2), Mount::Link(2)),
        (MountModel::Flange, Mount::Link(6)),
        (MountModel::Tilt, Mount::Tilt),
        (MountModel::Part, Mount::Table),
        (MountModel::Nozzle, Mount::Link(6)),
    ];
    for (mount, _) in mounts {
        let mut solid = model.solids[1].clone();
        (solid.name, solid.mount, solid.shape) = (format!("{mount:?}"), mount, ball.clone());
        model.solids.push(solid);
    }
    let cell = eight(model);
    let scene = cell.equipment().scene(100.0);
    for (mount, expected) in mounts {
        let body = scene.bodies.iter().find(|body| body.name == format!("{mount:?}")).unwrap();
        assert_eq!(body.mount, expected);
        let at = body.mount_body * Point3::new(1.0, 2.0, 3.0);
        let expected = match mount {
            // Turned a quarter about z, then moved.
            MountModel::Part => Point3::new(-2.0, 6.0, 13.0),
            // The nozzle's z points against the flow, its y likewise.
            MountModel::Nozzle => Point3::new(1.0, -2.0, 147.0),
            _ => Point3::new(1.0, 2.0, 3.0),
        };
        assert!((at - expected).norm() < 1e-12, "{mount:?} {at}");
    }
}

/// Bug: an arm described in metres, or one that stands too far away, was taken, and every waypoint was out of reach.
#[test]
fn an_arm_that_cannot_reach_is_refused() {
    let refused = |model: WorkcellModel| match AnyWorkcell::new(model) {
        Err(error @ WorkcellError::Reach { .. }) => error.to_string(),
        other => panic!("{other:?}"),
    };
    let mut metres = model(UR3);
    let d_mm = [0.1519, 0.0, 0.0, 0.11235, 0.08535, 0.0819];
    metres.arm.geometry = ArmGeometry::Ur {
        d_mm,
        upper_arm_mm: -0.24365,
        forearm_mm: -0.21325,
        offsets_deg: [0.0; 6],
        signs: [1.0; 6],
        j23_factor: 0.0,
    };
    assert!(
        refused(metres).starts_with("arm.geometry: stretched out, the arm reaches 0.9 mm: lengths are in millimetres")
    );
    // 888.4 mm of lengths, and 120 mm to the part.
    let at = |x: f64| {
        let mut far = model(UR3);
        far.nozzle.tip_mm = [x, 0.0, 0.0];
        far
    };
    assert!(AnyWorkcell::new(at(1008.0)).is_ok());
    let reported = refused(at(1009.0));
    assert!(
        reported.starts_with("nozzle.tip_mm: stretched out, the arm reaches 888.4 mm: with the 120.0 mm"),
        "{reported}"
    );
    // Its plate of 300 mm may lie so far away that only its near edge is in reach.
    let away = |x: f64| {
        let mut away = model(UR10);
        away.part.position_mm = [x, 0.0, 0.0];
        away
    };
    let (stretched, refusal) = (1683.4 + 166.8, refused(away(3000.0)));
    assert!(refusal.starts_with("part: stretched out, the arm reaches 1683.4 mm: with the 166.8 mm"), "{refusal}");
    assert!(AnyWorkcell::new(away(stretched + 149.0)).is_ok());
    assert!(refused(away(stretched + 151.0)).starts_with("part: "));
    let mut tiny = model(IRB1200);
    tiny.arm.geometry = irb1200_geometry(1e-3);
    assert!(refused(tiny).contains("were metres meant?"));
}
