//! Segments of a plan of moves: nothing is lost, nothing is added.

use super::direction;
use curvlay_examples::build3mf::{Segment, SegmentKind, WriteBuildError, direction_of, segments};
use curvlay_toolpath::deposit::{Deposition, DepositionOptions, MoveKind, deposit};
use curvlay_toolpath::nalgebra::{Point3, Vector3, distance};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::path::BeadKind;
use proptest::prelude::*;

fn waypoint() -> impl Strategy<Value = Waypoint> {
    let kind = prop::sample::select(vec![BeadKind::Wall, BeadKind::Solid, BeadKind::Bridge]);
    ([0.0..50_f64, 0.0..50.0, 0.0..50.0], direction(), 0.2..0.9_f64, 0.1..0.4_f64, kind).prop_map(
        |(place, axis, width, height, kind)| Waypoint {
            position: Point3::from(place),
            axis,
            width,
            height,
            arc: 0.0,
            added: false,
            lift: Vector3::zeros(),
            kind,
        },
    )
}

/// Paths of a print in layers that go up; now and then a path goes on where the one before ended.
fn paths() -> impl Strategy<Value = Vec<ToolPath>> {
    let path = (prop::collection::vec(waypoint(), 2..10), 0..2_u32, any::<bool>());
    prop::collection::vec(path, 1..8).prop_map(|all| {
        let (mut layer, mut end) = (0, None);
        let path = |(mut waypoints, up, goes_on): (Vec<Waypoint>, u32, bool)| {
            layer += up;
            if let Some(end) = end.filter(|_| goes_on) {
                waypoints[0] = end;
            }
            waypoints[0].arc = 0.0;
            for k in 1..waypoints.len() {
                waypoints[k].arc = waypoints[k - 1].arc + distance(&waypoints[k].position, &waypoints[k - 1].position);
            }
            end = waypoints.last().copied();
            ToolPath { layer, curve: 0, closed: false, waypoints }
        };
        all.into_iter().map(path).collect()
    })
}

fn plan(paths: &[ToolPath]) -> Deposition {
    deposit(paths, &DepositionOptions::default()).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Lines are the moves in their order: places, sizes, kinds, layers, times and filament.
    #[test]
    fn every_move_is_in_a_segment(paths in paths()) {
        let plan = plan(&paths);
        let all: Vec<Segment> = segments(&plan.moves, &paths).unwrap()().collect();
        let mut lines = all.iter().flat_map(|segment| segment.lines.iter().map(move |line| (segment, line)));
        let motions = plan.moves.iter().filter(|step| matches!(step.kind, MoveKind::Travel | MoveKind::Print));
        // The first travel has no place to come from.
        for step in motions.skip(1) {
            let (segment, line) = lines.next().unwrap();
            prop_assert_eq!(Point3::from(line.end.translation.vector), step.tip);
            prop_assert!((direction_of(&line.end).into_inner() - step.direction.into_inner()).norm() < 1e-12);
            prop_assert!((line.seconds - step.seconds).abs() <= 0.0);
            if let Some(speed) = line.speed_mm_s {
                prop_assert!((speed - step.feed).abs() <= 0.0);
            }
            let kind = step.bead.map_or(SegmentKind::Travel, SegmentKind::Bead);
            prop_assert_eq!(segment.kind, kind);
            if step.kind == MoveKind::Print {
                prop_assert_eq!((segment.path as usize, segment.layer), (step.path, paths[step.path].layer));
                let ends = &paths[step.path].waypoints[step.waypoint - 1..=step.waypoint];
                let sections = line.bead.unwrap().map(|end| (end.width_mm, end.height_mm));
                prop_assert_eq!(sections, [0, 1].map(|k| (ends[k].width, ends[k].height)));
            }
        }
        prop_assert!(lines.next().is_none());
        let sum = |of: fn(&Segment) -> f64| all.iter().map(of).sum::<f64>();
        let moved = |kind| plan.moves.iter().filter(|step| step.kind == kind).map(|step| step.filament).sum::<f64>();
        prop_assert!((sum(|s| s.filament_mm) - moved(MoveKind::Print)).abs() < 1e-9);
        prop_assert!((sum(|s| s.prime_mm) - moved(MoveKind::Prime)).abs() < 1e-12);
        prop_assert!((sum(|s| s.retract_mm) + moved(MoveKind::Retract)).abs() < 1e-12);
    }

    /// Each segment begins where the one before ended, a travel goes over to the layer behind it, and no two neighbours could be one.
    #[test]
    fn segments_join(paths in paths()) {
        let plan = plan(&paths);
        let all: Vec<Segment> = segments(&plan.moves, &paths).unwrap()().collect();
        for pair in all.windows(2) {
            prop_assert_eq!(pair[0].lines.last().unwrap().end, pair[1].start);
            if pair[0].kind == SegmentKind::Travel {
                prop_assert_eq!((pair[0].layer, pair[0].path), (pair[1].layer, pair[1].path));
            }
            let alike = pair[0].kind == pair[1].kind && pair[0].path == pair[1].path;
            prop_assert!(!alike || pair[0].retract_mm > 0.0 || pair[1].prime_mm > 0.0);
        }
    }
}

#[test]
fn moves_that_go_with_no_path_are_refused() {
    let at = |x: f64| Waypoint {
        position: Point3::new(x, 0.0, 0.3),
        axis: Vector3::z_axis(),
        width: 0.5,
        height: 0.3,
        arc: x,
        added: false,
        lift: Vector3::zeros(),
        kind: BeadKind::Wall,
    };
    let paths = [ToolPath { layer: 0, curve: 0, closed: false, waypoints: vec![at(0.0), at(9.0)] }];
    let moves = plan(&paths).moves;
    let refused = |moves: &[_], paths: &[ToolPath]| match segments(moves, paths).map(|_| ()) {
        Err(WriteBuildError::Moves { index, .. }) => index,
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(&moves, &[]), 0);
    let mut wrong = moves.clone();
    let print = wrong.iter().position(|step| step.kind == MoveKind::Print).unwrap();
    wrong[print].waypoint = 7;
    assert_eq!(refused(&wrong, &paths), print);
    assert_eq!(refused(&moves[print..], &paths), 0);
    wrong = moves.clone();
    wrong[print].bead = None;
    assert_eq!(refused(&wrong, &paths), print);
    assert_eq!(segments(&[], &[]).unwrap()().count(), 0);
}
