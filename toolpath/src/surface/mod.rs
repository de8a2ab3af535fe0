//! Paths on a curved layer: a triangle mesh with a boundary.
//!
//! * [`SurfaceMesh`]: the mesh, checked at the door.
//! * [`SurfaceDistance`]: the exact geodesic distance to the boundary, or to any edges and vertices.
//! * [`path_statistics`]: what beads along any curves cover, leave bare, cover twice and spill; by a raster that knows
//!   nothing of how the curves were made.
//! * [`LevelField`]: its level sets, how they nest, and the pockets between which they part; and paths along them
//!   that fill the surface with beads ([`LevelField::paths`]).

mod geodesic;
mod level_set;
mod mesh;
mod paths;
mod statistics;
mod union;

pub use geodesic::{DistanceError, Nearest, Sources, SurfaceDistance};
pub use level_set::{Band, LevelField, LevelSetError, LevelSets, Pocket, Ring, SurfacePoint};
pub use mesh::{MeshError, Regions, SurfaceMesh};
pub use paths::{LayerPaths, PathError, PathOptions, PathPoint, Pattern, SurfacePath, Unfilled, UnfilledReason};
pub use statistics::{
    BeadCurve, CurveStatistics, Gap, PathStatistics, StatisticsError, StatisticsOptions, path_statistics,
};
