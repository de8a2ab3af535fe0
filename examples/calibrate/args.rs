//! The arguments, each declared once.

use clap::{Parser, ValueEnum};
use curvlay_examples::args::{Common, above_zero};
use std::path::PathBuf;

/// Finds the tip of a tool and the axes of an arm from measurements, and writes the calibrated workcell.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "calibrate")]
pub struct Args {
    /// Measurements: a CSV file (.csv) or a JSON file, with touches of one point, measured poses, or both [default: made in code]
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Workcell that is calibrated, a JSON file [default: a UR10 with the nozzle in its hand]
    #[arg(long, value_name = "FILE")]
    pub workcell: Option<PathBuf>,
    /// Which numbers of the arm are fitted
    #[arg(long, value_name = "WHAT", default_value = "all")]
    pub fit: Fit,
    /// Millimetres that a radian of a measured angle counts as: the error of positions divided by that of angles of the device
    #[arg(long = "radian", value_name = "MM", default_value_t = 200.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub radian_mm: f64,
    /// Amplification of errors above which a number counts as undetermined and keeps its value
    #[arg(long, value_name = "FACTOR", default_value_t = 100.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub open: f64,
    /// Maximum root mean square of the residuals of arm and tool, in millimetres; more sets exit status 3
    #[arg(long = "allow-residual", value_name = "MM", default_value_t = 0.5, value_parser = above_zero, allow_negative_numbers = true)]
    pub allow_residual_mm: f64,
    /// Without a file: number of simulated poses
    #[arg(long = "poses", value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(10..=10_000), conflicts_with = "file", allow_negative_numbers = true)]
    pub poses: u32,
    /// Without a file: noise of the measured positions in millimetres; that of angles follows by --radian
    #[arg(long = "noise", value_name = "MM", default_value_t = 0.02, value_parser = above_zero, conflicts_with = "file", allow_negative_numbers = true)]
    pub noise_mm: f64,
    /// Without a file: seed of the noise and of the errors of the arm
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "file")]
    pub seed: u64,
    #[command(flatten)]
    pub(super) common: Common,
}

/// Which numbers of the arm are fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Fit {
    /// The zeros of joints 2 to 5.
    Offsets,
    /// These, and the lengths: the inverse stays a closed form.
    Lengths,
    /// All that poses determine: tilted and shifted axes as well.
    All,
}
