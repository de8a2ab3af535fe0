//! What the example leaves behind: a table on stdout, `summary.json`, `places.csv`, `report.html`.

use super::args::Args;
use super::figures::{Audited, Found, Laid, Verdict};
use super::judged;
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::findings::Findings;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use std::io::{self, Write};
use std::time::Duration;

const PLACES: &str = "places.csv";

/// Whether a run writes a file of that name.
pub fn is_ours(name: &str) -> bool {
    [PLACES, "report.html"].contains(&name)
}

/// A run, once it is judged.
pub struct Run<'a> {
    /// What was asked for.
    pub args: &'a Args,
    /// What the checks say.
    pub audited: &'a Audited,
    /// What is wrong.
    pub findings: &'a Findings,
}

/// Writes the files, the summary last: where it is, all is there.
///
/// # Errors
/// A [`Failure`] from the folder.
pub fn write(run: &Run, folder: &OutputFolder, time: Duration) -> Result<Vec<Table>, Failure> {
    folder.write_with(PLACES, |out| places(run, out))?;
    folder.write("report.html", report(run).to_html())?;
    summary(run, time)?.write(folder)?;
    Ok(vec![about(run), table(run)])
}

/// A line for each place.
fn places(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "check,x_mm,y_mm,z_mm,layer,size")?;
    for (check, verdict) in run.audited.in_order() {
        let Verdict::Found(found) = verdict else { continue };
        for place in &found.places {
            let layer = place.layer.map_or(String::new(), |layer| layer.to_string());
            let at = place.at;
            writeln!(out, "{},{:.4},{:.4},{:.4},{layer},{:.4}", check.key(), at.x, at.y, at.z, place.size)?;
        }
    }
    Ok(())
}

fn about(run: &Run) -> Table {
    let mut table = Table::new(["", ""]);
    table.row(["input".to_owned(), run.args.input.display().to_string()]);
    table.row(["read as".to_owned(), run.audited.meant.clone()]);
    for (key, value) in &run.audited.about {
        table.row([key.replace('_', " "), shown(*value)]);
    }
    table
}

fn shown(value: f64) -> String {
    if value.fract().abs() > 0.0 { format!("{value:.4}") } else { format!("{value:.0}") }
}

/// The checks: what was found, and why others have no figure.
fn table(run: &Run) -> Table {
    let mut table = Table::new(["check", "found", "share", "allowed", "worst place, or why there is no figure"]);
    for (check, verdict) in run.audited.in_order() {
        match verdict {
            Verdict::Absent(why) => table.row([check.name(), "absent", "", "", why]),
            Verdict::Found(found) => {
                let share = found.share.map_or(String::new(), |share| format!("{:.3} %", 100.0 * share));
                let allowed = format!("{} %", 100.0 * judged::allowed(run.args, check).0);
                table.row([check.name().to_owned(), found.shown(), share, allowed, words(found)])
            }
        };
    }
    table
}

fn words(found: &Found) -> String {
    let worst = found.places.first().map(judged::place);
    [worst, Some(found.note.clone()).filter(|note| !note.is_empty())]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join("; ")
}

fn summary(run: &Run, time: Duration) -> Result<Summary, Failure> {
    let Run { args, audited, findings } = run;
    let mut summary = Summary::new();
    let mesh = args.part.mesh.as_ref().map_or("none".to_owned(), |path| path.display().to_string());
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("input", args.input.display().to_string())?
        .set("read_as", audited.meant.as_str())?
        .set("mesh", mesh)?
        .set("nozzle", args.nozzle_sizes().map(|size| size.to_string()).join(","))?
        .set("scale", args.input_scale)?
        .set("layers_as_one", args.layers_as_one.unwrap_or(1))?
        .set("machine", args.machine.as_ref().map_or("none".to_owned(), |path| path.display().to_string()))?
        .set("max_tilt_deg", args.max_tilt_deg)?
        .set("clearance_cells", args.clearance_cells)?
        .set("eps_cells", args.eps_cells)?
        .set("beyond_eps", args.beyond_eps)?
        .set("platform_diameter_mm", args.platform_mm)?
        .set("max_cells", args.max_cells)?
        .set_all(&args.allow)?;
    rules(&mut summary, args, audited.laid)?;
    for (key, value) in &audited.about {
        number(&mut summary, key, *value)?;
    }
    for (check, verdict) in audited.in_order() {
        let Verdict::Found(found) = verdict else { continue };
        number(&mut summary, &format!("{}_{}", check.key(), found.unit), found.amount)?;
        if let Some(share) = found.share {
            summary.set(&format!("{}_share", check.key()), share)?;
        }
        for (key, value) in &found.more {
            number(&mut summary, key, *value)?;
        }
        if let Some(worst) = found.places.first() {
            summary.set(&format!("{}_worst", check.key()), judged::place(worst))?;
        }
    }
    let absent = audited.in_order().filter(|(_, verdict)| matches!(verdict, Verdict::Absent(_)));
    summary.set("absent", absent.map(|(check, _)| check.key()).collect::<Vec<_>>().join(","))?;
    summary.set("threads", args.common.threads)?;
    findings.summary(&mut summary)?;
    summary.set_seconds("total_s", time)?;
    Ok(summary)
}

/// The options of what was laid.
fn rules(summary: &mut Summary, args: &Args, laid: Laid) -> Result<(), Failure> {
    let (bead, sheet) = (&args.bead, &args.sheet);
    if laid == Laid::Cells {
        return Ok(());
    }
    summary
        .set("support_distance_heights", bead.support_distance)?
        .set("support_drop_heights", bead.support_drop)?
        .set("air_reach_widths", bead.air_reach)?
        .set("contact_heights", bead.contact)?
        .set("overlap_share", bead.overlap)?
        .set("slack_heights", bead.slack)?;
    match laid {
        Laid::Layers => {
            summary.set("surface", typed_name(sheet.side))?.set("up", typed_name(sheet.layers_up))?;
            summary.set("plate_mm", sheet.plate_mm)?
        }
        _ => summary.set("sharp_turn_deg", bead.sharp_deg)?,
    };
    Ok(())
}

/// Counts are whole numbers in the summary.
fn number(summary: &mut Summary, key: &str, value: f64) -> Result<(), Failure> {
    let is_count = value.fract().abs() <= 0.0 && (0.0..1e15).contains(&value) && !key.ends_with("_mm");
    if is_count {
        summary.set(key, value as u64)?
    } else {
        summary.set(key, value)?
    };
    Ok(())
}

fn report(run: &Run) -> Report {
    let mut report = Report::new("Audit of a result");
    run.findings.report(&mut report);
    report.table("What was audited", &about(run)).table("What was found", &table(run));
    let pictures: Vec<(&str, &[u8])> =
        run.audited.pictures.iter().map(|(caption, png)| (caption.as_str(), png.as_slice())).collect();
    if !pictures.is_empty() {
        report.heading("Pictures, with the worst place of each check").pictures(&pictures);
    }
    let mut all = Table::new(["check", "place", "size"]);
    for (check, verdict) in run.audited.in_order() {
        let Verdict::Found(found) = verdict else { continue };
        for place in &found.places {
            all.row([check.name().to_owned(), judged::place(place), format!("{:.3}", place.size)]);
        }
    }
    if !all.rows().is_empty() {
        report.heading("Places").table("The first 20 of each check, the worst first", &all);
    }
    report
}
