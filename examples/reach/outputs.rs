//! What the example leaves behind: the table on stdout, `summary.json`, `reach.csv` and `report.html`.

use super::Args;
use super::drawing::{build, picture};
use super::reaching::{Reached, TOOL_ANGLES, failed_checks, is_in_box};
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::output::OutputFolder;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_kinematics::nalgebra::Vector3;
use std::io::{self, Write};
use std::time::Duration;

pub fn write(args: &Args, reached: &[Reached], folder: &OutputFolder, time: Duration) -> Result<(), Failure> {
    folder.write_with("reach.csv", |out| write_points(args, reached, out))?;
    folder.write("report.html", report(args, reached).to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, reached, time)?.write(folder)?;
    Ok(())
}

/// A line for each frame that does not face down.
fn write_points(args: &Args, reached: &[Reached], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "arm,x_mm,y_mm,z_mm,in_box")?;
    for arm in reached {
        for point in &arm.points {
            let inside = u8::from(is_in_box(point, &arm.placement, args.box_mm));
            writeln!(out, "{},{:.3},{:.3},{:.3},{inside}", typed_name(arm.name), point.x, point.y, point.z)?;
        }
    }
    Ok(())
}

/// A line for each arm.
pub fn table(reached: &[Reached]) -> Table {
    let heads =
        ["arm", "frames", "nozzle x mm", "y mm", "z mm", "in box", "waypoints reached", "configurations", "time s"];
    let mut table = Table::new(heads);
    for arm in reached {
        let centre = arm.placement.centre;
        table.row([
            arm.name.title().to_owned(),
            arm.points.len().to_string(),
            format!("{:.1}", centre.x),
            format!("{:.1}", centre.y),
            format!("{:.1}", centre.z),
            arm.placement.frames.to_string(),
            format!("{} of {}", arm.waypoints_reached, arm.waypoints),
            arm.configurations.to_string(),
            format!("{:.2}", arm.time.as_secs_f64()),
        ]);
    }
    table
}

fn summary(args: &Args, reached: &[Reached], time: Duration) -> Result<Summary, Failure> {
    let failed = failed_checks(reached);
    let mut summary = Summary::new();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("arm", typed_name(args.arm))?
        .set("samples", args.samples)?
        .set("box_mm", args.box_mm)?
        .set("platform_mm", args.platform_mm)?
        .set("front_mm", args.front_mm)?
        .set("threads", args.common.threads)?;
    let chosen = reached.iter().filter(|arm| arm.name == args.arm).map(|arm| (String::new(), arm));
    let all = reached.iter().map(|arm| (format!("{}_", typed_name(arm.name)), arm));
    for (prefix, arm) in chosen.chain(all) {
        let centre = arm.placement.centre;
        summary
            .set(&format!("{prefix}frames"), arm.points.len())?
            .set(&format!("{prefix}best_x_mm"), centre.x)?
            .set(&format!("{prefix}best_y_mm"), centre.y)?
            .set(&format!("{prefix}best_z_mm"), centre.z)?
            .set(&format!("{prefix}frames_in_box"), arm.placement.frames)?
            .set(&format!("{prefix}waypoints"), arm.waypoints)?
            .set(&format!("{prefix}waypoints_reached"), arm.waypoints_reached)?
            .set(&format!("{prefix}configurations"), arm.configurations)?
            .set(&format!("{prefix}worst_mm"), arm.worst_mm)?
            .set_seconds(&format!("{prefix}place_s"), arm.time)?;
    }
    summary
        .set("check_ok", failed.is_empty())?
        .set("checks_failed", failed.join(", "))?
        .set_seconds("total_s", time)?;
    Ok(summary)
}

fn report(args: &Args, reached: &[Reached]) -> Report {
    let mut report = Report::new("Reach of the arms, and where the nozzle should stand");
    report.paragraph(&format!(
        "After Dai (2020), section 2.3.1: {} postures of each arm, spread evenly over its joints; frames of the platform \
         in its hand that face down, lie below the floor or less than {} mm in front of axis 1 are dropped. The method puts \
         the nozzle at the middle of the box of {} mm that contains the most of the others. A second count of the frames in \
         the box, one by one, agrees for {} of {} arms.",
        args.samples,
        args.front_mm,
        args.box_mm,
        reached.iter().filter(|arm| arm.recounted == arm.placement.frames).count(),
        reached.len()
    ));
    for arm in reached.iter().filter(|arm| !arm.is_ok()) {
        report.notice(&format!(
            "{}: {} frames were counted in the box of {}, and a nozzle missed its waypoint by {:e} mm.",
            arm.name.title(),
            arm.recounted,
            arm.placement.frames,
            arm.worst_mm
        ));
    }
    let waypoints = reached.first().map_or(0, |arm| arm.waypoints);
    report.table("This run", &table(reached)).paragraph(&format!(
        "Waypoints: an upright cube of half the box, {waypoints} points. Reached: with at least one of {TOOL_ANGLES} tool angles, \
         within the limits of the joints. Collisions are not checked."
    ));
    for arm in reached {
        let front = picture(arm, Vector3::new(0.35, -1.0, 0.3), args.box_mm);
        let above = picture(arm, Vector3::new(0.0, -0.25, 1.0), args.box_mm);
        report
            .heading(arm.name.title())
            .viewer(&build(arm, args.box_mm))
            .pictures(&[("from the front, cut at the nozzle", &front), ("from above, cut at the nozzle", &above)]);
    }
    report
}
