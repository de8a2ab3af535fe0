//! What the checks found, in words.

use super::args::Args;
use super::figures::{Audited, Check, Found, Place, Verdict};
use curvlay_examples::findings::{Findings, Severity, accept, percent};

/// Places that a finding names.
const NAMED: usize = 3;

/// The share that is allowed of a check, and its option; none for counts.
pub fn allowed(args: &Args, check: Check) -> Option<(f64, &'static str)> {
    let allow = &args.allow;
    Some(match check {
        Check::Shadowed => (allow.allow_shadowed, "--allow-shadowed"),
        Check::Unsupported => (allow.allow_unsupported, "--allow-unsupported"),
        Check::InAir => (allow.allow_in_air, "--allow-in-air"),
        Check::Gouged => (allow.allow_gouged, "--allow-gouged"),
        Check::Uncovered => (allow.allow_uncovered, "--allow-uncovered"),
        Check::Outside => (allow.allow_outside, "--allow-outside"),
        Check::LaidTwice => (allow.allow_laid_twice, "--allow-laid-twice"),
        Check::Starts | Check::SharpTurns => return None,
    })
}

/// Adds a finding for each check that found something.
pub fn find(args: &Args, audited: &Audited, findings: &mut Findings) {
    for (check, verdict) in audited.in_order() {
        let Verdict::Found(found) = verdict else { continue };
        let Some((allowed, option)) = allowed(args, check).filter(|_| found.amount > 0.0) else { continue };
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

/// `x 1.00, y 2.00, z 3.00 mm, layer 4, line 512`.
pub fn place(place: &Place) -> String {
    let Place { at, layer, line, .. } = place;
    let layer = layer.map_or(String::new(), |layer| format!(", layer {layer}"));
    let line = line.map_or(String::new(), |line| format!(", line {line}"));
    format!("x {:.2}, y {:.2}, z {:.2} mm{layer}{line}", at.x, at.y, at.z)
}
