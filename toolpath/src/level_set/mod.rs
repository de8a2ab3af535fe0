//! The level sets of a distance: rings at given distances, how they nest, and the pockets between which they part.
//!
//! Takes a [`SurfaceDistance`](crate::geodesic::SurfaceDistance); gives a [`LevelField`], which refines the mesh until the distance is
//! linear over its triangles.
//!
//! Zhao et al., "Connected Fermat spirals for layered fabrication", ACM TOG 35(4), 2016, section 4, fill a region along
//! its offsets and join them by a tree; Dai 2020, section 3.5.1, does so with geodesic distance on a surface. There
//! rings of neighbouring distances are matched by how near they are. Here nesting is read off the field: rings belong
//! together when they bound one *band*, a connected part of the surface between two levels. Bands and rings form a
//! graph: the Reeb graph of the distance, cut at the levels. For a region without holes it is a tree.
//!
//! *Pockets* are the branches of the tree of regions above a level (the split tree), each from its summit down to the
//! saddle where it joins a higher one. Bumps lower than asked for are not separated; on the medial axis the field is
//! nearly level, and rounding makes many of them.
//!
//! * `field`: the distance, linear over triangles; `refine`: that it is. `rings`: level sets. `bands`: what lies between.
//! * `around`: half-edges out of vertices. `levels`: where level sets are. `pockets`: summits and saddles.
//!
//! What is connected is decided by comparing values at vertices only, equal ones included, so plateaus need no care.

mod around;
mod bands;
mod field;
mod levels;
mod pockets;
mod refine;
mod rings;

use crate::mesh::SurfacePoint;
pub(crate) use around::Around;
pub use bands::{Band, LevelSets};
pub use field::LevelField;
pub(crate) use levels::Levels;
pub use pockets::Pocket;

/// A connected part of a level set: a polyline on the surface, with a point where it crosses each edge of the refined
/// mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// Number of the level.
    pub level: usize,
    /// Points in order, with greater distances on the left (seen from outside). Neighbours may coincide where the level
    /// runs through a vertex.
    pub points: Vec<SurfacePoint>,
    /// Whether the last point is joined to the first. It is, for the distance to the whole boundary; other level sets
    /// may end at the boundary.
    pub closed: bool,
    /// The band on its right, where the distance is less.
    pub below: u32,
    /// The band on its left.
    pub above: u32,
}

/// Why there are no level sets.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LevelSetError {
    /// The tolerance is not a positive number.
    #[error("a tolerance of {tolerance} mm: it must be positive")]
    Tolerance {
        /// The tolerance that was asked for.
        tolerance: f64,
    },
    /// Levels must be finite, and each greater than the one before.
    #[error("level {level} is not finite, or not above the level before")]
    Level {
        /// The first bad one.
        level: usize,
    },
    /// The refined mesh grows too large; take a larger tolerance.
    #[error("a tolerance of {tolerance} mm is too fine: it takes more than {triangles} triangles")]
    TooFine {
        /// The tolerance that was asked for.
        tolerance: f64,
        /// Triangles when it was given up.
        triangles: usize,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl Ring {
    /// Length of the polyline.
    pub fn length(&self) -> f64 {
        let steps = self.points.windows(2).map(|pair| (pair[1].position - pair[0].position).norm()).sum::<f64>();
        match (self.closed, self.points.first(), self.points.last()) {
            (true, Some(first), Some(last)) => steps + (first.position - last.position).norm(),
            _ => steps,
        }
    }
}
