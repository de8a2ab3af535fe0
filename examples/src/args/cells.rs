//! How large the cells are, and how the part grows of them.

use super::rules::{above_zero, count, eps};
use clap::{Args, ValueEnum};
use curvlay_layers::curved;
use curvlay_voxel::Resolution;

/// How large the cells are: one of the two, or neither.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Cells and their order")]
pub struct VoxelArgs {
    /// Number of cells to aim for [default: as many as make a cell as high as a layer, but 100,000 at most; for large parts as many as
    /// make a cell four layers high]
    #[arg(long, value_name = "N", conflicts_with = "cell", value_parser = count, allow_negative_numbers = true)]
    pub voxels: Option<u64>,
    /// Edge of a cell in millimetres
    #[arg(long, value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub cell: Option<f64>,
}

impl VoxelArgs {
    /// As voxelising takes it, if the user says.
    pub fn resolution(&self) -> Option<Resolution> {
        self.cell.map(Resolution::Cell).or(self.voxels.map(Resolution::Count))
    }
}

/// How the part grows.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Cells and their order")]
pub struct GrowArgs {
    /// Depth inside the hull from which a cell counts as shadowed, in cells
    #[arg(long = "eps", value_name = "CELLS", default_value_t = 1.0, value_parser = eps, allow_negative_numbers = true)]
    pub eps_cells: f64,
    /// Only cells deeper than --eps count as shadowed, not those at exactly that depth
    #[arg(long)]
    pub beyond_eps: bool,
    /// How the next layer is chosen
    #[arg(long, default_value = "best")]
    pub strategy: Strategy,
    /// How the strategies governed and printed keep cells from being shadowed
    #[arg(long, default_value = "adaptive")]
    pub prevention: Prevention,
}

impl GrowArgs {
    /// As growing takes it; `None` for the best one.
    pub fn strategy(&self) -> Option<curved::Strategy> {
        let prevention = match self.prevention {
            Prevention::Incremental => curved::Prevention::Incremental,
            Prevention::Adaptive => curved::Prevention::Adaptive,
        };
        match self.strategy {
            Strategy::Best => None,
            Strategy::Greedy => Some(curved::Strategy::Greedy),
            Strategy::Incremental => Some(curved::Strategy::Incremental),
            Strategy::Adaptive => Some(curved::Strategy::Adaptive),
            Strategy::Governed => Some(curved::Strategy::Governed(prevention)),
            Strategy::Unbuild => Some(curved::Strategy::Unbuild),
            Strategy::Printed => Some(curved::Strategy::Printed(prevention)),
        }
    }
}

/// How the next layer is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Strategy {
    /// Incremental; where that misses cells, un-built as well: what fills more of the part.
    Best,
    /// All cells that can be built now.
    Greedy,
    /// Cell by cell, unless it shadows others.
    Incremental,
    /// All, halving the set while it shadows others.
    Adaptive,
    /// In the order of a peeling field.
    Governed,
    /// In the reverse of the order in which the part can be taken apart.
    Unbuild,
    /// Field-governed as printed in the dissertation, to compare with.
    Printed,
}

/// How cells are kept from being shadowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Prevention {
    /// Cell by cell.
    Incremental,
    /// By halving sets.
    Adaptive,
}
