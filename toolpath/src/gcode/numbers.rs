//! Line numbers and checksums: `N3 G1 X1*96`. Firmware asks again for a line that was damaged on its way, or lost.
//!
//! The checksum is that of RepRap: all bytes of the line before the `*`, joined by exclusive or. Comments are not part of it, and lines
//! without a command have neither; so a direction in a comment is not protected.

/// Numbers of the lines that have a command; `M110 N0`, the first one, has 0.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    next: u64,
    lines: Vec<u8>,
}

/// All bytes, joined by exclusive or.
pub(super) fn checksum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, byte| sum ^ byte)
}

/// The number that lines count from after a line with `M110`, if it has that command: `Some(None)` where no number stands behind it.
pub(super) fn counted_from(words: &[u8], prefix: &str) -> Option<Option<f64>> {
    let (command, rest) = words.split_at_checked(4)?;
    if !command.eq_ignore_ascii_case(b"M110") || rest.first().is_some_and(u8::is_ascii_alphanumeric) {
        return None;
    }
    let number = || {
        let (start, rest) = rest.trim_ascii_start().split_at_checked(prefix.len())?;
        let digits = rest.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(rest.len());
        let is_prefix = start.eq_ignore_ascii_case(prefix.as_bytes());
        std::str::from_utf8(&rest[..digits]).ok().filter(|_| is_prefix)?.parse().ok()
    };
    Some(number())
}

impl Numbers {
    /// Whole lines, with numbers and checksums.
    pub fn number(&mut self, text: &[u8]) -> &[u8] {
        self.lines.clear();
        for line in text.split_inclusive(|&byte| byte == b'\n') {
            let end = line.iter().position(|&byte| matches!(byte, b';' | b'\n')).unwrap_or(line.len());
            let (words, rest) = line.split_at(end);
            let words = words.trim_ascii();
            if words.is_empty() {
                self.lines.extend_from_slice(line);
                continue;
            }
            let start = self.lines.len();
            self.lines.extend_from_slice(format!("N{} ", self.next).as_bytes());
            self.next += 1;
            self.lines.extend_from_slice(words);
            let sum = checksum(&self.lines[start..]);
            self.lines.extend_from_slice(format!("*{sum}").as_bytes());
            if rest.first() == Some(&b';') {
                self.lines.push(b' ');
            }
            self.lines.extend_from_slice(rest);
        }
        &self.lines
    }
}
