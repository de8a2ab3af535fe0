//! What printing takes, from the surfaces of some layers, without paths: length of beads, material, time.
//!
//! For a first look at a part. A few surfaces, evenly spread over the layers, stand for all of them ([`Samples`]). On each the exact
//! distance to its boundary says where rings of beads lie and how wide they are ([`contour`](crate::contour)), so the length of beads is
//! an integral over the surface: area by beads across (`region`). Where layers are not solid, walls, skins and infill are distinguished as
//! [`infill`](crate::infill) does, but how far it is to the outside of the part is asked of its mesh. From length, width and thickness
//! follow volume and time, by the rules of [`deposit`](crate::deposit).
//!
//! Each connected region of walls, skin or infill takes one curve. A curve begins and ends anywhere in its region, and the next one is the
//! nearest: from such places, drawn at random with a fixed seed, follow the ways between curves (`ways`).
//!
//! Not counted: bridges between rings, curves that are left out for being short or out of the nozzle's reach, cuts for collisions and
//! what is longer about ways around the part. The nozzle is taken to turn no faster than it may: see [`PrintEstimate::print_s`].

mod random;
mod region;
mod samples;
mod ways;

pub use samples::{SampledPart, Samples};

use crate::ProgressFn;
use crate::deposit::DepositionOptions;
use crate::fill::FillLayersError;
use crate::infill::{FillError, Solid};
use crate::parallel;
use crate::travel::TravelOptions;
use region::{Beads, Sheet, sheet};
use std::f64::consts::PI;

/// What printing takes. Sums over all layers, those between the samples included.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PrintEstimate {
    /// Area of all layers.
    pub area_mm2: f64,
    /// Length of all beads.
    pub bead_mm: f64,
    /// Of this sparse infill.
    pub infill_mm: f64,
    /// Volume of all beads.
    pub extruded_mm3: f64,
    /// Filament for them.
    pub filament_mm: f64,
    /// Area that is too narrow for any bead, and its volume.
    pub too_narrow_mm2: f64,
    /// See `too_narrow_mm2`.
    pub too_narrow_mm3: f64,
    /// Volume of what is filled sparsely, by layers.
    pub sparse_mm3: f64,
    /// Curves: each needs a travel to it, but for the first.
    pub curves: f64,
    /// Length of the travels.
    pub travel_mm: f64,
    /// Seconds of printing.
    pub print_s: f64,
    /// Seconds of travels, of drawing filament back before them and of pushing it forward again.
    pub travel_s: f64,
}

impl PrintEstimate {
    /// Seconds of everything.
    pub fn total_s(&self) -> f64 {
        self.print_s + self.travel_s
    }
}

/// Estimates what it takes to print a part and its support.
///
/// # Arguments
/// * `parts`: the part, and its support if it has any: the surfaces with the same place in both lists are printed together.
/// * `layers_each`: how many layers each surface stands for, itself included: above 0 and finite.
/// * `progress`: called with the stage `estimate` after each layer; may cancel.
///
/// # Errors
/// [`FillLayersError`], as [`fill_layers`](crate::fill::fill_layers): a surface cannot be filled, or work was cancelled; and
/// [`FillLayersError::LayersEach`].
///
/// # Cost
/// Some milliseconds for a surface of 2,000 triangles, a tenth of filling it. With the feature `rayon` surfaces are shared out among threads;
/// the result is the same.
///
/// # Example
/// ```
/// use curvlay_toolpath::deposit::DepositionOptions;
/// use curvlay_toolpath::estimate::{SampledPart, Samples, estimate_print};
/// use curvlay_toolpath::layer::LayerSurface;
/// use curvlay_toolpath::nalgebra::Point3;
/// use curvlay_toolpath::path::PathOptions;
/// use curvlay_toolpath::travel::TravelOptions;
/// use std::ops::ControlFlow::Continue;
/// // A block of 16 x 8 x 8 mm in ten layers, of which the fifth stands for all.
/// let vertices = [[0.0, 0.0], [16.0, 0.0], [16.0, 8.0], [0.0, 8.0]].map(|[x, y]| Point3::new(x, y, 3.6));
/// let surface = LayerSurface { vertices: &vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2], is_half: false };
/// let options = PathOptions { bead: 1.0, ..PathOptions::default() };
/// let part = SampledPart { surfaces: &[surface], options, solid: (&[], &[]) };
/// let samples = Samples { parts: &[part], layers_each: 10.0 };
/// let (deposition, travel) = (DepositionOptions::default(), TravelOptions::default());
/// let estimate = estimate_print(&samples, &deposition, &travel, &|_| Continue(()))?;
/// // 16 x 8 mm2 in beads of 1 mm, ten times; 8 mm3/s. Beads that turn around corners share what is there.
/// assert!((estimate.bead_mm / 1280.0 - 1.0).abs() < 0.02 && (estimate.extruded_mm3 / 1024.0 - 1.0).abs() < 0.02, "{estimate:?}");
/// assert!((estimate.print_s / 128.0 - 1.0).abs() < 0.02);
/// # Ok::<(), curvlay_toolpath::fill::FillLayersError>(())
/// ```
pub fn estimate_print(
    samples: &Samples,
    deposition: &DepositionOptions,
    travel: &TravelOptions,
    progress: ProgressFn,
) -> Result<PrintEstimate, FillLayersError> {
    let each = samples.layers_each;
    if !(each > 0.0 && each.is_finite()) {
        return Err(FillLayersError::LayersEach { layers_each: each });
    }
    let mut layers: Vec<Vec<Sheet>> = Vec::new();
    for part in samples.parts {
        let heights = vec![1.0; part.solid.1.len()];
        let is_sparse = !part.options.infill.is_solid() && part.options.infill.skin > 0;
        let solid = is_sparse.then(|| Solid::new(part.solid.0, part.solid.1, &heights)).transpose()?;
        let sheets = parallel::map(part.surfaces, "estimate", progress, |layer, surface| {
            let found =
                (!surface.triangles.is_empty()).then(|| sheet(surface, solid.as_ref(), &part.options, deposition));
            found.transpose().map_err(|error| of_layer(layer, error))
        });
        let sheets = sheets.ok_or(FillLayersError::Cancelled)?;
        layers.resize_with(layers.len().max(sheets.len()), Vec::new);
        for (layer, sheet) in layers.iter_mut().zip(sheets) {
            layer.extend(sheet?);
        }
    }
    let mut estimate = PrintEstimate::default();
    layers.iter().flatten().for_each(|sheet| estimate.add(&sheet.beads, each));
    let area = PI / 4.0 * deposition.filament_diameter.powi(2);
    estimate.filament_mm = estimate.extruded_mm3 / area;
    let regions: Vec<Vec<_>> =
        layers.into_iter().map(|sheets| sheets.into_iter().flat_map(|sheet| sheet.regions).collect()).collect();
    let ways = ways::between(&regions, each);
    let travels = (ways.curves - 1.0).max(0.0);
    estimate.curves = ways.curves;
    // Up from the end of one curve, and down to the start of the next.
    estimate.travel_mm = ways.length_mm + 2.0 * travel.min_lift * travels;
    let retraction_s = deposition.retraction * (1.0 / deposition.retract_feed + 1.0 / deposition.prime_feed);
    estimate.travel_s = estimate.travel_mm / deposition.travel_feed + travels * retraction_s;
    Ok(estimate)
}

impl PrintEstimate {
    fn add(&mut self, beads: &Beads, each: f64) {
        self.area_mm2 += each * beads.area_mm2;
        self.bead_mm += each * beads.length_mm;
        self.infill_mm += each * beads.infill_mm;
        self.extruded_mm3 += each * beads.volume_mm3;
        self.too_narrow_mm2 += each * beads.too_narrow_mm2;
        self.too_narrow_mm3 += each * beads.too_narrow_mm3;
        self.sparse_mm3 += each * beads.sparse_mm3;
        self.print_s += each * beads.seconds;
    }
}

fn of_layer(layer: usize, error: FillError) -> FillLayersError {
    if error == FillError::Cancelled { FillLayersError::Cancelled } else { FillLayersError::Layer { layer, error } }
}
