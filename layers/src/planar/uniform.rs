//! For reproducing Boge (2019), section 6.3: each level of cells is a layer, and what hangs in the air is missed. Prints use curved layers.
//!
//! Boge 2019, section 6.3 (Table 6.6, Figures 6.2 to 6.6).
//! The thesis counts missed cells without saying when one is missed. The rule here gives all five of her counts: a
//! cell is built only if the whole column under it, down to the platform, is solid. So nothing leans out, not even
//! by one cell, and what stands on a missed cell is missed as well.
//! The platform is the whole plane under the lowest level of the grid.

use crate::cells::{Cells, LayerOrder, set_bits};

/// A solid cut into plane layers, all of one level.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UniformSlicing {
    /// The levels from the bottom up, each by rising cell number, up to the last one with a cell that can be built.
    pub order: LayerOrder,
    /// The cells that would need support, by rising number.
    pub missed: Vec<u32>,
}

/// Cuts a solid into its levels, and lists the cells that cannot be built in them without support.
///
/// # Returns
/// Every cell of `cells` is either in a layer or missed. Without cells there is no layer.
///
/// # Cost
/// An operation for each word of bits, and four bytes of memory for each cell of the solid. One thread.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::planar::slice_uniformly;
/// // An upright T, one cell thick: a stem of two cells below a bar of three, two levels high.
/// let cells = Cells::new([3, 1, 4], &[0b010, 0b010, 0b111, 0b111])?;
/// let slicing = slice_uniformly(&cells);
/// assert_eq!(slicing.order.iter().collect::<Vec<_>>(), [[1], [4], [7], [10]]);
/// assert_eq!(slicing.missed, [6, 8, 9, 11]); // the arms of the bar
/// # Ok::<(), curvlay_layers::cells::CellsError>(())
/// ```
pub fn slice_uniformly(cells: &Cells) -> UniformSlicing {
    let mut slicing = UniformSlicing::default();
    let [nx, ny, _] = cells.dims();
    let words = cells.words_per_row();
    // Columns that are solid from the platform up to the level at hand.
    let mut standing = vec![u64::MAX; words * ny as usize];
    let mut layer = Vec::new();
    for (z, level) in (0..).zip(cells.rows().chunks_exact(standing.len())) {
        for (at, (standing, &solid)) in standing.iter_mut().zip(level).enumerate() {
            let row = (at / words) as u32 + ny * z;
            let first = nx * row + 64 * (at % words) as u32;
            slicing.missed.extend(set_bits(solid & !*standing).map(|bit| first + bit));
            *standing &= solid;
            layer.extend(set_bits(*standing).map(|bit| first + bit));
        }
        // Above an empty layer nothing stands any more.
        if !layer.is_empty() {
            slicing.order.push(layer.drain(..));
        }
    }
    slicing
}
