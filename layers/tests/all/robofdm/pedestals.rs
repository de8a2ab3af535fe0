use super::parts::{block, go, solid, tuning};
use super::shapes::{Shape, cells, tee, to_segment};
use curvlay_layers::nalgebra::Vector3;
use curvlay_layers::planar::Solid;
use curvlay_layers::planar::robofdm::{
    AuditOptions, AuditedPart, BeamOptions, Decomposition, Head, LeftReason, PartsAudit, Pedestal, RoboFdmError,
    SeamStrength, TuningOptions, audit_parts, beam_search, lowest_pedestal,
};

/// A small head for shapes of 30 mm, with a pedestal.
fn head(pedestal: f64) -> Head {
    Head { cone_height: 3.0, block_radius: 4.0, platform_radius: 25.0, pedestal, ..Head::default() }
}

fn searched(whole: &Solid, tuning: TuningOptions) -> Decomposition {
    let tuning = TuningOptions { spacing: 2.0, normals: 60, ..tuning };
    beam_search(whole, None, &BeamOptions { tuning, width: 3, branches: 3, ..BeamOptions::default() }, &go).unwrap()
}

fn audited(whole: &Solid, parts: &Decomposition, head: Head) -> PartsAudit {
    let parts: Vec<AuditedPart> = parts.parts.iter().map(|part| part.audited()).collect();
    audit_parts(whole, &parts, &AuditOptions { head: Some(head), ..AuditOptions::default() }, &go).unwrap()
}

/// A round plate of 9.6 mm radius, its underside 2 mm above the platform, on a stem.
fn low_cap() -> Shape {
    cells([24, 24, 9], |p| {
        let d = p - Vector3::new(12.0, 12.0, 0.0);
        let round = |radius: f64, low: f64, high: f64| (d.x.hypot(d.y) - radius).max(low - p.z).max(p.z - high);
        round(4.1, 0.1, 6.0).min(round(9.6, 2.1, 8.1))
    })
}

#[test]
fn on_a_pedestal_the_head_has_room_near_the_platform() {
    let whole = solid(&low_cap());
    let without = searched(&whole, TuningOptions { head: Some(head(0.0)), ..tuning() });
    let with = searched(&whole, TuningOptions { head: Some(head(8.0)), ..tuning() });
    let share = |parts: &Decomposition| parts.risky_mm2() / parts.risky_before_mm2;
    assert!(share(&without) > 0.3 && share(&with) < 0.1, "{} {}", share(&without), share(&with));
    // Why it is left: the platform.
    assert!(without.left.iter().any(|left| left.reason == LeftReason::Platform && left.promise_mm2 > 10.0));
    let explained: f64 = without.left.iter().map(|left| left.risky_mm2).sum();
    assert!(explained > 0.9 * without.risky_mm2() && explained < without.risky_mm2() * (1.0 + 1e-9));
    // An audit that shares nothing with the search: no contact on the pedestal, some without it.
    assert_eq!(audited(&whole, &with, head(8.0)).head_contacts.iter().sum::<usize>(), 0);
    assert!(audited(&whole, &with, head(0.0)).head_contacts.iter().sum::<usize>() > 0);
    // As low as may be.
    let lowest = lowest_pedestal(&whole, &with.parts, &head(8.0));
    assert!(lowest > 0.0 && lowest < 8.0, "{lowest}");
    assert_eq!(audited(&whole, &with, head(lowest)).head_contacts.iter().sum::<usize>(), 0);
    // By the same test one step lower is too low.
    let lower = Head { pedestal: lowest - 0.5, ..head(8.0) };
    assert!((lowest_pedestal(&whole, &with.parts, &lower) - lower.pedestal).abs() < 1e-12);
    assert!(lowest_pedestal(&whole, &[], &head(8.0)) <= 0.0);
}

#[test]
fn the_audit_sees_the_pedestal_itself() {
    // A small block beside a foot of 10 by 10, printed level towards the foot from beside it: the head passes above the platform, which lies
    // 20 mm lower, but not through the pedestal.
    let foot = block(10.0, 10.0, 2.0);
    let moved: Vec<_> = block(2.0, 2.0, 2.0).vertices().iter().map(|p| p + Vector3::new(-6.0, 4.0, -4.0)).collect();
    let beside = Solid::new(&moved, foot.triangles()).unwrap();
    let points = [foot.vertices(), beside.vertices()].concat();
    let second = beside.triangles().iter().map(|t| t.map(|v| v + 8));
    let both = Solid::new(&points, &foot.triangles().iter().copied().chain(second).collect::<Vec<_>>()).unwrap();
    let part = |solid, direction, on_platform| AuditedPart { solid, direction, on_platform };
    let parts = [part(&foot, Vector3::z(), true), part(&beside, Vector3::x(), false)];
    let contacts = |pedestal: f64| {
        let options = AuditOptions { head: Some(head(pedestal)), ..AuditOptions::default() };
        audit_parts(&both, &parts, &options, &go).unwrap().head_contacts[1]
    };
    let free = Head { platform_radius: 0.0, ..head(0.0) };
    let options = AuditOptions { head: Some(free), ..AuditOptions::default() };
    let alone = audit_parts(&both, &parts, &options, &go).unwrap().head_contacts[1];
    assert!(contacts(20.0) > alone, "{} {alone}", contacts(20.0));
}

#[test]
fn a_pedestal_is_a_prism_of_the_first_layer() {
    // A cone of 45 degrees, upside down and cut: the section at half a layer of 1 mm is wider than the foot.
    let shape = tee();
    let whole = solid(&shape);
    let pedestal = Pedestal::new(&whole, &Vector3::z(), 1.0, 5.0).unwrap();
    let (points, faces) = pedestal.mesh();
    let mesh = Solid::new(&points, &faces).unwrap();
    assert!((mesh.volume() / pedestal.volume_mm3() - 1.0).abs() < 0.01, "{} {}", mesh.volume(), pedestal.volume_mm3());
    let [low, high] = mesh.bounds();
    let foot = whole.extent(&Vector3::z())[0];
    assert!((low.z - foot + 5.0).abs() < 1e-9 && (high.z - foot).abs() < 1e-9);
    let layers = pedestal.layers(0.8).unwrap();
    assert_eq!(layers.layers.len(), 6);
    assert!((layers.height_mm - 5.0 / 6.0).abs() < 1e-9 && (layers.low_mm - low.z).abs() < 1e-9);
    assert!(layers.layers.windows(2).all(|two| (two[0].high_mm - two[1].low_mm).abs() < 1e-9));
    assert!(pedestal.layers(0.0).is_err() && pedestal.layers(1e-9).is_err());
    for (layer, height) in [(1.0, 0.0), (0.0, 5.0), (1.0, f64::NAN), (1.0, -1.0)] {
        assert_eq!(Pedestal::new(&whole, &Vector3::z(), layer, height), None);
    }
}

/// A post, and beside it a ball of 6 mm radius on a level neck of 1.8 mm.
fn on_a_neck() -> Shape {
    cells([40, 16, 24], |p| {
        let post = to_segment(p, [6.0, 8.0, -5.0], [6.0, 8.0, 19.0]).max(4.1 - p.z) - 4.1;
        let ball = (p - Vector3::new(28.0, 8.0, 14.0)).norm() - 6.1;
        post.min(to_segment(p, [6.0, 8.0, 14.0], [28.0, 8.0, 14.0]) - 1.8).min(ball)
    })
}

#[test]
fn seams_that_are_too_weak_are_not_made() {
    let whole = solid(&on_a_neck());
    let strength = SeamStrength { print_force_n: 4.0, ..SeamStrength::default() };
    // So that the neck bears less than the force at the far side of the ball.
    let weak = SeamStrength { bond_mpa: 12.0, platform_bond_mpa: 1e3, ..strength };
    let any = searched(&whole, TuningOptions { strength: Some(SeamStrength { bond_mpa: 1e3, ..weak }), ..tuning() });
    let strained = |parts: &Decomposition, allowed: f64| {
        parts.holds.iter().filter(|hold| !hold.on_platform && hold.stress_mpa > allowed).count()
    };
    assert!(any.parts.len() > 1 && strained(&any, 6.0) > 0, "{:?}", any.holds);
    let held = searched(&whole, TuningOptions { strength: Some(weak), ..tuning() });
    assert_eq!(strained(&held, 6.0), 0, "{:?}", held.holds);
    assert!(held.risky_mm2() <= held.risky_before_mm2 && held.parts.len() <= any.parts.len() + 3);
    // Each part is held by something, and all of the weight comes to the foot.
    assert_eq!(held.holds.len(), held.parts.len());
    assert!((held.holds[0].carried_mm3 - whole.volume()).abs() < 1e-6 * whole.volume() && held.holds[0].on_platform);
    // Its area is that of the seam that the part has.
    for hold in &any.holds[1..] {
        let section = hold.section.unwrap();
        assert!((section.area_mm2 - any.parts[hold.part].seam_mm2).abs() < 1e-6 * section.area_mm2);
        assert!(hold.carried_mm3 >= any.parts[hold.part].solid.volume() * (1.0 - 1e-9));
    }
    // As in the paper without.
    assert!(searched(&whole, tuning()).holds.is_empty());
}

#[test]
fn bad_strengths_and_pedestals_are_named() {
    let whole = block(10.0, 10.0, 10.0);
    let name =
        |tuning: TuningOptions| match beam_search(&whole, None, &BeamOptions { tuning, ..BeamOptions::default() }, &go)
            .unwrap_err()
        {
            RoboFdmError::Option { name, .. } => name,
            other => panic!("{other}"),
        };
    let of = |strength: SeamStrength| name(TuningOptions { strength: Some(strength), ..tuning() });
    let default = SeamStrength::default();
    assert_eq!(of(SeamStrength { density_g_cm3: -1.0, ..default }), "strength.density_g_cm3");
    assert_eq!(of(SeamStrength { print_force_n: f64::NAN, ..default }), "strength.print_force_n");
    assert_eq!(of(SeamStrength { bond_mpa: 0.0, ..default }), "strength.bond_mpa");
    assert_eq!(of(SeamStrength { platform_bond_mpa: 0.0, ..default }), "strength.platform_bond_mpa");
    assert_eq!(of(SeamStrength { safety: 0.5, ..default }), "strength.safety");
    assert_eq!(name(TuningOptions { head: Some(head(-1.0)), ..tuning() }), "head.pedestal");
}
