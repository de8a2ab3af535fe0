//! A roller in the place of the nozzle: its bodies, and what they may touch.
#![cfg(feature = "serde")] // the cells are read from the files of the examples

use crate::common::cells::ur3;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use curvlay_kinematics::scene::Shape;
use curvlay_kinematics::workcell::{
    AnyWorkcell, ClearanceLevel, GrowingOptions, GrowingScene, HOT_END, NOZZLE, PartCells, RollerModel,
    SixAxisWorkcell, Workcell, WorkcellModel,
};
use proptest::prelude::*;

const UR3: &str = include_str!("../../../examples/cells/ur3.json");

/// The points of a roller in the nozzle frame.
fn points(cell: &SixAxisWorkcell) -> Vec<Point3<f64>> {
    let scene = cell.equipment().scene(100.0);
    let body = scene.bodies.iter().find(|body| body.name == NOZZLE).unwrap();
    match &body.shape {
        Shape::Hull { points, .. } => points.clone(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn it_lies_across_its_heading_and_touches_at_the_tip() {
    let roller = RollerModel { diameter_mm: 30.0, width_mm: 8.0, ..RollerModel::default() };
    for heading in [0.0, 0.7, -2.0f64] {
        let with_roller = ur3().with_roller(roller, heading).unwrap();
        let along = Vector3::new(heading.cos(), heading.sin(), 0.0);
        let across = Vector3::z().cross(&along);
        for point in points(&with_roller) {
            assert!((point.coords.dot(&across).abs() - 4.0).abs() < 1e-9);
            // A prism of twelve sides around the round.
            let out = Vector3::new(point.coords.dot(&along), point.z - 15.0, 0.0).norm();
            assert!((15.0 - 1e-9..15.0 * 1.036).contains(&out), "{out}");
        }
        // Reach and frames are those of the nozzle.
        assert_eq!(with_roller.equipment().nozzle_frame(), ur3().equipment().nozzle_frame());
    }
    assert!(ur3().equipment().roller().is_none());
}

#[test]
fn a_file_may_have_it() {
    let text = UR3.replace("\"plate\":", "\"roller\": {\"diameter_mm\": 16, \"width_mm\": 6, \"block_diameter_mm\": 20, \"block_top_mm\": 50, \"mount_deg\": 90},\n  \"plate\":");
    let model = WorkcellModel::from_json(text.as_bytes()).unwrap();
    assert_eq!(model.roller.unwrap().mount_deg, Some(90.0));
    for (from, to, reported) in [
        ("\"width_mm\": 6", "\"width_mm\": 0", "roller.width_mm"),
        ("\"block_top_mm\": 50", "\"block_top_mm\": 16", "above the diameter of the roller, 16"),
        ("\"diameter_mm\": 16", "\"diameter_mm\": -1", "roller.diameter_mm"),
        ("\"mount_deg\": 90", "\"mount_deg\": 1e9", "roller.mount_deg"),
    ] {
        let error = AnyWorkcell::from_json(text.replace(from, to).as_bytes()).unwrap_err().to_string();
        assert!(error.contains(reported), "{error}");
    }
    assert!(ur3().with_roller(RollerModel { block_diameter_mm: f64::NAN, ..RollerModel::default() }, 0.0).is_err());
    assert!(ur3().with_roller(RollerModel::default(), f64::INFINITY).is_err());
}

/// The roller may press on the part; the block above it may not touch it, while that of a nozzle may.
#[test]
fn its_block_keeps_off_the_part() {
    // A wall of 30 mm beside the place where the tool stands.
    let cells: Vec<u32> = (0..15).flat_map(|z| (0..10).map(move |y| 9 + 10 * (y + 10 * z))).collect();
    let mut rows = vec![0u64; 150];
    rows.iter_mut().for_each(|row| *row = 1 << 9);
    let layers = [cells];
    let part = PartCells {
        dims: [10, 10, 15],
        rows: &rows,
        cell_mm: 2.0,
        origin: Point3::new(-10.0, -10.0, 0.0),
        frame_part: Isometry3::identity(),
        layers: &layers,
    };
    let touching = |cell: &SixAxisWorkcell| {
        let mut scene = GrowingScene::new(cell, &part, 120.0, &GrowingOptions::default()).unwrap();
        scene.begin(0).unwrap();
        let waypoint = curvlay_kinematics::Waypoint { position: Point3::new(0.0, 0.0, 2.0), axis: Vector3::z_axis() };
        let mut all = Vec::new();
        for sample in 0..24 {
            cell.solutions(&waypoint, &[0.25 * f64::from(sample)], &mut |_, joints| {
                let found = scene.touching_printing(&joints, ClearanceLevel::Least).unwrap();
                all.push(found.map(|pair| pair.map(str::to_owned)));
            });
        }
        all
    };
    let wide = RollerModel { block_diameter_mm: 30.0, ..RollerModel::default() };
    let is_block = |pair: &Option<[String; 2]>| pair.as_ref().is_some_and(|pair| pair.contains(&HOT_END.to_owned()));
    assert!(touching(&ur3()).iter().all(|pair| !is_block(pair)));
    assert!(touching(&ur3().with_roller(wide, 0.0).unwrap()).iter().any(is_block));
    // A block that is slim enough passes beside the wall, 8 mm away, with the margin.
    let slim = RollerModel { block_diameter_mm: 6.0, ..wide };
    assert!(touching(&ur3().with_roller(slim, 0.0).unwrap()).iter().any(Option::is_none));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// No point of roller or block is deeper in the plate than is said, whatever the heading; level, the depth is exact.
    #[test]
    fn the_depth_in_the_plate_bounds_every_heading(
        axis in prop::array::uniform3(-1.0..1.0f64), z in -5.0..30.0f64, diameter in 5.0..40.0f64, width in 2.0..30.0f64,
    ) {
        let axis = Vector3::from(axis) + Vector3::z() * 1.2;
        prop_assume!(axis.norm() > 0.2);
        let axis = UnitVector3::new_normalize(axis);
        let roller = RollerModel { diameter_mm: diameter, width_mm: width, block_diameter_mm: 25.0, block_top_mm: 61.0, mount_deg: None };
        let with_roller = ur3().with_roller(roller, 0.0).unwrap();
        let tip = Point3::new(3.0, -4.0, z);
        let said = with_roller.equipment().depth_in_plate(&tip, &axis).map_or(0.0, |contact| contact.depth_mm);
        let side = axis.cross(&Vector3::new(0.31, 0.95, -0.1)).normalize();
        let other = axis.cross(&side);
        let mut deepest: f64 = 0.0;
        for heading in 0..24 {
            let angle = f64::from(heading) * 0.2618;
            let along = side * angle.cos() + other * angle.sin();
            let across = axis.cross(&along);
            for k in 0..48 {
                let round = f64::from(k) * 0.1309;
                for end in [-0.5, 0.5] {
                    let p = axis.into_inner() * (diameter / 2.0 * (1.0 - round.cos())) + along * (diameter / 2.0 * round.sin()) + across * (end * width);
                    deepest = deepest.max(-(tip + p).z);
                }
                for height in [diameter, 61.0] {
                    let p = axis.into_inner() * height + (side * round.cos() + other * round.sin()) * 12.5;
                    deepest = deepest.max(-(tip + p).z);
                }
            }
        }
        prop_assert!(said >= deepest - 1e-9, "{said} {deepest}");
        if (axis.z - 1.0).abs() < 1e-9 {
            prop_assert!((said - deepest).abs() < 1e-9);
        }
    }
}
