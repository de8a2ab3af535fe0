//! Something that is wrong, and what helps.

use std::fmt;

/// A share in words, such as `24.24 %`.
pub fn percent(share: f64) -> String {
    if share > 0.0 && share < 5e-5 { "less than 0.01 %".to_owned() } else { format!("{:.2} %", 100.0 * share) }
}

/// The largest of some lengths in words, such as `0.24 mm at most`.
///
/// # Example
/// ```
/// use curvlay_examples::findings::at_most_mm;
/// assert_eq!([0.0, 0.0049, 0.24].map(at_most_mm), ["0.00 mm at most", "less than 0.01 mm", "0.24 mm at most"]);
/// ```
pub fn at_most_mm(length_mm: f64) -> String {
    if length_mm > 0.0 && length_mm < 5e-3 {
        "less than 0.01 mm".to_owned()
    } else {
        format!("{length_mm:.2} mm at most")
    }
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

/// The effect of a finding on the exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// None, and nothing is wrong: what was done to the part, what was taken.
    Note,
    /// None.
    Warning,
    /// Sets it to 3.
    Failed,
}

impl Severity {
    /// Failed if a share is above what is allowed, or is no number.
    pub fn above(share: f64, allowed: f64) -> Self {
        if share <= allowed { Severity::Warning } else { Severity::Failed }
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
