//! Where the machine is at a tick of the clock.

use super::super::axes::Axes;
use super::super::program::command::Place;

/// A tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// Seconds since the program began.
    pub seconds: f64,
    /// The axes.
    pub axes: Axes,
    /// Filament that went into the nozzle since the last tick, in millimetres.
    pub filament_mm: f64,
    /// Whether the extruder runs, or the move has filament.
    pub extrudes: bool,
    /// The command under way.
    pub place: Place,
    /// The radius of the blend that the tip is in, in millimetres; 0 elsewhere.
    pub blend_mm: f64,
    /// Whether the axes follow a stream.
    pub streams: bool,
    /// Nothing is known of the way from the last tick to this one: the program began, or the machine went home.
    pub jumped: bool,
}
