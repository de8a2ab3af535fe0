//! The path as a curve over a parameter in which rest is regular, and the grid on it.
//!
//! Near rest a motion of limited jerk goes like `s ~ t^3`. So `s` is a smooth function of `sigma`: cubic at both ends and
//! linear between, `s = w (2 x^3 - 2 x^4 + 3/5 x^5)` with `x = sigma / w` within `w` of an end. Its first two derivatives
//! agree with the linear part. By `sigma`, rest is a place where the curve's first two derivatives are zero, and
//! `(d sigma / dt)^2` is finite and smooth there.

use std::ops::Range;

/// What an end's window of width 1 covers in `s`.
const COVERED: f64 = 0.6;

/// The C2 cubic spline through the postures, with natural ends.
pub(super) struct Curve<'a, const N: usize> {
    postures: &'a [[f64; N]],
    planned: &'a [f64],
    curvatures: Vec<[f64; N]>,
}

impl<'a, const N: usize> Curve<'a, N> {
    pub fn new(postures: &'a [[f64; N]], planned: &'a [f64]) -> Self {
        let last = postures.len() - 1;
        let mut curvatures = vec![[0.0; N]; postures.len()];
        let mut above = vec![0.0; postures.len()];
        for k in 1..last {
            let (h, next) = (planned[k] - planned[k - 1], planned[k + 1] - planned[k]);
            let pivot = 2.0 * (h + next) - h * above[k - 1];
            above[k] = next / pivot;
            for j in 0..N {
                let rise = (postures[k + 1][j] - postures[k][j]) / next - (postures[k][j] - postures[k - 1][j]) / h;
                curvatures[k][j] = (6.0 * rise - h * curvatures[k - 1][j]) / pivot;
            }
        }
        for k in (1..last).rev() {
            let after = curvatures[k + 1];
            curvatures[k].iter_mut().zip(after).for_each(|(bend, after)| *bend -= above[k] * after);
        }
        Curve { postures, planned, curvatures }
    }

    /// The third derivative on a piece.
    fn third(&self, piece: usize) -> [f64; N] {
        let h = self.planned[piece + 1] - self.planned[piece];
        std::array::from_fn(|j| (self.curvatures[piece + 1][j] - self.curvatures[piece][j]) / h)
    }

    /// Value, first and second derivative on a piece, `along` after its beginning.
    pub fn at(&self, piece: usize, along: f64) -> [[f64; N]; 3] {
        let h = self.planned[piece + 1] - self.planned[piece];
        let (mut joints, mut slopes, mut bends) = ([0.0; N], [0.0; N], [0.0; N]);
        let (inverse, sixth) = (1.0 / h, h / 6.0);
        for j in 0..N {
            let (q, next) = (self.postures[piece][j], self.postures[piece + 1][j]);
            let (m, after) = (self.curvatures[piece][j], self.curvatures[piece + 1][j]);
            let slope = (next - q) * inverse - sixth * (2.0 * m + after);
            let third = (after - m) * inverse;
            joints[j] = q + along * (slope + along * (m / 2.0 + along * third / 6.0));
            slopes[j] = slope + along * (m + along * third / 2.0);
            bends[j] = m + along * third;
        }
        [joints, slopes, bends]
    }
}

/// `s` and its first two derivatives by `sigma`, both counted from the start of the path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Warp {
    /// Widths of the windows at both ends, in `sigma`.
    widths: [f64; 2],
    /// Of the whole path, in `s` and in `sigma`.
    length: f64,
    pub sigma: f64,
}

impl Warp {
    /// With windows that cover these lengths of `s`, at most half the path each.
    pub fn new(length: f64, covered: [f64; 2]) -> Self {
        let covered = covered.map(|part| part.min(0.5 * length));
        let widths = covered.map(|part| part / COVERED);
        Warp { widths, length, sigma: length + (1.0 - COVERED) * (widths[0] + widths[1]) }
    }

    pub fn at(&self, sigma: f64) -> [f64; 3] {
        let left = self.sigma - sigma;
        if sigma < self.widths[0] {
            let [s, first, second] = window(sigma / self.widths[0]);
            [self.widths[0] * s, first, second / self.widths[0]]
        } else if left < self.widths[1] {
            let [s, first, second] = window(left / self.widths[1]);
            [self.length - self.widths[1] * s, first, -second / self.widths[1]]
        } else {
            [sigma - (1.0 - COVERED) * self.widths[0], 1.0, 0.0]
        }
    }

    /// The `sigma` of a place.
    pub fn inverse(&self, s: f64) -> f64 {
        let left = self.length - s;
        if s < COVERED * self.widths[0] {
            self.widths[0] * window_inverse(s / self.widths[0])
        } else if left < COVERED * self.widths[1] {
            self.sigma - self.widths[1] * window_inverse(left / self.widths[1])
        } else {
            s + (1.0 - COVERED) * self.widths[0]
        }
    }

    /// Where the windows end, in `sigma`.
    pub fn middle(&self) -> Range<f64> {
        self.widths[0]..self.sigma - self.widths[1]
    }
}

fn window(x: f64) -> [f64; 3] {
    let y = 1.0 - x;
    [x * x * x * (2.0 - x * (2.0 - 0.6 * x)), x * x * (6.0 - x * (8.0 - 3.0 * x)), 12.0 * x * y * y]
}

fn window_inverse(s: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // As many halvings as a double has digits.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if window(middle)[0] < s {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The grid: knots of the motion that contain all postures.
pub(super) struct Grid<const N: usize> {
    /// At each knot.
    pub knots: Vec<Knot<N>>,
    /// From each knot to the next.
    pub segments: Vec<Segment<N>>,
    /// The knot of each posture.
    pub postures: Vec<usize>,
}

pub(super) struct Knot<const N: usize> {
    pub joints: [f64; N],
    /// `dq / d sigma`.
    pub slope: [f64; N],
    /// `ds / d sigma`.
    pub warp: f64,
    /// By how much the third derivative by `sigma` jumps; 0 between postures.
    pub jump: [f64; N],
}

pub(super) struct Segment<const N: usize> {
    /// The piece of the path.
    pub piece: usize,
    /// In `sigma`.
    pub width: f64,
    /// In `s`, a unit of `sigma`.
    pub warp: f64,
    /// The acceleration is `before beta_k + after beta_{k+1}`.
    pub before: [f64; N],
    pub after: [f64; N],
}

impl<const N: usize> Grid<N> {
    /// # Arguments
    /// * `parts`: into how many segments each piece is cut at least.
    /// * `ramp`: segments of each window at least.
    pub fn new(curve: &Curve<'_, N>, warp: &Warp, parts: &[usize], ramp: usize) -> Self {
        let start = curve.planned[0];
        let last = curve.postures.len() - 1;
        let sigma: Vec<f64> = (0..=last)
            .map(|k| match k {
                0 => 0.0,
                _ if k == last => warp.sigma,
                _ => warp.inverse(curve.planned[k] - start),
            })
            .collect();
        let middle = warp.middle();
        let count = parts.iter().sum::<usize>() + 2 * ramp;
        let (mut knots, mut segments) = (Vec::with_capacity(count + 1), Vec::with_capacity(count));
        let mut postures = vec![0];
        let warped = |piece: usize, sigma: f64| -> (Knot<N>, [f64; N]) {
            let [s, first, second] = warp.at(sigma);
            let along =
                (s - (curve.planned[piece] - start)).clamp(0.0, curve.planned[piece + 1] - curve.planned[piece]);
            let [joints, slope, bend] = curve.at(piece, along);
            let curvature = std::array::from_fn(|j| bend[j] * first * first + slope[j] * second);
            (Knot { joints, slope: slope.map(|d| d * first), warp: first, jump: [0.0; N] }, curvature)
        };
        let mut first = warped(0, 0.0).0;
        first.joints = curve.postures[0];
        knots.push(first);
        for piece in 0..last {
            let (from, to) = (sigma[piece], sigma[piece + 1]);
            let whole = to - from;
            // What lies in the windows counts by their knots, the rest by the piece's.
            let left = (to.min(middle.start) - from).max(0.0) / middle.start * ramp as f64;
            let right = (to - from.max(middle.end)).max(0.0) / (warp.sigma - middle.end) * ramp as f64;
            let share = (to.min(middle.end) - from.max(middle.start)).max(0.0) / whole;
            let count = ((left + right + share * parts[piece] as f64 - 1e-6).ceil() as usize).max(parts[piece]);
            let step = whole / count as f64;
            for part in 1..=count {
                let (centre, bend) = warped(piece, from + (part as f64 - 0.5) * step);
                let before = std::array::from_fn(|j| 0.5 * bend[j] - 0.5 * centre.slope[j] / step);
                let after = std::array::from_fn(|j| 0.5 * bend[j] + 0.5 * centre.slope[j] / step);
                let [begin, end] = [part - 1, part].map(|part| warp.at(from + part as f64 * step)[0]);
                segments.push(Segment { piece, width: step, warp: (end - begin) / step, before, after });
                knots.push(warped(piece, if part == count { to } else { from + part as f64 * step }).0);
            }
            let knot = knots.len() - 1;
            knots[knot].joints = curve.postures[piece + 1];
            if piece + 1 < last {
                let (before, after) = (curve.third(piece), curve.third(piece + 1));
                let cube = knots[knot].warp.powi(3);
                knots[knot].jump = std::array::from_fn(|j| (after[j] - before[j]) * cube);
            }
            postures.push(knot);
        }
        Grid { knots, segments, postures }
    }
}
