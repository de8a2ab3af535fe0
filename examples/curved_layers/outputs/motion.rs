//! Of the motion: `trajectory.csv`, figures, and the robot at eight moments.

use super::{Picture, borrowed, seconds};
use crate::failure;
use crate::motion::MotionRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_examples::motion::PartInHand;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::render::{Camera, INK, PLATFORM, Scene, layer_colour};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use nalgebra::{Isometry3, Point3, Translation3, Vector3};
use std::io::{self, Write};

/// Pictures of the robot.
const MOMENTS: usize = 8;

/// Pixels of each of them.
const PICTURE: [u32; 2] = [520, 480];

/// Half the thickness of drawn links, in millimetres.
const BONE: f64 = 16.0;

pub fn products(run: &MotionRun, folder: &OutputFolder) -> Result<(), Failure> {
    folder.write_with("trajectory.csv", |out| write_csv(run, out))?;
    Ok(())
}

/// A line a knot of the splines; transfers at their corners of time. Times go on from run to run.
fn write_csv(run: &MotionRun, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "time_s,q1,q2,q3,q4,q5,q6,kind,layer,path")?;
    let mut line = |time: f64, joints: &[f64; 6], kind: &str, layer: u32, path: usize| {
        write!(out, "{time:.6}")?;
        joints.iter().try_for_each(|joint| write!(out, ",{joint:.9}"))?;
        writeln!(out, ",{kind},{},{path}", layer + 1)
    };
    let mut start = 0.0;
    for (number, motion) in run.runs.iter().enumerate() {
        let (first, last) = motion.trajectory.span();
        for (time, joints) in motion.trajectory.times().iter().zip(motion.trajectory.joints()) {
            let kind = if *time < 0.0 || motion.is_after_print(*time) { "run" } else { "print" };
            line(start + time - first, joints, kind, motion.layer, motion.path)?;
        }
        start += last - first;
        if let Some(Some(transfer)) = run.transfers.get(number) {
            for time in transfer.knots() {
                line(start + time, &transfer.at(time).position, "transfer", motion.layer, motion.path)?;
            }
            start += transfer.duration();
        }
    }
    Ok(())
}

pub fn summary(run: &MotionRun, summary: &mut Summary) -> Result<(), Failure> {
    let times = &run.times;
    summary
        .set("robot_time_s", run.robot_s())?
        .set("plan_s", run.plan_s())?
        .set_seconds("plan_motion_s", times.plan)?
        .set_seconds("plan_check_s", times.check)?
        .set_seconds("plan_transfers_s", times.transfers)?
        .set("realtime_factor", run.plan_s() / run.robot_s().max(f64::MIN_POSITIVE))?
        .set("motions", run.runs.len())?
        .set("breaks", run.breaks)?
        .set("unreachable_waypoints", run.unreachable)?
        .set("blocked_waypoints", run.blocked)?
        .set("bounds_missed", run.bounds_missed)?
        .set("waypoint_error_mm", run.missed_mm)?
        .set("collisions", run.collisions)?
        .set("transfers", run.transfers.len())?
        .set("without_transfer", run.without_transfer())?;
    Ok(())
}

pub fn rows(run: &MotionRun, table: &mut Table) {
    let times = &run.times;
    let worst = run.worst.as_ref().map_or_else(String::new, |worst| format!(", mostly {worst}"));
    table
        .row(["robot moves".to_owned(), format!("{:.1} min in {} motions", run.robot_s() / 60.0, run.runs.len())])
        .row(["planned in".to_owned(), seconds(times.plan)])
        .row(["checked in".to_owned(), seconds(times.check)])
        .row(["transfers in".to_owned(), seconds(times.transfers)])
        .row(["planning to moving".to_owned(), format!("{:.4}", run.plan_s() / run.robot_s().max(f64::MIN_POSITIVE))])
        .row(["out of reach".to_owned(), format!("{} waypoints, {} more blocked", run.unreachable, run.blocked)])
        .row(["too fast for the arm".to_owned(), format!("{} breaks, {} motions", run.breaks, run.bounds_missed)])
        .row(["collisions".to_owned(), format!("{}{worst}", run.collisions)])
        .row(["transfers".to_owned(), format!("{}, {} not found", run.transfers.len(), run.without_transfer())]);
}

pub fn report(surfaces: &SurfacesRun, run: &MotionRun, report: &mut Report) -> Result<(), Failure> {
    let shown = (0..MOMENTS).filter_map(|moment| {
        let at = (2 * moment + 1) * run.runs.len() / (2 * MOMENTS);
        run.runs.get(at).map(|_| moment_of(surfaces, run, at))
    });
    let pictures = shown.collect::<Result<Vec<Picture>, Failure>>()?;
    report.heading("The robot, which holds the part under a standing nozzle").pictures(&borrowed(&pictures));
    Ok(())
}

/// The robot in the middle of a run, with the surfaces up to its own.
fn moment_of(surfaces: &SurfacesRun, run: &MotionRun, at: usize) -> Result<Picture, Failure> {
    let motion = &run.runs[at];
    let robot = PartInHand::new(Vec::new()).map_err(failure)?;
    let (cell, joints) = (robot.cell(), motion.trajectory.at_waypoints());
    let frames = cell.arm().frames(&joints[joints.len() / 2]);
    let shift = Isometry3::from(Translation3::new(-run.shift.x, -run.shift.y, 0.0));
    let base_part = frames[6] * cell.held() * shift;
    let mut scene = Scene::new(Camera::from_direction(Vector3::new(0.4, -1.0, 0.35)));
    for ends in frames.windows(2) {
        let [a, b] = [0, 1].map(|k: usize| Point3::from(ends[k].translation.vector));
        scene.bar(a, b, BONE, INK);
    }
    let flange = Point3::from(frames[6].translation.vector);
    scene.bar(flange, frames[6] * cell.held() * Point3::origin(), BONE, PLATFORM);
    let layers = surfaces.sheets.len() as u32;
    for (number, sheet) in surfaces.sheets.iter().enumerate().take(motion.layer as usize + 1) {
        let corner = |corner: u32| base_part * sheet.vertices[corner as usize];
        let colour = layer_colour(number as u32 + 1, layers);
        scene.triangles(sheet.triangles.iter().map(|corners| (corners.map(corner), colour)));
    }
    let nozzle = cell.other();
    scene.bar(nozzle * Point3::origin(), nozzle * Point3::new(0.0, 0.0, 8.0), 2.5, INK);
    scene.bar(nozzle * Point3::new(0.0, 0.0, 8.0), nozzle * Point3::new(0.0, 0.0, 60.0), 10.0, INK);
    let [width, height] = PICTURE;
    Ok((format!("layer {} of {layers}", motion.layer + 1), scene.draw(width, height).to_png()))
}
