//! Nozzles resolved by the least tilt: closed forms, slow twins, and what is refused.
//!
//! The slow twin knows nothing of trees, bounds and caps: it looks at a dense raster of points on every sheet of every
//! triangle.

use crate::common::nozzle::tip_1_mm;
use crate::common::{creases, go_on, layers, nozzle};

use creases::{H, PIECE, groove, groove_of, hills, nowhere, sheets, slow_depth, slow_lack};
use curvlay_toolpath::gouging::{
    GougingError, GougingOptions, Moment, Nozzle, NozzleError, NozzlePart, NozzleShape, Obstacle, ResolvedPaths,
};
use curvlay_toolpath::layer::LayerStack;
use curvlay_toolpath::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use curvlay_toolpath::orientation::{OrientOptions, Pose, ToolPath, Waypoint};
use layers::{Layer, path, with_stack};
use nozzle::{inside, to_profile};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_4, PI};
use std::ops::ControlFlow;

/// A nozzle's measures: tip flat, half angle, height of the cone, block.
fn shape(tip_flat_mm: f64, half_angle: f64, cone_height_mm: f64, block_mm: f64) -> NozzleShape {
    NozzleShape { tip_flat_mm, half_angle, cone_height_mm, block_mm }
}

fn resolved_with(layers: &[Layer], paths: &[ToolPath], options: &GougingOptions) -> ResolvedPaths {
    with_stack(layers, |stack| stack.resolve_gouging(paths.to_vec(), &tip_1_mm(), options, &go_on).unwrap())
}

/// Nothing but earlier layers, nothing left out, and no smoothing for paths of two waypoints.
fn alone() -> GougingOptions {
    let default = GougingOptions::default();
    let never = GougingOptions { max_lift: 0.0, max_depth: f64::INFINITY, ..default };
    GougingOptions { max_turn: PI, max_turn_per_mm: f64::INFINITY, own_layer: false, plate: false, ..never }
}

#[test]
fn a_tip_that_no_tilt_frees_is_raised_as_little_as_does() {
    // In the middle of a level layer, 0.4 of its height below its top: a quarter is allowed, and every tilt goes deeper.
    let floor = Layer::sheet([0.0, 0.0, 10.0], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0], 20, H);
    let tip = Point3::new(20.0, 20.0, 10.0 + 0.5 * H - 0.4 * H);
    let raised = |max_lift: f64| {
        let (resolved, direction) =
            at(std::slice::from_ref(&floor), tip, Vector3::z(), &GougingOptions { max_lift, ..alone() });
        assert!(direction.angle(&Vector3::z_axis()) < 1e-3, "{direction:?}");
        resolved
    };
    for never in [0.0, 0.1] {
        let resolved = raised(never);
        assert_eq!((resolved.left.len(), resolved.lifted, resolved.max_lift), (2, 0, 0.0));
        assert_eq!(resolved.paths[0].waypoints[0].position, tip);
    }
    let resolved = raised(0.5);
    assert_eq!((resolved.left.len(), resolved.lifted), (0, 2));
    assert!((0.15 * H - PIECE..=0.15 * H + 0.025 * H).contains(&resolved.max_lift), "{}", resolved.max_lift / H);
    let waypoint = resolved.paths[0].waypoints[1];
    assert!((waypoint.lift.norm() - resolved.max_lift).abs() < 1e-12);
    assert!(
        (waypoint.position - tip - Vector3::z() * resolved.max_lift).norm() < 1e-9
            && (waypoint.bead_top() - tip).norm() < 1e-12
    );
}

#[test]
fn a_tip_is_raised_across_the_layer_however_the_nozzle_leans() {
    // The same floor in front of a wall: the nozzle has to lean as well, and the edge of its tip goes deeper.
    let floor = Layer::sheet([0.0, -20.0, -0.1 * H], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0], 20, H);
    let tip = Point3::new(6.0, 0.0, 0.0);
    let options = GougingOptions { max_lift: 1.0, ..alone() };
    let (resolved, direction) = at(&[wall(), floor], tip, Vector3::z(), &options);
    assert_eq!((resolved.left.len(), resolved.lifted), (0, 2));
    assert!(direction.x > 0.2, "{direction:?}");
    let waypoint = resolved.paths[0].waypoints[0];
    assert!(waypoint.lift.xy().norm() < 1e-12 && waypoint.lift.z > 0.2 * H, "{:?}", waypoint.lift);
    assert!((waypoint.position - tip - waypoint.lift).norm() < 1e-12);
}

/// Frees a nozzle at one place, given twice.
fn at(
    layers: &[Layer],
    tip: Point3<f64>,
    direction: Vector3<f64>,
    options: &GougingOptions,
) -> (ResolvedPaths, UnitVector3<f64>) {
    let all: Vec<Layer> = layers.iter().cloned().chain([nowhere()]).collect();
    let resolved = resolved_with(&all, &[path(layers.len() as u32, &[(tip, direction), (tip, direction)])], options);
    let [one, other] = [0, 1].map(|k| resolved.paths[0].waypoints[k].axis);
    assert_eq!(one, other);
    (resolved, one)
}

proptest! {
    #[test]
    fn clearance_is_a_distance_but_before_edges(z in -6.0_f64..20.0, rho in 0.0_f64..18.0) {
        let (clearance, distance) = (tip_1_mm().clearance(z, rho), to_profile(z, rho));
        if inside(z, rho) {
            prop_assert!(clearance <= 0.0 && -clearance <= distance + 1e-12);
        } else {
            prop_assert!(clearance >= -1e-12 && clearance <= distance + 1e-12, "{clearance} {distance}");
            prop_assert!(clearance >= distance * (3.0 * PI / 8.0).cos() - 1e-12, "{clearance} {distance}");
        }
    }

    #[test]
    fn clearance_changes_no_more_than_the_point_moves(a in prop::array::uniform2(-3.0_f64..14.0), b in prop::array::uniform2(-3.0_f64..14.0)) {
        let [c, d] = [a, b].map(|[z, rho]| tip_1_mm().clearance(z, rho));
        prop_assert!((c - d).abs() <= (a[0] - b[0]).hypot(a[1] - b[1]) + 1e-12);
    }
}

#[test]
fn a_nozzle_that_gouges_a_quarter_of_the_way_goes_round() {
    // From 60 degrees on one side to 60 on the other, past a pin at 30 that is a little aside: at both ends and half way
    // nothing is near.
    let lean = |degrees: f64| Vector3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
    let pin = lean(30.0) * 5.0 + Vector3::y() * 0.9;
    let pin = Layer::sheet([pin.x - 0.5, pin.y - 0.5, pin.z], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 4, H);
    let layers = [pin, nowhere()];
    let nozzle = Nozzle::new(shape(0.5, 10_f64.to_radians(), 20.0, 8.0)).unwrap();
    let paths = [path(1, &[(Point3::origin(), lean(60.0)), (Point3::new(0.0, 0.2, 0.0), lean(-60.0))])];
    let gouging = |paths: &[ToolPath], stack: &LayerStack| {
        let contacts = stack.contacts(paths, &nozzle, &alone(), &go_on).unwrap();
        let waypoints = &paths[0].waypoints;
        let looks = (0..waypoints.len() - 1).flat_map(|k| (0..=8).map(move |look| (k, f64::from(look) / 8.0)));
        let is_free = |&(k, share): &(usize, f64)| {
            let [from, to] = [&waypoints[k], &waypoints[k + 1]];
            let tip = from.position + (to.position - from.position) * share;
            let direction = UnitVector3::new_normalize(from.axis.slerp(&to.axis, share).into_inner());
            contacts.is_free(Moment::At { path: 0, waypoint: k }, &Pose { tip, direction }).unwrap()
        };
        looks.filter(|look| !is_free(look)).map(|(_, share)| share).collect::<Vec<f64>>()
    };
    with_stack(&layers, |stack| {
        let before = gouging(&paths, stack);
        assert!(before.contains(&0.25) && !before.iter().any(|share| [0.0, 0.5, 1.0].contains(share)), "{before:?}");
        let resolved = stack.resolve_gouging(paths.to_vec(), &nozzle, &alone(), &go_on).unwrap();
        assert!(resolved.added > 0 && resolved.left.is_empty());
        assert_eq!(gouging(&resolved.paths, stack), Vec::<f64>::new());
    });
}

#[test]
fn over_a_level_layer_nothing_gouges() {
    let level = |k: u32| Layer::sheet([0.0, 0.0, H * (f64::from(k) + 0.5)], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0], 9, H);
    let z = |k: u32| H * (f64::from(k) + 0.5);
    let zigzag = |k: u32| {
        let row = |r: u32| {
            let y = 5.0 + 0.8 * f64::from(r);
            let x = [4.0, 16.0];
            let (from, to) = if r.is_multiple_of(2) { (x[0], x[1]) } else { (x[1], x[0]) };
            [[from, y, z(k)], [to, y, z(k)]]
        };
        level(k).with(&(0..8).flat_map(row).collect::<Vec<_>>(), 0.8)
    };
    let layers = [zigzag(0), zigzag(1), zigzag(2)];
    let (paths, resolved) = with_stack(&layers, |stack| {
        let oriented = stack.orient(&OrientOptions::default(), &go_on).unwrap();
        let resolved =
            stack.resolve_gouging(oriented.paths.clone(), &tip_1_mm(), &GougingOptions::default(), &go_on).unwrap();
        (oriented.paths, resolved)
    });
    assert_eq!((resolved.gouging_before, resolved.tilted, resolved.left.len(), resolved.added), (0, 0, 0, 0));
    assert_eq!(resolved.paths, paths);
    // With the tip in the middle of the layer, beads beside the nozzle are in the way of its tip.
    let sunk = with_stack(&layers, |stack| {
        let oriented = stack.orient(&OrientOptions { lift: 0.0, ..OrientOptions::default() }, &go_on).unwrap();
        stack.resolve_gouging(oriented.paths, &tip_1_mm(), &GougingOptions::default(), &go_on).unwrap()
    });
    assert!(sunk.gouging_before > 0);
}

/// An upright wall at x = 0, facing +x, much higher than the nozzle is wide.
fn wall() -> Layer {
    Layer::sheet([0.0, -40.0, -30.0], [0.0, 80.0, 0.0], [0.0, 0.0, 90.0], 12, H)
}

#[test]
fn in_front_of_a_wall_it_leans_away_by_the_closed_form() {
    // What is left of the wall without its skin is H / 4 thick on either side. Leaning by t, the lower edge of the block comes
    // as near as 10 cos t - 8 sin t; grown by the slack m of caps, (10 + m) cos t - (8 - m) sin t.
    let lean = |distance: f64, m: f64| {
        let (radius, height) = (10.0 + m, 8.0 - m);
        (distance / f64::hypot(radius, height)).acos() - (height / radius).atan()
    };
    for distance in [1.5, 3.0, 6.0, 9.0] {
        let (resolved, direction) = at(&[wall()], Point3::new(distance, 0.0, 0.0), Vector3::z(), &alone());
        assert_eq!((resolved.gouging_before, resolved.left.len(), resolved.tilted), (2, 0, 2));
        let tilt = direction.angle(&Vector3::z());
        let (least, most) = (lean(distance - H / 4.0, 0.0), lean(distance - H / 4.0, PIECE));
        assert!(tilt >= least - 2e-3 && tilt <= most + 1e-6, "{distance}: {least} {tilt} {most}");
        // Sideways it may be off as far as the slack lets it.
        assert!(direction.x > 0.0 && direction.y.abs() < 0.06, "{direction:?}");
        assert!((resolved.max_tilt - tilt).abs() < 1e-9);
    }
    // Beyond the block it may stand upright.
    let (resolved, _) = at(&[wall()], Point3::new(10.0 + H / 4.0 + 1e-6, 0.0, 0.0), Vector3::z(), &alone());
    assert_eq!(resolved.gouging_before, 0);
}

#[test]
fn a_later_layer_is_not_in_the_way() {
    let tip = Point3::new(3.0, 0.0, 0.0);
    let paths = [path(0, &[(tip, Vector3::z()), (tip, Vector3::z())])];
    assert_eq!(resolved_with(&[nowhere(), wall()], &paths, &alone()).gouging_before, 0);
    let paths = [path(1, &[(tip, Vector3::z()), (tip, Vector3::z())])];
    assert_eq!(resolved_with(&[wall(), nowhere()], &paths, &alone()).gouging_before, 2);
}

#[test]
fn above_the_plate_it_leans_no_farther_than_the_plate_lets_it() {
    let options = GougingOptions { plate: true, ..alone() };
    let lying = Vector3::new(1.0, 0.0, 0.2);
    for (height, expected) in [(1.0, 0.8_f64.atan() + (1.0 / 164_f64.sqrt()).asin()), (0.2, 0.4_f64.asin())] {
        let (resolved, direction) = at(&[], Point3::new(0.0, 0.0, height), lying, &options);
        assert_eq!((resolved.gouging_before, resolved.left.len()), (2, 0));
        assert!((direction.angle(&Vector3::z()) - expected).abs() < 1e-6, "{height}: {direction:?}");
        assert!(direction.y.abs() < 1e-9 && direction.x > 0.0);
    }
    // With a clearance the plate is so much higher, but by no more than half the height of the tip.
    let aloof = GougingOptions { plate_clearance: 0.3, ..options };
    let lean = |height: f64, options| at(&[], Point3::new(0.0, 0.0, height), lying, options).1.angle(&Vector3::z());
    assert!((lean(1.3, &aloof) - lean(1.0, &options)).abs() < 1e-9 && lean(1.3, &options) > lean(1.0, &options) + 0.01);
    assert!((lean(0.4, &aloof) - lean(0.2, &options)).abs() < 1e-9);
    // Below the plate there is no way out.
    let (resolved, _) = at(&[], Point3::new(0.0, 0.0, -0.3), Vector3::z(), &options);
    assert_eq!((resolved.left.len(), resolved.left[0].obstacle), (2, Obstacle::Plate));
    assert!((resolved.left[0].depth - 0.3).abs() < 1e-12);
}

#[test]
fn a_wide_groove_leaves_it_upright_and_a_narrow_one_no_way_out() {
    let tip = Point3::new(0.0, 0.0, 0.0);
    // The block's edge is at 51.3 degrees from the tip.
    let (resolved, direction) = at(&[groove(0.95, 2.0)], tip, Vector3::z(), &alone());
    assert_eq!((resolved.gouging_before, direction), (0, Vector3::z_axis()));
    let (resolved, _) = at(&[groove(0.3, 2.0)], tip, Vector3::z(), &alone());
    assert_eq!(resolved.left.len(), 2);
    assert_eq!(
        (resolved.left[0].path, resolved.left[0].waypoint, resolved.left[0].obstacle),
        (0, 0, Obstacle::Layer(0))
    );
    let depth = slow_depth(&sheets(&[groove(0.3, 2.0)], 0.1), tip, &resolved.paths[0].waypoints[0].axis);
    assert!((resolved.left[0].depth - depth).abs() < 0.05, "{} {depth}", resolved.left[0].depth);
    // In a groove that leans, it leans along.
    let by = Isometry3::rotation(Vector3::y() * 0.6);
    let (resolved, direction) = at(&[groove(0.95, 2.0).moved(&by)], tip, Vector3::z(), &alone());
    assert_eq!(resolved.left.len(), 0);
    assert!(resolved.gouging_before == 2 && direction.x > 0.0 && direction.angle(&Vector3::z()) < 0.6);
}

/// Beads along a narrow groove of one layer: high on one side, high on the other, and along its bottom.
fn lines_in_a_groove() -> (Layer, ToolPath) {
    let angle = 0.75_f64;
    let (sin, cos) = angle.sin_cos();
    // Its sides meet at z = -2. Squares are smaller than a bead.
    let sides = groove_of(angle, 4.0 * angle.tan(), 80);
    let on_side = |sign: f64, y: f64| {
        let foot = Point3::new(sign * 8.0 * sin, y, 8.0 * cos - 2.0);
        (foot + Vector3::new(-sign * cos, 0.0, sin) * (H / 2.0), Vector3::new(-sign * cos, 0.0, sin))
    };
    let bottom = |y: f64| (Point3::new(0.0, y, -1.0), Vector3::z());
    let ys = || (-15..=15).map(f64::from);
    let up: Vec<_> = ys().map(|y| on_side(1.0, y)).collect();
    let back: Vec<_> = ys().map(|y| on_side(-1.0, -y)).collect();
    let along: Vec<_> = ys().map(bottom).collect();
    (sides, path(0, &[up, back, along].concat()))
}

#[test]
fn from_its_end_a_path_finds_room_that_it_takes_away_from_its_start() {
    let (layer, lines) = lines_in_a_groove();
    let options = GougingOptions { cut: false, own_layer: true, ..alone() };
    let forward = resolved_with(
        std::slice::from_ref(&layer),
        std::slice::from_ref(&lines),
        &GougingOptions { reverse: false, ..options },
    );
    // Along the bottom both sides are in the way but near the ends.
    assert!(forward.left.len() > 15 && forward.reversed.is_empty(), "{:?}", forward.left);
    assert!(forward.left.iter().all(|gouge| gouge.own_layer && gouge.obstacle == Obstacle::Layer(0)));
    assert!(forward.left.iter().all(|gouge| gouge.waypoint >= 62));
    // From the other end the bottom comes first, and is free.
    let resolved = resolved_with(std::slice::from_ref(&layer), std::slice::from_ref(&lines), &options);
    assert_eq!((resolved.left.len(), &resolved.reversed[..]), (0, &[0][..]));
    let (from, to) = (&lines.waypoints, &resolved.paths[0].waypoints);
    let length = from.last().unwrap().arc;
    for (w, v) in from.iter().zip(to.iter().rev()) {
        assert!(w.position == v.position && (v.arc - (length - w.arc)).abs() < 1e-9);
    }
}

#[test]
fn earlier_layers_close_in_whatever_the_own_one_does() {
    let tip = Point3::origin();
    let (resolved, _) = at(&[groove(0.3, 2.0)], tip, Vector3::z(), &GougingOptions { own_layer: true, ..alone() });
    assert!(resolved.left.len() == 2 && resolved.left.iter().all(|gouge| !gouge.own_layer));
    assert!(resolved.left.iter().all(|gouge| gouge.part == NozzlePart::Cone), "{:?}", resolved.left);
}

#[test]
fn what_only_smooths_a_turn_is_taken_out_where_it_gouges() {
    let up = Point3::new(0.0, 0.0, 200.0);
    let mut dip = path(1, &[(up, Vector3::z()), (Point3::origin(), Vector3::z()), (up, Vector3::z())]);
    let layers = [groove(0.3, 2.0), nowhere()];
    let sample = resolved_with(&layers, std::slice::from_ref(&dip), &alone());
    assert_eq!((sample.left.len(), sample.left[0].waypoint, sample.taken_out), (1, 1, 0));
    dip.waypoints[1].added = true;
    let resolved = resolved_with(&layers, &[dip], &alone());
    assert_eq!((resolved.gouging_before, resolved.left.len(), resolved.taken_out, resolved.added), (1, 0, 1, 0));
    assert_eq!(resolved.paths[0].waypoints.len(), 2);
}

#[test]
fn the_side_of_a_layer_may_be_entered_by_a_quarter() {
    // A level sheet at the height of the nozzle's tip edge, its edge beside the tip flat of radius 0.5.
    let sheet = |x: f64| Layer::sheet([x, -5.0, 0.05], [9.0, 0.0, 0.0], [0.0, 10.0, 0.0], 12, H);
    let gouges = |x: f64| at(&[sheet(x)], Point3::origin(), Vector3::z(), &alone()).0.gouging_before > 0;
    // Sheets are at 0.05 and 0.25, where the nozzle is 0.55 and 0.75 wide.
    assert!(!gouges(0.75 - H / 4.0 + 0.02));
    assert!(gouges(0.75 - H / 4.0 - 0.02));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn what_is_freed_is_free_and_what_is_left_is_that_deep(seed in 0_u64..300) {
        let (layer, tips) = hills(seed);
        let raster = sheets(std::slice::from_ref(&layer), 0.08);
        for tip in tips {
            let (resolved, direction) = at(std::slice::from_ref(&layer), tip, Vector3::z(), &alone());
            let depth = slow_depth(&raster, tip, &direction);
            match resolved.left.first() {
                None => prop_assert!(depth <= 0.25 * H + PIECE + 1e-9, "{depth}"),
                // A raster of 0.08 mm is at most 0.05 mm from the worst point.
                Some(left) => prop_assert!(left.depth >= depth - PIECE && left.depth <= depth + 0.06, "{left:?} {depth}"),
            }
            let upright = slow_depth(&raster, tip, &Vector3::z_axis());
            if upright > 0.25 * H + PIECE {
                prop_assert!(resolved.gouging_before == 2);
            }
            if upright < 0.25 * H - 0.06 {
                prop_assert!(resolved.gouging_before == 0 && direction == Vector3::z_axis());
            }
        }
    }

    #[test]
    fn no_smaller_tilt_frees(seed in 0_u64..300) {
        let (layer, tips) = hills(seed);
        // A direction is clear for sure if the raster lacks nothing with its own error and the slack of caps on top.
        let spread = 0.18;
        let raster = sheets(std::slice::from_ref(&layer), 0.3);
        for tip in tips.into_iter().take(2) {
            let (resolved, direction) = at(std::slice::from_ref(&layer), tip, Vector3::z(), &GougingOptions { max_tilt: 1.3, ..alone() });
            if resolved.gouging_before == 0 {
                continue;
            }
            let least = if resolved.left.is_empty() { direction.angle(&Vector3::z()) } else { 1.3 };
            for k in 0..400 {
                // Spread evenly over the cap of directions with less tilt: a sunflower.
                let share = (f64::from(k) + 0.5) / 400.0;
                let tilt = (1.0 - share * (1.0 - least.cos())).acos();
                let (sin, cos) = (f64::from(k) * PI * (3.0 - 5_f64.sqrt())).sin_cos();
                let other = Vector3::new(cos * tilt.sin(), sin * tilt.sin(), tilt.cos());
                let lack = slow_lack(&raster, tip, &UnitVector3::new_normalize(other));
                prop_assert!(lack < spread + PIECE, "tilt {tilt} of {least} keeps {lack}");
            }
        }
    }

    #[test]
    fn a_rigid_motion_moves_the_tilts(seed in 0_u64..300, turn in prop::array::uniform3(-3.0_f64..3.0)) {
        moved_alike(seed, turn)?;
    }
}

/// Frees the same nozzles in two frames.
fn moved_alike(seed: u64, turn: [f64; 3]) -> Result<(), TestCaseError> {
    let by = Isometry3::new(Vector3::new(7.0, -3.0, 5.0), Vector3::from(turn));
    let (layer, tips) = hills(seed);
    for tip in tips {
        let (here, direction) = at(std::slice::from_ref(&layer), tip, Vector3::z(), &alone());
        let (there, moved) = at(&[layer.moved(&by)], by * tip, by * Vector3::z(), &alone());
        let found = [(here, direction), (there, by.inverse() * moved)];
        let free: Vec<UnitVector3<f64>> =
            found.iter().filter(|(of, _)| of.left.is_empty()).map(|(_, free)| *free).collect();
        let tilts: Vec<f64> = free.iter().map(|free| free.angle(&Vector3::z())).collect();
        match free[..] {
            [] => prop_assert_eq!(found[0].0.left.len(), found[1].0.left.len()),
            [_, _] if (tilts[0] - tilts[1]).abs() < 0.05 => {}
            // Rounding may make other cuts. What both miss of the least tilt is then within the slack of caps, but where the
            // lesser one, or the only one, is so deep that the search with that slack does not see it.
            _ => {
                let lesser = free[usize::from(tilts.len() > 1 && tilts[1] < tilts[0])];
                let depth = slow_depth(&sheets(std::slice::from_ref(&layer), 0.08), tip, &lesser);
                prop_assert!(depth > 0.25 * H - PIECE - 0.06, "{tilts:?} {depth}");
            }
        }
    }
    Ok(())
}

/// Directions so close to the allowed depth that a search with the slack of caps found them in one frame only.
#[test]
fn what_is_barely_free_is_found_in_every_frame() {
    moved_alike(63, [0.0, 0.4440355646559515, -1.523831616905735]).unwrap();
    moved_alike(244, [-0.9715289838263557, 1.783698624268615, 2.1686454441730096]).unwrap();
    moved_alike(231, [0.0, 2.164226966132162, 0.0]).unwrap();
    // Free in one frame alone.
    moved_alike(280, [-2.554232376923183, 2.873514985693713, 2.907984396068748]).unwrap();
}

/// A path over a plain, with a wall beside it for a while.
fn past_a_wall() -> Vec<Layer> {
    let plain = Layer::sheet([-30.0, -60.0, 9.6], [60.0, 0.0, 0.0], [0.0, 120.0, 0.0], 40, H);
    let line: Vec<[f64; 3]> = vec![[7.0, -45.0, 10.4], [7.0, 45.0, 10.4]];
    let floor = Layer::sheet([-30.0, -60.0, 10.4], [60.0, 0.0, 0.0], [0.0, 120.0, 0.0], 40, H).with(&line, 0.8);
    let wall = Layer::sheet([0.0, -10.0, 10.4], [0.0, 20.0, 0.0], [0.0, 0.0, 30.0], 20, H);
    vec![plain, wall, floor]
}

fn along_the_wall(options: &GougingOptions) -> (Vec<ToolPath>, ResolvedPaths) {
    with_stack(&past_a_wall(), |stack| {
        let oriented = stack.orient(&OrientOptions::default(), &go_on).unwrap();
        let resolved = stack.resolve_gouging(oriented.paths.clone(), &tip_1_mm(), options, &go_on).unwrap();
        (oriented.paths, resolved)
    })
}

#[test]
fn tilts_are_ramped_along_the_path() {
    let (before, resolved) = along_the_wall(&GougingOptions::default());
    assert!(resolved.gouging_before > 20 && resolved.left.is_empty() && resolved.cut_turns.is_empty(), "{resolved:?}");
    assert!(resolved.tilted > resolved.gouging_before);
    assert!(resolved.turns.largest <= 10_f64.to_radians() + 1e-8);
    // Tips stay, far from the wall directions too, and everything is still free.
    let waypoints = &resolved.paths[0].waypoints;
    for w in &before[0].waypoints {
        assert!(waypoints.iter().any(|v| v.position == w.position));
    }
    assert_eq!(waypoints[0].axis, before[0].waypoints[0].axis);
    let raster = sheets(&past_a_wall()[1..2], 0.1);
    for w in waypoints.iter().step_by(5) {
        assert!(slow_depth(&raster, w.position, &w.axis) <= 0.25 * H + PIECE);
    }
    // A narrower limit takes a longer ramp.
    let (_, gentle) = along_the_wall(&GougingOptions { max_turn: 2_f64.to_radians(), ..GougingOptions::default() });
    assert!(gentle.turns.largest <= 2_f64.to_radians() + 1e-8 && gentle.left.is_empty(), "{:?}", gentle.turns);
    // Of the waypoints given: points put between count as tilted, too.
    let ramp = |resolved: &ResolvedPaths| {
        let is_tilted = |w: &&Waypoint| {
            resolved.paths[0].waypoints.iter().any(|v| v.position == w.position && v.axis.angle(&w.axis) > 1e-9)
        };
        before[0].waypoints.iter().filter(is_tilted).count()
    };
    assert!(ramp(&gentle) > ramp(&resolved), "{} {}", ramp(&gentle), ramp(&resolved));
}

#[test]
fn threads_change_nothing() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| along_the_wall(&GougingOptions::default()))
    };
    assert_eq!(on(1), on(4));
}

#[test]
fn nozzles_that_cannot_be_are_named() {
    let angle = FRAC_PI_4;
    for (value, given) in
        [(0.0, [0.0, 8.0, 20.0]), (f64::NAN, [1.0, f64::NAN, 20.0]), (f64::INFINITY, [1.0, 8.0, f64::INFINITY])]
    {
        let error = Nozzle::new(shape(given[0], angle, given[1], given[2])).unwrap_err();
        assert!(matches!(error, NozzleError::Measure { value: v, .. } if v.to_bits() == value.to_bits()), "{error}");
    }
    for half_angle in [0.0, -1.0, PI / 2.0, f64::NAN] {
        assert!(matches!(Nozzle::new(shape(1.0, half_angle, 8.0, 20.0)), Err(NozzleError::HalfAngle { .. })));
    }
    assert_eq!(Nozzle::new(shape(9.0, 0.1, 8.0, 20.0)), Err(NozzleError::WiderThanHigh { tip_flat: 9.0, height: 8.0 }));
    let block = Nozzle::new(shape(1.0, angle, 8.0, 16.0)).unwrap_err();
    assert!(matches!(block, NozzleError::Block { block, cone } if block < cone), "{block}");
}

#[test]
fn paths_and_options_that_cannot_be_used_are_named() {
    let layers = [nowhere(), nowhere()];
    let error = |paths: &[ToolPath], options: &GougingOptions| {
        with_stack(&layers, |stack| stack.resolve_gouging(paths.to_vec(), &tip_1_mm(), options, &go_on).unwrap_err())
    };
    let default = GougingOptions::default();
    let good = path(1, &[(Point3::origin(), Vector3::z()), (Point3::new(1.0, 0.0, 0.0), Vector3::z())]);
    for (name, options) in [
        ("allowed_depth", GougingOptions { allowed_depth: 0.6, ..default }),
        ("allowed_depth", GougingOptions { allowed_depth: f64::NAN, ..default }),
        ("max_lift", GougingOptions { max_lift: -0.1, ..default }),
        ("max_lift", GougingOptions { max_lift: f64::NAN, ..default }),
        ("max_depth", GougingOptions { max_depth: 0.2, ..default }),
        ("max_depth", GougingOptions { max_depth: f64::NAN, ..default }),
        ("max_tilt", GougingOptions { max_tilt: 4.0, ..default }),
        ("max_turn", GougingOptions { max_turn: 0.0, ..default }),
        ("max_turn_per_mm", GougingOptions { max_turn_per_mm: 0.0, ..default }),
        ("max_turn_per_mm", GougingOptions { max_turn_per_mm: f64::NAN, ..default }),
        ("plate_clearance", GougingOptions { plate_clearance: -0.1, ..default }),
        ("plate_clearance", GougingOptions { plate_clearance: f64::INFINITY, ..default }),
    ] {
        let error = error(std::slice::from_ref(&good), &options);
        assert!(matches!(error, GougingError::Option { option, .. } if option == name), "{error}");
    }
    let later = ToolPath { layer: 2, ..good.clone() };
    assert_eq!(error(&[good.clone(), later], &default), GougingError::Layer { path: 1, layer: 2, layers: 2 });
    let back = ToolPath { layer: 0, ..good.clone() };
    assert_eq!(error(&[good.clone(), back], &default), GougingError::Layer { path: 1, layer: 0, layers: 2 });
    let one = ToolPath { waypoints: good.waypoints[..1].to_vec(), ..good.clone() };
    assert_eq!(error(&[one], &default), GougingError::FewWaypoints { path: 0, waypoints: 1 });
    let mut nan = good.clone();
    nan.waypoints[1].position.x = f64::NAN;
    assert_eq!(error(&[nan], &default), GougingError::BadWaypoint { path: 0, waypoint: 1 });
    let mut zero = good.clone();
    zero.waypoints[0].axis = UnitVector3::new_unchecked(Vector3::zeros());
    assert_eq!(error(&[zero], &default), GougingError::BadWaypoint { path: 0, waypoint: 0 });
    let cancelled = with_stack(&layers, |stack| {
        stack.resolve_gouging(vec![good.clone()], &tip_1_mm(), &default, &|_| ControlFlow::Break(())).unwrap_err()
    });
    assert_eq!(cancelled, GougingError::Cancelled);
}
