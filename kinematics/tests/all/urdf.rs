//! Arms from URDF files: random arms of both families written with random frames come back with the same forward kinematics; what is no arm is refused in a
//! line that names it.

use crate::common::arm;
use curvlay_kinematics::nalgebra::{Isometry3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use curvlay_kinematics::urdf::{LinkNames, Misfit, UrdfArm, UrdfError};
use curvlay_kinematics::workcell::{ArmGeometry, ArmPart, UrdfModel, WorkcellModel};
use curvlay_kinematics::{ArmModel, DhTable, Geometry, JointLimits, OrthoLengths, robots};
use proptest::prelude::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write;

/// A joint of a test file.
#[derive(Clone, Debug)]
struct Joint {
    name: String,
    kind: &'static str,
    parent: String,
    child: String,
    origin: Isometry3<f64>,
    axis: Vector3<f64>,
    more: String,
}

fn text_of(joints: &[Joint]) -> String {
    let mut links: Vec<&str> = joints.iter().flat_map(|joint| [&joint.parent[..], &joint.child[..]]).collect();
    links.sort_unstable();
    links.dedup();
    let mut text = "<?xml version=\"1.0\"?>\n<robot name=\"test\">\n".to_owned();
    links.iter().for_each(|link| writeln!(text, "  <link name=\"{link}\"/>").unwrap());
    for Joint { name, kind, parent, child, origin, axis, more } in joints {
        let [x, y, z] = (origin.translation.vector / 1000.0).into();
        let (roll, pitch, yaw): (f64, f64, f64) = origin.rotation.euler_angles();
        writeln!(
            text,
            "  <joint name=\"{name}\" type=\"{kind}\">\n    <parent link=\"{parent}\"/><child link=\"{child}\"/>"
        )
        .unwrap();
        writeln!(text, "    <origin xyz=\"{x:.17} {y:.17} {z:.17}\" rpy=\"{roll:.17} {pitch:.17} {yaw:.17}\"/>")
            .unwrap();
        writeln!(text, "    <axis xyz=\"{:.17} {:.17} {:.17}\"/>{more}\n  </joint>", axis.x, axis.y, axis.z).unwrap();
    }
    text + "</robot>\n"
}

fn random_turn(random: &mut impl Rng) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(Vector3::from([0; 3].map(|_| random.random_range(-2.0..2.0))))
}

fn random_frame(random: &mut impl Rng) -> Isometry3<f64> {
    let shift = [0; 3].map(|_| random.random_range(-400.0..400.0));
    Isometry3::from_parts(Translation3::from(shift), random_turn(random))
}

/// A model as a URDF: link frames anywhere on their axes and turned as chance has it, a fixed joint here and there, a base and a flange that are not those of
/// the model. Axes come from the definition of the family, by hand, not from the arm that is tested.
fn exported(model: &ArmModel, base_arm: &Isometry3<f64>, flange_tip: &Isometry3<f64>, random: &mut impl Rng) -> String {
    let turn =
        |axis: Vector3<f64>, angle: f64| UnitQuaternion::from_axis_angle(&UnitVector3::new_normalize(axis), angle);
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let at = |shift: [f64; 3]| Isometry3::translation(shift[0], shift[1], shift[2]);
    // Before each joint a step, then its axis, at zero of the geometry's joints; and a step behind the last one.
    let (steps, axes, last): ([Isometry3<f64>; 6], [Vector3<f64>; 6], Isometry3<f64>) = match &model.geometry {
        Geometry::Ortho(l) => (
            [
                at([0.0; 3]),
                at([l.a1, l.b, l.c1]),
                at([0.0, 0.0, l.c2]),
                at([l.a2, 0.0, l.c3]),
                at([0.0; 3]),
                at([0.0; 3]),
            ],
            [z, y, y, z, y, z],
            at([0.0, 0.0, l.c4]),
        ),
        Geometry::Ur(t) => {
            let step = |k: usize| at([t.a[k], 0.0, t.d[k]]) * turn(x, t.alpha[k]);
            ([at([0.0; 3]), step(0), step(1), step(2), step(3), step(4)], [z; 6], step(5))
        }
        _ => panic!("another family"),
    };
    // The frame of link k in the file, on the frame that the family has behind joint k.
    let own: Vec<Isometry3<f64>> = (0..6)
        .map(|k| {
            let along = axes[k] * random.random_range(-300.0..300.0);
            Isometry3::from_parts(Translation3::from(along), random_turn(random))
        })
        .collect();
    let mut joints = Vec::new();
    let mut parent = "base_link".to_owned();
    for k in 0..6 {
        let before = if k == 0 { *base_arm } else { own[k - 1].inverse() };
        // With the joint of the file at 0 that of the geometry is at minus its offset.
        let zero = before * steps[k] * turn(axes[k], -model.offsets[k]) * own[k];
        let mut origin = zero;
        if random.random_bool(0.4) {
            let bracket = random_frame(random);
            let child = format!("bracket_{k}");
            joints.push(Joint {
                name: format!("screws_{k}"),
                kind: "fixed",
                parent: parent.clone(),
                child: child.clone(),
                origin: bracket,
                axis: Vector3::zeros(),
                more: String::new(),
            });
            (parent, origin) = (child, bracket.inverse() * zero);
        }
        let axis = own[k].rotation.inverse() * axes[k] * model.signs[k] * random.random_range(0.5..2.0);
        let child = format!("link_{}", k + 1);
        let more = format!(
            "<limit lower=\"{}\" upper=\"{}\" velocity=\"{}\" effort=\"0\"/>",
            -1.0 - k as f64,
            2.0 + k as f64,
            3.0 + k as f64
        );
        joints.push(Joint {
            name: format!("joint_{}", k + 1),
            kind: "revolute",
            parent,
            child: child.clone(),
            origin,
            axis,
            more,
        });
        parent = child;
    }
    let origin = own[5].inverse() * last * flange_tip;
    let fixed = |name: &str, parent: &str, child: &str, origin| Joint {
        name: name.into(),
        kind: "fixed",
        parent: parent.into(),
        child: child.into(),
        origin,
        axis: x,
        more: String::new(),
    };
    joints.push(fixed("flange_joint", &parent, "tool0", origin));
    joints.push(fixed("lamp_joint", "link_3", "lamp", random_frame(random)));
    joints.swap(0, 3);
    text_of(&joints)
}

fn link(random: &mut impl Rng) -> f64 {
    let length: f64 = random.random_range(60.0..900.0);
    if random.random_bool(0.5) { length } else { -length }
}

fn offset(random: &mut impl Rng) -> f64 {
    if random.random_bool(0.4) { 0.0 } else { random.random_range(-200.0..200.0) }
}

fn random_model(random: &mut impl Rng) -> ArmModel {
    let geometry = if random.random_bool(0.5) {
        let d = [0; 6].map(|_| offset(random));
        Geometry::Ur(DhTable::ur(d, link(random), link(random)))
    } else {
        let [a1, a2, b, c1, c4] = [0; 5].map(|_| offset(random));
        Geometry::Ortho(OrthoLengths { a1, a2, b, c1, c2: link(random), c3: link(random), c4 })
    };
    let quarter = |random: &mut dyn Rng| f64::from(random.random_range(-2..3)) * FRAC_PI_2;
    ArmModel {
        geometry,
        offsets: [0; 6].map(|_| if random.random_bool(0.5) { quarter(random) } else { random.random_range(-3.0..3.0) }),
        signs: [0; 6].map(|_| if random.random_bool(0.5) { 1.0 } else { -1.0 }),
        j23_factor: 0.0,
        limits: JointLimits::NONE,
    }
}

/// The flange of the file at these joints, by the model that it was written from, and by what was read.
fn both(model: &ArmModel, frames: &[Isometry3<f64>; 2], found: &UrdfArm, joints: &[f64; 6]) -> [Isometry3<f64>; 2] {
    let written = frames[0] * arm(model).forward(joints) * frames[1];
    [written, found.base_arm * arm(&found.model).forward(joints) * found.flange_tip]
}

fn assert_same_arm(model: &ArmModel, frames: &[Isometry3<f64>; 2], found: &UrdfArm, random: &mut impl Rng) {
    for _ in 0..20 {
        let joints: [f64; 6] = [0; 6].map(|_| random.random_range(-PI..PI));
        let [written, read] = both(model, frames, found, &joints);
        let shift = (written.translation.vector - read.translation.vector).norm();
        let turn = written.rotation.angle_to(&read.rotation);
        assert!(shift < 1e-6 && turn < 1e-7, "{model:?}\n{found:?}\n{joints:?}: {shift} mm, {turn} rad");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn arms_written_with_any_frames_come_back(seed in any::<u64>()) {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let model = random_model(&mut random);
        let any = random.random_bool(0.7);
        let frames = [0; 2].map(|_| if any { random_frame(&mut random) } else { Isometry3::identity() });
        let text = exported(&model, &frames[0], &frames[1], &mut random);
        let found = UrdfArm::read(&text, &LinkNames::default()).unwrap_or_else(|error| panic!("{error}\n{model:?}\n{text}"));
        prop_assert!(found.error_mm < 1e-6);
        assert_same_arm(&model, &frames, &found, &mut random);
        prop_assert_eq!(found.model.limits.lower.map(f64::to_bits), [-1f64, -2.0, -3.0, -4.0, -5.0, -6.0].map(f64::to_bits));
        prop_assert_eq!(found.model.limits.velocity.map(f64::to_bits), [3f64, 4.0, 5.0, 6.0, 7.0, 8.0].map(f64::to_bits));
        prop_assert_eq!((&found.joints[0][..], &found.flange[..]), ("joint_1", "tool0"));
        // Base and flange of the model are those of the file where these are on axes 1 and 6.
        prop_assert!(any || found.base_arm == Isometry3::identity() && found.flange_tip == Isometry3::identity());
        // The solutions that it finds are those of the arm.
        let joints: [f64; 6] = [0; 6].map(|_| random.random_range(-3.0..3.0));
        let pose = arm(&model).forward(&joints);
        let own = arm(&found.model);
        let goal = found.base_arm.inverse() * frames[0] * pose * frames[1] * found.flange_tip.inverse();
        prop_assert!(own.inverse(&goal).unwrap().iter().any(|(_, q)| crate::common::apart(q, &joints) < 1e-5));
    }

    /// Nothing that is done to a text makes the reader panic, and errors are one line.
    #[test]
    fn damaged_files_are_refused_or_read(seed in any::<u64>()) {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let model = random_model(&mut random);
        let mut text = exported(&model, &Isometry3::identity(), &Isometry3::identity(), &mut random).into_bytes();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..text.len());
            match random.random_range(0..4) {
                0 => text.truncate(at),
                1 => text[at] = random.random_range(32..127),
                2 => { text.remove(at); }
                _ => text.insert(at, random.random_range(32..127)),
            }
            if text.is_empty() {
                break;
            }
        }
        if let Err(error) = UrdfArm::read(&String::from_utf8_lossy(&text), &LinkNames::default()) {
            let line = error.to_string();
            prop_assert!(!line.is_empty() && !line.contains('\n') && line.len() < 400, "{}", line);
        }
    }
}

/// Bug: the error quoted the end of a line, and was two lines.
#[test]
fn a_tag_that_ends_its_line_has_an_error_of_one_line() {
    let error = UrdfArm::read("<robot name=\"a\">\n</robot\n<", &LinkNames::default()).unwrap_err().to_string();
    assert_eq!(error.lines().count(), 1, "{error}");
    let error = UrdfArm::read("<robot name=\"a\"/\n>", &LinkNames::default()).unwrap_err().to_string();
    assert_eq!(error, "line 1, column 17: not XML: expected '>' not '\\n'");
}

/// A sound file of an IRB 1200, as joints.
fn irb1200() -> Vec<Joint> {
    let origins =
        [[0.0, 0.0, 399.1], [0.0; 3], [0.0, 0.0, 350.0], [0.0, 0.0, 42.0], [351.0, 0.0, 0.0], [82.0, 0.0, 0.0]];
    let axes = [Vector3::z(), Vector3::y(), Vector3::y(), Vector3::x(), Vector3::y(), Vector3::x()];
    let name = |k: usize| if k == 0 { "base_link".to_owned() } else { format!("link_{k}") };
    let mut joints: Vec<Joint> = (0..6)
        .map(|k| Joint {
            name: format!("joint_{}", k + 1),
            kind: "revolute",
            parent: name(k),
            child: name(k + 1),
            origin: Isometry3::translation(origins[k][0], origins[k][1], origins[k][2]),
            axis: axes[k],
            more: "<limit lower=\"-2\" upper=\"2\" velocity=\"3\" effort=\"0\"/>".into(),
        })
        .collect();
    joints.push(Joint {
        name: "joint_6-tool0".into(),
        kind: "fixed",
        parent: "link_6".into(),
        child: "tool0".into(),
        origin: Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_euler_angles(0.0, FRAC_PI_2, 0.0)),
        axis: Vector3::x(),
        more: String::new(),
    });
    joints
}

fn read(joints: &[Joint]) -> Result<UrdfArm, UrdfError> {
    UrdfArm::read(&text_of(joints), &LinkNames::default())
}

fn refused(change: impl FnOnce(&mut Vec<Joint>)) -> UrdfError {
    let mut joints = irb1200();
    change(&mut joints);
    read(&joints).unwrap_err()
}

#[test]
fn the_published_chain_gives_the_published_lengths() {
    let found = read(&irb1200()).unwrap();
    let (Geometry::Ortho(found_lengths), Geometry::Ortho(lengths)) = (found.model.geometry, robots::IRB1200.geometry)
    else {
        panic!("another family")
    };
    let numbers = |l: OrthoLengths| [l.a1, l.a2, l.b, l.c1, l.c2, l.c3, l.c4];
    for (a, b) in numbers(found_lengths).iter().zip(numbers(lengths)) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
    assert!(found.model.signs.iter().all(|sign| *sign > 0.0));
    assert!(
        found.model.offsets.iter().zip(robots::IRB1200.offsets).all(|(a, b)| (a - b).abs() < 1e-12),
        "{:?}",
        found.model.offsets
    );
    assert_eq!((found.base.as_str(), found.name.as_str()), ("base_link", "test"));
}

#[test]
fn an_axis_that_does_not_fit_is_named_with_what_it_is_off() {
    let misfit = |error: UrdfError| match error {
        UrdfError::NeitherFamily { joint, misfit, family } => (joint, misfit, family),
        other => panic!("{other}"),
    };
    let (joint, found, family) = misfit(refused(|joints| joints[4].origin.translation.vector.z += 0.5));
    assert_eq!((joint.as_str(), found.axis, found.against), ("joint_5", 4, 3));
    assert!(
        matches!(found.misfit, Misfit::Apart(mm) if (mm - 0.5).abs() < 1e-9) && family.starts_with("an ortho-parallel")
    );
    let (joint, found, _) = misfit(refused(|joints| joints[2].axis = Vector3::new(0.01, 1.0, 0.0)));
    assert!(joint == "joint_3" && matches!(found.misfit, Misfit::NotParallel(angle) if (angle - 0.01).abs() < 1e-5));
    let (joint, found, _) = misfit(refused(|joints| joints[1].axis = Vector3::new(0.0, 1.0, 0.02)));
    assert!(joint == "joint_2" && matches!(found.misfit, Misfit::NotSquare(angle) if (angle - 0.02).abs() < 1e-5));
    let (joint, found, _) = misfit(refused(|joints| joints[2].origin.translation.vector.z = 0.0));
    assert!(joint == "joint_3" && found.misfit == Misfit::Same);
    let (joint, ..) = misfit(refused(|joints| joints[5].origin.translation.vector.z += 3.0));
    assert_eq!(joint, "joint_6");
    // Rounded as URDFs are: read, and the error is told.
    let mut rounded = irb1200();
    rounded[6].origin.rotation = UnitQuaternion::from_euler_angles(0.0, FRAC_PI_2 - 6e-6, 0.0);
    let found = read(&rounded).unwrap();
    assert!(found.flange_tip == Isometry3::identity() && found.error_mm < 0.02);
    // A UR arm whose wrist was moved.
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let still = Isometry3::identity();
    let text = exported(&robots::UR5, &still, &still, &mut random);
    assert!(UrdfArm::read(&text, &LinkNames::default()).is_ok());
    let bent = ArmModel {
        geometry: Geometry::Ur(DhTable {
            alpha: [FRAC_PI_2, 0.0, 0.01, FRAC_PI_2, -FRAC_PI_2, 0.0],
            ..DhTable::ur([89.0, 0.0, 0.0, 109.0, 95.0, 82.0], -425.0, -392.0)
        }),
        ..robots::UR5
    };
    let (joint, found, family) =
        misfit(UrdfArm::read(&exported(&bent, &still, &still, &mut random), &LinkNames::default()).unwrap_err());
    assert!(
        joint == "joint_4" && matches!(found.misfit, Misfit::NotParallel(angle) if (angle - 0.01).abs() < 1e-4),
        "{found}"
    );
    assert_eq!(family, "an arm of the UR type");
}

#[test]
fn what_is_no_arm_is_refused_in_a_line() {
    let cases: [(UrdfError, &str); 13] = [
        (refused(Vec::clear), "no joint is in the file"),
        (refused(|joints| joints[2].kind = "prismatic"), "joint `joint_3` is prismatic"),
        (refused(|joints| joints[2].kind = "floating"), "joint `joint_3` is floating"),
        (refused(|joints| joints[3].more += "<mimic joint=\"joint_2\"/>"), "joint `joint_4` mimics joint `joint_2`"),
        (refused(|joints| joints[3].kind = "fixed"), "from `base_link` to `link_6` 5 joints turn: an arm has six"),
        (refused(|joints| joints[1].more.clear()), "joint `joint_2` has no limit"),
        (refused(|joints| joints[1].axis = Vector3::zeros()), "joint `joint_2` has the axis 0 0 0"),
        (refused(|joints| joints[1].axis.x = f64::NAN), "joint `joint_2`: `NaN` in `xyz` must be a number"),
        (
            refused(|joints| joints[1].more = "<limit lower=\"1\" upper=\"-1\"/>".into()),
            "has no angle between its limits, 1 and -1",
        ),
        (refused(|joints| joints[2].name = "joint_1".into()), "joint `joint_1` is there twice"),
        (
            refused(|joints| {
                joints.push(Joint {
                    name: "rod".into(),
                    parent: "link_1".into(),
                    child: "link_4".into(),
                    ..irb1200().remove(0)
                })
            }),
            "link `link_4` is the child of joints `joint_4` and `rod`: a closed chain",
        ),
        (refused(|joints| joints[0].parent = "link_6".into()), "link `link_1` hangs on itself"),
        (
            refused(|joints| {
                joints.push(Joint {
                    name: "axle".into(),
                    parent: "cart".into(),
                    child: "wheel".into(),
                    ..irb1200().remove(0)
                })
            }),
            "links `base_link` and `cart` are both the child of no joint",
        ),
    ];
    for (error, expected) in cases {
        let line = error.to_string();
        assert!(line.contains(expected) && !line.contains('\n'), "{line}\n{expected}");
    }
    let text = |text: &str| UrdfArm::read(text, &LinkNames::default()).unwrap_err().to_string();
    assert_eq!(
        text("<robot name=\"arm\"><link name=\"base_link\"/></robot>"),
        "no joint is in the file: an arm has six that turn"
    );
    assert_eq!(text("<sdf/>"), "the outermost element is <sdf>, a URDF has <robot>");
    assert!(text("<robot>").starts_with("line 1, column "), "{}", text("<robot>"));
    let xacro = "<robot xmlns:xacro=\"http://ros.org/wiki/xacro\">\n<xacro:macro name=\"m\"/></robot>";
    assert!(text(xacro).starts_with("line 2: this is a xacro file"));
    let names = LinkNames { flange: Some("tip".into()), base: None };
    assert_eq!(UrdfArm::read(&text_of(&irb1200()), &names).unwrap_err().to_string(), "no link is called `tip`");
    let names = LinkNames { flange: None, base: Some("link_1".into()) };
    assert!(UrdfArm::read(&text_of(&irb1200()), &names).unwrap_err().to_string().contains("joint `joint_1` moves it"));
}

#[test]
fn links_are_found_by_their_usual_names() {
    // A gripper with a finger behind the flange, a spring that mimics, and `base` beside the root.
    let mut joints = irb1200();
    let like = |name: &str, kind, parent: &str, child: &str| Joint {
        name: name.into(),
        kind,
        parent: parent.into(),
        child: child.into(),
        ..irb1200().remove(0)
    };
    joints.push(like("finger", "prismatic", "tool0", "finger_1"));
    joints
        .push(Joint { more: "<mimic joint=\"joint_2\"/>".into(), ..like("spring", "continuous", "link_1", "piston") });
    joints
        .push(Joint { origin: Isometry3::translation(0.0, 0.0, 399.1), ..like("world", "fixed", "base_link", "base") });
    let found = read(&joints).unwrap();
    assert_eq!((found.base.as_str(), found.flange.as_str()), ("base", "tool0"));
    let Geometry::Ortho(lengths) = found.model.geometry else { panic!("another family") };
    assert!(lengths.c1.abs() < 1e-9);
    // Without `tool0` and `flange` the last of six.
    let mut bare = irb1200();
    bare.pop();
    let found = read(&bare).unwrap();
    assert_eq!(found.flange, "link_6");
    assert!((found.flange_tip.rotation.angle() - FRAC_PI_2).abs() < 1e-9);
    // Two arms on a stand.
    let mut twins = irb1200();
    let twin = |joint: &Joint| {
        let other = |name: &str| if name == "base_link" { name.to_owned() } else { format!("other_{name}") };
        Joint { name: other(&joint.name), parent: other(&joint.parent), child: other(&joint.child), ..joint.clone() }
    };
    twins.pop();
    twins.extend(twins.clone().iter().map(twin));
    assert!(matches!(read(&twins).unwrap_err(), UrdfError::SeveralArms { .. }));
}

/// A workcell file that names a URDF becomes one with the lengths; limits of the file hold where the cell has none.
#[test]
fn a_workcell_takes_its_arm_from_a_urdf() {
    let mut model = WorkcellModel::around(robots::find("IRB1200").unwrap());
    model.arm.geometry = ArmGeometry::Urdf(UrdfModel::File("arm.urdf".into()));
    model.arm.limits.max_deg = Some([Some(90.0); 6]);
    let unread = curvlay_kinematics::workcell::AnyWorkcell::new(model.clone()).unwrap_err();
    assert!(unread.to_string().starts_with("arm.geometry.urdf: arm.urdf: the file was not read"));
    let text = text_of(&irb1200());
    let read = model
        .clone()
        .with_urdf(&mut |file| if file == "arm.urdf" { Ok(text.clone()) } else { Err("no such file".into()) })
        .unwrap();
    assert_eq!(read.arm.limits.max_deg, Some([Some(90.0); 6]));
    assert!((read.arm.limits.min_deg.unwrap()[0].unwrap() + 2f64.to_degrees()).abs() < 1e-8);
    let ArmGeometry::OrthoParallel { a2_mm, .. } = read.arm.geometry else { panic!("no lengths") };
    assert!((a2_mm + 42.0).abs() < 1e-9);
    let refused = model.clone().with_urdf(&mut |_| Err("no such file".into())).unwrap_err();
    assert_eq!(refused.to_string(), "arm.geometry.urdf: arm.urdf: no such file");
    // A flange that is not on axis 6.
    let mut bare = irb1200();
    bare.pop();
    let text = text_of(&bare);
    let refused = model.clone().with_urdf(&mut |_| Ok(text.clone())).unwrap_err().to_string();
    assert!(
        refused.contains("axis 6 (joint `joint_6`) is 0.00 mm and 90.000 degrees off the z axis of link `link_6`"),
        "{refused}"
    );
    model.arm.geometry =
        ArmGeometry::Urdf(UrdfModel::Links { file: "arm.urdf".into(), base: Some("nowhere".into()), flange: None });
    let refused = model.with_urdf(&mut |_| Ok(text.clone())).unwrap_err().to_string();
    assert_eq!(refused, "arm.geometry.urdf: arm.urdf: no link is called `nowhere`");
}

#[cfg(feature = "serde")]
#[test]
fn a_file_names_a_urdf_with_or_without_links() {
    let geometry = |text: &str| serde_json::from_str::<ArmGeometry>(text);
    assert_eq!(geometry(r#"{"urdf": "a.urdf"}"#).unwrap(), ArmGeometry::Urdf(UrdfModel::File("a.urdf".into())));
    let links = geometry(r#"{"urdf": {"file": "a.urdf", "flange": "tcp"}}"#).unwrap();
    let expected = UrdfModel::Links { file: "a.urdf".into(), base: None, flange: Some("tcp".into()) };
    assert_eq!(links, ArmGeometry::Urdf(expected));
    let arm = ArmPart::of_model(&robots::UR5);
    assert_eq!(serde_json::from_str::<ArmPart>(&serde_json::to_string(&arm).unwrap()).unwrap(), arm);
}
