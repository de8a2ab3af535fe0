//! Workcells: files of the examples spoilt, what stands around arms, scenes that grow.

use super::numbers::{bad, each_spoilt, index, joints, number, point, pose, unit, waypoint};
use crate::common::ROBOTS;
use crate::common::cells::{over_table, ur3, ur10};
use curvlay_kinematics::nalgebra::{Isometry3, Point3, UnitVector3};
use curvlay_kinematics::print_program::{BlendOptions, StreamOptions};
use curvlay_kinematics::program::{KrlOptions, RapidOptions, TpOptions, UrScriptOptions};
use curvlay_kinematics::urdf::{LinkNames, UrdfArm};
use curvlay_kinematics::workcell::*;
use curvlay_kinematics::{Waypoint, robots};
use proptest::prelude::*;

const FILES: [&str; 4] = [
    include_str!("../../../../examples/cells/irb120-track.json"),
    include_str!("../../../../examples/cells/irb1200-table.json"),
    include_str!("../../../../examples/cells/ur10.json"),
    include_str!("../../../../examples/cells/ur3.json"),
];
const MODEL: [fn(&mut WorkcellModel, f64); 22] = [
    |model, value| model.part.position_mm[0] = value,
    |model, value| model.part.rpy_deg[1] = value,
    |model, value| model.nozzle.tip_mm[2] = value,
    |model, value| model.nozzle.flow[0] = value,
    |model, value| model.nozzle.tip_flat_mm = value,
    |model, value| model.nozzle.cone_half_angle_deg = value,
    |model, value| model.nozzle.cone_height_mm = value,
    |model, value| model.nozzle.block_diameter_mm = value,
    |model, value| model.nozzle.block_top_mm = value,
    |model, value| model.roller = Some(RollerModel { diameter_mm: value, ..RollerModel::default() }),
    |model, value| model.plate.thickness_mm = value,
    |model, value| model.plate.diameter_mm = Some(value),
    |model, value| model.plate.size_mm = Some([value, 100.0]),
    |model, value| model.home_deg = Some(vec![value; 6]),
    |model, value| model.controller.extruder_lag_s = value,
    |model, value| model.controller.servoj_gain = Some(value),
    |model, value| model.arm.allowance_mm = value,
    |model, value| model.arm.mount_below_base_mm = Some(value),
    |model, value| model.arm.limits.min_deg = Some([Some(value); 6]),
    |model, value| model.arm.limits.max_speed_deg_s = Some([Some(value); 6]),
    |model, value| model.stand = Some(StandModel::Pedestal { height_mm: value, radius_mm: None }),
    |model, value| {
        model.stand = Some(StandModel::Beam {
            height_mm: 500.0,
            thickness_mm: value,
            length_mm: 900.0,
            half_width_mm: Some(value),
            pillar_mm: [value, 90.0],
        })
    },
];
const GROWING: [fn(&mut GrowingOptions, f64); 5] = [
    |options, value| options.margin_mm = value,
    |options, value| options.clearances_mm = [value, 2.0, 0.5],
    |options, value| options.resolution_mm = value,
    |options, value| options.fine_resolution_mm = value,
    |options, value| options.near_mm = value,
];

fn solid() -> impl Strategy<Value = SolidModel> {
    let number = || prop_oneof![4 => 1.0..90.0f64, 1 => number()];
    let three = move || [number(), number(), number()];
    let shape = prop_oneof![
        (three(), three()).prop_map(|(min_mm, max_mm)| ShapeModel::Block { min_mm, max_mm }),
        three().prop_map(|[radius_mm, min_z_mm, max_z_mm]| ShapeModel::Cylinder { radius_mm, min_z_mm, max_z_mm }),
        (three(), three(), number()).prop_map(|(from_mm, to_mm, radius_mm)| ShapeModel::Capsule {
            from_mm,
            to_mm,
            radius_mm
        }),
        prop::collection::vec(three(), 0..6).prop_map(|points_mm| ShapeModel::Hull { points_mm }),
    ];
    let mounts = vec![
        MountModel::Base,
        MountModel::Carriage,
        MountModel::Rail,
        MountModel::Link(0),
        MountModel::Link(usize::MAX),
        MountModel::Flange,
        MountModel::Tilt,
        MountModel::Table,
        MountModel::Part,
        MountModel::Nozzle,
    ];
    ("[a-z]{0,3}", prop::sample::select(mounts), three(), shape).prop_map(|(name, mount, position_mm, shape)| {
        SolidModel { name, mount, frame: FrameModel { position_mm, rpy_deg: [0.0; 3] }, shape }
    })
}

/// An arm of six joints, in metres.
fn urdf() -> String {
    let joint = |n: usize, xyz: &str, axis: &str| {
        format!(
            r#"<joint name="j{n}" type="revolute"><parent link="l{}"/><child link="l{n}"/><origin xyz="{xyz}"/><axis xyz="{axis}"/>
            <limit lower="-2" upper="2" velocity="3" effort="0"/></joint><link name="l{n}"/>"#,
            n - 1
        )
    };
    let places = ["0 0 0.29", "0 0 0", "0 0 0.27", "0 0 0.07", "0.302 0 0", "0.072 0 0"];
    let axes = ["0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0"];
    let text: String = (0..6).map(|k| joint(k + 1, places[k], axes[k])).collect();
    format!(r#"<robot name="irb120"><link name="l0"/>{text}</robot>"#)
}

/// What a caller asks a cell.
struct Asked<'a> {
    waypoint: Waypoint,
    tip: Point3<f64>,
    axis: UnitVector3<f64>,
    joints: [f64; 6],
    numbers: &'a [f64],
    value: f64,
}

fn fill<const N: usize>(joints: &[f64], value: f64) -> [f64; N] {
    std::array::from_fn(|k| joints.get(k).copied().unwrap_or(value))
}

fn feed_cell<const N: usize, const F: usize, W: Workcell<N, F>>(cell: &W, asked: &Asked<'_>) {
    let Asked { waypoint, joints, numbers, value, .. } = asked;
    let _ = (cell.limits(), cell.free());
    for free in [[0.1; F], fill(numbers, *value)] {
        let mut found = Vec::new();
        cell.solutions(waypoint, &free, &mut |branch, joints| found.push((branch, joints)));
        for branch in found.iter().map(|&(branch, _)| branch).chain([0, 7, u32::MAX]) {
            cell.following(waypoint, &free, branch);
        }
        for previous in found.iter().map(|&(_, joints)| joints).chain([fill(joints, *value)]) {
            let _ =
                (cell.continuing(waypoint, &free, 0.1, &previous), cell.continuing(waypoint, &free, *value, &previous));
        }
    }
    for joints in [fill(joints, *value), fill(joints, 0.1)] {
        let _ = (cell.nozzle_on_part(&joints), cell.frames(&joints), cell.controller_pose(&joints));
        let _ = (cell.scene_posture(&joints), cell.manipulability(&joints));
    }
    feed_equipment(cell.equipment(), asked);
}

fn feed_equipment(equipment: &Equipment, asked: &Asked<'_>) {
    let _ = (equipment.arm(), equipment.arm_model(), equipment.catalogue_arm(), equipment.name(), equipment.model());
    let _ = (equipment.home::<6>(), equipment.home::<0>(), equipment.home::<8>(), equipment.language());
    let _ = (equipment.link_bodies(), equipment.positioner(), equipment.track(), equipment.roller());
    let (nozzle, part) = (equipment.nozzle_frame(), equipment.part_frame());
    let _ = (tool_frame(&nozzle.1), tool_frame(&part.1));
    for wanted in [100.0, asked.value] {
        let _ = (equipment.plate_diameter_mm(wanted), equipment.scene(wanted));
    }
    equipment.depth_in_plate(&asked.tip, &asked.axis);
    let _ = (
        BlendOptions::of_workcell(equipment),
        KrlOptions::of_workcell(equipment),
        RapidOptions::of_workcell(equipment),
    );
    let _ = (
        StreamOptions::of_workcell(equipment),
        TpOptions::of_workcell(equipment),
        UrScriptOptions::of_workcell(equipment),
    );
}

fn feed_any(cell: &AnyWorkcell, asked: &Asked<'_>) {
    feed_equipment(cell.equipment(), asked);
    match cell {
        AnyWorkcell::Six(cell) => {
            cell.setup();
            for (roller, heading) in [
                (RollerModel::default(), asked.value),
                (RollerModel { width_mm: asked.value, ..RollerModel::default() }, 0.3),
            ] {
                let _ = cell.with_roller(roller, heading).map(|cell| feed_cell(&cell, asked));
            }
            feed_cell(cell, asked);
        }
        AnyWorkcell::Seven(cell) => {
            let _ = (cell.setup(), cell.track());
            feed_cell(cell, asked);
        }
        AnyWorkcell::Eight(cell) => {
            cell.setup();
            feed_cell(cell, asked);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn cells_take_anything(waypoint in waypoint(), tip in point(), axis in unit(), joints in joints(), numbers in prop::collection::vec(number(), 2), value in bad(), solids in prop::collection::vec(solid(), 0..3), file in 0..4usize, robot in 0..6usize, name in "[A-Za-z0-9]{0,6}", link in prop::sample::select(vec![0, 6, 7, usize::MAX]), mesh in (prop::collection::vec(point(), 0..5), prop::collection::vec([index(), index(), index()], 0..4))) {
        let asked = Asked { waypoint, tip, axis, joints, numbers: &numbers, value };
        let sound = WorkcellModel::from_json(FILES[file].as_bytes()).unwrap();
        let mut odd = sound.clone();
        odd.solids.extend(solids);
        let mut meshes = sound.clone();
        meshes.arm.bodies = Some(BodiesModel::Meshes(vec![LinkMeshModel { link, file: name.clone(), unit_mm: value, frame: FrameModel { position_mm: [0.0; 3], rpy_deg: [value; 3] } }]));
        let mut named = sound.clone();
        named.arm = ArmPart::new(ArmGeometry::Named(name.clone()));
        let around = WorkcellModel::around_part(&name, ArmPart::of_model(ROBOTS[robot].1), ROBOTS[robot].1, value);
        let known = WorkcellModel::around(robots::find("IRB120").unwrap());
        for model in each_spoilt(&sound, &MODEL, value).into_iter().chain([odd, named, around, known]) {
            let mut written = Vec::new();
            let _ = (model.is_assumed(), model.write_json(&mut written));
            let _ = AnyWorkcell::from_json(&written[..]);
            let _ = AnyWorkcell::new(model).map(|cell| feed_any(&cell, &asked));
        }
        for unit_mm in [1.0, value] {
            let mut model = meshes.clone();
            if let Some(BodiesModel::Meshes(list)) = &mut model.arm.bodies {
                list[0].unit_mm = unit_mm;
            }
            let _ = AnyWorkcell::new(model.clone());
            let _ = AnyWorkcell::with_link_meshes(model, &mut |_| Ok(mesh.clone())).map(|cell| feed_any(&cell, &asked));
        }
        nozzle_pairs(&[&name, &name]);
    }

    #[test]
    fn cell_files_take_anything(text in "[a-z_0-9 ,.:\n{}\\[\\]\"-]{0,120}", any in prop::collection::vec(any::<u8>(), 0..90), at in 0..3000usize, byte in any::<u8>(), file in 0..4usize, name in prop::option::of("[a-z_0-9]{0,9}")) {
        let mut spoilt = FILES[file].as_bytes().to_vec();
        let cut = spoilt[..at.min(spoilt.len())].to_vec();
        if let Some(place) = spoilt.get_mut(at) {
            *place = byte;
        }
        for text in [text.clone().into_bytes(), any, spoilt, cut] {
            let _ = (WorkcellModel::from_json(&text[..]), AnyWorkcell::from_json(&text[..]));
        }
        let mut urdf = urdf().into_bytes();
        if let Some(place) = urdf.get_mut(at) {
            *place = byte;
        }
        let urdf = String::from_utf8_lossy(&urdf).into_owned();
        for names in [LinkNames::default(), LinkNames { base: name.clone(), flange: None }] {
            let _ = UrdfArm::read(&urdf, &names).map(|arm| ArmPart::of_urdf(&arm).is_ok());
        }
        let model = UrdfModel::Links { file: text.clone(), base: name, flange: None };
        for (model, read) in [(UrdfModel::File(text), &urdf), (model, &urdf)] {
            prop_assert!(model.file().len() < 200);
            let mut cell = WorkcellModel::from_json(FILES[file].as_bytes()).unwrap();
            cell.arm = ArmPart::new(ArmGeometry::Urdf(model));
            let _ = cell.clone().with_urdf(&mut |_| Err("there is none".to_owned()));
            let _ = cell.with_urdf(&mut |_| Ok(read.clone())).map(AnyWorkcell::new);
        }
    }
}

/// What a caller asks of a scene that grows.
struct Motions<'a> {
    joints: &'a [[f64; 6]; 4],
    layers: [u32; 2],
    value: f64,
    rows: &'a [u64],
}

fn feed_growing<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    part: &PartCells<'_>,
    options: &GrowingOptions,
    plate_mm: f64,
    asked: &Motions<'_>,
) {
    let Ok(mut scene) = GrowingScene::new(cell, part, plate_mm, options) else { return };
    let control = asked.joints.map(|joints| fill(&joints, asked.value));
    for layer in asked.layers {
        let _ = (scene.begin(layer), scene.build(layer));
        let [begun, built] = scene.layers();
        assert!(begun <= part.layers.len() && built <= part.layers.len());
        for level in [ClearanceLevel::Wide, ClearanceLevel::Narrow, ClearanceLevel::Least] {
            let _ = scene.touching_printing(&control[0], level);
        }
        let _ = (scene.touching_moving(&control[1]), scene.indicator(&control[2]));
        let _ = (
            scene.sweep_printing(&control),
            scene.sweep_moving(&control),
            scene.is_moving_free(&control[0], &control[3]),
        );
    }
    let _ = (scene.workcell(), scene.frame_part(), scene.options());
    let _ = scene.on_mould(asked.rows);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn growing_scenes_take_anything(dims in prop::array::uniform3(prop::sample::select(vec![0, 1, 2, 70, u32::MAX])), rows in prop::collection::vec(any::<u64>(), 0..9), cell_mm in number(), origin in point(), frame in pose(), layers in prop::collection::vec(prop::collection::vec(index(), 0..4), 0..3), joints in [joints(), joints(), joints(), joints()], which in [index(), index()], value in bad(), plate in number()) {
        let (six, eight, held) = (ur3(), over_table(), ur10());
        let sound_rows = [0b11u64; 4];
        let sound_layers = [vec![0, 1, 2, 3], vec![4, 5, 6, 7]];
        let sound = PartCells { dims: [2, 2, 2], rows: &sound_rows, cell_mm: 5.0, origin: Point3::origin(), frame_part: Isometry3::identity(), layers: &sound_layers };
        let parts = [sound, PartCells { dims, rows: &rows, ..sound }, PartCells { cell_mm, origin, ..sound }, PartCells { frame_part: frame, layers: &layers, ..sound }, PartCells { rows: &rows, ..sound }];
        let asked = Motions { joints: &joints, layers: which, value, rows: &rows };
        let options = GrowingOptions { resolution_mm: 5.0, fine_resolution_mm: 2.0, ..GrowingOptions::default() };
        for part in &parts {
            feed_growing(&six, part, &options, 100.0, &asked);
        }
        for options in each_spoilt(&options, &GROWING, value) {
            feed_growing(&eight, &sound, &options, 100.0, &asked);
        }
        for plate in [plate, value] {
            feed_growing(&held, &sound, &options, plate, &asked);
        }
    }
}
