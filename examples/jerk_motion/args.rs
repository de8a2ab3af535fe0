//! The arguments, each declared once.

use clap::{Parser, ValueEnum};
use curvlay_examples::args::{Common, above_zero, from_zero};
use curvlay_examples::mesh::Up;
use std::path::{Path, PathBuf};

/// Robot motion with little jerk along a curved layer, after Dai (2020), chapter 4.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "jerk_motion")]
pub struct Args {
    /// Waypoints instead of the built-in layer: lines of `px py pz nx ny nz`, place in mm and direction of growth
    #[arg(value_name = "WAYPOINTS", conflicts_with = "waypoints")]
    pub file: Option<PathBuf>,
    /// Waypoints (same as the positional file)
    #[arg(long, value_name = "FILE")]
    pub waypoints: Option<PathBuf>,
    /// Axis of the file that points up
    #[arg(long, default_value = "z", allow_hyphen_values = true)]
    pub up: Up,
    /// Feed in mm/s; without it, a waypoint every 0.1807 s
    #[arg(long = "feed", value_name = "MM/S", value_parser = above_zero, allow_negative_numbers = true)]
    pub feed_mm_s: Option<f64>,
    /// Waypoints of the spiral, 0.88 mm apart
    #[arg(long, value_name = "N", default_value_t = 2545, value_parser = clap::value_parser!(u32).range(5..=20_000))]
    pub count: u32,
    /// Rounding of the spiral's crest in millimetres
    #[arg(long = "crest", value_name = "MM", default_value_t = 9.0, value_parser = crest, allow_negative_numbers = true)]
    pub crest_mm: f64,
    /// Robots to plan for
    #[arg(long, value_enum, default_value_t = Cells::Both)]
    pub robots: Cells,
    /// Number of waypoints, from the first, in the study of noise; 0 omits the study
    #[arg(long = "noise", value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(0..=20_000))]
    pub noise_count: u32,
    /// Closed mesh of the part as built so far, in the frame of the waypoints; without it, a slab one layer below them
    #[arg(long, value_name = "FILE")]
    pub part: Option<PathBuf>,
    /// Diameter of a ball, the head of a post, that stands where wrist 2 passes in the middle of the path, as an obstacle; 0 for none
    /// [default: 50; 0 with waypoints from a file]
    #[arg(long = "post", value_name = "MM", value_parser = post, allow_negative_numbers = true)]
    pub post_mm: Option<f64>,
    /// Number of postures near the surface, and again on it, that measure the collision indicators; 0 omits them
    #[arg(long = "samples", value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    pub sample_count: u32,
    /// Number of postures from which collision indicators learn
    #[arg(long = "training", value_name = "N", default_value_t = 3020, value_parser = clap::value_parser!(u32).range(30..=20_000))]
    pub training_count: u32,
    /// Maximum share by which the global filter exceeds a limit of jerk; more sets exit status 3
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = from_zero, allow_negative_numbers = true)]
    pub allow_jerk: f64,
    #[command(flatten)]
    pub(super) common: Common,
}

/// Which robots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Cells {
    /// A UR3 with the part in its hand
    Ur3,
    /// An IRB 1200 over an A-250
    Cell8,
    /// One after the other
    Both,
}

pub fn post(text: &str) -> Result<f64, String> {
    from_zero(text).and_then(|mm| if mm <= 1000.0 { Ok(mm) } else { Err("must be at most 1000".to_owned()) })
}

pub fn crest(text: &str) -> Result<f64, String> {
    above_zero(text).and_then(|mm| if mm <= 1000.0 { Ok(mm) } else { Err("must be at most 1000".to_owned()) })
}

/// Diameter of the post beside the path that is made in code.
pub const POST_MM: f64 = 50.0;

impl Args {
    /// The diameter of the post, if there is one.
    pub fn post(&self) -> Option<f64> {
        let beside = if self.waypoints().is_some() { 0.0 } else { POST_MM };
        Some(self.post_mm.unwrap_or(beside)).filter(|&mm| mm > 0.0)
    }

    /// The waypoints of the user, however they were given.
    pub fn waypoints(&self) -> Option<&Path> {
        self.file.as_deref().or(self.waypoints.as_deref())
    }
}
