//! What a run found.

use super::demo::Truth;
use curvlay_examples::findings::Findings;
use curvlay_kinematics::nalgebra::Point3;
use curvlay_kinematics::workcell::WorkcellModel;
use curvlay_kinematics::{ArmFit, Calibration, FitResiduals, Measurements};

/// The arm as it was found.
pub struct FoundArm {
    pub fit: ArmFit,
    /// Of a fit to three quarters of the poses: how many the others are, and how far they are off.
    pub unseen: Option<(usize, FitResiduals)>,
}

/// What a run found.
pub struct Run {
    pub model: WorkcellModel,
    pub measured: Measurements,
    pub truth: Option<Truth>,
    pub arm: Option<FoundArm>,
    pub tool: Option<Calibration>,
    /// The nozzle's tip before.
    pub old_tip: Point3<f64>,
    pub is_closed_form: bool,
    pub findings: Findings,
}
