//! Blocks: what a section or a block contains, and blocks put where they are inserted.

use super::entities::{Shape, placement, shape_of};
use super::pairs::{Record, Records};
use super::{DxfError, next_in_section};
use crate::drawing::curve::Affine;
use crate::drawing::drawing::{Drawing, Entity};
use std::collections::BTreeMap;
use std::io::BufRead;

/// Blocks within blocks.
const DEEPEST: usize = 32;

/// Most entities of a drawing. A design has thousands; an array of arrays of blocks can have any number in a few lines.
const MAX_ENTITIES: usize = 1_000_000;

/// What a section or a block contains.
#[derive(Clone, Debug, Default)]
pub(super) struct Contents {
    /// Base point of the block.
    pub base: [f64; 2],
    pub shapes: Vec<(Record, Shape)>,
    pub skipped: BTreeMap<String, usize>,
}

impl Contents {
    /// Reads entities up to the record `end`.
    pub fn read<R: BufRead>(records: &mut Records<R>, end: &str) -> Result<Self, DxfError> {
        let mut contents = Contents::default();
        let mut held = None;
        loop {
            let record = match held.take() {
                Some(record) => record,
                None => next_in_section(records)?,
            };
            if record.kind == end {
                return Ok(contents);
            }
            let mut vertices = Vec::new();
            if record.kind == "POLYLINE" {
                loop {
                    let vertex = next_in_section(records)?;
                    match vertex.kind.as_str() {
                        "VERTEX" => vertices.push(vertex),
                        "SEQEND" => break,
                        _ => {
                            held = Some(vertex);
                            break;
                        }
                    }
                }
            }
            // Ends the attributes of an INSERT.
            if record.kind == "SEQEND" {
                continue;
            }
            let hidden = if record.whole_or(67, 0)? == 1 {
                Some("in paper space")
            } else {
                (record.whole_or(60, 0)? == 1).then_some("invisible")
            };
            match hidden {
                Some(why) => contents.skip(format!("{} ({why})", record.kind)),
                None => match shape_of(&record, &vertices)? {
                    Shape::Skipped(what) => contents.skip(what),
                    shape => contents.shapes.push((record, shape)),
                },
            }
        }
    }

    fn skip(&mut self, what: String) {
        *self.skipped.entry(what).or_default() += 1;
    }
}

/// The entities of a drawing with all blocks in their places.
pub(super) fn placed(
    entities: &Contents,
    blocks: &BTreeMap<String, Contents>,
    unit_mm: Option<f64>,
) -> Result<Drawing, DxfError> {
    let mut out = Drawing { unit_mm, ..Drawing::default() };
    let mut skipped = BTreeMap::new();
    let map = Affine::scale(unit_mm.unwrap_or(1.0));
    place(entities, blocks, &map, None, 0, &mut out, &mut skipped)?;
    out.skipped = skipped.into_iter().collect();
    Ok(out)
}

fn place(
    contents: &Contents,
    blocks: &BTreeMap<String, Contents>,
    map: &Affine,
    layer: Option<&str>,
    depth: usize,
    out: &mut Drawing,
    skipped: &mut BTreeMap<String, usize>,
) -> Result<(), DxfError> {
    for (what, count) in &contents.skipped {
        *skipped.entry(what.clone()).or_default() += count;
    }
    for (record, shape) in &contents.shapes {
        // What lies on layer 0 of a block is on the layer where it is inserted.
        let own = record.text(8);
        let layer = layer.filter(|_| own == "0" || own.is_empty()).unwrap_or(own);
        let too_many = DxfError::TooMany { line: record.line, limit: MAX_ENTITIES };
        match shape {
            Shape::Curves { curves, closed } => {
                if out.entities.len() >= MAX_ENTITIES {
                    return Err(too_many);
                }
                let curves = curves.iter().map(|curve| curve.mapped(map)).collect();
                let (kind, layer) = (record.kind.clone(), layer.to_owned());
                out.entities.push(Entity { kind, layer, line: record.line, curves, closed: *closed });
            }
            Shape::Insert { name, columns, rows } => {
                let (line, name) = (record.line, name.clone());
                let Some(block) = blocks.get(&name) else { return Err(DxfError::NoBlock { line, name }) };
                if depth >= DEEPEST {
                    return Err(DxfError::Depth { line, name, limit: DEEPEST });
                }
                // An array of nothing is nothing, however large.
                if block.shapes.is_empty() {
                    continue;
                }
                if columns.saturating_mul(*rows) > MAX_ENTITIES as u64 {
                    return Err(too_many);
                }
                for row in 0..*rows {
                    for column in 0..*columns {
                        let inner = placement(record, block.base, [column as f64, row as f64])?;
                        place(block, blocks, &map.after(&inner), Some(layer), depth + 1, out, skipped)?;
                    }
                }
            }
            Shape::Skipped(_) => {}
        }
    }
    Ok(())
}
