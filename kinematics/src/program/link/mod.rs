//! A program streamed to a controller while it runs: messages, frames, replies, the sender, and the controller's side in RAPID.
//!
//! B. Brooks (2016), sections 3.2.1.3, 3.3.8.1 and 4.14: points are encoded as they are sent, each message is sent again until it is
//! acknowledged, and a queue on the controller holds a few. A whole design as one RAPID file could not be loaded.
//!
//! Departs from the thesis: messages have numbers, so that one that comes twice is done once; a queue of several may be under way,
//! not one message, so that corners are rounded; extruder commands go through the same queue as the moves, in their order, not over
//! a line of their own; pausing is a message.
//!
//! # Protocol
//!
//! The sender connects by TCP. It sends frames of exactly [`LinkFrame::BYTES`] bytes: a line of ASCII in fixed columns, which the
//! controller cuts without a parser (RAPID's strings hold 80 characters). Unused places are blanks.
//!
//! | columns, from 1 | content |
//! |---|---|
//! | 1 to 8 | number |
//! | 9 | kind |
//! | 13 to 156 | 12 fields of 12 characters |
//! | 160 | line feed |
//!
//! | kind | number | fields |
//! |---|---|---|
//! | `J`, first on each connection | 0 | number of the job; number of the connection |
//! | `H`, pause or go on | version of the state, from 1 | 1 pauses, 0 goes on |
//! | `V`, speed | of the message | mm/s, degrees/s |
//! | `L`, straight move; `W`, move by joints to a pose | of the message | x, y, z in mm; quaternion, scalar first; configuration data (4); zone |
//! | `A`, move to joints | of the message | six angles in degrees; zone |
//! | `E`, extruder | of the message | the line of [`ExtruderCommand`](super::ExtruderCommand), over two fields |
//!
//! Zones are radii in mm; -1 is a stop. A quaternion of zeros is the home position, as in the thesis. Messages are numbered from 1.
//!
//! The controller replies to each frame, and whenever it has done a message, with the line `R job connection taken done hold fault`:
//! all messages up to `taken` are in its queue, all up to `done` are done, `hold` is the version of the last `H` that it obeyed, `fault`
//! the message that it cannot do, or 0. It takes a message only if it is the next one and its queue has a free place, and drops it
//! otherwise. So it does every message once and in order, whatever is lost, late or sent again. Numbers of one job go on over
//! connections. A job with a new number begins at 0; it is refused, by a reply with the old number, while messages of the old one wait.
//!
//! [`LinkSender`] is the sender without sockets and without a clock. [`write_link_rapid`] writes the controller's side.

mod frame;
mod message;
mod rapid;
mod sender;

pub use frame::{LinkFrame, LinkReply};
pub use message::{LinkMessage, LinkTranslator};
pub use rapid::{LinkRapidOptions, write_link_rapid};
pub use sender::{LinkOptions, LinkProgress, LinkSender};

/// Greatest number of a job, a connection or a message: RAPID's `num` holds no larger whole numbers.
pub const MAX_NUMBER: u32 = 8_388_607;

/// Why a program could not be streamed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// An option that cannot be used.
    #[error("the option `{what}` is {value}; it must be from {least} to {most}")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least value.
        least: f64,
        /// Greatest value.
        most: f64,
    },
    /// A number that does not fit its field, or is not finite.
    #[error("`{what}` is {value}; it must be from {least} to {most}")]
    Number {
        /// What it is.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least value.
        least: f64,
        /// Greatest value.
        most: f64,
    },
    /// A step that no message says.
    #[error("step {step}: the link has no {what}")]
    Unsupported {
        /// The step, from 0.
        step: u64,
        /// What it cannot say.
        what: &'static str,
    },
    /// Bytes that are no frame.
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
    /// The controller works for another sender, or was at this job before.
    #[error("the controller is at message {taken} of job {job}; wait until it is done, and take a new number")]
    OtherJob {
        /// Its job.
        job: u32,
        /// Its last message.
        taken: u32,
    },
    /// The controller has lost what it had.
    #[error("the controller had taken {known} messages and now says {says}: it has been restarted")]
    Lost {
        /// What it had taken.
        known: u32,
        /// What it says.
        says: u32,
    },
    /// The controller cannot do a message.
    #[error("the controller cannot do message {number}")]
    Refused {
        /// The message.
        number: u32,
    },
    /// More messages than numbers.
    #[error("the program has more than {MAX_NUMBER} messages")]
    TooMany,
    /// No reply came.
    #[error("no reply after {tries} tries")]
    NoReply {
        /// How often it was tried.
        tries: u32,
    },
    /// The controller replies and breaks the connection, again and again.
    #[error("{connections} connections one after the other ended without a message taken or done")]
    NoProgress {
        /// How many there were.
        connections: u32,
    },
}

fn fits(what: &'static str, value: f64, [least, most]: [f64; 2]) -> Result<f64, LinkError> {
    if (least..=most).contains(&value) { Ok(value) } else { Err(LinkError::Number { what, value, least, most }) }
}
