//! Joints for a pose of the flange, by Newton's method from joints nearby: what a controller does that is given poses and goes on from where it is.
//!
//! K. Levenberg, "A method for the solution of certain non-linear problems in least squares", Quarterly of Applied Mathematics 2 (1944): steps are
//! damped, so that a singular posture does not throw the arm away.

use super::super::axes::{Axes, Frame};
use super::chain::Chain;
use nalgebra::{Matrix6, Vector6};

/// A radian counts as this many millimetres where places and turns are added up: about the reach of a wrist.
const RADIAN_MM: f64 = 100.0;
/// A pose this near counts as reached: 1 nm, and 1e-8 rad.
const REACHED: f64 = 1e-6;
/// A pose farther away than this after all steps is out of reach, in millimetres: 1 um; what steps leave at a singular posture is less.
const MISSED: f64 = 1e-3;
/// Most steps. From joints nearby three do.
const STEPS: usize = 60;
/// Damping to begin with, as a share of squared millimetres a radian, and where it ends.
const DAMPING: f64 = 1e-6;
const MAX_DAMPING: f64 = 1e8;
/// Largest change of a joint in a step, in radians: farther away the first order says nothing.
const MAX_STEP: f64 = 0.5;

/// Joints that Newton's method has found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// The axes; those of the table as they were.
    pub axes: Axes,
    /// How far the flange is off, in millimetres, a radian counted as 100.
    pub off_mm: f64,
}

impl Reached {
    /// Whether the pose is reached.
    pub fn is_reached(&self) -> bool {
        self.off_mm <= MISSED
    }
}

/// What is left to a pose, in millimetres.
fn rest(flange: &Frame, goal: &Frame) -> Vector6<f64> {
    let way = goal.at - flange.at;
    let turn = flange.turn * flange.turn_to(goal) * RADIAN_MM;
    Vector6::new(way.x, way.y, way.z, turn.x, turn.y, turn.z)
}

/// Joints near `seed` at which the flange is at `goal` in the base, or as near as it gets.
pub fn solve(chain: &Chain, goal: &Frame, seed: &Axes) -> Reached {
    let mut axes = *seed;
    let mut links = chain.at(&axes);
    let mut left = rest(&links.flange, goal);
    let mut damping = 0.0;
    for _ in 0..STEPS {
        if left.norm() <= REACHED {
            break;
        }
        let mut rates = Matrix6::zeros();
        for (k, [speed, axis]) in chain.rates(&links).iter().enumerate() {
            let axis = axis * RADIAN_MM;
            rates.set_column(k, &Vector6::new(speed.x, speed.y, speed.z, axis.x, axis.y, axis.z));
        }
        let Some(step) = step(&rates, &left, damping) else {
            damping = next(damping);
            continue;
        };
        let scale = (MAX_STEP / step.amax()).min(1.0);
        let mut tried = axes;
        (0..6).for_each(|k| tried[k] += scale * step[k]);
        let there = chain.at(&tried);
        let then = rest(&there.flange, goal);
        if then.norm() < left.norm() {
            (axes, links, left) = (tried, there, then);
            damping = if damping > DAMPING { 0.1 * damping } else { 0.0 };
        } else if damping > MAX_DAMPING {
            break;
        } else {
            damping = next(damping);
        }
    }
    Reached { axes, off_mm: left.norm() }
}

fn next(damping: f64) -> f64 {
    (10.0 * damping).max(DAMPING * RADIAN_MM * RADIAN_MM)
}

/// The step of joints that takes what is left to zero, in the first order.
fn step(rates: &Matrix6<f64>, left: &Vector6<f64>, damping: f64) -> Option<Vector6<f64>> {
    if damping > 0.0 {
        let normal = rates.transpose() * rates + Matrix6::identity() * damping;
        return normal.cholesky().map(|factor| factor.solve(&(rates.transpose() * left)));
    }
    rates.lu().solve(left).filter(|step| step.iter().all(|value| value.is_finite()))
}
