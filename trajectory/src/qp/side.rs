//! A side of a row in the interior-point method: its slack, its multiplier, and for a soft row the miss and its price.

use super::problem::{BandedQp, Row};

/// Least slack, relative to the bound: what is less is rounding, and would cut all later steps short.
const MIN_SLACK: f64 = 3e-14;

/// Weights of rows are cut at one over this. Heavier rows drown the others in rounding; a tenth of the weight, and what
/// has no slack inside its bounds comes to its end too slowly.
const LIGHTEST: f64 = 1e-14;

/// One finite bound of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub row: u32,
    /// `+1` for an upper bound, `-1` for a lower one.
    pub sign: f64,
    pub bound: f64,
    pub penalty: f64,
    pub s: f64,
    pub z: f64,
    pub p: f64,
    pub w: f64,
    /// The step of the four.
    pub ds: f64,
    pub dz: f64,
    pub dp: f64,
    pub dw: f64,
    /// `sign (bound - a x) + p - s`.
    pub miss: f64,
    /// The weight of the row's square in the linear system.
    pub weight: f64,
    /// Right-hand sides of the two complementarity conditions.
    pub want: f64,
    pub want_soft: f64,
}

impl Side {
    /// The sides of all rows that are no equations, row by row.
    pub fn all_of(qp: &BandedQp) -> Vec<Side> {
        let of_row = |(row, bounds): (u32, &Row)| {
            let side = |sign, bound| Side {
                row,
                sign,
                bound,
                penalty: bounds.penalty,
                s: 1.0,
                z: 1.0,
                p: 0.0,
                w: f64::INFINITY,
                ds: 0.0,
                dz: 0.0,
                dp: 0.0,
                dw: 0.0,
                miss: 0.0,
                weight: 0.0,
                want: 0.0,
                want_soft: 0.0,
            };
            let sides = [(1.0, bounds.upper), (-1.0, bounds.lower)]
                .map(|(sign, bound)| (bound.is_finite() && !bounds.is_equation()).then(|| side(sign, bound)));
            sides.into_iter().flatten()
        };
        (0..).zip(&qp.rows).flat_map(of_row).collect()
    }

    pub fn is_soft(&self) -> bool {
        self.penalty < f64::INFINITY
    }

    /// What the step of `z` is when the row does not move, over the weight, where this share of the miss is made good.
    pub fn constant(&self, share: f64) -> f64 {
        let soft = if self.is_soft() { (self.want_soft - self.p * self.dull()) / self.w } else { 0.0 };
        self.want / self.z - soft - share * self.miss
    }

    /// `penalty - z - w`, which rounding alone keeps from zero.
    pub fn dull(&self) -> f64 {
        self.penalty - self.z - self.w
    }

    /// Sets the weight for the present slacks and multipliers.
    pub fn weigh(&mut self) -> f64 {
        let soft = if self.is_soft() { self.p / self.w } else { 0.0 };
        self.weight = 1.0 / (self.s / self.z + soft).max(LIGHTEST);
        self.weight
    }

    /// Goes this share of the step.
    pub fn go(&mut self, step: f64) {
        self.s = (self.s + step * self.ds).max(MIN_SLACK * (1.0 + self.bound.abs()));
        self.z += step * self.dz;
        if self.is_soft() {
            self.p += step * self.dp;
            self.w += step * self.dw;
        }
    }
}
