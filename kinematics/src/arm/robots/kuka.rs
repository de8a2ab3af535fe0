//! Arms of KUKA.
//!
//! Base is `$ROBROOT`, at the floor. Axes A1, A4 and A6 turn against the right hand about up and forward. With all at 0 the arm lies level along x; the
//! usual upright posture is A2 = -90, A3 = 90. The flange frame (`$FLANGE`) has z along axis 6, its x points down there.

use super::entry::{CatalogueArm, Maker};
use super::numbers::limits_deg;
use crate::arm::model::{ArmModel, Geometry};
use crate::arm::ortho::OrthoLengths;
use crate::limits::JointLimits;
use std::f64::consts::FRAC_PI_2;

const MAKER: Maker = Maker::Kuka;

const fn kuka(lengths: OrthoLengths, limits: JointLimits<6>) -> ArmModel {
    ArmModel {
        geometry: Geometry::Ortho(lengths),
        // A2 is counted from level.
        offsets: [0.0, -FRAC_PI_2, 0.0, 0.0, 0.0, 0.0],
        signs: [-1.0, 1.0, 1.0, -1.0, 1.0, -1.0],
        j23_factor: 0.0,
        limits,
    }
}

/// The arms of this maker.
pub(super) const ARMS: [CatalogueArm; 6] = [
    CatalogueArm {
        name: "KR6_R700",
        aliases: &["KR 6 R700-2"],
        maker: MAKER,
        title: "KR 6 R700-2",
        model: kuka(
            OrthoLengths { a1: 25.0, a2: -25.0, b: 0.0, c1: 400.0, c2: 335.0, c3: 365.0, c4: 90.0 },
            limits_deg(
                [-170.0, -190.0, -120.0, -185.0, -120.0, -350.0],
                [170.0, 45.0, 156.0, 185.0, 120.0, 350.0],
                [360.0, 300.0, 360.0, 450.0, 450.0, 540.0],
            ),
        ),
        mount_below_base_mm: 0.0,
        source: "ros-industrial/kuka_experimental, kuka_kr6_support, kr6r700_2",
        note: Some("the generation -2; the lengths of the older KR 6 R700 sixx differ"),
    },
    CatalogueArm {
        name: "KR6_R900",
        aliases: &["KR 6 R900-2"],
        maker: MAKER,
        title: "KR 6 R900-2",
        model: kuka(
            OrthoLengths { a1: 25.0, a2: -25.0, b: 0.0, c1: 400.0, c2: 455.0, c3: 420.0, c4: 90.0 },
            limits_deg(
                [-170.0, -190.0, -120.0, -185.0, -120.0, -350.0],
                [170.0, 45.0, 156.0, 185.0, 120.0, 350.0],
                [360.0, 300.0, 360.0, 450.0, 450.0, 540.0],
            ),
        ),
        mount_below_base_mm: 0.0,
        source: "ros-industrial/kuka_experimental, kuka_kr6_support, kr6r900_2",
        note: Some(
            "the generation -2; the older KR 6 R900 sixx is KR6_R900_sixx: its flange is 10 mm nearer to the wrist",
        ),
    },
    CatalogueArm {
        name: "KR6_R900_sixx",
        aliases: &[],
        maker: MAKER,
        title: "KR 6 R900 sixx",
        model: kuka(
            OrthoLengths { a1: 25.0, a2: -35.0, b: 0.0, c1: 400.0, c2: 455.0, c3: 420.0, c4: 80.0 },
            limits_deg(
                [-170.0, -190.0, -120.0, -185.0, -120.0, -350.0],
                [170.0, 45.0, 156.0, 185.0, 120.0, 350.0],
                [360.0, 300.0, 360.0, 381.0, 388.0, 615.0],
            ),
        ),
        mount_below_base_mm: 0.0,
        source: "ros-industrial/kuka_experimental, kuka_kr6_support, kr6r900sixx",
        note: None,
    },
    CatalogueArm {
        name: "KR10_R1100",
        aliases: &["KR 10 R1100-2"],
        maker: MAKER,
        title: "KR 10 R1100-2",
        model: kuka(
            OrthoLengths { a1: 25.0, a2: -25.0, b: 0.0, c1: 400.0, c2: 560.0, c3: 515.0, c4: 90.0 },
            limits_deg(
                [-170.0, -190.0, -120.0, -185.0, -120.0, -350.0],
                [170.0, 45.0, 156.0, 185.0, 120.0, 350.0],
                [300.0, 225.0, 330.0, 360.0, 360.0, 433.0],
            ),
        ),
        mount_below_base_mm: 0.0,
        source: "ros-industrial/kuka_experimental, kuka_kr10_support, kr10r1100_2",
        note: Some("the generation -2; the lengths of the older KR 10 R1100 sixx differ"),
    },
    CatalogueArm {
        name: "KR16_R2010",
        aliases: &["KR 16 R2010-2"],
        maker: MAKER,
        title: "KR 16 R2010-2",
        model: kuka(
            OrthoLengths { a1: 160.0, a2: -150.0, b: 0.0, c1: 520.0, c2: 980.0, c3: 860.0, c4: 153.0 },
            limits_deg(
                [-185.0, -185.0, -138.0, -350.0, -130.0, -350.0],
                [185.0, 65.0, 175.0, 350.0, 130.0, 350.0],
                [200.0, 175.0, 190.0, 430.0, 430.0, 630.0],
            ),
        ),
        mount_below_base_mm: 0.0,
        source: "ros-industrial/kuka_experimental, kuka_kr16_support, kr16_r2010_2",
        note: None,
    },
    CatalogueArm {
        name: "KR70_R2100",
        aliases: &[],
        maker: MAKER,
        title: "KR 70 R2100",
        model: kuka(
            OrthoLengths { a1: 175.0, a2: -50.0, b: 0.0, c1: 575.0, c2: 890.0, c3: 1035.0, c4: 185.0 },
            limits_deg(
                [-185.0, -175.0, -120.0, -180.0, -125.0, -350.0],
                [185.0, 60.0, 165.0, 180.0, 125.0, 350.0],
                [180.0, 158.0, 160.0, 230.0, 230.0, 320.0],
            ),
        ),
        mount_below_base_mm: 0.0,
        source: "ros-industrial/kuka_experimental, kuka_kr70_support, kr70_r2100",
        note: None,
    },
];
