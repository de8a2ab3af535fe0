//! ASCII DXF files (AutoCAD R12 to today), read into a [`Drawing`]: Brooks, section 4.5 to 4.7.
//!
//! Drawn are LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE and POLYLINE with bulges, SPLINE, and INSERT of blocks: nested, scaled, turned,
//! mirrored, in arrays. Entities of other planes (an extrusion that is not z) are seen from above. What is not drawn is counted
//! by its kind; so are entities of the paper space and invisible ones.
//!
//! Departs from the thesis: its reader took no ELLIPSE and no blocks, and did not say what it left out.

mod blocks;
mod entities;
mod pairs;
mod write;

pub use write::write_dxf;

use super::drawing::Drawing;
use blocks::Contents;
use pairs::{Record, Records};
use std::collections::BTreeMap;
use std::io::{self, BufRead};

/// Why a DXF file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DxfError {
    /// A line that no DXF file can have.
    #[error("line {line}: not an ASCII DXF file, or a damaged one")]
    NoDxf {
        /// The line.
        line: u64,
    },
    /// A binary DXF file.
    #[error("binary DXF files are not read; save the drawing as ASCII DXF")]
    Binary,
    /// The file ends within a section.
    #[error("line {line}: the file ends in the middle of a section")]
    Truncated {
        /// Its last line.
        line: u64,
    },
    /// There is no section of entities.
    #[error("the file has no section ENTITIES")]
    NoEntities,
    /// A value that must be a finite number, or a whole one.
    #[error("line {line}: `{text}` is not a finite number of the kind needed here")]
    Number {
        /// The line.
        line: u64,
        /// What stands there.
        text: String,
    },
    /// An entity lacks a value.
    #[error("line {line}: the {kind} has no value with group code {code}")]
    Missing {
        /// Where the entity begins.
        line: u64,
        /// Its kind.
        kind: String,
        /// The group code.
        code: i32,
    },
    /// An entity that cannot be.
    #[error("line {line}: the {kind} {what}")]
    Entity {
        /// Where the entity begins.
        line: u64,
        /// Its kind.
        kind: String,
        /// What is wrong with it.
        what: String,
    },
    /// A block is inserted that the file does not have.
    #[error("line {line}: there is no block `{name}`")]
    NoBlock {
        /// Where the INSERT begins.
        line: u64,
        /// The block.
        name: String,
    },
    /// Blocks inserted into each other without end.
    #[error("line {line}: the block `{name}` is within itself, or more than {limit} deep")]
    Depth {
        /// Where the INSERT begins.
        line: u64,
        /// The block.
        name: String,
        /// Greatest depth.
        limit: usize,
    },
    /// More entities than memory should hold, mostly from arrays of blocks.
    #[error("line {line}: with its blocks the drawing has more than {limit} entities")]
    TooMany {
        /// Where the entity begins that is too many.
        line: u64,
        /// Greatest number.
        limit: usize,
    },
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] io::Error),
}

/// Reads a DXF file, in millimetres: `$INSUNITS` says what its unit is.
///
/// # Errors
/// [`DxfError`] names the line. Coordinates are checked when the drawing is [flattened](Drawing::contours).
///
/// # Cost
/// `O(n)` for `n` entities, those of blocks as often as they are inserted.
///
/// # Example
/// ```
/// use curvlay_toolpath::drawing::read_dxf;
/// let file = "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n8\nRIM\n10\n0\n20\n0\n40\n7.5\n0\nTEXT\n1\nhello\n0\nENDSEC\n0\nEOF\n";
/// let drawing = read_dxf(file.as_bytes())?;
/// assert_eq!(drawing.layers(), [("RIM".to_owned(), 1)]);
/// assert_eq!(drawing.skipped, [("TEXT".to_owned(), 1)]);
/// # Ok::<(), curvlay_toolpath::drawing::DxfError>(())
/// ```
pub fn read_dxf(mut input: impl BufRead) -> Result<Drawing, DxfError> {
    if input.fill_buf()?.starts_with(b"AutoCAD Binary DXF") {
        return Err(DxfError::Binary);
    }
    let mut records = Records::new(input);
    let mut unit = None;
    let mut blocks: BTreeMap<String, Contents> = BTreeMap::new();
    let mut entities = None;
    while let Some(record) = records.next()? {
        if record.kind == "EOF" {
            break;
        }
        if record.kind != "SECTION" {
            return Err(DxfError::NoDxf { line: record.line });
        }
        match record.text(2) {
            "HEADER" => {
                unit = header_unit(&record)?;
                skip_section(&mut records)?;
            }
            "BLOCKS" => read_blocks(&mut records, &mut blocks)?,
            "ENTITIES" => entities = Some(Contents::read(&mut records, "ENDSEC")?),
            _ => skip_section(&mut records)?,
        }
    }
    let entities = entities.ok_or(DxfError::NoEntities)?;
    blocks::placed(&entities, &blocks, unit)
}

fn next_in_section<R: BufRead>(records: &mut Records<R>) -> Result<Record, DxfError> {
    match records.next()? {
        Some(record) if record.kind != "EOF" && record.kind != "SECTION" => Ok(record),
        _ => Err(DxfError::Truncated { line: records.line() }),
    }
}

fn skip_section<R: BufRead>(records: &mut Records<R>) -> Result<(), DxfError> {
    while next_in_section(records)?.kind != "ENDSEC" {}
    Ok(())
}

fn read_blocks<R: BufRead>(records: &mut Records<R>, blocks: &mut BTreeMap<String, Contents>) -> Result<(), DxfError> {
    loop {
        let head = next_in_section(records)?;
        match head.kind.as_str() {
            "ENDSEC" => return Ok(()),
            "BLOCK" => {
                let base = [head.number_or(10, 0.0)?, head.number_or(20, 0.0)?];
                let contents = Contents { base, ..Contents::read(records, "ENDBLK")? };
                blocks.insert(head.text(2).to_owned(), contents);
            }
            _ => {}
        }
    }
}

/// Millimetres in a unit of `$INSUNITS`, by its number; 0 is no unit.
const UNITS_MM: [f64; 18] = [
    0.0,
    25.4,
    304.8,
    1_609_344.0,
    1.0,
    10.0,
    1e3,
    1e6,
    25.4e-6,
    25.4e-3,
    914.4,
    1e-7,
    1e-6,
    1e-3,
    100.0,
    1e4,
    1e5,
    1e12,
];

/// The variables of the header are pairs of one record: a name with code 9, then its values.
fn header_unit(header: &Record) -> Result<Option<f64>, DxfError> {
    let mut pairs = header.pairs.iter().skip_while(|pair| pair.code != 9 || pair.value != "$INSUNITS").skip(1);
    let Some(value) = pairs.next().filter(|pair| pair.code == 70) else { return Ok(None) };
    let number = value.whole()?;
    let unit = usize::try_from(number).ok().and_then(|number| UNITS_MM.get(number)).copied();
    Ok(unit.filter(|&mm| mm > 0.0))
}
