//! Cells with their distance on the base, and the cells beside a cell.

use crate::cells::Cells;

/// A cell of the base, which an order begins with, and its value: how far its middle is from what it stands on, in cells.
pub(super) type OnBase = (u32, f64);

/// The cells beside the faces of a cell: below and above along each axis.
pub(crate) fn beside(cells: &Cells, cell: u32) -> [Option<u32>; 6] {
    let place = cells.position(cell);
    std::array::from_fn(|face| {
        let mut at = place;
        let along = &mut at[face / 2];
        *along = if face % 2 == 1 { *along + 1 } else { along.checked_sub(1)? };
        cells.contains(at).then(|| cells.id(at))
    })
}
