//! The lengths of an ortho-parallel arm with a spherical wrist from its axes at zero.
//!
//! The arm's base frame has z along axis 1. From there on each joint of [`OrthoLengths`] is found at the posture in which the file has all joints at 0: its angle
//! there is what the joint's offset takes off. Symbols as in `arm::ortho`: `x1` points forward in the arm's plane, `y1` across it, `u` along the forearm.

use super::error::AxisMisfit;
use super::fit::Fit;
use super::lines::{Conditions, DISTANCE_MM, Line, sense, sign};
use crate::arm::{Geometry, OrthoLengths};
use nalgebra::{Isometry3, Vector3};

pub(super) const FAMILY: &str = "an ortho-parallel arm with a spherical wrist";

/// The first axis that is not where this family has it.
pub(super) fn misfit(axes: &[Line; 6]) -> Option<AxisMisfit> {
    let mut conditions = Conditions::new(axes);
    conditions.square(1, 0);
    conditions.parallel(2, 1);
    conditions.beside(2, 1);
    conditions.square(3, 2);
    conditions.square(4, 3);
    conditions.meet(4, 3);
    conditions.square(5, 4);
    conditions.through(&axes[3].nearest_to(&axes[4]), 5, 4);
    conditions.first
}

/// The arm whose axes these are, seen from its base, and whose flange is there. Its axes fit.
pub(super) fn fit(axes: &[Line; 6], flange: &Isometry3<f64>, first_sign: f64) -> Fit {
    let up = Vector3::z();
    let level = |along: &Vector3<f64>| Vector3::new(along.x, along.y, 0.0).normalize();
    let mut y1 = level(&axes[1].along);
    let mut x1 = y1.cross(&up);
    let ahead = axes[1].at.dot(&x1);
    // Axis 2 is in front of axis 1; if it meets it, forward is where x of the base points.
    let backward = if ahead.abs() <= DISTANCE_MM { (x1.x, x1.y) < (0.0, 0.0) } else { ahead < 0.0 };
    if backward {
        (x1, y1) = (-x1, -y1);
    }
    let upper_arm = axes[2].at - axes[1].at;
    let (forward, high) = (upper_arm.dot(&x1), upper_arm.z);
    let t2 = forward.atan2(high);
    let wrist = axes[3].nearest_to(&axes[4]);
    let from_elbow = wrist - axes[2].at;
    let from_elbow = from_elbow - y1 * from_elbow.dot(&y1);
    let u = (axes[3].along - y1 * axes[3].along.dot(&y1)).normalize();
    let u = u * sense(from_elbow.dot(&u));
    let x3 = y1.cross(&u);
    let across = axes[4].along * if axes[4].along.dot(&y1) < 0.0 { -1.0 } else { 1.0 };
    let y4 = (across - u * across.dot(&u)).normalize();
    let x4 = y4.cross(&u);
    let hand = Fit::hand(&axes[5], &wrist, flange, &y4);
    let x5 = y4.cross(&hand.z);
    let inner = [
        x1.y.atan2(x1.x),
        t2,
        u.dot(&x1).atan2(u.z) - t2,
        (-y4.dot(&x3)).atan2(y4.dot(&y1)),
        hand.z.dot(&x4).atan2(hand.z.dot(&u)),
        hand.x.dot(&y4).atan2(hand.x.dot(&x5)),
    ];
    let lengths = OrthoLengths {
        a1: axes[1].at.dot(&x1),
        a2: from_elbow.dot(&x3),
        b: wrist.dot(&y1),
        c1: axes[1].at.z,
        c2: forward.hypot(high),
        c3: from_elbow.dot(&u),
        c4: hand.length,
    };
    let signs = [
        first_sign,
        sign(&axes[1].along, &y1),
        sign(&axes[2].along, &y1),
        sign(&axes[3].along, &u),
        sign(&axes[4].along, &y4),
        sign(&axes[5].along, &hand.z),
    ];
    Fit { geometry: Geometry::Ortho(lengths), inner, signs }
}
