//! Writes what the stages have made: files, summary, report, and the tables on stdout.

use super::{axes, build, field, machine, motion, paths, people, preview, programs, surfaces, tmf, workcell};
use crate::args::{Extra, Stage, failure};
use crate::job::{Job, Posed, Results};
use crate::motion::{Motion, of_run, trajectory};
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::orienting::COMMENT;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_examples::viewer::Model;
use curvlay_toolpath::fill::FilledLayer;
use std::ops::Range;

/// Writes the motion itself, which is checked before all else is written.
pub fn trajectory(motion: &Motion, folder: &OutputFolder) -> Result<(), Failure> {
    folder.write_with(trajectory::FILE, |out| of_run!(motion, run => trajectory::write_csv(run, out)))?;
    Ok(())
}

/// Writes what a stage has made, and the summary of all that is there by then; after the last one the report before it, and the
/// tables on stdout.
pub fn write(stage: Stage, job: &Job, results: &mut Results) -> Result<(), Failure> {
    products(stage, job, results)?;
    let tables = tables(job, results);
    let is_last = stage == job.args.stage;
    if is_last {
        let build = build::model(job, results);
        job.folder.write("report.html", report(job, results, &tables, &build)?.to_html())?;
        job.folder.write_list("build.glb", job.args.also.contains(&Extra::Gltf), |out| build.write_glb(out))?;
    }
    // The summary comes last, when all files that it describes are there.
    summary(stage, job, results)?.write(job.folder)?;
    if is_last {
        people::table(job, results).print().map_err(failure)?;
    }
    Ok(())
}

/// The summary of a run that fills a range of layers, from 0, and its table on stdout.
pub fn write_range(
    job: &Job,
    results: &Results,
    range: Range<usize>,
    layers: &[Option<FilledLayer>],
) -> Result<(), Failure> {
    let filled = || layers.iter().flatten();
    let (curves, length_mm) = (
        filled().map(|layer| layer.paths.paths.len()).sum::<usize>(),
        filled().map(|layer| layer.statistics.path_mm).sum::<f64>(),
    );
    // The other ranges go on from here.
    if let Some(surfaces) = results.surfaces.as_ref().filter(|_| job.args.resume.is_none()) {
        write_posed(job)?;
        surfaces::write_saved(surfaces, job.folder)?;
    }
    let mut figures = summary(Stage::Paths, job, results)?;
    figures
        .set("layers_first", range.start + 1)?
        .set("layers_last", range.end)?
        .set("range_curves", curves)?
        .set("range_path_mm", length_mm)?;
    figures.write(job.folder)?;
    let mut table = Table::new(["Layers", ""]);
    table
        .row([
            "layers".to_owned(),
            format!(
                "{}..{} of {}",
                range.start + 1,
                range.end,
                figures.get("surfaces").map_or(0, |n| n.as_u64().unwrap_or(0))
            ),
        ])
        .row(["curves".to_owned(), format!("{curves}, {:.1} m", length_mm / 1000.0)]);
    Table::print_all([&table]).map_err(failure)
}

/// The part as it was turned, if it was.
fn write_posed(job: &Job) -> Result<(), Failure> {
    if job.posed.is_some() {
        job.folder.write_with("oriented.obj", |out| job.part.mesh.write_obj(COMMENT, out))?;
    }
    Ok(())
}

/// The files of a stage. Programs that would be wrong are left out; that is a finding.
fn products(stage: Stage, job: &Job, results: &mut Results) -> Result<(), Failure> {
    let Results { field, surfaces, paths, machine, motion, files, findings, .. } = results;
    let Job { args, setup, folder, part, .. } = job;
    match stage {
        Stage::Preview | Stage::Field | Stage::Surfaces => {
            write_posed(job)?;
            // Surfaces that stand for others are not what is printed where cells are, nor what another run goes on from.
            let surfaces = surfaces.as_ref().filter(|_| stage != Stage::Preview);
            field::products(args, field, surfaces, folder)?;
            surfaces.iter().try_for_each(|run| surfaces::products(args, run, folder))
        }
        Stage::Paths => paths.iter().try_for_each(|run| paths::products(args, run, folder)),
        Stage::Gcode => machine.iter().try_for_each(|run| {
            machine::products(args, &part.name, run, (files, folder))?;
            tmf::products(job, field, run)?;
            files.axes.iter().for_each(|program| axes::find(program, findings));
            findings.say();
            Ok(())
        }),
        Stage::Motion => {
            machine.iter().try_for_each(|run| {
                machine::products(args, &part.name, run, (files, folder))?;
                tmf::products(job, field, run)
            })?;
            let Some(motion) = motion else { return Ok(()) };
            of_run!(motion, run => motion::products(run, folder)?);
            of_run!(motion, run => workcell::write(run, args.motion.workcell.as_deref(), folder)?);
            let written = of_run!(motion, run => programs::products(run, &args.motion, setup.format, folder)?);
            programs::find(&written, of_run!(motion, run => run.fastest_mm_s()), findings);
            findings.say();
            files.programs = Some(written);
            Ok(())
        }
    }
}

/// A table of figures for each stage.
fn tables(job: &Job, results: &Results) -> [Table; 5] {
    let Results { field, surfaces, paths, machine, motion, files, .. } = results;
    let stages = ["Cells and layers", "Surfaces", "Paths", "Nozzle and machine file", "Motion"];
    let mut tables = stages.map(|stage| Table::new([stage, ""]));
    let [of_field, of_surfaces, of_paths, of_machine, of_motion] = &mut tables;
    field::rows(job.args, job.part, field, of_field);
    if let Some(run) = &results.preview {
        preview::rows(run, of_surfaces);
        return tables;
    }
    surfaces.iter().for_each(|run| surfaces::rows(run, of_surfaces));
    paths.iter().for_each(|run| paths::rows(job.args, run, of_paths));
    let written = machine.iter().zip(&files.gcode).zip(paths);
    written.for_each(|((run, written), paths)| machine::rows(field, paths, run, written, of_machine));
    files.axes.iter().for_each(|program| axes::row(program, of_machine));
    motion.iter().for_each(|motion| of_run!(motion, run => motion::rows(run, of_motion)));
    files.programs.iter().for_each(|written| programs::rows(written, of_motion));
    tables
}

/// All figures that there are when a stage ends.
fn summary(stage: Stage, job: &Job, results: &Results) -> Result<Summary, Failure> {
    let Results { field, surfaces, paths, machine, motion, files, findings, choice, .. } = results;
    let mut summary = Summary::new();
    let figures = &mut summary;
    field::summary(job.args, job.part, field, figures)?;
    figures.set("stage_done", typed_name(stage))?.set("orient", typed_name(job.args.orient))?;
    if let Some(Posed { search, time }) = &job.posed {
        let best = search.best();
        let up = best.pose.up;
        figures
            .set("orient_up_x", up.x)?
            .set("orient_up_y", up.y)?
            .set("orient_up_z", up.z)?
            .set("orient_missed_cells", best.missed_cells)?
            .set("orient_given_missed_cells", search.given().map_or(0, |given| given.missed_cells))?
            .set_seconds("orient_s", *time)?;
    }
    if let Some(choice) = choice {
        figures.set("orders_tried", choice.names().join(","))?.set("of_limits", choice.taken.excess)?;
    }
    findings.summary(figures)?;
    if let (Some(run), Some(surfaces)) = (&results.preview, surfaces) {
        preview::summary(job, surfaces, run, figures)?;
        return Ok(summary);
    }
    surfaces.iter().try_for_each(|run| surfaces::summary(run, figures))?;
    paths.iter().try_for_each(|run| paths::summary(job.args, run, figures))?;
    let written = machine.iter().zip(&files.gcode).zip(paths);
    written
        .into_iter()
        .try_for_each(|((run, written), paths)| machine::summary(job, field, paths, run, written, figures))?;
    files.axes.iter().try_for_each(|program| axes::summary(program, figures))?;
    motion.iter().try_for_each(|motion| of_run!(motion, run => motion::summary(run, figures)))?;
    files.programs.iter().try_for_each(|written| programs::summary(written, figures))?;
    Ok(summary)
}

/// The build comes first, what is wrong with it beside it. The viewer and the pictures below take about as long: each is made by itself.
fn report(job: &Job, results: &Results, tables: &[Table; 5], build: &Model) -> Result<Report, Failure> {
    let (mut report, below) = rayon::join(|| first(job, results, build), || below(job, results, tables));
    report.append(&below?);
    Ok(report)
}

/// The viewer, findings and main figures.
fn first(job: &Job, results: &Results, build: &Model) -> Report {
    let Results { field, surfaces, findings, preview, .. } = results;
    let title = if preview.is_some() { "Preview" } else { "Curved layers" };
    let mut report = Report::new(&format!("{title}: {}", job.part.name));
    let said = |beside: &mut Report| {
        findings.report(beside);
        beside.table("", &people::table(job, results));
    };
    if let (Some(run), Some(surfaces)) = (preview, surfaces) {
        preview::words(field, surfaces, run).iter().for_each(|words| _ = report.paragraph(words));
    }
    report.beside(|first| _ = first.viewer(build), said);
    report
}

/// What each stage has to show, and all tables.
fn below(job: &Job, results: &Results, tables: &[Table; 5]) -> Result<Report, Failure> {
    let Results { field, surfaces, paths, machine, motion, choice, preview, .. } = results;
    let mut report = Report::new("");
    let filled = || tables.iter().filter(|table| !table.rows().is_empty());
    if let (Some(_), Some(surfaces)) = (preview, surfaces) {
        preview::report(field, surfaces, &mut report);
        field::report(job.args, field, &mut report)?;
        report.fold("All figures", |inner| filled().for_each(|table| _ = inner.table("", table)));
        return Ok(report);
    }
    if let Some(choice) = choice {
        report.heading("The order of the cells").paragraph(&choice.reason()).table("", &choice.table());
    }
    field::report(job.args, field, &mut report)?;
    if let Some(surfaces) = surfaces {
        surfaces::report(field, surfaces, &mut report);
        if let Some(paths) = paths {
            paths::report(surfaces, paths, &mut report);
        }
    }
    if let (Some(surfaces), Some(paths), Some(machine)) = (surfaces, paths, machine) {
        machine::report(surfaces, paths, machine, &mut report);
    }
    if let (Some(surfaces), Some(motion)) = (surfaces, motion) {
        of_run!(motion, run => motion::report(surfaces, run, &mut report));
    }
    report.fold("All figures, and those of the dissertation", |inner| {
        filled().for_each(|table| _ = inner.table("", table));
        field::comparison(job.part, field, inner);
    });
    Ok(report)
}
