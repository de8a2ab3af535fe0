//! Triangle meshes from files: STL (binary and ASCII), 3MF, OBJ, PLY.
//!
//! A file is read whole and then parsed, so that every number in it can be held against the bytes that are there.
//! Corners at exactly the same place become one vertex, in the order in which they appear. What a reader has to decide is a
//! finding, never a silent repair; what has no area is left out and named.

mod doubts;
mod formats;
mod obj;
mod placement;
mod ply;
mod single;
mod stl;
mod threemf;
mod weld;
mod write;

pub use doubts::{UNCERTAIN_SHARE, mesh_findings};
pub use placement::{LARGE_MM, Placement, Unit, Up};

use crate::findings::{Finding, Severity};
use curvlay_voxel::inspect::without_area;
use curvlay_voxel::{OrientError, OrientReport, Oriented, orient};
use formats::{Format, recognise};
use nalgebra::Point3;
use std::path::{Path, PathBuf};
use std::{fmt, fs, io};

/// Triangles over vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners, each place once.
    pub vertices: Vec<Point3<f64>>,
    /// Numbers of the corners, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Least and greatest coordinates; `None` without vertices.
    pub fn bounds(&self) -> Option<[Point3<f64>; 2]> {
        let first = *self.vertices.first()?;
        let grow = |[low, high]: [Point3<f64>; 2], p: &Point3<f64>| [low.inf(p), high.sup(p)];
        Some(self.vertices.iter().fold([first, first], grow))
    }

    /// Area of all triangles.
    pub fn area(&self) -> f64 {
        self.corners().map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0).sum()
    }

    /// Volume that the triangles enclose, whichever way they look; overlaps count twice.
    pub fn volume(&self) -> f64 {
        self.corners().map(|[a, b, c]| a.coords.dot(&b.coords.cross(&c.coords)) / 6.0).sum::<f64>().abs()
    }

    fn corners(&self) -> impl Iterator<Item = [Point3<f64>; 3]> {
        self.triangles.iter().map(|triangle| triangle.map(|corner| self.vertices[corner as usize]))
    }

    /// Turns triangles so that neighbours agree and all look outwards: to be done before anything else.
    ///
    /// # Returns
    /// What was done; its `Display` is a line for the user.
    ///
    /// # Errors
    /// [`MeshFault::Orientation`] for a surface that has no outside.
    pub fn orient(&mut self) -> Result<OrientReport, MeshFault> {
        let Oriented { triangles, report } = orient(&self.vertices, &self.triangles)?;
        self.triangles = triangles;
        Ok(report)
    }

    /// The same mesh after [`Mesh::orient`].
    ///
    /// # Errors
    /// As [`Mesh::orient`].
    pub fn oriented(mut self) -> Result<Self, MeshFault> {
        self.orient()?;
        Ok(self)
    }

    /// How far apart single-precision numbers lie at the largest coordinate, if all coordinates are such numbers (as
    /// in binary STL): the shape is no finer than that.
    pub fn float32_spacing(&self) -> Option<f64> {
        let mut largest = 0.0_f32;
        for &c in self.vertices.iter().flat_map(Point3::iter) {
            let single = c as f32;
            if f64::from(single).to_bits() != c.to_bits() {
                return None;
            }
            largest = largest.max(single.abs());
        }
        Some(f64::from(largest.next_up()) - f64::from(largest)).filter(|spacing| spacing.is_finite())
    }
}

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
    /// The name does not tell the format.
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
        --allow-large", placement::significant(*.longest_mm))]
    TooLarge {
        /// The longest side, in mm.
        longest_mm: f64,
    },
    /// Triangles that cannot be turned so that they bound a solid.
    #[error(transparent)]
    Orientation(#[from] OrientError),
    /// A surface that bounds no solid.
    #[error(
        "the mesh encloses no volume: its {triangles} triangles are a surface without thickness; give it one in the program that \
        made it"
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

/// A mesh as it was read, and what was decided on the way.
#[derive(Clone, Debug)]
pub struct MeshFile {
    /// The mesh.
    pub mesh: Mesh,
    /// What the reader decided, guessed or left out.
    pub findings: Vec<Finding>,
    /// The file states its unit (3MF), and the mesh is in millimetres.
    pub states_unit: bool,
}

impl MeshFile {
    /// A mesh about which there is nothing to say.
    pub fn of(mesh: Mesh) -> Self {
        MeshFile { mesh, findings: Vec::new(), states_unit: false }
    }
}

/// Reads a mesh; the content tells the format, and where it does not, the ending of the name (any case). Polygons are cut into
/// triangles in their own plane.
///
/// # Errors
/// [`MeshError`] names the file, the place in it and the fault, in one line.
///
/// # Cost
/// Linear in the size of the file, which is read whole. Nothing is set aside by a count that the file states.
pub fn read_mesh_file(path: &Path) -> Result<MeshFile, MeshError> {
    read(path).map_err(|fault| MeshError { path: path.to_owned(), fault })
}

/// The mesh of [`read_mesh_file`] alone, for those who tell nobody what was decided.
///
/// # Errors
/// As [`read_mesh_file`].
pub fn read_mesh(path: &Path) -> Result<Mesh, MeshError> {
    Ok(read_mesh_file(path)?.mesh)
}

fn read(path: &Path) -> Result<MeshFile, MeshFault> {
    if !fs::metadata(path).map_err(MeshFault::Unreadable)?.is_file() {
        return Err(MeshFault::NotAFile);
    }
    let bytes = fs::read(path).map_err(MeshFault::Unreadable)?;
    if bytes.is_empty() {
        return Err(MeshFault::Empty);
    }
    let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
    let welder = match recognise(&bytes, ending.as_deref())? {
        Format::Stl => stl::parse(&bytes),
        Format::Obj => obj::parse(&bytes),
        Format::Ply => ply::parse(&bytes),
        Format::ThreeMf => threemf::parse(&bytes),
    }?;
    let states_unit = welder.states_unit;
    let (mut mesh, mut findings) = welder.finish();
    findings.extend(leave_out(&mut mesh)?);
    if mesh.triangles.is_empty() { Err(MeshFault::NoTriangles) } else { Ok(MeshFile { mesh, findings, states_unit }) }
}

/// Leaves out the triangles without area that no neighbour needs.
fn leave_out(mesh: &mut Mesh) -> Result<Option<Finding>, MeshFault> {
    if mesh.triangles.is_empty() {
        return Ok(None);
    }
    let useless = without_area(&mesh.vertices, &mesh.triangles).map_err(OrientError::from)?;
    let Some(first) = useless.first() else { return Ok(None) };
    let (what, amount) = ("triangles without area were left out".to_owned(), useless.len().to_string());
    let place = format!("first: triangle {} of the mesh", first + 1);
    let mut numbers = 0..;
    mesh.triangles.retain(|_| numbers.next().is_some_and(|number: u32| useless.binary_search(&number).is_err()));
    Ok(Some(Finding::new(Severity::Noted, what, amount, place)))
}

/// Text without the byte-order mark that some editors put in front.
fn unmarked(bytes: &[u8]) -> Result<&[u8], MeshFault> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(MeshFault::Utf16);
    }
    Ok(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

fn syntax(place: Place, what: impl Into<String>) -> MeshFault {
    MeshFault::Syntax { place, what: what.into() }
}

/// `p` when it is finite, else the fault.
fn finite(p: [f64; 3], place: Place, corner: usize) -> Result<[f64; 3], MeshFault> {
    match p.iter().position(|c| !c.is_finite()) {
        Some(axis) => Err(MeshFault::NotFinite { place, corner, axis, value: p[axis] }),
        None => Ok(p),
    }
}

/// A piece of a file as it may stand in a message: short, and without control characters.
fn quoted(piece: &str) -> String {
    const SHOWN: usize = 30;
    let more = if piece.chars().nth(SHOWN).is_some() { "..." } else { "" };
    format!("`{}{more}`", printable(piece, SHOWN))
}

/// The first characters of a text on one line.
fn printable(text: &str, most: usize) -> String {
    text.chars()
        .take(most)
        .map(|c| if c.is_control() { c.escape_default().to_string() } else { c.to_string() })
        .collect()
}

/// Three numbers from the words of a line.
fn three_numbers<'a>(words: &mut impl Iterator<Item = &'a str>, place: Place) -> Result<[f64; 3], MeshFault> {
    let mut p = [0.0; 3];
    for c in &mut p {
        let word = words.next().ok_or_else(|| syntax(place, "three coordinates are due"))?;
        *c = word.parse().map_err(|_| syntax(place, format!("{} is not a number", quoted(word))))?;
    }
    Ok(p)
}
