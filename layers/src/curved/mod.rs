//! Curved layers by an advancing convex front.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), chapter 3; C. Dai, C. C. L. Wang,
//! C. Wu, S. Lefebvre, G. Fang, Y.-J. Liu, "Support-free volume printing by multi-axis motion", ACM TOG 37(4),
//! 2018; H. Boge, *Robotic additive manufacturing* (MSc thesis, NTNU 2019), chapters 4 to 6.
//!
//! A nozzle of any size reaches a point outside the convex hull of everything built so far, platform included.
//! So an order of cells can be built when each cell (1) has a neighbour in an earlier layer or stands on the
//! platform, and (2) does not lie inside the hull of the platform and all earlier layers. [`Rules`] says what
//! "neighbour" and "inside" mean, [`Platform`] what the part stands on, [`LayerOrder`] holds an order.
//!
//! [`Workpiece::layers`] does all steps: growth by a [`Strategy`] or the best one, [`audit`](audit()), the [`surface`]s of uniform
//! layers, and [trimming](trim) to the mesh.
//!
//! # The lattice
//! Cells are numbered `x + nx * (y + ny * z)`. Geometry is done on *doubled* coordinates: the centre of cell
//! `[x, y, z]` is the lattice point `[2x + 1, 2y + 1, 2z + 1]`, and the plate under the part is the plane `z = 0`.

mod audit;
mod best;
mod bits;
mod body;
mod boxes;
mod cells;
mod coherent_part;
mod complete;
mod contact;
mod directions;
mod distance;
mod distance_part;
mod growth;
mod guides;
mod heights;
mod impossible;
mod mould;
mod nozzle;
mod order;
pub mod orient;
mod peel;
mod platform;
mod quality;
mod rules;
mod runs;
mod skin;
mod standing;
mod strategy;
mod support;
pub mod surface;
pub mod trim;
mod unbuild;
mod watch;
mod workpiece;

pub use audit::{
    AuditError, AuditReport, Fault, FaultCounts, JudgedByNozzle, ProofError, audit, audit_with_nozzle, check_impossible,
};
pub use best::{WORTH, WORTH_MISSED};
pub(crate) use cells::set_bits;
pub use cells::{Cells, CellsError};
pub use complete::{
    CompleteOptions, CompleteOrder, CompletePart, LayersBy, NozzleUse, PartSupport, PrintedSheet, SupportCells,
};
pub use directions::{CellDirections, DirectionAt, DirectionsError};
pub use distance::{
    DirectedOptions, DistanceOrder, STEPS_PER_LAYER, distance_field, distance_layers, grow_by_distance,
    grow_by_heights, grow_directed,
};
pub use growth::{
    Candidates, Growth, GrowthError, GrowthOptions, GrowthStatistics, MissedCell, MissedReason, Prevention, Visit,
    grow, grow_as_printed,
};
pub use guides::Guides;
pub use heights::HeightsError;
pub use impossible::{Impossible, prove_impossible};
pub use nozzle::{DIRECTIONS, NozzleCell, NozzleRule, NozzleRuleError, grow_with_nozzle};
pub use order::LayerOrder;
pub use peel::{PeelError, SheetField, peel};
pub use platform::{Platform, PlatformError};
pub use quality::{LayerQuality, SMALL_PATCH, layer_quality};
pub use rules::{Neighbours, Rules, RulesError};
pub use strategy::Strategy;
pub use support::{CellMesh, NoSupport, SupportError, SupportOptions, Supported, add_support, cell_mesh};
pub use unbuild::{UnbuildOptions, unbuild};
pub use workpiece::{EVEN_THICKNESS, LayerBoundary, LayerSurfaces, LayeredPart, LayersError, OrderedPart, Workpiece};
