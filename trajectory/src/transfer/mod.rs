//! Transfers: from the end of one path to the start of the next without touching anything.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.5: RRT-Connect between poses. Here
//! besides: bounds of the joints, a way made shorter in time (`shorten`), and a motion as fast as velocity, acceleration
//! and jerk allow along it ([`SCurve`]): straight in joint space between corners, at rest in each. A line that was shown
//! to be free stays free, since the motion does not leave it; to round a corner would need another proof.
//!
//! What is free is the caller's to say: see [`FreeSpace`]. With a swept proof for each line the whole transfer is proven.
//! Proofs are dear, postures cheap: the search goes by postures, and proves the lines of what it found.
//! Nothing is searched without end: [`TransferOptions::iterations`] bounds it, and the same seed gives the same motion.

mod checks;
mod shorten;
mod space;
mod timing;
mod tree;

pub use space::FreeSpace;
pub use timing::{SCurve, SState};

use crate::bounds::Bounds;
use crate::random::Random;
use crate::spline::State;
use crate::vectors::square;
use timing::curve;

/// How a transfer is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct TransferOptions {
    /// Longest edge of the trees, in radians. Longer ones cross open space in fewer checks, shorter ones pass narrow gaps.
    pub step: f64,
    /// How far apart postures are that are tried along a line before it is proven, in radians. Finer ones find more of
    /// what is in the way before a proof does; whether a motion is free does not depend on it.
    pub spacing: f64,
    /// Random postures before giving up.
    pub iterations: usize,
    /// Attempts to make the way shorter.
    pub shortcuts: usize,
    /// How far beyond the angles of both ends random postures are drawn, in radians, within the bounds. Joints that turn
    /// without end need it.
    pub reach: f64,
    /// The seed of the random numbers.
    pub seed: u64,
}

impl Default for TransferOptions {
    /// Edges of 0.5 rad, postures 0.1 rad apart, 5000 random postures, 100 attempts to shorten, half a turn beyond both ends.
    fn default() -> Self {
        TransferOptions {
            step: 0.5,
            spacing: 0.1,
            iterations: 5000,
            shortcuts: 100,
            reach: std::f64::consts::PI,
            seed: 1,
        }
    }
}

/// Which end of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Where it starts.
    Start,
    /// Where it leads.
    Goal,
}

/// What came of a transfer.
#[derive(Clone, Debug, PartialEq)]
pub enum Planned<const N: usize> {
    /// A motion.
    Found(Transfer<N>),
    /// An end is not free, so nothing was searched.
    Collides {
        /// The name of the transfer, as given.
        name: String,
        /// Which end.
        end: End,
        /// What is in the way there: [`FreeSpace::obstruction`].
        with: String,
    },
    /// No way was found; there may be one all the same.
    NoPath {
        /// The name of the transfer, as given.
        name: String,
        /// Its start.
        from: [f64; N],
        /// Its goal.
        to: [f64; N],
        /// Random postures tried.
        iterations: usize,
        /// Postures reached from start and goal: an end with few of them is shut in.
        reached: [usize; 2],
    },
}

impl<const N: usize> Planned<N> {
    /// The motion, where there is one.
    pub fn found(self) -> Option<Transfer<N>> {
        if let Planned::Found(transfer) = self { Some(transfer) } else { None }
    }
}

impl<const N: usize> std::fmt::Display for Planned<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Planned::Found(transfer) => write!(f, "{:.2} s over {} lines", transfer.duration, transfer.curves.len()),
            Planned::Collides { name, end, with } => {
                let end = if *end == End::Start { "start" } else { "goal" };
                write!(f, "transfer {name}: {with} is in the way at the {end}")
            }
            Planned::NoPath { name, iterations, reached: [a, b], .. } => write!(
                f,
                "transfer {name}: no way in {iterations} attempts, {a} postures reached from the start, {b} from the goal"
            ),
        }
    }
}

/// Why no transfer can be planned at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransferError {
    /// An end is beyond the bounds, or not finite.
    #[error("transfer {name}: joint {} is {value} rad at the {end:?}, its bounds are {lower} to {upper}", joint + 1)]
    OutOfBounds {
        /// The name of the transfer.
        name: String,
        /// Which end.
        end: End,
        /// The joint, counted from 0.
        joint: usize,
        /// Its angle.
        value: f64,
        /// Its least angle.
        lower: f64,
        /// Its greatest angle.
        upper: f64,
    },
    /// Without a bound there is no fastest motion.
    #[error("joint {} has a greatest {what} of {value}: a transfer needs finite ones above 0", joint + 1)]
    Bound {
        /// The joint, counted from 0.
        joint: usize,
        /// `velocity`, `acceleration` or `jerk`.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Ends, bounds and reach lie so far apart that steps do not get there.
    #[error(
        "transfer {name}: the search spans {span} rad, more than {MAX_STEPS} steps of {step} rad: bring start and goal closer, \
         lower `reach`, or raise `step` and `spacing`"
    )]
    TooFar {
        /// The name of the transfer.
        name: String,
        /// Diagonal of the box of joints that the search draws from, in radians.
        span: f64,
        /// The smaller of [`TransferOptions::step`] and [`TransferOptions::spacing`].
        step: f64,
    },
    /// An option is out of range.
    #[error("{what} is {value}: it must be finite and above 0")]
    Option {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

/// A motion from rest to rest through corners, straight in joint space between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer<const N: usize> {
    corners: Vec<[f64; N]>,
    /// One a line, over a length of 1.
    curves: Vec<SCurve>,
    starts: Vec<f64>,
    duration: f64,
    iterations: usize,
}

impl<const N: usize> Transfer<N> {
    /// The fastest motion along lines through these corners (at least one): for a way that was found elsewhere.
    ///
    /// # Errors
    /// [`TransferError`] when a bound is missing. An empty list gives a motion of no corners that stays at zero.
    pub fn through(corners: Vec<[f64; N]>, bounds: &Bounds<N>) -> Result<Self, TransferError> {
        check_bounds(bounds)?;
        let mut transfer = Transfer { corners, curves: vec![], starts: vec![], duration: 0.0, iterations: 0 };
        for (line, ends) in transfer.corners.windows(2).enumerate() {
            let Some(curve) = curve(&ends[0], &ends[1], bounds) else {
                let joint = (0..N).find(|&j| !(ends[1][j] - ends[0][j]).is_finite()).unwrap_or(0);
                let end = if line == 0 && !ends[0][joint].is_finite() { End::Start } else { End::Goal };
                let value = if end == End::Start { ends[0][joint] } else { ends[1][joint] };
                let [lower, upper] = [bounds.lower[joint], bounds.upper[joint]];
                return Err(TransferError::OutOfBounds { name: format!("{line}"), end, joint, value, lower, upper });
            };
            transfer.starts.push(transfer.duration);
            transfer.duration += curve.duration();
            transfer.curves.push(curve);
        }
        Ok(transfer)
    }

    /// The same way, with each line followed within the bounds and within a speed of its own.
    ///
    /// # Arguments
    /// * `max_rate`: for the ends of a line, the greatest share of it a second; infinite for none.
    ///
    /// # Errors
    /// [`TransferError`] when a bound is missing.
    ///
    /// # Example
    /// ```
    /// use curvlay_trajectory::{Bounds, transfer::Transfer};
    /// let bounds = Bounds { velocity: [1.0], acceleration: [5.0], jerk: [50.0], ..Bounds::NONE };
    /// let fast = Transfer::through(vec![[0.0], [2.0]], &bounds)?;
    /// // A tenth of the line a second: 0.2 rad/s.
    /// let slow = fast.limited(&bounds, |_, _| 0.1)?;
    /// assert!((slow.at(slow.duration() / 2.0).velocity[0] - 0.2).abs() < 1e-9 && slow.duration() > 10.0);
    /// assert_eq!(slow.corners(), fast.corners());
    /// # Ok::<(), curvlay_trajectory::transfer::TransferError>(())
    /// ```
    pub fn limited(
        &self,
        bounds: &Bounds<N>,
        max_rate: impl Fn(&[f64; N], &[f64; N]) -> f64,
    ) -> Result<Self, TransferError> {
        let mut limited = Transfer { starts: vec![], curves: vec![], duration: 0.0, ..self.clone() };
        for ends in self.corners.windows(2) {
            let rate = max_rate(&ends[0], &ends[1]);
            let velocity = std::array::from_fn(|j| {
                let share = (ends[1][j] - ends[0][j]).abs() * rate;
                if share > 0.0 { bounds.velocity[j].min(share) } else { bounds.velocity[j] }
            });
            let line = Transfer::through(ends.to_vec(), &Bounds { velocity, ..*bounds })?;
            limited.starts.push(limited.duration);
            limited.duration += line.duration;
            limited.curves.extend(line.curves);
        }
        Ok(limited)
    }

    /// Its corners, ends included. The motion rests in each.
    pub fn corners(&self) -> &[[f64; N]] {
        &self.corners
    }

    /// In seconds.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Random postures that were drawn to find it; 0 where the straight line is free.
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// Joints and their derivatives at a time; at rest before the start and after the end.
    pub fn at(&self, time: f64) -> State<N> {
        let line = self.starts.partition_point(|&start| start <= time).saturating_sub(1);
        let moving = self.curves.get(line).filter(|_| time < self.duration);
        let Some(curve) = moving else {
            let end = if time < self.duration { self.corners.first() } else { self.corners.last() };
            let position = end.copied().unwrap_or([0.0; N]);
            return State { position, velocity: [0.0; N], acceleration: [0.0; N], jerk: [0.0; N] };
        };
        let (from, to) = (self.corners[line], self.corners[line + 1]);
        let state = curve.at(time - self.starts[line]);
        let times = |factor: f64| std::array::from_fn(|j| (to[j] - from[j]) * factor);
        let joint = |j: usize| {
            let share = if state.place < 0.5 {
                from[j] + (to[j] - from[j]) * state.place
            } else {
                to[j] - (to[j] - from[j]) * (1.0 - state.place)
            };
            // Rounding never leads beyond the ends.
            share.clamp(from[j].min(to[j]), from[j].max(to[j]))
        };
        State {
            position: std::array::from_fn(joint),
            velocity: times(state.velocity),
            acceleration: times(state.acceleration),
            jerk: times(state.jerk),
        }
    }

    /// The times at which the jerk changes, in order, from 0 to the end: between two of them joints are cubics of time.
    pub fn knots(&self) -> Vec<f64> {
        let of = |(curve, start): (&SCurve, &f64)| curve.knots().map(|knot| start + knot);
        let mut all: Vec<f64> = self.curves.iter().zip(&self.starts).flat_map(of).collect();
        all.push(self.duration);
        all.dedup();
        all
    }
}

/// The longest line that is searched has at most so many steps.
const MAX_STEPS: f64 = 1e6;

fn check_bounds<const N: usize>(bounds: &Bounds<N>) -> Result<(), TransferError> {
    let all = [("velocity", bounds.velocity), ("acceleration", bounds.acceleration), ("jerk", bounds.jerk)];
    for (what, values) in all {
        if let Some(joint) = values.iter().position(|value| !(value.is_finite() && *value > 0.0)) {
            return Err(TransferError::Bound { joint, what, value: values[joint] });
        }
    }
    Ok(())
}

/// Plans a motion between two postures at rest.
///
/// # Arguments
/// * `name`: what a failure calls it, such as `layer 4 to layer 5`.
/// * `bounds`: velocity, acceleration and jerk must be finite; angles may be without bounds.
/// * `space`: which lines in joint space are free; a closure will do.
///
/// # Errors
/// [`TransferError`] for ends out of bounds or too far apart, bounds that are missing, options out of range. That an end collides, or
/// that no way is found, is a result: [`Planned`].
///
/// # Cost
/// Checks of `space` take nearly all the time: one line where the straight one is free, else hundreds to thousands of
/// postures, and a proof of each line that comes to be part of the way, some tens. At most a few of them for each of
/// [`TransferOptions::iterations`] and [`TransferOptions::shortcuts`]. Deterministic.
///
/// # Example
/// ```
/// use curvlay_trajectory::{Bounds, transfer::{Planned, TransferOptions, plan_transfer}};
/// let bounds = Bounds { velocity: [1.0; 2], acceleration: [5.0; 2], jerk: [50.0; 2], ..Bounds::NONE };
/// // A wall from (0, -1) down: its upper end has to be passed.
/// let free = |a: &[f64; 2], b: &[f64; 2]| {
///     let crossing = a[1] + (b[1] - a[1]) * (a[0] / (a[0] - b[0]));
///     a[0] * b[0] > 0.0 || (a[0] != b[0] && crossing > -1.0)
/// };
/// let ends = ([-1.0, -2.0], [1.0, -2.0]);
/// let planned = plan_transfer("around the wall", &ends.0, &ends.1, &bounds, &free, &TransferOptions::default())?;
/// let transfer = planned.found().unwrap();
/// assert!(transfer.corners().len() >= 3 && transfer.duration() < 4.0);
/// assert_eq!(transfer.at(transfer.duration()).position, ends.1);
/// # Ok::<(), curvlay_trajectory::transfer::TransferError>(())
/// ```
pub fn plan_transfer<const N: usize>(
    name: &str,
    from: &[f64; N],
    to: &[f64; N],
    bounds: &Bounds<N>,
    space: &(impl FreeSpace<N> + ?Sized),
    options: &TransferOptions,
) -> Result<Planned<N>, TransferError> {
    for (what, value) in [("step", options.step), ("spacing", options.spacing), ("reach", options.reach)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(TransferError::Option { what, value });
        }
    }
    check_bounds(bounds)?;
    for (end, joints) in [(End::Start, from), (End::Goal, to)] {
        for (joint, &value) in joints.iter().enumerate() {
            let [lower, upper] = [bounds.lower[joint], bounds.upper[joint]];
            if !(value.is_finite() && lower <= value && value <= upper) {
                return Err(TransferError::OutOfBounds { name: name.into(), end, joint, value, lower, upper });
            }
        }
    }
    let low: [f64; N] = std::array::from_fn(|j| (from[j].min(to[j]) - options.reach).max(bounds.lower[j]));
    let high: [f64; N] = std::array::from_fn(|j| (from[j].max(to[j]) + options.reach).min(bounds.upper[j]));
    let (span, step) = (square(&low, &high).sqrt(), options.step.min(options.spacing));
    if span > MAX_STEPS * step {
        return Err(TransferError::TooFar { name: name.into(), span, step });
    }
    for (end, joints) in [(End::Start, from), (End::Goal, to)] {
        if let Some(with) = space.obstruction(joints) {
            return Ok(Planned::Collides { name: name.into(), end, with });
        }
    }
    let mut random = Random::new(options.seed);
    let search = tree::Search { low, high, longest: options.step, iterations: options.iterations };
    let mut checks = checks::Checks::new(space, options.spacing);
    match tree::connect(from, to, &mut checks, &search, &mut random) {
        tree::Way::None { iterations, trees } => {
            Ok(Planned::NoPath { name: name.into(), from: *from, to: *to, iterations, reached: trees })
        }
        tree::Way::Found { path, iterations } => {
            let path = shorten::shorten(path, bounds, &mut checks, options.shortcuts, &mut random);
            Ok(Planned::Found(Transfer { iterations, ..Transfer::through(path, bounds)? }))
        }
    }
}
