//! What a plan did.

/// Figures of what has come out of a plan so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisPlanSummary {
    /// Moves and all else that went in.
    pub moves: u64,
    /// Motions that came out.
    pub axis_moves: u64,
    /// Beads that were cut for a rewind or at a pole.
    pub bead_rewinds: u64,
    /// Rewinds between beads.
    pub travel_rewinds: u64,
    /// Passes through the neighbourhood of a pole.
    pub pole_passes: u64,
    /// Printing motions that take longer than their feed says, since an axis is at its fastest.
    pub slowed: u64,
    /// The largest factor among them; 1 without any.
    pub worst_slowdown: f64,
    /// A bound on how far the tip is off its line while it prints, mm.
    pub max_tip_error_mm: f64,
    /// A bound on how far the nozzle is off its direction while it prints, rad; on a polar machine what it cannot follow at the ends of motions.
    pub max_direction_error_rad: f64,
    /// The share of the tilt that a polar machine cannot follow, over the length of all beads; 0 on others.
    pub unfollowed_tilt: f64,
    /// Smallest and largest position of each axis (of the linear ones also with `tcp`), in the order of the letters, mm and radians; infinite before
    /// anything has come out.
    pub used: [[f64; 2]; 5],
    /// Time of all motions.
    pub seconds: f64,
    /// Filament in beads, mm.
    pub filament_mm: f64,
}

impl Default for AxisPlanSummary {
    fn default() -> Self {
        AxisPlanSummary {
            moves: 0,
            axis_moves: 0,
            bead_rewinds: 0,
            travel_rewinds: 0,
            pole_passes: 0,
            slowed: 0,
            worst_slowdown: 1.0,
            max_tip_error_mm: 0.0,
            max_direction_error_rad: 0.0,
            unfollowed_tilt: 0.0,
            used: [[f64::INFINITY, f64::NEG_INFINITY]; 5],
            seconds: 0.0,
            filament_mm: 0.0,
        }
    }
}
