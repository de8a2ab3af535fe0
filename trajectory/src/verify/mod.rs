//! For reproducing the verification of C. Dai's dissertation (section 4.3.3); prints use [`print`](mod@crate::print) and [`check`](crate::check).
//!
//! Verification: every waypoint and the motion between any two, against an exact check; and repair of what collides.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.3.3, which checks waypoints. Here the
//! motions between them are checked too, best by a proof for each as a whole. What is exact is the caller's to say, by
//! closures that get the index of the waypoint they look at: a part grows while it is printed.

mod dense;
mod repair;

pub use dense::{Checks, DENSE_STEP, dense_postures, repair_by_turning};
pub use repair::{Repair, RepairError, RepairOptions, repair};

use crate::{Progress, ProgressFn};

/// What collides.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Verification {
    /// Waypoints that collide, in order.
    pub waypoints: Vec<usize>,
    /// Motions that are not shown to be free, in order: `i` is that from waypoint `i` to `i + 1`. Motions to and from a
    /// waypoint that collides are not among them, and were not checked.
    pub motions: Vec<usize>,
}

impl Verification {
    /// Whether nothing collides.
    pub fn is_free(&self) -> bool {
        self.waypoints.is_empty() && self.motions.is_empty()
    }
}

/// Why a trajectory was not verified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// The progress callback cancelled the verification.
    #[error("cancelled")]
    Cancelled,
}

/// Waypoints between two calls of the progress callback.
const STRIDE: usize = 64;

/// Checks every waypoint, and the motion from each to the next.
///
/// # Arguments
/// * `posture_free(i, joints)`: whether waypoint `i` is free.
/// * `motion_free(i, from, to)`: whether the motion from waypoint `i` to `i + 1` is; whatever it is, straight or a
///   spline. Asked only where both ends are free.
///
/// # Errors
/// [`VerifyError::Cancelled`] when `progress` returns `Break`.
///
/// # Cost
/// One call of each a waypoint.
///
/// # Example
/// ```
/// use curvlay_trajectory::verify::verify;
/// use std::ops::ControlFlow;
/// let waypoints = [[0.0], [1.0], [2.0], [5.0], [6.0]];
/// let free = |_: usize, q: &[f64; 1]| q[0] < 5.5;
/// let passes = |_: usize, from: &[f64; 1], to: &[f64; 1]| !(from[0] < 4.0 && to[0] > 4.0);
/// let found = verify(&waypoints, &free, &passes, &|_| ControlFlow::Continue(()))?;
/// assert_eq!((found.waypoints, found.motions), (vec![4], vec![2]));
/// # Ok::<(), curvlay_trajectory::verify::VerifyError>(())
/// ```
pub fn verify<const N: usize>(
    waypoints: &[[f64; N]],
    posture_free: &(impl Fn(usize, &[f64; N]) -> bool + ?Sized),
    motion_free: &(impl Fn(usize, &[f64; N], &[f64; N]) -> bool + ?Sized),
    progress: ProgressFn<'_>,
) -> Result<Verification, VerifyError> {
    let mut found = Verification::default();
    let total = waypoints.len() as u64;
    let mut before = false;
    for (i, joints) in waypoints.iter().enumerate() {
        let done = i as u64;
        if i % STRIDE == 0 && progress(Progress { stage: "verify", done, total }).is_break() {
            return Err(VerifyError::Cancelled);
        }
        let free = posture_free(i, joints);
        if !free {
            found.waypoints.push(i);
        } else if before && !motion_free(i - 1, &waypoints[i - 1], joints) {
            found.motions.push(i - 1);
        }
        before = free;
    }
    Ok(found)
}
