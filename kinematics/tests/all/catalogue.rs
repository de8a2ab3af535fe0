//! The catalogue of arms against the joint chains that other people published, and arms whose joints 2 and 3 are coupled.

use crate::common::{apart, arm};
use curvlay_kinematics::nalgebra::{Isometry3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use curvlay_kinematics::robots::{self, CATALOGUE};
use curvlay_kinematics::scene::{Body, Mount, Scene, SceneModel, Shape, Sweep};
use curvlay_kinematics::{Arm, ArmError, ArmModel};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::{FRAC_PI_2, PI};

/// A chain of joints as a URDF has it, in metres: how high the maker's base frame is above `base_link`; of each joint its origin in the link before and its
/// axis; `tool0` on the last link, and its roll, pitch and yaw. All joints of these have no rotation at their origin.
struct Chain {
    name: &'static str,
    base_z: f64,
    joints: [([f64; 3], [f64; 3]); 6],
    tool: ([f64; 3], [f64; 3]),
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];
const BACK_X: [f64; 3] = [-1.0, 0.0, 0.0];
const BACK_Y: [f64; 3] = [0.0, -1.0, 0.0];
const DOWN: [f64; 3] = [0.0, 0.0, -1.0];
const O: [f64; 3] = [0.0; 3];

const ABB_AXES: [[f64; 3]; 6] = [Z, Y, Y, X, Y, X];
const KUKA_AXES: [[f64; 3]; 6] = [DOWN, Y, Y, BACK_X, Y, BACK_X];
const FANUC_AXES: [[f64; 3]; 6] = [Z, Y, BACK_Y, BACK_X, BACK_Y, BACK_X];
const STAUBLI_AXES: [[f64; 3]; 6] = [Z, Y, Y, Z, Y, Z];

const ABB_TOOL: [f64; 3] = [0.0, FRAC_PI_2, 0.0];
const FANUC_TOOL: [f64; 3] = [PI, -FRAC_PI_2, 0.0];

const fn chain(
    name: &'static str,
    base_z: f64,
    origins: [[f64; 3]; 6],
    axes: [[f64; 3]; 6],
    tool: ([f64; 3], [f64; 3]),
) -> Chain {
    let mut joints = [(O, O); 6];
    let mut k = 0;
    while k < 6 {
        joints[k] = (origins[k], axes[k]);
        k += 1;
    }
    Chain { name, base_z, joints, tool }
}

const fn x(x: f64) -> [f64; 3] {
    [x, 0.0, 0.0]
}

const fn z(z: f64) -> [f64; 3] {
    [0.0, 0.0, z]
}

/// Numbers of `joint` and `origin` elements of the macros named in the catalogue (ros-industrial/abb, kuka_experimental, fanuc, motoman,
/// staubli_experimental), as they stand there.
const CHAINS: [Chain; 25] = [
    chain("IRB120", 0.0, [O, z(0.29), z(0.27), z(0.07), x(0.302), x(0.072)], ABB_AXES, (O, ABB_TOOL)),
    chain("IRB1200", 0.0, [z(0.3991), O, z(0.35), z(0.042), x(0.351), x(0.082)], ABB_AXES, (O, ABB_TOOL)),
    chain("IRB1200_5_90", 0.0, [z(0.3991), O, z(0.448), z(0.042), x(0.451), x(0.082)], ABB_AXES, (O, ABB_TOOL)),
    chain("IRB1600_10_145", 0.0, [O, [0.15, 0.0, 0.4865], z(0.7), x(0.3), x(0.3), x(0.065)], ABB_AXES, (O, ABB_TOOL)),
    chain("IRB2400", 0.0, [O, [0.1, 0.0, 0.615], z(0.705), z(0.135), x(0.755), O], ABB_AXES, (x(0.085), ABB_TOOL)),
    chain("IRB2600_12_185", 0.0, [z(0.445), x(0.15), z(0.9), z(0.115), x(0.795), x(0.085)], ABB_AXES, (O, ABB_TOOL)),
    chain("IRB4600_60_205", 0.0, [z(0.495), x(0.175), z(0.9), z(0.175), x(0.96), x(0.135)], ABB_AXES, (O, ABB_TOOL)),
    chain("IRB6700_200_260", 0.0, [z(0.78), x(0.32), z(1.125), z(0.2), x(1.1425), x(0.2)], ABB_AXES, (O, ABB_TOOL)),
    chain("IRB6700_235_265", 0.0, [z(0.78), x(0.32), z(1.135), z(0.2), x(1.1825), x(0.2)], ABB_AXES, (O, ABB_TOOL)),
    chain("KR6_R700", 0.0, [z(0.4), x(0.025), x(0.335), [0.365, 0.0, 0.025], O, x(0.09)], KUKA_AXES, (O, ABB_TOOL)),
    chain("KR6_R900", 0.0, [z(0.4), x(0.025), x(0.455), z(0.025), x(0.42), x(0.09)], KUKA_AXES, (O, ABB_TOOL)),
    chain("KR6_R900_sixx", 0.0, [z(0.4), x(0.025), x(0.455), z(0.035), x(0.42), x(0.08)], KUKA_AXES, (O, ABB_TOOL)),
    chain("KR10_R1100", 0.0, [z(0.4), x(0.025), x(0.56), [0.515, 0.0, 0.025], O, x(0.09)], KUKA_AXES, (O, ABB_TOOL)),
    chain("KR16_R2010", 0.0, [z(0.52), x(0.16), x(0.98), [0.86, 0.0, 0.15], O, O], KUKA_AXES, (x(0.153), ABB_TOOL)),
    chain("KR70_R2100", 0.0, [z(0.575), x(0.175), x(0.89), z(0.05), x(1.035), x(0.185)], KUKA_AXES, (O, ABB_TOOL)),
    chain("LRMate200iD", 0.33, [z(0.33), x(0.05), z(0.33), z(0.035), x(0.335), x(0.08)], FANUC_AXES, (O, FANUC_TOOL)),
    chain("M20iA", 0.525, [z(0.525), x(0.15), z(0.79), z(0.25), x(0.835), x(0.1)], FANUC_AXES, (O, FANUC_TOOL)),
    chain("M710iC_50", 0.565, [z(0.565), x(0.15), z(0.87), z(0.17), x(1.016), x(0.175)], FANUC_AXES, (O, FANUC_TOOL)),
    chain(
        "R2000iC_165F",
        0.67,
        [z(0.67), x(0.312), z(1.075), z(0.225), x(1.28), x(0.215)],
        FANUC_AXES,
        (O, FANUC_TOOL),
    ),
    chain("GP7", 0.33, [z(0.33), x(0.04), z(0.445), [0.44, 0.0, 0.04], O, O], FANUC_AXES, (x(0.08), FANUC_TOOL)),
    chain("GP8", 0.33, [z(0.33), x(0.04), z(0.345), [0.34, 0.0, 0.04], O, O], FANUC_AXES, (x(0.08), FANUC_TOOL)),
    chain("GP12", 0.45, [z(0.45), x(0.155), z(0.614), [0.64, 0.0, 0.2], O, O], FANUC_AXES, (x(0.1), FANUC_TOOL)),
    chain("GP25", 0.505, [z(0.505), x(0.15), z(0.76), z(0.2), x(0.795), O], FANUC_AXES, (x(0.1), FANUC_TOOL)),
    chain("TX2_60", 0.375, [z(0.375), O, [0.0, 0.02, 0.29], O, z(0.31), z(0.07)], STAUBLI_AXES, (O, O)),
    chain("TX2_90", 0.478, [z(0.478), x(0.05), [0.0, 0.05, 0.425], O, z(0.425), z(0.1)], STAUBLI_AXES, (O, O)),
];

fn moved([x, y, z]: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Isometry3::from_parts(Translation3::new(1000.0 * x, 1000.0 * y, 1000.0 * z), rotation)
}

impl Chain {
    /// The flange in the maker's base frame, by multiplying out.
    fn forward(&self, joints: &[f64; 6]) -> Isometry3<f64> {
        let mut pose = Isometry3::translation(0.0, 0.0, -1000.0 * self.base_z);
        for ((origin, axis), angle) in self.joints.iter().zip(joints) {
            let turn = UnitQuaternion::from_axis_angle(&UnitVector3::new_normalize(Vector3::from(*axis)), *angle);
            pose = pose * moved(*origin, O) * turn;
        }
        pose * moved(self.tool.0, self.tool.1)
    }
}

fn assert_same(found: &Isometry3<f64>, expected: &Isometry3<f64>, what: &str) {
    let shift = (found.translation.vector - expected.translation.vector).norm();
    let turn = found.rotation.angle_to(&expected.rotation);
    assert!(shift < 1e-9 && turn < 1e-7, "{what}: {shift} mm, {turn} rad");
}

/// Zero, the joints one by one, and some at random.
fn postures() -> Vec<[f64; 6]> {
    let mut random = Pcg64Mcg::seed_from_u64(47);
    let mut all = vec![[0.0; 6]];
    all.extend((0..6).map(|joint| std::array::from_fn(|k| if k == joint { 0.7 } else { 0.0 })));
    all.extend((0..40).map(|_| std::array::from_fn(|_| random.random_range(-3.1..3.1))));
    all
}

#[test]
fn ortho_parallel_arms_are_the_published_chains() {
    let ortho = CATALOGUE.iter().filter(|arm| !Arm::new(&arm.model).unwrap().is_ur());
    let mut names = [ortho.map(|arm| arm.name).collect::<Vec<_>>(), CHAINS.iter().map(|chain| chain.name).collect()];
    names.iter_mut().for_each(|names| names.sort_unstable());
    assert_eq!(names[0], names[1]);
    for chain in &CHAINS {
        let entry = robots::find(chain.name).unwrap();
        let arm = arm(&entry.model);
        assert!((entry.mount_below_base_mm - 1000.0 * chain.base_z).abs() < 1e-9, "{}", chain.name);
        for joints in postures() {
            // A URDF has the angle between upper arm and forearm.
            let mut links = joints;
            links[2] += entry.model.j23_factor * joints[1];
            assert_same(&arm.forward(&joints), &chain.forward(&links), &format!("{} {joints:?}", chain.name));
        }
    }
}

/// `d1 a2 a3 d4 d5 d6` in metres, as the support article of Universal Robots prints them (UR30: the chain of the ROS description).
const UR_TABLES: [(&str, [f64; 6]); 9] = [
    ("UR3", [0.1519, -0.24365, -0.21325, 0.11235, 0.08535, 0.0819]),
    ("UR3e", [0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921]),
    ("UR5", [0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823]),
    ("UR5e", [0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996]),
    ("UR10", [0.1273, -0.612, -0.5723, 0.163941, 0.1157, 0.0922]),
    ("UR10e", [0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655]),
    ("UR16e", [0.1807, -0.4784, -0.36, 0.17415, 0.11985, 0.11655]),
    ("UR20", [0.2363, -0.862, -0.7287, 0.201, 0.1593, 0.1543]),
    ("UR30", [0.2363, -0.637, -0.5037, 0.201, 0.1593, 0.1543]),
];

#[test]
fn ur_arms_are_the_published_tables_and_the_chain_of_the_ros_description() {
    let names: Vec<_> = UR_TABLES.iter().map(|(name, _)| *name).collect();
    let all = CATALOGUE.iter().filter(|arm| Arm::new(&arm.model).unwrap().is_ur()).map(|arm| arm.name);
    assert_eq!(all.collect::<Vec<_>>(), names);
    for (name, [d1, a2, a3, d4, d5, d6]) in UR_TABLES {
        let arm = arm(&robots::find(name).unwrap().model);
        let half = FRAC_PI_2;
        let table =
            [[d1, 0.0, half], [0.0, a2, 0.0], [0.0, a3, 0.0], [d4, 0.0, half], [d5, 0.0, -half], [d6, 0.0, 0.0]];
        // `default_kinematics.yaml`: xyz and roll, pitch, yaw of each joint, which turns about its z.
        let origins = [
            (z(d1), O),
            (O, [half, 0.0, 0.0]),
            (x(a2), O),
            ([a3, 0.0, d4], O),
            ([0.0, -d5, 0.0], [half, 0.0, 0.0]),
            ([0.0, d6, 0.0], [half, PI, PI]),
        ];
        for joints in postures() {
            let about_z = |angle| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
            let (mut by_table, mut by_chain) = (Isometry3::identity(), Isometry3::identity());
            for k in 0..6 {
                let [d, a, alpha] = table[k];
                by_table = by_table * about_z(joints[k]) * moved([a, 0.0, d], [alpha, 0.0, 0.0]);
                by_chain = by_chain * moved(origins[k].0, origins[k].1) * about_z(joints[k]);
            }
            assert_same(&arm.forward(&joints), &by_table, name);
            assert_same(&arm.forward(&joints), &by_chain, name);
        }
    }
}

#[test]
fn every_arm_comes_back_from_its_poses_within_its_limits() {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    for entry in &CATALOGUE {
        let arm = arm(&entry.model);
        assert!(!entry.source.is_empty() && entry.title.starts_with(|letter: char| letter.is_ascii_uppercase()));
        let (mut found, mut kept) = (0, 0);
        for _ in 0..200 {
            let joints: [f64; 6] = std::array::from_fn(|k| {
                let (lower, upper) = (arm.limits().lower[k].max(-6.2), arm.limits().upper[k].min(6.2));
                random.random_range(lower..upper)
            });
            let pose = arm.forward(&joints);
            let near = |other: &[f64; 6]| apart(other, &joints) < 1e-6;
            found += usize::from(arm.inverse(&pose).unwrap().get(arm.branch(&joints)).is_some_and(near));
            let next = arm.continuing(&pose, &joints.map(|angle| angle + 1e-4)).unwrap();
            assert!(arm.limits().contains(&next), "{}: {next:?}", entry.name);
            kept += usize::from((0..6).all(|k| (next[k] - joints[k]).abs() < 1e-6));
        }
        assert!(found >= 198 && kept >= 190, "{}: {found} {kept}", entry.name);
    }
}

/// Joint 2 of an arm that counts joint 3 from the horizontal carries the hand along without turning it.
#[test]
fn joint_2_of_a_coupled_arm_does_not_turn_the_forearm() {
    for name in ["LRMate200iD", "M20iA", "IRB2400"] {
        let arm = arm(&robots::find(name).unwrap().model);
        assert!(arm.is_coupled());
        let (at, leaning) =
            (arm.forward(&[0.3, 0.0, 0.2, 0.4, 0.5, 0.6]), arm.forward(&[0.3, 0.6, 0.2, 0.4, 0.5, 0.6]));
        assert!(at.rotation.angle_to(&leaning.rotation) < 1e-7, "{name}");
        assert!((at.translation.vector - leaning.translation.vector).norm() > 100.0);
    }
    assert!(["UR3", "IRB1200"].iter().all(|name| !arm(&robots::find(name).unwrap().model).is_coupled()));
    // Fanuc: joint 3 up lifts the forearm. ABB: joint 3 up lowers it.
    let height = |name: &str, j3: f64| arm(&robots::find(name).unwrap().model).forward(&[0.0, 0.0, j3, 0.0, 0.0, 0.0]);
    assert!(height("M20iA", 0.3).translation.z > height("M20iA", 0.0).translation.z + 100.0);
    assert!(height("IRB2400", 0.3).translation.z < height("IRB2400", 0.0).translation.z - 100.0);
}

#[test]
fn a_coupling_that_is_no_whole_turn_is_refused() {
    for value in [0.5, -2.0, f64::NAN, f64::INFINITY] {
        let error = Arm::new(&ArmModel { j23_factor: value, ..robots::IRB120 }).unwrap_err();
        assert!(matches!(error, ArmError::Coupling { .. }), "{error}");
        assert!(error.to_string().contains("it must be -1, 0 or 1"));
    }
}

/// Something that is fixed to the upper arm is met by the forearm although joint 3 stands still: the sweep sees it between free ends.
#[test]
fn sweeps_of_a_coupled_arm_see_the_forearm_turn_against_the_upper_arm() {
    let arm = arm(&robots::find("IRB2400").unwrap().model);
    let ball = |name: &str, link: usize, at: [f64; 3]| Body {
        name: name.into(),
        mount: Mount::Link(link),
        mount_body: Isometry3::translation(at[0], at[1], at[2]),
        shape: Shape::Capsule { from: O.into(), to: O.into(), radius: 20.0 },
    };
    // On the forearm, 500 mm along it; and on the upper arm where that ball is when joint 2 leans by 0.5 rad.
    let on_forearm = [0.0, 0.0, 500.0];
    let [start, middle, end] = [0.0, 0.5, 1.0].map(|lean| [0.0, lean, 0.2, 0.0, 0.0, 0.0]);
    let frames = arm.frames(&middle);
    let meeting = frames[2].inverse() * frames[3] * curvlay_kinematics::nalgebra::Point3::from(on_forearm);
    let bodies = vec![ball("clip", 2, meeting.coords.into()), ball("lamp", 3, on_forearm)];
    let scene = Scene::new(SceneModel { bodies, ..SceneModel::of(arm) }).unwrap();
    assert_eq!(scene.touching(&start.into()).unwrap(), None);
    assert_eq!(scene.touching(&end.into()).unwrap(), None);
    let Sweep::Near { bodies, .. } = scene.sweep(&start.into(), &end.into(), 0.1).unwrap() else {
        panic!("the sweep missed it");
    };
    assert!(bodies.contains(&"clip") && bodies.contains(&"lamp"));
    assert!(!scene.is_free(&start.into(), &end.into(), 0.1).unwrap());
    // Joint 3 that goes along with joint 2 keeps the two links as they are.
    let along = [0.0, 1.0, 1.2, 0.0, 0.0, 0.0];
    assert_eq!(scene.sweep(&start.into(), &along.into(), 0.1).unwrap(), Sweep::Free);
}

#[cfg(feature = "serde")]
mod file {
    use super::*;
    use curvlay_kinematics::workcell::{AnyWorkcell, ArmGeometry, ArmPart, LimitsModel, WorkcellModel};
    use serde::Serialize;

    const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/cells/arms.json");

    fn file() -> String {
        std::fs::read_to_string(PATH).unwrap()
    }

    /// The catalogue in the format of workcell files.
    fn text() -> String {
        let entry = |entry: &robots::CatalogueArm| {
            let arm = ArmPart {
                mount_below_base_mm: (entry.mount_below_base_mm > 0.0).then_some(entry.mount_below_base_mm),
                ..ArmPart::of_model(&entry.model)
            };
            let name =
                [("name", json(entry.name)), ("other_names", json(entry.aliases)), ("maker", json(entry.maker.name()))];
            let name = name.map(|(field, value)| format!("\"{field}\": {value}")).join(", ");
            let note = entry.note.map(|note| ("note", json(note)));
            let fields = [("model", json(entry.title))].into_iter().chain(note);
            let fields = fields.chain([("source", json(entry.source)), ("arm", json(&arm))]);
            let fields: Vec<_> = fields.map(|(field, value)| format!("      \"{field}\": {value}")).collect();
            format!("    {{\n      {name},\n{}\n    }}", fields.join(",\n"))
        };
        let about = "The arms that workcell files name, like {\"geometry\": {\"named\": \"UR10e\"}}: robots::CATALOGUE of curvlay-kinematics. `arm` of an \
                     entry can be copied into a workcell file.";
        let all: Vec<_> = CATALOGUE.iter().map(entry).collect();
        format!("{{\n  \"about\": {},\n  \"arms\": [\n{}\n  ]\n}}\n", json(about), all.join(",\n"))
    }

    fn json<T: Serialize + ?Sized>(value: &T) -> String {
        serde_json::to_string(value).unwrap()
    }

    /// A catalogue that differs is written beside the test, so that it can be looked at and copied.
    #[test]
    fn the_file_is_the_catalogue() {
        let expected = text();
        if file() != expected {
            let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("arms.json");
            std::fs::write(&path, expected).unwrap();
            panic!("examples/cells/arms.json is not the catalogue; {} is", path.display());
        }
    }

    /// The lengths of the file make the arm that the name makes.
    #[test]
    fn arms_of_the_file_are_those_of_the_names() {
        let file: serde_json::Value = serde_json::from_str(&file()).unwrap();
        let entries = file["arms"].as_array().unwrap();
        assert_eq!(entries.len(), CATALOGUE.len());
        for entry in entries {
            let known = robots::find(entry["name"].as_str().unwrap()).unwrap();
            let mut model = WorkcellModel::around(known);
            model.arm.limits = LimitsModel::default();
            let named = AnyWorkcell::new(model.clone()).unwrap();
            model.arm = serde_json::from_value(entry["arm"].clone()).unwrap();
            assert!(!matches!(model.arm.geometry, ArmGeometry::Named(_)));
            let given = AnyWorkcell::new(model).unwrap();
            let (named, given) = (named.equipment(), given.equipment());
            assert_eq!(named.arm_model().limits, given.arm_model().limits, "{}", known.name);
            for joints in postures() {
                assert_same(&given.arm().forward(&joints), &named.arm().forward(&joints), known.name);
            }
        }
    }

    /// Every name makes a workcell in which the arm stands free, the nozzle upright over the middle of the plate and tilted as well.
    #[test]
    fn a_workcell_around_any_arm_reaches_its_plate() {
        use curvlay_kinematics::Waypoint;
        use curvlay_kinematics::nalgebra::Point3;
        use curvlay_kinematics::workcell::Workcell;
        let mut lost = Vec::new();
        for entry in &CATALOGUE {
            let AnyWorkcell::Six(cell) = AnyWorkcell::new(WorkcellModel::around(entry)).unwrap() else { panic!() };
            let bodies = cell.equipment().link_bodies().unwrap();
            assert!(!bodies.model.is_empty() && cell.equipment().scene(100.0).links.len() == 7);
            let scene = Scene::new(cell.equipment().scene(100.0)).unwrap();
            let radius = cell.equipment().plate_diameter_mm(100.0) / 2.0;
            let upright = [(0.0, 0.0), (radius, 0.0), (-radius, 0.0), (0.0, radius)];
            let leaning = [0.0, 1.0, 2.0, 3.0].map(|quarter: f64| {
                let (sin, cos) = (quarter * FRAC_PI_2).sin_cos();
                Vector3::new(0.5 * cos, 0.5 * sin, 0.9)
            });
            let upright = upright.map(|(x, y)| (x, y, vec![Vector3::z()]));
            for (x, y, axes) in upright.into_iter().chain([(0.0, 0.0, leaning.to_vec())]) {
                let mut free = 0;
                for (axis, turn) in axes.iter().flat_map(|axis| (0..12).map(move |turn| (axis, turn))) {
                    let position = Point3::new(x, y, 30.0);
                    let waypoint = Waypoint { position, axis: UnitVector3::new_normalize(*axis) };
                    cell.solutions(&waypoint, &[f64::from(turn) * 0.5], &mut |_, joints| {
                        let inside = cell.limits().nearest_image(&joints, &[0.0; 6]);
                        let is_free = |q| scene.touching(&cell.scene_posture(&q)).unwrap().is_none();
                        free += usize::from(inside.is_some_and(is_free));
                    });
                }
                if free == 0 {
                    lost.push(format!("{} at {x} {y}, {axes:?}", entry.name));
                }
            }
        }
        assert!(lost.is_empty(), "{lost:#?}");
    }
}
