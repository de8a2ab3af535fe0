//! What a run finds wrong, as data. One list, from which come the lines on stderr, the notices on top of the report, keys of
//! the summary, and the exit status: all of them show the same.

pub use crate::finding::{Finding, Severity, accept, at_most_mm, percent};
use crate::outcome::Outcome;
use crate::report::Report;
use crate::summary::{Summary, SummaryError};
use crate::terminal::say;

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
                Severity::Note => "note",
                Severity::Warning => "warning",
                Severity::Failed => "check failed",
            };
            say(&format!("{word}: {finding}"));
            finding.advice().for_each(|(word, text)| say(&format!("  {word}: {text}")));
        }
        self.said = self.list.len();
    }

    /// A notice for each, failed checks first and unlike warnings; notes are paragraphs behind them.
    pub fn report(&self, report: &mut Report) {
        for severity in [Severity::Failed, Severity::Warning, Severity::Note] {
            self.of(severity).for_each(|finding| _ = report.finding(finding));
        }
    }

    /// How many there are of each severity, and all of them: a line each, and under it cause and advice, indented by two spaces.
    ///
    /// # Errors
    /// [`SummaryError`] if the keys `findings_failed`, `findings_warnings`, `findings_notes` or `findings` are taken.
    pub fn summary(&self, summary: &mut Summary) -> Result<(), SummaryError> {
        let word = |finding: &Finding| match finding.severity {
            Severity::Note => "note",
            Severity::Warning => "warning",
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
            .set("findings_warnings", self.of(Severity::Warning).count())?
            .set("findings_notes", self.of(Severity::Note).count())?
            .set("findings", lines.join("\n"))?;
        Ok(())
    }

    /// What they make of the exit status, once they have been [said](Findings::say).
    pub fn outcome(&self) -> Outcome {
        if self.has_failed() { Outcome::ChecksFailed(Vec::new()) } else { Outcome::Done }
    }
}
