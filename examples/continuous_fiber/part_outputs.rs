//! What a run on a part leaves behind: findings, a table, `summary.json`, the machine file, programs, `tapes.csv`, pictures and the report.

use super::layer::Reinforced;
use super::part::{PartRun, TapedLayer};
use super::part_motion::PartMotion;
use super::part_programs::TAPE_KIND;
use super::part_read_back::MAX_OFF_MM;
use super::tape_outputs::{STRAIGHT_MM, layer_pictures, options, radius, tape_header, tape_lines};
use super::{ANGLE_DEG, Args, WORST_COVERED};
use curvlay_examples::args::Failure;
use curvlay_examples::count::counted;
use curvlay_examples::findings::{Findings, Severity, accept, percent};
use curvlay_examples::motion::read_back::MAX_FILAMENT_SHARE;
use curvlay_examples::motion::shown;
use curvlay_examples::nalgebra::Point3;
use curvlay_examples::output::{OutputFolder, is_numbered};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_examples::viewer::{self, Model};
use curvlay_toolpath::fiber::bedding::TapePlace;
use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead};
use curvlay_toolpath::gcode::{WriteOptions, write_gcode};
use std::io::Write;
use std::time::Instant;

/// How deep the roller may be in the beads below, as a share of the layer height: as the nozzle may.
const ROLLER_DEPTH: f64 = 0.25;
/// Maximum share of the bead length that is unsupported, as in `curved_layers`.
const ALLOWED_UNSUPPORTED: f64 = 0.01;

/// Share of the tapes' volume that may lie outside of the solver's cells.
const LOST: f64 = 0.01;

/// Whether a file is one that the example writes for a part.
pub fn is_ours(name: &str) -> bool {
    let is_module = |name: &str| is_numbered(name, "fiber_", 3, ".mod") || name == "fiber.mod";
    name == "part.gcode" || name == "growth.csv" || is_numbered(name, "part_", 3, ".script") || is_module(name)
}

fn layers(list: &[TapedLayer]) -> String {
    let numbers: Vec<String> = list.iter().map(|layer| (layer.number + 1).to_string()).collect();
    numbers.join(", ")
}

/// What is wrong with it.
pub fn find(args: &Args, run: &PartRun, findings: &mut Findings) {
    let growth = &run.layers.layered.growth;
    if !growth.missed.is_empty() {
        let share = run.layers.layered.surfaces.missed_mm3 / run.layers.volume_mm3;
        let amount = format!("{}, {} of the volume", counted(growth.missed.len(), "cell"), percent(share));
        findings
            .explain(Severity::Warning, "cells of the part are in no layer", amount, "")
            .try_to("curved_layers, which finds an order and support for such parts");
    }
    let wanted = run.schedule.iter().filter(|layer| layer.carries_tape).count();
    if wanted > run.taped.len() {
        let amount = format!("{} of {wanted}", wanted - run.taped.len());
        let what = "layers carry no tapes, since nowhere beads lie both below and above";
        findings.add(Severity::Warning, what, amount, "");
    }
    find_tapes(run, findings);
    if let Some(print) = &run.print {
        let count = print.resolved.left_out.len();
        if count > 0 {
            let left: f64 = print.resolved.left_out.iter().map(|piece| piece.arcs[1] - piece.arcs[0]).sum();
            let amount = format!("{}, {left:.0} mm", counted(count, "piece"));
            findings.add(
                Severity::Warning,
                "beads are left out: the nozzle would collide with printed material",
                amount,
                "",
            );
        }
    }
    find_bedding(args, run, findings);
    run.reinforced.iter().for_each(|reinforced| find_apart(reinforced, findings));
    run.motion.iter().for_each(|motion| find_motion(motion, findings));
}

fn find_tapes(run: &PartRun, findings: &mut Findings) {
    let empty: Vec<&TapedLayer> = run.taped.iter().filter(|layer| layer.loaded.plan.empty.is_some()).collect();
    if let Some(first) = empty.first() {
        let why = first.loaded.plan.empty.map_or(String::new(), |empty| empty.to_string());
        let numbers: Vec<String> = empty.iter().map(|layer| (layer.number + 1).to_string()).collect();
        let what = format!("no tape lies on {} of the layers that should carry some", empty.len());
        findings
            .explain(Severity::Warning, what, numbers.join(", "), "")
            .cause(format!("{}: {why}", first.loaded.name));
    }
    let has_tapes = |layer: &TapedLayer| layer.loaded.plan.empty.is_none();
    let worst = |layer: &&TapedLayer| has_tapes(layer) && layer.loaded.angle.covered_fraction < WORST_COVERED;
    let bare: Vec<&TapedLayer> = run.taped.iter().filter(worst).collect();
    let least = bare.iter().min_by(|a, b| {
        a.loaded.angle.covered_fraction.total_cmp(&b.loaded.angle.covered_fraction).then(a.number.cmp(&b.number))
    });
    if let Some(least) = least {
        let amount = format!(
            "{} of it at least, on {} of {}",
            percent(least.loaded.angle.covered_fraction),
            bare.len(),
            counted(run.taped.len(), "layer")
        );
        let what =
            format!("less than {} of the worst-stressed tenth of a layer lies under a tape", percent(WORST_COVERED));
        let left: f64 = least.loaded.plan.left_out.iter().map(|piece| piece.length_mm).sum();
        findings
            .explain(Severity::Warning, what, amount, format!("layer {}", least.number + 1))
            .cause(format!(
                "{left:.0} mm of its lines carry no tape: too short, too tightly bent, or too near to others"
            ))
            .try_to("--min-length, --min-radius or --tape-width with less");
    }
    let angle = run.taped.iter().filter_map(|layer| layer.loaded.angle.mean.map(f64::to_degrees)).fold(0.0, f64::max);
    if angle > ANGLE_DEG {
        let what = "tapes leave the principal direction over the worst-stressed tenth of a layer";
        findings
            .explain(Severity::Warning, what, format!("{angle:.1} degrees in the mean"), "")
            .try_to("--smoothing or --min-radius with less");
    }
}

fn find_bedding(args: &Args, run: &PartRun, findings: &mut Findings) {
    let Some(bedding) = &run.bedding else { return };
    let place = |list: &[TapePlace]| {
        let worst = list.iter().max_by(|a, b| a.mm.total_cmp(&b.mm));
        worst.map_or(String::new(), |worst| {
            let Point3 { coords: at } = worst.at;
            format!(
                "most at tape {} of layer {}, {:.1}, {:.1}, {:.1} mm",
                worst.tape + 1,
                worst.layer + 1,
                at.x,
                at.y,
                at.z
            )
        })
    };
    let [on_nothing, uncovered] = [bedding.on_nothing_share(), bedding.uncovered_share()];
    let pieces = [
        ("tapes are unsupported", on_nothing, &bedding.on_nothing),
        ("tapes are covered by nothing", uncovered, &bedding.uncovered),
    ];
    for (what, share, list) in pieces.into_iter().filter(|piece| !piece.2.is_empty()) {
        findings
            .explain(
                Severity::above(share, args.allow_bare),
                what,
                format!("{} of their area", percent(share)),
                place(list),
            )
            .allow(accept("--allow-bare", share));
    }
    let share = bedding.bead_on_nothing_share();
    if share > 0.0 {
        findings
            .explain(
                Severity::above(share, ALLOWED_UNSUPPORTED),
                "unsupported beads",
                format!("{} of their length", percent(share)),
                "",
            )
            .try_to("curved_layers, which finds an order and support for such parts");
    }
    if let Some(deepest) = bedding.roller_depth.filter(|deepest| deepest.mm > ROLLER_DEPTH * run.height_mm()) {
        let place = format!("tape {} of layer {}", deepest.tape + 1, deepest.layer + 1);
        let what = "the roller presses into beads beside the tape";
        findings
            .explain(Severity::Failed, what, format!("{:.2} mm deep", deepest.mm), place)
            .cause("the layer is hollow there, more than the roller is round")
            .try_to("`roller.diameter_mm` and `roller.width_mm` of the workcell with less, or other --layers");
    }
}

fn find_apart(reinforced: &Reinforced, findings: &mut Findings) {
    let Reinforced { apart: [plain, taped], bond_mpa, lost_share, .. } = *reinforced;
    if taped < 1.0 {
        let amount = format!("at {} of it, {} without tapes", percent(taped), percent(plain));
        findings
            .explain(Severity::Warning, "layers come apart under the load", amount, "")
            .cause(format!("peel and shear across layers are more than bonds of {bond_mpa:.2} MPa bear"))
            .try_to("layers along the load: another --up, or curved_layers");
    }
    if lost_share > LOST {
        findings.add(Severity::Warning, "the solver does not see all of the tapes", percent(lost_share), "");
    }
}

fn find_motion(motion: &PartMotion, findings: &mut Findings) {
    for is_tape in [false, true] {
        let list: Vec<_> = motion.faults.iter().filter(|fault| fault.0 == is_tape).collect();
        let missing = if is_tape { motion.tapes.saturating_sub(motion.runs[1]) } else { 0 };
        if list.is_empty() && missing == 0 {
            continue;
        }
        let what = if is_tape { "the robot does not lay all tapes" } else { "the robot does not print all beads" };
        let left_out = if is_tape { format!("{missing} of {} left out, ", motion.tapes) } else { String::new() };
        let first =
            list.first().map_or(String::new(), |(_, fault)| format!(", first: {} {}", fault.kind.name(), fault.what));
        let place = list.first().map_or(String::new(), |(_, fault)| match is_tape {
            true => format!("tape {} of layer {}, point {}", fault.path + 1, fault.layer + 1, fault.waypoint),
            false => format!("path {}, point {}", fault.path + 1, fault.waypoint),
        });
        let amount = format!("{left_out}{}{first}", counted(list.len(), "place"));
        findings
            .explain(Severity::Failed, what, amount, place)
            .try_to("a workcell with more room, another --up, or smaller `roller` bodies");
    }
    let read = &motion.read;
    for wrong in &read.wrong {
        findings.add(Severity::Failed, "the program is not as planned", wrong.clone(), "");
    }
    if read.tape_off_mm > MAX_OFF_MM {
        let amount = format!("{:.3} mm", read.tape_off_mm);
        findings.add(Severity::Failed, "the program lays tapes beside where they were planned", amount, "");
    }
    let beads = &read.beads;
    if (beads.filament_mm - beads.planned_mm).abs() > MAX_FILAMENT_SHARE * beads.planned_mm {
        let amount = format!("{:.1} instead of {:.1} mm", beads.filament_mm, beads.planned_mm);
        findings.add(Severity::Failed, "the program does not lay the filament of the motions", amount, "");
    }
}

pub fn write(
    args: &Args,
    run: &PartRun,
    findings: &Findings,
    folder: &OutputFolder,
    start: Instant,
) -> Result<(), Failure> {
    if !run.moves.is_empty() {
        let mut file = Vec::new();
        write_gcode(run.moves.iter().copied(), &WriteOptions::default(), &mut file)?;
        folder.write("part.gcode", file)?;
    }
    if let Some(followed) = &run.followed {
        folder.write_with("growth.csv", |out: &mut dyn Write| followed.write(out))?;
    }
    for (name, bytes) in run.motion.iter().flat_map(|motion| &motion.files) {
        folder.write(name, bytes)?;
    }
    folder.write_with("tapes.csv", |out: &mut dyn Write| {
        tape_header(out)?;
        run.taped.iter().try_for_each(|layer| tape_lines(out, "part", layer.number, &layer.loaded.plan))
    })?;
    let shown = run
        .taped
        .iter()
        .max_by(|a, b| a.loaded.plan.tape_mm().total_cmp(&b.loaded.plan.tape_mm()).then(b.number.cmp(&a.number)));
    let pictures = shown.map_or(Vec::new(), |layer| layer_pictures(&layer.loaded, &[], args.min_radius_mm));
    for (name, _, png) in &pictures {
        folder.write(name, png)?;
    }
    folder.write("report.html", report(run, findings, &pictures).to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, run, findings, start)?.write(folder)?;
    Ok(())
}

/// The layers with tapes.
pub fn table(run: &PartRun) -> Table {
    let mut table = Table::new([
        "layer",
        "tapes",
        "mm",
        "bedded",
        "of it covered",
        "twice",
        "worst tenth under tape",
        "off stress deg",
        "least radius mm",
    ]);
    for layer in &run.taped {
        let (plan, angle) = (&layer.loaded.plan, &layer.loaded.angle);
        table.row([
            (layer.number + 1).to_string(),
            plan.tapes.len().to_string(),
            format!("{:.1}", plan.tape_mm()),
            percent(layer.bedded_share),
            percent(plan.cover.covered_fraction),
            percent(plan.cover.overlap_fraction),
            percent(angle.covered_fraction),
            angle.mean.map_or(String::new(), |mean| format!("{:.1}", mean.to_degrees())),
            if plan.tapes.is_empty() { String::new() } else { radius(plan.min_radius_mm) },
        ]);
    }
    table
}

fn summary(args: &Args, run: &PartRun, findings: &Findings, start: Instant) -> Result<Summary, Failure> {
    let mut summary = Summary::new();
    options(args, &mut summary)?;
    of_tapes(args, run, &mut summary)?;
    of_stresses(run, &mut summary)?;
    summary.set_seconds("plan_s", run.plan_time)?;
    if let Some(print) = &run.print {
        summary
            .set("paths", print.resolved.paths.len())?
            .set("bead_length_mm", print.deposition.bead_mm)?
            .set("left_out_pieces", print.resolved.left_out.len())?
            .set("print_s", print.deposition.total_s)?;
    }
    if let Some(bedding) = &run.bedding {
        summary
            .set("tape_on_nothing_share", bedding.on_nothing_share())?
            .set("tape_uncovered_share", bedding.uncovered_share())?
            .set("roller_depth_mm", bedding.roller_depth.map_or(0.0, |deepest| deepest.mm))?
            .set("unsupported_share", bedding.bead_on_nothing_share())?;
    }
    if let Some(motion) = &run.motion {
        of_motion(motion, &mut summary)?;
    }
    findings.summary(&mut summary)?;
    summary.set_seconds("total_s", start.elapsed())?;
    Ok(summary)
}

/// Layers, tapes and wires; of shares the least of all layers, of what should be small the largest.
fn of_tapes(args: &Args, run: &PartRun, summary: &mut Summary) -> Result<(), Failure> {
    let (tapes, tape_mm) = run.of_roller();
    let least = |of: fn(&TapedLayer) -> f64| run.taped.iter().map(of).fold(1.0, f64::min);
    summary
        .set("bead_mm", run.bead_mm)?
        .set("layer_height_mm", run.height_mm())?
        .set("allow_bare", args.allow_bare)?
        .set("layers", run.schedule.len())?
        .set("missed_cells", run.layers.layered.growth.missed.len())?
        .set("taped_layers", layers(&run.taped))?
        .set("stress", run.source.clone())?
        .set("tapes", tapes)?
        .set("tape_mm", tape_mm)?
        .set("wires", run.wires.0)?
        .set("wire_mm", run.wires.1)?
        .set("cuts", run.tapes.iter().map(|list| list.tapes.len()).sum::<usize>())?
        .set("bedded_fraction", least(|layer| layer.bedded_share))?
        .set("covered_fraction", least(|layer| layer.loaded.plan.cover.covered_fraction))?
        .set("worst_covered_fraction", least(|layer| layer.loaded.angle.covered_fraction))?;
    let largest = |of: fn(&TapedLayer) -> f64| run.taped.iter().map(of).fold(0.0, f64::max);
    let radius = run.taped.iter().map(|layer| layer.loaded.plan.min_radius_mm).fold(STRAIGHT_MM, f64::min);
    let left = |layer: &TapedLayer| layer.loaded.plan.left_out.iter().map(|piece| piece.length_mm).sum::<f64>();
    summary
        .set("overlap_fraction", largest(|layer| layer.loaded.plan.cover.overlap_fraction))?
        .set("min_radius_mm", radius)?
        .set("lines_left_out_mm", run.taped.iter().map(left).fold(0.0, |sum, mm| sum + mm))?;
    let angles: Vec<f64> = run.taped.iter().filter_map(|layer| layer.loaded.angle.mean).collect();
    if let Some(most) = angles.into_iter().reduce(f64::max) {
        summary.set("angle_to_principal_deg", most.to_degrees())?;
    }
    Ok(())
}

/// The stresses, and what comes of them: layers that follow the load, and how stiff and strong the tapes make the part.
fn of_stresses(run: &PartRun, summary: &mut Summary) -> Result<(), Failure> {
    if let Some(solved) = &run.solved {
        summary
            .set("elastic_cells", solved.cells)?
            .set("elastic_iterations", solved.iterations)?
            .set_seconds("elastic_s", solved.time)?;
    }
    if let Some(followed) = &run.followed {
        summary
            .set("load_angle_directed_deg", followed.angle_deg[0])?
            .set("load_angle_followed_deg", followed.angle_deg[1])?
            .set("missed_directed", followed.missed[0])?
            .set("missed_followed", followed.missed[1])?;
    }
    if let Some(reinforced) = &run.reinforced {
        summary
            .set("stiffness_gain", reinforced.gain)?
            .set("bearing_fraction", reinforced.bearing)?
            .set("bond_mpa", reinforced.bond_mpa)?;
        // JSON has no infinity: what nothing loads does not come apart.
        for (key, factor) in
            [("apart_factor", reinforced.apart[1]), ("apart_factor_without_tapes", reinforced.apart[0])]
        {
            if factor.is_finite() {
                summary.set(key, factor)?;
            }
        }
    }
    Ok(())
}

fn of_motion(motion: &PartMotion, summary: &mut Summary) -> Result<(), Failure> {
    let read = &motion.read;
    summary
        .set("cell", motion.cell.clone())?
        .set("bead_runs", motion.runs[0])?
        .set("tape_runs", motion.runs[1])?
        .set("motion_faults", motion.faults.len())?
        .set("motion_robot_s", motion.robot_s)?
        .set("motion_deviation_mm", motion.max_deviation_mm[1])?
        .set("motion_turn_deg", motion.max_turn.to_degrees())?
        .set("roller_mount_deg", motion.mount.to_degrees())?
        .set("head_changes", motion.changes)?
        .set("program_files", motion.files.len())?
        .set("program_beads", read.laid[0])?
        .set("program_tapes", read.laid[1])?
        .set("program_cuts", read.cuts)?
        .set("program_tape_off_mm", read.tape_off_mm)?
        .set("program_filament_mm", read.beads.filament_mm)?;
    Ok(())
}

fn report(run: &PartRun, findings: &Findings, pictures: &[(String, String, Vec<u8>)]) -> Report {
    let mut report = Report::new("Continuous fibre in a whole part");
    findings.report(&mut report);
    let (tapes, tape_mm) = run.of_roller();
    report.paragraph(&format!(
        "{}: {} of {:.2} mm in beads of {:.2} mm, with {}, {tape_mm:.0} mm in all, on layers {}. Stresses: {}.",
        run.name,
        counted(run.schedule.len(), "layer"),
        run.height_mm(),
        run.bead_mm,
        counted(tapes, "tape"),
        layers(&run.taped),
        run.source
    ));
    report.table("Layers with tapes; bedded is the share of the layer that has beads below and above", &table(run));
    report_stresses(run, &mut report);
    if let Some(bedding) = &run.bedding {
        report.paragraph(&format!(
            "Of {:.0} mm² of tape {} are unsupported, and {} are uncovered, by a check of strands as wide as a layer is high among the beads as they \
             are deposited. The roller is at most {:.3} mm deep in the beads below.",
            bedding.tape_mm2,
            percent(bedding.on_nothing_share()),
            percent(bedding.uncovered_share()),
            bedding.roller_depth.map_or(0.0, |deepest| deepest.mm)
        ));
    }
    if let Some(motion) = &run.motion {
        report_motion(motion, &mut report);
    }
    let shown: Vec<(&str, &[u8])> =
        pictures.iter().map(|(_, caption, png)| (caption.as_str(), png.as_slice())).collect();
    report.pictures(&shown);
    if let Some(model) = model(run) {
        report.viewer(&model);
    }
    report
}

/// How stiff and strong the tapes make the part, and how layers follow the load.
fn report_stresses(run: &PartRun, report: &mut Report) {
    if let Some(reinforced) = &run.reinforced {
        report.paragraph(&format!(
            "With its tapes, of whose fibre {} bears, the part is {} stiffer against this load than without. Bonds of {:.2} MPa in peel and in shear come apart at {:.2} times \
             the load, without tapes at {:.2} times.",
            percent(reinforced.bearing),
            percent(reinforced.gain),
            reinforced.bond_mpa,
            reinforced.apart[1],
            reinforced.apart[0]
        ));
    }
    if let Some(followed) = &run.followed {
        let [directed, guided] = followed.angle_deg;
        let [missed, missed_by_guided] = followed.missed;
        report.paragraph(&format!(
            "Where the part is worst stressed, in a tenth of its cells, directed layers lean by {directed:.1} degrees from the largest stress; along growth.csv by {guided:.1} (curved_layers \
             --directions growth.csv). Without support these orders miss {missed} and {}.",
            counted(missed_by_guided, "cell")
        ));
    }
}

/// The motion of arm and head, and what the program does, read again.
fn report_motion(motion: &PartMotion, report: &mut Report) {
    let read = &motion.read;
    report.paragraph(&format!(
            "{}: {} along beads and {} along tapes, {:.0} s besides waits; the head changes {}, at home. The roller is mounted at {:.0} degrees and \
             turned away from a tape by {:.2} degrees at most. Read again, the program lays {} and {}, with {}; while the roller presses it is \
             within {:.3} mm of the planned tapes.",
            motion.cell,
            counted(motion.runs[0], "motion"),
            motion.runs[1],
            motion.robot_s,
            counted(motion.changes, "time"),
            motion.mount.to_degrees(),
            motion.max_turn.to_degrees(),
            counted(read.laid[0], "bead"),
            counted(read.laid[1], "tape"),
            counted(read.cuts, "cut"),
            read.tape_off_mm
        ));
}

/// The build for the viewer: as the robot does it, or as the machine file says.
fn model(run: &PartRun) -> Option<Model> {
    let print = run.print.as_ref()?;
    let (steps, robot) = match run.motion.as_ref().and_then(|motion| motion.shown.clone()) {
        Some((steps, robot)) => (steps, Some(robot)),
        None => (with_tapes(run, shown::steps(&print.resolved.paths, &print.deposition.moves)), None),
    };
    let mut kinds = shown::kinds();
    kinds.push("tape".to_owned());
    let layers = run.layers.surfaces();
    let layers = layers
        .iter()
        .map(|layer| viewer::Mesh { vertices: layer.vertices.to_vec(), triangles: layer.triangles.to_vec() });
    Some(Model { name: run.name.clone(), layers: layers.collect(), kinds, steps, robot, ..Model::default() })
}

/// The tapes of each layer behind its beads, as a machine file has them.
fn with_tapes(run: &PartRun, beads: Vec<viewer::Step>) -> Vec<viewer::Step> {
    let mut steps = Vec::with_capacity(beads.len());
    let mut lists = run.tapes.iter().peekable();
    let mut path = run.print.as_ref().map_or(0, |print| print.resolved.paths.len()) as u32;
    let mut lay = |list: &LayerTapes, steps: &mut Vec<viewer::Step>| {
        for tape in &list.tapes {
            for (k, (point, normal)) in tape.points.iter().zip(&tape.normals).enumerate() {
                let way = k.checked_sub(1).map_or(0.0, |before| (point - tape.points[before]).norm());
                steps.push(viewer::Step {
                    tip: point + normal.into_inner() * (list.lift + tape.thickness),
                    direction: normal.into_inner(),
                    width: tape.width,
                    height: tape.thickness,
                    kind: if k == 0 { viewer::Step::TRAVEL } else { TAPE_KIND },
                    layer: list.layer,
                    path,
                    seconds: way / TapeHead::default().lay_feed,
                });
            }
            path += 1;
        }
    };
    for step in beads {
        while let Some(list) = lists.next_if(|list| list.layer < step.layer) {
            lay(list, &mut steps);
        }
        steps.push(step);
    }
    lists.for_each(|list| lay(list, &mut steps));
    steps
}
