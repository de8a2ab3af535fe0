//! What an arm is really like: least squares over measured poses.
//!
//! A target on the flange (a reflector, a probe, a sphere) is measured by a device that stands beside the arm, in many
//! postures. With the arm as built ([`ArmDeviation`]), `world_target = world_base * forward(joints) * flange_target`, where
//! the first and the last pose are unknown as well. Gauss-Newton's method with the geometric Jacobian (a shift along `u` moves the
//! target by `u`; a turn about `u` through `c` by `u x (p - c)`, and turns it by `u`) finds them all; it begins at the nominal arm,
//! with frames from a linear system.
//!
//! B. Mooring, Z. Roth, M. Driels, *Fundamentals of Manipulator Calibration*, Wiley 1991: six axes with full poses
//! determine 30 numbers, 12 of them the two frames. The other 18 are the [`ArmParameter`]s of each family here: four between two
//! axes in a row, less the two that the base takes up. Joint 1 and joint 6 have no offset of their own for the same reason: that of
//! joint 1 is in `world_base`, that of joint 6 in `flange_target`.
//!
//! Which of them the poses determine follows from the singular values of the Jacobian, with lengths in millimetres and angles
//! in millimetres at the end of the longest link: they are how far the target moves, as a root mean square, for a unit. A
//! direction along which it hardly moves is open: nothing moves along it, and the result names the parameters.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 6.2.1, asks for this and has no
//! equations.

use super::data::{ArmFit, FitError, FitOptions, FitResiduals, MeasuredPose};
use super::first_frames::first_frames;
use super::least_squares::{Problem, Solved, State, residuals};
use super::parameters::{ArmParameter, ORTHO, UR};
use crate::arm::{Arm, ArmDeviation, ArmError, ArmModel};

/// Finds an arm from measured poses.
///
/// # Arguments
/// * `nominal`: the arm by its published numbers.
/// * `poses`: spread over the whole reach, all joints far to both sides. Twice as many as [`FitError::TooFew`] asks for leave
///   something for the residuals to say.
///
/// # Errors
/// [`FitError`]; poses that leave numbers open are no error: see [`ArmFit::open`].
///
/// # Cost
/// `O(n)` for `n` poses, about 0.1 ms each.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
/// use curvlay_kinematics::{Arm, ArmDeviation, FitOptions, MeasuredPose, fit_arm, robots};
/// // Joint 3 is off its zero by 0.01 rad, and the tracker stands somewhere.
/// let mut deviation = ArmDeviation::none();
/// deviation.offsets[2] = 0.01;
/// let built = Arm::calibrated(&robots::UR5, &deviation)?;
/// let (world_base, target) = (Isometry3::translation(2000.0, -500.0, 300.0), Isometry3::translation(30.0, 0.0, 60.0));
/// let measured = |k: i32| {
///     let joints = [1, 2, 3, 4, 5, 6].map(|j| 1.5 * f64::from(k * j * j % 17 - 8) / 8.0);
///     let pose = world_base * built.forward(&joints) * target;
///     MeasuredPose { joints, position: pose.translation.vector.into(), rotation: Some(pose.rotation) }
/// };
/// let poses: Vec<MeasuredPose> = (1..=16).map(measured).collect();
/// let fit = fit_arm(&robots::UR5, &poses, &FitOptions::default())?;
/// assert!(fit.before.rms_mm() > 1.0 && fit.after.rms_mm() < 1e-6 && fit.open.is_empty());
/// assert!((fit.deviation.offsets[2] - 0.01).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fit_arm(nominal: &ArmModel, poses: &[MeasuredPose], options: &FitOptions) -> Result<ArmFit, FitError> {
    let arm = Arm::new(nominal)?;
    let mut problem = Problem::new(nominal, &arm, poses, options)?;
    let frames = first_frames(poses, &arm, problem.lever_mm);
    let mut guess =
        State { deviation: ArmDeviation::none(), world_base: frames[0], flange_target: frames[1], values: vec![] };
    // The frames that fit the nominal arm best, for a fair residual.
    problem.solve(&mut guess, options.max_iterations)?;
    let before = problem.residuals(&guess)?;
    let family: &[ArmParameter] = if arm.is_ur() { &UR } else { &ORTHO };
    problem.parameters = family.iter().copied().filter(|parameter| parameter.is_in(options.scope)).collect();
    problem.check_count()?;
    guess.values = vec![0.0; problem.parameters.len()];
    let solved = problem.solve(&mut guess, options.max_iterations)?;
    let after = problem.residuals(&guess)?;
    let (parameters, open) = problem.judged(&guess)?;
    let State { deviation, world_base, flange_target, .. } = guess;
    let Solved { iterations, is_converged, .. } = solved;
    Ok(ArmFit { deviation, world_base, flange_target, parameters, open, before, after, iterations, is_converged })
}

/// How far measured targets are from computed ones, for poses that a fit has not seen.
///
/// # Errors
/// [`ArmError`] for a deviation that makes no arm.
pub fn fit_residuals(nominal: &ArmModel, fit: &ArmFit, poses: &[MeasuredPose]) -> Result<FitResiduals, ArmError> {
    let arm = Arm::calibrated(nominal, &fit.deviation)?;
    Ok(residuals(&arm, &fit.world_base, &fit.flange_target, poses))
}
