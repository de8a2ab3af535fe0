//! Texts with names in braces: filled in on the way out, and taken apart on the way in.

use crate::gcode::text::Text;

/// A value that a text may ask for.
#[derive(Clone, Debug)]
pub(super) enum Value {
    /// A name.
    Text(String),
    /// A number, to so many digits.
    Number(f64, usize),
    /// Known, but not set: the line is left out.
    Unset,
}

pub(super) type Values<'a> = [(&'static str, Value)];

/// Part of a line.
enum Piece<'a> {
    Text(&'a str),
    Brace(&'a str),
    Name(&'a str),
}

/// The parts of a line, or what is wrong with it.
fn pieces(line: &str) -> impl Iterator<Item = Result<Piece<'_>, String>> {
    let mut rest = line;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let at = rest.find(['{', '}']).unwrap_or(rest.len());
        if at > 0 {
            let (text, after) = rest.split_at(at);
            rest = after;
            return Some(Ok(Piece::Text(text)));
        }
        let (brace, after) = rest.split_at(1);
        if let Some(after) = after.strip_prefix(brace) {
            rest = after;
            return Some(Ok(Piece::Brace(brace)));
        }
        match after.split_once('}') {
            Some((name, after)) if brace == "{" => {
                rest = after;
                Some(Ok(Piece::Name(name)))
            }
            _ => {
                rest = "";
                Some(Err(format!("a single `{brace}`; write `{brace}{brace}` for the character")))
            }
        }
    })
}

/// The line with its values, or `None` where one is not set.
pub(super) fn fill(line: &str, values: &Values<'_>) -> Result<Option<String>, String> {
    let mut text = Text::default();
    let mut whole = true;
    for piece in pieces(line) {
        match piece? {
            Piece::Text(part) | Piece::Brace(part) => _ = text.word(part),
            Piece::Name(name) => match values.iter().find(|(known, _)| *known == name) {
                Some((_, Value::Text(value))) => _ = text.word(value),
                Some(&(_, Value::Number(value, decimals))) => _ = text.number("", value, decimals),
                Some((_, Value::Unset)) => whole = false,
                None => {
                    let known: Vec<&str> = values.iter().map(|(known, _)| *known).collect();
                    let known = if known.is_empty() { "no name is known here".into() } else { known.join(", ") };
                    return Err(format!("`{{{name}}}` is not one of {known}"));
                }
            },
        }
    }
    Ok(whole.then(|| String::from_utf8_lossy(&text.0).into_owned()))
}

/// What stands in a line where a text has its first name, if the line is of that text; nothing for a text without a name. Spaces at both ends do not matter.
pub(super) fn value_in<'a>(line: &'a str, template: &str) -> Option<&'a str> {
    let mut rest = line.trim();
    let (mut found, mut waits) = (None, false);
    for piece in pieces(template.trim()) {
        match piece.ok()? {
            Piece::Text(part) | Piece::Brace(part) if waits => {
                let end = rest.find(part)?;
                found = found.or(Some(&rest[..end]));
                (rest, waits) = (&rest[end + part.len()..], false);
            }
            Piece::Text(part) | Piece::Brace(part) => rest = rest.strip_prefix(part)?,
            Piece::Name(_) => waits = true,
        }
    }
    if waits {
        return Some(found.unwrap_or(rest).trim());
    }
    rest.is_empty().then(|| found.unwrap_or("").trim())
}

/// The number that stands in a line where a text has its name; 0 for a text without one. `None` where the line is not of that text.
pub(super) fn number_in(line: &str, template: &str) -> Option<f64> {
    let value = value_in(line, template)?;
    if value.is_empty() && !template.contains('{') {
        return Some(0.0);
    }
    // What the standard library reads beside decimals (inf, 1e5) is no number of a file.
    let plain = value.bytes().all(|byte| byte.is_ascii_digit() || b"+-.".contains(&byte));
    if plain { value.parse().ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::{Value, fill, number_in};

    #[test]
    fn lines_are_filled_in_and_taken_apart() {
        let values = [("celsius", Value::Number(62.25, 1)), ("name", Value::Text("a".into())), ("bed", Value::Unset)];
        assert_eq!(fill("M68 E1 Q{celsius} ; {{x}} {name}", &values), Ok(Some("M68 E1 Q62.3 ; {x} a".into())));
        assert_eq!(fill("M140 S{bed}", &values), Ok(None));
        assert_eq!(fill("", &values), Ok(Some(String::new())));
        assert_eq!(fill("{fan}", &values), Err("`{fan}` is not one of celsius, name, bed".into()));
        assert_eq!(fill("a }", &[]), Err("a single `}`; write `}}` for the character".into()));
        assert_eq!(fill("{a", &[]), Err("a single `{`; write `{{` for the character".into()));
        assert_eq!(number_in("M68 E1 Q62.3", "M68 E1 Q{celsius}"), Some(62.3));
        assert_eq!(number_in(" G4 F2 H1", "G4 F{seconds} H1"), Some(2.0));
        assert_eq!(number_in("G28", "G28"), Some(0.0));
        assert_eq!(number_in("FUNCTION DWELL TIME -1.5", "FUNCTION DWELL TIME {seconds}"), Some(-1.5));
        for (line, template) in
            [("G28 X", "G28"), ("M68 E2 Q1", "M68 E1 Q{c}"), ("M104 Sx", "M104 S{c}"), ("M104 S", "M104 S{c}")]
        {
            assert_eq!(number_in(line, template), None, "{line}");
        }
    }
}
