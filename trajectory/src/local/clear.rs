//! The rows of Eq. 4.12 that keep a window clear of collisions: `Gamma(q) < 0` at its waypoints.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.3.2. In each quadratic program a row
//! `Gamma(q) + grad Gamma . dq <= -clear`; a step is accepted only if the indicator itself confirms it.

use super::clearances::ClearOf;
use super::error::FilterError;
use super::filter::filter;
use super::options::{FilterOptions, Filtered};
use crate::ladder::LadderNode;
use crate::robot::Robot;
use crate::{Bounds, ProgressFn};

/// Algorithm 6 with all rows of Eq. 4.12: as [`filter_locally`](super::filter_locally), but where the indicator is below
/// `-clear` it stays there, and where it is above it does not rise.
///
/// Nothing is asked between waypoints, and an indicator may be wrong: check the motion with an exact scene
/// ([`verify`](crate::verify)).
///
/// # Errors
/// Those of [`filter_locally`](super::filter_locally), and [`FilterError::Clear`].
///
/// # Cost
/// Besides that of [`filter_locally`](super::filter_locally) a gradient of the indicator for each waypoint of a window
/// and step, and a value for each share of a step that is tried.
///
/// # Example
/// ```
/// use curvlay_trajectory::indicator::IndicatorFn;
/// use curvlay_trajectory::{Bounds, ClearOf, FilterOptions, FreeRange, LadderNode, Posture, RobotFn, filter_clear_of};
/// use std::ops::ControlFlow;
/// // Two joints share a sine; the second may not go below -0.3, and with least jerk it would.
/// let joints = |i: usize, free: f64| [(0.3 * i as f64).sin() + free, -free];
/// let robot = RobotFn {
///     waypoints: 60,
///     free: [FreeRange::Turn],
///     solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, joints(i, free[0])),
///     posture: |i: usize, free: &[f64; 1], _| Some(Posture { joints: joints(i, free[0]), rates: [[1.0, -1.0]] }),
/// };
/// let times: Vec<f64> = (0..60).map(|i| 0.2 * f64::from(i)).collect();
/// let start: Vec<_> = (0..60).map(|i| LadderNode { joints: joints(i, 0.0), free: [0.0], branch: 0 }).collect();
/// let low = IndicatorFn { value: |q: &[f64; 2]| -0.3 - q[1], gradient: |q: &[f64; 2]| (-0.3 - q[1], [0.0, -1.0]) };
/// let clear = ClearOf { indicator: &low, clear: 0.0 };
/// let bounds = Bounds { jerk: [0.5; 2], ..Bounds::NONE };
/// let options = FilterOptions::default();
/// let filtered = filter_clear_of(&robot, &times, &start, &bounds, &clear, &options, &|_| ControlFlow::Continue(()))?;
/// assert!(filtered.jerk[1] < 0.9 * filtered.jerk[0] && filtered.collisions.is_empty());
/// assert!(filtered.nodes.iter().all(|node| node.joints[1] >= -0.3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn filter_clear_of<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    robot: &R,
    times: &[f64],
    start: &[LadderNode<N, F>],
    bounds: &Bounds<N>,
    clear: &ClearOf<'_, N>,
    options: &FilterOptions<N>,
    progress: ProgressFn<'_>,
) -> Result<Filtered<N, F>, FilterError> {
    if !clear.clear.is_finite() {
        return Err(FilterError::Clear(clear.clear));
    }
    filter(&robot, times, start, (bounds, Some(*clear)), options, progress)
}
