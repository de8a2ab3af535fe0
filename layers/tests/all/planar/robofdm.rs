//! Parts cut by planes (RoboFDM, fine decomposition): what the paper promises of each part, and bad input.

use super::shapes::{assert_manifold, bend, blocks, ell, mushroom, tee, torus};
use curvlay_layers::nalgebra::Vector3;
use curvlay_layers::planar::{
    AuditOptions, CuttingError, CuttingOptions, PlaneDecomposition, Solid, VolumeOptions, VolumePart, audit_volumes,
    decompose_by_planes, risky_area,
};
use std::ops::ControlFlow;

fn upright() -> CuttingOptions {
    CuttingOptions { direction: Some(Vector3::z()), ..CuttingOptions::default() }
}

/// Cuts a solid, and checks what holds for every result.
fn cut(solid: &Solid, options: &CuttingOptions) -> PlaneDecomposition {
    let result = decompose_by_planes(solid, options, &|_| ControlFlow::Continue(())).unwrap();
    let [low, high] = solid.bounds();
    let size = (high - low).norm();
    let up = result.parts[0].base.normal();
    let volume: f64 = result.parts.iter().map(|part| part.solid.volume()).sum();
    assert!((volume - solid.volume()).abs() <= 1e-9 * solid.volume());
    for (k, part) in result.parts.iter().enumerate() {
        assert_manifold(&part.solid);
        // Above its base, which faces up, on a part that is printed before.
        assert!(part.solid.vertices().iter().all(|p| part.base.height(p) > -1e-9 * size), "{k}");
        assert!(part.base.normal().dot(&up) >= 0.0);
        assert_eq!(part.parent.is_none(), k == 0);
        assert!(part.parent.is_none_or(|parent| parent < k));
        assert_eq!(part.seam_mm2 > 0.0, k > 0);
        let base = Some((part.base.offset(), 1e-6 * size));
        let risky = risky_area(&part.solid, &part.base.normal(), options.max_angle, base).unwrap();
        assert!((risky - part.risky_mm2).abs() < 1e-6 * size * size, "{k}: {risky} {}", part.risky_mm2);
    }
    assert!(result.risky_after_mm2() <= result.risky_before_mm2);
    // No base crosses another one: each lies on one side of those of the parts around it (constraint I).
    for (k, part) in result.parts.iter().enumerate().skip(1) {
        let parent = &result.parts[part.parent.unwrap()];
        let area = slab_area(&part.solid, k, &result);
        assert!(
            (area - part.seam_mm2).abs() < 1e-6 * size * size,
            "{k}: all of a base lies on its parent, {area} {}",
            part.seam_mm2
        );
        assert!(parent.base.normal().dot(&up) >= 0.0);
    }
    // The audit of the other decomposition says that the parts are the solid.
    let parts: Vec<VolumePart> = result
        .parts
        .iter()
        .map(|part| VolumePart {
            solid: part.solid.clone(),
            direction: part.base.normal(),
            base_mm: part.base.offset(),
            separation: part.parent,
            layer_tops_mm: Vec::new(),
            overhang_mm3: 0.0,
        })
        .collect();
    let audit =
        audit_volumes(solid, &parts, &VolumeOptions::default(), &AuditOptions { lines: 30, ..AuditOptions::default() });
    assert!(audit.is_ok, "{audit:?}");
    result
}

/// The area of a part in its base plane.
fn slab_area(solid: &Solid, k: usize, result: &PlaneDecomposition) -> f64 {
    let base = &result.parts[k].base;
    (0..solid.triangles().len())
        .filter(|&t| solid.corners(t).iter().all(|p| base.height(p).abs() < 1e-9))
        .map(|t| {
            let [a, b, c] = solid.corners(t);
            -(b - a).cross(&(c - a)).dot(&base.normal()) / 2.0
        })
        .sum()
}

#[test]
fn arms_come_off() {
    for (name, solid, most) in [("ell", ell(), 0.2), ("tee", tee(), 0.2), ("bend", bend(15.0, 24), 0.2)] {
        let result = cut(&solid, &upright());
        assert!(result.risky_before_mm2 > 0.0 && result.parts.len() > 1, "{name}");
        let left = result.risky_after_mm2() / result.risky_before_mm2;
        assert!(left < most, "{name}: {left}");
    }
}

#[test]
fn what_is_safe_stays_whole_and_the_root_may_turn() {
    let cube = blocks(&[[0; 3]], 40.0);
    let result = cut(&cube, &upright());
    assert_eq!((result.parts.len(), result.risky_before_mm2), (1, 0.0));
    // A T is safe on its head.
    let result = cut(&tee(), &CuttingOptions::default());
    assert_eq!((result.parts.len(), result.risky_before_mm2), (1, 0.0));
}

#[test]
fn genus_one_and_enclosing_overhang_end() {
    for solid in [torus(40.0, 12.0, [24, 12]), mushroom()] {
        let result = cut(&solid, &CuttingOptions { normals: 40, ..upright() });
        assert!(result.parts.len() <= 64);
    }
}

#[test]
fn fewer_parts_leave_no_less_risky_area() {
    let whole = cut(&tee(), &upright());
    let two = cut(&tee(), &CuttingOptions { max_parts: 2, ..upright() });
    assert_eq!(two.parts.len(), 2);
    // A slab of the whole T, on which the rest is printed sideways, already does most of it.
    assert!(two.risky_after_mm2() >= whole.risky_after_mm2() && two.risky_after_mm2() < two.risky_before_mm2);
    assert_eq!(cut(&tee(), &CuttingOptions { max_parts: 1, ..upright() }).parts.len(), 1);
}

#[test]
fn options_that_make_no_sense_are_refused() {
    let refused =
        |options: CuttingOptions| decompose_by_planes(&tee(), &options, &|_| ControlFlow::Continue(())).unwrap_err();
    let d = CuttingOptions::default();
    for (options, name) in [
        (CuttingOptions { max_angle: 0.0, ..d }, "max_angle"),
        (CuttingOptions { max_angle: std::f64::consts::FRAC_PI_2, ..d }, "max_angle"),
        (CuttingOptions { step_mm: 0.0, ..d }, "step_mm"),
        (CuttingOptions { step_mm: f64::NAN, ..d }, "step_mm"),
        (CuttingOptions { least_gain: 0.0, ..d }, "least_gain"),
        (CuttingOptions { normals: 0, ..d }, "normals"),
        (CuttingOptions { tried_parts: 0, ..d }, "tried_parts"),
        (CuttingOptions { tried_planes: 0, ..d }, "tried_planes"),
        (CuttingOptions { max_parts: 0, ..d }, "max_parts"),
        (CuttingOptions { direction: Some(Vector3::zeros()), ..d }, "direction"),
    ] {
        let error = refused(options);
        assert!(matches!(error, CuttingError::Option { option, .. } if option == name), "{name}: {error}");
    }
    let facets = tee().triangles().len();
    assert_eq!(
        refused(CuttingOptions { tried_parts: facets + 1, ..d }),
        CuttingError::TriedParts { tried: facets + 1, facets }
    );
    assert_eq!(decompose_by_planes(&tee(), &upright(), &|_| ControlFlow::Break(())), Err(CuttingError::Stopped));
}
