//! Candidates in the order of their distance from a first one, and in groups that hang together.

use crate::cells::CellSet;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

/// Lengths are counted in this part of a cell, so that they can be compared exactly.
const PARTS: f64 = (1u64 << 32) as f64;

/// The candidates by their distance from the one with the least number, walking from neighbour to neighbour through the
/// `set` that they belong to (Dijkstra's algorithm; Dai 2020, section 3.4.3, starts from any one). Those that do not hang together with it follow in
/// the same way.
pub(super) fn by_distance(candidates: &[u32], set: &CellSet, offsets: &[[i32; 3]]) -> Vec<u32> {
    let mut distance: BTreeMap<u32, u64> = BTreeMap::new();
    let mut ordered = Vec::with_capacity(candidates.len());
    let mut sorted = candidates.to_vec();
    sorted.sort_unstable();
    let steps: Vec<([i32; 3], u64)> = offsets.iter().map(|&o| (o, (length(o) * PARTS) as u64)).collect();
    for &first in &sorted {
        if distance.contains_key(&first) {
            continue;
        }
        distance.insert(first, 0);
        let mut queue = BinaryHeap::from([Reverse((0, first))]);
        while let Some(Reverse((far, cell))) = queue.pop() {
            if distance[&cell] < far {
                continue;
            }
            if sorted.binary_search(&cell).is_ok() {
                ordered.push(cell);
            }
            for (offset, step) in &steps {
                for next in set.around(cell, std::slice::from_ref(offset)) {
                    let known = distance.entry(next).or_insert(u64::MAX);
                    if far + step < *known {
                        *known = far + step;
                        queue.push(Reverse((far + step, next)));
                    }
                }
            }
        }
    }
    ordered
}

/// The candidates in groups of those that hang together, by their least number.
pub(super) fn groups(candidates: &[u32], set: &CellSet, offsets: &[[i32; 3]]) -> Vec<Vec<u32>> {
    let mut left: BTreeSet<u32> = candidates.iter().copied().collect();
    let mut groups = Vec::new();
    while let Some(first) = left.pop_first() {
        let mut group = vec![first];
        let mut done = 0;
        while let Some(&cell) = group.get(done) {
            group.extend(set.around(cell, offsets).filter(|next| left.remove(next)));
            done += 1;
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

/// How far apart the centres of neighbours are.
fn length(offset: [i32; 3]) -> f64 {
    offset.map(f64::from).iter().map(|d| d * d).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::Cells;
    use crate::curved::buildable::rules::Neighbours;

    #[test]
    fn nearer_cells_come_first_and_islands_last() {
        // . # # .
        // # . . .   (first row below), and an island in the next level but one
        let rows = [0b0001, 0b0110, 0, 0, 0b1000, 0];
        let cells = Cells::new([4, 2, 3], &rows).unwrap();
        let all: Vec<u32> = cells.iter().collect();
        let ordered = by_distance(&all, &CellSet::of(&cells), Neighbours::FaceOrEdge.offsets());
        assert_eq!(ordered, [0, 5, 6, 19]);
        let without_middle = by_distance(&[0, 6, 19], &CellSet::of(&cells), Neighbours::FaceOrEdge.offsets());
        assert_eq!(without_middle, [0, 6, 19]);
        let hanging = groups(&all, &CellSet::of(&cells), Neighbours::FaceOrEdge.offsets());
        assert_eq!(hanging, [vec![0, 5, 6], vec![19]]);
    }
}
