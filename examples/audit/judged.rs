//! What the checks found, in words.

use super::args::Args;
use super::figures::{Audited, Check, Found, Place, Verdict};
use curvlay_examples::findings::{Findings, Severity, accept, percent};

/// Places that a finding names.
const NAMED: usize = 3;

/// The share that is allowed of a check, and its option.
pub fn allowed(args: &Args, check: Check) -> (f64, &'static str) {
    let allow = &args.allow;
    match check {
        Check::Shadowed => (allow.allow_shadowed, "--allow-shadowed"),
        Check::Unsupported => (allow.allow_unsupported, "--allow-unsupported"),
        Check::InAir => (allow.allow_in_air, "--allow-in-air"),
        Check::Gouged => (allow.allow_gouged, "--allow-gouged"),
        Check::Uncovered => (allow.allow_uncovered, "--allow-uncovered"),
        Check::Outside => (allow.allow_outside, "--allow-outside"),
        Check::LaidTwice => (allow.allow_laid_twice, "--allow-laid-twice"),
    }
}

/// Adds a finding for each check that found something.
pub fn find(args: &Args, audited: &Audited, findings: &mut Findings) {
    for slip in &audited.slips {
        findings
            .explain(Severity::Failed, "these are no sizes of a print", slip.as_str(), "")
            .cause("the numbers are probably not millimetres")
            .try_to("--scale with the millimetres in a unit of the input, such as 1000 for metres or 25.4 for inches");
    }
    audited.notes.iter().for_each(|note| findings.push(note.clone()));
    for (check, verdict) in audited.in_order() {
        let Verdict::Found(found) = verdict else { continue };
        if found.amount <= 0.0 {
            continue;
        }
        let (allowed, option) = allowed(args, check);
        let share = found.share.unwrap_or(1.0);
        let amount = format!("{}, {}", found.shown(), percent(share));
        let severity = Severity::above(share, allowed);
        let finding = findings.explain(severity, format!("{}: {}", check.name(), check.what()), amount, places(found));
        if severity == Severity::Failed {
            finding.allow(accept(option, share));
        }
    }
}

fn places(found: &Found) -> String {
    found.places.iter().take(NAMED).map(place).collect::<Vec<_>>().join("; ")
}

/// `x 1.00, y 2.00, z 3.00 mm, layer 4`.
pub fn place(place: &Place) -> String {
    let Place { at, layer, .. } = place;
    let layer = layer.map_or(String::new(), |layer| format!(", layer {layer}"));
    format!("x {:.2}, y {:.2}, z {:.2} mm{layer}", at.x, at.y, at.z)
}
