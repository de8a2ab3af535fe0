//! The table of an arm of the UR type from its axes at zero.
//!
//! As in `ortho`: each joint of the [`DhTable`] is found at the posture in which the file has all joints at 0. Symbols as in `arm::ur`: `n` is the normal of the plane
//! in which upper arm and forearm move; the offsets along the parallel axes are all put into `d4`.

use super::error::AxisMisfit;
use super::fit::Fit;
use super::lines::{Conditions, Line, sense, sign};
use crate::arm::{DhTable, Geometry};
use nalgebra::{Isometry3, Vector3};

pub(super) const FAMILY: &str = "an arm of the UR type";

/// The first axis that is not where this family has it.
pub(super) fn misfit(axes: &[Line; 6]) -> Option<AxisMisfit> {
    let mut conditions = Conditions::new(axes);
    conditions.square(1, 0);
    conditions.meet(1, 0);
    conditions.parallel(2, 1);
    conditions.beside(2, 1);
    conditions.parallel(3, 2);
    conditions.beside(3, 2);
    conditions.square(4, 3);
    conditions.meet(4, 3);
    conditions.square(5, 4);
    conditions.meet(5, 4);
    conditions.first
}

/// The arm whose axes these are, seen from its base, and whose flange is there. Its axes fit.
pub(super) fn fit(axes: &[Line; 6], flange: &Isometry3<f64>, first_sign: f64) -> Fit {
    let up = Vector3::z();
    let shoulder = Vector3::new(0.0, 0.0, axes[1].nearest_to(&axes[0]).z);
    let level = Vector3::new(axes[1].along.x, axes[1].along.y, 0.0).normalize();
    let wrist = axes[3].nearest_to(&axes[4]);
    let n = level * sense((wrist - shoulder).dot(&level));
    let x1 = Vector3::new(-n.y, n.x, 0.0);
    // Links of a UR arm point against x.
    let link = |from: &Vector3<f64>, to: &Vector3<f64>| {
        let along = (to - from) - n * (to - from).dot(&n);
        let x = -along / along.norm();
        (-along.norm(), x.z.atan2(x.dot(&x1)))
    };
    let (upper_arm, at2) = link(&shoulder, &axes[2].at);
    let (forearm, at3) = link(&axes[2].at, &axes[3].at);
    let crossing = axes[5].nearest_to(&axes[4]);
    let z4 = axes[4].along - n * axes[4].along.dot(&n);
    let z4 = z4.normalize() * sense((crossing - wrist).dot(&z4));
    let at4 = z4.dot(&x1).atan2(-z4.z);
    let x4 = x1 * at4.cos() + up * at4.sin();
    let hand = Fit::hand(&axes[5], &crossing, flange, &z4);
    let t5 = (-hand.z.dot(&x4)).atan2(hand.z.dot(&n));
    let x5 = x4 * t5.cos() + n * t5.sin();
    let inner = [n.x.atan2(-n.y), at2, at3 - at2, at4 - at3, t5, hand.x.dot(&-z4).atan2(hand.x.dot(&x5))];
    let d = [shoulder.z, 0.0, 0.0, (wrist - shoulder).dot(&n), (crossing - wrist).dot(&z4), hand.length];
    let signs = [
        first_sign,
        sign(&axes[1].along, &n),
        sign(&axes[2].along, &n),
        sign(&axes[3].along, &n),
        sign(&axes[4].along, &z4),
        sign(&axes[5].along, &hand.z),
    ];
    Fit { geometry: Geometry::Ur(DhTable::ur(d, upper_arm, forearm)), inner, signs }
}
