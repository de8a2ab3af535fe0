//! A robot made of closures.

use crate::robot::{FreeRange, Posture, Robot};

/// A [`Robot`] made of two closures, for kinematics that know nothing of this crate.
///
/// Solutions that collide are left out by the closures; then no planner meets them.
/// ```
/// use curvlay_trajectory::{FreeRange, Posture, Robot, RobotFn};
/// // One joint that is the tool angle itself.
/// let robot = RobotFn {
///     waypoints: 7,
///     free: [FreeRange::Turn],
///     solutions: |_: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 1])| each(0, *free),
///     posture: |_: usize, free: &[f64; 1], _: u32| Some(Posture { joints: *free, rates: [[1.0]] }),
/// };
/// assert_eq!(robot.posture(3, &[0.5], 0).map(|p| p.joints), Some([0.5]));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RobotFn<const F: usize, S, P> {
    /// Number of waypoints.
    pub waypoints: usize,
    /// What the free parameters may be.
    pub free: [FreeRange; F],
    /// As [`Robot::solutions`].
    pub solutions: S,
    /// As [`Robot::posture`].
    pub posture: P,
}

impl<const N: usize, const F: usize, S, P> Robot<N, F> for RobotFn<F, S, P>
where
    S: Fn(usize, &[f64; F], &mut dyn FnMut(u32, [f64; N])) + Sync,
    P: Fn(usize, &[f64; F], u32) -> Option<Posture<N, F>> + Sync,
{
    fn waypoints(&self) -> usize {
        self.waypoints
    }

    fn free(&self) -> [FreeRange; F] {
        self.free
    }

    fn solutions(&self, waypoint: usize, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N])) {
        (self.solutions)(waypoint, free, each);
    }

    fn posture(&self, waypoint: usize, free: &[f64; F], branch: u32) -> Option<Posture<N, F>> {
        (self.posture)(waypoint, free, branch)
    }
}
