//! How paths are made.

use super::infill::InfillOptions;

/// How a region is filled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Pattern {
    /// One continuous curve for each region, from the boundary inward and back out.
    #[default]
    Spirals,
    /// Closed curves along the boundary, one inside the other, not connected.
    Rings,
    /// Rows a bead apart, to and fro: one continuous curve for each part of a region that no hole and no bay divides. Beside
    /// the outermost rows up to a bead stays bare.
    Zigzag,
}

/// How paths are made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct PathOptions {
    /// Width of a bead, in millimetres: 0.8 by default.
    pub bead: f64,
    /// The pattern.
    pub pattern: Pattern,
    /// Whether widths follow the way across, from 0.75 to 1.25 times the bead, so that beads meet without gap where
    /// opposite sides face each other: so they do by default. Else all beads have the width asked for, as in the paper.
    /// Those of a zigzag always have.
    pub fitted: bool,
    /// A single bead in what other curves leave covers at least this many squares of a bead, or the gap stays: each is a
    /// curve more, with a way to it. One by default. A part of the surface without any other curve always gets one.
    pub min_gap: f64,
    /// Open curves of a layer whose ends are this many beads apart at most become one, if a bead can be laid on the straight way
    /// between them: 2 by default, 0 to leave all as they are.
    pub join_distance: f64,
    /// Curves shorter than this many beads are left out, 5 by default: each costs a start, and little is left of it but the
    /// start. The longest curve of a connected part of the surface always stays, so that tips and pins are printed, and so do those on which
    /// beads of the next layers lie ([`fill_layers`](crate::fill::fill_layers)).
    pub min_length: f64,
    /// Strips narrower than three quarters of a bead, but no narrower than this many, get a bead as wide as they are if beads of the next
    /// layers would else lie on nothing there: 0.5 by default, from 0.25 to 0.75, with which they stay bare. Strips on which nothing
    /// lies do in any case. For fitted beads alone: uniform ones lie in strips of half their width.
    pub min_width: f64,
    /// All layers together, and each alone, are refused before any work is done if their curves would have more points than this, by
    /// [`estimate_fill`](crate::fill::estimate_fill): 2^25 by default, for which some 5 GB are enough.
    pub max_points: usize,
    /// What is solid and what is not: all is, by default. [`LevelField::paths`](crate::level_set::LevelField::paths) fills a surface solid in any case; the rest is for
    /// [`fill_layers`](crate::fill::fill_layers).
    pub infill: InfillOptions,
    /// Whether [`fill_layers`](crate::fill::fill_layers) finds what beads cover: yes. Else only lengths, turns and crossings are found, and the
    /// shares of areas are 0 ([`StatisticsOptions::coverage`](crate::statistics::StatisticsOptions::coverage)); the paths are the same. It takes
    /// nearly as long as the paths.
    pub coverage: bool,
}

/// Points of a curve along the width of a bead, about: levels are followed to an eightieth of it.
pub(crate) const POINTS_A_BEAD: f64 = 2.0;

impl Default for PathOptions {
    fn default() -> Self {
        PathOptions {
            bead: 0.8,
            pattern: Pattern::default(),
            fitted: true,
            min_gap: 1.0,
            join_distance: 2.0,
            min_length: 5.0,
            min_width: 0.5,
            max_points: 1 << 25,
            infill: InfillOptions::default(),
            coverage: true,
        }
    }
}
