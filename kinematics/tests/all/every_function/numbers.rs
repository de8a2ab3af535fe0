//! Numbers of every kind, and what is made of them.

use curvlay_kinematics::nalgebra::{
    Isometry3, Point3, Quaternion, Translation3, Unit, UnitQuaternion, UnitVector3, Vector3,
};
use curvlay_kinematics::{JointLimits, Progress, Waypoint};
use proptest::prelude::*;
use std::ops::ControlFlow;

/// Not finite, none, or far out.
pub fn bad() -> impl Strategy<Value = f64> {
    let infinite = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let finite = [0.0, -0.0, 1e308, -1e308, f64::MAX, 5e-324, -5e-324, 1e15, -1e9, 1e-9, -1.0];
    prop::sample::select([&infinite[..], &finite].concat())
}

/// Sound for the most part.
pub fn number() -> impl Strategy<Value = f64> {
    prop_oneof![5 => (-3..=3i32).prop_map(f64::from), 5 => -3.0..3.0f64, 2 => bad()]
}

/// A number of things: few, none, more than there is memory for.
pub fn count() -> impl Strategy<Value = usize> {
    prop::sample::select(vec![0, 1, 2, 3, 7, 40, usize::MAX / 2, usize::MAX])
}

pub fn index() -> impl Strategy<Value = u32> {
    prop_oneof![9 => 0..5u32, 1 => prop::sample::select(vec![63, 64, 1 << 20, u32::MAX])]
}

/// Joints of an arm, one of them spoilt now and then.
pub fn joints() -> impl Strategy<Value = [f64; 6]> {
    (prop::array::uniform6(-3.0..3.0f64), 0..30usize, bad()).prop_map(|(mut joints, at, value)| {
        if let Some(joint) = joints.get_mut(at) {
            *joint = value;
        }
        joints
    })
}

/// Some hundred millimetres from the origin, or anywhere.
pub fn point() -> impl Strategy<Value = Point3<f64>> {
    prop_oneof![
        8 => [-400.0..400.0f64, -400.0..400.0f64, 0.0..400.0f64].prop_map(Point3::from),
        1 => [number(), number(), number()].prop_map(Point3::from),
    ]
}

pub fn vector() -> impl Strategy<Value = Vector3<f64>> {
    [number(), number(), number()].prop_map(Vector3::from)
}

/// Upright for the most part; else of any length.
pub fn unit() -> impl Strategy<Value = UnitVector3<f64>> {
    let leaning = |v: Vector3<f64>| Unit::try_new(v, 1e-9).unwrap_or(Vector3::z_axis());
    prop_oneof![
        3 => Just(Vector3::z_axis()),
        3 => [-1.0..1.0f64, -1.0..1.0f64, 0.2..1.0f64].prop_map(move |v| leaning(v.into())),
        1 => Just(-Vector3::z_axis()),
        1 => vector().prop_map(Unit::new_unchecked),
    ]
}

pub fn rotation() -> impl Strategy<Value = UnitQuaternion<f64>> {
    prop_oneof![
        6 => prop::array::uniform3(-3.0..3.0f64).prop_map(|v| UnitQuaternion::from_scaled_axis(v.into())),
        1 => prop::array::uniform4(number()).prop_map(|[w, i, j, k]| Unit::new_unchecked(Quaternion::new(w, i, j, k))),
    ]
}

pub fn pose() -> impl Strategy<Value = Isometry3<f64>> {
    (point(), rotation()).prop_map(|(at, rotation)| Isometry3::from_parts(Translation3::from(at.coords), rotation))
}

pub fn waypoint() -> impl Strategy<Value = Waypoint> {
    (point(), unit()).prop_map(|(position, axis)| Waypoint { position: position * 0.1, axis })
}

/// Limits of which any may be out of order, and sound ones with one number spoilt.
pub fn limits<const N: usize>() -> impl Strategy<Value = JointLimits<N>> {
    let five = || prop::collection::vec(number(), N).prop_map(|list| <[f64; N]>::try_from(list).unwrap());
    let any = (five(), five(), five(), five(), five()).prop_map(|(lower, upper, velocity, acceleration, jerk)| {
        JointLimits { lower, upper, velocity, acceleration, jerk }
    });
    let sound = JointLimits { lower: [-3.0; N], upper: [4.0; N], ..JointLimits::NONE };
    let spoilt = (0..N, 0..6usize, bad()).prop_map(move |(joint, what, value)| {
        let mut limits = sound;
        let JointLimits { lower, upper, velocity, acceleration, jerk } = &mut limits;
        if let Some(list) = [lower, upper, velocity, acceleration, jerk].into_iter().nth(what) {
            list[joint] = value;
        }
        limits
    });
    prop_oneof![1 => any, 3 => spoilt]
}

/// The options as they are, and with each field in turn set to a number.
pub fn each_spoilt<T: Clone, V: Copy>(sound: &T, fields: &[fn(&mut T, V)], value: V) -> Vec<T> {
    let spoilt = fields.iter().map(|set| {
        let mut options = sound.clone();
        set(&mut options, value);
        options
    });
    std::iter::once(sound.clone()).chain(spoilt).collect()
}

pub fn go(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}
