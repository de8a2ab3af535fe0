//! Volume decomposition: the shapes of the paper, every option, every error, and the audit against spoilt results.

use super::region::{polygon, rectangle};
use super::shapes::{
    assert_manifold, bend, blocks, cells, crank, ell, hook, knot, mushroom, sound_blocks, tee, turned,
};
use curvlay_layers::nalgebra::{Point2, Vector3};
use curvlay_layers::planar::{
    AuditOptions, BaseChoice, FeatureKind, Region, Scenario, Solid, StuckReason, VolumeDecomposition, VolumeError,
    VolumeOptions, VolumePart, audit_volumes, decompose_volume, largest_rectangle,
};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::ops::ControlFlow;

fn decompose(solid: &Solid, options: &VolumeOptions) -> VolumeDecomposition {
    decompose_volume(solid, options, &|_| ControlFlow::Continue(())).unwrap()
}

/// Decomposes a solid to the end, and checks what holds for every result.
fn whole(solid: &Solid, options: &VolumeOptions) -> VolumeDecomposition {
    let result = decompose(solid, options);
    assert!(result.stuck.is_empty(), "{:?}", result.stuck);
    let sum: f64 = result.parts.iter().map(|part| part.solid.volume()).sum();
    assert!((sum - solid.volume()).abs() <= 1e-9 * solid.volume());
    for part in &result.parts {
        assert_manifold(&part.solid);
        assert_eq!(part.overhang_mm3, 0.0);
    }
    let audit = audit_volumes(
        solid,
        &result.parts,
        options,
        &AuditOptions { lines: 40, points: 60, ..AuditOptions::default() },
    );
    assert!(audit.is_ok, "{audit:?}");
    for (part, found) in result.parts.iter().zip(&audit.parts) {
        let volume = part.solid.volume();
        assert!((found.layered_mm3 + found.unlayered_mm3 - volume).abs() <= 1e-9 * volume, "{found:?}");
        assert!(found.unlayered_mm3 <= 1e-9 * volume, "{found:?}");
    }
    result
}

fn directions(result: &VolumeDecomposition) -> Vec<[i32; 3]> {
    result.parts.iter().map(|part| [0, 1, 2].map(|k| part.direction[k].round() as i32)).collect()
}

#[test]
fn a_flipped_l_is_a_post_and_an_arm() {
    let result = whole(&ell(), &VolumeOptions::default());
    assert_eq!(directions(&result), [[0, 0, 1], [1, 0, 0]]);
    // The post carries 3 mm of the arm: its wall stands at x = 33.
    let arm = &result.parts[1];
    assert!((arm.base_mm - 33.0).abs() < 1e-6 && (arm.solid.volume() - 57.0 * 900.0).abs() < 1e-3, "{}", arm.base_mm);
    let step = &result.separations[0];
    assert_eq!((step.scenario, step.height_mm, step.walls.len()), (Scenario::Crossing, 60.0, 1));
    // Layers from 60 mm up hang over: from 33 mm on the first one, 3 mm less each.
    let by_hand: f64 = (0..10).map(|k| (90.0 - 33.05 - 3.0 * f64::from(k)) * 30.0 * 3.0).sum();
    assert!((result.overhang_before_mm3 - by_hand).abs() < 0.002 * by_hand, "{} {by_hand}", result.overhang_before_mm3);
    // The tilted wall: half a torch down for a stand-off along.
    let n = step.walls[0].tilted.normal();
    assert!((n.x / n.z - 12.5 / 15.0).abs() < 1e-12 && n.y == 0.0);
}

#[test]
fn a_t_has_two_arms() {
    let result = whole(&tee(), &VolumeOptions::default());
    let mut arms = directions(&result);
    assert_eq!(arms.remove(0), [0, 0, 1]);
    arms.sort_unstable();
    assert_eq!(arms, [[-1, 0, 0], [1, 0, 0]]);
    assert!(result.parts[1..].iter().all(|part| (part.solid.volume() - 27.0 * 900.0).abs() < 1e-3));
}

#[test]
fn of_a_mushroom_four_sides_go_in_the_inverse_order() {
    let solid = mushroom();
    let result = whole(&solid, &VolumeOptions::default());
    assert_eq!((result.separations.len(), result.separations[0].scenario), (1, Scenario::Enclosing));
    assert_eq!(directions(&result), [[0, 0, 1], [0, -1, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]]);
    // The largest rectangle in a circle is a square.
    let half = 20.0 / 2f64.sqrt();
    for part in &result.parts[1..] {
        assert!((part.base_mm - half).abs() < 0.1, "{} {half}", part.base_mm);
    }
    assert_eq!(result.separations[0].walls[3].upright.normal(), result.parts[1].direction);
}

#[test]
fn the_curved_part_bends_off_where_its_slope_passes_the_angle() {
    let result = whole(&bend(15.0, 32), &VolumeOptions::default());
    let step = &result.separations[0];
    assert_eq!(step.scenario, Scenario::Crossing);
    let [_, to_the_side] = directions(&result)[..] else { panic!("{:?}", directions(&result)) };
    assert_eq!(to_the_side, [1, 0, 0]);
    // The outer side of the bend has a radius of 75 mm about (60, 0, 40), the inner one, below, of 45 mm: it slopes by 45 degrees at
    // the height 40 + 45 sin 45 = 71.8. All that hangs over is above the height where the whole section stands on the one before.
    assert!(step.height_mm > 55.0 && step.height_mm < 80.0, "{}", step.height_mm);
    assert!(step.points.len() >= 2);
    let (point, normal) = step.interpolant.unwrap();
    // No plane is nearer to the points, in the sum of squares, than the interpolant one; the wall leaves all of them on one side.
    let squares = |normal: &Vector3<f64>| step.points.iter().map(|p| (p - point).dot(normal).powi(2)).sum::<f64>();
    for k in 0..200 {
        let turn = f64::from(k) * 0.7;
        let other = Vector3::new(turn.sin(), turn.cos() * 0.3 + f64::from(k) / 100.0 - 1.0, turn.cos()).normalize();
        assert!(squares(&normal) <= squares(&other) * (1.0 + 1e-9));
    }
    assert!(step.points.iter().all(|p| step.walls[0].upright.side(p) > 0));
    // The points are symmetrical about y = 0, as far as outlines are simplified.
    let sum: f64 = step.points.iter().map(|p| p.y).sum();
    assert!(sum.abs() < 0.0025 * step.points.len() as f64, "{sum}");
}

/// A crank, a hook that comes back under itself, and a knot: walls leave pieces on their near side that hold on to what is beyond alone.
fn winding() -> [(&'static str, Solid); 3] {
    [("crank", crank()), ("hook", hook()), ("knot", knot())]
}

fn slender() -> VolumeOptions {
    VolumeOptions { layer_mm: 2.0, min_layer_mm: 2.0, torch_diameter_mm: 12.0, ..VolumeOptions::default() }
}

#[test]
fn all_of_each_part_is_in_its_layers() {
    for (name, solid) in winding() {
        let result = decompose(&solid, &slender());
        let audit = audit_volumes(&solid, &result.parts, &slender(), &AuditOptions::default());
        let mut layered = 0.0;
        for (k, (part, found)) in result.parts.iter().zip(&audit.parts).enumerate() {
            // By the mesh alone.
            let [low, high] = part.solid.extent(&part.direction);
            assert!(low >= part.base_mm - 1e-6, "{name}, part {k}: {low} is behind {}", part.base_mm);
            assert!((part.layers.last().unwrap().high_mm - high).abs() < 1e-5, "{name}, part {k}");
            let volume = part.solid.volume();
            assert!((found.layered_mm3 + found.unlayered_mm3 - volume).abs() <= 1e-9 * volume, "{name}: {found:?}");
            assert!(found.unlayered_mm3 <= 1e-9 * volume, "{name}: {found:?}");
            layered += found.layered_mm3;
        }
        assert!((layered - solid.volume()).abs() < 1e-9 * solid.volume(), "{name}: {layered}");
        assert!(result.parts.len() <= slender().max_parts, "{name}");
    }
}

#[test]
fn what_loses_its_hold_behind_a_wall_is_printed_from_the_other_side() {
    // Journal, web, pin, web towards the axis, its end over the axis, journal.
    let result = whole(&crank(), &slender());
    let all = [[0, 0, 1], [1, 0, 0], [0, 0, 1], [-1, 0, 0], [-1, 0, 0], [0, 0, 1]];
    assert_eq!(directions(&result), all);
    // Both webs end at the wall, beyond which the torch lays the lower one first.
    assert_eq!(result.parts[1].base_mm, -result.parts[4].base_mm);
    // The hook needs its walls and no slivers.
    let result = whole(&hook(), &slender());
    assert!(result.parts.len() <= 6, "{}", result.parts.len());
}

#[test]
fn what_is_behind_a_base_is_found() {
    // The arm of an L with its base in the middle of it, carried by the post and the first half.
    let solid = ell();
    let options = VolumeOptions::default();
    let mut parts = decompose(&solid, &options).parts;
    let tops: Vec<f64> = (1..=9).map(|k| 63.0 + 3.0 * f64::from(k)).collect();
    let arm = VolumePart::sliced(parts[1].solid.clone(), &Vector3::x(), 63.0, &tops).unwrap();
    parts[1] = VolumePart { separation: Some(0), ..arm };
    let found = audit_volumes(&solid, &parts, &options, &AuditOptions::default());
    assert!(!found.is_ok && (found.parts[1].unlayered_mm3 - 30.0 * 900.0).abs() < 1e-3, "{:?}", found.parts[1]);
    assert!((found.parts[1].layered_mm3 - 27.0 * 900.0).abs() < 1e-3);
    assert!((found.parts[1].sections_mm3 - 27.0 * 900.0).abs() < 1e-3, "{:?}", found.parts[1]);
    // Sections that are not those of the mesh are found, unless features are left out.
    parts[1] = decompose(&solid, &options).parts.remove(1);
    parts[1].layers[4].section = Region::default();
    let found = audit_volumes(&solid, &parts, &options, &AuditOptions::default());
    assert!(!found.is_ok && (found.parts[1].left_out_mm3 - 2700.0).abs() < 200.0, "{:?}", found.parts[1]);
    // A layer 2 mm wider hangs nowhere, but is not that of the mesh either.
    let mut wider = decompose(&solid, &options).parts;
    wider[1].layers[4].section = wider[1].layers[4].section.offset(2.0).unwrap();
    let audit = |min_feature_mm: f64| {
        audit_volumes(&solid, &wider, &VolumeOptions { min_feature_mm, ..options }, &AuditOptions::default())
    };
    let spoilt = &audit(0.0).parts[1];
    assert!(spoilt.added_mm3 > 500.0 && spoilt.unsupported_mm2 <= 0.0, "{spoilt:?}");
    assert_eq!([audit(0.0).is_ok, audit(6.0).is_ok], [false, true]);
    // What lies on the layer that is not there hangs.
    assert!(found.parts[1].unsupported_mm2 > 500.0);
}

#[test]
fn the_audit_says_where_the_torch_is_blocked() {
    let options = VolumeOptions::default();
    let blocked = |parts: &[VolumePart], of: usize, options: &VolumeOptions| {
        audit_volumes(&ell(), parts, options, &AuditOptions::default()).parts[of].blocked_mm2
    };
    // An arm whose underside is 60 mm over the plate: a torch of 25 mm passes, one whose radius is 70 mm is in the plate with the lower 10 mm.
    let parts = decompose(&ell(), &options).parts;
    assert_eq!(blocked(&parts, 1, &options), 0.0);
    let wide = VolumeOptions { torch_diameter_mm: 140.0, ..options };
    let area = 19.0 * 30.0 * 10.0;
    let found = blocked(&parts, 1, &wide);
    assert!((found - area).abs() < 0.1 * area, "{found} {area}");
    // The post after the arm: the torch is in the arm where that is above the layers, or nearer than its cone is wide.
    let swapped = [parts[1].clone(), parts[0].clone()];
    let found = blocked(&swapped, 1, &options);
    // Within 12.5 mm of the arm, which is beside the post from x = 33 on, at all layers below it.
    assert!(found > 0.25 * parts[0].solid.volume() / 3.0, "{found}");
}

#[test]
fn walls_are_chosen_so_that_the_torch_passes() {
    // A shelf 8 mm over the plate: with an upright wall the torch, 12.5 mm in radius, is in the plate while it lays its lower side.
    let mut all = cells([0, 0, 0], [4, 4, 10]);
    all.extend(cells([4, 0, 2], [9, 4, 5]));
    let solid = blocks(&all, 4.0);
    let options = VolumeOptions { layer_mm: 2.0, min_layer_mm: 2.0, ..VolumeOptions::default() };
    let result = whole(&solid, &options);
    let audit = audit_volumes(&solid, &result.parts, &options, &AuditOptions::default());
    let blocked = audit.sum(|part| part.blocked_mm2) / audit.sum(|part| part.layers_mm2);
    let shelf = &result.parts[1];
    assert!(shelf.direction.z > 0.3 && shelf.direction.x > 0.6, "{:?}", shelf.direction);
    assert!(blocked < 0.001, "{blocked}");
}

#[test]
fn a_part_without_overhang_stays_whole() {
    let post = blocks(&[[0; 3]], 40.0);
    let result = whole(&post, &VolumeOptions::default());
    assert_eq!((result.parts.len(), result.overhang_before_mm3, result.parts[0].layers.len()), (1, 0.0, 14));
    assert_eq!(result.parts[0].solid.volume(), 64e3);
    // A cone on its tip, leaning by less than the angle from upright, and by more.
    let cone = |radius: f64| turned(&[[0.0, 0.0], [radius, 60.0], [0.0, 60.0]], 32);
    assert_eq!(whole(&cone(50.0), &VolumeOptions::default()).parts.len(), 1);
    assert!(decompose(&cone(80.0), &VolumeOptions::default()).overhang_before_mm3 > 0.0);
    let steep = VolumeOptions { angle: 30_f64.to_radians(), ..VolumeOptions::default() };
    assert_eq!(whole(&cone(80.0), &steep).parts.len(), 1);
}

#[test]
fn the_base_with_the_least_overhang_is_found() {
    let best = VolumeOptions { base: BaseChoice::LeastOverhang, ..VolumeOptions::default() };
    let result = whole(&tee(), &best);
    assert_eq!(result.parts.len(), 1);
    // On its back, which is larger than its top.
    assert_eq!(result.parts[0].direction.y.abs(), 1.0);
    let along = VolumeOptions { base: BaseChoice::Along(Vector3::new(0.0, 0.0, -7.0)), ..VolumeOptions::default() };
    assert_eq!(directions(&whole(&tee(), &along)), [[0, 0, -1]]);
}

#[test]
fn layers_are_thin_where_the_section_changes() {
    let options =
        VolumeOptions { layer_mm: 4.0, min_layer_mm: 1.0, torch_diameter_mm: 10.0, ..VolumeOptions::default() };
    let dome: Vec<[f64; 2]> =
        (0..=12).map(|k| PI / 24.0 * f64::from(k)).map(|a| [40.0 * a.cos(), 20.0 + 40.0 * a.sin()]).collect();
    let mut profile = vec![[0.0, 0.0], [40.0, 0.0]];
    profile.extend(&dome[..12]);
    profile.push([0.0, 60.0]);
    let result = whole(&turned(&profile, 24), &options);
    let layers = &result.parts[0].layers;
    let heights: Vec<f64> = layers.iter().map(|layer| layer.high_mm - layer.low_mm).collect();
    assert_eq!(heights[..4], [4.0; 4]);
    assert!(heights.contains(&1.0) && heights.iter().all(|&height| height <= 4.0));
    assert!((layers.last().unwrap().high_mm - 60.0).abs() < 1e-9);
    let constant = whole(&turned(&profile, 24), &VolumeOptions { min_layer_mm: 4.0, ..options });
    assert_eq!(constant.parts[0].layers.len(), 15);
}

#[test]
fn small_holes_and_islands_are_listed() {
    // A block with an upright hole of 4 mm, and a pin of 4 mm on top.
    let mut all = cells([0, 0, 0], [12, 12, 6]);
    all.retain(|&[x, y, _]| [x, y] != [3, 3]);
    all.extend(cells([8, 8, 6], [9, 9, 8]));
    let solid = blocks(&all, 4.0);
    let options = VolumeOptions { min_feature_mm: 6.0, ..VolumeOptions::default() };
    let result = decompose(&solid, &options);
    let kinds: Vec<(FeatureKind, f64)> = result.features.iter().map(|f| (f.kind, f.size_mm.round())).collect();
    assert_eq!(kinds, [(FeatureKind::Hole, 4.0), (FeatureKind::Island, 4.0)], "{:?}", result.features);
    let hole = &result.features[0];
    assert!((hole.volume_mm3 - 16.0 * 24.0).abs() < 1e-6 && hole.from_mm == 0.0 && (hole.to_mm - 24.0).abs() < 1e-9);
    assert!((hole.middle - Point2::new(14.0, 14.0)).norm() < 1e-6);
    assert!(decompose(&solid, &VolumeOptions::default()).features.is_empty());
    // A hole across the layers is closed as well, so that its ceiling does not count.
    let mut all = cells([0, 0, 0], [12, 12, 12]);
    all.retain(|&[x, _, z]| [x, z] != [5, 5]);
    let drilled = blocks(&all, 4.0);
    let wide = VolumeOptions { layer_mm: 1.0, min_layer_mm: 1.0, ..VolumeOptions::default() };
    assert!(decompose(&drilled, &wide).overhang_before_mm3 > 0.0);
    let closed = decompose(&drilled, &VolumeOptions { min_feature_mm: 6.0, ..wide });
    assert_eq!((closed.overhang_before_mm3, closed.parts.len()), (0.0, 1));
    // Closing leaves a meniscus of 3 mm radius at each end of a slot of 4 mm.
    let meniscus = 9.0 * (2.0_f64 / 3.0).asin() - 2.0 * 5f64.sqrt();
    let filled: f64 = closed.features.iter().map(|f| f.volume_mm3).sum();
    assert!((filled - (16.0 * 48.0 - 2.0 * 4.0 * meniscus)).abs() < 0.5, "{filled}");
}

#[test]
fn a_part_that_must_not_be_divided_is_named() {
    let result = decompose(&tee(), &VolumeOptions { max_parts: 2, ..VolumeOptions::default() });
    assert_eq!((result.parts.len(), result.stuck.len(), result.stuck[0].reason), (2, 1, StuckReason::TooManyParts));
    let stuck = &result.parts[result.stuck[0].part];
    assert!(stuck.overhang_mm3 > 1000.0);
    let audit = audit_volumes(&tee(), &result.parts, &VolumeOptions::default(), &AuditOptions::default());
    assert!(!audit.is_ok && audit.parts[result.stuck[0].part].unsupported_mm2 > 100.0);
}

#[test]
fn the_audit_finds_what_is_spoilt() {
    let solid = ell();
    let options = VolumeOptions::default();
    let good = decompose(&solid, &options).parts;
    let audit =
        |parts: &[_]| audit_volumes(&solid, parts, &options, &AuditOptions { points: 60, ..AuditOptions::default() });
    assert!(audit(&good).is_ok);
    // The arm before its post: nothing carries its first layer.
    let swapped = [good[1].clone(), good[0].clone()];
    let found = audit(&swapped);
    assert!(
        !found.is_ok
            && found.missing_share < 1e-9
            && found.doubled_share < 1e-9
            && found.parts[0].unsupported_mm2 > 500.0
    );
    let missing = audit(&good[..1]);
    assert!(missing.missing_share > 0.3 && missing.volume_error > 0.3 && !missing.is_ok);
    let doubled = audit(&[good[0].clone(), good[1].clone(), good[1].clone()]);
    assert!(doubled.doubled_share > 0.3 && !doubled.is_ok);
    // All of it upright: the arm hangs over.
    let tops: Vec<f64> = (1..=30).map(|k| 3.0 * f64::from(k)).collect();
    let upright = VolumePart::sliced(solid.clone(), &Vector3::z(), 0.0, &tops).unwrap();
    let hanging = audit(&[upright]);
    assert!(hanging.volume_error < 1e-12 && hanging.parts[0].unsupported_mm2 > 1000.0 && !hanging.is_ok);
}

#[test]
fn options_that_make_no_sense_are_refused() {
    let refused =
        |options: VolumeOptions| decompose_volume(&tee(), &options, &|_| ControlFlow::Continue(())).unwrap_err();
    let d = VolumeOptions::default();
    for (options, name) in [
        (VolumeOptions { layer_mm: 0.0, ..d }, "layer_mm"),
        (VolumeOptions { layer_mm: f64::NAN, ..d }, "layer_mm"),
        (VolumeOptions { min_layer_mm: 4.0, ..d }, "min_layer_mm"),
        (VolumeOptions { angle: 0.0, ..d }, "angle"),
        (VolumeOptions { angle: PI / 2.0, ..d }, "angle"),
        (VolumeOptions { standoff_mm: -1.0, ..d }, "standoff_mm"),
        (VolumeOptions { tolerance_mm: 0.0, ..d }, "tolerance_mm"),
        (VolumeOptions { area_change: 0.0, ..d }, "area_change"),
        (VolumeOptions { min_feature_mm: -1.0, ..d }, "min_feature_mm"),
        // Offsets that no polygon can have: until 0.1.0 they panicked.
        (VolumeOptions { min_feature_mm: 1e308, ..d }, "min_feature_mm"),
        (VolumeOptions { min_feature_mm: f64::NAN, ..d }, "min_feature_mm"),
        (VolumeOptions { angle: 1e-300, ..d }, "angle"),
        (VolumeOptions { angle: f64::NAN, ..d }, "angle"),
        (VolumeOptions { layer_mm: 1e308, min_layer_mm: 1e308, ..d }, "layer_mm"),
        (VolumeOptions { tolerance_mm: 1e308, ..d }, "tolerance_mm"),
        (VolumeOptions { standoff_mm: 1e308, ..d }, "standoff_mm"),
        (VolumeOptions { max_parts: 0, ..d }, "max_parts"),
        (VolumeOptions { base: BaseChoice::Along(Vector3::zeros()), ..d }, "base"),
    ] {
        let error = refused(options);
        assert!(matches!(error, VolumeError::Option { option, .. } if option == name), "{name}: {error}");
    }
    assert_eq!(
        refused(VolumeOptions { torch_diameter_mm: 91.0, ..d }),
        VolumeError::Torch { torch_mm: 91.0, part_mm: 90.0 }
    );
    assert!(matches!(refused(VolumeOptions { min_layer_mm: 1e-3, ..d }), VolumeError::Layers { .. }));
    assert_eq!(decompose_volume(&tee(), &d, &|_| ControlFlow::Break(())), Err(VolumeError::Stopped));
}

fn area_of([low, high]: [Point2<f64>; 2]) -> f64 {
    (high.x - low.x) * (high.y - low.y)
}

#[test]
fn rectangles_in_known_shapes() {
    let circle: Vec<[f64; 2]> =
        (0..180).map(|k| PI * f64::from(k) / 90.0).map(|a| [10.0 * a.cos(), 10.0 * a.sin()]).collect();
    let found = largest_rectangle(&Region::new(&[polygon(&circle)]).unwrap()).unwrap();
    assert!((area_of(found) - 200.0).abs() < 0.3, "{}", area_of(found));
    // A square with a hole in the middle: beside it.
    let mut holed = rectangle([0.0, 0.0], [9.0, 9.0]);
    holed.holes.push(vec![[4.0, 4.0], [4.0, 5.0], [5.0, 5.0], [5.0, 4.0]].into_iter().map(Point2::from).collect());
    let found = largest_rectangle(&Region::new(&[holed]).unwrap()).unwrap();
    assert!((area_of(found) - 36.0).abs() < 1e-4, "{found:?}");
    let cross = Region::new(&[rectangle([-1.0, -6.0], [1.0, 6.0]), rectangle([-5.0, -1.0], [5.0, 1.0])]).unwrap();
    assert!((area_of(largest_rectangle(&cross).unwrap()) - 24.0).abs() < 1e-4);
    assert!(largest_rectangle(&Region::default()).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// Unions of whole boxes: the largest rectangle has its sides on whole numbers, so all of them can be tried.
    #[test]
    fn rectangles_are_as_large_as_the_best_of_all(boxes in prop::collection::vec((0..8_i32, 0..8_i32, 1..5_i32, 1..5_i32), 1..7)) {
        let inside = |x: i32, y: i32| boxes.iter().any(|&(bx, by, w, h)| x >= bx && x < bx + w && y >= by && y < by + h);
        let mut best = 0;
        for x0 in 0..12 { for y0 in 0..12 { for x1 in x0 + 1..13 { for y1 in y0 + 1..13 {
            let area = (x1 - x0) * (y1 - y0);
            if area > best && (x0..x1).all(|x| (y0..y1).all(|y| inside(x, y))) {
                best = area;
            }
        } } } }
        let region = Region::new(&boxes.iter().map(|&(x, y, w, h)| rectangle([x, y].map(f64::from), [x + w, y + h].map(f64::from))).collect::<Vec<_>>()).unwrap();
        let [low, high] = largest_rectangle(&region).unwrap();
        let found = area_of([low, high]);
        prop_assert!(found >= f64::from(best) * (1.0 - 1e-5) && found <= f64::from(best) * (1.0 + 1e-9), "{found} {best}");
        // Inside, by a boolean that the search does not use.
        let own = Region::new(&[rectangle([low.x, low.y], [high.x, high.y])]).unwrap();
        prop_assert!(own.difference(&region).area() < 1e-6);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    /// Any blocks: parts are manifolds that add up, and what is called free of overhang passes the audit.
    #[test]
    fn blocks_are_divided_or_say_why_not(picked in prop::collection::vec(prop::array::uniform3(0..3_i32), 4..14)) {
        let solid = blocks(&sound_blocks(&picked), 30.0);
        let options = VolumeOptions { layer_mm: 6.0, min_layer_mm: 6.0, max_parts: 24, ..VolumeOptions::default() };
        let result = decompose(&solid, &options);
        let sum: f64 = result.parts.iter().map(|part| part.solid.volume()).sum();
        prop_assert!((sum - solid.volume()).abs() <= 1e-9 * solid.volume());
        result.parts.iter().for_each(|part| assert_manifold(&part.solid));
        let audit = audit_volumes(&solid, &result.parts, &options, &AuditOptions { lines: 25, points: 30, ..AuditOptions::default() });
        prop_assert!(audit.missing_share <= 1e-6 && audit.doubled_share <= 1e-6, "{audit:?}");
        for (part, found) in audit.parts.iter().enumerate() {
            prop_assert!(found.unlayered_mm3 <= 1e-6 * solid.volume(), "part {part}: {found:?}");
            prop_assert!(found.unsupported_mm2 <= 0.0 || result.stuck.iter().any(|stuck| stuck.part == part), "part {part}: {audit:?} {:?}", result.stuck);
        }
    }
}

/// The ends of the ranges are as good as their middle.
#[test]
fn options_at_the_ends_of_their_ranges_are_taken() {
    let d = VolumeOptions::default();
    for options in [VolumeOptions { min_feature_mm: 1e4, ..d }, VolumeOptions { angle: 1e-3, ..d }] {
        assert!(decompose_volume(&ell(), &options, &|_| ControlFlow::Continue(())).is_ok());
    }
}
