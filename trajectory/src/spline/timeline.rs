//! Knot times of a trajectory, and its second derivatives as a linear map of its knots.
//!
//! Between two knots `k` and `k + 1`, `h_k` apart, with angles `q` and accelerations `m`, a C2 cubic spline has the
//! velocity `(q_{k+1} - q_k) / h_k - h_k (2 m_k + m_{k+1}) / 6` at its beginning. That velocities agree at a knot is
//!
//! `h_{k-1} m_{k-1} + 2 (h_{k-1} + h_k) m_k + h_k m_{k+1} = 6 (q_{k+1} - q_k) / h_k - 6 (q_k - q_{k-1}) / h_{k-1}`
//!
//! (C. de Boor, *A Practical Guide to Splines*, Springer 1978, chapter IV). At rest neither speed nor acceleration is
//! left: `m = 0`, and the angle of the resting knot follows from its neighbour's, `q_0 = q_1 - h_0^2 m_1 / 6`. Put
//! into the equation of the neighbour, that takes the resting knot out of the system; its diagonal becomes
//! `3 h_0 + 2 h_1`, and the right-hand side keeps `6 (q_2 - q_1) / h_1`. So what is left is `T m = R q` over all knots
//! but the two resting ones, `T` symmetric, tridiagonal and diagonally dominant.
//!
//! Run-in and run-out are pieces of equal time before the first and after the last waypoint. The knots between them
//! may be anywhere (nothing is printed there), so waypoints keep their times, and a motion may pass the first one with
//! any speed and acceleration as soon as there are two pieces.

use crate::banded::Tridiagonal;
use std::ops::Range;

/// Pieces from rest to the first waypoint, and from the last one to rest.
///
/// The default is four pieces of half a second: with a jerk of 1 rad/s^3 two of them upwards and two downwards reach
/// 1 rad/s without acceleration, the speed at which the works run their arms. Fewer or shorter pieces cost jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunIn {
    /// Number of pieces at each end, 1 to [`RunIn::MAX_PIECES`].
    pub pieces: usize,
    /// Time of each, in seconds.
    pub spacing: f64,
}

impl RunIn {
    /// The most pieces at each end.
    pub const MAX_PIECES: usize = 64;
}

impl Default for RunIn {
    fn default() -> Self {
        RunIn { pieces: 4, spacing: 0.5 }
    }
}

/// Why there is no timeline.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TimelineError {
    /// There is no waypoint.
    #[error("no waypoint: a trajectory needs at least one")]
    Empty,
    /// A time is infinite or not a number.
    #[error("the time of waypoint {waypoint} is {time}, not a finite number")]
    NotFinite {
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// Its time.
        time: f64,
    },
    /// A time is not after the one before it.
    #[error("the time of waypoint {waypoint} is {time} s, not after {before} s of the one before it")]
    NotRising {
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// Its time.
        time: f64,
        /// The time of the waypoint before.
        before: f64,
    },
    /// The run-in or run-out is invalid.
    #[error(
        "run-in of {pieces} pieces of {spacing} s: from 1 to {} pieces of a finite time above 0 are needed",
        RunIn::MAX_PIECES
    )]
    RunIn {
        /// Number of pieces.
        pieces: usize,
        /// Time of each.
        spacing: f64,
    },
}

/// One row of `T m = R q`: what multiplies the knot before, the knot itself and the knot after.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplineRow {
    /// The row of `T`, for second derivatives. The first is 0 at the first knot, the last at the last knot.
    pub curvatures: [f64; 3],
    /// The row of `R`, for angles. Zero in the same places.
    pub angles: [f64; 3],
}

/// The knot times of a trajectory; all joints share them.
///
/// Knots are counted from 0 without the two resting ones: first those of the run-in, then the waypoints, then those of
/// the run-out. [`Timeline::times`] has the resting knots as well, so knot `k` is at `times()[k + 1]`.
/// ```
/// use curvlay_trajectory::{RunIn, Timeline};
/// let line = Timeline::new(&[0.0, 0.2, 0.4], RunIn { pieces: 3, spacing: 0.5 })?;
/// assert_eq!(line.times(), [-1.5, -1.0, -0.5, 0.0, 0.2, 0.4, 0.9, 1.4, 1.9]);
/// assert_eq!((line.knots(), line.waypoints()), (7, 2..5));
/// # Ok::<(), curvlay_trajectory::TimelineError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    times: Vec<f64>,
    /// Free knots at each end.
    run: usize,
    /// The factors of `T`.
    factors: Tridiagonal,
}

impl Timeline {
    /// Puts run-in and run-out around waypoints at these times.
    ///
    /// # Errors
    /// [`TimelineError`] names the waypoint or the number.
    ///
    /// # Cost
    /// Linear time and memory.
    pub fn new(waypoint_times: &[f64], run: RunIn) -> Result<Self, TimelineError> {
        let RunIn { pieces, spacing } = run;
        if !((1..=RunIn::MAX_PIECES).contains(&pieces) && spacing > 0.0 && spacing.is_finite()) {
            return Err(TimelineError::RunIn { pieces, spacing });
        }
        check_times(waypoint_times)?;
        let (&[first, ..], &[.., last]) = (waypoint_times, waypoint_times) else { return Err(TimelineError::Empty) };
        let run_in = (1..=pieces).rev().map(|k| first - k as f64 * spacing);
        let run_out = (1..=pieces).map(|k| last + k as f64 * spacing);
        let times: Vec<f64> = run_in.chain(waypoint_times.iter().copied()).chain(run_out).collect();
        // Far from zero a short time may be lost in rounding.
        if times.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(TimelineError::RunIn { pieces, spacing });
        }
        Ok(Timeline::factored(times, pieces - 1))
    }

    /// A timeline without run-in and run-out: these are all its knots, and it rests at the first and the last. Every
    /// knot between them counts as a waypoint.
    ///
    /// # Errors
    /// [`TimelineError::Empty`] for fewer than three times, [`TimelineError::NotFinite`] and
    /// [`TimelineError::NotRising`], where `waypoint` is the index of the time.
    ///
    /// # Cost
    /// Linear time and memory.
    /// ```
    /// use curvlay_trajectory::{Timeline, Trajectory};
    /// let line = Timeline::at_rest(&[0.0, 1.0, 2.0])?;
    /// assert_eq!((line.knots(), line.waypoints()), (1, 0..1));
    /// let there = Trajectory::new(&line, &[[0.5]])?;
    /// assert_eq!(there.times(), [0.0, 1.0, 2.0]);
    /// assert_eq!((there.at(0.0).velocity, there.at(1.0).position), ([0.0], [0.5]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn at_rest(times: &[f64]) -> Result<Self, TimelineError> {
        check_times(times)?;
        if times.len() < 3 {
            return Err(TimelineError::Empty);
        }
        Ok(Timeline::factored(times.to_vec(), 0))
    }

    fn factored(times: Vec<f64>, run: usize) -> Self {
        let mut line = Timeline { times, run, factors: Tridiagonal::default() };
        for k in 0..line.knots() {
            let [before, diagonal, _] = line.row(k).curvatures;
            line.factors.push(before, diagonal);
        }
        line
    }

    /// Times of all knots, the two resting ones included, in seconds.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Number of knots without the resting ones.
    pub fn knots(&self) -> usize {
        self.times.len() - 2
    }

    /// Which knots are the waypoints; those before and after are free.
    pub fn waypoints(&self) -> Range<usize> {
        self.run..self.knots() - self.run
    }

    /// Time of the piece that ends at knot `k` (`0..=knots()`; the last ends at rest), in seconds.
    ///
    /// # Panics
    /// If there is no such piece.
    pub fn step(&self, piece: usize) -> f64 {
        self.times[piece + 1] - self.times[piece]
    }

    /// The row of `T m = R q` at knot `k`.
    /// ```
    /// use curvlay_trajectory::{RunIn, Timeline};
    /// let line = Timeline::new(&[0.0, 1.0, 2.0], RunIn { pieces: 1, spacing: 2.0 })?;
    /// assert_eq!(line.row(0).curvatures, [0.0, 8.0, 1.0]);
    /// assert_eq!(line.row(1).curvatures, [1.0, 4.0, 1.0]);
    /// assert_eq!(line.row(1).angles, [6.0, -12.0, 6.0]);
    /// # Ok::<(), curvlay_trajectory::TimelineError>(())
    /// ```
    ///
    /// # Panics
    /// If there is no such knot: `k` must be below [`Timeline::knots`].
    pub fn row(&self, knot: usize) -> SplineRow {
        let (before, after) = (self.step(knot), self.step(knot + 1));
        let (first, last) = (knot == 0, knot + 1 == self.knots());
        let left = if first { 0.0 } else { 6.0 / before };
        let right = if last { 0.0 } else { 6.0 / after };
        let weight = |rests: bool, step: f64| if rests { 3.0 * step } else { 2.0 * step };
        SplineRow {
            curvatures: [
                if first { 0.0 } else { before },
                weight(first, before) + weight(last, after),
                if last { 0.0 } else { after },
            ],
            angles: [left, -left - right, right],
        }
    }

    /// Solves `T x = b` in place, `b` of [`Timeline::knots`] entries. `T` is symmetric, so this is the adjoint as well.
    ///
    /// # Panics
    /// If `b` has another length.
    pub fn solve(&self, b: &mut [f64]) {
        assert_eq!(b.len(), self.knots(), "one entry a knot");
        self.factors.solve(b);
    }

    /// The second derivatives `T^-1 R q` of one joint at its knots.
    ///
    /// # Panics
    /// If there is not one angle a knot.
    pub fn second_derivatives(&self, angles: &[f64]) -> Vec<f64> {
        assert_eq!(angles.len(), self.knots(), "one angle a knot");
        let mut m: Vec<f64> = (0..angles.len())
            .map(|k| {
                // Differences first: angles far from zero keep their digits.
                let [left, _, right] = self.row(k).angles;
                let before = if k > 0 { left * (angles[k - 1] - angles[k]) } else { 0.0 };
                let after = if k + 1 < angles.len() { right * (angles[k + 1] - angles[k]) } else { 0.0 };
                before + after
            })
            .collect();
        self.solve(&mut m);
        m
    }

    /// The same for all joints together, an array of them a knot.
    pub(crate) fn second_derivatives_of_all<const N: usize>(&self, angles: &[[f64; N]]) -> Vec<[f64; N]> {
        assert_eq!(angles.len(), self.knots(), "one posture a knot");
        let mut previous = [0.0; N];
        let right_side = |(k, at): (usize, &[f64; N])| {
            let right = if k + 1 < angles.len() { 6.0 / self.step(k + 1) } else { 0.0 };
            let next = angles.get(k + 1).unwrap_or(at);
            // Differences first: angles far from zero keep their digits.
            let after: [f64; N] = std::array::from_fn(|j| right * (next[j] - at[j]));
            let right_side = std::array::from_fn(|j| after[j] - previous[j]);
            previous = after;
            right_side
        };
        let mut m: Vec<[f64; N]> = angles.iter().enumerate().map(right_side).collect();
        self.factors.solve_all(&mut m);
        m
    }

    /// Integral of the product of two jerks, given by their second derivatives.
    pub(super) fn jerk_product(&self, a: &[f64], b: &[f64]) -> f64 {
        let at = |m: &[f64], knot: usize| if knot == 0 { 0.0 } else { m.get(knot - 1).copied().unwrap_or(0.0) };
        (0..=self.knots())
            .map(|piece| {
                let (rise_a, rise_b) = (at(a, piece + 1) - at(a, piece), at(b, piece + 1) - at(b, piece));
                rise_a * rise_b / self.step(piece)
            })
            .sum()
    }
}

fn check_times(times: &[f64]) -> Result<(), TimelineError> {
    for (waypoint, &time) in times.iter().enumerate() {
        if !time.is_finite() {
            return Err(TimelineError::NotFinite { waypoint, time });
        }
        if waypoint > 0 && time <= times[waypoint - 1] {
            return Err(TimelineError::NotRising { waypoint, time, before: times[waypoint - 1] });
        }
    }
    Ok(())
}
