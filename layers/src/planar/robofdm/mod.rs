//! RoboFDM: a solid in parts that are printed one after another, each in flat layers along the normal of its base plane.
//!
//! C. Wu, C. Dai, G. Fang, Y.-J. Liu and C. C. L. Wang, "RoboFDM: a robotic system for support-free fabrication using FDM", ICRA 2017; here
//! after C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.4.
//!
//! * Phase I: [`segment`] (with [`curve_skeleton`], [`GaussianMixture`] and [`Labelling`]).
//! * Phase II: [`plan_sequence`].
//! * Phase III: [`tune`], into closed meshes.
//! * [`audit_parts`] checks the result, or parts of any other origin.
//! * [`decompose_by_planes`]: the fine decomposition alone, from the whole solid, with constraint I to the letter. Departures there: below a
//!   plane there must be one piece, which keeps the base; every piece above becomes a part. A plane must not face down in the part that
//!   it cuts, so that the section itself needs no support.

mod audit;
mod border;
mod closed;
mod cut;
mod cutting;
mod error;
mod mixture;
mod planes;
mod promise;
mod segment;
mod sequence;
mod skeleton;
mod tuning;

pub use audit::{AuditOptions, AuditedPart, PartsAudit, audit_parts};
pub use border::Border;
pub use cut::{FlowNetwork, Labelling};
pub use cutting::{CuttingError, CuttingOptions, PlaneDecomposition, PlanePart, decompose_by_planes};
pub use error::RoboFdmError;
pub use mixture::GaussianMixture;
pub use segment::{MAX_CLUSTERS, SegmentOptions, Segmentation, segment};
pub use sequence::{BuildSequence, PlannedPart, Root, SequenceOptions, plan_sequence};
pub use skeleton::{CurveSkeleton, SkeletonOptions, curve_skeleton};
pub use tuning::{Decomposition, PrintedPart, TuningOptions, tune};
