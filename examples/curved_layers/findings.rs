//! What is wrong with what each stage has made, in plain words: when it is told, and when the exit status is 3.

use crate::complete::{NozzleGrowth, Support};
use crate::field::FieldRun;
use crate::machine::MachineRun;
use crate::motion::check::Checked;
use crate::motion::of_run;
use crate::paths::PathsRun;
use crate::surfaces::SurfacesRun;
use crate::{Args, Lying, Results, Stage};
use Severity::{Failed, Noted, Told};
use curvlay_examples::args::AllowArgs;
use curvlay_examples::findings::{Findings, Severity, percent};
use curvlay_layers::curved::{MissedReason, NoSupport};
use curvlay_trajectory::check::FindingClass;
use curvlay_trajectory::print::{FaultKind, PrintPlan};
use std::collections::BTreeSet;

/// Shares of area from which on something is worth a word. Of thin walls sharp edges alone make up some tenths of a percent.
const NOTABLE_SHARE: f64 = 0.01;

/// From how far on the volume of layers is told, and the volume laid; as shares of the part.
const NOTABLE_LAYERS: f64 = 0.05;
const NOTABLE_VOLUME: f64 = 0.02;

/// From how much longer on than planned printing is told to be slow: a motion from rest to rest is always a little longer.
const NOTABLE_DELAY: f64 = 0.05;

/// Adds what is wrong with a stage that has ended; the first two end together.
pub fn of_stage(stage: Stage, args: &Args, results: &mut Results) {
    let Results { field, surfaces, paths, machine, motion, findings, .. } = results;
    match stage {
        Stage::Field | Stage::Surfaces => {
            of_field(field, args, findings);
            surfaces.iter().for_each(|run| of_surfaces(field, run, findings));
        }
        Stage::Paths => paths.iter().for_each(|run| of_paths(run, findings)),
        Stage::Gcode => machine.iter().zip(paths.iter()).for_each(|(run, paths)| {
            of_machine(field, paths, run, args, findings);
            of_support(paths.bead_mm, run, args, findings);
        }),
        Stage::Motion => {
            motion.iter().for_each(|motion| of_run!(motion, run => of_plan(&run.plan, run.checked.as_ref(), findings)))
        }
    }
}

/// Of the mesh, the cells and their order.
fn of_field(run: &FieldRun, args: &Args, findings: &mut Findings) {
    let (diameter_mm, allow) = (args.platform_diameter_mm(), &args.allow);
    let (report, cell_mm) = (&run.solid.report, run.solid.grid.cell_mm());
    if !run.mesh.is_sound() {
        // The first line says how large it is.
        run.mesh.to_string().lines().skip(1).for_each(|line| findings.add(Told, format!("the mesh: {line}"), "", ""));
    }
    if report.dropped_triangles > 0 {
        findings.add(Noted, "triangles without area were dropped", report.dropped_triangles.to_string(), "");
    }
    if report.leak_faces > 0 {
        let amount = format!("{} cells near them were decided one by one by winding number", report.cells_asked_singly);
        findings.add(Told, "the mesh has holes wider than a cell", amount, "");
    }
    if report.inside_out {
        findings.add(Noted, "the faces point inwards: the part was taken as turned the right way round", "", "");
    }
    if let (true, Some((thinnest, at))) = (run.thin.share > NOTABLE_SHARE, run.thin.thinnest) {
        let meets = run.mesh.touching.count + run.mesh.crossings.count > 0;
        let or =
            if meets { ", or parts of the mesh touch or overlap" } else { ": where no bead fits they are not printed" };
        let what = format!("walls are thinner than a cell of {cell_mm:.3} mm{or}");
        let place = format!("{thinnest:.3} mm near x {:.2}, y {:.2}, z {:.2} of the mesh", at.x, at.y, at.z);
        findings.add(Told, what, format!("{} of the surface", percent(run.thin.share)), place);
    }
    let taken_mm = run.platform_diameter_mm();
    if taken_mm > diameter_mm + cell_mm {
        let what = format!("the part does not fit on a platform of {diameter_mm} mm");
        findings.add(Noted, what, format!("one of {taken_mm:.1} mm was taken"), "--platform-diameter");
    }
    if !run.support.is_empty() {
        let amount = format!("{} cells, {:.1} mm3, to be broken off", run.support.len(), run.support_mm3());
        findings.add(Told, "the part stands on support", amount, "--support");
    }
    if !run.growth.nozzle.is_empty() {
        let amount = format!("{} of {} cells", run.growth.nozzle.len(), run.growth.order.cells().len());
        let what = "cells lie inside the hull of what is built before: this nozzle reaches them, a larger one may not";
        findings.add(Told, what, amount, "--nozzle");
    }
    if !run.audit.is_ok() {
        findings.add(Failed, "the audit of the layers failed", run.audit.to_string(), "field.csv");
    }
    if let Err(error) = run.proofs {
        findings.add(Failed, "a proof that a cell is impossible does not hold", error.to_string(), "impossible.csv");
    }
    let share = run.missed_share();
    if !run.growth.missed.is_empty() {
        let amount = format!("{} of its volume, {}", percent(share), missed_in_words(run, args));
        let place = "field.csv, cell_layer 0; impossible.csv; --allow-missed";
        findings.add(Severity::above(share, allow.allow_missed), "a part of the solid is not built", amount, place);
    }
}

/// Which cells are missed and why, which of them no order can build, and what to do.
fn missed_in_words(run: &FieldRun, args: &Args) -> String {
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
        "{} of {} cells at x {x}, y {y}, z {z} of the mesh: {inside} inside the hull of what is built by then{reach}, {} with nothing to \
         stand on; by the hull rule {impossible} of them are proven impossible in any order; that rule alone misses {} cells, of which \
         {} are proven impossible in any order, {} are undecided; to do: {}",
        missed.len(),
        grid.count(),
        missed.len() - inside - out_of_reach,
        run.missed_by_hull.len(),
        run.impossible.len(),
        run.undecided(),
        ways_out(run, args, [inside, out_of_reach])
    )
}

/// What to do about missed cells, of which so many lie inside the hull, and out of reach of the nozzle.
fn ways_out(run: &FieldRun, args: &Args, [inside, out_of_reach]: [usize; 2]) -> String {
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
        NozzleGrowth::Off if inside > 0 => "--nozzle-growth after builds what the nozzle reaches (it is off)",
        _ if out_of_reach > 0 => "a slimmer --nozzle reaches more",
        _ => "",
    };
    let pose = if args.orient == Lying::Best { "" } else { "--orient best looks for a pose that misses fewer" };
    [support, nozzle, pose].into_iter().filter(|way| !way.is_empty()).collect::<Vec<_>>().join(", ")
}

/// Of the surfaces.
fn of_surfaces(field: &FieldRun, run: &SurfacesRun, findings: &mut Findings) {
    let (layers, part) = (run.spacing.volume_mm3, field.part_mm3);
    if (layers / part - 1.0).abs() > NOTABLE_LAYERS {
        let amount = format!("{} of its volume, {layers:.1} of {part:.1} mm3", percent(layers / part));
        findings.add(
            Told,
            "the layers do not hold what the part holds",
            amount,
            "layers.vtk; another --layer-height or --cell",
        );
    }
    let left = run.clipped.left;
    if left.crossing > 0 {
        let amount = format!("at {} of {} edges", left.crossing, left.edges);
        findings.add(Told, "surfaces pass through each other where clipping cannot cut them", amount, "layers.vtk");
    }
    if run.spacing.squeezed_share > NOTABLE_SHARE {
        let amount = format!("{} of the area", percent(run.spacing.squeezed_share));
        findings.add(Told, "surfaces are nearer to each other than 0.3 of the layer height", amount, "layers.vtk");
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
            "{} of their area; {} pieces of {:.1} mm3 get none at all",
            percent(unfillable),
            too_thin.parts,
            too_thin.volume_mm3
        );
        findings.add(Told, what, amount, "--bead");
    }
    if run.bridges.length_mm > 0.0 {
        let amount =
            format!("{:.1} m in all, the longest {:.1} mm", run.bridges.length_mm / 1000.0, run.bridges.longest_mm);
        findings.add(Noted, "skins bridge what is sparse below them", amount, "--skin, --density");
    }
    if totals.self_crossings > 0 {
        findings.add(Told, "paths cross each other", format!("{} times", totals.self_crossings), "paths.obj");
    }
}

/// Of the machine file.
fn of_machine(field: &FieldRun, paths: &PathsRun, run: &MachineRun, args: &Args, findings: &mut Findings) {
    let allow = &args.allow;
    let (left, waypoints) = (run.resolved.left.len(), run.waypoints());
    if left > 0 {
        let share = left as f64 / waypoints as f64;
        let amount = format!("at {left} of {waypoints} waypoints, {}", percent(share));
        let severity = Severity::above(share, allow.allow_gouging);
        findings.add(
            severity,
            "the nozzle is in what is built or in the plate",
            amount,
            "gouging.csv; --allow-gouging",
        );
    }
    if run.resolved.lifted > 0 {
        let amount = format!("at {} waypoints, by {:.2} mm at most", run.resolved.lifted, run.resolved.max_lift);
        findings.add(Noted, "the nozzle is raised a little, where it would be in what is built", amount, "");
    }
    let ([laid, left_out], pieces) = (run.lengths_mm(), run.resolved.left_out.len());
    if pieces > 0 {
        let share = left_out / (laid + left_out);
        let amount = format!("{pieces} pieces, {left_out:.1} of {:.1} mm, {}", laid + left_out, percent(share));
        let severity = Severity::above(share, allow.allow_left_out);
        findings.add(
            severity,
            "paths are left out, as the nozzle does not get there",
            amount,
            "left_out.csv; --allow-left-out",
        );
    }
    if !run.resolved.sharp.is_empty() {
        let amount = format!(
            "{} times, by {:.0} degrees at most",
            run.resolved.sharp.len(),
            run.resolved.turns.largest.to_degrees()
        );
        findings.add(
            Told,
            "the nozzle turns by more than 10 degrees from one waypoint to the next",
            amount,
            "turns.csv",
        );
    }
    if !run.travels.blocked.is_empty() {
        let amount = run.travels.blocked.len().to_string();
        findings.add(Failed, "travels run into what is built", amount, "blocked_travels.csv");
    }
    // With its support, which is laid as well; what sparse infill leaves empty is not to be laid.
    let (laid, missed) = (run.deposition.extruded_mm3, field.missed_mm3);
    let part = field.part_mm3 + field.support_mm3() - paths.hollow_mm3();
    let (filled, rest) = (laid / part, laid / (part - missed));
    let off = |share: f64| (share - 1.0).abs();
    if off(filled).max(off(rest)) > NOTABLE_VOLUME {
        let what = if rest < 1.0 { "less is laid than the part holds" } else { "more is laid than the part holds" };
        let severity = Severity::above(off(filled).max(off(rest)), allow.allow_volume);
        // These cells follow one by one, so their layers are torn into pieces that take no bead.
        let by_nozzle = field.growth.nozzle.len() as f64 / field.growth.order.cells().len() as f64;
        let (_, support) = args.complete.with_strategy(args.grow.strategy().is_none());
        let is_torn = rest < 1.0 && by_nozzle > NOTABLE_SHARE && support == Support::None;
        let advice = if is_torn {
            "; layers of cells that only this nozzle reaches are torn, and no bead fits: to do: --support auto builds such cells \
             on columns (it is off)"
        } else {
            ""
        };
        let rest = if missed > 0.0 { format!("; {} of what is not missed", percent(rest)) } else { String::new() };
        let amount = format!("{} of its volume, {laid:.1} of {part:.1} mm3{rest}{advice}", percent(filled));
        findings.add(severity, what, amount, "--allow-volume");
    }
}

/// Of what beads lie on.
fn of_support(bead_mm: f64, run: &MachineRun, args: &Args, findings: &mut Findings) {
    let support = &run.support;
    if support.unsupported.is_empty() {
        return;
    }
    let (share, longest) = (support.unsupported_share(), support.longest_mm());
    let what =
        format!("beads lie on nothing: neither plate nor earlier bead within {} layer heights", args.support_distance);
    let amount = format!(
        "{:.1} of {:.1} mm, {}, in {} pieces, the longest {longest:.1} mm",
        support.unsupported_mm(),
        support.bead_mm,
        percent(share),
        support.unsupported.len()
    );
    let AllowArgs { allow_unsupported, allow_unsupported_beads, .. } = args.allow;
    let limits = [(share, allow_unsupported), (longest / bead_mm, allow_unsupported_beads)];
    // Layers that end inside the part leave steps on which nothing can be done for beads: told unless a limit is asked for.
    let has_failed = limits.into_iter().any(|(value, limit)| limit.is_some_and(|limit| value > limit));
    let severity = if has_failed { Failed } else { Told };
    findings.add(severity, what, amount, "unsupported.csv; --allow-unsupported, --allow-unsupported-beads");
}

/// Of the motion: what the plan leaves undone, and what the check of the written motions found.
fn of_plan<const N: usize, const F: usize>(
    plan: &PrintPlan<N, F>,
    checked: Option<&Checked<N>>,
    findings: &mut Findings,
) {
    let kinds = [
        (FaultKind::Unreachable, "waypoints are out of the robot's reach and not printed"),
        (FaultKind::Blocked, "waypoints are not printed, as the robot would run into something at each of them"),
        (FaultKind::Break, "paths break off, and the way from one waypoint to the next is not printed"),
        (
            FaultKind::NoTransfer,
            "transfers were not found: programs end there at home, and paths to which no way leads from home are not printed",
        ),
    ];
    for (kind, what) in kinds.into_iter().filter(|(kind, _)| plan.count(*kind) > 0) {
        findings.add(Failed, what, plan.count(kind).to_string(), "motion-faults.csv");
    }
    if plan.printing_s > (1.0 + NOTABLE_DELAY) * plan.planned_s {
        let [printing, planned] = [plan.printing_s, plan.planned_s].map(|seconds| seconds / 60.0);
        let amount = format!(
            "printing takes {printing:.1} min instead of {planned:.1}, at {} of the planned feed at least",
            percent(plan.min_pace)
        );
        findings.add(Told, "motions are slowed down to keep the limits of joints and extruder", amount, "layers.csv");
    }
    let Some(checked) = checked else { return };
    let report = &checked.report;
    for class in FindingClass::ALL.into_iter().filter(|class| report.count(*class) > 0) {
        let programs = if class.is_unsafe() { "; they are in no program" } else { "" };
        let what = format!("motions are {}{programs}", class.name());
        let amount = format!("{} of {}", report.count(class), report.print.motions);
        findings.add(Failed, what, amount, "motion-check.csv");
    }
    if checked.unprinted_mm > 0.0 {
        let (unprinted, all) = (checked.unprinted_mm, checked.path_mm);
        let amount =
            format!("{unprinted:.1} of {all:.1} mm, {}; layers above them go over the void", percent(unprinted / all));
        findings.add(Failed, "paths are in no program", amount, "left_out.csv, motion-faults.csv");
    }
}
