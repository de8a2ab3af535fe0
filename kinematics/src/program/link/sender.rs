//! The sender as a state machine: what to write next, given what came and what time it is. No sockets, no clock.
//!
//! Go-back-N: frames that the controller has not taken are sent again, in their order, when no reply comes in time, and after each
//! new connection. At most a queue of messages is under way, so the sender holds no more than that of the program.

use super::{LinkError, LinkFrame, LinkMessage, LinkReply, MAX_NUMBER};
use std::collections::VecDeque;
use std::time::Duration;

/// How a program is streamed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinkOptions {
    /// Number of the job, from 1 to [`MAX_NUMBER`]: another than that of the last one. Default 1.
    pub job: u32,
    /// Messages that are not yet done, at most: places of the controller's queue. More let it look farther ahead along rounded corners, and
    /// delay changes of the height. Default 5, as in the thesis.
    pub queue: u32,
    /// After this time without a reply frames are sent again. Default 1 s.
    pub retry: Duration,
    /// So many tries without any reply, or connections without progress, are an error. Default 10.
    pub max_tries: u32,
    /// Longest pause before a new connection; at least [`retry`](Self::retry). Default 30 s.
    pub max_pause: Duration,
}

impl Default for LinkOptions {
    fn default() -> Self {
        LinkOptions {
            job: 1,
            queue: 5,
            retry: Duration::from_secs(1),
            max_tries: 10,
            max_pause: Duration::from_secs(30),
        }
    }
}

impl LinkOptions {
    /// How long to wait before a new connection, after so many that failed or brought no progress: `retry`, and twice as long for each of
    /// them, up to `max_pause`.
    /// ```
    /// use curvlay_kinematics::program::link::LinkOptions;
    /// let pauses = [0, 1, 2, 5, 1000].map(|failed| LinkOptions::default().pause(failed).as_secs());
    /// assert_eq!(pauses, [1, 2, 4, 30, 30]);
    /// ```
    pub fn pause(&self, failed: u32) -> Duration {
        let factor = 1u32.checked_shl(failed).filter(|factor| *factor > 0);
        factor
            .and_then(|factor| self.retry.checked_mul(factor))
            .map_or(self.max_pause, |pause| pause.min(self.max_pause))
    }
}

/// How far a sender is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkProgress {
    /// Messages that have a number: the controller may know them.
    pub numbered: u32,
    /// Messages in the controller's queue, or done.
    pub taken: u32,
    /// Messages done.
    pub done: u32,
    /// Frames of messages sent more than once.
    pub resent: u64,
    /// Whether the robot is to pause.
    pub hold: bool,
    /// Whether the controller has obeyed the last pause or go-on.
    pub hold_obeyed: bool,
    /// Whether all is done.
    pub over: bool,
}

/// Streams messages. Times are those of any clock that does not go back, for example since the begin.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::{ExtruderCommand, link::*};
/// use std::time::Duration;
/// let now = Duration::ZERO;
/// let messages = [ExtruderCommand::Start, ExtruderCommand::Stop].map(|command| Ok(LinkMessage::Extruder(command)));
/// let mut sender = LinkSender::new(messages.into_iter(), LinkOptions::default())?;
/// sender.connected()?;
/// let greeting = LinkFrame::decode(&sender.next_frame(now)?.unwrap())?;
/// assert_eq!(greeting, LinkFrame::Job { job: 1, connection: 1 });
/// // Nothing more until the controller has said where it is.
/// assert!(sender.next_frame(now)?.is_none());
/// sender.receive("R 1 1 0 0 0 0", now)?;
/// assert!(sender.next_frame(now)?.is_some() && sender.next_frame(now)?.is_some() && sender.next_frame(now)?.is_none());
/// sender.receive("R 1 1 2 2 0 0", now)?;
/// assert!(sender.progress().over);
/// # Ok::<(), LinkError>(())
/// ```
#[derive(Clone, Debug)]
pub struct LinkSender<I> {
    messages: I,
    options: LinkOptions,
    /// The messages have ended.
    ended: bool,
    /// Frames of the messages `done + 1` and on.
    queue: VecDeque<[u8; LinkFrame::BYTES]>,
    taken: u32,
    done: u32,
    /// The message to send next on this connection, and the first that was never sent.
    next: u32,
    fresh: u32,
    resent: u64,
    connection: u32,
    up: bool,
    /// The controller has replied on this connection.
    greeted: bool,
    say_job: bool,
    say_hold: bool,
    hold: bool,
    version: u32,
    obeyed: u32,
    height_mm: f64,
    deadline: Option<Duration>,
    tries: u32,
    /// Connections with a reply since a message was taken or done.
    idle: u32,
    fault: Option<LinkError>,
}

impl<I: Iterator<Item = Result<LinkMessage, LinkError>>> LinkSender<I> {
    /// A sender that is not connected.
    ///
    /// # Errors
    /// [`LinkError::Option`].
    pub fn new(messages: I, options: LinkOptions) -> Result<Self, LinkError> {
        for (what, value, most) in [
            ("job", options.job, MAX_NUMBER),
            ("queue", options.queue, 100),
            ("max_tries", options.max_tries, 1_000_000),
        ] {
            if !(1..=most).contains(&value) {
                return Err(LinkError::Option { what, value: f64::from(value), least: 1.0, most: f64::from(most) });
            }
        }
        if options.retry < MIN_RETRY {
            let (value, least) = (options.retry.as_secs_f64(), MIN_RETRY.as_secs_f64());
            return Err(LinkError::Option { what: "retry", value, least, most: Duration::MAX.as_secs_f64() });
        }
        if options.max_pause < options.retry {
            let (value, least) = (options.max_pause.as_secs_f64(), options.retry.as_secs_f64());
            return Err(LinkError::Option { what: "max_pause", value, least, most: Duration::MAX.as_secs_f64() });
        }
        Ok(LinkSender {
            messages,
            options,
            ended: false,
            queue: VecDeque::new(),
            taken: 0,
            done: 0,
            next: 1,
            fresh: 1,
            resent: 0,
            connection: 0,
            up: false,
            greeted: false,
            say_job: false,
            say_hold: false,
            hold: false,
            version: 0,
            obeyed: 0,
            height_mm: 0.0,
            deadline: None,
            tries: 0,
            idle: 0,
            fault: None,
        })
    }

    /// A connection is there: what was under way on the last one is lost, or not.
    ///
    /// # Errors
    /// [`LinkError::NoReply`] if too many connections brought no reply, [`LinkError::NoProgress`] if too many brought nothing else.
    pub fn connected(&mut self) -> Result<(), LinkError> {
        self.connection = self.connection % MAX_NUMBER + 1;
        (self.up, self.greeted, self.say_job, self.say_hold) = (true, false, true, false);
        self.deadline = None;
        self.count_try()?;
        let connections = self.idle;
        self.kept(if connections >= self.options.max_tries {
            Err(LinkError::NoProgress { connections })
        } else {
            Ok(())
        })
    }

    /// How long to wait before the next connection: nothing before the first, then as [`LinkOptions::pause`] says.
    pub fn pause(&self) -> Duration {
        if self.connection == 0 { Duration::ZERO } else { self.options.pause(self.idle.max(self.tries)) }
    }

    /// The connection is gone.
    pub fn disconnected(&mut self) {
        (self.up, self.greeted, self.deadline) = (false, false, None);
    }

    /// Pauses the robot, or lets it go on.
    pub fn set_hold(&mut self, hold: bool) {
        if hold != self.hold {
            self.hold = hold;
            self.version += 1;
            self.say_hold = true;
        }
    }

    /// The height of the nozzle over the surface, in addition to that of the targets, for messages that have no number yet. Messages
    /// in the queue keep theirs. A height that is not finite makes the next target an error.
    pub fn set_height_mm(&mut self, height_mm: f64) {
        self.height_mm = height_mm;
    }

    /// The next frame to write; `None`: nothing for now.
    ///
    /// # Errors
    /// [`LinkError`]: it cannot go on, and says so from now on.
    pub fn next_frame(&mut self, now: Duration) -> Result<Option<[u8; LinkFrame::BYTES]>, LinkError> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        if !self.up {
            return Ok(None);
        }
        if self.deadline.is_some_and(|deadline| now >= deadline) {
            self.count_try()?;
            self.deadline = None;
            // Also a question where it is: the reply to the last message may be lost.
            (self.say_job, self.say_hold) = (!self.greeted, self.greeted);
            self.next = self.taken + 1;
        }
        let frame = if std::mem::take(&mut self.say_job) {
            LinkFrame::Job { job: self.options.job, connection: self.connection }.encode()
        } else if !self.greeted {
            return Ok(None);
        } else if std::mem::take(&mut self.say_hold) {
            LinkFrame::Hold { version: self.version, hold: self.hold }.encode()
        } else if self.hold {
            return Ok(None);
        } else {
            let refilled = self.refill();
            self.kept(refilled)?;
            let Some(frame) = self.queue.get((self.next - self.done - 1) as usize) else { return Ok(None) };
            self.resent += u64::from(self.next < self.fresh);
            self.next += 1;
            self.fresh = self.fresh.max(self.next);
            Ok(*frame)
        };
        let frame = self.kept(frame)?;
        self.deadline = self.deadline.or(Some(now.saturating_add(self.options.retry)));
        Ok(Some(frame))
    }

    /// Takes a line from the controller.
    ///
    /// # Errors
    /// [`LinkError`]: it cannot go on.
    pub fn receive(&mut self, line: &str, now: Duration) -> Result<(), LinkError> {
        let taken = line.parse().and_then(|reply| self.take(&reply, line, now));
        self.kept(taken)
    }

    fn take(&mut self, reply: &LinkReply, line: &str, now: Duration) -> Result<(), LinkError> {
        if !self.up || reply.connection != self.connection {
            return Ok(());
        }
        let (job, numbered) = (reply.job, self.done + self.queue.len() as u32);
        if job != self.options.job || (!self.greeted && reply.taken > numbered) {
            return Err(LinkError::OtherJob { job, taken: reply.taken });
        }
        if reply.taken > numbered || reply.done > reply.taken {
            let line = line.trim().chars().take(60).collect();
            return Err(LinkError::Reply { line, what: "it has messages that were not sent" });
        }
        if !self.greeted && (reply.taken < self.taken || reply.done < self.done) {
            return Err(LinkError::Lost { known: self.taken, says: reply.taken });
        }
        if reply.fault > 0 {
            return Err(LinkError::Refused { number: reply.fault });
        }
        self.idle += u32::from(!self.greeted);
        // While it pauses there is nothing to get on with.
        let pauses = self.hold && reply.hold == self.version;
        if reply.taken > self.taken || reply.done > self.done || pauses {
            self.idle = 0;
        }
        // A late reply has smaller numbers.
        self.taken = self.taken.max(reply.taken);
        let obeyed = reply.hold.min(self.version);
        // A controller that was switched off in between has forgotten it.
        self.obeyed = if self.greeted { self.obeyed.max(obeyed) } else { obeyed };
        if reply.done > self.done {
            self.queue.drain(..(reply.done - self.done) as usize);
            self.done = reply.done;
        }
        if !self.greeted {
            self.greeted = true;
            self.next = self.taken + 1;
            self.say_hold = self.obeyed < self.version;
        }
        self.next = self.next.max(self.taken + 1);
        self.tries = 0;
        let open = !self.queue.is_empty() || self.obeyed < self.version;
        self.deadline = open.then(|| now.saturating_add(self.options.retry));
        Ok(())
    }

    /// When [`next_frame`](Self::next_frame) should be asked again at the latest, without a reply.
    pub fn deadline(&self) -> Option<Duration> {
        self.deadline
    }

    /// How far it is.
    pub fn progress(&self) -> LinkProgress {
        LinkProgress {
            numbered: self.done + self.queue.len() as u32,
            taken: self.taken,
            done: self.done,
            resent: self.resent,
            hold: self.hold,
            hold_obeyed: self.obeyed == self.version,
            over: self.ended && self.queue.is_empty(),
        }
    }

    /// Gives numbers to messages while the queue has places.
    fn refill(&mut self) -> Result<(), LinkError> {
        while !self.ended && self.queue.len() < self.options.queue as usize {
            let Some(message) = self.messages.next() else {
                self.ended = true;
                break;
            };
            let number = self.done + self.queue.len() as u32 + 1;
            if number > MAX_NUMBER {
                return Err(LinkError::TooMany);
            }
            let message = message?.raised(self.height_mm);
            self.queue.push_back(LinkFrame::Message { number, message }.encode()?);
        }
        Ok(())
    }

    fn count_try(&mut self) -> Result<(), LinkError> {
        self.tries += 1;
        let tries = self.tries - 1;
        self.kept(if tries > self.options.max_tries { Err(LinkError::NoReply { tries }) } else { Ok(()) })
    }

    /// Keeps an error.
    fn kept<T>(&mut self, result: Result<T, LinkError>) -> Result<T, LinkError> {
        if let Err(error) = &result {
            self.fault = Some(error.clone());
        }
        result
    }
}

/// Shortest time to a retry: below it a network of any kind is flooded.
const MIN_RETRY: Duration = Duration::from_millis(1);
