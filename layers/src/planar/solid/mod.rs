//! Closed meshes, and what planes do to them: sections, parts, overhang.

mod cap;
mod cells;
mod mesh;
mod nest;
mod overhang;
mod plane;
mod section;
mod tidy;

pub(in crate::planar) use cap::triangulate;
pub(in crate::planar) use cells::Wall;
pub use cells::{Cut, Partition};
pub use mesh::{Solid, SolidError};
pub use overhang::{OverhangError, risky_area, risky_faces};
pub use plane::{CutPlane, PlaneError, PlaneFrame};
pub use section::{SectionPolygon, slice};
