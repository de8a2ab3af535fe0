//! Stage `field`: cells, growth, audit. A field that an earlier run has saved takes the place of the growth.

use crate::estimate::{self, Memory};
use crate::failure;
use crate::guide::{GivenDirections, Guide};
use crate::mould::{Mould, Standing};
use crate::order::Ordered;
use crate::surfaces::{self, SurfaceOptions, SurfacesRun};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_examples::clock::StageClock;
use curvlay_examples::mesh::UNCERTAIN_SHARE;
use curvlay_layers::ProgressFn;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::{SavedField, mesh_stamp};
use curvlay_layers::curved::{
    AuditReport, Growth, Guides, Impossible, LayerOptions, LayerQuality, LayersBy, LayersError, Neighbours, NoSupport,
    NozzleUse, Platform, ProofError, Rules, Workpiece, check_impossible, layer_quality, prove_impossible,
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
    /// How the part is layered; the height is that of a printer's layers, if the cells are to follow from it.
    pub layers: LayerOptions,
}

/// Cells that a part gets unless the user says. With more of them layers wait for each other at more places: a hollow bunny of 92 mm has
/// eight times the curves with a million (docs/decisions/02-voxels.md). With fewer cells, thin walls get none.
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
    /// How many cells have support since beads of another try above them were unsupported.
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
    /// Places on the plate where beads of an earlier try were unsupported.
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

impl Times {
    /// The times of a run whose stages a clock has noted.
    fn of(clock: &StageClock, inspect: Duration, voxelise: Duration) -> Self {
        let [peel, grow, audit, prove, check_proofs, surfaces] = [
            &["peel"][..],
            &["grow", "distance", "peel", "unbuild", "nozzle", "support"],
            &["audit"],
            &["impossible"],
            &["check"],
            &["uniform", "audit uniform", "coherent", "contour", "trim", "spacing"],
        ]
        .map(|stages| clock.on_the_clock(stages));
        let total = inspect + voxelise + grow + audit + prove + check_proofs + surfaces;
        Times { inspect, voxelise, peel, grow, audit, prove, check_proofs, total }
    }
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

/// The part in cells, and what it stands on.
struct PartInCells {
    solid: Voxelisation,
    platform: Option<Platform>,
    mould: Option<Mould>,
    /// Cells that lie deep in the mould.
    buried: Vec<u32>,
}

impl PartInCells {
    /// Cells of the size that a saved field has, or the user asks for, or that follows from the layer height; without those in the mould.
    fn new(options: &FieldOptions, given: &Given, bars: &Bars) -> Result<Self, Failure> {
        let Given { part, mould, saved, .. } = given;
        let derived =
            || options.layers.height_mm.map_or(Resolution::Count(CELLS), |height_mm| cells_for(height_mm, part));
        let of_saved = |saved| surfaces::resolution(saved, part, mould.is_some());
        let resolution = saved.as_ref().map(of_saved).or(options.resolution).unwrap_or_else(derived);
        let voxel_options = VoxelOptions { resolution, ..VoxelOptions::default() };
        let progress = |p: curvlay_voxel::Progress| bars.show(p.stage, p.done, p.total);
        let solid = voxelise(&part.mesh.vertices, &part.mesh.triangles, &voxel_options, &progress)
            .map_err(|error| of_part(part, error))?;
        let Some(mould) = mould else {
            return Ok(PartInCells { solid, platform: None, mould: None, buried: Vec::new() });
        };
        let Standing { mould, platform, solid, buried } = Mould::stand(mould, solid, options.platform_diameter_mm)?;
        Ok(PartInCells { solid, platform: Some(platform), mould: Some(mould), buried })
    }
}

/// The platform: the one with the mould, or a disc under the part.
fn platform_of(
    with_mould: Option<Platform>,
    cells: &Cells,
    cell_mm: f64,
    diameter_mm: f64,
    part: &Part,
) -> Result<Platform, Failure> {
    if let Some(platform) = with_mould {
        return Ok(platform);
    }
    Platform::under(cells, diameter_mm / 2.0 / cell_mm).map_err(|_| {
        let what = format!("the part and a platform of {diameter_mm} mm are too large for cells of {cell_mm} mm");
        of_part(part, format!("{what}: take larger cells, or check --unit"))
    })
}

/// An error that names the part.
fn of_part(part: &Part, error: impl std::fmt::Display) -> Failure {
    failure(format!("{}: {error}", part.name))
}

/// What is made of the cells before there are paths: it decides how much memory the run takes.
fn made(options: &FieldOptions, surfaces: Option<&SurfaceOptions>, is_saved: bool) -> estimate::Made {
    let LayerOptions { nozzle, support, strategy, .. } = options.layers;
    match (surfaces, is_saved, strategy) {
        (None, true, _) => estimate::Made::CompleteOrder,
        (None, false, Some(_)) if nozzle == NozzleUse::Off && support.is_none() => estimate::Made::OrderByHulls,
        (None, false, Some(_)) => estimate::Made::CompleteOrder,
        // The best strategy makes surfaces to choose, where cells are missed.
        _ => estimate::Made::Surfaces,
    }
}

/// Makes the cells and their order, on a mould if there is one, and with options for them the surfaces; of a field that was `saved` if there is one.
pub fn run(
    options: &FieldOptions,
    surfaces: Option<&SurfaceOptions>,
    memory: Memory,
    mut given: Given,
    bars: &Bars,
) -> Result<(FieldRun, Option<SurfacesRun>), Failure> {
    let part = given.part;
    let (vertices, triangles) = (&part.mesh.vertices, &part.mesh.triangles);
    let of_mesh = |saved: &SavedField| saved.check_mesh(mesh_stamp(vertices, triangles));
    given.saved.iter().try_for_each(of_mesh).map_err(|error| of_part(part, error))?;
    let (mesh, inspect_time) = timed(|| inspect(vertices, triangles));
    let mesh = mesh.map_err(|error| of_part(part, error))?;
    let (in_cells, voxelise_time) = timed(|| PartInCells::new(options, &given, bars));
    let PartInCells { solid, platform, mould, buried } = in_cells?;
    let grid = &solid.grid;
    memory.holds_cells(grid.dims(), grid.count(), made(options, surfaces, given.saved.is_some()))?;
    let (thin, thin_time) = timed(|| thinner_than(vertices, triangles, grid.cell_mm()));
    let thin = thin.map_err(|error| of_part(part, error))?;

    let cells = Cells::new(grid.dims(), grid.rows())?;
    given.saved.iter().try_for_each(|saved| saved.check_cells(&cells, grid.origin()))?;
    let platform = platform_of(platform, &cells, grid.cell_mm(), options.platform_diameter_mm, part)?;
    let shifted: Vec<Point3<f64>> = vertices.iter().map(|vertex| vertex + solid.shift).collect();
    let mut workpiece = Workpiece {
        vertices: &shifted,
        triangles,
        cells,
        cell_mm: grid.cell_mm(),
        origin: grid.origin(),
        platform: &platform,
        rules: Rules { inside_depth_cells: options.eps, boundary_is_inside: !options.beyond_eps, ..Rules::default() },
        volume_mm3: mesh.volume_mm3(),
        guides: Guides::default(),
    };
    let clock = StageClock::default();
    let progress = |p: curvlay_layers::Progress| {
        clock.note(p.stage, p.done);
        bars.show(p.stage, p.done, p.total)
    };
    let layers_failed = |error| surfaces::failed(error, part);
    let exact_mm3 = exact_volume(part, &mesh);
    let buried_mm3 = measure(&mut workpiece, exact_mm3, &buried, &clock, &progress).map_err(layers_failed)?;
    let layers = LayerOptions {
        height_mm: surfaces.map_or(options.layers.height_mm, |surfaces| surfaces.height_mm),
        coherent: surfaces.is_some_and(|surfaces| surfaces.coherent),
        ..options.layers
    };
    clock.note("grow", 0);
    let below = workpiece.cells_below(given.bare).map_err(layers_failed)?;
    workpiece.guides.support = &below;
    let guided = given.guide.map(|guide| guide.in_cells(&workpiece, solid.shift, &layers)).transpose()?;
    let guided = guided.unwrap_or_default();
    workpiece.guides.heights = guided.heights.as_deref();
    workpiece.guides.directions = guided.directions.as_deref();
    let makes_surfaces = surfaces.is_some();
    let mut ordered = match given.saved.take() {
        Some(saved) => Ordered::saved(saved, &workpiece, &layers, makes_surfaces, (part, &clock), &progress)?,
        None => Ordered::grown(&workpiece, &layers, makes_surfaces, part, &progress)?,
    };
    let made = ordered.made.take();
    let Ordered { growth, missed_by_hull, contact, .. } = &ordered;
    clock.note("impossible", 0);
    let impossible = prove_impossible(&cells, &platform, &workpiece.rules, missed_by_hull, &progress)?;
    clock.note("check", 0);
    let proofs = check_impossible(&cells, &platform, &workpiece.rules, &impossible);
    clock.stop();
    let finish = |(made, options)| surfaces::finish(options, made, &workpiece, growth, part, &clock);
    let surfaces = made.zip(surfaces).map(finish).transpose()?;
    let times = Times::of(&clock, inspect_time + thin_time, voxelise_time);
    let missed_mm3 = match &surfaces {
        Some(surfaces) => surfaces.missed_mm3,
        None => workpiece.volume_of(&growth.missed_cells(), &progress).map_err(layers_failed)?,
    };
    let contact_cells_mm3 = contact.len() as f64 * grid.cell_mm().powi(3);
    let contact_mm3 = contact_cells_mm3 - workpiece.volume_of(contact, &progress).map_err(layers_failed)?;
    let quality = layer_quality(&cells, &growth.order, Neighbours::FaceOrEdge);
    let field = FieldRun {
        mesh,
        thin,
        quality,
        part_mm3: workpiece.volume_mm3,
        part_is_estimated: exact_mm3.is_none(),
        mould,
        buried_mm3,
        growth: ordered.growth,
        layers_by: ordered.layers_by,
        strategy: ordered.strategy,
        audit: ordered.audit,
        missed_by_hull: ordered.missed_by_hull,
        given: guided.given,
        below_beads: below.len(),
        support: ordered.support,
        contact_mm3,
        straight_cells: ordered.straight_cells,
        no_support: ordered.no_support,
        impossible,
        proofs,
        missed_mm3,
        times,
        solid,
        platform,
    };
    Ok((field, surfaces))
}

/// Measures the volume of the part, which is that of its mesh if that is exact, and takes off what lies in the mould. Returns that.
fn measure(
    workpiece: &mut Workpiece,
    exact_mm3: Option<f64>,
    buried: &[u32],
    clock: &StageClock,
    progress: ProgressFn,
) -> Result<f64, LayersError> {
    workpiece.volume_mm3 = match exact_mm3 {
        Some(exact_mm3) => exact_mm3,
        None => {
            clock.note("volume", 0);
            let all: Vec<u32> = workpiece.cells.iter().collect();
            workpiece.volume_of(&all, progress)?
        }
    };
    let buried_mm3 = workpiece.volume_of(buried, progress)?;
    workpiece.volume_mm3 -= buried_mm3;
    Ok(buried_mm3)
}
