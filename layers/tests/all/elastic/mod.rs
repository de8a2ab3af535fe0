//! Stresses under load: closed forms, an assembled twin, what is refused.

mod closed_forms;
mod composite;
mod dense_twin;
mod errors;
mod follow;

use curvlay_layers::cells::Cells;
use curvlay_layers::elastic::{
    Elastic, ElasticError, ElasticOptions, ElasticPart, Load, Material, Support, solve_elastic,
};

/// A solid in a small grid.
pub struct Solid {
    pub dims: [u32; 3],
    pub rows: Vec<u64>,
}

impl Solid {
    pub fn new(dims: [u32; 3], is_solid: impl Fn([u32; 3]) -> bool) -> Solid {
        let words = dims[0].div_ceil(64) as usize;
        let mut rows = vec![0; words * (dims[1] * dims[2]) as usize];
        for (z, y, x) in (0..dims[2]).flat_map(|z| (0..dims[1]).flat_map(move |y| (0..dims[0]).map(move |x| (z, y, x))))
        {
            if is_solid([x, y, z]) {
                rows[(y + dims[1] * z) as usize * words + x as usize / 64] |= 1 << (x % 64);
            }
        }
        Solid { dims, rows }
    }

    pub fn cells(&self) -> Cells<'_> {
        Cells::new(self.dims, &self.rows).unwrap()
    }

    /// The number of a node.
    pub fn node(&self, [x, y, z]: [u32; 3]) -> u32 {
        x + (self.dims[0] + 1) * (y + (self.dims[1] + 1) * z)
    }

    pub fn solve(
        &self,
        cell_mm: f64,
        material: Material,
        supports: &[Support],
        loads: &[Load],
    ) -> Result<Elastic, ElasticError> {
        let part = ElasticPart { cells: &self.cells(), cell_mm, material, supports, loads };
        let options = ElasticOptions { tolerance: 1e-9, ..ElasticOptions::default() };
        solve_elastic(&part, &options, &super::common::go)
    }
}
