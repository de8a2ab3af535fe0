//! Joint trajectories: C2 cubic splines through waypoints at given times, at rest at both ends.
//!
//! Within a piece the jerk is one number, so extremes of position, speed, acceleration and jerk, and the integral of
//! the squared jerk, have closed forms: what is said of a trajectory holds between its knots as well.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.1.1, looks at samples only
//! (Eq. 4.2); here the trajectory is a curve. How times become a linear map, and what run-in and run-out are, is described
//! at [`Timeline`].

mod check;
mod piece;
mod timeline;

pub use check::{Extremes, Quantity, Violation};
pub use piece::Peak;
pub use timeline::{RunIn, SplineRow, Timeline, TimelineError};

use nalgebra::{DMatrix, DVector};
use piece::Piece;
use std::ops::Range;

/// Why there is no trajectory.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrajectoryError {
    /// Joints and times do not fit.
    #[error("{given} joint positions for {expected} knots")]
    Count {
        /// Positions that were given.
        given: usize,
        /// Positions that the timeline calls for.
        expected: usize,
    },
    /// An angle is infinite or not a number.
    #[error("joint {} at knot {knot} is {value}, not a finite number", joint + 1)]
    NotFinite {
        /// The knot, counted from 0 among those that were given.
        knot: usize,
        /// The joint, counted from 0.
        joint: usize,
        /// Its angle.
        value: f64,
    },
}

/// Joints and their derivatives at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize> {
    /// Angles, in radians.
    pub position: [f64; N],
    /// In rad/s.
    pub velocity: [f64; N],
    /// In rad/s^2.
    pub acceleration: [f64; N],
    /// In rad/s^3; at a knot that of the piece that begins there.
    pub jerk: [f64; N],
}

/// A motion of `N` joints from rest to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory<const N: usize> {
    /// Of all knots, the resting ones included; so are the others.
    times: Vec<f64>,
    joints: Vec<[f64; N]>,
    accelerations: Vec<[f64; N]>,
    waypoints: Range<usize>,
}

impl<const N: usize> Trajectory<N> {
    /// The spline through given joints at every knot of the timeline but the resting ones, which follow.
    ///
    /// # Errors
    /// [`TrajectoryError`] if there is not one position a knot, or one is not finite.
    ///
    /// # Cost
    /// Linear time and memory.
    pub fn new(line: &Timeline, knots: &[[f64; N]]) -> Result<Self, TrajectoryError> {
        sound(knots, line.knots())?;
        let mut joints = Vec::with_capacity(knots.len() + 2);
        joints.push([0.0; N]);
        joints.extend_from_slice(knots);
        joints.push([0.0; N]);
        let mut accelerations = vec![[0.0; N]; joints.len()];
        let end = knots.len();
        accelerations[1..=end].copy_from_slice(&line.second_derivatives_of_all(knots));
        let (first_step, last_step) = (line.step(0), line.step(end));
        for joint in 0..N {
            let [first, last] = [accelerations[1][joint], accelerations[end][joint]];
            joints[0][joint] = knots[0][joint] - first_step * first_step * first / 6.0;
            joints[end + 1][joint] = knots[end - 1][joint] - last_step * last_step * last / 6.0;
        }
        let Range { start, end } = line.waypoints();
        Ok(Trajectory { times: line.times().to_vec(), joints, accelerations, waypoints: start + 1..end + 1 })
    }

    /// The spline through given joints at the waypoints, with that run-in and run-out that make the integral of the
    /// squared jerk least. No bounds are looked at: [`Trajectory::violations`] does that.
    ///
    /// # Errors
    /// [`TrajectoryError`] if there is not one position a waypoint, or one is not finite.
    ///
    /// # Cost
    /// Linear time and memory.
    /// ```
    /// use curvlay_trajectory::{RunIn, Timeline, Trajectory};
    /// let line = Timeline::new(&[0.0, 0.5, 1.0], RunIn::default())?;
    /// let trajectory = Trajectory::through(&line, &[[0.0, 1.0], [0.1, 1.0], [0.2, 1.0]])?;
    /// let halfway = trajectory.at(0.5);
    /// assert_eq!(halfway.position, [0.1, 1.0]);
    /// assert!((halfway.velocity[0] - 0.2).abs() < 0.05 && halfway.velocity[1] == 0.0);
    /// assert_eq!(trajectory.at(-100.0).velocity, [0.0; 2]);
    /// assert_eq!(trajectory.times()[trajectory.waypoints()], [0.0, 0.5, 1.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn through(line: &Timeline, waypoints: &[[f64; N]]) -> Result<Self, TrajectoryError> {
        Trajectory::new(line, &run_in_and_out(line, waypoints)?)
    }

    /// When it begins and ends, in seconds.
    pub fn span(&self) -> (f64, f64) {
        (self.times[0], self.times[self.times.len() - 1])
    }

    /// Times of all knots, the resting ones included.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Joints at all knots, the resting ones included.
    pub fn joints(&self) -> &[[f64; N]] {
        &self.joints
    }

    /// Which knots are the waypoints; before them is run-in, after them run-out.
    pub fn waypoints(&self) -> Range<usize> {
        self.waypoints.clone()
    }

    /// Joints at the waypoints.
    pub fn at_waypoints(&self) -> &[[f64; N]] {
        &self.joints[self.waypoints.clone()]
    }

    /// Number of pieces between knots.
    pub fn pieces(&self) -> usize {
        self.times.len() - 1
    }

    /// The jerks on piece `k`, that from knot `k` to knot `k + 1` (the resting ones counted), in rad/s^3.
    ///
    /// # Panics
    /// If there is no such piece: `k` must be below [`Trajectory::pieces`].
    pub fn jerk(&self, piece: usize) -> [f64; N] {
        std::array::from_fn(|joint| self.piece(piece, joint).j)
    }

    /// The Bezier control points of piece `k`, that from knot `k` to knot `k + 1` (the resting ones counted): the motion
    /// between the two lies within their convex hull.
    /// ```
    /// use curvlay_trajectory::{RunIn, Timeline, Trajectory};
    /// let line = Timeline::new(&[0.0, 1.0, 2.0], RunIn::default())?;
    /// let motion = Trajectory::through(&line, &[[0.0], [1.0], [0.0]])?;
    /// let piece = motion.waypoints().start;
    /// let [[a], [b], [c], [d]] = motion.control(piece);
    /// assert!((motion.at(0.5).position[0] - (a + 3.0 * b + 3.0 * c + d) / 8.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If there is no such piece: `k` must be below [`Trajectory::pieces`].
    pub fn control(&self, piece: usize) -> [[f64; N]; 4] {
        let (from, to) = (self.joints[piece], self.joints[piece + 1]);
        let cubics: [Piece; N] = std::array::from_fn(|joint| self.piece(piece, joint));
        let leaving = cubics.map(|cubic| cubic.q + cubic.v * cubic.step / 3.0);
        let arriving = |joint: usize| to[joint] - cubics[joint].velocity(cubics[joint].step) * cubics[joint].step / 3.0;
        [from, leaving, std::array::from_fn(arriving), to]
    }

    /// Joints and their derivatives at a time; at rest before the beginning and after the end.
    ///
    /// # Cost
    /// A binary search.
    pub fn at(&self, time: f64) -> State<N> {
        let (first, last) = self.span();
        let mut state = State { position: [0.0; N], velocity: [0.0; N], acceleration: [0.0; N], jerk: [0.0; N] };
        if !(first <= time && time < last) {
            state.position = if time < last { self.joints[0] } else { self.joints[self.pieces()] };
            return state;
        }
        let k = self.times.partition_point(|&knot| knot <= time) - 1;
        for joint in 0..N {
            let piece = self.piece(k, joint);
            let s = time - piece.time;
            state.position[joint] = piece.position(s);
            state.velocity[joint] = piece.velocity(s);
            state.acceleration[joint] = piece.acceleration(s);
            state.jerk[joint] = piece.j;
        }
        state
    }

    /// The integral of the squared jerk over all joints from rest to rest, in rad^2/s^5.
    pub fn squared_jerk(&self) -> f64 {
        self.squared_jerk_of(0..self.pieces())
    }

    /// The same between the first and the last waypoint only.
    pub fn squared_jerk_printing(&self) -> f64 {
        self.squared_jerk_of(self.waypoints.start..self.waypoints.end - 1)
    }

    fn squared_jerk_of(&self, pieces: Range<usize>) -> f64 {
        let of = |k| {
            let jerk = self.jerk(k);
            (self.times[k + 1] - self.times[k]) * jerk.iter().map(|j| j * j).sum::<f64>()
        };
        pieces.map(of).sum()
    }

    fn piece(&self, k: usize, joint: usize) -> Piece {
        let (time, step) = (self.times[k], self.times[k + 1] - self.times[k]);
        let (q, next) = (self.joints[k][joint], self.joints[k + 1][joint]);
        let (a, after) = (self.accelerations[k][joint], self.accelerations[k + 1][joint]);
        let v = (next - q) / step - step * (2.0 * a + after) / 6.0;
        Piece { time, step, q, v, a, j: (after - a) / step }
    }
}

/// The knots of the timeline: given waypoints, and free knots before and after them with which the integral of the
/// squared jerk is least.
///
/// # Errors
/// [`TrajectoryError`] if there is not one position a waypoint, or one is not finite.
pub fn run_in_and_out<const N: usize>(
    line: &Timeline,
    waypoints: &[[f64; N]],
) -> Result<Vec<[f64; N]>, TrajectoryError> {
    let range = line.waypoints();
    sound(waypoints, range.len())?;
    let (first, last) = (waypoints[0], waypoints[waypoints.len() - 1]);
    // Free knots stand where their waypoint stands, and then move by what least squares say.
    let mut knots = vec![first; range.start];
    knots.extend_from_slice(waypoints);
    knots.resize(line.knots(), last);
    let free: Vec<usize> = (0..range.start).chain(range.end..line.knots()).collect();
    if free.is_empty() {
        return Ok(knots);
    }
    let responses: Vec<Vec<f64>> = free
        .iter()
        .map(|&knot| {
            let mut angles = vec![0.0; line.knots()];
            angles[knot] = 1.0;
            line.second_derivatives(&angles)
        })
        .collect();
    let normal = DMatrix::from_fn(free.len(), free.len(), |a, b| line.jerk_product(&responses[a], &responses[b]));
    // Positive definite: only a motion that stands still has no jerk, and a free knot that leaves it moves.
    let Some(factor) = normal.cholesky() else { return Ok(knots) };
    for joint in 0..N {
        let m = line.second_derivatives(&knots.iter().map(|knot| knot[joint]).collect::<Vec<_>>());
        let slopes = DVector::from_iterator(free.len(), responses.iter().map(|r| -line.jerk_product(r, &m)));
        let moves = factor.solve(&slopes);
        free.iter().zip(moves.iter()).for_each(|(&knot, by)| knots[knot][joint] += by);
    }
    Ok(knots)
}

fn sound<const N: usize>(knots: &[[f64; N]], expected: usize) -> Result<(), TrajectoryError> {
    if knots.len() != expected {
        return Err(TrajectoryError::Count { given: knots.len(), expected });
    }
    for (knot, joints) in knots.iter().enumerate() {
        if let Some(joint) = joints.iter().position(|angle| !angle.is_finite()) {
            return Err(TrajectoryError::NotFinite { knot, joint, value: joints[joint] });
        }
    }
    Ok(())
}
