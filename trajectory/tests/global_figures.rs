//! Figures of the global filter on tool paths: the UR3 of the other tests, the same with a tilt cone, and eight axes.
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests

mod common;

use common::quiet;
use common::tilt::{Table, Tilting};
use common::ur3::{STEP, Ur3, read};
use curvlay_trajectory::nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use curvlay_trajectory::{
    Bounds, Cone, GlobalMotion, GlobalOptions, GlobalStatus, LadderOptions, LadderSearch, RunIn, Rung, Timeline,
    jerk_measure, plan_ladder, smooth_globally,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::time::Instant;

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

fn ladder(robot: &Ur3) -> Vec<Rung<6, 1>> {
    let options = LadderOptions { samples: [32], search: LadderSearch::CoarseToFine, ..LadderOptions::default() };
    let bounds = robot.bounds();
    // Where crests are too sharp for the speed, a path without bounds on it is still a start.
    let quick = Bounds { velocity: [f64::INFINITY; 6], ..bounds };
    let found = plan_ladder(robot, &robot.times(), &bounds, &options, &quiet);
    found.or_else(|_| plan_ladder(robot, &robot.times(), &quick, &options, &quiet)).unwrap().rungs
}

fn tell<const N: usize, const F: usize>(what: &str, seconds: f64, found: &GlobalMotion<N, F>) {
    let q: Vec<_> = found.rungs.iter().map(|rung| rung.joints).collect();
    let times: Vec<f64> = (0..q.len()).map(|k| STEP * k as f64).collect();
    println!(
        "{what}: {seconds:.2} s, {:?}, J {:.2}, integral {:.3?} -> {:.3}, peak {:.3?}, rounds {:?}, steep {}",
        found.status,
        jerk_measure(&times, &q),
        found.squared_jerk,
        found.trajectory.squared_jerk(),
        found.peak,
        found.rounds,
        found.steep.len(),
    );
    for violation in &found.violations {
        println!("    {violation}");
    }
}

/// Rungs without tilt.
fn upright(rungs: &[Rung<6, 1>]) -> Vec<Rung<6, 3>> {
    rungs.iter().map(|r| Rung { joints: r.joints, free: [r.free[0], 0.0, 0.0], branch: r.branch }).collect()
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
    tell("no cone", 0.0, &plain);
    tell("cone", 0.0, &found);
    assert!(found.trajectory.squared_jerk() < 0.1 * plain.trajectory.squared_jerk());
    for (rung, waypoint) in found.rungs.iter().zip(&tilting.robot.waypoints) {
        let nozzle = tilting.robot.cell.nozzle_on_part(&rung.joints);
        assert!((nozzle.translation.vector - waypoint.position.coords).norm() < 1e-6);
        assert!((nozzle.rotation * Vector3::z()).angle(&waypoint.axis) < half_angle + 1e-9);
        assert!(rung.free[1].hypot(rung.free[2]) < half_angle + 1e-12);
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
    tell("eight axes", 0.0, &found);
    assert!(found.status != GlobalStatus::BoundsMissed, "{:?}", found.violations);
    let held = smooth_globally(&robot.with_fixed_table(), &line, &start, &robot.bounds(), &options, &quiet).unwrap();
    tell("table at rest", 0.0, &held);
    assert!(found.trajectory.squared_jerk() < 0.9 * held.trajectory.squared_jerk());
}

/// `cargo test --release -p curvlay-trajectory --test global_figures -- --ignored --nocapture`
#[test]
#[ignore = "prints times; run it with --release"]
fn figures() {
    for name in ["smooth_2545", "smooth_4681", "2545", "4681"] {
        let Some(path) = read(&format!("syn_dev_{name}.txt")) else { return };
        let robot = Ur3::new(&path);
        let line = line(path.len());
        let clock = Instant::now();
        let start = ladder(&robot);
        let seconds = clock.elapsed().as_secs_f64();
        let q: Vec<_> = start.iter().map(|rung| rung.joints).collect();
        println!("{name}: ladder {seconds:.2} s, J {:.2}", jerk_measure(&robot.times(), &q));
        for lower_peak in [false, true] {
            let options = GlobalOptions { lower_peak, ..GlobalOptions::default() };
            let clock = Instant::now();
            let found = smooth_globally(&robot, &line, &start, &robot.bounds(), &options, &quiet).unwrap();
            tell(&format!("{name}, peak lowered {lower_peak}"), clock.elapsed().as_secs_f64(), &found);
        }
    }
}

/// The same; the noise study of Fig. 4.14 with and without a cone as wide as the noise.
#[test]
#[ignore = "prints times; run it with --release"]
fn noise() {
    let Some(path) = read("syn_dev_smooth_2545.txt") else { return };
    for degrees in [5.0f64, 10.0, 15.0] {
        let robot = Ur3::new(&noisy(&path, degrees.to_radians()));
        let (start, line, bounds) = (ladder(&robot), line(path.len()), robot.bounds());
        let clock = Instant::now();
        let plain = GlobalOptions { lower_peak: false, ..GlobalOptions::default() };
        let found = smooth_globally(&robot, &line, &start, &bounds, &plain, &quiet).unwrap();
        tell(&format!("{degrees} degrees"), clock.elapsed().as_secs_f64(), &found);
        let tilting = Tilting { robot };
        let cone = Some(Cone { tilts: [1, 2], half_angle: degrees.to_radians() });
        let options = GlobalOptions { cone, ..GlobalOptions::default() };
        let clock = Instant::now();
        let found = smooth_globally(&tilting, &line, &upright(&start), &bounds, &options, &quiet).unwrap();
        tell(&format!("{degrees} degrees, cone"), clock.elapsed().as_secs_f64(), &found);
    }
}
