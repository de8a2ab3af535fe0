//! `build.3mf`: mesh and toolpath of a print in one package, written and read.
//!
//! 3MF Consortium, *3MF Toolpath Extension*, version 1.0, release candidate (September 2026), with the 3MF core and production
//! extensions: namespace [`TOOLPATH`], `toolpathtype="6axis"`. Of its profiles it uses `beadwidth`, `beadheight`, `depositionspeed` and
//! `jumpspeed`, each with a `modifier`; of its geometry `polyline6d`. What it has no words for (travels, filament that is drawn back, filament
//! of a segment, seconds of a turn on the spot, numbers of layers) stands in a namespace of our own, [`OURS`]. The page
//! `docs/formats/build-3mf.md` has every element.
//!
//! * [`write_build`] takes the segments from an iterator, twice: first for the ranges of widths, heights and speeds, then for the layers. It
//!   holds one [`Segment`] at a time. [`segments`] makes them of a plan of moves.
//! * [`BuildReader`] opens a package and reads one layer part at a time.

mod frame;
mod layer;
mod model;
mod names;
mod options;
mod package;
mod parts;
mod profile;
mod read;
mod segments;
mod uuid;
mod write;
mod write_error;

pub use frame::{direction_of, frame_at};
pub(crate) use names::unit_mm;
pub use names::{CORE, LAYER_RELATIONSHIP, OURS, PRODUCTION, TOOLPATH};
pub use options::{BuildOptions, BuildWritten};
pub use parts::MAX_LINES;
pub use profile::{Profile, Range};
pub use read::{BuildReader, LayerPart, ReadBuildError, ReadSegment};
pub use segments::segments;
pub use write::write_build;
pub use write_error::WriteBuildError;

use curvlay_toolpath::path::BeadKind;
use nalgebra::Isometry3;

/// Millimetres of one step of a coordinate: what is read is within half of it, 0.05 um.
pub const UNIT_FACTOR_MM: f64 = 1e-4;

/// Decimals of the share of a range by which a width, a height or a speed is given: what is read is within 5e-7 of the range of its profile.
pub const FACTOR_DECIMALS: usize = 6;

/// What a segment is for: each has a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SegmentKind {
    /// Bead of a kind.
    Bead(BeadKind),
    /// The nozzle goes somewhere and lays nothing.
    Travel,
}

/// Width and height of a bead at a place, millimetres, above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Width.
    pub width_mm: f64,
    /// Height.
    pub height_mm: f64,
}

/// A straight line of the tip, from where the one before ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// The tip at its end, and how the nozzle stands: local z points from the tip into the nozzle ([`frame_at`]).
    pub end: Isometry3<f64>,
    /// The bead at its beginning and at its end, even in between; none of travels.
    pub bead: Option<[Section; 2]>,
    /// Speed of the tip, mm/s; none where the tip stands and the nozzle turns.
    pub speed_mm_s: Option<f64>,
    /// How long it takes, seconds.
    pub seconds: f64,
}

/// Lines of one kind that join.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// The layer it belongs to, from 0.
    pub layer: u32,
    /// The path it belongs to, from 0; a travel to the one that follows.
    pub path: u32,
    /// What it is for.
    pub kind: SegmentKind,
    /// Where it begins.
    pub start: Isometry3<f64>,
    /// One at least.
    pub lines: Vec<Line>,
    /// Filament of its beads, mm.
    pub filament_mm: f64,
    /// Filament pushed forward before it begins, mm, while the tip stands; below 0 it is drawn back.
    pub prime_mm: f64,
    /// Filament drawn back when it has ended, mm.
    pub retract_mm: f64,
}
