use super::parts::{block, go, solid, tuning};
use super::shapes::{Shape, cells, tee, to_segment};
use curvlay_layers::Progress;
use curvlay_layers::nalgebra::{Point3, Vector3};
use curvlay_layers::planar::Solid;
use curvlay_layers::planar::robofdm::{
    AuditOptions, AuditedPart, BeamOptions, Decomposition, Head, PartsAudit, RoboFdmError, SegmentOptions,
    SequenceOptions, TuningOptions, audit_parts, beam_search, plan_sequence, segment, tune,
};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

/// A small head for shapes of 30 mm.
fn head() -> Head {
    Head { cone_height: 3.0, block_radius: 4.0, platform_radius: 25.0, ..Head::default() }
}

fn audited(whole: &Solid, parts: &[AuditedPart], head: Option<Head>) -> PartsAudit {
    audit_parts(whole, parts, &AuditOptions { head, ..AuditOptions::default() }, &go).unwrap()
}

fn judged(whole: &Solid, parts: &Decomposition, head: Option<Head>) -> PartsAudit {
    let parts: Vec<_> = parts.parts.iter().map(|part| part.audited()).collect();
    audited(whole, &parts, head)
}

/// Two blocks on the platform: a wall 10 mm thick and so high, and one of 10 by 10 by 2 mm at a distance.
fn wall_and_block(height: f64, gap: f64) -> [Solid; 3] {
    let wall = block(10.0, 10.0, height);
    let flat = block(10.0, 10.0, 2.0);
    let moved: Vec<_> = flat.vertices().iter().map(|p| p + Vector3::x() * (10.0 + gap)).collect();
    let flat = Solid::new(&moved, flat.triangles()).unwrap();
    let points = [wall.vertices(), flat.vertices()].concat();
    let second = flat.triangles().iter().map(|t| t.map(|v| v + wall.vertices().len() as u32));
    let faces: Vec<[u32; 3]> = wall.triangles().iter().copied().chain(second).collect();
    let both = Solid::new(&points, &faces).unwrap();
    [wall, flat, both]
}

#[test]
fn the_audit_measures_how_deep_the_head_is() {
    let contact = |height: f64, gap: f64| {
        let [wall, flat, both] = wall_and_block(height, gap);
        let part = |solid| AuditedPart { solid, direction: Vector3::z(), on_platform: true };
        let audit = audited(&both, &[part(&wall), part(&flat)], Some(Head::default()));
        assert_eq!(audit.is_ok, audit.head_contacts == [0, 0], "{audit:?}");
        assert_eq!(audit.head_contacts[0], 0);
        (audit.head_contacts[1] > 0, audit.deepest_contact_mm)
    };
    // The block of the head, 10 mm wide, reaches the wall.
    let (meets, deep) = contact(20.0, 8.0);
    assert!(meets && (deep - 2.0).abs() < 0.05, "{deep}");
    assert!(!contact(20.0, 10.5).0);
    // Only the cone reaches down to a wall of 4 mm: the lowest tip is at 1 mm (layers of 1 mm are looked at in their middle), so
    // the cone is 3.5 mm wide at the wall's top.
    let (meets, deep) = contact(4.0, 2.0);
    assert!(meets && (deep - 1.5).abs() < 0.05, "{deep}");
    assert!(!contact(4.0, 3.5).0);
    // A wall that is no higher than the lowest tip is in no way, however near.
    assert!(!contact(1.0, 1.0).0);
    // With the other order the flat one stands first.
    let [wall, flat, both] = wall_and_block(20.0, 8.0);
    let part = |solid| AuditedPart { solid, direction: Vector3::z(), on_platform: true };
    assert!(audited(&both, &[part(&flat), part(&wall)], Some(Head::default())).is_ok);
}

#[test]
fn the_platform_stands_as_well() {
    let whole = block(20.0, 10.0, 10.0);
    // Printed on its side right above the platform: the head is wider than that.
    let parts = [AuditedPart { solid: &whole, direction: Vector3::x(), on_platform: true }];
    let audit = audited(&whole, &parts, Some(Head::default()));
    // Along x the platform of the first part is the plane x = 0.
    assert!(audit.is_ok, "{audit:?}");
    let foot = block(1.0, 10.0, 10.0);
    let rest: Vec<_> = whole.vertices().iter().map(|p| Point3::new(p.x.max(1.0), p.y, p.z)).collect();
    let rest = Solid::new(&rest, whole.triangles()).unwrap();
    let part = |solid, direction, on_platform| AuditedPart { solid, direction, on_platform };
    let parts = [part(&foot, Vector3::z(), true), part(&rest, Vector3::x(), false)];
    let audit = audited(&whole, &parts, Some(Head::default()));
    assert!(audit.head_contacts[1] > 0 && !audit.is_ok, "{audit:?}");
    let none = Head { platform_radius: 0.0, ..Head::default() };
    assert!(audited(&whole, &parts, Some(none)).is_ok);
    // Constraint II sees nothing wrong with it.
    assert!(audited(&whole, &parts, None).is_ok);
}

fn sequenced(shape: &Shape) -> curvlay_layers::planar::robofdm::BuildSequence {
    let segmentation = segment(&shape.points, &shape.triangles, &SegmentOptions::default()).unwrap();
    let upright = SequenceOptions { direction: Some(Vector3::z()), platform: 1.0, ..SequenceOptions::default() };
    plan_sequence(&shape.points, &shape.triangles, &segmentation, &upright).unwrap()
}

#[test]
fn what_the_search_finds_with_a_head_passes_the_audit() {
    let shape = tee();
    let (whole, sequence) = (solid(&shape), sequenced(&shape));
    let tuning = TuningOptions { head: Some(head()), normals: 40, ..tuning() };
    let tuned = tune(&whole, &sequence, &tuning, &go).unwrap();
    let options = BeamOptions { tuning, width: 3, branches: 2, ..BeamOptions::default() };
    let searched = beam_search(&whole, Some(&sequence), &options, &go).unwrap();
    // The search is never worse than the fine decomposition, but where it is good enough.
    let goal = tuning.goal * tuned.risky_before_mm2;
    assert!(searched.risky_mm2() <= tuned.risky_mm2().max(goal) * (1.0 + 1e-9));
    for parts in [&tuned, &searched] {
        assert!(parts.risky_mm2() < parts.risky_before_mm2 && parts.parts.len() > 1);
        let audit = judged(&whole, parts, Some(head()));
        assert!(audit.head_contacts.iter().all(|&contacts| contacts == 0), "{audit:?}");
        assert!(audit.volume_error.abs() < 1e-12 && audit.misplaced_points == 0);
    }
}

/// A ring that stands on the platform, 4 mm thick.
fn ring() -> Shape {
    cells([30, 8, 30], |p| {
        let d = p - Vector3::new(15.0, 4.0, 14.0);
        ((d.x.hypot(d.z) - 10.0).hypot(d.y) - 3.6).max(1.0 - p.z)
    })
}

#[test]
fn a_beam_search_needs_no_segments_and_cuts_handles() {
    let shape = ring();
    let whole = solid(&shape);
    let tuning = TuningOptions { platform: 2.0, spacing: 2.0, normals: 40, ..TuningOptions::default() };
    let options = BeamOptions { tuning, width: 4, branches: 3, ..BeamOptions::default() };
    let most = AtomicU64::new(0);
    let note = |tick: Progress| {
        if tick.stage == "beam" {
            most.fetch_max(tick.done, Ordering::Relaxed);
        }
        ControlFlow::Continue(())
    };
    let parts = beam_search(&whole, None, &options, &note).unwrap();
    // It is the search that cuts, not what cuts on behind it.
    assert!(most.into_inner() > 1);
    assert!(parts.risky_mm2() <= 0.1 * parts.risky_before_mm2, "{} {}", parts.risky_mm2(), parts.risky_before_mm2);
    let audit = judged(&whole, &parts, None);
    assert!(audit.misplaced_points == 0 && audit.volume_error.abs() < 1e-12 && audit.looking_down.is_empty());
    // Where all the risk there is may stay, nothing is cut.
    let content = BeamOptions { tuning: TuningOptions { goal: 1.0, ..tuning }, ..options };
    assert_eq!(beam_search(&whole, None, &content, &go).unwrap().parts.len(), 1);
    // One thread, the same.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| beam_search(&whole, None, &options, &go)).unwrap(), parts);
    // A wider beam keeps what a narrow one had at each step, and with one member it is greedy.
    let narrow = beam_search(&whole, None, &BeamOptions { width: 1, branches: 1, ..options }, &go).unwrap();
    assert!(parts.risky_mm2() <= narrow.risky_mm2().max(tuning.goal * parts.risky_before_mm2));
}

/// A round cap on a stem.
fn capped() -> Shape {
    cells([24, 24, 20], |p| {
        let d = p - Vector3::new(12.0, 12.0, 0.0);
        let round = |radius: f64, low: f64, high: f64| (d.x.hypot(d.y) - radius).max(low - p.z).max(p.z - high);
        round(3.1, 1.1, 12.0).min(round(9.6, 11.1, 17.1))
    })
}

/// Bug: segments stayed parts of their own, however few parts were allowed, and a cut made as many as it made.
#[test]
fn there_are_no_more_parts_than_are_allowed() {
    let fork = cells([40, 10, 24], |p| {
        let stem = to_segment(p, [20.0, 5.0, -5.0], [20.0, 5.0, 18.0]);
        let arms = to_segment(p, [5.0, 5.0, 18.0], [35.0, 5.0, 18.0]);
        stem.min(arms).max(4.1 - p.z) - 4.1
    });
    let mut most = 0;
    for shape in [tee(), capped(), fork] {
        let (whole, sequence) = (solid(&shape), sequenced(&shape));
        for (max_parts, head) in [1, 2, 3].into_iter().flat_map(|max| [(max, None), (max, Some(head()))]) {
            let tuning = TuningOptions { max_parts, head, normals: 40, ..tuning() };
            let options = BeamOptions { tuning, width: 3, branches: 2, ..BeamOptions::default() };
            let tuned = tune(&whole, &sequence, &tuning, &go).unwrap();
            let searched = beam_search(&whole, Some(&sequence), &options, &go).unwrap();
            for parts in [tuned, searched] {
                most = most.max(parts.parts.len());
                assert!(parts.parts.len() <= max_parts, "{} of {max_parts}", parts.parts.len());
                assert!(parts.risky_mm2() <= parts.risky_before_mm2 * (1.0 + 1e-9));
                let audit = judged(&whole, &parts, head);
                assert!(audit.misplaced_points == 0 && audit.volume_error.abs() < 1e-12, "{audit:?}");
            }
        }
    }
    assert_eq!(most, 3);
}

#[test]
fn a_cap_all_around_its_stem_is_taken_off_in_pieces() {
    // Cuts behind the stem promise the whole cap, but leave nothing that stands: they must not crowd out the others.
    let shape = capped();
    let whole = solid(&shape);
    let parts =
        tune(&whole, &sequenced(&shape), &TuningOptions { spacing: 2.0, normals: 60, ..tuning() }, &go).unwrap();
    assert!(parts.risky_mm2() <= 0.1 * parts.risky_before_mm2, "{} {}", parts.risky_mm2(), parts.risky_before_mm2);
    let audit = judged(&whole, &parts, None);
    assert!(audit.misplaced_points == 0 && audit.volume_error.abs() < 1e-12 && audit.looking_down.is_empty());
}

#[test]
fn a_segment_is_the_least_risky_of_two_starts() {
    let shape = cells([30, 10, 30], |p| {
        let corners = [[5.0, 5.0, -5.0], [5.0, 5.0, 24.0], [24.0, 5.0, 24.0], [24.0, 5.0, 15.0]];
        corners.windows(2).map(|c| to_segment(p, c[0], c[1])).fold(f64::MAX, f64::min).max(4.1 - p.z) - 4.1
    });
    let (whole, sequence) = (solid(&shape), sequenced(&shape));
    let options = BeamOptions { tuning: TuningOptions { goal: 1.0, ..tuning() }, ..BeamOptions::default() };
    // Nothing is cut: what is left is one of the starts.
    let parts = beam_search(&whole, Some(&sequence), &options, &go).unwrap();
    assert!(parts.risky_mm2() <= parts.risky_before_mm2);
    assert!((parts.risky_after_phases_mm2[0] - parts.risky_mm2()).abs() < 1e-6);
}

#[test]
fn bad_options_are_named() {
    let whole = block(4.0, 4.0, 9.0);
    let name = |options: BeamOptions| match beam_search(&whole, None, &options, &go) {
        Err(RoboFdmError::Option { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    let default = BeamOptions::default();
    assert_eq!(name(BeamOptions { width: 0, ..default }), "width");
    assert_eq!(name(BeamOptions { branches: 0, ..default }), "branches");
    assert_eq!(name(BeamOptions { direction: Vector3::zeros(), ..default }), "direction");
    let with = |head: Head| BeamOptions { tuning: TuningOptions { head: Some(head), ..default.tuning }, ..default };
    let head = Head::default();
    assert_eq!(name(with(Head { tip_radius: -1.0, ..head })), "head.tip_radius");
    assert_eq!(name(with(Head { cone_half_angle: 1.58, ..head })), "head.cone_half_angle");
    assert_eq!(name(with(Head { cone_height: f64::NAN, ..head })), "head.cone_height");
    assert_eq!(name(with(Head { block_radius: f64::INFINITY, ..head })), "head.block_radius");
    assert_eq!(name(with(Head { platform_radius: -1.0, ..head })), "head.platform_radius");
    assert_eq!(name(with(Head { layer: 0.0, ..head })), "head.layer");
    assert_eq!(name(with(Head { pixel: 0.0, ..head })), "head.pixel");
    let parts = [AuditedPart { solid: &whole, direction: Vector3::z(), on_platform: true }];
    let options = AuditOptions { head: Some(Head { pixel: -1.0, ..head }), ..AuditOptions::default() };
    assert!(matches!(audit_parts(&whole, &parts, &options, &go), Err(RoboFdmError::Option { name: "head.pixel", .. })));
    let shape = ring();
    let stop = |_: Progress| ControlFlow::Break(());
    assert_eq!(beam_search(&solid(&shape), None, &default, &stop), Err(RoboFdmError::Cancelled));
}
