//! Where nozzles, fixtures and parts stand.

use super::numbers::{bad, count, each_spoilt, go, limits, number, point, pose, waypoint};
use crate::common::cells::{over_table, ur3};
use crate::common::{ROBOTS, arm};
use curvlay_kinematics::nalgebra::{Isometry3, Point3};
use curvlay_kinematics::scene::{Scene, SceneModel};
use curvlay_kinematics::workcell::Workcell;
use curvlay_kinematics::*;
use proptest::prelude::*;

const REGION: [fn(&mut FixtureRegion, f64); 4] = [
    |region, value| region.min.x = value,
    |region, value| region.max.z = value,
    |region, value| region.coarse_mm = value,
    |region, value| region.fine_mm = value,
];
const PLATE: [fn(&mut PlateOptions<1>, f64); 5] = [
    |options, value| options.stop_margin = value,
    |options, value| options.margin_mm = value,
    |options, value| options.comfortable_mm = value,
    |options, value| options.rim_mm = value,
    |options, value| options.lever_mm = value,
];

fn assessment() -> impl Strategy<Value = Option<Assessment>> {
    prop::option::of((number(), number()).prop_map(|(clearance, quality)| Assessment { clearance, quality }))
}

fn feed_postures<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    waypoint: &Waypoint,
    limits: JointLimits<N>,
    clearance: f64,
    samples: u32,
) {
    let scene = Scene::new(SceneModel::of(*cell.equipment().arm())).unwrap();
    for (samples, clearance) in [(3, 10.0), (samples, clearance)] {
        let Ok(postures) = BestPosture::new(cell, &scene, [samples; F], clearance) else { continue };
        let _ = (postures.assess(waypoint), postures.find(waypoint));
        let _ = postures.within(limits).find(waypoint);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn boxes_take_anything(points in prop::collection::vec(point(), 0..30), envelope in [number(), number(), number()], frame in pose(), count in count(), rise in number(), robot in 0..6usize) {
        for envelope in [envelope, [100.0; 3], [0.0; 3]] {
            if let Ok(placement) = fullest_box(&points, envelope, &go) {
                prop_assert!(placement.frames > 0);
            }
        }
        let arm = arm(ROBOTS[robot].1);
        // Ten million samples are allowed.
        let samples = if count > 10_000_000 { count } else { count.min(40) };
        for frame in [frame, Isometry3::identity()] {
            let _ = reachable_points(&arm, &frame, &ReachOptions { samples, min_rise: rise }, |joints, frame| joints[0] > frame.translation.x);
        }
    }

    #[test]
    fn places_take_anything(waypoints in prop::collection::vec(waypoint(), 0..6), answers in prop::collection::vec(assessment(), 1..9), value in bad(), clearance in number(), counts in [0..4u32, 0..4u32], places in prop::collection::vec((number(), number(), number()), 0..4), count in count()) {
        let sound = FixtureRegion { min: Point3::new(-50.0, -50.0, 0.0), max: Point3::new(50.0, 50.0, 40.0), coarse_mm: 25.0, fine_mm: 10.0 };
        for region in each_spoilt(&sound, &REGION, value) {
            let mut turn = 0;
            let mut next = || { turn += 1; answers[turn % answers.len()] };
            let found = best_fixture_place(&region, &waypoints, clearance, |at| {
                let (first, x) = (next(), at.x);
                (x < 20.0).then_some(move |number: usize, _: &Waypoint| first.filter(|_| number.is_multiple_of(2)))
            }, &go);
            prop_assert!(found.is_err() || found.is_ok_and(|found| found.places > 0));
        }
        let [steps, turns] = counts;
        let huge = [(3.0, u32::MAX, 1), (3.0, 1, u32::MAX), (3.0, 1 << 16, 1 << 16)];
        let mut all: Vec<PartPlace> = places.into_iter().map(|(x, y, turn)| PartPlace { offset: [x, y], turn }).collect();
        for (offset, steps, turns) in [(10.0, steps, turns), (value, steps, turns), (clearance, 1, 1)].into_iter().chain(huge) {
            all.extend(place_grid(offset, steps, turns).unwrap_or_default().into_iter().take(9));
        }
        for place in &all {
            place.pose();
            waypoints.iter().for_each(|at| _ = place.waypoint(at));
        }
        for places in [&all[..], &all[..all.len() / 2], &[PartPlace::default()], &[]] {
            let mut turn = 0;
            let _ = best_place(places, &waypoints, clearance, |_, _| { turn += 1; answers[turn % answers.len()] }, &go);
        }
        centred_on_plate(waypoints.iter().map(|at| &at.position));
        for lever in [150.0, value, clearance] {
            if let Ok(found) = representative_waypoints(&waypoints, count, lever) {
                prop_assert!(found.waypoints.iter().all(|&at| at < waypoints.len()));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn plates_and_postures_take_anything(waypoints in prop::collection::vec(waypoint(), 0..3), value in bad(), wanted in number(), limits in limits::<6>(), table in limits::<8>(), count in count(), huge in prop::sample::select(vec![0, 1, u32::MAX])) {
        let (cell, eight) = (ur3(), over_table());
        let sound = PlateOptions { representatives: 2, steps: 1, turns: 2, ..PlateOptions::new([3]) };
        let more = [PlateOptions { samples: [huge], ..sound }, PlateOptions { steps: huge, ..sound }, PlateOptions { turns: huge, ..sound }, PlateOptions { representatives: count, ..sound }];
        for options in each_spoilt(&sound, &PLATE, value).into_iter().chain(more) {
            let _ = place_on_plate(&cell, &waypoints, 100.0, &options, &go);
        }
        for wanted in [wanted, value] {
            let _ = place_on_plate(&cell, &waypoints, wanted, &sound, &go);
            let _ = place_on_plate(&eight, &waypoints, wanted, &PlateOptions { representatives: 1, steps: 1, turns: 1, ..PlateOptions::new([2, 2]) }, &go);
        }
        for waypoint in waypoints.iter().take(1) {
            feed_postures(&cell, waypoint, limits, value, huge);
            feed_postures(&eight, waypoint, table, value, huge.min(2));
        }
    }
}
