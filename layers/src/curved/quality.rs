//! How well an order is cut into layers: into how many patches its layers fall apart, and how small these are.
//!
//! A layer is laid down patch by patch, and between two patches the nozzle travels. Of two orders that build the
//! same cells, the one with fewer and larger patches prints better.

use super::Neighbours;
use crate::cells::{Cells, LayerOrder};

/// A patch of fewer cells is small: 20 cells are a disc five cells across, too little for the nozzle to start, turn
/// and stop on, so it comes out as a blob. A larger limit would count patches that print well, a smaller one would
/// let the crumbs pass that a ragged front leaves behind.
pub const SMALL_PATCH: usize = 20;

/// How well an order is cut into layers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LayerQuality {
    /// Number of layers.
    pub layers: usize,
    /// Connected patches of all layers together. Cells of a layer are connected as the `neighbours` say that [`layer_quality`]
    /// is given: through faces and edges, or over two steps along an axis as well.
    pub patches: usize,
    /// Mean number of patches in a layer, as in [`LayerQuality::patches`]; 0 without layers.
    pub patches_per_layer: f64,
    /// Cells in patches of fewer than [`SMALL_PATCH`] cells.
    pub small_patch_cells: usize,
    /// Their share among all cells of the layers; 0 without cells.
    pub small_patch_share: f64,
}

/// Measures how well an order is cut into layers.
///
/// A patch is a set of cells of one layer that are connected through `neighbours`.
///
/// # Arguments
/// * `neighbours`: which cells count as connected. A nozzle passes from cell to cell through faces and edges
///   ([`Neighbours::FaceOrEdge`]), whatever the rules of support are; figures are compared by these.
/// * `cells`: gives the size of the grid.
/// * `order`: a cell that comes again counts once, in its first layer; numbers outside the grid are passed over.
///
/// # Cost
/// `O(n)` time for `n` cells in the order, four bytes of memory for each cell of the grid.
///
/// # Example
/// ```
/// use curvlay_layers::cells::{Cells, LayerOrder};
/// use curvlay_layers::curved::{Neighbours, layer_quality};
/// let cells = Cells::new([40, 1, 1], &[(1 << 40) - 1])?;
/// let mut order = LayerOrder::new();
/// order.push((0..30).filter(|&x| x != 5)); // a patch of 5 cells and one of 24
/// order.push(30..40);
/// let quality = layer_quality(&cells, &order, Neighbours::FaceOrEdge);
/// assert_eq!((quality.patches, quality.patches_per_layer), (3, 1.5));
/// assert_eq!(quality.small_patch_cells, 15);
/// assert_eq!(quality.small_patch_share, 15.0 / 39.0);
/// # Ok::<(), curvlay_layers::cells::CellsError>(())
/// ```
pub fn layer_quality(cells: &Cells, order: &LayerOrder, neighbours: Neighbours) -> LayerQuality {
    let dims = cells.dims();
    let mut waiting = vec![0; dims.iter().map(|&side| side as usize).product()]; // layer from 1, or 0
    for (number, layer) in (1..).zip(order.iter()) {
        for &cell in layer {
            if let Some(entry @ 0) = waiting.get_mut(cell as usize) {
                *entry = number;
            }
        }
    }
    let mut quality = LayerQuality { layers: order.len(), ..LayerQuality::default() };
    let mut in_all = 0;
    let mut patch = Vec::new();
    for (number, layer) in (1u32..).zip(order.iter()) {
        for &start in layer {
            patch.clear();
            take(&mut waiting, start, number, &mut patch);
            let mut reached = 0;
            while let Some(&cell) = patch.get(reached) {
                reached += 1;
                let place = cells.position(cell);
                for step in neighbours.offsets() {
                    let next = [0, 1, 2].map(|axis| place[axis].wrapping_add_signed(step[axis]));
                    if (0..3).all(|axis| next[axis] < dims[axis]) {
                        take(&mut waiting, cells.id(next), number, &mut patch);
                    }
                }
            }
            quality.patches += usize::from(!patch.is_empty());
            quality.small_patch_cells += if patch.len() < SMALL_PATCH { patch.len() } else { 0 };
            in_all += patch.len();
        }
    }
    let share = |part: usize, whole: usize| if whole == 0 { 0.0 } else { part as f64 / whole as f64 };
    quality.patches_per_layer = share(quality.patches, quality.layers);
    quality.small_patch_share = share(quality.small_patch_cells, in_all);
    quality
}

/// Moves `cell` into the patch if it waits for the layer `number`.
fn take(waiting: &mut [u32], cell: u32, number: u32, patch: &mut Vec<u32>) {
    if let Some(entry) = waiting.get_mut(cell as usize)
        && *entry == number
    {
        *entry = 0;
        patch.push(cell);
    }
}
