//! Closed meshes, and what planes do to them: sections, parts, overhang.

mod cap;
mod cells;
mod mesh;
mod nest;
mod overhang;
mod plane;
mod section;
mod tidy;

pub(crate) use cap::triangulate;
pub(crate) use cells::Wall;
pub use cells::{Cut, Partition};
pub use mesh::{Solid, SolidError};
pub use overhang::{OverhangError, risky_area, risky_faces};
pub use plane::{CutPlane, PlaneError, PlaneFrame};
pub use section::{SectionPolygon, slice};

/// The faces of a box, counter-clockwise from outside: corner `k` lies high along the axes of the bits of `k`.
#[cfg(test)]
pub(crate) const BOX: [[u32; 3]; 12] = [
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
];
