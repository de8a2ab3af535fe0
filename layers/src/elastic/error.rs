//! What is wrong with an elastic problem.

/// Why displacements could not be found.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElasticError {
    /// There is no cell.
    #[error("there is no cell to load")]
    NoCell,
    /// More nodes than a number of 32 bits counts.
    #[error("a grid of {dims:?} cells has 2^32 nodes or more: take larger cells")]
    TooLarge {
        /// Cells along x, y and z.
        dims: [u32; 3],
    },
    /// The edge of a cell is no length.
    #[error("cells of {cell_mm} mm: the edge must be finite and above 0")]
    Cell {
        /// The edge that was given, in millimetres.
        cell_mm: f64,
    },
    /// The material cannot be.
    #[error(
        "a material with Young's modulus {young_mpa} MPa and Poisson's ratio {poisson}: the modulus must be finite and above 0, the ratio \
         above -1 and below 0.5"
    )]
    Material {
        /// Young's modulus in MPa.
        young_mpa: f64,
        /// Poisson's ratio.
        poisson: f64,
    },
    /// An invalid orthotropic material: a modulus that is not above 0 and finite, or Poisson's ratios with which a strain would give work.
    #[error(
        "an orthotropic material whose moduli are not all above 0 and finite, or whose Poisson's ratios are too large for them"
    )]
    Orthotropic,
    /// A ply that cannot be.
    #[error("ply {ply} is of no cell, its direction is its normal or none, or its share is not above 0 and at most 1")]
    Ply {
        /// Which, from 0.
        ply: usize,
    },
    /// A strip that cannot be.
    #[error("strip {strip} has no two finite points with a normal each, or no finite width and thickness above 0")]
    Strip {
        /// Which, from 0.
        strip: usize,
    },
    /// A strip that is larger than any part of such cells.
    #[error("strip {strip} is larger than ten million faces of cells: are both in one unit?")]
    FineStrip {
        /// Which, from 0.
        strip: usize,
    },
    /// The tolerance or the number of iterations is invalid.
    #[error(
        "a tolerance of {tolerance} within {max_iterations} iterations: it must lie above 0 and below 1, with one iteration at least"
    )]
    Options {
        /// The tolerance that was asked for.
        tolerance: f64,
        /// Iterations that were allowed.
        max_iterations: u32,
    },
    /// A load, a displacement or a corner of a region is not a number, or infinite.
    #[error("{what} {number} holds a number that is not finite")]
    NotFinite {
        /// Support or load.
        what: BoundaryCondition,
        /// Which one, counted from 0.
        number: usize,
    },
    /// The region holds nothing that a support or a load could act on.
    #[error("the region of {what} {number} holds no {}: the part lies within {low:?} to {high:?} mm", .what.acts_on())]
    EmptyRegion {
        /// Support or load.
        what: BoundaryCondition,
        /// Which one, counted from 0.
        number: usize,
        /// Lower corner of the box around the part, in millimetres.
        low: [f64; 3],
        /// Its upper corner.
        high: [f64; 3],
    },
    /// Two supports ask for different displacements of a node.
    #[error("support {support} moves node {node:?} by {second} mm along axis {axis}, an earlier one by {first} mm")]
    Contradiction {
        /// The later support, counted from 0.
        support: usize,
        /// The node.
        node: [u32; 3],
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
        /// What the earlier support asks for, in millimetres.
        first: f64,
        /// What the later one asks for.
        second: f64,
    },
    /// Nothing holds the part.
    #[error("no support: the loads would move the part away; hold a region of it")]
    NoSupport,
    /// Cells that no chain of common faces joins to a supported node.
    #[error(
        "{cells} of {of} cells are not joined to a support through common faces (an edge or a corner is a hinge): support them too, or take \
         only `supported_cells`"
    )]
    NotConnected {
        /// Cells that nothing holds.
        cells: usize,
        /// All cells.
        of: usize,
    },
    /// The supports let a piece slide or turn.
    #[error(
        "the supports leave {free} of 6 rigid motions free to a piece of {cells} cells: fix more axes, or nodes that are not on a line"
    )]
    Loose {
        /// Independent motions that are left.
        free: usize,
        /// Cells of the piece.
        cells: usize,
    },
    /// The residual did not become small enough.
    #[error(
        "no convergence: the relative residual is {residual:.1e} after {iterations} iterations; allow more, or a larger tolerance"
    )]
    NoConvergence {
        /// Iterations made.
        iterations: u32,
        /// Norm of what is not in balance, as a share of the loads.
        residual: f64,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// What a user gives with a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundaryCondition {
    /// A [`Support`](super::Support).
    Support,
    /// A [`Load`](super::Load).
    Load,
}

impl BoundaryCondition {
    fn acts_on(self) -> &'static str {
        match self {
            BoundaryCondition::Support => "node",
            BoundaryCondition::Load => "centre of an outer face",
        }
    }
}

impl std::fmt::Display for BoundaryCondition {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            BoundaryCondition::Support => "support",
            BoundaryCondition::Load => "load",
        })
    }
}
