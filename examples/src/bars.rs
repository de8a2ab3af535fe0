//! Progress bars on stderr: one line a stage, nothing when stderr is not a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal, Write};
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

/// Shows how far each stage has come. Can be told from several threads.
#[derive(Debug)]
pub struct Bars {
    shown: bool,
    current: Mutex<Option<(String, ProgressBar)>>,
}

impl Bars {
    /// Bars on stderr; none with `quiet` or without a terminal.
    pub fn new(quiet: bool) -> Self {
        Bars { shown: !quiet && io::stderr().is_terminal(), current: Mutex::new(None) }
    }

    /// Says that `done` of `total` steps of `stage` are done (a total of 0: nobody knows of how many). Another name
    /// than before closes the bar of the stage before and opens a new one. Made for the `stage`, `done` and `total`
    /// of a progress report:
    /// ```
    /// use curvlay_examples::bars::Bars;
    /// let bars = Bars::new(true);
    /// bars.update("grow", 3, 10);
    /// assert!(bars.show("grow", 4, 10).is_continue());
    /// ```
    pub fn update(&self, stage: &str, done: u64, total: u64) {
        if !self.shown {
            return;
        }
        let mut current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        if current.as_ref().is_none_or(|(name, _)| name != stage) {
            if let Some((_, bar)) = current.take() {
                close(&bar);
            }
            *current = Some((stage.to_owned(), open(stage, total)));
        }
        if let Some((_, bar)) = current.as_ref() {
            if total > 0 {
                bar.set_length(total);
            }
            bar.set_position(done);
        }
    }

    /// The same for callbacks that may stop the work, which this does not.
    pub fn show(&self, stage: &str, done: u64, total: u64) -> ControlFlow<()> {
        self.update(stage, done, total);
        ControlFlow::Continue(())
    }

    /// Closes the last bar.
    pub fn finish(&self) {
        if let Some((_, bar)) = self.current.lock().unwrap_or_else(PoisonError::into_inner).take() {
            close(&bar);
        }
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        self.finish();
    }
}

/// A full bar with its time stays on the screen.
fn close(bar: &ProgressBar) {
    if let Some(length) = bar.length() {
        bar.set_position(length);
    }
    bar.abandon();
    // The cursor still stands behind the bar; with stderr gone nobody sees it.
    let _ = writeln!(io::stderr());
}

fn open(stage: &str, total: u64) -> ProgressBar {
    let bar = if total == 0 { ProgressBar::no_length() } else { ProgressBar::new(total) };
    bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(15));
    let style = ProgressStyle::with_template("{msg:<14} {bar:32} {percent:>3}% {elapsed_precise}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("━╸─"));
    bar.set_message(stage.to_owned());
    bar
}
