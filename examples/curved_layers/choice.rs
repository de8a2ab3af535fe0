//! Which order of the cells prints best, and how the others fared.

use crate::complete::LayersBy;
use curvlay_examples::args::typed_name;
use curvlay_examples::findings::percent;
use curvlay_examples::table::Table;
use curvlay_layers::curved;
use std::time::Duration;

/// How often support is put below unsupported beads, and the order printed again, at most.
pub const SUPPORT_ROUNDS: usize = 2;

/// The orders that are tried, one after the other: most parts need no other than the first.
pub fn orders() -> [LayersBy; 3] {
    curved::LayersBy::TRIED.map(LayersBy::from)
}

/// The order that was taken, and the others that were tried.
#[derive(Clone, Debug)]
pub struct Choice {
    pub taken: Tried,
    pub others: Vec<Tried>,
}

/// An order that was tried, and what it would print.
#[derive(Clone, Debug)]
pub struct Tried {
    pub layers_by: LayersBy,
    /// Cells with support since beads above them were unsupported.
    pub below_beads: usize,
    /// Whether all checks passed.
    pub passed: bool,
    /// The figure that is farthest above its limit, as a multiple of it: 1 at most where all are within. Infinite where nothing is allowed.
    pub excess: f64,
    pub missed_share: f64,
    /// None if it misses so much, or fails its audit, that it was not printed.
    pub printed: Option<Printed>,
    /// What trying it took.
    pub time: Duration,
}

/// What an order prints.
#[derive(Clone, Copy, Debug)]
pub struct Printed {
    pub paths: usize,
    pub unsupported_share: f64,
    pub unsupported_longest_mm: f64,
    pub gouging_share: f64,
    pub left_out_share: f64,
    pub cut_turns: usize,
    pub filled_share: f64,
    pub print_s: f64,
}

impl Tried {
    /// Whether its print is nearer to passing all checks than that of another.
    pub fn is_better_than(&self, other: &Tried) -> bool {
        let faults = |tried: &Tried| (!tried.passed, tried.printed.is_none(), tried.excess);
        faults(self) < faults(other)
    }
}

impl Choice {
    /// What was taken, and why.
    pub fn reason(&self) -> String {
        let name = typed_name(self.taken.layers_by);
        match (self.taken.passed, self.others.len()) {
            (true, 0) => format!("{name}: the print passes all checks, no other order was tried"),
            (true, _) => format!("{name}: the first order whose print passes all checks"),
            (false, _) => format!("{name}: no print passes all checks, this one is nearest to it"),
        }
    }

    /// The names of what was tried, the taken one first.
    pub fn names(&self) -> Vec<String> {
        self.all().map(|tried| typed_name(tried.layers_by)).collect()
    }

    fn all(&self) -> impl Iterator<Item = &Tried> {
        std::iter::once(&self.taken).chain(&self.others)
    }

    /// A row for each order, in the order in which they are tried.
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            "--layers-by",
            "checks",
            "missed",
            "unsupported beads",
            "longest",
            "nozzle collides",
            "left out",
            "paths",
            "cut at turns",
            "laid",
            "print time",
            "computing time",
        ]);
        for layers_by in orders() {
            let name = typed_name(layers_by);
            let Some(tried) = self.all().find(|tried| tried.layers_by == layers_by) else {
                table.row([name, "not tried".to_owned()]);
                continue;
            };
            let checks = match (tried.passed, tried.printed) {
                (true, _) => "passed",
                (false, Some(_)) => "failed",
                (false, None) => "failed before printing",
            };
            let taken = if layers_by == self.taken.layers_by { ", taken" } else { "" };
            let of_print = |text: &dyn Fn(&Printed) -> String| tried.printed.as_ref().map_or_else(String::new, text);
            let with = if tried.below_beads > 0 { ", with support below its beads" } else { "" };
            table.row([
                name + with,
                format!("{checks}{taken}"),
                percent(tried.missed_share),
                of_print(&|print| percent(print.unsupported_share)),
                of_print(&|print| format!("{:.1} mm", print.unsupported_longest_mm)),
                of_print(&|print| percent(print.gouging_share)),
                of_print(&|print| percent(print.left_out_share)),
                of_print(&|print| print.paths.to_string()),
                of_print(&|print| print.cut_turns.to_string()),
                of_print(&|print| percent(print.filled_share)),
                of_print(&|print| format!("{:.1} min", print.print_s / 60.0)),
                format!("{:.1} s", tried.time.as_secs_f64()),
            ]);
        }
        table
    }
}
