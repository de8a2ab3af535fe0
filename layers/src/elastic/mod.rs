//! Stresses in a part under load, on its cells.
//!
//! Of one isotropic material ([`solve_elastic`]), or with tapes of fibre in it ([`solve_composite`]). Each cell of the part is a brick of 8 nodes, as it is in topology optimisation: N. Aage, E. Andreassen, B. S. Lazarov, "Topology optimization using
//! PETSc", Struct. Multidiscip. Optim. 51(3), 2015. The bricks bend as they should (inner modes, [`Material`]), have few
//! stiffnesses, and the equations are solved by conjugate gradients with a V-cycle of geometric multigrid as preconditioner.
//!
//! Symbols: `K` is the stiffness, `u` the displacements, `f` the forces: `K u = f`.
//!
//! # Where stresses can be trusted
//! The border of the part is one of cells, a staircase. Around a hole of 8 cells radius stresses are within 10 % of the closed form from a cell and a
//! half off its border on, in a beam that is bent displacements within 1 % with two cells across (tests). In the outermost cells of a
//! slanted or round border they may be off by far more.

mod composite;
mod conditions;
pub(crate) mod elements;
mod error;
pub(crate) mod material;
mod mechanism;
mod multigrid;
pub(crate) mod nodes;
mod operator;
mod orthotropic;
mod solve;
mod transfer;

pub use composite::{Bond, Plies, Ply, Strip, load_factor, plies, solve_composite, traction};
pub use conditions::{Load, Region, Support};
pub use error::{BoundaryCondition, ElasticError};
pub use material::{Material, Principal, principal_stresses, stress_matrix, von_mises};
pub use orthotropic::{Orthotropic, laminate};

use crate::ProgressFn;
use crate::cells::Cells;
use crate::{Progress, parallel};
use conditions::Places;
use elements::Elements;
use multigrid::{Multigrid, free, minus};
use nalgebra::Matrix6;
use nodes::{NONE, Points};
use operator::{Operator, Triple};
use solve::{Outcome, conjugate_gradients};
use std::collections::BTreeMap;

/// A part, what holds it and what loads it.
#[derive(Clone, Copy, Debug)]
pub struct ElasticPart<'a> {
    /// The cells.
    pub cells: &'a Cells<'a>,
    /// Edge of a cell in millimetres.
    pub cell_mm: f64,
    /// What it is made of.
    pub material: Material,
    /// What holds it.
    pub supports: &'a [Support],
    /// What loads it; without any, supports that are moved do.
    pub loads: &'a [Load],
}

/// How exactly to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct ElasticOptions {
    /// Norm of the forces that are not in balance, as a share of the norm of the loads. Default 1e-6: displacements then are off by far
    /// less than by the size of the cells.
    pub tolerance: f64,
    /// Iterations after which it gives up. Default 500; 10 to 45 are usual, a plate three cells thick takes 85.
    pub max_iterations: u32,
}

impl Default for ElasticOptions {
    fn default() -> Self {
        ElasticOptions { tolerance: 1e-6, max_iterations: 500 }
    }
}

/// Displacements and stresses.
#[derive(Clone, Debug, PartialEq)]
pub struct Elastic {
    /// The nodes, rising: node `[x, y, z]` has the number `x + (nx + 1) * (y + (ny + 1) * z)` in a grid of `nx`, `ny`, `nz` cells.
    pub nodes: Vec<u32>,
    /// The displacement of each node in millimetres.
    pub displacements_mm: Vec<[f64; 3]>,
    /// The cells, rising.
    pub cells: Vec<u32>,
    /// The stress at the centre of each cell in MPa: xx, yy, zz, xy, yz, zx.
    pub stresses_mpa: Vec<[f64; 6]>,
    /// Iterations made.
    pub iterations: u32,
    /// Norm of the forces that are not in balance, as a share of that of the loads.
    pub residual: f64,
}

impl Elastic {
    /// The displacement of a node in millimetres, by its number.
    pub fn displacement(&self, node: u32) -> Option<[f64; 3]> {
        self.nodes.binary_search(&node).ok().map(|at| self.displacements_mm[at])
    }

    /// The mean displacement of the nodes in a region, in millimetres; `None` where there are none.
    ///
    /// # Arguments
    /// * `dims`: cells of the grid; `cell_mm`: their edge.
    ///
    /// # Cost
    /// `O(n)` for `n` nodes.
    pub fn mean_displacement(&self, dims: [u32; 3], cell_mm: f64, region: &Region) -> Option<[f64; 3]> {
        let [nx, ny] = [dims[0], dims[1]].map(|cells| u64::from(cells) + 1);
        let is_in = |node: u32| {
            let node = u64::from(node);
            let at = [node % nx, node / nx % ny, node / nx / ny].map(|k| k as f64 * cell_mm);
            (0..3).all(|k| (region.low_mm[k]..=region.high_mm[k]).contains(&at[k]))
        };
        let (mut sum, mut count) = ([0.0; 3], 0u32);
        for (_, u) in self.nodes.iter().zip(&self.displacements_mm).filter(|(node, _)| is_in(**node)) {
            (0..3).for_each(|k| sum[k] += u[k]);
            count += 1;
        }
        (count > 0).then(|| sum.map(|k| k / f64::from(count)))
    }

    /// The stress of a cell in MPa, by its number.
    pub fn stress(&self, cell: u32) -> Option<[f64; 6]> {
        self.cells.binary_search(&cell).ok().map(|at| self.stresses_mpa[at])
    }
}

/// Finds the displacements of a part under load, and its stresses.
///
/// # Arguments
/// * `progress`: called with the stage `elastic`, and how many hundredths of the way to the tolerance the residual has come on a logarithmic scale;
///   may cancel.
///
/// # Errors
/// [`ElasticError`]: for a part that is not held everywhere, regions that hold nothing, numbers that are not finite, no convergence.
///
/// # Cost
/// `O(n)` for `n` cells; see `docs/benchmarks.md`. Memory: about half a kilobyte for each cell. Several threads with the feature
/// `rayon`; the same input gives the same result on any number of them, bit for bit.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::elastic::{ElasticOptions, ElasticPart, Load, Material, Region, Support, solve_elastic};
/// // A bar of 2 x 2 x 10 cells of 1 mm that stands on the plate and is pulled upwards by 40 N: 10 MPa.
/// let rows = [0b11; 20];
/// let cells = Cells::new([2, 2, 10], &rows)?;
/// let part = ElasticPart {
///     cells: &cells,
///     cell_mm: 1.0,
///     material: Material { young_mpa: 1000.0, poisson: 0.0 },
///     supports: &[Support::fixed(Region::plane(2, 0.0))],
///     loads: &[Load::Force { region: Region::plane(2, 10.0), newtons: [0.0, 0.0, 40.0] }],
/// };
/// let elastic = solve_elastic(&part, &ElasticOptions::default(), &|_| std::ops::ControlFlow::Continue(()))?;
/// assert!(elastic.stresses_mpa.iter().all(|stress| (stress[2] - 10.0).abs() < 1e-4));
/// assert!((elastic.displacements_mm[90 + 4][2] - 0.1).abs() < 1e-6); // 10 MPa / 1000 MPa * 10 mm
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn solve_elastic(
    part: &ElasticPart,
    options: &ElasticOptions,
    progress: ProgressFn,
) -> Result<Elastic, ElasticError> {
    solve(part, &Laws { plain: part.material.law_of(), others: BTreeMap::new() }, options, progress)
}

/// Stress from strain in the cells of a part.
struct Laws {
    /// In all cells but others.
    plain: Matrix6<f64>,
    /// By cell.
    others: BTreeMap<u32, Matrix6<f64>>,
}

impl Laws {
    /// Those that differ, and which of them each cell has.
    fn pooled(&self, cells: &Points) -> (Vec<Matrix6<f64>>, Vec<u32>) {
        let law = |cell: &u32| self.others.get(cell).unwrap_or(&self.plain);
        let bits = |law: &Matrix6<f64>| -> [u64; 36] { std::array::from_fn(|k| law.as_slice()[k].to_bits()) };
        let (keys, of_cell) = elements::pooled(cells.ids.iter().map(|cell| bits(law(cell))));
        (keys.iter().map(|bits| Matrix6::from_fn(|i, j| f64::from_bits(bits[i + 6 * j]))).collect(), of_cell)
    }
}

/// See [`solve_elastic`].
fn solve(
    part: &ElasticPart,
    laws: &Laws,
    options: &ElasticOptions,
    progress: ProgressFn,
) -> Result<Elastic, ElasticError> {
    check(part, options)?;
    let Discrete { cells, nodes, corners } = Discrete::of(part.cells)?;
    let places = Places { cells: &cells, nodes: &nodes, corners: &corners, cell_mm: part.cell_mm };
    let (fixed, moved) = places.supported(part.supports)?;
    mechanism::check(&places, &fixed)?;
    let forces = places.forces(part.loads)?;
    let report = |done: u64| progress(Progress { stage: "elastic", done, total: 100 }).is_continue();
    if !report(0) {
        return Err(ElasticError::Cancelled);
    }
    let (laws, law_of) = laws.pooled(&cells);
    let cubes = parallel::map(laws.len(), |law| material::stiffness(&laws[law], part.cell_mm));
    let unfixed = Elements { matrices: cubes, of_cell: law_of.clone() };
    let operator = Operator::new(&unfixed, &cells, &nodes);
    // What is left once the supports that are moved have been.
    let b: Vec<Triple> =
        parallel::map(nodes.len(), |node| free(&fixed, node, minus(forces[node], operator.at(node, &moved))));
    let elements = Elements::fine(&unfixed, &corners, &fixed);
    let ids = (nodes.ids.clone(), cells.ids.clone());
    let mut multigrid = Multigrid::new(operator, elements, cells, nodes, &fixed);
    let hundredths = |residual: f64| (100.0 * residual.ln() / options.tolerance.ln()).clamp(0.0, 100.0) as u64;
    let go_on = |residual: f64| report(hundredths(residual));
    let ElasticOptions { tolerance, max_iterations } = *options;
    let (mut u, outcome) = conjugate_gradients(&mut multigrid, &b, &fixed, tolerance, max_iterations, &go_on);
    if outcome.cancelled {
        return Err(ElasticError::Cancelled);
    }
    if outcome.residual.is_nan() || outcome.residual > tolerance {
        return Err(ElasticError::NoConvergence { iterations: outcome.iterations, residual: outcome.residual });
    }
    u.iter_mut().zip(&moved).for_each(|(u, moved)| multigrid::add(u, *moved));
    let at_centre = parallel::map(laws.len(), |law| material::stress_at_centre(&laws[law], part.cell_mm));
    let stress = |cell: usize| {
        let of_corners = corners[cell].iter().flat_map(|&node| u[node as usize]);
        (at_centre[law_of[cell] as usize] * nalgebra::SVector::<f64, 24>::from_iterator(of_corners)).into()
    };
    let stresses_mpa = parallel::map(corners.len(), stress);
    let Outcome { iterations, residual, .. } = outcome;
    Ok(Elastic { nodes: ids.0, displacements_mm: u, cells: ids.1, stresses_mpa, iterations, residual })
}

/// The cells that supports hold: those that chains of common faces join to a supported node, as bits like those of [`Cells::rows`].
/// What else there is [`solve_elastic`] refuses.
///
/// # Errors
/// Those of [`solve_elastic`] that concern cells and supports, but for [`ElasticError::NotConnected`] and [`ElasticError::Loose`].
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::elastic::{Region, Support, supported_cells};
/// let cells = Cells::new([4, 1, 1], &[0b1011])?; // the last one stands alone
/// let rows = supported_cells(&cells, 1.0, &[Support::fixed(Region::plane(0, 0.0))])?;
/// assert_eq!(rows, [0b0011]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn supported_cells(cells: &Cells, cell_mm: f64, supports: &[Support]) -> Result<Vec<u64>, ElasticError> {
    let part = ElasticPart { cells, cell_mm, material: Material::default(), supports, loads: &[] };
    check(&part, &ElasticOptions::default())?;
    let discrete = Discrete::of(cells)?;
    let places = Places { cells: &discrete.cells, nodes: &discrete.nodes, corners: &discrete.corners, cell_mm };
    let (fixed, _) = places.supported(supports)?;
    let (piece_of, pieces) = mechanism::pieces_held(&places, &fixed);
    let mut rows = vec![0; cells.rows().len()];
    for (cell, _) in piece_of.iter().enumerate().filter(|&(_, &piece)| pieces[piece as usize].is_supported()) {
        let [x, y, z] = discrete.cells.place(cell);
        let row = y as usize + cells.dims()[1] as usize * z as usize;
        rows[row * cells.words_per_row() + x as usize / 64] |= 1 << (x % 64);
    }
    Ok(rows)
}

/// Whether it can begin.
fn check(part: &ElasticPart, options: &ElasticOptions) -> Result<(), ElasticError> {
    let ElasticOptions { tolerance, max_iterations } = *options;
    let Material { young_mpa, poisson } = part.material;
    if !(part.cell_mm > 0.0 && part.cell_mm.is_finite()) {
        return Err(ElasticError::Cell { cell_mm: part.cell_mm });
    }
    if !part.material.is_sound() {
        return Err(ElasticError::Material { young_mpa, poisson });
    }
    if !(tolerance > 0.0 && tolerance < 1.0 && max_iterations > 0) {
        return Err(ElasticError::Options { tolerance, max_iterations });
    }
    Ok(())
}

/// Cells and nodes, numbered in the order in which they are worked on.
struct Discrete {
    cells: Points,
    nodes: Points,
    corners: Vec<[u32; 8]>,
}

impl Discrete {
    fn of(cells: &Cells) -> Result<Self, ElasticError> {
        let dims = cells.dims();
        if dims.iter().map(|&side| u64::from(side) + 1).product::<u64>() >= u64::from(NONE) {
            return Err(ElasticError::TooLarge { dims });
        }
        let cells = Points::new(dims, cells.iter().collect());
        if cells.len() == 0 {
            return Err(ElasticError::NoCell);
        }
        let nodes = Points::corners(&cells);
        let corners = nodes.of_cells(&cells);
        Ok(Discrete { cells, nodes, corners })
    }
}
