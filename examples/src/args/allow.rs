//! What may be wrong before the exit status is 3.

use super::rules::{from_zero, share};
use clap::Args;
use serde::Serialize;

/// What may be wrong before the exit status is 3.
#[derive(Args, Clone, Copy, Debug, Serialize)]
#[command(next_help_heading = "What may be wrong")]
pub struct AllowArgs {
    /// Maximum share of the volume of the part in missed cells; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 1e-3, value_parser = share, allow_negative_numbers = true)]
    pub allow_missed: f64,
    /// Maximum deviation of the deposited volume from that of the part, with and without missed cells, as a share; more sets exit status
    /// 3
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, value_parser = share, allow_negative_numbers = true)]
    pub allow_volume: f64,
    /// Maximum share of waypoints at which the nozzle gouges; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 1e-3, value_parser = share, allow_negative_numbers = true)]
    pub allow_gouging: f64,
    /// Maximum share of the path length that is left out; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 1e-3, value_parser = share, allow_negative_numbers = true)]
    pub allow_left_out: f64,
    /// Maximum share of the bead length that is unsupported, without spans held at both ends; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 5e-3, value_parser = share, allow_negative_numbers = true)]
    pub allow_unsupported: f64,
    /// Maximum length of a single unsupported piece, in bead widths; more sets exit status 3
    #[arg(long, value_name = "BEADS", default_value_t = 40.0, value_parser = from_zero, allow_negative_numbers = true)]
    pub allow_unsupported_beads: f64,
    /// Maximum share of the path length that no robot program prints (unreachable, colliding, without a transfer, or withheld); more sets
    /// exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share, allow_negative_numbers = true)]
    pub allow_unprinted: f64,
}
