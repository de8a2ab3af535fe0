//! Findings of each stage: when a result is reported, and when the exit status is 3.

use crate::args::{Args, Lying, Stage};
use crate::complete::{LayersBy, NozzleGrowth, Support};
use crate::field::FieldRun;
use crate::job::Results;
use crate::machine::{MachineRun, to_lay_mm3};
use crate::motion::{Checked, MotionRun, of_run};
use crate::paths::PathsRun;
use crate::surfaces::SurfacesRun;
use Severity::{Failed, Note, Warning};
use curvlay_examples::args::AllowArgs;
use curvlay_examples::count::{counted, grouped};
use curvlay_examples::findings::{Findings, Severity, accept, at_most_mm, percent};
use curvlay_kinematics::workcell::Workcell;
use curvlay_layers::curved::{self, MissedReason, NoSupport};
use curvlay_toolpath::gcode::flavour::{Direction, Flavour};
use curvlay_toolpath::gouging::NozzlePart;
use curvlay_trajectory::check::FindingClass;
use curvlay_trajectory::print::{FaultKind, PrintPlan};
use std::collections::BTreeSet;

/// Area shares above which a finding is reported. Of thin walls sharp edges alone make up some tenths of a percent.
const NOTABLE_SHARE: f64 = 0.01;

/// Deviations of the volume of the layers, and of the deposited volume, above which they are reported; as shares of the part.
const NOTABLE_LAYERS: f64 = 0.05;
const NOTABLE_VOLUME: f64 = 0.02;

/// Additional print time, as a share, above which printing is reported as slow: a motion from rest to rest is always a little longer.
const NOTABLE_DELAY: f64 = 0.05;

/// Share of the time of printing at the limit of turning above which a finding is reported: from half on it rules the print.
const NOTABLE_TURNING: f64 = 0.5;

/// Lean of the nozzle, in radians, above which a machine file without directions is reported: by a degree a tip of 1 mm is off by 0.02 mm.
const NOTABLE_LEAN: f64 = 1.0 * std::f64::consts::PI / 180.0;

/// Adds what is wrong with a stage that has ended; the first two end together.
pub fn of_stage(stage: Stage, args: &Args, results: &mut Results) {
    let Results { field, surfaces, paths, machine, motion, findings, .. } = results;
    let borders_mm =
        || surfaces.iter().flat_map(|run| &run.sheets).map(|sheet| sheet.border_mm).fold(0.0, |sum, mm| sum + mm);
    match stage {
        // Surfaces that stand for others say nothing of how far apart layers are; the rest is for `preview::find`.
        Stage::Preview => of_field(field, args, findings),
        Stage::Field | Stage::Surfaces => {
            of_field(field, args, findings);
            surfaces.iter().for_each(|run| of_surfaces(field, run, findings));
        }
        Stage::Paths => paths.iter().for_each(|run| of_paths(run, findings)),
        Stage::Gcode => machine.iter().zip(paths.iter()).for_each(|(run, paths)| {
            of_machine(field, paths, run, args, findings);
            of_flavour(run, args, findings);
            of_feed(run, findings);
            of_support((paths.bead_mm, borders_mm()), run, args, findings);
        }),
        Stage::Motion => {
            motion.iter().for_each(|motion| {
                of_run!(motion, run => {
                    of_bodies(run, findings);
                    of_plan(&run.plan, run.checked.as_ref(), args.allow.allow_unprinted, findings);
                });
            });
        }
    }
}

/// Share of the part that may lie in what it is printed on before it is reported: slivers of cells beside its surface.
const NOTABLE_BURIED: f64 = 1e-4;

/// Of the mesh, the cells and their order.
fn of_field(run: &FieldRun, args: &Args, findings: &mut Findings) {
    of_mesh(run, findings);
    of_standing(run, args, findings);
    of_order(run, args, findings);
}

/// Of the mesh and its cells.
fn of_mesh(run: &FieldRun, findings: &mut Findings) {
    let (report, cell_mm) = (&run.solid.report, run.solid.grid.cell_mm());
    if !run.mesh.is_sound() {
        // The first line says how large it is.
        run.mesh
            .to_string()
            .lines()
            .skip(1)
            .for_each(|line| findings.add(Warning, format!("the mesh: {line}"), "", ""));
    }
    if report.dropped_triangles > 0 {
        findings.add(Note, "triangles without area were dropped", report.dropped_triangles.to_string(), "");
    }
    run.given.iter().for_each(|given| given.find(findings));
    if run.part_is_estimated {
        let is_open = run.mesh.open_edges.count > 0;
        let why = if is_open { "the mesh is open" } else { "bodies of the mesh pass through each other" };
        let what = format!("{why}: the volume of the part is an estimate by its cells");
        findings.add(Note, what, format!("{:.0} mm3", run.part_mm3), "a smaller --cell gives a better one");
    }
    if report.leak_faces > 0 {
        let amount =
            format!("{} near them decided one by one by winding number", counted(report.cells_asked_singly, "cell"));
        findings.add(Warning, "the mesh has holes wider than a cell", amount, "");
    }
    if report.inside_out {
        findings.add(Note, "the faces point inwards: the part was taken as turned the right way round", "", "");
    }
    if let (true, Some((thinnest, at))) = (run.thin.share > NOTABLE_SHARE, run.thin.thinnest) {
        let meets = run.mesh.touching.count + run.mesh.crossings.count > 0;
        let or =
            if meets { ", or parts of the mesh touch or overlap" } else { ": where no bead fits they are not printed" };
        let what = format!("walls are thinner than a cell of {cell_mm:.3} mm{or}");
        let place = format!("{thinnest:.3} mm near x {:.2}, y {:.2}, z {:.2} of the mesh", at.x, at.y, at.z);
        findings.add(Warning, what, format!("{} of the surface", percent(run.thin.share)), place);
    }
}

/// Of what the part stands on: a platform, a mould, support.
fn of_standing(run: &FieldRun, args: &Args, findings: &mut Findings) {
    let (diameter_mm, cell_mm) = (args.platform_diameter_mm(), run.solid.grid.cell_mm());
    let taken_mm = run.platform_diameter_mm();
    if taken_mm > diameter_mm + cell_mm {
        let what = format!("the part does not fit on a platform of {diameter_mm} mm");
        findings.add(Note, what, format!("one of {taken_mm:.1} mm was taken"), "--platform-diameter");
    }
    if let Some(mould) = &run.mould {
        findings.add(
            Note,
            format!("the part is printed on {}", mould.name),
            "",
            format!("it stands at {}", mould.place()),
        );
        if run.buried_mm3 > NOTABLE_BURIED * run.part_mm3 {
            let what =
                format!("the part reaches more than a cell into {}: what lies in there is not printed", mould.name);
            findings.add(Warning, what, format!("{:.1} mm3", run.buried_mm3), "");
        }
    }
    if run.support_mm3() > 0.0 {
        let below = match run.below_beads {
            0 => String::new(),
            cells => format!(", with {} below beads that had no support", counted(cells, "cell")),
        };
        let amount = format!("{:.1} mm3, to be broken off{below}", run.support_mm3());
        findings.add(Warning, "the part stands on support", amount, "--support");
    }
}

/// Of the order: what it misses, and what its checks say.
fn of_order(run: &FieldRun, args: &Args, findings: &mut Findings) {
    if !run.growth.nozzle.is_empty() {
        let amount =
            format!("{} of {}", grouped(run.growth.nozzle.len()), counted(run.growth.order.cells().len(), "cell"));
        let what = "cells were checked for this nozzle, not by the hull rule: a larger one may not reach them";
        // An order by distance is meant for the nozzle that prints.
        let is_by_hulls = run.layers_by.is_none_or(|layers_by| layers_by == curved::LayersBy::Hull);
        findings.add(if is_by_hulls { Warning } else { Note }, what, amount, "--nozzle");
    }
    if !run.audit.is_ok() {
        findings.add(Failed, "the audit of the layers failed", run.audit.to_string(), "field.csv");
    }
    if let Err(error) = run.proofs {
        findings.add(Failed, "a proof that a cell is impossible does not hold", error.to_string(), "impossible.csv");
    }
    let share = run.missed_share();
    if !run.growth.missed.is_empty() {
        let amount = format!("{} of its volume, {}", percent(share), missed_in_words(run));
        let place = "field.csv, cell_layer 0; impossible.csv";
        let finding = findings.explain(
            Severity::above(share, args.allow.allow_missed),
            "a part of the solid is not built",
            amount,
            place,
        );
        ways_out(run, args).into_iter().for_each(|way| _ = finding.try_to(way));
        finding.allow(accept("--allow-missed", share));
    }
}

/// Which cells are missed and why, and which of them no order can build.
fn missed_in_words(run: &FieldRun) -> String {
    let (missed, grid) = (&run.growth.missed, &run.solid.grid);
    let count = |is: &dyn Fn(MissedReason) -> bool| missed.iter().filter(|cell| is(cell.reason)).count();
    let inside = count(&|reason| matches!(reason, MissedReason::Shadowed { .. }));
    let out_of_reach = count(&|reason| reason == MissedReason::OutOfReach);
    let reach = if out_of_reach > 0 { format!(", {out_of_reach} out of reach of the nozzle") } else { String::new() };
    let places = || missed.iter().map(|cell| grid.position(cell.cell));
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let along = || places().map(|place| place[axis]);
        let [low, high] = [along().min(), along().max().map(|high| high + 1)]
            .map(|at| grid.origin()[axis] - run.solid.shift[axis] + f64::from(at.unwrap_or(0)) * grid.cell_mm());
        format!("{low:.1} to {high:.1}")
    });
    let proven: BTreeSet<u32> = run.impossible.iter().map(|impossible| impossible.cell).collect();
    let impossible = missed.iter().filter(|missed| proven.contains(&missed.cell)).count();
    format!(
        "{} of {} at x {x}, y {y}, z {z} of the mesh: {inside} inside the hull of the part built so far{reach}, {} without \
         support; by the hull rule {impossible} of them are proven impossible in any order; that rule alone misses {}, of which \
         {} are proven impossible in any order, {} are undecided",
        missed.len(),
        counted(grid.count(), "cell"),
        missed.len() - inside - out_of_reach,
        counted(run.missed_by_hull.len(), "cell"),
        run.impossible.len(),
        run.undecided()
    )
}

/// Whether the part may be turned to another pose.
fn can_turn(args: &Args) -> bool {
    args.orient != Lying::Best && args.mould.is_none()
}

/// The advice to do so, if it may.
fn another_pose(args: &Args) -> &'static str {
    if can_turn(args) { "--orient best" } else { "" }
}

/// What to do about missed cells.
fn ways_out(run: &FieldRun, args: &Args) -> [&'static str; 3] {
    let has = |is: &dyn Fn(MissedReason) -> bool| run.growth.missed.iter().any(|cell| is(cell.reason));
    let inside = has(&|reason| matches!(reason, MissedReason::Shadowed { .. }));
    let out_of_reach = has(&|reason| reason == MissedReason::OutOfReach);
    let support = match run.no_support {
        Some(NoSupport::Forbidden) => "--support auto builds them on columns (it is off)",
        Some(NoSupport::NoPlace) => "support finds no place below them",
        Some(NoSupport::NoHelp) => "support does not help, as many are missed with it",
        Some(_) => "support was left out, as part and support do not pass the audit",
        None if run.support.is_empty() => "without --resume, --support auto may build them on columns",
        None => "support was added, and leaves these",
    };
    let (nozzle_growth, _) = args.complete.with_strategy(args.grow.strategy().is_none());
    let nozzle = match nozzle_growth {
        NozzleGrowth::Off if inside => "--nozzle-growth after builds what the nozzle reaches (it is off)",
        _ if out_of_reach => "a slimmer --nozzle reaches more",
        _ => "",
    };
    let pose = if can_turn(args) { "--orient best looks for a pose that misses fewer" } else { "" };
    [support, nozzle, pose]
}

/// Of the surfaces.
fn of_surfaces(field: &FieldRun, run: &SurfacesRun, findings: &mut Findings) {
    let (layers, part) = (run.spacing.volume_mm3, field.part_mm3);
    if run.is_whole() && (layers / part - 1.0).abs() > NOTABLE_LAYERS {
        let amount = format!("{} of its volume, {layers:.1} of {part:.1} mm3", percent(layers / part));
        findings.add(
            Warning,
            "the volume of the layers differs from that of the part",
            amount,
            "layers.vtk; another --layer-height or --cell",
        );
    }
    let left = run.clipped.left;
    if left.crossing > 0 {
        let amount = format!("at {} of {}", grouped(left.crossing), counted(left.edges, "edge"));
        findings.add(Warning, "surfaces pass through each other where clipping cannot cut them", amount, "layers.vtk");
    }
    if run.spacing.squeezed_share > NOTABLE_SHARE {
        let amount = format!("{} of the area", percent(run.spacing.squeezed_share));
        findings.add(Warning, "surfaces are nearer to each other than 0.3 of the layer height", amount, "layers.vtk");
    }
}

/// Of the paths.
fn of_paths(run: &PathsRun, findings: &mut Findings) {
    let totals = &run.totals;
    let too_thin = &run.too_thin;
    // Without statistics only pieces that get no bead at all are known, not the tips of others.
    let unfillable = totals.unfillable_fraction.max(too_thin.area_mm2 / totals.area_mm2.max(f64::MIN_POSITIVE));
    if unfillable > NOTABLE_SHARE {
        let what = format!("no bead of {:.3} mm fits into a part of the layers", run.bead_mm);
        let amount = format!(
            "{} of their area; {} of {:.1} mm3 without any bead",
            percent(unfillable),
            counted(too_thin.parts, "piece"),
            too_thin.volume_mm3
        );
        findings.add(Warning, what, amount, "--bead");
    }
    if run.bridges.length_mm > 0.0 {
        let amount =
            format!("{:.1} m in all, the longest {:.1} mm", run.bridges.length_mm / 1000.0, run.bridges.longest_mm);
        findings.add(Note, "skins bridge what is sparse below them", amount, "--skin, --density");
    }
    if totals.self_crossings > 0 {
        findings.add(Warning, "paths cross each other", counted(totals.self_crossings, "time"), "paths.obj");
    }
}

/// Of the machine file.
fn of_machine(field: &FieldRun, paths: &PathsRun, run: &MachineRun, args: &Args, findings: &mut Findings) {
    of_gouging(paths, run, args, findings);
    of_left_out(run, args, findings);
    of_turns(run, findings);
    if !run.travels.blocked.is_empty() {
        let amount = run.travels.blocked.len().to_string();
        findings.add(Failed, "travels collide with printed material", amount, "blocked_travels.csv");
    }
    of_volume(field, paths, run, args, findings);
}

/// Of the nozzle in the part: where it stays, and where it is raised out of it.
fn of_gouging(paths: &PathsRun, run: &MachineRun, args: &Args, findings: &mut Findings) {
    let (left, waypoints) = (run.resolved.left.len(), run.waypoints());
    if left > 0 {
        let share = run.gouging_share();
        let amount = format!("at {} of {}, {}", grouped(left), counted(waypoints, "waypoint"), percent(share));
        let severity = Severity::above(share, args.allow.allow_gouging);
        let finding =
            findings.explain(severity, "the nozzle collides with the part or the plate", amount, "gouging.csv");
        let by_tip = run.resolved.left.iter().filter(|gouge| gouge.part == NozzlePart::Tip).count();
        if run.tip_mm > paths.bead_mm && by_tip > 0 {
            let (tip, bead) = (run.tip_mm, paths.bead_mm);
            finding
                .cause(format!("the tip of the nozzle is {tip} mm across, the beads are {bead:.2} mm wide: at {} of them it is the tip that collides", grouped(by_tip)))
                .try_to(format!("--nozzle with a tip of {bead:.2} mm or less, if that is your nozzle"))
                .try_to(format!("--bead {tip}"));
        } else {
            finding.try_to("--nozzle with the true shape of a slimmer nozzle").try_to(another_pose(args));
        }
        finding.allow(accept("--allow-gouging", share));
    }
    if run.resolved.lifted > 0 {
        let amount =
            format!("at {}, by {}", counted(run.resolved.lifted, "waypoint"), at_most_mm(run.resolved.max_lift));
        findings.add(Note, "the nozzle is raised a little where it would collide with printed material", amount, "");
    }
}

/// Of the paths that are left out, since the nozzle does not get there.
fn of_left_out(run: &MachineRun, args: &Args, findings: &mut Findings) {
    let ([laid, left_out], pieces) = (run.lengths_mm(), run.resolved.left_out.len());
    if left_out > 0.0 {
        let share = run.left_out_share();
        let with_gaps = if pieces > 0 && run.resolved.gaps > 0.0 { ", gaps at sharp turns included" } else { "" };
        let amount = format!("{left_out:.1} of {:.1} mm, {}{with_gaps}", laid + left_out, percent(share));
        let severity = Severity::above(share, args.allow.allow_left_out);
        let what = match pieces {
            0 => "gaps in the paths, at turns that are too sharp for the nozzle".to_owned(),
            _ => format!("{} skipped: out of the nozzle's reach", counted(pieces, "path segment")),
        };
        let list = if pieces > 0 { "left_out.csv" } else { "turns.csv" };
        findings
            .explain(severity, what, amount, list)
            .try_to("a slimmer --nozzle")
            .try_to(another_pose(args))
            .allow(accept("--allow-left-out", share));
    }
}

/// Of turns that are sharper than the nozzle may turn.
fn of_turns(run: &MachineRun, findings: &mut Findings) {
    let turns = run.resolved.cut_turns.iter().map(|turn| turn.angle.to_degrees());
    if let Some(largest) = turns.reduce(f64::max) {
        let gaps = run.resolved.gaps;
        let gaps = if gaps > 0.0 { format!(", {gaps:.1} mm are not printed there") } else { String::new() };
        let amount = format!("{}, {largest:.0} degrees at most{gaps}", counted(run.resolved.cut_turns.len(), "time"));
        let what = "paths are cut, since the nozzle would turn more sharply than --max-turn allows";
        findings.add(Warning, what, amount, "turns.csv");
    }
    let turns = run.resolved.sharp.iter().map(|turn| turn.angle.to_degrees());
    if let Some(largest) = turns.reduce(f64::max) {
        let amount = format!("{}, {largest:.0} degrees at most", counted(run.resolved.sharp.len(), "time"));
        let what = "the nozzle turns more sharply than --max-turn allows, and goes slowly: a cut would leave a gap in the bead";
        findings.add(Warning, what, amount, "turns.csv");
    }
}

/// Of the deposited volume.
fn of_volume(field: &FieldRun, paths: &PathsRun, run: &MachineRun, args: &Args, findings: &mut Findings) {
    // With its support, which is laid as well; what sparse infill leaves empty is not to be laid.
    let (laid, missed) = (run.deposition.extruded_mm3, field.missed_mm3);
    let (part, off) = (to_lay_mm3(field, paths), run.volume_off(field, paths));
    let [filled, rest] = run.filled_shares(field, paths);
    if off > NOTABLE_VOLUME {
        let severity = Severity::above(off, args.allow.allow_volume);
        // These cells follow one by one, so their layers are torn into pieces that take no bead.
        let by_nozzle = field.growth.nozzle.len() as f64 / field.growth.order.cells().len() as f64;
        let (_, support) = args.complete.with_strategy(args.grow.strategy().is_none());
        let is_torn = rest < 1.0 && by_nozzle > NOTABLE_SHARE && support == Support::None;
        let advice = if is_torn {
            "--support auto, which builds on columns the cells that only this nozzle reaches; their layers are torn, and no bead fits"
        } else {
            ""
        };
        let unfilled = paths.totals.unfillable_fraction;
        let cause = match (rest < 1.0, missed > 0.0) {
            (true, _) if unfilled > NOTABLE_SHARE => {
                format!("no bead of {:.3} mm fits into {} of the layers' area", paths.bead_mm, percent(unfilled))
            }
            (true, true) => format!("{missed:.1} mm3 are cells that are not built"),
            _ => String::new(),
        };
        let rest = if missed > 0.0 { format!("; {} of what is not missed", percent(rest)) } else { String::new() };
        let what = format!("deposited volume is {} of the part's", percent(filled));
        let slimmer = if cause.starts_with("no bead") { "a smaller --bead" } else { "" };
        findings
            .explain(severity, what, format!("{laid:.1} of {part:.1} mm3{rest}"), "")
            .cause(cause)
            .try_to(advice)
            .try_to(slimmer)
            .allow(accept("--allow-volume", off));
    }
}

/// Of the flavour of the machine file: whether the machine stands upright where the plan leans.
fn of_flavour(run: &MachineRun, args: &Args, findings: &mut Findings) {
    let leaves_out = |flavour: &&Flavour| matches!(flavour.direction, Direction::Upright | Direction::Comment);
    let Some(flavour) = args.loaded_flavour.as_ref().filter(leaves_out) else { return };
    let axes = run.resolved.paths.iter().flat_map(|path| &path.waypoints).map(|waypoint| waypoint.axis.z);
    let lean = axes.fold(1.0, f64::min).clamp(-1.0, 1.0).acos();
    if lean > NOTABLE_LEAN {
        let what = format!(
            "the machine file leaves the direction of the nozzle out, as the flavour `{}` has none",
            flavour.name
        );
        let amount = format!("by up to {:.0} degrees", lean.to_degrees());
        let finding = findings.explain(Warning, what, amount, "toolpath.gcode");
        finding.cause("collisions were checked with the planned directions, and the machine stands upright");
        finding.try_to("a flavour that takes directions, such as --flavour siemens or heidenhain, or the axes of a machine: --machine");
    }
}

/// Of the feed: most of the time held by the limit of turning.
fn of_feed(run: &MachineRun, findings: &mut Findings) {
    let [_, _, _, turning] = run.deposition.limits.shares();
    if turning > NOTABLE_TURNING {
        let (mean, asked) = (run.deposition.bead_mm / run.deposition.print_s, run.max_feed);
        let amount = format!("mean {mean:.0} mm/s, maximum {asked:.0} mm/s");
        let cause = format!("the nozzle turns at its limit for {} of the print time", percent(turning));
        let finding = findings.explain(Warning, "turns of the nozzle slow down printing", amount, "");
        finding.cause(cause).try_to("a higher --max-turn-rate, if the machine permits");
    }
}

/// Of what beads lie on, with the length along which layers end inside the part.
fn of_support((bead_mm, borders_mm): (f64, f64), run: &MachineRun, args: &Args, findings: &mut Findings) {
    let support = &run.support;
    if !support.spans.is_empty() {
        let what = "beads span gaps, straight and held at both ends";
        let (count, longest) = (counted(support.spans.len(), "piece"), support.longest_span_mm());
        let amount = format!("{:.1} mm in {count}, the longest {longest:.1} mm", support.span_mm());
        findings.add(Warning, what, amount, "spans.csv");
    }
    if support.unsupported.is_empty() {
        return;
    }
    let (share, longest) = (support.unsupported_share(), support.longest_mm());
    let on = if args.mould.is_some() { "plate, mould" } else { "plate" };
    let what = format!(
        "unsupported beads: neither {on} nor earlier bead within {} layer heights",
        args.support_distance_heights
    );
    let long = support.unsupported.iter().filter(|piece| piece.length() > bead_mm).count();
    let amount = format!(
        "{:.1} of {:.1} mm, {}; {} longer than a bead is wide, the longest {longest:.1} mm, and {}",
        support.unsupported_mm(),
        support.bead_mm,
        percent(share),
        counted(long, "piece"),
        counted(support.unsupported.len() - long, "crumb")
    );
    let AllowArgs { allow_unsupported, allow_unsupported_beads, .. } = args.allow;
    let limits = [(share, allow_unsupported), (longest / bead_mm, allow_unsupported_beads)];
    let (_, grown) = args.complete.with_strategy(args.grow.strategy().is_none());
    let is_by_hulls = args.layers_by() == LayersBy::Hull && args.resume.is_none();
    let has_failed = limits.into_iter().any(|(value, limit)| value > limit);
    let severity = if has_failed { Failed } else { Warning };
    findings
        .explain(severity, what, amount, "unsupported.csv")
        .cause(if borders_mm > 0.0 {
            format!("layers end inside the part along {borders_mm:.0} mm; beads of later layers beyond these ends may be unsupported")
        } else {
            String::new()
        })
        .try_to(if is_by_hulls { "--layers-by best" } else { "" })
        .try_to(if grown == Support::None { "--support auto" } else { "" })
        .try_to(another_pose(args))
        .allow(format!(
            "{} and {}",
            accept("--allow-unsupported", share),
            accept("--allow-unsupported-beads", longest / bead_mm)
        ));
}

/// Of the bodies of the arm: what "proven free" is proven for.
fn of_bodies<const N: usize, const F: usize, W: Workcell<N, F>>(run: &MotionRun<N, F, W>, findings: &mut Findings) {
    let equipment = run.cell.equipment();
    if equipment.model().is_assumed() {
        let what = "the workcell around the arm is assumed: nozzle, plate and stand are not yours; `check_cell ARM --write FILE` makes a file to put your \
                    numbers in";
        findings.add(Warning, what, equipment.name(), "--workcell");
    }
    if let Some((arm, note)) = equipment.catalogue_arm().and_then(|arm| Some((arm, arm.note?))) {
        findings.add(Note, note, arm.title, "arm.geometry of the workcell");
    }
    let Some(bodies) = equipment.link_bodies().filter(|_| !run.without_links) else {
        let what = "the arm was planned without bodies: no motion is proven free of collisions";
        return findings.add(Warning, what, "", "--no-links");
    };
    let (margin_mm, allowance_mm) = (run.margin_mm, equipment.model().arm.allowance_mm);
    let error = match bodies.is_estimate {
        true => "an estimate".to_owned(),
        false => format!("right to about {} mm", bodies.error_mm),
    };
    let amount = format!(
        "{}, {error}; with an allowance of {allowance_mm} mm for cables and a margin of {margin_mm} mm",
        bodies.model
    );
    let what = "motions are proven free for the bodies as they are modelled; nozzle against part and plate is sampled while it prints";
    findings.add(Note, what, amount, "--link-allowance, --margin");
    if bodies.is_estimate {
        let what = "the bodies of the arm are an estimate: real links may be thicker, try the motions slowly first";
        findings.add(Warning, what, "", "arm.bodies of the workcell");
    }
    if margin_mm <= bodies.error_mm {
        let what = "the margin is not above the error of the arm's bodies: motions proven free may touch";
        findings.add(Warning, what, format!("{margin_mm} mm against {} mm", bodies.error_mm), "--margin");
    }
}

/// Of the motion: what the plan leaves undone, and what the check of the written motions found.
fn of_plan<const N: usize, const F: usize>(
    plan: &PrintPlan<N, F>,
    checked: Option<&Checked<N>>,
    allowed: f64,
    findings: &mut Findings,
) {
    let unprinted = checked.map_or(1.0, |checked| checked.unprinted_mm / checked.path_mm.max(f64::MIN_POSITIVE));
    let severity = if allowed > 0.0 { Severity::above(unprinted, allowed) } else { Failed };
    of_faults(plan, severity, unprinted, findings);
    of_slow_motions(plan, findings);
    let Some(checked) = checked else { return };
    let report = &checked.report;
    for class in FindingClass::ALL.into_iter().filter(|class| report.count(*class) > 0) {
        let programs = if class.is_unsafe() { "; they are in no program" } else { "" };
        let what = format!("motions are {}{programs}", class.name());
        let amount = format!("{} of {}", report.count(class), report.print.motions);
        findings.add(Failed, what, amount, "motion-check.csv");
    }
    if checked.unprinted_mm > 0.0 {
        let (mm, all) = (checked.unprinted_mm, checked.path_mm);
        let amount =
            format!("{mm:.1} of {all:.1} mm, {}; beads above them, if any, are unsupported", percent(unprinted));
        findings
            .explain(severity, "paths are not printed", amount, "left_out.csv, motion-faults.csv")
            .allow(accept("--allow-unprinted", unprinted));
    }
}

/// Of what the robot cannot print, by kinds.
fn of_faults<const N: usize, const F: usize>(
    plan: &PrintPlan<N, F>,
    severity: Severity,
    unprinted: f64,
    findings: &mut Findings,
) {
    let elsewhere = "nozzle and part elsewhere in the --workcell: `reach` finds where the arm reaches most";
    let kinds = [
        (FaultKind::Unreachable, "waypoints are out of the robot's reach and not printed", elsewhere),
        (
            FaultKind::Blocked,
            "waypoints skipped: the robot would collide",
            "a part farther from the wrist or a slimmer nozzle in the --workcell",
        ),
        (FaultKind::Break, "paths break off, and the way from one waypoint to the next is not printed", elsewhere),
        (
            FaultKind::NoTransfer,
            "transfers were not found: programs end there at home, and paths to which no way leads from home are not printed",
            "a part farther from the wrist, or home_deg in the --workcell",
        ),
    ];
    for (kind, what, advice) in kinds.into_iter().filter(|(kind, ..)| plan.count(*kind) > 0) {
        let finding = findings.explain(severity, what, plan.count(kind).to_string(), "motion-faults.csv");
        finding.try_to(advice).allow(accept("--allow-unprinted", unprinted));
    }
}

/// Of motions that are slower than planned, or than they could be.
fn of_slow_motions<const N: usize, const F: usize>(plan: &PrintPlan<N, F>, findings: &mut Findings) {
    if plan.printing_s > (1.0 + NOTABLE_DELAY) * plan.planned_s {
        let [printing, planned] = [plan.printing_s, plan.planned_s].map(|seconds| seconds / 60.0);
        let amount = format!(
            "printing takes {printing:.1} min instead of {planned:.1}, at {} of the planned feed at least",
            percent(plan.min_pace)
        );
        findings.add(
            Warning,
            "motions are slowed down to keep the limits of joints and extruder",
            amount,
            "layers.csv",
        );
    }
    if plan.slow_runs > 0 {
        let what = "motions may be slower than their limits allow: the search for the fastest timing stopped early";
        findings.add(Warning, what, format!("{} of {}", plan.slow_runs, plan.runs.len()), "summary.json");
    }
}
