//! Where a layer is in the part.

use crate::mesh::SurfaceMesh;
use crate::path::InfillOptions;

/// Where a layer is in the part.
pub(crate) struct Site {
    /// Number of whole layers before it.
    pub number: usize,
    /// For each vertex how far it is inside of a skin, in millimetres; below 0 outside.
    pub skin: Vec<f64>,
}

impl Site {
    /// A layer with nothing above or below it: all of it is skin, if there are skins.
    pub fn alone(mesh: &SurfaceMesh, options: &InfillOptions) -> Site {
        let inside = if options.skin > 0 { mesh.diagonal() } else { -mesh.diagonal() };
        Site { number: 0, skin: vec![inside; mesh.vertices().len()] }
    }
}
