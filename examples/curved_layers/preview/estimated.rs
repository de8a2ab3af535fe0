//! What printing takes, from some of the layers.

use super::MAX_CELLS;
use crate::args::{Args, failure};
use crate::field;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::{Failure, Part};
use curvlay_examples::bars::Bars;
use curvlay_layers::curved::surface::ContourError;
use curvlay_toolpath::estimate::{PrintEstimate, SampledPart, Samples, estimate_print};
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::path::PathOptions;
use nalgebra::Point3;
use std::time::{Duration, Instant};

/// Layers of a full run are no lower than this, in cells, where the user says what cells there are: `ExtendedField::levels` refuses it.
const MIN_HEIGHT_CELLS: f64 = 0.2;

/// What a preview finds beside field and surfaces.
pub struct PreviewRun {
    /// Whole layers that the full run prints, half layers, and their height.
    pub layers: usize,
    pub half_layers: usize,
    pub height_mm: f64,
    pub bead_mm: f64,
    /// How many of them each surface stands for.
    pub layers_each: f64,
    /// Cells that the full run takes, where these are more.
    pub full_cells: Option<u64>,
    /// What printing takes.
    pub print: PrintEstimate,
    pub time: Duration,
}

impl PreviewRun {
    /// Estimates.
    pub fn new(
        args: &Args,
        part: &Part,
        field: &field::FieldRun,
        surfaces: &SurfacesRun,
        bars: &Bars,
    ) -> Result<Self, Failure> {
        let start = Instant::now();
        let wanted_mm = args.height().unwrap_or(field.solid.grid.cell_mm());
        let whole = surfaces.is_half.iter().filter(|is_half| !**is_half).count().max(1);
        // As layers fit the part: a whole number of them.
        let part_mm = surfaces.height_mm * whole as f64;
        let layers = (part_mm / wanted_mm).round().max(1.0);
        let (height_mm, layers_each) = (part_mm / layers, layers / whole as f64);
        let cell_mm = field.solid.grid.cell_mm();
        let is_derived = args.voxel.resolution().is_none() && args.resume.is_none();
        if !is_derived && wanted_mm < MIN_HEIGHT_CELLS * cell_mm {
            let error = ContourError::TooThin { height_mm: wanted_mm, cell_mm };
            return Err(failure(format!("--layer-height: {error}")));
        }
        let options = args.path_options(height_mm)?;
        args.memory().holds_paths(options.bead, cell_mm, surfaces)?;
        let fill = args.fill(options, surfaces);
        let thin = |surfaces: &[LayerSurface]| -> Vec<Vec<f64>> {
            let of = |surface: &LayerSurface| surface.thickness.iter().map(|mm| mm / layers_each).collect();
            surfaces.iter().map(of).collect()
        };
        let shift = |vertex: &Point3<f64>| vertex + field.solid.shift;
        let vertices: Vec<Point3<f64>> = part.mesh.vertices.iter().map(shift).collect();
        let (of_part, of_support) = (surfaces.of_part(), surfaces.of_support());
        let thickness = [thin(&of_part), thin(&of_support)];
        let [of_part, of_support] = [with(&of_part, &thickness[0]), with(&of_support, &thickness[1])];
        let sampled = |surfaces, options: PathOptions, solid| SampledPart { surfaces, options, solid };
        let mut parts = vec![sampled(&of_part[..], fill.part, (&vertices, &part.mesh.triangles))];
        if let (Some(support), Some(options)) = (&surfaces.support, fill.support) {
            parts.push(sampled(&of_support, options, (&support.mesh.vertices, &support.mesh.triangles)));
        }
        let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
        let samples = Samples { parts: &parts, layers_each };
        let print = estimate_print(&samples, &args.settings.deposition(), &args.settings.travel(), &progress)?;
        let bead_mm = options.bead;
        if print.bead_mm <= 0.0 {
            return Err(failure(format!("a bead of {bead_mm} mm fits nowhere: take a smaller --bead")));
        }
        let half_layers = (layers_each * surfaces.half_layers() as f64).round() as usize;
        let full_cells = is_derived.then(|| field::cells_of_full_run(args.height(), part));
        let full_cells = full_cells.filter(|&cells| cells > MAX_CELLS);
        let layers = layers as usize;
        let time = start.elapsed();
        Ok(PreviewRun { layers, half_layers, height_mm, bead_mm, layers_each, full_cells, print, time })
    }

    /// How much of the area is too narrow for any bead.
    pub fn too_narrow_share(&self) -> f64 {
        self.print.too_narrow_mm2 / self.print.area_mm2.max(f64::MIN_POSITIVE)
    }
}

/// The same surfaces with another thickness.
fn with<'a>(surfaces: &[LayerSurface<'a>], thickness: &'a [Vec<f64>]) -> Vec<LayerSurface<'a>> {
    surfaces.iter().zip(thickness).map(|(surface, thickness)| LayerSurface { thickness, ..*surface }).collect()
}
