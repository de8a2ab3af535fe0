//! The natural spline.

use curvlay_trajectory::nalgebra::{DMatrix, DVector};

/// The natural spline by a dense solve: derivatives of one joint by the parameter in a piece.
pub struct Natural {
    spacing: f64,
    angles: Vec<f64>,
    bends: Vec<f64>,
}

impl Natural {
    pub fn new(angles: Vec<f64>, spacing: f64) -> Self {
        let n = angles.len();
        let (mut a, mut b) = (DMatrix::identity(n, n), DVector::zeros(n));
        for k in 1..n - 1 {
            a[(k, k - 1)] = 1.0;
            a[(k, k)] = 4.0;
            a[(k, k + 1)] = 1.0;
            b[k] = 6.0 * (angles[k + 1] - 2.0 * angles[k] + angles[k - 1]) / spacing.powi(2);
        }
        let bends = a.lu().solve(&b).unwrap().iter().copied().collect();
        Natural { spacing, angles, bends }
    }

    pub fn angle(&self, piece: usize, along: f64) -> f64 {
        let (h, bend, next) = (self.spacing, self.bends[piece], self.bends[piece + 1]);
        let slope = (self.angles[piece + 1] - self.angles[piece]) / h - h * (2.0 * bend + next) / 6.0;
        self.angles[piece] + along * (slope + along * (bend / 2.0 + along * (next - bend) / (6.0 * h)))
    }

    pub fn at(&self, piece: usize, along: f64) -> [f64; 3] {
        let (h, third) = (self.spacing, (self.bends[piece + 1] - self.bends[piece]) / self.spacing);
        let rise = (self.angles[piece + 1] - self.angles[piece]) / h;
        let slope = rise - h * (2.0 * self.bends[piece] + self.bends[piece + 1]) / 6.0;
        let bend = self.bends[piece] + along * third;
        [slope + 0.5 * along * (self.bends[piece] + bend), bend, third]
    }
}
