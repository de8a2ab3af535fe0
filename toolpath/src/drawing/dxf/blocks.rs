//! Blocks: what a section or a block contains, and blocks put where they are inserted.
//!
//! What blocks become is counted before anything is placed, from those without inner blocks up: a few lines can ask for any number
//! of entities.

use super::entities::{Insert, Shape, shape_of};
use super::error::{DxfError, Place};
use super::layers::{Hidden, HiddenLayers};
use super::pair::Record;
use super::pairs::{Records, next_in_section};
use crate::drawing::curve::{Affine, Curve};
use crate::drawing::drawing::{Drawing, Entity};
use crate::drawing::skipped::Skips;
use std::collections::BTreeMap;
use std::io::BufRead;

/// Blocks within blocks.
const DEEPEST: usize = 32;

/// Most segments, arcs and control points of a drawing: some 100 MB. A design has thousands.
const MAX_CURVES: u64 = 1_000_000;

/// What a file has beside its entities.
#[derive(Default)]
pub(super) struct File {
    pub unit_mm: Option<f64>,
    pub notes: Vec<String>,
    pub hidden: HiddenLayers,
    /// By name in small letters: names of blocks are equal without regard to case.
    pub blocks: BTreeMap<String, Contents>,
}

/// Something that a section or a block contains.
#[derive(Clone, Debug)]
pub(super) struct Item {
    kind: String,
    layer: String,
    at: Place,
    /// Where it is, for messages.
    place: String,
    shape: Shape,
}

/// What a section or a block contains.
#[derive(Clone, Debug)]
pub(super) struct Contents {
    /// Base point of the block, or why it has none.
    pub base: Result<[f64; 2], String>,
    items: Vec<Item>,
    skips: Skips,
}

impl Contents {
    /// Reads entities up to the record `end`.
    pub fn read<R: BufRead>(records: &mut Records<R>, end: &str) -> Result<Self, DxfError> {
        let mut contents = Contents { base: Ok([0.0; 2]), items: Vec::new(), skips: Skips::default() };
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
                held = read_vertices(records, &mut vertices)?;
            }
            // Ends the attributes of an INSERT.
            if record.kind != "SEQEND" {
                contents.add(&record, &vertices);
            }
        }
    }

    fn add(&mut self, record: &Record, vertices: &[Record]) {
        let what = |why: &str| format!("{} ({why})", record.kind);
        if record.whole_or(67, 0).is_ok_and(|space| space == 1) {
            return self.skips.add(&what("in paper space"), record.place(None));
        }
        if record.whole_or(60, 0).is_ok_and(|hidden| hidden == 1) {
            return self.skips.add(&what("invisible"), record.place(None));
        }
        match shape_of(record, vertices) {
            Ok(Shape::Skipped(kind)) => self.skips.add(&kind, record.place(None)),
            Ok(shape) => {
                let (kind, layer) = (record.kind.clone(), record.text(8).to_owned());
                self.items.push(Item { kind, layer, at: record.at, place: record.place(None), shape });
            }
            Err(fault) => self.skips.add(&what(&fault.what), record.place(fault.at)),
        }
    }
}

/// Reads the vertices of a POLYLINE, and returns the record after them that is not SEQEND.
fn read_vertices<R: BufRead>(records: &mut Records<R>, vertices: &mut Vec<Record>) -> Result<Option<Record>, DxfError> {
    loop {
        let vertex = next_in_section(records)?;
        match vertex.kind.as_str() {
            "VERTEX" => vertices.push(vertex),
            "SEQEND" => return Ok(None),
            _ => return Ok(Some(vertex)),
        }
    }
}

/// What a block becomes with the blocks in it.
#[derive(Clone, Debug, Default)]
struct Counted {
    /// Segments, arcs and control points.
    curves: u64,
    /// Blocks in each other, itself included.
    height: usize,
    /// What is not drawn of it.
    skips: Skips,
}

/// The entities of a drawing with all blocks in their places.
pub(super) fn placed(mut entities: Contents, mut file: File) -> Result<Drawing, DxfError> {
    let counted = count_blocks(&mut file.blocks, &file.hidden);
    let all = count(&mut entities, &counted, &file.hidden);
    if all.curves > MAX_CURVES {
        return Err(DxfError::TooMany { limit: MAX_CURVES });
    }
    let out = Drawing { unit_mm: file.unit_mm, notes: file.notes, ..Drawing::default() };
    let mut placing = Placing { blocks: &file.blocks, counted: &counted, hidden: &file.hidden, skips: all.skips, out };
    placing.place(&entities, &Affine::scale(file.unit_mm.unwrap_or(1.0)), None);
    placing.out.skipped = placing.skips.into_list();
    Ok(placing.out)
}

/// Counts all blocks, those first in which no uncounted ones are inserted. Blocks within themselves are counted last, without what leads
/// to others of them.
fn count_blocks(blocks: &mut BTreeMap<String, Contents>, hidden: &HiddenLayers) -> BTreeMap<String, Counted> {
    let mut needs: BTreeMap<String, usize> = BTreeMap::new();
    let mut users: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (name, contents) in blocks.iter() {
        let mut inner: Vec<String> = contents.inserts().map(|insert| insert.name.to_lowercase()).collect();
        inner.sort_unstable();
        inner.dedup();
        inner.retain(|inner| blocks.contains_key(inner));
        needs.insert(name.clone(), inner.len());
        inner.into_iter().for_each(|inner| users.entry(inner).or_default().push(name.clone()));
    }
    let mut ready: Vec<String> = needs.iter().filter(|(_, count)| **count == 0).map(|(name, _)| name.clone()).collect();
    let mut counted = BTreeMap::new();
    while let Some(name) = ready.pop() {
        if let Some(contents) = blocks.get_mut(&name) {
            let total = count(contents, &counted, hidden);
            counted.insert(name.clone(), total);
        }
        for user in users.get(&name).into_iter().flatten() {
            if let Some(left) = needs.get_mut(user) {
                *left -= 1;
                if *left == 0 {
                    ready.push(user.clone());
                }
            }
        }
    }
    let circular: Vec<String> = blocks.keys().filter(|name| !counted.contains_key(*name)).cloned().collect();
    let without: BTreeMap<String, Counted> = circular
        .into_iter()
        .filter_map(|name| Some((name.clone(), count(blocks.get_mut(&name)?, &counted, hidden))))
        .collect();
    counted.extend(without);
    counted
}

impl Contents {
    fn inserts(&self) -> impl Iterator<Item = &Insert> {
        self.items.iter().filter_map(|item| match &item.shape {
            Shape::Insert(insert) => Some(&**insert),
            _ => None,
        })
    }
}

/// Counts what some contents become; what is not drawn of them is taken out.
fn count(contents: &mut Contents, counted: &BTreeMap<String, Counted>, hidden: &HiddenLayers) -> Counted {
    let mut total = Counted { curves: 0, height: 1, skips: std::mem::take(&mut contents.skips) };
    contents.items.retain(|item| {
        if let Some(why) = hidden_item(item, &item.layer, hidden) {
            total.skips.add(&why, item.place.clone());
            return false;
        }
        match &item.shape {
            Shape::Curves { curves, .. } => {
                total.curves = total.curves.saturating_add(curves.iter().map(weight).sum());
                true
            }
            Shape::Insert(insert) => match counted.get(&insert.name.to_lowercase()) {
                Some(block) if block.height < DEEPEST => {
                    total.curves = total.curves.saturating_add(block.curves.saturating_mul(insert.count()));
                    total.height = total.height.max(block.height + 1);
                    total.skips.add_times(&block.skips, usize::try_from(insert.count()).unwrap_or(usize::MAX));
                    if block.curves == 0 && block.skips.is_empty() {
                        let what = format!("INSERT (the block `{}` is empty)", insert.name);
                        total.skips.add(&what, item.place.clone());
                    }
                    // An array of nothing is nothing, however large.
                    block.curves > 0
                }
                Some(_) => {
                    let what = format!("INSERT (more than {DEEPEST} blocks in each other: `{}`)", insert.name);
                    total.skips.add(&what, item.place.clone());
                    false
                }
                None => {
                    let what = format!("INSERT (there is no block `{}`, or it is within itself)", insert.name);
                    total.skips.add(&what, item.place.clone());
                    false
                }
            },
            Shape::Skipped(_) => false,
        }
    });
    total
}

/// What memory a curve takes, in segments.
fn weight(curve: &Curve) -> u64 {
    match curve {
        Curve::Spline { points, .. } => points.len() as u64,
        _ => 1,
    }
}

/// Why something is not shown on a layer. What is inserted on a layer that is off may lie on others.
fn hidden_item(item: &Item, layer: &str, hidden: &HiddenLayers) -> Option<String> {
    let why = hidden.get(layer)?;
    let inserted = matches!(item.shape, Shape::Insert(_));
    (!inserted || why == Hidden::Frozen).then(|| format!("{} (layer `{layer}` is {})", item.kind, why.name()))
}

/// Puts entities into a drawing.
struct Placing<'a> {
    blocks: &'a BTreeMap<String, Contents>,
    counted: &'a BTreeMap<String, Counted>,
    hidden: &'a HiddenLayers,
    skips: Skips,
    out: Drawing,
}

impl Placing<'_> {
    /// # Arguments
    /// * `inserted`: the layer on which a block is inserted.
    fn place(&mut self, contents: &Contents, map: &Affine, inserted: Option<&str>) {
        for item in &contents.items {
            // What lies on layer 0 of a block is on the layer where it is inserted.
            let own = item.layer.as_str();
            let layer = inserted.filter(|_| own == "0" || own.is_empty()).unwrap_or(own);
            if let Some(why) = hidden_item(item, layer, self.hidden) {
                self.skips.add(&why, item.place.clone());
                continue;
            }
            match &item.shape {
                Shape::Curves { curves, closed } => self.draw(item, curves, *closed, layer, map),
                Shape::Insert(insert) => self.insert(item, insert, layer, map),
                Shape::Skipped(_) => {}
            }
        }
    }

    fn draw(&mut self, item: &Item, curves: &[Curve], closed: bool, layer: &str, map: &Affine) {
        let curves: Vec<Curve> = curves.iter().map(|curve| curve.mapped(map)).collect();
        // Blocks may be scaled to nothing, or put far away.
        if let Some(fault) = curves.iter().find_map(|curve| curve.drawable().err()) {
            return self.skips.add(&format!("{} ({fault})", item.kind), item.place.clone());
        }
        let (Place::Line(line) | Place::Byte(line)) = item.at;
        let (kind, layer) = (item.kind.clone(), layer.to_owned());
        self.out.entities.push(Entity { kind, layer, line, curves, closed, fill: None });
    }

    fn insert(&mut self, item: &Item, insert: &Insert, layer: &str, map: &Affine) {
        let name = insert.name.to_lowercase();
        let (Some(block), true) = (self.blocks.get(&name), self.counted.contains_key(&name)) else { return };
        let base = match &block.base {
            Ok(base) => *base,
            Err(fault) => {
                let what = format!("INSERT (base point of the block `{}`: {fault})", insert.name);
                return self.skips.add(&what, item.place.clone());
            }
        };
        for row in 0..insert.rows {
            for column in 0..insert.columns {
                let inner = insert.placement(base, [column as f64, row as f64]);
                self.place(block, &map.after(&inner), Some(layer));
            }
        }
    }
}
