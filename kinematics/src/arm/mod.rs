//! Arms of six joints: forward and inverse kinematics.
//!
//! Two families have a closed form here: arms of the UR type ([`DhTable`]) and ortho-parallel arms with a spherical
//! wrist ([`OrthoLengths`]). An arm is made from an [`ArmModel`], which is plain numbers; [`robots`](crate::robots)
//! has some. An arm as built, with axes that calibration has found off their places, is [`Arm::calibrated`]: it is solved from the closed
//! form that is nearest to it.
//!
//! Joints are `[f64; 6]` in radians, poses are `base_flange` in millimetres. Nothing here allocates, and all results
//! depend on the input alone.

mod branches;
mod continuing;
mod deviation;
mod dh;
mod error;
mod follow;
mod jacobian;
mod model;
mod newton;
mod numbers;
mod ortho;
mod planar;
pub mod robots;
mod solver;
mod ur;

pub use branches::{Branch, Elbow, SAME, Shoulder, Solutions, Wrist};
pub use deviation::ArmDeviation;
pub use dh::DhTable;
pub use error::ArmError;
pub use jacobian::Rates;
pub use model::{ArmModel, Geometry};
pub use numbers::{ANGLE_TOLERANCE, POSITION_TOLERANCE};
pub use ortho::OrthoLengths;
pub use solver::Arm;
