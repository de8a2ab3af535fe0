//! Marked nodes of a lattice, a bit each.

use super::lattice::Lattice;

/// Some nodes of a lattice.
#[derive(Clone)]
pub(super) struct Marks {
    strides: [usize; 3],
    bits: Vec<u64>,
}

impl Marks {
    /// No node of a lattice.
    pub(super) fn none_of(lattice: &Lattice) -> Self {
        Marks { strides: lattice.strides(), bits: vec![0; lattice.values.len().div_ceil(64)] }
    }

    pub(super) fn mark(&mut self, node: usize) {
        self.bits[node / 64] |= 1 << (node % 64);
    }

    pub(super) fn has(&self, node: usize) -> bool {
        self.bits[node / 64] >> (node % 64) & 1 == 1
    }

    /// These nodes and all that are at most so many steps from one of them along each axis. At the end of a row a step leads into the next one:
    /// there nodes are marked that need not be.
    pub(super) fn widened(mut self, steps: usize) -> Self {
        for stride in self.strides {
            let before = self.bits.clone();
            (1..=steps).for_each(|step| self.add_shifted(&before, step * stride));
        }
        self
    }

    /// Marks the nodes that lie so many numbers before and after others.
    fn add_shifted(&mut self, others: &[u64], by: usize) {
        let (words, bits) = (by / 64, by % 64);
        // The word of a row of bits that begins `bits` before or after that of the others.
        let of = |word: Option<usize>| word.and_then(|word| others.get(word)).copied().unwrap_or(0);
        for at in 0..self.bits.len() {
            let (up, down) = (at.checked_sub(words), at + words);
            self.bits[at] |= of(up) << bits | of(Some(down)) >> bits;
            if bits > 0 {
                let carried = of(up.and_then(|up| up.checked_sub(1))) >> (64 - bits);
                self.bits[at] |= carried | of(Some(down + 1)) << (64 - bits);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DIMS: [u32; 3] = [9, 11, 13];

    proptest! {
        #[test]
        fn all_in_reach_are_marked(places in prop::collection::vec((0..9_u32, 0..11_u32, 0..13_u32), 0..4), steps in 0_usize..4) {
            let len = DIMS.iter().product::<u32>() as usize;
            let lattice = Lattice { dims: DIMS, values: vec![0.0; len], joined: vec![0; len] };
            let mut marks = Marks::none_of(&lattice);
            places.iter().for_each(|&(x, y, z)| marks.mark(lattice.index([x, y, z])));
            let wide = marks.clone().widened(steps);
            for node in 0..len {
                let [x, y, z] = lattice.position(node);
                let away = |&(p, q, r): &(u32, u32, u32)| x.abs_diff(p).max(y.abs_diff(q)).max(z.abs_diff(r)) as usize;
                prop_assert!(wide.has(node) || places.iter().all(|place| away(place) > steps), "{node}");
                // Rows go on in the next ones, and no farther.
                let [a, b, c] = lattice.strides().map(|stride| stride * steps);
                let is_far = |&(p, q, r): &(u32, u32, u32)| lattice.index([p, q, r]).abs_diff(node) > a + b + c;
                prop_assert!(!wide.has(node) || !places.iter().all(is_far), "{node}");
            }
        }
    }
}
