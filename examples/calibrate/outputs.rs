//! What the example leaves behind: tables on stdout, `summary.json`, `workcell.json`, `residuals.csv`, `report.html`, and the measurements that were
//! made in code.

use super::demo::Truth;
use super::{Args, FoundArm, Run};
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::count::counted;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::plot::Plot;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_kinematics::nalgebra::Point3;
use curvlay_kinematics::workcell::{BodiesModel, Held};
use curvlay_kinematics::{ArmDeviation, ArmFit, ArmParameter, Calibration};
use std::io::{self, Write};
use std::path::Path;
use std::time::Duration;

const WORKCELL: &str = "workcell.json";
const MEASUREMENTS: &str = "measurements.csv";
const RESIDUALS: &str = "residuals.csv";

pub fn is_ours(name: &str) -> bool {
    [WORKCELL, MEASUREMENTS, RESIDUALS, "report.html"].contains(&name)
}

pub fn write(args: &Args, run: &Run, folder: &OutputFolder, time: Duration) -> Result<(), Failure> {
    if run.truth.is_some() {
        let mut table = vec![];
        run.measured.write_csv(&mut table)?;
        folder.write(MEASUREMENTS, table)?;
    }
    let mut cell = run.model.clone();
    if let (Some(BodiesModel::Meshes(meshes)), Some(path)) = (&mut cell.arm.bodies, &args.workcell) {
        // Meshes are found from the folder of the workcell, which is another one now.
        let beside = std::path::absolute(path.parent().unwrap_or(Path::new(".")))?;
        meshes.iter_mut().for_each(|mesh| mesh.file = beside.join(&mesh.file).to_string_lossy().into_owned());
    }
    let mut file = vec![];
    cell.write_json(&mut file)?;
    folder.write(WORKCELL, file)?;
    folder.write_with(RESIDUALS, |out| residuals(run, out))?;
    folder.write("report.html", report(args, run).to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, run, time)?.write(folder)?;
    Ok(())
}

/// A line for each pose and each touch.
fn residuals(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "kind,number,before_mm,after_mm,after_deg")?;
    if let Some(FoundArm { fit, .. }) = &run.arm {
        let mut angles = fit.after.angles.iter();
        for (k, pose) in run.measured.poses.iter().enumerate() {
            let angle =
                pose.rotation.and_then(|_| angles.next()).map_or(String::new(), |a| format!("{:.6}", a.to_degrees()));
            let (before, after) = (fit.before.positions_mm[k], fit.after.positions_mm[k]);
            writeln!(out, "pose,{},{before:.6},{after:.6},{angle}", k + 1)?;
        }
    }
    for (k, off) in run.tool.iter().flat_map(|tool| &tool.residuals).enumerate() {
        writeln!(out, "touch,{},,{off:.6},", k + 1)?;
    }
    Ok(())
}

/// Millimetres, or degrees.
fn shown(parameter: &ArmParameter, value: f64) -> String {
    if parameter.is_angle() { format!("{:.4} deg", value.to_degrees()) } else { format!("{value:.4} mm") }
}

/// What was put in where a parameter stands, to first order: of tilts and shifts that are no parameters of their own the offset and
/// the length beside them have a part.
fn known(parameter: &ArmParameter, deviation: &ArmDeviation) -> f64 {
    match *parameter {
        ArmParameter::Offset(joint) => deviation.offsets[joint],
        ArmParameter::Shift { axis, coordinate, sign, .. } => {
            sign * deviation.axes[axis - 1].translation.vector[coordinate]
        }
        ArmParameter::Turn { axis, coordinate } => deviation.axes[axis - 1].rotation.scaled_axis()[coordinate],
    }
}

pub fn tables(run: &Run) -> Vec<Table> {
    let mut tables = vec![];
    if let Some(FoundArm { fit, unseen }) = &run.arm {
        let mut table =
            Table::new(["residuals of the arm", "root mean square mm", "greatest mm", "root mean square deg"]);
        let unseen = unseen.as_ref().map(|(count, unseen)| (format!("{count} poses that a fit has not seen"), unseen));
        let rows = [("nominal arm".to_owned(), &fit.before), ("calibrated arm".to_owned(), &fit.after)];
        for (name, residuals) in rows.into_iter().chain(unseen) {
            let angle = residuals.rms_angle().map_or("-".to_owned(), |angle| format!("{:.4}", angle.to_degrees()));
            table.row([name, format!("{:.4}", residuals.rms_mm()), format!("{:.4}", residuals.max_mm()), angle]);
        }
        tables.push(table);
        let mut table = Table::new(["number of the arm", "found", "standard error", "determined"]);
        for found in &fit.parameters {
            let determined = if found.is_determined { "yes" } else { "no" };
            let error = if found.standard_error.is_finite() {
                shown(&found.parameter, found.standard_error)
            } else {
                "-".to_owned()
            };
            table.row([
                found.parameter.to_string(),
                shown(&found.parameter, found.value),
                error,
                determined.to_owned(),
            ]);
        }
        tables.push(table);
    }
    if let Some(tool) = &run.tool {
        let mut table = Table::new(["tool", "x mm", "y mm", "z mm"]);
        let mut row = |name: &str, p: &Point3<f64>| {
            table.row([name.to_owned(), format!("{:.3}", p.x), format!("{:.3}", p.y), format!("{:.3}", p.z)]);
        };
        row("tip in the workcell before", &run.old_tip);
        row("tip by the touches", &run.model.nozzle.tip_mm.into());
        if let Some(truth) = &run.truth {
            row("tip that was put in", &truth.tip_by(run.arm.as_ref().map(|found| &found.fit)));
        }
        let is_part_held = run.model.held == Held::Part;
        row(
            if is_part_held { "pin on the flange" } else { "point that was touched, in the base" },
            if is_part_held { &tool.flange_tip } else { &tool.base_mark },
        );
        tables.push(table);
    }
    tables
}

fn summary(args: &Args, run: &Run, time: Duration) -> Result<Summary, Failure> {
    let mut summary = Summary::new();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("cell", run.model.name.as_str())?
        .set("fit", typed_name(args.fit))?
        .set("radian_mm", args.radian_mm)?
        .set("open", args.open)?
        .set("allow_residual_mm", args.allow_residual_mm)?
        .set("made_in_code", run.truth.is_some())?
        .set("poses", run.measured.poses.len())?
        .set("touches", run.measured.touches.len())?
        .set("threads", args.common.threads)?;
    if let Some(found) = &run.arm {
        of_arm(found, run.is_closed_form, &mut summary)?;
    }
    if let Some(tool) = &run.tool {
        of_tool(tool, run, &mut summary)?;
    }
    run.findings.summary(&mut summary)?;
    summary.set_seconds("total_s", time)?;
    Ok(summary)
}

/// The arm as found: how well it meets the poses, its numbers, and its base.
fn of_arm(FoundArm { fit, unseen }: &FoundArm, is_closed_form: bool, summary: &mut Summary) -> Result<(), Failure> {
    summary
        .set("arm_before_mm", fit.before.rms_mm())?
        .set("arm_after_mm", fit.after.rms_mm())?
        .set("arm_after_max_mm", fit.after.max_mm())?
        .set("iterations", fit.iterations)?
        .set("converged", fit.is_converged)?
        .set("closed_form", is_closed_form)?
        .set("determined", fit.parameters.iter().filter(|found| found.is_determined).count())?
        .set("parameters", fit.parameters.len())?
        .set("open_directions", fit.open.len())?;
    for (key, residuals) in [("before", &fit.before), ("after", &fit.after)] {
        if let Some(angle) = residuals.rms_angle() {
            summary.set(&format!("arm_{key}_deg"), angle.to_degrees())?;
        }
    }
    if let Some((count, unseen)) = unseen {
        summary.set("unseen_poses", *count)?.set("unseen_mm", unseen.rms_mm())?;
    }
    for found in &fit.parameters {
        let key: String = found.parameter.to_string().replace(' ', "_");
        let value = if found.parameter.is_angle() { found.value.to_degrees() } else { found.value };
        let unit = if found.parameter.is_angle() { "deg" } else { "mm" };
        summary.set(&format!("{key}_{unit}"), value)?;
    }
    let base = fit.world_base;
    let (roll, pitch, yaw) = base.rotation.euler_angles();
    let at = base.translation.vector;
    for (key, value) in [("x", at.x), ("y", at.y), ("z", at.z)] {
        summary.set(&format!("base_{key}_mm"), value)?;
    }
    for (key, value) in [("roll", roll), ("pitch", pitch), ("yaw", yaw)] {
        summary.set(&format!("base_{key}_deg"), value.to_degrees())?;
    }
    Ok(())
}

/// The tip of the tool as found.
fn of_tool(tool: &Calibration, run: &Run, summary: &mut Summary) -> Result<(), Failure> {
    summary.set("tool_rms_mm", tool.rms)?.set("tool_amplification", tool.amplification)?;
    for (axis, value) in ["x", "y", "z"].into_iter().zip(run.model.nozzle.tip_mm) {
        summary.set(&format!("tip_{axis}_mm"), value)?;
    }
    summary.set("tip_moved_mm", (Point3::from(run.model.nozzle.tip_mm) - run.old_tip).norm())?;
    if let Some(truth) = &run.truth {
        let put_in = truth.tip_by(run.arm.as_ref().map(|found| &found.fit));
        let off = (Point3::from(run.model.nozzle.tip_mm) - put_in).norm();
        summary.set("tip_off_truth_mm", off)?;
    }
    Ok(())
}

fn report(args: &Args, run: &Run) -> Report {
    let mut report = Report::new("Calibration of a robot and its tool");
    run.findings.report(&mut report);
    report.paragraph(&format!("Workcell: {}. The calibrated one is {WORKCELL}.", run.model.name));
    if run.truth.is_some() {
        report.paragraph(&format!(
            "The measurements were made in code ({MEASUREMENTS}, a file such as yours would be): an arm with known errors, {} measured with \
             noise of {} mm, and a point touched {} by hand.",
            counted(run.measured.poses.len(), "pose"),
            args.noise_mm,
            counted(run.measured.touches.len(), "time")
        ));
    }
    let tables = tables(run);
    let mut tables = tables.iter();
    if let Some(FoundArm { fit, .. }) = &run.arm {
        report_arm(fit, run, [tables.next(), tables.next()], &mut report);
    }
    if let Some(tool) = &run.tool {
        report.heading("The tool").paragraph(&format!(
            "{} touches of one point agree within {:.3} mm (root mean square, greatest {:.3}). An error of touching grows at most {:.2} times in the tip.",
            run.measured.touches.len(),
            tool.rms,
            tool.residuals.iter().copied().fold(0.0, f64::max),
            tool.amplification
        ));
        if let Some(table) = tables.next() {
            report.table("", table);
        }
    }
    report
}

/// The arm: how it was found, its residuals, its numbers, its base.
fn report_arm(fit: &ArmFit, run: &Run, [residuals, numbers]: [Option<&Table>; 2], report: &mut Report) {
    report.heading("The arm").paragraph(&format!(
            "Gauss-Newton's method over {}, {}: {} of {} numbers are determined. Before: the nominal arm, with base and target where they \
             fit it best. {}",
            counted(run.measured.poses.len(), "pose"),
            counted(fit.iterations, "iteration"),
            fit.parameters.iter().filter(|found| found.is_determined).count(),
            fit.parameters.len(),
            if run.is_closed_form {
                "The inverse of the arm as found is a closed form."
            } else {
                "The arm as found has no closed form: its inverse goes on from the nearest one by Newton's method, branch by branch."
            }
        ));
    if let Some(table) = residuals {
        report.table("", table);
    }
    report.plot("How far each measured target is from the computed one", &residual_plot(fit));
    if let Some(table) = numbers {
        match &run.truth {
                Some(truth) => report.table("", &beside_truth(fit, truth)).paragraph(
                        "Every axis was shifted and turned along all three coordinates. Those that are no numbers of their own come to the same as an \
                         offset or a length beside them, which are found as the sum; so compare residuals, not single numbers.",
                    ),
                None => report.table("", table),
            };
    }
    let (roll, pitch, yaw) = fit.world_base.rotation.euler_angles();
    let at = fit.world_base.translation.vector;
    report.paragraph(&format!(
            "The base of the arm, as the device has it: {:.3}, {:.3}, {:.3} mm; roll {:.4}, pitch {:.4}, yaw {:.4} degrees. The offset of joint 1 is part of this, that of joint 6 of the \
             target on the flange: poses cannot distinguish them.",
            at.x, at.y, at.z, roll.to_degrees(), pitch.to_degrees(), yaw.to_degrees()
        ));
}

/// How far the targets are from where the arm has them, before and after.
fn residual_plot(fit: &ArmFit) -> Plot {
    let line = |residuals: &[f64]| -> Vec<[f64; 2]> {
        residuals.iter().enumerate().map(|(k, off)| [k as f64 + 1.0, *off]).collect()
    };
    let mut plot = Plot::new("pose", "residual in mm, as a power of ten");
    let powers = |points: Vec<[f64; 2]>| points.into_iter().map(|[x, y]| [x, y.log10()]);
    plot.line("nominal arm", [176, 60, 50], powers(line(&fit.before.positions_mm))).line(
        "calibrated arm",
        [11, 122, 117],
        powers(line(&fit.after.positions_mm)),
    );
    plot
}

/// The numbers of the arm beside those that were put in.
fn beside_truth(fit: &ArmFit, truth: &Truth) -> Table {
    let mut with = Table::new(["number of the arm", "found", "standard error", "put in"]);
    for found in &fit.parameters {
        let put_in = shown(&found.parameter, known(&found.parameter, &truth.deviation));
        with.row([
            found.parameter.to_string(),
            shown(&found.parameter, found.value),
            shown(&found.parameter, found.standard_error),
            put_in,
        ]);
    }
    with
}
