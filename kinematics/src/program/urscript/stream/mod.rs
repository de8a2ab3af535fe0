//! A print streamed to a controller of Universal Robots while it runs: ticks, frames, replies, the sender, and the robot's side in URScript.
//!
//! Facts on the language: *Script Manual* (Universal Robots, e-Series SW 5.x). `socket_open` makes a connection from the controller to a server;
//! `socket_read_ascii_float(number, socket_name, timeout)` reads at most 30 numbers, in parentheses and separated by commas, and returns a list that begins with
//! how many it has read, 0 where it has failed; `socket_send_line` sends a line; `servoj` is blocking for its time `t`; `stopj` slows all joints down;
//! threads run side by side, and each of them has to wait at times (`sync`, `sleep`, or a motion).
//!
//! # Ticks
//!
//! A [`UrTick`] is a posture for `servoj`, one control cycle after that before it, or a move by joints (`movej`) that stops there, together with the speed of
//! the filament. Ticks are numbered from 1. [`UrTicks`] makes them of steps, [`UrStreamJob`] gives a print its number: the same ticks have the same one.
//!
//! # Protocol
//!
//! The robot connects by TCP to the sender, and again whenever the connection is lost. The sender writes frames: 30 numbers, `(..,..)`, and a line feed.
//!
//! | numbers, from 1 | content |
//! |---|---|
//! | 1 | ticks in the frame, 0 to 3; -1: stop |
//! | 2 | number of the job |
//! | 3 | ticks of the job |
//! | 4 | number of the first tick in the frame; the next one that would be sent if it has none |
//! | 5 | sum of the numbers 7 to 30, to 0.001 |
//! | 6 | [`VERSION`] |
//! | 7 to 30 | three ticks: six joints in radians; speed of the filament in mm/s, -1: extruder off; 0 for `servoj`, or the speed of `movej` in rad/s |
//!
//! The robot says every 0.04 s where it is: `R job taken run state fault`. All ticks up to `taken` are in its ring or run, all up to `run` are run. It takes a
//! tick only if it is the next one and its ring has a free place, and drops it otherwise: so each is run once and in order, whatever is lost or comes twice. It
//! keeps ring and counts when a connection is lost. The job is 0 until a frame has come.
//!
//! # States and faults
//!
//! | state | |
//! |---|---|
//! | 0 | the robot stands: its ring is not filled yet, or no sender is connected |
//! | 1 | it moves |
//! | 2 | all ticks are run; the program ends |
//! | 3 | it was stopped by the sender; the program ends |
//! | 4 | it has halted for a fault, at tick `run + 1`; the program ends |
//!
//! | fault | |
//! |---|---|
//! | 1 | a joint of the tick is farther from the tick before than [`max_step_rad`](UrStreamOptions::max_step_rad) |
//! | 2 | the arm is not where it should go on from: a joint is off by more than [`max_gap_rad`](UrStreamOptions::max_gap_rad) |
//! | 3 | a move by joints is longer than [`max_move_rad`](UrStreamOptions::max_move_rad) |
//! | 4 | the sender has another version, another job, or another number of ticks |
//!
//! # The robot never jumps
//!
//! Ticks are passed at a share of their speed that goes from 0 to 1 and back by even steps, so that a full stop takes [`stop_s`](UrStreamOptions::stop_s). While
//! the share is below 1 the robot runs on straight lines by joints between two ticks, and the filament has the share of its speed. When the ring holds less than a third the share falls
//! with the root of what is left, an even deceleration that ends at the last tick that is there. So a robot without sender comes to rest on its path, switches the
//! extruder off, and goes on from there. The same happens at a stop, and when nothing has come for [`silence_s`](UrStreamOptions::silence_s).
//! `stopj` follows when it is at rest. Before it moves off, it compares the joints that it measures with where it should be.
//!
//! [`UrStreamSender`] is the sender without sockets and without a clock. [`write_ur_stream`] writes the robot's side.

mod frame;
mod options;
mod script;
mod sender;
mod tick;

pub use frame::{UrFault, UrFrame, UrReply, UrState};
pub use options::{UrSenderOptions, UrStreamOptions};
pub use script::write_ur_stream;
pub use sender::{UrStreamProgress, UrStreamSender};
pub use tick::{UrStreamJob, UrTick, UrTicks};

/// Version of the protocol.
pub const VERSION: u32 = 1;

/// Greatest number of a tick or a job: below 2^24, so that it is exact also where numbers have single precision. At 125 Hz 35 hours, at 500 Hz nine.
pub const MAX_TICKS: u32 = 16_000_000;

/// Why a print could not be streamed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UrStreamError {
    /// An option that cannot be used.
    #[error("the option `{what}` is {value}; it must be from {min} to {max}")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// A step that no tick says.
    #[error("step {step}: a stream has no {what}")]
    Unsupported {
        /// The step, from 0.
        step: u64,
        /// What it cannot say.
        what: &'static str,
    },
    /// A number of a step that is out of range, or not finite.
    #[error("step {step}: {what} is {value}; it must be from {min} to {max}")]
    Number {
        /// The step, from 0.
        step: u64,
        /// What it is.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// Two postures are farther apart than the robot takes.
    #[error("tick {tick}: joint {} turns by {rad} rad from the tick before; the robot takes {max_rad} rad", joint + 1)]
    Jump {
        /// The second of both.
        tick: u32,
        /// The joint, from 0.
        joint: usize,
        /// By how much it turns.
        rad: f64,
        /// By how much it may.
        max_rad: f64,
    },
    /// No ticks, or more of them than numbers.
    #[error("the print has {ticks} ticks; a stream has from 1 to {MAX_TICKS}")]
    Count {
        /// How many it has; counting stops behind the greatest number.
        ticks: u64,
    },
    /// Text that is no frame.
    #[error("not a frame: {what}")]
    Frame {
        /// What is wrong with it.
        what: &'static str,
    },
    /// A line that is no reply, or one that cannot be.
    #[error("`{line}` is no reply that can be: {what}")]
    Reply {
        /// The line, or its first 60 characters.
        line: String,
        /// What is wrong with it.
        what: &'static str,
    },
    /// The robot works at another print.
    #[error("the robot is at tick {run} of job {job}; stop its program and start it again")]
    OtherJob {
        /// Its job.
        job: u32,
        /// The last tick that it has run.
        run: u32,
    },
    /// The robot has forgotten what it had.
    #[error(
        "the robot had run {known} ticks and now says {says}: its program was started again; the print cannot go on"
    )]
    Lost {
        /// What it had run.
        known: u32,
        /// What it says.
        says: u32,
    },
    /// The robot has halted.
    #[error("the robot has halted before tick {tick}: {fault}")]
    Halted {
        /// The tick that it did not run.
        tick: u32,
        /// Why.
        fault: UrFault,
    },
    /// The ticks ended before their number.
    #[error("the print has ended at tick {ticks} of {total}: it is not the one that was counted")]
    Short {
        /// How many there were.
        ticks: u32,
        /// How many were counted.
        total: u32,
    },
    /// No robot, or one that makes no progress.
    #[error("{connections} connections one after the other ended without a tick taken or run")]
    NoProgress {
        /// How many there were.
        connections: u32,
    },
}
