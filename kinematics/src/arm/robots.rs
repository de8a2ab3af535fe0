//! Robots by their published numbers.
//!
//! Lengths and limits are the makers' as named at each constant; makers do not publish accelerations and jerks, so those
//! are infinite. Frames: of a UR arm frame 0 is the controller's base and frame 6 its flange (ROS `base_link` is this
//! base turned by pi about z); of an ABB arm the base frame at the floor, and `tool0`, z along axis 6.

use super::dh::DhTable;
use super::model::{ArmModel, Geometry};
use super::ortho::OrthoLengths;
use crate::limits::JointLimits;
use crate::positioner::PositionerModel;
use std::f64::consts::{FRAC_PI_2, TAU};

const fn radians<const N: usize>(degrees: [f64; N]) -> [f64; N] {
    let mut angles = degrees;
    let mut k = 0;
    while k < N {
        angles[k] = degrees[k].to_radians();
        k += 1;
    }
    angles
}

const fn limits<const N: usize>(lower: [f64; N], upper: [f64; N], speed_deg_s: [f64; N]) -> JointLimits<N> {
    JointLimits { lower, upper, velocity: radians(speed_deg_s), ..JointLimits::NONE }
}

const fn ur(d: [f64; 6], upper_arm: f64, forearm: f64, limits: JointLimits<6>) -> ArmModel {
    ArmModel { geometry: Geometry::Ur(DhTable::ur(d, upper_arm, forearm)), offsets: [0.0; 6], signs: [1.0; 6], limits }
}

const fn abb(lengths: OrthoLengths, limits: JointLimits<6>) -> ArmModel {
    // ABB counts joint 3 from a level forearm.
    let offsets = [0.0, 0.0, -FRAC_PI_2, 0.0, 0.0, 0.0];
    ArmModel { geometry: Geometry::Ortho(lengths), offsets, signs: [1.0; 6], limits }
}

const TWO_TURNS: ([f64; 6], [f64; 6]) = ([-TAU; 6], [TAU; 6]);

/// The small UR arms turn joint 6 without end.
const ENDLESS_6: ([f64; 6], [f64; 6]) =
    ([-TAU, -TAU, -TAU, -TAU, -TAU, f64::NEG_INFINITY], [TAU, TAU, TAU, TAU, TAU, f64::INFINITY]);

/// Universal Robots UR3 (series 3).
///
/// Source: Universal_Robots_ROS2_Description, `config/ur3` (default kinematics, joint limits). The user manual's Table
/// B.1 prints older, rounded lengths.
pub const UR3: ArmModel = ur(
    [151.9, 0.0, 0.0, 112.35, 85.35, 81.9],
    -243.65,
    -213.25,
    limits(ENDLESS_6.0, ENDLESS_6.1, [180.0, 180.0, 180.0, 360.0, 360.0, 360.0]),
);

/// Universal Robots UR3e.
///
/// Source: Universal Robots, support article "DH Parameters for calculations of kinematics and dynamics";
/// Universal_Robots_ROS2_Description, `config/ur3e`.
pub const UR3E: ArmModel = ur(
    [151.85, 0.0, 0.0, 131.05, 85.35, 92.1],
    -243.55,
    -213.2,
    limits(ENDLESS_6.0, ENDLESS_6.1, [180.0, 180.0, 180.0, 360.0, 360.0, 360.0]),
);

/// Universal Robots UR5 (series 3).
///
/// Source: CB3 user manual, Table B.4; Universal_Robots_ROS2_Description, `config/ur5`.
pub const UR5: ArmModel =
    ur([89.159, 0.0, 0.0, 109.15, 94.65, 82.3], -425.0, -392.25, limits(TWO_TURNS.0, TWO_TURNS.1, [180.0; 6]));

/// Universal Robots UR5e.
///
/// Source: as [`UR3E`], `config/ur5e`.
pub const UR5E: ArmModel =
    ur([162.5, 0.0, 0.0, 133.3, 99.7, 99.6], -425.0, -392.2, limits(TWO_TURNS.0, TWO_TURNS.1, [180.0; 6]));

/// Universal Robots UR10 (series 3).
///
/// Source: CB3 user manual, Table B.4; Universal_Robots_ROS2_Description, `config/ur10`.
pub const UR10: ArmModel = ur(
    [127.3, 0.0, 0.0, 163.941, 115.7, 92.2],
    -612.0,
    -572.3,
    limits(TWO_TURNS.0, TWO_TURNS.1, [120.0, 120.0, 180.0, 180.0, 180.0, 180.0]),
);

/// ABB IRB 120-3/0.6.
///
/// Source: ROS-Industrial `abb_irb120_support`, `irb120_3_58` (limits from ABB's data sheet ROB0149EN_D, 2012);
/// lengths agree with B. Brooks, ME thesis, Massey University 2016, Table 3-1.
pub const IRB120: ArmModel = abb(
    OrthoLengths { a1: 0.0, a2: -70.0, b: 0.0, c1: 290.0, c2: 270.0, c3: 302.0, c4: 72.0 },
    limits(
        radians([-165.0, -110.0, -110.0, -160.0, -120.0, -400.0]),
        radians([165.0, 110.0, 70.0, 160.0, 120.0, 400.0]),
        [250.0, 250.0, 250.0, 320.0, 320.0, 420.0],
    ),
);

/// ABB IRB 1200-7/0.7.
///
/// Source: ROS-Industrial `abb_irb1200_support`, `irb1200_7_70` (limits from ABB's data sheet ROB0275EN_A, 2016);
/// RobotStudio's modified-DH listing agrees.
pub const IRB1200: ArmModel = abb(
    OrthoLengths { a1: 0.0, a2: -42.0, b: 0.0, c1: 399.1, c2: 350.0, c3: 351.0, c4: 82.0 },
    limits(
        radians([-170.0, -100.0, -200.0, -270.0, -130.0, -360.0]),
        radians([170.0, 135.0, 70.0, 270.0, 130.0, 360.0]),
        [288.0, 240.0, 300.0, 400.0, 405.0, 600.0],
    ),
);

/// ABB IRBP A-250, a table that tilts about x and then turns about z.
///
/// Source: tesseract_ros_workcell, `irbpa250_d1000_macro`. Its limits and speeds are the cell builder's; they were not
/// checked against ABB's specification.
pub const IRBP_A250: PositionerModel = PositionerModel {
    tilt_origin: [733.0, 0.0, 1020.0],
    tilt_axis: [1.0, 0.0, 0.0],
    turn_origin: [0.0, 0.0, 1020.0],
    turn_axis: [0.0, 0.0, 1.0],
    table_origin: [0.0, 0.0, 1124.87],
    limits: limits([-TAU; 2], [TAU; 2], [85.0, 85.0]),
};

/// The arms by name, as files of workcells call them.
/// ```
/// use curvlay_kinematics::robots;
/// assert_eq!(robots::ARMS.iter().find(|(name, _)| *name == "UR3").map(|(_, arm)| **arm), Some(robots::UR3));
/// ```
pub const ARMS: [(&str, &ArmModel); 7] = [
    ("UR3", &UR3),
    ("UR3e", &UR3E),
    ("UR5", &UR5),
    ("UR5e", &UR5E),
    ("UR10", &UR10),
    ("IRB120", &IRB120),
    ("IRB1200", &IRB1200),
];

/// The positioners by name, as files of workcells call them.
pub const POSITIONERS: [(&str, &PositionerModel); 1] = [("IRBP_A250", &IRBP_A250)];
