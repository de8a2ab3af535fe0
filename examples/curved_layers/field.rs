//! Stage `field`: cells, growth, audit. A field that an earlier run has saved takes the place of the growth.

use crate::estimate::{self, Memory};
use crate::failure;
use crate::guide::{GivenDirections, Guide};
use crate::mould::{Mould, Standing};
use crate::surfaces::{self, Made, SurfaceOptions, SurfacesRun};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_examples::clock::StageClock;
use curvlay_examples::mesh::UNCERTAIN_SHARE;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::{SavedField, mesh_stamp};
use curvlay_layers::curved::{
    AuditReport, CompleteOptions, CompletePart, Growth, Guides, Impossible, JudgedByNozzle, LayerQuality, LayersBy,
    Neighbours, NoSupport, NozzleUse, Platform, ProofError, Rules, Strategy, SupportCells, Workpiece,
    audit_with_nozzle, check_impossible, layer_quality, prove_impossible,
};
use curvlay_voxel::inspect::{MeshReport, ThinFeatures, inspect, thinner_than};
use curvlay_voxel::{Resolution, VoxelOptions, Voxelisation, voxelise};
use nalgebra::Point3;
use std::time::{Duration, Instant};

/// What cells the part gets, and how their order is found.
#[derive(Clone, Copy, Debug)]
pub struct FieldOptions {
    /// None for cells that follow from the layer height.
    pub resolution: Option<Resolution>,
    /// Depth inside the hull from which a cell counts as shadowed, in cells.
    pub eps: f64,
    /// Whether a cell at exactly that depth does not count.
    pub beyond_eps: bool,
    pub platform_diameter_mm: f64,
    /// None for the best one.
    pub strategy: Option<Strategy>,
    /// What is done about cells that the order misses.
    pub complete: CompleteOptions,
    /// Layer height, by which the best one is chosen; none for the edge of a cell.
    pub height_mm: Option<f64>,
}

/// Cells that a part gets unless the user says. With more of them layers wait for each other at more places: a hollow bunny of 92 mm has
/// eight times the curves with a million (docs/decisions.md). With fewer cells, thin walls get none.
const CELLS: u64 = 100_000;

/// Large parts get more, so that cells are no higher than this many layers: contours take layers down to a fifth of a cell.
const MAX_LAYERS_OF_CELL: f64 = 4.0;

/// But never more than this: some seconds of growing, and 3 GB.
const MAX_CELLS: u64 = 1_000_000;

/// The cells of a part with layers of a printer: as high as a layer, or higher where they would be too many.
fn cells_for(height_mm: f64, part: &Part) -> Resolution {
    // The part touches about as many as its volume holds and half of its surface.
    let count = |edge: f64| part.mesh.volume() / edge.powi(3) + part.mesh.area() / (2.0 * edge.powi(2));
    let highest_mm = MAX_LAYERS_OF_CELL * height_mm;
    if count(height_mm) <= CELLS as f64 {
        Resolution::Cell(height_mm)
    } else if count(highest_mm) <= CELLS as f64 {
        Resolution::Count(CELLS)
    } else if count(highest_mm) <= MAX_CELLS as f64 {
        Resolution::Cell(highest_mm)
    } else {
        Resolution::Count(MAX_CELLS)
    }
}

/// What came of the stage.
pub struct FieldRun {
    pub mesh: MeshReport,
    /// What is thinner than a cell.
    pub thin: ThinFeatures,
    pub solid: Voxelisation,
    pub platform: Platform,
    /// What the part is built on, if that is not the plate.
    pub mould: Option<Mould>,
    /// Volume of the part that lies in that, more than a cell deep: it is not printed, and no part of `part_mm3`.
    pub buried_mm3: f64,
    pub growth: Growth,
    /// By what the order was found; none for a saved one.
    pub layers_by: Option<LayersBy>,
    /// The strategy that it is by.
    pub strategy: &'static str,
    pub audit: AuditReport,
    /// Cells that the order by the hull rule alone missed, by rising number.
    pub missed_by_hull: Vec<u32>,
    /// Directions that were given, and how far they are followed.
    pub given: Option<GivenDirections>,
    /// How many cells have support since beads of another try lay on nothing above them.
    pub below_beads: usize,
    /// The cells that are support, by rising number, and what straight columns would take.
    pub support: Vec<u32>,
    /// Volume of the support in cells of the part, beside its material.
    pub contact_mm3: f64,
    pub straight_cells: usize,
    /// Why there is no support where cells are missed; a saved field does not say.
    pub no_support: Option<NoSupport>,
    /// Those of the missed ones by the hull rule that no order can build, and whether the proofs hold.
    pub impossible: Vec<Impossible>,
    pub proofs: Result<(), ProofError>,
    pub quality: LayerQuality,
    /// Volume of the part, overlaps of its mesh counted once, and what of it lies in missed cells.
    pub part_mm3: f64,
    /// It is a sum over the cells, since bodies of the mesh pass through each other.
    pub part_is_estimated: bool,
    pub missed_mm3: f64,
    pub times: Times,
}

impl FieldRun {
    /// Share of the part that lies in missed cells.
    pub fn missed_share(&self) -> f64 {
        if self.growth.missed.is_empty() { 0.0 } else { self.missed_mm3 / self.part_mm3 }
    }

    /// Number of cells missed by the hull rule that are not proven to be impossible.
    pub fn undecided(&self) -> usize {
        self.missed_by_hull.len() - self.impossible.len()
    }

    /// Volume of the support, in cubic millimetres.
    pub fn support_mm3(&self) -> f64 {
        self.support.len() as f64 * self.solid.grid.cell_mm().powi(3) + self.contact_mm3
    }

    /// Diameter of the platform as it was used. The disc has corners at both ends of its diameter along x.
    pub fn platform_diameter_mm(&self) -> f64 {
        let xs = self.platform.corners().iter().map(|corner| corner[0]);
        let width = xs.clone().max().unwrap_or(0) - xs.min().unwrap_or(0);
        f64::from(width) / 2.0 * self.solid.grid.cell_mm()
    }
}

/// What layers are made of.
pub struct Given<'a> {
    pub part: &'a Part,
    /// What it is built on, if that is not the plate.
    pub mould: Option<&'a Part>,
    /// What its layers are guided by.
    pub guide: Option<&'a Guide>,
    /// The field, if an earlier run has saved it.
    pub saved: Option<SavedField>,
    /// Places on the plate where beads of an earlier try lay on nothing.
    pub bare: &'a [Point3<f64>],
}

/// How long the steps took.
pub struct Times {
    pub inspect: Duration,
    pub voxelise: Duration,
    pub peel: Duration,
    /// Peeling included, and a second strategy if it was tried.
    pub grow: Duration,
    pub audit: Duration,
    /// Of the proofs that missed cells are impossible, and of their check.
    pub prove: Duration,
    pub check_proofs: Duration,
    /// All of these, and the surfaces: those of the order that was not taken as well.
    pub total: Duration,
}

/// Runs `work` and says how long it took.
fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    (work(), start.elapsed())
}

/// The volume of the part, where its bodies bound it by themselves: none passes through another or lies on it, and what holes there are
/// leave nothing open.
fn exact_volume(part: &Part, mesh: &MeshReport) -> Option<f64> {
    let [holes_mm3, volume_mm3] = [part.orientation.holes_mm3, part.orientation.volume_mm3];
    let faults = [&mesh.crossings, &mesh.repeated, &mesh.inconsistent_edges];
    let is_exact = mesh.contacts_complete && faults.iter().all(|finding| finding.count == 0);
    // Bodies that overlap with a common face do not cross, but touch.
    let is_exact = is_exact && (mesh.touching.count == 0 || mesh.components == 1 + mesh.cavities);
    (is_exact && holes_mm3 <= UNCERTAIN_SHARE * volume_mm3).then_some(volume_mm3)
}

/// Makes the cells and their order, on a mould if there is one, and with options for them the surfaces; of a field that was `saved` if there is one.
pub fn run(
    options: &FieldOptions,
    surfaces: Option<&SurfaceOptions>,
    memory: Memory,
    Given { part, mould, guide, saved, bare }: Given,
    bars: &Bars,
) -> Result<(FieldRun, Option<SurfacesRun>), Failure> {
    let of_part = |error: &dyn std::fmt::Display| failure(format!("{}: {error}", part.name));
    let (vertices, triangles) = (&part.mesh.vertices, &part.mesh.triangles);
    saved
        .iter()
        .try_for_each(|saved| saved.check_mesh(mesh_stamp(vertices, triangles)).map_err(|error| of_part(&error)))?;
    let (mesh, inspect_time) = timed(|| inspect(vertices, triangles));
    let mesh = mesh.map_err(|error| of_part(&error))?;
    let derived = || options.height_mm.map_or(Resolution::Count(CELLS), |height_mm| cells_for(height_mm, part));
    let of_saved = |saved| surfaces::resolution(saved, part, mould.is_some());
    let resolution = saved.as_ref().map(of_saved).or(options.resolution).unwrap_or_else(derived);
    let voxel_options = VoxelOptions { resolution, ..VoxelOptions::default() };
    let (solid, voxelise_time) =
        timed(|| voxelise(vertices, triangles, &voxel_options, &|p| bars.show(p.stage, p.done, p.total)));
    let (solid, platform_mm) = (solid.map_err(|error| of_part(&error))?, options.platform_diameter_mm);
    let (mould, platform, solid, buried) = match mould {
        Some(mould) => {
            let Standing { mould, platform, solid, buried } = Mould::stand(mould, solid, platform_mm)?;
            (Some(mould), Some(platform), solid, buried)
        }
        None => (None, None, solid, Vec::new()),
    };
    let by_hulls = options.complete.nozzle == NozzleUse::Off && options.complete.support.is_none();
    let made = match (surfaces, &saved, options.strategy) {
        (None, Some(_), _) => estimate::Made::CompleteOrder,
        (None, None, Some(_)) if by_hulls => estimate::Made::OrderByHulls,
        (None, None, Some(_)) => estimate::Made::CompleteOrder,
        // The best strategy makes surfaces to choose, where cells are missed.
        _ => estimate::Made::Surfaces,
    };
    memory.holds_cells(solid.grid.dims(), solid.grid.count(), made)?;
    let (thin, thin_time) = timed(|| thinner_than(vertices, triangles, solid.grid.cell_mm()));
    let thin = thin.map_err(|error| of_part(&error))?;

    let (cells, cell_mm) = (Cells::new(solid.grid.dims(), solid.grid.rows())?, solid.grid.cell_mm());
    saved.iter().try_for_each(|saved| saved.check_cells(&cells, solid.grid.origin()))?;
    let platform = match platform {
        Some(platform) => platform,
        None => Platform::under(&cells, platform_mm / 2.0 / cell_mm).map_err(|_| {
            of_part(&format!(
                "the part and a platform of {platform_mm} mm are too large for cells of {cell_mm} mm: take larger cells, or \
                 check --unit"
            ))
        })?,
    };
    let shifted: Vec<Point3<f64>> = vertices.iter().map(|vertex| vertex + solid.shift).collect();
    let mut workpiece = Workpiece {
        vertices: &shifted,
        triangles,
        cells,
        cell_mm,
        origin: solid.grid.origin(),
        platform: &platform,
        rules: Rules { eps: options.eps, eps_is_inside: !options.beyond_eps, ..Rules::default() },
        volume_mm3: mesh.volume_mm3(),
        guides: Guides::default(),
    };
    let clock = StageClock::default();
    let progress = |p: curvlay_layers::Progress| {
        clock.note(p.stage, p.done);
        bars.show(p.stage, p.done, p.total)
    };
    if let Some(exact_mm3) = exact_volume(part, &mesh) {
        workpiece.volume_mm3 = exact_mm3;
    } else {
        clock.note("volume", 0);
        let all: Vec<u32> = cells.iter().collect();
        workpiece.volume_mm3 = workpiece.volume_of(&all, &progress).map_err(|error| surfaces::failed(error, part))?;
    }
    let layers_failed = |error| surfaces::failed(error, part);
    let buried_mm3 = workpiece.volume_of(&buried, &progress).map_err(layers_failed)?;
    workpiece.volume_mm3 -= buried_mm3;
    let complete = &options.complete;
    let height_mm = surfaces.map_or(options.height_mm, |surfaces| surfaces.height_mm).unwrap_or(cell_mm);
    clock.note("grow", 0);
    let below = workpiece.cells_below(bare).map_err(layers_failed)?;
    workpiece.guides.support = &below;
    let guided = guide.map(|guide| guide.in_cells(&workpiece, solid.shift, complete)).transpose()?.unwrap_or_default();
    workpiece.guides.heights = guided.heights.as_deref();
    workpiece.guides.directions = guided.directions.as_deref();
    let (mut support, mut contact, mut straight_cells) = (Vec::new(), Vec::new(), 0);
    let (mut no_support, mut layers_by) = (None, None);
    let (growth, missed_by_hull, strategy, audit, made) = if let Some(saved) = saved {
        let growth = saved.growth()?;
        (support, contact) = (saved.aids.support.clone(), saved.aids.contact.clone());
        let steps = saved.field.steps_per_layer();
        let judged = JudgedByNozzle { rule: saved.aids.rule, cell_mm, steps, cells: &growth.nozzle };
        let missed = growth.missed_cells();
        clock.note("audit", 0);
        let order = saved.field.order();
        let audit =
            audit_with_nozzle(&saved.cells()?, &platform, &workpiece.rules, &judged, &order, &missed, &progress)
                .map_err(failure)?;
        let layers = surfaces.map(|_| {
            let cells = SupportCells { cells: &support, contact: &contact };
            workpiece.surfaces_and_support(&saved.field, &saved.rows, cells, &missed, height_mm, &progress)
        });
        let layers = layers.transpose().map_err(layers_failed)?;
        let made = layers.map(|(layers, support)| {
            let SavedField { field, aids, .. } = saved;
            Made { layers, support, field, aids, method: "saved".to_owned(), waits: 0 }
        });
        (growth, missed, "saved", audit, made)
    } else {
        let order =
            workpiece.complete_order(options.strategy, height_mm, complete, &progress).map_err(layers_failed)?;
        (no_support, layers_by) = (order.no_support, Some(order.layers_by));
        if let Some(supported) = &order.supported {
            (support, contact) = (supported.support.clone(), supported.contact.clone());
            straight_cells = supported.straight_cells;
        }
        let name = match order.layers_by {
            LayersBy::Distance => "distance",
            LayersBy::Directed => "directed",
            _ => order.strategy.name(),
        };
        let (audit, missed) = (order.audit.clone(), order.missed_by_hull.clone());
        // There are no layers of an order that fails its audit.
        let (growth, made) = match surfaces.filter(|_| order.audit.is_ok()) {
            Some(surfaces) => {
                let made = if surfaces.coherent {
                    workpiece.coherent_layers_of_complete(order, height_mm, complete, &progress)
                } else {
                    workpiece.layers_of_complete(order, height_mm, complete, &progress)
                };
                let CompletePart { layered, support, .. } = made.map_err(layers_failed)?;
                (layered.growth.clone(), Some(Made::of(layered, support, complete.rule)))
            }
            None => (order.supported.map_or(order.growth, |supported| supported.growth), None),
        };
        (growth, missed, name, audit, made)
    };
    clock.note("impossible", 0);
    let impossible = prove_impossible(&cells, &platform, &workpiece.rules, &missed_by_hull, &progress)?;
    clock.note("check", 0);
    let proofs = check_impossible(&cells, &platform, &workpiece.rules, &impossible);
    clock.stop();
    let finish = |(made, options)| surfaces::finish(options, made, &workpiece, &growth, part, &clock);
    let surfaces = made.zip(surfaces).map(finish).transpose()?;
    let [peel, grow, audit_time, prove, check_proofs] = [
        &["peel"][..],
        &["grow", "distance", "peel", "unbuild", "nozzle", "support"],
        &["audit"],
        &["impossible"],
        &["check"],
    ]
    .map(|stages| clock.on_the_clock(stages));
    let inspect_time = inspect_time + thin_time;
    let surfaces_time = clock.on_the_clock(&["uniform", "audit uniform", "coherent", "contour", "trim", "spacing"]);
    let total = inspect_time + voxelise_time + grow + audit_time + prove + check_proofs + surfaces_time;
    let times = Times {
        inspect: inspect_time,
        voxelise: voxelise_time,
        peel,
        grow,
        audit: audit_time,
        prove,
        check_proofs,
        total,
    };
    let quality = layer_quality(&cells, &growth.order, Neighbours::FaceOrEdge);
    let (part_mm3, part_is_estimated) = (workpiece.volume_mm3, exact_volume(part, &mesh).is_none());
    let missed_mm3 = match &surfaces {
        Some(surfaces) => surfaces.missed_mm3,
        None => workpiece.volume_of(&growth.missed_cells(), &progress).map_err(layers_failed)?,
    };
    let contact_mm3 =
        contact.len() as f64 * cell_mm.powi(3) - workpiece.volume_of(&contact, &progress).map_err(layers_failed)?;
    let field = FieldRun {
        mesh,
        thin,
        solid,
        platform,
        mould,
        buried_mm3,
        growth,
        layers_by,
        strategy,
        audit,
        missed_by_hull,
        given: guided.given,
        below_beads: below.len(),
        support,
        contact_mm3,
        straight_cells,
        no_support,
        impossible,
        proofs,
        quality,
        part_mm3,
        part_is_estimated,
        missed_mm3,
        times,
    };
    Ok((field, surfaces))
}
