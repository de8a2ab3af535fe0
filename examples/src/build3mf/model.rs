//! The model part: the mesh as an object, and the resource of the toolpath.

use super::names::{CORE, OURS, PRODUCTION, TOOLPATH, layer_part, name_of};
use super::options::BuildOptions;
use super::package::HEAD;
use super::profile::{Measured, Measures, Range};
use super::uuid::Content;
use super::{SegmentKind, UNIT_FACTOR_MM, WriteBuildError};
use crate::mesh::Mesh;
use std::io::Write;

/// Resources of the model.
const TOOLPATH_ID: u32 = 1;
const OBJECT_ID: u32 = 2;

/// UUIDs of the build.
pub(super) struct Names {
    pub(super) item: String,
    pub(super) profiles: Vec<String>,
    content: Content,
}

impl Names {
    pub(super) fn new(content: Content, measures: &Measures) -> Self {
        let profiles = measures.kinds().filter_map(|(kind, _)| name_of(kind)).map(|name| content.uuid(name)).collect();
        Names { item: content.uuid("item"), profiles, content }
    }
}

/// Writes the model. `layers` has the number of the layer of each part, from 0.
pub(super) fn write(
    mesh: &Mesh,
    measures: &Measures,
    names: &Names,
    layers: &[u32],
    options: &BuildOptions,
    out: &mut impl Write,
) -> Result<(), WriteBuildError> {
    let uuid = |of: &str| names.content.uuid(of);
    // A consumer that does not know our words would lay beads on travels.
    let required = if options.travels { "p tp n" } else { "p tp" };
    writeln!(out, "{HEAD}\n<model unit=\"millimeter\" xml:lang=\"en-US\" xmlns=\"{CORE}\" xmlns:p=\"{PRODUCTION}\"")?;
    writeln!(out, " xmlns:tp=\"{TOOLPATH}\" xmlns:n=\"{OURS}\" requiredextensions=\"{required}\">")?;
    let name = escaped(options.name);
    writeln!(out, "<metadata name=\"Title\">{name}</metadata>")?;
    writeln!(out, "<metadata name=\"Application\">curvlay {}</metadata>", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "<resources>\n<tp:toolpathresource id=\"{TOOLPATH_ID}\" uuid=\"{}\"", uuid("toolpath"))?;
    writeln!(out, " unitfactor=\"{UNIT_FACTOR_MM}\" toolpathtype=\"6axis\">\n<tp:toolpathprofiles>")?;
    for ((kind, measured), uuid) in measures.kinds().zip(&names.profiles) {
        profile(kind, measured, uuid, out)?;
    }
    writeln!(out, "</tp:toolpathprofiles>\n<tp:toolpathlayers>")?;
    for (part, layer) in layers.iter().enumerate() {
        writeln!(out, "<tp:toolpathlayer path=\"{}\" n:layer=\"{}\"/>", layer_part(part), u64::from(*layer) + 1)?;
    }
    writeln!(out, "</tp:toolpathlayers>\n</tp:toolpathresource>")?;
    writeln!(out, "<object id=\"{OBJECT_ID}\" type=\"model\" name=\"{name}\" p:UUID=\"{}\">", uuid("object"))?;
    object(mesh, out)?;
    writeln!(out, "</object>\n</resources>\n<build p:UUID=\"{}\" tp:toolpathid=\"{TOOLPATH_ID}\">", uuid("build"))?;
    writeln!(out, "<item objectid=\"{OBJECT_ID}\" p:UUID=\"{}\"/>\n</build>\n</model>", names.item)?;
    Ok(())
}

/// The triangles, every digit of their corners.
fn object(mesh: &Mesh, out: &mut impl Write) -> Result<(), WriteBuildError> {
    writeln!(out, "<mesh>\n<vertices>")?;
    for at in &mesh.vertices {
        writeln!(out, "<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", at.x, at.y, at.z)?;
    }
    writeln!(out, "</vertices>\n<triangles>")?;
    for [a, b, c] in &mesh.triangles {
        writeln!(out, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>")?;
    }
    writeln!(out, "</triangles>\n</mesh>")?;
    Ok(())
}

/// A profile: of each number its greatest value, and a modifier where lines vary it.
fn profile(kind: SegmentKind, measured: &Measured, uuid: &str, out: &mut impl Write) -> Result<(), WriteBuildError> {
    let name = name_of(kind).unwrap_or_default();
    let speed = if kind == SegmentKind::Travel { "jumpspeed" } else { "depositionspeed" };
    let numbers = [
        ("beadwidth", measured.width(), "linear", "e"),
        ("beadheight", measured.height(), "linear", "f"),
        (speed, measured.speed(), "constant", "g"),
    ];
    write!(out, "<tp:toolpathprofile uuid=\"{uuid}\" name=\"{name}\" n:kind=\"{name}\"")?;
    for (attribute, range, ..) in &numbers {
        if let Some(Range { max, .. }) = range {
            write!(out, " {attribute}=\"{max}\"")?;
        }
    }
    writeln!(out, ">")?;
    for (attribute, range, kind, factor) in numbers {
        if let Some(Range { min, max }) = range.filter(Range::varies) {
            write!(out, "<tp:modifier attribute=\"{attribute}\" type=\"{kind}\" factor=\"{factor}\"")?;
            writeln!(out, " minvalue=\"{min}\" maxvalue=\"{max}\"/>")?;
        }
    }
    writeln!(out, "</tp:toolpathprofile>")?;
    Ok(())
}

/// Text as XML has it, without characters that XML does not have.
fn escaped(text: &str) -> String {
    let mut all = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => all.push_str("&amp;"),
            '<' => all.push_str("&lt;"),
            '>' => all.push_str("&gt;"),
            '"' => all.push_str("&quot;"),
            '\t' | '\n' | '\r' => all.push(' '),
            '\u{fffe}' | '\u{ffff}' => all.push('\u{fffd}'),
            c if c < ' ' => all.push('\u{fffd}'),
            c => all.push(c),
        }
    }
    all
}
