//! A first look: the order, some of its layers, and what printing them takes.

use super::estimated::PreviewRun;
use super::findings::find;
use crate::Stage;
use crate::args::failure;
use crate::job::{Job, Results};
use curvlay_examples::args::{Failure, Outcome};
use curvlay_examples::findings::Findings;
use curvlay_layers::curved::surface::SavedField;

impl Job<'_> {
    /// A first look: the order that a full run tries first, or the next one where that misses more than it may; its layers; estimates.
    pub fn preview(&self, mut saved: Option<SavedField>, findings: &Findings) -> Result<Outcome, Failure> {
        let Job { args, part, bars, .. } = *self;
        let mut best: Option<Results> = None;
        let faults = |results: &Results| (!results.field.audit.is_ok(), results.field.missed_share());
        for layers_by in args.orders() {
            let results = self.begin(layers_by, saved.take(), &[], findings.clone())?;
            if best.as_ref().is_none_or(|best| faults(&results) < faults(best)) {
                best = Some(results);
            }
            let is_fine = |(has_failed, missed): (bool, f64)| !has_failed && missed <= args.allow.allow_missed;
            if args.resume.is_some() || best.as_ref().is_some_and(|best| is_fine(faults(best))) {
                break;
            }
        }
        let Some(mut results) = best else { return Ok(Outcome::Done) };
        let Some(surfaces) = &results.surfaces else {
            return Err(failure(format!("the audit of the layers failed: {}", results.field.audit)));
        };
        let preview = PreviewRun::new(args, part, &results.field, surfaces, bars)?;
        find(self, &results.field, surfaces, &preview, &mut results.findings);
        results.preview = Some(preview);
        self.end(Stage::Preview, &mut results)?;
        Ok(results.findings.outcome())
    }
}
