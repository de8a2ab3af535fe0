//! Signals that come as much later as the arm is behind its stream.

use super::Step;
use std::collections::VecDeque;

/// Passes signals on after so many more steps of a stream. At the end the last posture is held until the last signal has come:
/// the arm gets there as late. A move passes at once.
pub(super) struct Delayed<I> {
    steps: I,
    ticks: u64,
    /// Signals, and the number of steps of the stream after which each is due.
    signals: VecDeque<(u64, Step)>,
    /// Steps of the stream that were passed on.
    passed: u64,
    next: Option<Step>,
    last: Option<Step>,
}

impl<I: Iterator<Item = Step>> Delayed<I> {
    pub fn new(steps: I, ticks: u64) -> Self {
        Delayed { steps, ticks, signals: VecDeque::new(), passed: 0, next: None, last: None }
    }

    fn due(&mut self) -> Option<Step> {
        let is_due = self.signals.front().is_some_and(|(due, _)| *due <= self.passed);
        if is_due { self.signals.pop_front().map(|(_, step)| step) } else { None }
    }
}

impl<I: Iterator<Item = Step>> Iterator for Delayed<I> {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        while self.next.is_none() {
            match self.steps.next() {
                Some(step @ Step::Servo { .. }) => self.next = Some(step),
                Some(step @ Step::Move(_)) => return Some(step),
                Some(signal) => self.signals.push_back((self.passed + self.ticks, signal)),
                None => break,
            }
        }
        if let Some(signal) = self.due() {
            return Some(signal);
        }
        if let Some(step) = self.next.take() {
            self.passed += 1;
            self.last = Some(step);
            return Some(step);
        }
        let (due, _) = *self.signals.front()?;
        match self.last {
            Some(step) => {
                self.passed += 1;
                Some(step)
            }
            // No stream: there is nothing to wait for.
            None => {
                self.passed = due;
                self.due()
            }
        }
    }
}
