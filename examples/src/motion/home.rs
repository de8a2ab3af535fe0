//! Where the programs of a print begin and end.

use super::PrintingCell;
use crate::outcome::Failure;
use curvlay_kinematics::workcell::Workcell;
use curvlay_trajectory::Progress;
use curvlay_trajectory::print::{Fault, FaultKind, PrintLimits, PrintOptions, PrintPlan, PrintRobot, Run};
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// What is reported where no home posture is found.
pub const NO_HOME: &str =
    "no home posture is free above the part: programs are not written; `home_deg` in the workcell names one";

/// The home posture: that of the workcell (`home_deg`), or else one above the part ([`PrintPlan::home_above`]). `None` without
/// any.
///
/// # Arguments
/// * `cell`: the workcell before anything is built.
///
/// # Errors
/// The posture of the workcell touches something when all layers are there; the work was stopped.
pub fn home<const N: usize, const F: usize, W: Workcell<N, F>>(
    plan: &PrintPlan<N, F>,
    robot: &impl PrintRobot<N, F>,
    cell: &PrintingCell<'_, N, F, W>,
    (limits, options): (&PrintLimits<N>, &PrintOptions<N, F>),
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Option<[f64; N]>, Failure> {
    let Some(home) = cell.workcell().equipment().home::<N>() else {
        return Ok(plan.home_above(robot, cell.clone(), limits, options, progress)?);
    };
    let mut built = cell.clone();
    for layer in &plan.layers {
        built.begin_and_build(layer.layer).map_err(Failure::new)?;
    }
    match built.in_the_way(&home) {
        Some(what) => {
            Err(Failure::new(format!("home_deg of the workcell: {what} touch there with the whole part on the plate")))
        }
        None => Ok(Some(home)),
    }
}

/// The plan cut into programs that begin and end at home: see [`home`] and [`PrintPlan::with_homes`]. Without a home posture all runs are
/// left out, each with a fault.
///
/// # Errors
/// As of those.
pub fn from_home<const N: usize, const F: usize, W: Workcell<N, F>>(
    plan: &PrintPlan<N, F>,
    cuts: &BTreeSet<usize>,
    robot: &impl PrintRobot<N, F>,
    cell: PrintingCell<'_, N, F, W>,
    (limits, options): (&PrintLimits<N>, &PrintOptions<N, F>),
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<PrintPlan<N, F>, Failure> {
    if let Some(home) = home(plan, robot, &cell, (limits, options), progress)? {
        return Ok(plan.with_homes(robot, cell, &home, cuts, limits, options, progress)?);
    }
    let mut without = plan.without(&(0..plan.segments(0..plan.runs.len()).count()).collect());
    let unprinted = |run: &Run<N, F>| Fault {
        layer: run.layer,
        path: run.path,
        kind: FaultKind::NoTransfer,
        waypoint: 0,
        what: NO_HOME.to_owned(),
    };
    without.faults.extend(plan.runs.iter().map(unprinted));
    Ok(without)
}
