//! What the stage `field` works on.

use crate::guide::Guide;
use curvlay_examples::args::Part;
use curvlay_layers::curved::LayerOptions;
use curvlay_layers::curved::surface::SavedField;
use curvlay_voxel::Resolution;
use nalgebra::Point3;

/// What cells the part gets, and how their order is found.
#[derive(Clone, Copy, Debug)]
pub struct FieldOptions {
    /// None for cells that follow from the layer height.
    pub resolution: Option<Resolution>,
    /// Cells that follow from the layer height are no more than this; none for no limit but that of full runs.
    pub max_cells: Option<u64>,
    /// Depth inside the hull from which a cell counts as shadowed, in cells.
    pub eps_cells: f64,
    /// Whether a cell at exactly that depth does not count.
    pub beyond_eps: bool,
    pub platform_diameter_mm: f64,
    /// How the part is layered; the height is that of a printer's layers, if the cells are to follow from it.
    pub layers: LayerOptions,
}

/// What layers are made of.
pub struct Given<'a> {
    pub part: &'a Part,
    /// What it is built on, if that is not the plate.
    pub mould: Option<&'a Part>,
    /// What its layers are guided by.
    pub guide: Option<&'a Guide>,
    /// The field, if an earlier run has saved it.
    pub saved: Option<SavedField>,
    /// Places on the plate where beads of an earlier try were unsupported.
    pub bare: &'a [Point3<f64>],
}
