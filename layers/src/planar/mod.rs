//! Plane layers: what a printer does that cannot turn the part, and solids that are cut into parts, each printed in flat layers
//! along a direction of its own.
//!
//! * [`decompose_volume`]: walls before overhang, after M. Lettori et al., "An Approach for Volume Decomposition in Robot-Based Additive
//!   Manufacturing", CAD'22, 2022.
//! * [`robofdm`]: skeleton, segments, sequence and tuned planes, after C. Dai, *Material Deposition in 3D Space* (TU Delft 2020), section 2.4.
//! * [`flat_layers`]: the layers of such a part as surfaces.
//! * [`slice_uniformly`]: H. Boge, *Robotic additive manufacturing* (MSc thesis, NTNU 2019), section 6.3.

mod flat;
mod lettori;
mod region;
pub mod robofdm;
mod solid;
mod uniform;

pub use flat::{FlatError, FlatLayer, FlatLayers, MAX_LAYERS, cells_by_flat_layer, flat_layers};
pub use lettori::{
    AuditOptions, BaseChoice, Feature, FeatureKind, PartAudit, Scenario, Separation, SeparationWall, Stuck,
    StuckReason, VolumeAudit, VolumeDecomposition, VolumeError, VolumeLayer, VolumeOptions, VolumePart, audit_volumes,
    decompose_volume, largest_rectangle,
};
pub use region::{MAX_LENGTH_MM, Region, RegionError};
pub use solid::{
    Cut, CutPlane, OverhangError, Partition, PlaneError, PlaneFrame, SectionPolygon, Solid, SolidError, risky_area,
    risky_faces, slice,
};
pub use uniform::{UniformSlicing, slice_uniformly};
