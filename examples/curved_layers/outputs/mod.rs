//! What the example leaves behind: the products of each stage, `report.html`, `summary.json`, the tables on stdout.
//!
//! One module a stage, each with its products, its figures (`summary`, `rows`) and its chapter of the report.

mod field;
mod machine;
mod motion;
mod paths;
mod pictures;
mod programs;
mod surfaces;

use crate::motion::Motion;
use crate::{Args, Results, failure};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::output::OutputFolder;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use std::time::Duration;

/// A picture and the line under it.
type Picture = (String, Vec<u8>);

/// The motion, knot by knot.
pub const TRAJECTORY: &str = "trajectory.csv";

/// Writes the motion itself, which is checked before all else is written.
pub fn trajectory(motion: &Motion, folder: &OutputFolder) -> Result<(), Failure> {
    folder.write_with(TRAJECTORY, |out| match motion {
        Motion::Six(run) => motion::write_csv(run, out),
        Motion::Eight(run) => motion::write_csv(run, out),
    })?;
    Ok(())
}

/// Writes all of it. Programs that would be wrong are left out; then it says why.
pub fn write(args: &Args, part: &Part, results: &Results, folder: &OutputFolder) -> Result<Option<String>, Failure> {
    let Results { setup, field: run, surfaces, paths, machine, motion } = results;
    let mut summary = Summary::new();
    let stages = ["Cells and layers", "Surfaces", "Paths", "Nozzle and machine file", "Motion"];
    let mut tables = stages.map(|stage| Table::new([stage, ""]));
    let [of_field, of_surfaces, of_paths, of_machine, of_motion] = &mut tables;
    let mut refused = None;

    field::products(run, folder)?;
    field::summary(args, part, run, &mut summary)?;
    field::rows(args, part, run, of_field);
    if let Some(run) = surfaces {
        surfaces::products(run, folder)?;
        surfaces::summary(run, &mut summary)?;
        surfaces::rows(run, of_surfaces);
    }
    if let Some(run) = paths {
        paths::products(run, folder)?;
        paths::summary(args, run, &mut summary)?;
        paths::rows(run, of_paths);
    }

    if let Some(run) = machine {
        let written = machine::products(args, run, folder)?;
        machine::summary(&setup.nozzle, run, &written, &mut summary)?;
        machine::rows(run, &written, of_machine);
    }
    if let Some(run) = motion {
        match run {
            Motion::Six(run) => motion::products(run, folder)?,
            Motion::Eight(run) => motion::products(run, folder)?,
        }
        let written = programs::products(run, setup.format, args.motion.program_steps, folder)?;
        refused = written.refused.clone();
        match run {
            Motion::Six(run) => motion::summary(run, &mut summary)?,
            Motion::Eight(run) => motion::summary(run, &mut summary)?,
        }
        programs::summary(&written, &mut summary)?;
        match run {
            Motion::Six(run) => motion::rows(run, of_motion),
            Motion::Eight(run) => motion::rows(run, of_motion),
        }
        programs::rows(&written, of_motion);
    }

    let mut report = Report::new(&format!("Curved layers: {}", part.name));
    motion.iter().flat_map(Motion::failed_checks).for_each(|check| _ = report.notice(&check));
    field::report(run, of_field, &mut report)?;
    if let Some(surfaces) = surfaces {
        report.table("", of_surfaces);
        surfaces::report(run, surfaces, &mut report);
        if let Some(paths) = paths {
            report.table("", of_paths);
            paths::report(surfaces, paths, &mut report);
        }
    }
    if let Some(machine) = machine {
        report.table("", of_machine);
        machine::report(machine, &mut report);
    }
    if let (Some(surfaces), Some(motion)) = (surfaces, motion) {
        report.table("", of_motion);
        refused.iter().for_each(|refused| _ = report.notice(&format!("no programs: {refused}")));
        match motion {
            Motion::Six(run) => motion::report(surfaces, run, &mut report),
            Motion::Eight(run) => motion::report(surfaces, run, &mut report),
        }
    }
    field::comparison(part, run, &mut report);
    folder.write("report.html", report.to_html())?;
    // The summary comes last: where it is, all is there.
    summary.write(folder)?;
    Table::print_all(tables.iter().filter(|table| !table.rows().is_empty())).map_err(failure)?;
    Ok(refused)
}

fn seconds(time: Duration) -> String {
    format!("{:.3} s", time.as_secs_f64())
}

fn borrowed(pictures: &[Picture]) -> Vec<(&str, &[u8])> {
    pictures.iter().map(|(caption, png)| (caption.as_str(), png.as_slice())).collect()
}
