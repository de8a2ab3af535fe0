//! What a program is written with, and what came of it.

use crate::gcode::{EndLift, Retraction, Tags, Written};

/// What a program of a [`Flavour`](super::Flavour) is written with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramOptions<'a> {
    /// Name of the program, for flavours that have one (`{name}`): letters, digits, `-` and `_`, 1 to 32 characters. Default `curvlay`.
    pub name: &'a str,
    /// How [marks](crate::gcode::Move::Mark) are written where comments begin with `;`. Default [`Tags::Prusa`]. Elsewhere the beginning of a layer is a plain comment.
    pub tags: Tags,
    /// The nozzle's temperature, 0 to 2000 degrees Celsius. Default `None`.
    pub nozzle_celsius: Option<f64>,
    /// The plate's temperature, 0 to 2000 degrees Celsius. Default `None`.
    pub bed_celsius: Option<f64>,
    /// The fan, 0 to 1. Default `None`.
    pub fan: Option<f64>,
    /// Feed of axis moves from an unknown place, 0.001 to 1e5 mm/s, for flavours whose travels have a feed. Default 20.
    pub first_feed_mm_s: f64,
    /// Lines in place of [`Flavour::heat_up`](super::Flavour::heat_up). Default `None`.
    pub start: Option<&'a str>,
    /// Lines in place of [`Flavour::cool_down`](super::Flavour::cool_down). Default `None`.
    pub finish: Option<&'a str>,
    /// Draw filament back on long ways between beads, unless the moves do it themselves. Moves of the part only. Default `None`.
    pub retraction: Option<Retraction>,
    /// What the nozzle does after the last move, if that is a bead. Moves of the part only. Default [`EndLift::default`].
    pub end: Option<EndLift>,
}

impl Default for ProgramOptions<'_> {
    fn default() -> Self {
        ProgramOptions {
            name: "curvlay",
            tags: Tags::default(),
            nozzle_celsius: None,
            bed_celsius: None,
            fan: None,
            first_feed_mm_s: 20.0,
            start: None,
            finish: None,
            retraction: None,
            end: Some(EndLift::default()),
        }
    }
}

/// What has been written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlavourWritten {
    /// Moves, lines, bytes and sums. The length of tape is known for moves of the part alone.
    pub written: Written,
    /// Moves whose time the flavour cannot say: they take as long as the controller thinks right.
    pub untimed: u64,
    /// Moves whose feed would be above [`Feed::max`](super::Feed::max), and which the program therefore does more slowly than planned.
    pub capped: u64,
    /// Retractions, primes and commands that the flavour has no words for; commands stand in comments.
    pub without_words: u64,
    /// Greatest angle between a direction and +z that was left out, radians: 0 unless the direction is [`Upright`](super::Direction::Upright) or in a comment.
    pub max_tilt: f64,
}
