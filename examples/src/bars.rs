//! Progress on stderr. On a terminal a bar a stage, with an estimate of what is left; elsewhere a line a stage with its time, so that a log
//! of a long run is not empty.

use crate::terminal::say;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal, Write};
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Shows how far each stage has come. Can be updated from several threads.
#[derive(Debug)]
pub struct Bars {
    shown: Shown,
    current: Mutex<Option<Stage>>,
}

/// Where progress goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    Nowhere,
    AsBars,
    AsLines,
}

/// The stage that runs.
#[derive(Debug)]
struct Stage {
    name: String,
    start: Instant,
    /// When a line was last written about it.
    said: Instant,
    /// On a terminal.
    bar: Option<ProgressBar>,
}

/// Stages that are shorter get no line: a run has dozens of them.
const LEAST_LINE: Duration = Duration::from_millis(500);
/// How often a stage that goes on gets a line.
const LINE_EVERY: Duration = Duration::from_secs(60);

impl Bars {
    /// Bars on stderr, or lines where it is no terminal; nothing with `quiet`.
    pub fn new(quiet: bool) -> Self {
        let shown = match (quiet, io::stderr().is_terminal()) {
            (true, _) => Shown::Nowhere,
            (false, true) => Shown::AsBars,
            (false, false) => Shown::AsLines,
        };
        Bars { shown, current: Mutex::new(None) }
    }

    /// Says that `done` of `total` steps of `stage` are done (a total of 0: of an unknown number). Another name
    /// than before closes the bar of the stage before and opens a new one. Made for the `stage`, `done` and `total`
    /// of a progress report:
    /// ```
    /// use curvlay_examples::bars::Bars;
    /// let bars = Bars::new(true);
    /// bars.update("grow", 3, 10);
    /// assert!(bars.show("grow", 4, 10).is_continue());
    /// ```
    pub fn update(&self, stage: &str, done: u64, total: u64) {
        if self.shown == Shown::Nowhere {
            return;
        }
        // Stages with the same words follow one another: to the user they are one.
        let stage = in_words(stage);
        let mut current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        if current.as_ref().is_none_or(|running| running.name != stage) {
            if let Some(before) = current.take() {
                before.close();
            }
            let now = Instant::now();
            let bar = (self.shown == Shown::AsBars).then(|| open(stage, total));
            *current = Some(Stage { name: stage.to_owned(), start: now, said: now, bar });
        }
        if let Some(running) = current.as_mut() {
            running.update(done, total);
        }
    }

    /// The same for callbacks that may stop the work, which this does not.
    pub fn show(&self, stage: &str, done: u64, total: u64) -> ControlFlow<()> {
        self.update(stage, done, total);
        ControlFlow::Continue(())
    }

    /// Closes the last bar.
    pub fn finish(&self) {
        if let Some(last) = self.current.lock().unwrap_or_else(PoisonError::into_inner).take() {
            last.close();
        }
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        self.finish();
    }
}

impl Stage {
    fn update(&mut self, done: u64, total: u64) {
        let Some(bar) = &self.bar else {
            if total > 0 && self.said.elapsed() >= LINE_EVERY {
                self.said = Instant::now();
                let percent = 100 * u128::from(done.min(total)) / u128::from(total);
                say(&format!("{}: {percent} % after {}", self.name, time(self.start.elapsed())));
            }
            return;
        };
        if total > 0 {
            bar.set_length(total);
        }
        bar.set_position(done);
    }

    /// A full bar with its time stays on the screen, or a line in the log.
    fn close(self) {
        let Some(bar) = self.bar else {
            line(&self.name, self.start.elapsed()).iter().for_each(|line| say(line));
            return;
        };
        if let Some(length) = bar.length() {
            bar.set_position(length);
        }
        bar.set_style(style("{msg:<28} {bar:32} {percent:>3}% {elapsed_precise}"));
        bar.abandon();
        // The cursor still stands behind the bar; with stderr gone nobody sees it.
        let _ = writeln!(io::stderr());
    }
}

/// What a log has of a stage that is done.
fn line(name: &str, spent: Duration) -> Option<String> {
    (spent >= LEAST_LINE).then(|| format!("{name}: {}", time(spent)))
}

/// A time as people say it.
fn time(spent: Duration) -> String {
    let seconds = spent.as_secs();
    match seconds {
        0..60 => format!("{:.1} s", spent.as_secs_f64()),
        60..3600 => format!("{} min {} s", seconds / 60, seconds % 60),
        _ => format!("{} h {} min", seconds / 3600, seconds / 60 % 60),
    }
}

fn open(stage: &str, total: u64) -> ProgressBar {
    let bar = if total == 0 { ProgressBar::no_length() } else { ProgressBar::new(total) };
    bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(15));
    let left = if total == 0 { "" } else { ", {eta} left" };
    bar.set_style(style(&format!("{{msg:<28}} {{bar:32}} {{percent:>3}}% {{elapsed_precise}}{left}")));
    bar.set_message(stage.to_owned());
    bar
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("━╸─")
}

/// A stage in words that the owner of a printer knows; those of the crates are for their developers. Others stay as they are.
fn in_words(stage: &str) -> &str {
    match stage {
        "voxels" | "rows" | "winding" | "inside" => "cutting the part into cells",
        "orient" => "searching the best pose",
        "pieces" | "platform" => "setting the part on the plate",
        "grow" | "peel" | "unbuild" | "order" => "finding a printing order",
        "nozzle" | "impossible" => "trying the nozzle",
        "support" | "gap" => "planning support",
        "uniform" | "level field" | "coherent" => "shaping the layers",
        "audit" | "audit uniform" | "check" | "verify" => "checking the layers",
        "contour" | "trim" | "crossings" | "clip" | "spacing" => "cutting layers to the part",
        "distance" | "curves" | "geodesics" | "guides" | "beads" | "fill" | "paths" | "stripes" => "filling the layers",
        "coverage" | "measure" => "measuring what beads cover",
        "gouging" | "resolve" | "smooth" | "follow" => "keeping the nozzle clear",
        "travel" | "deposit" => "planning travels",
        "place" | "part place" | "arms" => "placing the part before the robot",
        "plan motions" | "ladder" | "time path" | "time free" => "planning robot motion",
        "check motions" => "checking robot motion",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_said_in_the_unit_that_fits() {
        let said = [0.62, 59.9, 60.0, 3599.0, 7384.0].map(|seconds| time(Duration::from_secs_f64(seconds)));
        let line = |seconds| line(in_words("audit uniform"), Duration::from_secs_f64(seconds));
        assert_eq!((line(0.4), line(2.0).as_deref()), (None, Some("checking the layers: 2.0 s")));
        assert_eq!(said, ["0.6 s", "59.9 s", "1 min 0 s", "59 min 59 s", "2 h 3 min"]);
    }
}
