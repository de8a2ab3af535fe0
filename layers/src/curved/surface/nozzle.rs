//! Uniform layers of an order whose last layers are judged by the nozzle that prints.
//!
//! What comes before the first such cell is re-timed as ever. The layers after that keep their order: they follow one by one, a cell
//! thick, from the end of the others on. Then the values are evened out within their layers, so the audit sees the layers of the order.

use super::field::LayerField;
use super::lattice::Lattice;
use super::plain::plain_field;
use super::slope::evened;
use super::uniform::{UniformError, UniformField, UniformMethod, uniform_field};
use crate::cells::{Cells, LayerOrder};
use crate::curved::{JudgedByNozzle, Platform, Rules, audit_with_nozzle};
use crate::{Progress, ProgressFn};
use std::collections::BTreeSet;

/// Re-times an accepted order like [`uniform_field`], some cells of which are judged by the nozzle.
///
/// # Arguments
/// * `judged`: the nozzle, and the cells; with none of them this is [`uniform_field`].
/// * `order`: passes [`audit_with_nozzle`] with `missed`.
/// * `progress`: called with the stages `uniform` and `audit uniform`; may cancel.
///
/// # Errors
/// [`UniformError`].
///
/// # Cost
/// That of [`uniform_field`] and of [`audit_with_nozzle`].
///
/// # Example
/// ```
/// use curvlay_layers::cells::{Cells, LayerOrder};
/// use curvlay_layers::curved::{JudgedByNozzle, NozzleCell, NozzleRule, Platform, Rules};
/// use curvlay_layers::curved::surface::uniform_field_with_nozzle;
/// use curvlay_layers::nalgebra::Vector3;
/// let cells = Cells::new([1, 1, 3], &[1, 1, 1])?; // a column of three cells, the last one printed upright
/// let platform = Platform::under(&cells, 10.0)?;
/// let mut order = LayerOrder::new();
/// (0..3).for_each(|cell| order.push([cell]));
/// let directions = [NozzleCell { cell: 2, direction: Vector3::z_axis() }];
/// let judged = JudgedByNozzle { rule: NozzleRule::default(), cell_mm: 1.0, steps: 1, cells: &directions };
/// let rules = Rules::default();
/// let silent = |_| std::ops::ControlFlow::Continue(());
/// let uniform = uniform_field_with_nozzle(&cells, &platform, &rules, &judged, &order, &[], &silent)?;
/// assert_eq!([0, 1, 2].map(|cell| uniform.field.value(cell)), [0.5, 1.5, 2.5].map(Some));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn uniform_field_with_nozzle(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    judged: &JudgedByNozzle,
    order: &LayerOrder,
    missed: &[u32],
    progress: ProgressFn,
) -> Result<UniformField, UniformError> {
    if judged.cells.is_empty() {
        return uniform_field(cells, platform, rules, order, missed, progress);
    }
    let auditing = |p: Progress| progress(Progress { stage: "audit uniform", ..p });
    let audited =
        |field: &LayerField| audit_with_nozzle(cells, platform, rules, judged, &field.rounded(), missed, &auditing);
    let by_nozzle: BTreeSet<u32> = judged.cells.iter().map(|printed| printed.cell).collect();
    let is_judged = |layer: &[u32]| layer.iter().any(|cell| by_nozzle.contains(cell));
    let first = order.iter().position(is_judged).unwrap_or(order.len());
    if first > 0 {
        let mut head = LayerOrder::new();
        order.iter().take(first).for_each(|layer| head.push(layer.iter().copied()));
        let mut not_in_head = missed.to_vec();
        not_in_head.extend(order.iter().skip(first).flatten());
        let UniformField { field, method, .. } = uniform_field(cells, platform, rules, &head, &not_in_head, progress)?;
        let from = field.highest().floor() + 1.0;
        let mut values = field.values().to_vec();
        for (layer, of_layer) in order.iter().skip(first).enumerate() {
            of_layer.iter().for_each(|&cell| values[cell as usize] = from + layer as f64 + 0.5);
        }
        let field = evened(field.with_values(values));
        let audit = audited(&field)?;
        if audit.is_ok() {
            let jumps = Lattice::of(&field).jumps();
            return Ok(UniformField { field, method, audit, jumps });
        }
    }
    let field = plain_field(cells, order)?;
    let audit = audited(&field)?;
    if !audit.is_ok() {
        return Err(UniformError::Order(Box::new(audit)));
    }
    let jumps = Lattice::of(&field).jumps();
    Ok(UniformField { field, method: UniformMethod::Plain, audit, jumps })
}
