//! What a program for a dome in the hand does, move by move, by the speeds and targets that stand in it.
//!
//! The counterpart of [`print_on_dome`](super::print_on_dome), and a judge of it: it knows the rig and the arm, and nothing of the plan. Pass it the
//! steps of a program that was read back.

use super::rig::DomeRig;
use crate::arm::Arm;
use crate::program::check::Clock;
use crate::program::{Goal, Move, Step, Target};
use nalgebra::{Isometry3, Point3, Translation3};

/// Pieces of a move in which the speed of the nozzle is taken: between two targets the flange goes straight and turns evenly, and the
/// nozzle, seen from the platform, does neither.
const PIECES: u32 = 8;

/// Joints 1 to 5 change by less from one target to the next, in radians; more is another posture.
const SAME_POSTURE: f64 = 0.3;

/// What a program does.
#[derive(Clone, Debug, PartialEq)]
pub struct DomeRun {
    /// Seconds of all moves, plunges and ways between strokes included, at the speeds of the program. Accelerations and the loading of modules are
    /// not counted.
    pub seconds: f64,
    /// Seconds of the moves with the extruder on.
    pub printing_s: f64,
    /// How far the nozzle goes over the platform with the extruder on, in millimetres.
    pub printed_mm: f64,
    /// Least and greatest speed of the nozzle over the platform with the extruder on, mm/s, between targets as well; 0 and 0 if nothing is
    /// printed.
    pub speed_mm_s: [f64; 2],
    /// The speed of the filament, or of the extruder, times the seconds with the extruder on: of a speed in turns a minute, 60 times the turns.
    pub fed: f64,
    /// The same times the way of the nozzle, in millimetres.
    pub fed_mm: f64,
    /// Straight moves whose configuration data differ from those of the straight move before.
    pub conf_changes: usize,
    /// Straight moves that end out of reach, or in another posture than they begin in.
    pub lost: usize,
    /// The greatest speed of a joint in a straight move, as a share of its limit.
    pub joint_speed: f64,
    /// For each time the extruder was on.
    pub strokes: Vec<StrokeRun>,
}

/// A stroke of a program: from where the extruder goes on to where it goes off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokeRun {
    /// Seconds before it: away from the stroke before, to below this one, and up to it.
    pub before_s: f64,
    /// Seconds of it.
    pub printing_s: f64,
    /// Joints at its end, if each straight move goes on to the nearest joints, as a controller does with `ConfL\Off`.
    pub joints: [f64; 6],
}

/// Follows the steps of a program whose poses are those of the flange in the base, `tool0` and `wobj0`.
///
/// The nozzle goes over the platform as the flange moves straight and turns evenly from target to target; corners that are rounded are
/// taken as sharp. Joints are followed from those of the last move to joints; before one, straight moves count as [`lost`](DomeRun::lost).
///
/// # Cost
/// About three microseconds a move.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
/// use curvlay_kinematics::program::{DomeOptions, DomeRig, DomeStroke, print_on_dome, run_on_dome};
/// use curvlay_kinematics::{Arm, robots};
/// let (rig, arm, options) = (DomeRig::BROOKS, Arm::new(&robots::IRB120)?, DomeOptions::default());
/// // A ring around the pole: the flange turns, and stands still.
/// let at = |k: u32| {
///     let a = f64::from(k).to_radians();
///     (Point3::new(9.0 * a.cos(), 9.0 * a.sin(), 149.0), UnitVector3::new_normalize(Vector3::new(0.1 * a.cos(), 0.1 * a.sin(), 1.0)))
/// };
/// let ring = DomeStroke { points: (0..=360).map(at).collect(), closed: true, feed: 4.0, above: 0.0 };
/// let print = print_on_dome(&rig, &arm, &[ring], &options);
/// let run = run_on_dome(&rig, &arm, print.steps(&options));
/// assert!(run.speed_mm_s.iter().all(|speed| (speed - 20.0).abs() < 0.02));
/// // 30 mm up to the ring and down again, at 10 mm/s.
/// assert!((run.printing_s - run.printed_mm / 20.0).abs() < 1e-2 && (run.seconds - run.printing_s - 6.0).abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn run_on_dome(rig: &DomeRig, arm: &Arm, steps: impl IntoIterator<Item = Step>) -> DomeRun {
    let mut follower = Follower {
        rig,
        arm,
        clock: Clock::default(),
        run: DomeRun {
            seconds: 0.0,
            printing_s: 0.0,
            printed_mm: 0.0,
            speed_mm_s: [f64::INFINITY, 0.0],
            fed: 0.0,
            fed_mm: 0.0,
            conf_changes: 0,
            lost: 0,
            joint_speed: 0.0,
            strokes: Vec::new(),
        },
        is_on: false,
        feed: 0.0,
        pose: None,
        joints: None,
        last_line: None,
        since: 0.0,
    };
    for step in steps {
        follower.pass(&step);
    }
    let mut run = follower.run;
    run.speed_mm_s[0] = run.speed_mm_s[0].min(run.speed_mm_s[1]);
    run
}

struct Follower<'a> {
    rig: &'a DomeRig,
    arm: &'a Arm,
    clock: Clock,
    run: DomeRun,
    is_on: bool,
    feed: f64,
    /// Where the flange is.
    pose: Option<Isometry3<f64>>,
    joints: Option<[f64; 6]>,
    /// The move before, if it was straight.
    last_line: Option<Target>,
    /// When the extruder was switched last.
    since: f64,
}

impl Follower<'_> {
    fn pass(&mut self, step: &Step) {
        let before = self.clock.seconds;
        let arm = self.arm;
        self.clock.pass(step, &|joints: &[f64; 6], _| Some(arm.forward(joints)));
        let seconds = self.clock.seconds - before;
        self.run.seconds = self.clock.seconds;
        match step {
            Step::Move(Move { goal: Goal::Line(target), .. }) => {
                if let Some(from) = self.pose.filter(|_| self.is_on && seconds > 0.0) {
                    self.print(&from, &target.pose, seconds);
                }
                self.run.conf_changes += usize::from(self.last_line.is_some_and(|last| last.conf != target.conf));
                self.follow(&target.pose, seconds);
                (self.pose, self.last_line) = (Some(target.pose), Some(*target));
            }
            Step::Move(Move { goal: Goal::JointMove(target), .. }) => {
                self.joints = self.joints.and_then(|near| arm.continuing(&target.pose, &near));
                (self.pose, self.last_line) = (Some(target.pose), None);
            }
            Step::Move(Move { goal: Goal::Joints(joints), .. }) | Step::Servo { joints, .. } => {
                (self.pose, self.joints, self.last_line) = (Some(arm.forward(joints)), Some(*joints), None);
            }
            Step::Extruder(on) => {
                let passed = self.run.seconds - self.since;
                if *on && !self.is_on {
                    let joints = self.joints.unwrap_or_default();
                    self.run.strokes.push(StrokeRun { before_s: passed, printing_s: 0.0, joints });
                    self.since = self.run.seconds;
                } else if let Some(stroke) = self.run.strokes.last_mut().filter(|_| self.is_on && !*on) {
                    (stroke.printing_s, stroke.joints) = (passed, self.joints.unwrap_or(stroke.joints));
                    self.since = self.run.seconds;
                }
                self.is_on = *on;
            }
            Step::FilamentSpeed(feed) => self.feed = *feed,
            Step::Signal { .. } | Step::Wait(_) => {}
        }
    }

    /// A move with the extruder on.
    fn print(&mut self, from: &Isometry3<f64>, to: &Isometry3<f64>, seconds: f64) {
        let mut length = 0.0;
        let mut last = self.on_platform(from);
        for k in 1..=PIECES {
            // Of half a turn there is no one way; it counts at its end.
            let pose = from.try_lerp_slerp(to, f64::from(k) / f64::from(PIECES), 1e-9).unwrap_or(*to);
            let at = self.on_platform(&pose);
            let way = (at - last).norm();
            let speed = way * f64::from(PIECES) / seconds;
            let [slowest, fastest] = self.run.speed_mm_s;
            self.run.speed_mm_s = [slowest.min(speed), fastest.max(speed)];
            length += way;
            last = at;
        }
        self.run.printing_s += seconds;
        self.run.printed_mm += length;
        self.run.fed += self.feed * seconds;
        self.run.fed_mm += self.feed * length;
    }

    /// The tip of the nozzle in the frame of the platform.
    fn on_platform(&self, base_flange: &Isometry3<f64>) -> Point3<f64> {
        let flange_platform = Translation3::new(0.0, 0.0, -self.rig.effector);
        (base_flange * flange_platform).inverse_transform_point(&self.rig.contact())
    }

    /// Goes on to the nearest joints.
    fn follow(&mut self, pose: &Isometry3<f64>, seconds: f64) {
        let next = self.joints.and_then(|near| Some((near, self.arm.continuing(pose, &near)?)));
        let Some((near, joints)) = next else {
            self.run.lost += 1;
            return;
        };
        let is_same = self.arm.branch(&joints) == self.arm.branch(&near)
            || (0..5).all(|joint| (joints[joint] - near[joint]).abs() <= SAME_POSTURE);
        self.run.lost += usize::from(!is_same);
        if seconds > 0.0 {
            let velocity = self.arm.limits().velocity;
            let shares = (0..6).map(|joint| (joints[joint] - near[joint]).abs() / seconds / velocity[joint]);
            self.run.joint_speed = shares.fold(self.run.joint_speed, f64::max);
        }
        self.joints = Some(joints);
    }
}
