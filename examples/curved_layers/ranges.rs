//! Paths of a range of layers in a file, and such files put together: a big part on several computers.
//!
//! A surface is filled by itself, so what comes of it does not depend on which others are filled in the same run. What follows, the
//! order of the curves and which short ones stay, looks at all layers: it is done when they are put together. So the
//! result is that of one run, bit for bit.
//!
//! The file is text, a JSON value a line: a [`Header`], what was made of each layer ([`Layer`]), and an [`End`] with
//! a checksum of the lines before it. Numbers are written with all digits.
//!
//! A piece makes the surfaces near its layers alone. So the header says what all surfaces are made of, and each layer which surface it lies on.

use curvlay_examples::input::{self, InputError};
use curvlay_examples::output::{OutputError, OutputFolder};
use curvlay_layers::curved::surface::mesh_stamp;
use curvlay_toolpath::fill::FilledLayer;
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::mesh::SurfacePoint;
use curvlay_toolpath::path::{LayerPaths, PathOptions};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The file in the output folder.
pub const FILE: &str = "paths.jsonl";

/// What the first line says that the file is.
const FORMAT: &str = "curvlay paths 4";

/// Layers that are picked, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pick {
    /// From the first to the last, both included; to the last that there is if none is named.
    From { first: usize, last: Option<usize> },
    /// One of several pieces of about the same number of layers.
    Piece { piece: usize, of: usize },
}

/// `A..B`, `A..` or `K/N`, for clap.
pub fn pick(text: &str) -> Result<Pick, String> {
    let number = |text: &str| text.trim().parse::<usize>().ok().filter(|&n| n > 0);
    let wrong = || "must be A..B (both included), A.. or K/N (piece K of N), counted from 1".to_owned();
    if let Some((piece, of)) = text.split_once('/') {
        let (piece, of) = number(piece).zip(number(of)).ok_or_else(wrong)?;
        return if piece <= of {
            Ok(Pick::Piece { piece, of })
        } else {
            Err(format!("there is no piece {piece} of {of}"))
        };
    }
    let (first, last) = text.split_once("..").ok_or_else(wrong)?;
    let first = number(first).ok_or_else(wrong)?;
    if last.trim().is_empty() {
        return Ok(Pick::From { first, last: None });
    }
    let last = number(last).ok_or_else(wrong)?;
    if last < first {
        Err(format!("no layer: {last} comes before {first}"))
    } else {
        Ok(Pick::From { first, last: Some(last) })
    }
}

impl Pick {
    /// About which share of the layers it is; all, where that depends on how many there are.
    pub fn share(self) -> f64 {
        match self {
            Pick::From { .. } => 1.0,
            Pick::Piece { of, .. } => 1.0 / of as f64,
        }
    }

    /// The layers, from 0, out of so many.
    pub fn layers(self, count: usize) -> Result<Range<usize>, RangeError> {
        match self {
            Pick::From { first, last } => {
                let last = last.unwrap_or(count.max(first));
                if last <= count { Ok(first - 1..last) } else { Err(RangeError::Beyond { first, last, count }) }
            }
            Pick::Piece { of, .. } if of > count => Err(RangeError::Pieces { of, count }),
            Pick::Piece { piece, of } => Ok((piece - 1) * count / of..piece * count / of),
        }
    }
}

/// Why ranges of layers cannot be made or put together.
#[derive(Debug, thiserror::Error)]
pub enum RangeError {
    #[error("--layers {first}..{last}: there are {count} layers; {}", advice(*.first, *.count))]
    Beyond { first: usize, last: usize, count: usize },
    #[error("{of} pieces of {count} layers: some would be empty; use --layers K/{count} or fewer pieces")]
    Pieces { of: usize, count: usize },
    #[error("{}: cannot be read: {source}", .path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    #[error(transparent)]
    Input(InputError),
    #[error("{}: line {line}: {why}", .path.display())]
    Line { path: PathBuf, line: usize, why: String },
    #[error("{}: this file has no paths of a range of layers: --merge wants the paths.jsonl of runs with --layers", .path.display())]
    Format { path: PathBuf },
    #[error(
        "{}: the paths are on other surfaces: make them with the same mesh, --resume file and --layer-height",
        .path.display()
    )]
    OtherSurfaces { path: PathBuf },
    #[error(
        "{}: layer {layer} is on another surface than this run makes of the same field: make all pieces anew with this version of the program",
        .path.display()
    )]
    OtherSurface { path: PathBuf, layer: usize },
    #[error(
        "{}: the paths were made with other options: --bead, --pattern, --min-gap, --join-distance, --min-length, --min-width, \
         --density, --support-density and what goes with them must be the same in all runs",
        .path.display()
    )]
    OtherOptions { path: PathBuf },
    #[error("layers {}..{} are in {} and in {}: omit one of the files", .layers[0], .layers[1], .paths[0].display(), .paths[1].display())]
    Overlap { layers: [usize; 2], paths: [PathBuf; 2] },
    #[error("no file has layers {}: fill them with --layers and add their files", listed(.0))]
    Missing(Vec<[usize; 2]>),
}

fn advice(first: usize, count: usize) -> String {
    if first <= count {
        format!("--layers {first}..{count} or {first}.. ends with the last one")
    } else {
        format!("the last range may begin at {count}")
    }
}

fn listed(ranges: &[[usize; 2]]) -> String {
    ranges.iter().map(|[first, last]| format!("{first}..{last}")).collect::<Vec<_>>().join(", ")
}

/// How layers are filled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayerFill {
    pub part: PathOptions,
    /// Of a part with support.
    pub support: Option<PathOptions>,
}

/// The first line of a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Header {
    format: String,
    /// Stamp of what all surfaces are made of, hexadecimal.
    made_of: String,
    /// How they were filled.
    fill: LayerFill,
    /// How many surfaces there are, and the first and the last that follow, counted from 1.
    count: usize,
    first: usize,
    last: usize,
}

/// What was made of a layer.
#[derive(Serialize, Deserialize)]
struct Layer<T> {
    /// Stamp of its surface, hexadecimal.
    surface: String,
    /// `null` without a surface.
    filled: T,
}

/// The last line of a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct End {
    /// FNV-1a hash of the bytes of all lines before, with their line breaks, hexadecimal.
    checksum: String,
}

/// Start of an FNV-1a hash of 64 bits, and its step.
const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

fn mix(hash: u64, value: u64) -> u64 {
    (hash ^ value).wrapping_mul(0x0000_0100_0000_01b3)
}

fn mix_bytes(hash: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(hash, |hash, &byte| mix(hash, u64::from(byte)))
}

/// A number in the file.
fn hexadecimal(stamp: u64) -> String {
    format!("{stamp:016x}")
}

/// A number that differs for another surface: the FNV-1a hash of its stamp and the bits of its thickness.
fn stamp(surface: &LayerSurface) -> String {
    let hash = mix(FNV_START, mesh_stamp(surface.vertices, surface.triangles));
    hexadecimal(surface.thickness.iter().fold(hash, |hash, thickness| mix(hash, thickness.to_bits())))
}

/// Writes what was made of a range of layers. `made_of` identifies what all surfaces are made of.
pub fn write(
    surfaces: &[LayerSurface],
    made_of: u64,
    fill: &LayerFill,
    range: Range<usize>,
    layers: &[Option<FilledLayer>],
    folder: &OutputFolder,
) -> Result<(), OutputError> {
    let (format, made_of, count) = (FORMAT.to_owned(), hexadecimal(made_of), surfaces.len());
    let header = Header { format, made_of, fill: *fill, count, first: range.start + 1, last: range.end };
    folder.write_with(FILE, |out| {
        let mut hash = FNV_START;
        let mut line = |mut text: Vec<u8>| {
            text.push(b'\n');
            hash = mix_bytes(hash, &text);
            out.write_all(&text)
        };
        line(serde_json::to_vec(&header)?)?;
        for (surface, filled) in surfaces[range].iter().zip(layers) {
            line(serde_json::to_vec(&Layer { surface: stamp(surface), filled })?)?;
        }
        serde_json::to_writer(&mut *out, &End { checksum: hexadecimal(hash) })?;
        writeln!(out)
    })
}

/// Whether all files are there and are such files, before the work for which they are read.
///
/// # Errors
/// [`RangeError::Unreadable`] or [`RangeError::Format`] for the first that is not.
pub fn check(files: &[PathBuf]) -> Result<(), RangeError> {
    files.iter().try_for_each(|path| Lines::open(path)?.header().map(|_| ()))
}

/// What the files hold of these surfaces: each layer once.
pub fn read(
    files: &[PathBuf],
    surfaces: &[LayerSurface],
    made_of: u64,
    fill: &LayerFill,
) -> Result<Vec<Option<FilledLayer>>, RangeError> {
    let (made_of, count) = (hexadecimal(made_of), surfaces.len());
    let mut layers: Vec<Option<FilledLayer>> = vec![None; count];
    let mut owner: Vec<Option<usize>> = vec![None; count];
    for (number, path) in files.iter().enumerate() {
        let mut lines = Lines::open(path)?;
        let header = lines.header()?;
        let path = path.clone();
        if header.made_of != made_of || header.count != count {
            return Err(RangeError::OtherSurfaces { path });
        }
        if header.fill != *fill {
            return Err(RangeError::OtherOptions { path });
        }
        if header.first == 0 || header.first > header.last || header.last > count {
            return Err(RangeError::Line { path, line: 1, why: format!("no range of {count} layers") });
        }
        let range = header.first - 1..header.last;
        if let Some((at, other)) = range.clone().find_map(|at| owner[at].map(|other| (at, other))) {
            let last = range.take_while(|&layer| owner[layer] == Some(other) || layer < at).last().unwrap_or(at);
            return Err(RangeError::Overlap { layers: [at + 1, last + 1], paths: [files[other].clone(), path] });
        }
        for at in range {
            let Layer { surface, filled: layer }: Layer<Option<FilledLayer>> = lines.next()?;
            if surface != stamp(&surfaces[at]) {
                return Err(RangeError::OtherSurface { path, layer: at + 1 });
            }
            fits(layer.as_ref(), &surfaces[at]).map_err(|why| lines.fault(format!("layer {}: {why}", at + 1)))?;
            layers[at] = layer;
            owner[at] = Some(number);
        }
        lines.end()?;
    }
    let mut missing: Vec<[usize; 2]> = Vec::new();
    for layer in (1..=count).filter(|layer| owner[layer - 1].is_none()) {
        match missing.last_mut() {
            Some([_, last]) if *last + 1 == layer => *last = layer,
            _ => missing.push([layer, layer]),
        }
    }
    if missing.is_empty() { Ok(layers) } else { Err(RangeError::Missing(missing)) }
}

/// How far weights of a point may be from adding up to one, and how far the point from where they put it, as a share of the size of its
/// triangle: both are rounded numbers.
const ROUNDING: f64 = 1e-6;

/// Whether the paths of a layer lie on its surface: a file that was changed by hand may say anything.
fn fits(layer: Option<&FilledLayer>, surface: &LayerSurface) -> Result<(), String> {
    let Some(layer) = layer else {
        return if surface.triangles.is_empty() {
            Ok(())
        } else {
            Err("its surface is there, its paths are not".to_owned())
        };
    };
    let LayerPaths { paths, short, narrow, .. } = &layer.paths;
    for (number, path) in [paths, short, narrow].into_iter().flatten().enumerate() {
        for (k, point) in path.points.iter().enumerate() {
            let place = || format!("curve {}, point {}", number + 1, k + 1);
            on_surface(&point.at, surface).map_err(|why| format!("{}: {why}", place()))?;
            if !(point.width.is_finite() && point.width > 0.0) {
                return Err(format!("{}: a bead {} mm wide", place(), point.width));
            }
        }
    }
    Ok(())
}

/// Whether a point is where its triangle and its weights put it.
fn on_surface(point: &SurfacePoint, surface: &LayerSurface) -> Result<(), String> {
    let count = surface.triangles.len();
    let Some(corners) = surface.triangles.get(point.triangle as usize) else {
        return Err(format!("triangle {} of {count}", point.triangle));
    };
    let corners = corners.map(|corner| surface.vertices[corner as usize].coords);
    let weights = point.barycentric;
    let is_inside =
        weights.iter().all(|weight| *weight >= -ROUNDING) && (weights.iter().sum::<f64>() - 1.0).abs() <= ROUNDING;
    if !is_inside {
        return Err(format!("weights {weights:?} are not those of a point of a triangle"));
    }
    let size = corners.iter().map(|corner| corner.amax()).fold(1.0, f64::max);
    let expected = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
    let off = (point.position.coords - expected).norm();
    // A distance that is no number is wrong, too.
    if off <= ROUNDING * size { Ok(()) } else { Err(format!("{off:.3} mm off its triangle")) }
}

/// The values of a file, one a line.
struct Lines {
    path: PathBuf,
    source: BufReader<io::Take<File>>,
    text: String,
    line: usize,
    /// Of the lines that were read.
    hash: u64,
}

impl Lines {
    fn open(path: &Path) -> Result<Self, RangeError> {
        let unreadable = |source| RangeError::Unreadable { path: path.to_owned(), source };
        let source = input::open(path, input::MAX_DATA_BYTES).map_err(|error| match error {
            InputError::Unreadable { source, .. } => unreadable(source),
            InputError::NotAFile { path } => RangeError::Format { path },
            error => RangeError::Input(error),
        })?;
        let source = BufReader::new(source);
        Ok(Lines { path: path.to_owned(), source, text: String::new(), line: 0, hash: FNV_START })
    }

    /// The first line.
    fn header(&mut self) -> Result<Header, RangeError> {
        match self.next::<Header>() {
            Ok(header) if header.format == FORMAT => Ok(header),
            Ok(_) | Err(RangeError::Line { .. }) => Err(RangeError::Format { path: self.path.clone() }),
            Err(error) => Err(error),
        }
    }

    /// The last line: its checksum is that of the lines before, and nothing follows.
    fn end(&mut self) -> Result<(), RangeError> {
        let hash = self.hash;
        let end: End = self.next()?;
        if end.checksum != hexadecimal(hash) {
            return Err(self.fault("the lines before were changed, their checksum is another: make the file again"));
        }
        self.text.clear();
        match self.source.read_line(&mut self.text) {
            Ok(0) => Ok(()),
            _ => Err(self.fault("more follows behind the end: make the file again")),
        }
    }

    fn fault(&self, why: impl Into<String>) -> RangeError {
        RangeError::Line { path: self.path.clone(), line: self.line, why: why.into() }
    }

    fn next<T: for<'a> Deserialize<'a>>(&mut self) -> Result<T, RangeError> {
        self.text.clear();
        self.line += 1;
        let failed = |why: String| RangeError::Line { path: self.path.clone(), line: self.line, why };
        match self.source.read_line(&mut self.text) {
            Ok(0) => Err(failed("the file is cut short: make it again".to_owned())),
            Ok(_) => {
                self.hash = mix_bytes(self.hash, self.text.as_bytes());
                serde_json::from_str(&self.text).map_err(|error| failed(error.to_string()))
            }
            Err(source) => Err(RangeError::Unreadable { path: self.path.clone(), source }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_picked_by_range_or_piece() {
        let of = |text: &str, count| pick(text).map_err(|_| ()).and_then(|pick| pick.layers(count).map_err(|_| ()));
        assert_eq!(
            (of("3..5", 9), of("3..", 9), of("9..9", 9), of("9..", 9)),
            (Ok(2..5), Ok(2..9), Ok(8..9), Ok(8..9))
        );
        assert_eq!((of("3..10", 9), of("10..", 9), of("4/3", 9), of("1/10", 9)), (Err(()), Err(()), Err(()), Err(())));
        for text in ["", "0..3", "5..4", "..4", "a..b", "0/3", "1/0", "1", "1..2..3", "-1..3"] {
            assert!(pick(text).is_err(), "{text}");
        }
        for (count, of_them) in [(10, 3), (7, 7), (100, 8)] {
            let pieces = (1..=of_them).map(|k| of(&format!("{k}/{of_them}"), count).unwrap());
            assert_eq!(pieces.flatten().collect::<Vec<_>>(), (0..count).collect::<Vec<_>>());
        }
    }
}
