//! What the example leaves behind: the table on stdout, `summary.json`, trajectories and `report.html`.

use super::planning::{FREED, Figures, HistoryStep, Planned, beyond};
use super::plot::{Curve, draw};
use super::shortened::{FAULTS, shortened};
use super::studied::{find_collisions, report_study, set_study};
use super::{Args, Results, Run};
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::findings::{Findings, Severity, accept};
use curvlay_examples::output::OutputFolder;
use curvlay_examples::plot::Plot;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_trajectory::Trajectory;
use std::io::{self, Write};
use std::time::Duration;

/// Colours of joints in plots.
const JOINTS: [[u8; 3]; 8] = [
    [47, 111, 176],
    [214, 102, 23],
    [46, 139, 87],
    [178, 34, 52],
    [120, 81, 169],
    [140, 86, 75],
    [0, 139, 139],
    [128, 128, 0],
];

/// Waypoints are met within this.
const MET_MM: f64 = 1e-6;
const MET_RAD: f64 = 1e-9;

/// Table 4.2 of the dissertation, its layer of 2,545 waypoints on its own UR3: J, greatest jerk, seconds.
const PAPER: [(&str, f64, f64, f64); 2] =
    [("dissertation, WS1", 232.0, 0.97, 116.0), ("dissertation, dense graph", 1340.0, 5.26, 1837.0)];

/// The same table: greatest jerk of each joint on WS1, before and after Algorithm 6 and on the dense graph.
const PAPER_JOINTS: [(&str, [f64; 6]); 3] = [
    ("dissertation, ladder", [15.16, 5.13, 5.92, 6.32, 21.87, 17.72]),
    ("dissertation, local", [0.76, 0.80, 0.97, 0.97, 0.94, 0.74]),
    ("dissertation, dense graph", [1.85, 1.09, 1.75, 1.35, 2.24, 5.26]),
];

impl Results {
    /// Every robot's figures by method.
    fn rows(&self) -> Vec<(String, &Figures)> {
        let mut rows = Vec::new();
        if let Some(run) = &self.ur3 {
            add_rows(run, &mut rows);
        }
        if let Some(run) = &self.cell8 {
            add_rows(run, &mut rows);
        }
        rows
    }

    /// The robots, and where their ladders break off: waypoints counted over all pieces of the path.
    fn breaks(&self) -> Vec<(&'static str, &[usize])> {
        let ur3 = self.ur3.as_ref().and_then(breaks);
        let cell8 = self.cell8.as_ref().and_then(breaks);
        ur3.into_iter().chain(cell8).collect()
    }

    /// Where the path is split, and where ladders break off on it.
    fn splits(&self) -> usize {
        self.path.segments.len() - 1 + self.breaks().iter().map(|(_, waypoints)| waypoints.len()).sum::<usize>()
    }

    /// What is wrong with the path, and where ladders break off on it: a line each, in the order of the waypoints.
    pub fn faults(&self) -> Vec<String> {
        let given: Vec<usize> = self.path.segments.iter().flat_map(|piece| &piece.waypoints).copied().collect();
        let mut faults: Vec<(usize, String)> =
            self.path.defects.iter().map(|defect| (defect.waypoint(), defect.to_string())).collect();
        for (robot, waypoints) in self.breaks() {
            faults.extend(waypoints.iter().map(|&waypoint| {
                let waypoint = given[waypoint];
                (waypoint, format!("waypoint {waypoint}: {robot} is too slow to go on; its motion begins anew"))
            }));
        }
        faults.sort();
        faults.into_iter().map(|(_, what)| what).collect()
    }

    /// What is wrong with the path, and with the motions on it.
    pub fn findings(&self, args: &Args) -> Findings {
        let mut findings = Findings::default();
        shortened(self.faults()).into_iter().for_each(|fault| findings.add(Severity::Warning, fault, "", ""));
        for (name, figures) in self.rows() {
            if !(figures.missed_mm <= MET_MM && figures.missed_rad <= MET_RAD) {
                let amount = format!("by {:.1e} mm, {:.1e} rad", figures.missed_mm, figures.missed_rad);
                findings.add(Severity::Failed, format!("{name}: waypoints are missed"), amount, "");
            }
            // Only the global filter holds bounds between waypoints, and noise may ask for more than there is.
            if name.ends_with("_global") && !name.contains("noise") {
                find_broken(&name, figures, args.allow_jerk, &mut findings);
            }
        }
        if let Some(study) = &self.study {
            find_collisions(study, &mut findings);
        }
        findings
    }
}

/// Bounds that do not hold. One on jerk may be broken by a share: what it costs is smoothness.
fn find_broken(name: &str, figures: &Figures, allow_jerk: f64, findings: &mut Findings) {
    if let Some((count, worst)) = figures.broken(false) {
        let what = format!("{name}: limits of speed or acceleration are passed");
        findings
            .explain(Severity::Failed, what, format!("{count}, the worst: {worst}"), "report.html")
            .try_to("a lower --feed");
    }
    if let Some((count, worst)) = figures.broken(true) {
        let share = beyond(worst);
        let what = format!("{name}: limits of jerk are passed");
        let amount = format!("{count}, the worst: {worst}");
        let finding = findings.explain(Severity::above(share, allow_jerk), what, amount, "report.html");
        if let Some(least) = figures.jerk_lower_bound.filter(|least| *least > 1.0) {
            finding.cause(format!(
                "the path asks for it: by the last linearised problem of the filter some jerk is at least {least:.3} times its limit"
            ));
        }
        finding.try_to("a lower --feed").allow(accept("--allow-jerk", share));
    }
}

fn add_rows<'a, const N: usize>(run: &'a Run<N>, rows: &mut Vec<(String, &'a Figures)>) {
    let row =
        |middle: &str, planned: &'a Planned<N>| (format!("{}_{middle}{}", run.robot, planned.method), &planned.figures);
    rows.extend(run.planned.iter().map(|planned| row("", planned)));
    for (degrees, planned) in &run.noisy {
        rows.extend(planned.iter().map(|planned| row(&format!("noise{degrees}_"), planned)));
    }
}

/// Where the ladder of a robot breaks off.
fn breaks<const N: usize>(run: &Run<N>) -> Option<(&'static str, &[usize])> {
    let ladder = run.planned.iter().find(|planned| planned.method == "ladder")?;
    Some((run.robot, &ladder.figures.breaks))
}

/// Whether a file of this name is one that a run writes.
pub fn is_ours(name: &str) -> bool {
    [FAULTS, "ur3_trajectory.csv", "cell8_trajectory.csv", "report.html"].contains(&name)
}

pub fn write(
    args: &Args,
    (results, findings): (&Results, &Findings),
    folder: &OutputFolder,
    time: Duration,
) -> Result<(), Failure> {
    if let Some(run) = &results.ur3 {
        write_run(run, folder)?;
    }
    if let Some(run) = &results.cell8 {
        write_run(run, folder)?;
    }
    let faults = results.faults();
    folder
        .write_list(FAULTS, !faults.is_empty(), |out| faults.iter().try_for_each(|fault| writeln!(out, "{fault}")))?;
    folder.write("report.html", report(args, results, findings).to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, (results, findings), time)?.write(folder)?;
    Ok(())
}

/// The motion to run: the last but the grid and the one that may pass its bounds.
pub fn smoothest<const N: usize>(planned: &[Planned<N>]) -> Option<&Planned<N>> {
    planned.iter().rfind(|planned| planned.method != "grid" && planned.method != FREED)
}

fn write_run<const N: usize>(run: &Run<N>, folder: &OutputFolder) -> Result<(), Failure> {
    if let Some(planned) = smoothest(&run.planned) {
        folder.write_with(&format!("{}_trajectory.csv", run.robot), |out| knots(&planned.trajectories, out))?;
    }
    Ok(())
}

/// A line for each knot: run, time, joints. Between them the joints follow the C2 cubic spline, at rest at both ends.
fn knots<const N: usize>(trajectories: &[Trajectory<N>], out: &mut dyn Write) -> io::Result<()> {
    let names: Vec<String> = (1..=N).map(|joint| format!("q{joint}_rad")).collect();
    writeln!(out, "run,time_s,{}", names.join(","))?;
    for (run, trajectory) in trajectories.iter().enumerate() {
        for (time, joints) in trajectory.times().iter().zip(trajectory.joints()) {
            write!(out, "{run},{time:.6}")?;
            joints.iter().try_for_each(|angle| write!(out, ",{angle:.9}"))?;
            writeln!(out)?;
        }
    }
    Ok(())
}

/// All methods. The greatest jerk by Eq. 4.10 is what the dissertation has, that of the spline is what runs.
pub fn table(results: &Results) -> Table {
    let mut table = Table::new([
        "",
        "J, Eq. 4.10",
        "max jerk, Eq. 4.10",
        "max jerk, spline",
        "integral of squared jerk",
        "max speed",
        "runs",
        "time s",
    ]);
    for (name, figures) in results.rows() {
        table.row([
            name.replace('_', " "),
            format!("{:.2}", figures.j),
            format!("{:.3}", figures.jerk_at_waypoints()),
            format!("{:.3}", figures.jerk()),
            format!("{:.2}", figures.spline_jerk),
            format!("{:.3}", figures.velocity),
            figures.runs.to_string(),
            format!("{:.3}", figures.time.as_secs_f64()),
        ]);
    }
    for (name, j, jerk, seconds) in PAPER {
        let [j, jerk, seconds] = [format!("{j:.0}"), jerk.to_string(), format!("{seconds:.0}")];
        table.row([name, &j, &jerk, "-", "-", "-", "-", &seconds]);
    }
    table
}

/// Greatest jerk of each joint for each method, by both measures; of the UR3 beside the dissertation's layer WS1.
fn joints<const N: usize>(run: &Run<N>) -> Table {
    let paper: &[(&str, [f64; 6])] = if run.robot == "ur3" { &PAPER_JOINTS } else { &[] };
    let heads = run.planned.iter().flat_map(|planned| {
        let method = planned.method.replace('_', " ");
        [format!("{method}, Eq. 4.10"), format!("{method}, spline")]
    });
    let theirs = paper.iter().map(|(name, _)| format!("{name}, Eq. 4.10"));
    let mut table = Table::new(["joint".to_owned()].into_iter().chain(heads).chain(theirs));
    for joint in 0..N {
        let ours = run.planned.iter().flat_map(|Planned { figures, .. }| {
            [figures.waypoint_jerk[joint], figures.joint_jerk[joint]].map(|jerk| format!("{jerk:.3}"))
        });
        let theirs = paper.iter().map(|(_, jerks)| jerks[joint].to_string());
        table.row([(joint + 1).to_string()].into_iter().chain(ours).chain(theirs));
    }
    table
}

fn summary(args: &Args, (results, findings): (&Results, &Findings), time: Duration) -> Result<Summary, Failure> {
    let file = args.waypoints().and_then(|path| path.file_name()).map(|name| name.to_string_lossy().into_owned());
    let mut summary = Summary::new();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("path", file.unwrap_or_else(|| "spiral".to_owned()))?
        .set("crest_mm", args.crest_mm)?
        .set("feed_mm_s", args.feed_mm_s.map_or_else(|| "none".into(), serde_json::Value::from))?
        .set("robots", typed_name(args.robots))?
        .set("noise_waypoints", args.noise_count)?
        .set("post_mm", args.post().unwrap_or(0.0))?
        .set("allow_jerk", args.allow_jerk)?
        .set("threads", args.common.threads)?
        .set("given", results.given)?
        .set("waypoints", results.path.segments.iter().map(|piece| piece.waypoints.len()).sum::<usize>())?
        .set("pieces", results.path.segments.len())?
        .set("defects", results.path.defects.len())?
        .set("splits", results.splits())?;
    for (name, figures) in results.rows() {
        summary
            .set(&format!("{name}_j"), figures.j)?
            .set(&format!("{name}_spline_jerk"), figures.spline_jerk)?
            .set(&format!("{name}_max_waypoint_jerk"), figures.jerk_at_waypoints())?
            .set(&format!("{name}_max_jerk"), figures.jerk())?
            .set(&format!("{name}_max_acceleration"), figures.acceleration)?
            .set(&format!("{name}_max_velocity"), figures.velocity)?
            .set(&format!("{name}_runs"), figures.runs)?
            .set(&format!("{name}_missed_mm"), figures.missed_mm)?
            .set(&format!("{name}_missed_rad"), figures.missed_rad)?
            .set(&format!("{name}_strayed_mm"), figures.strayed_mm)?
            .set(&format!("{name}_limits_broken"), figures.violations.len())?
            .set_seconds(&format!("{name}_plan_s"), figures.time)?;
        if let Some(bound) = figures.jerk_lower_bound {
            summary.set(&format!("{name}_jerk_lower_bound"), bound)?;
        }
        if let Some(bound) = figures.speed_lower_bound {
            summary.set(&format!("{name}_speed_lower_bound"), bound)?;
        }
    }
    let ur3 = results.ur3.as_ref().map(|run| ("ur3", &run.notes));
    let cell8 = results.cell8.as_ref().map(|run| ("cell8", &run.notes));
    for (robot, notes) in ur3.into_iter().chain(cell8).filter(|(_, notes)| !notes.is_empty()) {
        summary.set(&format!("{robot}_notes"), notes.join("; "))?;
    }
    if let Some(study) = &results.study {
        set_study(study, &mut summary)?;
    }
    findings.summary(&mut summary)?;
    summary.set_seconds("total_s", time)?;
    Ok(summary)
}

fn report(args: &Args, results: &Results, findings: &Findings) -> Report {
    let mut report = Report::new("Robot motion with little jerk");
    let waypoints: usize = results.path.segments.iter().map(|piece| piece.waypoints.len()).sum();
    report.paragraph(&format!(
        "{waypoints} waypoints, pieces of the path: {}. A waypoint leaves the turn about the nozzle's axis free, over the table \
         its tilt and turn; the nozzle on the arm turns with joint 6 alone, which rests. The ladder takes the shortest path \
         through a few samples of what is free, the grid through one at every degree, the local filter is Algorithm 6 from \
         the ladder, the global filter takes all waypoints at once. Central differences at the waypoints (Eq. 4.10) give J, \
         the sum of squared jerks, and a greatest jerk, as in the dissertation. What runs is the C2 spline through the \
         waypoints, from rest to rest: the bounds, 1 rad/s, 5 rad/s^2 and 1 rad/s^3, are of the spline, everywhere.",
        results.path.segments.len()
    ));
    findings.report(&mut report);
    report.table("All methods", &table(results));
    if results.rows().iter().any(|(name, _)| name.ends_with(FREED)) {
        report.paragraph(
            "The local filter passes bounds on speed or acceleration: \"global freed\" is the global filter within what the local one \
             reaches.",
        );
    }
    if args.noise_count > 0 {
        report.paragraph(&format!(
            "The rows with noise are over the first {} waypoints, their directions turned by up to 5, 10 and 15 degrees, \
             with the makers' greatest speeds. The dissertation's layers are not public, so its rows are those of other \
             paths of that length.",
            args.noise_count
        ));
    }
    if let Some(run) = &results.ur3 {
        pictures(run, &mut report);
    }
    if let Some(run) = &results.cell8 {
        pictures(run, &mut report);
    }
    if let Some(study) = &results.study {
        report_study(study, &mut report);
    }
    report
}

/// How a filter went, step by step: Figs. 4.3 and 4.4 of the dissertation.
fn histories<const N: usize>(planned: &Planned<N>, report: &mut Report) {
    let Planned { method, history, .. } = planned;
    if history.len() < 2 {
        return;
    }
    let (step, objective, jerk) = match *method {
        "local" => ("window", "J in rad^2/s^6", "greatest jerk at the waypoints, rad/s^3"),
        _ => ("round", "integral of the squared jerk, rad^2/s^5", "greatest jerk over its limit"),
    };
    let line = |of: &dyn Fn(&HistoryStep) -> f64| -> Vec<[f64; 2]> {
        (1..).zip(history).map(|(number, step)| [f64::from(number), of(step)]).collect()
    };
    let mut plot = Plot::new(step, objective);
    plot.line(method, JOINTS[0], line(&|step| step.objective));
    report.plot(&format!("{method} filter: what it lowers, after each {step}"), &plot);
    let mut plot = Plot::new(step, jerk);
    let joints = history[0].jerk.len();
    for joint in 0..joints {
        let name = if joints > 1 { format!("joint {}", joint + 1) } else { "all joints".to_owned() };
        plot.line(&name, JOINTS[joint % JOINTS.len()], line(&|step| step.jerk[joint]));
    }
    report.plot(&format!("{method} filter: {jerk}, after each {step}"), &plot);
}

fn pictures<const N: usize>(run: &Run<N>, report: &mut Report) {
    let (Some(before), Some(after)) = (run.planned.first(), smoothest(&run.planned)) else { return };
    let (before_figures, after_figures) = (&before.figures, &after.figures);
    report.heading(&format!("{}: {} in grey, {} in orange", run.robot, before.method, after.method));
    report.table("Greatest jerk of each joint, rad/s^3", &joints(run));
    run.shown.iter().for_each(|model| _ = report.viewer(model));
    run.planned.iter().for_each(|planned| histories(planned, report));
    let draw = |curve| draw(&before.trajectories, &after.trajectories, curve);
    report.picture("joint angles over time, rad", &draw(Curve::Angle));
    report.picture("jerk over time, rad/s^3", &draw(Curve::Jerk));
    if let Some(speed) = before_figures.speed_lower_bound.filter(|speed| *speed > 1.0) {
        report.notice(&format!(
            "The path breaks off: no motion that meets its waypoints in time has less than {speed:.3} times the speed limit \
             of some joint, with any tool angles and on any branch"
        ));
    }
    for note in &run.notes {
        report.notice(note);
    }
    for violation in after_figures.violations.iter().take(12) {
        report.paragraph(&format!("beyond its bound: {violation}"));
    }
}
