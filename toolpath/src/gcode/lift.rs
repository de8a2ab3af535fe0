//! The nozzle leaves the part when the moves end.

/// What follows the last move if that is a bead: filament is drawn back, and the nozzle backs off along its direction, so that it
/// neither oozes onto the part nor rests on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndLift {
    /// Filament drawn back, 0 to 1e6 mm; none for 0. Default 1.
    pub filament_mm: f64,
    /// How fast, 0.001 to 1e5 mm/s. Default 30.
    pub filament_feed_mm_s: f64,
    /// How far the nozzle backs off, 0 to 1e6 mm. Default 20.
    pub lift_mm: f64,
    /// How fast, 0.001 to 1e5 mm/s. Default 80.
    pub feed_mm_s: f64,
}

impl Default for EndLift {
    fn default() -> Self {
        EndLift { filament_mm: 1.0, filament_feed_mm_s: 30.0, lift_mm: 20.0, feed_mm_s: 80.0 }
    }
}
