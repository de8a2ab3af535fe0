//! Arms by name.

use clap::ValueEnum;
use curvlay_kinematics::{ArmModel, robots};

/// An arm as it is typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ArmName {
    Ur3,
    Ur3e,
    Ur5,
    Ur5e,
    Irb120,
    Irb1200,
}

impl ArmName {
    pub fn model(self) -> &'static ArmModel {
        match self {
            ArmName::Ur3 => &robots::UR3,
            ArmName::Ur3e => &robots::UR3E,
            ArmName::Ur5 => &robots::UR5,
            ArmName::Ur5e => &robots::UR5E,
            ArmName::Irb120 => &robots::IRB120,
            ArmName::Irb1200 => &robots::IRB1200,
        }
    }

    /// As workcells call it.
    pub fn in_files(self) -> &'static str {
        match self {
            ArmName::Ur3 => "UR3",
            ArmName::Ur3e => "UR3e",
            ArmName::Ur5 => "UR5",
            ArmName::Ur5e => "UR5e",
            ArmName::Irb120 => "IRB120",
            ArmName::Irb1200 => "IRB1200",
        }
    }

    /// As its maker writes it.
    pub fn title(self) -> &'static str {
        match self {
            ArmName::Ur3 => "UR3",
            ArmName::Ur3e => "UR3e",
            ArmName::Ur5 => "UR5",
            ArmName::Ur5e => "UR5e",
            ArmName::Irb120 => "IRB 120-3/0.6",
            ArmName::Irb1200 => "IRB 1200-7/0.7",
        }
    }
}
