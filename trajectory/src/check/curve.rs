//! The spline that is executed, from its knots: one Hermite cubic a piece.
//!
//! Unknown are the velocities `v` at the knots, `0` at both ends. Accelerations agree at an inner knot `k` if
//! `v[k-1] / h[k-1] + 2 v[k] (1 / h[k-1] + 1 / h[k]) + v[k+1] / h[k] = 3 d[k-1] / h[k-1] + 3 d[k] / h[k]`, where `h` are
//! the times of the pieces and `d` their mean velocities (C. de Boor, *A Practical Guide to Splines*, Springer 1978,
//! chapter IV). Diagonally dominant, so solved by elimination without pivots.

/// One joint on one piece: `q + v s + a s^2 / 2 + j s^3 / 6` for `s` from 0 to `h`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic {
    pub h: f64,
    pub q: f64,
    pub v: f64,
    pub a: f64,
    pub j: f64,
    /// At the end.
    pub q_end: f64,
    pub v_end: f64,
    pub a_end: f64,
}

impl Cubic {
    pub fn position(&self, s: f64) -> f64 {
        if s >= self.h { self.q_end } else { self.q + s * (self.v + s * (self.a / 2.0 + s * self.j / 6.0)) }
    }

    /// Where the velocity is zero, within the piece.
    pub fn turns(&self) -> impl Iterator<Item = f64> {
        let (b, c, h) = (self.a, self.v, self.h);
        let discriminant = b * b - 2.0 * self.j * c;
        // Of the two forms of each root, the one without cancellation.
        let sum = -(b + discriminant.max(0.0).sqrt().copysign(b));
        let real = discriminant >= 0.0;
        [sum / self.j, 2.0 * c / sum].into_iter().filter(move |s| real && *s > 0.0 && *s < h)
    }

    /// Where the acceleration is zero, within the piece.
    pub fn crest(&self) -> Option<f64> {
        Some(-self.a / self.j).filter(|s| *s > 0.0 && *s < self.h)
    }

    pub fn velocity(&self, s: f64) -> f64 {
        self.v + s * (self.a + s * self.j / 2.0)
    }
}

/// The clamped spline through all knots.
#[derive(Clone, Debug)]
pub(super) struct Curve<'a, const N: usize> {
    pub times: &'a [f64],
    joints: &'a [[f64; N]],
    velocities: Vec<[f64; N]>,
}

impl<'a, const N: usize> Curve<'a, N> {
    /// Both slices have the same length, 2 or more, and times rise.
    pub fn new(times: &'a [f64], joints: &'a [[f64; N]]) -> Self {
        let knots = times.len();
        let mut velocities = vec![[0.0; N]; knots];
        // Forward: upper[k] is what remains of the entry right of the diagonal.
        let mut upper = vec![0.0; knots];
        for k in 1..knots - 1 {
            let (before, after) = (times[k] - times[k - 1], times[k + 1] - times[k]);
            let pivot = 2.0 / before + 2.0 / after - upper[k - 1] / before;
            upper[k] = 1.0 / (after * pivot);
            for joint in 0..N {
                let mean_before = (joints[k][joint] - joints[k - 1][joint]) / before;
                let mean_after = (joints[k + 1][joint] - joints[k][joint]) / after;
                let right = 3.0 * (mean_before / before + mean_after / after);
                velocities[k][joint] = (right - velocities[k - 1][joint] / before) / pivot;
            }
        }
        for k in (1..knots - 1).rev() {
            let after = velocities[k + 1];
            velocities[k].iter_mut().zip(after).for_each(|(v, after)| *v -= upper[k] * after);
        }
        Curve { times, joints, velocities }
    }

    pub fn pieces(&self) -> usize {
        self.times.len() - 1
    }

    pub fn cubic(&self, piece: usize, joint: usize) -> Cubic {
        let h = self.times[piece + 1] - self.times[piece];
        let (q, q_end) = (self.joints[piece][joint], self.joints[piece + 1][joint]);
        let (v, v_end) = (self.velocities[piece][joint], self.velocities[piece + 1][joint]);
        let mean = (q_end - q) / h;
        // Differences from the mean velocity: small numbers where the motion is even.
        let (first, last) = (v - mean, v_end - mean);
        let a = -(4.0 * first + 2.0 * last) / h;
        let a_end = (2.0 * first + 4.0 * last) / h;
        Cubic { h, q, v, a, j: 6.0 * (first + last) / (h * h), q_end, v_end, a_end }
    }

    /// Joints at a time of a piece.
    pub fn at(&self, piece: usize, time: f64) -> [f64; N] {
        let s = time - self.times[piece];
        std::array::from_fn(|joint| self.cubic(piece, joint).position(s))
    }

    /// The Bezier control polygon of a piece.
    pub fn control(&self, piece: usize) -> [[f64; N]; 4] {
        let third = (self.times[piece + 1] - self.times[piece]) / 3.0;
        let (from, to) = (self.joints[piece], self.joints[piece + 1]);
        let (v, v_end) = (self.velocities[piece], self.velocities[piece + 1]);
        let leave = std::array::from_fn(|j| from[j] + third * v[j]);
        let arrive = std::array::from_fn(|j| to[j] - third * v_end[j]);
        [from, leave, arrive, to]
    }

    /// The first piece on which numbers overflow: its knots are too close in time.
    pub fn overflow(&self) -> Option<usize> {
        let finite = |c: Cubic| [c.v, c.v_end, c.a, c.a_end, c.j].iter().all(|value| value.is_finite());
        (0..self.pieces()).find(|&piece| !(0..N).all(|joint| finite(self.cubic(piece, joint))))
    }
}
