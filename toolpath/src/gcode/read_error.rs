//! Why a file could not be read.

use std::io;

/// Why a file could not be read. Lines and columns are counted from 1, columns in bytes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// Something else stands there.
    #[error("line {line}, column {column}: expected {expected}, found `{found}`")]
    Unexpected {
        /// The line.
        line: u64,
        /// The column.
        column: u64,
        /// What belongs there.
        expected: &'static str,
        /// What stands there, at most 40 bytes of it.
        found: String,
    },
    /// A command that the dialect does not have.
    #[error("line {line}, column {column}: `{command}`: {why}")]
    Command {
        /// The line.
        line: u64,
        /// The column.
        column: u64,
        /// The command, at most 40 bytes of it.
        command: String,
        /// Why it is refused.
        why: &'static str,
    },
    /// A command lacks a word, and no earlier line has given it.
    #[error("line {line}, column {column}: the word {word} is missing")]
    Missing {
        /// The line.
        line: u64,
        /// Column of the command.
        column: u64,
        /// The word.
        word: String,
    },
    /// A word stands twice in a line.
    #[error("line {line}, column {column}: a second {word} in one line")]
    Repeated {
        /// The line.
        line: u64,
        /// Column of the second.
        column: u64,
        /// The word.
        word: String,
    },
    /// A number is out of its range.
    #[error("line {line}, column {column}: {word} is {value}; it must be from {least} to {most}")]
    Number {
        /// The line.
        line: u64,
        /// Column of the word.
        column: u64,
        /// The word.
        word: String,
        /// The number.
        value: f64,
        /// Least value allowed.
        least: f64,
        /// Greatest value allowed.
        most: f64,
    },
    /// A number has more characters than any number needs.
    #[error("line {line}, column {column}: the number is longer than {most} characters")]
    NumberTooLong {
        /// The line.
        line: u64,
        /// Column of its first character.
        column: u64,
        /// Characters allowed.
        most: usize,
    },
    /// A direction is zero, or its length is not near 1.
    #[error("line {line}, column {column}: the direction has the length {length}; it must be within 0.01 of 1")]
    Direction {
        /// The line.
        line: u64,
        /// Column of its first word.
        column: u64,
        /// Its length.
        length: f64,
    },
    /// Filament runs backwards while the nozzle moves: neither a bead nor a retraction.
    #[error("line {line}, column {column}: the nozzle moves while filament goes back by {filament_mm} mm")]
    Backwards {
        /// The line.
        line: u64,
        /// Column of the word E.
        column: u64,
        /// By how much, in millimetres.
        filament_mm: f64,
    },
    /// The checksum of a line is not that of its bytes: it was damaged.
    #[error("line {line}, column {column}: the checksum is {given}, but that of the line is {expected}")]
    Checksum {
        /// The line.
        line: u64,
        /// Column of the `*`.
        column: u64,
        /// What the line says.
        given: u8,
        /// What it should say.
        expected: u8,
    },
    /// A line with a checksum has another number than one more than the one before: lines are lost, or come twice.
    #[error("line {line}: its number is {given}, but {expected} comes next")]
    LineNumber {
        /// The line.
        line: u64,
        /// Its number.
        given: f64,
        /// The number that should come.
        expected: f64,
    },
    /// A line has a number that is not above the one before: lines come twice, or in another order.
    #[error("line {line}: its number is {given}, after {before}; numbers must ascend")]
    Descending {
        /// The line.
        line: u64,
        /// Its number.
        given: f64,
        /// The number before it.
        before: f64,
    },
    /// A line has no end.
    #[error("line {line} is longer than {most} bytes")]
    LineTooLong {
        /// The line.
        line: u64,
        /// Bytes allowed.
        most: usize,
    },
    /// The options cannot be used: the rotary table is not possible.
    #[error("the rotary table: {0}")]
    Machine(&'static str),
    /// The input cannot be read.
    #[error("after line {line}: {source}")]
    Io {
        /// Lines read.
        line: u64,
        /// The cause.
        source: io::Error,
    },
}
