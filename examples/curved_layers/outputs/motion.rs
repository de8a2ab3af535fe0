//! Of the motion: `trajectory.csv`, `layers.csv`, figures, and the robot at eight moments.

use super::{Picture, borrowed, pictures, seconds};
use crate::motion::robots::Printer;
use crate::motion::{FaultKind, Figures, LayerFigures, MotionRun, Run, Times};
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::plot::Plot;
use curvlay_examples::render::{Camera, INK, PLATFORM, Scene, layer_colour};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_hull::{ConvexHull, Depth};
use curvlay_kinematics::scene::{Body, Mount, Shape};
use nalgebra::{Isometry3, Point3, Translation3, Vector3};
use std::io::{self, Write};
use std::time::Duration;

/// Pictures of the robot.
const MOMENTS: usize = 8;

/// Pixels of each of them.
const PICTURE: [u32; 2] = [520, 480];

/// Half the thickness of drawn links, and of the plate under the part, in millimetres.
const BONE: f64 = 16.0;
const PLATE: f64 = 2.0;

/// What the arm stands on is drawn down to this far below its base, in millimetres, and in this colour.
const DRAWN_BELOW_MM: f64 = 120.0;
const STAND: [u8; 3] = [158, 166, 176];

/// Colours of the plot: motions, checks, transfers.
const PARTS: [[u8; 3]; 3] = [pictures::EVEN, [150, 158, 168], [217, 120, 30]];

pub fn products<const N: usize, const F: usize, R>(
    run: &MotionRun<N, F, R>,
    folder: &OutputFolder,
) -> Result<(), Failure> {
    folder.write_with("trajectory.csv", |out| write_csv(run, out))?;
    folder.write_with("layers.csv", |out| write_layers(&run.figures.layers, out))?;
    let faults = &run.figures.faults;
    folder.write_list("motion-faults.csv", !faults.is_empty(), |out| {
        writeln!(out, "layer,path,at,kind,what")?;
        faults.iter().try_for_each(|fault| {
            let (kind, what) = (fault.kind.name(), fault.what.replace(',', ";"));
            writeln!(out, "{},{},{},{kind},{what}", fault.layer + 1, fault.path, fault.waypoint)
        })
    })?;
    Ok(())
}

/// A line a knot of the splines; transfers at their corners of time. Times go on from run to run.
fn write_csv<const N: usize, const F: usize, R>(run: &MotionRun<N, F, R>, out: &mut dyn Write) -> io::Result<()> {
    let names: Vec<String> = (1..=N).map(|joint| format!("q{joint}")).collect();
    writeln!(out, "time_s,{},kind,layer,path", names.join(","))?;
    let mut line = |time: f64, joints: &[f64; N], kind: &str, of: &Run<N, F>| {
        write!(out, "{time:.6}")?;
        joints.iter().try_for_each(|joint| write!(out, ",{joint:.9}"))?;
        writeln!(out, ",{kind},{},{}", of.layer + 1, of.path)
    };
    let mut start = 0.0;
    for (number, motion) in run.runs.iter().enumerate() {
        let (first, _) = motion.trajectory.span();
        let [begin, end] = motion.printing();
        for (time, joints) in motion.trajectory.times().iter().zip(motion.trajectory.joints()) {
            let kind = if (begin..=end).contains(time) { "print" } else { "run" };
            line(start + time - first, joints, kind, motion)?;
        }
        start += motion.duration();
        if let Some(Some(transfer)) = run.transfers.get(number) {
            for time in transfer.knots() {
                line(start + time, &transfer.at(time).position, "transfer", motion)?;
            }
            start += transfer.duration();
        }
    }
    Ok(())
}

/// A line a layer: how long the robot moves, and how long a single thread would have planned.
fn write_layers(layers: &[LayerFigures], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "layer,motions,waypoints,robot_s,plan_s,check_s,transfers_s,realtime_factor,faults")?;
    layers.iter().try_for_each(|layer| {
        let [plan, check, transfers] =
            [layer.times.plan, layer.times.check, layer.times.transfers].map(|time| time.as_secs_f64());
        writeln!(
            out,
            "{},{},{},{:.3},{plan:.4},{check:.4},{transfers:.4},{:.6},{}",
            layer.layer + 1,
            layer.motions,
            layer.waypoints,
            layer.robot_s,
            layer.factor(Times::all),
            layer.faults
        )
    })
}

pub fn summary(run: &Figures, shift: &Vector3<f64>, summary: &mut Summary) -> Result<(), Failure> {
    let times = &run.times;
    let worst = run.layers.iter().filter(|layer| layer.motions > 0).map(|layer| layer.factor(Times::all));
    summary
        .set("cell", run.name)?
        .set("part_shift_x_mm", shift.x)?
        .set("part_shift_y_mm", shift.y)?
        .set("robot_time_s", run.robot_s())?
        .set("plan_s", run.plan_s())?
        .set_seconds("plan_motion_s", times.plan)?
        .set_seconds("plan_check_s", times.check)?
        .set_seconds("plan_transfers_s", times.transfers)?
        .set("realtime_factor", run.plan_s() / run.robot_s().max(f64::MIN_POSITIVE))?
        .set("realtime_factor_worst_layer", worst.fold(0.0, f64::max))?
        .set("motions", run.motions)?
        .set("breaks", run.count(FaultKind::Break))?
        .set("unreachable_waypoints", run.count(FaultKind::Unreachable))?
        .set("blocked_waypoints", run.count(FaultKind::Blocked))?
        .set("bounds_missed", run.count(FaultKind::Bounds))?
        .set("slowed_motions", run.count(FaultKind::Slowed))?
        .set("least_feed_share", run.least_feed)?
        .set("waypoint_error_mm", run.missed_mm)?
        .set("path_error_mm", run.strayed_mm)?
        .set("astray", run.count(FaultKind::Astray))?
        .set("collisions", run.count(FaultKind::Collision))?
        .set("transfers", run.transfers)?
        .set("without_transfer", run.count(FaultKind::NoTransfer))?;
    Ok(())
}

pub fn rows(run: &Figures, table: &mut Table) {
    let times = &run.times;
    let worst = run.worst().map_or_else(String::new, |worst| format!(", mostly {worst}"));
    let count = |kind| run.count(kind);
    let factor = run.plan_s() / run.robot_s().max(f64::MIN_POSITIVE);
    let reach = format!("{} waypoints, {} more blocked", count(FaultKind::Unreachable), count(FaultKind::Blocked));
    let slowed = format!("{} slowed, to {:.0} % at least", count(FaultKind::Slowed), 100.0 * run.least_feed);
    let slow = format!("{} breaks, {} motions, {slowed}", count(FaultKind::Break), count(FaultKind::Bounds));
    table
        .row(["robot moves".to_owned(), format!("{:.1} min in {} motions", run.robot_s() / 60.0, run.motions)])
        .row(["planned in".to_owned(), seconds(times.plan)])
        .row(["checked in".to_owned(), seconds(times.check)])
        .row(["transfers in".to_owned(), seconds(times.transfers)])
        .row(["planning to moving".to_owned(), format!("{factor:.4}")])
        .row(["out of reach".to_owned(), reach])
        .row(["too fast for the arm".to_owned(), slow])
        .row([
            "off the path".to_owned(),
            format!("{:.2} mm at most, {} steps too far", run.strayed_mm, count(FaultKind::Astray)),
        ])
        .row(["collisions".to_owned(), format!("{}{worst}", count(FaultKind::Collision))])
        .row(["transfers".to_owned(), format!("{}, {} not found", run.transfers, count(FaultKind::NoTransfer))]);
}

pub fn report<const N: usize, const F: usize, R: Printer<N, F>>(
    surfaces: &SurfacesRun,
    run: &MotionRun<N, F, R>,
    report: &mut Report,
) {
    let shown = (0..MOMENTS).filter_map(|moment| {
        let at = (2 * moment + 1) * run.runs.len() / (2 * MOMENTS);
        run.runs.get(at).and_then(|motion| moment_of(surfaces, run, motion))
    });
    let pictures: Vec<Picture> = shown.collect();
    let mut plot = Plot::new("layer", "planning time / robot time");
    let mut line = |name: &str, colour: [u8; 3], part: fn(&Times) -> Duration| {
        let moving = run.figures.layers.iter().filter(|layer| layer.robot_s > 0.0);
        plot.line(name, colour, moving.map(|layer| [f64::from(layer.layer + 1), layer.factor(part)]));
    };
    let [motions, checks, transfers] = PARTS;
    line("motions", motions, |times| times.plan);
    line("checks", checks, |times| times.check);
    line("transfers", transfers, |times| times.transfers);
    report
        .heading(&format!("The robot: {}", R::NAME))
        .pictures(&borrowed(&pictures))
        .plot("how long one thread plans a layer, by how long the robot moves for it", &plot);
}

/// The robot in the middle of a run, with the surfaces up to its own.
fn moment_of<const N: usize, const F: usize, R: Printer<N, F>>(
    surfaces: &SurfacesRun,
    run: &MotionRun<N, F, R>,
    motion: &Run<N, F>,
) -> Option<Picture> {
    let joints = motion.trajectory.at_waypoints();
    let stance = run.robot.stance(&joints[joints.len() / 2])?;
    let base_part = stance.part * Isometry3::from(Translation3::new(-run.shift.x, -run.shift.y, 0.0));
    let mut scene = Scene::new(Camera::from_direction(Vector3::new(0.4, -1.0, 0.35)));
    for ends in stance.arm.windows(2) {
        let [a, b] = [0, 1].map(|k: usize| Point3::from(ends[k].translation.vector));
        scene.bar(a, b, BONE, INK);
    }
    run.robot.scene().bodies.iter().for_each(|body| stand(body, &mut scene));
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
fn stand(body: &Body, scene: &mut Scene) {
    let (Mount::Base, Shape::Hull { points, .. }) = (body.mount, &body.shape) else { return };
    let points = points.iter().map(|point| body.mount_body * point);
    let corner = |p: Point3<f64>| [p.x, p.y, p.z.max(-DRAWN_BELOW_MM)].map(|c| c.round() as i32);
    let mut hull = ConvexHull::new(Depth::default());
    if hull.insert(&points.map(corner).collect::<Vec<_>>()).is_ok() {
        let point = |corner: Option<[i32; 3]>| corner.map(|at| Point3::from(at.map(f64::from)));
        let corners = hull.triangles().filter_map(|[a, b, c]| Some([point(a)?, point(b)?, point(c)?]));
        scene.triangles(corners.map(|corners| (corners, STAND)));
    }
}
