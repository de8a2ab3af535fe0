//! What a run finds wrong, as data. One list, from which come the lines on stderr, the notices on top of the report, keys of
//! the summary, and the exit status: all of them show the same.

use crate::args::{Outcome, say};
use crate::report::Report;
use crate::summary::{Summary, SummaryError};
use std::fmt;

/// A share in words, such as `24.24 %`.
pub fn percent(share: f64) -> String {
    if share > 0.0 && share < 5e-5 { "less than 0.01 %".to_owned() } else { format!("{:.2} %", 100.0 * share) }
}

/// The option with a value, rounded up to two digits, that accepts a share; empty for none.
///
/// # Example
/// ```
/// use curvlay_examples::findings::accept;
/// assert_eq!(accept("--allow-missed", 0.0341), "--allow-missed 0.035");
/// assert_eq!(accept("--allow-missed", 0.0), "");
/// ```
pub fn accept(option: &str, share: f64) -> String {
    if !(share > 0.0 && share.is_finite()) {
        return String::new();
    }
    let digit = 10f64.powf(share.log10().floor() - 1.0);
    let decimals = (-digit.log10()).round().max(0.0) as usize;
    format!("{option} {:.decimals$}", (share / digit).ceil() * digit)
}

/// What a finding does to the exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Nothing, and nothing is wrong: what was done to the part, what was taken.
    Noted,
    /// Nothing: a warning.
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

/// Something that is wrong, and what helps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Whether the run counts as failed for it.
    pub severity: Severity,
    /// What is wrong, in plain words.
    pub what: String,
    /// How much: a count, a share, a length; may be empty.
    pub amount: String,
    /// Where: a place, or the file that lists the places; may be empty.
    pub place: String,
    /// The likely cause, computed from the run; empty if it is unknown.
    pub cause: String,
    /// What to try, the most promising first; may be empty.
    pub tries: Vec<String>,
    /// The option that accepts it, with the value that would do, such as `--allow-missed 0.03`; empty if there is no such option.
    pub allow: String,
}

impl Finding {
    /// One of which neither cause nor remedy is known.
    pub fn new(
        severity: Severity,
        what: impl Into<String>,
        amount: impl Into<String>,
        place: impl Into<String>,
    ) -> Self {
        let (what, amount, place) = (what.into(), amount.into(), place.into());
        let (cause, allow) = (String::new(), String::new());
        Finding { severity, what, amount, place, cause, tries: Vec::new(), allow }
    }

    /// Sets the likely cause. An empty text is no cause.
    pub fn cause(&mut self, cause: impl Into<String>) -> &mut Self {
        self.cause = cause.into();
        self
    }

    /// Appends something to try. An empty text is left out.
    pub fn try_to(&mut self, advice: impl Into<String>) -> &mut Self {
        let advice = advice.into();
        if !advice.is_empty() {
            self.tries.push(advice);
        }
        self
    }

    /// Sets the option that accepts it.
    pub fn allow(&mut self, option: impl Into<String>) -> &mut Self {
        self.allow = option.into();
        self
    }

    /// What follows the line of the finding: its cause, what to try, and last how to accept it, each under its word.
    pub fn advice(&self) -> impl Iterator<Item = (&'static str, String)> {
        let all = [("cause", self.cause.clone()), ("try", self.tries.join("; ")), ("accept", self.allow.clone())];
        all.into_iter().filter(|(_, text)| !text.is_empty())
    }
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
    /// Adds one of which neither cause nor remedy is known; see [`Findings::explain`].
    pub fn add(
        &mut self,
        severity: Severity,
        what: impl Into<String>,
        amount: impl Into<String>,
        place: impl Into<String>,
    ) {
        self.explain(severity, what, amount, place);
    }

    /// Adds one, and returns it for its cause, what to try, and the option that accepts it.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::findings::{Findings, Severity};
    /// let (missed, allowed) = (0.24, 1e-3);
    /// let mut findings = Findings::default();
    /// findings
    ///     .explain(Severity::above(missed, allowed), "cells are missed", "24 % of the volume", "field.csv")
    ///     .cause("nothing stands below them")
    ///     .try_to("--support auto")
    ///     .allow("--allow-missed 0.25");
    /// assert!(findings.has_failed());
    /// let finding = findings.iter().next().unwrap();
    /// assert_eq!(finding.to_string(), "cells are missed: 24 % of the volume (field.csv)");
    /// assert_eq!(finding.advice().nth(1), Some(("try", "--support auto".to_owned())));
    /// ```
    pub fn explain(
        &mut self,
        severity: Severity,
        what: impl Into<String>,
        amount: impl Into<String>,
        place: impl Into<String>,
    ) -> &mut Finding {
        self.list.push_mut(Finding::new(severity, what, amount, place))
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

    /// Writes what has been added since the last call to stderr: a line each, and under it cause and advice, indented.
    pub fn say(&mut self) {
        for finding in &self.list[self.said..] {
            let word = match finding.severity {
                Severity::Noted => "note",
                Severity::Told => "warning",
                Severity::Failed => "check failed",
            };
            say(&format!("{word}: {finding}"));
            finding.advice().for_each(|(word, text)| say(&format!("  {word}: {text}")));
        }
        self.said = self.list.len();
    }

    /// A notice for each, failed checks first and unlike warnings; notes are paragraphs behind them.
    pub fn report(&self, report: &mut Report) {
        for severity in [Severity::Failed, Severity::Told, Severity::Noted] {
            self.of(severity).for_each(|finding| _ = report.finding(finding));
        }
    }

    /// How many there are of each severity, and all of them: a line each, and under it cause and advice, indented by two spaces.
    ///
    /// # Errors
    /// [`SummaryError`] if the keys `findings_failed`, `findings_told`, `findings_noted` or `findings` are taken.
    pub fn summary(&self, summary: &mut Summary) -> Result<(), SummaryError> {
        let word = |finding: &Finding| match finding.severity {
            Severity::Noted => "noted",
            Severity::Told => "told",
            Severity::Failed => "failed",
        };
        let lines: Vec<String> = self
            .iter()
            .flat_map(|finding| {
                let advice = finding.advice().map(|(word, text)| format!("  {word}: {text}"));
                std::iter::once(format!("{}: {finding}", word(finding))).chain(advice)
            })
            .collect();
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
