//! The sender as a state machine: what to write next, given what came and what time it is. No sockets, no clock.

use super::frame::{UrFrame, UrReply, UrState};
use super::options::{MAX_RING, UrSenderOptions};
use super::tick::UrTick;
use super::{UrStreamError, UrStreamJob};
use std::collections::VecDeque;
use std::time::Duration;

/// How far a print is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UrStreamProgress {
    /// Ticks sent at least once.
    pub sent: u32,
    /// Ticks that the robot has taken.
    pub taken: u32,
    /// Ticks that it has run.
    pub run: u32,
    /// Ticks of the print.
    pub total: u32,
    /// Ticks sent more than once.
    pub resent: u64,
    /// Connections so far.
    pub connections: u32,
    /// Lines that were no reply, on connections that were given up for it.
    pub garbled: u32,
    /// What the robot said last.
    pub state: UrState,
    /// Whether a stop was asked for.
    pub stopping: bool,
    /// Whether the robot has run all, or has stopped as it was asked to.
    pub over: bool,
}

/// Sends ticks. Times are those of any clock that does not go back, for example since the begin.
///
/// It holds no more ticks than are under way. Ticks that a robot has taken already, of the same job, are skipped: so a sender that was started
/// again goes on where the robot is.
///
/// # Example
/// ```
/// use curvlay_kinematics::program::ur_stream::*;
/// use std::time::Duration;
/// let now = Duration::ZERO;
/// let ticks = [UrTick { joints: [0.5; 6], filament_mm_s: None, move_rad_s: None }; 4].map(Ok);
/// let job = UrStreamJob::of(ticks.clone())?;
/// let mut sender = UrStreamSender::new(ticks.into_iter(), job, UrSenderOptions::default())?;
/// sender.connected(now)?;
/// // Nothing until the robot has said where it is.
/// assert!(sender.next_frame(now)?.is_none());
/// sender.receive("R 0 0 0 0 0", now)?;
/// let frame: UrFrame = sender.next_frame(now)?.unwrap().parse()?;
/// assert_eq!((frame.first, frame.ticks.len()), (1, 3));
/// assert!(sender.next_frame(now)?.is_some() && sender.next_frame(now)?.is_none());
/// sender.receive(&format!("R {} 4 4 2 0", job.number), now)?;
/// assert!(sender.progress().over);
/// # Ok::<(), UrStreamError>(())
/// ```
#[derive(Clone, Debug)]
pub struct UrStreamSender<I> {
    ticks: I,
    job: UrStreamJob,
    options: UrSenderOptions,
    /// The ticks `taken + 1` and on that were taken from the print.
    waiting: VecDeque<UrTick>,
    /// The next tick to write.
    next: u32,
    up: bool,
    greeted: bool,
    said_stop: bool,
    /// When something was written, when something came, and when the robot last took a tick.
    wrote: Duration,
    heard: Duration,
    took: Duration,
    /// Connections one after the other without progress.
    idle: u32,
    progress: UrStreamProgress,
    fault: Option<UrStreamError>,
}

impl<I: Iterator<Item = Result<UrTick, UrStreamError>>> UrStreamSender<I> {
    /// A sender that is not connected.
    ///
    /// # Arguments
    /// * `job`: that of the same ticks, [`UrStreamJob::of`].
    ///
    /// # Errors
    /// [`UrStreamError::Option`].
    pub fn new(ticks: I, job: UrStreamJob, options: UrSenderOptions) -> Result<Self, UrStreamError> {
        let wrong = |what, value, min, max| Err(UrStreamError::Option { what, value, min, max });
        if !(1..=MAX_RING).contains(&options.window) {
            return wrong("window", f64::from(options.window), 1.0, f64::from(MAX_RING));
        }
        if options.max_tries == 0 {
            return wrong("max_tries", 0.0, 1.0, f64::from(u32::MAX));
        }
        let times = [("heartbeat", options.heartbeat), ("retry", options.retry), ("silence", options.silence)];
        for (what, time) in times {
            if !(MIN_TIME..=MAX_TIME).contains(&time) {
                return wrong(what, time.as_secs_f64(), MIN_TIME.as_secs_f64(), MAX_TIME.as_secs_f64());
            }
        }
        let zero = Duration::ZERO;
        let progress = UrStreamProgress { total: job.ticks, ..UrStreamProgress::default() };
        let (waiting, fault) = (VecDeque::new(), None);
        let [up, greeted, said_stop] = [false; 3];
        let [wrote, heard, took] = [zero; 3];
        Ok(UrStreamSender {
            ticks,
            job,
            options,
            waiting,
            next: 1,
            up,
            greeted,
            said_stop,
            wrote,
            heard,
            took,
            idle: 0,
            progress,
            fault,
        })
    }

    /// A connection is there.
    ///
    /// # Errors
    /// [`UrStreamError::NoProgress`] if too many brought none.
    pub fn connected(&mut self, now: Duration) -> Result<(), UrStreamError> {
        (self.up, self.greeted, self.said_stop) = (true, false, false);
        [self.wrote, self.heard, self.took] = [now; 3];
        self.progress.connections += 1;
        self.idle += 1;
        let connections = self.idle - 1;
        self.kept(if connections >= self.options.max_tries {
            Err(UrStreamError::NoProgress { connections })
        } else {
            Ok(())
        })
    }

    /// The connection is gone.
    pub fn disconnected(&mut self) {
        (self.up, self.greeted) = (false, false);
    }

    /// Whether a connection is there that is of use: not one on which nothing comes, or what came was no reply.
    pub fn is_up(&self, now: Duration) -> bool {
        self.up && now.saturating_sub(self.heard) < self.options.silence
    }

    /// Asks the robot to stop: it slows down on its path, switches the extruder off, and ends its program. It is over when the robot has said so.
    pub fn stop(&mut self) {
        self.progress.stopping = true;
    }

    /// The next frame to write, with its line feed; `None`: nothing for now.
    ///
    /// # Errors
    /// [`UrStreamError`]: it cannot go on, and says so from now on.
    pub fn next_frame(&mut self, now: Duration) -> Result<Option<String>, UrStreamError> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        if !self.up || !self.greeted || self.progress.over {
            return Ok(None);
        }
        let due = |since: Duration, time: Duration| now.saturating_sub(since) >= time;
        let beat = due(self.wrote, self.options.heartbeat);
        if self.progress.stopping {
            if !beat && std::mem::replace(&mut self.said_stop, true) {
                return Ok(None);
            }
            self.said_stop = true;
            return Ok(Some(self.frame(Vec::new(), true, now)));
        }
        if self.next > self.progress.taken + 1 && due(self.took, self.options.retry) {
            self.next = self.progress.taken + 1;
            self.took = now;
        }
        let filled = self.fill();
        self.kept(filled)?;
        let from = (self.next - self.progress.taken - 1) as usize;
        let until = (self.progress.run + self.options.window).min(self.job.ticks);
        let free = (until + 1).saturating_sub(self.next) as usize;
        // A frame that is not full waits for a place in the window, unless it is the last one.
        let count = free.min(UrFrame::TICKS);
        let is_last = self.next as usize + count > self.job.ticks as usize;
        if count == 0 || (count < UrFrame::TICKS.min(self.options.window as usize) && !is_last) {
            return Ok(beat.then(|| self.frame(Vec::new(), false, now)));
        }
        let ticks: Vec<UrTick> = self.waiting.iter().skip(from).take(count).copied().collect();
        Ok(Some(self.frame(ticks, false, now)))
    }

    fn frame(&mut self, ticks: Vec<UrTick>, stop: bool, now: Duration) -> String {
        if self.next == self.progress.taken + 1 && !ticks.is_empty() {
            self.took = now;
        }
        let first = self.next;
        let last = first - 1 + ticks.len() as u32;
        self.progress.resent += u64::from(last.min(self.progress.sent).saturating_sub(first - 1));
        self.progress.sent = self.progress.sent.max(last);
        self.next = last + 1;
        self.wrote = now;
        UrFrame { job: self.job, first, ticks, stop }.encode()
    }

    /// Takes a line from the robot. One that is no reply ends the connection: [`is_up`](Self::is_up) says so.
    ///
    /// # Errors
    /// [`UrStreamError`]: it cannot go on.
    pub fn receive(&mut self, line: &str, now: Duration) -> Result<(), UrStreamError> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        if !self.up {
            return Ok(());
        }
        let Ok(reply) = line.parse::<UrReply>() else {
            self.progress.garbled += 1;
            self.disconnected();
            return Ok(());
        };
        let taken = self.take(&reply, line, now);
        self.kept(taken)
    }

    fn take(&mut self, reply: &UrReply, line: &str, now: Duration) -> Result<(), UrStreamError> {
        if let (UrState::Halted, Some(fault)) = (reply.state, reply.fault) {
            return Err(UrStreamError::Halted { tick: reply.run + 1, fault });
        }
        if reply.job != 0 && reply.job != self.job.number {
            return Err(UrStreamError::OtherJob { job: reply.job, run: reply.run });
        }
        let impossible = |what| UrStreamError::Reply { line: line.trim().chars().take(60).collect(), what };
        let first = self.progress.sent == 0 && reply.job != 0;
        if reply.taken > self.job.ticks || (!first && reply.taken > self.progress.sent) {
            return Err(impossible("it has ticks that were not sent"));
        }
        if reply.taken < self.progress.taken || reply.run < self.progress.run {
            // On one connection replies come in their order.
            return Err(UrStreamError::Lost { known: self.progress.run, says: reply.run });
        }
        if reply.state == UrState::Done && reply.run < self.job.ticks {
            return Err(impossible("it is done before the last tick"));
        }
        self.heard = now;
        if reply.taken > self.progress.taken || reply.run > self.progress.run {
            self.idle = 0;
        }
        self.pass(reply.taken)?;
        if reply.taken > self.progress.taken {
            self.took = now;
        }
        (self.progress.taken, self.progress.run) = (reply.taken, reply.run);
        self.progress.state = reply.state;
        self.progress.sent = self.progress.sent.max(reply.taken);
        self.next = self.next.max(reply.taken + 1);
        if !self.greeted {
            (self.greeted, self.next, self.took) = (true, reply.taken + 1, now);
        }
        self.progress.over = matches!(reply.state, UrState::Done | UrState::Stopped);
        Ok(())
    }

    /// Forgets the ticks up to one.
    fn pass(&mut self, taken: u32) -> Result<(), UrStreamError> {
        for number in self.progress.taken..taken {
            if self.waiting.pop_front().is_none() {
                self.fetch(number)?;
            }
        }
        Ok(())
    }

    /// The next tick of the print, behind so many.
    fn fetch(&mut self, number: u32) -> Result<UrTick, UrStreamError> {
        self.ticks.next().unwrap_or(Err(UrStreamError::Short { ticks: number, total: self.job.ticks }))
    }

    /// Takes ticks from the print up to the end of the window.
    fn fill(&mut self) -> Result<(), UrStreamError> {
        let until = (self.progress.run + self.options.window).min(self.job.ticks);
        while self.progress.taken + (self.waiting.len() as u32) < until {
            let tick = self.fetch(self.progress.taken + self.waiting.len() as u32)?;
            self.waiting.push_back(tick);
        }
        Ok(())
    }

    /// When [`next_frame`](Self::next_frame) should be asked again at the latest, without a reply.
    pub fn deadline(&self) -> Duration {
        self.wrote.saturating_add(self.options.heartbeat)
    }

    /// How far it is.
    pub fn progress(&self) -> UrStreamProgress {
        self.progress
    }

    /// Keeps an error.
    fn kept<T>(&mut self, result: Result<T, UrStreamError>) -> Result<T, UrStreamError> {
        if let Err(error) = &result {
            self.fault = Some(error.clone());
        }
        result
    }
}

/// Shortest and longest time of an option: a shorter one floods the network, a longer one is no use to an operator.
const MIN_TIME: Duration = Duration::from_millis(1);
const MAX_TIME: Duration = Duration::from_secs(3600);
