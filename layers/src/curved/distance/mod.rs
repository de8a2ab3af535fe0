//! Orders by the distance from the plate or a mould, measured inside the part, for the nozzle that prints.
//!
//! An order that grows in convex fronts ([`grow`](super::grow)) suits a nozzle of any size, so its cells wait for others far away, its layers
//! tear, and some of them hang out sideways. The distance from what the part stands on, along paths inside the part, has none of this: it is
//! continuous, a step from cell to cell is at most one layer, and every cell has one under it ([`STEPS_PER_LAYER`]). What it does not give is reach: so
//! each cell is held against the nozzle that is there ([`NozzleRule`](super::NozzleRule)), as it stands on everything of earlier layers. Where
//! fronts meet in a pit that is too narrow for it, what is in its way is [delayed], and the field is solved again, unless it is a directed one. What is not reached then
//! is left to [`grow_with_nozzle`](super::grow_with_nozzle) and to support.
//!
//! The idea of a scalar field whose level sets are the layers is that of Zhang et al., "S3-Slicer: a general slicing framework for multi-axis 3D
//! printing", ACM TOG 41(6), 2022, and of Etienne et al., "CurviSlicer: slightly curved slicing for 3-axis printers", ACM TOG 38(4), 2019, who
//! optimise deformations of tetrahedra. Ours is a distance on the cells, or follows it by one linear system, and is judged and mended cell by cell.
//!
//! Where fronts of the distance meet, they close a slot that no nozzle gets into. [`grow_directed`] orders by a field that leans from upright no more than the
//! nozzle's cone allows ([directed]). Where its directions turn layers are thick, and get [half layers](LayerField::with_half_layers).
//!
//! [`distance_field`] makes the field, [`grow_by_distance`] the order, [`distance_layers`] the field of an order that was completed by others.

mod beside;
mod delayed;
mod directed;
mod lifted;
mod march;
mod reach;

use super::growth::GrowthError;
use super::surface::{FieldError, LayerField};
use crate::cells::{Cells, LayerOrder};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::buildable::supported::carried;
use beside::OnBase;
pub(crate) use beside::beside;
pub use directed::DirectedOptions;
use nalgebra::Vector3;
pub use reach::{DistanceOrder, grow_by_distance, grow_by_heights, grow_directed};

/// The order of a distance field is cut this often in a layer. Every cell that is not on the base has one beside a face of it whose
/// distance is less by at least half a cell ([`distance_field`]), so with two steps a layer that one is in an earlier step.
pub const STEPS_PER_LAYER: u32 = 2;

/// Layers of a directed field more than this many heights apart get a half layer between them: the middles of beads that lie on each other are one and a half
/// apart at most, and where a half layer ends they lean a little.
const HALF_LAYERS: f64 = 1.45;

/// The distance of the cells from what they stand on, in cells, along paths inside the part.
///
/// The cells that stand on the platform, or on cells of its mould, have the value 1/2; those on the [mesh](Platform::on_mould_mesh) of a mould their distance from it. From there on the eikonal equation is solved by marching, of second order
/// where two cells in a row are known along an axis, else of first order. Each other value is at least 1/2 above the lowest of its face neighbours'.
///
/// # Returns
/// The field, a cell a layer, in [`STEPS_PER_LAYER`]; cells that no path across faces joins to the base have no value.
///
/// # Errors
/// [`GrowthError::NothingOnPlatform`] if no cell stands on the platform; [`GrowthError::Rules`] for rules that are unsound.
///
/// # Cost
/// `O(n log n)` for `n` cells, one thread: some 0.1 s for 100,000.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{Platform, Rules, distance_field};
/// // An upright post of three cells with an arm of two at its top.
/// let cells = Cells::new([3, 1, 3], &[0b001, 0b001, 0b111])?;
/// let field = distance_field(&cells, &Platform::under(&cells, 10.0)?, &Rules::default())?;
/// assert_eq!([0, 3, 6, 7, 8].map(|cell| field.value(cell)), [0.5, 1.5, 2.5, 3.5, 4.5].map(Some));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn distance_field(cells: &Cells, platform: &Platform, rules: &Rules) -> Result<LayerField, GrowthError> {
    rules.check(cells, platform)?;
    let base = base(carried(cells, platform, rules), cells, platform);
    if base.is_empty() {
        return Err(GrowthError::NothingOnPlatform);
    }
    Ok(solved(cells, &base, &|_| 0.0))
}

/// The value of cells of the base that stand on the platform, or on cells of a mould: their middle.
const ON_BASE: f64 = 0.5;

/// These cells, by rising number, as the base.
fn base(standing: Vec<u32>, cells: &Cells, platform: &Platform) -> Vec<OnBase> {
    let mould = platform.mould.as_ref();
    let on_mould = |cell: u32| mould.and_then(|mould| mould.height(cell));
    let value = |cell: u32| match on_mould(cell) {
        Some(height) if cells.position(cell)[2] == 0 => height.min(ON_BASE),
        height => height.unwrap_or(ON_BASE),
    };
    standing.into_iter().map(|cell| (cell, value(cell))).collect()
}

/// The field with these floors of its values.
fn solved(cells: &Cells, base: &[OnBase], floor: &dyn Fn(u32) -> f64) -> LayerField {
    in_cells(cells, march::distances(cells, base, floor))
}

/// How fast some values rise at a cell: over both neighbours along an axis, or the one that there is; 0 without any. `beside` gives the values beside its
/// faces.
fn slope(own: f64, beside: [Option<f64>; 6]) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| match (beside[2 * axis], beside[2 * axis + 1]) {
        (Some(low), Some(high)) => (high - low) / 2.0,
        (Some(low), None) => own - low,
        (None, Some(high)) => high - own,
        (None, None) => 0.0,
    })
}

/// The field of these values, a cell a layer.
fn in_cells(cells: &Cells, values: Vec<f64>) -> LayerField {
    let field = LayerField::new(cells, values, 1.0).unwrap_or_else(|error| unreachable!("{error}"));
    field.in_steps(STEPS_PER_LAYER)
}

/// The field of an order that [`grow_by_distance`] or [`grow_directed`] began and others went on with: theirs where the order follows it, then a layer for
/// each layer of the order.
///
/// # Arguments
/// * `cells`: those of the order.
/// * `distances`: the field of the order's beginning.
///
/// # Errors
/// [`FieldError::OutsideGrid`], [`FieldError::NotSolid`] for an order of other cells; [`FieldError::Empty`] for one without cells.
///
/// # Cost
/// `O(n)` for `n` cells of the grid.
///
/// # Example
/// ```
/// use curvlay_layers::cells::{Cells, LayerOrder};
/// use curvlay_layers::curved::{Platform, Rules, distance_field, distance_layers};
/// let cells = Cells::new([1, 1, 3], &[1; 3])?;
/// let distances = distance_field(&cells, &Platform::under(&cells, 10.0)?, &Rules::default())?;
/// let mut order = LayerOrder::new();
/// [0, 2, 1].map(|cell| order.push([cell])); // the last but one cell comes late
/// let field = distance_layers(&cells, &distances, &order)?;
/// assert_eq!([0, 1, 2].map(|cell| field.value(cell)), [0.5, 3.5, 2.5].map(Some));
/// assert_eq!(field.order(), order);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn distance_layers(cells: &Cells, distances: &LayerField, order: &LayerOrder) -> Result<LayerField, FieldError> {
    let len = cells.grid_len();
    if let Some(&cell) = order.cells().iter().find(|&&cell| cell as usize >= len) {
        return Err(FieldError::OutsideGrid { cell, len });
    }
    let head = steps_of(distances, order);
    let mut values = vec![f64::NAN; len];
    let mut highest: f64 = 0.0;
    for (&cell, value) in order.iter().take(head).flatten().filter_map(|cell| Some((cell, distances.value(*cell)?))) {
        values[cell as usize] = value;
        highest = highest.max(value);
    }
    let first = if head > 0 { highest.floor() + 1.0 } else { 0.0 };
    for (layer, of_layer) in order.iter().skip(head).enumerate() {
        of_layer.iter().for_each(|&cell| values[cell as usize] = first + layer as f64 + 0.5);
    }
    let field = LayerField::new(cells, values, 1.0)?.in_steps(STEPS_PER_LAYER);
    Ok(field.with_half_layers(distances.half_layers()))
}

/// How many layers an order follows the field from its beginning on: whole layers lie in one step each, and the steps rise.
fn steps_of(distances: &LayerField, order: &LayerOrder) -> usize {
    let step_of = |cell: u32| distances.value(cell).map(|value| (value * f64::from(STEPS_PER_LAYER)) as u64);
    let mut last = None;
    let follows = |layer: &&[u32]| {
        let step = layer.first().and_then(|&cell| step_of(cell));
        let is_next = step > last && layer.iter().all(|&cell| step_of(cell) == step);
        last = step.max(last);
        is_next
    };
    order.iter().take_while(follows).count()
}
