//! The planes of all facets, laid out for one pass over them.
//!
//! Normals and offsets are integers below 2^53 (see [`crate::MAX_COORDINATE`]), so they are exact as `f64`, and so
//! are heights of lattice points. As separate columns of `f64` they are compared several at a time.

use crate::plane::Plane;

/// Planes by the number of their facet, with gaps.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walls {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    /// Infinite where a facet is gone: no point lies outside it, and it shows none.
    offset: Vec<f64>,
    inner: Vec<f64>,
    length: Vec<f64>,
}

/// Planes that are compared at a time.
const BLOCK: usize = 8;

impl Walls {
    /// Number of facets, gaps included.
    pub(crate) fn len(&self) -> usize {
        self.x.len()
    }

    pub(crate) fn is_live(&self, facet: u32) -> bool {
        self.offset.get(facet as usize).is_some_and(|offset| offset.is_finite())
    }

    pub(crate) fn live(&self) -> impl Iterator<Item = u32> {
        (0..self.len() as u32).filter(|&facet| self.is_live(facet))
    }

    pub(crate) fn plane(&self, facet: u32) -> Plane {
        let at = facet as usize;
        let normal = [self.x[at], self.y[at], self.z[at]].map(|c| c as i64);
        Plane { normal, offset: self.offset[at] as i64, inner: self.inner[at] as i64 }
    }

    pub(crate) fn push(&mut self, plane: &Plane) {
        for column in [&mut self.x, &mut self.y, &mut self.z, &mut self.offset, &mut self.inner, &mut self.length] {
            column.push(0.0);
        }
        self.set(self.len() as u32 - 1, plane);
    }

    pub(crate) fn pop(&mut self) {
        self.truncate(self.len().saturating_sub(1));
    }

    pub(crate) fn truncate(&mut self, len: usize) {
        for column in [&mut self.x, &mut self.y, &mut self.z, &mut self.offset, &mut self.inner, &mut self.length] {
            column.truncate(len);
        }
    }

    pub(crate) fn set(&mut self, facet: u32, plane: &Plane) {
        let at = facet as usize;
        [self.x[at], self.y[at], self.z[at]] = plane.normal.map(|c| c as f64);
        self.offset[at] = plane.offset as f64;
        self.inner[at] = plane.inner as f64;
        self.length[at] = plane.length();
    }

    /// Leaves a gap and returns what was there.
    pub(crate) fn take(&mut self, facet: u32) -> Plane {
        let plane = self.plane(facet);
        self.offset[facet as usize] = f64::INFINITY;
        self.inner[facet as usize] = f64::INFINITY;
        plane
    }

    /// Height of `p` over the facet, times the length of its normal; exact.
    pub(crate) fn height(&self, facet: u32, p: [i32; 3]) -> f64 {
        let (at, [px, py, pz]) = (facet as usize, p.map(f64::from));
        self.x[at] * px + self.y[at] * py + self.z[at] * pz - self.offset[at]
    }

    /// Height of `p` over the facet.
    pub(crate) fn distance(&self, facet: u32, p: [i32; 3]) -> f64 {
        self.height(facet, p) / self.length[facet as usize]
    }

    /// Whether the facet shows that `p` is not deep.
    pub(crate) fn shows(&self, facet: u32, p: [i32; 3]) -> bool {
        let (at, [px, py, pz]) = (facet as usize, p.map(f64::from));
        self.x[at] * px + self.y[at] * py + self.z[at] * pz > self.inner[at]
    }

    /// The first facet that `p` lies strictly outside of.
    pub(crate) fn first_below(&self, p: [i32; 3]) -> Option<u32> {
        self.first_exceeded(p, &self.offset)
    }

    /// The first facet that shows that `p` is not deep.
    pub(crate) fn first_showing(&self, p: [i32; 3]) -> Option<u32> {
        self.first_exceeded(p, &self.inner)
    }

    fn first_exceeded(&self, p: [i32; 3], bounds: &[f64]) -> Option<u32> {
        let [px, py, pz] = p.map(f64::from);
        let blocks = self.x.chunks(BLOCK).zip(self.y.chunks(BLOCK)).zip(self.z.chunks(BLOCK)).zip(bounds.chunks(BLOCK));
        for (block, (((x, y), z), bounds)) in blocks.enumerate() {
            let exceeded = |k: usize| x[k] * px + y[k] * py + z[k] * pz > bounds[k];
            let any = if x.len() == BLOCK {
                let (x, y, z, bounds) = (&x[..BLOCK], &y[..BLOCK], &z[..BLOCK], &bounds[..BLOCK]);
                (0..BLOCK).fold(false, |any, k| any | (x[k] * px + y[k] * py + z[k] * pz > bounds[k]))
            } else {
                true
            };
            if any && let Some(k) = (0..x.len()).find(|&k| exceeded(k)) {
                return Some((block * BLOCK + k) as u32);
            }
        }
        None
    }
}
