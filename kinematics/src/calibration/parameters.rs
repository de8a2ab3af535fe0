//! The numbers of an arm that measured poses can determine, by family.

use crate::arm::ArmDeviation;
use nalgebra::{UnitQuaternion, Vector3};
use std::fmt;

/// Which numbers of an arm are fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FitScope {
    /// Offsets of joints 2 to 5: the zeros.
    Offsets,
    /// These, and the lengths for which the closed form of the inverse still holds exactly.
    Lengths,
    /// All that poses can determine.
    #[default]
    All,
}

/// A number of an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArmParameter {
    /// The offset of a joint, counted from 0, in radians.
    Offset(usize),
    /// The shift of an axis, counted from 0, along a coordinate of its frame, in millimetres; see [`ArmDeviation::axes`]. It may be a
    /// length of the arm: then that is its name.
    Shift {
        /// The axis, 1 to 5.
        axis: usize,
        /// 0 to 2.
        coordinate: usize,
        /// As the family calls it.
        length: Option<&'static str>,
        /// 1, or -1 where the length grows against the coordinate.
        sign: f64,
    },
    /// The turn of an axis about a coordinate of its frame, in radians.
    Turn {
        /// The axis, 1 to 5.
        axis: usize,
        /// 0 to 2.
        coordinate: usize,
    },
}

impl ArmParameter {
    /// Whether it is an angle; otherwise it is a length.
    pub fn is_angle(&self) -> bool {
        !matches!(self, ArmParameter::Shift { .. })
    }

    /// Whether the closed form of the inverse has it.
    pub(super) fn is_in(&self, scope: FitScope) -> bool {
        match scope {
            FitScope::Offsets => matches!(self, ArmParameter::Offset(_)),
            FitScope::Lengths => {
                matches!(self, ArmParameter::Offset(_) | ArmParameter::Shift { length: Some(_), .. })
            }
            FitScope::All => true,
        }
    }
}

impl fmt::Display for ArmParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |coordinate: usize| ["x", "y", "z"][coordinate.min(2)];
        match *self {
            ArmParameter::Offset(joint) => write!(f, "offset of joint {}", joint + 1),
            ArmParameter::Shift { length: Some(length), .. } => write!(f, "length {length}"),
            ArmParameter::Shift { axis, coordinate, length: None, .. } => {
                write!(f, "axis {} shifted along {}", axis + 1, name(coordinate))
            }
            ArmParameter::Turn { axis, coordinate } => write!(f, "axis {} turned about {}", axis + 1, name(coordinate)),
        }
    }
}

const fn shift(axis: usize, coordinate: usize) -> ArmParameter {
    ArmParameter::Shift { axis, coordinate, length: None, sign: 1.0 }
}

const fn length(axis: usize, coordinate: usize, name: &'static str) -> ArmParameter {
    ArmParameter::Shift { axis, coordinate, length: Some(name), sign: 1.0 }
}

const fn turn(axis: usize, coordinate: usize) -> ArmParameter {
    ArmParameter::Turn { axis, coordinate }
}

const fn offset(joint: usize) -> ArmParameter {
    ArmParameter::Offset(joint)
}

/// Of an arm of the UR type: frames of axes 2, 5 and 6 have y or -y along the axis before them, which the lengths `d4` and `d5` and
/// the offsets of the joints before take up; those of axes 3 and 4 have z along it, and the sum of `d2`, `d3` and `d4` counts.
pub(super) const UR: [ArmParameter; 18] = [
    shift(1, 0),
    turn(1, 0),
    offset(1),
    length(2, 0, "a2"),
    turn(2, 0),
    turn(2, 1),
    offset(2),
    length(3, 0, "a3"),
    turn(3, 0),
    turn(3, 1),
    offset(3),
    length(4, 1, "d4"),
    shift(4, 0),
    turn(4, 0),
    offset(4),
    // z of frame 4 is -y of frame 5.
    ArmParameter::Shift { axis: 5, coordinate: 1, length: Some("d5"), sign: -1.0 },
    shift(5, 0),
    turn(5, 0),
];

/// Of an ortho-parallel arm: axes 2, 3 and 5 are along y, the others along z.
pub(super) const ORTHO: [ArmParameter; 18] = [
    length(1, 0, "a1"),
    length(1, 1, "b"),
    turn(1, 0),
    offset(1),
    length(2, 2, "c2"),
    turn(2, 0),
    turn(2, 2),
    offset(2),
    length(3, 0, "a2"),
    turn(3, 0),
    offset(3),
    length(3, 2, "c3"),
    shift(4, 0),
    turn(4, 0),
    offset(4),
    shift(5, 0),
    shift(5, 1),
    turn(5, 0),
];

/// The deviation that values of parameters make. Turns of an axis are one rotation vector.
pub(super) fn deviation_of(parameters: &[ArmParameter], values: &[f64]) -> ArmDeviation {
    let mut deviation = ArmDeviation::none();
    let mut turns = [Vector3::zeros(); 5];
    for (parameter, &value) in parameters.iter().zip(values) {
        match *parameter {
            ArmParameter::Offset(joint) => deviation.offsets[joint] = value,
            ArmParameter::Shift { axis, coordinate, sign, .. } => {
                deviation.axes[axis - 1].translation.vector[coordinate] = sign * value;
            }
            ArmParameter::Turn { axis, coordinate } => turns[axis - 1][coordinate] = value,
        }
    }
    for (axis, turn) in deviation.axes.iter_mut().zip(turns) {
        axis.rotation = UnitQuaternion::from_scaled_axis(turn);
    }
    deviation
}
