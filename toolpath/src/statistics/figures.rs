//! What is asked, and the figures that answer.

use nalgebra::Point3;

/// A bead along a curve: a polyline on the surface and how wide the bead is.
///
/// Equal first and last points (of three or more) make a closed curve. One point is a round dot; a curve without points
/// is not there.
#[derive(Clone, Copy, Debug)]
pub struct BeadCurve<'a> {
    /// Points in order, in millimetres, within half a width of the surface.
    pub points: &'a [Point3<f64>],
    /// Width at each point, in millimetres; between points it goes evenly from one to the next.
    pub widths: &'a [f64],
}

/// How finely to look, and for what.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct StatisticsOptions {
    /// Samples across a bead of mean width (by length): 14. So beads of three quarters of it still have ten.
    pub samples_per_width: f64,
    /// The samples that may be used; one takes some 16 bytes. 2^26.
    pub max_samples: usize,
    /// Direction changes by more than this within a quarter of the width are sharp turns: 60 degrees, in radians.
    pub sharp_turn: f64,
    /// The least width of a bead that is admissible, in millimetres: what none of this width can cover counts as
    /// unfillable. Zero, so that nothing does.
    pub min_width_mm: f64,
    /// Whether to look at areas: yes. Else only lengths, turns and crossings are found: the shares of what is
    /// covered, covered twice, spilled, unfillable and filled are 0, there is no largest gap, and there are no samples.
    pub coverage: bool,
    /// `in_width_range` counts widths from the first to the second; in millimetres, all of them.
    #[cfg_attr(feature = "serde", serde(with = "crate::infinite::pair"))]
    pub width_range_mm: [f64; 2],
}

impl Default for StatisticsOptions {
    fn default() -> Self {
        StatisticsOptions {
            samples_per_width: 14.0,
            max_samples: 1 << 26,
            sharp_turn: std::f64::consts::FRAC_PI_3,
            min_width_mm: 0.0,
            coverage: true,
            width_range_mm: [0.0, f64::INFINITY],
        }
    }
}

/// The largest disc on the surface that touches neither a bead nor crosses the boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gap {
    /// Its radius: half the width of the gap; two steps of the raster too small at most. Infinite on a closed surface without beads.
    #[cfg_attr(feature = "serde", serde(with = "crate::infinite"))]
    pub radius_mm: f64,
    /// Its centre.
    pub at: Point3<f64>,
}

/// Figures of one curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CurveStatistics {
    /// Length of the polyline.
    pub length_mm: f64,
    /// Distance in space from its first point to its last.
    pub entry_exit_mm: f64,
    /// Whether it is closed.
    pub closed: bool,
    /// Places where its direction on the surface changes by more than the limit within a quarter of the width.
    pub sharp_turns: usize,
    /// Length of what lies off the surface: chords over notches of the boundary.
    pub off_surface_mm: f64,
}

/// Figures of beads on a surface. Shares are of the area of the surface unless they say otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PathStatistics {
    /// Area of the surface.
    pub area_mm2: f64,
    /// Share covered by a bead.
    pub covered_fraction: f64,
    /// Share covered by two curves, or by two arcs of one that are more than two widths apart along it.
    pub overlap_fraction: f64,
    /// Area of beads past the boundary, each bead counted by itself, as a share of the area of the surface.
    pub spill_fraction: f64,
    /// Share that no disc of the least width ([`StatisticsOptions::min_width_mm`]) covers without reaching over the
    /// boundary: what is narrower, and the tips of corners. No bead could cover it and spill nothing. The beads given have
    /// no part in it.
    pub unfillable_fraction: f64,
    /// Covered share of the rest, of what beads can fill; one if there is no rest.
    pub filled_fraction: f64,
    /// The largest gap; none if every sample is covered.
    pub largest_gap: Option<Gap>,
    /// Curves with at least one point.
    pub curves: usize,
    /// Steps from the end of a curve to the start of the next that is elsewhere.
    pub jumps: usize,
    /// Their length, straight through space.
    pub jump_mm: f64,
    /// Length of all curves.
    pub path_mm: f64,
    /// Length times width of all curves.
    pub bead_area_mm2: f64,
    /// Share of this whose width lies in the range asked for; zero without beads.
    pub in_width_range: f64,
    /// Sharp turns of all curves.
    pub sharp_turns: usize,
    /// Places where curves cross or touch themselves or each other. Ends may touch ends.
    pub self_crossings: usize,
    /// The largest distance from entry to exit of a curve.
    pub entry_exit_mm: f64,
    /// Length of path off the surface. Its bead counts as spilled.
    pub off_surface_mm: f64,
    /// Step of the raster.
    pub step_mm: f64,
    /// Samples of the raster.
    pub samples: usize,
    /// Figures of each curve given, zeros for one without points.
    pub each: Vec<CurveStatistics>,
}
