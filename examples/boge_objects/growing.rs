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

pub use super::grown::Run;
use super::hardware::Hardware;
use super::objects::Drawing;
use super::rating::Rating;
use super::thesis;
use curvlay_examples::args::{Failure, Outcome};
use curvlay_examples::bars::Bars;
use curvlay_layers::Progress;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{
    Candidates, GrowthOptions, Neighbours, Platform, Prevention, Rules, UnbuildOptions, Visit, audit, grow, peel,
    unbuild,
};
use curvlay_layers::planar::{UniformSlicing, slice_uniformly};
use curvlay_voxel::TextGrid;
use std::fmt;
use std::ops::ControlFlow;

/// Our strategies, as `curved_layers` calls them.
pub const STRATEGIES: [&str; 5] = ["greedy", "incremental", "adaptive", "governed", "unbuild"];

/// Un-building by the rules of the thesis.
pub const UNBUILT: &str = "unbuild by her rules";

/// An object grown in all ways on one platform.
pub struct Ways {
    /// By the rules of the thesis, in the order of [`thesis::METHODS`].
    pub theirs: [Run; 2],
    /// By the rules of the thesis, un-built.
    pub unbuilt: Run,
    /// By our default rules, in the order of [`STRATEGIES`].
    pub ours: [Run; 5],
}

impl Ways {
    /// All runs with the names of their methods.
    pub fn runs(&self) -> impl Iterator<Item = (&'static str, &Run)> {
        let theirs = thesis::METHODS.into_iter().zip(&self.theirs);
        theirs.chain([(UNBUILT, &self.unbuilt)]).chain(STRATEGIES.into_iter().zip(&self.ours))
    }
}

/// An object on a platform, grown in all ways.
pub struct Case {
    pub object: usize,
    pub platform: usize,
    /// Begins the names of its figures.
    pub key: String,
    pub drawn: TextGrid,
    pub ways: Ways,
    pub tuned: Tuned,
    /// Its levels as layers.
    pub sliced: UniformSlicing,
}

/// GCFA-ISP with the threshold that misses least: section 6.2.5.
pub struct Tuned {
    pub threshold: u32,
    pub run: Run,
}

/// Thresholds that are tried where none is given.
const THRESHOLDS: [u32; 17] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 24, 32, 48, 64, 96, 128, 192];

/// An object on what a set of hardware makes of its small platform.
pub struct OnHardware {
    pub object: usize,
    pub hardware: Hardware,
    pub ways: Ways,
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
    /// The threshold that was given, if one was.
    pub threshold: Option<u32>,
    /// The 77 figures of the tables.
    pub entries: Vec<Entry>,
    /// Object after object, in each the sets of [`Hardware::ALL`].
    pub hardware: Vec<OnHardware>,
}

impl Results {
    /// The figures that are not those of the thesis.
    pub fn disagreeing(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(|entry| entry.ours != entry.thesis)
    }

    /// All runs on the three platforms under their names.
    pub fn runs(&self) -> impl Iterator<Item = (String, &Run)> {
        let named = |case: &'_ Case, method: &str| figure(&case.key, method, "");
        self.cases.iter().flat_map(move |case| case.ways.runs().map(move |(method, run)| (named(case, method), run)))
    }

    /// All runs on what hardware makes of the small platform.
    pub fn runs_on_hardware(&self) -> impl Iterator<Item = (String, &Run)> {
        self.hardware.iter().flat_map(|on| {
            let key = format!("object{}_{}", on.object + 1, on.hardware.key());
            on.ways.runs().map(move |(method, run)| (figure(&key, method, ""), run))
        })
    }

    /// Runs with tuned thresholds.
    pub fn tuned_runs(&self) -> impl Iterator<Item = (String, &Run)> {
        self.cases.iter().map(|case| (figure(&case.key, "gcfa_isp_tuned", ""), &case.tuned.run))
    }

    /// All runs; each has its audit.
    pub fn audited(&self) -> impl Iterator<Item = (String, &Run)> {
        self.runs().chain(self.runs_on_hardware()).chain(self.tuned_runs())
    }

    /// Verdicts of Table 6.4 that are not those of the thesis, in words.
    pub fn other_ratings(&self) -> Vec<String> {
        let mut other = Vec::new();
        for case in &self.cases {
            for (method, run) in case.ways.theirs.iter().enumerate() {
                let (ours, thesis) =
                    (Rating::of(run, &case.drawn), thesis::RATINGS[case.object][case.platform][method]);
                if ours != thesis {
                    let key = figure(&case.key, thesis::METHODS[method], "rating");
                    other.push(format!("{key}: {ours}, in the thesis {thesis}"));
                }
            }
        }
        other
    }

    /// The names of the runs whose audit failed, with what is wrong.
    pub fn failed_audits(&self) -> Vec<String> {
        let failed = self.audited().filter(|(_, run)| !run.audit.is_ok());
        failed.map(|(name, run)| format!("{name}: {}", run.audit)).collect()
    }

    /// All is well when all figures and verdicts agree and all audits pass.
    pub fn outcome(&self) -> Outcome {
        let figures = self.disagreeing().map(Entry::to_string);
        let audits = self.failed_audits().into_iter().map(|failed| format!("audit of {failed}"));
        Outcome::of(figures.chain(self.other_ratings()).chain(audits).collect())
    }
}

/// The name of a figure: `object1_s_gcfa_isp_missed`.
pub fn figure(case: &str, method: &str, what: &str) -> String {
    let name = format!("{case}_{}_{what}", method.to_lowercase().replace(['-', ' '], "_"));
    name.trim_end_matches('_').to_owned()
}

/// Grows and compares everything.
pub fn run(drawings: Vec<Drawing>, threshold: Option<u32>, bars: &Bars) -> Result<Results, Failure> {
    let total = drawings.len() as u64;
    let (mut cases, mut entries, mut uniform) = (Vec::new(), Vec::new(), Vec::new());
    let mut hardware = Vec::new();
    for (done, drawing) in (0..).zip(drawings) {
        bars.update("grow", done, total);
        let case = grow_case(drawing, threshold)?;
        let (missed, layers) = (thesis::MISSED, thesis::LAYERS);
        for (method, run) in case.ways.theirs.iter().enumerate() {
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
            uniform.push(case.sliced.missed.len());
            for set in Hardware::ALL {
                hardware.push(OnHardware { object: case.object, hardware: set, ways: grow_on(&case.drawn, set)? });
            }
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
    Ok(Results { cases, uniform, threshold, entries, hardware })
}

/// The levels of a drawing as layers.
pub fn sliced(drawn: &TextGrid) -> Result<UniformSlicing, Failure> {
    Ok(slice_uniformly(&cells(drawn)?))
}

/// Grows by GCFA-ISP with a threshold, or with the one that misses least, then has the fewest layers, of those that are tried.
pub fn tuned(drawn: &TextGrid, hardware: Hardware, threshold: Option<u32>) -> Result<Tuned, Failure> {
    let thesis = Thesis::of(drawn, hardware)?;
    let mut best: Option<Tuned> = None;
    for &threshold in threshold.as_ref().map_or(&THRESHOLDS[..], std::slice::from_ref) {
        let run = thesis.grown(drawn, Prevention::FewerThan(threshold))?;
        let count = |run: &Run| (run.growth.missed.len(), run.growth.order.len());
        if best.as_ref().is_none_or(|best| count(&run) < count(&best.run)) {
            best = Some(Tuned { threshold, run });
        }
    }
    best.ok_or_else(|| Failure::new("no threshold was tried"))
}

/// The rules of the thesis for a drawing.
struct Thesis {
    platform: Platform,
    rules: Rules,
    visit: Visit,
}

impl Thesis {
    fn of(drawn: &TextGrid, hardware: Hardware) -> Result<Self, Failure> {
        let rules =
            Rules { inside_depth_cells: 0.0, neighbours: Neighbours::FaceOrEdge, flat: drawn.flat, ..Rules::default() };
        let visit = if drawn.flat { Visit::HighestFirst } else { Visit::LowestFirst };
        Ok(Thesis { platform: hardware.platform_of_thesis(drawn)?, rules, visit })
    }

    fn grown(&self, drawn: &TextGrid, prevention: Prevention) -> Result<Run, Failure> {
        let options = GrowthOptions { prevention, candidates: Candidates::OfLastLayer, visit: self.visit };
        grown(drawn, &self.platform, &self.rules, Way::Grow(options))
    }
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

fn grow_case(drawing: Drawing, threshold: Option<u32>) -> Result<Case, Failure> {
    let key = drawing.key();
    let Drawing { object, platform, drawn } = drawing;
    let ways = grow_on(&drawn, Hardware::InHand)?;
    let (tuned, sliced) = (tuned(&drawn, Hardware::InHand, threshold)?, sliced(&drawn)?);
    Ok(Case { object, platform, key, ways, tuned, sliced, drawn })
}

/// Grows an object in all ways, on what a set of hardware makes of its platform.
pub fn grow_on(drawn: &TextGrid, hardware: Hardware) -> Result<Ways, Failure> {
    let (thesis, own) = (Thesis::of(drawn, hardware)?, hardware.platform_of_ours(drawn)?);
    // By the rules of the thesis, and by our default rules: a depth of one cell.
    let by_default = Rules { flat: drawn.flat, ..Rules::default() };
    let ours = |way| grown(drawn, &own, &by_default, way);
    Ok(Ways {
        theirs: [thesis.grown(drawn, Prevention::None)?, thesis.grown(drawn, Prevention::FewerThanAll)?],
        unbuilt: grown(drawn, &thesis.platform, &thesis.rules, Way::Unbuild)?,
        ours: [
            ours(grown_with(Prevention::None))?,
            ours(grown_with(Prevention::Incremental))?,
            ours(grown_with(Prevention::Adaptive))?,
            ours(Way::Governed)?,
            ours(Way::Unbuild)?,
        ],
    })
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
