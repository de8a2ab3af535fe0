//! Names of the package: namespaces, relationships, content types, units, kinds.

use super::SegmentKind;
use curvlay_toolpath::path::BeadKind;

/// Namespace of the core specification.
pub const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
/// Namespace of the production extension, which the toolpath extension requires.
pub const PRODUCTION: &str = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
/// Namespace of the toolpath extension, of model and layers.
pub const TOOLPATH: &str = "http://schemas.3mf.io/3dmanufacturing/toolpath/2026/03";
/// Relationship of the model to each part with a layer.
pub const LAYER_RELATIONSHIP: &str = "http://schemas.3mf.io/3dmanufacturing/toolpath/2026/03/layer";
/// Namespace of what the extension has no words for.
pub const OURS: &str = "urn:x-curvlay:3mf-nozzle:1";

/// Relationship of the package to its model.
pub(super) const MODEL_RELATIONSHIP: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
pub(super) const RELATIONSHIPS: &str = "http://schemas.openxmlformats.org/package/2006/relationships";
pub(super) const CONTENT_TYPES: &str = "http://schemas.openxmlformats.org/package/2006/content-types";

/// Where the model is.
pub(super) const MODEL_PART: &str = "/3D/3dmodel.model";

/// Millimetres of a unit of the core specification (attribute `unit` of a model); none of another word.
pub(crate) fn unit_mm(unit: &str) -> Option<f64> {
    Some(match unit {
        "micron" => 1e-3,
        "millimeter" => 1.0,
        "centimeter" => 10.0,
        "inch" => 25.4,
        "foot" => 304.8,
        "meter" => 1000.0,
        _ => return None,
    })
}

/// All kinds, by the names that files have.
const KINDS: [(SegmentKind, &str); 9] = [
    (SegmentKind::Travel, "travel"),
    (SegmentKind::Bead(BeadKind::Wall), "wall"),
    (SegmentKind::Bead(BeadKind::Solid), "solid"),
    (SegmentKind::Bead(BeadKind::Skin), "skin"),
    (SegmentKind::Bead(BeadKind::Bridge), "bridge"),
    (SegmentKind::Bead(BeadKind::Infill), "infill"),
    (SegmentKind::Bead(BeadKind::Support), "support"),
    (SegmentKind::Bead(BeadKind::SparseSupport), "sparse_support"),
    (SegmentKind::Bead(BeadKind::SupportBridge), "support_bridge"),
];

/// The name of a kind; none of a kind that the library has and the format does not.
pub(super) fn name_of(kind: SegmentKind) -> Option<&'static str> {
    KINDS.iter().find(|(known, _)| *known == kind).map(|(_, name)| *name)
}

/// The kind of a name.
pub(super) fn kind_of(name: &str) -> Option<SegmentKind> {
    KINDS.iter().find(|(_, known)| *known == name).map(|(kind, _)| *kind)
}

/// The part with a layer, from 0.
pub(super) fn layer_part(index: usize) -> String {
    format!("/Toolpath/Layers/layer{:05}.xml", index + 1)
}

/// The part with the relationships of a part.
pub(super) fn relationships_of(part: &str) -> String {
    match part.rsplit_once('/') {
        Some((folder, name)) => format!("{folder}/_rels/{name}.rels"),
        None => format!("_rels/{part}.rels"),
    }
}
