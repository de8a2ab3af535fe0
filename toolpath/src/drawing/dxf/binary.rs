//! Binary DXF files: the same pairs, with codes and numbers as bytes, the least significant first.
//!
//! AutoCAD R12 and before has codes of one byte, with 255 before a code of two; later ones have two bytes always. What follows
//! depends on the code: the table of group codes in the DXF reference.

use super::error::{DxfError, Place};
use super::pair::{LONGEST_TEXT, Pair};
use super::text::Decoder;
use std::io::{BufRead, ErrorKind, Read};

const SENTINEL: &[u8; 22] = b"AutoCAD Binary DXF\r\n\x1a\0";

/// What a group code is followed by.
enum Kind {
    Text,
    Double,
    Int16,
    Int32,
    Int64,
    Byte,
    Chunk,
}

/// The pairs of a binary file.
pub(super) struct BinaryPairs<R> {
    reader: R,
    /// Bytes read.
    at: u64,
    /// Codes have two bytes.
    wide: bool,
    /// The first pair, with which the width of codes was found.
    first: Option<Pair>,
}

impl<R: BufRead> BinaryPairs<R> {
    /// Whether a file begins as a binary one.
    pub fn is_binary(begin: &[u8]) -> bool {
        begin.starts_with(&SENTINEL[..18])
    }

    /// Starts to read: the first pair is `0 SECTION`, or a comment.
    pub fn new(reader: R) -> Result<Self, DxfError> {
        let mut pairs = BinaryPairs { reader, at: 0, wide: true, first: None };
        if pairs.bytes::<22>()?.is_none_or(|begin| begin != *SENTINEL) {
            return Err(DxfError::NoDxf { at: Place::Byte(0) });
        }
        let Some([code]) = pairs.bytes::<1>()? else { return Ok(pairs) };
        // A code of two bytes is 0 0, or 231 3 for a comment; one of one byte is 0 or, for a comment, 255 231 3.
        let next = pairs.reader.fill_buf()?.first().copied();
        pairs.wide = (code == 0 && next == Some(0)) || (code != 0 && code != 255);
        let code = match (pairs.wide, code) {
            (true, low) => pairs.bytes::<1>()?.map(|[high]| i32::from(i16::from_le_bytes([low, high]))),
            (false, 255) => pairs.bytes::<2>()?.map(|code| i32::from(i16::from_le_bytes(code))),
            (false, code) => Some(i32::from(code)),
        };
        let code = code.ok_or(DxfError::Truncated { at: Place::Byte(pairs.at) })?;
        let value = pairs.text()?;
        pairs.first =
            Some(Pair { code, value: Decoder::default().text(&value), at: Place::Byte(SENTINEL.len() as u64) });
        Ok(pairs)
    }

    /// Bytes read so far.
    pub fn at(&self) -> u64 {
        self.at
    }

    /// The next pair; `None` at the end of the file.
    pub fn next(&mut self, decoder: &Decoder) -> Result<Option<Pair>, DxfError> {
        if let Some(first) = self.first.take() {
            return Ok(Some(first));
        }
        let at = Place::Byte(self.at);
        let Some(code) = self.code()? else { return Ok(None) };
        let truncated = || DxfError::Truncated { at };
        let value = match kind(code).ok_or(DxfError::NoDxf { at })? {
            Kind::Text => decoder.text(&self.text()?),
            Kind::Double => format!("{:?}", f64::from_le_bytes(self.bytes()?.ok_or_else(truncated)?)),
            Kind::Int16 => i16::from_le_bytes(self.bytes()?.ok_or_else(truncated)?).to_string(),
            Kind::Int32 => i32::from_le_bytes(self.bytes()?.ok_or_else(truncated)?).to_string(),
            Kind::Int64 => i64::from_le_bytes(self.bytes()?.ok_or_else(truncated)?).to_string(),
            Kind::Byte => self.bytes::<1>()?.ok_or_else(truncated)?[0].to_string(),
            Kind::Chunk => {
                let [length] = self.bytes()?.ok_or_else(truncated)?;
                for _ in 0..length {
                    self.bytes::<1>()?.ok_or_else(truncated)?;
                }
                String::new()
            }
        };
        Ok(Some(Pair { code, value, at }))
    }

    fn code(&mut self) -> Result<Option<i32>, DxfError> {
        if self.wide {
            return Ok(self.bytes()?.map(|code| i32::from(i16::from_le_bytes(code))));
        }
        match self.bytes()? {
            Some([255]) => Ok(self.bytes()?.map(|code| i32::from(i16::from_le_bytes(code)))),
            code => Ok(code.map(|[code]| i32::from(code))),
        }
    }

    /// A text up to its zero byte.
    fn text(&mut self) -> Result<Vec<u8>, DxfError> {
        let mut bytes = Vec::new();
        let read = Read::take(&mut self.reader, LONGEST_TEXT as u64).read_until(0, &mut bytes)?;
        let at = Place::Byte(self.at);
        self.at += read as u64;
        match bytes.pop() {
            Some(0) => Ok(bytes.trim_ascii().to_vec()),
            _ if read == LONGEST_TEXT => Err(DxfError::NoDxf { at }),
            _ => Err(DxfError::Truncated { at }),
        }
    }

    /// So many bytes; `None` if the file ends before.
    fn bytes<const N: usize>(&mut self) -> Result<Option<[u8; N]>, DxfError> {
        let mut bytes = [0; N];
        match self.reader.read_exact(&mut bytes) {
            Ok(()) => {
                self.at += N as u64;
                Ok(Some(bytes))
            }
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(None),
            Err(error) => Err(error.into()),
        }
    }
}

/// What follows a group code; `None` for a code that there is not.
fn kind(code: i32) -> Option<Kind> {
    Some(match code {
        0..=9 | 100..=109 | 300..=309 | 320..=369 | 390..=399 | 410..=419 | 430..=439 | 470..=481 | 999..=1003 => {
            Kind::Text
        }
        1005..=1009 => Kind::Text,
        10..=59 | 110..=149 | 210..=239 | 460..=469 | 1010..=1059 => Kind::Double,
        60..=79 | 170..=179 | 270..=289 | 370..=389 | 400..=409 | 1060..=1070 => Kind::Int16,
        90..=99 | 420..=429 | 440..=459 | 1071 => Kind::Int32,
        160..=169 => Kind::Int64,
        290..=299 => Kind::Byte,
        310..=319 | 1004 => Kind::Chunk,
        _ => return None,
    })
}
