//! What the example leaves behind: the table on stdout, `summary.json`, `legs.csv` and `report.html`.

use super::args::Args;
use super::table::{Pose, Printed, machine};
use curvlay_examples::args::Failure;
use curvlay_examples::count::counted;
use curvlay_examples::motion::shown;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::render::{Camera, INK, MISSED, Rgb, Scene, ramp};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_examples::viewer::{Mark, Marks, Model, Robot, Stance, Step};
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_kinematics::stewart::StewartFault;
use std::io::{self, Write};
use std::time::Duration;

/// The viewer plays the layer at this speed, and draws its path so wide and high.
const SHOWN_MM_S: f64 = 20.0;
const LINE_MM: f64 = 0.8;

/// Pixels of each picture.
const PICTURE: [u32; 2] = [620, 560];
const BASE: Rgb = [150, 158, 168];
const PLATE: Rgb = [205, 210, 216];
const NOZZLE: Rgb = [232, 98, 20];

/// Whether a file of this name is one that a run writes.
pub fn is_ours(name: &str) -> bool {
    ["legs.csv", "report.html"].contains(&name)
}

pub fn write(args: &Args, printed: &Printed, folder: &OutputFolder, time: Duration) -> Result<(), Failure> {
    folder.write_with("legs.csv", |out| write_legs(printed, out))?;
    folder.write("report.html", report(args, printed).to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, printed, time)?.write(folder)?;
    Ok(())
}

/// A line for each waypoint.
fn write_legs(printed: &Printed, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "x_mm,y_mm,z_mm,nx,ny,nz,l1_mm,l2_mm,l3_mm,l4_mm,l5_mm,l6_mm,singularity,reached")?;
    for pose in &printed.poses {
        let (at, n, l) = (pose.waypoint.position, pose.waypoint.axis, pose.legs);
        write!(out, "{:.4},{:.4},{:.4},{:.6},{:.6},{:.6}", at.x, at.y, at.z, n.x, n.y, n.z)?;
        write!(out, ",{:.4},{:.4},{:.4},{:.4},{:.4},{:.4}", l[0], l[1], l[2], l[3], l[4], l[5])?;
        writeln!(out, ",{:.6},{}", pose.singularity, u8::from(pose.fault.is_none()))?;
    }
    Ok(())
}

pub fn table(printed: &Printed) -> Table {
    let mut table = Table::new(["", "this run"]);
    table
        .row(["waypoints".to_owned(), printed.poses.len().to_string()])
        .row(["unreachable".to_owned(), printed.unreachable.to_string()])
        .row(["shortest leg mm".to_owned(), format!("{:.2}", printed.min_leg_mm)])
        .row(["longest leg mm".to_owned(), format!("{:.2}", printed.max_leg_mm)])
        .row(["largest step of a leg mm".to_owned(), format!("{:.3}", printed.largest_step_mm)])
        .row(["least singularity measure".to_owned(), format!("{:.4}", printed.min_singularity)])
        .row(["legs found again to mm".to_owned(), format!("{:.1e}", printed.worst_leg_mm)])
        .row(["time s".to_owned(), format!("{:.3}", printed.time.as_secs_f64())]);
    table
}

fn summary(args: &Args, printed: &Printed, time: Duration) -> Result<Summary, Failure> {
    let failed = printed.failed_checks();
    let file = args.waypoints().and_then(|path| path.file_name()).map(|name| name.to_string_lossy().into_owned());
    let mut summary = Summary::new();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("layer", file.unwrap_or_else(|| "dome".to_owned()))?
        .set("radius_mm", args.radius_mm)?
        .set("rise_mm", args.rise_mm)?
        .set("spacing_mm", args.spacing_mm)?
        .set("nozzle_mm", args.nozzle_mm)?
        .set("threads", args.common.threads)?
        .set("waypoints", printed.poses.len())?
        .set("unreachable", printed.unreachable)?
        .set("min_leg_mm", printed.min_leg_mm)?
        .set("max_leg_mm", printed.max_leg_mm)?
        .set("min_singularity", printed.min_singularity)?
        .set("largest_step_mm", printed.largest_step_mm)?
        .set("worst_leg_mm", printed.worst_leg_mm)?
        .set("worst_tip_mm", printed.worst_tip_mm)?
        .set("lost", printed.lost)?
        .set("check_ok", failed.is_empty())?
        .set("checks_failed", failed.join(", "))?
        .set_seconds("table_s", printed.time)?
        .set_seconds("total_s", time)?;
    Ok(summary)
}

fn report(args: &Args, printed: &Printed) -> Report {
    let mut report = Report::new("A curved layer on a Stewart platform");
    report.paragraph(&format!(
        "The platform carries the part; the nozzle hangs {} mm above the base and stands still. The platform turns so that the \
         direction of growth is upright. The singularity measure is the change of the legs, in mm, when the platform \
         moves by 1 mm in the worst way: 0 where the legs do not hold it.",
        args.nozzle_mm
    ));
    if let Some((index, fault)) =
        printed.poses.iter().enumerate().find_map(|(index, pose)| pose.fault.map(|fault| (index, fault)))
    {
        report.notice(&format!("{} out of reach; number {index}: {fault}", counted(printed.unreachable, "waypoint")));
    }
    report.table("This run", &table(printed)).paragraph(&format!(
        "The layer was followed a second time by the legs alone, each pose found from the one before, as a control would: at {} of {} \
         waypoints that are reached the nozzle is more than a nanometre off. Legs, capsules {} mm thick, touch at {} waypoints; these count as \
         unreachable.",
        printed.lost,
        printed.poses.len() - printed.unreachable,
        2.0 * machine().leg_radius,
        printed.poses.iter().filter(|pose| matches!(pose.fault, Some(StewartFault::Legs { .. }))).count()
    ));
    if let (Some(first), Some(last)) = (printed.poses.first(), printed.poses.last()) {
        let toward = Vector3::new(0.55, -1.0, 0.45);
        let (begin, end) =
            (picture(printed, &first.base_platform, toward), picture(printed, &last.base_platform, toward));
        report.viewer(&build(printed));
        report.pictures(&[("at the first waypoint", &begin), ("at the last waypoint", &end)]);
    }
    report
}

/// The layer as it is printed, and the machine under it.
fn build(printed: &Printed) -> Model {
    let model = machine();
    let base = model.base.map(Point3::from);
    let mut before = printed.poses.first().map_or(Point3::origin(), |pose| pose.waypoint.position);
    let (mut steps, mut stances, mut seconds) = (Vec::new(), Vec::new(), 0.0);
    let stride = shown::stride(printed.poses.len());
    for (number, Pose { waypoint, base_platform, .. }) in printed.poses.iter().enumerate() {
        let (tip, direction) = (waypoint.position, *waypoint.axis);
        let took = (tip - before).norm() / SHOWN_MM_S;
        let kind = if number == 0 { Step::TRAVEL } else { 0 };
        steps.push(Step { tip, direction, width: LINE_MM, height: LINE_MM, kind, layer: 0, path: 0, seconds: took });
        (before, seconds) = (tip, seconds + took);
        if number % stride == 0 {
            let platform = model.platform.map(|joint| base_platform * Point3::from(joint));
            let ring = |joints: [Point3<f64>; 6]| (0..6).map(move |k| [joints[k], joints[(k + 1) % 6]]);
            let legs = (0..6).map(|k| [base[k], platform[k]]);
            let bones = ring(base).chain(ring(platform)).chain(legs).collect();
            stances.push(Stance { seconds, joints: Vec::new(), bones, part: *base_platform });
        }
    }
    let unreached = printed.poses.iter().filter(|pose| pose.fault.is_some());
    let places = unreached.map(|pose| Mark { at: pose.waypoint.position, path: None }).collect();
    let marks = Marks { what: "waypoints out of reach".to_owned(), colour: MISSED, places };
    Model {
        name: "a layer on a Stewart platform".to_owned(),
        kinds: vec!["path".to_owned()],
        steps,
        marks: vec![marks].into_iter().filter(|marks| !marks.places.is_empty()).collect(),
        robot: Some(Robot { name: "Stewart platform".to_owned(), speeds: Vec::new(), stances, is_shown: true }),
        ..Model::default()
    }
}

/// The machine at a pose, with the layer on it.
fn picture(printed: &Printed, base_platform: &Isometry3<f64>, toward: Vector3<f64>) -> Vec<u8> {
    let mut scene = Scene::new(Camera::from_direction(toward));
    let model = machine();
    let base = model.base.map(Point3::from);
    let platform = model.platform.map(|joint| base_platform * Point3::from(joint));
    for k in 0..6 {
        let next = (k + 1) % 6;
        scene.bar(base[k], base[next], 5.0, BASE);
        scene.bar(platform[k], platform[next], 3.0, INK);
        scene.bar(base[k], platform[k], model.leg_radius, INK);
        let middle = base_platform * Point3::origin();
        scene.triangles([([middle, platform[k], platform[next]], PLATE)]);
    }
    let rest = (printed.poses.len() / 3000).max(1);
    let shown: Vec<_> = printed.poses.iter().step_by(rest).collect();
    for (k, pair) in shown.windows(2).enumerate() {
        let ends = [pair[0], pair[1]].map(|pose| base_platform * pose.waypoint.position);
        let share = k as f64 / shown.len() as f64;
        scene.bar(ends[0], ends[1], 0.6, if pair[1].fault.is_some() { MISSED } else { ramp(share) });
    }
    if let Some(pose) = printed.poses.first() {
        let tip = pose.base_platform * pose.waypoint.position;
        scene.bar(tip, tip + Vector3::z() * 60.0, 2.5, NOZZLE);
    }
    let [width, height] = PICTURE;
    scene.draw(width, height).to_png()
}
