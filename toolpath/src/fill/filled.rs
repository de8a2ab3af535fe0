//! Layers that are filled.

use super::support_part::SupportPart;
use crate::infill::SparseFill;
use crate::layer::{BuiltLayer, LayerCurve, LayerStack, LayerSurface, StackError};
use crate::path::{BeadKind, LayerPaths, SurfacePath};
use crate::statistics::PathStatistics;
use nalgebra::Point3;

/// The paths of one surface.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FilledLayer {
    /// Its curves; as part of [`FilledLayers`] in the order in which they are printed.
    pub paths: LayerPaths,
    /// What their beads cover.
    pub statistics: PathStatistics,
    /// Whether uniform beads took the place of fitted ones, which crossed.
    pub uniform: bool,
    /// The greatest distance of a place of the surface from its boundary, in millimetres: half the width of its widest place. Infinite
    /// for a surface without a boundary.
    #[cfg_attr(feature = "serde", serde(with = "crate::infinite"))]
    pub reach_mm: f64,
    /// What is sparse of it ([`PathOptions::infill`](crate::path::PathOptions::infill)): nothing of a layer that is filled solid. `statistics` are those of the rest.
    pub sparse: SparseFill,
    /// What is solid of it, by which it is judged again where short curves come back; of others none, and none of a part that is finished.
    pub(super) solid: Option<SolidPart>,
    /// The support beside it, if there is any.
    pub(super) support: Option<SupportPart>,
}

/// The part of a surface that is filled solid.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SolidPart {
    pub vertices: Vec<Point3<f64>>,
    pub triangles: Vec<[u32; 3]>,
}

/// The paths of all surfaces of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct FilledLayers {
    /// In the order of the surfaces; none for a surface without triangles.
    pub layers: Vec<Option<FilledLayer>>,
    /// Straight ways from curve to curve and from layer to layer, in millimetres.
    pub travel_mm: f64,
    /// The same in the order in which the curves were found.
    pub given_mm: f64,
    /// For each layer points and widths of its curves.
    pub(super) beads: Vec<Vec<Bead>>,
}

/// A curve as a stack of layers takes it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bead {
    pub points: Vec<Point3<f64>>,
    widths: Vec<f64>,
    kinds: Vec<BeadKind>,
    pub closed: bool,
}

pub(super) fn beads(layer: &Option<FilledLayer>) -> Vec<Bead> {
    let bead = |path: &SurfacePath| {
        let (points, widths) = path.points.iter().map(|point| (point.at.position, point.width)).unzip();
        let kinds = path.points.iter().map(|point| point.kind).collect();
        Bead { points, widths, kinds, closed: path.closed }
    };
    layer.iter().flat_map(|layer| &layer.paths.paths).map(bead).collect()
}

impl FilledLayers {
    /// The surfaces with their curves as what is built, layer by layer.
    ///
    /// # Arguments
    /// * `surfaces`: those that were filled.
    ///
    /// # Errors
    /// [`StackError`], e.g. for a thickness that is not above 0.
    ///
    /// # Cost
    /// That of [`LayerStack::new`].
    pub fn stack<'a>(&'a self, surfaces: &[LayerSurface<'a>]) -> Result<LayerStack<'a>, StackError> {
        let curve = |bead: &'a Bead| {
            let Bead { points, widths, kinds, closed } = bead;
            LayerCurve { points, widths, kinds, closed: *closed }
        };
        let no_curves: &[LayerCurve] = &[];
        let layer = |(surface, beads): (&LayerSurface<'a>, &'a Vec<Bead>)| {
            let LayerSurface { vertices, triangles, thickness, .. } = *surface;
            let built = BuiltLayer { vertices, triangles, spacing: thickness, curves: no_curves };
            (built, beads.iter().map(curve).collect())
        };
        LayerStack::with_curves(surfaces.iter().zip(&self.beads).map(layer).collect())
    }
}
