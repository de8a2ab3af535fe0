//! Stage `surfaces`: the order re-timed into even layers, contoured at a layer height, trimmed to the mesh.

use crate::field::{FieldRun, timed};
use crate::{Args, failure};
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_layers::curved::Cells;
use curvlay_layers::curved::surface::{
    Even, EvenMethod, LayerField, SavedField, Spacing, SurfaceSlices, contour, even, extend, measure_spacing,
    mesh_stamp, plain_field,
};
use curvlay_layers::curved::trim::{BoundaryKind, TrimError, TrimmedSheet, Trimmer};
use curvlay_voxel::VoxelGrid;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use std::collections::HashSet;
use std::fs::File;
use std::io::BufReader;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

/// What came of the stage.
pub struct SurfacesRun {
    /// The field that the surfaces belong to.
    pub field: LayerField,
    /// How it came about.
    pub method: String,
    /// Pairs of neighbours whose layers lie far apart, since one had to wait.
    pub waits: usize,
    pub height_mm: f64,
    /// The surfaces, trimmed to the mesh, first to last; some may be empty.
    pub sheets: Vec<TrimmedSheet>,
    pub spacing: Spacing,
    /// The same for the field of hop counts.
    pub plain_spacing: Spacing,
    pub boundary: Boundary,
    /// What of the part lies in missed cells.
    pub missed_mm3: f64,
    pub times: Times,
    /// What it takes to go on from here another time.
    pub saved: SavedField,
}

/// Where the surfaces end.
#[derive(Clone, Copy, Default)]
pub struct Boundary {
    /// How far off the mesh they end on it at most.
    pub error_mm: f64,
    /// How much of the boundary lies next to missed cells.
    pub at_missed_mm: f64,
    /// How much lies inside, where one side of the part had to wait for the other.
    pub at_waits_mm: f64,
    /// How much lies across holes of the mesh.
    pub at_holes_mm: f64,
}

/// How long the steps took.
#[derive(Clone, Copy, Default)]
pub struct Times {
    pub even: Duration,
    pub contour: Duration,
    pub trim: Duration,
    pub spacing: Duration,
}

impl SurfacesRun {
    pub fn slices(&self) -> Vec<SurfaceSlices<'_>> {
        slices(&self.sheets)
    }

    pub fn triangles(&self) -> usize {
        self.sheets.iter().map(|sheet| sheet.triangles.len()).sum()
    }
}

/// A field saved by an earlier run.
pub fn load(path: &Path, part: &Part) -> Result<SavedField, Failure> {
    let name = path.display();
    let file = File::open(path).map_err(|error| failure(format!("{name}: cannot be read: {error}")))?;
    let saved = SavedField::read(BufReader::new(file)).map_err(|error| failure(format!("{name}: {error}")))?;
    let stamp = mesh_stamp(&part.mesh.vertices, &part.mesh.triangles);
    saved.check_mesh(stamp).map_err(|error| failure(format!("{name}: {}: {error}", part.name)))?;
    Ok(saved)
}

/// Makes the surfaces, of a saved field if there is one.
pub fn run(
    args: &Args,
    part: &Part,
    run: &FieldRun,
    saved: Option<SavedField>,
    bars: &Bars,
) -> Result<SurfacesRun, Failure> {
    let grid = &run.solid.grid;
    let cells = Cells::new(grid.dims(), grid.rows()).map_err(failure)?;
    let missed: Vec<u32> = run.growth.missed.iter().map(|missed| missed.cell).collect();
    let mut times = Times::default();
    let (field, method, waits) = match saved {
        Some(saved) => (saved.field, "saved".to_owned(), 0),
        None => {
            let progress = |p: curvlay_layers::Progress| {
                bars.update(p.stage, p.done, p.total);
                ControlFlow::Continue(())
            };
            let (even, time) = timed(|| even(&cells, &run.platform, &run.rules, &run.growth.order, &missed, &progress));
            times.even = time;
            let Even { field, method, jumps, .. } = even.map_err(failure)?;
            (field, method_name(method), jumps)
        }
    };
    let height_mm = args.layer_height.unwrap_or(grid.cell_mm());
    let vertices: Vec<Point3<f64>> = part.mesh.vertices.iter().map(|vertex| vertex + run.solid.shift).collect();
    let (trimmer, time) = timed(|| Trimmer::new(&vertices, &part.mesh.triangles));
    let trimmer = trimmer.map_err(|error| failure(format!("{}: {error}", part.name)))?;
    times.trim = time;

    let made = sheets(&field, &cells, grid, height_mm, &trimmer, bars)?;
    times.contour = made.contour;
    times.trim += made.trim;
    let (spacing, time) = timed(|| measure_spacing(&slices(&made.sheets), height_mm));
    times.spacing = time;
    let plain = plain_field(&cells, &run.growth.order).map_err(failure)?;
    let plain = sheets(&plain, &cells, grid, height_mm, &trimmer, bars)?;
    let plain_spacing = measure_spacing(&slices(&plain.sheets), height_mm).map_err(failure)?;

    let boundary = boundary(&made.sheets, grid, &missed);
    let saved = SavedField {
        field: field.clone(),
        rows: grid.rows().to_vec(),
        cell_mm: grid.cell_mm(),
        origin: grid.origin(),
        mesh: mesh_stamp(&part.mesh.vertices, &part.mesh.triangles),
    };
    let missed_mm3 = volume_in(&missed, grid, &trimmer).map_err(failure)?;
    let spacing = spacing.map_err(failure)?;
    let sheets = made.sheets;
    Ok(SurfacesRun {
        field,
        method,
        waits,
        height_mm,
        sheets,
        spacing,
        plain_spacing,
        boundary,
        missed_mm3,
        times,
        saved,
    })
}

fn method_name(method: EvenMethod) -> String {
    match method {
        EvenMethod::Clock { lag, stays_level } => {
            format!("clock, lead {lag} layers, {}", if stays_level { "level fronts stay level" } else { "fronts turn" })
        }
        _ => "plain".to_owned(),
    }
}

fn slices(sheets: &[TrimmedSheet]) -> Vec<SurfaceSlices<'_>> {
    sheets.iter().map(|sheet| (&sheet.vertices[..], &sheet.triangles[..])).collect()
}

struct Sheets {
    sheets: Vec<TrimmedSheet>,
    contour: Duration,
    trim: Duration,
}

/// The surfaces of a field, trimmed.
fn sheets(
    field: &LayerField,
    cells: &Cells,
    grid: &VoxelGrid,
    height_mm: f64,
    trimmer: &Trimmer,
    bars: &Bars,
) -> Result<Sheets, Failure> {
    bars.update("contour", 0, 1);
    let (surfaces, contour_time) = timed(|| {
        let extended = extend(field, cells);
        let levels = extended.levels(grid.cell_mm(), height_mm)?;
        contour(&extended, &levels, grid.cell_mm(), grid.origin())
    });
    let surfaces = surfaces.map_err(|error| failure(format!("--layer-height: {error}")))?;
    bars.update("trim", 0, 1);
    let (sheets, trim) = timed(|| {
        let trimmed = surfaces.par_iter().map(|surface| trimmer.trim(&surface.points, &surface.triangles));
        trimmed.collect::<Result<Vec<_>, _>>()
    });
    Ok(Sheets { sheets: sheets.map_err(failure)?, contour: contour_time, trim })
}

/// Levels at which a missed cell is cut to measure what of the part lies in it.
const CUTS: u32 = 4;

/// How much of the part lies in these cells, many of which are at its skin: level sheets through them trimmed to the mesh.
fn volume_in(cells: &[u32], grid: &VoxelGrid, trimmer: &Trimmer) -> Result<f64, TrimError> {
    let h = grid.cell_mm();
    let mut cells: Vec<[u32; 3]> = cells.iter().map(|&cell| grid.position(cell)).collect();
    cells.sort_unstable_by_key(|&[x, y, z]| [z, y, x]);
    let mut area = 0.0;
    for level in cells.chunk_by(|a, b| a[2] == b[2]) {
        for cut in 0..CUTS {
            let z = f64::from(level[0][2]) + (f64::from(cut) + 0.5) / f64::from(CUTS);
            let corner = |x: u32, y: u32| grid.origin() + Vector3::new(f64::from(x), f64::from(y), z) * h;
            let square = |&[x, y, _]: &[u32; 3]| [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
            let points: Vec<Point3<f64>> = level.iter().flat_map(square).map(|[x, y]| corner(x, y)).collect();
            let triangles: Vec<[u32; 3]> =
                (0..level.len() as u32).flat_map(|k| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| 4 * k + v))).collect();
            area += trimmer.trim(&points, &triangles)?.area();
        }
    }
    Ok(area * h / f64::from(CUTS))
}

/// Adds up where the sheets end.
fn boundary(sheets: &[TrimmedSheet], grid: &VoxelGrid, missed: &[u32]) -> Boundary {
    let missed: HashSet<[i64; 3]> = missed.iter().map(|&cell| grid.position(cell).map(i64::from)).collect();
    let next_to_missed = |p: Point3<f64>| {
        let place = (p - grid.origin()) / grid.cell_mm();
        let around = |d: f64| [0, 1, 2].map(|axis| (place[axis] + d).floor() as i64);
        let (low, high) = (around(-1.0), around(1.0));
        !missed.is_empty()
            && (low[0]..=high[0])
                .any(|x| (low[1]..=high[1]).any(|y| (low[2]..=high[2]).any(|z| missed.contains(&[x, y, z]))))
    };
    let mut boundary = Boundary::default();
    for sheet in sheets {
        boundary.error_mm = boundary.error_mm.max(sheet.error_mm);
        boundary.at_holes_mm += sheet.hole_mm;
        for edge in sheet.boundary.iter().filter(|edge| edge.kind == BoundaryKind::Border) {
            let [a, b] = edge.ends.map(|end| sheet.vertices[end as usize]);
            let length = (b - a).norm();
            if next_to_missed(nalgebra::center(&a, &b)) {
                boundary.at_missed_mm += length;
            } else {
                boundary.at_waits_mm += length;
            }
        }
    }
    boundary
}
