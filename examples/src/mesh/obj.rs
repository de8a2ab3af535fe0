//! Wavefront OBJ: its vertices and faces, and where groups and objects begin. Everything else in it (normals, textures, lines) is passed over.

use super::fault::{MeshFault, Place, finite, quoted, syntax, three_numbers, unmarked};
use super::weld::Welder;

pub(super) fn parse(bytes: &[u8]) -> Result<Welder, MeshFault> {
    let text = String::from_utf8_lossy(unmarked(bytes)?);
    let mut welder = Welder::default();
    // OBJ counts vertices in the order of the file; `ids` leads from there to the welded ones.
    let mut ids = Vec::new();
    let mut polygon = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((i, line)) = lines.next() {
        let place = Place::Line(i + 1);
        let mut joined = without_comment(line).to_owned();
        // A line that ends in a backslash goes on in the next one; a comment ends with its line.
        while joined.ends_with('\\') {
            joined.pop();
            joined.push(' ');
            joined.push_str(lines.next().map_or("", |(_, more)| without_comment(more)));
        }
        let mut words = joined.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let p = finite(three_numbers(&mut words, place)?, place, ids.len() + 1)?;
                ids.push(welder.vertex(p)?);
            }
            Some("f") => {
                polygon.clear();
                for word in words {
                    polygon.push(ids[corner(word, ids.len(), place)?]);
                }
                welder.polygon(&polygon, place);
            }
            Some("g" | "o") => welder.group(&words.collect::<Vec<_>>().join(" ")),
            _ => {}
        }
    }
    Ok(welder)
}

/// A line up to its comment, without blanks at the end.
fn without_comment(line: &str) -> &str {
    line.split('#').next().unwrap_or("").trim_end()
}

/// The vertex that a corner such as `7`, `7/1/2`, `7//2` or `-1` (the last one so far) names, counted from 0.
fn corner(word: &str, known: usize, place: Place) -> Result<usize, MeshFault> {
    let number = word.split('/').next().unwrap_or("");
    let index: i64 =
        number.parse().map_err(|_| syntax(place, format!("{} is not the number of a vertex", quoted(word))))?;
    let from_zero =
        if index < 0 { i64::try_from(known).ok().and_then(|n| n.checked_add(index)) } else { Some(index - 1) };
    from_zero
        .and_then(|v| usize::try_from(v).ok())
        .filter(|&v| v < known)
        .ok_or_else(|| syntax(place, format!("a face names vertex {index} of {known}")))
}
