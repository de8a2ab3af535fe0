//! Why there are no paths.

use crate::level_set::LevelSetError;
use crate::mesh::MeshError;

/// Why there are no paths.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// The bead is not a positive number.
    #[error("a bead of {bead} mm: it must be positive")]
    Bead {
        /// The width that was asked for.
        bead: f64,
    },
    /// The minimum gap is not a number from 0 on.
    #[error("a minimum gap of {gap} squares of a bead: it must be 0 or more")]
    Gap {
        /// What was asked for.
        gap: f64,
    },
    /// The distance between ends to join is not a number from 0 on.
    #[error("a join distance of {beads} beads: it must be 0 or more")]
    JoinDistance {
        /// What was asked for.
        beads: f64,
    },
    /// The minimum length is not a number from 0 on.
    #[error("a minimum length of {beads} beads: it must be 0 or more")]
    MinLength {
        /// What was asked for.
        beads: f64,
    },
    /// The least width of a bead is not between a quarter and three quarters of a bead.
    #[error("a least width of {beads} beads: it must be from 0.25 to 0.75")]
    MinWidth {
        /// What was asked for.
        beads: f64,
    },
    /// An option of walls, skins or infill is out of its range.
    #[error("{option} is {value}: it must be {wanted}")]
    Infill {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// The region is very many beads wide; check the unit.
    #[error("a bead of {bead} mm in a region that reaches {reach} mm inward: more than 100000 beads")]
    BeadTooSmall {
        /// The width that was asked for.
        bead: f64,
        /// The greatest distance from the boundary.
        reach: f64,
    },
    /// The beads are so narrow that their points would not fit into memory.
    #[error(
        "a bead of {bead} mm takes some {points:.1e} points on {area_mm2:.0} mm2, above the limit of {most}: take a wider bead, or raise \
         PathOptions::max_points"
    )]
    TooManyPoints {
        /// The width that was asked for, in millimetres.
        bead: f64,
        /// Area of the surface.
        area_mm2: f64,
        /// Points that they would take, about.
        points: f64,
        /// The limit.
        most: usize,
    },
    /// The distance is not that to the whole boundary.
    #[error("a level set ends at the boundary: paths need the distance to the whole boundary")]
    NotToBoundary,
    /// The surface cannot be cut where the rows of a zigzag begin.
    #[error("no rows: the surface cannot be cut: {0}")]
    Cut(#[from] MeshError),
    /// The level sets cannot be made.
    #[error(transparent)]
    Levels(#[from] LevelSetError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}
