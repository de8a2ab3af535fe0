//! Signals that come later, as the arm is behind its stream, or earlier, as the equipment is behind the arm.

use crate::program::Step;
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

/// Passes signals on before so many steps of a stream that come before them. Where the stream has fewer steps before its first signal,
/// its first posture is held for the rest. A move passes at once: those of a stream come before its steps.
pub(super) struct Advanced<I> {
    steps: I,
    ticks: usize,
    /// Steps of the stream that wait.
    waiting: VecDeque<Step>,
    /// How often the first posture is to come once more, when it is known.
    held: usize,
    /// Whether a step of the stream was passed on, or a signal.
    has_begun: bool,
}

impl<I: Iterator<Item = Step>> Advanced<I> {
    pub fn new(steps: I, ticks: usize) -> Self {
        Advanced { steps, ticks, waiting: VecDeque::new(), held: 0, has_begun: false }
    }

    /// Holds the first posture, so that as many steps wait as the first signal is to be early.
    fn begin(&mut self) {
        let missing = self.ticks - self.waiting.len();
        match self.waiting.front().copied() {
            Some(first) => (0..missing).for_each(|_| self.waiting.push_front(first)),
            None => self.held = missing,
        }
    }
}

impl<I: Iterator<Item = Step>> Iterator for Advanced<I> {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        while self.waiting.len() <= self.ticks {
            match self.steps.next() {
                Some(step @ Step::Servo { .. }) => {
                    self.waiting.extend((0..std::mem::take(&mut self.held)).map(|_| step));
                    self.waiting.push_back(step);
                }
                Some(step @ Step::Move(_)) => return Some(step),
                Some(signal) => {
                    if !std::mem::replace(&mut self.has_begun, true) {
                        self.begin();
                    }
                    return Some(signal);
                }
                None => break,
            }
        }
        self.has_begun = true;
        self.waiting.pop_front()
    }
}
