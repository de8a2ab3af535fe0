//! A file, section by section.

use super::blocks::{Contents, File, placed};
use super::error::DxfError;
use super::layers::HiddenLayers;
use super::pair::Record;
use super::pairs::{Records, next_in_section};
use super::text::Decoder;
use crate::drawing::drawing::Drawing;
use crate::drawing::skipped::printable;
use std::collections::BTreeMap;
use std::io::BufRead;

/// Reads a DXF file, in millimetres: `$INSUNITS` says what its unit is. Entities that cannot be drawn are left out, and counted in
/// [`Drawing::skipped`]; a file of nothing else is an empty drawing.
///
/// # Errors
/// [`DxfError`] names the place.
///
/// # Cost
/// `O(n)` for `n` entities, those of blocks as often as they are inserted; memory in proportion to the file, and to what blocks
/// become, at most [`DxfError::TooMany`].
///
/// # Example
/// ```
/// use curvlay_toolpath::drawing::read_dxf;
/// let file = "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n8\nRIM\n10\n0\n20\n0\n40\n7.5\n0\nTEXT\n1\nhello\n0\nENDSEC\n0\nEOF\n";
/// let drawing = read_dxf(file.as_bytes())?;
/// assert_eq!(drawing.layers(), [("RIM".to_owned(), 1)]);
/// assert_eq!(drawing.skipped[0].to_string(), "1 TEXT: line 16");
/// # Ok::<(), curvlay_toolpath::drawing::DxfError>(())
/// ```
pub fn read_dxf(input: impl BufRead) -> Result<Drawing, DxfError> {
    let mut records = Records::new(input)?;
    let mut file = File::default();
    let mut entities = None;
    while let Some(record) = records.next()? {
        if record.kind == "EOF" {
            break;
        }
        if record.kind != "SECTION" {
            return Err(DxfError::NoDxf { at: record.at });
        }
        match record.text(2) {
            "HEADER" => {
                read_header(&record, &mut records, &mut file);
                skip_section(&mut records)?;
            }
            "TABLES" => read_tables(&mut records, &mut file.hidden)?,
            "BLOCKS" => read_blocks(&mut records, &mut file.blocks)?,
            "ENTITIES" => entities = Some(Contents::read(&mut records, "ENDSEC")?),
            _ => skip_section(&mut records)?,
        }
    }
    placed(entities.ok_or(DxfError::NoEntities)?, file)
}

fn skip_section<R: BufRead>(records: &mut Records<R>) -> Result<(), DxfError> {
    while next_in_section(records)?.kind != "ENDSEC" {}
    Ok(())
}

fn read_tables<R: BufRead>(records: &mut Records<R>, hidden: &mut HiddenLayers) -> Result<(), DxfError> {
    loop {
        let record = next_in_section(records)?;
        match record.kind.as_str() {
            "ENDSEC" => return Ok(()),
            "LAYER" => hidden.read(&record),
            _ => {}
        }
    }
}

fn read_blocks<R: BufRead>(records: &mut Records<R>, blocks: &mut BTreeMap<String, Contents>) -> Result<(), DxfError> {
    loop {
        let head = next_in_section(records)?;
        match head.kind.as_str() {
            "ENDSEC" => return Ok(()),
            "BLOCK" => {
                let base = head.number_or(10, 0.0).and_then(|x| Ok([x, head.number_or(20, 0.0)?]));
                let mut contents = Contents::read(records, "ENDBLK")?;
                contents.base = base.map_err(|fault| fault.what);
                blocks.insert(head.text(2).to_lowercase(), contents);
            }
            _ => {}
        }
    }
}

/// Takes the unit and the code page.
fn read_header<R>(header: &Record, records: &mut Records<R>, file: &mut File) {
    file.unit_mm = header_unit(header);
    let page = variable(header, "$DWGCODEPAGE", 3);
    match Decoder::new(variable(header, "$ACADVER", 1), page) {
        Some(decoder) => records.decoder = decoder,
        None => file.notes.push(format!("the code page `{}` is unknown: names may be misread", printable(page))),
    }
}

/// The variables of the header are pairs of one record: a name with code 9, then its values.
fn variable<'a>(header: &'a Record, name: &str, code: i32) -> &'a str {
    let mut pairs = header.pairs.iter().skip_while(|pair| pair.code != 9 || pair.value != name).skip(1);
    pairs.next().filter(|pair| pair.code == code).map_or("", |pair| &pair.value)
}

fn header_unit(header: &Record) -> Option<f64> {
    let number = variable(header, "$INSUNITS", 70).parse::<usize>().ok()?;
    UNITS_MM.get(number).copied().filter(|&mm| mm > 0.0)
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
