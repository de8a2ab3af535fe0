//! A pentadiagonal matrix and its factors.

/// `L D L^T` of a pentadiagonal matrix; `band[k]` holds its diagonal and the two entries below.
pub(super) struct Factors {
    pub band: Vec<[f64; 3]>,
}

impl Factors {
    pub fn factor(&mut self) {
        let n = self.band.len();
        for k in 0..n {
            let mut pivot = self.band[k][0];
            let mut below = self.band[k][1];
            if k >= 1 {
                let [d, l1, l2] = self.band[k - 1];
                pivot -= l1 * l1 * d;
                below -= l1 * l2 * d;
            }
            if k >= 2 {
                let [d, _, l2] = self.band[k - 2];
                pivot -= l2 * l2 * d;
            }
            // Positive but for rounding.
            pivot = pivot.max(1e-14 * self.band[k][0]).max(f64::MIN_POSITIVE);
            self.band[k] = [pivot, below / pivot, self.band[k][2] / pivot];
        }
    }

    pub fn solve(&self, b: &mut [f64]) {
        let n = b.len();
        for k in 0..n {
            let mut value = b[k];
            if k >= 1 {
                value -= self.band[k - 1][1] * b[k - 1];
            }
            if k >= 2 {
                value -= self.band[k - 2][2] * b[k - 2];
            }
            b[k] = value;
        }
        for k in (0..n).rev() {
            let mut value = b[k] / self.band[k][0];
            if k + 1 < n {
                value -= self.band[k][1] * b[k + 1];
            }
            if k + 2 < n {
                value -= self.band[k][2] * b[k + 2];
            }
            b[k] = value;
        }
    }
}
