use super::shapes::{Shape, cells, tee, to_segment};
use crate::common::BOX;
use curvlay_layers::Progress;
use curvlay_layers::nalgebra::{Point3, Vector3};
use curvlay_layers::planar::robofdm::{
    AuditOptions, AuditedPart, Decomposition, PartsAudit, PrintedPart, RoboFdmError, SegmentOptions, SequenceOptions,
    TuningOptions, audit_parts, crossing_sections, plan_sequence, segment, tune,
};
use curvlay_layers::planar::{CutPlane, Partition, Solid};
use std::ops::ControlFlow;

pub fn go(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

pub fn solid(shape: &Shape) -> Solid {
    Solid::new(&shape.points, &shape.triangles).unwrap()
}

fn decomposed(shape: &Shape, options: &TuningOptions) -> Result<Decomposition, RoboFdmError> {
    let segmentation = segment(&shape.points, &shape.triangles, &SegmentOptions::default())?;
    // The feet of these shapes are flat to a cell, not to a layer.
    let upright = SequenceOptions { direction: Some(Vector3::z()), platform: 1.0, ..SequenceOptions::default() };
    let sequence = plan_sequence(&shape.points, &shape.triangles, &segmentation, &upright)?;
    tune(&solid(shape), &sequence, options, &go)
}

pub fn tuning() -> TuningOptions {
    TuningOptions { platform: 1.0, spacing: 2.0, ..TuningOptions::default() }
}

fn audited(shape: &Shape, parts: &Decomposition) -> PartsAudit {
    let parts: Vec<_> = parts
        .parts
        .iter()
        .map(|part| AuditedPart { solid: &part.solid, direction: part.direction, on_platform: part.base.is_none() })
        .collect();
    audit_parts(&solid(shape), &parts, &AuditOptions::default(), &go).unwrap()
}

/// A hook: up, over, and down again, but not to the platform.
fn hook() -> Shape {
    cells([30, 10, 30], |p| {
        let corners = [[5.0, 5.0, -5.0], [5.0, 5.0, 24.0], [24.0, 5.0, 24.0], [24.0, 5.0, 15.0]];
        corners.windows(2).map(|c| to_segment(p, c[0], c[1])).fold(f64::MAX, f64::min).max(4.1 - p.z) - 4.1
    })
}

#[test]
fn the_arms_of_a_tee_become_parts_that_need_no_support() {
    let shape = tee();
    let parts = decomposed(&shape, &tuning()).unwrap();
    assert!(parts.parts.len() >= 3 && parts.parts[0].base.is_none());
    assert!(parts.risky_mm2() <= 0.05 * parts.risky_before_mm2, "{} of {}", parts.risky_mm2(), parts.risky_before_mm2);
    let [planes, merged, cut] = parts.risky_after_phases_mm2;
    assert!(merged <= planes * (1.0 + 1e-9) && cut <= merged * (1.0 + 1e-9));
    assert!(merged <= parts.risky_before_mm2);
    assert!((cut - parts.risky_mm2()).abs() < 1e-6);
    for (at, part) in parts.parts.iter().enumerate().skip(1) {
        assert!(part.seam_mm2 > 0.0 && !part.on.is_empty() && part.on.iter().all(|&on| on < at));
        assert_eq!(part.seams.iter().map(|seam| seam.on).collect::<Vec<_>>(), part.on);
        assert!((part.seams.iter().map(|seam| seam.area_mm2).sum::<f64>() - part.seam_mm2).abs() < 1e-6);
        // A cut has the normal of its plane.
        let direct = part.seams.iter().filter(|seam| seam.load_angle(&part.direction).unwrap() < 1e-6);
        assert!(direct.count() > 0 && part.seams.iter().all(|seam| seam.normal.dot(&part.direction) > -1e-6));
        assert!(part.direction.z > 0.0 && part.base.is_some_and(|base| base.normal() == part.direction));
    }
    assert!(crossing_sections(&parts.parts).is_empty());
    let audit = audited(&shape, &parts);
    assert!(audit.is_ok, "{audit:?}");
    assert!(audit.volume_error.abs() < 1e-12);
}

#[test]
fn cuts_save_risky_area_and_parts_fit_whatever_is_left() {
    let shape = hook();
    let whole = solid(&shape).volume();
    for options in [tuning(), TuningOptions { keep_sections_apart: true, ..tuning() }] {
        let parts = decomposed(&shape, &options).unwrap();
        assert!(
            parts.risky_mm2() < 0.6 * parts.risky_before_mm2,
            "{} of {}",
            parts.risky_mm2(),
            parts.risky_before_mm2
        );
        let volume: f64 = parts.parts.iter().map(|part| part.solid.volume()).sum();
        assert!((volume / whole - 1.0).abs() < 1e-12);
        // Constraint I, by its own check.
        assert!(crossing_sections(&parts.parts).is_empty());
        let audit = audited(&shape, &parts);
        assert_eq!((audit.misplaced_points, audit.looking_down.len()), (0, 0));
    }
    // No part is smaller than may be.
    let large = decomposed(&shape, &TuningOptions { min_piece: 0.05, perturbations: 0, ..tuning() }).unwrap();
    assert!(large.parts.iter().all(|part| part.solid.volume() >= 0.05 * whole * (1.0 - 1e-9)));
    // The same twice.
    assert_eq!(decomposed(&shape, &tuning()), decomposed(&shape, &tuning()));
}

#[test]
fn without_cuts_there_is_one_part_whose_risk_is_that_of_the_solid() {
    let shape = hook();
    let parts = decomposed(&shape, &TuningOptions { max_parts: 1, perturbations: 0, goal: 1.0, ..tuning() }).unwrap();
    let down = |[a, b, c]: [Point3<f64>; 3]| {
        let normal = (b - a).cross(&(c - a)) / 2.0;
        let on_platform =
            [a, b, c].iter().all(|p| p.z <= shape.points.iter().map(|p| p.z).fold(f64::MAX, f64::min) + 1.0);
        if normal.z < -(0.5f64.sqrt()) * normal.norm() && !on_platform { normal.norm() } else { 0.0 }
    };
    let expected: f64 = shape.triangles.iter().map(|t| down(t.map(|v| shape.points[v as usize]))).sum();
    assert!((parts.risky_before_mm2 - expected).abs() < 1e-6 * expected, "{} {expected}", parts.risky_before_mm2);
}

/// A box from the origin to a corner.
pub fn block(x: f64, y: f64, z: f64) -> Solid {
    let points: Vec<_> =
        (0..8).map(|i| Point3::new(f64::from(i & 1) * x, f64::from(i >> 1 & 1) * y, f64::from(i >> 2) * z)).collect();
    Solid::new(&points, &BOX).unwrap()
}

#[test]
fn the_audit_sees_what_hangs_what_overlaps_and_what_is_missing() {
    let whole = block(20.0, 10.0, 10.0);
    let mut partition = Partition::new(&whole);
    let cut = partition.cut(&[0], &CutPlane::through(&Point3::new(10.0, 0.0, 0.0), &Vector3::x()).unwrap());
    let [left, right] = [cut.below[0], cut.above[0]].map(|cell| partition.part(cell).unwrap());
    let part = |solid, direction, on_platform| AuditedPart { solid, direction, on_platform };
    let audit = |parts: &[AuditedPart]| audit_parts(&whole, parts, &AuditOptions::default(), &go).unwrap();

    // Left upright, then right along x on its side.
    let good = audit(&[part(&left, Vector3::z(), true), part(&right, Vector3::x(), false)]);
    assert!(good.is_ok && good.layers == [20, 20] && good.unsupported_mm2 == [0.0, 0.0], "{good:?}");
    assert!((good.layer_mm2[0] - 2000.0).abs() < 1e-6);
    // Right upright, but not on the platform: the first layer hangs, but for what leans out of the left part's layer below.
    let hanging = audit(&[part(&left, Vector3::z(), true), part(&right, Vector3::z(), false)]);
    assert!((hanging.unsupported_mm2[1] - 100.0).abs() < 1.0 && !hanging.is_ok, "{hanging:?}");
    // Down.
    let down = audit(&[part(&left, Vector3::z(), true), part(&right, -Vector3::z(), true)]);
    assert_eq!((down.looking_down.as_slice(), down.is_ok), ([1].as_slice(), false));
    // One part twice, one missing: the volume is right.
    let twice = audit(&[part(&left, Vector3::z(), true), part(&left, Vector3::z(), true)]);
    assert!(twice.volume_error.abs() < 1e-12 && twice.misplaced_points == 343 && !twice.is_ok, "{twice:?}");
    let missing = audit(&[part(&left, Vector3::z(), true)]);
    assert!((missing.volume_error + 0.5).abs() < 1e-12 && !missing.is_ok);
}

/// Bug: the limit was of all layers together, so that one in mid-air passed below many that lie on something.
#[test]
fn one_layer_on_nothing_among_many_fails() {
    // A tower of 200 layers that stands on nothing.
    let tower = block(10.0, 10.0, 100.0);
    let judged = |on_platform: bool, max_unsupported: f64| {
        let part = [AuditedPart { solid: &tower, direction: Vector3::z(), on_platform }];
        audit_parts(&tower, &part, &AuditOptions { max_unsupported, ..AuditOptions::default() }, &go).unwrap()
    };
    let floating = judged(false, 0.01);
    let [area, unsupported] = [floating.layer_mm2[0], floating.unsupported_mm2[0]];
    assert!((area - 20_000.0).abs() < 1e-6 && (unsupported - 100.0).abs() < 1e-6, "{unsupported} of {area}");
    assert!(!floating.is_ok && floating.hanging_layers == [1], "{floating:?}");
    let worst = floating.worst_layer.unwrap();
    assert!((worst.part, worst.layer) == (0, 0) && (worst.share - 1.0).abs() < 1e-9, "{worst:?}");
    let allowed = judged(false, 1.0);
    assert!(allowed.is_ok && allowed.hanging_layers == [0] && allowed.worst_layer == floating.worst_layer);
    // A tip of 4 mm2 on nothing, of a part with layers of 100 mm2 above it, is a share of those.
    let shape = cells([10, 10, 30], |p| {
        let d = p - Vector3::new(5.0, 5.0, 0.0);
        d.x.abs().max(d.y.abs()) - if p.z < 1.0 { 1.0 } else { 5.0f64.min(p.z) }
    });
    let tip = solid(&shape);
    let part = [AuditedPart { solid: &tip, direction: Vector3::z(), on_platform: false }];
    let audit = audit_parts(&tip, &part, &AuditOptions::default(), &go).unwrap();
    let share = audit.worst_layer.unwrap().share;
    assert!(share < 0.2 && audit.unsupported_mm2[0] > 1.0, "{audit:?}");
    // Where all lies on something there is no worst layer.
    let standing = judged(true, 0.0);
    assert!(standing.is_ok && standing.worst_layer.is_none(), "{standing:?}");
}

#[test]
fn a_wedge_leans_out_as_far_as_the_angle_lets_it() {
    // Sheared by 1: 45 degrees on one side.
    let upright = block(10.0, 10.0, 10.0);
    let sheared: Vec<_> = upright.vertices().iter().map(|p| Point3::new(p.x + p.z, p.y, p.z)).collect();
    let wedge = Solid::new(&sheared, upright.triangles()).unwrap();
    let part = [AuditedPart { solid: &wedge, direction: Vector3::z(), on_platform: true }];
    let unsupported = |max_angle: f64| {
        let options = AuditOptions { max_angle: max_angle.to_radians(), ..AuditOptions::default() };
        audit_parts(&wedge, &part, &options, &go).unwrap().unsupported_mm2[0]
    };
    assert!(unsupported(45.0) < 1e-6);
    // Nineteen layers, each leaning out half a millimetre, of which the tangent is held.
    let free = 0.5 - 0.5 * 40f64.to_radians().tan() * 1.02;
    assert!((unsupported(40.0) - 19.0 * 10.0 * free).abs() < 0.5, "{}", unsupported(40.0));
}

#[test]
fn a_solid_that_needs_no_support_stays_whole() {
    // A T on its head: along the planes of its arms there is risky area, in one piece there is none.
    let mut shape = tee();
    let high = shape.points.iter().map(|p| p.z).fold(f64::MIN, f64::max);
    shape.points.iter_mut().for_each(|p| *p = Point3::new(p.x, 20.0 - p.y, high - p.z));
    let parts = decomposed(&shape, &tuning()).unwrap();
    assert!(parts.risky_mm2() <= parts.risky_before_mm2 && parts.risky_after_phases_mm2[1] <= parts.risky_before_mm2);
}

#[test]
fn sections_cross_inside_or_only_touch() {
    let part = |solid: Solid, point: [f64; 3], normal: Vector3<f64>| PrintedPart {
        solid,
        direction: normal,
        base: Some(CutPlane::through(&point.into(), &normal).unwrap()),
        risky_mm2: 0.0,
        seam_mm2: 0.0,
        on: Vec::new(),
        seams: Vec::new(),
    };
    let moved = |solid: &Solid, by: [f64; 3]| {
        let points: Vec<_> = solid.vertices().iter().map(|p| p + Vector3::from(by)).collect();
        Solid::new(&points, solid.triangles()).unwrap()
    };
    // A level section over 0..10 in x and y, at z = 5, and upright ones at x = 5.
    let level = part(moved(&block(10.0, 10.0, 4.0), [0.0, 0.0, 5.0]), [0.0, 0.0, 5.0], Vector3::z());
    let upright =
        |z: f64, height: f64, y: f64| part(moved(&block(4.0, 3.0, height), [5.0, y, z]), [5.0, 0.0, 0.0], Vector3::x());
    let crosses = |other: PrintedPart| crossing_sections(&[level.clone(), other]) == [[0, 1]];
    assert!(crosses(upright(3.0, 4.0, 2.0)));
    // From below up to it, from above down to it, and beside it.
    assert!(!crosses(upright(1.0, 4.0, 2.0)) && !crosses(upright(5.0, 4.0, 2.0)) && !crosses(upright(3.0, 4.0, 11.0)));
    // Across its edge.
    assert!(crosses(upright(3.0, 4.0, 8.5)));
    let platform = PrintedPart { base: None, ..level.clone() };
    assert!(crossing_sections(&[platform, upright(3.0, 4.0, 2.0)]).is_empty());
}

#[test]
fn bad_options_are_named_and_work_can_be_cancelled() {
    let shape = tee();
    let name = |options: TuningOptions| match decomposed(&shape, &options) {
        Err(RoboFdmError::Option { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    let default = TuningOptions::default();
    assert_eq!(name(TuningOptions { max_angle: 0.0, ..default }), "max_angle");
    assert_eq!(name(TuningOptions { platform: f64::NAN, ..default }), "platform");
    assert_eq!(name(TuningOptions { max_section: 0.5, ..default }), "max_section");
    assert_eq!(name(TuningOptions { candidates: 0, ..default }), "candidates");
    assert_eq!(name(TuningOptions { normals: 0, ..default }), "normals");
    assert_eq!(name(TuningOptions { spacing: 0.0, ..default }), "spacing");
    assert_eq!(name(TuningOptions { seam_cost: -1.0, ..default }), "seam_cost");
    assert_eq!(name(TuningOptions { min_piece: -1.0, ..default }), "min_piece");
    assert_eq!(name(TuningOptions { max_parts: 0, ..default }), "max_parts");
    assert_eq!(name(TuningOptions { goal: 2.0, ..default }), "goal");
    assert_eq!(name(TuningOptions { max_offset: -1.0, ..default }), "max_offset");
    assert_eq!(name(TuningOptions { max_turn: 2.0, ..default }), "max_turn");

    let whole = solid(&shape);
    let parts = [AuditedPart { solid: &whole, direction: Vector3::z(), on_platform: true }];
    let stop = |_: Progress| ControlFlow::Break(());
    let audit = |options: AuditOptions| audit_parts(&whole, &parts, &options, &go);
    assert!(matches!(
        audit(AuditOptions { layer: 0.0, ..AuditOptions::default() }),
        Err(RoboFdmError::Option { name: "layer", .. })
    ));
    assert_eq!(audit_parts(&whole, &parts, &AuditOptions::default(), &stop), Err(RoboFdmError::Cancelled));
    assert_eq!(audit_parts(&whole, &[], &AuditOptions::default(), &go), Err(RoboFdmError::Empty));
    let segmentation = segment(&shape.points, &shape.triangles, &SegmentOptions::default()).unwrap();
    let sequence = plan_sequence(&shape.points, &shape.triangles, &segmentation, &SequenceOptions::default()).unwrap();
    assert_eq!(tune(&whole, &sequence, &default, &stop), Err(RoboFdmError::Cancelled));
}
