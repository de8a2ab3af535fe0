//! What the example leaves behind: tables on stdout, `summary.json`, `limits.csv`, `report.html`; `joints.csv` is written while the program runs.

use super::args::Args;
use super::axes::Axes;
use super::court::Court;
use super::judge::{Quantity, Worst};
use super::judged::place;
use super::machine::Machine;
use super::run::Executed;
use super::setup::Setup;
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::findings::Findings;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::plot::Plot;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_examples::viewer::{self, Mark, Marks, Model, Robot, Stance};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};
use std::io::{self, Write};
use std::time::Duration;

/// The table of axes over time.
pub const JOINTS: &str = "joints.csv";
const LIMITS: &str = "limits.csv";

/// Whether a run writes a file of that name.
pub fn is_ours(name: &str) -> bool {
    [JOINTS, LIMITS, "report.html"].contains(&name)
}

/// A run, once it is judged.
pub struct Run<'a> {
    /// What was asked for.
    pub args: &'a Args,
    /// What was replayed.
    pub setup: &'a Setup,
    /// What came of it.
    pub executed: Executed,
    /// The judges.
    pub court: Court<'a>,
    /// What they found.
    pub findings: Findings,
}

/// Writes the files, the summary last: where it is, all is there.
///
/// # Errors
/// A [`Failure`] from the folder.
pub fn write(run: Run, folder: &OutputFolder, time: Duration) -> Result<Vec<Table>, Failure> {
    folder.write_with(LIMITS, |out| limits(&run, out))?;
    let (tables, summary) = (tables(&run), summary(&run, time)?);
    folder.write("report.html", report(run).to_html())?;
    summary.write(folder)?;
    Ok(tables)
}

fn is_gcode(run: &Run) -> bool {
    matches!(run.setup.machine, Machine::FiveAxis(_))
}

/// A line for each axis.
fn limits(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "axis,max_speed,speed_share,max_acceleration,acceleration_share,max_jerk,jerk_share,beyond_range,file,step,time_s"
    )?;
    let joints = &run.court.joints;
    for (k, name) in run.setup.machine.axis_names().iter().enumerate() {
        let [range, speed, acceleration, jerk] = Quantity::ALL.map(|quantity| joints.shares[quantity as usize][k]);
        let [v, a, j] = [0, 1, 2].map(|order| joints.most[order][k]);
        let Worst { place, seconds, .. } =
            [speed, acceleration, jerk].into_iter().max_by(|a, b| a.value.total_cmp(&b.value)).unwrap_or_default();
        let file = run.executed.files.get(place.file as usize).map_or("", String::as_str);
        writeln!(
            out,
            "{name},{v:.6},{:.4},{a:.6},{:.4},{j:.6},{:.4},{:.6},{file},{},{seconds:.3}",
            speed.value, acceleration.value, jerk.value, range.value, place.step
        )?;
    }
    Ok(())
}

fn shown_share(worst: &Worst) -> String {
    if worst.value > 0.0 { format!("{:.0} %", 100.0 * worst.value) } else { "-".to_owned() }
}

/// What the program does, and the axes.
fn tables(run: &Run) -> Vec<Table> {
    let mut whole = Table::new(["what", "replayed", "planned"]);
    let Executed { seconds, programmed_s, obstacles, .. } = &run.executed;
    let planned = run.setup.planned_s.unwrap_or(*programmed_s);
    whole.row(["time s".to_owned(), format!("{seconds:.1}"), format!("{planned:.1}")]);
    whole.row(["moves".to_owned(), obstacles.moves.to_string(), "-".to_owned()]);
    let deposit = &run.court.deposit;
    let filament = run.court.tip.as_ref().map_or("-".to_owned(), |tip| format!("{:.1}", tip.planned_filament_mm));
    whole.row(["filament mm".to_owned(), format!("{:.1}", deposit.filament_mm), filament]);
    if let Some(tip) = &run.court.tip {
        whole.row(["extruded way mm".to_owned(), format!("{:.1}", tip.extruded_mm), format!("{:.1}", tip.planned_mm)]);
        whole.row(["tip off the plan mm, worst".to_owned(), format!("{:.3}", tip.worst_mm), "0".to_owned()]);
        whole.row([
            "tip off the plan mm, 95 %".to_owned(),
            format!("{:.3}", tip.errors.quantile(0.95)),
            "0".to_owned(),
        ]);
        let tilts = format!("{:.2}, {:.2}", tip.tilt.value, tip.tilts.quantile(0.95));
        whole.row(["nozzle direction off deg, worst and 95 %".to_owned(), tilts, "0".to_owned()]);
    }
    whole.row(["fastest tip mm/s".to_owned(), format!("{:.1}", run.court.max_tip_mm_s), "-".to_owned()]);
    let mut axes = Table::new(["axis", "speed", "of its limit", "acceleration", "of its limit", "jerk of its limit"]);
    let joints = &run.court.joints;
    for (k, name) in run.setup.machine.axis_names().iter().enumerate() {
        let (scale, unit) = if run.setup.machine.turns(k) { (1f64.to_degrees(), "deg") } else { (1.0, "mm") };
        let share = |quantity: Quantity| shown_share(&joints.shares[quantity as usize][k]);
        axes.row([
            name.clone(),
            format!("{:.2} {unit}/s", joints.most[0][k] * scale),
            share(Quantity::Speed),
            format!("{:.2} {unit}/s2", joints.most[1][k] * scale),
            share(Quantity::Acceleration),
            share(Quantity::Jerk),
        ]);
    }
    vec![whole, axes]
}

fn summary(run: &Run, time: Duration) -> Result<Summary, Failure> {
    let Run { args, setup, executed, court, .. } = run;
    let mut summary = Summary::new();
    let model = &setup.model;
    let plan = setup.plan.as_ref().map_or("none".to_owned(), |path| path.display().to_string());
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("program", setup.files.paths[0].display().to_string())?
        .set("format", setup.format())?
        .set("files", executed.files.len())?
        .set("machine", setup.machine.name())?
        .set("plan", plan)?
        .set("part_turn_deg", setup.placement.turn.to_degrees())?
        .set("part_shift_x_mm", setup.placement.shift_mm[0])?
        .set("part_shift_y_mm", setup.placement.shift_mm[1])?
        .set("nozzle", setup.nozzle_sizes.map(|size| size.to_string()).join(","))?
        .set("filament_diameter_mm", setup.filament_mm)?
        .set("profile", typed_name(model.profile))?
        .set("ramp_s", model.ramp_s)?
        .set("look_ahead", model.look_ahead)?
        .set("corner_mm", model.corner_mm)?
        .set("follower", typed_name(model.follower))?
        .set("lag_s", model.lag_s)?
        .set("speed_share", model.speed_share)?
        .set("rate_hz", model.rate_hz)?;
    for (key, value) in [("tip_acceleration_mm_s2", model.tip_mm_s2), ("joint_acceleration_rad_s2", model.joint_rad_s2)]
    {
        if value.is_finite() {
            summary.set(key, value)?;
        }
    }
    summary.set_all(&args.allow)?;
    summary
        .set("moves", executed.obstacles.moves)?
        .set("ticks", court.ticks)?
        .set("time_s", executed.seconds)?
        .set("programmed_s", executed.programmed_s)?
        .set("planned_s", setup.planned_s.unwrap_or(executed.programmed_s))?
        .set("targets_missed", executed.obstacles.missed.0)?
        .set("targets_turned", executed.obstacles.turned.0)?
        .set("zones_cut", executed.obstacles.cut.0)?
        .set("max_tip_mm_s", court.max_tip_mm_s)?;
    let names = setup.machine.axis_names();
    for (quantity, key) in
        [(Quantity::Speed, "speed"), (Quantity::Acceleration, "acceleration"), (Quantity::Jerk, "jerk")]
    {
        let (axis, worst) = court.joints.worst(quantity);
        summary
            .set(&format!("max_{key}_share"), worst.value)?
            .set(&format!("max_{key}_axis"), if worst.value > 0.0 { names[axis].as_str() } else { "none" })?
            .set(&format!("time_over_{key}_s"), court.joints.over_s[quantity as usize - 1])?;
    }
    let ranges = court.joints.worst(Quantity::Range).1.value;
    summary.set("beyond_range", ranges)?;
    if let Some(tip) = &court.tip {
        summary
            .set("tip_off_mm", tip.worst_mm)?
            .set("tip_off_share", tip.worst.value)?
            .set("tip_off_95_mm", tip.errors.quantile(0.95))?
            .set("tip_off_50_mm", tip.errors.quantile(0.5))?
            .set("tilt_off_deg", tip.tilt.value)?
            .set("tilt_off_95_deg", tip.tilts.quantile(0.95))?
            .set("tilt_off_50_deg", tip.tilts.quantile(0.5))?
            .set("tilted_mm", tip.tilted_mm)?
            .set("extruded_mm", tip.extruded_mm)?
            .set("off_plan_mm", tip.off_mm)?
            .set("stray_mm", tip.stray_mm)?
            .set("planned_mm", tip.planned_mm)?
            .set("missed_mm", tip.missed_mm)?
            .set("planned_filament_mm", tip.planned_filament_mm)?;
    }
    let deposit = &court.deposit;
    summary
        .set("filament_mm", deposit.filament_mm)?
        .set("stray_filament_mm", deposit.stray_filament_mm)?
        .set("compared_mm", deposit.compared_mm)?
        .set("area_off_mm", deposit.off_mm)?
        .set("max_area_off_share", deposit.worst.value)?
        .set("extruding_at_rest_s", deposit.rest_s)?
        .set("capsules", court.contact.beads())?
        .set("contacts", court.contact.built.times)?
        .set("contact_s", court.contact.built.seconds)?
        .set("max_contact_mm", court.contact.built.worst.value)?
        .set("plate_contacts", court.contact.plate.times)?
        .set("max_plate_contact_mm", court.contact.plate.worst.value)?
        .set("threads", args.common.threads)?;
    run.findings.summary(&mut summary)?;
    summary.set_seconds("total_s", time)?;
    Ok(summary)
}

/// Where findings are.
fn marks(run: &Run) -> Vec<Marks> {
    const RED: [u8; 3] = [198, 47, 34];
    let court = &run.court;
    let allow = &run.args.allow;
    let mut all = Vec::new();
    let mut mark = |what: &str, worst: &Worst, is_failed: bool| {
        if let (Some(at), true) = (worst.tip, is_failed) {
            let what = format!("{what} ({})", place(&run.executed, is_gcode(run), worst));
            all.push(Marks { what, colour: RED, places: vec![Mark { at, path: None }] });
        }
    };
    if let Some(tip) = &court.tip {
        mark("tip off the planned path", &tip.worst, tip.worst.value > allow.allow_tip);
        mark("nozzle direction differs from the plan", &tip.tilt, tip.tilt.value > allow.allow_tilt_deg);
        mark("extruder runs between paths", &tip.stray, tip.stray_mm > allow.allow_stray * tip.extruded_mm);
        mark(
            "bead thicker or thinner than planned",
            &court.deposit.worst,
            court.deposit.off_mm > allow.allow_area_share * court.deposit.compared_mm,
        );
    }
    mark("material comes out at rest", &court.deposit.rest, court.deposit.rest.value > allow.allow_rest);
    mark("nozzle in what is built", &court.contact.built.worst, court.contact.built.times > 0);
    mark("nozzle in the plate", &court.contact.plate.worst, court.contact.plate.times > 0);
    all
}

/// A robot as the viewer shows it.
fn robot(machine: &Machine, shown: &[(f64, Axes)]) -> Option<Robot> {
    let Machine::Robot(robot) = machine else { return None };
    let stances = shown.iter().map(|(seconds, axes)| {
        let (bones, part) = robot.drawn(axes);
        let turn: Matrix3<f64> = part.turn;
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
        let part = Isometry3::from_parts(Translation3::from(part.at), turn);
        Stance { seconds: *seconds, joints: axes[..robot.axes()].to_vec(), bones, part }
    });
    let speeds = robot.limits.speed[..robot.axes()].to_vec();
    Some(Robot { name: robot.name.clone(), speeds, stances: stances.collect(), is_shown: false })
}

fn report(run: Run) -> Report {
    let mut report = Report::new("Replay of a program");
    run.findings.report(&mut report);
    let tables = tables(&run);
    let Executed { files, .. } = &run.executed;
    report.paragraph(&format!(
        "{} of {}, on: {}. A model of the controller executes it ({} profile, look-ahead of {} moves, {} ticks a second); another controller differs.",
        if files.len() == 1 { files[0].clone() } else { format!("{} files", files.len()) },
        run.setup.files.paths[0].parent().map_or_else(String::new, |folder| folder.display().to_string()),
        run.setup.machine.name(),
        typed_name(run.setup.model.profile),
        run.setup.model.look_ahead,
        run.setup.model.rate_hz
    ));
    report.table("", &tables[0]);
    let marks = marks(&run);
    let [tip, cone_deg, cone, block] = run.setup.nozzle_sizes;
    let names = run.setup.machine.axis_names();
    let Run { setup, court, .. } = run;
    let model = Model {
        name: setup.machine.name().to_owned(),
        kinds: vec!["bead".to_owned()],
        steps: court.steps.finish(),
        marks,
        nozzle: Some(viewer::Nozzle { tip, half_angle_deg: cone_deg, cone, block }),
        robot: robot(&setup.machine, &court.shown.finish()),
        ..Model::default()
    };
    if !model.steps.is_empty() {
        report.viewer(&model);
    }
    report.heading("The tip");
    let mut plot = Plot::new("time in s", "speed of the tip in mm/s");
    plot.line("greatest of each moment", [11, 122, 117], court.speeds.finish());
    report.plot("Speed over the part", &plot);
    let errors = court.errors.finish();
    if !errors.is_empty() {
        let mut plot = Plot::new("time in s", "distance to the plan in mm");
        plot.line("greatest of each moment", [176, 60, 50], errors);
        report.plot("How far the tip is off the plan while it extrudes", &plot);
    }
    report.heading("The axes").table("", &tables[1]);
    const COLOURS: [[u8; 3]; 8] = [
        [11, 122, 117],
        [176, 60, 50],
        [70, 90, 180],
        [200, 140, 20],
        [120, 60, 150],
        [60, 140, 60],
        [90, 90, 90],
        [220, 90, 150],
    ];
    let mut turning = Plot::new("time in s", "axis in degrees");
    let mut sliding = Plot::new("time in s", "axis in mm");
    for (k, (curve, name)) in court.curves.into_iter().zip(&names).enumerate() {
        let plot = if setup.machine.turns(k) { &mut turning } else { &mut sliding };
        plot.line(name, COLOURS[k % COLOURS.len()], curve.finish());
    }
    for plot in [&turning, &sliding] {
        if plot.names().next().is_some() {
            report.plot("Axes over time", plot);
        }
    }
    report
}
