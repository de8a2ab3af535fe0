//! Waypoints from a file: six numbers a line, a place in millimetres and a direction.

use crate::input;
use crate::outcome::Failure;
use std::fmt::Display;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// Longest line of a file in bytes, and the most waypoints: beyond them it is another kind of file.
const LONGEST_LINE: u64 = 4096;
const MAX_WAYPOINTS: usize = 200_000;

/// A line of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Its number, from 1.
    pub number: u64,
    /// `px py pz nx ny nz`; not always finite.
    pub values: [f64; 6],
}

/// What is wrong with a file, as one line that names it.
pub fn fault(path: &Path, what: &dyn Display) -> Failure {
    Failure::new(format!("{}: {what}", path.display()))
}

/// Reads the lines of a file, with blanks, tabs or commas between the numbers. Empty lines and a head in words are
/// passed over.
///
/// # Errors
/// A [`Failure`] that names the file and the line.
pub fn read_waypoints(path: &Path) -> Result<Vec<Line>, Failure> {
    let failed = |what: &dyn Display| fault(path, what);
    let mut reader = BufReader::new(input::open(path, input::MAX_TEXT_BYTES)?);
    let (mut lines, mut bytes, mut number) = (Vec::new(), Vec::new(), 0u64);
    loop {
        bytes.clear();
        let read = reader.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes).map_err(|error| failed(&error))?;
        if read == 0 {
            break;
        }
        number += 1;
        if read as u64 == LONGEST_LINE {
            return Err(failed(&format!("line {number} is longer than {LONGEST_LINE} bytes")));
        }
        let text = String::from_utf8_lossy(&bytes);
        let text = text.trim();
        if text.is_empty() {
            continue;
        }
        let cells = text.split([' ', '\t', ',']).filter(|cell| !cell.is_empty());
        let values: Option<Vec<f64>> = cells.map(|cell| cell.parse().ok()).collect();
        let Some(values) = values.and_then(|values| values.try_into().ok()) else {
            // A head in words.
            if number == 1 && text.starts_with(|c: char| c.is_ascii_alphabetic()) {
                continue;
            }
            return Err(failed(&format!("line {number} must be six numbers `px py pz nx ny nz`")));
        };
        if lines.len() == MAX_WAYPOINTS {
            return Err(failed(&format!("more than {MAX_WAYPOINTS} waypoints")));
        }
        lines.push(Line { number, values });
    }
    if lines.is_empty() { Err(failed(&"there are no waypoints in it")) } else { Ok(lines) }
}
