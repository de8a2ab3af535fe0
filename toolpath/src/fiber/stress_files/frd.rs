//! Results of CalculiX at nodes (`.frd`, as text).
//!
//! G. Dhondt, K. Wittig, "CalculiX GraphiX user's manual", section "Result format": a block `2C` has the nodes, a block `100C` a result, whose name
//! stands in the line `-4` after it; lines `-5` name its components, lines `-1` have a node and its values, `-2` more of them, `-3` ends a
//! block. Numbers stand in fixed columns (10 for a node, or 5 in the short format; 12 for a value) without blanks between them.

use super::{Lines, StressFileError, number, sample};
use crate::fiber::stress::StressSample;
use std::collections::BTreeMap;
use std::io::BufRead;

/// Columns of a value.
const VALUE: usize = 12;

/// The components that a stress must have, in this order.
const COMPONENTS: [&str; 6] = ["SXX", "SYY", "SZZ", "SXY", "SYZ", "SZX"];

/// Reads the last block `STRESS` of a file: the last step of an analysis.
///
/// # Errors
/// [`StressFileError`], with the line. Binary files are refused.
///
/// # Cost
/// `O(n log n)` for `n` nodes.
///
/// # Example
/// ```
/// use curvlay_toolpath::fiber::stress_files::read_stress_frd;
/// let file = "    2C                             1                                     1
///  -1         7 1.00000E+00 2.00000E+00 3.00000E+00
///  -3
///   100CL  101 1.000000000           1                     0    1           1
///  -4  STRESS      6    1
///  -5  SXX         1    4    1    1
///  -5  SYY         1    4    2    2
///  -5  SZZ         1    4    3    3
///  -5  SXY         1    4    1    2
///  -5  SYZ         1    4    2    3
///  -5  SZX         1    4    3    1
///  -1         7 1.00000E+01-2.00000E+01 3.00000E+01 4.00000E+00 5.00000E+00 6.00000E+00
///  -3
///  9999
/// ";
/// let samples = read_stress_frd(file.as_bytes())?;
/// assert_eq!((samples[0].point.y, samples[0].stress[(1, 1)], samples[0].stress[(0, 2)]), (2.0, -20.0, 6.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_stress_frd(input: impl BufRead) -> Result<Vec<StressSample>, StressFileError> {
    let mut lines = Lines::new(input);
    let mut nodes: BTreeMap<u64, [f64; 3]> = BTreeMap::new();
    let mut stresses: Option<Vec<(u64, u64, [f64; 6])>> = None;
    while let Some(text) = lines.next()? {
        let head = text.trim_start();
        if head.starts_with("2C") {
            let width = node_width(text);
            let width = width.ok_or_else(|| unreadable(&lines))?;
            read_nodes(&mut lines, width, &mut nodes)?;
        } else if head.starts_with("100C") {
            let width = node_width(text);
            let width = width.ok_or_else(|| unreadable(&lines))?;
            if let Some(found) = read_result(&mut lines, width)? {
                stresses = Some(found);
            }
        } else if head.starts_with("9999") {
            break;
        }
    }
    let no_stress = StressFileError::NoStress { expected: "it has no block STRESS of results at nodes" };
    let stresses = stresses.filter(|found| !found.is_empty()).ok_or(no_stress)?;
    let place = |(line, node, six): (u64, u64, [f64; 6])| {
        let unknown = || StressFileError::Unexpected { line, expected: "a node of the file", found: node.to_string() };
        Ok(sample(*nodes.get(&node).ok_or_else(unknown)?, six))
    };
    stresses.into_iter().map(place).collect()
}

/// Columns of a node, by the format at the end of the line that begins a block: 0 is short, 1 is long; others are binary.
fn node_width(text: &str) -> Option<usize> {
    match text.split_whitespace().last() {
        Some("0") => Some(5),
        Some("1") => Some(10),
        _ => None,
    }
}

fn unreadable<R: BufRead>(lines: &Lines<R>) -> StressFileError {
    lines.unexpected("a block of text (format 0 or 1 at the end of the line)", lines.text.trim())
}

/// The node and the values of a line, from `from` on.
fn fields(line: u64, text: &str, from: usize, wanted: usize) -> Result<Vec<f64>, StressFileError> {
    let bytes = text.trim_end().as_bytes();
    let columns = bytes.get(from..).unwrap_or_default().chunks(VALUE);
    if columns.len() != wanted {
        return Err(StressFileError::Columns { line, found: columns.len(), wanted });
    }
    columns.map(|column| number(line, &String::from_utf8_lossy(column))).collect()
}

fn node_of<R: BufRead>(lines: &Lines<R>, text: &str, width: usize) -> Result<u64, StressFileError> {
    let column = text.get(3..3 + width).unwrap_or_default();
    column.trim().parse().map_err(|_| lines.unexpected("the number of a node", column))
}

fn read_nodes<R: BufRead>(
    lines: &mut Lines<R>,
    width: usize,
    nodes: &mut BTreeMap<u64, [f64; 3]>,
) -> Result<(), StressFileError> {
    loop {
        let Some(text) = lines.next()?.map(str::to_owned) else {
            return Err(lines.ends("the end -3 of the block of nodes"));
        };
        if text.starts_with(" -3") {
            return Ok(());
        }
        if !text.starts_with(" -1") {
            return Err(lines.unexpected("a node (-1) or the end of the block (-3)", &text));
        }
        let node = node_of(lines, &text, width)?;
        let place = fields(lines.line, &text, 3 + width, 3)?;
        nodes.insert(node, [place[0], place[1], place[2]]);
    }
}

/// The values of a result if it is a stress, each with its line and node.
#[allow(clippy::type_complexity)] // a line of its own would say no more
fn read_result<R: BufRead>(
    lines: &mut Lines<R>,
    width: usize,
) -> Result<Option<Vec<(u64, u64, [f64; 6])>>, StressFileError> {
    let (mut is_stress, mut components, mut found) = (false, Vec::new(), Vec::new());
    loop {
        let Some(text) = lines.next()?.map(str::to_owned) else {
            return Err(lines.ends("the end -3 of a block of results"));
        };
        let key = text.get(..3).unwrap_or_default();
        match key {
            " -3" => return Ok(is_stress.then_some(found)),
            " -4" => is_stress = text.split_whitespace().nth(1) == Some("STRESS"),
            " -5" => components.push(text.split_whitespace().nth(1).unwrap_or_default().to_owned()),
            " -1" | " -2" if !is_stress => {}
            " -1" => {
                if components.iter().take(6).ne(COMPONENTS.iter()) {
                    let names = components.join(" ");
                    return Err(lines.unexpected("components SXX SYY SZZ SXY SYZ SZX before the first node", &names));
                }
                let node = node_of(lines, &text, width)?;
                let six = fields(lines.line, &text, 3 + width, 6)?;
                found.push((lines.line, node, [six[0], six[1], six[2], six[3], six[4], six[5]]));
            }
            _ => return Err(lines.unexpected("a line -1 to -5 of a block of results", &text)),
        }
    }
}
