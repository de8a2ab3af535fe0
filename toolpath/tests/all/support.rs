//! Beads that lie on nothing: closed forms, a check by brute force, what must not change the answer, and what is refused.

use crate::common::layers;

use curvlay_toolpath::nalgebra::{Point3, Rotation3, Unit, Vector3};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::path::BeadKind;
use curvlay_toolpath::support::{BeadSupport, SupportError, SupportOptions, UnsupportedPiece, check_support};
use proptest::prelude::*;
use std::ops::ControlFlow;

/// Height of the layers of these tests.
const HEIGHT: f64 = 0.8;

fn go_on(_: curvlay_toolpath::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn checked(paths: &[ToolPath]) -> BeadSupport {
    check_support(paths, HEIGHT, &SupportOptions::default(), &go_on).unwrap()
}

/// A bead as wide and high as layers are, upright; heights are those of its middle.
fn bead(layer: u32, points: &[[f64; 3]]) -> ToolPath {
    let tips: Vec<_> = points.iter().map(|&[x, y, z]| (Point3::new(x, y, z + HEIGHT / 2.0), Vector3::z())).collect();
    layers::path(layer, &tips)
}

/// On a bead at this height, far above the plate, beads a layer height up and so far aside, from -10 to 10.
fn beside(aside: f64) -> Vec<ToolPath> {
    vec![bead(0, &[[-10.0, 0.0, 9.0], [10.0, 0.0, 9.0]]), bead(1, &[[-10.0, aside, 9.8], [10.0, aside, 9.8]])]
}

fn of_path(support: &BeadSupport, path: usize) -> Vec<[f64; 2]> {
    support.unsupported.iter().filter(|piece| piece.path == path).map(|piece| piece.arcs).collect()
}

#[test]
fn a_bead_is_held_within_one_and_a_half_heights() {
    // A right triangle: 0.8 up, and the root of 1.2^2 - 0.8^2 aside.
    let most = (1.2_f64.powi(2) - 0.8_f64.powi(2)).sqrt();
    assert_eq!(of_path(&checked(&beside(most - 1e-9)), 1), Vec::<[f64; 2]>::new());
    let support = checked(&beside(most + 1e-9));
    assert_eq!((of_path(&support, 0), of_path(&support, 1)), (vec![[0.0, 20.0]], vec![[0.0, 20.0]]));
    assert_eq!((support.bead_mm, support.unsupported_mm(), support.longest_mm()), (40.0, 40.0, 20.0));
    assert!((support.unsupported_share() - 1.0).abs() < 1e-12);
}

#[test]
fn the_plate_holds_what_is_near() {
    // Middles rise from 0.4 to 2.4 over 20 mm: above 1.2 after 8 mm.
    let path = bead(0, &[[0.0, 0.0, 0.4], [20.0, 0.0, 2.4]]);
    let length = path.waypoints[1].arc;
    let [piece] = checked(std::slice::from_ref(&path)).unsupported[..] else { panic!("one piece") };
    assert!((piece.arcs[0] - 0.4 * length).abs() <= 0.04 && (piece.arcs[1] - length).abs() < 1e-9, "{piece:?}");
    assert!((piece.tip.x - 14.0).abs() < 0.05);
    let afloat = SupportOptions { plate: false, ..SupportOptions::default() };
    let support = check_support(&[path], HEIGHT, &afloat, &go_on).unwrap();
    assert!((support.unsupported_mm() - length).abs() < 1e-9);
}

#[test]
fn wide_beads_hold_with_their_core() {
    // 3 mm wide and 0.8 high: a core of 1.1 mm on each side.
    let most = 1.1 + (1.2_f64.powi(2) - 0.8_f64.powi(2)).sqrt();
    for (aside, unsupported) in [(most - 1e-9, 0), (most + 1e-9, 1)] {
        let mut paths = beside(aside);
        paths[0].waypoints.iter_mut().for_each(|at| at.width = 3.0);
        assert_eq!(of_path(&checked(&paths), 1).len(), unsupported);
    }
}

#[test]
fn only_earlier_beads_of_other_layers_hold() {
    let mut paths = beside(0.0);
    assert!(of_path(&checked(&paths), 1).is_empty());
    paths[1].layer = 0;
    assert_eq!(of_path(&checked(&paths), 1), [[0.0, 20.0]]);
    paths[1].layer = 1;
    paths.swap(0, 1);
    // And what lies above does not hold.
    assert_eq!((of_path(&checked(&paths), 0), of_path(&checked(&paths), 1)), (vec![[0.0, 20.0]], vec![[0.0, 20.0]]));
    let level = [bead(0, &[[0.0, 0.0, 9.0], [9.0, 0.0, 9.0]]), bead(1, &[[0.0, 0.8, 9.0], [9.0, 0.8, 9.0]])];
    assert_eq!(of_path(&checked(&level), 1), [[0.0, 9.0]]);
}

/// The ends of the bead below `over`: 8 mm, then nothing, then from 15 mm on.
fn two_ends() -> [ToolPath; 2] {
    [bead(0, &[[0.0, 0.0, 0.4], [8.0, 0.0, 0.4]]), bead(0, &[[15.0, 0.0, 0.4], [30.0, 0.0, 0.4]])]
}

/// How far an end holds beyond itself what lies 0.81 mm above.
fn beyond() -> f64 {
    (1.2_f64.powi(2) - 0.81_f64.powi(2)).sqrt()
}

#[test]
fn a_span_is_found_where_it_is() {
    let over = bead(1, &[[0.0, 0.0, 1.21], [30.0, 0.0, 1.21]]);
    let support = checked(&[&two_ends()[..], &[over]].concat());
    let [span] = support.spans[..] else { panic!("one span") };
    let [from, to] = span.arcs;
    assert!((from - (8.0 + beyond())).abs() <= 0.04 && (to - (15.0 - beyond())).abs() <= 0.04, "{span:?}");
    assert_eq!((span.path, support.unsupported.len()), (2, 0));
    assert_eq!((support.span_mm(), support.longest_span_mm(), support.unsupported_mm()), (to - from, to - from, 0.0));
}

#[test]
fn a_span_is_straight_and_held_at_both_ends() {
    let spans = |over: &ToolPath, options: &SupportOptions| {
        let paths = [&two_ends()[..], std::slice::from_ref(over)].concat();
        let support = check_support(&paths, HEIGHT, options, &go_on).unwrap();
        assert_eq!(support.spans.len() + support.unsupported.len(), 1);
        support.spans.len() == 1
    };
    let default = SupportOptions::default();
    // Beads are 0.8 mm wide: the middle of the span may be 0.4 mm aside.
    let bent = |by: f64| {
        bead(1, &[[0.0, 0.0, 1.21], [8.9, 0.0, 1.21], [11.5, by, 1.21], [14.1, 0.0, 1.21], [30.0, 0.0, 1.21]])
    };
    assert!(spans(&bent(0.39), &default) && !spans(&bent(0.41), &default));
    assert!(!spans(&bent(0.39), &SupportOptions { span_bend: 0.4, ..default }));
    // It begins or ends so far before or after the gap.
    let from_to = |before: f64, after: f64| {
        bead(1, &[[8.0 + beyond() - before, 0.0, 1.21], [15.0 - beyond() + after, 0.0, 1.21]])
    };
    assert!(
        spans(&from_to(0.9, 0.9), &default)
            && !spans(&from_to(0.7, 0.9), &default)
            && !spans(&from_to(0.9, 0.7), &default)
    );
    assert!(spans(&from_to(0.5, 0.5), &SupportOptions { span_hold: 0.5, ..default }));
    assert!(!spans(&from_to(5.0, 5.0), &SupportOptions { span_hold: f64::INFINITY, ..default }));
    // Nothing before it, or nothing after it.
    let hold = SupportOptions { span_hold: 0.0, ..default };
    assert!(!spans(&bead(1, &[[10.0, 0.0, 1.21], [20.0, 0.0, 1.21]]), &hold));
    assert!(!spans(&bead(1, &[[0.0, 0.0, 1.21], [12.0, 0.0, 1.21]]), &hold));
    // What is not judged holds nothing.
    let mut sparse = bead(1, &[[0.0, 0.0, 1.21], [10.0, 0.0, 1.21], [30.0, 0.0, 1.21]]);
    sparse.waypoints[1].kind = BeadKind::Infill;
    assert!(!spans(&sparse, &hold));
}

#[test]
fn a_span_may_lie_over_the_start_of_a_closed_path() {
    let round = |y: f64| {
        let [start, near] = [[11.5, y, 1.21], [14.1, 0.0, 1.21]];
        let corners = [[30.0, 0.0, 1.21], [30.0, 9.0, 1.21], [0.0, 9.0, 1.21], [0.0, 0.0, 1.21], [8.9, 0.0, 1.21]];
        bead(1, &[&[start, near], &corners[..], &[start]].concat())
    };
    let mut over = round(0.0);
    let far = bead(0, &[[30.0, 0.0, 0.4], [30.0, 9.0, 0.4], [0.0, 9.0, 0.4], [0.0, 0.0, 0.4]]);
    let under = [&two_ends()[..], &[far]].concat();
    assert_eq!(checked(&[&under[..], &[over.clone()]].concat()).unsupported.len(), 2);
    over.closed = true;
    let support = checked(&[&under[..], &[over.clone()]].concat());
    let [span] = support.spans[..] else { panic!("one span: {support:?}") };
    assert!((span.length() - (7.0 - 2.0 * beyond())).abs() <= 0.08 && (span.tip.x - 11.5).abs() < 0.05, "{span:?}");
    // Bent at the start, it is none.
    over = ToolPath { closed: true, ..round(1.0) };
    assert!(checked(&[&under[..], &[over]].concat()).spans.is_empty());
}

#[test]
fn a_piece_over_the_start_of_a_closed_path_is_one() {
    let square = [[0.0, 0.0, 2.0], [10.0, 0.0, 2.0], [10.0, 10.0, 2.0], [0.0, 10.0, 2.0], [0.0, 0.0, 2.0]];
    let under = bead(0, &[[10.0, -1.0, 1.2], [10.0, 11.0, 1.2]]);
    let mut path = bead(1, &square);
    assert_eq!(of_path(&checked(&[under.clone(), path.clone()]), 1).len(), 2);
    path.closed = true;
    let paths = [under, path];
    let support = checked(&paths);
    let [piece] = support.unsupported[..] else { panic!("one piece: {support:?}") };
    let held = 10.0 + 2.0 * (1.2_f64.powi(2) - 0.8_f64.powi(2)).sqrt();
    assert!((piece.length() - (40.0 - held)).abs() <= 0.08, "{piece:?}");
    // Its middle is on the far side.
    assert!(piece.tip.x.abs() < 0.1 && (piece.tip.y - 5.0).abs() < 0.1, "{piece:?}");
}

/// From end to end, over the start of a closed path, no farther apart than asked for; half the height of the bead behind the tip, whichever way the nozzle points.
#[test]
fn middles_of_a_piece() {
    let square = [[0.0, 0.0, 2.0], [10.0, 0.0, 2.0], [10.0, 10.0, 2.0], [0.0, 10.0, 2.0], [0.0, 0.0, 2.0]];
    let path = ToolPath { closed: true, ..bead(1, &square) };
    let piece = UnsupportedPiece { path: 0, arcs: [28.0, 43.0], tip: Point3::origin() };
    let middles = piece.middles(std::slice::from_ref(&path), 2.0);
    let expected = |k: usize| match 28.0 + 1.875 * k as f64 {
        arc if arc <= 30.0 => [30.0 - arc, 10.0],
        arc if arc <= 40.0 => [0.0, 40.0 - arc],
        arc => [arc - 40.0, 0.0],
    };
    assert_eq!(middles.len(), 9);
    for (k, middle) in middles.iter().enumerate() {
        let [x, y] = expected(k);
        assert!((middle - Point3::new(x, y, 2.0)).norm() < 1e-9, "{k}: {middle} {x} {y}");
    }
    // Sideways, and with steps that are none.
    let mut leaning = path;
    leaning.waypoints.iter_mut().for_each(|at| at.axis = Vector3::x_axis());
    for step in [0.0, f64::NAN, -1.0, 100.0] {
        let [from, to] = piece.middles(std::slice::from_ref(&leaning), step)[..] else { panic!("two ends") };
        assert!((from - Point3::new(2.0 - HEIGHT / 2.0, 10.0, 2.0 + HEIGHT / 2.0)).norm() < 1e-9, "{from}");
        assert!((to - Point3::new(3.0 - HEIGHT / 2.0, 0.0, 2.0 + HEIGHT / 2.0)).norm() < 1e-9, "{to}");
    }
    assert!(UnsupportedPiece { path: 7, ..piece }.middles(&[leaning], 1.0).is_empty());
}

#[test]
fn nonsense_is_refused() {
    let path = bead(0, &[[0.0, 0.0, 0.4], [9.0, 0.0, 0.4]]);
    let error =
        |paths: &[ToolPath], options: SupportOptions| check_support(paths, HEIGHT, &options, &go_on).unwrap_err();
    let default = SupportOptions::default();
    let one = |at: Waypoint| ToolPath { waypoints: vec![path.waypoints[0], at], ..path.clone() };
    let at = path.waypoints[1];
    let bad = [
        Waypoint { position: Point3::new(f64::NAN, 0.0, 0.0), ..at },
        Waypoint { position: Point3::new(1e300, 0.0, 0.0), ..at },
        Waypoint { width: 0.0, ..at },
        Waypoint { height: f64::INFINITY, ..at },
        Waypoint { arc: -1.0, ..at },
    ];
    for at in bad {
        assert_eq!(error(&[one(at)], default), SupportError::BadWaypoint { path: 0, waypoint: 1 });
    }
    let short = ToolPath { waypoints: vec![at], ..path.clone() };
    assert_eq!(error(&[path.clone(), short], default), SupportError::FewWaypoints { path: 1, waypoints: 1 });
    for options in [
        SupportOptions { max_distance: 0.0, ..default },
        SupportOptions { step: f64::NAN, ..default },
        SupportOptions { min_drop: 2.0, ..default },
        SupportOptions { span_hold: f64::NAN, ..default },
        SupportOptions { span_bend: -0.1, ..default },
    ] {
        assert!(matches!(error(std::slice::from_ref(&path), options), SupportError::Option { .. }));
    }
    let fine = SupportOptions { step: 1e-12, ..default };
    assert!(matches!(error(std::slice::from_ref(&path), fine), SupportError::TooManyPlaces { .. }));
    let stopped = check_support(&[path], HEIGHT, &default, &|_| ControlFlow::Break(())).unwrap_err();
    assert_eq!(stopped, SupportError::Cancelled);
    assert_eq!(checked(&[]), BeadSupport::default());
}

/// A place of the middle, how the nozzle leans, the width of the bead.
type Wandering = ([f64; 3], [f64; 2], f64);

/// Beads that wander, lean and change their size, some near each other.
fn beads() -> impl Strategy<Value = Vec<ToolPath>> {
    let waypoint = ([-4.0..4.0, -4.0..4.0, 0.0..4.0_f64], [-0.6..0.6, -0.6..0.6_f64], 0.4..0.8_f64);
    let path = (0_u32..4, proptest::collection::vec(waypoint, 2..5));
    let tool_path = |(layer, waypoints): (u32, Vec<Wandering>)| {
        let tips: Vec<_> =
            waypoints.iter().map(|(p, [x, y], _)| (Point3::from(*p), Vector3::new(*x, *y, 1.0))).collect();
        let mut path = layers::path(layer, &tips);
        path.waypoints.iter_mut().zip(&waypoints).for_each(|(at, (.., width))| at.width = *width);
        path
    };
    proptest::collection::vec(path.prop_map(tool_path), 1..7)
}

/// Points along a bead, each with middle and direction, some hundreds a segment; and where it is along the path.
fn fine(path: &ToolPath, parts: usize) -> Vec<(Point3<f64>, Vector3<f64>, f64)> {
    let middle = |at: &Waypoint| at.position - at.axis.into_inner() * (0.5 * at.height);
    let mut points = Vec::new();
    for pair in path.waypoints.windows(2) {
        for k in 0..parts {
            let share = (k as f64 + 0.5) / parts as f64;
            let direction = pair[0].axis.lerp(&pair[1].axis, share).normalize();
            let at = middle(&pair[0]) + (middle(&pair[1]) - middle(&pair[0])) * share;
            points.push((at, direction, pair[0].arc + (pair[1].arc - pair[0].arc) * share));
        }
    }
    points
}

/// The length of each path that lies on nothing or is a span, point against point, for beads no wider than high.
fn by_brute_force(paths: &[ToolPath]) -> Vec<f64> {
    let all: Vec<_> = paths.iter().map(|path| fine(path, 300)).collect();
    let is_held = |number: usize, (at, direction, _): &(Point3<f64>, Vector3<f64>, f64)| {
        let earlier = (0..number).filter(|&other| paths[other].layer != paths[number].layer);
        let near =
            |other: &Point3<f64>| (at - other).norm() <= 1.5 * HEIGHT && (at - other).dot(direction) >= 0.25 * HEIGHT;
        at.z <= 1.5 * HEIGHT || earlier.into_iter().any(|other| all[other].iter().any(|(at, ..)| near(at)))
    };
    let unsupported = |(number, path): (usize, &ToolPath)| {
        let steps = path.waypoints.windows(2).map(|pair| (pair[1].arc - pair[0].arc) / 300.0);
        let lengths = steps.flat_map(|step| std::iter::repeat_n(step, 300));
        lengths.zip(&all[number]).filter(|(_, point)| !is_held(number, point)).map(|(step, _)| step).sum()
    };
    paths.iter().enumerate().map(unsupported).collect()
}

fn lengths(support: &BeadSupport, paths: usize) -> Vec<f64> {
    let of = |path| {
        support
            .unsupported
            .iter()
            .chain(&support.spans)
            .filter(|piece| piece.path == path)
            .map(UnsupportedPiece::length)
            .sum()
    };
    (0..paths).map(of).collect()
}

fn without_support(support: &BeadSupport) -> f64 {
    support.unsupported_mm() + support.span_mm()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn agrees_with_brute_force(paths in beads()) {
        let fine = SupportOptions { step: 0.01, ..SupportOptions::default() };
        let support = check_support(&paths, HEIGHT, &fine, &go_on).unwrap();
        for (own, slow) in lengths(&support, paths.len()).into_iter().zip(by_brute_force(&paths)) {
            // Both look at places a few hundredths apart; each end of a piece may be off by that.
            prop_assert!((own - slow).abs() <= 0.15, "{own} {slow}");
        }
    }

    #[test]
    fn the_step_moves_ends_by_no_more_than_itself(paths in beads()) {
        let fine = SupportOptions { step: 0.01, ..SupportOptions::default() };
        let [coarse, fine] = [SupportOptions::default(), fine].map(|options| check_support(&paths, HEIGHT, &options, &go_on).unwrap());
        // Each end by half a step; pieces and gaps shorter than a step may come and go.
        let ends = |support: &BeadSupport| 2 * (support.unsupported.len() + support.spans.len());
        let [one, other] = [&coarse, &fine].map(without_support);
        prop_assert!((one - other).abs() <= 0.08 * ends(&coarse).max(ends(&fine)) as f64 + 1e-9);
    }

    #[test]
    fn turned_and_moved_on_the_plate_nothing_changes(paths in beads(), angle in -3.0..3.0_f64, by in [-50.0..50.0, -50.0..50.0_f64]) {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
        let mut moved = paths.clone();
        for at in moved.iter_mut().flat_map(|path| &mut path.waypoints) {
            at.position = turn * at.position + Vector3::new(by[0], by[1], 0.0);
            at.axis = Unit::new_normalize(turn * at.axis.into_inner());
        }
        // Rounding may turn single places.
        let [one, other] = [&paths, &moved].map(|paths| without_support(&checked(paths)));
        prop_assert!((one - other).abs() <= 0.17, "{one} {other}");
    }

    #[test]
    fn an_earlier_bead_more_takes_no_support_away(paths in beads(), first in beads()) {
        let before = lengths(&checked(&paths), paths.len());
        let more = [&first[..1], &paths[..]].concat();
        let after = lengths(&checked(&more), more.len());
        for (before, after) in before.iter().zip(&after[1..]) {
            prop_assert!(*after <= before + 1e-9);
        }
    }
}
