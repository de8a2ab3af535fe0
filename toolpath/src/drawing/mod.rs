//! Drawings on curved surfaces: outlines of a DXF or SVG file become beads on a dome, a sphere, a height field or a mesh.
//!
//! B. Brooks, *3D printing a transposed design in biopolymer materials using an articulated robot and pellet-based extrusion* (ME
//! thesis, Massey University 2016), chapter 4.
//!
//! | step | section | here |
//! |---|---|---|
//! | file to entities | 4.5, 4.6 | [`read_dxf`], `read_svg`: a [`Drawing`] |
//! | entities to file | 4.3 | [`write_dxf`], [`save_drawing`] and [`load_drawing`] |
//! | entities to contours | 4.7 | [`Drawing::contours`], [`join`] |
//! | centre, scale, order | 4.8, 5.2.2 | [`centre_of`], [`place`], [`order`] |
//! | overlaps removed | 4.9 | [`remove_overlaps`]: [`Region`]s and open pieces |
//! | fill | 4.10 | [`fill`]: [`Stroke`]s |
//! | clusters thinned | 4.17.2 | [`thin_clusters`] |
//! | where a stroke begins | 4.13, 5.2.3 | [`start_strokes`] |
//! | onto the surface | 4.11 | [`Surface`], [`Projection`]; [`UnrolledMesh`] for least distortion |
//! | points on it to file | 4.12 | [`write_paths_dxf`] |
//!
//! Symbols: the thesis' `Point2D` is a `Point2` in millimetres, `Point3D` a [`SurfacePoint`].
//!
//! Everything here is in millimetres, counter-clockwise is positive, and the same input gives the same output.

mod arrange;
mod cluster;
mod coverage;
mod curve;
#[expect(clippy::module_inception, reason = "it holds the type `Drawing`")]
mod drawing;
mod dxf;
mod fault;
mod fill;
mod flatten;
mod join;
mod overlap;
mod polygon;
mod save;
mod skipped;
mod starts;
mod surface;
#[cfg(feature = "svg")]
mod svg;

pub use arrange::{ArrangeError, Centre, centre_of, order, place};
pub use cluster::{Thinned, thin_clusters};
pub use coverage::{Coverage, CoverageError, coverage};
pub use curve::Curve;
pub use drawing::{Drawing, Entity, FillRule, PathFill};
pub use dxf::{DxfError, Place, SpacePath, read_dxf, write_dxf, write_paths_dxf};
pub use fault::{CurveFault, MAX_COORDINATE_MM};
pub use fill::{ContourAt, Fill, FillError, FillOptions, Filled, Stroke, StrokeKind, fill};
pub use flatten::{Flatten, FlattenError};
pub use join::{Contour, Gap, JoinError, Joined, gaps, join};
pub use overlap::{OverlapError, Overlaps, Region, area_sum, remove_overlaps, union_area};
pub use polygon::signed_area;
pub use save::{LoadError, load_drawing, save_drawing};
pub use skipped::Skipped;
pub use starts::start_strokes;
pub use surface::{
    Distortion, HeightField, MeshSurface, MeshSurfaceError, Profile, ProjectError, Projection, Revolved, Surface,
    SurfacePoint, UnrollError, UnrollKind, UnrollOptions, UnrolledMesh, distortion, project, raised,
};
#[cfg(feature = "svg")]
pub use svg::{SvgError, SvgOptions, SvgScale, read_svg};
