//! What is read of a build.

use crate::build3mf::profile::Profile;
use crate::build3mf::{Line, Segment};
use nalgebra::Isometry3;

/// A part with a layer, or with a piece of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayerPart {
    /// Its name in the package.
    pub path: String,
    /// The layer, from 0, where the file says so.
    pub layer: Option<u32>,
}

/// A segment of a file: as [`Segment`], with its profile in place of a kind.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadSegment {
    /// Its profile, by its place in [`BuildReader::profiles`](super::BuildReader::profiles).
    pub profile: usize,
    /// Its `tag`: in files of ours the path, from 0.
    pub tag: Option<u32>,
    /// How long its lines take, by `timeprediction`.
    pub seconds: Option<f64>,
    /// How long it takes to get to its start, by `jumpprediction`.
    pub jump_s: Option<f64>,
    /// See [`Segment::start`].
    pub start: Isometry3<f64>,
    /// See [`Segment::lines`].
    pub lines: Vec<Line>,
    /// See [`Segment::filament_mm`]; 0 where the file does not say.
    pub filament_mm: f64,
    /// See [`Segment::prime_mm`].
    pub prime_mm: f64,
    /// See [`Segment::retract_mm`].
    pub retract_mm: f64,
}

impl ReadSegment {
    /// The segment as it was written, where the file says kind and layer, as ours do.
    pub fn as_written(self, profile: &Profile, part: &LayerPart) -> Option<Segment> {
        let (kind, layer, path) = (profile.kind?, part.layer?, self.tag?);
        let ReadSegment { start, lines, filament_mm, prime_mm, retract_mm, .. } = self;
        Some(Segment { layer, path, kind, start, lines, filament_mm, prime_mm, retract_mm })
    }
}
