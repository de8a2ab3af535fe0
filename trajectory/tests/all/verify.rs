//! Verification and repair: against plain loops and full enumeration.

use curvlay_trajectory::Progress;
use curvlay_trajectory::verify::{Repair, RepairError, RepairOptions, Verification, VerifyError, repair, verify};
use proptest::prelude::*;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

fn go(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn all_waypoints_and_all_motions_between_free_ones_are_asked() {
    let waypoints: Vec<[f64; 1]> = (0..200).map(|k| [f64::from(k)]).collect();
    let asked = Mutex::new((vec![], vec![]));
    let posture = |i: usize, q: &[f64; 1]| {
        asked.lock().unwrap().0.push(i);
        assert!((q[0] - i as f64).abs() < 1e-12);
        i % 50 != 7
    };
    let motion = |i: usize, from: &[f64; 1], to: &[f64; 1]| {
        asked.lock().unwrap().1.push(i);
        assert!((to[0] - from[0] - 1.0).abs() < 1e-12);
        i % 60 != 20
    };
    let found = verify(&waypoints, &posture, &motion, &go).unwrap();
    assert_eq!((found.waypoints.clone(), found.motions.clone()), (vec![7, 57, 107, 157], vec![20, 80, 140]));
    assert!(!found.is_free());
    let (postures, motions) = asked.into_inner().unwrap();
    assert_eq!(postures, (0..200).collect::<Vec<_>>());
    assert_eq!(motions, (0..199).filter(|i| i % 50 != 7 && (i + 1) % 50 != 7).collect::<Vec<_>>());
    let nothing = verify::<1>(&[], &|_, _| true, &|_, _, _| true, &go).unwrap();
    assert!(nothing.is_free());
}

#[test]
fn verification_stops_on_demand() {
    let waypoints = [[0.0]; 1000];
    let stop = |p: Progress| if p.done >= 256 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let asked = AtomicUsize::new(0);
    let free = |_: usize, _: &[f64; 1]| {
        asked.fetch_add(1, Ordering::Relaxed);
        true
    };
    let cancelled = verify(&waypoints, &free, &|_, _, _| true, &stop).unwrap_err();
    assert_eq!((cancelled, asked.into_inner()), (VerifyError::Cancelled, 256));
}

/// A trajectory of whole numbers, what each waypoint may be, and how far one may be from the next.
#[derive(Clone, Debug)]
struct Case {
    waypoints: Vec<[f64; 1]>,
    candidates: Vec<Vec<[f64; 1]>>,
    collides: Vec<bool>,
    far: f64,
}

fn case(least: usize) -> impl Strategy<Value = Case> {
    let place = || (-6i32..7).prop_map(|x| [f64::from(x)]);
    let waypoint = (place(), proptest::collection::vec(place(), least..4), any::<bool>());
    (proptest::collection::vec(waypoint, 1..7), 1u32..5).prop_map(|(all, far)| Case {
        waypoints: all.iter().map(|w| w.0).collect(),
        candidates: all.iter().map(|w| w.1.clone()).collect(),
        collides: all.iter().map(|w| w.2).collect(),
        far: f64::from(far) + 0.5,
    })
}

impl Case {
    fn fits(&self, from: &[f64; 1], to: &[f64; 1]) -> bool {
        (from[0] - to[0]).abs() < self.far
    }

    fn verification(&self) -> Verification {
        let motion = |_: usize, from: &[f64; 1], to: &[f64; 1]| self.fits(from, to);
        verify(&self.waypoints, &|i, _| !self.collides[i], &motion, &go).unwrap()
    }

    fn repair(&self, widen: usize) -> Repair<1> {
        let candidates = |i: usize| self.candidates[i].clone();
        let fits = |_: usize, from: &[f64; 1], to: &[f64; 1]| self.fits(from, to);
        repair(&self.waypoints, &self.verification(), &candidates, &fits, &RepairOptions { nearest: 9, widen }).unwrap()
    }

    fn splits(&self, waypoints: &[[f64; 1]]) -> usize {
        waypoints.windows(2).filter(|pair| !self.fits(&pair[0], &pair[1])).count()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// All waypoints collide and have candidates: one run, so every combination can be tried.
    #[test]
    fn a_run_is_the_best_of_all_combinations(mut case in case(1)) {
        case.collides.fill(true);
        let repaired = case.repair(0);
        let change = |waypoints: &[[f64; 1]]| -> f64 {
            waypoints.iter().zip(&case.waypoints).map(|(a, b)| (a[0] - b[0]).abs()).sum()
        };
        let mut best = (usize::MAX, f64::INFINITY);
        let count: usize = case.candidates.iter().map(Vec::len).product();
        for mut k in 0..count {
            let pick = |all: &Vec<[f64; 1]>| { let at = all[k % all.len()]; k /= all.len(); at };
            let all: Vec<[f64; 1]> = case.candidates.iter().map(pick).collect();
            let cost = (case.splits(&all), change(&all));
            if cost < best {
                best = cost;
            }
        }
        prop_assert_eq!((case.splits(&repaired.waypoints), change(&repaired.waypoints)), best);
        prop_assert_eq!(repaired.splits.len(), best.0);
        prop_assert!(repaired.stuck.is_empty());
    }

    #[test]
    fn what_is_said_of_a_repair_is_so(case in case(0), widen in 0usize..3) {
        let repaired = case.repair(widen);
        for i in 0..case.waypoints.len() {
            let now = repaired.waypoints[i];
            let is_old = (now[0] - case.waypoints[i][0]).abs() < 1e-12;
            let is_candidate = case.candidates[i].contains(&now);
            prop_assert_eq!(repaired.changed.contains(&i), !is_old);
            prop_assert!(is_old || is_candidate);
            let is_stuck = case.collides[i] && case.candidates[i].is_empty();
            prop_assert_eq!(repaired.stuck.contains(&i), is_stuck);
            prop_assert!(is_stuck || is_candidate || !case.collides[i]);
            // Every motion that does not fit is reported, but those to and from what is stuck, which need not be.
            if i + 1 < case.waypoints.len() {
                let next_stuck = case.collides[i + 1] && case.candidates[i + 1].is_empty();
                let fits = case.fits(&now, &repaired.waypoints[i + 1]);
                if !is_stuck && !next_stuck {
                    prop_assert_eq!(repaired.splits.contains(&i), !fits, "motion {}", i);
                }
            }
        }
        // More room never costs a split.
        if widen > 0 && repaired.stuck.is_empty() {
            prop_assert!(repaired.splits.len() <= case.splits(&case.waypoints).max(case.repair(0).splits.len()));
        }
    }
}

#[test]
fn neighbours_move_along_where_that_saves_a_split() {
    // The only free posture of waypoint 2 is two steps away; its neighbours have candidates half way.
    let waypoints = [[0.0], [0.0], [0.0], [0.0], [0.0]];
    let found = Verification { waypoints: vec![2], motions: vec![] };
    let candidates = |i: usize| if i == 2 { vec![[2.0]] } else { vec![[1.0], [-1.0]] };
    let fits = |_: usize, from: &[f64; 1], to: &[f64; 1]| (from[0] - to[0]).abs() < 1.5;
    let with = |widen| {
        let options = RepairOptions { widen, ..RepairOptions::default() };
        repair(&waypoints, &found, &candidates, &fits, &options).unwrap()
    };
    assert_eq!(with(0).splits, vec![1, 2]);
    let wide = with(1);
    assert_eq!((wide.splits.len(), wide.changed), (0, vec![1, 2, 3]));
    assert_eq!(wide.waypoints, [[0.0], [1.0], [2.0], [1.0], [0.0]]);
}

/// Waypoint 0 collides and has a candidate equal to it: settled all the same, so waypoint 1 must not leave it for 2.
#[test]
fn a_settled_waypoint_is_held_on_to_even_if_it_did_not_move() {
    let case = Case {
        waypoints: vec![[-3.0], [-2.0], [0.0]],
        candidates: vec![vec![[-3.0]], vec![[2.0]], vec![[3.0]]],
        collides: vec![true, false, true],
        far: 1.5,
    };
    let repaired = case.repair(1);
    assert_eq!(repaired.splits.len(), case.splits(&repaired.waypoints));
}

#[test]
fn a_motion_that_collides_moves_its_ends() {
    let waypoints = [[0.0], [0.0], [5.0], [5.0]];
    let found = Verification { waypoints: vec![], motions: vec![1] };
    let candidates = |i: usize| if i == 1 { vec![[2.0]] } else { vec![[4.0]] };
    let fits = |_: usize, from: &[f64; 1], to: &[f64; 1]| (from[0] - to[0]).abs() < 2.5;
    let repaired = repair(&waypoints, &found, &candidates, &fits, &RepairOptions::default()).unwrap();
    assert_eq!((repaired.waypoints, repaired.splits), (vec![[0.0], [2.0], [4.0], [5.0]], vec![]));
    // What is stuck stays and is reported; what is not finite is no candidate.
    let found = Verification { waypoints: vec![1], motions: vec![] };
    let none = |_: usize| vec![[f64::NAN]];
    let repaired = repair(&waypoints, &found, &none, &fits, &RepairOptions::default()).unwrap();
    assert_eq!((repaired.stuck, repaired.changed), (vec![1], vec![]));
}

#[test]
fn a_segment_may_widen_over_all_there_is() {
    let waypoints = [[0.0], [0.0], [9.0], [0.0], [0.0]];
    let found = Verification { waypoints: vec![2], motions: vec![] };
    let fits = |_: usize, from: &[f64; 1], to: &[f64; 1]| (from[0] - to[0]).abs() < 1.5;
    let candidates = |i: usize| vec![[[0.0], [1.0], [2.0], [1.0], [0.0]][i]];
    for widen in [16, usize::MAX / 2 + 1, usize::MAX] {
        let options = RepairOptions { widen, ..RepairOptions::default() };
        let repaired = repair(&waypoints, &found, &candidates, &fits, &options).unwrap();
        assert_eq!((repaired.changed, repaired.splits), (vec![1, 2, 3], vec![]));
    }
}

#[test]
fn repair_errors() {
    let fits = |_: usize, _: &[f64; 1], _: &[f64; 1]| true;
    let with = |waypoints: Vec<usize>, motions: Vec<usize>, nearest| {
        let found = Verification { waypoints, motions };
        let options = RepairOptions { nearest, ..RepairOptions::default() };
        repair(&[[0.0], [1.0]], &found, &|_| vec![], &fits, &options).unwrap_err()
    };
    assert_eq!(with(vec![2], vec![], 3), RepairError::NoWaypoint { waypoint: 2, count: 2 });
    assert_eq!(with(vec![], vec![1], 3), RepairError::NoWaypoint { waypoint: 2, count: 2 });
    assert_eq!(with(vec![], vec![usize::MAX], 3), RepairError::NoWaypoint { waypoint: usize::MAX, count: 2 });
    assert_eq!(with(vec![], vec![], 0), RepairError::NoneAllowed);
}
