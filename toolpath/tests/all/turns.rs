//! How far the nozzle turns on a millimetre of its way, and paths that are cut where it would turn farther.
//!
//! The slow twin compares the directions of all pairs of waypoints of a piece that are no farther apart than a millimetre.

use crate::common::nozzle::tip_1_mm;
use crate::common::{creases, go_on, layers};

use creases::{H, PIECE, groove_of, nowhere, rows, sheets};
use curvlay_toolpath::deposit::deposit_along;
use curvlay_toolpath::gouging::{GougingOptions, Nozzle, NozzleShape, ResolvedPaths};
use curvlay_toolpath::nalgebra::{Point3, Vector3};
use curvlay_toolpath::orientation::{ToolPath, Turns, Waypoint};
use curvlay_toolpath::travel::TravelOptions;
use layers::{Layer, path, with_stack};
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_4;

const TEN: f64 = 10_f64.to_radians();

fn resolved_with(layers: &[Layer], paths: &[ToolPath], options: &GougingOptions) -> ResolvedPaths {
    resolved_by(&tip_1_mm(), layers, paths, options)
}

fn resolved_by(nozzle: &Nozzle, layers: &[Layer], paths: &[ToolPath], options: &GougingOptions) -> ResolvedPaths {
    with_stack(layers, |stack| stack.resolve_gouging(paths.to_vec(), nozzle, options, &go_on).unwrap())
}

/// How deep the slim nozzle is in points of layers that lack a skin of a quarter.
fn slow_depth(sheets: &[Point3<f64>], waypoint: &Waypoint) -> f64 {
    let clearance = |p: &Point3<f64>| {
        let v = p - waypoint.position;
        let z = v.dot(&waypoint.axis);
        slim().clearance(z, (v - waypoint.axis.into_inner() * z).norm())
    };
    0.25 * H - sheets.iter().map(clearance).fold(f64::INFINITY, f64::min)
}

/// Nothing but earlier layers, nothing raised and nothing left out.
fn earlier_layers() -> GougingOptions {
    let default = GougingOptions::default();
    GougingOptions { own_layer: false, plate: false, max_lift: 0.0, max_depth: f64::INFINITY, ..default }
}

/// The largest turn on a millimetre, or between neighbours that are farther apart by their distance.
fn sharpest(path: &ToolPath) -> f64 {
    sharpest_but(path, &[])
}

/// The same where no step from one of the waypoints `sharp` is in between.
fn sharpest_but(path: &ToolPath, sharp: &[usize]) -> f64 {
    let ways: Vec<f64> = path.waypoints.windows(2).map(|pair| (pair[1].position - pair[0].position).norm()).collect();
    let mut sharpest = 0.0_f64;
    for from in 0..ways.len() {
        let mut way = 0.0;
        for to in from + 1..=ways.len() {
            if sharp.contains(&(to - 1)) {
                break;
            }
            way += ways[to - 1];
            if to == from + 1 || way <= 1.0 {
                let turn = path.waypoints[from].axis.angle(&path.waypoints[to].axis);
                sharpest = sharpest.max(turn / f64::max(way, 1.0));
            }
        }
    }
    sharpest
}

/// Along x, the directions leaning by `lean` one way before the middle and the other way behind.
fn leaning(count: u32, step: f64, lean: f64) -> ToolPath {
    let at = |k: u32| {
        let side = if 2 * k < count { 1.0 } else { -1.0 };
        (Point3::new(f64::from(k) * step, 0.0, 0.0), Vector3::new(0.0, side * lean.sin(), lean.cos()))
    };
    path(0, &(0..count).map(at).collect::<Vec<_>>())
}

#[test]
fn a_turn_is_spread_over_the_path() {
    let given = leaning(60, 1.0, 0.5);
    let resolved = resolved_with(&[nowhere()], std::slice::from_ref(&given), &earlier_layers());
    assert!(resolved.cut_turns.is_empty() && resolved.paths.len() == 1 && resolved.added == 0);
    let waypoints = &resolved.paths[0].waypoints;
    assert!(sharpest(&resolved.paths[0]) <= TEN + 1e-8 && sharpest(&given) > 0.99);
    assert!((resolved.turns.max_per_mm - sharpest(&resolved.paths[0])).abs() < 1e-9);
    // A radian takes six millimetres, and as many again to begin and end it gently; the rest stays, and so do the tips.
    let turned = waypoints.iter().zip(&given.waypoints).filter(|(now, given)| now.axis != given.axis);
    assert!((5..=20).contains(&turned.count()));
    assert!(waypoints.iter().zip(&given.waypoints).all(|(now, given)| now.position == given.position));
}

#[test]
fn a_path_that_is_too_short_for_a_turn_turns_as_far_as_it_may() {
    let resolved = resolved_with(&[nowhere()], &[leaning(4, 0.5, 1.0)], &earlier_layers());
    assert!(resolved.cut_turns.is_empty() && sharpest(&resolved.paths[0]) <= TEN + 1e-8);
    // Without a limit nothing turns.
    let any = GougingOptions { max_turn: 3.0, max_turn_per_mm: f64::INFINITY, ..earlier_layers() };
    let given = leaning(4, 0.5, 1.0);
    assert_eq!(resolved_with(&[nowhere()], std::slice::from_ref(&given), &any).paths, [given]);
}

/// A slim nozzle: a flat of a millimetre and a cone of 20 degrees.
fn slim() -> Nozzle {
    Nozzle::new(NozzleShape { tip_flat_mm: 1.0, half_angle: 20_f64.to_radians(), cone_height_mm: 20.0, block_mm: 16.0 })
        .unwrap()
}

/// Width of a bead whose ends fill the way from one side of the groove to the other, and of one that leaves a gap.
const WIDE: f64 = 1.7;
const NARROW: f64 = 0.4;

/// A groove with a right angle at its bottom, and a path from one of its sides to the other, on what is built. The flat of the tip may lean
/// by `asin(0.25 H / 0.5)`, 24 degrees, from the normal of a side, so on the 1.7 mm between the sides the nozzle would have to turn by 42.
fn across_a_groove(width: f64) -> (Vec<Layer>, ToolPath) {
    let groove = groove_of(FRAC_PI_4, 4.0, 80);
    let on = |side: f64, from_bottom: f64| {
        let up = Vector3::new(side, 0.0, 1.0).normalize();
        let normal = Vector3::new(-side, 0.0, 1.0).normalize();
        (Point3::new(0.0, 0.0, -2.0) + up * from_bottom + normal * (0.5 * H), normal)
    };
    let along: Vec<f64> = (0..24).map(|k| 1.2 + 0.5 * f64::from(k)).collect();
    let down = along.iter().rev().map(|&s| on(-1.0, s));
    let mut across = path(1, &down.chain(along.iter().map(|&s| on(1.0, s))).collect::<Vec<_>>());
    across.waypoints.iter_mut().for_each(|waypoint| waypoint.width = width);
    (vec![groove, nowhere()], across)
}

#[test]
fn a_path_is_cut_where_free_directions_turn_too_sharply() {
    let (layers, given) = across_a_groove(WIDE);
    let resolved = resolved_by(&slim(), &layers, std::slice::from_ref(&given), &earlier_layers());
    assert!(resolved.left.is_empty() && resolved.left_out.is_empty());
    let [cut] = resolved.cut_turns[..] else { panic!("{:?}", resolved.cut_turns) };
    assert_eq!((resolved.paths.len(), cut.path, cut.waypoint), (2, 1, 0));
    let [end, start] =
        [resolved.paths[0].waypoints[resolved.paths[0].waypoints.len() - 1], resolved.paths[1].waypoints[0]];
    assert!(cut.angle > TEN && (end.axis.angle(&start.axis) - cut.angle).abs() < 1e-9);
    // The ends of the beads fill what is not printed between them.
    assert!((end.position - start.position).norm() < WIDE && resolved.gaps == 0.0 && resolved.sharp.is_empty());
    let raster: Vec<_> = sheets(&layers[..1], 0.1).into_iter().filter(|p| p.y.abs() < 12.0 && p.z < 15.0).collect();
    for path in &resolved.paths {
        assert!(sharpest(path) <= TEN + 1e-8, "{}", sharpest(path).to_degrees());
        for waypoint in &path.waypoints {
            assert!(slow_depth(&raster, waypoint) <= 0.25 * H + PIECE);
        }
    }
    // With a limit that allows the turn there is one path.
    let fast = GougingOptions { max_turn: 3.0, max_turn_per_mm: 2.0, ..earlier_layers() };
    assert_eq!(resolved_by(&slim(), &layers, &[given], &fast).paths.len(), 1);
}

#[test]
fn a_path_is_not_cut_where_the_bead_would_have_a_gap() {
    let (layers, given) = across_a_groove(NARROW);
    let resolved = resolved_by(&slim(), &layers, std::slice::from_ref(&given), &earlier_layers());
    assert!(resolved.cut_turns.is_empty() && resolved.gaps == 0.0 && resolved.paths.len() == 1);
    let [slow] = resolved.sharp[..] else { panic!("{:?}", resolved.sharp) };
    assert!(slow.angle > 2.0 * TEN && sharpest(&resolved.paths[0]) > TEN);
    assert!(sharpest_but(&resolved.paths[0], &[slow.waypoint]) <= TEN + 1e-8);
}

#[test]
fn the_nozzle_leaves_the_part_at_a_cut() {
    let (layers, given) = across_a_groove(WIDE);
    let resolved = resolved_by(&slim(), &layers, &[given], &earlier_layers());
    let travels = with_stack(&layers, |stack| {
        let options = TravelOptions { plate: false, ..TravelOptions::default() };
        stack.travels(&resolved.paths, &slim(), &options, &go_on).unwrap()
    });
    assert!(travels.blocked.is_empty() && travels.ways[1].len() >= 2, "{travels:?}");
    // Even where the next piece begins at the end of the last one.
    let mut paths = resolved.paths;
    let end = paths[0].waypoints[paths[0].waypoints.len() - 1].position;
    let shift = end - paths[1].waypoints[0].position;
    paths[1].waypoints.iter_mut().for_each(|waypoint| waypoint.position += shift);
    let plan = deposit_along(&paths, &[Vec::new(), travels.ways[1].clone()], &Default::default()).unwrap();
    assert_eq!(plan.retractions, 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn no_piece_turns_too_far_and_nothing_is_lost(seed in 0_u64..1000, degrees in 2.0_f64..40.0) {
        let (layer, given) = rows(seed);
        let limit = degrees.to_radians();
        let options = GougingOptions { max_turn_per_mm: limit, plate: false, ..GougingOptions::default() };
        let resolved = resolved_with(std::slice::from_ref(&layer), &given, &options);
        let mut sharpest_of_all = 0.0_f64;
        for (number, path) in resolved.paths.iter().enumerate() {
            prop_assert!(path.waypoints.len() > 1);
            sharpest_of_all = sharpest_of_all.max(sharpest(path));
            let sharp = resolved.sharp.iter().filter(|turn| turn.path == number).map(|turn| turn.waypoint);
            prop_assert!(sharpest_but(path, &sharp.collect::<Vec<_>>()) <= limit + 1e-7);
        }
        for turn in &resolved.sharp {
            let [from, to] = [0, 1].map(|k| resolved.paths[turn.path].waypoints[turn.waypoint + k]);
            prop_assert!((from.axis.angle(&to.axis) - turn.angle).abs() < 1e-9);
            prop_assert!((to.position - from.position).norm() > to.width);
        }
        prop_assert!((Turns::of(&resolved.paths).max_per_mm - sharpest_of_all).abs() < 1e-9);
        for cut in &resolved.cut_turns {
            prop_assert!(cut.path > 0 && cut.waypoint == 0 && cut.angle > 0.0);
        }
        for whole in &given {
            let of_curve = || resolved.paths.iter().filter(|path| path.curve == whole.curve);
            let left_out = || resolved.left_out.iter().filter(|piece| piece.curve == whole.curve);
            for given in &whole.waypoints {
                let is_laid = |w: &Waypoint| (w.bead_top() - given.position).norm() < 1e-9;
                let is_printed = of_curve().any(|path| path.waypoints.iter().any(is_laid));
                prop_assert!(is_printed || left_out().any(|p| (p.arcs[0]..=p.arcs[1]).contains(&given.arc)));
            }
        }
    }
}
