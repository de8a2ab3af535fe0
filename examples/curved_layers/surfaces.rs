//! Stage `surfaces`: the order re-timed into uniform layers, contoured at a layer height, trimmed to the mesh.

use crate::args::failure;
use crate::ranges::Pick;
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::clock::StageClock;
use curvlay_examples::input::{self, InputError};
use curvlay_examples::mesh::Mesh;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::{
    LayerField, PrintAids, SavedField, Spacing, UniformField, UniformMethod, mesh_stamp, plain_field,
};
use curvlay_layers::curved::{
    Growth, LayerSurfaces, LayersError, NozzleCell, NozzleRule, PartSupport, PrintedSheet, Workpiece,
};
use curvlay_layers::nalgebra::Vector3;
use curvlay_toolpath::layer::{DirectionHints, LayerSurface};
use curvlay_voxel::Resolution;
use std::fmt::Display;
use std::io::BufReader;
use std::ops::{ControlFlow, Deref};
use std::path::Path;
use std::time::Duration;

/// How the surfaces are made.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceOptions {
    /// Layer height; none for the edge of a cell.
    pub height_mm: Option<f64>,
    /// Makes no more whole ones than about this, evenly spread: each stands for the layers around it. None for all.
    pub max_surfaces: Option<u32>,
    /// Tries a field that is torn as little as the part allows, too.
    pub coherent: bool,
    /// Makes the surfaces of hop counts as well, to compare with.
    pub compare: bool,
    /// Makes the surfaces of these layers alone, with so many whole layers before and after them; all where it has to be found out which field is more coherent. None for all.
    pub layers: Option<(Pick, usize)>,
}

/// Surfaces and the field that they belong to.
pub struct Made {
    pub layers: LayerSurfaces,
    pub support: Option<PartSupport>,
    pub field: LayerField,
    pub aids: PrintAids,
    /// How the field came about.
    pub method: String,
    /// Pairs of neighbours whose layers lie far apart, since one had to wait.
    pub waits: usize,
    /// The layer height that was asked for.
    pub asked_mm: f64,
}

impl Made {
    /// Of the field of an order, and its layers.
    pub fn of(
        uniform: UniformField,
        (layers, support): (LayerSurfaces, Option<PartSupport>),
        growth: &Growth,
        rule: NozzleRule,
        asked_mm: f64,
    ) -> Self {
        let mut aids = PrintAids { rule, nozzle: growth.nozzle.clone(), ..PrintAids::default() };
        if let Some(PartSupport { cells, gap, contact, .. }) = &support {
            (aids.support, aids.gap, aids.contact) = (cells.clone(), gap.clone(), contact.clone());
        }
        let (method, waits) = (method_name(uniform.method), uniform.jumps);
        Made { layers, support, method, field: uniform.field, aids, waits, asked_mm }
    }
}

/// What came of the stage.
pub struct SurfacesRun {
    layers: LayerSurfaces,
    /// The support.
    pub support: Option<PartSupport>,
    /// The layers with their support, if there is any.
    pub printed: Vec<PrintedSheet>,
    /// The field, and all else that it takes to go on from here another time.
    pub saved: SavedField,
    pub method: String,
    pub waits: usize,
    /// The layer height that was asked for.
    asked_mm: f64,
    /// Spacing for the field of hop counts, to compare with.
    pub plain_spacing: Option<Spacing>,
    pub times: Times,
}

/// How long the steps took.
#[derive(Clone, Copy, Default)]
pub struct Times {
    pub even: Duration,
    pub contour: Duration,
    pub trim: Duration,
    pub spacing: Duration,
}

impl Deref for SurfacesRun {
    type Target = LayerSurfaces;

    fn deref(&self) -> &LayerSurfaces {
        &self.layers
    }
}

impl SurfacesRun {
    /// The surfaces as tool paths are planned on.
    pub fn surfaces(&self) -> Vec<LayerSurface<'_>> {
        if self.printed.is_empty() {
            return self.of_part();
        }
        let printed = self.printed.iter();
        printed
            .map(|PrintedSheet { vertices, triangles, thickness_mm: thickness, is_half, .. }| LayerSurface {
                vertices,
                triangles,
                thickness,
                is_half: *is_half,
            })
            .collect()
    }

    /// Those of the part alone.
    pub fn of_part(&self) -> Vec<LayerSurface<'_>> {
        self.layers.iter().map(LayerSurface::from).collect()
    }

    /// Those of the support.
    pub fn of_support(&self) -> Vec<LayerSurface<'_>> {
        self.support.iter().flat_map(|support| support.surfaces.iter()).map(LayerSurface::from).collect()
    }

    /// A number that identifies what all surfaces are made of, whether they were made or not.
    pub fn made_of(&self) -> u64 {
        self.saved.surfaces_stamp(self.asked_mm)
    }

    /// How the nozzle is known to get to the places of cells that were judged by it.
    pub fn hints(&self) -> Result<DirectionHints, Failure> {
        let SavedField { field, aids, cell_mm, origin, .. } = &self.saved;
        let [nx, ny, _] = field.dims();
        let middle = |cell: u32| [cell % nx, cell / nx % ny, cell / nx / ny].map(|k| (f64::from(k) + 0.5) * cell_mm);
        let known = |&NozzleCell { cell, direction }: &NozzleCell| (origin + Vector3::from(middle(cell)), direction);
        Ok(DirectionHints::new(&aids.nozzle.iter().map(known).collect::<Vec<_>>(), *cell_mm)?)
    }

    /// Volume of the layers of the support, in cubic millimetres.
    pub fn support_mm3(&self) -> f64 {
        self.support.as_ref().map_or(0.0, |support| support.surfaces.spacing.volume_mm3)
    }

    /// How many of the surfaces lie half way between two layers.
    pub fn half_layers(&self) -> usize {
        self.is_half.iter().filter(|is_half| **is_half).count()
    }

    pub fn triangles(&self) -> usize {
        self.sheets.iter().map(|sheet| sheet.triangles.len()).sum()
    }
}

/// A field saved by an earlier run, from a regular file: others may never end.
pub fn load(path: &Path) -> Result<SavedField, Failure> {
    let failed = |error: &dyn Display| failure(format!("{}: {error}", path.display()));
    let file = input::open(path, input::MAX_DATA_BYTES).map_err(|error| match error {
        InputError::NotAFile { .. } => failed(&"is not a file; --resume wants the field.txt of an earlier run"),
        error => failure(error),
    })?;
    let saved = SavedField::read(BufReader::new(file)).map_err(|error| failed(&error))?;
    Ok(saved)
}

/// A place of a part's grid is rounded to 2^-20 of a cell; rounding of coordinates is far less than a quarter of that.
const ROUNDING: f64 = 1.0 / (1 << 22) as f64;

/// How large the cells are that a saved field is of, and where the grid of its part begins. Around a mould the saved one begins a whole number of cells
/// before that.
pub fn resolution(saved: &SavedField, part: &Part, has_mould: bool) -> Resolution {
    let SavedField { cell_mm, origin, .. } = *saved;
    let Mesh { vertices, triangles } = &part.mesh;
    let corner = [0, 1].map(|axis| {
        let along = triangles.iter().flatten().map(|&corner| vertices[corner as usize][axis]);
        let low = along.fold(f64::INFINITY, f64::min);
        let cells = ((low - origin[axis]) / cell_mm + ROUNDING).floor();
        if has_mould { origin[axis] + cells * cell_mm } else { origin[axis] }
    });
    Resolution::At { cell_mm, corner }
}

/// What stands beside the surfaces: the field to save, times, and what to compare with.
pub fn finish(
    options: &SurfaceOptions,
    Made { layers, support, field, aids, method, waits, asked_mm }: Made,
    workpiece: &Workpiece,
    growth: &Growth,
    part: &Part,
    clock: &StageClock,
) -> Result<SurfacesRun, Failure> {
    let plain_spacing = || -> Result<Spacing, Failure> {
        let rows = support.as_ref().map_or(workpiece.cells.rows(), |support| &support.rows);
        let cells = Cells::new(workpiece.cells.dims(), rows)?;
        let plain = plain_field(&cells, &growth.order)?;
        let silent = |_| ControlFlow::Continue(());
        let united = Workpiece { cells, ..*workpiece };
        let plain = united.surfaces(&plain, &growth.missed_cells(), layers.height_mm, &silent);
        Ok(plain.map_err(|error| failed(error, part))?.spacing)
    };
    let plain_spacing = options.compare.then(plain_spacing).transpose()?;
    let [even, contour, trim, spacing] =
        [&["uniform", "audit uniform", "coherent"][..], &["contour"], &["trim", "crossings", "clip"], &["spacing"]]
            .map(|stages| clock.on_the_clock(stages));
    let saved = SavedField {
        field,
        rows: support.as_ref().map_or(workpiece.cells.rows(), |support| &support.rows).to_vec(),
        cell_mm: workpiece.cell_mm,
        origin: workpiece.origin,
        mesh: mesh_stamp(&part.mesh.vertices, &part.mesh.triangles),
        aids,
    };
    let printed = support.as_ref().map_or(Vec::new(), |support| support.printed_with(&layers));
    let times = Times { even, contour, trim, spacing };
    Ok(SurfacesRun { layers, support, printed, saved, method, waits, asked_mm, plain_spacing, times })
}

/// Why there are no surfaces, in one line.
pub fn failed(error: LayersError, part: &Part) -> Failure {
    match error {
        LayersError::Contour(error) => failure(format!("--layer-height: {error}")),
        LayersError::Trim(error) => failure(format!("{}: {error}", part.name)),
        error => failure(error),
    }
}

/// How a field was made even, in words.
pub fn method_name(method: UniformMethod) -> String {
    match method {
        UniformMethod::Clock { lag, stays_level } => {
            format!("clock, lead {lag} layers, {}", if stays_level { "level fronts stay level" } else { "fronts turn" })
        }
        UniformMethod::Coherent => "coherent field".to_owned(),
        UniformMethod::Distance => "distance from what the part stands on".to_owned(),
        UniformMethod::Directed => {
            "directions of the distance, within the tilt that the cone of the nozzle allows".to_owned()
        }
        _ => "plain".to_owned(),
    }
}
