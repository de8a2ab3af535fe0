//! The least field above a given one in which every cell has its support in an earlier step.
//!
//! A priority flood (R. Barnes, C. Lehman, D. Mulla, "Priority-flood", Computers & Geosciences 62, 2014) with whole steps: a
//! cell comes no sooner than the step after the earliest of its neighbours. Cells leave the queue by rising time, so
//! the first neighbour to leave it decides.

use super::part::Part;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// `F(t)`; infinite where nothing that stands is reached. Times are finite and at least 0. What stands keeps its time.
pub(super) fn flooded(part: &Part, times: &[f64]) -> Vec<f64> {
    let mut out = vec![f64::INFINITY; times.len()];
    // Floats from 0 on are in the order of their bits.
    let mut queue: BinaryHeap<Reverse<(u64, usize)>> = BinaryHeap::new();
    for place in (0..times.len()).filter(|&place| part.stands[place]) {
        out[place] = times[place];
        queue.push(Reverse((times[place].to_bits(), place)));
    }
    while let Some(Reverse((bits, place))) = queue.pop() {
        let time = out[place];
        if bits != time.to_bits() {
            continue; // it was found sooner
        }
        for next in part.around(place) {
            let sooner = times[next].max(time.floor() + 1.0);
            if sooner < out[next] {
                out[next] = sooner;
                queue.push(Reverse((sooner.to_bits(), next)));
            }
        }
    }
    out
}
