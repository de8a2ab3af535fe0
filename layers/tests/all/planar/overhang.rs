//! Risky area (Eq. 2.1): closed forms and bad input.

use super::shapes::{cube, torus, turned};
use curvlay_layers::nalgebra::Vector3;
use curvlay_layers::planar::{OverhangError, risky_area, risky_faces};
use std::f64::consts::{PI, TAU};

#[test]
fn a_cone_on_its_tip_is_safe_up_to_its_slope() {
    // Leans by 30 degrees from upright.
    let (height, radius) = (10.0, 10.0 * 30_f64.to_radians().tan());
    let cone = turned(&[[0.0, 0.0], [radius, height], [0.0, height]], 240);
    let side = (0..cone.triangles().len())
        .map(|t| {
            let [a, b, c] = cone.corners(t);
            let n = (b - a).cross(&(c - a));
            if n.z < 0.0 { n.norm() / 2.0 } else { 0.0 }
        })
        .sum::<f64>();
    let risky = |degrees: f64| risky_area(&cone, &Vector3::z(), degrees.to_radians(), None).unwrap();
    assert_eq!(risky(30.1), 0.0);
    assert!((risky(29.9) - side).abs() < 1e-9 && (side - PI * radius * radius.hypot(height)).abs() < 0.1);
    // The other way up only the base is risky, unless it is named.
    let down = -Vector3::z() * 3.0;
    assert!(
        (risky_area(&cone, &down, 0.5, None).unwrap() - 120.0 * radius * radius * (TAU / 240.0).sin()).abs() < 1e-9
    );
    assert_eq!(risky_area(&cone, &down, 0.5, Some((-height, 1e-9))).unwrap(), 0.0);
}

#[test]
fn of_a_torus_the_band_below_is_risky() {
    let (radius, tube) = (10.0, 3.0);
    let torus = torus(radius, tube, [240, 240]);
    for degrees in [20.0_f64, 45.0, 70.0] {
        let angle = degrees.to_radians();
        // Where the normal looks down by more than the angle: an arc of pi - 2 angle of the tube, by Pappus.
        let band = TAU * radius * tube * (PI - 2.0 * angle);
        let risky = risky_area(&torus, &Vector3::z(), angle, None).unwrap();
        assert!((risky - band).abs() < 0.03 * band, "{degrees}: {risky} {band}");
    }
}

#[test]
fn turning_part_and_direction_together_changes_nothing() {
    let torus = torus(8.0, 4.0, [12, 8]);
    for [x, y, z] in [[1.0, 0.0, 0.0], [0.3, -0.4, 0.5], [0.0, -1.0, 0.0]] {
        let direction = Vector3::new(x, y, z);
        let faces = risky_faces(&torus, &direction, 0.7, None).unwrap();
        let by_hand = (0..torus.triangles().len()).filter(|&t| {
            let [a, b, c] = torus.corners(t);
            let n = (b - a).cross(&(c - a)).normalize();
            n.dot(&direction.normalize()) + 0.7_f64.sin() < 0.0
        });
        assert_eq!(faces, by_hand.collect::<Vec<_>>());
    }
}

#[test]
fn angles_of_nothing_and_directions_of_nothing_are_refused() {
    let cube = cube();
    for angle in [0.0, -0.1, 90_f64.to_radians(), f64::NAN] {
        assert!(matches!(risky_area(&cube, &Vector3::z(), angle, None), Err(OverhangError::Angle { .. })));
    }
    assert_eq!(risky_area(&cube, &Vector3::zeros(), 0.5, None), Err(OverhangError::Direction));
}
