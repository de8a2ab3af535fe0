//! Words of a line of G-code: letters with numbers.

/// Longest line, in bytes: beyond it the file is of another kind.
pub const LONGEST_LINE: usize = 16 * 1024;

/// The words of a line, and its comment behind `;`.
///
/// # Errors
/// What is wrong at which column, from 1.
pub fn words(line: &str, found: &mut Vec<(char, f64)>) -> Result<Option<String>, (usize, String)> {
    found.clear();
    let bytes = line.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        match bytes[at] {
            b' ' | b'\t' | b'\r' | b'%' | b'/' => at += 1,
            b';' => return Ok(Some(line[at + 1..].trim().to_owned())),
            // A checksum: readers of machines check it, the line is what it is.
            b'*' => break,
            b'(' => {
                let close = bytes[at..].iter().position(|byte| *byte == b')');
                at += close.ok_or_else(|| (at + 1, "a comment without its `)`".to_owned()))? + 1;
            }
            letter if letter.is_ascii_alphabetic() => {
                let (value, next) = number(bytes, at + 1);
                let value = value.ok_or_else(|| (at + 2, format!("a number behind `{}`", char::from(letter))))?;
                found.push((char::from(letter.to_ascii_uppercase()), value));
                at = next;
            }
            _ => {
                let what = line[at..].chars().next().unwrap_or('?');
                return Err((at + 1, format!("a letter instead of `{what}`")));
            }
        }
    }
    Ok(None)
}

/// The decimal number at a place, and where it ends.
fn number(bytes: &[u8], mut at: usize) -> (Option<f64>, usize) {
    while matches!(bytes.get(at), Some(b' ' | b'\t')) {
        at += 1;
    }
    let begin = at;
    while matches!(bytes.get(at), Some(b'0'..=b'9' | b'.' | b'+' | b'-')) {
        at += 1;
    }
    let text = std::str::from_utf8(&bytes[begin..at]).unwrap_or("");
    (text.parse::<f64>().ok().filter(|value| value.abs() <= 1e9), at)
}
