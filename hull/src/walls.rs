//! The planes of all facets, laid out for one pass over them.
//!
//! Normals and offsets are integers below 2^53 (see [`crate::MAX_COORDINATE`]), so they are exact as `f64`, and so
//! are heights of lattice points. As separate columns of `f64` they are compared several at a time.

use crate::plane::Plane;

/// Planes by the number of their facet, with gaps.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walls {
    blocks: Vec<Block>,
    /// Number of facets, gaps included.
    len: usize,
}

/// Planes that are compared at a time: enough to keep the processor busy, few enough to find the one in a hit.
const BLOCK: usize = 8;

/// The columns of some planes.
#[derive(Clone, Copy, Debug)]
struct Block {
    x: [f64; BLOCK],
    y: [f64; BLOCK],
    z: [f64; BLOCK],
    /// Infinite where there is no facet: no point lies outside it, and it shows none.
    offset: [f64; BLOCK],
    inner: [f64; BLOCK],
    length: [f64; BLOCK],
}

impl Block {
    const EMPTY: Block = Block {
        x: [0.0; BLOCK],
        y: [0.0; BLOCK],
        z: [0.0; BLOCK],
        offset: [f64::INFINITY; BLOCK],
        inner: [f64::INFINITY; BLOCK],
        length: [1.0; BLOCK],
    };

    /// `normal . p` for one of the planes.
    fn dot(&self, k: usize, [px, py, pz]: [f64; 3]) -> f64 {
        self.x[k] * px + self.y[k] * py + self.z[k] * pz
    }
}

impl Walls {
    pub(crate) fn is_live(&self, facet: u32) -> bool {
        let at = facet as usize;
        at < self.len && self.blocks[at / BLOCK].offset[at % BLOCK].is_finite()
    }

    pub(crate) fn live(&self) -> impl Iterator<Item = u32> {
        (0..self.len as u32).filter(|&facet| self.is_live(facet))
    }

    pub(crate) fn plane(&self, facet: u32) -> Plane {
        let (block, k) = self.at(facet);
        let normal = [block.x[k], block.y[k], block.z[k]].map(|c| c as i64);
        Plane { normal, offset: block.offset[k] as i64, inner: block.inner[k] as i64 }
    }

    pub(crate) fn push(&mut self, plane: &Plane) {
        if self.len.is_multiple_of(BLOCK) {
            self.blocks.push(Block::EMPTY);
        }
        self.len += 1;
        self.set(self.len as u32 - 1, plane);
    }

    pub(crate) fn pop(&mut self) {
        if let Some(last) = self.len.checked_sub(1) {
            self.take(last as u32);
            self.len = last;
            self.blocks.truncate(last.div_ceil(BLOCK));
        }
    }

    pub(crate) fn clear(&mut self) {
        self.blocks.clear();
        self.len = 0;
    }

    pub(crate) fn set(&mut self, facet: u32, plane: &Plane) {
        let (block, k) = (&mut self.blocks[facet as usize / BLOCK], facet as usize % BLOCK);
        [block.x[k], block.y[k], block.z[k]] = plane.normal.map(|c| c as f64);
        block.offset[k] = plane.offset as f64;
        block.inner[k] = plane.inner as f64;
        block.length[k] = plane.length();
    }

    /// Leaves a gap and returns what was there.
    pub(crate) fn take(&mut self, facet: u32) -> Plane {
        let plane = self.plane(facet);
        let (block, k) = (&mut self.blocks[facet as usize / BLOCK], facet as usize % BLOCK);
        block.offset[k] = f64::INFINITY;
        block.inner[k] = f64::INFINITY;
        plane
    }

    /// Height of `p` over the facet, times the length of its normal; exact.
    pub(crate) fn height(&self, facet: u32, p: [i32; 3]) -> f64 {
        let (block, k) = self.at(facet);
        block.dot(k, p.map(f64::from)) - block.offset[k]
    }

    /// Height of `p` over the facet.
    pub(crate) fn distance(&self, facet: u32, p: [i32; 3]) -> f64 {
        let (block, k) = self.at(facet);
        (block.dot(k, p.map(f64::from)) - block.offset[k]) / block.length[k]
    }

    /// Whether the facet shows that `p` is not deep.
    pub(crate) fn shows(&self, facet: u32, p: [i32; 3]) -> bool {
        let (block, k) = self.at(facet);
        block.dot(k, p.map(f64::from)) > block.inner[k]
    }

    /// The first facet that `p` lies strictly outside of.
    pub(crate) fn first_below(&self, p: [i32; 3]) -> Option<u32> {
        self.first_exceeded(p, |block| &block.offset)
    }

    /// The first facet that shows that `p` is not deep.
    pub(crate) fn first_showing(&self, p: [i32; 3]) -> Option<u32> {
        self.first_exceeded(p, |block| &block.inner)
    }

    fn first_exceeded(&self, p: [i32; 3], bounds: impl Fn(&Block) -> &[f64; BLOCK]) -> Option<u32> {
        let p = p.map(f64::from);
        let exceeded = |block: &Block, k: usize| block.dot(k, p) > bounds(block)[k];
        let any = |block: &Block| (0..BLOCK).fold(false, |any, k| any | exceeded(block, k));
        let hit = self.blocks.iter().position(any)?;
        let k = (0..BLOCK).find(|&k| exceeded(&self.blocks[hit], k))?;
        Some((hit * BLOCK + k) as u32)
    }

    fn at(&self, facet: u32) -> (&Block, usize) {
        (&self.blocks[facet as usize / BLOCK], facet as usize % BLOCK)
    }
}
