//! What trying an order found.

use crate::args::Args;
use crate::choice::{Printed, Tried};
use crate::complete::LayersBy;
use crate::job::Results;
use nalgebra::Point3;
use std::time::Duration;

/// Places where beads are unsupported, if there are more of them than allowed: those of pieces that are too long, or of all longer than a bead is wide where all
/// together are too much.
pub fn bare_places(results: &Results, args: &Args) -> Vec<Point3<f64>> {
    let (Some(paths), Some(run)) = (&results.paths, &results.machine) else { return Vec::new() };
    let is_too_much = run.support.unsupported_share() > args.allow.allow_unsupported;
    let beads = if is_too_much { 1.0 } else { args.allow.allow_unsupported_beads };
    let long = run.support.unsupported.iter().filter(|piece| piece.length() > beads * paths.bead_mm);
    long.flat_map(|piece| piece.middles(&run.resolved.paths, paths.bead_mm / 2.0)).collect()
}

/// An order with what came of it, printed or not.
pub fn tried(layers_by: LayersBy, results: &Results, args: &Args, time: Duration) -> Tried {
    let Results { field, paths, machine, findings, .. } = results;
    let (allow, missed_share) = (&args.allow, field.missed_share());
    let mut figures = vec![(missed_share, allow.allow_missed)];
    let printed = paths.as_ref().zip(machine.as_ref()).map(|(paths, run)| {
        let printed = Printed {
            paths: run.resolved.paths.len(),
            unsupported_share: run.support.unsupported_share(),
            unsupported_longest_mm: run.support.longest_mm(),
            gouging_share: run.gouging_share(),
            left_out_share: run.left_out_share(),
            cut_turns: run.resolved.cut_turns.len(),
            filled_share: run.filled_shares(field, paths)[0],
            print_s: run.deposition.total_s,
        };
        figures.extend([
            (printed.unsupported_share, allow.allow_unsupported),
            (printed.unsupported_longest_mm / paths.bead_mm, allow.allow_unsupported_beads),
            (printed.gouging_share, allow.allow_gouging),
            (printed.left_out_share, allow.allow_left_out),
            (run.volume_off(field, paths), allow.allow_volume),
        ]);
        printed
    });
    let of_limit = |(figure, limit): (f64, f64)| if figure > 0.0 { figure / limit } else { 0.0 };
    let excess = figures.into_iter().map(of_limit).fold(0.0, f64::max);
    let passed = printed.is_some() && !findings.has_failed();
    Tried { layers_by, below_beads: field.below_beads, passed, excess, missed_share, printed, time }
}
