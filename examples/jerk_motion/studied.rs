//! What the study of collisions leaves behind: findings, keys of `summary.json`, and its part of `report.html`.

use super::collisions::{Audit, PAPER_SHIFT, Row, Steered, Study};
use super::shortened::MAX_LINES;
use curvlay_examples::args::Failure;
use curvlay_examples::findings::{Findings, Severity};
use curvlay_examples::report::Report;
use curvlay_examples::summary::Summary;
use curvlay_examples::table::Table;

/// Steps of the motion that the geometric indicator steers must be free; what another indicator lets through is reported.
pub fn find_collisions(study: &Study, findings: &mut Findings) {
    if let Some(first) = study.collisions.first() {
        let amount = format!("{} of {}, the first at {first}", study.collisions.len(), study.motions);
        let what = "steps of the motion around what is in the way are not proven free of collisions";
        findings.add(Severity::Failed, what, amount, "report.html");
    }
    for steered in study.steered.iter().filter(|steered| steered.indicator.starts_with("svm")) {
        let (audit, after) = (&steered.audit, steered.last());
        if !audit.unproven.is_empty() {
            let what = format!("{}: steps are not proven free of collisions", steered.name());
            let amount = format!("{} of {}; {} after repair", audit.unproven.len(), audit.steps, after.unproven.len());
            findings.add(Severity::Warning, what, amount, "report.html");
        }
    }
}

impl Steered {
    /// What the scene says in the end: after repair, where there was any.
    fn last(&self) -> &Audit {
        self.repaired.as_ref().map_or(&self.audit, |repaired| &repaired.audit)
    }
}

/// Table 4.1 of the dissertation for its two layers: TNR near and on contact, kernels and samples.
const PAPER_INDICATORS: [(&str, [&str; 2], usize, usize); 3] = [
    ("dissertation", ["0.963, 0.944", "0.969, 0.956"], 887, 3020),
    ("dissertation, random", ["0.894, 0.876", "0.942, 0.923"], 479, 3020),
    ("dissertation, random", ["0.889, 0.883", "0.951, 0.943"], 887, 5842),
];

/// Table 4.1, ours and the dissertation's.
fn table_4_1(study: &Study) -> Table {
    let mut table = indicators(&study.rows);
    for (name, [near, on], kernels, samples) in PAPER_INDICATORS {
        let [shift, kernels, samples] = [PAPER_SHIFT.to_string(), kernels.to_string(), samples.to_string()];
        table.row([name, near, on, "-", "-", &shift, &kernels, &samples, "-", "-"]);
    }
    table
}

/// What indicators are worth.
fn indicators(rows: &[Row]) -> Table {
    let mut table = Table::new([
        "indicator",
        "TNR near",
        "TNR on contact",
        "missed near",
        "missed on contact",
        "bias shift",
        "kernels",
        "samples",
        "checked exactly",
        "evaluation us",
    ]);
    let rate = |rate: Option<f64>| rate.map_or_else(|| "-".to_owned(), |rate| format!("{rate:.3}"));
    for row in rows {
        table.row([
            row.name.replace('_', " "),
            rate(row.tnr[0]),
            rate(row.tnr[1]),
            rate(row.missed[0]),
            rate(row.missed[1]),
            if row.kernels > 0 { format!("{}", row.bias_shift) } else { "-".to_owned() },
            row.kernels.to_string(),
            row.samples.to_string(),
            row.checked.to_string(),
            format!("{:.2}", row.evaluation_us),
        ]);
    }
    table
}

pub fn set_study(study: &Study, summary: &mut Summary) -> Result<(), Failure> {
    study.rows.iter().try_for_each(|row| set_row("", row, summary))?;
    if let Some((waypoints, rows)) = &study.past_post {
        summary.set("post_waypoints", *waypoints)?;
        rows.iter().try_for_each(|row| set_row("post_", row, summary))?;
    }
    let [[near, near_collide], [on, on_collide]] = study.verified;
    summary
        .set("samples_near", near)?
        .set("samples_near_colliding", near_collide)?
        .set("samples_contact", on)?
        .set("samples_contact_colliding", on_collide)?
        .set("motions_verified", study.motions)?
        .set("collisions", study.collisions.len())?
        .set("collisions_unaware", study.unaware)?;
    study.steered.iter().try_for_each(|steered| set_steered(steered, summary))
}

fn set_row(place: &str, row: &Row, summary: &mut Summary) -> Result<(), Failure> {
    let name = format!("{place}{}", row.name);
    for (place, k) in [("near", 0), ("contact", 1)] {
        // Nothing to count gives no rate.
        for (what, rate) in [("tnr", row.tnr[k]), ("missed", row.missed[k])] {
            if let Some(rate) = rate {
                summary.set(&format!("{name}_{what}_{place}"), rate)?;
            }
        }
    }
    summary
        .set(&format!("{name}_bias_shift"), row.bias_shift)?
        .set(&format!("{name}_kernels"), row.kernels)?
        .set(&format!("{name}_samples"), row.samples)?
        .set(&format!("{name}_checked"), row.checked)?
        .set(&format!("{name}_evaluation_us"), row.evaluation_us)?;
    Ok(())
}

fn set_steered(steered: &Steered, summary: &mut Summary) -> Result<(), Failure> {
    let (name, audit) = (steered.name(), &steered.audit);
    summary
        .set(&format!("{name}_j"), steered.j)?
        .set(&format!("{name}_max_jerk"), steered.max_jerk)?
        .set(&format!("{name}_limits_broken"), audit.limits_broken)?
        .set(&format!("{name}_predicted"), steered.predicted)?
        .set(&format!("{name}_colliding"), audit.colliding)?
        .set(&format!("{name}_unproven"), audit.unproven.len())?
        .set_seconds(&format!("{name}_filter_s"), steered.time)?;
    if let Some(repaired) = &steered.repaired {
        summary
            .set(&format!("{name}_repaired"), repaired.changed)?
            .set(&format!("{name}_repair_splits"), repaired.splits)?
            .set(&format!("{name}_repair_stuck"), repaired.stuck)?
            .set(&format!("{name}_repaired_colliding"), repaired.audit.colliding)?
            .set(&format!("{name}_repaired_unproven"), repaired.audit.unproven.len())?
            .set(&format!("{name}_repaired_limits_broken"), repaired.audit.limits_broken)?
            .set_seconds(&format!("{name}_repair_s"), steered.repair_time)?;
    }
    Ok(())
}

/// Motions by what steered them, before and after repair.
fn steered(study: &Study) -> Table {
    let mut table = Table::new([
        "indicator",
        "filter",
        "J, Eq. 4.10",
        "max jerk, spline",
        "limits broken",
        "predicted",
        "colliding",
        "steps not free",
        "filter s",
        "repaired",
        "splits",
        "stuck",
        "then colliding",
        "steps not free",
        "limits broken",
    ]);
    for steered in &study.steered {
        let audit = &steered.audit;
        let before = [
            steered.indicator.replace('_', " "),
            steered.filter.name().to_owned(),
            format!("{:.2}", steered.j),
            format!("{:.3}", steered.max_jerk),
            audit.limits_broken.to_string(),
            steered.predicted.to_string(),
            audit.colliding.to_string(),
            audit.unproven.len().to_string(),
            format!("{:.2}", steered.time.as_secs_f64()),
        ];
        let after = steered.repaired.as_ref().map_or_else(
            || ["-"; 6].map(str::to_owned),
            |repaired| {
                let Audit { colliding, unproven, limits_broken, .. } = &repaired.audit;
                [repaired.changed, repaired.splits, repaired.stuck, *colliding, unproven.len(), *limits_broken]
                    .map(|count| count.to_string())
            },
        );
        table.row(before.into_iter().chain(after));
    }
    table
}

pub fn report_study(study: &Study, report: &mut Report) {
    let [[near, near_collide], [on, on_collide]] = study.verified;
    report.heading("Collisions: the UR3 with the part in its hand under a head of nozzle and heater");
    report.paragraph(&format!(
        "Of {near} postures near the working surface {near_collide} collide, of {on} on it {on_collide}, by the exact \
         scene. TNR is the share of free ones that are said to be free (Eq. 4.16), missed the share of colliding ones \
         that are not; the dissertation does not report the latter. It adds 1 to the bias of its machines, which predicts more \
         collisions, right and wrong: shifted rows are ours with the same. \
         Its figures are those of other surfaces and another head."
    ));
    report.table("Table 4.1", &table_4_1(study));
    if study.rows.iter().any(|row| row.name.starts_with("svm_gap")) {
        report.paragraph(
        "svm gap is a machine over features of a posture, the gap between tip and working surface among them, that learns from samples \
         which it had wrong: for each of its samples several postures are checked exactly.",
        );
    }
    report.paragraph(&format!(
        "Of {} steps from knot to knot of a motion that the geometric indicator steers through the global filter, each as a straight \
         motion of the joints, {} are not proven to keep the bodies of the scene apart; of those of the smoothest motion above, which \
         knows of nothing in the way, {}.",
        study.motions,
        study.collisions.len(),
        study.unaware
    ));
    if let Some((waypoints, rows)) = &study.past_post {
        report.paragraph(&format!(
            "A post stands beside the path: its head is a ball that reaches 5 mm into wrist 2 of the motion without it, in the middle of \
             {waypoints} waypoints. Machines learn what is in the way there anew."
        ));
        report.table("Indicators past the post", &indicators(rows));
    }
    if !study.steered.is_empty() {
        report.table("Motions from the same ladder, by what steers the filters", &steered(study));
        report.paragraph(
            "predicted: waypoints at which the indicator itself still says that something collides; colliding, steps not free: by the \
             exact scene, which judges all of them alike. Repair turns the tool at waypoints that collide, in steps of pi / 500 (Eq. 4.13), \
             and splits the motion where joints would be too fast; it does not look at acceleration and jerk.",
        );
    }
    study.collisions.iter().take(MAX_LINES).chain(&study.notes).for_each(|line| _ = report.notice(line));
}
