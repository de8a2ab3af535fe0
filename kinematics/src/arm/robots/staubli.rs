//! Arms of Staubli.
//!
//! The world frame of the controller has its origin on axis 1 at the height of axis 2. With all joints at 0 the arm stands upright; all joints turn by the right hand about
//! up and left. The forearm is beside axis 1.

use super::entry::{CatalogueArm, Maker};
use super::numbers::limits_deg;
use crate::arm::model::{ArmModel, Geometry};
use crate::arm::ortho::OrthoLengths;
use crate::limits::JointLimits;

const MAKER: Maker = Maker::Staubli;

const fn staubli(lengths: OrthoLengths, limits: JointLimits<6>) -> ArmModel {
    ArmModel { geometry: Geometry::Ortho(lengths), offsets: [0.0; 6], signs: [1.0; 6], j23_factor: 0.0, limits }
}

/// The arms of this maker.
pub(super) const ARMS: [CatalogueArm; 2] = [
    CatalogueArm {
        name: "TX2_60",
        aliases: &["TX2-60"],
        maker: MAKER,
        title: "TX2-60",
        model: staubli(
            OrthoLengths { a1: 0.0, a2: 0.0, b: 20.0, c1: 0.0, c2: 290.0, c3: 310.0, c4: 70.0 },
            limits_deg(
                [-180.0, -127.5, -152.5, -270.0, -121.0, -270.0],
                [180.0, 127.5, 152.5, 270.0, 132.5, 270.0],
                [435.0, 385.0, 500.0, 995.0, 1065.0, 1445.0],
            ),
        ),
        mount_below_base_mm: 375.0,
        source: "ros-industrial/staubli_experimental, staubli_tx2_60_support, tx2_60 (nominal speeds)",
        note: None,
    },
    CatalogueArm {
        name: "TX2_90",
        aliases: &["TX2-90"],
        maker: MAKER,
        title: "TX2-90",
        model: staubli(
            OrthoLengths { a1: 50.0, a2: 0.0, b: 50.0, c1: 0.0, c2: 425.0, c3: 425.0, c4: 100.0 },
            limits_deg(
                [-180.0, -130.0, -145.0, -270.0, -115.0, -270.0],
                [180.0, 147.5, 145.0, 270.0, 140.0, 270.0],
                [400.0, 400.0, 430.0, 540.0, 475.0, 760.0],
            ),
        ),
        mount_below_base_mm: 478.0,
        source: "ros-industrial/staubli_experimental, staubli_tx2_90_support, tx2_90",
        note: None,
    },
];
