//! What the rows of a knot are made of, and which of them take part.

/// What the rows of a knot are made of.
#[derive(Clone, Debug)]
pub(super) struct Place<const N: usize> {
    /// In the middle of the segment behind the knot, accelerations are `before beta_k + after beta_{k+1}`; zero behind the last.
    pub before: [f64; N],
    pub after: [f64; N],
    /// By how much the third derivatives by `sigma` jump at the knot.
    pub jump: [f64; N],
    /// Of the segments before and behind the knot; 0 where there is none.
    pub widths: [f64; 2],
}

/// Limits of one knot's rows, above and below.
#[derive(Clone, Debug)]
pub(super) struct Limits<const N: usize> {
    pub acceleration: [[f64; N]; 2],
    /// On the segments before and behind the knot.
    pub jerk: [[[f64; N]; 2]; 2],
}

/// Which rows of a knot take part.
pub(super) struct KnotNear<const N: usize> {
    /// For each joint a bit for the jerk on the segment before the knot, that behind it, and the acceleration.
    pub joints: [u8; N],
    /// Flow and spike.
    pub others: [bool; 2],
}

/// What a row limits.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    /// On the segment before the knot (0) or behind it (1).
    Jerk(usize, usize),
    Acceleration(usize),
    Flow,
    Spike,
}

/// The unknown of a knot: unknown `k` belongs to knot `k + 1`, and the outermost knots share those of their neighbours.
#[inline]
pub(super) fn unknown(segments: usize, knot: usize) -> usize {
    knot.clamp(1, segments - 1) - 1
}

/// The most by which a value is above its upper limit, or below the lower one, which are multiplied by a number; -infinity if none has a limit.
#[inline]
pub(super) fn most_beyond<const N: usize>([above, below]: &[[f64; N]; 2], values: &[f64; N], scale: f64) -> f64 {
    let mut most = f64::NEG_INFINITY;
    for j in 0..N {
        for beyond in [values[j] - above[j] * scale, -values[j] - below[j] * scale] {
            // What is not a number does not count.
            most = if beyond > most { beyond } else { most };
        }
    }
    most
}

/// The greatest share of a value in its limit.
pub(super) fn most_share<const N: usize>([above, below]: &[[f64; N]; 2], values: &[f64; N]) -> f64 {
    let share = |j: usize| values[j].abs() / if values[j] > 0.0 { above[j] } else { below[j] };
    (0..N).map(share).fold(0.0, f64::max)
}

impl<const N: usize> Place<N> {
    /// The distance of the middles of the segments on both sides.
    pub fn distance(&self) -> f64 {
        0.5 * (self.widths[0] + self.widths[1])
    }

    /// Without a jump one row is for both sides: the other counts as one that takes part.
    pub fn none_near(&self) -> KnotNear<N> {
        KnotNear { joints: self.jump.map(|jump| if jump == 0.0 { 2 } else { 0 }), others: [false; 2] }
    }

    /// What of the jump the difference of accelerations misses on the segments on both sides: it holds the mean of both, by their widths.
    pub fn shares(&self) -> [f64; 2] {
        [-0.5 * self.widths[1], 0.5 * self.widths[0]]
    }
}
