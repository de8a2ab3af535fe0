//! What a run finds wrong, as data. One list, from which come the lines on stderr, the notices on top of the report, keys of
//! the summary, and the exit status: nothing is told in one place alone.

use crate::args::{Outcome, say};
use crate::report::Report;
use crate::summary::{Summary, SummaryError};
use std::fmt;

/// A share in words, such as `24.24 %`.
pub fn percent(share: f64) -> String {
    if share > 0.0 && share < 5e-5 { "less than 0.01 %".to_owned() } else { format!("{:.2} %", 100.0 * share) }
}

/// What a finding does to the exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Nothing, and nothing is wrong: what was done to the part, what was taken.
    Noted,
    /// Nothing: the user should know.
    Told,
    /// It becomes 3.
    Failed,
}

impl Severity {
    /// Failed if a share is above what is allowed, or is no number.
    pub fn above(share: f64, allowed: f64) -> Self {
        if share <= allowed { Severity::Told } else { Severity::Failed }
    }
}

/// Something that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Whether the run counts as failed for it.
    pub severity: Severity,
    /// What is wrong, in plain words.
    pub what: String,
    /// How much: a count, a share, a length; may be empty.
    pub amount: String,
    /// Where: a place, the file that lists the places, or the option to change; may be empty.
    pub place: String,
}

/// One line: `what: amount (place)`.
impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Finding { what, amount, place, .. } = self;
        write!(f, "{what}{}{amount}", if amount.is_empty() { "" } else { ": " })?;
        if place.is_empty() { Ok(()) } else { write!(f, " ({place})") }
    }
}

/// All that a run found wrong, in the order in which it was found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Findings {
    list: Vec<Finding>,
    /// How many of them are on stderr.
    said: usize,
}

impl Findings {
    /// Adds one.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::findings::{Findings, Severity};
    /// let (missed, allowed) = (0.24, 1e-3);
    /// let mut findings = Findings::default();
    /// findings.add(Severity::above(missed, allowed), "cells are missed", "24 % of the volume", "field.csv");
    /// assert!(findings.has_failed());
    /// assert_eq!(findings.iter().next().unwrap().to_string(), "cells are missed: 24 % of the volume (field.csv)");
    /// ```
    pub fn add(
        &mut self,
        severity: Severity,
        what: impl Into<String>,
        amount: impl Into<String>,
        place: impl Into<String>,
    ) {
        let (what, amount, place) = (what.into(), amount.into(), place.into());
        self.list.push(Finding { severity, what, amount, place });
    }

    /// Adds one that was made elsewhere.
    pub fn push(&mut self, finding: Finding) {
        self.list.push(finding);
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Finding> {
        self.list.iter()
    }

    /// Those of a severity.
    pub fn of(&self, severity: Severity) -> impl Iterator<Item = &Finding> {
        self.list.iter().filter(move |finding| finding.severity == severity)
    }

    /// Whether the run counts as failed.
    pub fn has_failed(&self) -> bool {
        self.of(Severity::Failed).next().is_some()
    }

    /// Writes what has been added since the last call to stderr, a line each.
    pub fn say(&mut self) {
        for finding in &self.list[self.said..] {
            let word = match finding.severity {
                Severity::Noted => "note",
                Severity::Told => "warning",
                Severity::Failed => "check failed",
            };
            say(&format!("{word}: {finding}"));
        }
        self.said = self.list.len();
    }

    /// A notice for each, what failed first; notes are paragraphs behind them.
    pub fn report(&self, report: &mut Report) {
        self.of(Severity::Failed).for_each(|finding| _ = report.notice(&format!("Check failed: {finding}")));
        self.of(Severity::Told).for_each(|finding| _ = report.notice(&finding.to_string()));
        self.of(Severity::Noted).for_each(|finding| _ = report.paragraph(&format!("Note: {finding}.")));
    }

    /// How many there are of each severity, and all of them, a line each.
    ///
    /// # Errors
    /// [`SummaryError`] if the keys `findings_failed`, `findings_told`, `findings_noted` or `findings` are taken.
    pub fn summary(&self, summary: &mut Summary) -> Result<(), SummaryError> {
        let word = |finding: &Finding| match finding.severity {
            Severity::Noted => "noted",
            Severity::Told => "told",
            Severity::Failed => "failed",
        };
        let lines: Vec<String> = self.iter().map(|finding| format!("{}: {finding}", word(finding))).collect();
        summary
            .set("findings_failed", self.of(Severity::Failed).count())?
            .set("findings_told", self.of(Severity::Told).count())?
            .set("findings_noted", self.of(Severity::Noted).count())?
            .set("findings", lines.join("\n"))?;
        Ok(())
    }

    /// What they make of the exit status, once they have been [said](Findings::say).
    pub fn outcome(&self) -> Outcome {
        if self.has_failed() { Outcome::ChecksFailed(Vec::new()) } else { Outcome::Done }
    }
}
