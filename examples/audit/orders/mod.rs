//! Orders of cells, read from files of others and ours. `docs/formats/audit.md` states the formats.

mod csv;
mod lattice;
mod order;
mod vtk;

use curvlay_examples::args::Failure;
use curvlay_examples::input;
use std::io::BufReader;
use std::path::Path;

use order::OrderFault;
pub use order::{CellOrder, OrderOptions};

/// Reads an order.
///
/// # Errors
/// One line with file, line and what is wrong.
pub fn read(path: &Path, options: &OrderOptions) -> Result<CellOrder, Failure> {
    let file = input::open(path, input::MAX_DATA_BYTES)?;
    let mut reader = BufReader::new(file);
    let head = first_bytes(&mut reader, path)?;
    let order =
        if head.starts_with(b"# vtk DataFile") { vtk::read(reader, options) } else { csv::read(reader, options) };
    order.map_err(|OrderFault { line, what }| match line {
        0 => Failure::new(format!("{}: {what}", path.display())),
        line => Failure::new(format!("{}: line {line}: {what}", path.display())),
    })
}

fn first_bytes(reader: &mut impl std::io::BufRead, path: &Path) -> Result<Vec<u8>, Failure> {
    let head =
        reader.fill_buf().map_err(|error| Failure::new(format!("{}: cannot be read: {error}", path.display())))?;
    Ok(head.iter().take(32).copied().collect())
}
