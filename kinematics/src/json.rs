//! Why JSON is not read, with the place apart from the words.

/// A fault of a JSON file.
pub(crate) enum JsonFault {
    /// It cannot be read; what the system says.
    Io(String),
    /// What is wrong, and where: line and column, from 1.
    At([usize; 2], String),
}

impl From<serde_json::Error> for JsonFault {
    fn from(error: serde_json::Error) -> Self {
        let what = error.to_string();
        if error.is_io() {
            return JsonFault::Io(what);
        }
        let (line, column) = (error.line(), error.column());
        let what = what.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&what);
        let not = if error.is_syntax() || error.is_eof() { "not JSON: " } else { "" };
        JsonFault::At([line, column], format!("{not}{what}"))
    }
}
