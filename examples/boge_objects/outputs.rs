//! What the example leaves behind: the tables on stdout, `summary.json` and `report.html`.

use super::drawing::worked_example;
use super::growing::{Case, Results, Run, STRATEGIES, UNBUILT, figure};
use super::hardware::Hardware;
use super::objects::PLATFORMS;
use super::rating::Rating;
use super::thesis::{HARDWARE, LAYERS, METHODS, MISSED, RATINGS, UNIFORM};
use curvlay_examples::args::Failure;
use curvlay_examples::count::counted;
use curvlay_examples::output::OutputFolder;
use curvlay_examples::render::{LayeredCells, Plane, draw_cut};
use curvlay_examples::report::Report;
use curvlay_examples::summary::{Summary, SummaryError};
use curvlay_examples::table::Table;
use curvlay_layers::cells::LayerOrder;
use curvlay_voxel::TextGrid;
use std::io::{self, Write};
use std::time::Duration;

/// The cells of the best order with their layers.
pub const LAYERS_FILE: &str = "layers.csv";

/// Pixels of each picture: squares of 20 pixels for the 35 cells of the large platform.
const PICTURE: [u32; 2] = [728, 320];

const BOTH: &str = "Tables 5.1 and 5.2: missed cells and layers, by the rules of the thesis, ours and Boge's";
const TUNED: &str = "Section 6.2.5: GCFA-ISP as in the thesis, and with a voxel accumulation threshold";
const SLICED: &str = "Table 6.6: missed cells of uniform slicing, ours and Boge's";
const RATED: &str = "Table 6.4: how good each field is, ours and Boge's, and the same of our default rules";
pub const BOUNDS: &str = "Good: nothing missed, and at most 1.5 layers for each level of cells; ok: at most 5.5 % missed, and as few layers; the \
     rest is poor. The thesis gives no bounds; these are ours, chosen after its table.";
const SETS: &str = "Table 6.7: properties of hardware by Boge, and what the platform of each means for the six objects";
const SETS_NOTE: &str = "Her marks as printed; by her sections 6.4.2 and 6.4.3 the small platform goes with the elevated one and not with \
     the floor, and so do our counts. On the floor the platform reaches 100 cells beyond the drawn one on each side.";
const DEFAULT: &str = "The same objects by our default rules (eps 1 cell): missed cells / layers";

pub fn write(results: &Results, folder: &OutputFolder, threads: usize, time: Duration) -> Result<(), Failure> {
    folder.write_with(LAYERS_FILE, |out| write_layers(results, out))?;
    folder.write("report.html", report(results)?.to_html())?;
    // The summary comes last: where it is, all is there.
    summary(results, threads, time)?.write(folder)?;
    Ok(())
}

/// A line for each cell of each object on each platform: its layers by the methods of the thesis, 0 for a missed cell.
fn write_layers(results: &Results, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "object,platform,x,y,z,gcfa,gcfa_isp,gcfa_isp_tuned")?;
    for case in &results.cases {
        let grid = &case.drawn.grid;
        let size = grid.dims().iter().map(|&side| side as usize).product();
        let fields =
            [&case.ways.theirs[0], &case.ways.theirs[1], &case.tuned.run].map(|run| run.growth.order.field(size));
        let [object, platform] = place(case);
        for cell in grid.iter() {
            let [x, y, z] = grid.position(cell);
            let [gcfa, isp, tuned] = fields.each_ref().map(|field| field[cell as usize]);
            writeln!(out, "{object},{platform},{x},{y},{z},{gcfa},{isp},{tuned}")?;
        }
    }
    Ok(())
}

/// Prints the tables; a reader that has gone away (`| head`) is not an error.
pub fn print(results: &Results) -> Result<(), Failure> {
    let text = format!(
        "{BOTH}\n{}\n{TUNED}\n{}\n{RATED}\n{}{BOUNDS}\n\n{SLICED}\n{}\n{SETS}\n{}{SETS_NOTE}\n\n{DEFAULT}\n{}\n{}",
        thesis_table(results),
        tuned_table(results),
        rating_table(results),
        uniform_table(results),
        hardware_table(results),
        default_table(results),
        verdict(results)
    );
    match io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// Object and platform.
fn place(case: &Case) -> [String; 2] {
    [(case.object + 1).to_string(), PLATFORMS[case.platform].to_owned()]
}

/// A line for each object on each platform; for each method ours and hers.
fn thesis_table(results: &Results) -> Table {
    let methods = METHODS
        .iter()
        .flat_map(|method| [format!("{method} missed"), "Boge".to_owned(), "layers".to_owned(), "Boge".to_owned()]);
    let heads = ["object".to_owned(), "platform".to_owned()].into_iter().chain(methods);
    let mut table = Table::new(heads.chain([UNBUILT.to_owned(), "layers".to_owned()]));
    for case in &results.cases {
        let figures = case.ways.theirs.iter().enumerate().flat_map(|(method, run)| {
            let in_table = |table: [[[usize; 2]; 3]; 6]| table[case.object][case.platform][method];
            [run.growth.missed.len(), in_table(MISSED), run.growth.order.len(), in_table(LAYERS)]
        });
        let unbuilt = [case.ways.unbuilt.growth.missed.len(), case.ways.unbuilt.growth.order.len()];
        table.row(place(case).into_iter().chain(figures.chain(unbuilt).map(|figure| figure.to_string())));
    }
    table
}

/// A line for each object on each platform: what the threshold of section 6.2.5 gains.
fn tuned_table(results: &Results) -> Table {
    let mut table = Table::new(["object", "platform", "GCFA-ISP missed", "layers", "threshold", "missed", "layers"]);
    for case in &results.cases {
        let (isp, tuned) = (&case.ways.theirs[1].growth, &case.tuned.run.growth);
        let figures =
            [isp.missed.len(), isp.order.len(), case.tuned.threshold as usize, tuned.missed.len(), tuned.order.len()];
        table.row(place(case).into_iter().chain(figures.map(|figure| figure.to_string())));
    }
    table
}

/// A line for each object on each platform: ratings by the rules of the thesis beside hers, and of our strategies.
fn rating_table(results: &Results) -> Table {
    let heads = ["object", "platform", METHODS[0], "Boge", METHODS[1], "Boge"];
    let mut table = Table::new(heads.into_iter().chain(STRATEGIES));
    for case in &results.cases {
        let hers = RATINGS[case.object][case.platform];
        let both = case.ways.theirs.iter().zip(hers).flat_map(|(run, hers)| [Rating::of(run, &case.drawn), hers]);
        let ours = case.ways.ours.iter().map(|run| Rating::of(run, &case.drawn));
        table.row(place(case).into_iter().chain(both.chain(ours).map(|rating| rating.to_string())));
    }
    table
}

/// A column for each set of hardware: her marks, and missed cells of all objects together.
fn hardware_table(results: &Results) -> Table {
    let mut table = Table::new([""].into_iter().chain(Hardware::ALL.iter().map(|set| set.name())));
    for (property, has) in HARDWARE {
        table.row([property].into_iter().chain(has.map(|has| if has { "yes" } else { "no" })));
    }
    let missed = Hardware::ALL.map(|set| missed_on(results, set));
    let methods = results.hardware.first().into_iter().flat_map(|on| on.ways.runs());
    for (at, (method, _)) in methods.enumerate() {
        let of_sets = missed.each_ref().map(|of_set| of_set[at].to_string());
        table.row([format!("missed cells, {method}")].into_iter().chain(of_sets));
    }
    table
}

/// Missed cells of all objects together, method by method.
fn missed_on(results: &Results, set: Hardware) -> Vec<usize> {
    let mut sums = Vec::new();
    for on in results.hardware.iter().filter(|on| on.hardware == set) {
        let missed: Vec<usize> = on.ways.runs().map(|(_, run)| run.growth.missed.len()).collect();
        sums.resize(missed.len(), 0);
        sums.iter_mut().zip(missed).for_each(|(sum, missed)| *sum += missed);
    }
    sums
}

fn uniform_table(results: &Results) -> Table {
    let mut table = Table::new(["object", "cells", "missed", "Boge"]);
    let on_small = results.cases.iter().filter(|case| case.platform == 0);
    for (case, missed) in on_small.zip(&results.uniform) {
        let thesis = UNIFORM[case.object].map_or_else(|| "-".to_owned(), |missed| missed.to_string());
        table.row([place(case)[0].clone(), case.drawn.grid.count().to_string(), missed.to_string(), thesis]);
    }
    table
}

fn default_table(results: &Results) -> Table {
    let heads = ["object", "platform"].into_iter().chain(STRATEGIES).chain(["audits"]);
    let mut table = Table::new(heads);
    for case in &results.cases {
        let figures =
            case.ways.ours.iter().map(|run| format!("{} / {}", run.growth.missed.len(), run.growth.order.len()));
        let passed = case.ways.ours.iter().filter(|run| run.audit.is_ok()).count();
        let audits = if passed == STRATEGIES.len() { "passed" } else { "FAILED" };
        table.row(place(case).into_iter().chain(figures).chain([audits.to_owned()]));
    }
    table
}

/// How many checks passed, and which did not.
fn verdict(results: &Results) -> Table {
    let (entries, audits) = (results.entries.len(), results.audited().count());
    let failed = results.failed_audits();
    let (ratings, other) = (ratings(results), results.other_ratings());
    let mut table = Table::new(["", ""]);
    table
        .row(["figures that agree".to_owned(), format!("{} of {entries}", entries - results.disagreeing().count())])
        .row(["verdicts that agree".to_owned(), format!("{} of {ratings}", ratings - other.len())])
        .row(["audits passed".to_owned(), format!("{} of {audits}", audits - failed.len())]);
    for entry in results.disagreeing() {
        table.row(["DIFFERS".to_owned(), entry.to_string()]);
    }
    other.into_iter().for_each(|line| _ = table.row(["DIFFERS".to_owned(), line]));
    failed.into_iter().for_each(|line| _ = table.row(["AUDIT FAILED".to_owned(), line]));
    table
}

/// Verdicts of Table 6.4.
fn ratings(results: &Results) -> usize {
    results.cases.iter().map(|case| case.ways.theirs.len()).sum()
}

fn summary(results: &Results, threads: usize, time: Duration) -> Result<Summary, SummaryError> {
    let disagreeing: Vec<&str> = results.disagreeing().map(|entry| entry.key.as_str()).collect();
    let failed = results.failed_audits();
    let audits = results.audited().count();
    let mut summary = Summary::new();
    summary
        .set("version", env!("CARGO_PKG_VERSION"))?
        .set("threads", threads)?
        .set("entries", results.entries.len())?
        .set("agreeing", results.entries.len() - disagreeing.len())?
        .set("disagreeing", disagreeing.join(", "))?
        .set("ratings", ratings(results))?
        .set("ratings_agreeing", ratings(results) - results.other_ratings().len())?
        .set("audits", audits)?
        .set("audits_passed", audits - failed.len())?
        .set("audit_ok", failed.is_empty())?
        .set("audits_failed", failed.join("; "))?
        .set_seconds("total_s", time)?;
    if let Some(threshold) = results.threshold {
        summary.set("threshold", threshold)?;
    }
    for case in &results.cases {
        let tuned = &case.tuned.run.growth;
        summary
            .set(&figure(&case.key, "gcfa_isp_tuned", "threshold"), case.tuned.threshold)?
            .set(&figure(&case.key, "gcfa_isp_tuned", "missed"), tuned.missed.len())?
            .set(&figure(&case.key, "gcfa_isp_tuned", "layers"), tuned.order.len())?;
    }
    for (object, &missed) in results.uniform.iter().enumerate() {
        summary.set(&format!("object{}_uniform_missed", object + 1), missed)?;
    }
    for set in Hardware::ALL {
        let methods = results.hardware.first().into_iter().flat_map(|on| on.ways.runs());
        for ((method, _), missed) in methods.zip(missed_on(results, set)) {
            summary.set(&figure(set.key(), method, "missed"), missed)?;
        }
    }
    for (name, run) in results.runs() {
        summary
            .set(&format!("{name}_missed"), run.growth.missed.len())?
            .set(&format!("{name}_layers"), run.growth.order.len())?;
    }
    Ok(summary)
}

fn report(results: &Results) -> Result<Report, Failure> {
    let mut report = Report::new("Six objects after Boge (2019)");
    report.paragraph(
        "H. Boge grew six small objects layer by layer on a small, a medium and a large platform (Robotic additive \
         manufacturing, MSc thesis, NTNU 2019): greedily (GCFA), and with incremental shadow prevention (GCFA-ISP). A \
         cell that comes to lie inside the convex hull of what is built is missed. The objects are shown in figures \
         only; here they are reconstructions, chosen to fit her counts.",
    );
    results.disagreeing().for_each(|entry| {
        _ = report.notice(&format!("{} is {}, in the thesis {}", entry.key, entry.ours, entry.thesis));
    });
    results.other_ratings().iter().for_each(|line| _ = report.notice(line));
    results.failed_audits().iter().for_each(|line| _ = report.notice(&format!("The audit failed: {line}")));
    report
        .table("This run", &verdict(results))
        .heading("By the rules of the thesis")
        .table(BOTH, &thesis_table(results))
        .table(TUNED, &tuned_table(results))
        .paragraph(&tuned_note(results))
        .table(RATED, &rating_table(results))
        .paragraph(BOUNDS)
        .table(SLICED, &uniform_table(results))
        .table(SETS, &hardware_table(results))
        .paragraph(SETS_NOTE)
        .heading("By our default rules")
        .paragraph(
            "A cell may lie up to one cell deep in the hull, cells held back can be taken later, and the platform \
             reaches down without end.",
        )
        .table(DEFAULT, &default_table(results))
        .heading("The worked example of chapter 4 (Figs. 4.10 to 4.24)")
        .paragraph(
            "Object 1 on the medium platform, layer by layer: the hull of the centres of all that is built and of the platform, and a cross for each cell that is not built and lies in \
             it: missed, since what lies in the hull is not built any more.",
        );
    report_pictures(results, &mut report)?;
    Ok(report)
}

/// The objects layer by layer: the worked example, slices, and what is built on each platform.
fn report_pictures(results: &Results, report: &mut Report) -> Result<(), Failure> {
    if let Some(case) = results.cases.iter().find(|case| case.object == 0 && case.platform == 1) {
        for (method, run) in METHODS.iter().zip(&case.ways.theirs) {
            let (missed, layers) = (run.growth.missed.len(), run.growth.order.len());
            report.drawing(
                &format!("{method}: {}, {} missed", counted(layers, "layer"), counted(missed, "cell")),
                &worked_example(case, run)?,
            );
        }
    }
    report.heading("Curved layers and plane slicing (Figs. 6.2 to 6.6)");
    for object in 0..UNIFORM.len() {
        sliced_beside_worst(report, results, object)?;
    }
    for (platform, name) in ["small", "medium", "large"].into_iter().enumerate() {
        report.heading(&format!("On the {name} platform, by the rules of the thesis"));
        for case in results.cases.iter().filter(|case| case.platform == platform) {
            let runs: Vec<_> =
                METHODS.iter().zip(&case.ways.theirs).map(|(method, run)| (case, *method, run)).collect();
            pictures(report, &runs)?;
        }
    }
    report.heading("Object 6 in cuts from front to back (Figs. 5.28 to 5.38)");
    for (platform, method) in [(1, 0), (2, 0), (2, 1)] {
        let of_six = results.cases.iter().find(|case| case.object == 5 && case.platform == platform);
        if let Some(case) = of_six {
            cuts(report, case, METHODS[method], &case.ways.theirs[method])?;
        }
    }
    report.heading("On the large platform, by our default rules");
    let runs: Vec<_> = on_large(results).map(|case| (case, STRATEGIES[4], &case.ways.ours[4])).collect();
    pictures(report, &runs)?;
    Ok(())
}

fn on_large(results: &Results) -> impl Iterator<Item = &Case> {
    results.cases.iter().filter(|case| case.platform == PLATFORMS.len() - 1)
}

/// What the thresholds gain, over all cases.
fn tuned_note(results: &Results) -> String {
    let sum = |count: &dyn Fn(&Case) -> usize| results.cases.iter().map(count).sum::<usize>();
    let (isp, tuned) =
        (sum(&|case| case.ways.theirs[1].growth.missed.len()), sum(&|case| case.tuned.run.growth.missed.len()));
    let which = match results.threshold {
        Some(threshold) => format!("With a threshold of {threshold}"),
        None => "With the best threshold of each".to_owned(),
    };
    format!(
        "{which} GCFA-ISP misses {tuned} cells in all, {isp} as in the thesis. A cell is kept when it leaves fewer cells shadowed than the threshold; in the thesis, fewer than the whole \
         greedy layer would (--threshold)."
    )
}

/// The worst result of an object by the methods of the thesis, and its levels as layers.
fn sliced_beside_worst(report: &mut Report, results: &Results, object: usize) -> Result<(), Failure> {
    let of_object = || results.cases.iter().filter(|case| case.object == object);
    let all = of_object()
        .flat_map(|case| METHODS.iter().zip(&case.ways.theirs).map(move |(method, run)| (case, *method, run)));
    // The first of those that miss most.
    let Some((case, method, run)) = all.rev().max_by_key(|(_, _, run)| run.growth.missed.len()) else { return Ok(()) };
    let curved = picture(&case.drawn, run)?;
    let plane = layered_picture(&case.drawn, &case.sliced.order, case.sliced.missed.len())?;
    let number = object + 1;
    let missed = run.growth.missed.len();
    report.pictures(&[
        (
            &format!("object {number}: {method} on {}, the worst result, {missed} missed", PLATFORMS[case.platform]),
            &curved,
        ),
        (&format!("object {number}: plane slicing, {} missed", case.sliced.missed.len()), &plane),
    ]);
    Ok(())
}

/// Cuts through an object, one after the other.
fn cuts(report: &mut Report, case: &Case, method: &str, run: &Run) -> Result<(), Failure> {
    let grid = &case.drawn.grid;
    let field = run.growth.order.field(grid.dims().iter().map(|&side| side as usize).product());
    let layered = LayeredCells::new(grid.dims(), grid.rows(), &field)?;
    let [width, height] = PICTURE;
    let mut drawn = Vec::new();
    let rows: Vec<u32> = grid.iter().map(|cell| grid.position(cell)[1]).collect();
    let (Some(&first), Some(&last)) = (rows.iter().min(), rows.iter().max()) else { return Ok(()) };
    for y in first..=last {
        let cut = draw_cut(&layered, Plane::Y(y), width, height);
        let png = cut.with_legend(run.growth.order.len() as u32, run.growth.missed.len()).to_png();
        let caption = format!(
            "object {} on {}, {method}: cut {} of {}",
            case.object + 1,
            PLATFORMS[case.platform],
            y - first + 1,
            last - first + 1
        );
        drawn.push((caption, png));
    }
    report.slider(&drawn.iter().map(|(caption, png)| (caption.as_str(), png.as_slice())).collect::<Vec<_>>());
    Ok(())
}

/// Adds the growing fields side by side.
fn pictures(report: &mut Report, runs: &[(&Case, &str, &Run)]) -> Result<(), Failure> {
    let mut drawn = Vec::new();
    for (case, method, run) in runs {
        let cut = if case.drawn.flat { "" } else { " (cut through the middle)" };
        drawn.push((format!("object {}, {method}{cut}", case.object + 1), picture(&case.drawn, run)?));
    }
    report.pictures(&drawn.iter().map(|(caption, png)| (caption.as_str(), png.as_slice())).collect::<Vec<_>>());
    Ok(())
}

/// The growing field as squares; of an object in space the cut through its middle.
pub fn picture(drawn: &TextGrid, run: &Run) -> Result<Vec<u8>, Failure> {
    layered_picture(drawn, &run.growth.order, run.growth.missed.len())
}

/// The layers of an order as squares; of an object in space the cut through its middle.
fn layered_picture(drawn: &TextGrid, order: &LayerOrder, missed: usize) -> Result<Vec<u8>, Failure> {
    let grid = &drawn.grid;
    let field = order.field(grid.dims().iter().map(|&side| side as usize).product());
    let layered = LayeredCells::new(grid.dims(), grid.rows(), &field)?;
    let [width, height] = PICTURE;
    let cut = draw_cut(&layered, Plane::middle_y(grid.dims()), width, height);
    Ok(cut.with_legend(order.len() as u32, missed).to_png())
}
