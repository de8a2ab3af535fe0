//! Stresses in files: CSV, VTK and CalculiX.
//!
//! * `csv`: positions and six components, read and written. `vtk`: legacy files as text, arrays at points. `frd`: results of CalculiX at nodes.
//!
//! Lengths are in millimetres, as in everything else; the unit of stresses is the file's. Readers take a line at a time, and memory in proportion to what they
//! have read.

mod csv;
mod frd;
mod vtk;

pub use csv::{STRESS_CSV_HEADER, read_stress_csv, write_stress_csv};
pub use frd::read_stress_frd;
pub use vtk::read_stress_vtk;

use super::stress::{SIX, StressSample};
use nalgebra::{Matrix3, Point3};
use std::io::{self, BufRead};

/// Why stresses could not be read. Lines are counted from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StressFileError {
    /// The system says so.
    #[error("line {line}: {error}")]
    Io {
        /// The line that was being read.
        line: u64,
        /// What it says.
        error: io::Error,
    },
    /// Something else stands there.
    #[error("line {line}: expected {expected}, found `{found}`")]
    Unexpected {
        /// The line.
        line: u64,
        /// What belongs there.
        expected: &'static str,
        /// What stands there, at most 40 characters of it.
        found: String,
    },
    /// A line has more or fewer columns than it should.
    #[error("line {line}: {found} columns; there must be {wanted}")]
    Columns {
        /// The line.
        line: u64,
        /// How many there are.
        found: usize,
        /// How many there should be.
        wanted: usize,
    },
    /// A number is NaN, infinite or absurd.
    #[error("line {line}: `{found}` is not a number between -1e100 and 1e100")]
    Number {
        /// The line.
        line: u64,
        /// What stands there, at most 40 characters of it.
        found: String,
    },
    /// The file ends too early.
    #[error("line {line}: the file ends; expected {expected}")]
    Ends {
        /// The last line.
        line: u64,
        /// What is missing.
        expected: &'static str,
    },
    /// A tensor is not symmetric.
    #[error("line {line}: the stress tensor of point {point} is not symmetric")]
    NotSymmetric {
        /// The line at which it ends.
        line: u64,
        /// The point, from 0.
        point: usize,
    },
    /// There are no stresses in the file.
    #[error("the file has no stresses: {expected}")]
    NoStress {
        /// What was looked for.
        expected: &'static str,
    },
}

/// Numbers beyond this are refused.
const MAX_NUMBER: f64 = 1e100;

/// A line longer than this is no line of such a file.
const LONGEST_LINE: u64 = 1 << 20;

/// Lines of a file, with their numbers.
struct Lines<R> {
    input: R,
    line: u64,
    text: String,
}

impl<R: BufRead> Lines<R> {
    fn new(input: R) -> Self {
        Lines { input, line: 0, text: String::new() }
    }

    /// The next line without its end; `None` at the end of the file.
    fn next(&mut self) -> Result<Option<&str>, StressFileError> {
        self.text.clear();
        let mut bytes = Vec::new();
        let line = self.line + 1;
        let io_error = |error| StressFileError::Io { line, error };
        let read = io::Read::take(&mut self.input, LONGEST_LINE).read_until(b'\n', &mut bytes).map_err(io_error)?;
        if read == 0 {
            return Ok(None);
        }
        self.line = line;
        if read as u64 == LONGEST_LINE && !bytes.ends_with(b"\n") {
            let found = shortened(&String::from_utf8_lossy(&bytes[..64]));
            return Err(StressFileError::Unexpected { line, expected: "a line of text", found });
        }
        self.text.push_str(&String::from_utf8_lossy(&bytes));
        Ok(Some(self.text.trim_end_matches(['\n', '\r'])))
    }

    fn unexpected(&self, expected: &'static str, found: &str) -> StressFileError {
        StressFileError::Unexpected { line: self.line, expected, found: shortened(found) }
    }

    fn ends(&self, expected: &'static str) -> StressFileError {
        StressFileError::Ends { line: self.line, expected }
    }
}

fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}

/// A finite number.
fn number(line: u64, text: &str) -> Result<f64, StressFileError> {
    let value: Option<f64> = text.trim().parse().ok();
    value.filter(|value| value.abs() <= MAX_NUMBER).ok_or(StressFileError::Number { line, found: shortened(text) })
}

/// A sample of a place and six components: xx, yy, zz, xy, yz, zx.
fn sample(place: [f64; 3], six: [f64; 6]) -> StressSample {
    let mut stress = Matrix3::zeros();
    for (value, (row, column)) in six.into_iter().zip(SIX) {
        (stress[(row, column)], stress[(column, row)]) = (value, value);
    }
    StressSample { point: Point3::from(place), stress }
}
