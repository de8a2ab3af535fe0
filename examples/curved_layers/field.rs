//! Stage `field`: cells, growth, audit. A field that an earlier run has saved takes the place of the growth.

use crate::{Args, failure};
use curvlay_examples::args::{Failure, Part, Prevention as PreventionArg, Strategy};
use curvlay_examples::bars::Bars;
use curvlay_layers::curved::surface::SavedField;
use curvlay_layers::curved::{
    AuditReport, Cells, Growth, GrowthOptions, GrowthStatistics, LayerQuality, MissedCell, MissedReason, Neighbours,
    Platform, Prevention, Rules, UnbuildOptions, audit, grow, layer_quality, peel, unbuild,
};
use curvlay_voxel::inspect::{MeshReport, ThinFeatures, inspect, thinner_than};
use curvlay_voxel::{Resolution, VoxelOptions, Voxelisation, voxelise};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// How many cells a part gets unless the user says.
const DEFAULT_CELLS: u64 = 100_000;

/// From this share of the surface on thin walls are worth a word: sharp edges alone make up some tenths of a percent.
const NOTABLE_SHARE: f64 = 0.01;

/// What came of the stage.
pub struct FieldRun {
    pub mesh: MeshReport,
    /// What is thinner than a cell.
    pub thin: ThinFeatures,
    pub solid: Voxelisation,
    pub platform: Platform,
    pub rules: Rules,
    pub growth: Growth,
    /// The strategy that the order is by.
    pub strategy: &'static str,
    pub audit: AuditReport,
    pub quality: LayerQuality,
    pub times: Times,
    /// What the user should know about the mesh, a line each.
    pub findings: Vec<String>,
}

impl FieldRun {
    /// Diameter of the platform as it was used. The disc has corners at both ends of its diameter along x.
    pub fn platform_diameter_mm(&self) -> f64 {
        let xs = self.platform.corners().iter().map(|corner| corner[0]);
        let width = xs.clone().max().unwrap_or(0) - xs.min().unwrap_or(0);
        f64::from(width) / 2.0 * self.solid.grid.cell_mm()
    }
}

/// How long the steps took.
pub struct Times {
    pub inspect: Duration,
    pub voxelise: Duration,
    pub peel: Duration,
    /// Peeling included.
    pub grow: Duration,
    pub audit: Duration,
    /// All of these.
    pub total: Duration,
}

/// Runs `work` and says how long it took.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    (work(), start.elapsed())
}

/// Runs the stage by one strategy, or with a field that was `saved`.
pub fn run(
    args: &Args,
    part: &Part,
    strategy: Strategy,
    saved: Option<&SavedField>,
    bars: &Bars,
) -> Result<FieldRun, Failure> {
    let start = Instant::now();
    let (vertices, triangles) = (&part.mesh.vertices, &part.mesh.triangles);
    let (mesh, inspect_time) = timed(|| inspect(vertices, triangles));
    let mesh = mesh.map_err(|error| failure(format!("{}: {error}", part.name)))?;

    let wanted = Resolution::Count(args.voxel.voxels.unwrap_or(DEFAULT_CELLS));
    let resolution = saved.map(|saved| saved.cell_mm).or(args.voxel.cell).map_or(wanted, Resolution::Cell);
    let options = VoxelOptions { resolution, ..VoxelOptions::default() };
    let (solid, voxelise_time) = timed(|| {
        voxelise(vertices, triangles, &options, &|p| {
            bars.update(p.stage, p.done, p.total);
            ControlFlow::Continue(())
        })
    });
    let solid = solid.map_err(|error| failure(format!("{}: {error}", part.name)))?;

    let (thin, thin_time) = timed(|| thinner_than(vertices, triangles, solid.grid.cell_mm()));
    let thin = thin.map_err(|error| failure(format!("{}: {error}", part.name)))?;

    let progress = |p: curvlay_layers::Progress| {
        bars.update(p.stage, p.done, p.total);
        ControlFlow::Continue(())
    };
    let cells = Cells::new(solid.grid.dims(), solid.grid.rows()).map_err(failure)?;
    if saved.is_some_and(|saved| saved.field.dims() != cells.dims() || saved.rows != cells.rows()) {
        return Err(failure("the saved field is of other cells than the mesh gives: grow it anew"));
    }
    let rules = Rules { eps: args.grow.eps, ..Rules::default() };
    let radius = args.grow.platform_diameter_mm / 2.0 / solid.grid.cell_mm();
    let platform = Platform::under(&cells, radius).map_err(|_| {
        failure(format!(
            "{}: the part and a platform of {} mm are too large for cells of {} mm: take larger cells, or check --unit",
            part.name,
            args.grow.platform_diameter_mm,
            solid.grid.cell_mm()
        ))
    })?;
    let grower = Grower { args, cells: &cells, platform: &platform, rules: &rules, progress: &progress };
    let (grown, grow_time) = timed(|| match saved {
        Some(saved) => Ok(Grown { growth: taken_up(&cells, saved), by: "saved", peel: Duration::ZERO }),
        None => grower.grow(strategy),
    });
    let Grown { growth, by, peel: peel_time } = grown?;
    let missed: Vec<u32> = growth.missed.iter().map(|missed| missed.cell).collect();
    let (audit, audit_time) = timed(|| audit(&cells, &platform, &rules, &growth.order, &missed, &progress));
    let audit = audit.map_err(failure)?;
    let times = Times {
        inspect: inspect_time + thin_time,
        voxelise: voxelise_time,
        peel: peel_time,
        grow: grow_time,
        audit: audit_time,
        total: start.elapsed(),
    };
    let quality = layer_quality(&cells, &growth.order, Neighbours::FaceOrEdge);
    let findings = findings(&mesh, &thin, &solid);
    Ok(FieldRun { mesh, thin, solid, platform, rules, growth, strategy: by, audit, quality, times, findings })
}

/// The order that a saved field stands for.
fn taken_up(cells: &Cells, saved: &SavedField) -> Growth {
    let without = cells.iter().filter(|&cell| saved.field.value(cell).is_none());
    let missed = without.map(|cell| MissedCell { cell, reason: MissedReason::SupportMissed }).collect();
    Growth { order: saved.field.rounded(), missed, statistics: GrowthStatistics::default() }
}

/// Grows by any strategy.
struct Grower<'a> {
    args: &'a Args,
    cells: &'a Cells<'a>,
    platform: &'a Platform,
    rules: &'a Rules,
    progress: &'a (dyn Fn(curvlay_layers::Progress) -> ControlFlow<()> + Sync),
}

/// An order, the strategy that it is by, and how long peeling took.
struct Grown {
    growth: Growth,
    by: &'static str,
    peel: Duration,
}

impl Grower<'_> {
    fn grow(&self, strategy: Strategy) -> Result<Grown, Failure> {
        let Grower { cells, platform, rules, progress, .. } = *self;
        match strategy {
            Strategy::Greedy => self.with("greedy", Prevention::None),
            Strategy::Best | Strategy::Incremental => self.with("incremental", Prevention::Incremental),
            Strategy::Adaptive => self.with("adaptive", Prevention::Adaptive),
            Strategy::Governed => {
                let (field, peel) = timed(|| peel(cells, platform, rules, progress));
                let options = GrowthOptions { prevention: governed_prevention(self.args), ..GrowthOptions::default() };
                let growth = grow(cells, platform, rules, &options, Some(&field.map_err(failure)?), progress);
                Ok(Grown { growth: growth.map_err(failure)?, by: "governed", peel })
            }
            Strategy::Unbuild => {
                let growth = unbuild(cells, platform, rules, &UnbuildOptions::default(), progress);
                Ok(Grown { growth: growth.map_err(failure)?, by: "unbuild", peel: Duration::ZERO })
            }
        }
    }

    fn with(&self, by: &'static str, prevention: Prevention) -> Result<Grown, Failure> {
        let options = GrowthOptions { prevention, ..GrowthOptions::default() };
        let growth = grow(self.cells, self.platform, self.rules, &options, None, self.progress);
        Ok(Grown { growth: growth.map_err(failure)?, by, peel: Duration::ZERO })
    }
}

/// How the governed strategy keeps cells from being shadowed.
fn governed_prevention(args: &Args) -> Prevention {
    match args.grow.prevention {
        PreventionArg::Incremental => Prevention::Incremental,
        PreventionArg::Adaptive => Prevention::Adaptive,
    }
}

/// What is wrong with the mesh and what became of it.
fn findings(mesh: &MeshReport, thin: &ThinFeatures, solid: &Voxelisation) -> Vec<String> {
    let report = &solid.report;
    let mut findings = Vec::new();
    if !mesh.is_sound() {
        findings.extend(mesh.to_string().lines().map(str::to_owned));
    }
    if report.dropped_triangles > 0 {
        findings.push(format!("{} triangles without area were dropped", report.dropped_triangles));
    }
    if thin.share > NOTABLE_SHARE {
        findings.push(format!(
            "{:.1} % of the surface belongs to walls thinner than a cell of {:.3} mm: they come out a cell thick",
            100.0 * thin.share,
            solid.grid.cell_mm()
        ));
    }
    if report.leak_faces > 0 {
        findings.push(format!(
            "the mesh has holes wider than a cell: {} cells near them were decided one by one by winding number",
            report.cells_asked_singly
        ));
    }
    if report.inside_out {
        findings.push("the faces point inwards: the part was taken as turned the right way round".to_owned());
    }
    findings
}
