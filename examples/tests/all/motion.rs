//! The cells of the examples, and what is said of their motions.

use curvlay_examples::motion::programs::{full_scale, pieces};
use curvlay_examples::motion::{OnCell, PartInHand, STEP_S, Studied, bounds_of, dissertation_cells};
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use curvlay_kinematics::workcell::Workcell;
use curvlay_trajectory::print::{LegKind, PlanTimes, PrintPlan, PrintRobot, Run, Travel, Waypoint, path_deviations};
use curvlay_trajectory::transfer::Transfer;
use curvlay_trajectory::{Bounds, Robot, RunIn, Timeline, Trajectory};
use std::f64::consts::TAU;
use std::ops::Range;

/// A signal of the filament uses at least two fifths of its range.
#[test]
fn the_range_of_the_filament_holds_the_print() {
    let known = [(0.9, 1.0), (1.0, 1.0), (1.01, 2.0), (3.0, 5.0), (7.5, 10.0), (10.0, 10.0), (0.03, 0.05), (0.0, 20.0)];
    for (mm_s, scale) in known {
        assert!(
            (full_scale(mm_s) - scale).abs() < 1e-12 * scale && full_scale(mm_s) >= mm_s,
            "{mm_s}: {}",
            full_scale(mm_s)
        );
    }
    for k in 1..2000 {
        let mm_s = 0.01 * f64::from(k);
        assert!((0.4..=1.0).contains(&(mm_s / full_scale(mm_s))), "{mm_s}");
    }
}

/// A bent line over the flange, with turning directions.
fn line(count: usize) -> Vec<Waypoint> {
    let at = |k: usize| {
        let along = k as f64 / count as f64;
        let axis = UnitVector3::new_normalize(Vector3::new(0.4 * (5.0 * along).sin(), 0.2 * along, 1.0));
        Waypoint { position: Point3::new(30.0 * along - 15.0, 8.0 * (3.0 * along).cos(), 20.0), axis }
    };
    (0..count).map(at).collect()
}

/// The motion through the postures on these branches, at one tool angle, without whole turns.
fn motion(robot: &PartInHand, branches: &[u32]) -> Trajectory<6> {
    let times: Vec<f64> = (0..branches.len()).map(|k| STEP_S * k as f64).collect();
    let mut joints: Vec<[f64; 6]> = Vec::new();
    for (k, &branch) in branches.iter().enumerate() {
        let found = Robot::posture(robot, k, &[0.3], branch).unwrap().joints;
        let before = joints.last().copied().unwrap_or(found);
        joints.push(std::array::from_fn(|j| found[j] + TAU * ((before[j] - found[j]) / TAU).round()));
    }
    Trajectory::through(&Timeline::new(&times, RunIn::default()).unwrap(), &joints).unwrap()
}

#[test]
fn how_far_a_nozzle_strays_is_what_a_thousand_looks_find() {
    let robot = OnCell::new(dissertation_cells().unwrap().0, line(12));
    let branch = (0..8).find(|&branch| (0..12).all(|k| Robot::posture(&robot, k, &[0.3], branch).is_some())).unwrap();
    let trajectory = motion(&robot, &[branch; 12]);
    let found = path_deviations(&robot, robot.path(), &trajectory, &trajectory.times()[trajectory.waypoints()], 0.0);
    assert_eq!(found.len(), 11);
    for (step, found) in found.iter().enumerate() {
        let [from, to] = [step, step + 1].map(|k| robot.path()[k].position);
        let nearest = |tip: Point3<f64>| {
            (0..=1000)
                .map(|k| (from + (to - from) * (f64::from(k) / 1000.0) - tip).norm())
                .fold(f64::INFINITY, f64::min)
        };
        let at = |k: u32| {
            let joints = trajectory.at(STEP_S * (step as f64 + f64::from(k) / 1000.0)).position;
            nearest(robot.nozzle(&joints).unwrap().translation.vector.into())
        };
        let slow = (0..=1000).map(at).fold(0.0, f64::max);
        assert!(*found <= slow + 0.01 && *found >= 0.9 * slow - 0.01, "step {step}: {found} {slow}");
        assert!(slow < 1.0, "{slow}");
    }
}

#[test]
fn an_arm_that_turns_over_between_two_waypoints_strays() {
    let robot = OnCell::new(dissertation_cells().unwrap().0, line(12));
    let on: Vec<u32> =
        (0..8).filter(|&branch| (0..12).all(|k| Robot::posture(&robot, k, &[0.3], branch).is_some())).collect();
    let mut branches = [on[0]; 12];
    branches[6..].fill(on[1]);
    let trajectory = motion(&robot, &branches);
    for (k, joints) in trajectory.at_waypoints().iter().enumerate() {
        assert!(robot.missed(k, joints).0 < 1e-9);
    }
    assert!(
        path_deviations(&robot, robot.path(), &trajectory, &trajectory.times()[trajectory.waypoints()], 0.0)[5] > 10.0
    );
}

/// Four runs on a line with travels between them; the third travel was not found.
fn plan() -> PrintPlan<6, 1> {
    let line = Timeline::new(&[0.0, 1.0, 2.0], RunIn::default()).unwrap();
    let to = |angle: f64| Trajectory::through(&line, &[0.0, 0.5, 1.0].map(|share| [angle * share; 6])).unwrap();
    let waypoint = line_of_one();
    let run = |path: usize| Run {
        path,
        layer: path as u32,
        trajectory: to(0.1 * (path + 1) as f64),
        passes: Vec::new(),
        filament_mm: Vec::new(),
        ends: [([0.0], waypoint), ([0.0], waypoint)],
    };
    let bounds = bounds_of(dissertation_cells().unwrap().0.limits());
    let limits = Bounds { acceleration: [5.0; 6], jerk: [50.0; 6], ..bounds };
    let way = Transfer::through(vec![[0.0; 6], [0.2; 6]], &limits).unwrap();
    let travel = || Some(Travel { lift: to(0.01), way: way.clone(), approach: to(0.02) });
    PrintPlan {
        runs: (0..4).map(run).collect(),
        travels: vec![travel(), travel(), None],
        homes: Vec::new(),
        faults: Vec::new(),
        layers: Vec::new(),
        max_missed_mm: 0.0,
        max_deviation_mm: 0.0,
        min_pace: 1.0,
        slow_runs: 0,
        planned_s: 0.0,
        printing_s: 0.0,
        times: PlanTimes::default(),
    }
}

fn line_of_one() -> Waypoint {
    line(1)[0]
}

/// Motions are print, lift, transfer, approach, and the next print. Programs end before one that is left out.
#[test]
fn programs_stop_before_a_motion_that_is_not_proven_free() {
    let plan = plan();
    let kinds: Vec<LegKind> = plan.legs(0..4).map(|leg| leg.kind).collect();
    let [print, lift, transfer, approach] = LegKind::ALL;
    assert_eq!(kinds, [print, lift, transfer, approach, print, lift, transfer, approach, print, print]);
    let left = |motions: &[usize]| {
        let safe = plan.without(&motions.iter().copied().collect());
        assert_eq!(safe.travels.len(), safe.runs.len().saturating_sub(1));
        let paths = |piece: Range<usize>| piece.map(|run| safe.runs[run].path).collect::<Vec<usize>>();
        pieces(&safe).into_iter().map(paths).collect::<Vec<Vec<usize>>>()
    };
    assert_eq!(left(&[]), [vec![0, 1, 2], vec![3]]);
    assert_eq!(left(&[0]), [vec![1, 2], vec![3]]);
    assert_eq!(left(&[1]), [vec![0], vec![1, 2], vec![3]]);
    assert_eq!(left(&[2]), left(&[3]));
    assert_eq!(left(&[4]), [vec![0], vec![2], vec![3]]);
    assert_eq!(left(&[5, 7]), [vec![0, 1], vec![2], vec![3]]);
    assert_eq!(left(&[8]), [vec![0, 1], vec![3]]);
    assert_eq!(left(&[9]), [vec![0, 1, 2]]);
    assert_eq!(left(&[0, 4, 8, 9]), Vec::<Vec<usize>>::new());
    // No joints of what is left out are in the steps: after 0 without the run, which is at 0.2.
    let safe = plan.without(&[4].into());
    assert!(safe.legs(0..safe.runs.len()).all(|leg| leg.kind == print && leg.run.path != 1));
}
