//! The pairs of a DXF file, a group code and a value each, and records that begin with code 0.

use super::binary::BinaryPairs;
use super::text::Decoder;
use super::{DxfError, Fault, Place};
use std::io::{self, BufRead};

/// A line or a text longer than this is no DXF.
pub(super) const LONGEST_TEXT: usize = 1 << 16;

/// A group code with its value.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    pub code: i32,
    pub value: String,
    /// Where the value is.
    pub at: Place,
}

impl Pair {
    pub fn number(&self) -> Result<f64, Fault> {
        let number = self.value.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.fault("is not a finite number"))
    }

    pub fn whole(&self) -> Result<i64, Fault> {
        self.value.parse().map_err(|_| self.fault("is not a whole number"))
    }

    fn fault(&self, what: &str) -> Fault {
        let short: String = self.value.chars().take(40).collect();
        Fault { what: format!("`{short}` {what}"), at: Some(self.at) }
    }
}

/// An entity, or what else begins with code 0.
#[derive(Clone, Debug)]
pub(super) struct Record {
    pub kind: String,
    /// Where its kind is.
    pub at: Place,
    pub pairs: Vec<Pair>,
}

impl Record {
    pub fn find(&self, code: i32) -> Option<&Pair> {
        self.pairs.iter().find(|pair| pair.code == code)
    }

    pub fn text(&self, code: i32) -> &str {
        self.find(code).map_or("", |pair| &pair.value)
    }

    pub fn number_or(&self, code: i32, default: f64) -> Result<f64, Fault> {
        self.find(code).map_or(Ok(default), Pair::number)
    }

    pub fn whole_or(&self, code: i32, default: i64) -> Result<i64, Fault> {
        self.find(code).map_or(Ok(default), Pair::whole)
    }

    pub fn number(&self, code: i32) -> Result<f64, Fault> {
        self.find(code).ok_or_else(|| Fault::new(format!("there is no value with group code {code}")))?.number()
    }

    /// All numbers of a code, in order.
    pub fn numbers(&self, code: i32) -> Result<Vec<f64>, Fault> {
        self.pairs.iter().filter(|pair| pair.code == code).map(Pair::number).collect()
    }

    /// Where it is, with its handle, by which CAD programs find it.
    pub fn place(&self, at: Option<Place>) -> String {
        let (at, handle) = (at.unwrap_or(self.at), self.text(5));
        if handle.is_empty() { at.to_string() } else { format!("{at} (handle {handle})") }
    }
}

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
