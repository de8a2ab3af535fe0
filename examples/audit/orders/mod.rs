//! Orders of cells, read from files of others and ours. `docs/formats/audit.md` states the formats.

mod csv;
mod lattice;
mod order;
mod vtk;

use curvlay_examples::args::Failure;
use curvlay_examples::input;
use std::io::{BufRead, BufReader};
use std::path::Path;

use order::OrderFault;
pub use order::{CellOrder, OrderOptions};

/// Bytes at the start of a file by which its format is known.
const HEAD_BYTES: usize = 4096;

/// Reads an order; the first bytes say in which format.
///
/// # Errors
/// One line with file, line and what is wrong.
pub fn read(path: &Path, options: &OrderOptions) -> Result<CellOrder, Failure> {
    let fault = |OrderFault { line, what }| match line {
        0 => Failure::new(format!("{}: {what}", path.display())),
        line => Failure::new(format!("{}: line {line}: {what}", path.display())),
    };
    let mut reader = BufReader::with_capacity(HEAD_BYTES, input::open(path, input::MAX_DATA_BYTES)?);
    let head = reader.fill_buf().map_err(|error| fault(OrderFault::at(0, format!("cannot be read: {error}"))))?;
    let order = match head {
        head if head.trim_ascii().is_empty() => Err(OrderFault::at(0, "is empty")),
        head if head.starts_with(b"# vtk DataFile") => vtk::read(reader, options),
        head if head.starts_with(b"curvlay field ") => {
            Err(OrderFault::at(0, "is an even field, which has no order: take field.csv of the same run"))
        }
        _ => csv::read(reader, options),
    };
    order.map_err(fault)
}
