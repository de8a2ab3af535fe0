//! The part in cells, and what it stands on.

use super::options::{FieldOptions, Given};
use crate::estimate::{self, Memory};
use crate::failure;
use crate::mould::{Mould, Standing};
use crate::surfaces;
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_examples::mesh::UNCERTAIN_SHARE;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::mesh_stamp;
use curvlay_layers::curved::{Guides, Platform, Rules, Workpiece};
use curvlay_voxel::inspect::{MeshReport, ThinFeatures, inspect, thinner_than};
use curvlay_voxel::{Resolution, VoxelOptions, Voxelisation, voxelise};
use nalgebra::Point3;
use std::time::{Duration, Instant};

/// Cells that a part gets unless the user says. With more of them layers wait for each other at more places: a hollow bunny of 92 mm has
/// eight times the curves with a million (docs/decisions/02-voxels.md). With fewer cells, thin walls get none.
const CELLS: u64 = 100_000;

/// Large parts get more, so that cells are no higher than this many layers: contours take layers down to a fifth of a cell.
const MAX_LAYERS_OF_CELL: f64 = 4.0;

/// But never more than this: some seconds of growing, and 3 GB.
const MAX_CELLS: u64 = 1_000_000;

/// About as many cells as a part gets with this edge: its volume holds so many, and half of its surface.
fn count_of(edge: f64, part: &Part) -> f64 {
    part.mesh.volume() / edge.powi(3) + part.mesh.area() / (2.0 * edge.powi(2))
}

/// The same cells, but no more than `most`.
fn at_most(most: u64, cells: Resolution, part: &Part) -> Resolution {
    match cells {
        Resolution::Count(count) => Resolution::Count(count.min(most)),
        Resolution::Cell(edge) if count_of(edge, part) > most as f64 => Resolution::Count(most),
        other => other,
    }
}

/// About how many cells a part gets in a full run, unless the user says; none for a height that is the edge of a cell.
pub fn cells_of_full_run(height_mm: Option<f64>, part: &Part) -> u64 {
    match height_mm.map_or(Resolution::Count(CELLS), |height_mm| cells_for(height_mm, part)) {
        Resolution::Count(count) => count,
        Resolution::Cell(edge) => count_of(edge, part).round() as u64,
        _ => CELLS,
    }
}

/// The cells of a part with layers of a printer: as high as a layer, or higher where they would be too many.
fn cells_for(height_mm: f64, part: &Part) -> Resolution {
    let count = |edge: f64| count_of(edge, part);
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

/// The part in cells, and what it stands on.
pub struct PartInCells {
    pub mesh: MeshReport,
    /// What is thinner than a cell.
    pub thin: ThinFeatures,
    /// Without cells in the mould.
    pub solid: Voxelisation,
    pub platform: Platform,
    pub mould: Option<Mould>,
    /// Cells that lie deep in the mould.
    pub buried: Vec<u32>,
    /// The volume of the part, if its mesh bounds one.
    pub exact_mm3: Option<f64>,
    /// How long the inspections of the mesh took, and the cells.
    pub inspect_time: Duration,
    pub voxelise_time: Duration,
    /// The vertices of the mesh, in the frame of the cells.
    vertices: Vec<Point3<f64>>,
}

impl PartInCells {
    /// Inspects the mesh and makes its cells, on a mould if there is one. A saved field must be of this mesh and of these cells.
    ///
    /// The `memory` must hold what is `made` of the cells later: steps that take long begin only then.
    pub fn new(
        options: &FieldOptions,
        given: &Given,
        (memory, made): (Memory, estimate::Made),
        bars: &Bars,
    ) -> Result<Self, Failure> {
        let Given { part, saved, .. } = given;
        let (vertices, triangles) = (&part.mesh.vertices, &part.mesh.triangles);
        if let Some(saved) = saved {
            saved.check_mesh(mesh_stamp(vertices, triangles)).map_err(|error| of_part(part, error))?;
        }
        let (mesh, inspect_time) = timed(|| inspect(vertices, triangles));
        let mesh = mesh.map_err(|error| of_part(part, error))?;
        let (standing, voxelise_time) = timed(|| standing(options, given, bars));
        let (solid, mould) = standing?;
        let grid = &solid.grid;
        memory.holds_cells(grid.dims(), grid.count(), made)?;
        let (thin, thin_time) = timed(|| thinner_than(vertices, triangles, grid.cell_mm()));
        let thin = thin.map_err(|error| of_part(part, error))?;
        let cells = Cells::new(grid.dims(), grid.rows())?;
        if let Some(saved) = saved {
            saved.check_cells(&cells, grid.origin())?;
        }
        let (platform, mould, buried) = match mould {
            Some(OnMould { platform, mould, buried }) => (platform, Some(mould), buried),
            None => (disc_under(&cells, grid.cell_mm(), options.platform_diameter_mm, part)?, None, Vec::new()),
        };
        let exact_mm3 = exact_volume(part, &mesh);
        let vertices = vertices.iter().map(|vertex| vertex + solid.shift).collect();
        let inspect_time = inspect_time + thin_time;
        Ok(PartInCells { mesh, thin, solid, platform, mould, buried, exact_mm3, inspect_time, voxelise_time, vertices })
    }

    /// The part as it is layered, without guides. Its volume is that of its mesh.
    pub fn workpiece<'a>(&'a self, part: &'a Part, options: &FieldOptions) -> Result<Workpiece<'a>, Failure> {
        let grid = &self.solid.grid;
        Ok(Workpiece {
            vertices: &self.vertices,
            triangles: &part.mesh.triangles,
            cells: Cells::new(grid.dims(), grid.rows())?,
            cell_mm: grid.cell_mm(),
            origin: grid.origin(),
            platform: &self.platform,
            rules: Rules {
                inside_depth_cells: options.eps_cells,
                boundary_is_inside: !options.beyond_eps,
                ..Rules::default()
            },
            volume_mm3: self.mesh.volume_mm3(),
            guides: Guides::default(),
        })
    }
}

/// A mould with the platform that it makes, and the cells of the part that lie deep in it.
struct OnMould {
    mould: Mould,
    platform: Platform,
    buried: Vec<u32>,
}

/// Cells of the size that a saved field has, or the user asks for, or that follows from the layer height; without those in the mould.
fn standing(options: &FieldOptions, given: &Given, bars: &Bars) -> Result<(Voxelisation, Option<OnMould>), Failure> {
    let Given { part, mould, saved, .. } = given;
    let derived = || {
        let derived = options.layers.height_mm.map_or(Resolution::Count(CELLS), |height_mm| cells_for(height_mm, part));
        options.max_cells.map_or(derived, |most| at_most(most, derived, part))
    };
    let of_saved = |saved| surfaces::resolution(saved, part, mould.is_some());
    let resolution = saved.as_ref().map(of_saved).or(options.resolution).unwrap_or_else(derived);
    let voxel_options = VoxelOptions { resolution, ..VoxelOptions::default() };
    let progress = |p: curvlay_voxel::Progress| bars.show(p.stage, p.done, p.total);
    let solid = voxelise(&part.mesh.vertices, &part.mesh.triangles, &voxel_options, &progress)
        .map_err(|error| of_part(part, error))?;
    let Some(mould) = mould else { return Ok((solid, None)) };
    let Standing { mould, platform, solid, buried } = Mould::stand(mould, solid, options.platform_diameter_mm)?;
    Ok((solid, Some(OnMould { mould, platform, buried })))
}

/// A disc under the part.
fn disc_under(cells: &Cells, cell_mm: f64, diameter_mm: f64, part: &Part) -> Result<Platform, Failure> {
    Platform::under(cells, diameter_mm / 2.0 / cell_mm).map_err(|_| {
        let what = format!("the part and a platform of {diameter_mm} mm are too large for cells of {cell_mm} mm");
        of_part(part, format!("{what}: take larger cells, or check --unit"))
    })
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

/// An error that names the part.
fn of_part(part: &Part, error: impl std::fmt::Display) -> Failure {
    failure(format!("{}: {error}", part.name))
}

/// Runs `work` and says how long it took.
fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    (work(), start.elapsed())
}
