//! Why a JSON file is not read: what is wrong, and where.

use std::fmt;

/// A fault of a JSON text.
#[derive(Clone, Debug, PartialEq)]
pub struct JsonFault {
    /// The line, counted from 1.
    pub line: usize,
    /// The column, counted from 1; 0 at the end of a line.
    pub column: usize,
    /// What is wrong there.
    pub what: String,
}

impl From<&serde_json::Error> for JsonFault {
    fn from(error: &serde_json::Error) -> Self {
        let (line, column) = (error.line(), error.column());
        let text = error.to_string();
        let what = text.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&text);
        let not = if error.is_syntax() || error.is_eof() { "not JSON: " } else { "" };
        JsonFault { line, column, what: format!("{not}{what}") }
    }
}

impl fmt::Display for JsonFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}: {}", self.line, self.column, self.what)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_comes_first() {
        let said = |text: &str| JsonFault::from(&serde_json::from_str::<[u8; 2]>(text).unwrap_err()).to_string();
        assert_eq!(said("hello"), "line 1, column 1: not JSON: expected value");
        assert_eq!(said("[1,\n"), "line 2, column 0: not JSON: EOF while parsing a value");
        assert_eq!(said("[1,\n300]"), "line 2, column 3: invalid value: integer `300`, expected u8");
    }
}
