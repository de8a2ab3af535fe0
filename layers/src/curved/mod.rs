//! Curved layers by an advancing convex front.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), chapter 3; C. Dai, C. C. L. Wang,
//! C. Wu, S. Lefebvre, G. Fang, Y.-J. Liu, "Support-free volume printing by multi-axis motion", ACM TOG 37(4),
//! 2018; H. Boge, *Robotic additive manufacturing* (MSc thesis, NTNU 2019), chapters 4 to 6.
//!
//! A nozzle of any size reaches a point outside the convex hull of everything built so far, platform included.
//! So an order of cells can be built when each cell (1) has a neighbour in an earlier layer or stands on the
//! platform, and (2) does not lie inside the hull of the platform and all earlier layers. [`Rules`] says what
//! "neighbour" and "inside" mean, [`Platform`] what the part stands on, [`LayerOrder`](crate::cells::LayerOrder) holds an order.
//!
//! [`Workpiece::layers`] does all steps: growth by a [`Strategy`] or the best one, [`audit`](audit()), the [`surface`]s of uniform
//! layers, and [trimming](crate::trim) to the mesh.
//!
//! # The lattice
//! Cells are numbered `x + nx * (y + ny * z)`. Geometry is done on *doubled* coordinates: the centre of cell
//! `[x, y, z]` is the lattice point `[2x + 1, 2y + 1, 2z + 1]`, and the plate under the part is the plane `z = 0`.

mod audit;
mod buildable;
mod distance;
mod growth;
mod impossible;
mod load;
mod nozzle;
pub mod orient;
mod part;
mod quality;
mod strategy;
mod support;
pub mod surface;
mod unbuild;

pub use audit::{
    AuditError, AuditReport, Fault, FaultCounts, JudgedByNozzle, ProofError, audit, audit_listing, audit_with_nozzle,
    check_impossible,
};
pub use buildable::platform::{Platform, PlatformError};
pub use buildable::rules::{Neighbours, Rules, RulesError};
pub use distance::{
    DirectedOptions, DistanceOrder, STEPS_PER_LAYER, distance_field, distance_layers, grow_by_distance,
    grow_by_heights, grow_directed,
};
pub use growth::{
    Candidates, Growth, GrowthError, GrowthOptions, GrowthStatistics, MissedCell, MissedReason, NozzleCell, PeelError,
    Prevention, SheetField, Visit, grow, grow_as_printed, peel,
};
pub use impossible::{Impossible, prove_impossible};
pub use load::{FollowError, FollowOptions, LoadAngle, LoadField, layer_normal, load_angle, load_field};
pub use nozzle::{DIRECTIONS, NozzleRule, NozzleRuleError, grow_with_nozzle};
pub use part::best::{WORTH, WORTH_MISSED};
pub use part::directions::{CellDirections, DirectionAt, DirectionsError};
pub use part::error::LayersError;
pub use part::guides::Guides;
pub use part::heights::HeightsError;
pub use part::layer_surfaces::{LayerBoundary, LayerSurfaces};
pub use part::layered::LayeredPart;
pub use part::options::{LayerOptions, LayersBy, NozzleUse};
pub use part::order::PartOrder;
pub use part::planned::PlannedSurfaces;
pub use part::support::{PartSupport, PrintedSheet, SupportCells};
pub use part::workpiece::Workpiece;
pub use quality::{LayerQuality, SMALL_PATCH, layer_quality};
pub use strategy::Strategy;
pub use support::{CellMesh, NoSupport, SupportError, SupportOptions, Supported, add_support, cell_mesh};
pub use unbuild::{UnbuildOptions, unbuild};
