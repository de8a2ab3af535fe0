//! Geometric multigrid on cells: one V-cycle of it comes near the inverse of the stiffness.
//!
//! U. Trottenberg, C. W. Oosterlee, A. Schüller, *Multigrid*, Academic Press 2001, sections 2.4 to 2.6. Each level has cells of twice the edge; a
//! larger cell is there if one of its eight is, with the Galerkin stiffness of those that are ([`Elements::coarse`]), so that the
//! border of the part and its supports are on every level what they are on the finest. M. Adams, M. Brezina, J. Hu, R. Tuminaro, "Parallel multigrid
//! smoothing: polynomial versus Gauss-Seidel", J. Comput. Phys. 188(2), 2003, section 2: the smoother is a Chebyshev polynomial of
//! the operator times the inverse of its diagonal, which any number of threads works out alike. The coarsest level is factored.

use super::elements::Elements;
use super::nodes::Points;
use super::operator::{Operator, Triple};
use super::transfer::Transfer;
use crate::parallel::{fill, sum, update};
use crate::sparse::{Entries, Factors};

/// Degree of the smoother: steps before and after each visit of the coarser levels. One step needs more iterations than it saves; three
/// save fewer than they cost.
const DEGREE: usize = 2;

/// The smoother works on eigenvalues from the largest down to this part of it; the lower ones are smooth enough for the next level.
const SMOOTHED: f64 = 0.15;

/// Steps of the power method that estimates the largest eigenvalue, and what is added to it: the estimate lies below it.
const POWER_STEPS: usize = 12;
const POWER_MARGIN: f64 = 1.1;

/// At most so many nodes are left to the factors: a cycle solves with them once, in less time than it smooths the level above.
const COARSEST: usize = 200;

/// The levels, and what each of them works with.
#[derive(Debug)]
pub(super) struct Multigrid {
    levels: Vec<Level>,
    coarsest: Coarsest,
}

#[derive(Debug)]
struct Level {
    operator: Operator,
    /// Largest eigenvalue of the inverse diagonal times the operator, about.
    largest: f64,
    transfer: Transfer,
    work: Work,
}

/// Vectors of a level that are used again.
#[derive(Debug)]
struct Work {
    residual: Vec<Triple>,
    step: Vec<Triple>,
}

impl Multigrid {
    /// The levels below the finest one, whose operator is `fine`.
    ///
    /// * `elements`: those of `cells`, without what is fixed.
    pub(super) fn new(fine: Operator, elements: Elements, cells: Points, nodes: Points, fixed: &[u8]) -> Self {
        let mut levels: Vec<Level> = Vec::new();
        let (mut operator, mut elements, mut cells, mut nodes) = (fine, elements, cells, nodes);
        while nodes.len() > COARSEST {
            let coarse_cells = cells.halved();
            let coarse_nodes = Points::corners(&coarse_cells);
            elements = elements.coarse(&cells, &coarse_cells);
            let transfer = Transfer::new(&nodes, &coarse_nodes);
            let coarse = Operator::new(&elements, &coarse_cells, &coarse_nodes);
            let fixed = if levels.is_empty() { fixed } else { &[] };
            let work = Work::new(operator.len());
            let largest = POWER_MARGIN * largest_eigenvalue(&operator, fixed);
            levels.push(Level { operator, largest, transfer, work });
            (operator, cells, nodes) = (coarse, coarse_cells, coarse_nodes);
        }
        let fixed = if levels.is_empty() { fixed } else { &[] };
        Multigrid { levels, coarsest: Coarsest::new(operator, fixed) }
    }

    /// The operator of the finest level.
    pub(super) fn operator(&self) -> &Operator {
        self.levels.first().map_or(&self.coarsest.operator, |level| &level.operator)
    }

    /// One V-cycle from zero for the forces `b`; `fixed` components, where `b` is 0, stay 0.
    pub(super) fn cycle(&mut self, b: &[Triple], fixed: &[u8], x: &mut Vec<Triple>) {
        cycle(&mut self.levels, &self.coarsest, b, fixed, x);
    }
}

fn cycle(levels: &mut [Level], coarsest: &Coarsest, b: &[Triple], fixed: &[u8], x: &mut Vec<Triple>) {
    let Some((level, coarser)) = levels.split_first_mut() else {
        coarsest.solve(b, x);
        return;
    };
    let Level { operator, largest, transfer, work } = level;
    x.resize(operator.len(), [0.0; 3]);
    x.fill([0.0; 3]);
    work.residual.copy_from_slice(b);
    smooth(operator, *largest, fixed, work, x, Last::Updated);

    let mut forces = vec![[0.0; 3]; coarser.first().map_or(coarsest.operator.len(), |next| next.operator.len())];
    fill(&mut forces, |node| transfer.force(node, &work.residual));
    let mut correction = Vec::new();
    cycle(coarser, coarsest, &forces, &[], &mut correction);
    update(x, |node, x| add(x, free(fixed, node, transfer.displacement(node, &correction))));

    fill(&mut work.residual, |node| free(fixed, node, minus(b[node], operator.at(node, x))));
    smooth(operator, *largest, fixed, work, x, Last::Forgotten);
}

/// What becomes of the residual after the last step of a smoother.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Last {
    Updated,
    Forgotten,
}

/// Steps of the Chebyshev polynomial; `work.residual` is what is not in balance before, and after if it is asked for.
fn smooth(operator: &Operator, largest: f64, fixed: &[u8], work: &mut Work, x: &mut [Triple], last: Last) {
    let (middle, half) = (largest * (1.0 + SMOOTHED) / 2.0, largest * (1.0 - SMOOTHED) / 2.0);
    let sigma = middle / half;
    let mut rho = 1.0 / sigma;
    let Work { residual, step, .. } = work;
    fill(step, |node| scaled(operator.inverse(node), residual[node], 1.0 / middle));
    for k in 0..DEGREE {
        update(x, |node, x| add(x, step[node]));
        if k + 1 < DEGREE || last == Last::Updated {
            update(residual, |node, r| *r = minus(*r, free(fixed, node, operator.at(node, step))));
        }
        if k + 1 < DEGREE {
            let next = 1.0 / (2.0 * sigma - rho);
            update(step, |node, step| {
                let change = scaled(operator.inverse(node), residual[node], 2.0 * next / half);
                *step = [0, 1, 2].map(|k| next * rho * step[k] + change[k]);
            });
            rho = next;
        }
    }
}

impl Work {
    fn new(len: usize) -> Self {
        let zeros = vec![[0.0; 3]; len];
        Work { residual: zeros.clone(), step: zeros }
    }
}

/// The largest eigenvalue of the inverse diagonal times the operator by the power method, from a start that is always the same.
fn largest_eigenvalue(operator: &Operator, fixed: &[u8]) -> f64 {
    let len = operator.len();
    // Signs that change from node to node: most of it lies in the upper end of the spectrum.
    let sign = |node: usize, k: usize| if (node * 0x9e37_79b9 + k * 0x85eb_ca6b) >> 7 & 1 == 0 { 1.0 } else { -1.0 };
    let mut x: Vec<Triple> = (0..len).map(|node| free(fixed, node, [0, 1, 2].map(|k| sign(node, k)))).collect();
    let mut next = x.clone();
    let mut largest = 0.0;
    for _ in 0..POWER_STEPS {
        let norm = sum(len, |node| dot(x[node], x[node])).sqrt();
        if norm <= 0.0 {
            break;
        }
        fill(&mut next, |node| scaled(operator.inverse(node), free(fixed, node, operator.at(node, &x)), 1.0 / norm));
        largest = sum(len, |node| dot(next[node], next[node])).sqrt();
        std::mem::swap(&mut x, &mut next);
    }
    if largest > 0.0 { largest } else { 1.0 }
}

/// The last level, factored.
#[derive(Debug)]
struct Coarsest {
    operator: Operator,
    factors: Option<Factors>,
}

impl Coarsest {
    fn new(operator: Operator, fixed: &[u8]) -> Self {
        let len = 3 * operator.len();
        let (mut matrix, mut diagonal) = (Entries::default(), vec![0.0; len]);
        let is_free = |row: usize| fixed.get(row / 3).is_none_or(|bits| bits >> (row % 3) & 1 == 0);
        // Both halves are given; the factors take the lower one.
        for (i, j, value) in operator.entries().filter(|&(i, j, _)| i >= j && is_free(i) && is_free(j)) {
            matrix.add(i, j, value);
            diagonal[i] += if i == j { value } else { 0.0 };
        }
        // Fixed, or a component that moves nothing but what is fixed.
        (0..len).filter(|&k| diagonal[k] <= 0.0).for_each(|k| matrix.add(k, k, 1.0 - diagonal[k]));
        Coarsest { factors: Factors::new(len, &matrix), operator }
    }

    fn solve(&self, b: &[Triple], x: &mut Vec<Triple>) {
        x.clear();
        match &self.factors {
            Some(factors) => {
                let mut solved: Vec<f64> = b.iter().flatten().copied().collect();
                factors.solve(&mut solved);
                x.extend(solved.chunks_exact(3).map(|c| [c[0], c[1], c[2]]));
            }
            // Rounding made it indefinite: the diagonal alone still helps.
            None => x.extend((0..b.len()).map(|node| scaled(self.operator.inverse(node), b[node], 1.0))),
        }
    }
}

/// Without the components that are fixed; none is where `fixed` is empty.
pub(super) fn free(fixed: &[u8], node: usize, value: Triple) -> Triple {
    match fixed.get(node) {
        Some(&bits) if bits != 0 => [0, 1, 2].map(|k| if bits >> k & 1 == 1 { 0.0 } else { value[k] }),
        _ => value,
    }
}

pub(super) fn dot(a: Triple, b: Triple) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn minus(a: Triple, b: Triple) -> Triple {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn add(to: &mut Triple, value: Triple) {
    (0..3).for_each(|k| to[k] += value[k]);
}

fn scaled(inverse: Triple, value: Triple, factor: f64) -> Triple {
    [0, 1, 2].map(|k| inverse[k] * value[k] * factor)
}
