//! Cells as bits, with coarser and coarser grids above them.
//!
//! Level 0 is the cells; a block of level `l + 1` is two blocks of level `l` along each axis. Of each block two bits:
//! whether any cell in it is solid, and whether all are. A block that is full is one box, so what lies deep in the
//! part is never looked into. A cell that comes in changes one block a level.

use super::bounds::Aabb;
use nalgebra::{Point3, Vector3};

/// The bits of one level: bit `x % 64` of word `x / 64` of row `y + ny z`.
#[derive(Clone, Debug)]
struct Level {
    dims: [u32; 3],
    words: usize,
    any: Vec<u64>,
    full: Vec<u64>,
}

impl Level {
    fn new(dims: [u32; 3]) -> Self {
        let words = dims[0].div_ceil(64) as usize;
        let len = words * dims[1] as usize * dims[2] as usize;
        Level { dims, words, any: vec![0; len], full: vec![0; len] }
    }

    fn place(&self, [x, y, z]: [u32; 3]) -> (usize, u64) {
        let row = y as usize + self.dims[1] as usize * z as usize;
        (row * self.words + x as usize / 64, 1 << (x % 64))
    }

    fn any(&self, at: [u32; 3]) -> bool {
        let (word, bit) = self.place(at);
        self.any[word] & bit != 0
    }

    fn full(&self, at: [u32; 3]) -> bool {
        let (word, bit) = self.place(at);
        self.full[word] & bit != 0
    }
}

/// A part made of cells.
#[derive(Clone, Debug)]
pub(super) struct CellTree {
    levels: Vec<Level>,
    cell: f64,
}

impl CellTree {
    /// No cells yet. The caller has seen to it that a row a bit fits in memory.
    pub fn new(dims: [u32; 3], cell: f64) -> Self {
        let mut levels = vec![Level::new(dims)];
        let mut dims = dims;
        while dims != [1; 3] {
            dims = dims.map(|n| n.div_ceil(2));
            levels.push(Level::new(dims));
        }
        CellTree { levels, cell }
    }

    pub fn dims(&self) -> [u32; 3] {
        self.levels[0].dims
    }

    pub fn is_empty(&self) -> bool {
        self.levels[self.levels.len() - 1].any[0] == 0
    }

    /// Adds the cells of `rows` to those there are. `O(words + new cells)`.
    pub fn add(&mut self, rows: &[u64]) {
        let [_, ny, _] = self.dims();
        let words = self.levels[0].words;
        for (at, &word) in rows.iter().enumerate() {
            let mut fresh = word & !self.levels[0].any[at];
            let (row, first) = ((at / words) as u32, (at % words) as u32 * 64);
            while fresh != 0 {
                let x = first + fresh.trailing_zeros();
                fresh &= fresh - 1;
                self.set([x, row % ny, row / ny]);
            }
        }
    }

    fn set(&mut self, cell: [u32; 3]) {
        let (word, bit) = self.levels[0].place(cell);
        self.levels[0].any[word] |= bit;
        self.levels[0].full[word] |= bit;
        let mut at = cell;
        let mut filled = true;
        for level in 1..self.levels.len() {
            at = at.map(|n| n / 2);
            filled = filled && self.parts(level, at).all(|part| self.levels[level - 1].full(part));
            let here = &mut self.levels[level];
            let (word, bit) = here.place(at);
            let known = here.any[word] & bit != 0;
            here.any[word] |= bit;
            if filled {
                here.full[word] |= bit;
            } else if known {
                break;
            }
        }
    }

    /// The blocks within the grid that make up a block of a level above 0.
    fn parts(&self, level: usize, at: [u32; 3]) -> impl Iterator<Item = [u32; 3]> + '_ {
        let dims = self.levels[level - 1].dims;
        (0..8u32).filter_map(move |k| {
            let part = [2 * at[0] + (k & 1), 2 * at[1] + (k >> 1 & 1), 2 * at[2] + (k >> 2)];
            (0..3).all(|axis| part[axis] < dims[axis]).then_some(part)
        })
    }

    pub fn root(&self) -> Node {
        Node { level: self.levels.len() - 1, at: [0; 3] }
    }

    pub fn is_leaf(&self, node: &Node) -> bool {
        node.level == 0 || self.levels[node.level].full(node.at)
    }

    /// The blocks within a block that have cells.
    pub fn children(&self, node: &Node) -> impl Iterator<Item = Node> + '_ {
        let below = node.level - 1;
        let solid = move |at: &[u32; 3]| self.levels[below].any(*at);
        self.parts(node.level, node.at).filter(solid).map(move |at| Node { level: below, at })
    }

    pub fn bounds(&self, node: &Node) -> Aabb {
        let dims = self.dims();
        let low = Vector3::from(node.at.map(|n| f64::from(n << node.level)));
        let high: [f64; 3] = std::array::from_fn(|k| f64::from(((node.at[k] + 1) << node.level).min(dims[k])));
        Aabb::between(&Point3::from(low * self.cell), &Point3::from(Vector3::from(high) * self.cell))
    }
}

/// A block of some level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    pub level: usize,
    pub at: [u32; 3],
}
