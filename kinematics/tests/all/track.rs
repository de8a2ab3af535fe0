//! An arm on a linear track: kinematics and scene against the same arm put elsewhere by hand, numbers that cannot be, and programs.
#![cfg(feature = "serde")] // the cell is read from a file of the examples

use crate::common::programs::{Files, written_files};
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Translation3, UnitVector3, Vector3};
use curvlay_kinematics::print_program::{PrintKnot, TargetMotion, TargetOptions, print_targets};
use curvlay_kinematics::program::{
    CsvReader, ExternalAxes, Goal, KrlOptions, Move, ProgramLimits, RapidOptions, Step, TpOptions, UrScriptOptions,
    WriteError, read_krl, read_rapid, read_tp, write_csv_on_track, write_krl, write_rapid, write_tp, write_urscript,
};
use curvlay_kinematics::scene::{Body, Mount, Posture, Scene, SceneError, SceneModel, Shape, Sweep, links};
use curvlay_kinematics::workcell::{
    AnyWorkcell, FreeRange, Held, MountModel, PlateModel, PositionerPart, SevenAxisWorkcell, Workcell, WorkcellError,
    WorkcellFileError, WorkcellModel,
};
use curvlay_kinematics::{Arm, Track, TrackError, TrackModel, Waypoint, robots};
use proptest::prelude::*;
use std::io::Cursor;

const FILE: &str = include_str!("../../../examples/cells/irb120-track.json");

fn model() -> WorkcellModel {
    WorkcellModel::from_json(FILE.as_bytes()).unwrap()
}

fn seven(model: WorkcellModel) -> SevenAxisWorkcell {
    match AnyWorkcell::new(model).unwrap() {
        AnyWorkcell::Seven(cell) => cell,
        _ => panic!("it has no track"),
    }
}

/// The same cell with a nozzle beside axis 6, bent.
fn bent() -> SevenAxisWorkcell {
    let mut model = model();
    (model.nozzle.tip_mm, model.nozzle.flow) = ([40.0, 10.0, 120.0], [0.5, 0.2, 1.0]);
    model.track.as_mut().unwrap().tool_angle_deg = 20.0;
    seven(model)
}

/// Where the nozzle is on the part, by the arm and the numbers of the file alone.
fn by_hand(cell: &SevenAxisWorkcell, joints: &[f64; 7]) -> Isometry3<f64> {
    let equipment = cell.equipment();
    let arm = Arm::new(equipment.arm_model()).unwrap();
    // Range 0 to 1400 mm, origin at 700, along y.
    let mm = 700.0 + joints[6] * cell.track().mm_per_unit();
    let base = Translation3::new(0.0, mm - 700.0, 0.0);
    let part = Translation3::new(400.0, 0.0, 0.0);
    part.inverse() * (base * arm.forward(&std::array::from_fn(|k| joints[k]))) * equipment.nozzle_frame().1
}

fn solutions(cell: &SevenAxisWorkcell, waypoint: &Waypoint, place: f64) -> Vec<(u32, [f64; 7])> {
    let mut found = vec![];
    cell.solutions(waypoint, &[place], &mut |branch, joints| found.push((branch, joints)));
    found
}

fn leaning(y: f64, z: f64, lean: [f64; 2]) -> Waypoint {
    let axis = UnitVector3::new_normalize(Vector3::new(lean[0], lean[1], 1.0));
    Waypoint { position: Point3::new(5.0, y, z), axis }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn solutions_meet_the_waypoint_and_follow_the_track(
        y in -650.0..650.0f64, z in 0.0..80.0f64, lean in prop::array::uniform2(-0.3..0.3f64), share in -0.95..0.95f64, is_bent: bool,
    ) {
        let cell = if is_bent { bent() } else { seven(model()) };
        let place = share * cell.limits().upper[6];
        let waypoint = leaning(y, z, lean);
        for (branch, joints) in solutions(&cell, &waypoint, place) {
            for nozzle in [by_hand(&cell, &joints), cell.nozzle_on_part(&joints).unwrap()] {
                prop_assert!((nozzle.translation.vector - waypoint.position.coords).norm() < 1e-6);
                prop_assert!((nozzle.rotation * Vector3::z() - waypoint.axis.into_inner()).norm() < 1e-8);
            }
            prop_assert!((joints[6] - place).abs() < 1e-15);
            let Some((again, [rates])) = cell.following(&waypoint, &[place], branch) else { continue };
            prop_assert!((0..7).all(|k| (again[k] - joints[k]).abs() < 1e-12));
            let step = 1e-6;
            let near = |by: f64| cell.following(&waypoint, &[place + by], branch).map(|(joints, _)| joints);
            let (Some(before), Some(after)) = (near(-step), near(step)) else { continue };
            for k in 0..7 {
                let slope = (after[k] - before[k]) / (2.0 * step);
                // Next to a singularity a difference says little.
                let near = (slope - rates[k]).abs() <= 1e-3 * (1.0 + rates[k].powi(2));
                prop_assert!(near || rates[k].abs() > 30.0, "{k}: {slope} {}", rates[k]);
            }
            // Lifting off moves the arm alone, back to the same posture where it began.
            if cell.limits().contains(&joints) {
                let stays = cell.continuing(&waypoint, &[0.0], 0.0, &joints).unwrap();
                prop_assert!((0..7).all(|k| (stays[k] - joints[k]).abs() < 1e-7), "{stays:?} {joints:?}");
                let frames = cell.frames(&joints).unwrap();
                let part_nozzle = frames.part.inverse() * frames.nozzle;
                prop_assert!((part_nozzle.translation.vector - waypoint.position.coords).norm() < 1e-6);
                prop_assert!((frames.part.translation.vector - Vector3::new(400.0, 0.0, 0.0)).norm() < 1e-9);
            }
        }
    }

    /// The scene of a track is the scene of an arm that was put elsewhere: everything on the ground goes the other way.
    #[test]
    fn the_ground_goes_by(joints in prop::array::uniform6(-2.0..2.0f64), place in -1.0..1.0f64, onwards in -1.0..1.0f64) {
        let (with, track) = beside_a_track();
        let at = |joints: [f64; 6], place: f64| Posture { joints, table: [place, 0.0] };
        let still = |place: f64| put_elsewhere(&track.shift(place));
        let found = with.nearest(&at(joints, place)).unwrap().unwrap();
        let expected = still(place);
        let expected = expected.nearest(&joints.into()).unwrap().unwrap();
        prop_assert!((found.distance - expected.distance).abs() < 1e-9);
        // Its slope by the track.
        if let (Some(near), true) = (with.clearance(&at(joints, place), 1e4).unwrap(), found.distance > 1.0) {
            let distance = |by: f64| with.nearest(&at(joints, place + by)).unwrap().unwrap().distance;
            let slope = (distance(1e-6) - distance(-1e-6)) / 2e-6;
            // Where another pair or point is as near, it is the slope of one of them.
            let bent = (distance(1e-4) - 2.0 * distance(0.0) + distance(-1e-4)).abs() > 1e-3;
            prop_assert!(bent || (slope - near.table[0]).abs() < 0.5, "{slope} {:?}", near.table);
        }
        // A motion that is proven free is free, and one that is not comes near.
        let to = joints.map(|angle| angle + 0.2);
        let sweep = with.sweep(&at(joints, place), &at(to, onwards), 1.0).unwrap();
        let least = (0..=40).map(|k| {
            let share = f64::from(k) / 40.0;
            let between = std::array::from_fn(|j| joints[j] + share * (to[j] - joints[j]));
            still(place + share * (onwards - place)).nearest(&between.into()).unwrap().unwrap().distance
        });
        let least = least.fold(f64::INFINITY, f64::min);
        match sweep {
            Sweep::Free => prop_assert!(least > 5.0, "{least}"),
            Sweep::Near { at: share, .. } => {
                let between = std::array::from_fn(|j| joints[j] + share * (to[j] - joints[j]));
                let there = still(place + share * (onwards - place));
                prop_assert!(there.nearest(&between.into()).unwrap().unwrap().distance <= 6.0 + 1e-6);
            }
        }
    }
}

fn block(name: &str, mount: Mount, low: [f64; 3], high: [f64; 3]) -> Body {
    let shape = Shape::block(low.into(), high.into());
    Body { name: name.into(), mount, mount_body: Isometry3::identity(), shape }
}

fn on_the_ground(mount: Mount) -> Vec<Body> {
    vec![
        block("wall", mount, [150.0, 300.0, -100.0], [250.0, 500.0, 700.0]),
        block("post", mount, [-400.0, -80.0, 0.0], [-350.0, 0.0, 900.0]),
    ]
}

/// The upper arm and the forearm of a UR3, which are not compared with each other.
fn two_links() -> Vec<Body> {
    links(&robots::UR3).into_iter().filter(|link| matches!(link.mount, Mount::Link(2 | 3))).collect()
}

/// A UR3 on a track along a slanted line, between things that stand still.
fn beside_a_track() -> (Scene, Track) {
    let track = TrackModel {
        direction: [1.0, 2.0, 0.0],
        range_mm: [-500.0, 900.0],
        zero_mm: 100.0,
        speed_mm_s: 500.0,
        acceleration_mm_s2: 1000.0,
        jerk_mm_s3: f64::INFINITY,
    };
    let track = Track::new(&track, 500.0).unwrap();
    let arm = Arm::new(&robots::UR3).unwrap();
    let bodies = on_the_ground(Mount::Ground);
    let model = SceneModel { links: two_links(), bodies, track: Some(track), margin: 5.0, ..SceneModel::of(arm) };
    (Scene::new(model).unwrap(), track)
}

/// The same without a track: the arm in the origin, everything else put back by hand.
fn put_elsewhere(shift: &Vector3<f64>) -> Scene {
    let arm = Arm::new(&robots::UR3).unwrap();
    let mut bodies = on_the_ground(Mount::Base);
    bodies.iter_mut().for_each(|body| body.mount_body = Translation3::from(-shift) * body.mount_body);
    Scene::new(SceneModel { links: two_links(), bodies, margin: 5.0, ..SceneModel::of(arm) }).unwrap()
}

#[test]
fn a_carriage_is_compared_with_what_it_passes_but_not_with_its_rail() {
    let (_, track) = beside_a_track();
    let arm = Arm::new(&robots::UR3).unwrap();
    let bodies = vec![
        block("carriage", Mount::Base, [-100.0, -100.0, -50.0], [100.0, 100.0, 0.0]),
        block("rail", Mount::Rail, [-2000.0, -2000.0, -100.0], [2000.0, 2000.0, -50.0]),
        block("wall", Mount::Ground, [150.0, 300.0, -100.0], [250.0, 500.0, 700.0]),
    ];
    let model = SceneModel { bodies: bodies.clone(), track: Some(track), margin: 1.0, ..SceneModel::of(arm) };
    let scene = Scene::new(model.clone()).unwrap();
    assert_eq!(scene.pairs().collect::<Vec<_>>(), [["carriage", "wall"]]);
    let at = |mm: f64| Posture { joints: [0.0; 6], table: [track.joint(mm), 0.0] };
    assert_eq!(scene.touching(&at(100.0)), Ok(None));
    // 400 mm along (1, 2) are (179, 358).
    assert_eq!(scene.touching(&at(500.0)), Ok(Some(["carriage", "wall"])));
    assert!(scene.is_free(&at(-500.0), &at(100.0), 0.5).unwrap());
    assert!(!scene.is_free(&at(100.0), &at(900.0), 0.5).unwrap());
    assert!(scene.touching(&Posture { joints: [0.0; 6], table: [f64::NAN, 0.0] }).is_err());
    let without = SceneModel { track: None, ..model.clone() };
    assert_eq!(Scene::new(without).map(|_| ()), Err(SceneError::NoTrack { body: "rail".into() }));
    let table = curvlay_kinematics::Positioner::new(&robots::IRBP_A250, &Isometry3::identity()).unwrap();
    let both = SceneModel { positioner: Some(table), ..model };
    assert_eq!(Scene::new(both).map(|_| ()), Err(SceneError::TableAndTrack));
}

#[test]
fn a_track_reaches_what_the_arm_alone_does_not() {
    let on_track = seven(model());
    let mut still = model();
    still.track = None;
    still.solids.retain(|solid| !matches!(solid.mount, MountModel::Rail | MountModel::Carriage));
    let AnyWorkcell::Six(still) = AnyWorkcell::new(still).unwrap() else { panic!("it has a track") };
    let [FreeRange::Within(low, high)] = on_track.free() else { panic!("a track has ends") };
    assert!((on_track.track().mm(low)).abs() < 1e-9 && (on_track.track().mm(high) - 1400.0).abs() < 1e-9);
    let limits = on_track.limits();
    let unit = on_track.track().mm_per_unit();
    // Lengths of the IRB 120: 270, 70, 302, 72 and 290 mm.
    assert!((unit - 1004.0).abs() < 1e-9, "{unit}");
    assert!((limits.velocity[6] * unit - 1000.0).abs() < 1e-9 && (limits.jerk[6] * unit - 20_000.0).abs() < 1e-9);
    for (y, alone) in [(-600.0, false), (0.0, true), (600.0, false)] {
        let waypoint = leaning(y, 10.0, [0.0; 2]);
        let mut count = 0;
        for sample in 0..36 {
            still.solutions(&waypoint, &[0.1745 * f64::from(sample)], &mut |_, _| count += 1);
        }
        assert_eq!(count > 0, alone, "{y}");
        assert!(
            (0..=20).any(|k| !solutions(&on_track, &waypoint, low + (high - low) * f64::from(k) / 20.0).is_empty())
        );
    }
    assert!(solutions(&on_track, &leaning(0.0, 10.0, [0.0; 2]), high + 1e-6).is_empty());
    assert!(solutions(&on_track, &leaning(0.0, 10.0, [0.0; 2]), f64::NAN).is_empty());
}

#[test]
fn home_has_a_place_on_the_track() {
    let mut model = model();
    model.home_deg = Some(vec![0.0, -10.0, 20.0, 0.0, 60.0, 0.0]);
    let home = seven(model.clone()).equipment().home::<7>().unwrap();
    assert!(home[6].abs() < 1e-15 && (home[4].to_degrees() - 60.0).abs() < 1e-12);
    model.track.as_mut().unwrap().home_mm = Some(200.0);
    let cell = seven(model.clone());
    assert!((cell.track().mm(cell.equipment().home::<7>().unwrap()[6]) - 200.0).abs() < 1e-9);
    model.home_deg.as_mut().unwrap().push(0.0);
    assert!(matches!(AnyWorkcell::new(model), Err(WorkcellError::Number { path, .. }) if path == "home_deg.length"));
}

#[test]
fn numbers_that_make_no_track_are_named() {
    type Change = fn(&mut WorkcellModel);
    let refused = |change: Change| {
        let mut model = model();
        change(&mut model);
        AnyWorkcell::new(model).unwrap_err()
    };
    let cases: [(&str, Change); 9] = [
        ("track.range_mm[0]", |m| m.track.as_mut().unwrap().range_mm = [10.0, 0.0]),
        ("track.range_mm[1]", |m| m.track.as_mut().unwrap().range_mm[1] = f64::INFINITY),
        ("track.zero_mm", |m| m.track.as_mut().unwrap().zero_mm = f64::NAN),
        ("track.max_speed_mm_s", |m| m.track.as_mut().unwrap().max_speed_mm_s = 0.0),
        ("track.max_acceleration_mm_s2", |m| m.track.as_mut().unwrap().max_acceleration_mm_s2 = Some(-1.0)),
        ("track.max_jerk_mm_s3", |m| m.track.as_mut().unwrap().max_jerk_mm_s3 = Some(f64::NAN)),
        ("track.home_mm", |m| m.track.as_mut().unwrap().home_mm = Some(1500.0)),
        ("track.tool_angle_deg", |m| m.track.as_mut().unwrap().tool_angle_deg = f64::NAN),
        ("plate.size_mm[1]", |m| m.plate.size_mm = Some([10.0, 0.0])),
    ];
    for (field, change) in cases {
        let error = refused(change);
        assert!(matches!(&error, WorkcellError::Number { path, .. } if path == field), "{field}: {error}");
    }
    let still = refused(|m| m.track.as_mut().unwrap().direction = [0.0; 3]);
    assert_eq!(still, WorkcellError::NoDirection { path: "track.direction".into() });
    let far = refused(|m| m.part.position_mm = [400.0, 4000.0, 0.0]);
    assert!(matches!(far, WorkcellError::Reach { path: "track.range_mm", .. }), "{far}");
    let WorkcellError::Reach { reach_mm, .. } = far else { unreachable!() };
    // Behind the end of the track a plate of 300 mm may be so far away that only its near edge is in reach.
    let behind = |mm: f64| {
        let mut model = model();
        model.part.position_mm = [0.0, 700.0 + mm, 0.0];
        model.plate = PlateModel { diameter_mm: Some(300.0), size_mm: None, ..model.plate };
        AnyWorkcell::new(model)
    };
    let farthest = reach_mm + seven(model()).equipment().nozzle_frame().1.translation.vector.norm() + 150.0;
    assert!(behind(farthest - 1.0).is_ok());
    assert!(matches!(behind(farthest + 1.0), Err(WorkcellError::Reach { path: "track.range_mm", .. })));
    assert_eq!(refused(|m| m.held = Held::Part), WorkcellError::HeldPartOnTrack);
    assert_eq!(refused(|m| m.plate = PlateModel { diameter_mm: Some(5.0), ..m.plate }), WorkcellError::TwoPlates);
    let on_floor = refused(|m| m.solids[1].mount = MountModel::Base);
    assert!(matches!(on_floor, WorkcellError::Carriage { .. }), "{on_floor}");
    assert!(on_floor.to_string().starts_with("solids[1].mount: "), "{on_floor}");
    let no_track = refused(|m| m.track = None);
    assert!(matches!(&no_track, WorkcellError::Mount { path, .. } if path == "solids[0].mount"), "{no_track}");
    let table: PositionerPart =
        WorkcellModel::from_json(include_str!("../../../examples/cells/irb1200-table.json").as_bytes())
            .unwrap()
            .positioner
            .unwrap();
    let mut both = model();
    both.positioner = Some(table);
    assert_eq!(AnyWorkcell::new(both).unwrap_err(), WorkcellError::TrackAndTable);
    // Fields that the file must have.
    for field in ["direction", "range_mm", "max_speed_mm_s"] {
        let mut file: serde_json::Value = serde_json::from_str(FILE).unwrap();
        file["track"].as_object_mut().unwrap().remove(field);
        let error = WorkcellModel::from_json(file.to_string().as_bytes()).unwrap_err();
        assert!(matches!(&error, WorkcellFileError::Json { what, .. } if what.contains(field)), "{error}");
    }
    let mut written = vec![];
    model().write_json(&mut written).unwrap();
    assert_eq!(WorkcellModel::from_json(written.as_slice()).unwrap(), model());
    let model = TrackModel {
        direction: [0.0, f64::INFINITY, 0.0],
        range_mm: [0.0; 2],
        zero_mm: 0.0,
        speed_mm_s: 1.0,
        acceleration_mm_s2: 1.0,
        jerk_mm_s3: 1.0,
    };
    assert!(matches!(Track::new(&model, 1.0), Err(TrackError::Direction { .. })));
    // Bug: its length was infinite, and the base did not move at all.
    let huge = Track::new(&TrackModel { direction: [0.0, 1e200, 0.0], ..model }, 1.0).unwrap();
    assert!((huge.rate() - Vector3::y()).norm() < 1e-12, "{}", huge.rate());
    let model = TrackModel { direction: [0.0, 1.0, 0.0], ..model };
    assert!(matches!(Track::new(&model, f64::NAN), Err(TrackError::Number { what: "reach_mm", .. })));
    // However long, never a turn.
    let long = Track::new(&TrackModel { range_mm: [-1e5, 1e5], ..model }, 1000.0).unwrap();
    assert!(long.limits().upper[0] - long.limits().lower[0] <= 3.0 + 1e-12);
}

fn all(files: &Files) -> String {
    files.values().map(String::as_str).collect()
}

/// A line of 300 mm along the track, at 50 mm/s.
fn print(cell: &SevenAxisWorkcell, track: fn(f64) -> f64, options: TargetOptions) -> Vec<Step> {
    let knots = (0..=6).map(|k| {
        let y = 50.0 * f64::from(k) - 150.0;
        let (_, joints) = solutions(cell, &leaning(y, 5.0, [0.0; 2]), cell.track().joint(700.0 + track(y)))[0];
        PrintKnot { time_s: f64::from(k), joints, filament_mm: 2.0 * f64::from(k) }
    });
    let motion = TargetMotion { knots: knots.collect(), onward: vec![[0.0; 7]], head: None };
    print_targets(cell, [motion], options).collect()
}

/// Where the track is at each move, in mm.
fn places(steps: &[Step]) -> Vec<f64> {
    let moves = steps.iter().filter_map(|step| if let Step::Move(to) = step { Some(to) } else { None });
    moves.map(|to| to.table.and_then(|axes| axes.track_mm()).unwrap()).collect()
}

/// Where the lines of a program end.
fn lines(steps: &[Step]) -> impl Iterator<Item = Vector3<f64>> {
    steps.iter().filter_map(|step| match step {
        Step::Move(Move { goal: Goal::Line(target), .. }) => Some(target.pose.translation.vector),
        _ => None,
    })
}

/// Waypoints are merged only where the track is on its even way, too.
#[test]
fn waypoints_stay_where_the_track_is_uneven() {
    // This nozzle keeps its heading, so that nothing but the track is uneven.
    let cell = bent();
    let merge = TargetOptions { merge_mm: 0.05, merge_share: 0.05, ..TargetOptions::default() };
    assert_eq!(lines(&print(&cell, |y| 0.8 * y, merge)).count(), 1);
    assert_eq!(lines(&print(&cell, |y| 0.8 * y + 1e-3 * y * y, merge)).count(), 6);
}

#[test]
fn programs_have_the_track_in_millimetres() {
    let cell = seven(model());
    let steps = print(&cell, |y| 0.8 * y, TargetOptions { merge_mm: 0.0, ..TargetOptions::default() });
    let expected = [580.0, 620.0, 660.0, 700.0, 740.0, 780.0, 820.0, 700.0];
    assert!(places(&steps).iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{:?}", places(&steps));
    let near = |read: &[Step]| {
        assert_eq!(places(read).len(), expected.len());
        assert!(places(read).iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{:?}", places(read));
        for (a, b) in lines(&steps).zip(lines(read)) {
            assert!((a - b).norm() < 1e-3, "{a} {b}");
        }
    };
    let equipment = cell.equipment();

    let options = RapidOptions { name: "print".into(), ..RapidOptions::of_workcell(equipment) };
    let (files, _) = written_files(|open| write_rapid(steps.clone(), &options, open)).unwrap();
    let text = all(&files);
    assert!(text.contains("[580,9E9,9E9,9E9,9E9,9E9]") || text.contains("[580,9E+09"), "{text}");
    let file = |name: &str| Cursor::new(files[name].as_str());
    near(&read_rapid(file("print.mod"), |name| Ok(file(name))).unwrap().map(Result::unwrap).collect::<Vec<_>>());

    let options = KrlOptions { name: "print".into(), ..KrlOptions::of_workcell(equipment) };
    let (files, _) = written_files(|open| write_krl(steps.clone(), &options, open)).unwrap();
    let text = all(&files);
    assert!(text.contains(",E1 620") && !text.contains(",E2 "), "{text}");
    let file = |name: &str| Cursor::new(files[name].as_str());
    let read = read_krl(file("print.dat"), file("print.src"), |name| Ok(file(name))).unwrap();
    near(&read.map(Result::unwrap).collect::<Vec<_>>());

    let options = TpOptions { name: "PRINT".into(), ..TpOptions::of_workcell(equipment) };
    assert!(options.track);
    let (files, _) = written_files(|open| write_tp(steps.clone(), &options, open)).unwrap();
    let text = all(&files);
    assert!(text.contains("\tE1= 620 mm\n};") && !text.contains("GP2"), "{text}");
    assert!(text.contains("DEFAULT_GROUP\t= 1,*,*,*,*;") && !text.contains("COORD"), "{text}");
    let file = |name: &str| Cursor::new(files[name].as_str());
    near(&read_tp(file("PRINT.ls"), |name| Ok(file(name))).unwrap().map(Result::unwrap).collect::<Vec<_>>());
    // Group 1 has no table.
    let table = Move {
        goal: Goal::Joints([0.0; 6]),
        table: Some(ExternalAxes::from([0.1, 0.2])),
        speed: Default::default(),
        zone: curvlay_kinematics::program::Zone::Stop,
    };
    let refused = written_files(|open| write_tp([Step::Move(table)], &options, open)).unwrap_err();
    assert!(refused.to_string().contains("external axes other than a track"), "{refused}");

    let mut csv = Vec::new();
    write_csv_on_track(steps.clone(), &ProgramLimits::default(), &mut csv).unwrap();
    let text = String::from_utf8(csv).unwrap();
    near(&CsvReader::new(text.as_bytes()).unwrap().collect::<Result<Vec<_>, _>>().unwrap());
    // Bug: a turn without a track was read as an axis.
    let turned = text.replacen(",580,,", ",,580,", 1);
    assert!(turned != text && CsvReader::new(turned.as_bytes()).unwrap().next().unwrap().is_err());

    let options = UrScriptOptions { name: "print".into(), ..UrScriptOptions::default() };
    let refused = write_urscript(steps, &options, &mut Vec::new()).unwrap_err();
    assert!(matches!(refused, WriteError::Unsupported { .. }), "{refused}");
    assert!(refused.to_string().contains("external axis"), "{refused}");
}
