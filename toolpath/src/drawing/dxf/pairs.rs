//! The pairs of a DXF file, a group code and a value each, and records that begin with code 0.

use super::binary::BinaryPairs;
use super::error::{DxfError, Place};
use super::pair::{LONGEST_TEXT, Pair, Record};
use super::text::Decoder;
use std::io::{self, BufRead};

/// Reads records one after the other.
pub(super) struct Records<R> {
    source: Source<R>,
    next: Option<Pair>,
    /// How texts are decoded; the header changes it.
    pub decoder: Decoder,
}

enum Source<R> {
    Text { reader: R, line: u64 },
    Binary(BinaryPairs<R>),
}

impl<R: BufRead> Records<R> {
    pub fn new(mut reader: R) -> Result<Self, DxfError> {
        let source = match BinaryPairs::<R>::is_binary(reader.fill_buf()?) {
            true => Source::Binary(BinaryPairs::new(reader)?),
            false => Source::Text { reader, line: 0 },
        };
        Ok(Records { source, next: None, decoder: Decoder::default() })
    }

    /// How far it has read.
    pub fn at(&self) -> Place {
        match &self.source {
            Source::Text { line, .. } => Place::Line(*line),
            Source::Binary(pairs) => Place::Byte(pairs.at()),
        }
    }

    /// The next record; `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<Record>, DxfError> {
        let head = match self.next.take() {
            Some(head) => head,
            None => loop {
                match self.pair()? {
                    // Comments stand before the first record.
                    Some(pair) if pair.code == 999 => {}
                    Some(pair) if pair.code == 0 => break pair,
                    Some(pair) => return Err(DxfError::NoDxf { at: pair.at }),
                    None => return Ok(None),
                }
            },
        };
        let mut record = Record { kind: head.value, at: head.at, pairs: Vec::new() };
        while let Some(pair) = self.pair()? {
            if pair.code == 0 {
                self.next = Some(pair);
                break;
            }
            record.pairs.push(pair);
        }
        // Only what ends something can be the last: another record may be cut short.
        if self.next.is_none() && !["EOF", "ENDSEC"].contains(&record.kind.as_str()) {
            return Err(DxfError::Truncated { at: self.at() });
        }
        Ok(Some(record))
    }

    fn pair(&mut self) -> Result<Option<Pair>, DxfError> {
        match &mut self.source {
            Source::Text { reader, line } => text_pair(reader, line, &self.decoder),
            Source::Binary(pairs) => pairs.next(&self.decoder),
        }
    }
}

/// The next record of a section.
pub(super) fn next_in_section<R: BufRead>(records: &mut Records<R>) -> Result<Record, DxfError> {
    match records.next()? {
        Some(record) if record.kind != "EOF" && record.kind != "SECTION" => Ok(record),
        _ => Err(DxfError::Truncated { at: records.at() }),
    }
}

/// Two lines: the code and the value.
fn text_pair<R: BufRead>(reader: &mut R, line: &mut u64, decoder: &Decoder) -> Result<Option<Pair>, DxfError> {
    let Some(code) = read_line(reader, line)? else { return Ok(None) };
    let at = Place::Line(*line);
    if code.is_empty() && reader.fill_buf()?.is_empty() {
        // An empty line at the end.
        return Ok(None);
    }
    let code = std::str::from_utf8(&code).ok().and_then(|code| code.trim().parse().ok());
    let code = code.ok_or(DxfError::NoDxf { at })?;
    let value = read_line(reader, line)?.ok_or(DxfError::Truncated { at })?;
    Ok(Some(Pair { code, value: decoder.text(&value), at: Place::Line(*line) }))
}

/// Bytes that mark UTF-8 at the begin of a file.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

fn read_line<R: BufRead>(reader: &mut R, line: &mut u64) -> Result<Option<Vec<u8>>, DxfError> {
    let mut bytes = Vec::new();
    let read = io::Read::take(&mut *reader, LONGEST_TEXT as u64).read_until(b'\n', &mut bytes)?;
    if read == 0 {
        return Ok(None);
    }
    *line += 1;
    if read == LONGEST_TEXT && bytes.last() != Some(&b'\n') {
        return Err(DxfError::NoDxf { at: Place::Line(*line) });
    }
    let text = match *line {
        1 => bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&bytes),
        _ => &bytes,
    };
    Ok(Some(text.trim_ascii().to_vec()))
}
