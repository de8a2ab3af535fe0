//! Arms from URDF files: chains of six turning joints that are of the UR type or ortho-parallel with a spherical wrist.
//!
//! A URDF places frames as its author liked. So what counts here is where the joint axes are as lines in space while all joints are at 0, and where
//! the flange is: [`UrdfArm::read`] finds the lengths, offsets and signs of the [`ArmModel`](crate::ArmModel) that has these lines, or says which
//! axis fits neither family and by how much. Format: the URDF pages of the ROS wiki (`urdf/XML/joint`, `urdf/XML/link`); lengths there are metres.
//!
//! The two families and their symbols: [`OrthoLengths`](crate::OrthoLengths), [`DhTable`](crate::DhTable). Not read: meshes, masses, anything else than joints.
//!
//! ```
//! use curvlay_kinematics::urdf::{LinkNames, UrdfArm};
//! let joint = |n: usize, xyz: &str, axis: &str| format!(
//!     r#"<joint name="j{n}" type="revolute"><parent link="l{}"/><child link="l{n}"/><origin xyz="{xyz}"/><axis xyz="{axis}"/>
//!        <limit lower="-2" upper="2" velocity="3" effort="0"/></joint><link name="l{n}"/>"#, n - 1);
//! let joints = [("0 0 0.29", "0 0 1"), ("0 0 0", "0 1 0"), ("0 0 0.27", "0 1 0"), ("0 0 0.07", "1 0 0"), ("0.302 0 0", "0 1 0"), ("0.072 0 0", "1 0 0")];
//! let text: String = joints.iter().enumerate().map(|(k, (xyz, axis))| joint(k + 1, xyz, axis)).collect();
//! let found = UrdfArm::read(&format!(r#"<robot name="irb120"><link name="l0"/>{text}</robot>"#), &LinkNames::default())?;
//! let curvlay_kinematics::Geometry::Ortho(lengths) = found.model.geometry else { return Err("another family".into()) };
//! assert!((lengths.a2 + 70.0).abs() < 1e-9 && (lengths.c3 - 302.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arm;
mod chain;
mod error;
mod file;
mod fit;
mod lines;
mod ortho;
mod tree;
mod ur;

pub use arm::UrdfArm;
pub use error::{AxisMisfit, Misfit, UrdfError};
pub use tree::LinkNames;
