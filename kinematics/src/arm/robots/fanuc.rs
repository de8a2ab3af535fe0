//! Arms of Fanuc.
//!
//! The world frame of the controller has its origin on axis 1 at the height of axis 2. Joint 3 is counted from the horizontal, up, whatever joint 2 is; joints
//! 4 and 6 turn against the right hand about the forearm and the flange. The flange frame has z along axis 6, its x points up where all joints are 0.

use super::entry::{CatalogueArm, Maker};
use super::numbers::limits_deg;
use crate::arm::model::{ArmModel, Geometry};
use crate::arm::ortho::OrthoLengths;
use crate::limits::JointLimits;
use std::f64::consts::{FRAC_PI_2, PI};

const MAKER: Maker = Maker::Fanuc;

const fn fanuc(lengths: OrthoLengths, limits: JointLimits<6>) -> ArmModel {
    ArmModel {
        geometry: Geometry::Ortho(lengths),
        offsets: [0.0, 0.0, -FRAC_PI_2, 0.0, 0.0, PI],
        signs: [1.0, 1.0, -1.0, -1.0, -1.0, -1.0],
        j23_factor: 1.0,
        limits,
    }
}

/// The arms of this maker.
pub(super) const ARMS: [CatalogueArm; 4] = [
    CatalogueArm {
        name: "LRMate200iD",
        aliases: &["LR Mate 200iD", "LR Mate 200iD/7"],
        maker: MAKER,
        title: "LR Mate 200iD",
        model: fanuc(
            OrthoLengths { a1: 50.0, a2: -35.0, b: 0.0, c1: 0.0, c2: 330.0, c3: 335.0, c4: 80.0 },
            limits_deg(
                [-170.0, -100.0, -140.0, -190.0, -125.0, -360.0],
                [170.0, 145.0, 280.0, 190.0, 125.0, 360.0],
                [450.0, 380.0, 520.0, 550.0, 545.0, 1000.0],
            ),
        ),
        mount_below_base_mm: 330.0,
        source: "ros-industrial/fanuc, fanuc_lrmate200id_support, lrmate200id",
        note: Some(
            "joint 3 is counted from the horizontal (J3 = 0 is a level forearm at any J2); the limits of J3 are the data sheet's, and the controller's limit of J2 with J3 is not known here",
        ),
    },
    CatalogueArm {
        name: "M20iA",
        aliases: &["M-20iA"],
        maker: MAKER,
        title: "M-20iA",
        model: fanuc(
            OrthoLengths { a1: 150.0, a2: -250.0, b: 0.0, c1: 0.0, c2: 790.0, c3: 835.0, c4: 100.0 },
            limits_deg(
                [-170.0, -100.0, -185.0, -200.0, -140.0, -270.0],
                [170.0, 160.0, 273.0, 200.0, 140.0, 270.0],
                [195.0, 175.0, 180.0, 360.0, 360.0, 550.0],
            ),
        ),
        mount_below_base_mm: 525.0,
        source: "ros-industrial/fanuc, fanuc_m20ia_support, m20ia",
        note: Some(
            "joint 3 is counted from the horizontal (J3 = 0 is a level forearm at any J2); the limits of J3 are the data sheet's, and the controller's limit of J2 with J3 is not known here",
        ),
    },
    CatalogueArm {
        name: "M710iC_50",
        aliases: &["M-710iC/50"],
        maker: MAKER,
        title: "M-710iC/50",
        model: fanuc(
            OrthoLengths { a1: 150.0, a2: -170.0, b: 0.0, c1: 0.0, c2: 870.0, c3: 1016.0, c4: 175.0 },
            limits_deg(
                [-180.0, -90.0, -160.0, -360.0, -125.0, -360.0],
                [180.0, 135.0, 280.0, 360.0, 125.0, 360.0],
                [175.0, 175.0, 175.0, 250.0, 250.0, 355.0],
            ),
        ),
        mount_below_base_mm: 565.0,
        source: "ros-industrial/fanuc, fanuc_m710ic_support, m710ic50",
        note: Some(
            "joint 3 is counted from the horizontal (J3 = 0 is a level forearm at any J2); the limits of J3 are the data sheet's, and the controller's limit of J2 with J3 is not known here",
        ),
    },
    CatalogueArm {
        name: "R2000iC_165F",
        aliases: &["R-2000iC/165F"],
        maker: MAKER,
        title: "R-2000iC/165F",
        model: fanuc(
            OrthoLengths { a1: 312.0, a2: -225.0, b: 0.0, c1: 0.0, c2: 1075.0, c3: 1280.0, c4: 215.0 },
            limits_deg(
                [-185.0, -60.0, -132.0, -360.0, -125.0, -360.0],
                [185.0, 76.0, 180.0, 360.0, 125.0, 360.0],
                [130.0, 115.0, 125.0, 180.0, 180.0, 260.0],
            ),
        ),
        mount_below_base_mm: 670.0,
        source: "ros-industrial/fanuc, fanuc_r2000ic_support, r2000ic165f",
        note: Some(
            "joint 3 is counted from the horizontal (J3 = 0 is a level forearm at any J2); the limits of J3 are the data sheet's, and the controller's limit of J2 with J3 is not known here",
        ),
    },
];
