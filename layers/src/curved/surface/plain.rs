//! The field of whole layers.

use super::field::{FieldError, LayerField};
use super::lattice::Lattice;
use crate::cells::{Cells, LayerOrder};

/// The plain field of an order: a cell of layer `k` (from 1) has the value `k - 1/2`.
///
/// The thickness of its layers is their mean: the number of cells over the sum of the slopes at them. (Dai 2020, section
/// 3.6.3, takes 1.25 cells, found by experiment.)
///
/// # Errors
/// [`FieldError`] for an order that names cells outside the solid, or none.
///
/// # Example
/// ```
/// use curvlay_layers::cells::{Cells, LayerOrder};
/// use curvlay_layers::curved::surface::plain_field;
/// let cells = Cells::new([1, 1, 3], &[1; 3])?;
/// let mut order = LayerOrder::new();
/// (0..3).for_each(|cell| order.push([cell]));
/// let field = plain_field(&cells, &order)?;
/// assert_eq!((field.value(2), field.layer_cells()), (Some(2.5), 1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn plain_field(cells: &Cells, order: &LayerOrder) -> Result<LayerField, FieldError> {
    let len = cells.grid_len();
    if let Some(&cell) = order.cells().iter().find(|&&cell| cell as usize >= len) {
        return Err(FieldError::OutsideGrid { cell, len });
    }
    let layers = order.field(len);
    let value = |&layer: &u32| if layer == 0 { f64::NAN } else { f64::from(layer) - 0.5 };
    let field = LayerField::new(cells, layers.iter().map(value).collect(), 1.0)?;
    let mean_slope = Lattice::of(&field).mean_slope();
    Ok(field.with_layer_cells(if mean_slope > 0.0 { 1.0 / mean_slope } else { 1.0 }))
}
