//! How a part should lie on the plate: poses to choose from, what each of them costs, and their ranking.
//!
//! Dai 2020 takes the pose as given (section 3.4.1), yet it decides which cells the hull of the part and the platform shadows: a
//! handle that opens upwards can be built, the same handle with its opening to the plate may not. So [`poses`] proposes poses: the given one, those in which
//! the part [rests](PoseKind::Resting) on the plate by itself, and directions spread evenly over the sphere. [`judge_poses`] grows
//! the part in each of them and ranks them.
//!
//! # Symbols
//! `up` is the direction of the part that points away from the plate. A pose is that direction alone: turning about it changes
//! nothing but where the cells lie.
//!
//! # Ranking
//! The fewest missed cells come first; among equals those that stand by themselves, then the least support, the fewest layers, the least
//! height, the largest base, and the order in which the poses were given. [`OrientOptions::standing_first`] puts all that stand
//! first. The cells must be of one size in all poses, or their numbers cannot be compared.
//!
//! # Coarse to fine
//! Missed cells depend little on the size of the cells, so a few thousand cells are enough to tell poses apart. Judge all
//! of them with large cells, and the best again with small ones.

mod body;
mod columns;
mod judge;
mod pose;
mod poses;

pub use judge::{JudgedPose, PoseCells, judge_poses};
pub use pose::{Pose, PoseKind};
pub use poses::poses;

use super::growth::GrowthError;
use super::strategy::Strategy;
use crate::cells::CellsError;
use crate::curved::buildable::platform::PlatformError;
use crate::curved::buildable::rules::Rules;

/// Options of [`poses`] and [`judge_poses`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct OrientOptions {
    /// Directions on the sphere, at most [`OrientOptions::MAX_DIRECTIONS`]. Default 300: neighbours lie some 12 degrees apart.
    pub directions: u32,
    /// By what angle a part that stands must be tipped at least before it falls, in radians. Default 5 degrees: less, and
    /// the push of a nozzle tips it.
    pub min_tipping: f64,
    /// What lies within this height over the plate carries the part, as a share of the longest side of its box. Default 5e-4: 0.05 mm
    /// of 100 mm, a quarter of a first layer. Larger ones make round parts stand, smaller ones take the facets of a face that is
    /// flat but for rounding for several.
    pub contact: f64,
    /// Resting poses nearer than this to one that is harder to tip are left out, in radians. Default 3 degrees.
    pub min_apart: f64,
    /// Diameter of the platform in millimetres; a disc that covers the part is taken if that is larger. Default 127.5.
    pub platform_diameter_mm: f64,
    /// What supports a cell, and from which depth on it cannot be reached.
    pub rules: Rules,
    /// How the part is grown; `None`, the default, for the incremental strategy, and where that misses cells un-building if it misses fewer.
    pub strategy: Option<Strategy>,
    /// Ranks all poses in which the part stands by itself before those in which it does not. Default false.
    pub standing_first: bool,
}

impl OrientOptions {
    /// More directions than this are refused: they would lie less than half a degree apart, and judging them take days.
    pub const MAX_DIRECTIONS: u32 = 100_000;
}

impl Default for OrientOptions {
    fn default() -> Self {
        OrientOptions {
            directions: 300,
            min_tipping: 5f64.to_radians(),
            contact: 5e-4,
            min_apart: 3f64.to_radians(),
            platform_diameter_mm: 127.5,
            rules: Rules::default(),
            strategy: None,
            standing_first: false,
        }
    }
}

/// Why poses cannot be found or judged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError<E> {
    /// There is nothing to lay.
    #[error("the mesh has no triangle")]
    NoTriangle,
    /// A coordinate is not a number, or too large.
    #[error("vertex {vertex} has an invalid coordinate: {position:?}")]
    BadVertex {
        /// The vertex.
        vertex: usize,
        /// Its coordinates.
        position: [f64; 3],
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {index}, but there are {vertices}")]
    BadIndex {
        /// The triangle.
        triangle: usize,
        /// What it names.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// All of the mesh lies in one plane, or encloses nothing: it has no centre of mass.
    #[error("the mesh encloses no volume: it has no centre of mass")]
    NoVolume,
    /// An option is out of its range.
    #[error("{option} is {value}, it must lie between {} and {}", .range[0], .range[1])]
    Option {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
        /// Least and greatest value.
        range: [f64; 2],
    },
    /// There is no pose to judge.
    #[error("no pose was given")]
    NoPose,
    /// The cells of a pose could not be made.
    #[error("pose {pose}: {error}")]
    Voxelise {
        /// The pose, by its number in the input.
        pose: usize,
        /// Why.
        error: E,
    },
    /// What was made of a pose is no set of cells.
    #[error("pose {pose}: {error}")]
    Cells {
        /// The pose.
        pose: usize,
        /// Why.
        error: CellsError,
    },
    /// The edge of a cell is not a length, or not the same in all poses.
    #[error(
        "pose {pose} has cells of {cell_mm} mm, the first one cells of {first_mm} mm: the edge must be positive, finite, and the same in all poses"
    )]
    CellSize {
        /// The pose.
        pose: usize,
        /// Edge of its cells.
        cell_mm: f64,
        /// Edge of the cells of the first one.
        first_mm: f64,
    },
    /// The platform of a pose is out of reach.
    #[error("pose {pose}: {error}")]
    Platform {
        /// The pose.
        pose: usize,
        /// Why.
        error: PlatformError,
    },
    /// The growth of a pose did not start.
    #[error("pose {pose}: {error}")]
    Growth {
        /// The pose.
        pose: usize,
        /// Why.
        error: GrowthError,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl OrientOptions {
    /// Checks the options against their ranges.
    fn check<E>(&self) -> Result<(), PoseError<E>> {
        let half_turn = std::f64::consts::PI;
        let ranges = [
            ("directions", f64::from(self.directions), [0.0, f64::from(Self::MAX_DIRECTIONS)]),
            ("min_tipping", self.min_tipping, [0.0, half_turn / 2.0]),
            ("contact", self.contact, [0.0, 0.1]),
            ("min_apart", self.min_apart, [0.0, half_turn]),
            ("platform_diameter_mm", self.platform_diameter_mm, [0.0, f64::MAX]),
        ];
        match ranges.into_iter().find(|(_, value, [low, high])| !(*low..=*high).contains(value)) {
            Some((option, value, range)) => Err(PoseError::Option { option, value, range }),
            None => Ok(()),
        }
    }
}
