//! Lines on their way out: numbers, checksums, ends, and how long they may be.

use super::data::{Comment, LineRules};
use crate::gcode::WriteError;
use crate::gcode::numbers::checksum;
use std::io::Write;

/// Text that is collected before it goes out.
const CHUNK: usize = 32 * 1024;

pub(super) struct Output<'a, W> {
    out: W,
    rules: &'a LineRules,
    comment: &'a Comment,
    held: Vec<u8>,
    /// Number of the next line that has one.
    next: u64,
    pub lines: u64,
    pub bytes: u64,
}

impl<'a, W: Write> Output<'a, W> {
    pub fn new(out: W, rules: &'a LineRules, comment: &'a Comment) -> Self {
        let next = rules.numbers.as_ref().map_or(0, |numbers| numbers.first);
        Output { out, rules, comment, held: Vec::new(), next, lines: 0, bytes: 0 }
    }

    /// A line of words, perhaps with a comment behind them. Comments that do not fit are cut.
    pub fn line(&mut self, line: &str) -> Result<(), WriteError> {
        let at = line.find(&self.comment.open).unwrap_or(line.len());
        let (words, comment) = line.split_at(at);
        self.put(words.trim(), comment.trim_end(), false)
    }

    /// Words, and a comment that belongs to them: it must fit as well.
    pub fn whole(&mut self, words: &str, comment: &str) -> Result<(), WriteError> {
        self.put(words, comment, true)
    }

    /// A comment alone, given without its signs.
    pub fn comment(&mut self, text: &str) -> Result<(), WriteError> {
        // What would end the comment, begin another one in it, or is no ASCII, becomes a sign that does neither.
        let Comment { open, close } = self.comment;
        let ends = |c: char| close.contains(c) || (!close.is_empty() && open.contains(c));
        let plain = |c: char| if (c.is_ascii_graphic() && !ends(c)) || c == ' ' { c } else { '_' };
        let text: String = text.chars().map(plain).collect();
        let space = if self.comment.close.is_empty() { " " } else { "" };
        let comment = format!("{}{space}{text}{}", self.comment.open, self.comment.close);
        self.put("", &comment, false)
    }

    /// Lines that are comments already.
    pub fn raw_comment(&mut self, line: &str) -> Result<(), WriteError> {
        self.put("", line, false)
    }

    fn put(&mut self, words: &str, comment: &str, whole: bool) -> Result<(), WriteError> {
        let start = self.held.len();
        let numbers = self.rules.numbers.as_ref();
        let is_numbered = |numbers: &&super::data::LineNumbers| {
            if words.is_empty() { numbers.comments && !comment.is_empty() } else { !words.starts_with('%') }
        };
        if let Some(numbers) = numbers.filter(is_numbered) {
            self.held.extend_from_slice(format!("{}{} ", numbers.prefix, self.next).as_bytes());
            self.next += numbers.step;
        }
        self.held.extend_from_slice(words.as_bytes());
        if numbers.is_some_and(|numbers| numbers.checksum) && !words.is_empty() {
            let sum = checksum(&self.held[start..]);
            self.held.extend_from_slice(format!("*{sum}").as_bytes());
        }
        let (length, max) = (self.held.len() - start, self.rules.max_length);
        let space = usize::from(!words.is_empty() && !comment.is_empty());
        if length > max || (whole && length + space + comment.len() > max) {
            let length = length + if whole { space + comment.len() } else { 0 };
            return Err(WriteError::LongLine { line: self.lines + 1, length, max });
        }
        let room = (max - length).saturating_sub(space);
        let close = if comment.starts_with(&self.comment.open) { self.comment.close.as_str() } else { "" };
        if comment.len() <= room {
            self.held.extend_from_slice(&b" "[..space]);
            self.held.extend_from_slice(comment.as_bytes());
        } else if room > self.comment.open.len() + close.len() {
            // ASCII by now: any byte is the end of a character.
            self.held.extend_from_slice(&b" "[..space]);
            self.held.extend_from_slice(&comment.as_bytes()[..room - close.len()]);
            self.held.extend_from_slice(close.as_bytes());
        }
        self.held.extend_from_slice(if self.rules.crlf { b"\r\n" } else { b"\n" });
        self.lines += 1;
        if self.held.len() > CHUNK { self.send() } else { Ok(()) }
    }

    fn send(&mut self) -> Result<(), WriteError> {
        self.out.write_all(&self.held)?;
        self.bytes += self.held.len() as u64;
        self.held.clear();
        Ok(())
    }

    pub fn finish(&mut self) -> Result<(), WriteError> {
        self.send()?;
        Ok(self.out.flush()?)
    }
}
