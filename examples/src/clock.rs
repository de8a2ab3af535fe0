//! How long the stages of a computation take, by its reports of progress.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

/// Adds up the time of each stage. Threads may add at the same time.
///
/// The time before a report belongs to the stage of the report, or to the stage before it if nothing is done yet: so a stage
/// that reports its begin is timed exactly.
#[derive(Debug, Default)]
pub struct StageClock {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    last: Option<(Instant, &'static str)>,
    last_of_thread: HashMap<ThreadId, (Instant, &'static str)>,
    /// On the clock, and the threads added up.
    times: HashMap<&'static str, [Duration; 2]>,
}

impl StageClock {
    /// Takes a report: `done` units of work of `stage` are done.
    pub fn note(&self, stage: &'static str, done: u64) {
        self.add(Some(stage), done);
    }

    /// Ends the stage that runs; what comes until the next report belongs to none.
    pub fn stop(&self) {
        self.add(None, 0);
    }

    fn add(&self, stage: Option<&'static str>, done: u64) {
        let now = Instant::now();
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let State { last, last_of_thread, times } = &mut *state;
        let of_thread = last_of_thread.remove(&thread::current().id());
        for (which, last) in [*last, of_thread].into_iter().enumerate() {
            let Some((since, running)) = last else { continue };
            let owner = stage.filter(|_| done > 0).unwrap_or(running);
            times.entry(owner).or_default()[which] += now - since;
        }
        *last = stage.map(|stage| (now, stage));
        last_of_thread.extend(stage.map(|stage| (thread::current().id(), (now, stage))));
    }

    /// How long stages took on the clock.
    pub fn on_the_clock(&self, stages: &[&str]) -> Duration {
        self.sum(stages, 0)
    }

    /// How long threads were at work at stages, all of them added up.
    pub fn of_threads(&self, stages: &[&str]) -> Duration {
        self.sum(stages, 1)
    }

    fn sum(&self, stages: &[&str], which: usize) -> Duration {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        stages.iter().filter_map(|stage| state.times.get(stage)).map(|times| times[which]).sum()
    }
}
