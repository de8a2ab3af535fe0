//! Lines on stderr.

use std::fmt::Display;
use std::io::{self, Write};

/// Writes to stderr what was done, or comes next.
pub fn note(message: impl Display) {
    say(&format!("note: {message}"));
}

/// Writes a warning to stderr.
pub fn warn(message: impl Display) {
    say(&format!("warning: {message}"));
}

/// Writes a warning to stderr that a mesh is not closed, if edges of it are open.
pub fn warn_if_open(open_edges: usize) {
    if open_edges > 0 {
        warn(format!(
            "the mesh is not closed: {open_edges} of its edges have one triangle only; holes are closed by a guess"
        ));
    }
}

/// Writes a line to stderr.
pub(crate) fn say(line: &str) {
    // Nothing can be reported without stderr.
    let _ = writeln!(io::stderr(), "{}", printable(line));
}

/// A text on one line as a terminal may show it: a file's name may hold control characters, which would clear the screen or worse.
/// ```
/// assert_eq!(curvlay_examples::args::printable("a\u{1b}[2J.stl"), "a\\u{1b}[2J.stl");
/// ```
pub fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { c.escape_default().to_string() } else { c.to_string() }).collect()
}
