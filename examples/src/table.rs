//! Tables: aligned text for stdout, rows for the report.

use crate::nalgebra::Vector3;
use std::fmt::{self, Display};
use std::io::{self, Write};

/// A direction as a cell.
///
/// # Example
/// ```
/// use curvlay_examples::{nalgebra::Vector3, table::direction};
/// assert_eq!(direction(&Vector3::new(-1e-9, -0.6, 0.8)), "(0.000 -0.600 0.800)");
/// ```
pub fn direction(direction: &Vector3<f64>) -> String {
    // Rounded first, and with a zero added: -0 is 0.
    let [x, y, z] = <[f64; 3]>::from(*direction).map(|k| (k * 1000.0).round() / 1000.0 + 0.0);
    format!("({x:.3} {y:.3} {z:.3})")
}

/// A header and rows of the same number of columns.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows. Empty headings are fine.
    pub fn new(header: impl IntoIterator<Item = impl ToString>) -> Self {
        Table { header: header.into_iter().map(|cell| cell.to_string()).collect(), rows: Vec::new() }
    }

    /// Adds a row; missing cells are empty, cells beyond the header are dropped.
    pub fn row(&mut self, cells: impl IntoIterator<Item = impl ToString>) -> &mut Self {
        let mut row: Vec<String> = cells.into_iter().map(|cell| cell.to_string()).collect();
        row.resize(self.header.len(), String::new());
        self.rows.push(row);
        self
    }

    /// The headings.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// The rows.
    pub fn rows(&self) -> &[Vec<String>] {
        &self.rows
    }

    /// Whether a column holds figures (with units, signs or dashes) and so is set flush right.
    pub fn is_numeric(&self, column: usize) -> bool {
        let mut filled = self.rows.iter().filter_map(|row| row.get(column)).filter(|cell| !cell.is_empty()).peekable();
        filled.peek().is_some() && filled.all(|cell| starts_as_figure(cell))
    }

    /// Writes the table to stdout; a reader that has gone away (`| head`) is not an error.
    ///
    /// # Errors
    /// What the system says when stdout cannot be written.
    pub fn print(&self) -> io::Result<()> {
        Table::print_all([self])
    }

    /// Writes tables to stdout, with an empty line between; else like [`Table::print`].
    ///
    /// # Errors
    /// As [`Table::print`].
    pub fn print_all<'a>(tables: impl IntoIterator<Item = &'a Table>) -> io::Result<()> {
        let texts: Vec<String> = tables.into_iter().map(Table::to_string).collect();
        match io::stdout().lock().write_all(texts.join("\n").as_bytes()) {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
            other => other,
        }
    }
}

/// `12`, `-3.5 mm`, `1,204`, `< 0.1 s`, `-` (nothing measured).
fn starts_as_figure(cell: &str) -> bool {
    let bare = cell.trim_start_matches(['<', '>', '~', '+', '-', '\u{2212}', '\u{2013}', ' ']);
    bare.is_empty() || bare.starts_with(|c: char| c.is_ascii_digit() || c == '.')
}

impl Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let columns = self.header.len();
        let width = |column: usize| {
            let cells = self.rows.iter().chain([&self.header]).map(|row| row[column].chars().count());
            cells.max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let flush_right: Vec<bool> = (0..columns).map(|column| self.is_numeric(column)).collect();
        let heading = self.header.iter().any(|cell| !cell.is_empty()).then_some(&self.header);
        for row in heading.into_iter().chain(&self.rows) {
            let mut line = String::new();
            for (column, cell) in row.iter().enumerate() {
                let wide = widths[column];
                line += &if flush_right[column] { format!("{cell:>wide$}") } else { format!("{cell:<wide$}") };
                line += "  ";
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}
