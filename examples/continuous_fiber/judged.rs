//! What the plan of the specimens must reach, and what is wrong with it.

use super::layer::LoadedLayer;
use super::motion::Moved;
use super::predict::Predictions;
use super::tapes::Planned;
use curvlay_examples::findings::{Findings, Severity, percent};
use curvlay_toolpath::fiber::tapes::TapeOptions;

/// What the tapes of a specimen must reach: share covered, and share covered twice.
pub const SPECIMEN: [f64; 2] = [0.95, 0.02];

/// The mean angle to the principal direction over the worst-stressed tenth, in degrees.
pub const ANGLE_DEG: f64 = 15.0;

/// Share of the worst-stressed tenth of a layer below which tapes do not reinforce it as they should.
pub const WORST_COVERED: f64 = 0.8;

/// Difference of a prediction, as a share, above which it is reported.
pub const NEAR: f64 = 0.1;

pub fn judge(planned: &Planned, options: &TapeOptions, findings: &mut Findings) {
    let title = planned.specimen.title;
    let [covered, overlap, radius] = planned.cover();
    if covered < SPECIMEN[0] || overlap > SPECIMEN[1] {
        let amount = format!("{} covered, {} twice", percent(covered), percent(overlap));
        findings.add(Severity::Failed, format!("{title}: the strip of a tape is not covered as it should"), amount, "");
    }
    if radius < options.min_radius {
        findings.add(Severity::Failed, format!("{title}: a tape bends too tightly"), format!("{radius:.1} mm"), "");
    }
    if let Some(print) = planned.print.as_ref().filter(|print| !print.resolved.left_out.is_empty()) {
        let count = print.resolved.left_out.len();
        findings.add(
            Severity::Warning,
            format!("{title}: pieces of thermoplastic are left out"),
            count.to_string(),
            "",
        );
    }
}

pub fn judge_layer(layer: &LoadedLayer, findings: &mut Findings) {
    if let Some(empty) = &layer.plan.empty {
        findings.add(Severity::Warning, format!("no tape lies on {}", layer.name), empty.to_string(), "");
    }
    let degrees = layer.angle.mean.map(f64::to_degrees);
    if let Some(degrees) = degrees.filter(|degrees| *degrees > ANGLE_DEG) {
        let what = "tapes leave the principal direction over the worst-stressed tenth of the layer";
        findings.add(Severity::Warning, what, format!("{degrees:.1} degrees in the mean"), "--smoothing, --min-radius");
    }
    let covered = layer.angle.covered_fraction;
    if layer.plan.empty.is_none() && covered < WORST_COVERED {
        let what = format!(
            "less than {} of the worst-stressed tenth of {} lies under a tape",
            percent(WORST_COVERED),
            layer.name
        );
        findings.add(Severity::Warning, what, percent(covered), "");
    }
    let left: f64 = layer.plan.left_out.iter().map(|piece| piece.length_mm).sum();
    if left > 0.0 {
        let amount = format!("{left:.0} mm of {:.0} mm", left + layer.plan.tape_mm());
        findings.add(Severity::Warning, format!("lines without a tape on {}", layer.name), amount, "tapes.csv");
    }
}

pub fn judge_motion(moved: &Moved, findings: &mut Findings) {
    for fault in &moved.faults {
        let what = format!("the robot does not lay all tapes: {} {}", fault.kind.name(), fault.what);
        findings.add(Severity::Failed, what, "", format!("tape {}, point {}", fault.path + 1, fault.waypoint));
    }
    if moved.faults.is_empty() && moved.runs != moved.tapes {
        findings.add(Severity::Failed, "tapes are laid in pieces", format!("{} of {}", moved.runs, moved.tapes), "");
    }
}

pub fn judge_predictions(predictions: &Predictions, findings: &mut Findings) {
    for prediction in &predictions.list {
        let ratio = prediction.ours / prediction.measured;
        if (ratio - 1.0).abs() > NEAR {
            let amount = format!("{:.3} / {:.3} {}", prediction.ours, prediction.measured, prediction.unit);
            let what = format!("{}: ours / measured differ; possible reasons: {}", prediction.what, prediction.remark);
            findings.add(Severity::Note, what, amount.trim_end(), "");
        }
    }
}
