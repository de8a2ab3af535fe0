//! What the user asks for.

use clap::Parser;
use curvlay_examples::args::{Common, above_zero};
use std::path::{Path, PathBuf};

/// A curved layer printed on a Stewart platform under a fixed nozzle, after Dai (2020), section 2.2.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "stewart_table")]
pub struct Args {
    /// Waypoints instead of the built-in layer: lines of `px py pz nx ny nz`, place in mm and direction of growth
    #[arg(value_name = "WAYPOINTS", conflicts_with = "waypoints")]
    pub file: Option<PathBuf>,
    /// Waypoints (same as the positional file)
    #[arg(long, value_name = "FILE")]
    pub waypoints: Option<PathBuf>,
    /// Radius of the dome in millimetres
    #[arg(long = "radius", value_name = "MM", default_value_t = 40.0, value_parser = millimetres, allow_negative_numbers = true)]
    pub radius_mm: f64,
    /// Height of the middle of the dome over its rim, in millimetres
    #[arg(long = "rise", value_name = "MM", default_value_t = 10.0, value_parser = millimetres, allow_negative_numbers = true)]
    pub rise_mm: f64,
    /// Distance between turns of the spiral, and between waypoints along it, in millimetres
    #[arg(long = "spacing", value_name = "MM", default_value_t = 1.0, value_parser = spacing, allow_negative_numbers = true)]
    pub spacing_mm: f64,
    /// Height of the nozzle over the base in millimetres
    #[arg(long = "nozzle", value_name = "MM", default_value_t = 400.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub nozzle_mm: f64,
    #[command(flatten)]
    pub common: Common,
}

/// The spiral has about pi (radius / spacing)^2 waypoints.
fn millimetres(text: &str) -> Result<f64, String> {
    above_zero(text).and_then(|mm| if mm <= 300.0 { Ok(mm) } else { Err("must be at most 300".to_owned()) })
}

fn spacing(text: &str) -> Result<f64, String> {
    above_zero(text).and_then(|mm| if mm >= 0.2 { Ok(mm) } else { Err("must be at least 0.2".to_owned()) })
}

impl Args {
    /// The waypoints of the user, however they were given.
    pub fn waypoints(&self) -> Option<&Path> {
        self.file.as_deref().or(self.waypoints.as_deref())
    }
}
