//! Words and numbers on their way out of a file, with the place of each; memory is one line.

use crate::program::check::MAX_NUMBER;
use std::io::{self, BufRead};

/// Longest line that is read, in bytes: our lines have less than 400, and no file may fill the memory.
const MAX_LINE: usize = 16 * 1024;

/// What some editors put before a text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Characters of a file that an error quotes.
const QUOTED: usize = 40;

/// Why a program could not be read. Lines and columns are counted from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// Something else stands there.
    #[error("line {line}, column {column}: expected {expected}, found {found}")]
    Unexpected {
        /// The line.
        line: u64,
        /// The column, in bytes.
        column: u64,
        /// What belongs there.
        expected: &'static str,
        /// What stands there.
        found: String,
    },
    /// A number cannot be what it stands for.
    #[error("line {line}, column {column}: {value} cannot be {what}")]
    Number {
        /// The line.
        line: u64,
        /// The column, in bytes.
        column: u64,
        /// What it stands for.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// A line has no end.
    #[error("line {line} is longer than {most} bytes")]
    LineTooLong {
        /// The line.
        line: u64,
        /// Bytes allowed.
        most: usize,
    },
    /// The input cannot be read.
    #[error("after line {line}: {source}")]
    Io {
        /// Lines read.
        line: u64,
        /// The cause.
        source: io::Error,
    },
    /// A module that the main loads cannot be opened.
    #[error("module {index}, `{file}`, cannot be opened: {source}")]
    Part {
        /// Which of the modules, counted from 0.
        index: usize,
        /// Its file.
        file: String,
        /// The cause.
        source: io::Error,
    },
    /// A module that the main loads cannot be read.
    #[error("module {index}, `{file}`: {source}")]
    InPart {
        /// Which of the modules, counted from 0.
        index: usize,
        /// Its file.
        file: String,
        /// The cause.
        source: Box<ReadError>,
    },
}

/// What stands in a file. Words and texts are places in the line that is being read: they are looked at before the next token, which may be in another line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Token {
    Word(usize, usize),
    Text(usize, usize),
    Number(f64),
    Mark(u8),
    End,
}

/// A number at the head of a line in plain decimals, with its length: an exact whole number over an exact power of
/// ten, so the quotient is the double next to what is written. `None` when there is none, or it is written otherwise.
fn plain_number(text: &[u8]) -> Option<(f64, usize)> {
    const POWERS: [f64; 16] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
    let negative = text.first() == Some(&b'-');
    let mut at = usize::from(negative);
    let (mut whole, mut digits, mut decimals, mut point) = (0u64, 0, 0, false);
    while let Some(&byte) = text.get(at) {
        match byte {
            b'0'..=b'9' => {
                whole = whole * 10 + u64::from(byte - b'0');
                digits += 1;
                decimals += usize::from(point);
                // Fifteen digits are below 2^53.
                if digits > 15 {
                    return None;
                }
            }
            b'.' if !point => point = true,
            b'.' | b'_' | b'a'..=b'z' | b'A'..=b'Z' => return None,
            _ => break,
        }
        at += 1;
    }
    if digits == 0 {
        return None;
    }
    let value = whole as f64 / POWERS[decimals];
    Some((if negative { -value } else { value }, at))
}

/// Tokens of a file in which comments run from one character to the end of the line.
#[derive(Debug)]
pub(crate) struct Tokens<R> {
    reader: R,
    comment: u8,
    line: Vec<u8>,
    at: usize,
    /// Where the last token begins.
    start: usize,
    row: u64,
    peeked: Option<Token>,
}

impl<R: BufRead> Tokens<R> {
    pub fn new(reader: R, comment: u8) -> Self {
        Tokens { reader, comment, line: Vec::new(), at: 0, start: 0, row: 0, peeked: None }
    }

    /// Reads the next line without its end; false at the end of the file.
    pub fn next_line(&mut self) -> Result<bool, ReadError> {
        self.line.clear();
        (self.at, self.start) = (0, 0);
        let mut any = false;
        loop {
            let held = match self.reader.fill_buf() {
                Ok(held) => held,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(source) => return Err(ReadError::Io { line: self.row, source }),
            };
            if held.is_empty() {
                self.row += u64::from(any);
                return Ok(any);
            }
            // A byte-order mark at the begin of a file.
            if self.row == 0 && !any && held.starts_with(BYTE_ORDER_MARK) {
                self.reader.consume(BYTE_ORDER_MARK.len());
                any = true;
                continue;
            }
            any = true;
            let end = held.iter().position(|&byte| byte == b'\n');
            let part = &held[..end.unwrap_or(held.len())];
            if self.line.len() + part.len() > MAX_LINE {
                return Err(ReadError::LineTooLong { line: self.row + 1, most: MAX_LINE });
            }
            self.line.extend_from_slice(part);
            let used = part.len() + usize::from(end.is_some());
            self.reader.consume(used);
            if end.is_some() {
                self.row += 1;
                return Ok(true);
            }
        }
    }

    /// Goes on behind the next `%%%`, through any lines.
    pub fn skip_header(&mut self) -> Result<(), ReadError> {
        self.peeked = None;
        loop {
            let rest = &self.line[self.at..];
            if let Some(found) = rest.windows(3).position(|three| three == b"%%%") {
                self.at += found + 3;
                return Ok(());
            }
            if !self.next_line()? {
                return Err(self.unexpected("%%% at the end of the header", Token::End));
            }
        }
    }

    /// Goes on behind the end of the line.
    pub fn skip_line(&mut self) {
        self.peeked = None;
        self.at = self.line.len();
    }

    /// The line that is being read.
    pub fn line(&self) -> &[u8] {
        &self.line
    }

    /// The next token; it stays the next one.
    pub fn peek(&mut self) -> Result<Token, ReadError> {
        if let Some(token) = self.peeked {
            return Ok(token);
        }
        let token = self.scan()?;
        self.peeked = Some(token);
        Ok(token)
    }

    pub fn next(&mut self) -> Result<Token, ReadError> {
        match self.peeked.take() {
            Some(token) => Ok(token),
            None => self.scan(),
        }
    }

    fn scan(&mut self) -> Result<Token, ReadError> {
        loop {
            while self.line.get(self.at).is_some_and(u8::is_ascii_whitespace) {
                self.at += 1;
            }
            if self.line.get(self.at).is_some_and(|&byte| byte != self.comment) {
                break;
            }
            if !self.next_line()? {
                return Ok(Token::End);
            }
        }
        self.start = self.at;
        let byte = self.line[self.at];
        let run = |from: usize, more: &dyn Fn(u8) -> bool| {
            self.line[from..].iter().position(|&b| !more(b)).map_or(self.line.len(), |length| from + length)
        };
        let following = self.line.get(self.at + 1);
        let signed = byte == b'-' && following.is_some_and(|b| b.is_ascii_digit() || *b == b'.');
        if byte.is_ascii_digit() || byte == b'.' || signed {
            let mut end = self.at + 1;
            while let Some(&b) = self.line.get(end) {
                let exponent_sign = matches!(b, b'-' | b'+') && matches!(self.line[end - 1], b'e' | b'E');
                if !(b.is_ascii_alphanumeric() || b == b'.' || exponent_sign) {
                    break;
                }
                end += 1;
            }
            self.at = end;
            let text = std::str::from_utf8(&self.line[self.start..end]).unwrap_or("");
            let value: Option<f64> = text.parse().ok().filter(|value: &f64| value.is_finite());
            return value.map(Token::Number).ok_or_else(|| self.unexpected("a number", Token::Word(self.start, end)));
        }
        if byte.is_ascii_alphabetic() || byte == b'_' {
            self.at = run(self.at, &|b| b.is_ascii_alphanumeric() || b == b'_');
            return Ok(Token::Word(self.start, self.at));
        }
        if byte == b'"' {
            let end = run(self.at + 1, &|b| b != b'"');
            if end == self.line.len() {
                return Err(self.unexpected("the end of the text in its line", Token::Word(self.start, end)));
            }
            self.at = end + 1;
            return Ok(Token::Text(self.start + 1, end));
        }
        self.at += 1;
        Ok(Token::Mark(byte))
    }

    fn quoted(&self, token: Token) -> String {
        let quote = |bytes: &[u8]| String::from_utf8_lossy(&bytes[..bytes.len().min(QUOTED)]).into_owned();
        match token {
            Token::Word(from, to) => format!("`{}`", quote(&self.line[from..to])),
            Token::Text(from, to) => format!("\"{}\"", quote(&self.line[from..to])),
            Token::Number(value) => value.to_string(),
            Token::Mark(byte) => format!("`{}`", char::from(byte).escape_default()),
            Token::End => "the end of the file".to_owned(),
        }
    }

    /// The place of the last token.
    pub fn place(&self) -> (u64, u64) {
        (self.row.max(1), self.start as u64 + 1)
    }

    pub fn unexpected(&self, expected: &'static str, token: Token) -> ReadError {
        let (line, column) = self.place();
        ReadError::Unexpected { line, column, expected, found: self.quoted(token) }
    }

    /// The same for a word that has been read before, at its own place.
    pub fn unexpected_at(&self, (line, column): (u64, u64), expected: &'static str, word: &str) -> ReadError {
        let found: String = word.chars().take(QUOTED).collect();
        ReadError::Unexpected { line, column, expected, found: format!("`{found}`") }
    }

    pub fn wrong(&self, what: &'static str, value: f64) -> ReadError {
        let (line, column) = self.place();
        ReadError::Number { line, column, what, value }
    }

    pub fn is_word(&self, token: Token, word: &str) -> bool {
        matches!(token, Token::Word(from, to) if self.line[from..to].eq_ignore_ascii_case(word.as_bytes()))
    }

    /// One of these words, whatever the case.
    pub fn expect_word(&mut self, word: &'static str) -> Result<(), ReadError> {
        let token = self.next()?;
        if self.is_word(token, word) { Ok(()) } else { Err(self.unexpected(word, token)) }
    }

    pub fn name(&mut self, expected: &'static str) -> Result<String, ReadError> {
        match self.next()? {
            Token::Word(from, to) => Ok(String::from_utf8_lossy(&self.line[from..to]).into_owned()),
            other => Err(self.unexpected(expected, other)),
        }
    }

    pub fn string(&mut self, expected: &'static str) -> Result<String, ReadError> {
        match self.next()? {
            Token::Text(from, to) => Ok(String::from_utf8_lossy(&self.line[from..to]).into_owned()),
            other => Err(self.unexpected(expected, other)),
        }
    }

    pub fn word_at(&self, from: usize, to: usize) -> &[u8] {
        &self.line[from..to]
    }

    /// Each of these marks.
    #[inline]
    pub fn marks(&mut self, marks: &'static str) -> Result<(), ReadError> {
        for &mark in marks.as_bytes() {
            // Most stand right here.
            if self.peeked.is_none() && self.line.get(self.at) == Some(&mark) {
                self.start = self.at;
                self.at += 1;
                continue;
            }
            let token = self.next()?;
            if token != Token::Mark(mark) {
                return Err(self.unexpected(marks, token));
            }
        }
        Ok(())
    }

    /// A number, with a sign before it or without.
    #[inline]
    pub fn number(&mut self) -> Result<f64, ReadError> {
        if self.peeked.is_none()
            && let Some((value, length)) = plain_number(&self.line[self.at..])
        {
            self.start = self.at;
            self.at += length;
            return Ok(value);
        }
        let mut sign = 1.0;
        loop {
            match self.next()? {
                Token::Number(value) => return Ok(sign * value),
                Token::Mark(b'-') if sign > 0.0 => sign = -1.0,
                Token::Mark(b'+') => {}
                other => return Err(self.unexpected("a number", other)),
            }
        }
    }

    /// A number between two, both included.
    #[inline]
    pub fn within(&mut self, what: &'static str, least: f64, most: f64) -> Result<f64, ReadError> {
        let value = self.number()?;
        if (least..=most).contains(&value) { Ok(value) } else { Err(self.wrong(what, value)) }
    }

    /// A number above zero, up to what writers take in a file of this unit: so many times.
    pub fn positive(&mut self, what: &'static str, unit: f64) -> Result<f64, ReadError> {
        let value = self.number()?;
        if value > 0.0 && value * unit <= MAX_NUMBER { Ok(value * unit) } else { Err(self.wrong(what, value)) }
    }

    /// `[a, b, ...]` with exactly `N` numbers, none beyond what writers take.
    pub fn numbers<const N: usize>(&mut self, what: &'static str) -> Result<[f64; N], ReadError> {
        let mut values = [0.0; N];
        self.marks("[")?;
        for (k, value) in values.iter_mut().enumerate() {
            if k > 0 {
                self.marks(",")?;
            }
            *value = self.within(what, -MAX_NUMBER, MAX_NUMBER)?;
        }
        self.marks("]")?;
        Ok(values)
    }

    pub fn whole(&mut self) -> Result<i32, ReadError> {
        let value = self.number()?;
        let whole = value as i32;
        if (f64::from(whole) - value).abs() > 0.0 {
            return Err(self.wrong("a whole number", value));
        }
        Ok(whole)
    }
}

#[cfg(test)]
mod tests {
    use super::plain_number;

    #[test]
    fn plain_numbers_are_those_of_the_standard_library() {
        for text in ["0", "-0", "1.5", "-12.0625", ".5", "5.", "0.000000001", "123456789012345", "-99999.999999999"] {
            let (value, length) = plain_number(format!("{text},").as_bytes()).unwrap();
            assert_eq!((value.to_bits(), length), (text.parse::<f64>().unwrap().to_bits(), text.len()), "{text}");
        }
        for text in ["", "-", ".", "1e5", "1.2.3", "9E9", "1234567890123456", "x", "--1", "1_0"] {
            assert_eq!(plain_number(text.as_bytes()), None, "{text}");
        }
    }
}
