//! Values raised so that each cell is held by a lower one.
//!
//! A field that is solved for may be nearly level somewhere, or fall where the part hangs down. Nothing would hold a cell there: so each is raised to
//! [`MIN_RISE`] above the lowest of its face neighbours.

use super::march::MIN_RISE;
use super::{OnBase, beside};
use crate::cells::Cells;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The least values, by cell number, that are nowhere below `values`, and [`MIN_RISE`] above the lowest face neighbour's, but on the base, which has its own.
/// NaN where no way across faces leads to the base.
pub(super) fn lifted(cells: &Cells, base: &[OnBase], values: &[f64]) -> Vec<f64> {
    let mut lifted = vec![f64::NAN; values.len()];
    // Values are positive, so their bits are in their order; of equal ones the cell with the lowest number comes first.
    let mut queue: BinaryHeap<Reverse<(u64, u32)>> = BinaryHeap::new();
    for &(cell, value) in base {
        lifted[cell as usize] = value;
        queue.push(Reverse((value.to_bits(), cell)));
    }
    // Cells come in the order of their values, so the first one beside a cell is its lowest neighbour.
    while let Some(Reverse((_, cell))) = queue.pop() {
        let least = lifted[cell as usize] + MIN_RISE;
        for next in beside(cells, cell).into_iter().flatten() {
            if lifted[next as usize].is_nan() {
                let value = least.max(values[next as usize]);
                lifted[next as usize] = value;
                queue.push(Reverse((value.to_bits(), next)));
            }
        }
    }
    lifted
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The same by going over all cells until nothing changes: the value of a cell follows from its neighbours'.
    fn by_rounds(cells: &Cells, base: &[OnBase], values: &[f64]) -> Vec<f64> {
        let mut lifted = vec![f64::INFINITY; values.len()];
        base.iter().for_each(|&(cell, value)| lifted[cell as usize] = value);
        let is_base = |cell: &u32| base.iter().any(|base| base.0 == *cell);
        loop {
            let before = lifted.clone();
            for cell in cells.iter().filter(|cell| !is_base(cell)) {
                let lowest = beside(cells, cell).into_iter().flatten().map(|other| lifted[other as usize]);
                let lowest = lowest.fold(f64::INFINITY, f64::min);
                lifted[cell as usize] = (lowest + MIN_RISE).max(values[cell as usize]);
            }
            if before == lifted {
                return lifted.into_iter().map(|value| if value.is_finite() { value } else { f64::NAN }).collect();
            }
        }
    }

    proptest! {
        #[test]
        fn values_are_the_least_that_are_held(
            rows in prop::collection::vec(0u64..32, 20),
            values in prop::collection::vec(0.0..9.0f64, 100),
            heights in prop::collection::vec(0.001..1.0f64, 20),
        ) {
            let cells = Cells::new([5, 4, 5], &rows).unwrap();
            let base: Vec<OnBase> = cells.iter().filter(|&cell| cell < 20).map(|cell| (cell, heights[cell as usize])).collect();
            let found = lifted(&cells, &base, &values);
            let expected = by_rounds(&cells, &base, &values);
            prop_assert!(found.iter().zip(&expected).all(|(a, b)| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()));
        }
    }
}
