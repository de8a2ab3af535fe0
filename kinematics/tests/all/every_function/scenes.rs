//! Scenes: bodies of any shape, postures, sweeps.

use super::numbers::{bad, each_spoilt, index, joints, number, point, pose};
use crate::common::{ROBOTS, arm};
use curvlay_kinematics::nalgebra::{Isometry3, Point3};
use curvlay_kinematics::robots;
use curvlay_kinematics::scene::*;
use curvlay_kinematics::{Positioner, Track, TrackModel};
use proptest::prelude::*;

fn shape() -> impl Strategy<Value = Shape> {
    let points = || prop::collection::vec(point(), 0..7);
    let triangles = prop::collection::vec([index(), index(), index()], 0..5);
    let dims = prop::array::uniform3(prop::sample::select(vec![0, 1, 2, 70, u32::MAX]));
    let one = prop_oneof![
        2 => (point(), point(), number()).prop_map(|(from, to, radius)| Shape::Capsule { from, to, radius }),
        2 => (points(), number()).prop_map(|(points, radius)| Shape::Hull { points, radius }),
        2 => (points(), triangles).prop_map(|(points, triangles)| Shape::Mesh { points, triangles }),
        2 => (dims, prop::collection::vec(any::<u64>(), 0..9), number()).prop_map(|(dims, rows, cell)| Shape::Cells { dims, rows, cell }),
        1 => (point(), point()).prop_map(|(low, high)| Shape::block(low, high)),
        1 => (number(), number(), number()).prop_map(|(radius, low, high)| Shape::cylinder(radius, low, high)),
        2 => (1..3u32, 1..3u32).prop_map(|(x, y)| Shape::Cells { dims: [x, y, 1], rows: vec![1; y as usize], cell: 5.0 }),
        1 => Just(Shape::block(Point3::new(200.0, -50.0, 0.0), Point3::new(300.0, 50.0, 90.0))),
    ];
    prop_oneof![6 => one.clone(), 1 => prop::collection::vec(one, 0..3).prop_map(Shape::Union)]
}

fn mount() -> impl Strategy<Value = Mount> {
    let fixed = vec![Mount::Base, Mount::Tilt, Mount::Table, Mount::Ground, Mount::Rail];
    prop_oneof![3 => prop::sample::select(fixed), 1 => prop::sample::select(vec![0, 3, 6, 7, usize::MAX]).prop_map(Mount::Link)]
}

fn body() -> impl Strategy<Value = Body> {
    let place = prop_oneof![2 => Just(Isometry3::identity()), 1 => pose()];
    ("[a-c]", mount(), place, shape()).prop_map(|(name, mount, mount_body, shape)| Body {
        name,
        mount,
        mount_body,
        shape,
    })
}

pub fn posture() -> impl Strategy<Value = Posture> {
    (joints(), [number(), number()]).prop_map(|(joints, table)| Posture { joints, table })
}

const SCENE: [fn(&mut SceneModel, f64); 3] = [
    |model, value| model.margin = value,
    |model, value| model.link_allowance = value,
    |model, value| model.clearance = value,
];

fn feed(scene: &Scene, postures: &[Posture; 4], value: f64) {
    let _ = (scene.margin(), scene.link_allowance(), scene.names().count(), scene.pairs().count());
    let [from, from_rate, to, to_rate] = postures;
    for posture in [from, to] {
        let _ = (scene.touching(posture), scene.nearest(posture));
        for within in [10.0, value] {
            let _ = scene.clearance(posture, within);
        }
    }
    for resolution in [5.0, value] {
        let _ = (scene.sweep(from, to, resolution), scene.is_free(from, to, resolution));
        for seconds in [0.5, value] {
            let control = cubic_control(from, from_rate, to, to_rate, seconds);
            let _ = (scene.sweep_cubic(&control, resolution), scene.is_cubic_free(&control, resolution));
        }
        let _ = (scene.sweep_cubic(postures, resolution), scene.is_cubic_free(postures, resolution));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn scenes_take_anything(
        bodies in prop::collection::vec(body(), 0..4), postures in [posture(), posture(), posture(), posture()], value in bad(), robot in 0..6usize, allowed in prop::collection::vec(["[a-d]", "[a-d]"], 0..3), name in "[a-d]", other in shape(), points in prop::collection::vec(point(), 0..5), triangles in prop::collection::vec([index(), index(), index()], 0..4), rows in prop::collection::vec(any::<u64>(), 0..5),
    ) {
        let model = ROBOTS[robot].1;
        let track = TrackModel { direction: [1.0, 0.0, 0.0], range_mm: [0.0, 900.0], zero_mm: 0.0, speed_mm_s: 500.0, acceleration_mm_s2: 1e3, jerk_mm_s3: 1e4 };
        let (positioner, track) = (Positioner::new(&robots::IRBP_A250, &Isometry3::identity()).ok(), Track::new(&track, 800.0).ok());
        let allowed: Vec<[String; 2]> = allowed;
        let plain = SceneModel { links: links(model), bodies, allowed, ..SceneModel::of(arm(model)) };
        let estimated = SceneModel { links: estimated_links(model), ..plain.clone() };
        for model in [SceneModel { allowed: vec![], ..plain.clone() }, SceneModel { positioner, ..plain.clone() }, SceneModel { positioner, track, ..plain.clone() }, estimated] {
            let Ok(mut scene) = Scene::new(model) else { continue };
            feed(&scene, &postures, value);
            let _ = scene.replace(&name, other.clone());
            let _ = (scene.add_triangles(&name, &points, &triangles), scene.add_cells(&name, &rows));
            feed(&scene, &postures, 5.0);
        }
        let alone = SceneModel { bodies: vec![], ..plain };
        for model in each_spoilt(&alone, &SCENE, value) {
            let _ = Scene::new(model).map(|scene| feed(&scene, &postures, value));
        }
    }

    #[test]
    fn links_take_anything(robot in 0..6usize, value in bad(), lengths in prop::array::uniform6(number())) {
        let mut model = *ROBOTS[robot].1;
        prop_assert!(link_source(&model).is_some());
        model.offsets[2] = value;
        let _ = (links(&model), estimated_links(&model), link_source(&model));
        let [upper, fore, ..] = lengths;
        model.geometry = curvlay_kinematics::Geometry::Ur(curvlay_kinematics::DhTable::ur(lengths, upper, fore));
        let _ = (links(&model), estimated_links(&model), link_source(&model));
    }
}
