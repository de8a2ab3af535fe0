//! Of the motion: `layers.csv`, figures, and the robot at eight moments.

use super::pictures;
use super::shown::{Picture, borrowed, seconds};
use crate::motion::{Checked, MotionRun};
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_examples::count::counted;
use curvlay_examples::findings::at_most_mm;
use curvlay_examples::motion::turning_joints;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::plot::Plot;
use curvlay_examples::render::{Camera, INK, PLATFORM, Scene, layer_colour};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_hull::{ConvexHull, Depth};
use curvlay_kinematics::scene::{Body, Mount, Shape};
use curvlay_kinematics::workcell::{Equipment, HOT_END, NOZZLE, Workcell};
use curvlay_trajectory::check::{FindingClass, FindingPlace, JointPeaks, PrintPeak};
use curvlay_trajectory::print::{FaultKind, LayerPlan, PlanTimes, PrintPlan, Run};
use nalgebra::{Isometry3, Point3, Vector3};
use serde_json::Value;
use std::io::{self, Write};
use std::time::Duration;

/// Pictures of the robot.
const MOMENTS: usize = 8;

/// Pixels of each of them.
const PICTURE: [u32; 2] = [520, 480];

/// Half the thickness of drawn links, and of the plate under the part, in millimetres.
const BONE: f64 = 16.0;
const PLATE: f64 = 2.0;

/// Diameter of a plate in the base, where the workcell leaves it open.
const PLATE_MM: f64 = 100.0;

/// What the arm stands on is drawn down to this far below its base, in millimetres, and in this colour.
const DRAWN_BELOW_MM: f64 = 120.0;
const STAND: [u8; 3] = [158, 166, 176];

/// Colours of the plot: motions, transfers.
const PARTS: [[u8; 3]; 2] = [pictures::EVEN, [217, 120, 30]];

pub fn products<const N: usize, const F: usize, W>(
    run: &MotionRun<N, F, W>,
    folder: &OutputFolder,
) -> Result<(), Failure> {
    folder.write_with("layers.csv", |out| write_layers(&run.plan.layers, out))?;
    let faults = &run.plan.faults;
    folder.write_list("motion-faults.csv", !faults.is_empty(), |out| {
        writeln!(out, "layer,path,at,kind,what")?;
        faults.iter().try_for_each(|fault| {
            let (kind, what) = (fault.kind.name(), fault.what.replace(',', ";"));
            writeln!(out, "{},{},{},{kind},{what}", fault.layer + 1, fault.path, fault.waypoint)
        })
    })?;
    let findings =
        run.checked.iter().flat_map(|checked| checked.report.print.findings.iter().zip(&checked.report.places));
    folder.write_list("motion-check.csv", findings.clone().next().is_some(), |out| {
        writeln!(out, "motion,layer,path,kind,time_s,what")?;
        findings.clone().try_for_each(|(finding, FindingPlace { kind, layer, path })| {
            let what = finding.to_string().replace(',', ";");
            writeln!(out, "{},{},{path},{},{:.4},{what}", finding.motion, layer + 1, kind.name(), finding.time)
        })
    })?;
    Ok(())
}

/// Planning time by robot time; 0 where the robot does not move.
fn share(plan_s: f64, robot_s: f64) -> f64 {
    if robot_s > 0.0 { plan_s / robot_s } else { 0.0 }
}

/// The same of a layer.
fn factor(layer: &LayerPlan, times: fn(&PlanTimes) -> Duration) -> f64 {
    share(times(&layer.times).as_secs_f64(), layer.robot_s)
}

/// A line a layer: how long the robot moves, and how long a single thread would have planned.
fn write_layers(layers: &[LayerPlan], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "layer,motions,waypoints,robot_s,plan_s,transfers_s,realtime_factor,faults")?;
    layers.iter().try_for_each(|layer| {
        let [plan, transfers] = [layer.times.runs, layer.times.travels].map(|time| time.as_secs_f64());
        writeln!(
            out,
            "{},{},{},{:.3},{plan:.4},{transfers:.4},{:.6},{}",
            layer.layer + 1,
            layer.runs,
            layer.waypoints,
            layer.robot_s,
            factor(layer, PlanTimes::all),
            layer.faults
        )
    })
}

pub fn summary<const N: usize, const F: usize, W: Workcell<N, F>>(
    run: &MotionRun<N, F, W>,
    summary: &mut Summary,
) -> Result<(), Failure> {
    let MotionRun { cell, plan: run, limits, margin_mm, without_links, frame_part, checked: found, .. } = run;
    let bodies = cell.equipment().link_bodies().filter(|_| !without_links);
    let times = &run.times;
    let worst = run.layers.iter().map(|layer| factor(layer, PlanTimes::all));
    let turning = turning_joints(cell.equipment(), N);
    let limit = |values: [f64; N]| {
        let least = values[..turning].iter().copied().fold(f64::INFINITY, f64::min);
        if least.is_finite() { Value::from(least) } else { Value::from("none") }
    };
    summary
        .set("cell", cell.equipment().name())?
        .set("part_shift_x_mm", -frame_part.translation.x)?
        .set("part_shift_y_mm", -frame_part.translation.y)?
        .set("part_turn_deg", frame_part.rotation.scaled_axis().z.to_degrees())?
        .set("limit_acceleration_rad_s2", limit(limits.bounds.acceleration))?
        .set("limit_jerk_rad_s3", limit(limits.bounds.jerk))?
        .set("limit_flow_mm3_s", limit([limits.max_flow_mm3_s; N]))?
        .set("limit_flow_ramp_mm3_s2", limit([limits.max_flow_ramp_mm3_s2; N]))?
        .set("path_tolerance_mm", limits.tolerance_mm)?
        .set("margin_mm", *margin_mm)?
        .set("link_bodies", bodies.map_or("none", |bodies| &bodies.model))?
        .set("link_bodies_error_mm", bodies.map_or(0.0, |bodies| bodies.error_mm))?
        .set("link_allowance_mm", cell.equipment().model().arm.allowance_mm)?
        .set("robot_time_s", run.robot_s())?
        .set("printing_s", run.printing_s)?
        .set("printing_planned_s", run.planned_s)?
        .set("plan_s", run.plan_s())?
        .set_seconds("plan_motion_s", times.runs)?
        .set_seconds("plan_transfers_s", times.travels)?
        .set("realtime_factor", share(run.plan_s(), run.robot_s()))?
        .set("realtime_factor_worst_layer", worst.fold(0.0, f64::max))?
        .set("motions", run.runs.len())?
        .set("breaks", run.count(FaultKind::Break))?
        .set("unreachable_waypoints", run.count(FaultKind::Unreachable))?
        .set("blocked_waypoints", run.count(FaultKind::Blocked))?
        .set("min_pace", run.min_pace)?
        .set("slow_motions", run.slow_runs)?
        .set("waypoint_error_mm", run.max_missed_mm)?
        .set("path_error_mm", run.max_deviation_mm)?
        .set("astray", run.count(FaultKind::PathDeviation))?
        .set("transfers", run.travels.len())?
        .set("without_transfer", run.count(FaultKind::NoTransfer))?;
    found.iter().try_for_each(|found| checked(found, cell.equipment(), summary))
}

/// Figures of the check.
fn checked<const N: usize>(checked: &Checked<N>, equipment: &Equipment, summary: &mut Summary) -> Result<(), Failure> {
    let report = &checked.report.print;
    let peak = |peak: &Option<PrintPeak>| peak.map_or(0.0, |peak| peak.value);
    let (turning, on_track) = report.joints.split_at(turning_joints(equipment, N));
    for (track, peaks) in equipment.track().into_iter().zip(on_track) {
        let mm = track.mm_per_unit();
        summary
            .set("max_velocity_track_mm_s", mm * peaks.velocity.value.abs())?
            .set("max_acceleration_track_mm_s2", mm * peaks.acceleration.value.abs())?
            .set("max_jerk_track_mm_s3", mm * peaks.jerk.value.abs())?;
    }
    for (joint, peaks) in turning.iter().enumerate() {
        let joint = joint + 1;
        summary
            .set(&format!("max_velocity_q{joint}_rad_s"), peaks.velocity.value.abs())?
            .set(&format!("max_acceleration_q{joint}_rad_s2"), peaks.acceleration.value.abs())?
            .set(&format!("max_jerk_q{joint}_rad_s3"), peaks.jerk.value.abs())?;
    }
    summary
        .set_seconds("check_s", checked.took)?
        .set("check_findings", report.findings.len())?
        .set("check_limits", checked.report.count(FindingClass::Limits))?
        .set("check_deviations", checked.report.count(FindingClass::Deviations))?
        .set("check_contacts", checked.report.count(FindingClass::Contacts))?
        .set("collisions", checked.report.count(FindingClass::Collisions))?
        .set("check_joins", checked.report.count(FindingClass::Joins))?
        .set("time_over_acceleration_share", report.share_over_acceleration())?
        .set("time_over_jerk_share", report.share_over_jerk())?
        .set("max_deviation_mm", peak(&report.deviation))?
        .set("max_axis_error_deg", peak(&report.tilt).to_degrees())?
        .set("max_contact_mm", peak(&report.depth))?
        .set("unprinted_mm", checked.unprinted_mm)?;
    Ok(())
}

/// The table on stdout: the plan, and its check.
pub fn rows<const N: usize, const F: usize, W: Workcell<N, F>>(run: &MotionRun<N, F, W>, table: &mut Table) {
    plan_rows(&run.plan, table);
    check_rows(run, table);
}

fn check_rows<const N: usize, const F: usize, W: Workcell<N, F>>(run: &MotionRun<N, F, W>, table: &mut Table) {
    let Some(checked) = &run.checked else { return };
    let report = &checked.report.print;
    let turning = turning_joints(run.cell.equipment(), N);
    let most = |of: fn(&JointPeaks) -> f64| report.joints[..turning].iter().map(of).fold(0.0, f64::max);
    let rates = format!(
        "{:.2} rad/s, {:.2} rad/s2, {:.1} rad/s3 at most; above a limit {:.2} % of the time",
        most(|joint| joint.velocity.value.abs()),
        most(|joint| joint.acceleration.value.abs()),
        most(|joint| joint.jerk.value.abs()),
        100.0 * report.share_over_acceleration().max(report.share_over_jerk()),
    );
    let peak = |peak: &Option<PrintPeak>| peak.map_or(0.0, |peak| peak.value);
    let found = FindingClass::ALL.map(|class| format!("{} {}", checked.report.count(class), class.name())).join(", ");
    table.row(["checked in".to_owned(), seconds(checked.took)]).row(["joints".to_owned(), rates]);
    if let (Some(track), Some(peaks)) = (run.cell.equipment().track(), report.joints.last()) {
        let [speed, acceleration] =
            [&peaks.velocity, &peaks.acceleration].map(|peak| track.mm_per_unit() * peak.value.abs());
        table.row(["track".to_owned(), format!("{speed:.0} mm/s, {acceleration:.0} mm/s2 at most")]);
    }
    table
        .row(["off the path, checked".to_owned(), format!("{:.3} mm at most", peak(&report.deviation))])
        .row(["nozzle in what is built".to_owned(), format!("{:.3} mm at most", peak(&report.depth))])
        .row(["motions with findings".to_owned(), found])
        .row([
            "not printed".to_owned(),
            format!("{:.1} mm of {:.1} m", checked.unprinted_mm, checked.path_mm / 1000.0),
        ]);
}

fn plan_rows<const N: usize, const F: usize>(run: &PrintPlan<N, F>, table: &mut Table) {
    let times = &run.times;
    let count = |kind| run.count(kind);
    let factor = share(run.plan_s(), run.robot_s());
    let reach =
        format!("{}, {} more blocked", counted(count(FaultKind::Unreachable), "waypoint"), count(FaultKind::Blocked));
    let [printing, planned] = [run.printing_s, run.planned_s].map(|seconds| seconds / 60.0);
    let pace =
        format!("{printing:.1} min, {planned:.1} at the planned feed; {:.0} % of it at least", 100.0 * run.min_pace);
    table
        .row([
            "robot moves".to_owned(),
            format!("{:.1} min in {}", run.robot_s() / 60.0, counted(run.runs.len(), "motion")),
        ])
        .row(["of which it prints".to_owned(), pace])
        .row(["planned in".to_owned(), seconds(times.runs)])
        .row(["transfers in".to_owned(), seconds(times.travels)])
        .row(["planning to moving".to_owned(), format!("{factor:.4}")])
        .row(["out of reach".to_owned(), reach])
        .row(["paths break off".to_owned(), counted(count(FaultKind::Break), "time")])
        .row([
            "off the path".to_owned(),
            format!(
                "{}, {} too far",
                at_most_mm(run.max_deviation_mm),
                counted(count(FaultKind::PathDeviation), "step")
            ),
        ])
        .row(["transfers".to_owned(), format!("{}, {} not found", run.travels.len(), count(FaultKind::NoTransfer))]);
}

pub fn report<const N: usize, const F: usize, W: Workcell<N, F>>(
    surfaces: &SurfacesRun,
    run: &MotionRun<N, F, W>,
    report: &mut Report,
) {
    let shown = (0..MOMENTS).filter_map(|moment| {
        let at = (2 * moment + 1) * run.plan.runs.len() / (2 * MOMENTS);
        run.plan.runs.get(at).and_then(|motion| moment_of(surfaces, run, motion))
    });
    let pictures: Vec<Picture> = shown.collect();
    let mut plot = Plot::new("layer", "planning time / robot time");
    let mut line = |name: &str, colour: [u8; 3], part: fn(&PlanTimes) -> Duration| {
        let moving = run.plan.layers.iter().filter(|layer| layer.robot_s > 0.0);
        plot.line(name, colour, moving.map(|layer| [f64::from(layer.layer + 1), layer.factor(part)]));
    };
    let [motions, transfers] = PARTS;
    line("motions", motions, |times| times.runs);
    line("transfers", transfers, |times| times.travels);
    report
        .heading(&format!("The robot: {}", run.cell.equipment().name()))
        .pictures(&borrowed(&pictures))
        .plot("how long one thread plans a layer, by how long the robot moves for it", &plot);
}

/// The robot in the middle of a run, with the surfaces up to its own.
fn moment_of<const N: usize, const F: usize, W: Workcell<N, F>>(
    surfaces: &SurfacesRun,
    run: &MotionRun<N, F, W>,
    motion: &Run<N, F>,
) -> Option<Picture> {
    let joints = motion.trajectory.joints();
    let stance = run.cell.frames(&joints[joints.len() / 2])?;
    let base_part = stance.part * run.frame_part;
    let mut scene = Scene::new(Camera::from_direction(Vector3::new(0.4, -1.0, 0.35)));
    for ends in stance.arm.windows(2) {
        let [a, b] = [0, 1].map(|k: usize| Point3::from(ends[k].translation.vector));
        scene.bar(a, b, BONE, INK);
    }
    let bodies = run.cell.equipment().scene(PLATE_MM).bodies;
    bodies.iter().for_each(|body| stand(body, &stance.arm[0], &mut scene));
    let carrier = stance.carrier * Point3::origin();
    let under = stance.part * Point3::new(0.0, 0.0, -PLATE);
    if (under - carrier).norm() > BONE {
        scene.bar(carrier, under, BONE, PLATFORM);
    }
    let across = Vector3::new(3.0 * BONE, 0.0, 0.0);
    for turn in [0.0, std::f64::consts::FRAC_PI_2] {
        let turned = stance.part * Isometry3::rotation(Vector3::z() * turn);
        let [a, b] = [-1.0, 1.0].map(|side| turned * (Point3::new(0.0, 0.0, -PLATE) + across * side));
        scene.bar(a, b, PLATE, PLATFORM);
    }
    let layers = surfaces.sheets.len() as u32;
    for (number, sheet) in surfaces.sheets.iter().enumerate().take(motion.layer as usize + 1) {
        let corner = |corner: u32| base_part * sheet.vertices[corner as usize];
        let colour = layer_colour(number as u32 + 1, layers);
        scene.triangles(sheet.triangles.iter().map(|corners| (corners.map(corner), colour)));
    }
    let above = |mm: f64| stance.nozzle * Point3::new(0.0, 0.0, mm);
    scene.bar(above(0.0), above(8.0), 2.5, INK);
    scene.bar(above(8.0), above(60.0), 10.0, INK);
    let [width, height] = PICTURE;
    Some((format!("layer {} of {layers}", motion.layer + 1), scene.draw(width, height).to_png()))
}

/// Draws a body on which the arm stands, to the millimetre; the floor is farther down.
fn stand(body: &Body, base: &Isometry3<f64>, scene: &mut Scene) {
    let Shape::Hull { points, .. } = &body.shape else { return };
    let mount = match body.mount {
        Mount::Base => *base,
        Mount::Ground | Mount::Rail => Isometry3::identity(),
        Mount::Link(_) | Mount::Tilt | Mount::Table => return,
    };
    if [NOZZLE, HOT_END].contains(&&body.name[..]) {
        return;
    }
    let points = points.iter().map(|point| mount * body.mount_body * point);
    let corner = |p: Point3<f64>| [p.x, p.y, p.z.max(-DRAWN_BELOW_MM)].map(|c| c.round() as i32);
    let mut hull = ConvexHull::new(Depth::default());
    if hull.insert(&points.map(corner).collect::<Vec<_>>()).is_ok() {
        let point = |corner: Option<[i32; 3]>| corner.map(|at| Point3::from(at.map(f64::from)));
        let corners = hull.triangles().filter_map(|[a, b, c]| Some([point(a)?, point(b)?, point(c)?]));
        scene.triangles(corners.map(|corners| (corners, STAND)));
    }
}
