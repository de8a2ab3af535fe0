//! Layers that are filled.

use super::support_part::SupportPart;
use crate::infill::SparseFill;
use crate::layer::{LayerStack, LayerSurface, StackError};
use crate::path::{LayerPaths, SurfacePath};
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
#[non_exhaustive]
pub struct FilledLayers {
    /// In the order of the surfaces; none for a surface without triangles.
    pub layers: Vec<Option<FilledLayer>>,
    /// Straight ways from curve to curve and from layer to layer, in millimetres.
    pub travel_mm: f64,
    /// The same in the order in which the curves were found.
    pub given_mm: f64,
}

/// The curves of a layer that are printed.
pub(super) fn curves(layer: &Option<FilledLayer>) -> &[SurfacePath] {
    layer.as_ref().map_or(&[], |layer| &layer.paths.paths)
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
        LayerStack::of_paths(surfaces.iter().copied().zip(self.layers.iter().map(curves)))
    }
}
