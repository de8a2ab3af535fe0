//! The global filter where more than the tool angle is free: a UR3 with a tilt cone, and eight axes.

use crate::common::quiet;
use crate::common::tilt::{Table, Tilting};
use crate::common::ur3::{STEP, Ur3};
use curvlay_trajectory::nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use curvlay_trajectory::{
    Bounds, Cone, FreeRange, GlobalOptions, GlobalStatus, LadderNode, LadderOptions, LadderSearch, Robot, RobotFn,
    RunIn, Timeline, plan_ladder, smooth_globally,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

type Path = Vec<(Point3<f64>, Vector3<f64>)>;

/// Normals turned by up to `most` radians, each its own way.
fn noisy(path: &Path, most: f64) -> Path {
    let mut rng = Pcg64::seed_from_u64(14);
    let turn = |(p, n): &(Point3<f64>, Vector3<f64>)| {
        let any = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let turn = UnitQuaternion::from_axis_angle(&Unit::new_normalize(n.cross(&any)), rng.random_range(0.0..most));
        (*p, turn * n)
    };
    path.iter().map(turn).collect()
}

fn line(count: usize) -> Timeline {
    Timeline::new(&(0..count).map(|k| STEP * k as f64).collect::<Vec<_>>(), RunIn::default()).unwrap()
}

fn ladder(robot: &Ur3) -> Vec<LadderNode<6, 1>> {
    let options = LadderOptions { samples: [32], search: LadderSearch::CoarseToFine, ..LadderOptions::default() };
    plan_ladder(robot, &robot.times(), &robot.bounds(), &options, &quiet).unwrap().nodes
}

/// Waypoints without tilt.
fn upright(nodes: &[LadderNode<6, 1>]) -> Vec<LadderNode<6, 3>> {
    nodes.iter().map(|r| LadderNode { joints: r.joints, free: [r.free[0], 0.0, 0.0], branch: r.branch }).collect()
}

#[test]
fn a_cone_smooths_noisy_normals_and_is_kept() {
    let dome = Ur3::dome(150);
    let path: Path = dome.waypoints.iter().map(|w| (w.position, w.axis.into_inner())).collect();
    let (half_angle, count) = (10f64.to_radians(), path.len());
    let robot = Ur3::new(&noisy(&path, half_angle));
    let (start, line) = (ladder(&robot), line(count));
    let options = GlobalOptions { lower_peak: false, ..GlobalOptions::default() };
    let plain = smooth_globally(&robot, &line, &start, &Bounds::NONE, &options, &quiet).unwrap();
    let tilting = Tilting { robot };
    tilting.check_rates(7, &[0.4, 0.1, -0.07], start[7].branch);
    let with = GlobalOptions { cone: Some(Cone { tilts: [1, 2], half_angle }), ..options };
    let found = smooth_globally(&tilting, &line, &upright(&start), &Bounds::NONE, &with, &quiet).unwrap();
    assert!(found.trajectory.squared_jerk() < 0.1 * plain.trajectory.squared_jerk());
    for (node, waypoint) in found.nodes.iter().zip(&tilting.robot.waypoints) {
        let nozzle = tilting.robot.cell.nozzle_on_part(&node.joints);
        assert!((nozzle.translation.vector - waypoint.position.coords).norm() < 1e-6);
        assert!((nozzle.rotation * Vector3::z()).angle(&waypoint.axis) < half_angle + 1e-9);
        assert!(node.free[1].hypot(node.free[2]) < half_angle + 1e-12);
    }
}

#[test]
fn eight_axes_are_smoother_than_six() {
    let dome = Ur3::dome(150);
    let robot = Table::new(&dome.waypoints);
    let (start, line) = (robot.level_start(), line(150));
    robot.check_rates(11, &start[11].free, start[11].branch);
    let options = GlobalOptions { lower_peak: false, ..GlobalOptions::default() };
    let found = smooth_globally(&robot, &line, &start, &robot.bounds(), &options, &quiet).unwrap();
    assert!(found.status != GlobalStatus::BoundsMissed, "{:?}", found.violations);
    let held = smooth_globally(&robot.with_fixed_table(), &line, &start, &robot.bounds(), &options, &quiet).unwrap();
    assert!(found.trajectory.squared_jerk() < 0.9 * held.trajectory.squared_jerk());
}

#[test]
fn a_cone_takes_the_noise_out_of_a_whole_layer() {
    // What the dissertation's filter cannot do (Fig. 4.14): the greatest jerk stays within its bound for normals with 10
    // degrees of noise.
    let dome = Ur3::dome(400);
    let path: Path = dome.waypoints.iter().map(|w| (w.position, w.axis.into_inner())).collect();
    let half_angle = 10f64.to_radians();
    let robot = Ur3::new(&noisy(&path, half_angle));
    let (line, bounds) = (line(path.len()), robot.bounds());
    let unhurried = Bounds { velocity: [f64::INFINITY; 6], ..bounds };
    let start = plan_ladder(&robot, &robot.times(), &unhurried, &LadderOptions::default(), &quiet).unwrap().nodes;
    let tilting = Tilting { robot };
    // The squared jerk falls to a hundred thousandth; for a low peak it may rise to twice that.
    let cone = Some(Cone { tilts: [1, 2], half_angle });
    let options = GlobalOptions { cone, rise: 1.0, ..GlobalOptions::default() };
    let found = smooth_globally(&tilting, &line, &upright(&start), &bounds, &options, &quiet).unwrap();
    assert!(found.violations.is_empty(), "{:?} {:?} {:?}", found.status, found.peak, found.violations);
    for (node, waypoint) in found.nodes.iter().zip(&tilting.robot.waypoints) {
        let nozzle = tilting.robot.cell.nozzle_on_part(&node.joints);
        assert!((nozzle.translation.vector - waypoint.position.coords).norm() < 1e-6);
        assert!((nozzle.rotation * Vector3::z()).angle(&waypoint.axis) < half_angle + 1e-9);
    }
}

#[test]
fn steps_beyond_the_range_of_a_parameter_stop_at_its_end() {
    // The table may tilt by 0.25 rad: from level no row foresees a step beyond.
    let dome = Ur3::dome(60);
    let robot = Table::new(&dome.waypoints);
    let (start, line) = (robot.level_start(), line(60));
    let options = GlobalOptions { lower_peak: false, ..GlobalOptions::default() };
    let range = FreeRange::Within(-0.25, 0.25);
    let narrow = RobotFn {
        waypoints: 60,
        free: [FreeRange::Turn, range, range],
        solutions: |i: usize, free: &[f64; 3], each: &mut dyn FnMut(u32, [f64; 8])| robot.solutions(i, free, each),
        posture: |i: usize, free: &[f64; 3], branch: u32| robot.posture(i, free, branch),
    };
    let found = smooth_globally(&narrow, &line, &start, &Bounds::NONE, &options, &quiet).unwrap();
    let most = found.nodes.iter().map(|node| node.free[1].abs()).fold(0.0, f64::max);
    assert!(most <= 0.25, "{most}");
    assert!(found.trajectory.squared_jerk() < 0.9 * found.squared_jerk[0]);
}
