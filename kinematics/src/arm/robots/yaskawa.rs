//! Arms of Yaskawa Motoman.
//!
//! The robot frame has its origin on axis 1 at the height of axis 2. With all joints at 0 the upper arm stands and the forearm is level; U turns the forearm up. Joint 3 is
//! the angle between upper arm and forearm. The flange frame has z along axis 6, its x points up there.

use super::entry::{CatalogueArm, Maker};
use super::numbers::limits_deg;
use crate::arm::model::{ArmModel, Geometry};
use crate::arm::ortho::OrthoLengths;
use crate::limits::JointLimits;
use std::f64::consts::{FRAC_PI_2, PI};

const MAKER: Maker = Maker::Yaskawa;

const fn yaskawa(lengths: OrthoLengths, limits: JointLimits<6>) -> ArmModel {
    ArmModel {
        geometry: Geometry::Ortho(lengths),
        offsets: [0.0, 0.0, -FRAC_PI_2, 0.0, 0.0, PI],
        signs: [1.0, 1.0, -1.0, -1.0, -1.0, -1.0],
        j23_factor: 0.0,
        limits,
    }
}

/// The arms of this maker.
pub(super) const ARMS: [CatalogueArm; 4] = [
    CatalogueArm {
        name: "GP7",
        aliases: &[],
        maker: MAKER,
        title: "GP7",
        model: yaskawa(
            OrthoLengths { a1: 40.0, a2: -40.0, b: 0.0, c1: 0.0, c2: 445.0, c3: 440.0, c4: 80.0 },
            limits_deg(
                [-170.0, -65.0, -70.0, -190.0, -135.0, -360.0],
                [170.0, 145.0, 190.0, 190.0, 135.0, 360.0],
                [375.0, 315.0, 410.0, 550.0, 550.0, 1000.0],
            ),
        ),
        mount_below_base_mm: 330.0,
        source: "ros-industrial/motoman, motoman_gp7_support, gp7",
        note: None,
    },
    CatalogueArm {
        name: "GP8",
        aliases: &[],
        maker: MAKER,
        title: "GP8",
        model: yaskawa(
            OrthoLengths { a1: 40.0, a2: -40.0, b: 0.0, c1: 0.0, c2: 345.0, c3: 340.0, c4: 80.0 },
            limits_deg(
                [-170.0, -65.0, -70.0, -190.0, -135.0, -360.0],
                [170.0, 145.0, 190.0, 190.0, 135.0, 360.0],
                [455.0, 385.0, 520.0, 550.0, 550.0, 1000.0],
            ),
        ),
        mount_below_base_mm: 330.0,
        source: "ros-industrial/motoman, motoman_gp8_support, gp8",
        note: None,
    },
    CatalogueArm {
        name: "GP12",
        aliases: &[],
        maker: MAKER,
        title: "GP12",
        model: yaskawa(
            OrthoLengths { a1: 155.0, a2: -200.0, b: 0.0, c1: 0.0, c2: 614.0, c3: 640.0, c4: 100.0 },
            limits_deg(
                [-170.0, -90.0, -85.0, -200.0, -150.0, -455.0],
                [170.0, 155.0, 150.0, 200.0, 150.0, 455.0],
                [260.0, 230.0, 260.0, 470.0, 470.0, 700.0],
            ),
        ),
        mount_below_base_mm: 450.0,
        source: "ros-industrial/motoman, motoman_gp12_support, gp12",
        note: None,
    },
    CatalogueArm {
        name: "GP25",
        aliases: &[],
        maker: MAKER,
        title: "GP25",
        model: yaskawa(
            OrthoLengths { a1: 150.0, a2: -200.0, b: 0.0, c1: 0.0, c2: 760.0, c3: 795.0, c4: 100.0 },
            limits_deg(
                [-180.0, -105.0, -86.0, -200.0, -150.0, -455.0],
                [180.0, 155.0, 160.0, 200.0, 150.0, 455.0],
                [210.0, 210.0, 265.0, 420.0, 420.0, 885.0],
            ),
        ),
        mount_below_base_mm: 505.0,
        source: "ros-industrial/motoman, motoman_gp25_support, gp25",
        note: None,
    },
];
