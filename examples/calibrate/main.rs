//! What a robot is really like: the tip of its tool from touches of one point, its zeros, lengths and axes from measured poses, and
//! the workcell with both.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 6.2.1, asks for both; B. Mooring, Z. Roth, M. Driels,
//! *Fundamentals of Manipulator Calibration* (Wiley 1991).
//! ```sh
//! cargo run --release --example calibrate
//! cargo run --release --example calibrate -- measurements.csv --workcell cell.json --fit lengths
//! ```
//! Without a file of measurements they are made in code: a UR10 with known errors, a tracker and a probe with noise, so that what is found can be
//! compared with what was put in. `kinematics/docs/measurements.md` describes the file. `--help` lists the options.

mod args;
mod demo;
mod found;
mod outputs;

pub use args::{Args, Fit};
use curvlay_examples::args::{Failure, Outcome, run_with_args};
use curvlay_examples::bars::Bars;
use curvlay_examples::count::counted;
use curvlay_examples::findings::{Findings, Severity};
use curvlay_examples::input;
use curvlay_examples::motion::link_mesh;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::waypoints::fault;
use curvlay_kinematics::nalgebra::{Isometry3, Point3};
use curvlay_kinematics::workcell::{AnyWorkcell, CalibrationModel, Held, WorkcellModel};
use curvlay_kinematics::{
    Arm, ArmFit, ArmModel, Calibration, FitOptions, FitResiduals, FitScope, MeasuredPose, Measurements, Touch,
    calibrate_tool, fit_arm, fit_residuals,
};
use demo::Truth;
use found::{FoundArm, Run};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// A quarter of the poses is held back from a first fit, to see what it is worth at poses that it has not seen.
const HELD_BACK: usize = 4;
/// A pose this many times the root mean square off is likely a mistake.
const OUTLIER: f64 = 4.0;
/// With poses that were not seen this many times worse, there are too few of them for so many numbers.
const OVERFITTED: f64 = 1.5;
/// Touches that amplify their errors more than this are turned too little.
const POOR_TOUCHES: f64 = 5.0;

fn main() -> ExitCode {
    run_with_args(|args: Args| {
        let inputs = [args.file.as_deref(), args.workcell.as_deref()];
        let folder = args.common.folder("calibrate", inputs, outputs::is_ours)?;
        let (run, outcome) = work(&args, &Bars::new(args.common.quiet), &folder)?;
        curvlay_examples::table::Table::print_all(&outputs::tables(&run))?;
        Ok(outcome)
    })
}

/// Calibrates and writes the files.
pub fn work(args: &Args, bars: &Bars, folder: &OutputFolder) -> Result<(Run, Outcome), Failure> {
    let start = Instant::now();
    let (model, cell) = workcell(args)?;
    let given = args.file.as_deref().map(read).transpose()?;
    folder.clear(outputs::is_ours)?;
    let (measured, truth) = match given {
        Some(measured) => (measured, None),
        None => {
            let (measured, truth) = demo::measure(args, &cell)?;
            (measured, Some(truth))
        }
    };
    let mut run = calibrate(args, model, &cell, measured, truth, bars)?;
    bars.finish();
    outputs::write(args, &run, folder, start.elapsed())?;
    run.findings.say();
    let outcome = run.findings.outcome();
    Ok((run, outcome))
}

/// The workcell, as it is before.
fn workcell(args: &Args) -> Result<(WorkcellModel, AnyWorkcell), Failure> {
    const UR10_CELL: &str = include_str!("../cells/ur10.json");
    let Some(path) = &args.workcell else {
        let model = WorkcellModel::from_json(UR10_CELL.as_bytes())?;
        return Ok((model.clone(), AnyWorkcell::new(model)?));
    };
    let text = input::read(path, input::MAX_SETTINGS_BYTES)?;
    let model = WorkcellModel::from_json(&text[..]).map_err(|error| fault(path, &error))?;
    let beside = path.parent().unwrap_or(Path::new("."));
    let cell = AnyWorkcell::with_link_meshes(model.clone(), &mut |file| link_mesh(beside, file));
    Ok((model, cell.map_err(|error| fault(path, &error))?))
}

fn read(path: &Path) -> Result<Measurements, Failure> {
    let bytes = input::read(path, input::MAX_SETTINGS_BYTES)?;
    let is_table = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
    let measured = if is_table { Measurements::from_csv(&bytes[..]) } else { Measurements::from_json(&bytes[..]) };
    let measured = measured.map_err(|error| fault(path, &error))?;
    if measured.touches.is_empty() && measured.poses.is_empty() {
        return Err(fault(path, &"no touches and no poses: there is nothing to calibrate by"));
    }
    Ok(measured)
}

fn calibrate(
    args: &Args,
    mut model: WorkcellModel,
    cell: &AnyWorkcell,
    measured: Measurements,
    truth: Option<Truth>,
    bars: &Bars,
) -> Result<Run, Failure> {
    let named = |error: &dyn std::fmt::Display| match &args.file {
        Some(path) => fault(path, error),
        None => Failure::new(error.to_string()),
    };
    let mut findings = Findings::default();
    let nominal = cell.equipment().arm_model();
    let scope = match args.fit {
        Fit::Offsets => FitScope::Offsets,
        Fit::Lengths => FitScope::Lengths,
        Fit::All => FitScope::All,
    };
    let options = FitOptions { scope, radian_mm: args.radian_mm, open: args.open, ..FitOptions::default() };
    let arm = if measured.poses.is_empty() {
        findings.add(Severity::Note, "there are no measured poses: the arm stays as it is", "", "");
        None
    } else {
        bars.update("arm", 0, 1);
        let fit = fit_arm(nominal, &measured.poses, &options).map_err(|error| named(&error))?;
        let unseen = check_on_unseen(nominal, &measured.poses, &options);
        model.arm.calibration = Some(CalibrationModel::from(&fit.deviation));
        find_in_arm(args, &fit, unseen.as_ref(), &mut findings);
        Some(FoundArm { fit, unseen })
    };
    // The arm as fitted: touches by joints are placed by it.
    let built = match &arm {
        Some(found) => Arm::calibrated(nominal, &found.fit.deviation)?,
        None => *cell.equipment().arm(),
    };
    let old_tip = Point3::from(model.nozzle.tip_mm);
    let tool = if measured.touches.is_empty() {
        findings.add(Severity::Note, "there are no touches: the tip of the nozzle stays where it is", "", "");
        None
    } else {
        bars.update("tool", 0, 1);
        find_in_touches(&measured.touches, arm.is_some(), &mut findings);
        let flanges: Vec<Isometry3<f64>> = measured.touches.iter().map(|touch| touch.base_flange(&built)).collect();
        let tool = calibrate_tool(&flanges).map_err(|error| named(&error))?;
        // With the part in the hand a pin on the flange touches the nozzle, which stands still.
        let tip = if model.held == Held::Part { tool.base_mark } else { tool.flange_tip };
        model.nozzle.tip_mm = tip.into();
        find_in_tool(args, &tool, &mut findings);
        Some(tool)
    };
    find_in_built(&built, &mut findings);
    Ok(Run { model, measured, truth, arm, tool, old_tip, is_closed_form: built.is_closed_form(), findings })
}

/// Touches that do not know the arm as found.
fn find_in_touches(touches: &[Touch], has_fit: bool, findings: &mut Findings) {
    let by_flange = touches.iter().filter(|touch| matches!(touch, Touch::Flange(_))).count();
    if by_flange > 0 && has_fit {
        let what = "touches are given by the flange as the controller shows it, which does not know the arm as found";
        findings
            .explain(Severity::Warning, what, by_flange.to_string(), "")
            .try_to("give these touches by their joints");
    }
}

/// An arm whose targets a controller with nominal lengths does not reach.
fn find_in_built(built: &Arm, findings: &mut Findings) {
    if !built.is_closed_form() && !built.is_ur() {
        findings
            .explain(Severity::Note, "programs with targets reach the measured places only on a controller that knows the arm as built", "", "")
            .cause("a controller with nominal lengths computes its joints from targets; ABB calls one that knows better Absolute Accuracy")
            .try_to("--fit lengths, and its lengths and offsets in the controller");
    }
}

/// A fit to three quarters of the poses, at the others; none where so few do not determine it.
fn check_on_unseen(nominal: &ArmModel, poses: &[MeasuredPose], options: &FitOptions) -> Option<(usize, FitResiduals)> {
    let is_held = |k: usize| k % HELD_BACK == HELD_BACK - 1;
    let part = |held: bool| -> Vec<MeasuredPose> {
        poses.iter().enumerate().filter(|(k, _)| is_held(*k) == held).map(|(_, pose)| *pose).collect()
    };
    let (seen, held) = (part(false), part(true));
    let fit = fit_arm(nominal, &seen, options).ok().filter(|fit| fit.open.is_empty())?;
    let residuals = fit_residuals(nominal, &fit, &held).ok()?;
    (!held.is_empty()).then_some((held.len(), residuals))
}

fn find_in_arm(args: &Args, fit: &ArmFit, unseen: Option<&(usize, FitResiduals)>, findings: &mut Findings) {
    if !fit.is_converged {
        findings.add(
            Severity::Failed,
            "the fit of the arm did not converge",
            format!("after {}", counted(fit.iterations, "iteration")),
            "",
        );
    }
    let rms = fit.after.rms_mm();
    if rms > args.allow_residual_mm {
        findings
            .explain(
                Severity::Failed,
                "the arm as found does not meet the poses",
                format!("{rms:.3} mm (root mean square)"),
                "residuals.csv",
            )
            .cause("poses or joints of another arm, units, or a target that moved on the flange")
            .try_to(if args.fit == Fit::All { "" } else { "--fit all" })
            .allow(format!("--allow-residual {:.1}", (rms * 10.0).ceil() / 10.0));
    }
    for open in &fit.open {
        let names: Vec<String> = open.parameters.iter().map(ToString::to_string).collect();
        findings
            .explain(
                Severity::Warning,
                "the poses leave a combination of numbers open, which stays as it is",
                names.join(", "),
                format!("errors grow {:.0} times", open.amplification),
            )
            .try_to("poses in which the joints before and behind these turn far to both sides");
    }
    let outliers: Vec<String> = fit
        .after
        .positions_mm
        .iter()
        .enumerate()
        .filter(|(_, off)| **off > OUTLIER * rms)
        .map(|(k, off)| format!("{} ({off:.2} mm)", k + 1))
        .collect();
    if !outliers.is_empty() {
        findings
            .explain(Severity::Warning, "poses are far off the others", outliers.join(", "), "residuals.csv")
            .try_to("measure them again, or leave them out");
    }
    find_in_unseen(rms, unseen, findings);
}

/// How a fit to some of the poses meets the others.
fn find_in_unseen(rms: f64, unseen: Option<&(usize, FitResiduals)>, findings: &mut Findings) {
    match unseen {
        Some((count, unseen)) if unseen.rms_mm() > OVERFITTED * rms => {
            let amount = format!("{:.3} mm at {count} of them, {rms:.3} mm at the others", unseen.rms_mm());
            findings
                .explain(Severity::Warning, "poses that a fit has not seen are met less well", amount, "")
                .try_to("more poses, spread over the whole reach")
                .try_to("--fit lengths");
        }
        Some(_) => {}
        None => {
            findings
                .explain(Severity::Warning, "no poses could be held back to try the fit on", "", "")
                .try_to("more poses: those that are there are needed to determine the arm");
        }
    }
}

fn find_in_tool(args: &Args, tool: &Calibration, findings: &mut Findings) {
    if tool.rms > args.allow_residual_mm {
        findings
            .explain(
                Severity::Failed,
                "the touches do not agree on a point",
                format!("{:.3} mm (root mean square)", tool.rms),
                "residuals.csv",
            )
            .try_to("calibrate the arm by measured poses first, in the same file")
            .allow(format!("--allow-residual {:.1}", (tool.rms * 10.0).ceil() / 10.0));
    }
    if tool.amplification > POOR_TOUCHES {
        findings
            .explain(
                Severity::Warning,
                "the touches are turned little against each other",
                format!("an error of touching grows {:.1} times", tool.amplification),
                "",
            )
            .try_to("touch in postures that are turned further, about two axes");
    }
    let off = tool.residuals.iter().enumerate().filter(|(_, off)| **off > OUTLIER * tool.rms);
    for (k, off) in off {
        findings.add(
            Severity::Warning,
            "a touch is far off the others",
            format!("number {} by {off:.2} mm", k + 1),
            "residuals.csv",
        );
    }
}
