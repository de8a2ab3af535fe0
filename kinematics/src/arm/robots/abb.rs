//! Arms of ABB.
//!
//! Base frame at the floor, and `tool0` with z along axis 6; its x points down where all joints are 0. Joint 3 is 0 where the forearm is
//! square to the upper arm. The IRB 2400 has a parallelogram: its joint 3 is counted from the horizontal.

use super::entry::{CatalogueArm, Maker};
use super::numbers::{limits, limits_deg, radians};
use crate::arm::model::{ArmModel, Geometry};
use crate::arm::ortho::OrthoLengths;
use crate::limits::JointLimits;
use std::f64::consts::FRAC_PI_2;

const fn abb(lengths: OrthoLengths, limits: JointLimits<6>) -> ArmModel {
    // ABB counts joint 3 from a level forearm.
    let offsets = [0.0, 0.0, -FRAC_PI_2, 0.0, 0.0, 0.0];
    ArmModel { geometry: Geometry::Ortho(lengths), offsets, signs: [1.0; 6], j23_factor: 0.0, limits }
}

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

const fn entry(
    name: &'static str,
    aliases: &'static [&'static str],
    title: &'static str,
    model: ArmModel,
    source: &'static str,
) -> CatalogueArm {
    CatalogueArm { name, aliases, maker: Maker::Abb, title, model, mount_below_base_mm: 0.0, source, note: None }
}

/// The arms of ABB.
pub(super) const ARMS: [CatalogueArm; 9] = [
    entry(
        "IRB120",
        &["IRB 120-3/0.6", "IRB120_3_58"],
        "IRB 120-3/0.6",
        IRB120,
        "ros-industrial/abb, abb_irb120_support, irb120_3_58 (limits from ABB's data sheet ROB0149EN_D)",
    ),
    entry(
        "IRB1200",
        &["IRB 1200-7/0.7", "IRB1200_7_70"],
        "IRB 1200-7/0.7",
        IRB1200,
        "ros-industrial/abb, abb_irb1200_support, irb1200_7_70 (limits from ABB's data sheet ROB0275EN_A)",
    ),
    entry(
        "IRB1200_5_90",
        &["IRB 1200-5/0.9"],
        "IRB 1200-5/0.9",
        abb(
            OrthoLengths { a1: 0.0, a2: -42.0, b: 0.0, c1: 399.1, c2: 448.0, c3: 451.0, c4: 82.0 },
            limits_deg(
                [-170.0, -100.0, -200.0, -270.0, -130.0, -360.0],
                [170.0, 130.0, 70.0, 270.0, 130.0, 360.0],
                [288.0, 240.0, 300.0, 400.0, 405.0, 600.0],
            ),
        ),
        "ros-industrial/abb, abb_irb1200_support, irb1200_5_90",
    ),
    entry(
        "IRB1600_10_145",
        &["IRB 1600-10/1.45"],
        "IRB 1600-10/1.45",
        abb(
            OrthoLengths { a1: 150.0, a2: 0.0, b: 0.0, c1: 486.5, c2: 700.0, c3: 600.0, c4: 65.0 },
            limits_deg(
                [-180.0, -90.0, -245.0, -200.0, -115.0, -400.0],
                [180.0, 120.0, 65.0, 200.0, 115.0, 400.0],
                [180.0, 180.0, 185.0, 385.0, 400.0, 460.0],
            ),
        ),
        "ros-industrial/abb, abb_irb1600_support, irb1600_10_145",
    ),
    CatalogueArm {
        note: Some("joint 3 is counted from the horizontal, as its parallelogram has it"),
        ..entry(
            "IRB2400",
            &["IRB 2400-12/1.55", "IRB 2400-10", "IRB2400_12_155"],
            "IRB 2400-12/1.55",
            ArmModel {
                j23_factor: -1.0,
                ..abb(
                    OrthoLengths { a1: 100.0, a2: -135.0, b: 0.0, c1: 615.0, c2: 705.0, c3: 755.0, c4: 85.0 },
                    limits_deg(
                        [-180.0, -100.0, -60.0, -200.0, -120.0, -400.0],
                        [180.0, 110.0, 65.0, 200.0, 120.0, 400.0],
                        [150.0, 150.0, 150.0, 360.0, 360.0, 450.0],
                    ),
                )
            },
            "ros-industrial/abb, abb_irb2400_support, irb2400_12_155; lengths also in Jmeyer1292/opw_kinematics",
        )
    },
    entry(
        "IRB2600_12_185",
        &["IRB 2600-12/1.85"],
        "IRB 2600-12/1.85",
        abb(
            OrthoLengths { a1: 150.0, a2: -115.0, b: 0.0, c1: 445.0, c2: 900.0, c3: 795.0, c4: 85.0 },
            limits_deg(
                [-180.0, -95.0, -180.0, -400.0, -120.0, -400.0],
                [180.0, 155.0, 75.0, 400.0, 120.0, 400.0],
                [175.0, 175.0, 175.0, 360.0, 360.0, 500.0],
            ),
        ),
        "ros-industrial/abb, abb_irb2600_support, irb2600_12_185",
    ),
    entry(
        "IRB4600_60_205",
        &["IRB 4600-60/2.05"],
        "IRB 4600-60/2.05",
        abb(
            OrthoLengths { a1: 175.0, a2: -175.0, b: 0.0, c1: 495.0, c2: 900.0, c3: 960.0, c4: 135.0 },
            limits_deg(
                [-180.0, -90.0, -180.0, -400.0, -125.0, -400.0],
                [180.0, 150.0, 75.0, 400.0, 120.0, 400.0],
                [175.0, 175.0, 175.0, 250.0, 250.0, 360.0],
            ),
        ),
        "ros-industrial/abb, abb_irb4600_support, irb4600_60_205",
    ),
    entry(
        "IRB6700_200_260",
        &["IRB 6700-200/2.60"],
        "IRB 6700-200/2.60",
        abb(
            OrthoLengths { a1: 320.0, a2: -200.0, b: 0.0, c1: 780.0, c2: 1125.0, c3: 1142.5, c4: 200.0 },
            limits_deg(
                [-170.0, -65.0, -180.0, -300.0, -130.0, -360.0],
                [170.0, 85.0, 70.0, 300.0, 130.0, 360.0],
                [110.0, 110.0, 110.0, 190.0, 150.0, 210.0],
            ),
        ),
        "ros-industrial/abb, abb_irb6700_support, irb6700_200_260",
    ),
    entry(
        "IRB6700_235_265",
        &["IRB 6700-235/2.65"],
        "IRB 6700-235/2.65",
        abb(
            OrthoLengths { a1: 320.0, a2: -200.0, b: 0.0, c1: 780.0, c2: 1135.0, c3: 1182.5, c4: 200.0 },
            limits_deg(
                [-170.0, -65.0, -180.0, -300.0, -130.0, -360.0],
                [170.0, 85.0, 70.0, 300.0, 130.0, 360.0],
                [100.0, 90.0, 90.0, 170.0, 120.0, 190.0],
            ),
        ),
        "ros-industrial/abb, abb_irb6700_support, irb6700_235_265",
    ),
];
