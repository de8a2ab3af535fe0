//! STL, binary or ASCII, whatever the header says. The length of a binary file decides how many triangles it has.

use super::fault::{MeshFault, Place, finite, quoted, syntax, three_numbers, unmarked};
use super::weld::Welder;

/// Header and count.
const HEAD: usize = 84;
/// Normal, three corners, and two bytes whose meaning differs from program to program.
const TRIANGLE: usize = 50;

pub(super) fn parse(bytes: &[u8]) -> Result<Welder, MeshFault> {
    let count = bytes.get(HEAD - 4..HEAD).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]));
    let expected = count.map(|n| HEAD as u64 + TRIANGLE as u64 * u64::from(n));
    if expected == Some(bytes.len() as u64) {
        return binary(&bytes[HEAD..], Welder::default());
    }
    let text = match unmarked(bytes) {
        // Of two bytes a character one is zero; else the mark is only how a binary file begins.
        Err(wide) if bytes.get(2..4).is_some_and(|first| first.contains(&0)) => return Err(wide),
        text => text.unwrap_or(bytes),
    };
    match (count, bytes.contains(&0)) {
        (_, false) if has_keyword(text) => ascii(text),
        (Some(count), true) => miscounted(bytes, count),
        _ => Err(MeshFault::NotStl),
    }
}

/// Whether a line begins as those of ASCII STL do.
fn has_keyword(text: &[u8]) -> bool {
    let lines = text.split(|&byte| byte == b'\n' || byte == b'\r');
    lines.map(<[u8]>::trim_ascii_start).any(|line| {
        let begins = |word: &[u8]| line.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
        begins(b"solid") || begins(b"facet")
    })
}

/// A binary file with another count than its length calls for: read by its length, unless it was cut short.
fn miscounted(bytes: &[u8], count: u32) -> Result<Welder, MeshFault> {
    let body = &bytes[HEAD..];
    let (fits, rest) = (body.len() / TRIANGLE, body.len() % TRIANGLE);
    let stated = u64::from(count);
    // A count of 0 or of 2^32 - 1 was never filled in; one too many is a slip that programs make.
    let no_count = count == 0 || count == u32::MAX || stated == fits as u64 + 1;
    let taken = match rest {
        0 if no_count => fits,
        0 if stated < fits as u64 && body[count as usize * TRIANGLE..].chunks_exact(TRIANGLE).all(is_facet) => fits,
        _ if count > 0 && stated <= fits as u64 => count as usize,
        _ => {
            let expected = HEAD as u64 + TRIANGLE as u64 * stated;
            return Err(MeshFault::Length { triangles: count, expected, bytes: bytes.len() as u64 });
        }
    };
    let mut welder = Welder::default();
    if taken as u64 != stated {
        let amount = format!("the header says {stated}, the length of the file {taken}");
        welder.note("the count of triangles in the file is wrong; its length decided", amount, "");
    }
    let behind = body.len() - taken * TRIANGLE;
    if behind > 0 {
        welder.note("bytes behind the last triangle were passed over", behind.to_string(), "");
    }
    binary(&body[..taken * TRIANGLE], welder)
}

/// Number `at` of a facet: three of the normal, then those of the corners.
fn number(facet: &[u8], at: usize) -> f64 {
    let bytes = &facet[4 * at..4 * at + 4];
    f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
}

/// Whether bytes are a facet and not a filling: finite corners, not all at one place.
fn is_facet(facet: &[u8]) -> bool {
    let corners = [1, 2, 3].map(|corner| [0, 1, 2].map(|axis| number(facet, 3 * corner + axis)));
    let place = |corner: [f64; 3]| corner.map(|c| (c + 0.0).to_bits());
    corners.as_flattened().iter().all(|c| c.is_finite())
        && corners.iter().any(|&corner| place(corner) != place(corners[0]))
}

fn binary(facets: &[u8], mut welder: Welder) -> Result<Welder, MeshFault> {
    for (i, facet) in facets.chunks_exact(TRIANGLE).enumerate() {
        let place = Place::Triangle(i + 1, (HEAD + TRIANGLE * i) as u64);
        let mut corners = [0; 3];
        for (k, corner) in corners.iter_mut().enumerate() {
            let p = [0, 1, 2].map(|axis| number(facet, 3 * (k + 1) + axis));
            *corner = welder.vertex(finite(p, place, k + 1)?)?;
        }
        welder.polygon(&corners, place);
    }
    Ok(welder)
}

/// `solid` and a name, then facets of three corners, then `endsolid`; several such parts may follow one another. Where
/// the lines end does not matter but behind the names. Normals are not looked at. Lines before the first `solid` or `facet` are
/// passed over, and the end may be missing behind a whole facet.
fn ascii(bytes: &[u8]) -> Result<Welder, MeshFault> {
    let text = String::from_utf8_lossy(bytes);
    let mut reader = AsciiReader::default();
    let mut in_line: Vec<&str> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        in_line.clear();
        in_line.extend(line.split_ascii_whitespace());
        if reader.has_started(&in_line) {
            reader.line(&in_line, i + 1)?;
        }
    }
    // `outer loop` or `facet` stand at the end of a file that was cut, `endfacet` of one without an end.
    let last_word = text.split_ascii_whitespace().next_back();
    reader.finish(last_word.is_some_and(|word| word.eq_ignore_ascii_case("endfacet")))
}

/// An ASCII file, read line by line.
#[derive(Default)]
struct AsciiReader {
    welder: Welder,
    /// Corners of the facet that is open.
    corners: Vec<u32>,
    /// Whether a part has begun and not ended.
    open: bool,
    /// The last line that was read.
    last: usize,
    started: bool,
    passed_over: usize,
}

impl AsciiReader {
    /// Whether this line is read: from the first `solid` or `facet` on all are. Counts the lines before that have words.
    fn has_started(&mut self, in_line: &[&str]) -> bool {
        let keyword = |word: &&str| word.eq_ignore_ascii_case("solid") || word.eq_ignore_ascii_case("facet");
        if !self.started && !in_line.is_empty() {
            self.started = in_line.first().is_some_and(keyword);
            self.passed_over += usize::from(!self.started);
        }
        self.started
    }

    /// Reads the words of a line, which has its number from 1.
    fn line(&mut self, in_line: &[&str], number: usize) -> Result<(), MeshFault> {
        let place = Place::Line(number);
        let mut words = in_line.iter();
        while let Some(word) = words.next() {
            self.last = number;
            match word.to_ascii_lowercase().as_str() {
                "vertex" => {
                    let p = three_numbers(&mut words.by_ref().copied(), place)?;
                    self.corners.push(self.welder.vertex(finite(p, place, self.corners.len() + 1)?)?);
                }
                "endfacet" => self.end_facet(place)?,
                "solid" => {
                    self.begin_part(place)?;
                    words = from_facet(words.as_slice()).iter();
                }
                "endsolid" if !from_facet(words.as_slice()).is_empty() => {
                    return Err(syntax(
                        place,
                        "facets behind `endsolid`: the next part must begin in a line of its own",
                    ));
                }
                "endsolid" => {
                    self.open = false;
                    words = [].iter();
                }
                "facet" if !self.corners.is_empty() => {
                    return Err(syntax(place, "`facet` before the `endfacet` of the last"));
                }
                // The normal, whatever its numbers are.
                "facet" => words = after_normal(words.as_slice()).iter(),
                "outer" | "loop" | "endloop" => {}
                _ => return Err(syntax(place, format!("{} has no place in an STL file", quoted(word)))),
            }
        }
        Ok(())
    }

    /// `endfacet`
    fn end_facet(&mut self, place: Place) -> Result<(), MeshFault> {
        if self.corners.len() != 3 {
            return Err(syntax(place, format!("the facet has {} corners, not 3", self.corners.len())));
        }
        self.welder.polygon(&self.corners, place);
        self.corners.clear();
        Ok(())
    }

    /// `solid`
    fn begin_part(&mut self, place: Place) -> Result<(), MeshFault> {
        if !self.corners.is_empty() {
            return Err(syntax(place, "`solid` before the `endfacet` of the last facet"));
        }
        if self.open {
            self.welder.note("a part of the file has no `endsolid`", "", place.to_string());
        }
        self.open = true;
        Ok(())
    }

    /// Whether the file is whole, and what was made of it.
    fn finish(self, ends_with_endfacet: bool) -> Result<Welder, MeshFault> {
        let AsciiReader { mut welder, corners, open, last, passed_over, .. } = self;
        let ends_whole = ends_with_endfacet && corners.is_empty();
        if open && !ends_whole && !welder.mesh.triangles.is_empty() || !corners.is_empty() {
            return Err(syntax(Place::Line(last), "the file ends within a facet: cut short"));
        }
        if open && ends_whole {
            let what = "the file ends without `endsolid`: complete unless it was cut off there";
            welder.note(what, "", Place::Line(last).to_string());
        }
        if passed_over > 0 {
            welder.note("lines before `solid` were passed over", passed_over.to_string(), "");
        }
        Ok(welder)
    }
}

/// What follows the normal of a facet in its line.
fn after_normal<'a, 'b>(words: &'b [&'a str]) -> &'b [&'a str] {
    let keyword = |word: &&str| ["outer", "vertex", "endfacet"].iter().any(|known| word.eq_ignore_ascii_case(known));
    &words[words.iter().position(keyword).unwrap_or(words.len())..]
}

/// What follows the name of a part in its line: from the first `facet normal` on.
fn from_facet<'a, 'b>(words: &'b [&'a str]) -> &'b [&'a str] {
    let starts = |pair: &[&str]| pair[0].eq_ignore_ascii_case("facet") && pair[1].eq_ignore_ascii_case("normal");
    &words[words.windows(2).position(starts).unwrap_or(words.len())..]
}
