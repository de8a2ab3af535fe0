//! Profiles: what segments of a kind have in common, and how a line says where in a range it is.

use super::{FACTOR_DECIMALS, Line, Section, Segment, SegmentKind, WriteBuildError};
use std::collections::BTreeMap;

/// A number of a profile: constant, or by line within a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
}

impl Range {
    const EMPTY: Self = Range { min: f64::INFINITY, max: f64::NEG_INFINITY };

    fn add(&mut self, value: f64) {
        self.min = self.min.min(value);
        self.max = self.max.max(value);
    }

    fn or_none(self) -> Option<Self> {
        (self.min <= self.max).then_some(self)
    }

    /// Whether lines give their own values: the extension wants a range that has a width.
    pub fn varies(&self) -> bool {
        self.max > self.min
    }

    /// The value at a share of the range.
    pub fn at(&self, factor: f64) -> f64 {
        // Both ends are met to the last bit.
        self.min * (1.0 - factor) + self.max * factor
    }

    /// The share of the range of a value, in steps of the file.
    pub(super) fn steps(&self, value: f64) -> u32 {
        let share = (value - self.min) / (self.max - self.min);
        (share.clamp(0.0, 1.0) * f64::from(STEPS)).round() as u32
    }
}

/// Steps of a factor from 0 to 1.
pub(super) const STEPS: u32 = 10u32.pow(FACTOR_DECIMALS as u32);

/// What segments of a kind have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Its UUID, by which layers name it.
    pub uuid: String,
    /// Its name, of its own in the file.
    pub name: String,
    /// The kind that it stands for, where the file says so.
    pub kind: Option<SegmentKind>,
    /// Width of beads in mm: `beadwidth`.
    pub width_mm: Option<Range>,
    /// Height of beads in mm: `beadheight`.
    pub height_mm: Option<Range>,
    /// Speed of the tip in mm/s: `depositionspeed`, of travels `jumpspeed`.
    pub speed_mm_s: Option<Range>,
}

/// Ranges of the numbers of a kind.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    pub(super) width: Range,
    pub(super) height: Range,
    pub(super) speed: Range,
}

/// Ranges by kind, in the order of the kinds.
#[derive(Debug, Default)]
pub(super) struct Measures(BTreeMap<SegmentKind, Measured>);

const SIZE: [f64; 2] = [1e-6, 1e6];
const SPEED: [f64; 2] = [1e-3, 1e6];
const SECONDS: [f64; 2] = [0.0, 1e6];
const FILAMENT: [f64; 2] = [-1e9, 1e9];

impl Measures {
    /// Takes a segment in, `index` from 0. Refuses what cannot be written.
    pub(super) fn add(&mut self, index: usize, segment: &Segment) -> Result<(), WriteBuildError> {
        let wrong = |what| WriteBuildError::Segment { segment: index, what };
        if super::names::name_of(segment.kind).is_none() {
            return Err(wrong("the format has no name for its kind"));
        }
        if segment.lines.is_empty() {
            return Err(wrong("it has no line"));
        }
        let all =
            [("filament_mm", segment.filament_mm), ("prime_mm", segment.prime_mm), ("retract_mm", segment.retract_mm)];
        all.into_iter().try_for_each(|(what, value)| number(index, 0, what, value, FILAMENT))?;
        let empty = Measured { width: Range::EMPTY, height: Range::EMPTY, speed: Range::EMPTY };
        let measured = self.0.entry(segment.kind).or_insert(empty);
        for (at, line) in segment.lines.iter().enumerate() {
            if line.bead.is_some() == (segment.kind == SegmentKind::Travel) {
                return Err(wrong("beads have a width and a height at every line, and travels have none"));
            }
            measured.take(line, |what, value, range| number(index, at, what, value, range))?;
        }
        Ok(())
    }

    pub(super) fn get(&self, kind: SegmentKind) -> Option<(usize, &Measured)> {
        self.0.iter().enumerate().find(|(_, (known, _))| **known == kind).map(|(at, (_, measured))| (at, measured))
    }

    pub(super) fn kinds(&self) -> impl Iterator<Item = (SegmentKind, &Measured)> {
        self.0.iter().map(|(kind, measured)| (*kind, measured))
    }
}

impl Measured {
    fn take(
        &mut self,
        line: &Line,
        check: impl Fn(&'static str, f64, [f64; 2]) -> Result<(), WriteBuildError>,
    ) -> Result<(), WriteBuildError> {
        check("seconds", line.seconds, SECONDS)?;
        for Section { width_mm, height_mm } in line.bead.into_iter().flatten() {
            check("width_mm", width_mm, SIZE)?;
            check("height_mm", height_mm, SIZE)?;
            self.width.add(width_mm);
            self.height.add(height_mm);
        }
        if let Some(speed) = line.speed_mm_s {
            check("speed_mm_s", speed, SPEED)?;
            self.speed.add(speed);
        }
        Ok(())
    }

    pub(super) fn width(&self) -> Option<Range> {
        self.width.or_none()
    }

    pub(super) fn height(&self) -> Option<Range> {
        self.height.or_none()
    }

    pub(super) fn speed(&self) -> Option<Range> {
        self.speed.or_none()
    }
}

fn number(
    segment: usize,
    line: usize,
    what: &'static str,
    value: f64,
    [least, most]: [f64; 2],
) -> Result<(), WriteBuildError> {
    // False for NaN.
    let is_within = value >= least && value <= most;
    if is_within { Ok(()) } else { Err(WriteBuildError::Number { segment, line, what, value, least, most }) }
}
