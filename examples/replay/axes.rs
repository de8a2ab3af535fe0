//! The axes of a machine, and where its nozzle is: plain data that all modules share.

pub use curvlay_examples::laid::NozzlePose;
use nalgebra::{Matrix3, Vector3};

/// Most axes of a machine: an arm and a table.
pub const MAX_AXES: usize = 8;

/// A value for each axis, in radians or millimetres; what a machine does not have is 0.
pub type Axes = [f64; MAX_AXES];

/// A rotation and a place, in millimetres: maps coordinates of a frame into those of the one that carries it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The rotation.
    pub turn: Matrix3<f64>,
    /// The origin.
    pub at: Vector3<f64>,
}

impl Frame {
    /// The frame that carries it.
    pub fn identity() -> Self {
        Frame { turn: Matrix3::identity(), at: Vector3::zeros() }
    }

    /// A place without a rotation.
    pub fn shift(x: f64, y: f64, z: f64) -> Self {
        Frame { turn: Matrix3::identity(), at: Vector3::new(x, y, z) }
    }

    /// A rotation about an axis of length 1, by the formula of Rodrigues.
    pub fn rotation(axis: &Vector3<f64>, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let cross = Matrix3::new(0.0, -axis.z, axis.y, axis.z, 0.0, -axis.x, -axis.y, axis.x, 0.0);
        let turn = Matrix3::identity() * cos + cross * sin + axis * axis.transpose() * (1.0 - cos);
        Frame { turn, at: Vector3::zeros() }
    }

    /// Roll, pitch and yaw about the fixed x, y and z axes, in radians.
    pub fn from_rpy([roll, pitch, yaw]: [f64; 3], at: [f64; 3]) -> Self {
        let about = |axis: Vector3<f64>, angle: f64| Frame::rotation(&axis, angle).turn;
        let turn = about(Vector3::z(), yaw) * about(Vector3::y(), pitch) * about(Vector3::x(), roll);
        Frame { turn, at: at.into() }
    }

    /// This frame, then one that it carries.
    pub fn then(&self, carried: &Frame) -> Frame {
        Frame { turn: self.turn * carried.turn, at: self.at + self.turn * carried.at }
    }

    /// From the outer frame back.
    pub fn inverse(&self) -> Frame {
        let back = self.turn.transpose();
        Frame { turn: back, at: -(back * self.at) }
    }

    /// The vector about which a frame turns relative to another one, its length the angle in radians: from `self` to `to`, in coordinates of `self`.
    pub fn turn_to(&self, to: &Frame) -> Vector3<f64> {
        let relative = self.turn.transpose() * to.turn;
        let sine = 0.5
            * Vector3::new(
                relative[(2, 1)] - relative[(1, 2)],
                relative[(0, 2)] - relative[(2, 0)],
                relative[(1, 0)] - relative[(0, 1)],
            );
        let (sin, cos) = (sine.norm(), 0.5 * (relative.trace() - 1.0));
        let angle = sin.atan2(cos);
        if sin > HALF_TURN_SINE {
            return sine * (angle / sin);
        }
        if cos > 0.0 {
            // Sine and angle agree to all digits.
            return sine;
        }
        // Half a turn: the axis is the longest column of (R + 1) / 2.
        let doubled = 0.5 * (relative + Matrix3::identity());
        let longest = (0..3).max_by(|&a, &b| doubled[(a, a)].total_cmp(&doubled[(b, b)])).unwrap_or(0);
        let axis = doubled.column(longest).into_owned();
        axis * (angle / axis.norm())
    }
}

/// Below this sine an angle is next to nothing, or next to half a turn, where the sine has lost the axis.
const HALF_TURN_SINE: f64 = 1e-7;

impl From<&nalgebra::Isometry3<f64>> for Frame {
    fn from(pose: &nalgebra::Isometry3<f64>) -> Self {
        Frame { turn: pose.rotation.to_rotation_matrix().into_inner(), at: pose.translation.vector }
    }
}

/// What the axes may do, in radians or millimetres and seconds; infinite where there is no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Smallest values.
    pub lower: Axes,
    /// Greatest values.
    pub upper: Axes,
    /// Greatest speeds.
    pub speed: Axes,
    /// Greatest accelerations.
    pub acceleration: Axes,
    /// Greatest jerks.
    pub jerk: Axes,
}

impl Limits {
    /// No limits.
    pub const NONE: Limits = Limits {
        lower: [f64::NEG_INFINITY; MAX_AXES],
        upper: [f64::INFINITY; MAX_AXES],
        speed: [f64::INFINITY; MAX_AXES],
        acceleration: [f64::INFINITY; MAX_AXES],
        jerk: [f64::INFINITY; MAX_AXES],
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..ProptestConfig::with_cases(128) })]

        #[test]
        fn frames_agree_with_the_library(
            a in prop::array::uniform3(-3.1f64..3.1), b in prop::array::uniform3(-3.1f64..3.1), p in prop::array::uniform3(-500f64..500.0)
        ) {
            let isometry = |rpy: [f64; 3], at: [f64; 3]| {
                let turn = nalgebra::UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]);
                nalgebra::Isometry3::from_parts(nalgebra::Translation3::from(at), turn)
            };
            let (first, second) = (Frame::from_rpy(a, p), Frame::from_rpy(b, [p[1], p[2], p[0]]));
            let (one, two) = (isometry(a, p), isometry(b, [p[1], p[2], p[0]]));
            let close = |frame: &Frame, pose: &nalgebra::Isometry3<f64>| {
                let of = Frame::from(pose);
                (frame.turn - of.turn).norm() < 1e-12 && (frame.at - of.at).norm() < 1e-9
            };
            prop_assert!(close(&first.then(&second), &(one * two)));
            prop_assert!(close(&first.inverse(), &one.inverse()));
            let turn = first.turn_to(&second);
            let angle = turn.norm();
            let again = if angle > 0.0 { first.turn * Frame::rotation(&(turn / angle), angle).turn } else { first.turn };
            prop_assert!((again - second.turn).norm() < 1e-8, "{}", (again - second.turn).norm());
        }
    }

    #[test]
    fn half_a_turn_keeps_its_axis() {
        for axis in [Vector3::x(), Vector3::y(), Vector3::new(0.6, 0.0, -0.8)] {
            let turned = Frame::rotation(&axis, std::f64::consts::PI);
            let turn = Frame::identity().turn_to(&turned);
            assert!((turn.norm() - std::f64::consts::PI).abs() < 1e-9 && turn.cross(&axis).norm() < 1e-7, "{turn}");
        }
        assert_eq!(Frame::identity().turn_to(&Frame::identity()), Vector3::zeros());
    }
}
