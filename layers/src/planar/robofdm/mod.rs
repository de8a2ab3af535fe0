//! RoboFDM: a solid in parts that are printed one after another, each in flat layers along the normal of its base plane.
//!
//! C. Wu, C. Dai, G. Fang, Y.-J. Liu and C. C. L. Wang, "RoboFDM: a robotic system for support-free fabrication using FDM", ICRA 2017; here
//! after C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 2.4.
//!
//! * Phase I: [`segment`] (with [`curve_skeleton`], Gaussian mixtures and graph cuts).
//! * Phase II: [`plan_sequence`].
//! * Phase III: [`tune`], into closed meshes.
//! * [`beam_search`] takes the place of the third phase, and needs no other one.
//! * [`Head`]: a collision test in place of constraint II.
//! * [`audit_parts`] checks the result, or parts of any other origin.

mod audit;
mod audited;
mod beam;
mod border;
mod closed;
mod contacts;
mod crossing;
mod cut;
mod error;
mod follow;
mod head;
mod merging;
mod mixture;
mod options;
mod parts;
mod pedestal;
mod promise;
mod random;
mod reasons;
mod risk;
mod segment;
mod sequence;
mod skeleton;
mod split;
mod state;
mod strength;
mod tuning;

pub use audit::{AuditOptions, PartsAudit, WorstLayer, audit_parts};
pub use audited::AuditedPart;
pub use beam::{BeamOptions, beam_search};
pub use border::Border;
pub use crossing::crossing_sections;
pub use error::RoboFdmError;
pub use head::Head;
pub use options::TuningOptions;
pub use parts::{PrintedPart, Seam};
pub use pedestal::{Pedestal, lowest_pedestal};
pub use reasons::{Left, LeftReason};
pub use segment::{MAX_CLUSTERS, SegmentOptions, Segmentation, segment};
pub use sequence::{BuildSequence, PlannedPart, Root, SequenceOptions, plan_sequence};
pub use skeleton::{CurveSkeleton, SkeletonOptions, curve_skeleton};
pub use strength::{Hold, SeamSection, SeamStrength};
pub use tuning::{Decomposition, tune};
