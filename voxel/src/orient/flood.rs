//! One way round for all triangles that hang together by edges of two.

/// A triangle at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Use {
    /// Lesser corner in the upper half, greater one in the lower.
    edge: u64,
    /// The corner off the edge.
    apex: u32,
    /// Whether the triangle runs from the lesser corner to the greater one.
    pub(super) forward: bool,
    pub(super) triangle: u32,
}

/// Triangles in patches: all that hang together by edges of two triangles.
pub(super) struct Patches {
    /// The patch of each triangle, by its least triangle.
    pub(super) of: Vec<u32>,
    /// Which triangles are to be turned so that each patch looks one way: that of the larger part of its area.
    pub(super) turned: Vec<bool>,
    /// By patch, whether triangles disagreed; for other triangles than the least of a patch it means nothing.
    pub(super) mixed: Vec<bool>,
    pub(super) disagreeing_edges: usize,
    /// All triangles at all edges, edge after edge, without the repeats of a triangle.
    uses: Vec<Use>,
}

impl Patches {
    /// Floods over a mesh of welded corners.
    ///
    /// # Errors
    /// Two triangles with a common edge that cannot agree, and the ends of that edge.
    pub(super) fn flood(triangles: &[[u32; 3]], areas: &[f64]) -> Result<Self, ([u32; 2], [u32; 2])> {
        let mut uses = Vec::with_capacity(3 * triangles.len());
        for (triangle, &[a, b, c]) in (0..).zip(triangles) {
            if a != b && b != c && c != a {
                for [from, to, apex] in [[a, b, c], [b, c, a], [c, a, b]] {
                    let edge = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
                    uses.push(Use { edge, apex, forward: from < to, triangle });
                }
            }
        }
        uses.sort_unstable();
        let mut sets = ParitySets::new(triangles.len());
        // A triangle that repeats another goes with it, whatever becomes of that.
        uses.dedup_by(|next, first| {
            let repeats = (next.edge, next.apex, next.forward) == (first.edge, first.apex, first.forward);
            repeats && sets.join(first.triangle, next.triangle, false)
        });
        let mut disagreeing = Vec::new();
        for run in uses.chunk_by(|a, b| a.edge == b.edge) {
            if let [a, b] = run {
                let disagree = a.forward == b.forward;
                if !sets.join(a.triangle, b.triangle, disagree) {
                    return Err(([a.triangle, b.triangle], a.ends()));
                }
                if disagree {
                    disagreeing.push(a.triangle);
                }
            }
        }

        let found: Vec<(u32, bool)> = (0..triangles.len() as u32).map(|triangle| sets.find(triangle)).collect();
        let mut lead = vec![0.0; triangles.len()];
        for (&(patch, odd), &area) in found.iter().zip(areas) {
            lead[patch as usize] += if odd { -area } else { area };
        }
        let mut mixed = vec![false; triangles.len()];
        disagreeing.iter().for_each(|&triangle| mixed[found[triangle as usize].0 as usize] = true);
        Ok(Patches {
            turned: found.iter().map(|&(patch, odd)| odd != (lead[patch as usize] < 0.0)).collect(),
            of: found.iter().map(|&(patch, _)| patch).collect(),
            mixed,
            disagreeing_edges: disagreeing.len(),
            uses,
        })
    }

    /// The triangles at each edge.
    pub(super) fn edges(&self) -> impl Iterator<Item = &[Use]> {
        self.uses.chunk_by(|a, b| a.edge == b.edge)
    }

    /// +1 if the triangle, turned as it is to be, runs along the edge forwards, else -1.
    pub(super) fn way(&self, at: &Use) -> i32 {
        if at.forward != self.turned[at.triangle as usize] { 1 } else { -1 }
    }
}

impl Use {
    /// The ends of the edge.
    pub(super) fn ends(&self) -> [u32; 2] {
        [(self.edge >> 32) as u32, self.edge as u32]
    }
}

/// Sets in which each member stands one way or the other beside the least.
struct ParitySets {
    parents: Vec<u32>,
    /// Whether each stands otherwise than its parent.
    odd: Vec<bool>,
}

impl ParitySets {
    fn new(len: usize) -> Self {
        ParitySets { parents: (0..len as u32).collect(), odd: vec![false; len] }
    }

    /// The least member of the set of `of`, and whether `of` stands otherwise than that.
    fn find(&mut self, mut of: u32) -> (u32, bool) {
        let mut odd = false;
        loop {
            let at = of as usize;
            let parent = self.parents[at] as usize;
            if parent == at {
                return (of, odd);
            }
            // Every second step is shortened, so that long chains vanish.
            self.odd[at] ^= self.odd[parent];
            self.parents[at] = self.parents[parent];
            odd ^= self.odd[at];
            of = self.parents[at];
        }
    }

    /// Joins two sets so that `a` and `b` stand alike, or `odd`ly. False if they hang together already, the other way.
    fn join(&mut self, a: u32, b: u32, odd: bool) -> bool {
        let ((a, odd_a), (b, odd_b)) = (self.find(a), self.find(b));
        let between = odd ^ odd_a ^ odd_b;
        if a == b {
            return !between;
        }
        let (least, other) = (a.min(b), a.max(b));
        self.parents[other as usize] = least;
        self.odd[other as usize] = between;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chains joined in an order that makes them long: parities are those of the sums along them.
    #[test]
    fn parities_add_up_along_chains() {
        let mut sets = ParitySets::new(100);
        let odd = |k: u32| k % 3 == 1;
        for k in (0..99).rev() {
            assert!(sets.join(k, k + 1, odd(k)));
        }
        let sum = |k: u32| (0..k).filter(|&j| odd(j)).count() % 2 == 1;
        for k in 0..100 {
            assert_eq!(sets.find(k), (0, sum(k)));
        }
        assert!(sets.join(5, 99, sum(5) != sum(99)) && !sets.join(5, 99, sum(5) == sum(99)));
    }
}
