//! Lines of a file, one at a time, and the words in them.

use super::numbers::checksum;
use super::{LONGEST_LINE, ReadError};
use std::io::{self, BufRead};

/// Characters of a number: 17 digits say all of a double, and some write zeros before and behind.
const LONGEST_NUMBER: usize = 40;

/// Bytes of a file that an error quotes.
const QUOTED: usize = 40;

#[derive(Debug)]
pub(super) struct Lines<R> {
    reader: R,
    line: Vec<u8>,
    /// Lines begun.
    row: u64,
    at: usize,
}

/// A word's name, its number and where it begins in its line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Word {
    /// The letter, upper case.
    pub letter: u8,
    /// Upper case, when the letter is `n` and one more follows.
    pub second: Option<u8>,
    pub value: f64,
    pub start: usize,
}

impl Word {
    pub fn name(&self) -> String {
        match self.second {
            Some(second) => format!("n{}", char::from(second)),
            None => char::from(self.letter).to_string(),
        }
    }
}

impl<R: BufRead> Lines<R> {
    pub fn new(reader: R) -> Self {
        Lines { reader, line: Vec::new(), row: 0, at: 0 }
    }

    pub fn row(&self) -> u64 {
        self.row
    }

    /// Takes the next line, without its end; false at the end of the file.
    pub fn next_line(&mut self) -> Result<bool, ReadError> {
        self.line.clear();
        self.at = 0;
        let mut any = false;
        loop {
            let held = match self.reader.fill_buf() {
                Ok(held) => held,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(source) => return Err(ReadError::Io { line: self.row, source }),
            };
            if held.is_empty() {
                return Ok(any);
            }
            self.row += u64::from(!any);
            any = true;
            let end = held.iter().position(|&byte| byte == b'\n');
            let part = &held[..end.unwrap_or(held.len())];
            if self.line.len() + part.len() > LONGEST_LINE {
                return Err(ReadError::LineTooLong { line: self.row, most: LONGEST_LINE });
            }
            self.line.extend_from_slice(part);
            let used = part.len() + usize::from(end.is_some());
            self.reader.consume(used);
            if end.is_some() {
                return Ok(true);
            }
        }
    }

    /// What is left of the line.
    pub fn rest(&self) -> &[u8] {
        self.line.get(self.at..).unwrap_or_default()
    }

    /// Where the rest begins, from 0.
    pub fn at(&self) -> usize {
        self.at
    }

    /// Passes over so many bytes.
    pub fn skip(&mut self, bytes: usize) {
        self.at = (self.at + bytes).min(self.line.len());
    }

    pub fn skip_spaces(&mut self) {
        while self.line.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    /// The next word of the line, past comments.
    pub fn word(&mut self) -> Result<Option<Word>, ReadError> {
        loop {
            self.skip_spaces();
            match self.line.get(self.at) {
                None | Some(b';' | b'*') => return Ok(None),
                Some(b'(') => match self.line[self.at..].iter().position(|&byte| byte == b')') {
                    Some(length) => self.at += length + 1,
                    None => return Err(self.unexpected(self.at, "a comment that ends in its line")),
                },
                Some(byte) if byte.is_ascii_alphabetic() => break,
                Some(_) => return Err(self.unexpected(self.at, "a word: a letter and a number")),
            }
        }
        let start = self.at;
        let letter = self.line[start].to_ascii_uppercase();
        self.at += 1;
        let next = self.line.get(self.at).map(u8::to_ascii_uppercase);
        let second = next.filter(|byte| letter == b'N' && matches!(byte, b'X' | b'Y' | b'Z'));
        self.at += usize::from(second.is_some());
        self.skip_spaces();
        let value = self.number()?;
        Ok(Some(Word { letter, second, value, start }))
    }

    /// The checksum that the words end with, if they have one: what it should be, and what it is; with the place of the `*`.
    pub fn checksum(&mut self) -> Result<Option<([u8; 2], usize)>, ReadError> {
        let star = self.at;
        if self.line.get(star) != Some(&b'*') {
            return Ok(None);
        }
        self.at += 1;
        self.skip_spaces();
        let start = self.at;
        let value = self.number()?;
        let given = value as u8;
        if (f64::from(given) - value).abs() > 0.0 {
            return Err(self.unexpected(start, "a checksum, 0 to 255"));
        }
        self.skip_spaces();
        match self.line.get(self.at) {
            None | Some(b';') => Ok(Some(([checksum(&self.line[..star]), given], star))),
            Some(_) => Err(self.unexpected(self.at, "the end of the line behind a checksum")),
        }
    }

    /// The three numbers of the comment that the words end with, if it begins with a tag; with where each stands.
    pub fn tagged(&mut self, tag: &str) -> Result<Option<[(f64, usize); 3]>, ReadError> {
        if !self.line[self.at.min(self.line.len())..].starts_with(tag.as_bytes()) {
            return Ok(None);
        }
        self.at += tag.len();
        let mut numbers = [(0.0, 0); 3];
        for number in &mut numbers {
            self.skip_spaces();
            let start = self.at;
            *number = (self.number()?, start);
        }
        self.skip_spaces();
        match self.line.get(self.at) {
            None => Ok(Some(numbers)),
            Some(_) => Err(self.unexpected(self.at, "the end of the line behind a direction")),
        }
    }

    /// A decimal number: sign, digits, one point. No exponent: `E` is a word.
    pub fn number(&mut self) -> Result<f64, ReadError> {
        const POWERS: [f64; 16] =
            [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
        let start = self.at;
        let text = &self.line[start..];
        let signed = matches!(text.first(), Some(b'-' | b'+'));
        let mut length = usize::from(signed);
        let (mut whole, mut digits, mut decimals, mut point) = (0u64, 0, 0, false);
        while let Some(&byte) = text.get(length) {
            match byte {
                b'0'..=b'9' => {
                    // Fifteen digits are below 2^53; beyond, the value is not used.
                    whole = whole.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                    digits += 1;
                    decimals += usize::from(point);
                }
                b'.' if !point => point = true,
                _ => break,
            }
            length += 1;
        }
        if digits == 0 || text.get(length) == Some(&b'.') {
            return Err(self.unexpected(start, "a number"));
        }
        if length > LONGEST_NUMBER {
            return Err(ReadError::NumberTooLong { line: self.row, column: start as u64 + 1, most: LONGEST_NUMBER });
        }
        // An exact whole number over an exact power of ten: the quotient is the double next to what is written.
        let value = match POWERS.get(decimals) {
            Some(power) if digits <= 15 => whole as f64 / power,
            _ => {
                let text = std::str::from_utf8(&text[usize::from(signed)..length]).ok();
                text.and_then(|text| text.parse().ok()).ok_or_else(|| self.unexpected(start, "a number"))?
            }
        };
        let negative = text.first() == Some(&b'-');
        self.at = start + length;
        Ok(if negative { -value } else { value })
    }

    /// Up to 40 bytes of the word at `start`.
    pub fn quote(&self, start: usize) -> String {
        let text = self.line.get(start..).unwrap_or_default();
        let text = &text[..text.len().min(QUOTED)];
        let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        if end == 0 { "the end of the word".to_owned() } else { String::from_utf8_lossy(&text[..end]).into_owned() }
    }

    pub fn unexpected(&self, start: usize, expected: &'static str) -> ReadError {
        ReadError::Unexpected { line: self.row, column: start as u64 + 1, expected, found: self.quote(start) }
    }
}

#[cfg(test)]
mod tests {
    use super::Lines;

    fn first(text: &str) -> Result<f64, String> {
        let mut lines = Lines::new(text.as_bytes());
        lines.next_line().map_err(|error| error.to_string())?;
        lines.word().map(|word| word.unwrap().value).map_err(|error| error.to_string())
    }

    #[test]
    fn numbers_are_those_of_the_standard_library() {
        let texts =
            ["0", "-0", "+1.5", "-12.0625", ".5", "5.", "0.0000000000000000012", "123456789012345", "99999.999999999"];
        for text in
            texts.into_iter().chain(["1234567890.1234567890123", "-0.30000000000000004", "18446744073709551616.5"])
        {
            assert_eq!(
                first(&format!("x {text}")).map(f64::to_bits),
                Ok(text.parse::<f64>().unwrap().to_bits()),
                "{text}"
            );
        }
        for text in ["", "-", ".", "+.", "1.2.3", "nan", "inf", "--1", "e5", "\u{2212}1"] {
            assert!(first(&format!("X{text}")).is_err(), "{text}");
        }
        assert_eq!(
            first(&format!("X{}", "1".repeat(41))).unwrap_err(),
            "line 1, column 2: the number is longer than 40 characters"
        );
    }
}
