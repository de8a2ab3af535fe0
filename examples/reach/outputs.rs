//! What the example leaves behind: the table on stdout, `summary.json`, `reach.csv` and `report.html`.

use super::Args;
use super::drawing::{build, picture};
use super::reaching::{Cell, Found, Reached, is_in_box};
use super::standing::Worth;
use super::tried::TOOL_ANGLES;
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::count::counted;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_kinematics::nalgebra::{Point3, Vector3};
use std::io::{self, Write};
use std::time::Duration;

pub fn write(args: &Args, found: &Found, folder: &OutputFolder, time: Duration) -> Result<(), Failure> {
    folder.write_with("reach.csv", |out| write_points(args, &found.arms, out))?;
    folder.write("report.html", report(args, found).to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, found, time)?.write(folder)?;
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

fn at(place: &Point3<f64>) -> String {
    format!("{:.0}, {:.0}, {:.0}", place.x, place.y, place.z)
}

fn free(worth: &Worth, waypoints: usize) -> String {
    format!("{} of {waypoints}", worth.free)
}

/// A line for each arm.
pub fn table(reached: &[Reached]) -> Table {
    let heads = [
        "arm",
        "frames",
        "middle of the box mm",
        "free there",
        "best place mm",
        "free there",
        "tight",
        "reached",
        "configurations",
        "time s",
    ];
    let mut table = Table::new(heads);
    for arm in reached {
        let best = &arm.stood.best;
        table.row([
            arm.name.title().to_owned(),
            arm.points.len().to_string(),
            at(&arm.placement.centre),
            free(&arm.box_worth, arm.waypoints),
            at(&best.place),
            free(best, arm.waypoints),
            best.tight.to_string(),
            arm.waypoints_reached.to_string(),
            arm.configurations.to_string(),
            format!("{:.2}", arm.time.as_secs_f64()),
        ]);
    }
    table
}

/// A line for each workcell that we ship.
pub fn cells(cells: &[Cell]) -> Table {
    let heads = [
        "workcell",
        "what stands",
        "at mm",
        "free there",
        "tight",
        "best place mm",
        "free there",
        "tight",
        "away mm",
        "but for a turn mm",
    ];
    let mut table = Table::new(heads);
    for Cell { name, stood, .. } in cells {
        let (Some(now), Some(apart)) = (stood.now, stood.apart_mm()) else { continue };
        table.row([
            name.clone(),
            stood.stands.name().to_owned(),
            at(&now.place),
            free(&now, stood.waypoints),
            now.tight.to_string(),
            at(&stood.best.place),
            free(&stood.best, stood.waypoints),
            stood.best.tight.to_string(),
            format!("{:.0}", apart[0]),
            format!("{:.0}", apart[1]),
        ]);
    }
    table
}

fn summary(args: &Args, found: &Found, time: Duration) -> Result<Summary, Failure> {
    let reached = &found.arms;
    let mut summary = Summary::new();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("arm", typed_name(args.arm))?
        .set("samples", args.samples)?
        .set("box_mm", args.box_mm)?
        .set("platform_mm", args.platform_mm)?
        .set("front_mm", args.front_mm)?
        .set("coarse_mm", args.coarse_mm)?
        .set("fine_mm", args.fine_mm)?
        .set("threads", args.common.threads)?;
    let chosen = reached.iter().filter(|arm| arm.name == args.arm).map(|arm| (String::new(), arm));
    let all = reached.iter().map(|arm| (format!("{}_", typed_name(arm.name)), arm));
    for (prefix, arm) in chosen.chain(all) {
        let (centre, best) = (arm.placement.centre, arm.stood.best);
        summary
            .set(&format!("{prefix}frames"), arm.points.len())?
            .set(&format!("{prefix}best_x_mm"), best.place.x)?
            .set(&format!("{prefix}best_y_mm"), best.place.y)?
            .set(&format!("{prefix}best_z_mm"), best.place.z)?
            .set(&format!("{prefix}waypoints_free"), best.free)?
            .set(&format!("{prefix}waypoints_tight"), best.tight)?
            .set(&format!("{prefix}places"), arm.stood.places)?
            .set(&format!("{prefix}assessments"), arm.stood.assessments)?
            .set(&format!("{prefix}box_x_mm"), centre.x)?
            .set(&format!("{prefix}box_y_mm"), centre.y)?
            .set(&format!("{prefix}box_z_mm"), centre.z)?
            .set(&format!("{prefix}box_waypoints_free"), arm.box_worth.free)?
            .set(&format!("{prefix}frames_in_box"), arm.placement.frames)?
            .set(&format!("{prefix}waypoints"), arm.waypoints)?
            .set(&format!("{prefix}waypoints_reached"), arm.waypoints_reached)?
            .set(&format!("{prefix}configurations"), arm.configurations)?
            .set(&format!("{prefix}worst_mm"), arm.worst_mm)?
            .set_seconds(&format!("{prefix}place_s"), arm.time)?;
    }
    for Cell { key, stood, .. } in &found.cells {
        let (Some(now), Some(apart)) = (stood.now, stood.apart_mm()) else { continue };
        summary
            .set(&format!("cell_{key}_free"), now.free)?
            .set(&format!("cell_{key}_tight"), now.tight)?
            .set(&format!("cell_{key}_best_x_mm"), stood.best.place.x)?
            .set(&format!("cell_{key}_best_y_mm"), stood.best.place.y)?
            .set(&format!("cell_{key}_best_z_mm"), stood.best.place.z)?
            .set(&format!("cell_{key}_best_free"), stood.best.free)?
            .set(&format!("cell_{key}_best_tight"), stood.best.tight)?
            .set(&format!("cell_{key}_away_mm"), apart[0])?
            .set(&format!("cell_{key}_away_but_for_turn_mm"), apart[1])?
            .set(&format!("cell_{key}_verdict"), stood.verdict().unwrap_or_default())?;
    }
    found.findings.summary(&mut summary)?;
    summary.set_seconds("total_s", time)?;
    Ok(summary)
}

fn report(args: &Args, found: &Found) -> Report {
    let reached = &found.arms;
    let mut report = Report::new("Reach of the arms, and where the nozzle should stand");
    found.findings.report(&mut report);
    report.paragraph(&format!(
        "After Dai (2020), section 2.3.1: {} of each arm, spread evenly over its joints; frames of the platform \
         in its hand that face down, lie below the floor or less than {} mm in front of axis 1 are dropped. The dissertation puts \
         the nozzle at the middle of the box of {} mm that contains the most of the others. A second count of the frames in \
         the box, one by one, agrees for {} of {}. Counting frames knows no collisions: the box lies at the limit that keeps it away from the arm.",
        counted(args.samples, "posture"),
        args.front_mm,
        args.box_mm,
        reached.iter().filter(|arm| arm.recounted == arm.placement.frames).count(),
        counted(reached.len(), "arm")
    ));
    report.paragraph(&format!(
        "The best place is searched by what a part is worth there: an upright cube of {} mm that grows layer by layer, on an arm that stands on a floor, under a nozzle that hangs down \
         from a holder. Most waypoints with a free posture come first, then fewest that are tight, then the greatest smallest manipulability; first on a grid of {} mm over all that the arm \
         reaches, then in steps down to {} mm. Links, plate, part, nozzle, holder and floor keep 2 mm apart, comfortable are 9.5 mm more.",
        0.5 * args.box_mm,
        args.coarse_mm,
        args.fine_mm
    ));
    let waypoints = reached.first().map_or(0, |arm| arm.waypoints);
    report.table("Arms", &table(reached)).paragraph(&format!(
        "Free: of {waypoints} waypoints, those with a posture within the limits of the joints that touches nothing, at one of {TOOL_ANGLES} tool angles. Reached: those with any posture at the best \
         place, free or not; configurations: how many postures they have together."
    ));
    let ends: Vec<String> =
        reached.iter().filter(|arm| arm.stood.at_end.contains(&true)).map(|arm| arm.name.title().to_owned()).collect();
    report.paragraph(&match ends.len() {
        0 => "No best place lies at an end of what the arm reaches.".to_owned(),
        _ => format!("The best place lies at an end of what the arm reaches for: {}.", ends.join(", ")),
    });
    report.heading("The workcells that we ship").table("", &cells(&found.cells));
    report.paragraph(
        "The same part in each cell, searched in three coordinates. Away: from where it stands to the best place; and the same but for a turn about axis 1, which is all the same to most arms. Walls, floor and \
         stands are those of the file of the cell: where a positioner has a stand, a body should say so.",
    );
    for arm in reached {
        let front = picture(arm, Vector3::new(0.35, -1.0, 0.3), args.box_mm);
        let above = picture(arm, Vector3::new(0.0, -0.25, 1.0), args.box_mm);
        report.heading(arm.name.title()).viewer(&build(arm, args.box_mm)).pictures(&[
            ("from the front, cut at the box of the most frames", &front),
            ("from above, cut at that box; the arm is at the best place", &above),
        ]);
    }
    report
}
