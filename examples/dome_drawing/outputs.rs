//! What the example leaves behind: the table on stdout, `summary.json`, `strokes.csv`, the program, pictures, and `report.html`.

use super::plan::Planned;
use super::robot::{EVEN, NAME, Printed, on_platform};
use super::saved::{Plan, PlanKind};
use super::{Args, input, pictures};
use curvlay_examples::args::{Failure, Outcome, typed_name};
use curvlay_examples::count::counted;
use curvlay_examples::findings::{Findings, Severity, percent};
use curvlay_examples::output::{OutputError, OutputFolder};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;
use curvlay_examples::viewer::{Mesh, Model, Step};
use curvlay_toolpath::drawing::{save_drawing, write_dxf, write_paths_dxf};

/// Share of the design that beads may leave open, and share that they may cover twice, without a finding; what the filled design of the
/// thesis should reach.
const COVERED: f64 = 0.97;
const OVERLAP: f64 = 0.04;

/// Whether a file is of an earlier run.
pub fn is_ours(name: &str) -> bool {
    let part = || {
        let number = name.strip_prefix(NAME)?.strip_prefix('_')?.strip_suffix(".mod")?;
        (!number.is_empty() && number.chars().all(|c| c.is_ascii_digit())).then_some(())
    };
    ["plan.json", "strokes.csv", "strokes.dxf", "report.html", "design.drawing", "design.dxf", "setup.json"]
        .contains(&name)
        || ["", "_link", "_move"].iter().any(|part| name == format!("{NAME}{part}.mod"))
        || part().is_some()
        || pictures::NAMES.iter().any(|picture| name == format!("{picture}.png"))
}

/// The program, and what it is written from.
fn write_program(args: &Args, plan: &Plan, printed: &Printed, folder: &OutputFolder) -> Result<(), Failure> {
    for (name, bytes) in &printed.program.files {
        folder.write(name, bytes)?;
    }
    folder.write("setup.json", args.setup.to_json())?;
    folder.write_with("plan.json", |out| plan.write(out))?;
    folder.write_with("strokes.csv", |out| plan.write_csv(out))?;
    folder.write_with("strokes.dxf", |mut out| write_paths_dxf(&mut out, &plan.in_space()))?;
    Ok(())
}

/// What a run with `--plan` leaves behind.
pub fn write_again(args: &Args, plan: &Plan, printed: &Printed, folder: &OutputFolder) -> Result<Outcome, Failure> {
    let mut findings = Findings::default();
    program_findings(args, printed, &mut findings);
    findings.say();
    write_program(args, plan, printed, folder)?;
    let mut report = Report::new("A drawing on a dome");
    findings.report(&mut report);
    report.paragraph(&format!("A plan that an earlier run saved, printed on {}", program_words(args, printed)));
    report.table("This run, beside the thesis", &table_again(args, plan, printed));
    report.viewer(&build(args, plan, printed));
    folder.write("report.html", report.to_html())?;
    let mut summary = Summary::new();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("design", plan.name.as_str())?
        .set("setup", args.setup.name())?
        .set("threads", args.common.threads)?;
    program_summary(args, plan, printed, &mut summary)?;
    findings.summary(&mut summary)?;
    summary.set_seconds("seconds", printed.seconds)?;
    summary.write(folder).map_err(|error: OutputError| Failure::from(error))?;
    Ok(findings.outcome())
}

/// The table of a run with `--plan`.
pub fn table_again(args: &Args, plan: &Plan, printed: &Printed) -> Table {
    let mut table = Table::new(["", "this run", "thesis"]);
    program_rows(args, plan, printed, &mut table);
    table
}

pub fn write(
    args: &Args,
    planned: &Planned,
    plan: &Plan,
    printed: &Printed,
    folder: &OutputFolder,
) -> Result<Outcome, Failure> {
    let mut findings = findings(args, planned, printed);
    findings.say();
    write_program(args, plan, printed, folder)?;
    folder.write_with("design.drawing", |mut out| save_drawing(&mut out, &planned.drawing))?;
    folder.write_with("design.dxf", |mut out| write_dxf(&mut out, &planned.drawing))?;
    let drawn = pictures::draw(planned);
    for (name, png) in pictures::NAMES.iter().zip(&drawn) {
        folder.write(&format!("{name}.png"), png)?;
    }
    folder.write("report.html", report(args, planned, plan, printed, &findings, &drawn).to_html())?;
    // The summary comes last: where it is, all is there.
    summary(args, planned, plan, printed, &findings)?
        .write(folder)
        .map_err(|error: OutputError| Failure::from(error))?;
    Ok(findings.outcome())
}

fn findings(args: &Args, planned: &Planned, printed: &Printed) -> Findings {
    let mut findings = Findings::default();
    let drawing = &planned.drawing;
    if !drawing.skipped.is_empty() {
        findings.add(Severity::Warning, "entities are not drawn", input::skipped(drawing), "");
    }
    let of_file = args.dxf.is_some() || args.svg.is_some();
    let [width, height] = planned.size_mm;
    for note in &drawing.notes {
        let options = if args.svg.is_some() && note.contains("pixels") { "--dpi, --unit" } else { "" };
        findings.add(Severity::Warning, note.as_str(), "", options);
    }
    if drawing.unit_mm.is_none() && of_file && drawing.notes.is_empty() {
        let amount = format!("the design is {width:.1} by {height:.1} mm");
        findings.add(Severity::Warning, "the file names no unit; millimetres are taken", amount, "--unit");
    }
    if let Some(widest) = planned.gaps.iter().max_by(|a, b| a.width.total_cmp(&b.width)) {
        let count = planned.gaps.len();
        let amount = format!(
            "{count}, the widest of {:.3} mm at {:.2}, {:.2} in the file",
            widest.width, widest.at.x, widest.at.y
        );
        let join = (widest.width * 1050.0).ceil() / 1000.0;
        findings.add(Severity::Warning, "gaps keep contours open", amount, format!("--join {join}"));
    }
    if planned.duplicates + planned.zero_length > 0 {
        let amount = format!("{}, {} of no length", counted(planned.duplicates, "duplicate"), planned.zero_length);
        findings.add(Severity::Warning, "pieces are removed", amount, "");
    }
    let overlaps = &planned.overlaps;
    if overlaps.dropped > 0 {
        let amount = format!("{}, {:.1} mm2", overlaps.dropped, overlaps.dropped_mm2);
        findings.add(Severity::Warning, "pieces are too small", amount, "--min-area");
    }
    if planned.filled.too_narrow > 0 {
        let amount = format!("{}, {:.1} mm2", planned.filled.too_narrow, planned.filled.too_narrow_mm2);
        findings.add(Severity::Warning, "regions are too narrow for a bead", amount, "--bead");
    }
    program_findings(args, printed, &mut findings);
    let fills = !matches!(args.fill, super::FillKind::None) && !planned.overlaps.regions.is_empty();
    if fills && planned.coverage.covered < COVERED {
        let amount = format!("{} of the area", percent(1.0 - planned.coverage.covered));
        findings.add(Severity::Warning, "the beads leave gaps", amount, "--bead");
    }
    if fills && planned.coverage.overlap > OVERLAP {
        let amount = format!("{} of the area", percent(planned.coverage.overlap));
        findings.add(Severity::Warning, "beads lie on each other", amount, "--bead");
    }
    findings
}

/// What is wrong with the program.
fn program_findings(args: &Args, printed: &Printed, findings: &mut Findings) {
    let print = &printed.program.print;
    for fault in print.faults.iter().take(5) {
        findings.add(Severity::Failed, "a stroke is not printed", fault.to_string(), "");
    }
    if print.faults.len() > 5 {
        findings.add(Severity::Failed, "more strokes are not printed", (print.faults.len() - 5).to_string(), "");
    }
    for (pair, count) in &printed.touching {
        let amount = format!("{count} of the {} looked at", counted(printed.checked, "waypoint"));
        findings.add(Severity::Failed, format!("{pair} touch"), amount, "");
    }
    if printed.blocked_travels > 0 {
        let amount = printed.blocked_travels.to_string();
        findings.add(Severity::Failed, "ways between strokes are not free", amount, "");
    }
    if !printed.read_back() {
        let amount = format!("{:.1e} mm at {}", printed.round_trip_mm, counted(printed.targets_read, "target"));
        findings.add(Severity::Failed, "the program read back is not the plan", amount, "");
    }
    let run = &printed.run;
    let [slowest, fastest] = run.speed_mm_s;
    let wanted = args.setup.print_mm_s();
    if !printed.is_even(wanted) {
        let amount = format!("{slowest:.2} to {fastest:.2} mm/s, not {wanted} within {}", percent(EVEN));
        findings.add(Severity::Failed, "the nozzle does not go evenly", amount, "--step");
    }
    if run.lost + printed.off_course > 0 {
        let amount = format!("{}, {}", counted(run.lost, "move"), counted(printed.off_course, "stroke"));
        findings.add(Severity::Failed, "straight moves of the program lead to other joints than planned", amount, "");
    }
    if run.joint_speed > 1.0 {
        let amount = format!("{} of its limit", percent(run.joint_speed));
        findings.add(Severity::Warning, "the robot slows down where a joint is at its limit of speed", amount, "");
    }
}

/// How often the nozzle stops, also in the middle of a stroke.
fn stops(args: &Args, planned: &Planned, printed: &Printed) -> usize {
    planned.filled.stops() * args.layers as usize + printed.program.print.splits
}

fn widths(planned: &Planned) -> [f64; 2] {
    let widths = planned.filled.strokes.iter().map(|stroke| stroke.width);
    let [least, most] = widths.fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], w| [a.min(w), b.max(w)]);
    [least.min(most), most]
}

pub fn table(args: &Args, planned: &Planned, plan: &Plan, printed: &Printed) -> Table {
    let coverage = &planned.coverage;
    let [least, most] = widths(planned);
    let mut table = Table::new(["", "this run", "thesis"]);
    let mut row = |name: &str, ours: String, thesis: &str| _ = table.row([name.to_owned(), ours, thesis.to_owned()]);
    row("entities", planned.pieces.len().to_string(), "");
    row("not drawn", planned.drawing.skipped_count().to_string(), "");
    row("closed contours", planned.closed().to_string(), "");
    row("open contours", (planned.contours.len() - planned.closed()).to_string(), "");
    row("area of the contours mm2", format!("{:.1}", planned.area_sum_mm2), "");
    row("without overlaps mm2", format!("{:.1}", planned.area_union_mm2), "");
    row("bead mm", format!("{least:.2} to {most:.2}"), "3.2 to 6.4");
    row("stops", stops(args, planned, printed).to_string(), "");
    row("stops with scan lines", (planned.stops_scan_lines * args.layers as usize).to_string(), "");
    row("covered", percent(coverage.covered), "");
    row("covered twice", percent(coverage.overlap), "");
    row("outside of the design", percent(coverage.outside), "");
    row("largest distortion", percent(planned.distortion.largest), "");
    program_rows(args, plan, printed, &mut table);
    table
}

/// Rows of the program.
fn program_rows(args: &Args, plan: &Plan, printed: &Printed, table: &mut Table) {
    let print = &printed.program.print;
    let points = plan.points();
    let mut row = |name: &str, ours: String, thesis: &str| _ = table.row([name.to_owned(), ours, thesis.to_owned()]);
    row("contour points", points[0].to_string(), "66661");
    row("fill points", points[1].to_string(), "27758");
    row("axis 6 degrees", format!("{:.1}", printed.axis6_span_deg()), "");
    row("returns home", printed.returns_home.to_string(), "one a contour");
    row("strokes not printed", print.faults.len().to_string(), "");
    let minutes = |seconds: f64| format!("{:.1}", seconds / 60.0);
    row("minutes, with plunges and hops", minutes(printed.run.seconds), "");
    row("of these printing", minutes(printed.run.printing_s), "");
    row("nozzle mm/s", printed.run.speed_mm_s.map(|speed| format!("{speed:.2}")).join(" to "), "20");
    row("turns of the extruder", format!("{:.1}", printed.extruder_turns()), "");
    row("beads mm3", format!("{:.0}", printed.material_mm3(args)), "");
    row("moves", printed.program.written.moves.to_string(), "");
    row("modules", (printed.program.written.modules + 1).to_string(), "1, too large to load");
    row("read back within mm", format!("{:.1e}", printed.round_trip_mm), "");
    row("file to program s", format!("{:.3}", printed.seconds.as_secs_f64()), "");
}

fn summary(
    args: &Args,
    planned: &Planned,
    plan: &Plan,
    printed: &Printed,
    findings: &Findings,
) -> Result<Summary, Failure> {
    let [least, most] = widths(planned);
    let layers: Vec<String> =
        planned.drawing.layers().into_iter().map(|(name, count)| format!("{name} {count}")).collect();
    let skipped: Vec<String> =
        planned.drawing.skipped.iter().map(|skipped| format!("{} {}", skipped.what, skipped.count)).collect();
    let surface = std::path::Path::new(&args.surface).file_name().map(|name| name.to_string_lossy().into_owned());
    let mut summary = Summary::new();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("design", planned.name.as_str())?
        .set("drawing_layers", layers.join(", "))?
        .set("bead_mm", args.bead_mm)?
        .set("fill", typed_name(args.fill))?
        .set("angle_deg", args.angle_deg)?
        .set("surface", surface.unwrap_or_default())?
        .set("projection", typed_name(args.projection))?
        .set("step_mm", args.step_mm)?
        .set("layers", args.layers)?
        .set("setup", args.setup.name())?
        .set("scale", planned.scale)?
        .set("threads", args.common.threads)?
        .set("entities", planned.pieces.len())?
        .set("skipped_entities", planned.drawing.skipped_count())?
        .set("skipped", skipped.join(", "))?
        .set("unit_mm", planned.drawing.unit_mm.unwrap_or(0.0))?
        .set("gaps", planned.gaps.len())?
        .set("duplicates", planned.duplicates)?
        .set("zero_length", planned.zero_length)?
        .set("closed", planned.closed())?
        .set("open", planned.contours.len() - planned.closed())?
        .set("regions", planned.overlaps.regions.len())?
        .set("area_sum_mm2", planned.area_sum_mm2)?
        .set("area_union_mm2", planned.area_union_mm2)?
        .set("stops", stops(args, planned, printed))?
        .set("stops_scan_lines", planned.stops_scan_lines * args.layers as usize)?
        .set("on_printed", planned.on_printed)?
        .set("thinned_mm", planned.thinned_mm)?
        .set("min_width_mm", least)?
        .set("max_width_mm", most)?
        .set("covered_fraction", planned.coverage.covered)?
        .set("overlap_fraction", planned.coverage.overlap)?
        .set("outside_fraction", planned.coverage.outside)?
        .set("mean_distortion", planned.distortion.mean)?
        .set("largest_distortion", planned.distortion.largest)?;
    program_summary(args, plan, printed, &mut summary)?;
    findings.summary(&mut summary)?;
    summary.set_seconds("seconds", printed.seconds)?;
    Ok(summary)
}

/// Keys of the program.
fn program_summary(args: &Args, plan: &Plan, printed: &Printed, summary: &mut Summary) -> Result<(), Failure> {
    let print = &printed.program.print;
    let points = plan.points();
    summary
        .set("contour_points", points[0])?
        .set("fill_points", points[1])?
        .set("splits", print.splits)?
        .set("axis6_min_deg", print.axis6[0].to_degrees())?
        .set("axis6_max_deg", print.axis6[1].to_degrees())?
        .set("axis6_span_deg", printed.axis6_span_deg())?
        .set("returns_home", printed.returns_home)?
        .set("unreachable", print.faults.len())?
        .set("touching", printed.touching.values().sum::<usize>())?
        .set("blocked_travels", printed.blocked_travels)?
        .set("program_min", printed.run.seconds / 60.0)?
        .set("printing_min", printed.run.printing_s / 60.0)?
        .set("printed_mm", printed.run.printed_mm)?
        .set("min_nozzle_mm_s", printed.run.speed_mm_s[0])?
        .set("max_nozzle_mm_s", printed.run.speed_mm_s[1])?
        .set("extruder_turns", printed.extruder_turns())?
        .set("material_mm3", printed.material_mm3(args))?
        .set("conf_changes", printed.run.conf_changes)?
        .set("joint_speed_fraction", printed.run.joint_speed)?
        .set("inserted_points", print.inserted)?
        .set("merged_points", print.merged)?
        .set("moves", printed.program.written.moves)?
        .set("modules", printed.program.written.modules + 1)?
        .set("round_trip_mm", printed.round_trip_mm)?;
    Ok(())
}

/// The design as the program prints it on the dome, with the times of the program.
fn build(args: &Args, plan: &Plan, printed: &Printed) -> Model {
    let mut steps = Vec::new();
    for (path, (printed, run)) in (0..).zip(printed.program.print.strokes.iter().zip(&printed.run.strokes)) {
        let stroke = &plan.strokes[printed.stroke];
        let kind = match stroke.kind {
            PlanKind::Outline => 0,
            PlanKind::Fill => 1,
            PlanKind::Open => 2,
        };
        let length = printed.lengths.last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
        for (k, pose) in printed.poses.iter().enumerate() {
            let (tip, direction) = on_platform(&args.setup.rig(), pose);
            let (kind, seconds) = match k {
                0 => (Step::TRAVEL, run.before_s),
                _ => (kind, run.printing_s * (printed.lengths[k] - printed.lengths[k - 1]) / length),
            };
            steps.push(Step {
                tip,
                direction: *direction,
                width: stroke.width_mm,
                height: args.layer_height_mm,
                kind,
                layer: stroke.layer - 1,
                path,
                seconds,
            });
        }
    }
    // Away from the last one.
    if let Some(last) = steps.last().copied() {
        let seconds = printed.run.seconds - steps.iter().map(|step| step.seconds).sum::<f64>();
        steps.push(Step { kind: Step::TRAVEL, seconds, ..last });
    }
    Model {
        name: "a drawing on a dome".to_owned(),
        kinds: ["outline", "fill", "open contour"].map(str::to_owned).to_vec(),
        steps,
        ..Model::default()
    }
}

/// The program in words.
fn program_words(args: &Args, printed: &Printed) -> String {
    let (print, run) = (&printed.program.print, &printed.run);
    format!(
        "a platform that an {} holds under a fixed nozzle. The program has {} strokes in {} poses; {} strokes are not printed. It takes {:.0} \
         minutes at the speeds of its moves, {:.0} of them with the extruder on, without accelerations and the loading of modules.",
        args.setup.arm_name(),
        print.strokes.len(),
        print.points(),
        print.faults.len(),
        run.seconds / 60.0,
        run.printing_s / 60.0
    )
}

fn report(
    args: &Args,
    planned: &Planned,
    plan: &Plan,
    printed: &Printed,
    findings: &Findings,
    drawn: &[Vec<u8>],
) -> Report {
    let mut report = Report::new("A drawing on a dome");
    findings.report(&mut report);
    report.paragraph(&format!(
        "The entities of the design are joined to contours; what an earlier contour fills is removed from later ones; what is left is \
         drawn in beads, and projected onto {}",
        program_words(args, printed)
    ));
    report.table("This run, beside the thesis", &table(args, planned, plan, printed));
    let mut layers = Table::new(["layer", "entities"]);
    for (name, count) in planned.drawing.layers() {
        layers.row([name, count.to_string()]);
    }
    report.table("Layers of the file", &layers);
    let (vertices, triangles) = pictures::mesh_of(planned);
    report.viewer(&Model { layers: vec![Mesh { vertices, triangles }], ..build(args, plan, printed) });
    let captions = [
        "the entities of the file, a colour each",
        "joined contours: closed ones dark, open ones orange",
        "after overlaps are removed, a colour for each region",
        "the beads, as wide as they are laid; open contours orange, begins of strokes dark",
        "on the surface",
        "distortion: dark where lengths are kept, bright where they change most",
    ];
    for pair in captions.iter().zip(drawn).collect::<Vec<_>>().chunks(2) {
        let pictures: Vec<(&str, &[u8])> = pair.iter().map(|(caption, png)| (**caption, png.as_slice())).collect();
        report.pictures(&pictures);
    }
    report
}
