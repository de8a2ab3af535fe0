//! Check of motions, one after the other.

use super::curve::Curve;
use super::data::{CheckedMotion, MotionKind, PathPoint};
use super::error::CheckError;
use super::options::CheckOptions;
use super::report::{Findings, MotionReport, PrintReport};
use super::scene::PrintScene;
use super::{limits, samples};
use crate::{Bounds, Progress, ProgressFn};

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
/// use curvlay_trajectory::check::{CheckOptions, CheckedMotion, Contact, FindingKind, Moment, MotionKind, PathPoint, PrintSceneFn, check_print};
/// use curvlay_trajectory::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
/// use std::ops::ControlFlow;
///
/// // An axis that carries the nozzle along x, 10 mm a radian: jerk 3, -3, -3, 3 rad/s^3.
/// let times = [0.0, 1.0, 2.0, 3.0, 4.0];
/// let joints = [[0.0], [0.5], [3.0], [5.5], [6.0]];
/// let point = |x| PathPoint { position: Point3::new(x, 0.0, 0.0), axis: Vector3::z_axis(), passed_s: None };
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
    progress: ProgressFn<'_>,
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
    let sound = |point: &PathPoint| point.position.iter().chain(point.axis.iter()).all(|x| x.is_finite());
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
