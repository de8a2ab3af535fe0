//! What an interior-point step keeps for each unknown, and the products of slack and multiplier that it aims at (see `local`).

use super::local::{RADIUS, window_sums};

/// The gap keeps at least this share of the residual of the Lagrangian's gradient: products that vanish before it leave
/// the unknowns at the boundary, where steps are short.
const GAP: f64 = 0.1;

/// Fields over the unknowns.
pub(super) struct Fields {
    /// How much of a step unknowns and multipliers allow.
    pub primal: Vec<f64>,
    pub dual: Vec<f64>,
    /// Sums of the products of slacks and multipliers, the same after a step, and their number.
    pub gap: Vec<f64>,
    pub after: Vec<f64>,
    pub sides: Vec<f64>,
    /// Residual of the Lagrangian's gradient, times the unknown.
    pub residual: Vec<f64>,
    /// The product to aim at, the share of the products of steps that is corrected, and the largest aim.
    pub centre: Vec<f64>,
    pub bend: Vec<f64>,
    pub most: Vec<f64>,
}

impl Fields {
    pub fn new(n: usize) -> Self {
        let zero = vec![0.0; n];
        Fields {
            primal: zero.clone(),
            dual: zero.clone(),
            gap: zero.clone(),
            after: zero.clone(),
            sides: zero.clone(),
            residual: zero.clone(),
            centre: zero.clone(),
            bend: zero.clone(),
            most: zero,
        }
    }

    /// The predictor's aim.
    pub fn aim_at_none(&mut self) {
        self.centre.fill(0.0);
        self.bend.fill(0.0);
        self.most.fill(0.0);
    }

    /// The corrector's aim, from what the predictor leaves around each unknown.
    pub fn aim(&mut self, least: f64) {
        let sums = window_sums([&self.gap, &self.after, &self.sides, &self.residual], RADIUS);
        for (k, [gap, after, sides, residual]) in sums.into_iter().enumerate() {
            let mean = gap / sides;
            let share = if gap > 0.0 { (after / gap).clamp(0.0, 1.0).powi(3) } else { 0.0 };
            self.centre[k] = (share * mean).max(GAP * residual / sides).max(least);
            self.bend[k] = self.primal[k].min(1.0) * self.dual[k].min(1.0);
            self.most[k] = 10.0 * mean.max(self.centre[k]);
        }
    }

    /// The product of a slack and a multiplier to aim at, where the steps of the predictor have this product.
    #[inline]
    pub fn aimed(&self, at: usize, product: f64) -> f64 {
        (self.centre[at] - self.bend[at] * product).clamp(0.0, self.most[at])
    }
}
