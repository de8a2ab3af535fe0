//! The eikonal equation `|grad d| = 1` on the cells of a solid, by fast marching.
//!
//! J. A. Sethian, "A fast marching level set method for monotonically advancing fronts", PNAS 93(4), 1996; the second-order
//! stencil is that of his *Level Set Methods and Fast Marching Methods*, Cambridge 1999, section 8.7.
//! Symbols: `T` in the book is a value here; along each axis it enters as `weight (T - origin)^2`.

use super::beside::{OnBase, beside};
use crate::cells::Cells;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Values rise by at least this much from the lowest face neighbour, in cells. A first-order value rises by `1/sqrt(3)` or more, since three equal
/// terms `(T - u)^2` add up to 1; those of second order are held to a little less, so that support within half a layer is sure.
pub(super) const MIN_RISE: f64 = 0.5;

/// A value on its way: the lowest first, of equal ones the cell with the lowest number. Values are positive, so their bits are in their order.
type Queued = Reverse<(u64, u32)>;

/// Distances by cell number, from the cells of `base`, which have theirs; NaN where there is no cell or no way. No value is below its
/// `floor`, those of the base neither; where floors of neighbours differ by no more than 1, so do values.
pub(super) fn distances(cells: &Cells, base: &[OnBase], floor: &(dyn Fn(u32) -> f64 + '_)) -> Vec<f64> {
    let len = cells.grid_len();
    let (values, known) = (vec![f64::NAN; len], vec![false; len]);
    let mut march = March { cells: *cells, values, known, base, queue: BinaryHeap::new(), floor };
    for &(cell, value) in base {
        let value = floor(cell).max(value);
        march.values[cell as usize] = value;
        march.queue.push(Reverse((value.to_bits(), cell)));
    }
    march.run();
    march.values
}

struct March<'a> {
    cells: Cells<'a>,
    floor: &'a dyn Fn(u32) -> f64,
    /// NaN as long as nothing has come near.
    values: Vec<f64>,
    /// Whether the value is final.
    known: Vec<bool>,
    base: &'a [OnBase],
    queue: BinaryHeap<Queued>,
}

/// What an axis contributes to the equation: `weight * (T - origin)^2`.
#[derive(Clone, Copy)]
struct Term {
    weight: f64,
    origin: f64,
    /// The value of the neighbour itself.
    neighbour: f64,
}

impl March<'_> {
    fn run(&mut self) {
        while let Some(Reverse((_, cell))) = self.queue.pop() {
            // A cell is queued again whenever its value falls.
            if std::mem::replace(&mut self.known[cell as usize], true) {
                continue;
            }
            for next in beside(&self.cells, cell).into_iter().flatten() {
                if self.known[next as usize] {
                    continue;
                }
                let value = self.value_of(next);
                let before = self.values[next as usize];
                // What is on the base knows its distance; from its neighbours it may look a little less.
                if before.is_nan() || value < before && !self.is_base(next) {
                    self.values[next as usize] = value;
                    self.queue.push(Reverse((value.to_bits(), next)));
                }
            }
        }
    }

    fn is_base(&self, cell: u32) -> bool {
        self.base.binary_search_by_key(&cell, |base| base.0).is_ok()
    }

    fn known_value(&self, cell: u32) -> Option<f64> {
        self.known[cell as usize].then(|| self.values[cell as usize])
    }

    /// The value of a cell, from its known neighbours, of which there is one at least.
    fn value_of(&self, cell: u32) -> f64 {
        let mut terms: Vec<Term> = (0..3).filter_map(|axis| self.term(cell, axis)).collect();
        terms.sort_by(|a, b| a.neighbour.total_cmp(&b.neighbour));
        let lowest = terms.first().map_or(0.0, |term| term.neighbour);
        let first_order: Vec<Term> = terms.iter().map(|&Term { neighbour, .. }| Term::first_order(neighbour)).collect();
        let value = solved(&terms).or_else(|| solved(&first_order)).unwrap_or(lowest + 1.0);
        value.clamp(lowest + MIN_RISE, lowest + 1.0).max((self.floor)(cell))
    }

    /// What the lower of the two known neighbours along an axis contributes; of second order where a lower one lies behind it.
    fn term(&self, cell: u32, axis: usize) -> Option<Term> {
        let side = |face: usize| {
            let next = beside(&self.cells, cell)[face]?;
            Some((self.known_value(next)?, next, face))
        };
        let lower = |a: &(f64, u32, usize), b: &(f64, u32, usize)| a.0.total_cmp(&b.0);
        let (neighbour, next, face) = [side(2 * axis), side(2 * axis + 1)].into_iter().flatten().min_by(lower)?;
        let behind = beside(&self.cells, next)[face].and_then(|behind| self.known_value(behind));
        Some(match behind {
            // At the base the field has a kink: it is level along it.
            Some(behind) if behind <= neighbour && !self.is_base(next) => {
                Term { weight: 9.0 / 4.0, origin: (4.0 * neighbour - behind) / 3.0, neighbour }
            }
            _ => Term::first_order(neighbour),
        })
    }
}

impl Term {
    fn first_order(neighbour: f64) -> Self {
        Term { weight: 1.0, origin: neighbour, neighbour }
    }
}

/// The solution of the equation with as many terms as it takes: none may lie above it. Terms are sorted by their neighbours.
fn solved(terms: &[Term]) -> Option<f64> {
    (1..=terms.len()).rev().find_map(|count| {
        let sum = |of: &dyn Fn(&Term) -> f64| terms[..count].iter().map(of).sum::<f64>();
        let a = sum(&|t| t.weight);
        let b = sum(&|t| t.weight * t.origin);
        let c = sum(&|t| t.weight * t.origin * t.origin) - 1.0;
        let discriminant = b * b - a * c;
        let value = (b + discriminant.sqrt()) / a;
        (discriminant >= 0.0 && value >= terms[count - 1].neighbour).then_some(value)
    })
}
