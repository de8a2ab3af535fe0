//! Options of the robot's side and of the sender.

use crate::program::urscript::UrScriptOptions;
use crate::program::urscript::write::tighten;
use crate::program::{ProgramLimits, ServoRate};
use std::net::Ipv4Addr;
use std::time::Duration;

/// Fastest filament that a frame holds, in mm/s.
pub(super) const MAX_FILAMENT_MM_S: f64 = 1000.0;

/// How the robot's side of a stream is written.
///
/// # On the controller
/// The program is loaded and started like any other of ours; it ends with the print, with a stop, or with a fault, and has to be started again for the next print.
/// It drives nowhere by itself: the first tick of a print is a move by joints of at most [`max_move_rad`](Self::max_move_rad), so the arm has to be jogged near to
/// where the print begins.
#[derive(Clone, Debug, PartialEq)]
pub struct UrStreamOptions {
    /// Frames, payload, extruder, accelerations and `servoj`, as in a program without a stream.
    pub script: UrScriptOptions,
    /// Address of the sender, as the robot sees it.
    pub address: Ipv4Addr,
    /// TCP port at which the sender listens. Default 30050.
    pub port: u16,
    /// The controller's rate. Default 125 Hz.
    pub rate: ServoRate,
    /// Ticks that the robot holds, 12 to 960: how long the network may be silent before the robot slows down. Default 75, 0.6 s at 125 Hz.
    pub ring: u32,
    /// How far a joint may turn from tick to tick, in rad. Default 0.051, 1 % above 2 pi rad/s at 125 Hz: no joint of these arms turns faster.
    pub max_step_rad: f64,
    /// How far a joint may be from where the robot goes on, when it moves off, in rad. Default 0.02: more than the servos are off at rest, 10 mm at a reach of 0.5 m.
    pub max_gap_rad: f64,
    /// How far a joint may turn in a move by joints, in rad. Default 0.35, 20 degrees: the arm is near to where the print begins.
    pub max_move_rad: f64,
    /// How long a full stop takes, in seconds, along the path. Default 0.3.
    pub stop_s: f64,
    /// After so many seconds without a frame the robot stops and makes a new connection. Default 1.
    pub silence_s: f64,
}

impl Default for UrStreamOptions {
    fn default() -> Self {
        UrStreamOptions {
            script: UrScriptOptions::default(),
            address: Ipv4Addr::LOCALHOST,
            port: 30050,
            rate: ServoRate::Hz125,
            ring: 75,
            max_step_rad: 0.051,
            max_gap_rad: 0.02,
            max_move_rad: 0.35,
            stop_s: 0.3,
            silence_s: 1.0,
        }
    }
}

/// Fewest and most ticks in a ring.
pub(super) const MIN_RING: u32 = 12;
pub(super) const MAX_RING: u32 = 960;

impl UrStreamOptions {
    /// For a controller of this rate: the ring holds 0.6 s, and joints turn by at most 2 pi rad/s and 1 %.
    pub fn of_rate(rate: ServoRate, script: UrScriptOptions) -> Self {
        let (defaults, seconds) = (UrStreamOptions::default(), rate.seconds());
        let ring = (0.6 / seconds).round() as u32;
        UrStreamOptions { script, rate, ring, max_step_rad: 1.01 * std::f64::consts::TAU * seconds, ..defaults }
    }

    /// Options of a sender for this robot: its window is the ring, and it writes five times as often as the robot needs.
    pub fn sender(&self) -> UrSenderOptions {
        // What is no number counts as the least, which is the safe side.
        let silence_s = if self.silence_s >= 0.05 { self.silence_s.min(60.0) } else { 0.05 };
        let heartbeat = Duration::from_secs_f64(0.2 * silence_s);
        UrSenderOptions { window: self.ring, heartbeat, ..UrSenderOptions::default() }
    }

    /// The fastest filament that the extruder's signal holds, in mm/s.
    pub fn max_filament_mm_s(&self) -> f64 {
        let script = &self.script;
        script.extruder.max_mm_s(script).min(script.limits.filament_mm_s).min(MAX_FILAMENT_MM_S)
    }

    /// The limits of the program and those of its arm.
    pub(super) fn limits(&self) -> ProgramLimits {
        let mut limits = self.script.limits;
        if let Some(arm) = &self.script.arm {
            tighten(&mut limits, &ProgramLimits::of_arm(arm));
        }
        limits
    }
}

/// How a print is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UrSenderOptions {
    /// Ticks that are sent and not yet run, at most: places of the robot's ring ([`UrStreamOptions::ring`](super::UrStreamOptions::ring)). Default 75.
    pub window: u32,
    /// A frame is written at least this often, if only to say that the sender is there: well below
    /// [`UrStreamOptions::silence_s`](super::UrStreamOptions::silence_s). Default 0.2 s.
    pub heartbeat: Duration,
    /// When ticks that were sent are not taken for so long, they are sent again. Default 0.5 s.
    pub retry: Duration,
    /// A connection on which nothing comes for so long is dead. Default 2 s.
    pub silence: Duration,
    /// So many connections one after the other without progress are an error. Default 10.
    pub max_tries: u32,
}

impl Default for UrSenderOptions {
    fn default() -> Self {
        UrSenderOptions {
            window: 75,
            heartbeat: Duration::from_millis(200),
            retry: Duration::from_millis(500),
            silence: Duration::from_secs(2),
            max_tries: 10,
        }
    }
}
