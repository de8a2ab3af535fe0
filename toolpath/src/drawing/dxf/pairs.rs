//! The lines of a DXF file: pairs of a group code and a value, and records that begin with code 0.

use super::DxfError;
use std::io::BufRead;

/// A line longer than this is no DXF.
const LONGEST_LINE: u64 = 1 << 16;

/// A group code with its value.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    pub code: i32,
    pub value: String,
    /// The line of the value.
    pub line: u64,
}

impl Pair {
    pub fn number(&self) -> Result<f64, DxfError> {
        let number = self.value.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| DxfError::Number { line: self.line, text: self.short() })
    }

    pub fn whole(&self) -> Result<i64, DxfError> {
        self.value.parse().map_err(|_| DxfError::Number { line: self.line, text: self.short() })
    }

    /// The value, cut to what a message can hold.
    fn short(&self) -> String {
        self.value.chars().take(40).collect()
    }
}

/// An entity, or what else begins with code 0.
#[derive(Clone, Debug)]
pub(super) struct Record {
    pub kind: String,
    /// The line of its kind.
    pub line: u64,
    pub pairs: Vec<Pair>,
}

impl Record {
    pub fn find(&self, code: i32) -> Option<&Pair> {
        self.pairs.iter().find(|pair| pair.code == code)
    }

    pub fn text(&self, code: i32) -> &str {
        self.find(code).map_or("", |pair| &pair.value)
    }

    pub fn number_or(&self, code: i32, default: f64) -> Result<f64, DxfError> {
        self.find(code).map_or(Ok(default), Pair::number)
    }

    pub fn whole_or(&self, code: i32, default: i64) -> Result<i64, DxfError> {
        self.find(code).map_or(Ok(default), Pair::whole)
    }

    pub fn number(&self, code: i32) -> Result<f64, DxfError> {
        let missing = || DxfError::Missing { line: self.line, kind: self.kind.clone(), code };
        self.find(code).ok_or_else(missing)?.number()
    }

    /// All numbers of a code, in order.
    pub fn numbers(&self, code: i32) -> Result<Vec<f64>, DxfError> {
        self.pairs.iter().filter(|pair| pair.code == code).map(Pair::number).collect()
    }
}

/// Reads records one after the other.
pub(super) struct Records<R> {
    reader: R,
    line: u64,
    next: Option<Pair>,
}

impl<R: BufRead> Records<R> {
    pub fn new(reader: R) -> Self {
        Records { reader, line: 0, next: None }
    }

    pub fn line(&self) -> u64 {
        self.line
    }

    /// The next record; `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<Record>, DxfError> {
        let head = match self.next.take() {
            Some(head) => head,
            None => match self.pair()? {
                // Comments stand before the first record.
                Some(pair) if pair.code == 999 => return self.next(),
                Some(pair) if pair.code == 0 => pair,
                Some(pair) => return Err(DxfError::NoDxf { line: pair.line }),
                None => return Ok(None),
            },
        };
        let mut record = Record { kind: head.value, line: head.line, pairs: Vec::new() };
        while let Some(pair) = self.pair()? {
            if pair.code == 0 {
                self.next = Some(pair);
                break;
            }
            record.pairs.push(pair);
        }
        // Only what ends something can be the last: another record may be cut short.
        if self.next.is_none() && !["EOF", "ENDSEC"].contains(&record.kind.as_str()) {
            return Err(DxfError::Truncated { line: self.line });
        }
        Ok(Some(record))
    }

    fn pair(&mut self) -> Result<Option<Pair>, DxfError> {
        let Some(code) = self.read_line()? else { return Ok(None) };
        let code_line = self.line;
        if code.is_empty() && self.reader.fill_buf()?.is_empty() {
            // An empty line at the end.
            return Ok(None);
        }
        let code = code.parse().map_err(|_| DxfError::NoDxf { line: code_line })?;
        let value = self.read_line()?.ok_or(DxfError::Truncated { line: code_line })?;
        Ok(Some(Pair { code, value, line: self.line }))
    }

    fn read_line(&mut self) -> Result<Option<String>, DxfError> {
        let mut bytes = Vec::new();
        let read = std::io::Read::take(&mut self.reader, LONGEST_LINE).read_until(b'\n', &mut bytes)?;
        if read == 0 {
            return Ok(None);
        }
        self.line += 1;
        if read as u64 == LONGEST_LINE && bytes.last() != Some(&b'\n') {
            return Err(DxfError::NoDxf { line: self.line });
        }
        Ok(Some(String::from_utf8_lossy(&bytes).trim().to_owned()))
    }
}
