//! PLY, ASCII or binary, through `ply-rs-bw`; its header counts are held against the size of the file. Faces and strips of
//! triangles are read.

use super::fault::{MeshFault, Place, finite, printable, quoted, syntax, unmarked};
use super::weld::Welder;
use crate::count::counted;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType};
use std::io::Cursor;

pub(super) fn parse(bytes: &[u8]) -> Result<Welder, MeshFault> {
    let whole = bytes.len();
    let bytes = unmarked(bytes)?;
    // Places are those in the file.
    let mark = (whole - bytes.len()) as u64;
    let parser = Parser::<Element>::new();
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = match parser.read_header(&mut reader) {
        Ok(header) => header,
        Err(error) => return Err(syntax(Place::Line(error.line().unwrap_or(1)), one_line(&error))),
    };
    check_header(&header, bytes.len() - reader.get_ref().position() as usize)?;
    let ascii = header.encoding == Encoding::Ascii;
    let mut welder = Welder::default();
    let mut ids = Vec::new();
    for def in header.elements.values() {
        let start = if ascii { Place::Line(reader.line()) } else { Place::Byte(mark + reader.get_ref().position()) };
        let elements = match parser.read_payload_for_element(&mut reader, def, &header) {
            Ok(elements) => elements,
            Err(error) => {
                return Err(match error.line() {
                    Some(line) if ascii => syntax(Place::Line(line), with_text(&error, bytes, line)),
                    _ => syntax(Place::Byte(mark + reader.get_ref().position()), one_line(&error)),
                });
            }
        };
        // In an ASCII file each element is a line; in a binary one the start of its list has to do.
        let place = |i: usize| match start {
            Place::Line(line) => Place::Line(line + i),
            other => other,
        };
        match def.name.as_str() {
            "vertex" => {
                for (i, vertex) in elements.iter().enumerate() {
                    ids.push(welder.vertex(finite(vertex.position, place(i), i + 1)?)?);
                }
            }
            "face" | STRIPS => {
                for (i, face) in elements.iter().enumerate() {
                    add_face(&mut welder, &ids, &def.name, (i + 1, &face.corners), place(i))?;
                }
            }
            _ => {}
        }
    }
    Ok(welder)
}

/// Adds a face, or strips of triangles, by the numbers of its vertices from 0.
fn add_face(
    welder: &mut Welder,
    ids: &[u32],
    name: &str,
    (number, corners): (usize, &[i64]),
    place: Place,
) -> Result<(), MeshFault> {
    let corner = |&v: &i64| {
        usize::try_from(v).ok().and_then(|v| ids.get(v).copied()).ok_or_else(|| {
            let what = name.trim_end_matches('s');
            syntax(place, format!("{what} {number} names vertex {v} (from 0) of {}", ids.len()))
        })
    };
    if name != STRIPS {
        let corners = corners.iter().map(corner).collect::<Result<Vec<_>, _>>()?;
        welder.polygon(&corners, place);
        return Ok(());
    }
    // A corner of -1 ends a strip.
    for strip in corners.split(|&v| v == -1) {
        let corners = strip.iter().map(corner).collect::<Result<Vec<_>, _>>()?;
        add_strip(welder, &corners, place);
    }
    Ok(())
}

/// Adds a strip of triangles: each corner from the third on makes one with the two before, every second one turned. Corners
/// that repeat only steer the strip.
fn add_strip(welder: &mut Welder, corners: &[u32], place: Place) {
    for (k, &[a, b, c]) in corners.array_windows::<3>().enumerate() {
        if a != b && b != c && c != a {
            welder.polygon(&if k % 2 == 0 { [a, b, c] } else { [b, a, c] }, place);
        }
    }
}

/// Holds the header against what we need and what the rest of the file can hold.
fn check_header(header: &Header, bytes_left: usize) -> Result<(), MeshFault> {
    let in_header = |what: String| syntax(Place::Line(1), what);
    for def in header.elements.values() {
        // Every element takes a byte at least, so a larger count is a lie.
        if def.count > bytes_left {
            let what = format!(
                "the header promises {} of {} in {}",
                def.count,
                quoted(&def.name),
                counted(bytes_left, "byte")
            );
            return Err(in_header(what));
        }
        if def.properties.is_empty() && def.count > 0 {
            return Err(in_header(format!("the header gives {} no properties", quoted(&def.name))));
        }
    }
    let kind = |element: &str, property: &str| {
        header.elements.get(element).and_then(|def| def.properties.get(property)).map(|def| &def.data_type)
    };
    for axis in ["x", "y", "z"] {
        if !matches!(kind("vertex", axis), Some(PropertyType::Scalar(_))) {
            return Err(in_header(format!("the header has no number `{axis}` of `vertex`")));
        }
    }
    let count = |element: &str| header.elements.get(element).map_or(0, |def| def.count);
    if count("face") == 0 && count(STRIPS) == 0 && count("vertex") > 0 {
        return Err(MeshFault::PointCloud { points: count("vertex") });
    }
    let element = if count("face") > 0 { "face" } else { STRIPS };
    let corners = CORNERS.iter().find_map(|name| kind(element, name));
    if !matches!(corners, Some(PropertyType::List(_, item)) if ![ScalarType::Float, ScalarType::Double].contains(item))
    {
        return Err(in_header(format!("the header has no list of whole numbers `vertex_indices` of `{element}`")));
    }
    let order = |name| header.elements.get_index_of(name);
    if order(element) < order("vertex") {
        return Err(in_header("faces before vertices cannot be read".to_owned()));
    }
    Ok(())
}

/// The element that holds strips.
const STRIPS: &str = "tristrips";

/// Both names are about.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// What the parser says, without its line breaks and the line number that we give ourselves.
fn one_line(error: &ParseError) -> String {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default();
    let first = first.split_once(": ").filter(|(line, _)| line.starts_with("Line ")).map_or(first, |(_, what)| what);
    printable(first.trim_end_matches('.'), 120)
}

/// The same, and what stands in the line.
fn with_text(error: &ParseError, bytes: &[u8], line: usize) -> String {
    let text = String::from_utf8_lossy(bytes);
    let found = text.lines().nth(line.saturating_sub(1)).map_or_else(String::new, |text| format!(": {}", quoted(text)));
    one_line(error) + &found
}

/// A vertex or a face, whichever the properties fill.
struct Element {
    position: [f64; 3],
    corners: Vec<i64>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Element { position: [0.0; 3], corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if let Some(axis) = ["x", "y", "z"].iter().position(|&axis| axis == name) {
            self.position[axis] = match property {
                Property::Char(v) => f64::from(v),
                Property::UChar(v) => f64::from(v),
                Property::Short(v) => f64::from(v),
                Property::UShort(v) => f64::from(v),
                Property::Int(v) => f64::from(v),
                Property::UInt(v) => f64::from(v),
                Property::Float(v) => f64::from(v),
                Property::Double(v) => v,
                _ => return PropertyAccessResult::UnsupportedType,
            };
            PropertyAccessResult::Set
        } else if CORNERS.contains(&name) {
            self.corners = match property {
                Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
                Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
                Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
                Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
                Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
                Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
                _ => return PropertyAccessResult::UnsupportedType,
            };
            PropertyAccessResult::Set
        } else {
            PropertyAccessResult::Ignored
        }
    }
}
