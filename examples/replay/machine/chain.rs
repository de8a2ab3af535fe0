//! An arm as a product of matrices: a fixed step before each joint, a turn about z, a fixed step behind the last.

use super::super::axes::Frame;
use curvlay_kinematics::{ArmModel, Geometry};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// Six joints.
#[derive(Clone, Debug)]
pub struct Chain {
    /// From joint to joint, with z along the axis of the next one.
    steps: [Frame; 6],
    /// From the last joint to the flange.
    end: Frame,
    /// The angle about an axis is `sign * joint - offset`; of joint 3, `coupling` times joint 2 is added to the joint first.
    coupling: f64,
    signs: [f64; 6],
    offsets: [f64; 6],
}

/// The frame before each joint, turned by it, and the flange, in the base.
#[derive(Clone, Copy, Debug)]
pub struct Links {
    /// Behind each joint, z along its axis.
    pub joints: [Frame; 6],
    /// The flange.
    pub flange: Frame,
}

impl Chain {
    /// The arm with these numbers.
    ///
    /// # Arguments
    /// * `turned`: by how much the joints of the geometry are more than the numbers say, in radians.
    /// * `moved`: where axes 2 to 6 are, seen from where they should be.
    ///
    /// # Returns
    /// `None` for a kind of arm that is not known here.
    pub fn new(model: &ArmModel, turned: &[f64; 6], moved: &[Frame; 5]) -> Option<Self> {
        let offsets = std::array::from_fn(|k| model.offsets[k] - turned[k]);
        let (signs, coupling) = (model.signs, model.j23_factor);
        let mut chain = Chain { steps: [Frame::identity(); 6], end: Frame::identity(), coupling, signs, offsets };
        match &model.geometry {
            Geometry::Ur(table) => {
                // T = Rz(q) Tz(d) Tx(a) Rx(alpha)
                let behind = |k: usize| {
                    let twist = Frame::rotation(&Vector3::x(), table.alpha[k]);
                    Frame::shift(table.a[k], 0.0, table.d[k]).then(&twist)
                };
                for k in 1..6 {
                    chain.steps[k] = behind(k - 1).then(&moved[k - 1]);
                }
                chain.end = behind(5);
            }
            Geometry::Ortho(lengths) => {
                // All links upright: axes 1, 4 and 6 along z, axes 2, 3 and 5 along y.
                let places = [
                    [0.0, 0.0, lengths.c1],
                    [lengths.a1, lengths.b, 0.0],
                    [0.0, 0.0, lengths.c2],
                    [lengths.a2, 0.0, lengths.c3],
                    [0.0; 3],
                    [0.0, 0.0, lengths.c4],
                ];
                // Turns z to y.
                let to_y = Frame::rotation(&Vector3::x(), -FRAC_PI_2);
                let about_y = [false, true, true, false, true, false];
                for k in 0..6 {
                    let [x, y, z] = places[k];
                    let mut step = Frame::shift(x, y, z);
                    if k > 0 {
                        step = step.then(&moved[k - 1]);
                        if about_y[k - 1] {
                            step = to_y.inverse().then(&step);
                        }
                    }
                    chain.steps[k] = if about_y[k] { step.then(&to_y) } else { step };
                }
            }
            _ => return None,
        }
        Some(chain)
    }

    /// Where everything is at these joints, in radians.
    pub fn at(&self, joints: &[f64]) -> Links {
        let mut links = Links { joints: [Frame::identity(); 6], flange: Frame::identity() };
        let mut frame = Frame::identity();
        for (k, joint) in joints.iter().enumerate().take(6) {
            let coupled = if k == 2 { self.coupling * joints[1] } else { 0.0 };
            let angle = self.signs[k] * (joint + coupled) - self.offsets[k];
            frame = about_z(&frame.then(&self.steps[k]), angle);
            links.joints[k] = frame;
        }
        links.flange = frame.then(&self.end);
        links
    }

    /// How the flange moves with each joint: millimetres and radians a radian.
    pub fn rates(&self, links: &Links) -> [[Vector3<f64>; 2]; 6] {
        let mut rates = [0, 1, 2, 3, 4, 5].map(|k| {
            let axis = links.joints[k].turn.column(2) * self.signs[k];
            [axis.cross(&(links.flange.at - links.joints[k].at)), axis]
        });
        let third = rates[2];
        (0..2).for_each(|k| rates[1][k] += self.coupling * third[k]);
        rates
    }
}

/// A frame turned about its z axis.
fn about_z(frame: &Frame, angle: f64) -> Frame {
    let (sin, cos) = angle.sin_cos();
    let (x, y) = (frame.turn.column(0), frame.turn.column(1));
    let turn = Matrix3::from_columns(&[x * cos + y * sin, y * cos - x * sin, frame.turn.column(2).into_owned()]);
    Frame { turn, at: frame.at }
}

#[cfg(test)]
mod tests {
    use super::*;
    use curvlay_kinematics::{Arm, robots};
    use proptest::prelude::*;

    fn plain(model: &ArmModel) -> Chain {
        Chain::new(model, &[0.0; 6], &[Frame::identity(); 5]).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..ProptestConfig::with_cases(64) })]

        /// The arms of the library have another derivation: closed forms of rotation and wrist.
        #[test]
        fn the_flange_is_where_the_library_has_it(joints in prop::array::uniform6(-3.0f64..3.0)) {
            for arm in &robots::CATALOGUE {
                let (name, model) = (arm.name, &arm.model);
                let flange = plain(model).at(&joints).flange;
                let expected = Frame::from(&Arm::new(model).unwrap().forward(&joints));
                prop_assert!((flange.at - expected.at).norm() < 1e-9 && (flange.turn - expected.turn).norm() < 1e-12, "{name}");
            }
        }

        #[test]
        fn rates_are_differences(joints in prop::array::uniform6(-3.0f64..3.0)) {
            const STEP: f64 = 1e-6;
            for arm in &robots::CATALOGUE {
                let (name, model) = (arm.name, &arm.model);
                let chain = plain(model);
                let rates = chain.rates(&chain.at(&joints));
                for k in 0..6 {
                    let moved = |sign: f64| {
                        let mut joints = joints;
                        joints[k] += sign * STEP;
                        chain.at(&joints).flange
                    };
                    let (low, high) = (moved(-1.0), moved(1.0));
                    let speed = (high.at - low.at) / (2.0 * STEP);
                    let turn = low.turn * low.turn_to(&high) / (2.0 * STEP);
                    prop_assert!((speed - rates[k][0]).norm() < 1e-4 && (turn - rates[k][1]).norm() < 1e-6, "{name} {k}");
                }
            }
        }

        #[test]
        fn a_calibrated_arm_is_the_one_of_the_library(
            joints in prop::array::uniform6(-3.0f64..3.0), off in prop::array::uniform6(-0.01f64..0.01)
        ) {
            let rpy = [0.3 * off[0], off[1], off[2]];
            let at = [100.0 * off[3], 100.0 * off[4], 100.0 * off[5]];
            for arm in &robots::CATALOGUE {
                let (name, model) = (arm.name, &arm.model);
                let isometry = nalgebra::Isometry3::from_parts(
                    nalgebra::Translation3::from(at),
                    nalgebra::UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]),
                );
                let deviation = curvlay_kinematics::ArmDeviation { offsets: off, axes: [isometry; 5] };
                let Ok(arm) = Arm::calibrated(model, &deviation) else { continue };
                let flange = Chain::new(model, &off, &[Frame::from_rpy(rpy, at); 5]).unwrap().at(&joints).flange;
                let expected = Frame::from(&arm.forward(&joints));
                prop_assert!((flange.at - expected.at).norm() < 1e-8, "{name} {}", (flange.at - expected.at).norm());
            }
        }
    }
}
