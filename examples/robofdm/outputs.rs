//! What the example leaves behind: the tables on stdout, meshes of the parts, `parts.csv`, lists of what is left out and of faults,
//! programs, pictures, `report.html` and `summary.json`.

use super::decompose::{Divided, reason};
use super::{Args, Base, Made, Method, drawing};
use curvlay_examples::args::{Failure, typed_name};
use curvlay_examples::findings::{Findings, percent};
use curvlay_examples::mesh::Mesh;
use curvlay_examples::motion::{Moved, Printed, is_program, shown};
use curvlay_examples::output::{OutputFolder, is_numbered};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::{Table, direction};
use curvlay_examples::viewer::{self, Mark, Marks, Model};
use curvlay_layers::planar::robofdm::Pedestal;
use curvlay_layers::planar::{FlatLayer, Solid};
use curvlay_toolpath::gcode::{WriteOptions, marked_moves, write_gcode};
use curvlay_trajectory::print::FaultKind;
use std::io::{self, Write};
use std::time::Instant;

/// Red, green and blue of what is left out.
const LEFT_OUT: [u8; 3] = [150, 60, 200];

/// The parts as a machine file.
const GCODE: &str = "parts.gcode";

/// The most steps of which there is a picture.
const SHOWN: usize = 24;

pub fn write(
    args: &Args,
    made: &Made,
    findings: &Findings,
    folder: &OutputFolder,
    start: Instant,
) -> Result<(), Failure> {
    folder.clear(is_ours)?;
    let divided = &made.divided;
    if let Some(pedestal) = &divided.pedestal {
        let (vertices, triangles) = pedestal.mesh();
        folder.write_with("pedestal.stl", |out| Mesh { vertices, triangles }.write_stl(out))?;
    }
    for (k, part) in divided.parts.parts.iter().enumerate() {
        folder.write_with(&format!("part_{:02}.stl", k + 1), |out| mesh_of(&part.solid).write_stl(out))?;
    }
    folder.write_with("parts.csv", |out| write_parts(made, out))?;
    if let Some(printed) = &made.printed {
        folder.write_with(GCODE, |out| {
            // An error of the writer's own means a move of ours that no file can have.
            write_gcode(
                marked_moves(&printed.plan.deposition.moves, &printed.plan.resolved.paths),
                &WriteOptions::default(),
                out,
            )
            .map(|_| ())
            .map_err(io::Error::other)
        })?;
        let left_out = &printed.plan.resolved.left_out;
        folder.write_list("left_out.csv", !left_out.is_empty(), |out| write_left_out(made, printed, out))?;
        if let Some(moved) = &printed.moved {
            folder.write_list("faults.csv", !moved.faults.is_empty(), |out| write_faults(made, printed, moved, out))?;
            for (name, bytes) in &moved.files {
                folder.write(name, bytes)?;
            }
        }
    }
    let parts = drawing::parts(divided);
    folder.write("parts.png", &parts)?;
    let segments = drawing::segments(divided);
    for (name, _, png) in &segments {
        folder.write(name, png)?;
    }
    let count = divided.parts.parts.len().min(SHOWN);
    let steps: Vec<Vec<u8>> = (0..count).map(|step| drawing::step(divided, step)).collect();
    for (k, png) in steps.iter().enumerate() {
        folder.write(&format!("step_{:02}.png", k + 1), png)?;
    }
    folder.write(
        "report.html",
        report(args, made, findings, &Pictures { parts: &parts, segments: &segments, steps: &steps }).to_html(),
    )?;
    // The summary comes last: where it is, all is there.
    summary(args, made, findings, start)?.write(folder)?;
    Ok(())
}

/// Files that an earlier run may have left.
pub fn is_ours(name: &str) -> bool {
    is_numbered(name, "part_", 2, ".stl")
        || is_numbered(name, "step_", 2, ".png")
        || is_program(name)
        || drawing::SEGMENTS.iter().any(|(picture, _)| *picture == name)
        || [GCODE, "pedestal.stl", "parts.csv", "left_out.csv", "faults.csv", "parts.png", "report.html"]
            .contains(&name)
}

fn mesh_of(solid: &Solid) -> Mesh {
    Mesh { vertices: solid.vertices().to_vec(), triangles: solid.triangles().to_vec() }
}

fn write_parts(made: &Made, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "part,dx,dy,dz,base_mm,on,volume_mm3,risky_mm2,seam_mm2,unsupported_mm2,layers,layer_mm,filament,load_angle_deg,carried_mm3,stress_mpa,allowed_mpa,left_because"
    )?;
    let divided = &made.divided;
    for (k, part) in divided.parts.parts.iter().enumerate() {
        let d = part.direction;
        let base = part.base.map_or_else(String::new, |base| format!("{:.6}", base.offset()));
        let on: Vec<String> = part.on.iter().map(|on| (on + 1).to_string()).collect();
        write!(out, "{},{:.9},{:.9},{:.9},{base},{}", k + 1, d.x, d.y, d.z, on.join(" "))?;
        let (volume, unsupported) = (part.solid.volume(), divided.audit.unsupported_mm2[k]);
        write!(out, ",{volume:.6},{:.6},{:.6},{unsupported:.6}", part.risky_mm2, part.seam_mm2)?;
        match &made.printed {
            Some(printed) => {
                let layers = &printed.layers[k + divided.before_parts()];
                write!(out, ",{},{:.6}", layers.layers.len(), layers.height_mm)?;
            }
            None => write!(out, ",,")?,
        }
        write!(out, ",{}", (k + divided.before_parts()) as u32 % made.filaments + 1)?;
        match made.load_angle(k) {
            Some(angle) => write!(out, ",{:.4}", angle.to_degrees())?,
            None => write!(out, ",")?,
        }
        match divided.hold(k) {
            Some(hold) => write!(out, ",{:.4},{:.6},{:.6}", hold.carried_mm3, hold.stress_mpa, hold.allowed_mpa)?,
            None => write!(out, ",,,")?,
        }
        writeln!(out, ",{}", divided.left(k).map_or_else(String::new, reason))?;
    }
    Ok(())
}

fn write_left_out(made: &Made, printed: &Printed, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "part,layer,curve,from_mm,to_mm,x_mm,y_mm,z_mm,depth_mm,nozzle,obstacle")?;
    for piece in &printed.plan.resolved.left_out {
        let (part, tip) = (made.part_of(printed, piece.layer), piece.tip);
        write!(out, "{part},{},{},{:.4},{:.4}", piece.layer + 1, piece.curve, piece.arcs[0], piece.arcs[1])?;
        write!(out, ",{:.4},{:.4},{:.4},{:.4}", tip.x, tip.y, tip.z, piece.depth)?;
        writeln!(out, ",{},{}", piece.part, piece.obstacle)?;
    }
    Ok(())
}

fn write_faults(made: &Made, printed: &Printed, moved: &Moved, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "part,layer,path,waypoint,kind,what")?;
    for fault in &moved.faults {
        let part = made.part_of(printed, fault.layer);
        let what = fault.what.replace(',', ";");
        writeln!(out, "{part},{},{},{},{},{what}", fault.layer + 1, fault.path, fault.waypoint, fault.kind.name())?;
    }
    Ok(())
}

/// A line for each part.
pub fn parts_table(made: &Made) -> Table {
    let mut table =
        Table::new(["part", "direction", "on", "volume mm3", "risky mm2", "seam mm2", "stress MPa", "layers"]);
    for (k, part) in made.divided.parts.parts.iter().enumerate() {
        let on: Vec<String> = part.on.iter().map(|on| (on + 1).to_string()).collect();
        table.row([
            (k + 1).to_string(),
            direction(&part.direction),
            if part.base.is_none() { "platform".to_owned() } else { on.join(" ") },
            format!("{:.0}", part.solid.volume()),
            format!("{:.1}", part.risky_mm2),
            format!("{:.1}", part.seam_mm2),
            made.divided.hold(k).map_or_else(String::new, |hold| format!("{:.2}", hold.stress_mpa)),
            made.printed.as_ref().map_or_else(String::new, |printed| {
                printed.layers[k + made.divided.before_parts()].layers.len().to_string()
            }),
        ]);
    }
    table
}

/// Minutes of the whole print, changes of filament included.
fn minutes(args: &Args, moved: &Moved) -> f64 {
    (moved.robot_s + moved.changes as f64 * args.change_s) / 60.0
}

/// This run beside Table 2.1 of the dissertation.
pub fn comparison(args: &Args, made: &Made) -> Table {
    let divided = &made.divided;
    let mut table = Table::new(["", "this run", "bunny (paper)", "armadillo (paper)", "hanging-ball (paper)"]);
    let mut row = |name: &str, ours: String, paper: [&str; 3]| {
        let [a, b, c] = paper.map(str::to_owned);
        table.row([name.to_owned(), ours, a, b, c]);
    };
    let facets = divided.solid.triangles().len();
    row("facets", facets.to_string(), ["10000", "17142", "5984"]);
    let seconds = divided.decompose_time.as_secs_f64();
    row("decomposition s", format!("{seconds:.1}"), ["171", "269", "156"]);
    row("parts", divided.parts.parts.len().to_string(), [""; 3]);
    row("risky area left", percent(divided.risky_share()), [""; 3]);
    // It says nothing of support: the risky area does.
    row("parts add up to the solid", if divided.audit.is_ok { "yes" } else { "NO" }.to_owned(), [""; 3]);
    if let Some(printed) = &made.printed {
        row("layers", printed.layer_count().to_string(), [""; 3]);
        row("tool paths mm", format!("{:.0}", printed.path_mm()), [""; 3]);
        let extruding = printed.plan.deposition.total_s / 60.0;
        row("planned by the feed min", format!("{extruding:.1}"), [""; 3]);
        if let Some(moved) = &printed.moved {
            row("fabrication min", format!("{:.1}", minutes(args, moved)), ["152", "263", "85"]);
            row("transfers", moved.transfers.to_string(), [""; 3]);
            row("transfers from part to part", moved.between_parts.to_string(), [""; 3]);
            row("unreachable waypoints", moved.count(FaultKind::Unreachable).to_string(), [""; 3]);
        }
    }
    table
}

fn summary(args: &Args, made: &Made, findings: &Findings, start: Instant) -> Result<Summary, Failure> {
    let mut summary = Summary::new();
    of_options(args, &made.divided, &mut summary)?;
    of_parts(args, &made.divided, &mut summary)?;
    of_audit(args, &made.divided, &mut summary)?;
    if let Some(angle) = made.least_load_angle() {
        summary.set("load_angle_deg", angle.to_degrees())?;
    }
    if let Some(printed) = &made.printed {
        of_print(args, printed, &mut summary)?;
    }
    findings.summary(&mut summary)?;
    summary.set_seconds("total_s", start.elapsed())?;
    Ok(summary)
}

/// What was asked for.
fn of_options(args: &Args, divided: &Divided, summary: &mut Summary) -> Result<(), Failure> {
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("mesh", divided.name.as_str())?
        .set("stage", typed_name(args.stage))?
        .set("base", typed_name(args.base))?
        .set("method", typed_name(args.method))?
        .set("avoid", typed_name(args.avoid))?
        .set("perturbations", args.perturbations)?
        .set("max_offset", args.max_offset_share)?
        .set("max_turn_deg", args.max_turn_deg)?
        .set("max_section", args.max_section)?
        .set("candidates", args.candidates)?
        .set("normals", args.normals)?
        .set("spacing_mm", args.spacing_mm)?
        .set("halvings", args.halvings)?
        .set("keep_sections_apart", args.keep_sections_apart)?
        .set("angle_deg", args.angle_deg)?
        .set("layer_height_mm", args.layer_height)?
        .set("bead_mm", args.bead_mm())?
        .set("pattern", typed_name(args.pattern))?
        .set("filaments", args.filaments)?
        .set("threads", args.common.threads)?;
    Ok(())
}

/// The parts, and how seams hold them.
fn of_parts(args: &Args, divided: &Divided, summary: &mut Summary) -> Result<(), Failure> {
    summary
        .set("facets", divided.solid.triangles().len())?
        .set("volume_mm3", divided.solid.volume())?
        .set("segments", divided.segmentation.parts)?
        .set("parts", divided.parts.parts.len())?
        .set_seconds("decomposition_s", divided.decompose_time)?
        .set("risky_before_mm2", divided.parts.risky_before_mm2)?
        .set("risky_after_mm2", divided.parts.risky_mm2())?
        .set("allow_risky", args.allow_risky)?
        .set("seam_mm2", divided.parts.seam_mm2())?
        .set("taken_method", method_name(divided.ways.tries[divided.ways.taken].method))?
        .set("tries", divided.ways.tries.len())?
        .set("pedestal_mm", divided.raised_mm())?
        .set("pedestal_mm3", divided.pedestal.as_ref().map_or(0.0, Pedestal::volume_mm3))?
        .set("density_g_cm3", args.density_g_cm3)?
        .set("print_force_n", args.print_force_n)?
        .set("bond_mpa", args.bond_mpa)?
        .set("plate_bond_mpa", args.plate_bond_mpa)?
        .set("safety", args.safety)?
        .set("any_seam", args.any_seam)?
        .set("weakest_seam_share", weakest(divided, false))?
        .set("foot_share", weakest(divided, true))?
        .set("weak_seams", divided.parts.holds.iter().filter(|hold| hold.share() > 1.0).count())?;
    Ok(())
}

/// What the audit of the parts says.
fn of_audit(args: &Args, divided: &Divided, summary: &mut Summary) -> Result<(), Failure> {
    summary
        .set("audit_ok", divided.audit.is_ok)?
        .set_seconds("audit_s", divided.audit_time)?
        .set("volume_error", divided.audit.volume_error)?
        .set("head_contacts", divided.audit.head_contacts.iter().sum::<usize>())?
        .set("crossing_sections", divided.crossing.len())?
        .set("misplaced_points", divided.audit.misplaced_points)?
        .set("allow_unsupported", args.allow_unsupported)?
        .set("unsupported_mm2", divided.unsupported_mm2())?
        .set("hanging_layers", divided.audit.hanging_layers.iter().sum::<usize>())?
        .set("worst_layer_share", divided.audit.worst_layer.map_or(0.0, |worst| worst.share))?;
    Ok(())
}

/// The print, and its motion where it was planned.
fn of_print(args: &Args, printed: &Printed, summary: &mut Summary) -> Result<(), Failure> {
    let resolved = &printed.plan.resolved;
    summary
        .set("layers", printed.layer_count())?
        .set("paths", resolved.paths.len())?
        .set("path_mm", printed.path_mm())?
        .set("covered_fraction", printed.filled.totals().covered_fraction)?
        .set("tilted_waypoints", resolved.tilted)?
        .set("left_out_mm", printed.left_out_mm())?
        .set("blocked_travels", printed.plan.travels.blocked.len())?
        .set("feed_min", printed.plan.deposition.total_s / 60.0)?;
    let Some(moved) = &printed.moved else { return Ok(()) };
    summary
        .set("cell", moved.cell.as_str())?
        .set("nozzle_x_mm", moved.nozzle_mm[0])?
        .set("nozzle_y_mm", moved.nozzle_mm[1])?
        .set("nozzle_z_mm", moved.nozzle_mm[2])?
        .set("runs", moved.runs)?
        .set("transfers", moved.transfers)?
        .set("part_transfers", moved.between_parts)?
        .set("missing_transfers", moved.missing)?
        .set("filament_changes", moved.changes)?
        .set("unreachable_waypoints", moved.count(FaultKind::Unreachable))?
        .set("blocked_waypoints", moved.count(FaultKind::Blocked))?
        .set("motion_faults", moved.faults.len())?
        .set("fabrication_min", minutes(args, moved))?
        .set("program_files", moved.files.len())?;
    Ok(())
}

/// The greatest stress as a share of what it may be, of seams with the plate or of others. 1e9 for a seam without area, which JSON has no
/// number for.
fn weakest(divided: &Divided, on_platform: bool) -> f64 {
    let of = divided.parts.holds.iter().filter(|hold| hold.on_platform == on_platform);
    of.map(|hold| hold.share().min(1e9)).fold(0.0, f64::max)
}

fn method_name(method: Method) -> &'static str {
    if method == Method::Beam { "beam" } else { "robofdm" }
}

/// The ways in which parts were sought.
fn tries(divided: &Divided) -> Table {
    let mut table = Table::new(["method", "pedestal mm", "parts", "risky area left", "audit", "taken"]);
    for (k, tried) in divided.ways.tries.iter().enumerate() {
        table.row([
            method_name(tried.method).to_owned(),
            format!("{:.1}", tried.pedestal_mm),
            tried.parts.to_string(),
            percent(tried.risky_mm2 / divided.parts.risky_before_mm2.max(f64::MIN_POSITIVE)),
            if tried.is_accepted { "passes" } else { "does not pass" }.to_owned(),
            if k == divided.ways.taken { "yes" } else { "" }.to_owned(),
        ]);
    }
    table
}

/// What is left, and why.
fn left(divided: &Divided) -> Table {
    let mut table = Table::new(["part", "risky mm2", "why it is left"]);
    for left in &divided.parts.left {
        table.row([(left.part + 1).to_string(), format!("{:.1}", left.risky_mm2), reason(left)]);
    }
    table
}

/// The parts as they are printed.
fn build(made: &Made, printed: &Printed) -> Model {
    let sheet =
        |layer: &FlatLayer| viewer::Mesh { vertices: layer.vertices.clone(), triangles: layer.triangles.clone() };
    let left_out = printed.plan.resolved.left_out.iter().map(|piece| Mark { at: piece.tip, path: None });
    let marks = Marks { what: "paths left out".to_owned(), colour: LEFT_OUT, places: left_out.collect() };
    let mesh = made.divided.standing();
    let moved = printed.moved.as_ref();
    Model {
        name: "RoboFDM".to_owned(),
        part: viewer::Mesh { vertices: mesh.vertices, triangles: mesh.triangles },
        layers: printed.layers.iter().flat_map(|part| part.layers.iter().map(sheet)).collect(),
        kinds: shown::kinds(),
        // What the robot does, where its motion is planned.
        steps: match moved {
            Some(moved) => moved.steps.clone(),
            None => shown::steps(&printed.plan.resolved.paths, &printed.plan.deposition.moves),
        },
        robot: moved.and_then(|moved| moved.robot.clone()),
        nozzle: moved.and_then(|moved| moved.nozzle),
        marks: vec![marks].into_iter().filter(|marks| !marks.places.is_empty()).collect(),
        ..Model::default()
    }
}

/// Pictures of the report.
struct Pictures<'a> {
    parts: &'a [u8],
    segments: &'a [(&'static str, &'static str, Vec<u8>)],
    steps: &'a [Vec<u8>],
}

fn report(args: &Args, made: &Made, findings: &Findings, pictures: &Pictures) -> Report {
    let Pictures { parts, segments, steps } = *pictures;
    let mut report = Report::new("RoboFDM");
    findings.report(&mut report);
    let stands = if args.base == Base::Best { "along the best direction of its root" } else { "as in its file" };
    report.paragraph(&format!(
        "The part stands {stands}. It is printed in parts, one after another, each in flat layers of {} mm along its arrow. Of the \
         sides that would lean out over nothing by more than {} degrees from upright, {} of the area is left.",
        args.layer_height,
        args.angle_deg,
        percent(made.divided.risky_share())
    ));
    report.table("Parts", &parts_table(made));
    report.table("How parts were sought", &tries(&made.divided));
    if !made.divided.parts.left.is_empty() {
        report.table("What is left, and why", &left(&made.divided));
    }
    report.table("This run, beside Table 2.1 of the dissertation", &comparison(args, made));
    made.printed.iter().for_each(|printed| _ = report.viewer(&build(made, printed)));
    report.picture("all parts, in the order of their colours", parts);
    let divided = &made.divided;
    report.heading("How the parts were found").paragraph(&format!(
        "The skeleton has {} branches; the distance of the surface from it, with {} {} of thickness, makes {} segments (Fig. 2.4 of the dissertation). `--root` takes the number of a \
         segment. The sequence of the segments (Fig. 2.5) is where the planes begin; they are tuned, and parts are cut further, until little risky area is left.",
        divided.segmentation.skeleton.branch_count(),
        divided.segmentation.mixture.means.len(),
        if divided.segmentation.mixture.means.len() == 1 { "level" } else { "levels" },
        divided.segmentation.parts
    ));
    let shown: Vec<(&str, &[u8])> = segments.iter().map(|(_, caption, png)| (*caption, png.as_slice())).collect();
    report.pictures(&shown).drawing(
        "the sequence of the segments: each is printed on the one above it, along its base plane's normal; with its risky area",
        &drawing::graph(divided),
    );
    let all = made.divided.parts.parts.len();
    let captions: Vec<String> = (1..=steps.len()).map(|step| format!("part {step} of {all}")).collect();
    for (captions, steps) in captions.chunks(3).zip(steps.chunks(3)) {
        let pictures: Vec<(&str, &[u8])> =
            captions.iter().zip(steps).map(|(caption, png)| (caption.as_str(), png.as_slice())).collect();
        report.pictures(&pictures);
    }
    report
}
