//! Headers and footers: lines of G-code with names in braces that are filled in.

use super::text::Text;
use super::{LONGEST_LINE, WriteError};

/// A name that a template may use: its value, and the digits behind the point.
pub(super) type Value = (&'static str, Option<f64>, usize);

/// Appends a template's lines. A line that asks for a value which is not set is left out; `{{` and `}}` are braces.
pub(super) fn expand(text: &mut Text, name: &'static str, template: &str, values: &[Value]) -> Result<u64, WriteError> {
    let mut lines = 0;
    for (row, line) in template.lines().enumerate() {
        let wrong = |problem: String| WriteError::Template { template: name, line: row + 1, problem };
        let start = text.0.len();
        let mut whole = true;
        let mut rest = line;
        while let Some(at) = rest.find(['{', '}']) {
            text.word(&rest[..at]);
            let brace = &rest[at..=at];
            rest = &rest[at + 1..];
            if let Some(after) = rest.strip_prefix(brace) {
                text.word(brace);
                rest = after;
                continue;
            }
            let (key, after) = match rest.split_once('}') {
                Some(split) if brace == "{" => split,
                _ => return Err(wrong(format!("a single `{brace}`; write `{brace}{brace}` for the character"))),
            };
            let known = || values.iter().map(|value| value.0).collect::<Vec<_>>().join(", ");
            match values.iter().find(|value| value.0 == key) {
                Some(&(_, Some(value), decimals)) => _ = text.number("", value, decimals),
                Some((_, None, _)) => whole = false,
                None => return Err(wrong(format!("`{{{key}}}` is not one of {}", known()))),
            }
            rest = after;
        }
        text.word(rest);
        if text.0.len() - start > LONGEST_LINE {
            return Err(wrong(format!("longer than {LONGEST_LINE} bytes")));
        }
        if whole {
            text.word("\n");
            lines += 1;
        } else {
            text.0.truncate(start);
        }
    }
    Ok(lines)
}
