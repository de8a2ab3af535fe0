//! Stage `paths`: every surface filled with continuous curves, and what their beads cover.

use crate::args::failure;
use crate::mould::Mould;
use crate::ranges::LayerFill;
use crate::surfaces::SurfacesRun;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::clock::StageClock;
use curvlay_toolpath::fill::{
    Bridges, FillLayersError, FillTotals, FilledLayer, FilledLayers, LeftOutParts, SHORT_CURVE_BEADS, fill_range,
    fill_rest,
};
use curvlay_toolpath::layer::{LayerStack, LayerSurface, StackError};
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::path::SurfacePath;
use std::ops::{ControlFlow, Range};
use std::time::{Duration, Instant};

/// What came of the stage.
pub struct PathsRun {
    pub bead_mm: f64,
    pub filled: FilledLayers,
    pub totals: FillTotals,
    /// Curves of fewer than [`SHORT_CURVE_BEADS`] beads.
    pub short_curves: usize,
    /// Parts of the layers that no bead fits into.
    pub too_thin: LeftOutParts,
    /// What skins bridge.
    pub bridges: Bridges,
    pub times: Times,
}

/// How long the steps took, all threads together.
#[derive(Clone, Copy, Default)]
pub struct Times {
    pub geodesic: Duration,
    /// Level sets and curves.
    pub paths: Duration,
    pub statistics: Duration,
    /// The order of the curves.
    pub order: Duration,
    /// On the clock, from the first surface to the last.
    pub wall: Duration,
}

/// The points of each curve, the first repeated at the end of a closed one.
pub fn curves(layer: &FilledLayer) -> impl Iterator<Item = Vec<Point3<f64>>> {
    layer.paths.paths.iter().map(SurfacePath::line).map(|(points, _)| points)
}

impl PathsRun {
    /// The layers with their curves as what is built, on a mould if there is one.
    pub fn stack<'a>(
        &'a self,
        layers: &[LayerSurface<'a>],
        mould: Option<&Mould>,
        layer_mm: f64,
    ) -> Result<LayerStack<'a>, StackError> {
        let stack = self.filled.stack(layers)?;
        match mould {
            Some(mould) => stack.on_mould(&mould.surface(layer_mm)),
            None => Ok(stack),
        }
    }

    /// Short curves as a share of all.
    pub fn short_curve_share(&self) -> f64 {
        self.short_curves as f64 / self.totals.curves as f64
    }

    /// Volume that sparse infill leaves empty.
    pub fn hollow_mm3(&self) -> f64 {
        self.totals.sparse.volume_mm3 - self.totals.sparse.infill_mm3
    }

    /// Curves per metre of path.
    pub fn starts_per_metre(&self) -> f64 {
        1000.0 * self.totals.curves as f64 / self.totals.path_mm
    }
}

/// Fills a range of the surfaces, from 0.
pub fn range(
    fill: &LayerFill,
    surfaces: &SurfacesRun,
    range: Range<usize>,
    bars: &Bars,
) -> Result<Vec<Option<FilledLayer>>, Failure> {
    let progress = |p: curvlay_toolpath::Progress| {
        if p.stage == "fill" {
            bars.update("paths", p.done, p.total);
        }
        ControlFlow::Continue(())
    };
    filled(fill, surfaces, range, &progress).map_err(|error| failed(error, || None))
}

/// Part and support of a range of layers, each filled in its own way.
fn filled(
    fill: &LayerFill,
    surfaces: &SurfacesRun,
    range: Range<usize>,
    progress: &(dyn Fn(curvlay_toolpath::Progress) -> ControlFlow<()> + Sync),
) -> Result<Vec<Option<FilledLayer>>, FillLayersError> {
    let of_part = surfaces.of_part();
    let filled = fill_range(&of_part, range.clone(), &fill.part, progress)?;
    let Some(options) = &fill.support else { return Ok(filled) };
    let support = fill_range(&surfaces.of_support(), range.clone(), options, progress)?;
    let both = filled.into_iter().zip(support).zip(&of_part[range]);
    Ok(both.map(|((part, support), surface)| FilledLayer::with_support(part, support, surface)).collect())
}

/// `thinnest_mm`: of the walls of the part, for those who have to take another bead.
fn failed(error: FillLayersError, thinnest_mm: impl FnOnce() -> Option<f64>) -> Failure {
    match error {
        FillLayersError::NothingFits { bead, widest_mm, fits_mm } => {
            let thinnest = thinnest_mm().map_or(String::new(), |mm| format!("the thinnest wall is {mm:.3} mm, and "));
            failure(format!(
                "a bead of {bead} mm fits nowhere: {thinnest}layers are {widest_mm:.3} mm wide at most; take a --bead of {fits_mm:.3} mm or less"
            ))
        }
        FillLayersError::Layer { layer, error } => failure(format!("layer {}: {error}", layer + 1)),
        error => failure(error),
    }
}

/// Fills the surfaces, but for those that are filled already. `thinnest_mm`: of the walls of the part; asked for where no bead fits.
pub fn run(
    fill: &LayerFill,
    surfaces: &SurfacesRun,
    given: Vec<Option<FilledLayer>>,
    bars: &Bars,
    thinnest_mm: impl FnOnce() -> Option<f64>,
) -> Result<PathsRun, Failure> {
    let (start, clock) = (Instant::now(), StageClock::default());
    let progress = |p: curvlay_toolpath::Progress| {
        clock.note(p.stage, p.done);
        // In between threads report on their own surfaces.
        if p.stage == "fill" {
            bars.update("paths", p.done, p.total);
        }
        ControlFlow::Continue(())
    };
    let all = surfaces.surfaces();
    let given = match fill.support {
        Some(_) if given.is_empty() => {
            filled(fill, surfaces, 0..all.len(), &progress).map_err(|error| failed(error, || None))?
        }
        _ => given,
    };
    let filled = fill_rest(&all, given, &fill.part, &progress).map_err(|error| failed(error, thinnest_mm))?;
    clock.stop();
    let [geodesic, paths, statistics] = ["distance", "curves", "coverage"].map(|stage| clock.of_threads(&[stage]));
    let times = Times { geodesic, paths, statistics, order: clock.on_the_clock(&["order"]), wall: start.elapsed() };
    let (bead_mm, totals) = (fill.part.bead, filled.totals());
    if totals.curves == 0 {
        return Err(failure(
            "no layer has a surface, nothing would be printed: take a smaller --cell or more --voxels",
        ));
    }
    let too_thin = filled.left_out(&all);
    let bridges = filled.bridges(&all);
    let short_curves = filled.curves_shorter_than(SHORT_CURVE_BEADS * bead_mm);
    Ok(PathsRun { bead_mm, totals, short_curves, too_thin, filled, bridges, times })
}
