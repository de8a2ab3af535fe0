//! Whether the hard rows of a quadratic program contradict each other.
//!
//! The least sum by which they must be missed is a linear program that always has a solution, with an interior: each
//! row is made soft at the price 1. Where the sum is not zero, its multipliers are a proof (J. Farkas, 1902): with these
//! factors the rows add up to one that has no variable left and cannot hold.
//!
//! Of an iterative method something is always left, `r x <= value` with a small `r` and a `value` below zero, and that
//! holds far enough out. Rows of one variable take up what is left of it, which makes the proof exact where all variables
//! have bounds of their own. Of the others it says how far out a point would have to lie.

use super::interior::Interior;
use super::options::QpOptions;
use super::problem::BandedQp;
use super::system::largest;

/// A sum of misses up to this, relative to the largest bound, is rounding.
const NOTHING: f64 = 1e-6;

/// Rows are contradictory when no point keeps them whose variables are up to this many times those of the point that misses
/// them least. With less, problems whose solutions lie far out are called infeasible; with more, rounding in variables
/// without bounds leaves no proof at all.
const FAR: f64 = 1e6;

/// Multipliers of the rows that prove them contradictory; `None` where they are not, or nothing can be proved.
pub(super) fn contradiction(qp: &BandedQp, options: &QpOptions) -> Option<Vec<f64>> {
    let Softened { qp: soft, copies, scale } = Softened::of(qp)?;
    let found = Interior::new(&soft).solve(options, None);
    let mut proof = vec![0.0; qp.rows.len()];
    for (row, copy) in copies {
        proof[row] = found.duals[copy];
    }
    // The multipliers prove it whether or not the last digits of the point are there.
    let (value, left) = settle(qp, &mut proof);
    let reach = FAR * (1.0 + largest(&found.x));
    (value < -NOTHING * scale && left * reach < -value).then_some(proof)
}

/// The hard rows of a program, each of which may be missed at the price 1.
struct Softened {
    qp: BandedQp,
    /// The hard rows, and where their copies are.
    copies: Vec<(usize, usize)>,
    /// The largest bound of a hard row, at least 1.
    scale: f64,
}

impl Softened {
    /// An equation may reach over three stages, which a soft row may not: it gets a variable for its miss, placed in the
    /// middle stage behind the variables of that stage. An equation over border variables alone joins them in the border.
    fn of(qp: &BandedQp) -> Option<Self> {
        let mut sizes: Vec<usize> = qp.first.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let equations = (0..qp.rows.len()).filter(|&row| qp.rows[row].is_equation());
        let homes: Vec<Option<usize>> = equations.map(|row| qp.home(row)).collect();
        let border = qp.border + homes.iter().filter(|home| home.is_none()).count();
        let mut behind = sizes.clone();
        for &stage in homes.iter().flatten() {
            sizes[stage] += 1;
        }
        let mut soft = Softened { qp: BandedQp::new(&sizes, border), copies: Vec::new(), scale: 1.0 };
        let place = places(qp, &soft.qp);
        let mut last = soft.qp.variables() - border + qp.border;
        let mut homes = homes.into_iter();
        let mut terms = Vec::new();
        for (row, bounds) in qp.rows.iter().enumerate() {
            if bounds.penalty < f64::INFINITY {
                continue;
            }
            for bound in [bounds.lower, bounds.upper].into_iter().filter(|bound| bound.is_finite()) {
                soft.scale = soft.scale.max(bound.abs());
            }
            terms.clear();
            terms.extend(qp.terms_of(row).iter().map(|&(variable, by)| (place[variable as usize], by)));
            if !bounds.is_equation() {
                soft.copies.push((row, soft.qp.add_soft_row(&terms, bounds.lower, bounds.upper, 1.0)));
                continue;
            }
            let miss = match homes.next()? {
                Some(stage) => {
                    behind[stage] += 1;
                    soft.qp.first[stage] + behind[stage] - 1
                }
                None => {
                    last += 1;
                    last - 1
                }
            };
            terms.push((miss, 1.0));
            soft.copies.push((row, soft.qp.add_row(&terms, bounds.lower, bounds.upper)));
            soft.qp.add_soft_row(&[(miss, 1.0)], 0.0, 0.0, 1.0);
        }
        Some(soft)
    }
}

/// Where each variable of a program is in one with more variables behind those of each stage and those of the border.
fn places(qp: &BandedQp, larger: &BandedQp) -> Vec<usize> {
    let moved = |variable: usize| match qp.stage(variable) {
        Some(stage) => larger.first[stage] + (variable - qp.first[stage]),
        None => larger.variables() - larger.border + (variable - (qp.variables() - qp.border)),
    };
    (0..qp.variables()).map(moved).collect()
}

/// Lets hard rows of one variable take up what is left of it in the sum of all rows with these factors. Returns the bound of
/// the sum, and the sum of what is left of the other variables.
fn settle(qp: &BandedQp, factors: &mut [f64]) -> (f64, f64) {
    let mut left = vec![0.0; qp.variables()];
    for (row, by) in factors.iter().enumerate() {
        for &(variable, value) in qp.terms_of(row) {
            left[variable as usize] += by * value;
        }
    }
    let bound = |row: usize, by: f64| if by > 0.0 { qp.rows[row].upper } else { qp.rows[row].lower };
    for (row, by) in factors.iter_mut().enumerate() {
        let &[(variable, value)] = qp.terms_of(row) else { continue };
        let left = &mut left[variable as usize];
        let all = *by - *left / value;
        if qp.rows[row].penalty == f64::INFINITY && all.is_finite() && bound(row, all).is_finite() {
            (*by, *left) = (all, 0.0);
        }
    }
    let used = factors.iter().enumerate().filter(|(_, by)| by.abs() > 0.0);
    let value = used.map(|(row, &by)| by * bound(row, by)).sum();
    (value, left.iter().map(|by| by.abs()).sum())
}
