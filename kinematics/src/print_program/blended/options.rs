//! What [`print_blended`](super::print_blended) takes.

use crate::print_program::PrintKnot;

/// A motion of a print from rest to rest, as samples of the plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlendedSegment<const N: usize> {
    /// Samples, close enough that the motion between two of them does not matter: some milliseconds. Times rise. Moves end at some of them, the last one
    /// among these.
    pub samples: Vec<PrintKnot<N>>,
    /// Whether it prints: then it goes in lines with the extruder on, else by joints.
    pub prints: bool,
}

/// How far moves with blends may be from the plan, and what the controller does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlendOptions {
    /// How far the tip may be from the planned path while it prints, in mm. Default 0.1, a quarter of a bead of 0.4 mm.
    pub path_mm: f64,
    /// How far the axis of the nozzle may be turned from the planned one then, in rad. Default 0.5 degrees.
    pub axis_rad: f64,
    /// How far each joint may be from the planned path while nothing is laid, in rad. Default 0.002: 1 mm at a reach of 0.5 m, half of the margin that
    /// motions are checked with.
    pub travel_rad: f64,
    /// By how much of its own the speed of a line may differ from that of the plan at a sample in between. Default 0.25: where the plan slows down at a
    /// corner, so does the program, in steps of a quarter.
    pub speed_share: f64,
    /// By how much of its own the filament for a millimetre may differ from that of the plan at a sample in between. Default 0.05.
    pub bead_share: f64,
    /// Lines shorter than this, in seconds, need not keep these shares. Default 0.04, five cycles of a controller of 125 Hz.
    pub min_move_s: f64,
    /// How fast the controller speeds up along a line, in mm/s^2. Default 1200, as in [`UrScriptOptions`](crate::program::UrScriptOptions).
    pub acceleration_mm_s2: f64,
    /// How fast it speeds up by joints, in rad/s^2. Default 1.4, as there.
    pub acceleration_rad_s2: f64,
    /// Speed of the tip that is written at least, in mm/s. Default 0.01.
    pub min_speed_mm_s: f64,
    /// Speed of a joint that is written at least, in rad/s. Default 0.001.
    pub min_speed_rad_s: f64,
    /// Lag of the extruder in seconds, 0 to 0.5: signals come earlier by it. Default 0.
    pub lag_s: f64,
    /// The speed of the filament is written again where it changes by more than this share. Default 0.002, as in a stream: what is off may add up over a print.
    pub same_speed: f64,
}

impl Default for BlendOptions {
    fn default() -> Self {
        BlendOptions {
            path_mm: 0.1,
            axis_rad: 0.5f64.to_radians(),
            travel_rad: 2e-3,
            speed_share: 0.25,
            bead_share: 0.05,
            min_move_s: 0.04,
            acceleration_mm_s2: 1200.0,
            acceleration_rad_s2: 1.4,
            min_speed_mm_s: 0.01,
            min_speed_rad_s: 1e-3,
            lag_s: 0.0,
            same_speed: 2e-3,
        }
    }
}
