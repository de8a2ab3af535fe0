//! What the example leaves behind: tables on stdout, `summary.json`, machine files, programs, `tapes.csv` and `report.html`.

use super::arcs::ArcTest;
use super::layer::Solved;
use super::predict::{MEASURED_GPA, MEASURED_NM2, Prediction, Predictions, deflection_mm};
use super::tape_outputs::{STRAIGHT_MM, layer_pictures, options, radius, tape_header, tape_lines};
use super::tapes::Planned;
use super::{Args, Run, drawing, part_outputs};
use curvlay_examples::args::Failure;
use curvlay_examples::count::counted;
use curvlay_examples::findings::percent;
use curvlay_examples::output::{OutputFolder, is_numbered};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_toolpath::fiber::head::LayerTapes;
use curvlay_toolpath::fiber::tapes::{Tape, TapePlan};
use curvlay_toolpath::gcode::{Move, Tool, WriteOptions, write_gcode};
use std::io::{self, Write};
use std::time::Instant;

/// Whether a file is one that the example writes.
pub fn is_ours(name: &str) -> bool {
    let specimen = |stem: &str| {
        let rest = name.strip_prefix(stem);
        rest.is_some_and(|rest| matches!(rest, ".gcode" | ".png") || is_numbered(rest, "_tapes_", 3, ".script"))
    };
    ["dumbbell", "bar", "arc"].into_iter().any(specimen)
        || ["report.html", "tapes.csv", "arc_planar.gcode", "layer.gcode", "layer.png", "layer_stress.png"]
            .contains(&name)
        || part_outputs::is_ours(name)
}

pub fn write(args: &Args, run: &Run, folder: &OutputFolder, start: Instant) -> Result<(), Failure> {
    let written = |name: &str, moves: &[Move]| -> Result<(), Failure> {
        if moves.is_empty() {
            return Ok(());
        }
        let mut file = Vec::new();
        write_gcode(moves.iter().copied(), &WriteOptions::default(), &mut file)?;
        Ok(folder.write(name, file)?)
    };
    for planned in &run.specimens {
        written(&format!("{}.gcode", planned.specimen.name), &planned.moves)?;
    }
    written("arc_planar.gcode", &run.planar.moves)?;
    let head = args.head();
    let loaded = [(Tool::Roller, &run.layer.plan.tapes), (Tool::Conductor, &run.wires)]
        .map(|(tool, tapes)| head.moves(&LayerTapes { layer: 0, tool, lift: 0.0, tapes: tapes.clone() }));
    written("layer.gcode", &loaded.into_iter().collect::<Result<Vec<_>, _>>()?.concat())?;
    for (name, bytes) in run.moved.iter().flat_map(|moved| &moved.files) {
        folder.write(name, bytes)?;
    }
    folder.write_with("tapes.csv", |out| write_tapes(run, out))?;
    let pictures = Pictures::of(args, run);
    for (name, _, png) in &pictures.0 {
        folder.write(name, png)?;
    }
    folder.write("report.html", report(run, &pictures).to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, run, start)?.write(folder)?;
    Ok(())
}

fn write_tapes(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    tape_header(out)?;
    for planned in &run.specimens {
        for (layer, plan) in planned.tapes.iter().zip(&planned.plans) {
            tape_lines(out, planned.specimen.name, layer.layer, plan)?;
        }
    }
    tape_lines(out, "layer", 0, &run.layer.plan)
}

/// Tapes of the specimens and of the layer.
pub fn tapes(run: &Run) -> Table {
    let mut table =
        Table::new(["", "tapes", "mm", "covered", "twice", "least radius mm", "whole layer covered", "twice"]);
    for planned in &run.specimens {
        let (specimen, filled) = (&planned.specimen, &planned.filled);
        let [covered, overlap, least] = planned.cover();
        table.row([
            specimen.title.to_owned(),
            planned.count().to_string(),
            format!("{:.1}", planned.tape_mm()),
            percent(covered),
            percent(overlap),
            radius(least),
            percent(filled.cover.covered_fraction),
            percent(filled.cover.overlap_fraction),
        ]);
    }
    let plan = &run.layer.plan;
    table.row([
        run.layer.name.clone(),
        plan.tapes.len().to_string(),
        format!("{:.1}", plan.tape_mm()),
        percent(plan.cover.covered_fraction),
        percent(plan.cover.overlap_fraction),
        radius(plan.min_radius_mm),
        String::new(),
        String::new(),
    ]);
    table
}

/// Ours beside the measured.
pub fn predictions(run: &Run) -> Table {
    let mut table = Table::new(["", "ours", "measured", "ours / measured"]);
    for prediction in &run.predictions.list {
        let unit = if prediction.unit.is_empty() { String::new() } else { format!(", {}", prediction.unit) };
        table.row([
            format!("{}{unit}", prediction.what),
            format!("{:.3}", prediction.ours),
            format!("{:.3}", prediction.measured),
            format!("{:.2}", prediction.ours / prediction.measured),
        ]);
    }
    table
}

/// Names, captions and bytes.
struct Pictures(Vec<(String, String, Vec<u8>)>);

impl Pictures {
    fn of(args: &Args, run: &Run) -> Self {
        let mut list = Vec::new();
        for planned in &run.specimens {
            let name = planned.specimen.name;
            let caption = format!("{}: the tape on a layer in its middle", planned.specimen.title);
            list.push((format!("{name}.png"), caption, drawing::specimen(planned, args.min_radius_mm)));
        }
        list.extend(layer_pictures(&run.layer, &run.wires, args.min_radius_mm));
        Pictures(list)
    }
}

fn summary(args: &Args, run: &Run, start: Instant) -> Result<Summary, Failure> {
    let mut summary = Summary::new();
    options(args, &mut summary)?;
    of_specimens(run, &mut summary)?;
    of_layer(run, &mut summary)?;
    if let Some(moved) = &run.moved {
        summary
            .set("cell", moved.cell.clone())?
            .set("motion_runs", moved.runs)?
            .set("motion_faults", moved.faults.len())?
            .set("motion_robot_s", moved.robot_s)?
            .set("motion_deviation_mm", moved.max_deviation_mm)?
            .set("motion_turn_deg", moved.max_turn.to_degrees())?
            .set("roller_mount_deg", moved.mount.to_degrees())?
            .set("program_files", moved.files.len())?;
    }
    run.findings.summary(&mut summary)?;
    summary.set_seconds("total_s", start.elapsed())?;
    Ok(summary)
}

/// The specimens of the dissertation, ours and measured.
fn of_specimens(run: &Run, summary: &mut Summary) -> Result<(), Failure> {
    let (specimens, layer) = (&run.specimens, &run.layer);
    let arcs = &run.predictions.arcs;
    let covers: Vec<[f64; 3]> = specimens.iter().map(Planned::cover).collect();
    let plans = || specimens.iter().flat_map(|planned| &planned.plans).chain([&layer.plan]);
    summary
        .set("tapes", plans().map(|plan| plan.tapes.len()).sum::<usize>())?
        .set("tape_mm", plans().map(TapePlan::tape_mm).sum::<f64>())?
        .set("covered_fraction", covers.iter().map(|cover| cover[0]).fold(1.0, f64::min))?
        .set("overlap_fraction", covers.iter().map(|cover| cover[1]).fold(0.0, f64::max))?
        .set("min_radius_mm", plans().map(|plan| plan.min_radius_mm).fold(STRAIGHT_MM, f64::min))?
        .set("cuts", plans().map(TapePlan::cuts).sum::<usize>())?
        .set("modulus_gpa", run.predictions.modulus_gpa)?
        .set("measured_modulus_gpa", MEASURED_GPA[1])?
        .set("rigidity_perfect_nm2", run.predictions.rigidity_nm2[0])?
        .set("rigidity_nm2", run.predictions.rigidity_nm2[1])?
        .set("measured_rigidity_nm2", MEASURED_NM2[1])?
        .set("bearing_fraction", run.predictions.bearing)?
        .set("bond_mpa", run.predictions.bond_mpa)?
        .set("arc_taped_planar_cu", arcs.planar_taped.stiffness_n_mm / arcs.curved.stiffness_n_mm)?
        .set("arc_cu_apart_n", run.predictions.bond_mpa * arcs.curved.apart_n_mpa)?
        .set("arc_cr_apart_n", run.predictions.bond_mpa * arcs.curved_taped.apart_n_mpa)?
        .set("arc_taped_planar_apart_n", run.predictions.bond_mpa * arcs.planar_taped.apart_n_mpa)?;
    if let Some(mean) = layer.angle.mean {
        summary.set("angle_to_principal_deg", mean.to_degrees())?;
    }
    summary.set_seconds("plan_s", run.plan_time)?;
    for planned in specimens {
        let (name, filled) = (planned.specimen.name, &planned.filled);
        summary
            .set(&format!("{name}_tapes"), planned.count())?
            .set(&format!("{name}_tape_mm"), planned.tape_mm())?
            .set(&format!("{name}_filled_covered_fraction"), filled.cover.covered_fraction)?
            .set(&format!("{name}_filled_overlap_fraction"), filled.cover.overlap_fraction)?;
    }
    let ratio = |what: &str| run.predictions.list.iter().find(|prediction| prediction.what.contains(what));
    for (key, what) in [("arc_cr_cu", "CR/CU"), ("arc_pu_cu", "PU/CU")] {
        if let Some(prediction) = ratio(what) {
            summary.set(key, prediction.ours)?.set(&format!("measured_{key}"), prediction.measured)?;
        }
    }
    summary
        .set("arc_planar_layers", run.planar.layers)?
        .set("arc_planar_longest_tape_mm", run.planar.longest_tape_mm)?;
    Ok(())
}

fn of_layer(run: &Run, summary: &mut Summary) -> Result<(), Failure> {
    let layer = &run.layer;
    summary
        .set("layer", layer.name.clone())?
        .set("layer_stress", layer.source.clone())?
        .set("layer_area_mm2", layer.plan.cover.area_mm2)?
        .set("layer_triangles", layer.surface.triangles().len())?
        .set("layer_tapes", layer.plan.tapes.len())?
        .set("layer_tape_mm", layer.plan.tape_mm())?
        .set("layer_covered_fraction", layer.plan.cover.covered_fraction)?
        .set("layer_overlap_fraction", layer.plan.cover.overlap_fraction)?
        .set("layer_min_radius_mm", layer.plan.min_radius_mm.min(STRAIGHT_MM))?
        .set("layer_left_out_mm", layer.plan.left_out.iter().map(|piece| piece.length_mm).sum::<f64>())?
        .set("layer_singular_points", layer.singular_points)?
        .set("wires", run.wires.len())?
        .set("wire_mm", run.wires.iter().map(Tape::length).fold(0.0, |sum, mm| sum + mm))?
        .set("layer_worst_covered_fraction", layer.angle.covered_fraction)?
        .set("layer_empty", layer.plan.empty.map_or(String::new(), |empty| empty.to_string()))?;
    if let Some(Solved { cells, iterations, time }) = layer.solved {
        summary.set("elastic_cells", cells)?.set("elastic_iterations", iterations)?.set_seconds("elastic_s", time)?;
    }
    Ok(())
}

/// What a prediction assumes, by how much it is off, and what may be the reason.
fn explained(prediction: &Prediction) -> String {
    let Prediction { what, ours, measured, assumed, remark, .. } = prediction;
    let off = ours / measured - 1.0;
    let side = if off < 0.0 { "below" } else { "above" };
    format!("{what}: {assumed}. Ours is {} {side} the measured figure. Possible reasons: {remark}.", percent(off.abs()))
}

fn report(run: &Run, pictures: &Pictures) -> Report {
    let mut report = Report::new("Continuous fibre on curved layers");
    run.findings.report(&mut report);
    report.paragraph(
        "The specimens of the dissertation (C. Dai, 2020, chapter 5) with tapes between their layers, and a layer under load with tapes along its \
         principal stresses. Covered is the strip on which the dissertation lays its tape; the whole layer is what tapes of 5 mm along the specimen \
         would cover of all of it.",
    );
    report
        .table("Tapes", &tapes(run))
        .table("Stiffness: ours by theory, measured in the dissertation", &predictions(run));
    for prediction in &run.predictions.list {
        report.paragraph(&explained(prediction));
    }
    if let Ok(mm) = deflection_mm(run.predictions.rigidity_nm2[1]) {
        report.paragraph(&format!("At 7.27 N and supports 200 mm apart the reinforced bar would bend by {mm:.2} mm."));
    }
    report_arcs(&run.predictions, &mut report);
    report_layer(run, &mut report);
    let shown: Vec<(&str, &[u8])> =
        pictures.0.iter().map(|(_, caption, png)| (caption.as_str(), png.as_slice())).collect();
    report.pictures(&shown);
    report
}

/// The arc by the solver: tapes that follow it, and tapes in planar layers.
fn report_arcs(Predictions { arcs, bond_mpa, .. }: &Predictions, report: &mut Report) {
    let gained = |test: &ArcTest| percent(test.stiffness_n_mm / arcs.curved.stiffness_n_mm - 1.0);
    report.paragraph(&format!(
        "The arc by the solver: tapes that follow it, {:.0} mm³ of them, make it {} stiffer; tapes in planar layers, {:.0} mm³ of them, {}. With bonds of {bond_mpa:.2} MPa \
         planar layers come apart at {:.0} N, with tapes at {:.0} N; curved ones at {:.0} N, with tapes at {:.0} N.",
        arcs.curved_taped.tape_mm3,
        gained(&arcs.curved_taped),
        arcs.planar_taped.tape_mm3,
        gained(&arcs.planar_taped),
        bond_mpa * arcs.planar.apart_n_mpa,
        bond_mpa * arcs.planar_taped.apart_n_mpa,
        bond_mpa * arcs.curved.apart_n_mpa,
        bond_mpa * arcs.curved_taped.apart_n_mpa
    ));
}

/// The layer under load, and the motions along the tapes of the arc.
fn report_layer(run: &Run, report: &mut Report) {
    let layer = &run.layer;
    if let Some(mean) = layer.angle.mean {
        report.paragraph(&format!(
            "On {}, {}, the mean angle between tape and principal direction over the worst-stressed tenth of the area is {:.1} degrees; {} of that \
             area lies under a tape.",
            layer.name,
            layer.source,
            mean.to_degrees(),
            percent(layer.angle.covered_fraction)
        ));
    }
    if let Some(moved) = &run.moved {
        report.paragraph(&format!(
            "{}: {} for the {} of the arc, {:.0} s, {}. On them the contact line is within {:.3} mm of the centre line, the \
             roller within {:.2} degrees of it, mounted at {:.0} degrees. The body of the cell's nozzle stands for that of the roller.",
            moved.cell,
            counted(moved.runs, "motion"),
            counted(moved.tapes, "tape"),
            moved.robot_s,
            counted(moved.faults.len(), "fault"),
            moved.max_deviation_mm,
            moved.max_turn.to_degrees(),
            moved.mount.to_degrees()
        ));
    }
}
