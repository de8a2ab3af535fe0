//! Where the interior-point method starts: unknowns within all rows, and multipliers.

use super::program::Program;

/// Slack, as a share of the limits, and products of slack and multiplier, in all as a share of the duration, at the
/// beginning on the finer grid.
const START_SLACK: f64 = 0.05;
const START_SHARE: f64 = 0.1;

impl<const N: usize> Program<N> {
    /// The greatest factor of all unknowns that keeps all rows, given that a smaller one does, and leaves this share of
    /// the limits.
    pub fn factor(&self, left: f64) -> f64 {
        let [constant, rooted] = self.rows.least_shares(&self.x);
        ((1.0 - left) * constant).min(((1.0 - left) * rooted).powf(2.0 / 3.0))
    }

    /// Shrinks all unknowns together until every row has at least this share of its limit left.
    pub fn shrink(&mut self, left: f64) {
        let mut factor = self.factor(left);
        for (x, upper) in self.x.iter().zip(&self.upper) {
            factor = factor.min((1.0 - left) * upper / x);
        }
        if factor < 1.0 {
            self.x.iter_mut().for_each(|x| *x *= factor);
        }
    }

    /// Starts from the solution on a coarser grid.
    pub fn start_like(&mut self, coarse: &Program<N>) {
        let (mut segment, mut begin, mut sigma) = (0, 0.0, 0.0);
        for k in 0..self.x.len() {
            sigma += self.widths[k];
            while segment + 1 < coarse.widths.len() && begin + coarse.widths[segment] < sigma {
                begin += coarse.widths[segment];
                segment += 1;
            }
            let (from, to) = coarse.ends(segment);
            let share = ((sigma - begin) / coarse.widths[segment]).min(1.0);
            self.x[k] = ((1.0 - share) * coarse.x[from] + share * coarse.x[to]).min(0.9 * self.upper[k]);
        }
        let more = self.rows.missing(&self.x);
        self.x.iter_mut().for_each(|x| *x += more);
        self.shrink(START_SLACK);
        self.near.clear();
        self.rows.unmark();
        self.centre(START_SHARE, true);
    }

    /// Sets all multipliers so that each product with its slack is the same, or at least that.
    pub fn centre(&mut self, share: f64, cold: bool) {
        self.take_part(0.0);
        let sides = 2 * self.near.len() + self.x.len();
        let product = share * self.time() / sides as f64;
        for ((z, x), upper) in self.upper_multipliers.iter_mut().zip(&self.x).zip(&self.upper) {
            let usual = product / (upper - x);
            *z = if cold { usual } else { z.max(usual) };
        }
        for near in &mut self.near {
            near.look(&self.x);
            for side in 0..2 {
                let usual = product / near.slack[side];
                near.multipliers[side] = if cold { usual } else { near.multipliers[side].max(usual) };
            }
        }
    }
}
