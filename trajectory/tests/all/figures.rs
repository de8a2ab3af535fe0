//! The planners on real and synthetic tool paths, for a UR3 that holds the part.

use crate::common::quiet;
use crate::common::ur3::{STEP, Ur3, read};
use curvlay_trajectory::{
    Bounds, FilterOptions, GlobalOptions, GlobalStatus, Ladder, LadderError, LadderOptions, LadderSearch, PathOptions,
    Quantity, RunIn, Timeline, Timing, filter_locally, plan_ladder, smooth_globally, timed_path,
};

fn grid(search: LadderSearch, samples: u32) -> LadderOptions<6, 1> {
    LadderOptions { samples: [samples], doublings: 0, search, ..LadderOptions::default() }
}

fn assert_met(robot: &Ur3, ladder: &Ladder<6, 1>) {
    for (node, waypoint) in ladder.nodes.iter().zip(&robot.waypoints) {
        let nozzle = robot.cell.nozzle_on_part(&node.joints);
        assert!((nozzle.translation.vector - waypoint.position.coords).norm() <= 1e-6);
        let axis = nozzle.rotation * curvlay_trajectory::nalgebra::Vector3::z();
        assert!(axis.cross(&waypoint.axis).norm() <= 1e-9 && axis.dot(&waypoint.axis) > 0.0);
    }
}

#[test]
#[ignore = "needs ../shared/waypoints; .ci/run runs it where that folder exists"]
fn synthetic_paths_are_one_piece_and_smoothed() {
    for name in ["syn_dev_smooth_2545.txt", "syn_dev_2545.txt"] {
        let path = read(name);
        let times: Vec<f64> = (0..path.len()).map(|k| STEP * k as f64).collect();
        let (positions, normals): (Vec<_>, Vec<_>) = path.iter().copied().unzip();
        let timed = timed_path(&positions, &normals, Timing::Given(&times), &PathOptions::default()).unwrap();
        assert_eq!((timed.segments.len(), timed.defects.len()), (1, 0), "{:?}", timed.defects);
        let robot = Ur3::new(&path[..600]);
        let (times, bounds) = (robot.times(), robot.bounds());
        let ladder = plan_ladder(&robot, &times, &bounds, &LadderOptions::default(), &quiet).unwrap();
        assert_met(&robot, &ladder);
        let (exact, fast) = (grid(LadderSearch::Exact, 90), grid(LadderSearch::CoarseToFine, 90));
        let (least, near) = (
            plan_ladder(&robot, &times, &bounds, &exact, &quiet).unwrap(),
            plan_ladder(&robot, &times, &bounds, &fast, &quiet).unwrap(),
        );
        assert_met(&robot, &least);
        assert!(
            near.cost >= least.cost * (1.0 - 1e-9) && near.cost <= 1.01 * least.cost,
            "{} {}",
            near.cost,
            least.cost
        );
        let filter = FilterOptions { iterations: 25, ..FilterOptions::default() };
        let local = filter_locally(&robot, &times, &ladder.nodes, &bounds, &filter, &quiet).unwrap();
        assert!(local.jerk[1] <= local.jerk[0]);
    }
}

#[test]
#[ignore = "needs ../shared/waypoints; .ci/run runs it where that folder exists"]
fn the_defects_of_published_paths_are_found() {
    let names = ["bunnyHead_10200", "freeform_10", "model_1_16", "simple_curve_10", "topology_2200S", "yoga_26300"];
    let mut all = [0; 2];
    for name in names {
        let path = read(&format!("maxis_{name}.txt"));
        let (positions, normals): (Vec<_>, Vec<_>) = path.iter().copied().unzip();
        let timed = timed_path(&positions, &normals, Timing::Feed(5.0), &PathOptions::default()).unwrap();
        let kept: usize = timed.segments.iter().map(|piece| piece.waypoints.len()).sum();
        assert!(kept > path.len() * 9 / 10, "{kept} of {}", path.len());
        all[0] += timed.segments.len();
        all[1] += timed.defects.len();
    }
    assert!(all[0] > names.len() && all[1] > 0);
}

#[test]
#[ignore = "needs ../shared/waypoints; .ci/run runs it where that folder exists"]
fn a_crest_taken_at_speed_goes_another_way_round_and_names_what_no_path_nearby_holds() {
    let path = read("syn_dev_2545.txt");
    // The middle of the spiral, where the tool once turned the wrong way round at 1.1 rad/s.
    let robot = Ur3::new(&path);
    let robot = Ur3 { waypoints: robot.waypoints[1150..1480].to_vec(), ..robot };
    let (times, bounds) = (robot.times(), robot.bounds());
    let line = Timeline::new(&times, RunIn::default()).unwrap();
    let unhurried = Bounds { velocity: [f64::INFINITY; 6], ..bounds };
    let start = plan_ladder(&robot, &times, &unhurried, &LadderOptions::default(), &quiet).unwrap().nodes;
    let options = GlobalOptions { lower_peak: false, ..GlobalOptions::default() };
    let found = smooth_globally(&robot, &line, &start, &bounds, &options, &quiet).unwrap();
    assert_eq!(found.status, GlobalStatus::BoundsMissed);
    for extremes in found.trajectory.extremes() {
        assert!(extremes.velocity.value.abs() < 1.001, "{extremes:?}");
    }
    let missed = found.missed.unwrap();
    assert!(missed.total < 1.1 && missed.lower_bound > 0.9 * missed.total, "{missed:?}");
    // Bounds that the way allows are held.
    let wider = Bounds { acceleration: [12.0; 6], ..bounds };
    let held = smooth_globally(&robot, &line, &start, &wider, &options, &quiet).unwrap();
    assert!(held.missed.is_none() && held.violations.iter().all(|violation| violation.quantity == Quantity::Jerk));
    assert!(held.trajectory.squared_jerk() < found.trajectory.squared_jerk());
}

#[test]
#[ignore = "needs ../shared/waypoints; .ci/run runs it where that folder exists"]
fn the_step_that_speeds_do_not_allow_is_named() {
    let path = read("syn_dev_4681.txt");
    let robot = Ur3::new(&path);
    // Around waypoint 32 a joint has to move at 1.045 rad/s at least, on any branch and at any tool angle.
    let robot = Ur3 { waypoints: robot.waypoints[26..38].to_vec(), ..robot };
    let found = plan_ladder(&robot, &robot.times(), &robot.bounds(), &grid(LadderSearch::Exact, 1024), &quiet);
    let Err(LadderError::NoPath { waypoint: 6, samples: 1024, needed }) = found else { panic!("{found:?}") };
    assert!((1.0..1.1).contains(&needed), "{needed}");
    let faster = Bounds { velocity: [1.05; 6], ..robot.bounds() };
    plan_ladder(&robot, &robot.times(), &faster, &grid(LadderSearch::Exact, 1024), &quiet).unwrap();
}
