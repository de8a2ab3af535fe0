//! Straight support under missed cells: an upper bound of what it takes to carry them.

use crate::cells::Cells;

/// Cells of the straight columns below the cells of `carried`, each down to a cell of the part or the plate, counted once. Words
/// of 64 columns are filled at once, level by level from the top.
pub(super) fn columns_below(cells: &Cells, carried: &[u32]) -> u64 {
    let (words, [_, ny, _]) = (cells.words_per_row(), cells.dims());
    let level_words = words * ny as usize;
    let mut needs = vec![0u64; cells.rows().len()];
    for &cell in carried {
        let [x, y, z] = cells.position(cell);
        needs[words * (y as usize + ny as usize * z as usize) + x as usize / 64] |= 1 << (x % 64);
    }
    let mut hanging = vec![0u64; level_words];
    let mut count = 0;
    for (solid, needs) in cells.rows().chunks_exact(level_words).zip(needs.chunks_exact(level_words)).rev() {
        for ((hanging, solid), needs) in hanging.iter_mut().zip(solid).zip(needs) {
            *hanging &= !solid;
            count += u64::from(hanging.count_ones());
            *hanging |= needs;
        }
    }
    count
}
