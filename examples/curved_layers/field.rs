//! Stage `field`: cells, governing field, growth, audit.

use crate::{Args, failure};
use curvlay_examples::args::{Failure, Part, Prevention as PreventionArg, Strategy};
use curvlay_examples::bars::Bars;
use curvlay_layers::curved::{
    AuditReport, Cells, Growth, GrowthOptions, LayerQuality, Neighbours, Platform, Prevention, Rules, UnbuildOptions,
    audit, grow, layer_quality, peel, unbuild,
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
    pub growth: Growth,
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
fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    (work(), start.elapsed())
}

pub fn run(args: &Args, part: &Part, bars: &Bars) -> Result<FieldRun, Failure> {
    let start = Instant::now();
    let (vertices, triangles) = (&part.mesh.vertices, &part.mesh.triangles);
    let (mesh, inspect_time) = timed(|| inspect(vertices, triangles));
    let mesh = mesh.map_err(|error| failure(format!("{}: {error}", part.name)))?;

    let resolution =
        args.voxel.cell.map_or(Resolution::Count(args.voxel.voxels.unwrap_or(DEFAULT_CELLS)), Resolution::Cell);
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
    let grow_start = Instant::now();
    let (governor, peel_time) = match args.grow.strategy {
        Strategy::Governed => {
            let (field, time) = timed(|| peel(&cells, &platform, &rules, &progress));
            (Some(field.map_err(failure)?), time)
        }
        _ => (None, Duration::ZERO),
    };
    let growth = match args.grow.strategy {
        Strategy::Unbuild => unbuild(&cells, &platform, &rules, &UnbuildOptions::default(), &progress),
        _ => {
            let options = GrowthOptions { prevention: prevention(args), ..GrowthOptions::default() };
            grow(&cells, &platform, &rules, &options, governor.as_ref(), &progress)
        }
    };
    let growth = growth.map_err(failure)?;
    let grow_time = grow_start.elapsed();
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
    Ok(FieldRun { mesh, thin, solid, platform, growth, audit, quality, times, findings })
}

/// The prevention that a strategy stands for.
pub fn prevention(args: &Args) -> Prevention {
    match (args.grow.strategy, args.grow.prevention) {
        (Strategy::Greedy | Strategy::Unbuild, _) => Prevention::None,
        (Strategy::Incremental, _) | (Strategy::Governed, PreventionArg::Incremental) => Prevention::Incremental,
        (Strategy::Adaptive, _) | (Strategy::Governed, PreventionArg::Adaptive) => Prevention::Adaptive,
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
