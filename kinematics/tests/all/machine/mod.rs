//! Five-axis machines: models, kinematics both ways, plans along a path.

mod closed_forms;
#[cfg(feature = "serde")]
mod files;
mod models;
#[cfg(feature = "serde")]
mod parts;
mod plan;
mod random;
mod sampled;
