//! What planning asks of the robot, and of the workcell around it.

use crate::indicator::CollisionIndicator;
use crate::robot::{FreeRange, Posture, Robot};
use crate::transfer::FreeSpace;
use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};

/// Where the nozzle shall be, in the frame of what carries the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// The tip, in millimetres.
    pub position: Point3<f64>,
    /// The axis of the nozzle, away from the tip.
    pub axis: UnitVector3<f64>,
}

impl Waypoint {
    /// The waypoint at which a nozzle stands: its tip, and its z axis.
    pub fn of_nozzle(nozzle: &Isometry3<f64>) -> Self {
        let axis = UnitVector3::new_normalize(nozzle.rotation * Vector3::z());
        Waypoint { position: Point3::from(nozzle.translation.vector), axis }
    }

    /// The same waypoint in another frame.
    pub fn moved(&self, frame: &Isometry3<f64>) -> Self {
        let axis = UnitVector3::new_unchecked(frame.rotation * self.axis.into_inner());
        Waypoint { position: frame * self.position, axis }
    }
}

/// A robot by itself, without a path: kinematics between joints and the nozzle on the part.
///
/// `N` joints, `F` free parameters: see [`Robot`], which is a robot with a path before it. [`OnPath`] makes one of this.
pub trait PrintRobot<const N: usize, const F: usize>: Sync {
    /// What the free parameters may be.
    fn free(&self) -> [FreeRange; F];

    /// Calls `each` with the branch and the joints of every solution at a waypoint, in ascending order of branches.
    fn solutions(&self, waypoint: &Waypoint, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N]));

    /// The solution on one branch with its derivatives; `None` out of reach and where there is no derivative.
    fn posture(&self, waypoint: &Waypoint, free: &[f64; F], branch: u32) -> Option<Posture<N, F>>;

    /// The nozzle in the frame of what carries the part, z away from the tip; `None` where the joints have no pose.
    fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>>;

    /// The solution nearest to `near` with the tool turned about the nozzle by `turn` radians, and the free parameters otherwise
    /// as `free` has them or as they are at `near`. `None` out of reach.
    fn continued(&self, waypoint: &Waypoint, free: &[f64; F], turn: f64, near: &[f64; N]) -> Option<[f64; N]>;
}

/// A [`PrintRobot`] made of closures, for kinematics that know nothing of this crate.
#[derive(Clone, Copy, Debug)]
pub struct PrintRobotFn<const F: usize, S, P, T, C> {
    /// What the free parameters may be.
    pub free: [FreeRange; F],
    /// As [`PrintRobot::solutions`].
    pub solutions: S,
    /// As [`PrintRobot::posture`].
    pub posture: P,
    /// As [`PrintRobot::nozzle`].
    pub nozzle: T,
    /// As [`PrintRobot::continued`].
    pub continued: C,
}

impl<const N: usize, const F: usize, S, P, T, C> PrintRobot<N, F> for PrintRobotFn<F, S, P, T, C>
where
    S: Fn(&Waypoint, &[f64; F], &mut dyn FnMut(u32, [f64; N])) + Sync,
    P: Fn(&Waypoint, &[f64; F], u32) -> Option<Posture<N, F>> + Sync,
    T: Fn(&[f64; N]) -> Option<Isometry3<f64>> + Sync,
    C: Fn(&Waypoint, &[f64; F], f64, &[f64; N]) -> Option<[f64; N]> + Sync,
{
    fn free(&self) -> [FreeRange; F] {
        self.free
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N])) {
        (self.solutions)(waypoint, free, each);
    }

    fn posture(&self, waypoint: &Waypoint, free: &[f64; F], branch: u32) -> Option<Posture<N, F>> {
        (self.posture)(waypoint, free, branch)
    }

    fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>> {
        (self.nozzle)(joints)
    }

    fn continued(&self, waypoint: &Waypoint, free: &[f64; F], turn: f64, near: &[f64; N]) -> Option<[f64; N]> {
        (self.continued)(waypoint, free, turn, near)
    }
}

/// A [`PrintRobot`] with a path before it.
#[derive(Debug)]
pub struct OnPath<'a, R> {
    /// The robot.
    pub robot: &'a R,
    /// The path.
    pub waypoints: &'a [Waypoint],
}

impl<const N: usize, const F: usize, R: PrintRobot<N, F>> Robot<N, F> for OnPath<'_, R> {
    fn waypoints(&self) -> usize {
        self.waypoints.len()
    }

    fn free(&self) -> [FreeRange; F] {
        self.robot.free()
    }

    fn solutions(&self, waypoint: usize, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N])) {
        self.robot.solutions(&self.waypoints[waypoint], free, each);
    }

    fn posture(&self, waypoint: usize, free: &[f64; F], branch: u32) -> Option<Posture<N, F>> {
        self.robot.posture(&self.waypoints[waypoint], free, branch)
    }
}

/// How much distance a posture keeps from what it must not touch, beyond the margin of motions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Clearance {
    /// Enough for a smooth motion to leave the straight way between two waypoints, and for the arm to leave the path.
    Wide,
    /// Less, for paths that cannot be followed otherwise.
    Narrow,
    /// As little as proofs need.
    Least,
}

impl Clearance {
    /// All of them, the widest first.
    pub const ALL: [Clearance; 3] = [Clearance::Wide, Clearance::Narrow, Clearance::Least];
}

/// What of the print stands when a nozzle is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// A path is printed up to one of its waypoints.
    At {
        /// The path, by its place in the list.
        path: usize,
        /// The waypoint of the path.
        waypoint: usize,
    },
    /// A path is printed whole, and the next one is not begun.
    After {
        /// The path, by its place in the list.
        path: usize,
    },
}

/// The workcell with the layers that are built so far: what touches, and what gouges.
///
/// It has two states: *printing*, in which the nozzle may touch the part and the plate (how deep is asked by
/// [`PrintWorkcell::is_gouging`]), and *moving*, in which nothing may touch anything. The indicator
/// ([`CollisionIndicator`]) speaks of printing, [`FreeSpace`] of moving. Answers must depend on the arguments and on the
/// layers that were added alone. A clone is made for each layer, so that layers are planned side by side.
pub trait PrintWorkcell<const N: usize>: CollisionIndicator<N> + FreeSpace<N> + Clone + Send {
    /// A layer is about to be printed: while printing, it is there from now on.
    ///
    /// # Errors
    /// Why it cannot be added, in words.
    fn begin(&mut self, layer: u32) -> Result<(), String>;

    /// While moving, a layer is there from now on.
    ///
    /// # Errors
    /// Why it cannot be added, in words.
    fn build(&mut self, layer: u32) -> Result<(), String>;

    /// Whether a posture keeps so much clearance while printing.
    fn keeps(&self, joints: &[f64; N], clearance: Clearance) -> bool;

    /// What does not keep even the least clearance at a posture while printing, in words; `None` where all does.
    fn obstacle(&self, joints: &[f64; N]) -> Option<String>;

    /// What may touch while printing, somewhere on a cubic piece of a motion, given by its Bezier control polygon in
    /// joint space; `None` only if the piece is proven free.
    fn touches(&self, control: &[[f64; N]; 4]) -> Option<String>;

    /// Whether the nozzle is too deep in what is built at some moment.
    fn is_gouging(&self, moment: Moment, nozzle: &Waypoint) -> bool;
}

/// A workcell in which nothing is in the way: motions keep limits and path, and collisions are not looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpenWorkcell;

impl<const N: usize> CollisionIndicator<N> for OpenWorkcell {
    fn value(&self, _: &[f64; N]) -> f64 {
        f64::NEG_INFINITY
    }

    fn gradient(&self, _: &[f64; N]) -> (f64, [f64; N]) {
        (f64::NEG_INFINITY, [0.0; N])
    }
}

impl<const N: usize> FreeSpace<N> for OpenWorkcell {
    fn free(&self, _: &[f64; N], _: &[f64; N]) -> bool {
        true
    }
}

impl<const N: usize> PrintWorkcell<N> for OpenWorkcell {
    fn begin(&mut self, _: u32) -> Result<(), String> {
        Ok(())
    }

    fn build(&mut self, _: u32) -> Result<(), String> {
        Ok(())
    }

    fn keeps(&self, _: &[f64; N], _: Clearance) -> bool {
        true
    }

    fn obstacle(&self, _: &[f64; N]) -> Option<String> {
        None
    }

    fn touches(&self, _: &[[f64; N]; 4]) -> Option<String> {
        None
    }

    fn is_gouging(&self, _: Moment, _: &Waypoint) -> bool {
        false
    }
}
