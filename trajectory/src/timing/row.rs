//! Rows of the program: limits of three neighbouring unknowns.

/// A two-sided row over three neighbouring unknowns.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// The first unknown; entries beyond the last unknown are 0.
    pub first: usize,
    pub by: [f64; 3],
    /// The unknown that the limit goes with, counted from `first`; `None` where the limit is a constant.
    pub root: Option<u8>,
    /// The limit goes with the unknown itself and not with the inverse of its root.
    pub is_linear: bool,
    /// Above and below; infinite where there is none.
    pub limits: [f64; 2],
}

/// A row that takes part, and its sides.
#[derive(Clone, Debug)]
pub(super) struct Near {
    /// Its number.
    pub number: usize,
    pub row: Row,
    pub multipliers: [f64; 2],
    pub slack: [f64; 2],
    /// Of the slack.
    pub inverse: [f64; 2],
    /// Derivative of the limits by the unknown that they go with.
    pub bend: [f64; 2],
    pub slack_step: [f64; 2],
    pub step: [f64; 2],
}

impl Row {
    /// The row of these terms, which are of three neighbouring unknowns, with the one that the limits go with.
    pub fn of(terms: [(usize, f64); 4], root: Option<usize>, limits: [f64; 2]) -> Self {
        let first = terms.iter().filter(|(_, by)| *by != 0.0).map(|&(at, _)| at).chain(root).min().unwrap_or(0);
        let mut by = [0.0; 3];
        for (at, value) in terms.into_iter().filter(|(_, value)| *value != 0.0) {
            by[at - first] += value;
        }
        Row { first, by, root: root.map(|root| (root - first) as u8), is_linear: false, limits }
    }

    #[inline]
    pub fn value(&self, x: &[f64]) -> f64 {
        if let Some([a, b, c]) = x.get(self.first..self.first + 3) {
            return self.by[0] * a + self.by[1] * b + self.by[2] * c;
        }
        let at = |i: usize| x.get(self.first + i).copied().unwrap_or(0.0);
        self.by[0] * at(0) + self.by[1] * at(1) + self.by[2] * at(2)
    }

    /// What the limits are multiplied by.
    #[inline]
    pub fn scale(&self, x: &[f64]) -> f64 {
        self.rooted().map_or(1.0, |root| if self.is_linear { x[root] } else { 1.0 / x[root].sqrt() })
    }

    /// The unknown in the middle, where the row is counted.
    #[inline]
    pub fn middle(&self, unknowns: usize) -> usize {
        (self.first + 1).min(unknowns - 1)
    }

    /// The unknown that the limit goes with.
    #[inline]
    pub fn rooted(&self) -> Option<usize> {
        self.root.map(|root| self.first + usize::from(root))
    }
}

impl Near {
    pub fn new(number: usize, row: Row) -> Self {
        let none = [0.0; 2];
        Near { number, row, multipliers: none, slack: none, inverse: none, bend: none, slack_step: none, step: none }
    }

    /// Adds what the limits of its row curve the barrier by to a band of the Newton matrix.
    #[inline]
    pub fn add_curvature(&self, band: &mut [[f64; 3]]) {
        let row = &self.row;
        let w = [self.multipliers[0] * self.inverse[0], self.multipliers[1] * self.inverse[1]];
        let both = w[0] + w[1];
        let [a, b, c] = row.by;
        let at = row.first;
        band[at][0] += both * a * a;
        band[at][1] += both * a * b;
        band[at][2] += both * a * c;
        if at + 1 < band.len() {
            band[at + 1][0] += both * b * b;
            band[at + 1][1] += both * b * c;
        }
        if at + 2 < band.len() {
            band[at + 2][0] += both * c * c;
        }
        let Some(root) = row.root.map(usize::from) else { return };
        // Gradients are `a - bend_0 e` above and `-a - bend_1 e` below.
        let cross = self.bend[1] * w[1] - self.bend[0] * w[0];
        let square = self.bend[0] * self.bend[0] * w[0] + self.bend[1] * self.bend[1] * w[1];
        band[at + root][0] += square + 2.0 * cross * row.by[root];
        for other in 0..3 {
            if other < root {
                band[at + other][root - other] += cross * row.by[other];
            } else if other > root && at + other < band.len() {
                band[at + root][other - root] += cross * row.by[other];
            }
        }
    }

    #[inline]
    pub fn look(&mut self, x: &[f64]) {
        let row = &self.row;
        let value = row.value(x);
        let (scale, bend) = row.rooted().map_or((1.0, 0.0), |root| {
            if row.is_linear {
                return (x[root], 1.0);
            }
            let scale = 1.0 / x[root].sqrt();
            (scale, -0.5 * scale * scale * scale)
        });
        self.slack = [row.limits[0] * scale - value, row.limits[1] * scale + value];
        self.inverse = self.slack.map(f64::recip);
        self.bend = [row.limits[0] * bend, row.limits[1] * bend];
    }

    /// Adds the gradients of both sides times these numbers.
    #[inline]
    pub fn add(&self, to: &mut [f64], push: [f64; 2]) {
        let row = &self.row;
        let along = push[0] - push[1];
        for (entry, by) in to[row.first..].iter_mut().zip(&row.by) {
            *entry += along * by;
        }
        if let Some(root) = row.rooted() {
            to[root] -= push[0] * self.bend[0] + push[1] * self.bend[1];
        }
    }

    #[inline]
    pub fn move_by(&mut self, dx: &[f64]) {
        let row = &self.row;
        let rise = row.value(dx);
        let root = row.rooted().map_or(0.0, |root| dx[root]);
        self.slack_step = [self.bend[0] * root - rise, self.bend[1] * root + rise];
    }
}
