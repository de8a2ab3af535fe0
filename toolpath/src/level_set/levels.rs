//! Distances at which level sets are taken: the same everywhere, or different from place to place.

/// Levels as the distance at which each lies, for each vertex of the refined mesh; linear in between. They rise: at no
/// vertex is a level below or at the one before.
pub(crate) trait Levels {
    /// How many there are.
    fn count(&self) -> usize;

    /// Where a level lies at a vertex.
    fn at(&self, level: usize, vertex: u32) -> f64;

    /// How many levels are below a value at a vertex.
    fn below(&self, value: f64, vertex: u32) -> usize {
        let (mut low, mut high) = (0, self.count());
        while low < high {
            let middle = (low + high) / 2;
            if self.at(middle, vertex) < value { low = middle + 1 } else { high = middle }
        }
        low
    }
}

impl Levels for [f64] {
    fn count(&self) -> usize {
        self.len()
    }

    fn at(&self, level: usize, _vertex: u32) -> f64 {
        self[level]
    }
}
