//! Check of a whole print, as it is executed: limits, rest, joins, deviation from the path, contact, collisions.
//!
//! The print is plain data: motions one after the other, each with times and joints at its knots. What is judged is the
//! C2 cubic spline through them, at rest at both ends, which is what a robot executes. It is computed here, from the
//! knots alone; no code is shared with the planners or with [`crate::Trajectory`], so a fault there does not hide itself.
//!
//! - **Limits** hold or fail everywhere on the spline: the jerk of a piece is constant, so the extremes of position,
//!   velocity and acceleration have closed forms, and so has the time above a limit.
//! - **Rest.** The spline begins and ends with velocity 0 by construction; with an acceleration other than 0 it jumps.
//! - **Joins.** A motion begins where and not before the one before ends.
//! - **Deviation and contact** are looked at in samples, between which the tip moves by at most
//!   [`CheckOptions::sample_mm`] and the axis turns by at most [`CheckOptions::sample_rad`]. Between two samples the tip is about half
//!   a `sample_mm` from the nearer one, so the true deviation is larger than the reported one by no more than that. A place on the nozzle at
//!   the distance `r` from the tip moves by up to `sample_mm + sample_rad r`, so it may be deeper in something than reported by half of that: with the
//!   defaults 0.05 mm at the tip, 0.09 mm at 10 mm above it.
//! - **Sweeps.** Each piece goes to the caller's proof as a Bezier control polygon.
//!
//! A path is followed forward only: the nearest place is searched from the current one on, within
//! [`CheckOptions::window_mm`] of path, so other parts of it that pass nearby do not confuse it. Each point must be
//! met when it is passed. Where the nozzle is farther away than the window, 50 windows are searched.
//! So where a part of the path longer than the window is left out, deviations grow to the window before the path is found
//! again, and some points after that part count as skipped, too.
//! Where points repeat a place with another axis, the first axis counts until the tip moves on.
//!
//! Knots closer than about a microsecond carry no information on accelerations (differences of rounded angles over the
//! square of the time), so merge them first.

mod curve;
mod follow;
mod limits;
mod report;
mod samples;
mod scene;
mod written;

pub use report::{Finding, FindingClass, FindingKind, JointPeaks, MotionReport, PrintPeak, PrintReport};
pub use scene::{Contact, Moment, PrintScene, PrintSceneFn};
pub use written::{FindingPlace, GrowingPrintScene, WrittenMotion, WrittenReport, check_written};

use crate::{Bounds, BoundsError, Progress};
use curve::Curve;
use nalgebra::{Point3, UnitVector3};
use report::Findings;
use std::ops::ControlFlow;

/// What a motion is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MotionKind {
    /// Follows a path.
    Print,
    /// Goes somewhere without printing: lift-off, transfer, approach.
    Travel,
}

/// A point of a path, in the frame of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Where the tip shall be, in millimetres.
    pub tip: Point3<f64>,
    /// The nozzle's axis, away from the tip.
    pub axis: UnitVector3<f64>,
    /// When the motion is said to pass it, in seconds, if that is known. Then the nozzle is not taken to be beyond it
    /// earlier: in a spike both legs are equally near.
    pub passed_s: Option<f64>,
}

/// A motion of a print: the C2 cubic spline through its knots, at rest at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckedMotion<'a, const N: usize> {
    /// What it is for.
    pub kind: MotionKind,
    /// Times of the knots, rising, in seconds; all motions have one clock.
    pub times: &'a [f64],
    /// Joints at the knots.
    pub joints: &'a [[f64; N]],
    /// What a print follows, in order, straight from one point to the next; empty for travels.
    pub path: &'a [PathPoint],
    /// From when to when the path is followed; `None` means from begin to end. Before is run-in, after run-out, where
    /// the nozzle may be anywhere. Not looked at for travels.
    pub printing: Option<[f64; 2]>,
    /// Declares that the robot is brought to the begin of this motion by other means, so a gap before it is no finding.
    pub apart: bool,
}

impl<const N: usize> CheckedMotion<'_, N> {
    fn span(&self) -> [f64; 2] {
        [self.times.first().copied().unwrap_or(0.0), self.times.last().copied().unwrap_or(0.0)]
    }
}

/// What is tolerated, and how dense samples are.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct CheckOptions {
    /// Share by which a velocity, acceleration or jerk may pass its limit. Times and angles written with few digits need
    /// more: an error `e` of an angle makes up to about `12 e / h^3` of jerk on a piece of `h` seconds.
    pub slack: f64,
    /// By how much a position may pass its limit, in radians.
    pub position_slack: f64,
    /// Largest acceleration at begin and end of a motion, in rad/s^2.
    pub max_end_acceleration: f64,
    /// How far from the end of the motion before a joint may begin, in radians.
    pub max_gap: f64,
    /// How long before the end of the motion before a motion may begin, in seconds; rounding of written times.
    pub max_overlap_s: f64,
    /// Farthest move of the tip between two samples, in millimetres.
    pub sample_mm: f64,
    /// Farthest turn of the nozzle's axis between two samples, in radians.
    pub sample_rad: f64,
    /// How far ahead on the path the nearest place is searched, in millimetres; at least `sample_mm`. A longer window
    /// confuses legs of a path that are nearer to each other than the nozzle is off; a shorter one loses the path where
    /// corners are cut.
    pub window_mm: f64,
    /// Largest distance of the tip from the path, and from each path point when it is passed, in millimetres.
    pub max_deviation_mm: f64,
    /// Largest angle between nozzle and axis of the path, in radians.
    pub max_angle: f64,
    /// Deepest contact, in millimetres.
    pub max_depth_mm: f64,
}

impl Default for CheckOptions {
    /// Limits with a millionth of slack, 1e-3 rad/s^2 at rest, gaps of 1e-6 rad, overlaps of 1e-6 s; samples 0.1 mm and
    /// half a degree apart, a window of 2 mm; 0.1 mm off the path, 2 degrees off its axis, no contact.
    fn default() -> Self {
        CheckOptions {
            slack: 1e-6,
            position_slack: 1e-6,
            max_end_acceleration: 1e-3,
            max_gap: 1e-6,
            max_overlap_s: 1e-6,
            sample_mm: 0.1,
            sample_rad: 0.5_f64.to_radians(),
            window_mm: 2.0,
            max_deviation_mm: 0.1,
            max_angle: 2.0_f64.to_radians(),
            max_depth_mm: 0.0,
        }
    }
}

impl CheckOptions {
    fn check(&self) -> Result<(), CheckError> {
        let tolerances = [
            ("slack", self.slack, 0.0),
            ("position_slack", self.position_slack, 0.0),
            ("max_end_acceleration", self.max_end_acceleration, 0.0),
            ("max_gap", self.max_gap, 0.0),
            ("max_overlap_s", self.max_overlap_s, 0.0),
            ("sample_mm", self.sample_mm, f64::MIN_POSITIVE),
            ("sample_rad", self.sample_rad, f64::MIN_POSITIVE),
            ("window_mm", self.window_mm, self.sample_mm),
            ("max_deviation_mm", self.max_deviation_mm, 0.0),
            ("max_angle", self.max_angle, 0.0),
            ("max_depth_mm", self.max_depth_mm, 0.0),
        ];
        match tolerances.into_iter().find(|&(_, value, least)| !(value.is_finite() && value >= least)) {
            Some((what, value, min)) => Err(CheckError::Option { what, value, min }),
            None => Ok(()),
        }
    }
}

/// Why a print cannot be checked. What is wrong with a motion itself is a [`Finding`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CheckError {
    /// A motion has fewer than two knots.
    #[error("motion {motion} has {knots} knots, 2 are needed")]
    TooFewKnots {
        /// The motion, counted from 0.
        motion: usize,
        /// Its knots.
        knots: usize,
    },
    /// Not as many times as joints.
    #[error("motion {motion} has {times} times for {joints} knots")]
    Count {
        /// The motion, counted from 0.
        motion: usize,
        /// Its times.
        times: usize,
        /// Its joint positions.
        joints: usize,
    },
    /// A time is infinite or not a number.
    #[error("motion {motion}: the time of knot {knot} is {time}, not a finite number")]
    Time {
        /// The motion, counted from 0.
        motion: usize,
        /// The knot, counted from 0.
        knot: usize,
        /// Its time.
        time: f64,
    },
    /// A time is not after the one before.
    #[error("motion {motion}: the time of knot {knot} is {time} s, not after {before} s of the one before")]
    NotRising {
        /// The motion, counted from 0.
        motion: usize,
        /// The knot, counted from 0.
        knot: usize,
        /// Its time.
        time: f64,
        /// The time of the knot before.
        before: f64,
    },
    /// An angle is infinite or not a number.
    #[error("motion {motion}: joint {} at knot {knot} is {value}, not a finite number", joint + 1)]
    Angle {
        /// The motion, counted from 0.
        motion: usize,
        /// The knot, counted from 0.
        knot: usize,
        /// The joint, counted from 0.
        joint: usize,
        /// Its angle.
        value: f64,
    },
    /// Two knots are so close in time that the spline between them has no finite derivatives.
    #[error("motion {motion}: knots {knot} and {} are too close in time", knot + 1)]
    TooClose {
        /// The motion, counted from 0.
        motion: usize,
        /// The first of the two, counted from 0.
        knot: usize,
    },
    /// A print without a path, or a travel with one.
    #[error("motion {motion} is a {kind:?} with {points} path points")]
    PathLength {
        /// The motion, counted from 0.
        motion: usize,
        /// What it is for.
        kind: MotionKind,
        /// Its path points.
        points: usize,
    },
    /// A path point has a coordinate that is infinite or not a number.
    #[error("motion {motion}: path point {point} has an invalid coordinate")]
    PathPoint {
        /// The motion, counted from 0.
        motion: usize,
        /// The point, counted from 0.
        point: usize,
    },
    /// A path is followed from later to earlier, or at times beyond the motion.
    #[error("motion {motion}: prints from {from} s to {to} s, but goes from {begin} s to {end} s")]
    Printing {
        /// The motion, counted from 0.
        motion: usize,
        /// When the path begins.
        from: f64,
        /// When the path ends.
        to: f64,
        /// When the motion begins.
        begin: f64,
        /// When the motion ends.
        end: f64,
    },
    /// A motion along a path, or to a waypoint of it, that there is not, or from a later waypoint to an earlier one.
    #[error("motion {motion}: path {path} has no waypoint {waypoint}, or it is passed in the wrong order")]
    NoWaypoint {
        /// The motion, counted from 0.
        motion: usize,
        /// Its path.
        path: usize,
        /// The waypoint.
        waypoint: usize,
    },
    /// The scene cannot add a layer.
    #[error("layer {layer} cannot be added: {why}")]
    Layer {
        /// The layer, counted from 0.
        layer: u32,
        /// Why, in words.
        why: String,
    },
    /// Limits that nothing can keep.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// An option is out of range.
    #[error("option {what} is {value}: it must be finite and {min} at least")]
    Option {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its least value.
        min: f64,
    },
    /// The progress callback cancelled the check.
    #[error("the check was cancelled")]
    Cancelled,
}

/// Checks a whole print, motion by motion.
///
/// # Arguments
/// * `motions`: in the order of time. None at all is a sound print.
/// * `bounds`: limits of the joints.
/// * `scene`: kinematics, contact and sweeps.
/// * `progress`: called before each motion, in units of motions; may stop the work.
///
/// # Errors
/// [`CheckError`] for motions that are no print, invalid limits or options, and when `progress` returns `Break`. That a print is
/// faulty is no error: [`PrintReport::findings`].
///
/// # Cost
/// Linear in the knots for limits. Besides one sweep a piece, and one pose and one contact a sample: two samples a piece at least.
/// Deterministic. To use several threads call [`check_motion`] for each motion and [`PrintReport::of`] with all reports.
///
/// # Example
/// ```
/// use curvlay_trajectory::Bounds;
/// use curvlay_trajectory::check::{CheckOptions, CheckedMotion, Contact, Moment, MotionKind, PathPoint};
/// use curvlay_trajectory::check::{FindingKind, PrintSceneFn, check_print};
/// use curvlay_trajectory::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
/// use std::ops::ControlFlow;
///
/// // An axis that carries the nozzle along x, 10 mm a radian: jerk 3, -3, -3, 3 rad/s^3.
/// let times = [0.0, 1.0, 2.0, 3.0, 4.0];
/// let joints = [[0.0], [0.5], [3.0], [5.5], [6.0]];
/// let point = |x| PathPoint { tip: Point3::new(x, 0.0, 0.0), axis: Vector3::z_axis(), passed_s: None };
/// let path = [point(0.0), point(60.0)];
/// let motion = CheckedMotion {
///     kind: MotionKind::Print, times: &times, joints: &joints, path: &path, printing: None, apart: false,
/// };
/// let scene = PrintSceneFn {
///     nozzle: |q: &[f64; 1]| Some(Isometry3::translation(10.0 * q[0], 0.0, 0.0)),
///     // A block from x = 50 mm on.
///     contact: |_: &Moment, tip: &Point3<f64>, _: &UnitVector3<f64>| {
///         (tip.x > 50.0).then(|| Contact { depth_mm: tip.x - 50.0, what: "the block".into() })
///     },
///     sweep: |_: usize, _: usize, _: &[[f64; 1]; 4]| None,
/// };
/// let bounds = Bounds { velocity: [4.0], acceleration: [5.0], jerk: [5.0], ..Bounds::NONE };
/// let report = check_print(&[motion], &bounds, &scene, &CheckOptions::default(), &|_| ControlFlow::Continue(()))?;
/// assert!((report.joints[0].velocity.value - 3.0).abs() < 1e-12 && report.joints[0].velocity.time == 2.0);
/// assert!((report.joints[0].jerk.value.abs() - 3.0).abs() < 1e-12 && report.deviation.unwrap().value < 1e-12);
/// let [finding] = &report.findings[..] else { panic!("one finding") };
/// assert!(matches!(finding.kind, FindingKind::Contact { depth_mm, .. } if depth_mm == 10.0));
/// assert!(finding.to_string().starts_with("motion 0 at 4.000 s: the nozzle is 10.000 mm deep in the block"));
/// # Ok::<(), curvlay_trajectory::check::CheckError>(())
/// ```
pub fn check_print<const N: usize>(
    motions: &[CheckedMotion<N>],
    bounds: &Bounds<N>,
    scene: &(impl PrintScene<N> + ?Sized),
    options: &CheckOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<PrintReport<N>, CheckError> {
    options.check()?;
    bounds.check()?;
    let mut reports = Vec::with_capacity(motions.len());
    for (done, motion) in motions.iter().enumerate() {
        let total = motions.len();
        if progress(Progress { stage: "check", done: done as u64, total: total as u64 }).is_break() {
            return Err(CheckError::Cancelled);
        }
        reports.push(check_motion(done, motion, bounds, scene, options)?);
    }
    Ok(PrintReport::of(&reports, options))
}

/// Checks one motion by itself: all but how it joins the one before, which [`PrintReport::of`] does.
///
/// # Arguments
/// * `number`: of the motion in the print, counted from 0; for reports, errors and `scene`.
/// * The rest is as for [`check_print`].
///
/// # Errors
/// As [`check_print`].
///
/// # Cost
/// As [`check_print`]. Deterministic; memory is linear in the knots.
pub fn check_motion<const N: usize>(
    number: usize,
    motion: &CheckedMotion<N>,
    bounds: &Bounds<N>,
    scene: &(impl PrintScene<N> + ?Sized),
    options: &CheckOptions,
) -> Result<MotionReport<N>, CheckError> {
    options.check()?;
    bounds.check()?;
    check_data(number, motion)?;
    let curve = Curve::new(motion.times, motion.joints);
    if let Some(knot) = curve.overflow() {
        return Err(CheckError::TooClose { motion: number, knot });
    }
    let mut findings = Findings::default();
    let rates = limits::check(number, &curve, bounds, options, &mut findings);
    let followed = samples::check(number, motion, &curve, scene, options, &mut findings);
    Ok(MotionReport {
        motion: number,
        kind: motion.kind,
        apart: motion.apart,
        span: motion.span(),
        ends: [motion.joints[0], motion.joints[motion.joints.len() - 1]],
        findings: findings.in_order(),
        joints: rates.joints,
        deviation: followed.deviation,
        tilt: followed.tilt,
        depth: followed.depth,
        seconds_over_acceleration: rates.seconds_over_acceleration,
        seconds_over_jerk: rates.seconds_over_jerk,
        pieces: curve.pieces(),
        samples: followed.samples,
    })
}

fn check_data<const N: usize>(motion: usize, checked: &CheckedMotion<N>) -> Result<(), CheckError> {
    let CheckedMotion { kind, times, joints, path, printing, .. } = *checked;
    if times.len() != joints.len() {
        return Err(CheckError::Count { motion, times: times.len(), joints: joints.len() });
    }
    if times.len() < 2 {
        return Err(CheckError::TooFewKnots { motion, knots: times.len() });
    }
    for (knot, (&time, angles)) in times.iter().zip(joints).enumerate() {
        if !time.is_finite() {
            return Err(CheckError::Time { motion, knot, time });
        }
        if knot > 0 && time <= times[knot - 1] {
            return Err(CheckError::NotRising { motion, knot, time, before: times[knot - 1] });
        }
        if let Some(joint) = angles.iter().position(|angle| !angle.is_finite()) {
            return Err(CheckError::Angle { motion, knot, joint, value: angles[joint] });
        }
    }
    if path.is_empty() == (kind == MotionKind::Print) {
        return Err(CheckError::PathLength { motion, kind, points: path.len() });
    }
    let sound = |point: &PathPoint| point.tip.iter().chain(point.axis.iter()).all(|x| x.is_finite());
    if let Some(point) = path.iter().position(|point| !sound(point)) {
        return Err(CheckError::PathPoint { motion, point });
    }
    let [begin, end] = checked.span();
    if let (Some([from, to]), MotionKind::Print) = (printing, kind)
        && !(begin <= from && from <= to && to <= end)
    {
        return Err(CheckError::Printing { motion, from, to, begin, end });
    }
    Ok(())
}
