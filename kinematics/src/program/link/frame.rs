//! Frames from the sender and replies from the controller, as bytes.

use super::{LinkError, LinkMessage, MAX_NUMBER, fits};
use crate::program::text::Text;
use crate::program::{ConfData, ExtruderCommand, Speed, Target, Zone};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use std::fmt;
use std::str::FromStr;

/// What the sender writes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinkFrame {
    /// The first on each connection.
    Job {
        /// Number of the job.
        job: u32,
        /// Number of the connection, which replies repeat: it marks a late reply to an earlier connection.
        connection: u32,
    },
    /// Pauses, or goes on. The state with the largest version counts.
    Hold {
        /// Version of the state.
        version: u32,
        /// Whether it pauses.
        hold: bool,
    },
    /// A message of the queue.
    Message {
        /// Its number, from 1.
        number: u32,
        /// The message.
        message: LinkMessage,
    },
}

/// Columns of a frame, from 0.
pub(super) const KIND_AT: usize = 8;
pub(super) const FIELDS_AT: usize = 12;
pub(super) const FIELD: usize = 12;
pub(super) const FIELDS: usize = 12;

/// Digits behind the point.
const MM: usize = 4;
const QUATERNION: usize = 8;
const DEGREES: usize = 5;

/// Greatest lengths and speeds, in mm and mm/s, and angles, in degrees, that leave a blank behind them in their field.
const MAX_MM: f64 = 99_999.0;
const MAX_DEGREES: f64 = 9_999.0;
const MAX_CONF: f64 = 999.0;
const MAX_ZONE_MM: f64 = 200.0;
/// The field of a zone that is a stop.
const STOP: f64 = -1.0;

impl LinkFrame {
    /// Length of each frame.
    pub const BYTES: usize = 160;

    /// The bytes of the frame.
    ///
    /// # Errors
    /// [`LinkError::Number`] for what does not fit.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::program::{ExtruderCommand, link::{LinkFrame, LinkMessage}};
    /// let frame = LinkFrame::Message { number: 7, message: LinkMessage::Extruder(ExtruderCommand::Rpm(4.5)) };
    /// let bytes = frame.encode()?;
    /// assert!(bytes.starts_with(b"7       E   RPM,4.5 ") && bytes.ends_with(b" \n"));
    /// assert_eq!(LinkFrame::decode(&bytes)?, frame);
    /// # Ok::<(), curvlay_kinematics::program::link::LinkError>(())
    /// ```
    pub fn encode(&self) -> Result<[u8; LinkFrame::BYTES], LinkError> {
        let mut out = Columns([b' '; LinkFrame::BYTES]);
        out.0[LinkFrame::BYTES - 1] = b'\n';
        match *self {
            LinkFrame::Job { job, connection } => {
                out.head(0, b'J')?;
                out.field(0, "job", f64::from(job), 0, [1.0, f64::from(MAX_NUMBER)])?;
                out.field(1, "connection", f64::from(connection), 0, [1.0, f64::from(MAX_NUMBER)])?;
            }
            LinkFrame::Hold { version, hold } => {
                out.head(version, b'H')?;
                out.field(0, "hold", f64::from(u8::from(hold)), 0, [0.0, 1.0])?;
            }
            LinkFrame::Message { number, message } => out.message(number, message)?,
        }
        Ok(out.0)
    }

    /// Reads a frame.
    ///
    /// # Errors
    /// [`LinkError::Frame`] for bytes that are no frame.
    pub fn decode(bytes: &[u8]) -> Result<Self, LinkError> {
        let wrong = |what| LinkError::Frame { what };
        if bytes.len() != LinkFrame::BYTES || bytes[LinkFrame::BYTES - 1] != b'\n' || !bytes.is_ascii() {
            return Err(wrong("it must be 160 bytes of ASCII, the last a line feed"));
        }
        let text =
            |from: usize, length: usize| std::str::from_utf8(&bytes[from..from + length]).unwrap_or("").trim_end();
        let field = |k: usize| {
            let value: f64 = text(FIELDS_AT + FIELD * k, FIELD).parse().map_err(|_| wrong("a field is no number"))?;
            if value.is_finite() { Ok(value) } else { Err(wrong("a field is no number")) }
        };
        let whole = |k: usize| {
            text(FIELDS_AT + FIELD * k, FIELD).parse::<i32>().map_err(|_| wrong("a field is no whole number"))
        };
        let count = |k: usize| whole(k).and_then(|n| u32::try_from(n).map_err(|_| wrong("a number is below 0")));
        let number: u32 = text(0, KIND_AT).parse().map_err(|_| wrong("it has no number"))?;
        if number > MAX_NUMBER {
            return Err(wrong("its number is too large"));
        }
        let zone = |k: usize| field(k).map(|mm| if mm < 0.0 { Zone::Stop } else { Zone::Blend(mm) });
        let target = || {
            let quaternion = Quaternion::new(field(3)?, field(4)?, field(5)?, field(6)?);
            let place = Translation3::new(field(0)?, field(1)?, field(2)?);
            let conf = ConfData { cf1: whole(7)?, cf4: whole(8)?, cf6: whole(9)?, cfx: whole(10)? };
            let rotation = UnitQuaternion::try_new(quaternion, 0.5);
            Ok(rotation.map(|rotation| Target { pose: Isometry3::from_parts(place, rotation), conf }))
        };
        let message = match bytes[KIND_AT] {
            b'J' => return Ok(LinkFrame::Job { job: count(0)?, connection: count(1)? }),
            b'H' => return Ok(LinkFrame::Hold { version: number, hold: count(0)? != 0 }),
            b'V' => {
                let speed = Speed { mm_s: field(0)?, rad_s: field(1)?.to_radians() };
                LinkMessage::Speed(speed)
            }
            b'L' => match target()? {
                Some(target) => LinkMessage::Line { target, zone: zone(11)? },
                None => LinkMessage::Home,
            },
            b'W' => match target()? {
                Some(target) => LinkMessage::JointMove { target, zone: zone(11)? },
                None => LinkMessage::Home,
            },
            b'A' => {
                let mut joints = [0.0; 6];
                for (k, joint) in joints.iter_mut().enumerate() {
                    *joint = field(k)?.to_radians();
                }
                LinkMessage::Joints { joints, zone: zone(6)? }
            }
            b'E' => {
                let command: Result<ExtruderCommand, _> = text(FIELDS_AT, 2 * FIELD).parse();
                LinkMessage::Extruder(command.map_err(|_| wrong("it has no command of the extruder"))?)
            }
            _ => return Err(wrong("its kind is unknown")),
        };
        Ok(LinkFrame::Message { number, message })
    }
}

/// A frame that is being written.
struct Columns([u8; LinkFrame::BYTES]);

impl Columns {
    fn head(&mut self, number: u32, kind: u8) -> Result<(), LinkError> {
        fits("number", f64::from(number), [0.0, f64::from(MAX_NUMBER)])?;
        let digits = number.to_string();
        self.0[..digits.len()].copy_from_slice(digits.as_bytes());
        self.0[KIND_AT] = kind;
        Ok(())
    }

    fn field(
        &mut self,
        k: usize,
        what: &'static str,
        value: f64,
        decimals: usize,
        range: [f64; 2],
    ) -> Result<(), LinkError> {
        let mut text = Text::default();
        text.fixed(fits(what, value, range)?, decimals);
        self.words(k, &text.0);
        Ok(())
    }

    fn words(&mut self, k: usize, text: &[u8]) {
        let at = FIELDS_AT + FIELD * k;
        self.0[at..at + text.len()].copy_from_slice(text);
    }

    fn zone(&mut self, k: usize, zone: Zone) -> Result<(), LinkError> {
        match zone {
            Zone::Stop => self.field(k, "zone", STOP, 0, [STOP, STOP]),
            Zone::Blend(mm) => self.field(k, "zone", mm, MM, [0.0, MAX_ZONE_MM]),
        }
    }

    fn pose(&mut self, at: &Point3<f64>, quaternion: [f64; 4], conf: ConfData, zone: Zone) -> Result<(), LinkError> {
        for k in 0..3 {
            self.field(k, "position", at[k], MM, [-MAX_MM, MAX_MM])?;
        }
        for (k, part) in quaternion.into_iter().enumerate() {
            self.field(3 + k, "quaternion", part, QUATERNION, [-1.0, 1.0])?;
        }
        for (k, part) in [conf.cf1, conf.cf4, conf.cf6, conf.cfx].into_iter().enumerate() {
            self.field(7 + k, "configuration", f64::from(part), 0, [-MAX_CONF, MAX_CONF])?;
        }
        self.zone(11, zone)
    }

    fn target(&mut self, target: &Target, zone: Zone) -> Result<(), LinkError> {
        let q = target.pose.rotation.quaternion();
        // Both signs are one rotation; the scalar is not below 0.
        let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
        // A unit quaternion may be longer than 1 by its rounding.
        let parts =
            [q.w, q.i, q.j, q.k].map(|part| if part.abs() < 1.0 + 1e-9 { sign * part.clamp(-1.0, 1.0) } else { part });
        self.pose(&Point3::from(target.pose.translation.vector), parts, target.conf, zone)
    }

    fn message(&mut self, number: u32, message: LinkMessage) -> Result<(), LinkError> {
        match message {
            LinkMessage::Speed(Speed { mm_s, rad_s }) => {
                self.head(number, b'V')?;
                self.field(0, "speed", mm_s, MM, [1e-3, MAX_MM])?;
                self.field(1, "speed of turning", rad_s.to_degrees(), MM, [1e-3, MAX_MM])
            }
            LinkMessage::Line { target, zone } => {
                self.head(number, b'L')?;
                self.target(&target, zone)
            }
            LinkMessage::JointMove { target, zone } => {
                self.head(number, b'W')?;
                self.target(&target, zone)
            }
            LinkMessage::Home => {
                self.head(number, b'L')?;
                self.pose(&Point3::origin(), [0.0; 4], ConfData::default(), Zone::Stop)
            }
            LinkMessage::Joints { joints, zone } => {
                self.head(number, b'A')?;
                for (k, joint) in joints.into_iter().enumerate() {
                    self.field(k, "joint", joint.to_degrees(), DEGREES, [-MAX_DEGREES, MAX_DEGREES])?;
                }
                self.zone(6, zone)
            }
            LinkMessage::Extruder(command) => {
                self.head(number, b'E')?;
                // At most `RPM,` and 20 characters, or `PULSEREV,` and 10.
                let mut text = command.to_string();
                text.truncate(2 * FIELD);
                self.words(0, text.as_bytes());
                Ok(())
            }
        }
    }
}

/// What the controller replies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkReply {
    /// The job it works at.
    pub job: u32,
    /// The connection of the last `J`.
    pub connection: u32,
    /// Messages in its queue or done.
    pub taken: u32,
    /// Messages done.
    pub done: u32,
    /// Version of the last `H` that it obeyed.
    pub hold: u32,
    /// The message that it cannot do; 0: none.
    pub fault: u32,
}

impl fmt::Display for LinkReply {
    /// The line without its end.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let LinkReply { job, connection, taken, done, hold, fault } = self;
        write!(f, "R {job} {connection} {taken} {done} {hold} {fault}")
    }
}

impl FromStr for LinkReply {
    type Err = LinkError;

    /// Reads a line; white space around it does not matter.
    /// ```
    /// use curvlay_kinematics::program::link::LinkReply;
    /// let reply: LinkReply = "R 17 1 120 115 0 0\n".parse()?;
    /// assert_eq!((reply.taken, reply.done), (120, 115));
    /// # Ok::<(), curvlay_kinematics::program::link::LinkError>(())
    /// ```
    fn from_str(line: &str) -> Result<Self, LinkError> {
        let wrong =
            || LinkError::Reply { line: line.trim().chars().take(60).collect(), what: "it must be R and six numbers" };
        let mut words = line.split_whitespace();
        if words.next() != Some("R") {
            return Err(wrong());
        }
        let numbers: Option<Vec<u32>> = words.map(|word| word.parse().ok().filter(|n| *n <= MAX_NUMBER)).collect();
        match numbers.as_deref() {
            Some(&[job, connection, taken, done, hold, fault]) => {
                Ok(LinkReply { job, connection, taken, done, hold, fault })
            }
            _ => Err(wrong()),
        }
    }
}
