//! Some layers that stand for all.

use crate::layer::LayerSurface;
use crate::path::PathOptions;
use nalgebra::Point3;

/// Some layers of a part and its support, evenly spread over all of them.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// The part, and its support if it has any.
    pub parts: &'a [SampledPart<'a>],
    /// How many layers each of the surfaces stands for, itself included.
    pub layers_each: f64,
}

/// Some layers of a part, or of its support.
#[derive(Clone, Copy, Debug)]
pub struct SampledPart<'a> {
    /// The surfaces in build order, with the thickness of the layers that are printed, not of the distance between the samples.
    pub surfaces: &'a [LayerSurface<'a>],
    /// How they are filled.
    pub options: PathOptions,
    /// Vertices and triangles of the mesh that the surfaces are trimmed to: it says how far it is to the outside, where there are skins.
    pub solid: (&'a [Point3<f64>], &'a [[u32; 3]]),
}
