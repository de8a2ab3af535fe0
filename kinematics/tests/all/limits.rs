//! Limits and turns against counting whole turns one by one.

use curvlay_kinematics::{JointLimits, LimitError, robots};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

/// All images of one angle within its limits, rising.
fn images_of(angle: f64, lower: f64, upper: f64) -> Vec<f64> {
    (-20..=20).map(|turns| angle + TAU * f64::from(turns)).filter(|image| (lower..=upper).contains(image)).collect()
}

fn limits() -> impl Strategy<Value = JointLimits<2>> {
    prop::array::uniform2((-12.0..12.0, 0.0..20.0)).prop_map(|ranges: [(f64, f64); 2]| JointLimits {
        lower: ranges.map(|(lower, _)| lower),
        upper: ranges.map(|(lower, width)| lower + width),
        ..JointLimits::NONE
    })
}

proptest! {
    #[test]
    fn images_are_those_that_counting_finds(
        limits in limits(),
        joints in prop::array::uniform2(-PI..PI),
        from in prop::array::uniform2(-30.0..30.0),
    ) {
        let [a, b] = [0, 1].map(|k| images_of(joints[k], limits.lower[k], limits.upper[k]));
        let wanted: Vec<[f64; 2]> = b.iter().flat_map(|&b| a.iter().map(move |&a| [a, b])).collect();
        let found: Vec<[f64; 2]> = limits.images(&joints, &from).collect();
        prop_assert_eq!(found.len(), wanted.len());
        for (found, wanted) in found.iter().zip(&wanted) {
            prop_assert!((0..2).all(|k| (found[k] - wanted[k]).abs() < 1e-12));
            prop_assert!(limits.contains(found));
        }
        let distance = |image: &[f64; 2]| (image[0] - from[0]).hypot(image[1] - from[1]);
        let least = wanted.iter().map(distance).fold(f64::INFINITY, f64::min);
        match limits.nearest_image(&joints, &from) {
            Some(nearest) => prop_assert!((distance(&nearest) - least).abs() < 1e-12 && limits.contains(&nearest)),
            None => prop_assert!(wanted.is_empty()),
        }
    }
}

#[test]
fn a_hair_beyond_a_stop_is_on_it() {
    let limits = JointLimits { lower: [-1.0], upper: [1.0], ..JointLimits::NONE };
    assert_eq!(limits.nearest_image(&[1.0 + 1e-12], &[0.0]), Some([1.0]));
    assert_eq!(limits.nearest_image(&[-1.0 - 1e-12 + TAU], &[0.0]), Some([-1.0]));
    assert_eq!(limits.nearest_image(&[1.0 + 1e-8], &[0.0]), None);
    assert_eq!(limits.images(&[1.0 + 1e-12], &[0.0]).collect::<Vec<_>>(), [[1.0]]);
    assert_eq!(limits.images(&[2.0], &[0.0]).count(), 0);
    let one_point = JointLimits { lower: [1.0], upper: [1.0], ..JointLimits::NONE };
    assert_eq!(one_point.images(&[1.0], &[9.0]).collect::<Vec<_>>(), [[1.0]]);
}

#[test]
fn an_endless_joint_has_the_image_next_to_the_reference() {
    let images: Vec<[f64; 1]> = JointLimits::NONE.images(&[1.0], &[100.0]).collect();
    assert_eq!(images.len(), 1);
    assert!((images[0][0] - 100.0).abs() <= PI && ((images[0][0] - 1.0) / TAU).fract().abs() < 1e-12);
}

#[test]
fn limits_of_any_size_end() {
    let wide = JointLimits { lower: [-1e300, 5.0], upper: [1e300, 1e17], ..JointLimits::NONE };
    assert_eq!(wide.check(), Ok(()));
    assert_eq!(wide.images(&[1.0; 2], &[9.0; 2]).count(), 1);
    let far = JointLimits { lower: [1e300], upper: [1e300], ..JointLimits::NONE };
    assert!(far.images(&[1.0], &[0.0]).count() <= 1);
}

#[test]
fn angles_that_are_no_numbers_have_no_image() {
    for angle in [f64::NAN, f64::INFINITY] {
        assert_eq!(JointLimits::NONE.nearest_image(&[angle], &[0.0]), None);
        assert_eq!(robots::UR5.limits.nearest_image(&[angle; 6], &[0.0; 6]), None);
        assert_eq!(robots::UR5.limits.nearest_image(&[0.0; 6], &[angle; 6]), None);
        assert!(!robots::UR5.limits.contains(&[angle; 6]));
    }
}

#[test]
fn limits_that_cannot_be_are_named() {
    let good: JointLimits<2> = JointLimits { lower: [-1.0; 2], upper: [1.0; 2], ..JointLimits::NONE };
    assert_eq!(good.check(), Ok(()));
    let empty = JointLimits { upper: [1.0, -2.0], ..good };
    assert_eq!(empty.check(), Err(LimitError::Empty { joint: 1, lower: -1.0, upper: -2.0 }));
    assert!(matches!(JointLimits { lower: [f64::NAN; 2], ..good }.check(), Err(LimitError::Empty { joint: 0, .. })));
    assert!(matches!(
        JointLimits { lower: [f64::INFINITY; 2], ..JointLimits::NONE }.check(),
        Err(LimitError::Empty { .. })
    ));
    for (what, limits) in [
        ("velocity", JointLimits { velocity: [1.0, 0.0], ..good }),
        ("acceleration", JointLimits { acceleration: [1.0, -1.0], ..good }),
        ("jerk", JointLimits { jerk: [1.0, f64::NAN], ..good }),
    ] {
        assert!(matches!(limits.check(), Err(LimitError::Still { joint: 1, what: named, .. }) if named == what));
    }
}
