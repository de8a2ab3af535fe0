//! A line of a TP program, taken apart from its begin on.

use crate::program::ReadError;
use crate::program::text::tokens::Tokens;
use std::io::BufRead;

/// Characters of a file that an error quotes.
const QUOTED: usize = 40;

/// A line, and how much of it has been read.
#[derive(Debug, Default)]
pub(super) struct Line {
    text: String,
    at: usize,
    row: u64,
}

impl Line {
    /// The next line that is not empty; `None` at the end of the file.
    pub fn raw<R: BufRead>(tokens: &mut Tokens<R>) -> Result<Option<Self>, ReadError> {
        while tokens.next_line()? {
            let text = String::from_utf8_lossy(tokens.line()).into_owned();
            let mut line = Line { text, at: 0, row: tokens.place().0 };
            line.skip();
            if !line.is_empty() {
                return Ok(Some(line));
            }
        }
        Ok(None)
    }

    /// The next instruction, behind its number; `None` at `/POS`. A line without an instruction is passed over.
    pub fn next<R: BufRead>(tokens: &mut Tokens<R>) -> Result<Option<Self>, ReadError> {
        loop {
            let Some(mut line) = Self::raw(tokens)? else {
                let found = "the end of the file".to_owned();
                let (line, column) = tokens.place();
                return Err(ReadError::Unexpected { line, column, expected: "/POS behind the instructions", found });
            };
            if line.take("/POS") {
                return Ok(None);
            }
            line.number("the number of a line", 1.0, 1e6)?;
            line.expect(":")?;
            if !line.rest_is(";") {
                return Ok(Some(line));
            }
        }
    }

    fn skip(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    fn left(&self) -> &str {
        &self.text[self.at..]
    }

    fn rest_is(&self, end: &str) -> bool {
        self.left().trim() == end
    }

    pub fn is_empty(&self) -> bool {
        self.left().is_empty()
    }

    /// Line and column.
    pub fn place(&self) -> [u64; 2] {
        [self.row.max(1), self.at as u64 + 1]
    }

    /// Whether the rest begins so; then it is taken, with the white space behind it.
    pub fn take(&mut self, begin: &str) -> bool {
        let is_there = self.left().starts_with(begin);
        if is_there {
            self.at += begin.len();
            self.skip();
        }
        is_there
    }

    pub fn expect(&mut self, begin: &'static str) -> Result<(), ReadError> {
        if self.take(begin) { Ok(()) } else { Err(self.unexpected(begin)) }
    }

    /// Letters, digits and `_`.
    pub fn word(&mut self, expected: &'static str) -> Result<String, ReadError> {
        let length = self.left().bytes().take_while(|byte| byte.is_ascii_alphanumeric() || *byte == b'_').count();
        if length == 0 {
            return Err(self.unexpected(expected));
        }
        let word = self.left()[..length].to_owned();
        self.at += length;
        self.skip();
        Ok(word)
    }

    /// The next letter; a blank where there is none.
    pub fn letter(&mut self) -> char {
        let letter = self.left().chars().next().unwrap_or(' ');
        self.at += if self.is_empty() { 0 } else { letter.len_utf8() };
        self.skip();
        letter
    }

    /// A number within a range, as plain decimals.
    pub fn number(&mut self, what: &'static str, least: f64, most: f64) -> Result<f64, ReadError> {
        let sign = usize::from(self.left().starts_with('-'));
        let digits = self.left().bytes().skip(sign).take_while(|byte| byte.is_ascii_digit() || *byte == b'.').count();
        let Some(value) = self.left()[..sign + digits].parse::<f64>().ok() else {
            return Err(self.unexpected("a number"));
        };
        if !(least..=most).contains(&value) {
            let [line, column] = self.place();
            return Err(ReadError::Number { line, column, what, value });
        }
        self.at += sign + digits;
        self.skip();
        Ok(value)
    }

    /// Takes all up to the `;` at the end.
    pub fn rest(&mut self) {
        let rest = self.left();
        self.at += rest.rfind(';').unwrap_or(rest.len());
    }

    /// The `;` at the end of an instruction.
    pub fn end(&mut self) -> Result<(), ReadError> {
        self.expect(";")?;
        if self.is_empty() { Ok(()) } else { Err(self.unexpected("the end of the line")) }
    }

    pub fn unexpected(&self, expected: &'static str) -> ReadError {
        self.unexpected_at(self.place(), expected)
    }

    /// What stands at a place of the line is not what belongs there.
    pub fn unexpected_at(&self, [line, column]: [u64; 2], expected: &'static str) -> ReadError {
        let from = usize::try_from(column).unwrap_or(1).saturating_sub(1);
        let rest: String = self.text.get(from..).unwrap_or("").chars().take(QUOTED).collect();
        let found = if rest.is_empty() { "the end of the line".to_owned() } else { format!("`{rest}`") };
        ReadError::Unexpected { line, column, expected, found }
    }
}
