//! The place of a part for a whole print: against trying everything; the sample that stands for a print; postures against a
//! plain search.

use curvlay_kinematics::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use curvlay_kinematics::scene::{Body, Mount, Scene, SceneModel, Shape};
use curvlay_kinematics::workcell::{
    AnyWorkcell, ArmGeometry, ArmPart, ControllerModel, EightAxisWorkcell, FrameModel, FreeRange, Held, LimitsModel,
    NozzleModel, PlateModel, PositionerGeometry, PositionerPart, SixAxisWorkcell, VERSION, Workcell, WorkcellModel,
};
use curvlay_kinematics::{
    Assessment, BestPosture, JointLimits, PartPlace, PlaceError, PlateError, PlateOptions, Waypoint, best_place,
    centred_on_plate, place_grid, place_on_plate, representative_waypoints,
};
use proptest::prelude::*;
use std::cell::RefCell;
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow::{Break, Continue};

fn upright(x: f64, y: f64, z: f64) -> Waypoint {
    Waypoint { position: Point3::new(x, y, z), axis: Vector3::z_axis() }
}

/// An assessment for each waypoint at each place, with few different values, so that there are ties.
type Table = Vec<Vec<Option<(u8, u8)>>>;

fn table() -> impl Strategy<Value = (Table, Vec<PartPlace>)> {
    (1usize..12, 0usize..10).prop_flat_map(|(places, waypoints)| {
        let value = prop::option::weighted(0.8, (0u8..4, 0u8..6));
        let rows = prop::collection::vec(prop::collection::vec(value, waypoints), places);
        let place = (-3i8..3, -3i8..3, -2i8..3)
            .prop_map(|(x, y, turn)| PartPlace { offset: [f64::from(x), f64::from(y)], turn: f64::from(turn) });
        (rows, prop::collection::vec(place, places))
    })
}

/// Every place in full, compared by its figures one after the other.
fn slow_best(table: &Table, places: &[PartPlace]) -> usize {
    let figures = |place: usize| {
        let row = &table[place];
        let unreachable = row.iter().filter(|found| found.is_none()).count();
        let tight = row.iter().flatten().filter(|(clearance, _)| *clearance < 2).count();
        let quality = row.iter().flatten().map(|(_, quality)| *quality).min().unwrap_or(u8::MAX);
        let [x, y] = places[place].offset;
        // Squares of whole numbers are exact.
        (unreachable, tight, u8::MAX - quality, (x * x + y * y) as u32, places[place].turn.abs() as u32, place)
    };
    (0..places.len()).map(figures).min().unwrap().5
}

proptest! {
    #[test]
    fn the_best_place_is_that_of_all_assessments((table, places) in table()) {
        // The waypoint's height tells which one it is; its place is given by the closure's first argument.
        let waypoints: Vec<_> = (0..table[0].len()).map(|k| upright(0.0, 0.0, k as f64)).collect();
        let calls = RefCell::new(0u64);
        let assess = |place: &PartPlace, at: &Waypoint| {
            *calls.borrow_mut() += 1;
            assert!((at.position.x - place.offset[0]).abs() < 1e-12 && (at.position.y - place.offset[1]).abs() < 1e-12);
            // Equal places are the same row.
            let row = places.iter().position(|other| other == place).unwrap();
            table[row][at.position.z as usize]
                .map(|(clearance, quality)| Assessment { clearance: f64::from(clearance), quality: f64::from(quality) })
        };
        let best = best_place(&places, &waypoints, 2.0, assess, &|_| Continue(())).unwrap();
        let same: Table =
            places.iter().map(|place| table[places.iter().position(|other| other == place).unwrap()].clone()).collect();
        let expected = slow_best(&same, &places);
        prop_assert_eq!(best.index, expected);
        prop_assert_eq!(best.place, places[expected]);
        let row = &same[expected];
        let unreachable: Vec<usize> = (0..row.len()).filter(|&k| row[k].is_none()).collect();
        let tight: Vec<usize> = (0..row.len()).filter(|&k| row[k].is_some_and(|(clearance, _)| clearance < 2)).collect();
        prop_assert_eq!(&best.unreachable, &unreachable);
        prop_assert_eq!(&best.tight, &tight);
        let quality = row.iter().flatten().map(|(_, quality)| f64::from(*quality)).fold(f64::INFINITY, f64::min);
        prop_assert!((best.min_quality - quality).abs() < 1e-12 || best.min_quality.is_infinite() && quality.is_infinite());
        prop_assert_eq!(best.assessments, *calls.borrow());
        prop_assert!(best.assessments <= (places.len() * waypoints.len()) as u64);
    }

    #[test]
    fn a_place_moves_waypoints_as_its_pose(
        offset in prop::array::uniform2(-50.0..50.0f64),
        turn in -7.0..7.0f64,
        position in prop::array::uniform3(-50.0..50.0f64),
        axis in prop::array::uniform3(-1.0..1.0f64),
    ) {
        let axis = UnitVector3::new_normalize(Vector3::from(axis) + Vector3::z() * 1.1);
        let waypoint = Waypoint { position: Point3::from(position), axis };
        let place = PartPlace { offset, turn };
        let placed = place.waypoint(&waypoint);
        prop_assert!((placed.position - place.pose() * waypoint.position).norm() < 1e-10);
        prop_assert!((placed.axis.into_inner() - place.pose() * axis.into_inner()).norm() < 1e-12);
    }

    /// Each choice is the farthest, the radius is that of the whole, and any first few are the choice of as many.
    #[test]
    fn representatives_are_farthest_points(
        points in prop::collection::vec(prop::array::uniform3(-4i8..4), 1..30),
        count in 1usize..12,
        lever in 0u8..5,
    ) {
        let lever = f64::from(lever);
        let waypoints: Vec<Waypoint> = points
            .iter()
            .map(|&[x, y, lean]| Waypoint {
                position: Point3::new(f64::from(x), f64::from(y), 0.0),
                axis: UnitVector3::new_normalize(Vector3::new(f64::from(lean), 0.0, 4.0)),
            })
            .collect();
        let apart = |a: usize, b: usize| {
            let (a, b) = (&waypoints[a], &waypoints[b]);
            (a.position - b.position).norm().hypot(lever * (a.axis.into_inner() - b.axis.into_inner()).norm())
        };
        let found = representative_waypoints(&waypoints, count, lever).unwrap();
        let to_chosen = |index: usize, chosen: &[usize]| {
            chosen.iter().map(|&other| apart(index, other)).fold(f64::INFINITY, f64::min)
        };
        let chosen = &found.waypoints;
        prop_assert!(!chosen.is_empty() && chosen.len() <= count);
        for k in 1..chosen.len() {
            let own = to_chosen(chosen[k], &chosen[..k]);
            let farthest = (0..waypoints.len()).map(|index| to_chosen(index, &chosen[..k])).fold(0.0, f64::max);
            prop_assert!((own - farthest).abs() < 1e-12 && own > 0.0);
            // Rounding of squares may tie; up to that the first is taken.
            let first = (0..waypoints.len()).find(|&index| to_chosen(index, &chosen[..k]) > farthest - 1e-9).unwrap();
            prop_assert!(first == chosen[k] || to_chosen(first, &chosen[..k]) < farthest + 1e-9);
        }
        let radius = (0..waypoints.len()).map(|index| to_chosen(index, chosen)).fold(0.0, f64::max);
        prop_assert!((found.radius - radius).abs() < 1e-12);
        let fewer = representative_waypoints(&waypoints, count - 1, lever).unwrap();
        prop_assert_eq!(&fewer.waypoints[..], &chosen[..chosen.len().min(count - 1)]);
        prop_assert!(chosen.len() == count || radius <= 0.0);
    }
}

/// One place is good, all others lack one waypoint each, among many: these are looked at first.
#[test]
fn waypoints_that_were_bad_are_tried_first() {
    let waypoints: Vec<_> = (0..100).map(|k| upright(0.0, 0.0, f64::from(k))).collect();
    let places = place_grid(10.0, 5, 1).unwrap();
    let assess = |place: &PartPlace, at: &Waypoint| {
        let is_out = at.position.z as u32 == 73 && place.offset[0] < 9.0;
        (!is_out).then_some(Assessment { clearance: 1.0, quality: 1.0 })
    };
    let best = best_place(&places, &waypoints, 0.0, assess, &|_| Continue(())).unwrap();
    assert_eq!(best.place, PartPlace { offset: [10.0, 0.0], turn: 0.0 });
    // In full: the first place and the best one. Of each other one, the waypoint that fails, and one more at most.
    assert!(best.assessments <= 200 + 2 * places.len() as u64, "{} of {}", best.assessments, places.len());
}

#[test]
fn places_are_a_disc_from_the_middle_outwards() {
    let places = place_grid(30.0, 3, 4).unwrap();
    assert_eq!(places.len(), 29 * 4);
    let far = |place: &PartPlace| place.offset[0].hypot(place.offset[1]);
    assert!(places.windows(2).all(|pair| far(&pair[0]) <= far(&pair[1])));
    assert!(places.iter().all(|place| far(place) <= 30.0 && place.turn > -PI && place.turn <= PI));
    assert_eq!(places[..4].iter().map(|place| place.turn).collect::<Vec<_>>(), [0.0, PI / 2.0, -PI / 2.0, PI]);
    assert_eq!(place_grid(30.0, 0, 1).unwrap(), [PartPlace::default()]);
    for (max_offset, steps, turns, what) in
        [(f64::NAN, 1, 1, "max_offset"), (-1.0, 1, 1, "max_offset"), (1.0, 1, 0, "turns"), (1.0, u32::MAX, 1, "steps")]
    {
        let error = place_grid(max_offset, steps, turns).unwrap_err();
        assert!(matches!(error, PlaceError::Option { what: found, .. } if found == what), "{error}");
    }
}

#[test]
fn what_cannot_be_placed_is_named() {
    let fine = |_: &PartPlace, _: &Waypoint| Some(Assessment { clearance: 1.0, quality: 1.0 });
    let (places, waypoints) = ([PartPlace::default()], [upright(0.0, 0.0, 0.0)]);
    let go = |_| Continue(());
    assert_eq!(best_place(&[], &waypoints, 0.0, fine, &go), Err(PlaceError::NoPlace));
    let wild = [places[0], PartPlace { offset: [0.0, f64::NAN], turn: 0.0 }];
    assert_eq!(best_place(&wild, &waypoints, 0.0, fine, &go), Err(PlaceError::Place { index: 1 }));
    let wild = [PartPlace { turn: f64::INFINITY, ..places[0] }];
    assert_eq!(best_place(&wild, &waypoints, 0.0, fine, &go), Err(PlaceError::Place { index: 0 }));
    let nowhere = [waypoints[0], upright(0.0, f64::NAN, 0.0)];
    assert_eq!(best_place(&places, &nowhere, 0.0, fine, &go), Err(PlaceError::Waypoint { index: 1 }));
    let error = best_place(&places, &waypoints, f64::NAN, fine, &go);
    assert!(matches!(error, Err(PlaceError::Option { what: "min_clearance", .. })));
    for (clearance, quality) in [(f64::NAN, 1.0), (1.0, f64::NAN)] {
        let none = |_: &PartPlace, _: &Waypoint| Some(Assessment { clearance, quality });
        let error = best_place(&places, &waypoints, 0.0, none, &go);
        assert_eq!(error, Err(PlaceError::Assessment { place: 0, waypoint: 0 }));
    }
    assert_eq!(best_place(&places, &waypoints, 0.0, fine, &|_| Break(())), Err(PlaceError::Cancelled));
    let steps = std::sync::Mutex::new(vec![]);
    let watch = |step: curvlay_kinematics::Progress| {
        steps.lock().unwrap().push((step.done, step.total));
        Continue(())
    };
    let best = best_place(&[places[0]; 3], &[], 0.0, fine, &watch).unwrap();
    assert_eq!((best.index, best.assessments, best.min_quality), (0, 0, f64::INFINITY));
    assert_eq!(*steps.lock().unwrap(), [(0, 3), (1, 3), (2, 3)]);

    let error = representative_waypoints(&nowhere, 1, 1.0);
    assert_eq!(error, Err(PlaceError::Waypoint { index: 1 }));
    assert!(matches!(representative_waypoints(&waypoints, 1, f64::NAN), Err(PlaceError::Option { what: "lever", .. })));
    let none = representative_waypoints(&[], 5, 1.0).unwrap();
    assert!(none.waypoints.is_empty() && none.radius <= 0.0);
    assert!(representative_waypoints(&waypoints, 0, 1.0).unwrap().radius.is_infinite());
    assert_eq!(representative_waypoints(&[waypoints[0]; 4], 3, 1.0).unwrap().waypoints, [0]);
}

/// A UR3 with the part in its hand.
fn ur3() -> SixAxisWorkcell {
    let model = WorkcellModel {
        version: VERSION,
        name: "UR3".into(),
        arm: ArmPart::new(ArmGeometry::Named("UR3".into())),
        held: Held::Part,
        part: FrameModel { position_mm: [0.0, 0.0, 45.0], ..FrameModel::default() },
        nozzle: NozzleModel {
            tip_mm: [300.0, 60.0, 220.0],
            flow: [0.0, 0.0, -1.0],
            tip_flat_mm: 1.0,
            cone_half_angle_deg: 45.0,
            cone_height_mm: 8.0,
            block_diameter_mm: 20.0,
            block_top_mm: 60.0,
        },
        roller: None,
        plate: PlateModel { thickness_mm: 4.0, diameter_mm: None, size_mm: None },
        positioner: None,
        track: None,
        home_deg: None,
        controller: ControllerModel::default(),
        stand: None,
        solids: vec![],
    };
    match AnyWorkcell::new(model).unwrap() {
        AnyWorkcell::Six(cell) => cell,
        _ => panic!("not six axes"),
    }
}

/// An IRB 1200 over a table.
fn irb1200() -> EightAxisWorkcell {
    let mut model = ur3().equipment().model().clone();
    model.arm.geometry = ArmGeometry::Named("IRB1200".into());
    model.held = Held::Nozzle;
    model.part = FrameModel::default();
    (model.nozzle.tip_mm, model.nozzle.flow) = ([0.0, 0.0, 150.0], [0.0, 0.0, 1.0]);
    model.positioner = Some(PositionerPart {
        geometry: PositionerGeometry::Named("IRBP_A250".into()),
        frame: FrameModel { position_mm: [520.0, 0.0, -900.0], ..FrameModel::default() },
        limits: LimitsModel::default(),
        print_tilt_deg: [-60.0, 60.0],
        tool_angle_deg: 0.0,
    });
    match AnyWorkcell::new(model).unwrap() {
        AnyWorkcell::Eight(cell) => cell,
        _ => panic!("not eight axes"),
    }
}

/// The scene of a cell, in which the nozzle may touch the plate, with a wall beside it.
fn scene<const N: usize, const F: usize>(cell: &impl Workcell<N, F>, margin: f64, wall: f64) -> Scene {
    let mut model = cell.equipment().scene(100.0);
    model.allowed = ["nozzle", "hot end"].map(|name| [name.into(), "plate".into()]).into();
    model.bodies.push(Body {
        name: "wall".into(),
        mount: Mount::Base,
        mount_body: Isometry3::identity(),
        shape: Shape::block(Point3::new(-1000.0, wall, -1000.0), Point3::new(1000.0, wall + 50.0, 1000.0)),
    });
    Scene::new(SceneModel { margin, ..model }).unwrap()
}

/// All postures at all samples, each asked for all it is worth.
fn slow_posture<const N: usize, const F: usize>(
    cell: &impl Workcell<N, F>,
    scene: &Scene,
    limits: &JointLimits<N>,
    frees: &[[f64; F]],
    max_clearance: f64,
    waypoint: &Waypoint,
) -> Option<(f64, f64)> {
    let mut all = vec![];
    for free in frees {
        cell.solutions(waypoint, free, &mut |_, joints| {
            if limits.contains(&joints) {
                let nearest = scene.nearest(&cell.scene_posture(&joints)).unwrap().unwrap();
                let clearance = (nearest.distance - scene.margin()).min(max_clearance);
                all.push((clearance, cell.manipulability(&joints)));
            }
        });
    }
    let free = all.into_iter().filter(|(clearance, _)| *clearance > 0.0);
    free.reduce(|a, b| if b.0 > a.0 + 1e-9 || ((b.0 - a.0).abs() <= 1e-9 && b.1 > a.1) { b } else { a })
}

#[test]
fn the_best_posture_is_the_best_of_all() {
    let cell = ur3();
    let (mut none, mut tight) = (0, 0);
    // The last wall stands where the nozzle is: everything touches it.
    for (margin, wall) in [(2.0, 135.0), (0.0, 300.0), (0.0, 40.0)] {
        let scene = scene(&cell, margin, wall);
        let mut limits = *cell.limits();
        (limits.lower[2], limits.upper[2]) = (-PI, 0.5);
        let postures = BestPosture::new(&cell, &scene, [12], 8.0).unwrap().within(limits);
        let frees: Vec<[f64; 1]> = (0..12).map(|k| [TAU * f64::from(k) / 12.0]).collect();
        for (k, y) in [(0, -60.0), (1, -20.0), (2, 0.0), (3, 40.0), (4, 90.0), (5, 160.0)] {
            let axis = UnitVector3::new_normalize(Vector3::new(0.3 * f64::from(k % 3), 0.2, 1.0));
            let waypoint = Waypoint {
                position: Point3::new(10.0, y, if k == 5 { 900.0 } else { 20.0 + 70.0 * f64::from(k) }),
                axis,
            };
            let found = postures.find(&waypoint);
            let expected = slow_posture(&cell, &scene, &limits, &frees, 8.0, &waypoint);
            match (found, expected) {
                (Some((found, joints)), Some((clearance, quality))) => {
                    assert!((found.clearance - clearance).abs() < 1e-6, "{found:?} {clearance}");
                    assert!((found.quality / quality - 1.0).abs() < 1e-6, "{found:?} {quality}");
                    assert!(limits.contains(&joints));
                    let at = cell.nozzle_on_part(&joints).unwrap().translation.vector;
                    assert!((at - waypoint.position.coords).norm() < 1e-5);
                    assert_eq!(postures.assess(&waypoint), Some(found));
                    tight += usize::from(clearance < 7.9);
                }
                (None, None) => none += 1,
                other => panic!("{other:?}"),
            }
        }
    }
    assert!(none > 0 && tight > 0, "{none} {tight}");
}

#[test]
fn a_table_is_tilted_from_end_to_end() {
    let cell = irb1200();
    let scene = scene(&cell, 0.0, 900.0);
    let postures = BestPosture::new(&cell, &scene, [3, 4], 5.0).unwrap();
    let third = PI / 3.0;
    let frees: Vec<[f64; 2]> =
        (0..12).map(|k| [-third + third * f64::from(k % 3), TAU * f64::from(k / 3) / 4.0]).collect();
    let level = BestPosture::new(&cell, &scene, [1, 4], 5.0).unwrap();
    for lean in [0.0, 0.6, 1.4] {
        let axis = UnitVector3::new_normalize(Vector3::new(0.0, lean, 1.0));
        let waypoint = Waypoint { position: Point3::new(0.0, 20.0, 40.0), axis };
        for (postures, frees) in [(&postures, frees.clone()), (&level, frees[1..].iter().step_by(3).copied().collect())]
        {
            let (found, _) = postures.find(&waypoint).unwrap();
            let (clearance, quality) = slow_posture(&cell, &scene, cell.limits(), &frees, 5.0, &waypoint).unwrap();
            assert!((found.clearance - clearance).abs() < 1e-6 && (found.quality / quality - 1.0).abs() < 1e-6);
        }
    }
    assert!(matches!(
        BestPosture::new(&cell, &scene, [3, 0], 5.0).map(drop),
        Err(PlaceError::Option { what: "samples", .. })
    ));
    assert!(matches!(
        BestPosture::new(&cell, &scene, [3, 1], 0.0).map(drop),
        Err(PlaceError::Option { what: "max_clearance", .. })
    ));
}

/// A part that is out of reach in places: moved on its plate it is not.
#[test]
fn a_print_is_moved_into_reach() {
    let cell = ur3();
    let scene = scene(&cell, 2.0, 400.0);
    let postures = BestPosture::new(&cell, &scene, [12], 5.0).unwrap();
    // A ring far beside the middle of the plate, leaning outwards.
    let print: Vec<Waypoint> = (0..2000)
        .map(|k| {
            let (sin, cos) = (TAU * f64::from(k % 100) / 100.0).sin_cos();
            let axis = UnitVector3::new_normalize(Vector3::new(0.8 * cos, 0.8 * sin, 1.0));
            let height = 150.0 * f64::from(k) / 2000.0;
            Waypoint { position: Point3::new(500.0 + 40.0 * cos, 400.0 + 40.0 * sin, height), axis }
        })
        .collect();
    let few = representative_waypoints(&print, 25, 150.0).unwrap();
    let few: Vec<Waypoint> = few.waypoints.iter().map(|&index| print[index]).collect();
    let places = place_grid(800.0, 4, 1).unwrap();
    let assess = |_: &PartPlace, at: &Waypoint| postures.assess(at);
    let middle = best_place(&places[..1], &few, 2.0, assess, &|_| Continue(())).unwrap();
    let best = best_place(&places, &few, 2.0, assess, &|_| Continue(())).unwrap();
    assert!(!middle.unreachable.is_empty(), "{middle:?}");
    assert!(best.unreachable.is_empty() && best.tight.is_empty(), "{best:?}");
    assert!(best.assessments < (places.len() * few.len()) as u64);
}

/// Every waypoint at every place, counted one by one.
#[test]
fn a_print_stands_where_the_fewest_waypoints_are_bad() {
    let cell = irb1200();
    let print: Vec<Waypoint> =
        [(0.0, 0.0, 5.0), (40.0, 0.0, 5.0), (20.0, 30.0, 160.0)].map(|(x, y, z)| upright(x, y, z)).into();
    let options = PlateOptions { steps: 2, comfortable_mm: 3.0, rim_mm: 1.0, ..PlateOptions::new([3, 4]) };
    let found = place_on_plate(&cell, &print, 700.0, &options, &|_| Continue(())).unwrap();

    let middle = Isometry3::translation(-20.0, -10.0, 0.0);
    assert!(
        (centred_on_plate(print.iter().map(|at| &at.position)).translation.vector - middle.translation.vector).norm()
            < 1e-12
    );
    let mut model = cell.equipment().scene(700.0);
    model.allowed = ["nozzle", "hot end"].map(|name| [name.into(), "plate".into()]).into();
    let scene = Scene::new(SceneModel { margin: options.margin_mm, ..model }).unwrap();
    let at = |range: FreeRange, k: u32, count: u32| match range {
        FreeRange::Turn => TAU * f64::from(k) / f64::from(count),
        FreeRange::Within(min, max) => min + (max - min) * f64::from(k) / f64::from(count - 1),
    };
    let [tilt, turn] = cell.free();
    let frees: Vec<[f64; 2]> = (0..3).flat_map(|i| (0..4).map(move |k| [at(tilt, i, 3), at(turn, k, 4)])).collect();
    let plate_mm = cell.equipment().plate_diameter_mm(700.0);
    let wide = print.iter().map(|at| (middle * at.position).coords.xy().norm()).fold(0.0, f64::max);
    let places = place_grid((plate_mm / 2.0 - wide - 1.0).max(0.0), 2, 1).unwrap();
    let bad = |place: &PartPlace| {
        let worth = print.iter().map(|at| {
            let position = place.pose() * middle * at.position;
            slow_posture(&cell, &scene, cell.limits(), &frees, 3.0, &Waypoint { position, ..*at })
        });
        let worth: Vec<_> = worth.collect();
        let none = worth.iter().filter(|worth| worth.is_none()).count();
        (none, worth.iter().flatten().filter(|worth| worth.0 < 3.0).count())
    };
    // Of the best ones the first: they go outwards.
    let best = places.iter().min_by_key(|place| bad(place)).unwrap();
    assert!(places.iter().any(|place| bad(place) > bad(best)));
    let expected = best.pose() * middle;
    assert!((found.translation.vector - expected.translation.vector).norm() < 1e-9, "{found} {expected}");
    let none = PlateOptions { samples: [0, 1], ..options };
    assert!(matches!(
        place_on_plate(&cell, &print, 700.0, &none, &|_| Continue(())),
        Err(PlateError::Place(PlaceError::Option { what: "samples", .. }))
    ));
    assert_eq!(
        place_on_plate(&cell, &print, 700.0, &options, &|_| Break(())),
        Err(PlateError::Place(PlaceError::Cancelled))
    );
}
