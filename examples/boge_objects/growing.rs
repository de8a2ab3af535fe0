//! Growing every object on every platform, by the rules of the thesis and by ours.
//!
//! Boge 2019, chapter 4 and sections 5.2 and 6.3. Where the thesis is silent or contradicts itself, its own figures
//! decided:
//! * Hulls are of cell centres, and what lies on the hull is inside. The platform is a row of cells right below the
//!   first level and takes part with their centres: a thin plate half a cell below the part, with an underside.
//! * Candidates are the neighbours (distance 1 or the root of 2) of the last layer only, and they come in the order
//!   of the file: top row first for a flat object, bottom block first for one in space.
//! * Line 6 of Algorithm 2 must read the other way round: a layer is improved when it would shadow *more* cells.
//! * A cell that was tried and turned down stays in the tested set, as line 20 says.
//! * Uniform slicing builds a cell only if the whole column under it is solid.

use super::objects::Drawing;
use super::thesis;
use curvlay_examples::args::{Failure, Outcome};
use curvlay_examples::bars::Bars;
use curvlay_layers::Progress;
use curvlay_layers::curved::{
    AuditReport, Candidates, Cells, Growth, GrowthOptions, Neighbours, Platform, PlatformError, Prevention, Rules,
    UnbuildOptions, Visit, audit, grow, peel, unbuild,
};
use curvlay_layers::planar::slice_uniformly;
use curvlay_voxel::TextGrid;
use std::fmt;
use std::ops::ControlFlow;

/// Our strategies, as `curved_layers` calls them.
pub const STRATEGIES: [&str; 5] = ["greedy", "incremental", "adaptive", "governed", "unbuild"];

/// Un-building by the rules of the thesis.
pub const UNBUILT: &str = "unbuild by her rules";

/// An order, and what its audit says.
pub struct Run {
    pub growth: Growth,
    pub audit: AuditReport,
}

/// An object on a platform, grown in all ways.
pub struct Case {
    pub object: usize,
    pub platform: usize,
    /// Begins the names of its figures.
    pub key: String,
    pub drawn: TextGrid,
    /// By the rules of the thesis, in the order of [`thesis::METHODS`].
    pub theirs: [Run; 2],
    /// By the rules of the thesis, un-built.
    pub unbuilt: Run,
    /// By our default rules, in the order of [`STRATEGIES`].
    pub ours: [Run; 5],
}

/// A figure of the thesis beside ours.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    pub key: String,
    pub ours: usize,
    pub thesis: usize,
}

impl fmt::Display for Entry {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: {}, in the thesis {}", self.key, self.ours, self.thesis)
    }
}

/// Everything that was grown and compared.
pub struct Results {
    /// Object after object, in each the platforms S, M and L.
    pub cases: Vec<Case>,
    /// Cells that uniform slicing misses, for each object.
    pub uniform: Vec<usize>,
    /// The 77 figures of the tables.
    pub entries: Vec<Entry>,
}

impl Results {
    /// The figures that are not those of the thesis.
    pub fn disagreeing(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(|entry| entry.ours != entry.thesis)
    }

    /// All runs under their names.
    pub fn runs(&self) -> impl Iterator<Item = (String, &Run)> {
        self.cases.iter().flat_map(|case| {
            let theirs = thesis::METHODS.iter().zip(&case.theirs);
            let named = theirs.chain([(&UNBUILT, &case.unbuilt)]).chain(STRATEGIES.iter().zip(&case.ours));
            named.map(|(method, run)| (figure(&case.key, method, ""), run))
        })
    }

    /// The names of the runs whose audit failed, with what is wrong.
    pub fn failed_audits(&self) -> Vec<String> {
        let failed = self.runs().filter(|(_, run)| !run.audit.is_ok());
        failed.map(|(name, run)| format!("{name}: {}", run.audit)).collect()
    }

    /// All is well when all figures agree and all audits pass.
    pub fn outcome(&self) -> Outcome {
        let figures = self.disagreeing().map(Entry::to_string);
        let audits = self.failed_audits().into_iter().map(|failed| format!("audit of {failed}"));
        Outcome::of(figures.chain(audits).collect())
    }
}

/// The name of a figure: `object1_s_gcfa_isp_missed`.
fn figure(case: &str, method: &str, what: &str) -> String {
    let name = format!("{case}_{}_{what}", method.to_lowercase().replace(['-', ' '], "_"));
    name.trim_end_matches('_').to_owned()
}

/// Grows and compares everything.
pub fn run(drawings: Vec<Drawing>, bars: &Bars) -> Result<Results, Failure> {
    let total = drawings.len() as u64;
    let (mut cases, mut entries, mut uniform) = (Vec::new(), Vec::new(), Vec::new());
    for (done, drawing) in (0..).zip(drawings) {
        bars.update("grow", done, total);
        let case = grow_case(drawing)?;
        let (missed, layers) = (thesis::MISSED, thesis::LAYERS);
        for (method, run) in case.theirs.iter().enumerate() {
            let entry = |what: &str, ours: usize, table: [[[usize; 2]; 3]; 6]| Entry {
                key: figure(&case.key, thesis::METHODS[method], what),
                ours,
                thesis: table[case.object][case.platform][method],
            };
            entries.push(entry("missed", run.growth.missed.len(), missed));
            entries.push(entry("layers", run.growth.order.len(), layers));
        }
        // The platform makes no difference to it.
        if case.platform == 0 {
            uniform.push(slice_uniformly(&cells(&case.drawn)?).missed.len());
        }
        cases.push(case);
    }
    for (object, (&ours, thesis)) in uniform.iter().zip(thesis::UNIFORM).enumerate() {
        entries.extend(thesis.map(|thesis| Entry {
            key: format!("object{}_uniform_missed", object + 1),
            ours,
            thesis,
        }));
    }
    Ok(Results { cases, uniform, entries })
}

/// The cells of a drawing.
fn cells(drawn: &TextGrid) -> Result<Cells<'_>, Failure> {
    Ok(Cells::new(drawn.grid.dims(), drawn.grid.rows())?)
}

/// How to come to an order.
#[derive(Clone, Copy)]
enum Way {
    Grow(GrowthOptions),
    /// Adaptively, governed by the peeling field.
    Governed,
    Unbuild,
}

fn grown_with(prevention: Prevention) -> Way {
    Way::Grow(GrowthOptions { prevention, ..GrowthOptions::default() })
}

fn grow_case(drawing: Drawing) -> Result<Case, Failure> {
    let key = drawing.key();
    let Drawing { object, platform, drawn } = drawing;
    let visit = if drawn.flat { Visit::HighestFirst } else { Visit::LowestFirst };
    let as_in_the_thesis =
        |prevention| Way::Grow(GrowthOptions { prevention, candidates: Candidates::OfLastLayer, visit });
    let greedy = by_thesis(&drawn, as_in_the_thesis(Prevention::None))?;
    let isp = by_thesis(&drawn, as_in_the_thesis(Prevention::FewerThanAll))?;
    let unbuilt = by_thesis(&drawn, Way::Unbuild)?;
    let ours = [
        by_default(&drawn, grown_with(Prevention::None))?,
        by_default(&drawn, grown_with(Prevention::Incremental))?,
        by_default(&drawn, grown_with(Prevention::Adaptive))?,
        by_default(&drawn, Way::Governed)?,
        by_default(&drawn, Way::Unbuild)?,
    ];
    Ok(Case { object, platform, key, theirs: [greedy, isp], unbuilt, ours, drawn })
}

/// Grows by the rules of the thesis.
fn by_thesis(drawn: &TextGrid, way: Way) -> Result<Run, Failure> {
    let rules = Rules { eps: 0.0, neighbours: Neighbours::FaceOrEdge, flat: drawn.flat, ..Rules::default() };
    // Half a cell below the plane z = 0 lie the centres of the cells there.
    let platform = platform(drawn, [0.5, 0.5])?.elevated(-1)?;
    grown(drawn, &platform, &rules, way)
}

/// Grows by our default rules: a depth of one cell, a platform that reaches down, with its top under the part and
/// its corners at those of the cells.
fn by_default(drawn: &TextGrid, way: Way) -> Result<Run, Failure> {
    let rules = Rules { flat: drawn.flat, ..Rules::default() };
    grown(drawn, &platform(drawn, [0.0, 1.0])?, &rules, way)
}

/// The hull of the platform's cells, of which each reaches from `low` to `high`.
fn platform(drawn: &TextGrid, [low, high]: [f64; 2]) -> Result<Platform, PlatformError> {
    let along = |axis: usize| drawn.platform.iter().map(move |cell| f64::from(cell[axis]));
    if drawn.flat {
        let (first, last) = along(0).fold((f64::MAX, f64::MIN), |(first, last), x| (first.min(x), last.max(x)));
        return Platform::segment(first + low, last + high);
    }
    let corners = along(0)
        .zip(along(1))
        .flat_map(|(x, y)| [[x + low, y + low], [x + high, y + low], [x + high, y + high], [x + low, y + high]]);
    Platform::polygon(&corners.collect::<Vec<_>>())
}

/// Grows and audits.
fn grown(drawn: &TextGrid, platform: &Platform, rules: &Rules, way: Way) -> Result<Run, Failure> {
    // One of these takes milliseconds.
    let go = |_: Progress| ControlFlow::Continue(());
    let cells = cells(drawn)?;
    let growth = match way {
        Way::Grow(options) => grow(&cells, platform, rules, &options, None, &go)?,
        Way::Governed => {
            let options = GrowthOptions { prevention: Prevention::Adaptive, ..GrowthOptions::default() };
            grow(&cells, platform, rules, &options, Some(&peel(&cells, platform, rules, &go)?), &go)?
        }
        Way::Unbuild => unbuild(&cells, platform, rules, &UnbuildOptions::default(), &go)?,
    };
    let missed = growth.missed_cells();
    let audit = audit(&cells, platform, rules, &growth.order, &missed, &go)?;
    Ok(Run { growth, audit })
}
