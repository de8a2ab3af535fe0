//! Of a preview: rows for the operator, figures, and what the report says of it.

use super::pictures;
use super::shown::{borrowed, duration, seconds};
use crate::field::FieldRun;
use crate::job::Job;
use crate::preview::PreviewRun;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::count::{counted, grouped};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use serde_json::Value;

pub fn summary(job: &Job, surfaces: &SurfacesRun, run: &PreviewRun, summary: &mut Summary) -> Result<(), Failure> {
    let (args, print) = (job.args, &run.print);
    let (grams, cost) = args.settings.mass_and_cost(print.extruded_mm3);
    let or_none = |figure: Option<f64>| figure.map_or_else(|| "none".into(), Value::from);
    summary
        .set("is_estimate", true)?
        .set("preview_surfaces", surfaces.sheets.len())?
        .set("preview_layers_each", run.layers_each)?
        .set("preview_triangles", surfaces.triangles())?
        .set_seconds("preview_s", run.time)?
        .set("bead_mm", run.bead_mm)?
        .set("pattern", typed_name(args.pattern))?
        .set("layer_height_mm", run.height_mm)?
        .set("estimated_layers", run.layers)?
        .set("estimated_half_layers", run.half_layers)?
        .set("estimated_path_mm", print.bead_mm)?
        .set("estimated_infill_mm", print.infill_mm)?
        .set("estimated_extruded_mm3", print.extruded_mm3)?
        .set("estimated_filament_mm", print.filament_mm)?
        .set("estimated_filament_g", or_none(grams))?
        .set("estimated_filament_cost", or_none(cost))?
        .set("estimated_print_time_s", print.total_s())?
        .set("estimated_travel_time_s", print.travel_s)?
        .set("estimated_travel_mm", print.travel_mm)?
        .set("estimated_curves", print.curves.round())?
        .set("estimated_too_narrow_share", run.too_narrow_share())?
        .set("estimated_too_narrow_mm3", print.too_narrow_mm3)?;
    Ok(())
}

/// Layers, time and material.
pub fn people(job: &Job, run: &PreviewRun, row: &mut dyn FnMut(&str, String)) {
    let (settings, print) = (&job.args.settings, &run.print);
    let halves = match run.half_layers {
        0 => String::new(),
        halves => format!(" and about {}", counted(halves, "half layer")),
    };
    row("layers", format!("about {} of {:.3} mm{halves}, beads of {:.3} mm", run.layers, run.height_mm, run.bead_mm));
    row("print time", format!("about {} (estimate)", duration(print.total_s())));
    let (grams, cost) = settings.mass_and_cost(print.extruded_mm3);
    let mut material =
        format!("about {:.2} m of filament, {:.2} cm3", print.filament_mm / 1000.0, print.extruded_mm3 / 1000.0);
    grams.iter().for_each(|grams| material += &format!(", {grams:.1} g"));
    cost.iter().for_each(|cost| material += &format!(", costs {cost:.2}"));
    settings.material.iter().for_each(|name| material += &format!(" ({name})"));
    row("material", format!("{material} (estimate)"));
    row(
        "beads",
        format!(
            "about {:.1} m in {} curves (estimate)",
            print.bead_mm / 1000.0,
            grouped(print.curves.round() as usize)
        ),
    );
}

/// What is shown, what the estimates are, and what the full run does beyond it: a paragraph each.
pub fn words(field: &FieldRun, surfaces: &SurfacesRun, run: &PreviewRun) -> [String; 2] {
    let (grid, shown) = (&field.solid.grid, surfaces.sheets.len());
    let cells = match run.full_cells {
        Some(cells) => format!(
            "The preview orders {} cells of {:.2} mm; the full run takes about {}, so its layers may differ a little.",
            grouped(grid.count()),
            grid.cell_mm(),
            grouped(cells as usize)
        ),
        None => {
            format!("The order is of {} cells of {:.2} mm, as in the full run.", grouped(grid.count()), grid.cell_mm())
        }
    };
    let layers = match run.half_layers {
        0 => counted(run.layers, "layer"),
        halves => format!("{} and {}", counted(run.layers, "layer"), counted(halves, "half layer")),
    };
    let shown = match run.layers_each > 1.0 {
        true => format!(
            "It shows {}, one for every {:.1} of the {layers} of the print.",
            counted(shown, "surface"),
            run.layers_each
        ),
        false => format!("It shows all {layers}."),
    };
    [
        format!("This is a preview: a first look, no paths are planned. {shown} {cells}"),
        format!(
            "Time and material are estimates from the area of these surfaces. {ACCURACY} Only the full run checks collisions of the nozzle, unsupported \
             beads and travels, and may choose another order of the layers for them: the same command without --stage preview."
        ),
    ]
}

/// How near estimates were to full runs, as docs/benchmarks.md has them.
const ACCURACY: &str = "In tests the length of beads was within 4 % of that of the full run, the volume within 2 % (7 % with sparse infill), the \
                        time within 8 %, mostly too short: cuts and turns of the nozzle are not known yet.";

pub fn rows(run: &PreviewRun, table: &mut Table) {
    let print = &run.print;
    table
        .row(["layers shown stand for".to_owned(), format!("{:.2} layers each", run.layers_each)])
        .row(["length of beads, estimate".to_owned(), format!("{:.1} m", print.bead_mm / 1000.0)])
        .row(["of this sparse infill".to_owned(), format!("{:.1} m", print.infill_mm / 1000.0)])
        .row(["deposited volume, estimate".to_owned(), format!("{:.1} mm3", print.extruded_mm3)])
        .row(["too narrow for a bead".to_owned(), format!("{:.1} mm3", print.too_narrow_mm3)])
        .row(["print time, estimate".to_owned(), format!("{:.0} s", print.total_s())])
        .row([
            "of this travels and retractions".to_owned(),
            format!("{:.0} s, {:.1} m", print.travel_s, print.travel_mm / 1000.0),
        ])
        .row(["time of the estimate".to_owned(), seconds(run.time)]);
}

/// The pictures that make sense before there are paths.
pub fn report(field: &FieldRun, surfaces: &SurfacesRun, report: &mut Report) {
    let support = if surfaces.support.is_some() { ", its support orange" } else { "" };
    let frames = pictures::frames(field, surfaces);
    report.heading(&format!("The part while it is built{support}")).slider(&borrowed(&frames));
}
