//! Of the paths: their lines as OBJ, figures and pictures.

use super::pictures;
use super::shown::{Picture, borrowed, seconds};
use crate::args::{Args, Extra};
use crate::paths::{PathsRun, curves};
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::count::counted;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_toolpath::fill::SHORT_CURVE_BEADS;
use std::io::{self, Write};

pub fn products(args: &Args, run: &PathsRun, folder: &OutputFolder) -> Result<(), Failure> {
    folder.write_list("paths.obj", args.writes(Extra::PathsObj), |out| write_obj(run, out))?;
    Ok(())
}

/// A group a layer, a line a curve.
fn write_obj(run: &PathsRun, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "# tool paths, in millimetres, beads of {} mm; a group a layer, a line a curve", run.bead_mm)?;
    let mut first = 1;
    for (number, layer) in (1..).zip(&run.filled.layers) {
        writeln!(out, "g layer_{number}")?;
        for curve in layer.iter().flat_map(curves) {
            for point in &curve {
                writeln!(out, "v {:.6} {:.6} {:.6}", point.x, point.y, point.z)?;
            }
            write!(out, "l")?;
            (first..first + curve.len()).try_for_each(|vertex| write!(out, " {vertex}"))?;
            writeln!(out)?;
            first += curve.len();
        }
    }
    Ok(())
}

pub fn summary(args: &Args, run: &PathsRun, summary: &mut Summary) -> Result<(), Failure> {
    let (filled, totals, times) = (&run.filled, &run.totals, &run.times);
    summary
        .set("bead_mm", run.bead_mm)?
        .set("pattern", typed_name(args.pattern))?
        .set("least_gap", args.min_gap_squares)?
        .set("join_distance_beads", args.join_distance_beads)?
        .set("least_length_beads", args.min_length_beads)?
        .set("least_width_beads", args.min_width_beads)?
        .set_seconds("geodesic_s", times.geodesic)?
        .set_seconds("paths_s", times.paths)?
        .set_seconds("statistics_s", times.statistics)?
        .set_seconds("paths_wall_s", times.wall)?
        .set("curves", totals.curves)?
        .set("short_curves", run.short_curves)?
        .set("short_curve_share", run.short_curve_share())?
        .set("starts_per_metre", run.starts_per_metre())?
        .set("joints", totals.joints)?
        .set("left_short_curves", totals.short_left)?
        .set("left_short_mm", totals.short_left_mm)?
        .set("narrow_curves", totals.narrow_curves)?
        .set("narrow_mm", totals.narrow_mm)?
        .set("left_narrow_curves", totals.narrow_left)?
        .set("left_narrow_mm", totals.narrow_left_mm)?
        .set("regions", totals.regions)?
        .set("jumps", totals.jumps)?
        .set("jump_mm", filled.travel_mm)?
        .set("unordered_jump_mm", filled.given_mm)?
        .set_seconds("order_s", times.order)?
        .set("path_mm", totals.path_mm)?
        .set("wall_mm", totals.wall_mm)?
        .set("solid_mm", totals.solid_mm)?
        .set("skin_mm", totals.skin_mm)?
        .set("support_mm", totals.support_mm)?
        .set("support_density", args.complete.support_density_percent / 100.0)?
        .set("infill_mm", totals.sparse.infill_mm)?
        .set("sparse_mm3", totals.sparse.volume_mm3)?
        .set("sparse_infill_mm3", totals.sparse.infill_mm3)?
        .set("infill_density", args.settings.infill().density)?
        .set("achieved_density", if totals.sparse.volume_mm3 > 0.0 { totals.sparse.density() } else { 1.0 })?
        .set("bridged_mm", run.bridges.length_mm)?
        .set("max_bridge_mm", run.bridges.longest_mm)?;
    if args.has_statistics() {
        summary
            .set("covered_fraction", totals.covered_fraction)?
            .set("overlap_fraction", totals.overlap_fraction)?
            .set("spill_fraction", totals.spill_fraction)?
            .set("unfillable_fraction", totals.unfillable_fraction)?
            .set("filled_fraction", totals.filled_fraction)?
            .set("largest_gap_mm", totals.max_gap_mm)?;
    }
    summary
        .set("too_thin_parts", run.too_thin.parts)?
        .set("too_thin_mm3", run.too_thin.volume_mm3)?
        .set("sharp_turns", totals.sharp_turns)?
        .set("self_crossings", totals.self_crossings)?
        .set("layers_with_even_beads", totals.uniform_layers)?;
    Ok(())
}

pub fn rows(args: &Args, run: &PathsRun, table: &mut Table) {
    let (totals, times) = (&run.totals, &run.times);
    let share = |fraction: f64| format!("{:.2} %", 100.0 * fraction);
    if totals.sparse.volume_mm3 > 0.0 {
        let metres = |mm: f64| format!("{:.1} m", mm / 1000.0);
        table.row(["density of infill".to_owned(), share(totals.sparse.density())]).row([
            "bridged by skins".to_owned(),
            format!("{}, {:.1} mm at most", metres(run.bridges.length_mm), run.bridges.longest_mm),
        ]);
    }
    table
        .row(["bead".to_owned(), format!("{:.3} mm wide", run.bead_mm)])
        .row(["curves".to_owned(), format!("{} in {}", totals.curves, counted(totals.regions, "region"))])
        .row([
            "short curves".to_owned(),
            format!("{} below {SHORT_CURVE_BEADS} beads, {}", run.short_curves, share(run.short_curve_share())),
        ])
        .row([
            "joined, left out".to_owned(),
            format!(
                "{}; {} of {:.1} mm",
                counted(totals.joints, "joint"),
                counted(totals.short_left, "short curve"),
                totals.short_left_mm
            ),
        ])
        .row([
            "beads of narrow strips".to_owned(),
            format!(
                "{} of {:.1} mm, since something lies on them; {} of {:.1} mm left out",
                totals.narrow_curves, totals.narrow_mm, totals.narrow_left, totals.narrow_left_mm
            ),
        ])
        .row(["starts".to_owned(), format!("{:.2} per metre", run.starts_per_metre())])
        .row(["length".to_owned(), format!("{:.1} m", totals.path_mm / 1000.0)])
        .row([
            "jumps".to_owned(),
            format!("{}, {:.1} mm in all; {:.1} mm as found", totals.jumps, run.filled.travel_mm, run.filled.given_mm),
        ]);
    if args.has_statistics() {
        table
            .row(["covered".to_owned(), share(totals.covered_fraction)])
            .row(["covered twice".to_owned(), share(totals.overlap_fraction)])
            .row(["past the boundary".to_owned(), share(totals.spill_fraction)])
            .row(["no bead fits".to_owned(), share(totals.unfillable_fraction)])
            .row(["covered of the rest".to_owned(), share(totals.filled_fraction)])
            .row(["largest gap".to_owned(), format!("{:.3} mm wide", totals.max_gap_mm)]);
    }
    table
        .row(["sharp turns".to_owned(), totals.sharp_turns.to_string()])
        .row(["crossings".to_owned(), totals.self_crossings.to_string()])
        .row([
            "time, all threads".to_owned(),
            format!(
                "geodesics {}, paths {}, coverage and crossings {}",
                seconds(times.geodesic),
                seconds(times.paths),
                seconds(times.statistics)
            ),
        ]);
}

pub fn report(surfaces: &SurfacesRun, run: &PathsRun, report: &mut Report) {
    let shown = pictures::quarters(surfaces);
    let spirals: Vec<Picture> = shown.iter().filter_map(|&at| pictures::paths(surfaces, run, at)).collect();
    let support = if surfaces.support.is_some() { "; support orange" } else { "" };
    report
        .heading(&format!("Tool paths, from blue at the entry to yellow at the exit{support}"))
        .pictures(&borrowed(&spirals));
    if let Some(distance) = shown.get(1).and_then(|&at| pictures::distance(surfaces, run, at)) {
        report.heading("Geodesic distance to the boundary, a band a bead").pictures(&borrowed(&[distance]));
    }
}
