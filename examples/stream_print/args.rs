//! The arguments.

use clap::Parser;
use curvlay_examples::args::{UrExtruderArgs, above_zero};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;

/// Streams a planned print to an arm of Universal Robots
///
/// The robot runs a program that connects to this computer; the print is sent tick by tick while the arm moves. Ctrl-C stops the robot on its path with the
/// extruder off.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "stream_print")]
pub struct Args {
    /// Folder of a print that was planned with `curved_layers --stage motion --program urscript`: print_001.script ..., programs.csv, trajectory.csv, workcell.json
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Address of this computer, as the robot sees it: the robot's program connects to it
    #[arg(long, value_name = "IP", default_value_t = Ipv4Addr::LOCALHOST)]
    pub host: Ipv4Addr,
    /// TCP port of this computer at which the robot connects
    #[arg(long, value_name = "PORT", default_value_t = 30050, value_parser = clap::value_parser!(u16).range(1..))]
    pub port: u16,
    /// Writes the robot's program to a file and ends: load it with a Script node and start it, then run this command again without the option
    #[arg(long, value_name = "FILE", conflicts_with_all = ["dry_run", "robot"])]
    pub write: Option<PathBuf>,
    /// Sends the robot's program to port 30002 of a robot, which must be in remote control
    #[arg(long, value_name = "IP:PORT|IP", value_parser = robot, conflicts_with = "dry_run")]
    pub robot: Option<SocketAddr>,
    /// Streams to a built-in model of a controller instead of a robot, and prints what it did
    #[arg(long)]
    pub dry_run: bool,
    /// Ticks that the robot holds: how long the network may be silent before it slows down [default: 0.6 s]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(12..=960))]
    pub ring: Option<u32>,
    /// How far a joint may be from where the robot goes on, in degrees
    #[arg(long = "max-gap", value_name = "DEG", default_value_t = 1.15, value_parser = gap)]
    pub max_gap_deg: f64,
    /// How far the arm may be from where the print begins, in degrees of any joint: it goes there by itself, without a check for collisions
    #[arg(long = "max-approach", value_name = "DEG", default_value_t = 20.0, value_parser = approach)]
    pub max_approach_deg: f64,
    /// Speed of that way, in degrees per second
    #[arg(long = "approach-speed", value_name = "DEG_S", default_value_t = 15.0, value_parser = speed)]
    pub approach_deg_s: f64,
    /// How long to wait for the robot to connect, in seconds
    #[arg(long = "wait", value_name = "S", default_value_t = 300.0, value_parser = above_zero)]
    pub wait_s: f64,
    /// Maximum number of connections in a row that make no progress
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub tries: u32,
    /// The extruder.
    #[command(flatten)]
    pub extruder: UrExtruderArgs,
    /// No progress on stderr
    #[arg(long)]
    pub quiet: bool,
}

/// A robot's address, and the port for programs if none is given: 30002, the secondary interface (*Script Manual*, connecting to URControl).
fn robot(text: &str) -> Result<SocketAddr, String> {
    let address = text.parse().ok().or_else(|| text.parse::<Ipv4Addr>().ok().map(|ip| SocketAddr::from((ip, 30002))));
    address.ok_or_else(|| "it must be an address such as 192.168.1.10, with :PORT if that is not 30002".to_owned())
}

fn within(text: &str, [min, max]: [f64; 2]) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("`{text}` is no number"))?;
    if (min..=max).contains(&value) { Ok(value) } else { Err(format!("it must be from {min} to {max}")) }
}

fn gap(text: &str) -> Result<f64, String> {
    within(text, [0.01, 5.0])
}

fn approach(text: &str) -> Result<f64, String> {
    within(text, [0.01, 360.0])
}

fn speed(text: &str) -> Result<f64, String> {
    within(text, [0.1, 180.0])
}
