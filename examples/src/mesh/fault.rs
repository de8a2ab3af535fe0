//! What is wrong with a mesh file, and where.

use crate::count::counted;
use curvlay_voxel::OrientError;
use std::path::PathBuf;
use std::{fmt, io};

/// Longest side, and farthest place, that are taken without being allowed, in mm: ten metres are beyond any robot of
/// ours, and a part of a few millimetres in metres by mistake.
pub const LARGE_MM: f64 = 10_000.0;

/// A mesh file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", .path.display())]
pub struct MeshError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub fault: MeshFault,
}

/// What is wrong with a mesh file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshFault {
    /// The system does not hand the file out.
    #[error("cannot be read: {0}")]
    Unreadable(#[source] io::Error),
    /// A directory, or another thing that is not a file.
    #[error("is not a file")]
    NotAFile,
    /// The format is not known from the name.
    #[error("the ending of the name must be .stl, .3mf, .obj or .ply")]
    UnknownEnding,
    /// Another kind of file.
    #[error("this is {what}: {to_do}")]
    OtherFormat {
        /// What it is.
        what: &'static str,
        /// What the user may do.
        to_do: &'static str,
    },
    /// A file of points alone.
    #[error("this is a point cloud: {points} points without faces; export a mesh with faces")]
    PointCloud {
        /// Points that the header states.
        points: usize,
    },
    /// A 3MF package that cannot be used.
    #[error("the 3MF package: {0}")]
    Package(String),
    /// More than is taken from one file.
    #[error("{what} would take more than {limit}")]
    TooMuch {
        /// What of the file.
        what: String,
        /// How much is taken.
        limit: &'static str,
    },
    /// No bytes.
    #[error("the file is empty")]
    Empty,
    /// Sound, but without a triangle.
    #[error("the file holds no triangles")]
    NoTriangles,
    /// Neither ASCII nor binary STL.
    #[error("this is not an STL file: neither `solid` in front nor the length of a binary one")]
    NotStl,
    /// A binary STL file whose length does not fit its count.
    #[error(
        "the header promises {triangles} triangles, which take {expected} bytes, but the file has {bytes}: cut \
        short, or not an STL file; export it anew"
    )]
    Length {
        /// Triangles that the header promises.
        triangles: u32,
        /// Bytes that they take.
        expected: u64,
        /// Bytes of the file.
        bytes: u64,
    },
    /// A coordinate that is infinite, not a number, or beyond what a number holds.
    #[error("{place}: coordinate {axis} of corner {corner} is {value}", axis = ["x", "y", "z"][*.axis])]
    NotFinite {
        /// Where it is.
        place: Place,
        /// The corner of the triangle, or the vertex, counted from 1.
        corner: usize,
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
        /// What stands there.
        value: f64,
    },
    /// Something that the format does not allow.
    #[error("{place}: {what}")]
    Syntax {
        /// Where it is.
        place: Place,
        /// What is wrong.
        what: String,
    },
    /// The coordinates leave the range of numbers once scale and unit are applied.
    #[error("the part is infinitely large at this scale and unit")]
    Scale,
    /// Larger than [`LARGE_MM`], which was not allowed.
    #[error("the longest side of the part is {} mm, more than {LARGE_MM} mm: check --unit and --scale, or allow it with \
        --allow-large", significant(*.longest_mm))]
    TooLarge {
        /// The longest side, in mm.
        longest_mm: f64,
    },
    /// Triangles that cannot be turned so that they bound a solid.
    #[error(transparent)]
    Orientation(#[from] OrientError),
    /// A surface that bounds no solid.
    #[error(
        "the mesh encloses no volume: it is a surface of {} without thickness; give it one in the program that made it",
        counted(.triangles, "triangle")
    )]
    NoVolume {
        /// How many triangles it has.
        triangles: usize,
    },
    /// Text of two bytes a character.
    #[error("the text is UTF-16: save it as UTF-8 or ASCII")]
    Utf16,
}

/// A place in a file, counted from 1 (bytes from 0, objects by their ids).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of a text file.
    Line(usize),
    /// A byte of a binary file.
    Byte(u64),
    /// A triangle, and where it starts.
    Triangle(usize, u64),
    /// A vertex of an object.
    Vertex(usize),
    /// A triangle of an object, by the number of the object.
    ObjectTriangle(u32, usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Place::Line(line) => write!(f, "line {line}"),
            Place::Byte(byte) => write!(f, "byte {byte}"),
            Place::Triangle(triangle, byte) => write!(f, "triangle {triangle} (byte {byte})"),
            Place::Vertex(vertex) => write!(f, "vertex {vertex}"),
            Place::ObjectTriangle(object, triangle) => write!(f, "object {object}, triangle {triangle}"),
        }
    }
}

/// Text without the byte-order mark that some editors put in front.
pub(super) fn unmarked(bytes: &[u8]) -> Result<&[u8], MeshFault> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(MeshFault::Utf16);
    }
    Ok(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

pub(super) fn syntax(place: Place, what: impl Into<String>) -> MeshFault {
    MeshFault::Syntax { place, what: what.into() }
}

/// `p` when it is finite, else the fault.
pub(super) fn finite(p: [f64; 3], place: Place, corner: usize) -> Result<[f64; 3], MeshFault> {
    match p.iter().position(|c| !c.is_finite()) {
        Some(axis) => Err(MeshFault::NotFinite { place, corner, axis, value: p[axis] }),
        None => Ok(p),
    }
}

/// A piece of a file as it may stand in a message: short, and without control characters.
pub(super) fn quoted(piece: &str) -> String {
    const SHOWN: usize = 30;
    let more = if piece.chars().nth(SHOWN).is_some() { "..." } else { "" };
    format!("`{}{more}`", printable(piece, SHOWN))
}

/// The first characters of a text on one line.
pub(super) fn printable(text: &str, most: usize) -> String {
    text.chars()
        .take(most)
        .map(|c| if c.is_control() { c.escape_default().to_string() } else { c.to_string() })
        .collect()
}

/// Three numbers from the words of a line.
pub(super) fn three_numbers<'a>(
    words: &mut impl Iterator<Item = &'a str>,
    place: Place,
) -> Result<[f64; 3], MeshFault> {
    let mut p = [0.0; 3];
    for c in &mut p {
        let word = words.next().ok_or_else(|| syntax(place, "three coordinates are due"))?;
        *c = word.parse().map_err(|_| syntax(place, format!("{} is not a number", quoted(word))))?;
    }
    Ok(p)
}

/// A 3MF package that cannot be used.
pub(super) fn package_fault(what: impl Into<String>) -> MeshFault {
    MeshFault::Package(what.into())
}

/// A length with four figures.
pub(super) fn significant(value: f64) -> String {
    if value <= 0.0 || (1e-3..1e6).contains(&value) {
        let digits = if value <= 0.0 { 0 } else { (3 - value.log10().floor() as i32).max(0) as usize };
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.3e}")
    }
}
