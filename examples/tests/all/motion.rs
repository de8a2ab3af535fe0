//! The cells of the examples, and what is said of their motions.

use curvlay_examples::motion::programs::{full_scale, pieces, stream, targets};
use curvlay_examples::motion::read_back::{MAX_OFF_MM, ReadBack};
use curvlay_examples::motion::{OnCell, PartInHand, STEP_S, Studied, bounds_of, dissertation_cells};
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use curvlay_kinematics::program::{Goal, Move, Step};
use curvlay_kinematics::workcell::Workcell;
use curvlay_trajectory::print::{
    Arrival, Departure, PlanTimes, PrintPlan, PrintRobot, Run, SegmentKind, Travel, Waypoint, path_deviations,
};
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
    PrintPlan { runs: (0..4).map(run).collect(), travels: vec![travel(), travel(), None], ..nothing() }
}

fn nothing<const N: usize, const F: usize>() -> PrintPlan<N, F> {
    PrintPlan {
        runs: Vec::new(),
        travels: Vec::new(),
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
    let kinds: Vec<SegmentKind> = plan.segments(0..4).map(|leg| leg.kind).collect();
    let [print, lift, transfer, approach] = SegmentKind::ALL;
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
    assert!(safe.segments(0..safe.runs.len()).all(|leg| leg.kind == print && leg.run.path != 1));
}

/// Two runs from a home posture and back, the second behind a travel, each of 4 s with 2 mm of filament a second between its knots.
fn from_home<const N: usize, const F: usize>(home: [f64; N], limits: &Bounds<N>) -> PrintPlan<N, F> {
    let at = |by: f64| -> [f64; N] { home.map(|angle| angle + by) };
    let motion = |from: f64, to: f64| {
        let knots: Vec<[f64; N]> = (1..4).map(|k| at(from + (to - from) * f64::from(k) / 4.0)).collect();
        Trajectory::new(&Timeline::at_rest(&[0.0, 1.0, 2.0, 3.0, 4.0]).unwrap(), &knots).unwrap()
    };
    let run = |path: usize| Run {
        path,
        layer: 0,
        trajectory: motion(0.1 + 0.1 * path as f64, 0.2 + 0.1 * path as f64),
        passes: (0..5).map(|knot| (knot, Some(knot))).collect(),
        filament_mm: (0..5).map(|knot| 2.0 * f64::from(knot)).collect(),
        ends: [([0.0; F], line_of_one()), ([0.0; F], line_of_one())],
    };
    let way = |from: f64, to: f64| Transfer::through(vec![at(from), at(to)], limits).unwrap();
    let arrival = Arrival { way: way(0.0, 0.05), approach: motion(0.05, 0.1) };
    let travel = Travel { lift: motion(0.2, 0.25), way: way(0.25, 0.15), approach: motion(0.15, 0.2) };
    let departure = Departure { lift: motion(0.3, 0.35), way: way(0.35, 0.0) };
    PrintPlan {
        runs: vec![run(0), run(1)],
        travels: vec![Some(travel)],
        homes: vec![(Some(arrival), None), (None, Some(departure))],
        ..nothing()
    }
}

/// What is read in steps, each of them changed by `damage`.
fn read<const N: usize, const F: usize, W: Workcell<N, F>>(
    cell: &W,
    plan: &PrintPlan<N, F>,
    home: &[f64; N],
    steps: &[Step],
    damage: impl Fn(usize, Step) -> Option<Step>,
) -> ReadBack {
    let mut found = ReadBack::default();
    let steps = steps.iter().enumerate().filter_map(|(k, step)| damage(k, *step)).map(Ok::<Step, ()>);
    found.add((cell, plan, home), 0..plan.runs.len(), steps).unwrap();
    found
}

fn faster_filament(_: usize, step: Step) -> Option<Step> {
    Some(if let Step::FilamentSpeed(mm_s) = step { Step::FilamentSpeed(1.01 * mm_s) } else { step })
}

#[test]
fn what_is_wrong_in_a_stream_is_read() {
    let cell = dissertation_cells().unwrap().0;
    let home = [0.3, -1.2, 1.4, -0.4, 1.2, 0.1];
    let limits = Bounds { acceleration: [5.0; 6], jerk: [50.0; 6], ..bounds_of(cell.limits()) };
    let plan = from_home(home, &limits);
    let steps: Vec<Step> = stream(&cell, &plan, 0..2).collect();
    let read = |damage: &dyn Fn(usize, Step) -> Option<Step>| read(&cell, &plan, &home, &steps, damage);
    let sound = read(&|_, step| Some(step));
    assert_eq!((sound.programs, sound.not_at_home, sound.planned_mm), (1, 0, 16.0));
    assert!(
        sound.off_mm < 1e-7 && (sound.filament_mm - 16.0).abs() < 0.005 * 16.0 && sound.travel_mm_s > 1.0,
        "{sound:?}"
    );
    // Neither the first move nor the last posture is at home.
    assert_eq!(read(&|k, step| (k > 0).then_some(step)).not_at_home, 1);
    assert_eq!(read(&|k, step| (k + 10 < steps.len()).then_some(step)).not_at_home, 1);
    let richer = read(&faster_filament).filament_mm / sound.filament_mm;
    assert!((richer - 1.01).abs() < 1e-9, "{richer}");
    let servos: Vec<usize> = (0..steps.len()).filter(|&k| matches!(steps[k], Step::Servo { .. })).collect();
    let middle = servos[servos.len() / 2];
    let moved = read(&|k, step| match step {
        Step::Servo { joints, seconds } if k == middle => {
            Some(Step::Servo { joints: joints.map(|angle| angle + 1e-3), seconds })
        }
        step => Some(step),
    });
    assert!(moved.off_mm > MAX_OFF_MM, "{moved:?}");
    // Each tick behind one that is missing comes too early.
    assert!(read(&|k, step| (k != middle).then_some(step)).off_mm > MAX_OFF_MM);
    let hasty = read(&|_, step| match step {
        Step::Servo { joints, seconds } => Some(Step::Servo { joints, seconds: seconds / 2.0 }),
        step => Some(step),
    });
    assert!((hasty.travel_mm_s / sound.travel_mm_s - 2.0).abs() < 1e-9);
}

#[test]
fn what_is_wrong_in_lines_is_read() {
    let cell = dissertation_cells().unwrap().1;
    let home = [0.1, 0.2, 0.3, 0.1, 0.8, 0.0, 0.2, 0.1];
    let limits = Bounds { acceleration: [5.0; 8], jerk: [50.0; 8], ..bounds_of(cell.limits()) };
    let plan = from_home(home, &limits);
    let steps: Vec<Step> = targets(&cell, &plan, 0..2).collect();
    let read = |damage: &dyn Fn(usize, Step) -> Option<Step>| read(&cell, &plan, &home, &steps, damage);
    let sound = read(&|_, step| Some(step));
    assert_eq!((sound.programs, sound.not_at_home, sound.planned_mm, sound.travel_mm_s), (1, 0, 16.0, 0.0));
    assert!(sound.off_mm < 1e-9 && (sound.filament_mm - 16.0).abs() < 0.005 * 16.0, "{sound:?}");
    assert_eq!(read(&|k, step| (k > 0).then_some(step)).not_at_home, 1);
    assert_eq!(read(&|k, step| (k + 1 < steps.len()).then_some(step)).not_at_home, 1);
    assert!((read(&faster_filament).filament_mm / sound.filament_mm - 1.01).abs() < 1e-9);
    let lines: Vec<usize> =
        (0..steps.len()).filter(|&k| matches!(steps[k], Step::Move(Move { goal: Goal::Line(_), .. }))).collect();
    let moved = read(&|k, step| match step {
        Step::Move(Move { goal: Goal::Line(mut target), table, speed, zone }) if k == lines[1] => {
            target.pose.translation.z += 2.0 * MAX_OFF_MM;
            Some(Step::Move(Move { goal: Goal::Line(target), table, speed, zone }))
        }
        step => Some(step),
    });
    assert!(moved.off_mm > MAX_OFF_MM && moved.off_mm < 3.0 * MAX_OFF_MM, "{moved:?}");
    // A run ends before its last place: the first, and the last.
    let off = steps.iter().position(|step| *step == Step::Extruder(false)).unwrap();
    let ends = [*lines.iter().rfind(|line| **line < off).unwrap(), lines[lines.len() - 1]];
    for end in ends {
        assert!(read(&|k, step| (k != end).then_some(step)).off_mm.is_infinite());
    }
    // The second run is not there.
    let on = steps.iter().rposition(|step| *step == Step::Extruder(true)).unwrap();
    let off = steps.iter().rposition(|step| *step == Step::Extruder(false)).unwrap();
    assert!(read(&|k, step| (!(on..=off).contains(&k)).then_some(step)).off_mm.is_infinite());
}
