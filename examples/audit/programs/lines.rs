//! Lines of G-code, of any length if they are comments.

use curvlay_examples::laid::LONGEST_LINE;
use std::io::{BufRead, Read};

/// Lines of a file; long comments are cut.
pub struct Lines<R> {
    reader: R,
    bytes: Vec<u8>,
    text: String,
    /// The line that was read last, from 1.
    pub line: u64,
}

impl<R: BufRead> Lines<R> {
    /// Before the first one.
    pub fn new(reader: R) -> Self {
        Lines { reader, bytes: Vec::new(), text: String::new(), line: 0 }
    }

    /// The next line.
    ///
    /// # Errors
    /// What the system says; a long line that is no comment.
    pub fn next(&mut self) -> Result<Option<&str>, String> {
        self.bytes.clear();
        self.line += 1;
        let line = self.line;
        let fault = |error: std::io::Error| format!("line {line}: {error}");
        self.reader.by_ref().take(LONGEST_LINE as u64).read_until(b'\n', &mut self.bytes).map_err(fault)?;
        if self.bytes.is_empty() {
            return Ok(None);
        }
        if self.bytes.len() >= LONGEST_LINE && self.bytes.last() != Some(&b'\n') {
            if self.bytes.first() != Some(&b';') {
                return Err(format!("line {line}: longer than {LONGEST_LINE} bytes: is it G-code?"));
            }
            // Settings and thumbnails of slicers.
            loop {
                let part = self.reader.fill_buf().map_err(fault)?;
                let end = part.iter().position(|byte| *byte == b'\n');
                let used = end.map_or(part.len(), |at| at + 1);
                if used == 0 {
                    break;
                }
                self.reader.consume(used);
                if end.is_some() {
                    break;
                }
            }
        }
        self.text = String::from_utf8_lossy(&self.bytes).into_owned();
        Ok(Some(self.text.trim()))
    }
}
