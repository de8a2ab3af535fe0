//! What the planners ask of a robot that follows waypoints.
//!
//! A waypoint fixes the tip and the tool's axis. What it leaves free is `F` numbers: the turn about the tool's axis
//! (an arm of six axes, `F = 1`), the two joints of a table besides (`F = 3`), a tilt within a cone (two more). With
//! them, the joints follow in closed form, once for each branch. C. Dai, *Material Deposition in 3D Space*
//! (dissertation, TU Delft 2020), section 4.3.1: `theta` is `free`, `q` is `joints`.

/// The values that a free parameter may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreeRange {
    /// An angle: values a whole turn apart are one.
    Turn,
    /// From the first to the second, both included.
    Within(f64, f64),
}

impl FreeRange {
    /// Whether there are values in it: it is finite, and does not end before it begins.
    pub(crate) fn is_sound(self) -> bool {
        match self {
            FreeRange::Turn => true,
            FreeRange::Within(least, most) => least <= most && (most - least).is_finite(),
        }
    }

    /// How many samples are different: as many as wanted, but one where the range holds a single value, such as the tilt of a table that only
    /// turns.
    pub(crate) fn samples(self, wanted: u32) -> u32 {
        match self {
            FreeRange::Within(least, most) if most <= least => wanted.min(1),
            FreeRange::Turn | FreeRange::Within(..) => wanted,
        }
    }
}

/// Joints at a waypoint, and how they follow the free parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture<const N: usize, const F: usize> {
    /// The joints, in radians, in `(-pi, pi]` where a joint turns farther.
    pub joints: [f64; N],
    /// `rates[f][j]`: derivative of joint `j` by free parameter `f`.
    pub rates: [[f64; N]; F],
}

/// A robot with a path of waypoints before it: inverse kinematics with `F` numbers left free.
///
/// Branches are numbered by the robot; one number means one smooth sheet of solutions away from singularities.
pub trait Robot<const N: usize, const F: usize>: Sync {
    /// Number of waypoints.
    fn waypoints(&self) -> usize;

    /// What the free parameters may be.
    fn free(&self) -> [FreeRange; F];

    /// Calls `each` with the branch and the joints of every solution at a waypoint, in ascending order of branches.
    fn solutions(&self, waypoint: usize, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N]));

    /// The solution on one branch with its derivatives; `None` out of reach and where there is no derivative.
    fn posture(&self, waypoint: usize, free: &[f64; F], branch: u32) -> Option<Posture<N, F>>;
}

/// So that a planner takes any robot and is compiled once: of `robot: &R` a `&robot` is a `&dyn Robot`.
impl<const N: usize, const F: usize, R: Robot<N, F> + ?Sized> Robot<N, F> for &R {
    fn waypoints(&self) -> usize {
        (**self).waypoints()
    }

    fn free(&self) -> [FreeRange; F] {
        (**self).free()
    }

    fn solutions(&self, waypoint: usize, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N])) {
        (**self).solutions(waypoint, free, each);
    }

    fn posture(&self, waypoint: usize, free: &[f64; F], branch: u32) -> Option<Posture<N, F>> {
        (**self).posture(waypoint, free, branch)
    }
}
