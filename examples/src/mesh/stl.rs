//! STL: binary when the length is what the count in its header calls for, whatever the header says; else ASCII.

use super::{Mesh, MeshFault, Place, Welder, finite, quoted, syntax, three_numbers, unmarked};

/// Header and count.
const HEAD: usize = 84;
/// Normal, three corners, and two bytes that nobody agrees on.
pub(super) const TRIANGLE: usize = 50;

pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, MeshFault> {
    let count = bytes.get(HEAD - 4..HEAD).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]));
    let expected = count.map(|n| HEAD as u64 + TRIANGLE as u64 * u64::from(n));
    if expected == Some(bytes.len() as u64) {
        return binary(bytes);
    }
    let text = match unmarked(bytes) {
        // Of two bytes a character one is zero; else the mark is only how a binary file begins.
        Err(wide) if bytes.get(2..4).is_some_and(|first| first.contains(&0)) => return Err(wide),
        text => text.unwrap_or(bytes),
    };
    let solid = text.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    match (count, expected) {
        _ if solid && !bytes.contains(&0) => ascii(text),
        (Some(triangles), Some(expected)) if bytes.contains(&0) => {
            Err(MeshFault::Length { triangles, expected, bytes: bytes.len() as u64 })
        }
        _ => Err(MeshFault::NotStl),
    }
}

fn binary(bytes: &[u8]) -> Result<Mesh, MeshFault> {
    let mut welder = Welder::default();
    for (i, facet) in bytes[HEAD..].chunks_exact(TRIANGLE).enumerate() {
        let place = Place::Triangle(i + 1, (HEAD + TRIANGLE * i) as u64);
        let mut corners = [0; 3];
        for (k, corner) in corners.iter_mut().enumerate() {
            let number = |axis: usize| {
                let at = 12 * (k + 1) + 4 * axis;
                f64::from(f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]]))
            };
            *corner = welder.vertex(finite([number(0), number(1), number(2)], place, k + 1)?)?;
        }
        welder.mesh.triangles.push(corners);
    }
    Ok(welder.mesh)
}

/// `solid` and a name, then facets of three corners, then `endsolid`; several such parts may follow one another. Where
/// the lines end does not matter but behind the names. Normals are not looked at.
fn ascii(bytes: &[u8]) -> Result<Mesh, MeshFault> {
    let text = String::from_utf8_lossy(bytes);
    let mut welder = Welder::default();
    let mut corners = Vec::new();
    let (mut open, mut last) = (false, 0);
    let mut in_line: Vec<&str> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let place = Place::Line(i + 1);
        in_line.clear();
        in_line.extend(line.split_ascii_whitespace());
        let mut words = in_line.iter();
        while let Some(word) = words.next() {
            last = i + 1;
            match word.to_ascii_lowercase().as_str() {
                "vertex" => {
                    let p = three_numbers(&mut words.by_ref().copied(), place)?;
                    corners.push(welder.vertex(finite(p, place, corners.len() + 1)?)?);
                }
                "endfacet" if corners.len() == 3 => {
                    welder.polygon(&corners);
                    corners.clear();
                }
                "endfacet" => return Err(syntax(place, format!("the facet has {} corners, not 3", corners.len()))),
                "solid" if open => return Err(syntax(place, "`solid` before the `endsolid` of the part before")),
                "solid" => {
                    open = true;
                    words = from_facet(words.as_slice()).iter();
                }
                "endsolid" if !from_facet(words.as_slice()).is_empty() => {
                    return Err(syntax(
                        place,
                        "facets behind `endsolid`: the next part must begin in a line of its own",
                    ));
                }
                "endsolid" => {
                    open = false;
                    words = [].iter();
                }
                "facet" if !corners.is_empty() => {
                    return Err(syntax(place, "`facet` before the `endfacet` of the last"));
                }
                // The normal, whatever its numbers are.
                "facet" => {
                    let rest = words.as_slice();
                    let keyword = |word: &&str| {
                        ["outer", "vertex", "endfacet"].iter().any(|known| word.eq_ignore_ascii_case(known))
                    };
                    words = rest[rest.iter().position(keyword).unwrap_or(rest.len())..].iter();
                }
                "outer" | "loop" | "endloop" => {}
                _ => return Err(syntax(place, format!("{} has no place in an STL file", quoted(word)))),
            }
        }
    }
    if open {
        return Err(syntax(Place::Line(last), "the file ends before `endsolid`: cut short"));
    }
    Ok(welder.mesh)
}

/// What follows the name of a part in its line: from the first `facet normal` on.
fn from_facet<'a, 'b>(words: &'b [&'a str]) -> &'b [&'a str] {
    let starts = |pair: &[&str]| pair[0].eq_ignore_ascii_case("facet") && pair[1].eq_ignore_ascii_case("normal");
    &words[words.windows(2).position(starts).unwrap_or(words.len())..]
}
