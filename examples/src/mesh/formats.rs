//! What a file is, by its first bytes and whatever its name: formats that are read, and formats that can only be named.

use super::fault::MeshFault;

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Stl,
    Obj,
    Ply,
    ThreeMf,
}

/// What to do with a model in a format that is not read.
const EXPORT: &str = "export a mesh from the program that made it: STL, 3MF, OBJ or PLY";
/// What to do with an archive.
const UNPACK: &str = "unpack it first";

/// First bytes of formats that are not read, what they are, and what to do. Text is compared without regard to case.
const OTHERS: [(&[u8], &str, &str); 27] = [
    (b"iso-10303-21", "a STEP file (exact surfaces, no triangles)", EXPORT),
    (b"<amf", "an AMF file", EXPORT),
    (b"off\n", "an OFF file", EXPORT),
    (b"off\r", "an OFF file", EXPORT),
    (b"off ", "an OFF file", EXPORT),
    (b"coff", "an OFF file", EXPORT),
    (b"noff", "an OFF file", EXPORT),
    (b"#vrml", "a VRML file", EXPORT),
    (b"<x3d", "an X3D file", EXPORT),
    (b"<collada", "a COLLADA file", EXPORT),
    (b"gltf", "a binary glTF file", EXPORT),
    (b"kaydara fbx", "an FBX file", EXPORT),
    (b"blender", "a Blender project", EXPORT),
    (b"3d geometry file format", "a Rhino file", EXPORT),
    (b"**abcdefghijklmnopqrstuvwxyz", "a Parasolid file (exact surfaces, no triangles)", EXPORT),
    (b"\xd0\xcf\x11\xe0", "a project of a CAD program", EXPORT),
    (b"autocad binary dxf", "a DXF drawing", EXPORT),
    (b"<svg", "an SVG drawing", EXPORT),
    (b"\x1f\x8b", "a gzip archive", UNPACK),
    (b"\xfd7zxz", "an xz archive", UNPACK),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", UNPACK),
    (b"rar!", "a RAR archive", UNPACK),
    (b"<!doctype html", "a web page", "the download went wrong: fetch the file itself"),
    (b"<html", "a web page", "the download went wrong: fetch the file itself"),
    (b"version https://git-lfs", "a Git LFS pointer", "fetch the file that it stands for with `git lfs pull`"),
    (b"%pdf", "a PDF document", EXPORT),
    (b"\x89png", "a PNG picture", EXPORT),
];

/// The format by the content, where that is beyond doubt; else by the ending of the name.
///
/// # Errors
/// [`MeshFault::OtherFormat`] for what can only be named, [`MeshFault::UnknownEnding`] where nothing says what it is.
pub(super) fn recognise(bytes: &[u8], ending: Option<&str>) -> Result<Format, MeshFault> {
    if bytes.starts_with(b"PK\x03\x04") {
        return Ok(Format::ThreeMf);
    }
    // A binary STL file may begin with anything.
    let is_binary_stl = ending == Some("stl") && has_length_of_stl(bytes);
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let start = after_xml_head(start);
    let begins = |magic: &[u8]| start.get(..magic.len()).is_some_and(|start| start.eq_ignore_ascii_case(magic));
    if !is_binary_stl {
        if let Some(&(_, what, to_do)) = OTHERS.iter().find(|(magic, ..)| begins(magic)) {
            return Err(MeshFault::OtherFormat { what, to_do });
        }
        if start.starts_with(b"ply\n") || start.starts_with(b"ply\r") {
            return Ok(Format::Ply);
        }
        if is_iges(bytes) {
            return Err(MeshFault::OtherFormat { what: "an IGES file (exact surfaces, no triangles)", to_do: EXPORT });
        }
    }
    match ending {
        Some("stl") => Ok(Format::Stl),
        Some("obj") => Ok(Format::Obj),
        Some("ply") => Ok(Format::Ply),
        Some("3mf") => Err(MeshFault::OtherFormat { what: "no 3MF file (those are ZIP archives)", to_do: EXPORT }),
        _ if begins(b"solid ") || begins(b"solid\n") || has_length_of_stl(bytes) => Ok(Format::Stl),
        _ => Err(MeshFault::UnknownEnding),
    }
}

/// Whether a file is as long as a binary STL file with its count.
fn has_length_of_stl(bytes: &[u8]) -> bool {
    let count = bytes.get(80..84).map(|c| u64::from(u32::from_le_bytes([c[0], c[1], c[2], c[3]])));
    count.is_some_and(|count| count > 0 && 84 + 50 * count == bytes.len() as u64)
}

/// What follows the declaration, the comments and the document type of an XML file.
fn after_xml_head(mut start: &[u8]) -> &[u8] {
    loop {
        let end: &[u8] = match start {
            _ if start.starts_with(b"<?xml") => b"?>",
            _ if start.starts_with(b"<!--") => b"-->",
            _ => return start,
        };
        match start.windows(end.len()).position(|window| window == end) {
            Some(at) => start = start[at + end.len()..].trim_ascii_start(),
            None => return start,
        }
    }
}

/// Whether the first line is one of IGES: 80 characters, an S before a number at the end.
fn is_iges(bytes: &[u8]) -> bool {
    bytes
        .get(72..80)
        .is_some_and(|end| end[0] == b'S' && end[1..].iter().all(|c| b" 0123456789".contains(c)) && end[7] == b'1')
}
