//! Arms of Universal Robots.
//!
//! Frame 0 is the controller's base and frame 6 its flange. ROS `base_link` is this base turned by pi about z.
//! Nobody publishes accelerations and jerks, so those are infinite.

use super::entry::{CatalogueArm, Maker};
use super::numbers::limits;
use crate::arm::dh::DhTable;
use crate::arm::model::{ArmModel, Geometry};
use crate::limits::JointLimits;
use std::f64::consts::TAU;

const fn ur(d: [f64; 6], upper_arm: f64, forearm: f64, limits: JointLimits<6>) -> ArmModel {
    ArmModel {
        geometry: Geometry::Ur(DhTable::ur(d, upper_arm, forearm)),
        offsets: [0.0; 6],
        signs: [1.0; 6],
        j23_factor: 0.0,
        limits,
    }
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

const fn entry(name: &'static str, model: ArmModel, source: &'static str) -> CatalogueArm {
    CatalogueArm {
        name,
        aliases: &[],
        maker: Maker::UniversalRobots,
        title: name,
        model,
        mount_below_base_mm: 0.0,
        source,
        note: None,
    }
}

const TABLE: &str = "Universal Robots, support article \"DH Parameters for calculations of kinematics and dynamics\"; limits and speeds: Universal_Robots_ROS2_Description, config, joint_limits.yaml (from the user manual)";

/// The arms of Universal Robots.
pub(super) const ARMS: [CatalogueArm; 9] = [
    entry("UR3", UR3, "Universal_Robots_ROS2_Description, config/ur3 (default kinematics, joint limits)"),
    entry("UR3e", UR3E, TABLE),
    entry("UR5", UR5, "CB3 user manual, Table B.4; Universal_Robots_ROS2_Description, config/ur5"),
    entry("UR5e", UR5E, TABLE),
    entry("UR10", UR10, "CB3 user manual, Table B.4; Universal_Robots_ROS2_Description, config/ur10"),
    entry(
        "UR10e",
        ur(
            [180.7, 0.0, 0.0, 174.15, 119.85, 116.55],
            -612.7,
            -571.55,
            limits(TWO_TURNS.0, TWO_TURNS.1, [120.0, 120.0, 180.0, 180.0, 180.0, 180.0]),
        ),
        TABLE,
    ),
    CatalogueArm {
        aliases: &["UR16"],
        ..entry(
            "UR16e",
            ur(
                [180.7, 0.0, 0.0, 174.15, 119.85, 116.55],
                -478.4,
                -360.0,
                limits(TWO_TURNS.0, TWO_TURNS.1, [120.0, 120.0, 180.0, 180.0, 180.0, 180.0]),
            ),
            TABLE,
        )
    },
    entry(
        "UR20",
        ur(
            [236.3, 0.0, 0.0, 201.0, 159.3, 154.3],
            -862.0,
            -728.7,
            limits(TWO_TURNS.0, TWO_TURNS.1, [120.0, 120.0, 150.0, 210.0, 210.0, 210.0]),
        ),
        TABLE,
    ),
    entry(
        "UR30",
        ur(
            [236.3, 0.0, 0.0, 201.0, 159.3, 154.3],
            -637.0,
            -503.7,
            limits(TWO_TURNS.0, TWO_TURNS.1, [120.0, 120.0, 150.0, 210.0, 210.0, 210.0]),
        ),
        "Universal_Robots_ROS2_Description, config/ur30 (default kinematics, joint limits)",
    ),
];
