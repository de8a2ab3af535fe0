//! The arguments, each declared once.

use super::arms::ArmName;
use clap::Parser;
use curvlay_examples::args::{Common, above_zero};

/// What arms reach with a part in the hand, and where a nozzle should stand, after Dai (2020), section 2.3.1.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "reach")]
pub struct Args {
    /// Arm that the plain keys of the summary describe
    #[arg(long, value_name = "NAME", default_value = "ur3")]
    pub arm: ArmName,
    /// Number of sampled postures
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000), allow_negative_numbers = true)]
    pub samples: u32,
    /// Edge of the box around the nozzle in millimetres
    #[arg(long = "box", value_name = "MM", default_value_t = 200.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub box_mm: f64,
    /// Height of the platform, on which the part stands, over the flange in millimetres
    #[arg(long = "platform", value_name = "MM", default_value_t = 45.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub platform_mm: f64,
    /// For the box of the dissertation: minimum distance of frames in front of axis 1, in millimetres, since counting frames ignores
    /// collisions
    #[arg(long = "front", value_name = "MM", default_value_t = 150.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub front_mm: f64,
    /// Maximum distance between the places with which the search begins, in millimetres
    #[arg(long = "coarse", value_name = "MM", default_value_t = 100.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub coarse_mm: f64,
    /// Final step of the search, in millimetres
    #[arg(long = "fine", value_name = "MM", default_value_t = 12.5, value_parser = above_zero, allow_negative_numbers = true)]
    pub fine_mm: f64,
    #[command(flatten)]
    pub(super) common: Common,
}
