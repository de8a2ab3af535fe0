//! Summary for the operator: a table on stdout, and on top of the report. All other figures are in the report, behind a
//! fold, and in the summary.

use super::axes;
use super::shown::duration;
use crate::args::Stage;
use crate::choice::Choice;
use crate::guide::Guide;
use crate::job::{Job, Results};
use crate::motion::of_run;
use curvlay_examples::count::counted;
use curvlay_examples::findings::{Severity, percent};
use curvlay_examples::table::Table;

/// Size, layers, time, material, starts, what is wrong, and where the files are.
pub fn table(job: &Job, results: &Results) -> Table {
    let Job { args, part, folder, setup, .. } = job;
    let Results { field, surfaces, paths, machine, motion, preview, choice, .. } = results;
    let mut table = Table::new([part.name.as_str(), ""]);
    let mut row = |name: &str, text: String| _ = table.row([name.to_owned(), text]);
    if let Some([low, high]) = part.mesh.bounds() {
        let [x, y, z] = (high - low).into();
        row("size", format!("{x:.1} x {y:.1} x {z:.1} mm, {:.2} cm3", field.part_mm3 / 1000.0));
    }
    if let Some(name) = &args.settings.name {
        row("profile", name.clone());
    }
    if let Some(run) = preview {
        super::preview::people(job, run, &mut row);
    } else if let Some(surfaces) = surfaces {
        let halves = surfaces.half_layers();
        let mut layers = format!("{} of {:.3} mm", surfaces.sheets.len() - halves, surfaces.height_mm);
        if halves > 0 {
            layers += &format!(" and {}", counted(halves, "half layer"));
        }
        if let Some(paths) = paths {
            layers += &format!(", beads of {:.3} mm", paths.bead_mm);
        }
        row("layers", layers);
    }
    if let Some(order) = Guide::words(args).or_else(|| choice.as_ref().map(Choice::reason)) {
        row("order", order);
    }
    let infill = args.settings.infill();
    if paths.is_some() && !infill.is_solid() {
        let percent = 100.0 * infill.density;
        row(
            "filled",
            format!(
                "{}, skins of {}, {percent} % inside",
                counted(infill.walls, "wall"),
                counted(infill.skin, "layer")
            ),
        );
    }
    if let (Some(paths), Some(machine)) = (paths, machine) {
        let (deposition, of_nozzle) = (&machine.deposition, setup.cell.equipment().model().nozzle.tip_flat_mm);
        row("print time", duration(deposition.total_s));
        let (grams, cost) = args.settings.mass_and_cost(deposition.extruded_mm3);
        let mut material = format!(
            "{:.2} m of filament, {:.2} cm3",
            deposition.filament_mm / 1000.0,
            deposition.extruded_mm3 / 1000.0
        );
        grams.iter().for_each(|grams| material += &format!(", {grams:.1} g"));
        cost.iter().for_each(|cost| material += &format!(", costs {cost:.2}"));
        args.settings.material.iter().for_each(|name| material += &format!(" ({name})"));
        row("material", material);
        row(
            "starts",
            format!("{}; nozzle tip {of_nozzle} mm across (not the bead width)", machine.resolved.paths.len()),
        );
        row("printed", super::machine::filled(field, paths, machine));
    }
    if let Some(motion) = motion {
        row("robot time", duration(of_run!(motion, run => run.plan.robot_s())));
    }
    row("checks", checks(results));
    if args.stage >= Stage::Gcode {
        row("machine file", folder.path().join("toolpath.gcode").display().to_string());
    }
    if results.files.axes.is_some() {
        row("program of axes", folder.path().join(axes::FILE).display().to_string());
    }
    row("open", folder.path().join("report.html").display().to_string());
    table
}

/// What was checked, and what of it failed; the share of beads on nothing, also where that is allowed.
fn checks(results: &Results) -> String {
    let Results { surfaces, paths, machine, motion, files, findings, .. } = results;
    let checked: Vec<&str> = [
        ("order of the cells", true),
        ("surfaces", surfaces.is_some() && results.preview.is_none()),
        ("paths", paths.is_some()),
        ("nozzle, travels and beads", machine.is_some()),
        ("motions", motion.as_ref().is_some_and(|motion| of_run!(motion, run => run.checked.is_some()))),
        ("programs", files.has_read_programs()),
    ]
    .into_iter()
    .filter_map(|(what, is_checked)| is_checked.then_some(what))
    .collect();
    let (failed, warnings) = (findings.of(Severity::Failed).count(), findings.of(Severity::Warning).count());
    let plural = |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
    let failed = if failed == 0 { "none failed".to_owned() } else { format!("{} failed", plural(failed, "check")) };
    let mut text = format!("{failed} ({})", checked.join("; "));
    if warnings > 0 {
        text += &format!(", {}, see above", plural(warnings, "warning"));
    }
    let on_nothing = machine.as_ref().map_or(0.0, |run| run.support.unsupported_share());
    if on_nothing > 0.0 {
        text += &format!("; {} of the bead length is unsupported", percent(on_nothing));
    }
    text
}
