//! Where the bodies of a robot are, and how they move with its joints.
//!
//! Frames are rotation matrices with a place, not quaternions: every frame turns several points.

use nalgebra::{IsometryMatrix3, Point3, Vector3};

/// How a joint moves what it carries: the velocity of a point `p` in the world is `linear + angular x p`, a radian (or a
/// millimetre) of the joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// Angular velocity.
    pub angular: Vector3<f64>,
    /// Velocity of what is at the world's origin.
    pub linear: Vector3<f64>,
}

impl Twist {
    /// A joint that turns about an axis through a point, by the right hand.
    pub fn turning(point: &Point3<f64>, axis: &Vector3<f64>) -> Self {
        Twist { angular: *axis, linear: point.coords.cross(axis) }
    }

    /// A joint that slides along an axis.
    pub fn sliding(axis: &Vector3<f64>) -> Self {
        Twist { angular: Vector3::zeros(), linear: *axis }
    }

    /// The velocity of a point of the world.
    pub fn velocity(&self, point: &Point3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(&point.coords)
    }
}

/// The forward kinematics that an indicator needs, for a robot of `N` joints: the place of point `p` of body `b` is
/// `frames[b] * p`, and joint `k` moves it by `twists[k].velocity(..)` if it carries the body.
pub trait Bodies<const N: usize>: Sync {
    /// The number of bodies. Things that stand still in the world are a body too.
    fn count(&self) -> usize;

    /// Which joints carry a body, whatever the posture.
    fn carriers(&self, body: usize) -> [bool; N];

    /// Writes `world_body` of every body at these joints; `frames` has [`Bodies::count`] places.
    fn place(&self, joints: &[f64; N], frames: &mut [IsometryMatrix3<f64>]);

    /// The same, and how each joint moves what it carries.
    fn place_moving(&self, joints: &[f64; N], frames: &mut [IsometryMatrix3<f64>]) -> [Twist; N];
}

/// Bodies made of closures.
/// ```
/// use curvlay_trajectory::indicator::geometric::{Bodies, BodiesFn, Twist};
/// use curvlay_trajectory::nalgebra::{IsometryMatrix3, Point3, Vector3};
/// // The world, and an arm that turns about z.
/// let arm = BodiesFn {
///     carriers: vec![[false], [true]],
///     place: |q: &[f64; 1], frames: &mut [IsometryMatrix3<f64>]| frames[1] = IsometryMatrix3::rotation(Vector3::z() * q[0]),
///     twists: |_: &[f64; 1], _: &[IsometryMatrix3<f64>]| [Twist::turning(&Point3::origin(), &Vector3::z())],
/// };
/// let mut frames = [IsometryMatrix3::identity(); 2];
/// let [twist] = arm.place_moving(&[std::f64::consts::FRAC_PI_2], &mut frames);
/// let tip = frames[1] * Point3::new(100.0, 0.0, 0.0);
/// assert!((tip - Point3::new(0.0, 100.0, 0.0)).norm() < 1e-12);
/// assert!((twist.velocity(&tip) - Vector3::new(-100.0, 0.0, 0.0)).norm() < 1e-12);
/// ```
#[derive(Clone, Debug)]
pub struct BodiesFn<const N: usize, P, T> {
    /// Which joints carry each body.
    pub carriers: Vec<[bool; N]>,
    /// Writes the frames; those left alone are the world's.
    pub place: P,
    /// How the joints move, from joints and frames.
    pub twists: T,
}

impl<const N: usize, P, T> Bodies<N> for BodiesFn<N, P, T>
where
    P: Fn(&[f64; N], &mut [IsometryMatrix3<f64>]) + Sync,
    T: Fn(&[f64; N], &[IsometryMatrix3<f64>]) -> [Twist; N] + Sync,
{
    fn count(&self) -> usize {
        self.carriers.len()
    }

    fn carriers(&self, body: usize) -> [bool; N] {
        self.carriers.get(body).copied().unwrap_or([false; N])
    }

    fn place(&self, joints: &[f64; N], frames: &mut [IsometryMatrix3<f64>]) {
        (self.place)(joints, frames);
    }

    fn place_moving(&self, joints: &[f64; N], frames: &mut [IsometryMatrix3<f64>]) -> [Twist; N] {
        (self.place)(joints, frames);
        (self.twists)(joints, frames)
    }
}
