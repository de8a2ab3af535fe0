//! What a window sees of its source: the distance along an edge, and where one wave arrives before another.
//!
//! In the frame of an edge (along x) the source is unfolded into the half-plane below. A point wave starts in the point
//! `(x, -depth)` with the distance `base`; a strip wave is a parallel front that moves along `(along, across)`.
//! The distance is `base + sqrt((t - x)^2 + depth^2)` or `base + along * t`: both convex in `t`. Two of them are equal
//! where a quadratic polynomial is zero, so they cross at most twice.

/// A wave as seen from an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wave {
    Point { x: f64, depth: f64, base: f64 },
    Strip { along: f64, across: f64, base: f64 },
}

/// Which of two waves has which part of an interval: the winners take turns, beginning with the challenger or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contest {
    pub challenger_first: bool,
    pub cuts: [f64; 2],
    pub count: usize,
}

/// A zero of the difference of two distances is good when the difference there is below this share of the distance: a
/// few roundings. Closer is not to be had; at a much larger value the envelope would not be exact to rounding.
const ZERO: f64 = 1e-15;
/// Halvings after which a bracket of doubles cannot shrink any more.
const HALVINGS: usize = 64;

impl Wave {
    /// The distance at `t`.
    pub fn at(&self, t: f64) -> f64 {
        match *self {
            Wave::Point { x, depth, base } => base + ((t - x) * (t - x) + depth * depth).sqrt(),
            Wave::Strip { along, base, .. } => base + along * t,
        }
    }

    /// The least distance over an interval.
    pub fn least(&self, [from, to]: [f64; 2]) -> f64 {
        match *self {
            Wave::Point { x, .. } => self.at(x.clamp(from, to)),
            Wave::Strip { along, .. } => self.at(if along > 0.0 { from } else { to }),
        }
    }

    /// Whether the distance at `t` is more than the given one; but for rounding, and without a root.
    pub fn is_later(&self, t: f64, than: f64) -> bool {
        match *self {
            Wave::Point { x, depth, base } => {
                let room = than - base;
                room < 0.0 || room * room < (t - x) * (t - x) + depth * depth
            }
            Wave::Strip { .. } => self.at(t) > than,
        }
    }

    /// The direction of travel across the edge at `t`, of any length.
    pub fn direction(&self, t: f64) -> [f64; 2] {
        match *self {
            Wave::Point { x, depth, .. } => [t - x, depth],
            Wave::Strip { along, across, .. } => [along, across],
        }
    }

    /// The distance at a point above the edge, along a straight line.
    pub fn beyond(&self, [px, py]: [f64; 2]) -> f64 {
        match *self {
            Wave::Point { x, depth, base } => base + (px - x).hypot(py + depth),
            Wave::Strip { along, across, base } => base + along * px + across * py,
        }
    }

    /// Where the straight line to a point above the edge crosses it.
    pub fn crossing(&self, [px, py]: [f64; 2]) -> f64 {
        match *self {
            Wave::Point { x, depth, .. } => x + (px - x) * (depth / (depth + py)),
            Wave::Strip { along, across, .. } => px - py * (along / across),
        }
    }

    /// The wave as seen from the same edge run the other way.
    pub fn reversed(&self, length: f64) -> Wave {
        match *self {
            Wave::Point { x, depth, base } => Wave::Point { x: length - x, depth, base },
            Wave::Strip { along, across, base } => Wave::Strip { along: -along, across, base: base + along * length },
        }
    }

    /// The wave as seen from an edge above, from `tail` on in the unit direction `u`, that the wave crosses from its
    /// left.
    pub fn seen_from(&self, tail: [f64; 2], u: [f64; 2]) -> Wave {
        match *self {
            Wave::Point { x, depth, base } => {
                let d = [x - tail[0], -depth - tail[1]];
                Wave::Point { x: d[0] * u[0] + d[1] * u[1], depth: u[0] * d[1] - u[1] * d[0], base }
            }
            Wave::Strip { along, across, base } => Wave::Strip {
                along: along * u[0] + across * u[1],
                across: along * u[1] - across * u[0],
                base: base + along * tail[0] + across * tail[1],
            },
        }
    }

    /// Whether two waves differ by no more than `slack`, on an edge up to `reach`.
    pub fn agrees(&self, other: &Wave, reach: f64, slack: f64) -> bool {
        match (*self, *other) {
            (Wave::Point { x, depth, base }, Wave::Point { x: x2, depth: depth2, base: base2 }) => {
                (x - x2).abs() + (depth - depth2).abs() + (base - base2).abs() <= slack
            }
            (Wave::Strip { along, base, .. }, Wave::Strip { along: along2, base: base2, .. }) => {
                (along - along2).abs() * reach + (base - base2).abs() <= slack
            }
            _ => false,
        }
    }

    fn shifted(&self, by: f64) -> Wave {
        match *self {
            Wave::Point { x, depth, base } => Wave::Point { x: x - by, depth, base },
            Wave::Strip { along, across, base } => Wave::Strip { along, across, base: base + along * by },
        }
    }

    fn base(&self) -> f64 {
        match *self {
            Wave::Point { base, .. } | Wave::Strip { base, .. } => base,
        }
    }
}

/// Divides an interval between a wave that is there and a challenger, who wins only where it is ahead by more than
/// `slack`.
pub(super) fn contest(challenger: &Wave, holder: &Wave, [from, to]: [f64; 2], slack: f64) -> Contest {
    let behind = |t: f64| challenger.at(t) - holder.at(t) + slack;
    let ends = [behind(from), behind(to)];
    let first = ends[0] < 0.0;
    let whole = Contest { challenger_first: first, cuts: [0.0; 2], count: 0 };
    if first != (ends[1] < 0.0) {
        let [one, other] = equal_at(challenger, holder, from, slack);
        let guess = if from < one && one < to { one } else { other };
        let cut = zero(behind, [from, to], first, guess, ZERO * holder.at(from).abs());
        return Contest { cuts: [cut, 0.0], count: 1, ..whole };
    }
    // The loser at both ends can win between them only as a point wave that passes nearby.
    let (winner, loser) = if first { (challenger, holder) } else { (holder, challenger) };
    let hopeless = match loser {
        Wave::Strip { .. } => true,
        Wave::Point { .. } => loser.least([from, to]) > winner.at(from).max(winner.at(to)) + slack,
    };
    if hopeless {
        return whole;
    }
    let [one, other] = equal_at(challenger, holder, from, slack);
    let (low, high) = (one.min(other), one.max(other));
    if !(from < low && low < high && high < to) {
        return whole;
    }
    let middle = 0.5 * (low + high);
    if (behind(middle) < 0.0) == first {
        return whole;
    }
    let small = ZERO * holder.at(from).abs();
    let cuts = [zero(behind, [from, middle], first, low, small), zero(behind, [middle, to], !first, high, small)];
    Contest { cuts, count: 2, ..whole }
}

/// Where the two distances, the first one more by `slack`, may be equal: solutions of a quadratic equation, NaN where
/// there is none. Measured from `origin`, near which the figures are small.
fn equal_at(a: &Wave, b: &Wave, origin: f64, slack: f64) -> [f64; 2] {
    let (a, b) = (a.shifted(origin), b.shifted(origin));
    let ahead = a.base() + slack - b.base();
    // p t + q = m sqrt((t - x)^2 + depth^2)
    let (p, q, m, x, depth) = match (a, b) {
        (Wave::Strip { along: one, .. }, Wave::Strip { along: other, .. }) => {
            return [origin - ahead / (one - other), f64::NAN];
        }
        (Wave::Strip { along, .. }, Wave::Point { x, depth, .. }) => (along, ahead, 1.0, x, depth),
        (Wave::Point { x, depth, .. }, Wave::Strip { along, .. }) => (along, -ahead, 1.0, x, depth),
        (Wave::Point { x: xa, depth: da, .. }, Wave::Point { x: xb, depth: db, .. }) => {
            let q = (xb - xa) * (xb + xa) + (db - da) * (db + da) + ahead * ahead;
            (2.0 * (xa - xb), q, 2.0 * ahead, xb, db)
        }
    };
    let square = p * p - m * m;
    let half = p * q + m * m * x;
    let constant = q * q - m * m * (x * x + depth * depth);
    let root = (half * half - square * constant).sqrt();
    let sum = -(half + root.copysign(half));
    [origin + sum / square, origin + constant / sum]
}

/// A zero of a function between two places where its signs differ.
fn zero(f: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2], negative_at_low: bool, guess: f64, small: f64) -> f64 {
    let mut t = guess;
    for _ in 0..HALVINGS {
        let inside = low < t && t < high; // false for NaN
        if !inside {
            t = 0.5 * (low + high);
        }
        let value = f(t);
        if value.abs() <= small {
            break;
        }
        if (value < 0.0) == negative_at_low {
            low = t
        } else {
            high = t
        }
        t = 0.5 * (low + high);
    }
    t
}
